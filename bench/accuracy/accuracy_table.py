#!/usr/bin/env python3
"""Reads, ranks and describes results of accuracy.py. As a program, accuracy_table.py CSV README.md rewrites the text there; accuracy_table.py CSV
prints the table.

SPDX-License-Identifier: MIT
"""
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import tables

REFERENCE = "reference"
TOLERANCE = 1e-3  # the program's default, which the methods auto and mesh-auto must keep


def number(row, key):
    return float(row[key]) if row[key] != "" else math.nan


def shown(row):
    """Returns the size of a bias. A bias below two standard errors is not resolved, and is replaced by this limit."""
    return max(abs(number(row, "bias")), 2 * number(row, "bias_se"))


def mark_front(rows):
    """Sets `front` on the rows that no other row of their scene beats in both time and bias. The reference does not compete."""
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


def lines(header, rows):
    """Returns the lines that are printed."""
    return ["%s: %s" % pair for pair in header] + ["", *tables.aligned([TITLES] + [cells(row) for row in rows]), "", *reading(header, rows)]


def by_group(rows, *groups):
    return [row for row in rows if row["group"] in groups]


def of(rows, scene, method):
    found = [row for row in rows if row["scene"] == scene and row["method"] == method]
    return found[0] if found else None


def resolved(row, errors=3):
    """Returns the larger of the biases of totals and profile, if it exceeds that many standard errors; else 0."""
    total, profile = abs(number(row, "bias")), number(row, "profile_bias")
    return max(total if total > errors * number(row, "bias_se") else 0.0,
               profile if profile > errors * number(row, "profile_se") else 0.0)


def worst(rows, key):
    return max(rows, key=key)


def bias_rules(rows):
    """Returns lines on how the bias of tessellations grows with their deviation: the constants of src/surface/surface_choice.c."""
    shares, plateau = [], worst([row for row in rows if row["group"].startswith("mesh-vertex") and row["tolerance"]
                                 and number(row, "tolerance") <= 1e-3], resolved)
    for group in ("mesh-analytic-area", "mesh-analytic-inscribed", "mesh-facet-area", "mesh-facet-inscribed"):
        def share(row):
            return resolved(row, 5) / number(row, "deviation")  # in hundreds of rows, some are off by three errors
        row = worst([row for row in by_group(rows, group) if number(row, "deviation") > 0], share)
        shares.append("%s %.1f (%s)" % (group[5:].replace("-", ", "), share(row), row["scene"]))
    return ["- Bias / deviation of tessellations, worst resolved case: %s. Of these follow the deviations that keep a "
            "tolerance." % "; ".join(shares),
            "- Interpolated vertex normals round off the edges between rings: a bias of up to %.1g stays (%s) however "
            "fine the mesh; they are never chosen." % (resolved(plateau), plateau["scene"])]


def automatic(rows):
    return by_group(rows, "auto", "mesh-auto")


def asked(row):
    return number(row, "tolerance") if row["tolerance"] else TOLERANCE


def is_kept(row):
    """True if the bias of a total is certainly below the asked tolerance."""
    return abs(number(row, "bias")) + 2 * number(row, "bias_se") <= asked(row)


def kept(rows):
    """Returns a line that says if the automatic choices keep their tolerance."""
    held = automatic(rows)
    broken = [row for row in held if abs(number(row, "bias")) > asked(row) + 3 * number(row, "bias_se")
              or number(row, "profile_bias") > asked(row) + 3 * number(row, "profile_se")]
    certain = sum(is_kept(row) for row in held)
    names = ", ".join("%s %s" % (row["scene"], row["method"]) for row in broken) or "none"
    return ("- `auto` and forced meshes at the asked tolerance: of %d cases %s exceed it beyond three standard errors; in %d "
            "the total's bias plus two errors is below it, in the rest the noise is not." % (len(held), names, certain))


