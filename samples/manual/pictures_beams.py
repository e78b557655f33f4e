#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Pictures of beams, detectors and scored arrays for the manual, into samples/manual/pictures.

python3 samples/manual/pictures_beams.py                                 draws all that need no run
python3 samples/manual/pictures_beams.py detector scores                 draws these
python3 samples/manual/pictures_beams.py saved_packets exits.photons.h5  draws the packets of a file"""
import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.patches import Arc, Circle, Polygon, Rectangle, Wedge  # noqa: E402

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "pictures")
LIGHT, INK, SOFT = "#d55e00", "#222222", "#9a9a9a"
MEDIUM = "#e9eef4"
matplotlib.rcParams.update({"svg.hashsalt": "clustermcml", "font.size": 9, "svg.fonttype": "path"})


def save(figure, name):
    figure.savefig(os.path.join(FOLDER, name), metadata={"Date": None}, bbox_inches="tight")
    plt.close(figure)


def arrow(axes, tail, head, colour=LIGHT, width=1.4):
    axes.annotate("", head, tail, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0})


def frame(axes, title, x, y):
    axes.set(xlim=x, ylim=y, aspect="equal")
    axes.set_title(title, fontsize=9, family="monospace")
    axes.axis("off")


def shapes():
    """Draws the irradiance of each shape on the plane across the axis. Darker means more light."""
    side = np.linspace(-1.2, 1.2, 241)
    x, y = np.meshgrid(side, side)
    r = np.hypot(x, y)
    stripes = np.where((abs(x) < 1) & (abs(y) < 1), 0.5 + 0.5 * np.sign(np.sin(9 * x + 6 * y)), 0)
    panels = [("pencil", r < 0.06, []), ("disk R", r < 0.8, [((0, 0), (0.8, 0), "R")]),
              ("gaussian R", np.exp(-2 * (r / 0.8)**2), [((0, 0), (0.8, 0), "R")]),
              ("ring R1 R2", (r > 0.45) & (r < 0.9), [((0, 0), (0, 0.45), "R1"), ((0, 0), (0.9, 0), "R2")]),
              ("rectangle W H", (abs(x) < 1) & (abs(y) < 0.5), [((-1, -0.7), (1, -0.7), "W"), ((1.12, -0.5), (1.12, 0.5), "H")]),
              ("image \"pattern.gsf\"", stripes, [])]
    figure, rows = plt.subplots(1, len(panels), figsize=(11, 2.1))
    for axes, (title, light, lengths) in zip(rows, panels):
        axes.imshow(light, extent=(-1.2, 1.2, -1.2, 1.2), cmap="Oranges", vmin=0, vmax=1.3, origin="lower")
        for tail, head, text in lengths:
            axes.annotate("", head, tail, arrowprops={"arrowstyle": "<|-|>", "color": INK, "lw": 0.9, "shrinkA": 0, "shrinkB": 0})
            upright = abs(head[1] - tail[1]) > abs(head[0] - tail[0])
            axes.text((tail[0] + head[0]) / 2 + (0.06 if upright else 0), (tail[1] + head[1]) / 2 + (0 if upright else 0.06), text)
        frame(axes, title, (-1.25, 1.45), (-1.25, 1.25))
        axes.plot(0, 0, "+", color=INK, ms=5)
    save(figure, "beam_shapes.svg")


def lights():
    """Draws the intensity per solid angle of each kind of light about the axis, which points down."""
    def rays(kind):
        angles = np.radians(np.arange(-180, 181, 15))
        if kind == "parallel":
            return [(0, 1.0)]
        if kind == "na:N":
            return [(t, 1.0) for t in np.radians(np.linspace(-24, 24, 5))]
        if kind == "lambertian":
            return [(t, np.cos(t)) for t in angles if abs(t) < 1.5]
        if kind == "isotropic":
            return [(t, 0.8) for t in angles[:-1:2]]
        return [(t, 0.5 + 0.5 * np.sin(2.2 * abs(t))**2) for t in angles if abs(t) < 1.2]
    kinds = ["parallel", "na:N", "lambertian", "isotropic", "\"angles.txt\""]
    figure, row = plt.subplots(1, len(kinds), figsize=(11, 2.3))
    for axes, kind in zip(row, kinds):
        starts = np.linspace(-0.5, 0.5, 5) if kind == "parallel" else [0]
        axes.plot([-0.6, 0.6], [0, 0], color=INK, lw=2)
        for start in starts:
            for t, length in rays(kind):
                arrow(axes, (start, 0), (start + length * np.sin(t), -length * np.cos(t)))
        if kind == "na:N":
            axes.plot([0, 0], [0, -1.15], color=SOFT, lw=0.8, ls="--")
            axes.add_patch(Arc((0, 0), 1.1, 1.1, theta1=270, theta2=294, color=INK, lw=0.9))
            axes.text(0.16, -0.42, "t", fontsize=9)
        frame(axes, "light=" + kind, (-1.15, 1.15), (-1.2, 0.95))
    save(figure, "beam_light.svg")


def axes_of_beam():
    """Draws the angle, the azimuth, and the place of a beam's shape, with and without z=."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3), gridspec_kw={"width_ratios": [1.6, 1]})
    left.add_patch(Rectangle((-2, -1.2), 4.6, 1.2, color=MEDIUM, lw=0))
    left.plot([-2, 2.6], [0, 0], color=INK, lw=1.5)
    lean = np.radians(35)
    way = np.array([np.sin(lean), -np.cos(lean)])
    across = np.array([np.cos(lean), np.sin(lean)])
    for s in (-0.3, 0, 0.3):
        start = s * across - 1.2 * way
        arrow(left, start, s * across - (s * across)[1] / way[1] * way)
    left.plot(*zip(-0.42 * across, 0.42 * across), color=LIGHT, lw=1.2, ls=":")
    left.plot([0, 0], [0, 1.05], color=SOFT, lw=0.8, ls="--")
    left.add_patch(Arc((0, 0), 1.6, 1.6, theta1=90, theta2=125, color=INK, lw=0.9))
    left.text(-0.1, 0.86, "angle", ha="right")
    left.plot(0, 0, "o", color=INK, ms=3)
    left.text(0.05, -0.2, "at=X,Y")
    left.text(0.42, 0.32, "the shape lies here, were\nnothing in the way", fontsize=8, color=LIGHT)
    left.plot([1.3, 1.9], [-0.6, -0.6], color=LIGHT, lw=3)
    for t in np.radians([0, 60, 120, 180, 240, 300]):
        arrow(left, (1.6, -0.6), (1.6 + 0.4 * np.sin(t), -0.6 - 0.4 * np.cos(t)), width=1)
    left.plot([2.25, 2.25], [0, -0.6], color=INK, lw=0.8)
    left.text(2.3, -0.35, "z=Z")
    arrow(left, (-1.8, 0.9), (-1.3, 0.9), INK, 0.9)
    arrow(left, (-1.8, 0.9), (-1.8, 0.4), INK, 0.9)
    left.text(-1.27, 0.85, "x")
    left.text(-1.85, 0.22, "z")
    frame(left, "seen along y", (-2, 2.7), (-1.2, 1.15))
    turn = np.radians(50)
    arrow(right, (0, 0), (1.0, 0), INK, 0.9)
    arrow(right, (0, 0), (0, 1.0), INK, 0.9)
    right.text(1.03, -0.05, "x")
    right.text(-0.03, 1.05, "y")
    arrow(right, (-0.6 * np.cos(turn), -0.6 * np.sin(turn)), (0.95 * np.cos(turn), 0.95 * np.sin(turn)))
    right.add_patch(Arc((0, 0), 0.9, 0.9, theta1=0, theta2=50, color=INK, lw=0.9))
    right.text(0.45, 0.22, "azimuth")
    frame(right, "seen from above, y away", (-0.7, 1.2), (-0.6, 1.15))
    save(figure, "beam_axis.svg")


