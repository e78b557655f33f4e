#!/usr/bin/env python3
"""Measures the bias of spheres and cylinders as meshes: body_bias.py [--photons N] [--runs N] [--program PATH] [--out DIR]

Each scene is simulated with its exact body and with meshes of falling tolerance, with the same packets, in independent runs. The bias is that of
the body's absorption; its error comes from paired differences. The order is the slope of the bias's logarithm over that of the number of segments,
weighted by how well each bias is known. Leaves body_bias.md in DIR.

SPDX-License-Identifier: MIT
"""
import math
import os
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import command
import runs
import tables

HEAD = "1.0\n1\nbody.mco A\n1000\n0.01 0.01\n10 10 1\nbeam disk 0.2\n1\n1.4\n"
SCENES = {
    "black sphere, parallel light": HEAD + "1.4 0 0 0 0.5\ni sphere 0 0 0.25 0.15 1.4 1e9 0 0\n1.4\n",
    "black cylinder, parallel light": HEAD + "1.4 0 0 0 0.5\ni cylinder -0.1 0 0.2 0.1 0.05 0.3 0.1 1.4 1e9 0 0\n1.4\n",
    "sphere of n = 1.5 under paint": HEAD + "1.37 0.2 50 0.5 0.5\ni sphere 0 0 0.25 0.15 1.5 20 50 0.8\n1.4\n",
    "cylinder of n = 1.33 under paint": HEAD + "1.37 0.2 50 0.5 0.5\ni cylinder -0.3 0 0.25 0.3 0.05 0.25 0.05 1.33 20 50 0.8\n1.4\n",
}
TOLERANCES = ("1e-1", "3e-2", "1e-2", "3e-3", "1e-3")
TITLES = ("scene", "triangles", "tolerance", "bias of A", "its error", "order")


def fly(program, path, photons, seed, *options):
    """Returns (share that the body absorbs, its facets)."""
    line = [program, path, "--json", "--quiet", "--photons", repr(photons), "--seed", str(seed), "--ignore-absorption",
               "-o", os.path.dirname(path), *options]
    body = runs.records(line)[0]["bodies"][0]
    return body["A"], body["primitives"]


def segments(scene, triangles):
    """Returns the number n of segments into which edges are cut: a sphere has 20 n^2 triangles, a prism 4 n - 4."""
    return math.sqrt(triangles / 20) if "sphere" in scene else (triangles + 4) / 4


def measure(program, path, arguments):
    """Returns [(tolerance, triangles, bias, error)]."""
    seeds = range(1, arguments.runs + 1)
    exact = [fly(program, path, arguments.photons, seed)[0] for seed in seeds]
    rows = []
    for tolerance in TOLERANCES:
        flown = [fly(program, path, arguments.photons, seed, "--boundaries", "mesh", "--tolerance", tolerance) for seed in seeds]
        off = [(a - b) / statistics.fmean(exact) for (a, _), b in zip(flown, exact)]
        rows.append((tolerance, flown[0][1], statistics.fmean(off), statistics.stdev(off) / math.sqrt(len(off))))
    return rows


def order(scene, rows):
    """Returns (slope, error) of the bias over the segments, from biases that are known to a third."""
    known = [(math.log(segments(scene, n)), math.log(abs(bias)), bias / error) for _, n, bias, error in rows
             if abs(bias) > 3 * error]
    if len(known) < 2:
        return None
    weight = sum(w * w for _, _, w in known)
    x0, y0 = (sum(w * w * k[i] for k in known for w in k[2:]) / weight for i in (0, 1))
    square = sum(w * w * (x - x0) ** 2 for x, _, w in known)
    return -sum(w * w * (x - x0) * (y - y0) for x, y, w in known) / square, 1 / math.sqrt(square)


def lines(arguments):
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for scene, text in SCENES.items():
            path = os.path.join(folder, "body.mci")
            with open(path, "w", encoding="ascii") as file:
                file.write(text)
            measured = measure(arguments.program, path, arguments)
            slope = order(scene, measured)
            for i, (tolerance, triangles, bias, error) in enumerate(measured):
                rows.append([scene if i == 0 else "", str(triangles), tolerance, f"{bias:+.1e}", f"{error:.0e}",
                             f"{slope[0]:.2f} ± {slope[1]:.2f}" if i == 0 and slope else ""])
    yield tables.measured(tables.machine(arguments.program, arguments.runs)) + (
        f"; {arguments.runs} pairs of runs of {arguments.photons:.0e} photons.")
    yield ""
    yield from tables.table(TITLES, rows)


def main():
    arguments = command.parser(__doc__, photons=300000, runs=(16, 4)).parse_args()
    tables.keep(os.path.join(arguments.out, "body_bias.md"), list(lines(arguments)))


if __name__ == "__main__":
    main()
