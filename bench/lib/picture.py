"""Pictures by matplotlib. Words stay words in the svg, and equal figures have equal bytes.

SPDX-License-Identifier: MIT
"""
import importlib.util
import re

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9")  # colours that colour-blind people can tell apart
STYLE = {"svg.fonttype": "none", "svg.hashsalt": "clustermcml", "font.size": 10, "font.sans-serif": ["DejaVu Sans", "Arial"], "axes.spines.top": False, "axes.spines.right": False,
         "axes.grid": True, "grid.color": "#e6e6e6", "axes.axisbelow": True, "axes.titlesize": 10, "legend.frameon": False}


def need(parser, *modules):
    """Refuses a command line if a Python module is missing."""
    for module in modules:
        if not importlib.util.find_spec(module):
            parser.error("%s is missing: pip install %s" % (module, module))


def begin():
    """Returns matplotlib.pyplot in the style of all pictures."""
    import matplotlib
    matplotlib.use("svg")
    import matplotlib.pyplot as plt
    plt.rcParams.update(STYLE)
    return plt


def band(axes, x, y, error, colour, **line):
    """Draws a curve with a band of one standard error."""
    axes.fill_between(x, [a - e for a, e in zip(y, error)], [a + e for a, e in zip(y, error)], color=colour, alpha=0.25, linewidth=0)
    axes.plot(x, y, color=colour, linewidth=1.2, **line)


def bars(axes, x, y, error, colour, marker="o", size=3.5, line="none"):
    """Draws marks with bars of one standard error. The bars are one path, which keeps the svg small."""
    ends = [(at, value + sign * e) for at, value, e in zip(x, y, error) for sign in (-1, 1, float("nan"))]
    axes.plot(*zip(*ends), color=colour, linewidth=0.9)
    axes.plot(x, y, color=colour, marker=marker, markersize=size, linewidth=1, linestyle=line)


def save(figure, path):
    """Writes the figure. Coordinates are rounded to a hundredth of a point, and names of groups are dropped."""
    figure.savefig(path, metadata={"Date": None, "Creator": None})
    with open(path, encoding="utf-8") as stream:
        text = stream.read()
    text = re.sub(r"<[^>]+>", lambda tag: re.sub(r"(\d\.\d{2})\d+", r"\1", tag.group()), text)
    text = re.sub(r'(<g) id="(?:text|line2d|LineCollection|xtick|ytick|patch|matplotlib.axis|FillBetweenPolyCollection|PolyCollection)_\d+"', r"\1", text)
    with open(path, "w", encoding="utf-8") as stream:
        stream.write(re.sub(r"\n +", "\n", text))
