"""Pictures of results: the axes of an array choose between curves, maps, cuts, discs and meshes. Tables of sweeps and of other programs work, too.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import math
import os
import re
from dataclasses import replace
from typing import Any, Iterator, NamedTuple, Optional, Sequence

import numpy as np

from . import errors
from .command_line import Parser, check_overwrite, print_text, readable, shown_path
from .fields import Field, spread_over_mua
from .mco import AXES, QUANTITIES, UNITS
from .pictures import COLOURS, add_caption, drawing, save
from .results import read_as
from .scales import ends_of, is_counted, label_of, marked, set_powers, set_scale
from .watts import lit

MARKS = "oshDv^P*"
MOST = 64  # most files in a picture
FAR = 100.0  # ratio of the largest to the smallest value from which colours are logarithmic
UNLIT = "#D0D0D0"


class Curve(NamedTuple):
    x: Any
    y: Any
    error: Any  # standard error of y, None if unknown
    others: bool  # the curve was read from a table of another program
    drawn_as: str  # label of the upright axis
    axis: str  # label of the lower axis


# ---- results ----

class Result:
    """A file of results, which finds the arrays that the words of --of name. amount: power or energy of the beam in `light`, W or J."""

    def __init__(self, path: str, amount: float = 1.0, light: str = "") -> None:
        self.path, self.data, self.amount, self.light = path, read_as(readable(path)), amount, light

    def of(self, name: str) -> tuple[Field, Optional[Field]]:
        """Returns the array and its standard errors, None if unknown."""
        array, known = self._as_read(name)
        if not self.light:
            return array, known
        return lit(array, self.amount, self.light), None if known is None else lit(known, self.amount, self.light)

    def _as_read(self, name: str) -> tuple[Field, Optional[Field]]:
        if name in ("fluence", "fluence_rz"):
            of, unit = ("A_z", "1") if name == "fluence" else ("A_rz", "1/cm2")
            if "lacks" in self.data.attrs:
                raise errors.InputError(f"{self.data.attrs['lacks']}: missing or of another run (expected the .h5 of this run: a fluence needs the extents of shapes)")
            if of not in self.data or not (self.data["layer_mua"].values > 0).any():
                raise errors.InputError(f"{self.path}: mua = 0 in all layers (expected a layer that absorbs, for a fluence)")
            known = spread_over_mua(self.data, of + "_se") if of + "_se" in self.data else None
            return replace(spread_over_mua(self.data, of), name=name, attrs={"long_name": f"fluence, {of} over mua", "units": unit}), known
        if name + "_xy" in self.data and (name not in self.data or not self.data[name].dims):
            name += "_xy"
        if name in self.data.names() and not self.data[name].dims:
            error = f" +- {float(self.data[name + '_se']):.2g}" if name + "_se" in self.data else ""
            raise errors.InputError(f"{shown_path(self.path)}: {name} is one number, {float(self.data[name]):.6g}{error} (expected an array over an axis{self._longer(name)})")
        if name not in self.data.names() or not self.data[name].dims:
            arrays = [known for known in self.data.names() if self.data[known].dims and not known.endswith("_se")]
            raise errors.InputError(f"{shown_path(self.path)}: no array {name} (expected one of {' '.join(['fluence fluence_rz', *arrays])})")
        return self.data[name], self.data.get(name + "_se")

    def _longer(self, name: str) -> str:
        """Returns the names of longer arrays of the same quantity, for messages."""
        found = [other for other in self.data.names() if other.startswith(name + "_") and self.data[other].dims and not other.endswith("_se")]
        return ": " + " ".join(found) if found else ""

    def cut(self, name: str, cuts: dict[str, float]) -> tuple[Field, Optional[Field]]:
        """Returns an array and its errors, cut at places along its axes: the nearest bins count. Voxels without a cut are cut at y = 0."""
        array, known = self.of(name)
        places = {("z_volume" if axis == "z" and "z_volume" in array.dims else axis): place for axis, place in cuts.items()}
        if "z_volume" in array.dims and not places:
            places = {"y": 0.0}
        for axis, place in places.items():
            if axis not in array.dims:
                raise errors.InputError(f"--cut {axis.removesuffix('_volume')}={place:g} (expected an axis of {name}: {' '.join(map(str, array.dims))})")
            ends = array.axes[axis].values
            half = abs(ends[-1] - ends[0]) / max(ends.size - 1, 1) / 2
            if not ends.min() - half * (1 + 1e-9) <= place <= ends.max() + half * (1 + 1e-9):
                raise errors.InputError(f"--cut {axis.removesuffix('_volume')}={place:g} (expected a place of {ends_of(array.axes[axis])}, in {shown_path(self.path)})")
            array, known = array.nearest(axis, place), None if known is None else known.nearest(axis, place)
        if places and not array.dims:
            raise errors.InputError(f"--cut: {name} has no axis left (expected one place less; its numbers are in the .h5)")
        return array, known

    def places(self, name: str, cuts: dict[str, float]) -> str:
        """Returns the places where an array is cut, as text: the middles of the bins."""
        array, words = self.of(name)[0], []
        for axis, place in cuts.items():
            values = array.axes["z_volume" if axis == "z" and "z_volume" in array.dims else axis]
            unit = str(values.attrs.get("units", "1"))
            words.append(f"{axis} = {float(values.values[np.abs(values.values - place).argmin()]):g}" + (f" {unit}" if unit != "1" else ""))
        return ", ".join(words)

    def heights(self) -> list[tuple[Any, Any]]:
        """Returns the radial heightfields of the result as pairs r and h [cm]."""
        found = [self.data[name] for name in self.data.names() if re.fullmatch(r"boundary\d+_height", name)]
        return [(array.axes[array.dims[0]].values, array.values) for array in found]


def _curve(array: Field, known: Optional[Field], times_r: bool) -> Curve:
    """Returns the curve of an array with one axis. The last bin over r and z is left out, because it also holds all light beyond."""
    axis = array.axes[array.dims[0]]
    end = array.size - (axis.name in ("r", "z") and array.size > 1)
    factor = axis.values if times_r else 1.0
    y, error = array.values * factor, None if known is None else known.values * factor
    long = str(array.attrs.get("long_name", "")).partition(";")[0]
    drawn = label_of(replace(array, attrs={"units": str(array.attrs.get("units", "1")).replace("cm2", "cm")}), f"r·{array.name}(r)") if times_r else label_of(array)
    return Curve(axis.values[:end], y[:end], None if error is None else error[:end], False, drawn + ("\n" + long if long and not times_r else ""), label_of(axis))


# ---- curves of others ----

def _table(path: str) -> list[tuple[int, list[str]]]:
    try:
        with open(readable(path), encoding="utf-8-sig", errors="replace") as file:
            lines = [(number, re.split(r"[,;\s]+", line.partition("#")[0].strip(" ,;\t\n"))) for number, line in enumerate(file, 1)]
    except OSError as error:
        raise errors.unreadable(path, "a table", error) from error
    return [(number, words) for number, words in lines if words != [""]]


def _is_number(word: str) -> bool:
    with contextlib.suppress(ValueError):
        return bool(float(word) <= math.inf)
    return False


def _labels_of_mcml(name: str, times_r: bool) -> tuple[str, str]:
    """Returns the labels of the axis and of the curve, as a result has them, for the names of MCML's curves. Other names give ""."""
    dims, meaning = QUANTITIES.get(name, ((), ""))
    if len(dims) != 1:
        return "", ""
    axis = Field([0.0], dims, {"units": AXES[dims[0]][0]}, dims[0])
    curve = _curve(Field([0.0], dims, {"units": UNITS[dims], "long_name": meaning}, name, {dims[0]: axis}), None, times_r)
    return curve.axis, curve.drawn_as


