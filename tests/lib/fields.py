"""Parts that the tests of .h5, .vti and .vtp files share: readers of these files, which need Debian packages.

If a package is missing, the test is skipped with a message; samples/packages.sh test installs the packages."""
import os
import subprocess
import sys

import cml

try:
    import h5py
    import numpy
    import vtk
    import xarray
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError as reason:
    print(f"skipped: {reason} (sh samples/packages.sh test installs it)")
    sys.exit(77)

__all__ = ["h5py", "numpy", "vtk", "xarray", "fly_twice", "read_vtk", "arrays_of"]


def fly_twice(scene, photons):
    """Runs a scene in the current folder with the seeds 1 and 2 into the folders 1 and 2. photons: numbers for both runs."""
    with open("maps.mci", "w", encoding="utf-8") as file:
        file.write(scene)
    for seed, count in zip("12", photons):
        os.mkdir(seed)
        subprocess.run([cml.PROGRAM, "maps.mci", "--quiet", "--seed", seed, "--photons", str(count), "-o", seed], check=True)


def read_vtk(path):
    """Returns the data set of a .vti or .vtp file. VTK's own complaints count as errors."""
    reader = vtk.vtkXMLImageDataReader() if path.endswith(".vti") else vtk.vtkXMLPolyDataReader()
    complaints = []
    reader.AddObserver("ErrorEvent", lambda *_: complaints.append("error"))
    reader.AddObserver("WarningEvent", lambda *_: complaints.append("warning"))
    if not reader.CanReadFile(path):
        raise RuntimeError(f"{path}: VTK cannot read it")
    reader.SetFileName(path)
    reader.Update()
    if complaints:
        raise RuntimeError(f"{path}: VTK complains")
    return reader.GetOutput()


def arrays_of(data):
    """Returns the cell data as {name: numpy array}."""
    cells = data.GetCellData()
    return {cells.GetArrayName(i): vtk_to_numpy(cells.GetArray(i)) for i in range(cells.GetNumberOfArrays())}
