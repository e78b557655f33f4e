#!/usr/bin/env python3
"""Tells the bounds on the speed of the cpu engine: limits.py SPEED.csv PARTS.txt README.md rewrites the tables there.

SPEED.csv comes from speed.py with --mcml, PARTS.txt from parts.py on the same machine. The first table gives the speed of the engine over original
MCML without one of its stages. Further tables, one per medium, give the share of the speed with a plane on top that is kept below a curved top
without one of its parts. The last table says how often a curved top is asked for a crossing.

SPDX-License-Identifier: MIT
"""
import csv
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import tables

LEFT_OUT = (("planes", "planes_ns"), ("launches and exits", "launch_exit_ns"), ("what is left", "left_ns"))
LOOPS = (("the draws", "draw"), ("the tally", "scatter"))
PARTS = (("classifying lanes", "classify"), ("intervals", "intervals"), ("march or walk", "search"),
         ("reflection", "reflect"), ("crossing", "cross"))
MEDIA = ("S2", "S6a")


def read_parts(path):
    """Returns (stages by first word, flat scenes by name, curved tops by name, rows of tops that were asked) of a parts.txt."""
    sections, current = {}, None
    with open(path, newline="") as stream:
        for line in stream:
            if line.startswith("#"):
                current = sections.setdefault(line[1:].split(":")[0].strip(), [])
            else:
                current.append(line)
    found = [list(csv.DictReader(lines)) for lines in sections.values()]

    def table_of(key):
        return next(table for table in found if table and key in table[0])

    return ({row["stage"].split()[0].strip(":"): row for row in table_of("stage")},
            {row["scene"]: row for row in table_of("scene")}, {row["top"]: row for row in table_of("top")},
            table_of("asked"))


def flat_table(stages, scenes, speed):
    titles = (["scene", "ns per photon", "MCML / ours"] + ["without " + name for name, _ in LEFT_OUT + LOOPS]
              + ["loops of full passes alone"])
    rows = []
    for name, parts in scenes.items():
        if not speed.get(name, {}).get("mcml_to_ours"):
            continue
        ns, ratio = float(parts["ns"]), float(speed[name]["mcml_to_ours"])
        lanes = float(parts["passes_ns"]) / float(stages["whole"]["ns_alone"])
        saved = [float(parts[column]) for _, column in LEFT_OUT]
        saved += [lanes * float(stages[stage]["ns_saved_when_left_out"]) for _, stage in LOOPS]
        alone = float(stages["whole"]["ns_alone"]) * float(parts["interactions"])
        rows.append([name, "%.1f" % ns] + ["%.1f" % (ratio * ns / (ns - part)) for part in [0] + saved]
                          + ["%.1f" % (ratio * ns / alone)])
    return list(tables.table(titles, rows))


def curved_table(medium, tops, speed):
    """Returns the share of the plane's steps per second that is kept: measured, and without parts of the time of a photon."""
    titles = [medium + " below", "queries per photon", "ns per photon", "of the plane's steps per second"]
    titles += ["without " + name for name, _ in PARTS] + ["without all five"]
    rows = []
    for name, parts in tops.items():
        if not name.startswith(medium + "-") or name not in speed:
            continue
        ns, share, saved = float(parts["ns"]), 1 / float(speed[name]["to_flat"]), [float(parts[key]) for _, key in PARTS]
        rows.append([name[len(medium) + 1:], parts["queries"], "%.0f" % ns]
                          + ["%.2f" % (share * ns / (ns - part)) for part in [0] + saved + [sum(saved)]])
    return list(tables.table(titles, rows))


def asked_table(rows):
    """Returns how often a boundary is asked for a crossing, and the share that is asked in vain."""
    return list(tables.table(("top", "steps per photon", "asked %", "met %", "in vain, of those asked"), [
        [row["scene"], row["steps"], "%.2f" % (100 * float(row["asked"])), "%.2f" % (100 * float(row["met"])),
         "%.0f %%" % (100 - 100 * float(row["met"]) / float(row["asked"]))] for row in rows]))


def main():
    if len(sys.argv) != 4:
        sys.exit("usage: limits.py SPEED.csv PARTS.txt README.md")
    header, table = tables.read_csv(sys.argv[1])
    stages, scenes, tops, asked = read_parts(sys.argv[2])
    speed = {row["case"]: row for row in table if row["threads"] == "1"}
    fresh = [tables.measured(header) + ".", ""]
    fresh += flat_table(stages, scenes, speed)
    for medium in MEDIA:
        fresh += [""] + curved_table(medium, tops, speed)
    fresh += [""] + asked_table(asked)
    tables.replace(sys.argv[3], "parts/limits.py", fresh)


if __name__ == "__main__":
    main()