def _label_of_column(word: str) -> str:
    """Returns the label for the name of a column, such as r_mid_cm.

    >>> _label_of_column("r_mid_cm"), _label_of_column("S_per_cm2"), _label_of_column("cdf")
    ('radius r  [cm]', 'S  [1/cm²]', 'cdf  [-]')
    """
    name, per, unit = re.fullmatch(r"(\w+?)(?:_mid)?(?:_(per_)?(cm[23]?|sr|rad|ps))?", word, re.ASCII).groups()  # type: ignore[union-attr]
    return label_of(Field(0.0, (), {"units": ("1/" if per else "") + (unit or "1")}, name))


def _others(path: str, name: str, times_r: bool) -> Curve:
    """Reads a curve from a table: place, value, standard error, or columns with names (r_mid_cm, Rd_r_per_cm2), of which `name` counts."""
    rows, columns, names = _table(path), [0, 1, 2], ("", "")
    if rows and not _is_number(rows[0][1][0]):
        head = rows[0][1]
        of = [i for i, word in enumerate(head) if re.match(re.escape(name) + "(_|$)", word) and not word.startswith(name + "_se")]
        place = [i for i, word in enumerate(head) if re.match("(r|z|alpha|t)(_|$)", word)]
        if len(head) > 3 or of:
            if not of or not place:
                others = [re.sub("_(per_cm2|per_cm|per_sr|se)$", "", word) for word in head if not word.endswith("_se") and word not in [head[i] for i in place]]
                raise errors.InputError(f"{shown_path(path)}: {name} is missing (expected --of {' or '.join(others) or 'a column'}, and a column of places, as r_mid_cm)")
            names = (head[place[0]], head[of[0]])
            columns = [place[0], of[0], *[i for i, word in enumerate(head) if word.startswith(name + "_se")]]
        rows = rows[1:]
    columns = [column for column in columns if rows and column < len(rows[0][1])]
    if len(rows) < 2 or len(columns) < 2:
        raise errors.InputError(f"{shown_path(path)}: no curve (expected two rows or more of two or three numbers: place, value, standard error)")
    numbers: list[list[float]] = []
    for number, words in rows:
        good = all(column < len(words) and _is_number(words[column]) for column in columns)
        if not good or float(words[columns[1]]) < 0 or numbers and not float(words[columns[0]]) > numbers[-1][0]:
            raise errors.InputError(f"{shown_path(path)}:{number}: {' '.join(words)[:80]} (expected {len(columns)} numbers: a place beyond the last, a value of 0 or more"
                                    f"{', its standard error' if len(columns) > 2 else ''})")
        numbers.append([float(words[column]) for column in columns])
    x, y, *error = np.array(numbers).T
    axis, drawn = _labels_of_mcml(name, times_r)
    if not axis and names[0]:
        axis, drawn = (_label_of_column(word) for word in names)
    factor = x if times_r else 1.0
    return Curve(x, y * factor, error[0] * factor if error else None, True, drawn, axis)


