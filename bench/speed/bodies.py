#!/usr/bin/env python3
"""Measures the cost of bodies: bodies.py [--rounds N] [--against PATH] [--program PATH] [--out DIR]

Runs scenes with a body and without it, also with another clustermcml (--against) in the same rounds. Leaves bodies.md in DIR, with medians of the
processor time per step, and of the steps per second over those of the same scene without bodies. bench/speed/README.md says more.

SPDX-License-Identifier: MIT
"""
import os
import statistics
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command
import runs
import shapes
import tables

FEW, MANY = 2000, 150000  # photons of two runs, whose difference removes all time outside of steps
EDGE_PARTS = 71  # 20 * 71^2 = 100820 triangles
OTHER = "1.5 1 50 0.5"  # medium of the bodies in S6a


def scenes():
    """Yields name, lines, and name of the scene without bodies."""
    lines = cases.data_lines("S6a")
    layer = next(k for k, line in enumerate(lines) if line.startswith("1.4 ")) + 1
    bodies = {"S6a-mesh-1e5": f'i "ball.obj" {OTHER} shift=0,0,-0.25', "S6a-sphere-0.1": f"i sphere 0 0 0.25 0.1 {OTHER}",
              "S6a-sphere-0.05": f"i sphere 0 0 0.25 0.05 {OTHER}"}
    yield "S6a", lines, "S6a"
    for name, body in bodies.items():
        yield name, lines[:layer] + [body] + lines[layer:], "S6a"
    for name in ("vessel", "beads"):
        lines = cases.lines_of("samples/%s.mci" % name)
        yield name + "-none", [line for line in lines if not line.startswith("i ")], name + "-none"
        yield name, lines, name + "-none"


def fly(program, folder, name, photons, seed):
    (record,) = runs.records([program, "run", name + ".mci", "--photons", str(photons), "--seed", str(seed), "--threads", "1",
                              "--json", "--checkpoint", "off"], folder)
    return record


def measure(program, folder, name, seed):
    few, many = (fly(program, folder, name, photons, seed) for photons in (FEW, MANY))
    return {"ns": 1e9 * (many["cpu_s"] - few["cpu_s"]) / (many["steps"] - few["steps"]),
            "queries": many["queries"] / many["steps"], "lost": many["lost"]}


def lines(arguments):
    """Returns the table of all programs, which take turns."""
    folder, programs = os.path.join(arguments.out, "bodies"), [arguments.program] + [arguments.against] * bool(arguments.against)
    os.makedirs(folder, exist_ok=True)
    shapes.write_ball(os.path.join(folder, "ball.obj"), 0.1, EDGE_PARTS)
    without = {}
    for name, text, flat in scenes():
        without[name] = flat
        with open(os.path.join(folder, name + ".mci"), "w") as file:
            file.write("\n".join(text) + "\n")
    flown = {(name, program): [] for name in without for program in programs}
    for number in range(arguments.rounds):
        for name, program in list(flown) if number % 2 == 0 else list(reversed(flown)):
            flown[name, program].append(measure(program, folder, name, number + 1))
    yield tables.measured(tables.machine(arguments.program, arguments.rounds)) + f"; {arguments.rounds} rounds."
    yield ""
    rows = []
    for (name, program), results in flown.items():
        ns = [r["ns"] for r in results]
        ratio = statistics.median(r["ns"] / mine for r, mine in zip(flown[without[name], program], ns))
        rows.append([name, *([os.path.basename(program)] * (len(programs) > 1)),
                     f"{statistics.median(ns):.1f} ({min(ns):.1f}-{max(ns):.1f})", f"{ratio:.2f}",
                     f"{100 * results[0]['queries']:.2f}", sum(r["lost"] for r in results)])
    yield from tables.table(["scene", *["program"] * (len(programs) > 1), "ns/step", "over no body", "queries %", "lost"], rows)


def main():
    parser = command.parser(__doc__, rounds=5)
    parser.add_argument("--against", type=command.built)
    arguments = parser.parse_args()
    tables.keep(os.path.join(arguments.out, "bodies.md"), list(lines(arguments)))


main()