def cost(rows):
    """Returns the ns per query beyond the steps of a plane, for (a cone without rings, each ring, a mesh), or None."""
    def query(row):
        plane = of(rows, row["scene"], "plane")
        seconds = number(row, "cpu_s") - 1e-9 * number(plane, "ns_per_step") * number(row, "steps")
        return 1e9 * seconds / number(row, "queries")
    fields = [row for row in rows if row["scene"].startswith("S2-rings-")]
    cones = sorted((int(row["primitives"]), query(row)) for row in by_group(fields, "cone"))
    meshes = [query(row) for row in by_group(fields, "mesh-auto")]
    per_ring = (cones[-1][1] - cones[0][1]) / (cones[-1][0] - cones[0][0])
    return cones[0][1] - per_ring * cones[0][0], per_ring, sum(meshes) / len(meshes)


def slower(rows, row, other):
    """Returns the ratio of another method's time per step to that of `row`, in the same scene."""
    return number(of(rows, row["scene"], other), "ns_per_step") / number(row, "ns_per_step")


def gain(rows):
    """Returns lines on how close `auto` comes to the best method of each scene, and on its choices if boundaries differ."""
    def lag(row):
        sure = [other for other in rows if other["scene"] == row["scene"] and other["group"] != REFERENCE
                and (abs(number(other, "bias")) + 2 * number(other, "bias_se") <= TOLERANCE or other is row)]
        return max(number(row, "ns_per_step") / number(other, "ns_per_step") for other in sure)
    autos = [row for row in rows if row["method"] == "auto"]
    last, stack = worst(autos, lag), of(rows, "stack", "auto")
    return ("- `auto` takes at most %.2f times (%s) the time of the fastest method whose bias plus two errors is below %g. "
            "In `stack` (fine rings, a flat field, a hill) it takes %s: %.1f times as fast as cones, %.1f times as meshes."
            % (lag(last), last["scene"], TOLERANCE, stack["kinds"].replace("|", ", "), slower(rows, stack, "cpu-cone"),
               slower(rows, stack, "mesh")))


def knees(rows):
    """Returns a line on the times at which a bias exceeds the noise. Biases from rounding are left out."""
    def seconds(group):
        return [number(row, "knee_s") for row in by_group(rows, group) if biased(row) and number(row, "knee_s") < 1e6]
    plane, mesh, cone = (seconds(group) for group in ("plane", "mesh-auto", "cone"))
    later = "none of a mesh at the default tolerance shows" if not mesh else "of a mesh at the default tolerance %.2g s" % min(mesh)
    return ("- Noise hides a bias up to the knee. Earliest knee, on one core: of a plane %.1g s, %s, %s." % (
        min(plane), later, "cones show none" if not cone else "of cones %.2g s" % min(cone)))


def packets(rows):
    meshes = [row for row in by_group(rows, "mesh-analytic-area") if row["tolerance"] == "1e-1"]
    words = []
    for key in ("Rd", "A", "Tt"):
        needs = [number(row, "packets_1e-4_" + key) for row in meshes if number(row, "packets_1e-4_" + key) > 1]  # equal surfaces need no packets
        words.append("%s %.1e to %.1e" % (key, min(needs), max(needs)))
    return ("- Paired packets that resolve a bias of 1e-4 of the light at 3 standard errors, coarsest mesh against cones: %s; "
            "finer meshes share more paths and need fewer." % ", ".join(words))


def reading(header, rows):
    """Returns the reading of the charts in ten lines of Markdown. A part of the scenes only says if tolerances were kept."""
    about = dict(header)
    if "only" in about:
        return [kept(rows)]
    cones, planes = by_group(rows, "cone"), by_group(rows, "plane")
    ratios = [slower(rows, row, "mesh") for row in cones if of(rows, row["scene"], "mesh")]
    faster = [1 / slower(rows, row, "plane") for row in cones if of(rows, row["scene"], "plane")]
    single, flat = worst(cones, resolved), [resolved(row) for row in planes if resolved(row) > 0]
    failing = worst(rows, lambda row: number(row, "failures_per_1e9"))
    return ["- %s; %s run, %s s; %.1e to %.1e packets per case." % (
                tables.measured(header, "compiler"), about["length"], about["seconds"], min(number(row, "packets") for row in rows), max(number(row, "packets") for row in rows)),
            "- Cones in single precision: worst resolved bias %.1g (%s), rounding. Ignoring the shape (plane): %.1g to %.1g where "
            "it is resolved, for %.1f to %.1f times the speed of cones." % (
                resolved(single), single["scene"], min(flat), max(flat), min(faster), max(faster)),
            *bias_rules(rows),
            "- A mesh at the default tolerance takes %.1f to %.1f times the cones' time per step; a query costs %.0f ns + %.2f ns "
            "per ring (cones), %.0f ns (mesh)." % (min(ratios), max(ratios), *cost(rows)),
            kept(rows), gain(rows), knees(rows), packets(rows),
            "- Lost packets: %d in %.2g crossings of all cases; the worst case %s %s has %.3g per 1e9." % (
                sum(int(row["lost"]) for row in rows), sum(number(row, "crossings") for row in rows), failing["scene"],
                failing["method"], number(failing, "failures_per_1e9"))]