def detector():
    """Draws the plane, the shape, and the cone of a detector, with light that it sees and light that it does not see."""
    figure, axes = plt.subplots(figsize=(8, 3.3))
    axes.add_patch(Rectangle((-2.6, -1.1), 6, 1.1, color=MEDIUM, lw=0))
    hill = np.linspace(-2.6, 3.4, 200)
    height = 0.35 * np.exp(-(hill / 0.9)**2)
    axes.fill_between(hill, 0, height, color=MEDIUM, lw=0)
    axes.plot(hill, height, color=INK, lw=1.5)
    plane = 0.35
    axes.plot([-2.6, 3.4], [plane, plane], color=SOFT, lw=0.8, ls="--")
    axes.text(3.45, plane - 0.04, "plane z")
    axes.plot([-0.5, 0.5], [plane, plane], color="#0072b2", lw=4)
    lean, half = np.radians(30), np.radians(16)
    axes.add_patch(Wedge((0, plane), 1.5, 90 - 30 - 16, 90 - 30 + 16, color="#0072b2", alpha=0.18, lw=0))
    tip = np.array([np.sin(lean), np.cos(lean)])
    axes.plot([0, 1.75 * tip[0]], [plane, plane + 1.75 * tip[1]], color="#0072b2", lw=1, ls="-.")
    axes.plot([0, 0], [plane, plane + 1.6], color=SOFT, lw=0.8, ls="--")
    axes.add_patch(Arc((0, plane), 1.9, 1.9, theta1=60, theta2=90, color=INK, lw=0.9))
    axes.text(0.12, plane + 1.02, "angle")
    axes.add_patch(Arc((0, plane), 2.6, 2.6, theta1=44, theta2=60, color=INK, lw=0.9))
    axes.text(0.9, plane + 1.12, "t", ha="left")
    axes.text(1.3, plane + 1.5, "sin t = NA / n", fontsize=9)
    axes.text(-0.62, plane + 0.08, "SHAPE", ha="right", color="#0072b2")

    def leaves(foot, degrees, text, seen):
        way = np.array([np.sin(np.radians(degrees)), np.cos(np.radians(degrees))])
        foot = np.array([foot, 0.35 * np.exp(-(foot / 0.9)**2)])
        arrow(axes, foot, foot + 1.2 * way, LIGHT if seen else SOFT)
        back = foot + (plane - foot[1]) / way[1] * way
        axes.plot(*zip(foot, back), color=LIGHT if seen else SOFT, lw=1, ls=":")
        axes.plot(*back, "o", color=LIGHT if seen else SOFT, ms=3)
        axes.text(*(foot + 1.24 * way), text, fontsize=8, color=LIGHT if seen else SOFT, ha="center", va="bottom")
    leaves(0.25, 38, "seen", True)
    leaves(-0.3, -20, "outside of the cone", False)
    leaves(-1.6, 35, "beside the shape", False)
    frame(axes, "", (-2.6, 4.1), (-0.6, 2.1))
    save(figure, "detector.svg")


