#!/bin/sh
# Builds a wheel for Linux with glibc 2.28 or later, on Debian 12 with an x86-64 processor. The wheel holds the program, the library
# that Python calls, all that they are linked with, and an adapter for each ABI of MPI: under mpiexec or srun the program
# finds the MPI library of the machine.
#
#     sh samples/wheel.sh [FOLDER]               the wheel is left in FOLDER, by default build/wheel
#     ARCH=aarch64 sh samples/wheel.sh [FOLDER]  a wheel for ARM processors
#     WORK=FOLDER sh samples/wheel.sh            the libraries stay in that folder, and the next call builds none
#
# Everything is compiled against a root of Debian 11, which src/cli/install/wheel makes from packages of fixed versions.
# Needs a mirror of Debian and a package registry.
# SPDX-License-Identifier: MIT
set -eu
case ${1:-} in -*) sed -n '2,/^# SPDX/{/^# SPDX/!s/^#  *//p;}' "$0"; exit 0 ;; esac
source=$(cd "$(dirname "$0")/.." && pwd)
parts=$source/src/cli/install/wheel
out=${1:-$source/build/wheel}
export WHEEL_ARCH="${ARCH:-x86_64}"
sh "$source/samples/packages.sh" wheel
test "$WHEEL_ARCH" = x86_64 || sh "$source/samples/packages.sh" "wheel-$WHEEL_ARCH"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM HUP
libraries=$(realpath -m "${WORK:-$work}/$WHEEL_ARCH")
export WHEEL_ROOT="$libraries/root"
export CMAKE_BUILD_PARALLEL_LEVEL="${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}"

python3 -m venv "$work/tools"
export PATH="$work/tools/bin:$PATH"
pip install --quiet --no-deps --require-hashes -r "$parts/requirements.txt"
if ! test -f "$libraries/done"; then
    { cmake -S "$parts" -B "$libraries/build" && cmake --build "$libraries/build"; } >"$work/log" 2>&1 ||
        { tail -n 40 "$work/log" >&2; exit 1; }
    touch "$libraries/done"
fi

mkdir "$work/abi"
cp "$work/tools/include/mpi_abi.h" "$work/abi/mpi.h"
debian=x86_64-linux-gnu # headers are the same for both machines
adapters="openmpi=$WHEEL_ROOT/usr/lib/$debian/openmpi/include;mpich=$WHEEL_ROOT/usr/include/$debian/mpich;abi=$work/abi"
# the program that prints its help, and auditwheel, find the root's OpenCL and OpenMP there
export LD_LIBRARY_PATH="$WHEEL_ROOT/usr/lib/$WHEEL_ARCH-linux-gnu"
_PYTHON_HOST_PLATFORM=linux-$WHEEL_ARCH pip wheel --quiet --no-deps --no-build-isolation --wheel-dir "$work" "$source" \
    --config-settings=build-dir="$work/build" --config-settings=cmake.define.CMAKE_TOOLCHAIN_FILE="$parts/toolchain.cmake" \
    --config-settings=cmake.define.CLUSTERMCML_MPI=OFF --config-settings=cmake.define.CLUSTERMCML_ADAPTERS="$adapters"
auditwheel repair --wheel-dir "$work/whole" "$work"/clustermcml-*.whl \
    >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
mkdir -p "$out"
cp "$work"/whole/clustermcml-*.whl "$out"
ls -sh "$out"/clustermcml-*.whl