# ---- sweeps ----

class Sweep:
    """The table of a sweep."""

    def __init__(self, path: str) -> None:
        with open(readable(path), encoding="utf-8", errors="replace", newline="") as file:
            rows = list(csv.reader(file))
        self.path, self.head = path, rows[0] if rows else []
        self.rows = [dict(zip(self.head, row)) for row in rows[1:]]
        if "row" not in self.head or "Rsp" not in self.head or "photons" not in self.head or any(len(row) != len(self.head) for row in rows):
            raise errors.InputError(f"{shown_path(path)}: no table of a sweep (expected columns row, photons and Rsp, and as many words in each row)")
        self.swept = [name for name in self.head[self.head.index("row") + 1:self.head.index("photons")]]

    def column(self, option: str, name: str) -> str:
        if name not in self.head:
            raise errors.InputError(f"--{option} {name} (expected a column of {shown_path(self.path)}: {', '.join(self.head)})")
        return name

    def numbers(self, option: str, name: str, rows: Optional[list[dict[str, str]]] = None) -> Any:
        words = [row[self.column(option, name)] for row in (self.rows if rows is None else rows)]
        if not all(map(_is_number, words)):
            raise errors.InputError(f"--{option} {name} (expected a column of numbers)")
        return np.array(words, dtype=float)

    def varies(self, name: str) -> bool:
        return len({row[name] for row in self.rows}) > 1

    def over(self, wanted: Optional[str]) -> list[str]:
        """Returns the columns along the axes: the wanted ones, else a label that is a number, else the first swept column that is a number."""
        if wanted:
            return [self.column("over", name) for name in wanted.split(",")]
        able = [name for name in self.swept if self.varies(name) and all(_is_number(row[name]) for row in self.rows)]
        labels = [name for name in able if "." not in name]
        if not able:
            raise errors.InputError(f"{shown_path(self.path)}: rows (expected two that differ in a number, or --over)")
        return (labels or able)[:1]

    def curves(self, over: str, by: Optional[str]) -> Iterator[tuple[str, list[dict[str, str]]]]:
        """Yields the rows of each curve, and the value that tells it from others: of the column that makes the fewest curves, if rows need one."""
        def split(name: Optional[str]) -> dict[str, list[dict[str, str]]]:
            found: dict[str, list[dict[str, str]]] = {}
            for row in self.rows:
                found.setdefault(row[name] if name else "", []).append(row)
            return found
        able: list[Optional[str]] = [self.column("by", by)] if by else [None, *sorted((name for name in self.swept if name != over and self.varies(name)), key=lambda name: len(split(name)))]
        for name in able:
            parts = split(name)
            if by or all(len({row[over] for row in rows}) == len(rows) for rows in parts.values()):
                yield from ((f"{name} = {value}" if name else "", sorted(rows, key=lambda row: float(row[over]))) for value, rows in parts.items())
                return
        raise errors.InputError(f"{shown_path(self.path)}: rows with the same {over} (expected --by, a column that tells them apart)")

    def unit(self, name: str) -> str:
        units = {"mua": "1/cm", "mus": "1/cm", "angle": "degree", "azimuth": "degree", **dict.fromkeys(("d", "radius", "x", "y", "z", "r1", "r2", "w", "h", "dx", "dy"), "cm")}
        return f"{name}  [{units.get(name.rpartition('.')[2], '-')}]" if "." in name or name in ("Rsp", "Rd", "A", "Tt") else name