def scores():
    """Draws the arrays that each line of a scene makes the program fill."""
    figure, (rings, pixels, gates, sky) = plt.subplots(1, 4, figsize=(11.5, 2.6))
    for r in (0.25, 0.5, 0.75, 1.0):
        rings.add_patch(Circle((0, 0), r, fill=False, color=INK, lw=0.9))
    rings.add_patch(Wedge((0, 0), 0.75, 0, 360, width=0.25, color=LIGHT, alpha=0.5, lw=0))
    frame(rings, "dr nr: rings", (-1.1, 1.1), (-1.1, 1.1))
    for k in range(7):
        at = -1 + k / 3
        pixels.plot([at, at], [-1, 1], color=INK, lw=0.7)
        pixels.plot([-1, 1], [at, at], color=INK, lw=0.7)
    pixels.add_patch(Rectangle((1 / 3, 0), 1 / 3, 1 / 3, color=LIGHT, alpha=0.5, lw=0))
    frame(pixels, "map: pixels", (-1.1, 1.1), (-1.1, 1.1))
    t = np.linspace(0, 1, 9)
    height = np.append((t[:-1] / 0.15 * np.exp(-t[:-1] / 0.25)) / 0.7, 0)
    gates.stairs(height[:-1], t, fill=True, color=LIGHT, alpha=0.5)
    gates.stairs(height[:-1], t, color=INK, lw=0.8)
    gates.add_patch(Rectangle((1.0, 0), 0.35, 0.16, facecolor="white", edgecolor=INK, lw=0.8, hatch="///"))
    gates.text(1.0, 0.2, "later", fontsize=8)
    gates.text(0.96, -0.14, "T1", fontsize=9)
    gates.text(0.0, -0.14, "0", fontsize=9)
    gates.set(xlim=(-0.05, 1.5), ylim=(-0.2, 1.2))
    gates.set_title("time: gates", fontsize=9, family="monospace")
    gates.axis("off")
    for k in (1, 2, 3):
        sky.add_patch(Circle((0, 0), k / 3, fill=False, color=INK, lw=0.9))
    for a in np.radians(np.arange(0, 360, 45)):
        sky.plot([0, np.cos(a)], [0, np.sin(a)], color=INK, lw=0.7)
    sky.add_patch(Wedge((0, 0), 2 / 3, 45, 90, width=1 / 3, color=LIGHT, alpha=0.5, lw=0))
    frame(sky, "directions: of the sky", (-1.1, 1.1), (-1.1, 1.1))
    save(figure, "scores.svg")


def saved_packets(file):
    """Draws depth against distance of the packets in a .photons.h5 that left through the top."""
    sys.path.insert(0, os.path.join(FOLDER, "..", "..", "..", "src", "python"))
    import clustermcml as mc  # noqa: E402, PLC0415
    rows = mc.read_photons(file)
    rows = rows[rows.side == 0]
    figure, axes = plt.subplots(figsize=(6, 3))
    light = axes.hist2d(np.hypot(rows.x, rows.y), rows.deepest, bins=[50, 50], range=[[0, 1], [0, 1]], weights=rows.weight,
                        cmap="viridis", norm=matplotlib.colors.LogNorm(), rasterized=True)[3]
    middle = np.linspace(0.025, 0.975, 20)
    mean = [np.average(part.deepest, weights=part.weight) for part in
            (rows[abs(np.hypot(rows.x, rows.y) - r) < 0.025] for r in middle)]
    axes.plot(middle, mean, color="white", lw=1.5)
    axes.text(0.7, 0.5, "mean", color="white")
    axes.set(xlabel="where it leaves, r [cm]", ylabel="how deep it was [cm]", ylim=(1, 0))
    figure.colorbar(light, label="weight of the packets")
    save(figure, "saved_packets.svg")


ALL = {"beam_shapes": shapes, "beam_light": lights, "beam_axis": axes_of_beam, "detector": detector, "scores": scores}
if sys.argv[1:2] == ["saved_packets"]:
    saved_packets(sys.argv[2])
else:
    for drawing in sys.argv[1:] or ALL:
        ALL[drawing]()
