"""Draws a panel per scene from a result of frontier.py: bias against the seconds to an error of 0.1 % (large mark) and of 0.01 % (small mark).

Every method has its own marker. All panels have the same axes and one key.

SPDX-License-Identifier: MIT
"""
import chart
import frontier_scenes
import frontier_table
import picture
from chart import BLUE, GREY, ORANGE

COLUMNS = 3
METHODS = {"plane": ("x", 6, True, "plane (shape ignored)"), "cone": ("D", 5, True, "cones"), "grid": ("s", 4.5, True, "mesh, regular grid (grid walk)"),
           "mesh": ("^", 5.5, False, "mesh (Embree)"), "auto": ("o", 10, False, "method chosen by auto")}
VARIANTS = {"before": (ORANGE, 1.3, "before: random, MCML's roulette"), "mcml": ("black", 1, "original MCML (plane)"),
            "after": (BLUE, 0.77, "after: lattice, roulette window (default)")}  # factors of the bias, so that none hides another
SMALL = 0.6  # size of the mark of 0.01 %


def draw_place(axes, place, factor, colour, marker, size, filled):
    seconds, longer, bias, limit = place
    axes.plot((seconds, longer), (factor * bias, factor * bias), color=colour, linewidth=1.2)
    if limit:
        axes.annotate("", (seconds, 0.5 * factor * bias), (seconds, factor * bias), arrowprops={"arrowstyle": "->", "color": colour, "shrinkA": 0, "shrinkB": 0})
    chart.marks(axes, [seconds], [factor * bias], colour, marker, size, filled)
    chart.marks(axes, [longer], [factor * bias], colour, marker, SMALL * size, filled)


def key(plt):
    lines = [plt.Line2D([], [], color=colour, linewidth=2.5, label=text) for colour, _, text in reversed(VARIANTS.values())]
    lines += [plt.Line2D([], [], color=GREY, linestyle="none", marker=marker, markersize=size, markerfacecolor=GREY if filled else "none", label=text)
              for marker, size, filled, text in METHODS.values()]
    lines.append(plt.Line2D([], [], color=GREY, linestyle="none", marker=r"$\downarrow$", markersize=7, label="upper limit of the bias (2 standard errors)"))
    return lines + [plt.Line2D([], [], color="#888888", linestyle=line, linewidth=1, label=text) for line, text in (("--", "bias of 0.1 %"), (":", "bias of 0.01 %"))]


def draw(rows, target):
    plt, scenes = picture.begin(), frontier_scenes.CHARTED
    height = (len(scenes) + COLUMNS) // COLUMNS  # one place is for the key
    figure = plt.figure(figsize=(12.4, 0.7 + 2.9 * height))
    panels = figure.subplots(height, COLUMNS, gridspec_kw={"left": 0.055, "right": 0.99, "top": 1 - 0.9 / (0.7 + 2.9 * height), "bottom": 0.05, "wspace": 0.22, "hspace": 0.42}).flatten()
    for axes, scene in zip(panels, scenes):
        axes.set(xscale="log", yscale="log", xlabel="core seconds", ylabel="relative bias")
        axes.set_title(frontier_scenes.LABELS.get(scene, scene))
        axes.axhline(1e-3, color="#888888", linestyle="--", linewidth=1)
        axes.axhline(1e-4, color="#888888", linestyle=":", linewidth=1)
        for variant, (colour, factor, _) in VARIANTS.items():
            for method, (marker, size, filled, _) in METHODS.items():
                place = frontier_table.place_of(rows, scene, variant, method)
                if place:
                    draw_place(axes, place, factor, colour, marker, size, filled)
        chart.powers(axes.xaxis, -2, 5, 1)
        chart.powers(axes.yaxis, -7, 0, 1)
        axes.set(xlim=(1e-2, 1e5), ylim=(1e-7, 1))
    rest = panels[len(scenes):]
    for axes in rest:
        axes.axis("off")
    rest[0].legend(handles=key(plt), loc="upper left", bbox_to_anchor=(-0.1, 1.05), fontsize=9)
    note = "" if frontier_table.pick(rows, variant="mcml") else ". original MCML was not timed (--mcml PATH)"
    figure.text(0.055, 1 - 0.28 / (0.7 + 2.9 * height), "Relative bias against the time to a given standard error", fontsize=13)
    figure.text(0.055, 1 - 0.5 / (0.7 + 2.9 * height), "one thread; the slowest and the most biased of Rd, A, Tt above 1 % of the light. Large marks: standard error of 0.1 %; "
                "small marks: 0.01 %" + note, fontsize=9)
    picture.save(figure, target)