# ---- drawing ----

def _draw_curves(figure: Any, given: argparse.Namespace, sources: list[Any]) -> None:
    names = [given.of] if given.of else ["Rd_r", "Tt_r"]
    panels = figure.subplots(len(names), squeeze=False)[:, 0]
    for axes, name in zip(panels, names):
        heights: list[tuple[int, Any, Any]] = []
        seen: list[tuple[Any, Any]] = []
        beyond = 0.0
        for k, source in enumerate(sources):
            if isinstance(source, Result):
                curve = _curve(*source.cut(name, given.cut), times_r=not given.of)
                curve = curve._replace(drawn_as=curve.drawn_as + (f", {source.places(name, given.cut)}" if given.cut else ""))
                heights += [(k, r, h) for r, h in source.heights()] if "radius" in curve.axis else []
            else:
                curve = _others(source, name, times_r=not given.of)
            log = (given.scale or ("linear" if is_counted(curve.axis) else "log")) == "log"
            _draw_curve(axes, curve, given.labels[k], COLOURS[k % len(COLOURS)], MARKS[k % len(MARKS)], log)
            seen.append((np.asarray(curve.y, dtype=float), curve.error))
            values: Any = np.nan_to_num(np.asarray(curve.y, dtype=float))
            lit = curve.x[values > 0]
            beyond = max(beyond, float(lit[-1]) if lit.size else 0.0)
            if curve.axis:
                axes.set(xlabel=curve.axis, ylabel=curve.drawn_as)
        counted = is_counted(axes.get_xlabel())
        if beyond > 0 and not given.logx and not counted and min(axes.dataLim.x0, axes.dataLim.x1) >= 0:
            axes.set_xlim(0, beyond * 1.02)
        set_scale(axes, given.scale or ("linear" if counted else "log"), seen)
        if heights and not given.logx:
            _draw_heights(axes, heights)
        axes.legend()
    _set_ranges(panels, given)


def _draw_curve(axes: Any, curve: Curve, label: str, colour: str, mark: str, log: bool) -> None:
    """Draws a curve. On a log scale, zeros are gaps, and error bars as large as their values leave the frame below."""
    error, y = curve.error, np.where(curve.y > 0, curve.y, np.nan) if log else curve.y
    bars = error if error is None or not log else np.array([np.fmin(error, y * (1 - 1e-9)), error])
    if "[-]" in curve.axis and is_counted(curve.axis):
        axes.errorbar(curve.x, y, bars, fmt=mark, color=colour, capsize=3, label=label)
        axes.set_xticks(curve.x)
    elif curve.others:
        axes.errorbar(curve.x, y, bars, ls="--", marker=mark, mfc="none", color=colour, markevery=marked(y), label=label)
    else:
        axes.plot(curve.x, y, marker=mark, color=colour, markevery=marked(y), label=label)
        if error is not None:
            axes.fill_between(curve.x, y - (bars[0] if log else error), y + error, color=colour, alpha=0.25, lw=0)


def _draw_heights(axes: Any, heights: list[tuple[int, Any, Any]]) -> None:
    """Draws heightfields dotted, in the lowest quarter of the panel."""
    twin = axes.twinx()
    for k, r, h in heights:
        twin.plot(np.append(r, max(r[-1], axes.get_xlim()[1])), np.append(h, h[-1]), ":", color=COLOURS[k % len(COLOURS)])
    low, high = min(float(h.min()) for _, _, h in heights), max(float(h.max()) for _, _, h in heights)
    size = high - low or abs(high) or 1.0
    twin.set(ylim=(low - 0.1 * size, low + 4 * size), ylabel="height  [cm]", xlim=axes.get_xlim())
    twin.set_yticks([low, high] if high > low else [low])
    twin.grid(False)


def _add_bar(figure: Any, drawn: Any, panels: Any, label: str, **options: Any) -> None:
    equal = panels[-1].name == "rectilinear" and panels[-1].get_aspect() == 1  # such a panel may be lower than the picture
    bar = figure.colorbar(drawn, label=label, **({"cax": panels[-1].inset_axes([1.04, 0, 0.05, 1])} if equal else {"ax": list(panels)}), **options)
    set_powers(bar.ax.yaxis)


def _set_ranges(panels: Any, given: argparse.Namespace) -> None:
    for axes in panels:
        if given.logx:
            axes.set_xscale("log")
        if given.xrange:
            axes.set_xlim(given.xrange)
        if given.yrange:
            axes.set_ylim(given.yrange)
        set_powers(axes.xaxis)
        set_powers(axes.yaxis)


