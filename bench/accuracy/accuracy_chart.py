"""Draws a page of one scene from a result of accuracy.py, to be read at a width of 18 cm.

Panels: bias against time per step, total error against time, failures against time per step, and a key of the methods in the scene. Every method
has its own marker. All scenes have equal axes, except for the time per step. Values below an axis are drawn on it.

SPDX-License-Identifier: MIT
"""
import math

import chart
import picture
from chart import BLUE, GREEN, ORANGE, PINK, RED, SKY

WIDTH, HEIGHT = 680.0, 652.0  # size of the page, in the units of the panels' places
MESHES = {"mesh-analytic-area": (BLUE, "s", True), "mesh-analytic-inscribed": (SKY, "s", False), "mesh-vertex-area": (GREEN, "o", True),
          "mesh-vertex-inscribed": (GREEN, "o", False), "mesh-facet-area": (RED, "^", True), "mesh-facet-inscribed": (ORANGE, "^", False)}
METHODS = {"auto": ("black", "o", False), **MESHES, "mesh-auto": (BLUE, "v", False), "cone": (PINK, "D", True), "opencl": (PINK, "D", False),
           "plane": ("black", "x", True)}
SIZES = {"auto": 9, "mesh-auto": 6.5}
CURVES = {"plane": ("black", "-", "plane"), "cpu-cone": (PINK, "-", "cones"), "mesh": (BLUE, "-", "mesh, default tolerance"),
          "mesh-analytic-area-1e-1": (BLUE, "--", "mesh, tolerance 0.1"), "mesh-vertex-area-1e-1": (GREEN, "-", "same, vertex normals"),
          "sampled-face-50": (RED, "-", "mesh of 50 facets")}
TICS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000), (1, 3, 10, 30, 100, 300, 1000, 3000, 10000)


def panel(figure, left, top, title, xlabel, ylabel):
    axes = figure.add_axes([left / WIDTH, 1 - (top + 206) / HEIGHT, 258 / WIDTH, 206 / HEIGHT], xscale="log", yscale="log", xlabel=xlabel, ylabel=ylabel)
    axes.set_title(title)
    return axes


def column(points, number):
    return [point[number] for point in points]


def draw_biases(axes, found):
    axes.plot(column(found["front"], 0), column(found["front"], 1), drawstyle="steps-post", color="#aaaaaa", linewidth=1.6)
    axes.axhline(1e-3, color="black", linestyle="--", linewidth=0.8)
    paper = found["mesh-analytic-area"]
    axes.plot(column(paper, 0), [bound if bound > 0 else math.nan for bound in column(paper, 5)], color=BLUE, linestyle=":", linewidth=1)
    for name in (*MESHES, "cone", "plane"):
        chart.marks(axes, column(found[name], 0), column(found[name], 3), METHODS[name][0], "+", 3.5)
    for name, (colour, marker, filled) in METHODS.items():
        x, y, error = (column(found[name], k) for k in range(3))
        picture.bars(axes, x, y, error, colour, marker="none")
        chart.marks(axes, x, y, colour, marker, SIZES.get(name, 4), filled)


def draw_failures(axes, found):
    for name, (colour, marker, filled) in METHODS.items():
        chart.marks(axes, column(found[name], 0), column(found[name], 4), colour, marker, SIZES.get(name, 4), filled)
    axes.vlines(column(found["limits"], 0), [0.4 * limit for limit in column(found["limits"], 1)], column(found["limits"], 1), color="#aaaaaa", linewidth=1.2)


def draw_errors(axes, found):
    for name, (colour, line, _) in CURVES.items():
        points = found["curve." + name]
        axes.plot(column(points, 0), column(points, 1), color=colour, linestyle=line, linewidth=1.5)
    chart.marks(axes, column(found["knees"], 0), column(found["knees"], 1), "black", "o", 5)


def key(plt, found):
    """Draws the key: a line for everything in this scene."""
    radial = bool(found["curve.cpu-cone"])  # true for a scene with cones; otherwise the surface is a mesh, and the samples are coarser meshes

    def line(colour, style, text, width=1.5):
        return plt.Line2D([], [], color=colour, linestyle=style, linewidth=width, label=text)

    def mark(name, text):
        colour, marker, filled = METHODS[name]
        return plt.Line2D([], [], color=colour, linestyle="none", marker=marker, markersize=SIZES.get(name, 4), markerfacecolor=colour if filled else "none", label=text)
    texts = {name: "mesh, %s normals" % name.split("-")[1] + (", area-kept" if name.endswith("area") else ", inscribed") * radial for name in MESHES}
    texts.update({"plane": "plane (shape ignored)", "cone": "cones" if radial else "mesh of 40000 facets", "opencl": "cones, opencl",
                  "mesh-auto": "mesh, default tolerance", "auto": "auto (chosen by the program)"})
    lines = [mark(name, text) for name, text in texts.items() if found[name]]
    lines += [plt.Line2D([], [], color=chart.GREY, linestyle="none", marker="+", markersize=4, label="L2 bias of Rd(r) and Tt(r)"),
              line("#aaaaaa", "-", "Pareto front"), line("black", "--", "default tolerance", 0.8)]
    if any(point[5] > 0 for point in found["mesh-analytic-area"]):
        lines.append(line(BLUE, ":", "analytic estimate", 1))
    lines += [line(colour, style, "total error: " + text) for name, (colour, style, text) in CURVES.items() if found["curve." + name]]
    if found["knees"]:
        lines.append(plt.Line2D([], [], color="black", linestyle="none", marker="o", markersize=5, label="knee (noise equals bias)"))
    return lines


def draw(scene, found, times, path):
    """Draws the page. found: points of each series, by accuracy_table.series_of. times: ends of the axis of times."""
    plt = picture.begin()
    plt.rcParams.update({"xtick.labelsize": 10, "ytick.labelsize": 10})
    figure = plt.figure(figsize=(WIDTH / 96, HEIGHT / 96))
    figure.text(10 / WIDTH, 1 - 26 / HEIGHT, scene + ": accuracy against speed, by method", fontsize=12)
    biases = panel(figure, 68, 66, "bias (bars: 2 standard errors)", "ns per step", "largest relative bias of Rd, A, Tt")
    failures = panel(figure, 68, 376, "lost packets (tail: upper limit, 95 %)", "ns per step", "lost per 1e9 crossings")
    errors = panel(figure, 402, 66, "total error (noise and bias)", "core seconds", "relative error")
    for axes, draw_panel, first, last in ((biases, draw_biases, -8, 0), (failures, draw_failures, 0, 6), (errors, draw_errors, -5, 1)):
        draw_panel(axes, found)
        axes.set_ylim(10.0 ** first, 10.0 ** last)
        chart.powers(axes.yaxis, first, last, 2)
    for axes in (biases, failures):
        tics = [tic for tic in TICS[times[1] / times[0] > 100] if times[0] <= tic <= times[1]]
        chart.powers(axes.xaxis, 0, 0, 1)
        axes.set_xticks(tics, ["%d" % tic for tic in tics])
        axes.set_xlim(*times)
    chart.powers(errors.xaxis, -5, 3, 2)
    errors.set_xlim(1e-5, 1e3)
    figure.legend(handles=key(plt, found), loc="upper left", bbox_to_anchor=(350 / WIDTH, 1 - 318 / HEIGHT), handlelength=1.8, labelspacing=0.1, borderpad=0)
    picture.save(figure, path)
    plt.close(figure)
