"""Draws the efficiency of many ranks that bench/speed/scaling.py has predicted: pictures_cluster.py PICTURE

SPDX-License-Identifier: MIT
"""
import os
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402

plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "clustermcml", "font.sans-serif": ["DejaVu Sans", "Arial"], "axes.spines.top": False,
                     "axes.spines.right": False, "axes.grid": True, "grid.color": "#e6e6e6", "legend.frameon": False})
TABLE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "bench", "speed", "results", "scaling-amd-epyc-2core.txt")


def predicted():
    """{bins: [(ranks, efficiency in percent)]}, the rows below the line "ranks   bins ..."."""
    with open(TABLE, encoding="utf-8") as file:
        rows = file.read().partition("efficiency %\n")[2].splitlines()
    curves = {}
    for row in rows:
        ranks, bins, *_, efficiency = row.split()
        curves.setdefault(float(bins), []).append((int(ranks), float(efficiency)))
    return curves


def main(path):
    figure, axes = plt.subplots(figsize=(5.2, 3.2), layout="constrained")
    for (bins, points), colour in zip(sorted(predicted().items()), ("#0072B2", "#D55E00")):
        axes.plot(*zip(*points), "o-", color=colour, label=f"{bins:,.0f} bins")
    axes.set(xscale="log", ylim=(80, 101), xlabel="ranks", ylabel="efficiency, predicted [%]")
    axes.legend(loc="lower left")
    figure.savefig(path, metadata={"Date": None, "Creator": None})


main(sys.argv[1])