def _norm(matplotlib: Any, arrays: Sequence[Any], given: argparse.Namespace) -> Any:
    """Returns one scale for all maps: linear up to a range of FAR, logarithmic beyond. The faintest hundredth of lit cells is darkest."""
    flat: list[Any] = [np.ravel(array) for array in arrays]
    lit = np.concatenate([array[np.isfinite(array) & (array > 0)] for array in flat])
    log = given.scale == "log" or given.scale is None and lit.size > 0 and lit.max() > FAR * lit.min()
    low, high = given.crange or (None, None)
    high = high if high is not None else float(np.percentile(lit, given.percentile)) if lit.size else 1.0
    least = min((float(array[np.isfinite(array)].min()) for array in flat if np.isfinite(array).any()), default=0.0)
    low = low if low is not None else (float(np.percentile(lit, 1)) if lit.size else high / 10) if log else min(0.0, least)
    if log and not low > 0:
        raise errors.InputError(f"--crange {low:g}: on a logarithmic scale (expected a lower end above 0, or --linear)")
    return matplotlib.colors.LogNorm(low, max(high, low * 1.0001)) if log else matplotlib.colors.Normalize(low, max(high, low + 1e-30))


def _edges(axis: Field) -> tuple[float, float]:
    values = axis.values
    half = abs(values[-1] - values[0]) / (values.size - 1) / 2 if values.size > 1 else abs(values[0]) or 0.5
    return float(values.min() - half), float(values.max() + half)


def _shown(array: Field) -> Field:
    """Returns the array without its last bins over r and z, which hold all light beyond the grid."""
    for dim in array.dims:
        array = array.part(dim, slice(0, -1)) if dim in ("r", "z") and array.axes[dim].size > 1 else array
    return array


def _grey(arrays: list[Field], log: bool) -> str:
    """Returns the meaning of grey pixels, for the caption."""
    values = [_shown(array).values for array in arrays]
    words = ["no light"] * (log and any((one <= 0).any() for one in values)) + ["not known"] * any(np.isnan(one).any() for one in values)
    return "; grey: " + " or ".join(words) if words else ""


def _draw_map(figure: Any, axes: Any, array: Field, norm: Any, cmap: Any) -> Any:
    """Draws an array over two axes; depths go down. Directions are a disc: distance from the middle is the angle, azimuth runs around."""
    if array.dims == ("theta", "phi"):
        round_ = -(-180 // array.axes["phi"].size)  # number of straight pieces in place of each arc
        theta, phi = np.linspace(0, np.pi / 2, array.axes["theta"].size + 1), np.linspace(0, 2 * np.pi, round_ * array.axes["phi"].size + 1)
        axes.set(yticks=[30, 60], ylim=(0, 90), axisbelow=False)  # circles and their angles lie over the colours
        axes.set_yticklabels(["30°", "60°"], color="#404040", bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 1})
        axes.grid(False)  # matplotlib before 3.7 asks for this
        drawn = axes.pcolormesh(phi, np.degrees(theta), np.repeat(array.values, round_, axis=1), norm=norm, cmap=cmap, rasterized=True)
        axes.grid(True, color="white", alpha=0.4)
        return drawn
    first = str(array.dims[0])
    if first == "r" or first in ("x", "layer", "body") or first.endswith("_x"):
        array = array.turned()
    array = _shown(array)
    y, x = (array.axes[dim] for dim in array.dims)
    down = str(y.name).startswith("z")
    (left, right), (bottom, top) = _edges(x), _edges(y)
    drawn = axes.imshow(array.values, extent=(left, right, bottom, top), origin="lower", interpolation="nearest", aspect="equal" if x.attrs.get("units") == y.attrs.get("units") and 0.2 < (right - left) / (top - bottom) < 5 else "auto", norm=norm, cmap=cmap)
    axes.set(xlabel=label_of(x), ylabel=label_of(y))
    axes.grid(False)
    if down:
        axes.invert_yaxis()
    return drawn


def _draw_maps(matplotlib: Any, figure: Any, given: argparse.Namespace, sources: list[Any]) -> None:
    arrays = [source.cut(given.of, given.cut)[0] for source in sources]
    for source, array in zip(sources, arrays):
        if array.dims != arrays[0].dims:
            raise errors.InputError(f"{shown_path(source.path)}: {given.of} over {' '.join(map(str, array.dims))} (expected {' '.join(map(str, arrays[0].dims))}, as in {shown_path(sources[0].path)})")
    cmap = matplotlib.colormaps[matplotlib.rcParams["image.cmap"]].copy()
    cmap.set_bad(UNLIT)
    norm = _norm(matplotlib, [array.values for array in arrays], given)
    panels = figure.subplots(1, len(arrays), squeeze=False, subplot_kw={"projection": "polar"} if arrays[0].dims == ("theta", "phi") else {})[0]
    for axes, array, label in zip(panels, arrays, given.labels):
        drawn = _draw_map(figure, axes, array, norm, cmap)
        axes.set_title(label)
    at = sources[0].places(given.of, given.cut)
    log = isinstance(norm, matplotlib.colors.LogNorm)
    _add_bar(figure, drawn, panels, label_of(arrays[0], given.of) + (f", {at}" if at else "") + _grey(arrays, log), extend="max" if given.percentile < 100 else "neither")
    _set_ranges(panels, given)


