"""Parts that the charts of measurements share: marks, axes in powers of ten, and a check that matplotlib is installed.

SPDX-License-Identifier: MIT
"""
import importlib.util
import sys

import picture

BLUE, RED, GREEN, PINK, SKY = picture.COLOURS
ORANGE, GREY = "#E69F00", "#777777"
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def marks(axes, x, y, colour, marker, size=4, filled=True, line="none"):
    """Draws marks of one kind. Hollow marks differ from filled ones without their colour."""
    return axes.plot(x, y, linestyle=line, marker=marker, markersize=size, color=colour, markerfacecolor=colour if filled else "none", linewidth=1, clip_on=False, zorder=3)[0]


def powers(axis, first, last, step):
    """Labels an axis at every step-th power of ten. Labels are plain letters, whose width is known."""
    powers_of = range(first, last + 1, step)
    axis.set_ticks([10.0 ** k for k in powers_of], labels=["10" + str(k).translate(SUPERSCRIPTS) for k in powers_of])
    axis.set_minor_locator(sys.modules["matplotlib.ticker"].NullLocator())


def draw_result(draw, csv, target):
    """Draws a result into the folder of results, if matplotlib is installed."""
    if importlib.util.find_spec("matplotlib"):
        draw(csv, target)
    else:
        print("no matplotlib, no figure", file=sys.stderr)
