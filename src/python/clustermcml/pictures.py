"""Parts that all pictures share: style, colours and files. Equal input gives equal bytes.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import contextlib
import io
import math
import os
from typing import TYPE_CHECKING, Any, Iterator, Optional

from . import errors
from .command_line import shown_path, write

if TYPE_CHECKING:
    from .compare import Comparison

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000", "#E69F00", "#56B4E9", "#F0E442")  # palette of Okabe and Ito, which colour-blind people can tell apart
STYLE = {"font.size": 10, "font.sans-serif": ["DejaVu Sans", "Arial", "Helvetica"], "axes.titlesize": 11, "axes.titleweight": "bold", "axes.grid": True, "axes.axisbelow": True, "grid.color": "#E4E4E4", "grid.linewidth": 0.6,
         "axes.edgecolor": "#404040", "axes.linewidth": 0.8, "lines.linewidth": 1.3, "lines.markersize": 3.5, "legend.frameon": False, "image.cmap": "viridis", "savefig.dpi": 192, "svg.fonttype": "none",
         "svg.hashsalt": "clustermcml"}


@contextlib.contextmanager
def drawing(style: Optional[str] = None, size: tuple[float, float] = (8.0, 5.0)) -> Iterator[Any]:
    """Yields matplotlib with the style of the package. style: a matplotlib style file that is applied on top, and may set
    another size. size: in inches. If matplotlib is missing, the program says so (src/cli/hand_over.c)."""
    import matplotlib
    with matplotlib.rc_context():
        matplotlib.rcParams.update({**STYLE, "axes.prop_cycle": matplotlib.cycler(color=COLOURS), "figure.figsize": size})
        if style is not None:
            try:
                with open(style, encoding="utf-8"):
                    pass
                own = matplotlib.rc_params_from_file(style, use_default_template=False)
            except (OSError, UnicodeError, ValueError) as error:
                raise errors.InputError(f"--style {shown_path(style)}: cannot be read ({getattr(error, 'strerror', None) or error})") from None
            matplotlib.rcParams.update(own)
        yield matplotlib


def save(figure: Any, path: str) -> None:
    """Saves a figure in the format that its name asks for. No date is written, so that equal input gives equal bytes."""
    os.environ.setdefault("SOURCE_DATE_EPOCH", "0")
    kind, content = os.path.splitext(path)[1][1:].lower(), io.BytesIO()
    figure.savefig(content, format=kind, metadata={"Date": None} if kind == "svg" else None)
    write(path, content.getvalue())


def add_caption(figure: Any, caption: str) -> None:
    """Writes a caption below the figure, which grows by the lines of the caption."""
    import textwrap
    lines = textwrap.wrap(caption, int(figure.get_figwidth() * 15))
    figure.set_figheight(figure.get_figheight() + 0.16 * len(lines))
    figure.supxlabel("\n".join(lines).replace("$", r"\$"), fontsize="small", x=0.01, ha="left", color="#404040")


def draw_comparison(comparison: Comparison, alpha: float, path: str) -> None:
    """Draws z of every test over the axis of its profile, one panel below the other, with the limit of the level. A bar along
    the axis shows bins that were joined. An arrow stands for a value beyond the frame."""
    from .compare import UNITS, limit_of
    shown = {name: array for name, array in comparison.arrays.items()
             if len(array.dims) == 1 and array.dims[0] in UNITS and comparison.found[name] and not name.startswith("detector_") and not array.alone}
    if not shown:
        raise errors.InputError(f"{comparison.names[0]}: too few packets for a picture (expected a profile to show)")
    limit, most = limit_of(alpha, len(comparison.tests)), 8.0
    with drawing():
        from matplotlib.figure import Figure
        figure = Figure(figsize=(9, 1.2 + 1.9 * len(shown)), layout="constrained")
        for row, (axes, (name, array)) in enumerate(zip(figure.subplots(len(shown), squeeze=False)[:, 0], shown.items())):
            tests = [test for test in comparison.found[name] if not test.whole]
            ends = [array.ends(test) for test in tests]
            worst = max(comparison.found[name], key=lambda test: abs(test.z))
            middles, halves = [(low + high) / 2 for low, high in ends], [(high - low) / 2 for low, high in ends]
            axes.errorbar(middles, [max(-most, min(most, test.z)) for test in tests], xerr=halves, fmt="o", ms=3, lw=1.2, color=COLOURS[0])
            for middle, test in zip(middles, tests):
                if abs(test.z) > most:
                    axes.annotate("", (middle, math.copysign(most + 0.9, test.z)), (middle, math.copysign(most - 1.5, test.z)), arrowprops={"arrowstyle": "-|>", "color": COLOURS[1]})
            for level in (-limit, limit):
                axes.axhline(max(-most, min(most, level)), ls="--", lw=1.2, color=COLOURS[1])
            axes.set(xlim=(0, ends[-1][1]), ylim=(-most - 1, most + 1), yticks=(-8, -4, 0, 4, 8), xlabel=UNITS[str(array.dims[0])], ylabel=f"z of {name}")
            if abs(worst.z) > most:
                axes.set_title(f"worst z {worst.z:+.1f}" + (" (the sum)" if worst.whole else ""), loc="right", fontsize="small", fontweight="normal")
        verdict = "differ" if comparison.p < alpha else "agree"
        a, b = (os.path.basename(shown_path(name)) if len(name) > 44 else shown_path(name) for name in comparison.names)
        figure.suptitle(f"{a} (a) against {b} (b)\nThey {verdict}: among {len(comparison.tests)} tests chance alone makes such a difference with p = {comparison.p:.2g}.\n"
                        f"dashed: |z| = {limit:.2f}, the level {alpha:g}; arrows: beyond |z| = {most:g}", fontsize="medium")
        save(figure, path)
