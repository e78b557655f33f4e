#!/bin/sh
# Installs the Debian packages that clustermcml needs, from the one list of them; Debian 12, Debian 13 and Ubuntu 24.04
# have the same names. `packages.sh` installs missing packages to build, run and plot; `packages.sh test` also those of
# the tests; `packages.sh build` only those that a build with its tests needs, a sixth of all; `packages.sh names` prints the
# names of all, and installs nothing. `packages.sh wheel` installs those of samples/wheel.sh alone, and
# `packages.sh wheel-aarch64` its compiler for ARM. Asks for sudo only if something is missing.
# SPDX-License-Identifier: MIT
set -eu
build="cmake make gcc g++ libc6-dev pkg-config git libembree-dev libtinyobjloader-dev libjansson-dev zlib1g-dev libhdf5-dev libopenmpi-dev openmpi-bin ocl-icd-opencl-dev opencl-headers"
packages="$build python3-h5py python3-matplotlib python3-scipy python3-xarray pocl-opencl-icd"
tested="ninja-build libcmocka-dev librandom123-dev python3" # what a build of the tests needs
case ${1:-} in
test | names)
    packages="$packages $tested clang lld clang-format libomp-dev libclang-rt-dev libxml2-utils file iproute2"
    packages="$packages python3-h5netcdf python3-netcdf4 python3-vtk9 mypy octave dpkg-dev lintian man-db"
    packages="$packages mkdocs-material mkdocstrings mkdocstrings-python-handlers" # the manual
    # A Slurm of one node, which its test starts. Debian starts none without a configuration.
    packages="$packages munge slurmctld slurmd slurm-client slurm-wlm-basic-plugins"
    ;;
build) packages="$build $tested" ;;
wheel) packages="cmake make gcc g++ libc6-dev pkg-config git ca-certificates python3-venv" ;;
wheel-aarch64) packages="gcc-aarch64-linux-gnu g++-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user-static" ;;
esac

test "${1:-}" != names || { printf '%s\n' $packages; exit 0; }

missing=
for package in $packages; do
    case $(dpkg-query -W -f '${Status}' "$package" 2>/dev/null) in
    *" installed") ;;
    *) missing="$missing $package" ;;
    esac
done
test -n "$missing" || exit 0

as_root=
if test "$(id -u)" -ne 0; then
    command -v sudo >/dev/null || { echo "install as root:$missing" >&2; exit 1; }
    as_root=sudo
fi
echo "installing$missing"
export DEBIAN_FRONTEND=noninteractive
# Word splitting is meant: one argument per package.
$as_root apt-get update -q
$as_root apt-get install -y -q --no-install-recommends $missing
