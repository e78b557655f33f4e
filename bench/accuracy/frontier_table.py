#!/usr/bin/env python3
"""Describes results of frontier.py. As a program, frontier_table.py CSV README.md rewrites the text there; frontier_table.py CSV prints the table.

SPDX-License-Identifier: MIT
"""
import math
import os
import statistics
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import frontier_scenes
import tables

MANY = ("hihill", "hicrater", "lonoise")
GAINS = ("Rd", "A", "Tt", "totals", "profiles")
FLOOR = 2e-7  # lower edge of the chart; smaller biases are drawn on it


def number(row, key):
    return float(row[key]) if row[key] != "" else math.nan


def pick(rows, **keys):
    return [row for row in rows if all(row[key] == value for key, value in keys.items())]


def usual(rows):
    """Returns the rows `after` of the method that the program takes by itself: auto, or the plane of a flat scene."""
    return [row for row in pick(rows, variant="after")
            if row["method"] == "auto" or not pick(rows, scene=row["scene"], method="auto")]


def hidden(row):
    """True if two standard errors hide the bias."""
    return abs(number(row, "bias")) < 2 * number(row, "bias_se")


def shown(row):
    return max(abs(number(row, "bias")), 2 * number(row, "bias_se"))


def ranged(row, name):
    return "%.3g (%.3g-%.3g)" % tuple(number(row, "gain_%s%s" % (name, end)) for end in ("", "_min", "_max"))


TITLES = ["scene", "boundary", "s to 0.1 %: Rd", "A", "Tt", "before / after: Rd", "A", "Tt", "Rd, A, Tt", "profiles",
          "MCML / after: Rd", "A", "Tt"]


def cells(row):
    return ([row["scene"], row["method"]] + ["%.2g" % number(row, "s_" + total) for total in ("Rd", "A", "Tt")]
            + [ranged(row, name) for name in GAINS]
            + ["%.3g" % number(row, "mcml_" + total) if row["mcml_" + total] != "" else "-" for total in ("Rd", "A", "Tt")])


def mcml_row(rows, row):
    """Returns the row of the plane, on which original MCML was timed, in place of a row with a shape."""
    return row if row["method"] == "plane" else (pick(rows, scene=row["scene"], method="plane", variant="after") or [row])[0]


def table(rows):
    lines = []
    for row in usual(rows):
        lines.append(cells(row))
        flat = mcml_row(rows, row)
        if flat is not row and flat["mcml_Rd"] != "":
            lines.append(cells(flat))
    return lines


def mean(values):
    return math.exp(statistics.fmean(map(math.log, values)))


def span(values):
    return "%.2g to %.2g" % (min(values), max(values))


def gains_reading(rows):
    chosen = usual(rows)
    many = [row for row in chosen if row["scene"] in MANY]
    totals = [number(row, "gain_totals") for row in chosen]
    least = min(((number(row, "gain_" + name), row["scene"], name) for row in chosen for name in GAINS))
    profiles = {len(some): span([number(row, "gain_profiles") for row in some]) for some in (many, chosen)}
    yield ("Thin scenes (%s): %s times as fast as before to the same error of Rd, A, Tt (geometric mean of the three), %s times "
           "to that of profile bins." % (", ".join(row["scene"] for row in many),
                                         span([number(row, "gain_totals") for row in many]), profiles[len(many)]))
    yield ("All scenes: %s times as fast to the same error of Rd, A, Tt, %.2g in their geometric mean, %s to that of profile "
           "bins; the least of all columns is %.2g (%s of %s)." % (span(totals), mean(totals), profiles[len(chosen)],
                                                                   least[0], least[2], least[1]))


def mcml_reading(rows):
    timed = [row for row in pick(rows, variant="after", method="plane") if row["mcml_Rd"] != ""]
    if not timed:
        yield "Original MCML was not timed (`--mcml PATH`)."
        return
    ratios = ["/".join("%.3g" % number(row, "mcml_" + total) for total in ("Rd", "A", "Tt")) for row in timed]
    each = ["%s %s" % (row["scene"], ratio) for row, ratio in zip(timed, ratios)]
    yield "Original MCML takes so many times as long to the same error of Rd/A/Tt, on planes: %s." % ", ".join(each)


