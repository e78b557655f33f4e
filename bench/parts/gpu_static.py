#!/usr/bin/env python3
"""Reports the needs of the OpenCL kernel on NVIDIA's GPUs, without a GPU: registers, spills, stack, instructions, theoretical occupancy.

    gpu_static.py [--clang PATH] [--ptxas PATH] [--kernels DIR] [--out DIR]

Compiles the kernel for sm_70, sm_80 and sm_90, with the options that the program uses on a GPU: to PTX with clang (16 or newer, with NVPTX) and
libclc's nvptx64--nvidiacl.bc, then with NVIDIA's ptxas. Tools that are not on the PATH are searched where Debian puts them. ptxas otherwise comes
from the Python package registry (nvidia-cuda-nvcc-cu12) and stays in DIR (bench/out). Leaves gpu_static.csv there, and prints its table. Exit code
77 if a tool is missing.

    gpu_static.py --readme CSV README

writes the table into the text. NVIDIA's own OpenCL compiler may choose other registers.

SPDX-License-Identifier: MIT
"""
import argparse
import csv
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command
import tables

GROUP = 128  # work-items of a group: GPU_GROUP of src/engine/opencl/opencl_flight.c
NEAR_KB = 16  # local memory of a group: LOCAL_BYTES_SHARED of the same file
INSTRUCTION = 16  # bytes of an instruction, from sm_70 on
# Limits of a multiprocessor: registers, warps, local memory [KiB] (CUDA C++ Programming Guide 12.9, table "Technical Specifications per Compute
# Capability"). Registers are given to warps in units of 256.
REGISTERS, WARPS, WARP = 65536, 64, 32
LOCAL_KB = {"sm_70": 96, "sm_80": 164, "sm_90": 228}
KINDS = (("planes", ["-D", "CML_ONLY_PLANES", "-D", "CML_WITHOUT_BODIES"]), ("cones", ["-D", "CML_WITHOUT_BODIES"]), ("cones, bodies", []))
LIMITS = (0, 96, 80)  # most registers that ptxas may use; 0: no limit
TITLES = ("device", "boundaries", "registers at most", "registers", "spilled to memory [bytes]", "stack [bytes]", "instructions",
          "warps of 64", "occupancy")

# clang's headers do not declare the 64-bit additions for any device of this target
ATOMICS = """
__attribute__((overloadable)) static inline ulong atom_add(volatile __%s ulong *cell, ulong amount)
{
    ulong old;
    __asm__ volatile("atom.%s.add.u64 %%0, [%%1], %%2;" : "=l"(old) : "l"(cell), "l"(amount) : "memory");
    return old;
}
"""


