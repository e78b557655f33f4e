#!/usr/bin/env python3
"""Compares samples/vessel.mci with MMC: vessel.py --mmc PATH [--photons N] [--runs N] [--program PATH] [--out DIR]

MMC (https://github.com/fangq/mmc, `make -C src omp`) simulates the sample's layers and its vessel. The vessel is the prism that `clustermcml mesh`
makes of it, filled with tetrahedra by tetgen; the layers end HALF_WIDTH from the middle. This program simulates the sample unchanged, and in double
precision with the prism. The share of light that each medium absorbs is compared. Errors come from the spread of runs. Leaves vessel.md in DIR.

SPDX-License-Identifier: MIT
"""
import json
import math
import os
import re
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command
import tables
import slab

sys.path.insert(0, os.path.join(cases.ROOT, "tests", "lib"))
import cml  # noqa: E402

SAMPLE = os.path.join(cases.ROOT, "samples", "vessel.mci")
HALF_WIDTH = 1.0  # [cm]
ABOVE = 0.01  # height of the space above the layers in which MMC's beam starts [cm]
TOLERANCE = "1e-3"
TITLES = ("absorbed by", "MMC", "ours, `cpu`", "off by", "ours, `reference`, prism", "off by")


def read_sample():
    """Returns ([(n, mua, mus, g, d)] of the layers, radius of the beam)."""
    rows = [line.split() for line in cases.lines_of(SAMPLE)]
    beam = next(float(row[2]) for row in rows if row[0] == "beam")
    body = next(i for i, row in enumerate(rows) if row[0] == "i")
    layers = [tuple(map(float, row)) for row in rows[body - 3:body]]
    return layers + [(*map(float, rows[body][9:]), 0.0)], beam


def write_poly(vessel, depths, path):
    """Writes tetgen's input: plates at all depths [cm, z down], walls around, the vessel, and a region for each layer and the vessel."""
    square = [(-HALF_WIDTH, -HALF_WIDTH), (HALF_WIDTH, -HALF_WIDTH), (HALF_WIDTH, HALF_WIDTH), (-HALF_WIDTH, HALF_WIDTH)]
    points, polygons = [(x, y, z) for z in depths for x, y in square], []
    for i in range(len(depths)):
        first = 4 * i + 1
        polygons.append([first + k for k in range(4)])
        if i + 1 < len(depths):
            polygons += [[first + k, first + (k + 1) % 4, first + 4 + (k + 1) % 4, first + 4 + k] for k in range(4)]
    with open(vessel, encoding="ascii") as stream:
        before = len(points)
        for words in map(str.split, stream):
            if words[0] == "v":
                points.append((float(words[1]), float(words[2]), 0.0 - float(words[3])))
            elif words[0] == "f":
                polygons.append([before + int(word.split("/")[0]) for word in words[1:]])
    inside = [(0.9 * HALF_WIDTH, 0.9 * HALF_WIDTH, 0.5 * (a + b)) for a, b in zip(depths, depths[1:])]
    middle = [sum(p[k] for p in points[before:]) / len(points[before:]) for k in range(3)]
    with open(path, "w", encoding="ascii") as stream:
        stream.write("%d 3 0 0\n" % len(points))
        stream.writelines("%d %.17g %.17g %.17g\n" % (i, *p) for i, p in enumerate(points, 1))
        stream.write("%d 0\n" % len(polygons))
        stream.writelines("1\n%d %s\n" % (len(polygon), " ".join(map(str, polygon))) for polygon in polygons)
        stream.write("0\n%d\n" % (len(inside) + 1))
        stream.writelines("%d %.17g %.17g %.17g %d 0\n" % (i, *p, i) for i, p in enumerate([*inside, middle], 1))


