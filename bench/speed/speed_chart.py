"""Draws two panels from a result of speed.py: time per step against the number of primitives, and the ratio to original MCML. The shape of a marker
shows the kind of surface, and open or filled markers the medium, so that no series needs its colour.

SPDX-License-Identifier: MIT
"""
import statistics

import chart
import picture
from chart import BLUE, RED

SHOWN = {"rings-mesh": ("^", "rings, as mesh"), "rough-mesh": ("s", "rough mesh"), "rings-cone": ("o", "rings, as exact cones")}
MEDIA = {"S2": (RED, False, "--"), "S6a": (BLUE, True, "-.")}


def with_range(axes, points, colour):
    """Draws upright lines from the least to the most of all rounds."""
    axes.vlines([point[0] for point in points], [point[2] for point in points], [point[3] for point in points], color=colour, linewidth=1)


def draw_times(axes, series):
    for medium, (colour, filled, dash) in MEDIA.items():
        for surface, (marker, text) in SHOWN.items():
            points = series.get("%s-%s" % (medium, surface), [])
            with_range(axes, points, colour)
            chart.marks(axes, [point[0] for point in points], [point[1] for point in points], colour, marker, 5, filled, "-").set_label("%s, %s" % (medium, text))
        axes.axhline(statistics.fmean(point[1] for point in series[medium + "-flat-plane"]), color=colour, linestyle=dash, linewidth=1.5, label=medium + ", flat")
    axes.set(xscale="log", yscale="log", title="Time per step, one thread", xlabel="number of rings (cones) or triangles (mesh) of the top boundary", ylabel="ns per step")
    chart.powers(axes.xaxis, 0, 6, 1)
    chart.powers(axes.yaxis, 1, 1, 1)
    tics = (3, 5, 10, 20, 50, 100, 200, 500)
    axes.set_yticks(tics, ["%d" % tic for tic in tics])
    axes.set(xlim=(1.5, 2e6), ylim=(3, 3000))
    axes.grid(False, axis="x")
    axes.legend(loc="upper left", ncols=2)


def draw_ratios(axes, rows):
    places = range(len(rows))
    axes.bar(places, [row[1] for row in rows], 0.6, color=BLUE, alpha=0.6)
    with_range(axes, [(place, *row[1:]) for place, row in zip(places, rows)], "black")
    axes.set_xticks(places, [row[0] for row in rows])
    axes.set(title="Speed-up over original MCML, flat scenes, one thread", xlabel="scene", ylabel="ratio of times per photon")
    axes.grid(False, axis="x")


def draw(series, target):
    plt, both = picture.begin(), "mcml" in series
    figure = plt.figure(figsize=(11 if both else 6.5, 4.6), layout="constrained")
    panels = figure.subplots(1, 1 + both, squeeze=False)[0]
    draw_times(panels[0], series)
    if both:
        draw_ratios(panels[1], series["mcml"])
    picture.save(figure, target)