def _draw_sweeps(matplotlib: Any, figure: Any, given: argparse.Namespace, sweeps: list[Sweep]) -> None:
    of, over = given.of or "Rd", sweeps[0].over(given.over)
    if len(over) > 2:
        raise errors.InputError(f"--over {given.over} (expected one column, or two)")
    if len(over) == 2:
        _draw_swept_maps(matplotlib, figure, given, sweeps, of, over)
        return
    axes, k = figure.subplots(), 0
    seen: list[tuple[Any, Any]] = []
    for sweep, label in zip(sweeps, given.labels):
        sweep.numbers("over", over[0])
        for by, rows in sweep.curves(over[0], given.by):
            x, y = sweep.numbers("over", over[0], rows), sweep.numbers("of", of, rows)
            error = sweep.numbers("of", of + "_se", rows) if of + "_se" in sweep.head else None
            name = ": ".join(filter(None, [label if len(sweeps) > 1 or given.label else "", by])) or of
            seen.append((y, error))
            _draw_curve(axes, Curve(x, y, error, False, "", ""), name, COLOURS[k % len(COLOURS)], MARKS[k % len(MARKS)], given.scale != "linear")
            k += 1
    axes.set(xlabel=sweeps[0].unit(over[0]), ylabel=sweeps[0].unit(of))
    set_scale(axes, given.scale or "log", seen)
    axes.legend()
    _set_ranges([axes], given)


