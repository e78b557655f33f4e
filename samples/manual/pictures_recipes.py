"""Draws pictures of the recipes from stored tables: pictures_recipes.py cluster|phantom|totals PICTURE

cluster: the efficiency of many ranks that bench/speed/scaling.py has predicted.
phantom: the phase function in samples/polystyrene.txt, beside Henyey and Greenstein's of the same mean cosine.
totals: differences of the totals in recipes/samples.md from independent values, in standard errors.

SPDX-License-Identifier: MIT
"""
import math
import os
import re
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402

plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "clustermcml", "font.sans-serif": ["DejaVu Sans", "Arial"], "axes.spines.top": False,
                     "axes.spines.right": False, "axes.grid": True, "grid.color": "#e6e6e6", "legend.frameon": False})
HERE = os.path.dirname(os.path.abspath(__file__))
BLUE, ORANGE = "#0072B2", "#D55E00"


def read(*path):
    with open(os.path.join(HERE, *path), encoding="utf-8") as file:
        return file.read()


def predicted():
    """Returns {bins: [(ranks, efficiency in percent)]} from the rows below the line "ranks   bins ..."."""
    rows = read("..", "..", "bench", "speed", "results", "scaling-amd-epyc-2core.txt").partition("efficiency %\n")[2].splitlines()
    curves = {}
    for row in rows:
        ranks, bins, *_, efficiency = row.split()
        curves.setdefault(float(bins), []).append((int(ranks), float(efficiency)))
    return curves


def cluster(figure):
    axes = figure.subplots()
    for (bins, points), colour in zip(sorted(predicted().items()), (BLUE, ORANGE)):
        axes.plot(*zip(*points), "o-", color=colour, label=f"{bins:,.0f} bins")
    axes.set(xscale="log", ylim=(80, 101), xlabel="ranks", ylabel="efficiency, predicted [%]")
    axes.legend(loc="lower left")


def deviations():
    """Returns [(sample, z of Rd, z of Tt)] of the rows that have independent values."""
    rows = []
    for line in read("recipes", "samples.md").splitlines():
        cells = [cell.strip() for cell in line.split("|")]
        if len(cells) < 12 or not cells[8].partition(" ")[0].replace(".", "").isdigit():
            continue
        Rd, Tt, other_Rd, other_Tt = (tuple(map(float, re.findall(r"[\d.]+", cells[i]))) for i in (5, 7, 8, 9))
        rows.append((cells[1].strip("`"), *((a - b) / math.hypot(s, t) for (a, s), (b, t) in ((Rd, other_Rd), (Tt, other_Tt)))))
    return rows


def totals(figure):
    names, Rd, Tt = zip(*deviations())
    axes = figure.subplots()
    for values, colour, marker, label in ((Rd, BLUE, "o", "Rd"), (Tt, ORANGE, "s", "Tt")):
        axes.plot(values, range(len(names)), marker, color=colour, label=label)
    axes.axvspan(-2, 2, color="#eeeeee", zorder=0)
    axes.set(yticks=range(len(names)), yticklabels=names, xlim=(-4, 4), xlabel="difference to the independent value, in standard errors")
    axes.invert_yaxis()
    axes.legend(loc="lower right")


def phantom(figure):
    axes, g = figure.subplots(), 0.92175
    rows = [tuple(map(float, line.split())) for line in read("..", "polystyrene.txt").splitlines() if not line.startswith("#")]
    axes.plot(*zip(*rows), color=BLUE, label="spheres of 1 µm, Mie")
    other = [(1 - g**2) / (4 * math.pi * (1 + g**2 - 2 * g * math.cos(math.radians(angle))) ** 1.5) for angle, _ in rows]
    axes.plot([angle for angle, _ in rows], other, "--", color=ORANGE, label="Henyey and Greenstein, g = 0.922")
    axes.set(yscale="log", xlim=(0, 180), xticks=range(0, 181, 30), xlabel="scattering angle [degrees]", ylabel="phase function [1/sr]")
    axes.legend()


def main(kind, path):
    figure = plt.figure(figsize=(6.2, 3.6), layout="constrained")
    {"cluster": cluster, "phantom": phantom, "totals": totals}[kind](figure)
    figure.savefig(path, metadata={"Date": None, "Creator": None})


main(*sys.argv[1:])
