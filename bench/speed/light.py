#!/usr/bin/env python3
"""Measures the cost of sources and phase functions: light.py [--rounds N] [--program PATH] [--out DIR]

Launches: packets are absorbed at once, by a medium with the index of its surroundings, so that a run does nothing else. Phase functions: a slab
(S6a of g = 0.9) has Henyey and Greenstein's function, or the same function as gk and as a table, which are drawn alike. Leaves light.md in DIR,
with medians of processor time, and of the difference or ratio to the first row. bench/speed/README.md says more.

SPDX-License-Identifier: MIT
"""
import math
import os
import statistics
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command
import runs
import tables

FEW = 2000  # photons of the shorter run; the difference of two runs removes all time outside of the flight
LAUNCHED, SCATTERED = 10000000, 200000
BEAMS = ("disk 0.1", "pencil", "gaussian 0.1", "ring 0.05 0.1", "rectangle 0.1 0.2", 'image "stripes.gsf"', "disk 0.1 light=na:0.5",
         "disk 0.1 light=lambertian", 'disk 0.1 light="lamp.txt"', "disk 0.1 z=0.1 light=isotropic")


def scenes(folder):
    """Yields kind, name, lines. The first scene of a kind is the standard for the others."""
    with open(os.path.join(folder, "lamp.txt"), "w") as file:
        file.write("0 1\n30 0.8\n60 0\n")
    with open(os.path.join(cases.ROOT, "meshes", "stripes.gsf"), "rb") as image, open(os.path.join(folder, "stripes.gsf"), "wb") as copy:
        copy.write(image.read())
    for beam in BEAMS:
        yield "launch", beam, ["1.0", "1", "light.mco A", "1", "beam " + beam, "0.1 0.1", "1 1 1", "1", "1.0", "1.0 1000 0 0 1", "1.0"]
    lines, g = cases.data_lines("S6a"), 0.9
    layer = next(k for k, line in enumerate(lines) if line.startswith("1.4 "))
    lines[layer] = f"1.4 0.1 90 {g} 0.5"
    with open(os.path.join(folder, "law.txt"), "w") as file:
        for i in range(3601):  # points are closest where the function is steep
            t = 180 * (i / 3600) ** 2
            file.write(f"{t:.10g} {(1 + g * g - 2 * g * math.cos(math.radians(t))) ** -1.5:.17g}\n")
    for phase in ("", f"phase gk {g} 0.5", 'phase table "law.txt"'):
        yield "phase", phase or "Henyey and Greenstein", lines[:layer + 1] + [phase] * bool(phase) + lines[layer + 1:]


def cpu_seconds(program, folder, photons, seed):
    (record,) = runs.records([program, "run", "light.mci", "--photons", str(photons), "--seed", str(seed), "--threads", "1",
                              "--json", "--checkpoint", "off"], folder)
    return record["cpu_s"], record["steps"]


def nanoseconds(program, folder, kind, lines, seed):
    """Returns the nanoseconds of a packet (launches) or of a step (phase functions)."""
    with open(os.path.join(folder, "light.mci"), "w") as file:
        file.write("\n".join(lines) + "\n")
    many = LAUNCHED if kind == "launch" else SCATTERED
    few_s, few_steps = cpu_seconds(program, folder, FEW, seed)
    many_s, many_steps = cpu_seconds(program, folder, many, seed)
    return 1e9 * (many_s - few_s) / (many - FEW if kind == "launch" else many_steps - few_steps)


def lines(arguments):
    folder = os.path.join(arguments.out, "light")
    os.makedirs(folder, exist_ok=True)
    flown = {scene[:2]: (scene[2], []) for scene in scenes(folder)}
    for number in range(arguments.rounds):
        for kind, name in list(flown) if number % 2 == 0 else list(reversed(flown)):
            text, found = flown[kind, name]
            found.append(nanoseconds(arguments.program, folder, kind, text, number + 1))
    yield tables.measured(tables.machine(arguments.program, arguments.rounds)) + f"; median (least-most) of {arguments.rounds} rounds."
    for kind, heading in (("launch", ["beam", "ns/packet", "beyond a disk"]), ("phase", ["phase function", "ns/step", "times"])):
        names = [name for of, name in flown if of == kind]
        first = flown[kind, names[0]][1]
        rows = []
        for name in names:
            ns = flown[kind, name][1]
            beside = [mine - disk for mine, disk in zip(ns, first)] if kind == "launch" else [mine / law for mine, law in zip(ns, first)]
            rows.append([name.removeprefix("phase ")] + [f"{statistics.median(v):.{d}f} ({min(v):.{d}f}-{max(v):.{d}f})" for v, d in (
                (ns, 1), (beside, 1 if kind == "launch" else 3))])
        yield ""
        yield from tables.table(heading, rows)


def main():
    arguments = command.parser(__doc__, rounds=7).parse_args()
    tables.keep(os.path.join(arguments.out, "light.md"), list(lines(arguments)))


main()
