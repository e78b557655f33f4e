#!/usr/bin/env python3
"""Reads, ranks and tells what accuracy.py measured. As a program: accuracy_table.py CSV README.md rewrites the reading
there; accuracy_table.py CSV prints the table; accuracy_table.py CSV --series DIRECTORY writes what accuracy.gp draws.

SPDX-License-Identifier: MIT
"""
import math
import os
import sys

import results

REFERENCE = "reference"
TOLERANCE = 1e-3  # the program's default, which the methods auto and mesh-auto are held to


def number(row, key):
    return float(row[key]) if row[key] != "" else math.nan


def shown(row):
    """A bias below two standard errors is not resolved; the limit stands in its place."""
    return max(abs(number(row, "bias")), 2 * number(row, "bias_se"))


def mark_front(rows):
    """Sets `front` on the rows that no other row of their scene beats in both time and bias; the reference is no rival."""
    for row in rows:
        rivals = [other for other in rows if other["scene"] == row["scene"] and other["group"] != REFERENCE]
        beaten = any(number(other, "ns_per_step") <= number(row, "ns_per_step") and shown(other) <= shown(row)
                     and other is not row for other in rivals)
        row["front"] = int(row["group"] != REFERENCE and not beaten)


TITLES = ["scene", "method", "kinds", "primitives", "ns/step", "worst bias", "profile", "paper", "s to 1 %", "knee s",
          "failures/1e9", "front"]


def cells(row):
    bound = "-" if row["optical_bound"] == "" else "%.1g" % number(row, "optical_bound")
    failures = "%.3g" % number(row, "failures_per_1e9") if int(row["lost"]) else "<%.3g" % number(row, "failures_limit")
    return [row["scene"], row["method"], row["kinds"], str(row["primitives"]), "%.1f" % number(row, "ns_per_step"),
            "%+.1e +- %.1e %s" % (number(row, "bias"), number(row, "bias_se"), row["worst"]),
            "%.1e (%.1e)" % (number(row, "profile_bias"), number(row, "profile_se")), bound,
            "%.2g" % number(row, "s_to_1pc"), "%.2g" % number(row, "knee_s"), failures, "*" if int(row["front"]) else ""]


def text(header, rows):
    grid = [TITLES] + [cells(row) for row in rows]
    widths = [max(len(line[i]) for line in grid) for i in range(len(TITLES))]
    lines = ["%s: %s" % pair for pair in header] + [""]
    lines += ["  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip() for line in grid]
    return "\n".join(lines + [""] + reading(header, rows)) + "\n"


def reading(header, rows):
    return []


def main(arguments):
    if len(arguments) == 1:
        sys.stdout.write(text(*results.read_csv(arguments[0])))


if __name__ == "__main__":
    main(sys.argv[1:])
