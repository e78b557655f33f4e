#!/usr/bin/env python3
"""Tables of what divergence.sh counts: divergence.py CSV prints them, divergence.py --readme CSV README writes them into a text.

SPDX-License-Identifier: MIT
"""
import csv
import os
import sys

import block

NAMES = {"fig5.mci": "S1", "fig6.mci": "S2", "fig7text.mci": "S3", "mcml_sample.mci": "S4", "skin7.mci": "S5",
         "thick.mci": "S6a", "S6b.mci": "S6b", "hihill.mci": "hihill"}
BEFORE = "each pass, lattice apart"
STAGES = ("fly", "boundary", "interact", "roulette", "replace")
UNITS = 132  # multiprocessors of an H100
HERE = os.path.dirname(os.path.abspath(__file__))


def read(path):
    """Rows by scene and order."""
    scenes = {}
    with open(path, encoding="utf-8") as file:
        for row in csv.DictReader(file):
            scene, order = row["scene and order"].split(": ")
            scenes.setdefault(scene, {})[order] = row
    return scenes


def kernels_order(rows):
    return rows["8 passes" if rows[BEFORE]["only planes"] == "1" else "2 passes"]  # CML_DEVICE_PASSES of kernels/device_lanes.h


def resident_lanes():
    """Of the newest device in the table of registers, for planes and for cones."""
    with open(os.path.join(HERE, "results", "gpu-static.csv"), encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["device"] == "sm_90" and row["registers at most"] == "any"]
    return {row["boundaries"]: UNITS * 32 * int(row["warps of 64"]) for row in rows}


def prices(scenes):
    names = list(next(iter(scenes.values())))
    yield from block.table(["scene", "no lane waits", *names],
                           [[NAMES[scene], rows[BEFORE]["least"], *(rows[name]["instructions"] for name in names)]
                            for scene, rows in scenes.items()])


def shares(scenes):
    def cell(rows, stage):
        return "%.0f, %.0f" % tuple(100 * float(row[stage + " share"]) for row in (rows["each pass"], kernels_order(rows)))
    yield from block.table(["scene", *STAGES],
                           [[NAMES[scene], *(cell(rows, stage) for stage in STAGES)] for scene, rows in scenes.items()])


def additions(scenes):
    lanes = resident_lanes()
    rows = []
    for scene, of_orders in scenes.items():
        row = kernels_order(of_orders)
        far = 1 - float(row["in local memory"])
        others = lanes["planes" if row["only planes"] == "1" else "cones"] * far * float(row["collision"])
        rows.append([NAMES[scene], "%.2f" % float(row["deposit"]), "%.0f %%" % (100 - 100 * far), "%.3f" % float(row["layer"]),
                     "%.2f" % float(row["sums"]), "%.1f" % float(row["lanes"]), "%.0f %%" % (100 * float(row["one bin"])),
                     "%.1f" % float(row["busiest"]), "%.1f" % (32 * float(row["replace share"])), "%.0f" % others])
    yield from block.table(["scene", "A_rz", "of it local", "A_l", "sums and exits", "lanes at A_rz", "share a bin", "most at a bin",
                            "lanes at sums", "others at a bin, global"], rows)


def text(path):
    scenes = read(path)
    yield "Instructions of a warp per event, times 32 lanes:"
    yield ""
    yield from prices(scenes)
    yield ""
    yield "Lanes of 32 that are active when a warp does a stage, in per cent: in each pass, and in the kernel's order:"
    yield ""
    yield from shares(scenes)
    yield ""
    yield "Atomic additions per event, and lanes that add together:"
    yield ""
    yield from additions(scenes)


def main():
    if sys.argv[1] == "--readme":
        block.replace(sys.argv[3], "divergence.py", list(text(sys.argv[2])))
    else:
        print("\n".join(text(sys.argv[1])))


main()
