#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws pictures for the input pages of the manual: grids, the scene as original MCML reads it, tiles, reliefs, rough faces, phase functions and
backings.

python3 samples/manual/pictures_input.py NAME ...      draws into samples/manual/pictures; without names, all of them

Needs build/clustermcml (CLUSTERMCML names another program), numpy and matplotlib, and the modules of the Python package.
"""
import os
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
sys.path.insert(0, os.path.join(ROOT, "src", "python"))
os.environ.setdefault("CLUSTERMCML", os.path.join(ROOT, "build", "clustermcml"))

import clustermcml as mc  # noqa: E402
import numpy as np  # noqa: E402
from clustermcml import pictures  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.patches import Rectangle  # noqa: E402

INK, SOFT, MEDIUM = "#222222", "#9a9a9a", "#e9eef4"


def gsf(path):
    """Reads a Gwyddion Simple Field. Returns heights [rows, columns] and the widths of the map, all in um."""
    with open(path, "rb") as file:
        data = file.read()
    end = data.index(b"\0")
    head = dict(line.split("=", 1) for line in data[:end].decode().splitlines()[1:])
    head = {key.strip(): value.strip() for key, value in head.items()}
    nx, ny = int(head["XRes"]), int(head["YRes"])
    start = end + 4 - end % 4
    um = {"m": 1e6, "cm": 1e4, "mm": 1e3, "um": 1.0}
    heights = np.frombuffer(data, "<f4", nx * ny, start).reshape(ny, nx) * um[head["ZUnits"]]
    return heights, *(float(head[key]) * um[head["XYUnits"]] for key in ("XReal", "YReal"))


def arrow(axes, tip, foot):
    """Draws a ray of light."""
    axes.annotate("", tip, foot, arrowprops={"arrowstyle": "-|>", "color": pictures.COLOURS[1], "lw": 1.4, "shrinkA": 0, "shrinkB": 0})


def grid(figure):
    """Draws the bins of depth and radius below the surface, and those of angle above it."""
    axes = figure.subplots()
    axes.grid(False)
    axes.axis("off")
    nz, nr, na, radius = 4, 6, 6, 3.2
    axes.add_patch(Rectangle((-7.6, -5.2), 15.2, 5.2, color=MEDIUM, lw=0))
    for i in range(nz + 1):
        axes.plot([-nr, nr], [-i, -i], color=SOFT, lw=0.8, ls="-" if i else "")
    for i in range(-nr, nr + 1):
        axes.plot([i, i], [0, -nz], color=SOFT, lw=0.8, ls="--" if i == 0 else "-")
    axes.plot([-7.6, 7.6], [0, 0], color=INK, lw=1.5)
    for i in range(na + 1):
        angle = i * np.pi / 2 / na
        axes.plot([0, radius * np.sin(angle)], [0, radius * np.cos(angle)], color=SOFT, lw=0.8)
    turn = np.linspace(0, np.pi / 2, 50)
    axes.plot(radius * np.sin(turn), radius * np.cos(turn), color=SOFT, lw=0.8)
    arrow(axes, (0, 0), (0, 4.2))
    axes.text(-0.2, 3.6, "beam", ha="right", color=pictures.COLOURS[1])
    axes.text(radius * 0.75, radius * 0.8, "na bins of angle,\n0 to 90 degrees", fontsize="small")
    for ends, place, text in ((((2, -2.5), (3, -2.5)), (2.5, -2.35), "dr"), (((-3.5, -1), (-3.5, -2)), (-3.35, -1.6), "dz")):
        axes.annotate("", *ends, arrowprops={"arrowstyle": "<|-|>", "color": INK, "lw": 0.9, "shrinkA": 0, "shrinkB": 0})
        axes.text(*place, text, ha="center" if text == "dr" else "left")
    axes.text(-6, 0.15, "nr bins of radius about the z axis", fontsize="small")
    axes.text(0, -4.75, "what lies beyond the grid counts in the last bins", ha="center", fontsize="small", color="#404040")
    axes.text(-7.4, -4.3, "nz bins\nof depth", fontsize="small")
    axes.set(xlim=(-7.7, 7.7), ylim=(-5.3, 4.4), aspect="equal")


def mcml(figure):
    """Draws the scene of mcml.md as this program and as original MCML read it."""
    sides = figure.subplots(1, 2, sharey=True)
    r, heights = np.array([0, 0.1, 0.3]), np.array([0.06, 0.02, 0])
    x = np.concatenate([[-0.45], -r[::-1], r, [0.45]])
    hill = np.concatenate([[0], heights[::-1], heights, [0]])
    for axes, title, h, beams in zip(sides, ("this program", "original MCML"), (hill, 0 * hill), ((-0.2, 0, 0.2), (0,))):
        axes.grid(False)
        axes.fill_between(x, -h, 0.5, color=MEDIUM, lw=0)
        for z in (-h, 0.5 + 0 * h):
            axes.plot(x, z, color=INK)
        for at in beams:
            arrow(axes, (at, -np.interp(abs(at), x, h)), (at, -0.2))
        axes.set(xlabel="x [cm]", xlim=(-0.45, 0.45), ylim=(0.6, -0.2), title=title)
    sides[0].set_ylabel("depth z [cm]")


def tile(figure):
    """Draws heights from above: three by three periods, one of which is the file."""
    heights, wide, high = gsf(os.path.join(ROOT, "meshes", "furrows.gsf"))
    wide, high = wide / 1e4, high / 1e4
    axes = figure.subplots()
    axes.grid(False)
    extent = (-1.5 * wide, 1.5 * wide, -1.5 * high, 1.5 * high)
    shown = axes.imshow(np.tile(heights, (3, 3)), extent=extent, cmap="copper", interpolation="bilinear")
    axes.add_patch(Rectangle((-wide / 2, -high / 2), wide, high, fill=False, color="#ffffff", lw=2))
    axes.text(0, high / 2 + 0.006, "the file", color="#ffffff", ha="center", fontweight="bold")
    axes.set(xlabel="x [cm]", ylabel="y [cm]")
    figure.colorbar(shown, ax=axes, label="height [um]")


def reliefs(figure):
    """Draws heights from above, on equal scales, and a profile through each."""
    lines = ("gaussian", "exponential", "fractal:0.8")
    rows = figure.subplots(2, 3, height_ratios=(2.3, 1), sharex=True)
    with tempfile.TemporaryDirectory() as folder:
        for (above, below), spectrum in zip(rows.T, lines):
            scene = os.path.join(folder, "scene.mci")
            with open(scene, "w") as file:
                file.write(f"1.0\n1\nrelief.mco A\n100\n0.01 0.01\n9 9 1\nbeam rectangle tile\n1\n1.0\nm gaussian 0.3 0.002 tile points=128 spectrum={spectrum}\n"
                           "1.5 1 10 0.8 0.1\n1.0\n")
            mc.mesh(scene, folder)
            heights, wide, high = gsf(os.path.join(folder, "relief.mco.boundary0.gsf"))
            heights = heights - heights.mean()
            shown = above.imshow(heights, extent=(0, wide, 0, high), cmap="copper", vmin=-12, vmax=12)
            above.set_title("spectrum=" + spectrum, fontsize="small", family="monospace")
            above.grid(False)
            x = (np.arange(heights.shape[1]) + 0.5) * wide / heights.shape[1]
            below.plot(x, heights[heights.shape[0] // 2], color=pictures.COLOURS[0], lw=1)
            below.set(xlabel="x [um]", ylim=(-12, 12))
    rows[0, 0].set_ylabel("y [um]")
    rows[1, 0].set_ylabel("height [um]")
    figure.colorbar(shown, ax=rows[0], label="height [um]")


def rough(figure):
    """Draws light behind the plate of rough.md by its angle to the beam. The distance from the middle is the logarithm of the light."""
    axes = figure.add_subplot(projection="polar")
    with tempfile.TemporaryDirectory() as folder:
        scene = os.path.join(folder, "scene.mci")
        with open(scene, "w") as file:
            file.write("1.0\n1\nplate.mco A\n1e5\n0.01 0.01\n9 9 1\ndirections 36 1\n1\n1.0\n1.52 0.01 0 0 0.2\nrough ggx 0.4\n1.0\n")
        for colour, alpha in zip(pictures.COLOURS, (0.05, 0.1, 0.2, 0.4)):
            lobe = mc.run(scene, photons=4e5, set={"boundary1.alpha": alpha}).Tt_dir
            theta, value = lobe.theta.values, np.log10(np.maximum(lobe.values[:, 0], 1e-3)) + 3
            axes.plot(np.concatenate([-theta[::-1], theta]), np.concatenate([value[::-1], value]), color=colour, label=f"ggx {alpha:g}")
    axes.set_theta_zero_location("S")
    axes.set(thetamin=-90, thetamax=90, yticks=range(0, 6), yticklabels=["0.001", "0.01", "0.1", "1", "10", "100"])
    axes.tick_params(axis="y", labelsize=7)
    axes.legend(loc="lower left", bbox_to_anchor=(0.9, 0.0), title="weight per sr")


def phase(figure):
    """Draws p by the angle of deflection. The distance from the middle is the logarithm of p."""
    t = np.radians(np.linspace(-180, 180, 1441))
    c = np.cos(t)

    def hg(g):
        return (1 - g * g) / (4 * np.pi * (1 + g * g - 2 * g * c)**1.5)

    def gk(g, a):
        return a * g * (1 - g * g)**(2 * a) / (np.pi * ((1 + g)**(2 * a) - (1 - g)**(2 * a)) * (1 + g * g - 2 * g * c)**(a + 1))

    axes = figure.add_subplot(projection="polar")
    curves = (("Henyey, Greenstein: g 0.8", hg(0.8)), ("hg2 0.9 -0.4 0.923: g 0.8", 0.923 * hg(0.9) + 0.077 * hg(-0.4)),
              ("mhg 0.9 0.889: g 0.8", 0.889 * hg(0.9) + 0.111 * 3 * c * c / (4 * np.pi)), ("gk 0.6209 1.2: g 0.8", gk(0.6209, 1.2)),
              ("rayleigh: g 0", 3 * (1 + c * c) / (16 * np.pi)))
    for colour, (label, p) in zip(pictures.COLOURS, curves):
        mean = np.sum((p * c * abs(np.sin(t)))) / np.sum(p * abs(np.sin(t)))
        print(f"{label}: mean cosine {mean:.4f}")
        axes.plot(t, np.log10(p) + 3, color=colour, label=label)
    axes.set(yticks=range(0, 5), yticklabels=["0.001", "0.01", "0.1", "1", "10"], ylim=(0, 4.4))
    axes.tick_params(axis="y", labelsize=7)
    axes.legend(loc="upper left", bbox_to_anchor=(1.05, 1), title="p per sr", alignment="left")


def backing(figure):
    """Draws Rd of the paint of backings.md by its thickness, from adding-doubling."""
    axes = figure.subplots()
    thickness = np.geomspace(5e-4, 0.1, 25)
    lines = (("backing 0.8 lambertian: a white ground", "0.8 lambertian"), ("backing 0.8: a mirror", "0.8"), ("backing 0: a black ground", "0"))
    with tempfile.TemporaryDirectory() as folder:
        for colour, (label, line) in zip(pictures.COLOURS, lines):
            scene = os.path.join(folder, "scene.mci")
            with open(scene, "w") as file:
                file.write(f"1.0\n1\npaint.mco A\n1e4\n0.01 0.01\n9 9 1\n1\n1.0\n1.5 0.3 400 0.6 0.01\nbacking {line}\n1.0\n")
            totals = [mc.exact(scene, set={"layer1.d": f"{d:.6g}"})[0] for d in thickness]
            axes.plot(thickness * 1e4, [total["Rd"] for total in totals], color=colour, label=label)
    axes.set(xscale="log", xlabel="thickness of the paint [um]", ylabel="Rd", ylim=(0, 1), xlim=(5, 1000))
    axes.set_xticks([10, 100, 1000], ["10", "100", "1000"])
    axes.legend(loc="center left", bbox_to_anchor=(0.02, 0.4))


PICTURES = {"input_grid": (grid, (6.4, 4.2)), "input_mcml": (mcml, (7.2, 3.2)), "input_tile": (tile, (5.6, 4.4)), "input_reliefs": (reliefs, (8.0, 4.2)),
            "input_rough": (rough, (6.4, 4.0)), "input_phase": (phase, (8.6, 4.4)), "input_backing": (backing, (6.0, 3.6))}


def main():
    for name in sys.argv[1:] or PICTURES:
        draw, size = PICTURES[name]
        with pictures.drawing(size=size) as matplotlib:
            matplotlib.rcParams["savefig.dpi"] = 80
            figure = Figure(figsize=size, layout="constrained")
            draw(figure)
            pictures.save(figure, os.path.join(HERE, "pictures", name + (".png" if name in ("input_tile", "input_reliefs") else ".svg")))


if __name__ == "__main__":
    main()
