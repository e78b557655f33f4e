#!/usr/bin/env python3
"""What bounds the speed of the cpu engine: limits.py SPEED.csv PARTS.txt README.md rewrites the tables there.

SPEED.csv is of speed.sh with --mcml, PARTS.txt of parts.sh on the same machine. The first table says how many times as
fast as original MCML the engine would be without one of its stages; the second what a curved boundary costs before its
shape does, and how that grows with rings and triangles.
SPDX-License-Identifier: MIT
"""
import csv
import sys

import results

BEGIN, END = "<!-- written by bench/limits.py -->", "<!-- until here -->"
LEFT_OUT = (("planes", "planes_ns"), ("launches and exits", "launch_exit_ns"), ("what is left", "left_ns"))
LOOPS = (("the draws", "draw"), ("the tally", "scatter"))
CURVED = ("level-mesh", "rough-1e3", "rough-1e5", "rough-3e5", "rough-1e6", "rings-1-cone", "rings-10-cone",
          "rings-50-cone", "rings-200-cone", "rings-1000-cone")


def read_parts(path):
    """(stages by first word, flat scenes by name) of a parts.txt."""
    sections, current = {}, None
    with open(path, newline="") as stream:
        for line in stream:
            if line.startswith("#"):
                current = sections.setdefault(line[1:].split(":")[0].strip(), [])
            else:
                current.append(line)
    tables = [list(csv.DictReader(lines)) for lines in sections.values()]
    stages = next(table for table in tables if table and "stage" in table[0])
    scenes = next(table for table in tables if table and "scene" in table[0])
    return {row["stage"].split()[0].strip(":"): row for row in stages}, {row["scene"]: row for row in scenes}


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


def curved_table(speed):
    titles = ["top"] + [what for medium in ("S2", "S6a")
                        for what in ("%s: of the plane's steps per second" % medium, "queries per photon",
                                     "ns per query beyond the plane's time")]
    lines = [line(titles), "|---" * len(titles) + "|"]
    for top in CURVED:
        cells = [top]
        for medium in ("S2", "S6a"):
            row, flat = speed.get("%s-%s" % (medium, top)), speed[medium]
            if row is None:
                cells += ["-"] * 3
                continue
            steps = float(row["steps_per_photon"])
            queries, beyond = steps * float(row["query_share"]), float(row["ns_per_step"]) - float(flat["ns_per_step"])
            cells += ["%.2f" % (1 / float(row["to_flat"])), "%.2f" % queries, "%.0f" % (steps * beyond / queries)]
        lines.append(line(cells))
    return lines


def rewrite(readme, fresh):
    with open(readme) as stream:
        text = stream.read()
    if BEGIN not in text:
        sys.exit("%s: no line %s" % (readme, BEGIN))
    before, rest = text.split(BEGIN, 1)
    after = rest.split(END, 1)[1]
    with open(readme, "w") as stream:
        stream.write(before + BEGIN + "\n" + "\n".join(fresh) + "\n" + END + after)


def main():
    if len(sys.argv) != 4:
        sys.exit("usage: limits.py SPEED.csv PARTS.txt README.md")
    header, table = results.read_csv(sys.argv[1])
    stages, scenes = read_parts(sys.argv[2])
    speed = {row["case"]: row for row in table if row["threads"] == "1"}
    about = dict(header)
    fresh = ["Measured: %s; %s." % (about["program"], about["machine"]), ""]
    rewrite(sys.argv[3], fresh + flat_table(stages, scenes, speed) + [""] + curved_table(speed))


if __name__ == "__main__":
    main()