def biased(row):
    """True if the bias of the totals is resolved."""
    return abs(number(row, "bias")) > 3 * number(row, "bias_se") and number(row, "bias_se") > 0


def curve(row):
    """Returns (seconds, error) of one method, over all of CURVE. An unresolved bias counts as none."""
    bias, variance, rate = biased(row) * number(row, "bias"), number(row, "variance"), number(row, "packets_per_s")
    points = [10 ** (i / 4) for i in range(-20, 13)] if bias else CURVE
    return [(t, math.sqrt(bias ** 2 + variance / (rate * t))) for t in points]


def knee(row):
    return number(row, "knee_s"), math.sqrt(2) * abs(number(row, "bias"))


GROUPS = ("cone", "opencl", "plane", "auto", "mesh-auto", "mesh-analytic-area", "mesh-analytic-inscribed",
          "mesh-vertex-area", "mesh-vertex-inscribed", "mesh-facet-area", "mesh-facet-inscribed")
CURVES = ("plane", "cpu-cone", "mesh", "mesh-analytic-area-1e-1", "mesh-vertex-area-1e-1", "sampled-face-50")
CURVE = (1e-5, 1e3)  # range of seconds in the chart of total errors
LEAST = 1e-8  # the lower edge of the chart of biases
MARGIN = 1.5  # factor by which the axis of times extends beyond its values


def points(rows):
    """Returns time per step, bias, its two errors, the profile's bias, failures, and the bound on paper of each row, sorted by time."""
    return sorted((number(row, "ns_per_step"), max(shown(row), LEAST), 2 * number(row, "bias_se"),
                   max(number(row, "profile_bias"), number(row, "profile_se"), LEAST),
                   max(number(row, "failures_per_1e9"), number(row, "failures_limit")),
                   float(row["optical_bound"] or "nan")) for row in rows)


def series_of(rows):
    """Returns {name: points} of one scene: its groups, front, limits, curves and knees."""
    found = {group: points(by_group(rows, group)) for group in GROUPS}
    found["front"] = points([row for row in rows if int(row["front"])])
    found["limits"] = [(number(row, "ns_per_step"), number(row, "failures_limit"))
                       for row in rows if row["group"] in GROUPS and not int(row["lost"])]
    drawn = [row for row in rows if row["method"] in CURVES]
    found.update({"curve." + name: [point for row in drawn if row["method"] == name for point in curve(row)]
                  for name in CURVES})
    found["knees"] = [knee(row) for row in drawn if biased(row) and CURVE[0] <= number(row, "knee_s") <= CURVE[1]]
    return found


def pages(rows):
    """Yields for every scene its name, its series, and the ends of the axis of times."""
    for scene in dict.fromkeys(row["scene"] for row in rows):
        mine = [row for row in rows if row["scene"] == scene]
        times = [number(row, "ns_per_step") for row in mine if row["group"] in GROUPS]
        yield scene, series_of(mine), (min(times) / MARGIN, max(times) * MARGIN)


def main(arguments):
    if len(arguments) not in (1, 2):
        sys.exit("usage: accuracy_table.py CSV [README.md]")
    header, rows = tables.read_csv(arguments[0])
    if len(arguments) == 1:
        print("\n".join(lines(header, rows)))
    else:
        tables.replace(arguments[1], "accuracy/accuracy_table.py", reading(header, rows))


if __name__ == "__main__":
    main(sys.argv[1:])
