#!/bin/sh
# What the OpenCL kernel needs on NVIDIA's GPUs, without one: registers, spills, stack, instructions, theoretical occupancy.
#     gpu_static.sh [--clang PATH] [--ptxas PATH] [--kernels DIR] [--out DIR]
# Compiles the kernel for sm_70, sm_80 and sm_90, as the program has it built for a GPU, to PTX with clang (16 or newer, with
# NVPTX) and libclc's nvptx64--nvidiacl.bc, then with NVIDIA's ptxas. What is not on the PATH is looked for where Debian puts
# it; ptxas comes from the Python package registry otherwise (nvidia-cuda-nvcc-cu12) and stays in DIR (bench/out). Leaves
# gpu_static.csv there, and prints the table of it. Exit code 77 where a tool is missing.
#     python3 bench/parts/gpu_static.py --readme CSV bench/parts/README.md
# writes the table into the text. NVIDIA's own OpenCL compiler need not choose the same registers.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/../lib/lib.sh"
clang= ptxas= kernels=$root/kernels
options "" "clang ptxas kernels out" "$@"
[ -f "$kernels/transport.cl" ] || fail "$kernels: no folder of kernels"
need python3 cmake readelf
missing() { # TEXT
    echo "gpu_static.sh: $1" >&2
    exit 77
}
for name in clang-16 clang-17 clang-18 clang-19 clang; do
    [ -n "$clang" ] || clang=$(command -v $name) || clang=
done
[ -n "$clang" ] || missing "clang is missing (packages clang-16 libclc-16-dev)"
"$clang" --print-targets 2>/dev/null | grep -q nvptx64 || missing "$clang knows no nvptx64"
library=$(find /usr/lib/clc /usr/share/clc /usr/lib/llvm-*/share/clc -name nvptx64--nvidiacl.bc 2>/dev/null | head -n 1)
[ -n "$library" ] || missing "nvptx64--nvidiacl.bc is missing (package libclc-16 or newer)"
mkdir -p "$out"
if [ -z "$ptxas" ] && ! ptxas=$(command -v ptxas); then
    wheel=$out/ptxas
    [ -d "$wheel" ] || python3 -m pip install --quiet --no-deps --target "$wheel" nvidia-cuda-nvcc-cu12 >&2 ||
        missing "ptxas is missing, and so is a package registry to get it from"
    ptxas=$(find "$wheel" -name ptxas -type f | head -n 1)
    [ -n "$ptxas" ] || missing "no ptxas in $wheel"
    chmod +x "$ptxas"
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake -D KERNELS="$kernels" -D OUTPUT="$work/kernel" -P "$root/src/engine/opencl/opencl_text.cmake"
mv "$work/kernel.text" "$work/kernel.cl"
python3 -B "$here/gpu_static.py" "$work" "$clang" "$library" "$ptxas" "$out/gpu_static.csv"
