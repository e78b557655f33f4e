#!/usr/bin/env python3
"""What bounds the speed of the cpu engine: limits.py SPEED.csv PARTS.txt README.md rewrites the tables there.

SPEED.csv is of speed.sh with --mcml, PARTS.txt of parts.sh on the same machine. The first table says how many times as
fast as original MCML the engine would be without one of its stages; the others, of a medium each, how much of its speed with a plane on top it would keep below a curved
top without one of the parts that come with it.
SPDX-License-Identifier: MIT
"""
import csv
import sys

import block
import results

LEFT_OUT = (("planes", "planes_ns"), ("launches and exits", "launch_exit_ns"), ("what is left", "left_ns"))
LOOPS = (("the draws", "draw"), ("the tally", "scatter"))
PARTS = (("classifying lanes", "classify"), ("intervals", "intervals"), ("march or walk", "search"),
         ("reflection", "reflect"), ("crossing", "cross"))
MEDIA = ("S2", "S6a")


def read_parts(path):
    """(stages by first word, flat scenes by name, curved tops by name) of a parts.txt."""
    sections, current = {}, None
    with open(path, newline="") as stream:
        for line in stream:
            if line.startswith("#"):
                current = sections.setdefault(line[1:].split(":")[0].strip(), [])
            else:
                current.append(line)
    tables = [list(csv.DictReader(lines)) for lines in sections.values()]

    def table_of(key):
        return next(table for table in tables if table and key in table[0])

    return ({row["stage"].split()[0].strip(":"): row for row in table_of("stage")},
            {row["scene"]: row for row in table_of("scene")}, {row["top"]: row for row in table_of("top")})


def line(cells):
    return "| " + " | ".join(cells) + " |"


def flat_table(stages, scenes, speed):
    titles = (["scene", "ns per photon", "MCML / ours"] + ["without " + name for name, _ in LEFT_OUT + LOOPS]
              + ["loops of full passes alone"])
    lines = [line(titles), "|---" * len(titles) + "|"]
    for name, parts in scenes.items():
        if not speed.get(name, {}).get("mcml_to_ours"):
            continue
        ns, ratio = float(parts["ns"]), float(speed[name]["mcml_to_ours"])
        lanes = float(parts["passes_ns"]) / float(stages["whole"]["ns_alone"])
        saved = [float(parts[column]) for _, column in LEFT_OUT]
        saved += [lanes * float(stages[stage]["ns_saved_when_left_out"]) for _, stage in LOOPS]
        alone = float(stages["whole"]["ns_alone"]) * float(parts["interactions"])
        lines.append(line([name, "%.1f" % ns] + ["%.1f" % (ratio * ns / (ns - part)) for part in [0] + saved]
                          + ["%.1f" % (ratio * ns / alone)]))
    return lines


def curved_table(medium, tops, speed):
    """How much of the plane's steps per second are left: measured, and without parts of the time of a photon."""
    titles = [medium + " below", "queries per photon", "ns per photon", "of the plane's steps per second"]
    titles += ["without " + name for name, _ in PARTS] + ["without all five"]
    lines = [line(titles), "|---" * len(titles) + "|"]
    for name, parts in tops.items():
        if not name.startswith(medium + "-") or name not in speed:
            continue
        ns, share, saved = float(parts["ns"]), 1 / float(speed[name]["to_flat"]), [float(parts[key]) for _, key in PARTS]
        lines.append(line([name[len(medium) + 1:], parts["queries"], "%.0f" % ns]
                          + ["%.2f" % (share * ns / (ns - part)) for part in [0] + saved + [sum(saved)]]))
    return lines


def main():
    if len(sys.argv) != 4:
        sys.exit("usage: limits.py SPEED.csv PARTS.txt README.md")
    header, table = results.read_csv(sys.argv[1])
    stages, scenes, tops = read_parts(sys.argv[2])
    speed = {row["case"]: row for row in table if row["threads"] == "1"}
    about = dict(header)
    fresh = ["Measured: %s; %s." % (about["program"], about["machine"]), ""]
    fresh += flat_table(stages, scenes, speed)
    for medium in MEDIA:
        fresh += [""] + curved_table(medium, tops, speed)
    block.replace(sys.argv[3], "limits.py", fresh)


if __name__ == "__main__":
    main()
