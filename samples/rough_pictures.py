#!/usr/bin/env python3
"""Draws pictures of the samples with rough faces: rough_pictures.py [DIR] [PHOTONS]

Simulates ground_glass.mci, paint_gloss.mci and frosted_bead.mci, by default with 1e6 photons a curve, and leaves a picture of each in DIR, by
default the current directory. Bands are one standard error. Needs the Python package (or PYTHONPATH=src/python and CLUSTERMCML=build/clustermcml in
a checkout) and matplotlib.

SPDX-License-Identifier: MIT
"""
import os
import sys

import clustermcml as mc
import matplotlib
import numpy as np

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "clustermcml", "font.sans-serif": ["DejaVu Sans", "Arial"], "axes.spines.top": False, "axes.spines.right": False,
                     "axes.grid": True, "grid.color": "#e6e6e6", "axes.axisbelow": True, "legend.frameon": False})


def fly(sample, photons, **options):
    return mc.run(os.path.join(HERE, sample), photons=photons, ignore_absorption=True, **options)


def curve(axes, x, value, error, colour, label):
    """Draws a line with a band of one standard error."""
    axes.fill_between(x, np.maximum(value - error, 1e-9), value + error, color=colour, alpha=0.3, linewidth=0)
    axes.plot(x, value, color=colour, linewidth=1.2, label=label)


def figure(panels=1):
    made, axes = plt.subplots(1, panels, figsize=(5.2 * panels, 3.6))
    return made, np.atleast_1d(axes)


def label(axes, least, most, words):
    """Sets a log scale of the weight per sr, with plain numbers."""
    ticks = 10.0 ** np.arange(np.ceil(np.log10(least)), np.floor(np.log10(most)) + 1)
    axes.set(yscale="log", ylim=(least, most), xlabel=words, ylabel="weight per sr")
    axes.set_yticks(ticks, ["%g" % tick for tick in ticks])
    axes.set_yticks([], minor=True)
    axes.legend(fontsize=9)


def save(made, folder, name):
    made.tight_layout()
    made.savefig(os.path.join(folder, name), metadata={"Date": None, "Creator": None})
    print(os.path.join(folder, name))


def ground_glass(folder, photons):
    """Draws transmitted light by angle. Haze is the share of this light that leaves more than 2.5 degrees off the beam."""
    made, (axes,) = figure()
    for colour, alpha in zip(COLOURS, (0.05, 0.1, 0.2, 0.4)):
        result = fly("ground_glass.mci", photons, set={"boundary1.alpha": alpha})
        straight = 2 * np.pi * (1 - np.cos(np.radians(2.5))) * result.Tt_dir[0, 0]
        haze = float(100 * (1 - straight / result.Tt))
        print(f"ground glass, alpha {alpha:g}: haze {haze:.1f} %, Tt {float(result.Tt):.4f} +- {float(result.Tt_se):.4f}")
        curve(axes, np.degrees(result.theta), result.Tt_dir[:, 0], result.Tt_dir_se[:, 0], colour, f"alpha {alpha:g}: haze {haze:.0f} %")
    axes.set(xlim=(0, 90))
    label(axes, 1e-3, 200, "angle to the beam [degrees]")
    save(made, folder, "ground_glass.svg")


def in_plane(values, errors):
    """Returns values within 10 degrees of the plane of incidence, from behind the beam (negative angles) to ahead of it."""
    half = values.sizes["phi"] // 2
    sides = [(values[:, [half - 1, half]], errors[:, [half - 1, half]]), (values[:, [0, -1]], errors[:, [0, -1]])]
    (behind, behind_se), (ahead, ahead_se) = [(v.mean("phi").values, np.sqrt((e**2).sum("phi")).values / 2) for v, e in sides]
    return np.concatenate([behind[::-1], ahead]), np.concatenate([behind_se[::-1], ahead_se])


def paint_gloss(folder, photons):
    """Draws the gloss lobe (left) and the light from inside the paint (right), in the plane of incidence."""
    made, axes = figure(2)
    for colour, alpha, name in zip(COLOURS, (0.05, 0.2, 0.5), ("glossy, alpha 0.05", "satin, 0.2", "matt, 0.5")):
        result = fly("paint_gloss.mci", photons, set={"boundary0.alpha": alpha})
        theta = np.degrees(np.concatenate([-result.theta[::-1], result.theta]))
        for side, kind in zip(axes, ("Rsp_dir", "Rd_dir")):
            curve(side, theta, *in_plane(result[kind], result[kind + "_se"]), colour, name)
        lobe, _ = in_plane(result.Rsp_dir, result.Rsp_dir_se)
        print(f"paint, {name}: gloss is brightest at {theta[lobe.argmax()]:.0f} degrees, {lobe.max():.3g} per sr; Rsp {float(result.Rsp):.4f} +- {float(result.Rsp_se):.4f}")
    for side, title, least, most in zip(axes, ("gloss: Rsp_dir", "from inside the paint: Rd_dir"), (1e-3, 1e-3), (10, 1)):
        side.set(xlim=(-90, 90), xticks=(-60, -30, 0, 30, 60), title=title)
        label(side, least, most, "angle to the vertical, light comes at -60 [degrees]")
    save(made, folder, "paint_gloss.svg")


def frosted_bead(folder, photons):
    """Draws light by its angle to the beam: Tt_dir up to 90 degrees, Rd_dir beyond."""
    made, (axes,) = figure()
    for colour, alpha in zip(COLOURS, (0, 0.1, 0.4)):
        result = fly("frosted_bead.mci", photons, set={"body1.alpha": alpha})
        angles = np.degrees(np.concatenate([result.theta, np.pi - result.theta[::-1]]))
        value, error = (np.concatenate([result["Tt_dir" + end][:, 0], result["Rd_dir" + end][::-1, 0]]) for end in ("", "_se"))
        print(f"bead, alpha {alpha:g}: backwards {float(result.Rd):.4f} +- {float(result.Rd_se):.4f}")
        curve(axes, angles, value, error, colour, f"frosted, alpha {alpha:g}" if alpha else "clear")
    axes.set(xlim=(0, 180), xticks=range(0, 181, 30))
    label(axes, 1e-3, 5, "angle to the beam [degrees]")
    save(made, folder, "frosted_bead.svg")


def main():
    folder, photons = (sys.argv[1:] + [".", "1e6"][len(sys.argv) - 1:])[:2]
    os.makedirs(folder, exist_ok=True)
    for draw in (ground_glass, paint_gloss, frosted_bead):
        draw(folder, float(photons))


if __name__ == "__main__":
    main()