def prepare(program, folder):
    """Writes MMC's input. Returns the media of its tetrahedra, 0 above the layers."""
    layers, beam = read_sample()
    subprocess.run([program, "mesh", SAMPLE, "--tolerance", TOLERANCE, "-o", folder], check=True, capture_output=True)
    depths = [-ABOVE, 0.0]
    for layer in layers[:-1]:
        depths.append(depths[-1] + layer[4])
    stem = os.path.join(folder, "vessel")
    write_poly(stem + ".mco.body1.obj", depths, stem + ".poly")
    subprocess.run(["tetgen", "-pAQ", stem + ".poly"], check=True, stdout=subprocess.DEVNULL)
    nodes, cells = slab.read_tetgen(stem + ".1.node", float), slab.read_tetgen(stem + ".1.ele", float)
    media = [int(cell[4]) - 1 for cell in cells]
    mm = slab.MM
    scene = {"Mesh": {"MeshID": "vessel", "InitElem": media.index(0) + 1,
                      "MeshNode": [[mm * x for x in node[:3]] for node in nodes],
                      "MeshElem": [[*map(int, cell[:4]), medium or -1] for cell, medium in zip(cells, media)]},
             "Domain": {"Media": [{"mua": 0, "mus": 0, "g": 1, "n": layers[0][0]}]
                        + [{"mua": mua / mm, "mus": mus / mm, "g": g, "n": n} for n, mua, mus, g, _ in layers]},
             "Session": {"Photons": 1, "RNGSeed": 1, "ID": "vessel", "DoMismatch": 0},
             "Forward": {"T0": 0, "T1": 1e-6, "Dt": 1e-6},
             "Optode": {"Source": {"Type": "disk", "Pos": [0, 0, -0.5 * mm * ABOVE], "Dir": [0, 0, 1],
                                   "Param1": [mm * beam, 0, 0, 0]}}}
    with open(stem + ".json", "w", encoding="ascii") as stream:
        json.dump(scene, stream)
    return media


def fly_mmc(mmc, folder, media, photons, seed):
    """Returns [share that layer 1, 2, 3 and the vessel absorb]."""
    line = [mmc, "-f", "vessel.json", "-c", "sse", "-G", "-1", "-M", "S", "-b", "0", "-C", "0", "-e", "1e-4", "-O", "E",
               "-F", "ascii", "-S", "1", "-d", "0", "-D", "T", "-n", repr(photons), "-E", str(seed), "-s", "flown"]
    done = subprocess.run(line, cwd=folder, capture_output=True, text=True, check=True)
    printed = re.search(r"absorbed: +([\d.]+)%", re.sub(r"\x1b\[[0-9;]*m", "", done.stdout))
    shares = [0.0] * (max(media) + 1)
    with open(os.path.join(folder, "flown.dat"), encoding="ascii") as stream:
        for medium, line in zip(media, stream):
            shares[medium] += float(line.split()[1])
    if not printed or abs(sum(shares) - float(printed.group(1)) / 100) > 1e-4:
        sys.exit("MMC: tetrahedra absorb %g, it says %s" % (sum(shares), printed and printed.group(1)))
    return shares[1:]


def fly_ours(program, folder, photons, seed, *options):
    line = [program, SAMPLE, "--photons", repr(photons), "--seed", str(seed), "--quiet", "-o", folder, *options]
    subprocess.run(line, check=True)
    sections = cml.read_sections(os.path.join(folder, "vessel.mco"))
    return sections["A_l"] + sections["A_body"]


def summed(runs):
    """Returns [(mean, standard error)] of each number of the runs, and of their sum."""
    runs = [[*run, sum(run)] for run in runs]
    return [(statistics.fmean(column), statistics.stdev(column) / math.sqrt(len(runs))) for column in zip(*runs)]


def lines(arguments):
    seeds = range(1, arguments.runs + 1)
    with tempfile.TemporaryDirectory() as folder:
        media = prepare(arguments.program, folder)
        mmc = summed([fly_mmc(arguments.mmc, folder, media, arguments.photons, seed) for seed in seeds])
        cpu = summed([fly_ours(arguments.program, folder, arguments.photons, seed) for seed in seeds])
        prism = summed([fly_ours(arguments.program, folder, arguments.photons, seed + 100, "--engine", "reference",
                                 "--boundaries", "mesh", "--tolerance", TOLERANCE) for seed in seeds])
    yield tables.measured(tables.machine(arguments.program, arguments.runs)) + (
        "; %d runs of %.0e photons each; %d tetrahedra. Off by so many errors of the difference." % (
            arguments.runs, arguments.photons, len(media)))
    yield ""
    rows = []
    for name, a, b, c in zip(("gel", "epidermis", "dermis", "vessel", "all"), mmc, cpu, prism):
        rows.append([name, "%.5f ± %.5f" % a, "%.5f ± %.5f" % b, "%+.1f" % ((b[0] - a[0]) / math.hypot(a[1], b[1])),
                     "%.5f ± %.5f" % c, "%+.1f" % ((c[0] - a[0]) / math.hypot(a[1], c[1]))])
    yield from tables.table(TITLES, rows)


def main():
    parser = command.parser(__doc__, photons=300000, runs=(8, 4))
    parser.add_argument("--mmc", type=command.built, required=True)
    arguments = parser.parse_args()
    tables.keep(os.path.join(arguments.out, "vessel.md"), list(lines(arguments)))


if __name__ == "__main__":
    main()
