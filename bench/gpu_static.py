#!/usr/bin/env python3
"""Compiles the OpenCL kernel for NVIDIA's GPUs and says what it needs there: gpu_static.py WORK CLANG LIBRARY PTXAS CSV STAGES,
with WORK/kernel.cl; gpu_static.py --readme CSV README writes the table into a text. STAGES: another CSV, the instructions of
each stage on the last device, compiled as functions of their own.

SPDX-License-Identifier: MIT
"""
import csv
import os
import re
import subprocess
import sys

import block

GROUP = 128  # work-items: GPU_GROUP of src/engine/opencl/opencl_flight.c
NEAR_KB = 16  # local memory of a group: NEAR_BYTES_SHARED there
INSTRUCTION = 16  # bytes, from sm_70 on
# Of a multiprocessor: registers, warps, local memory [KiB] (CUDA C++ Programming Guide 12.9, table "Technical Specifications
# per Compute Capability"); registers are handed out to warps by the 256
REGISTERS, WARPS, WARP = 65536, 64, 32
LOCAL_KB = {"sm_70": 96, "sm_80": 164, "sm_90": 228}
KINDS = (("planes", ["-D", "CML_ONLY_PLANES", "-D", "CML_WITHOUT_BODIES"]), ("cones", ["-D", "CML_WITHOUT_BODIES"]), ("cones, bodies", []))
LIMITS = (0, 96, 80)  # registers that ptxas may take at most; 0: as many as it wants
# what a lane waits for if another one does it (CML_STAGE of kernels/device_lanes.h), and the lattice's part of flying
STAGES = {"fly": "fly", "boundary": "process_lane", "interact": "interact", "deposit": "deposit", "roulette": "roulette",
          "replace": "replace"}
TITLES = ("device", "boundaries", "registers at most", "registers", "spilled to memory [bytes]", "stack [bytes]", "instructions",
          "warps of 64", "occupancy")

# clang's headers declare the 64-bit additions for no device of this target
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
    """Of the kernel, padding included."""
    sizes = re.findall(r"\.text\.cml_transport\s+PROGBITS\s+\S+\s+\S+\s+([0-9a-f]+)", call(["readelf", "-SW", cubin]))
    return int(sizes[0], 16) // INSTRUCTION


def functions(cubin):
    """Instructions of the functions that the kernel calls."""
    found = re.findall(r"\s(0x[0-9a-f]+|\d+) FUNC .*\$cml_transport\$cml_device_(\w+)", call(["readelf", "-sW", cubin]))
    return {name: int(size, 0) // INSTRUCTION for size, name in found}


def stages(work, clang, library, ptxas, device):
    """Rows of boundaries, stage, instructions. What a lane does more while its packet draws from the lattice is the difference
    to a kernel in which none does."""
    for kind, options in KINDS:
        sizes = []
        for more in ([], ["-D", "CML_NO_LATTICE"]):
            ptx = to_ptx(work, clang, library, device,
                         [*options, *more, "-D", "CML_STAGE=static __attribute__((noinline))"])
            cubin = os.path.join(work, "stages.cubin")
            call([ptxas, "-arch=" + device, ptx, "-o", cubin])
            sizes.append(functions(cubin))
        with_lattice, without = sizes
        yield from ([kind, name, with_lattice[function]] for name, function in STAGES.items() if name != "fly")
        yield [kind, "fly", without["fly"]]
        yield [kind, "lattice", with_lattice["fly"] - without["fly"]]


def resident_warps(registers, device):
    """Warps of a multiprocessor that can be in flight together, by registers and local memory."""
    of_warp = (registers * WARP + 255) // 256 * 256
    by_registers = REGISTERS // of_warp // (GROUP // WARP)
    groups = min(by_registers, LOCAL_KB[device] // (NEAR_KB + 1), WARPS // (GROUP // WARP))  # a KiB of each is the system's
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


def main():
    if sys.argv[1] == "--readme":
        with open(sys.argv[2], encoding="utf-8") as file:
            titles, *rows = csv.reader(file)
        block.replace(sys.argv[3], "gpu_static.py", list(block.table(titles, rows)))
        return
    work, clang, library, ptxas, target, stages_csv = sys.argv[1:7]
    rows = measure(work, clang, library, ptxas)
    with open(stages_csv, "w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([["boundaries", "stage", "instructions"],
                                    *stages(work, clang, library, ptxas, list(LOCAL_KB)[-1])])
    with open(target, "w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([TITLES, *rows])
    print("%s; %s" % (call([clang, "--version"]).splitlines()[0], call([ptxas, "--version"]).splitlines()[-1]))
    print("\n".join(block.table(TITLES, [[str(cell) for cell in row] for row in rows])))


main()
