#!/usr/bin/env python3
"""Computes medians, ratios, CSV and tables of the bench. As a program, results.py [--irregular] CSV README.md rewrites the table there, or that of
the irregular tops.

SPDX-License-Identifier: MIT
"""
import math
import os
import statistics
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import tables

README_ROWS = ("S1", "S2", "S3", "S4", "S5", "S6a", "S6b", "S6a-rough-1e3", "S6a-rough-1e5", "S6a-rough-1e6",
               "S6a-rings-50-cone", "S6a-rings-50-mesh", "S2-rough-1e5", "A-rough-1e5")


def spread(name, values):
    """Returns median, minimum and maximum under three column names."""
    if not values:
        return {name: "", name + "_min": "", name + "_max": ""}
    return {name: statistics.median(values), name + "_min": min(values), name + "_max": max(values)}


def ratios(above, below):
    return [a / b for a, b in zip(above, below)]


def nanoseconds(case):
    return [run["ns_per_step"] for run in case.runs]


def surface_of(run):
    """Returns kind and primitives of the first boundary, the only one that may be curved here."""
    return run["boundaries"][0]["kind"], run["boundaries"][0]["primitives"]


def accuracy(case):
    """Returns the columns on Rd and lost packets. The rounds have different seeds, so that their mean is a better Rd than any of them."""
    n = len(case.runs)
    known = cases.reference(case.medium) if case.surface == "flat" else None
    row = {"Rd": sum(run["Rd"] for run in case.runs) / n,
           "Rd_se": math.sqrt(sum(run["Rd_se"] ** 2 for run in case.runs)) / n,
           "Rd_reference": "" if known is None else known, "mcml_Rd": "", "mcml_Rd_se": "",
           "lost": sum(run["lost"] for run in case.runs), "residue": max(abs(run["residue"]) for run in case.runs)}
    if case.mcml_runs:
        rd = statistics.mean(rd for _, rd in case.mcml_runs)
        # an upper bound: no weight in [0, 1] spreads wider than all or nothing
        row.update(mcml_Rd=rd, mcml_Rd_se=math.sqrt(rd * (1 - rd) / (case.mcml_photons * len(case.mcml_runs))))
    return row


def row_of(case, flat, grid, single):
    """Returns one row. flat: the plane with the same medium and threads. grid: the regular grid beside an irregular top, or None. single: this case
    on one thread."""
    runs = case.runs
    kind, primitives = surface_of(runs[0])
    row = {"case": case.name, "medium": case.medium, "surface": case.surface, "kind": kind,
           "primitives": primitives, "threads": case.threads, "photons": case.photons}
    row.update(spread("ns_per_step", nanoseconds(case)))
    row["photons_per_s"] = statistics.median(run["photons_per_s"] for run in runs)
    row.update(spread("to_flat", ratios(nanoseconds(case), nanoseconds(flat)) if flat is not case else []))
    row.update(spread("to_grid", ratios(nanoseconds(case), nanoseconds(grid)) if grid else []))
    per_photon = [1 / run["photons_per_s"] for run in runs]
    row.update(spread("mcml_to_ours", ratios([seconds for seconds, _ in case.mcml_runs], per_photon)))
    row.update(spread("one_to_threads", ratios(nanoseconds(single), nanoseconds(case)) if single is not case else []))
    row["steps_per_photon"] = sum(run["steps"] for run in runs) / sum(run["photons"] for run in runs)
    row["query_share"] = sum(run["queries"] for run in runs) / sum(run["steps"] for run in runs)
    row["build_s"] = statistics.median(sum(b["build_s"] for b in run["boundaries"]) for run in runs)
    row["MiB"] = sum(b["MiB"] for b in runs[0]["boundaries"])
    row["process_MiB"] = statistics.median(run["rss"] for run in runs)
    row.update(accuracy(case))
    return row


def rows(done):
    by_name = {(case.name, case.threads): case for case in done}
    return [row_of(case, by_name.get((case.medium, case.threads), by_name[case.medium, 1]),
                   by_name.get((case.grid, case.threads)), by_name[case.name, 1]) for case in done]


def ranged(row, name, digits):
    if row[name] == "":
        return "-"
    return "%.*f (%.*f-%.*f)" % (digits, float(row[name]), digits, float(row[name + "_min"]),
                                 digits, float(row[name + "_max"]))


