#!/usr/bin/env python3
"""Measures the light that single scattering at rough faces loses: rough_faces.py [--photons N] [--rounds N] [--program PATH] [--out DIR]

A slab with rough faces is simulated by this program, whose light walks on the facets until it leaves, and by Mitsuba 3's `roughdielectric`, whose
light is reflected or refracted once, and lost if it would meet the surface again. The unabsorbed share of a pencil is compared; Mitsuba measures it
as the light along its ray in an even environment. Both use as many packets in as many rounds, and errors come from the spread of rounds. `pip
install mitsuba`. Leaves rough_faces.md in DIR; takes some minutes on one thread. bench/peers/README.md says more.

SPDX-License-Identifier: MIT
"""
import importlib.metadata
import json
import math
import os
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import command
import picture
import runs
import slab
import tables

N, MEDIUM, D = 1.5, [1, 20, 0.8], 0.5
FACES = ((), ("beckmann", 0.2), ("beckmann", 0.5), ("beckmann", 1), ("ggx", 0.2), ("ggx", 0.5), ("ggx", 1))
ANGLES = (0, 45)
UNIT, HALF_WIDTH = 100, 30.0  # units of a cm; half the width of the slab [cm]
TITLES = ("faces", "angle", "ours: not absorbed", "Mitsuba", "lost", "z", "ours, core s of 1e6", "Mitsuba")


def box(path):
    """Writes the slab, closed far away."""
    square = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    vertices = [(HALF_WIDTH * x, HALF_WIDTH * y, z) for z in (0, D) for x, y in square]
    sides = [[b, a, a + 4, b + 4] for a, b in ((1, 2), (2, 3), (3, 4), (4, 1))]
    slab.write_ply((vertices, [[1, 2, 3, 4], [8, 7, 6, 5], *sides]), path, UNIT)


def ours(program, work, faces, angle, photons, seeds):
    """Returns (core seconds, share that is not absorbed) of this program, by seed."""
    line = "rough %s %g" % faces if faces else "# smooth"
    path = os.path.join(work, "slab.mci")
    with open(path, "w", encoding="ascii") as stream:
        stream.write("1.0\n1\nslab.mco A\n1000\n0.1 1\n5 1 1\nbeam pencil angle=%g\n1\n1\n%s\n%g %s %g\n%s\n1\n" % (
            angle, line, N, " ".join("%g" % x for x in MEDIUM), D, line))
    for seed in seeds:
        record = runs.records([program, path, "--json", "--quiet", "--threads", "1", "--sampling", "random", "--seed", str(seed),
                               "--photons", str(photons), "-o", work])[0]
        yield record["cpu_s"], 1 - record["A"]


def mitsuba(work, faces, angle, photons, seeds):
    """Returns (core seconds, share that is not absorbed) of Mitsuba, by seed."""
    path = os.path.join(work, "slab.json")
    scene = {"unit": UNIT, "angle": angle, "media": {"0": MEDIUM}, "shapes": [
        {"file": os.path.join(work, "slab.ply"), "n": [N, 1.0], "media": ["0", None], **({"rough": faces} if faces else {})}]}
    with open(path, "w", encoding="ascii") as stream:
        json.dump(scene, stream)
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "mitsuba_slab.py")
    for record in runs.records([sys.executable, "-B", script, path, str(photons), *map(str, seeds)]):
        yield record["seconds"], 1 - record["absorbed"]


def measured(flights, photons):
    """Returns (share, its error, core seconds of 1e6 packets) of flights of `photons` packets."""
    seconds, shares = zip(*flights)
    return statistics.fmean(shares), statistics.stdev(shares) / math.sqrt(len(shares)), 1e6 * statistics.fmean(seconds) / photons


def row_of(arguments, work, faces, angle):
    photons, seeds = arguments.photons // arguments.rounds, range(1, arguments.rounds + 1)
    mine = measured(ours(arguments.program, work, faces, angle, photons, seeds), photons)
    other = measured(mitsuba(work, faces, angle, photons, seeds), photons)
    lost, error = mine[0] - other[0], math.hypot(mine[1], other[1])
    print(faces, angle, mine, other, file=sys.stderr, flush=True)
    return ["%s %g" % faces if faces else "smooth", angle, "%.4f ± %.4f" % mine[:2], "%.4f ± %.4f" % other[:2],
            "%.1f ± %.1f %%" % (100 * lost / mine[0], 100 * error / mine[0]), "%+.1f" % (lost / error), "%.1f" % mine[2], "%.0f" % other[2]]


def main():
    parser = command.parser(__doc__, photons=120000, rounds=(8, 4))
    arguments = parser.parse_args()
    picture.need(parser, "mitsuba")
    with tempfile.TemporaryDirectory() as work:
        box(os.path.join(work, "slab.ply"))
        rows = [row_of(arguments, work, faces, angle) for faces in FACES for angle in ANGLES]
    about = tables.machine(arguments.program, arguments.rounds)
    tables.keep(os.path.join(arguments.out, "rough_faces.md"), [
        tables.measured(about) + "; Mitsuba %s; %d rounds of %d packets each." % (
            importlib.metadata.version("mitsuba"), arguments.rounds, arguments.photons // arguments.rounds), "", *tables.table(TITLES, rows)])


if __name__ == "__main__":
    main()