def _draw_swept_maps(matplotlib: Any, figure: Any, given: argparse.Namespace, sweeps: list[Sweep], of: str, over: list[str]) -> None:
    """Draws values of sweeps over two columns. Cells stand side by side in rising order, as if their values were evenly spread."""
    grids = []
    for sweep in sweeps:
        x, y, values = sweep.numbers("over", over[0]), sweep.numbers("over", over[1]), sweep.numbers("of", of)
        (xs, i), (ys, j) = np.unique(x, return_inverse=True), np.unique(y, return_inverse=True)
        if len(set(zip(i, j))) < len(i):
            raise errors.InputError(f"{shown_path(sweep.path)}: rows with the same {over[0]} and {over[1]} (expected one row for each)")
        grid = np.full((ys.size, xs.size), np.nan)
        grid[j, i] = values
        grids.append((xs, ys, grid))
    cmap = matplotlib.colormaps[matplotlib.rcParams["image.cmap"]].copy()
    cmap.set_bad(UNLIT)
    norm = _norm(matplotlib, [grid for _, _, grid in grids], given)
    figure.set_size_inches(1.6 + 5.2 * len(sweeps), 4.8)
    panels = figure.subplots(1, len(sweeps), squeeze=False)[0]
    for axes, label, (xs, ys, grid) in zip(panels, given.labels, grids):
        drawn = axes.imshow(grid, origin="lower", aspect="auto", interpolation="nearest", norm=norm, cmap=cmap)
        for ticks, values in ((axes.set_xticks, xs), (axes.set_yticks, ys)):
            step = max(1, -(-values.size // 8))
            ticks(np.arange(0, values.size, step), [f"{value:g}" for value in values[::step]])
        axes.set(xlabel=sweeps[0].unit(over[0]), ylabel=sweeps[0].unit(over[1]), title=label)
        axes.grid(False)
    _add_bar(figure, drawn, panels, sweeps[0].unit(of) + ("; grey: no row" if any(np.isnan(grid).any() for _, _, grid in grids) else ""))


def _draw_facets(matplotlib: Any, figure: Any, given: argparse.Namespace, sources: list[Any]) -> None:
    """Draws meshes from the side, shaded. Each facet has the colour of its number. The shapes stand in the .vtp file beside the .h5."""
    from .facets import draw_mesh, read_mesh
    shape, _, name = given.of.partition("_")
    meshes = [read_mesh(re.sub(r"\.h5$", "", source.path, flags=re.IGNORECASE) + (".bodies.vtp" if shape == "body" else f".{shape}.vtp"), name) for source in sources]
    meshes = [mesh._replace(values=mesh.values * source.amount) for mesh, source in zip(meshes, sources)]
    norm = _norm(matplotlib, [mesh.values for mesh in meshes], given)
    panels = figure.subplots(1, len(meshes), squeeze=False, subplot_kw={"projection": "3d"})[0]
    for axes, mesh, label in zip(panels, meshes, given.labels):
        draw_mesh(matplotlib, axes, mesh, norm)
        axes.set_title(label)
    drawn = matplotlib.cm.ScalarMappable(norm, matplotlib.rcParams["image.cmap"])
    _add_bar(figure, drawn, panels, label_of(sources[0].of(given.of)[0]), shrink=0.7, pad=0.12)


# ---- the command ----

def _range(word: str) -> tuple[Optional[float], Optional[float]]:
    """Reads A:B with A below B. One of both may be left out.

    >>> _range("0.1:"), _range("1:2")
    ((0.1, None), (1.0, 2.0))
    """
    low, colon, high = word.partition(":")
    with contextlib.suppress(ValueError):
        ends = (float(low) if low else None, float(high) if high else None)
        if colon and (low or high) and all(end is None or math.isfinite(end) for end in ends) and (ends[0] is None or ends[1] is None or ends[0] < ends[1]):
            return ends
    raise argparse.ArgumentTypeError(f"{word} (expected A:B with A below B; A: and :B leave the other end open)")


def _cut(word: str) -> tuple[str, float]:
    axis, _, place = word.partition("=")
    if not axis or not _is_number(place) or not math.isfinite(float(place)):
        raise argparse.ArgumentTypeError(f"{word} (expected an axis and a place, as y=0)")
    return axis, float(place)


def _parser() -> Parser:
    parser = Parser("plot", "FILE ...", "Draws r*Rd(r) and r*Tt(r), or the array that --of names, of one or more results (.mco, .h5): by its axes as curves with bands of one standard "
                    "error, maps in colours side by side, cuts through voxels, directions as discs, facets as shaded meshes. Curves of others (.csv: place, value, standard error) are "
                    "dashed, radial heightfields dotted. Of tables of sweeps (.sweep.csv) columns over each other.",
                    "clustermcml plot a.h5 --of phi_xyz --cut y=0 --title 'Skin, 633 nm' -o fluence.svg")
    parser.add_argument("files", nargs="+", metavar="FILE", help=".mco, .h5, .csv or .sweep.csv")
    parser.add_output("the picture: .svg, .png, .pdf or .eps; default plot.svg", "plot.svg")
    parser.add_argument("--of", metavar="NAME", help="an array of the file, its errors NAME_se, or fluence, fluence_rz (A_z, A_rz over mua); of a map Rd or Tt; of a sweep a column; default r*Rd(r) and r*Tt(r), of a sweep Rd")
    parser.add_argument("--cut", metavar="AXIS=A", type=_cut, action="append", default=[], help="an array of more axes at one place of an axis, in its unit (cm, rad, ps, or a number of a layer); of voxels y=0 without it")
    for name, unit, text in (("power", "W", "as W, W/cm2, W/cm3 ..."), ("energy", "J", "as J, J/cm2, J/ps ...")):
        parser.add_argument("--" + name, metavar=unit, type=parser.number(f"a number > 0 [{unit}]", 1e-300, 1e300), help=f"{name} of the beam [{unit}]: light is drawn {text}")
    parser.add_argument("--over", metavar="NAME[,NAME]", help="of a sweep: the column along the lower axis, default what was swept first; two: in colours over both")
    parser.add_argument("--by", metavar="NAME", help="of a sweep: a curve for each value of this column; default where rows need it")
    parser.add_argument("--label", metavar="TEXT", action="append", default=[], help="in place of a file's name; once for each file, in their order")
    parser.add_argument("--title", metavar="TEXT", help="above the picture; default: names of the scenes, none above maps")
    parser.add_argument("--caption", metavar="TEXT", help="below the picture, broken into lines")
    for name, text in (("xrange", "of the lower axis, in its unit"), ("yrange", "of the upright axis, likewise"), ("crange", "of the colours of a map: the same for all pictures that shall be compared")):
        parser.add_argument("--" + name, metavar="A:B", type=_range, help=text + "; A: and :B leave the other end to the data")
    parser.add_argument("--percentile", metavar="P", type=parser.number("a number above 0, up to 100", 1e-9, 100), default=100.0, help="the colours of a map end at this percentile of its lit pixels, default 100")
    parser.add_argument("--log", dest="scale", action="store_const", const="log", help="logarithmic scale; default: curves are, maps as their range asks for")
    parser.add_argument("--linear", dest="scale", action="store_const", const="linear", help="linear scale")
    parser.add_argument("--logx", action="store_true", help="of curves: the lower axis is logarithmic, too")
    parser.add_argument("--style", metavar="FILE", help="a style of matplotlib (.mplstyle), over ours: fonts, colour map, widths of a journal")
    parser.add_argument("--quiet", action="store_true", help="does not name the picture")
    return parser


def _sources(given: argparse.Namespace) -> tuple[str, list[Any]]:
    """Opens the files. Returns their kind, "sweep" or another, and a source of curves or arrays for each."""
    endings = [path.lower() for path in given.files]
    tables = [path.endswith(".sweep.csv") for path in endings]
    for path in given.files:
        if path.lower().endswith((".vti", ".vtp")):
            raise errors.InputError(f"{shown_path(path)} (expected the .h5 beside it, which has the same arrays, and --of)")
    light = [(amount, unit) for amount, unit in ((given.power, "W"), (given.energy, "J")) if amount is not None]
    if len(light) > 1 or light and any(tables):
        raise errors.InputError(f"--{'power' if light[0][1] == 'W' else 'energy'} {light[0][0]:g} (expected with results, .h5 or .mco, and one of --power and --energy)")
    if any(tables):
        if not all(tables):
            raise errors.InputError(f"{shown_path(given.files[tables.index(False)])} (expected the table of a sweep, like {shown_path(given.files[tables.index(True)])})")
        return "sweep", [Sweep(path) for path in given.files]
    for option in ("over", "by"):
        if getattr(given, option):
            raise errors.InputError(f"--{option} (expected with the table of a sweep, NAME.sweep.csv)")
    sources: list[Any] = [path if path.lower().endswith(".csv") else Result(path, *sum(light, ())) for path in given.files]
    results = [source for source in sources if isinstance(source, Result)]
    array = results[0].cut(given.of, given.cut)[0] if results and given.of else None
    if array is not None and str(array.dims[0]).endswith("facet"):
        kind = "facets"
    elif array is not None and len(array.dims) > 2:
        raise errors.InputError(f"--of {given.of}: over {' '.join(map(str, array.dims))} (expected --cut at a place of one of them)")
    else:
        kind = "map" if array is not None and len(array.dims) == 2 else "curve"
    if kind != "curve" and len(results) < len(sources):
        raise errors.InputError(f"{shown_path(next(s for s in sources if not isinstance(s, Result)))} (expected a result with {given.of}, like {shown_path(results[0].path)})")
    if array is not None and "z_volume" in results[0].of(given.of)[0].dims and not given.cut:
        given.cut = {"y": 0.0}
    return kind, sources


def _labels(given: argparse.Namespace) -> list[str]:
    """Returns a label for each file: its own name, with the folder if two files have the same name. Its middle goes if it is wider than a panel."""
    names = [os.path.basename(path) for path in given.files]
    own = [shown_path(name if names.count(name) == 1 else path) for name, path in zip(names, given.files)]
    shown = given.label + own[len(given.label):]
    return [text if len(text) <= 40 else text[:18] + "..." + text[-19:] for text in (label.replace("$", r"\$") for label in shown)]


def _title(sources: list[Any]) -> str:
    names = [re.sub(r"\.(mco|h5)$", "", str(source.data.attrs.get("title", ""))) for source in sources if isinstance(source, Result)]
    return ", ".join(dict.fromkeys(names)) if len(names) <= 4 else ""


def draw(given: argparse.Namespace) -> None:
    given.cut = dict(given.cut)
    kind, sources = _sources(given)
    given.labels = _labels(given)
    size = (8.0, 4.0 * (1 if given.of else 2)) if kind == "curve" else (8.0, 5.0) if kind == "sweep" else (1.6 + 5.2 * len(sources), 4.8)
    with drawing(given.style, size) as matplotlib:
        from matplotlib.figure import Figure
        figure = Figure(layout="constrained")
        if kind == "curve":
            _draw_curves(figure, given, sources)
        else:
            {"sweep": _draw_sweeps, "facets": _draw_facets, "map": _draw_maps}[kind](matplotlib, figure, given, sources)
        title = given.title if given.title is not None else _title(sources) if kind == "curve" else ""
        if title:
            figure.suptitle(title.replace("$", r"\$"), fontweight="bold")
        if given.caption:
            add_caption(figure, given.caption)
        save(figure, given.output)


def main(words: list[str]) -> int:
    given = _parser().parse_args(words)
    if len(given.files) > MOST or len(given.label) > len(given.files):
        raise errors.InputError(f"plot: {len(given.files)} files and {len(given.label)} labels (expected at most {MOST} files, and a label for each)")
    check_overwrite("plot", given.output, given.files)
    draw(given)
    return 0 if given.quiet else print_text(shown_path(given.output) + "\n")