def cells(row):
    """Returns the cells of a table for people."""
    exact = " (%.5f)" % float(row["Rd_reference"]) if row["Rd_reference"] != "" else ""
    return [row["case"], row["kind"], str(row["primitives"]), str(row["threads"]), ranged(row, "ns_per_step", 1),
            ranged(row, "to_flat", 2), ranged(row, "mcml_to_ours", 1), "%.1f" % (100 * float(row["query_share"])),
            "-" if row["kind"] == "plane" else "%.2g" % float(row["build_s"]),
            "-" if row["kind"] == "plane" else "%.3g" % float(row["MiB"]),
            "%.5f ± %.5f%s" % (float(row["Rd"]), float(row["Rd_se"]), exact), str(row["lost"])]


TITLES = ["case", "boundary", "primitives", "threads", "ns/step", "x flat", "MCML / ours", "queries %", "build s",
          "MiB", "Rd (exact)", "lost"]
GRID_TITLES = ["irregular top", "threads", "ns/step", "x flat", "x regular grid", "queries %", "of the grid", "build s",
               "MiB", "lost"]


def irregular(table):
    """Returns the cells of a table of irregular tops beside regular grids of as many triangles. Older results have none."""
    by_name = {(row["case"], row["threads"]): row for row in table}
    found = []
    for row in table:
        if row.get("to_grid", "") == "":
            continue
        medium, _, number = row["case"].split("-")[:3]
        grid = by_name["%s-rough-%s" % (medium, number), row["threads"]]
        found.append([row["case"], str(row["threads"]), ranged(row, "ns_per_step", 1), ranged(row, "to_flat", 2),
                      ranged(row, "to_grid", 2), *("%.1f" % (100 * float(one["query_share"])) for one in (row, grid)),
                      "%.2g" % float(row["build_s"]), "%.3g" % float(row["MiB"]), str(row["lost"])])
    return found


def lines(header, table):
    """Returns the lines that are printed."""
    return ["%s: %s" % pair for pair in header] + ["", *tables.aligned([TITLES] + [cells(row) for row in table]), "", *tables.aligned(
        [GRID_TITLES] + irregular(table)), ""] + ["%s: %s threads %s times one thread" % (
            row["case"], row["threads"], ranged(row, "one_to_threads", 2)) for row in table if row["one_to_threads"] != ""]


def series(table):
    """Returns the data of speed_chart.py: (primitives, ns per step, least, most) per medium, surface and kind on one thread, and under "mcml"
    (case, ratio to original MCML, least, most)."""
    found = {}
    for row in table:
        if row["threads"] == "1":
            points = found.setdefault("-".join((row["medium"], row["surface"], row["kind"])), [])
            points.append([float(row[name]) for name in ("primitives", "ns_per_step", "ns_per_step_min", "ns_per_step_max")])
        if row["mcml_to_ours"] != "":
            found.setdefault("mcml", []).append([row["case"], *(float(row["mcml_to_ours" + end]) for end in ("", "_min", "_max"))])
    return found


def readme_lines(header, table):
    """Yields a line on the measurement, and a table of the chosen rows without the column of threads."""
    about, drop = dict(header), TITLES.index("threads")
    gains = ["%s %s" % (row["case"], ranged(row, "one_to_threads", 2)) for row in table if row["one_to_threads"] != ""]
    yield tables.measured(header, "compiler") + "; median (least-most) of %s rounds. Two threads over one: %s." % (
        about["rounds"], ", ".join(gains))
    yield ""
    chosen = [cells(row) for row in table if row["case"] in README_ROWS and row["threads"] == "1"]
    titles, *lines = [line[:drop] + line[drop + 1:] for line in [TITLES] + chosen]
    yield from tables.table(titles, lines)


def irregular_lines(header, table):
    """Yields a line on the measurement, and the table of tops beside regular grids."""
    yield tables.measured(header) + "; median (least-most) of %s rounds." % dict(header)["rounds"]
    yield ""
    yield from tables.table(GRID_TITLES, irregular(table))


if __name__ == "__main__":
    *flags, csv_path, readme = sys.argv[1:] if len(sys.argv) > 2 else [None] * 4
    if flags == []:
        tables.replace(readme, "speed/results.py", readme_lines(*tables.read_csv(csv_path)))
    elif flags == ["--irregular"]:
        tables.replace(readme, "speed/results.py --irregular", irregular_lines(*tables.read_csv(csv_path)))
    else:
        sys.exit("usage: results.py [--irregular] CSV README.md")