def call(command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        sys.exit("gpu_static.py: %s\n%s" % (" ".join(command), done.stdout))
    return done.stdout


def to_ptx(work, clang, library, device, options):
    ptx = os.path.join(work, "kernel.ptx")
    call([clang, "-x", "cl", "-cl-std=CL1.2", "-O3", "-w", "-target", "nvptx64-nvidia-nvcl", "-cl-single-precision-constant",
          "-Xclang", "-mlink-bitcode-file", "-Xclang", library, "-Xclang", "-target-cpu", "-Xclang", device,
          "-include", os.path.join(work, "atomics.h"), "-D", "CML_GROUP_SIZE=%d" % GROUP, "-D", "CML_DEVICE_LANES=1",
          "-D", "__OPENCL_VERSION__=120", *options, "-S", os.path.join(work, "kernel.cl"), "-o", ptx])
    return ptx


def instructions(cubin):
    """Returns the number of instructions of the kernel, padding included."""
    sizes = re.findall(r"\.text\.cml_transport\s+PROGBITS\s+\S+\s+\S+\s+([0-9a-f]+)", call(["readelf", "-SW", cubin]))
    return int(sizes[0], 16) // INSTRUCTION


def resident_warps(registers, device):
    """Returns the warps of a multiprocessor that can run together, by registers and local memory."""
    of_warp = (registers * WARP + 255) // 256 * 256
    by_registers = REGISTERS // of_warp // (GROUP // WARP)
    groups = min(by_registers, LOCAL_KB[device] // (NEAR_KB + 1), WARPS // (GROUP // WARP))  # the system takes a KiB of each group
    return groups * (GROUP // WARP)


def row_of(work, ptxas, ptx, device, kind, limit):
    cubin = os.path.join(work, "kernel.cubin")
    said = call([ptxas, "-v", "-arch=" + device, *(["--maxrregcount=%d" % limit] if limit else []), ptx, "-o", cubin])
    part = said[said.index("properties for cml_transport"):]
    stack, stores, loads = (int(n) for n in re.search(
        r"(\d+) bytes stack frame, (\d+) bytes spill stores, (\d+) bytes spill loads", part).groups())
    registers = int(re.search(r"Used (\d+) registers", part)[1])
    warps = resident_warps(registers, device)
    return [device, kind, limit or "any", registers, "%d + %d" % (stores, loads), stack, instructions(cubin), warps,
            "%.0f %%" % (100 * warps / WARPS)]


def measure(work, clang, library, ptxas):
    with open(os.path.join(work, "atomics.h"), "w", encoding="ascii") as file:
        file.write(ATOMICS % ("global", "global") + ATOMICS % ("local", "shared"))
    rows = []
    for device in LOCAL_KB:
        for kind, options in KINDS:
            ptx = to_ptx(work, clang, library, device, options)
            rows += [row_of(work, ptxas, ptx, device, kind, limit) for limit in LIMITS]
    return rows


def missing(text):
    print("gpu_static.py: " + text, file=sys.stderr)
    sys.exit(77)


def find_clang(wanted):
    """Returns (clang, the library of the target's functions)."""
    names = [wanted] if wanted else ["clang-16", "clang-17", "clang-18", "clang-19", "clang"]
    clang = next(filter(None, map(shutil.which, names)), None)
    if not clang:
        missing("%s is missing (packages clang-16 libclc-16-dev)" % names[-1])
    if "nvptx64" not in call([clang, "--print-targets"]):
        missing("%s knows no nvptx64" % clang)
    found = [path for folder in ("/usr/lib/clc", "/usr/share/clc", "/usr/lib/llvm-*/share/clc")
             for path in glob.glob(folder + "/**/nvptx64--nvidiacl.bc", recursive=True)]
    if not found:
        missing("nvptx64--nvidiacl.bc is missing (package libclc-16 or newer)")
    return clang, found[0]


def find_ptxas(out):
    """Returns the path of ptxas, from the PATH or from a wheel of NVIDIA's."""
    if shutil.which("ptxas"):
        return shutil.which("ptxas")
    wheel = os.path.join(out, "ptxas")
    if not os.path.isdir(wheel) and subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", wheel,
                                                    "nvidia-cuda-nvcc-cu12"], stdout=sys.stderr, check=False).returncode:
        missing("ptxas is missing, and so is a package registry to get it from")
    found = [path for path in glob.glob(wheel + "/**/ptxas", recursive=True) if os.path.isfile(path)]
    if not found:
        missing("no ptxas in %s" % wheel)
    os.chmod(found[0], 0o755)
    return found[0]


def kernels(path):
    if not os.path.isfile(os.path.join(path, "transport.cl")):
        raise argparse.ArgumentTypeError("%s: no folder of kernels" % path)
    return os.path.abspath(path)


def write_readme(path, readme):
    with open(path, encoding="utf-8") as file:
        titles, *rows = csv.reader(file)
    tables.replace(readme, "parts/gpu_static.py", list(tables.table(titles, rows)))


def main():
    parser = command.parser(__doc__, place=("kernels", kernels, os.path.join(cases.ROOT, "kernels")))
    parser.add_argument("--clang")
    parser.add_argument("--ptxas")
    command.instead(parser, "--readme", ("CSV", "README"), write_readme)
    arguments = parser.parse_args()
    command.need(parser, "cmake", "readelf")
    clang, library = find_clang(arguments.clang)
    os.makedirs(arguments.out, exist_ok=True)
    ptxas = arguments.ptxas or find_ptxas(arguments.out)
    with tempfile.TemporaryDirectory() as work:
        kernel = os.path.join(work, "kernel")
        call(["cmake", "-D", "KERNELS=" + arguments.kernels, "-D", "OUTPUT=" + kernel, "-P",
              os.path.join(cases.ROOT, "src", "engine", "opencl", "opencl_text.cmake")])
        os.rename(kernel + ".text", kernel + ".cl")
        rows = measure(work, clang, library, ptxas)
    with open(os.path.join(arguments.out, "gpu_static.csv"), "w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([TITLES, *rows])
    print("%s; %s" % (call([clang, "--version"]).splitlines()[0], call([ptxas, "--version"]).splitlines()[-1]))
    print("\n".join(tables.table(TITLES, rows)))


main()
