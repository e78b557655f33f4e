# Recipe for Spack 1, which builds the checkout that it stands in:
#     spack repo add CHECKOUT/src/cli/install/spack
#     spack env create . && spack -e . develop --path CHECKOUT clustermcml@=main && spack -e . install --add clustermcml
# SPDX-License-Identifier: MIT
from spack_repo.builtin.build_systems.cmake import CMakePackage

from spack.package import *


class Clustermcml(CMakePackage):
    """Monte Carlo light transport in layered turbid media whose boundaries need not be flat."""

    license("MIT")
    version("main")

    variant("mpi", default=True, description="Run on several machines")
    variant("hdf5", default=True, description="Write .h5 files and maps")
    variant("opencl", default=False, description="Build the opencl engine")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.22:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("embree@3.12:")
    depends_on("tinyobjloader")
    depends_on("jansson")
    depends_on("zlib-api")
    depends_on("py-h5py", type="run")
    depends_on("py-h5netcdf", type="run")
    depends_on("py-matplotlib", type="run")
    depends_on("py-scipy", type="run")
    depends_on("py-xarray", type="run")
    depends_on("mpi", when="+mpi")
    depends_on("hdf5+hl~mpi", when="+hdf5")
    depends_on("opencl", when="+opencl")

    def cmake_args(self):
        return [
            self.define("CLUSTERMCML_TESTS", False),
            self.define_from_variant("CLUSTERMCML_MPI", "mpi"),
            self.define_from_variant("CLUSTERMCML_HDF5", "hdf5"),
            self.define_from_variant("CLUSTERMCML_OPENCL", "opencl"),
        ]
