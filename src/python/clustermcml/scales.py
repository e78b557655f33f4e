"""Scales of a picture's axes, and their ticks.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import math
import re
from typing import Any, Iterable

import numpy as np

from .fields import Field

NAMES = {"r": "radius r", "z": "depth z", "z_volume": "depth z", "alpha": "angle α from the vertical", "gate": "time t"}
COUNTED = ("layer", "body", "medium", "inside", "side")  # axes without lengths


def is_counted(axis: str) -> bool:
    return axis.split()[:1] != [] and axis.split()[0] in COUNTED


def marked(y: Any) -> Any:
    """Returns the places of a curve that have marks: about twenty, and all without a neighbour, which no line would show."""
    step, there = max(1, y.size // 20), np.pad(np.isfinite(y), 1)
    if y.size > 1000:  # with a step instead of places, matplotlib marks only what lies within the frame
        return step
    return np.flatnonzero(there[1:-1] & (~(there[:-2] | there[2:]) | (np.arange(y.size) % step == 0))).tolist()


def set_scale(axes: Any, scale: str, curves: Iterable[tuple[Any, Any]]) -> None:
    """Sets the scale of the upright axis. curves: pairs of values and errors (or None). A log scale ends a little beyond the
    values above 0 and the upper ends of their errors."""
    axes.set_yscale(scale)
    low, high = math.inf, 0.0
    for y, error in curves:
        lit = y > 0
        if lit.any():
            low, high = min(low, float(y[lit].min())), max(high, float((y if error is None else y + np.nan_to_num(error))[lit].max()))
    if scale == "log" and high > 0:
        margin = (high / low) ** 0.05 if high > low else 2.0
        axes.set_ylim(low / margin, high * margin)


def _power(value: float, _: Any = None) -> str:
    """Returns a power of ten as text. matplotlib's own typesetting of powers takes a sixth of the time of a picture.

    >>> _power(1e-12)
    '10⁻¹²'
    """
    return "10" + str(round(math.log10(value))).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")) if value > 0 else ""


def set_powers(axis: Any) -> None:
    """Sets the ticks of a logarithmic axis. Below one decade they are even steps, because no power may lie in it. Below two
    decades they are 1, 2 and 5 times powers of ten. Otherwise only powers have ticks, because each tick costs time."""
    if axis.get_scale() != "log":
        return
    from matplotlib.ticker import MaxNLocator, NullFormatter, NullLocator
    low, high = sorted(axis.get_view_interval())
    plain = high < 100 * low
    axis.set_major_formatter((lambda value, _: f"{value:.6g}") if plain else _power)
    axis.set_minor_formatter((lambda value, _: f"{value:.6g}") if plain else NullFormatter())
    if high < 10 * low:
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        axis.set_minor_locator(NullLocator())
    else:
        axis.set_minor_locator(type(axis.get_minor_locator())(subs=[2, 5] if plain else []))


def ends_of(axis: Field) -> str:
    """Returns the first and last number of a counted axis, else the outer edges of its bins, as text."""
    first, last, unit = float(axis.values.min()), float(axis.values.max()), str(axis.attrs.get("units", "1"))
    half = (last - first) / max(axis.size - 1, 1) / 2
    return f"{first:g} to {last:g}" if unit == "1" else f"{round(first - half, 12):g} to {last + half:g} {unit}"


def label_of(array: Field, name: str = "") -> str:
    """Returns the label of an array with its unit, as axes of pictures have it."""
    units = {"cm2": "cm²", "cm3": "cm³", "1": "-", "sr-1": "1/sr"}
    unit = str(array.attrs.get("units", "1"))
    unit = units.get(unit, unit.replace("cm2", "cm²").replace("cm3", "cm³"))
    own = re.sub(r"^detector_\w+_(?=[xy]$)", "", str(array.name))  # axes of a camera's pixels
    return f"{name or NAMES.get(own, own)}  [{unit}]"