def bias_reading(rows):
    after = pick(rows, variant="after")
    planes = [row for row in after if row["method"] == "plane" and row["truth"] == "reference"]
    others = [row for row in after if row["method"] != "plane"]
    flat = [row for row in after if row["truth"] == "adding-doubling"]
    far = max(others, key=shown)
    scans = [row for row in planes if row["scene"].endswith("-rough")]
    radial = [row for row in planes if row not in scans]
    yield ("A plane for a radial shape is %s off in the worst total. For a scan, at the one point that the pencil meets, it is %s off. No other "
           "method is off by more than %.1e, what noise leaves open included (%s of %s)." % (
               span([shown(row) for row in radial]), span([shown(row) for row in scans]), shown(far), far["method"], far["scene"]))
    both = flat + pick(rows, variant="before", truth="adding-doubling")
    z = [abs(number(row, "bias")) / number(row, "bias_se") for row in both]
    yield ("Flat scenes against adding-doubling: the total with the largest difference is at most %.1f standard errors off (%d "
           "comparisons); what noise leaves open is %s after." % (max(z), len(z), span([shown(row) for row in flat])))
    z = [abs(number(row, "z_before")) for row in after]
    yield ("After against before: the total that differs most does so by at most %.1f standard errors (%d comparisons of three "
           "totals)." % (max(z), len(z)))


def kinds_reading(rows):
    for scene in MANY:
        of = {row["method"]: row for row in pick(rows, variant="after", scene=scene)}
        yield "%s, s to 0.1 %% (0.01 %%) of the slowest total: %s." % (scene, ", ".join(
            "%s %.2g (%.2g)" % (name, number(row, "s_worst"), number(row, "s_worst_small")) for name, row in of.items()))
    small = [number(row, "s_worst_small") / number(row, "s_worst") for row in usual(rows)]
    yield "A tenth of the error takes 100 times as long before, %s times after." % span(small)


def reading(rows):
    """Returns lines that compare scenes, or none if only some scenes were run."""
    if len({row["scene"] for row in rows}) < len(frontier_scenes.NAMES):
        return []
    return (list(gains_reading(rows)) + list(mcml_reading(rows)) + list(bias_reading(rows)) + list(kinds_reading(rows)))


def lines(header, rows):
    """Returns the lines that are printed."""
    return ["%s: %s" % pair for pair in header] + ["", *tables.aligned([TITLES] + table(rows)), "", *reading(rows)]


def readme_lines(header, rows):
    about = dict(header)
    yield tables.measured(header) + "; median (least-most) of %s rounds, %s cores busy." % (about["rounds"], about.get("cores busy", "?"))
    yield ""
    yield from tables.table(TITLES, table(rows))
    yield ""
    for line in reading(rows):
        yield "- " + line


def place_of(rows, scene, variant, method):
    """Returns (seconds to 0.1 %, seconds to 0.01 %, bias, True if the bias is a limit), or None without such a row. Sampling leaves no bias, so
    that the method's bias comes from the longer runs."""
    found = pick(rows, scene=scene, variant=variant, method=method)
    if not found:
        return None
    row, longer = found[0], pick(rows, scene=scene, variant="after", method=method)[0]
    return number(row, "s_worst"), number(row, "s_worst_small"), max(shown(longer), FLOOR), hidden(longer)


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit("usage: frontier_table.py CSV [README.md]")
    header, rows = tables.read_csv(sys.argv[1])
    if len(sys.argv) == 2:
        print("\n".join(lines(header, rows)))
    else:
        tables.replace(sys.argv[2], "accuracy/frontier_table.py", readme_lines(header, rows))


if __name__ == "__main__":
    main()
