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
KERNEL = {"planes": "8 passes", "cones": "2 passes"}  # CML_DEVICE_PASSES of kernels/device_lanes.h
STAGES = ("fly", "boundary", "interact", "roulette", "replace")
UNITS = 132  # multiprocessors of an H100
HERE = os.path.dirname(os.path.abspath(__file__))


def read(path):
    """Rows by scene: the orders by name, and what is known of bins."""
    with open(path, encoding="utf-8") as file:
        lines = list(csv.reader(file))
    titles = {line[0]: line for line in lines if line[1] == "scene"}
    orders, bins = {}, {}
    for line in lines:
        if line[1] == "scene":
            continue
        row = dict(zip(titles[line[0]], line))
        if line[0] == "order":
            orders.setdefault(row["scene"], {})[row["order"]] = row
        else:
            bins[row["scene"]] = row
    return orders, bins


def resident_lanes():
    """Of the newest device in the table of registers, for planes and for cones."""
    with open(os.path.join(HERE, "results", "gpu-static.csv"), encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["device"] == "sm_90" and row["registers at most"] == "any"]
    return {row["boundaries"]: UNITS * 32 * int(row["warps of 64"]) for row in rows}


def prices(orders):
    names = list(next(iter(orders.values())))
    yield from block.table(["scene", "no lane waits", *names],
                           [[NAMES[scene], rows[names[0]]["least"], *(rows[name]["instructions"] for name in names)]
                            for scene, rows in orders.items()])


def shares(orders, bins):
    def cell(rows, scene, stage):
        share = [100 * float(rows[name][stage + " share"]) for name in ("each pass", KERNEL[bins[scene]["boundaries"]])]
        return "%.0f, %.0f" % tuple(share)
    yield from block.table(["scene", *STAGES],
                           [[NAMES[scene], *(cell(rows, scene, stage) for stage in STAGES)] for scene, rows in orders.items()])


def additions(bins):
    lanes = resident_lanes()
    rows = []
    for scene, row in bins.items():
        near, busiest = float(row["in local memory"]), float(row["busiest"])
        others = lanes[row["boundaries"]] * (1 - near) * float(row["collision"])
        rows.append([NAMES[scene], "%.2f" % float(row["deposits"]), "%.0f %%" % (100 * near), "%.3f" % float(row["layer"]),
                     "%.2f" % float(row["sums"]), "%.1f" % float(row["lanes"]), "%.0f %%" % (100 * float(row["one bin"])),
                     "%.1f" % busiest, "%.1f" % float(row["replaced together"]), "%.0f" % others])
    yield from block.table(["scene", "A_rz", "of it local", "A_l", "sums and exits", "lanes at A_rz", "share a bin", "most at a bin",
                            "lanes at sums", "others at a bin, global"], rows)


def text(path):
    orders, bins = read(path)
    yield "Instructions of a warp per event, times 32 lanes:"
    yield ""
    yield from prices(orders)
    yield ""
    yield "Lanes of 32 that are active when a warp does a stage, in per cent: in each pass, and in the kernel's order:"
    yield ""
    yield from shares(orders, bins)
    yield ""
    yield "Atomic additions per event, and lanes that add together:"
    yield ""
    yield from additions(bins)


def main():
    if sys.argv[1] == "--readme":
        block.replace(sys.argv[3], "divergence.py", list(text(sys.argv[2])))
    else:
        print("\n".join(text(sys.argv[1])))


main()
