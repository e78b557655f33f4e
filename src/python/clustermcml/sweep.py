"""Sweeps: a scene flown for all combinations of some values, or for the rows of a table.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Iterable, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from . import errors
from .fields import Fields
from .options import Path, SweepOptions, option_words, shown
from .program import fly
from .progress import Progress, Wanted
from .scene import Scene
from .scene_files import NONE

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from typing_extensions import Unpack


def table_text(lines: Iterable[Iterable[object]]) -> str:
    """Returns the text of a file of --sweep: names, then a line for each row."""
    return "".join(",".join(map(str, line)) + "\n" for line in lines)


@dataclass
class _Table:
    """The table of a sweep. columns: a value of each parameter for every row. labels: columns that are carried along and not
    set. sizes: of the new dimensions."""

    columns: dict[str, list[Any]]
    labels: Sequence[str]
    sizes: dict[str, int]
    coords: dict[str, Any]

    def text(self) -> str:
        """Returns the text of a file of --sweep. Labels stand in quotation marks."""
        def cell(name: str, value: object) -> str:
            return '"' + str(value).replace('"', '""') + '"' if name in self.labels else str(value)
        return table_text(map(cell, self.columns, line) for line in [self.columns, *zip(*self.columns.values())])


def _column(name: str, values: Any, kinds: str, expected: str) -> list[Any]:
    """Returns the values of a column as Python's own. kinds: allowed kinds of its dtype, as letters of numpy. Numbers become floats."""
    array = np.asarray(values) if "U" in kinds else errors.array(name, values, kinds, expected)
    array = array.astype(str) if array.dtype.kind == "O" else array
    if array.ndim != 1 or not array.size or array.dtype.kind not in kinds or not all(errors.is_line(str(value)) for value in array):
        raise errors.refuse(name, values, expected)
    if array.dtype.kind in "iu" and max(abs(int(array.min())), int(array.max())) > 2**53:
        raise errors.refuse(name, values, "whole numbers up to 2^53, as floats have them")
    return list((array.astype(float) if kinds == "iuf" else array).tolist())


def _numbers(columns: Mapping[str, Any]) -> dict[str, list[float]]:
    return {name: _column(f"parameters[{name!r}]", values, "iuf", "a list of at least one number") for name, values in columns.items()}


def _grid(parameters: Mapping[str, Any]) -> _Table:
    """Returns a table of all combinations of the values. The last name varies fastest."""
    values = _numbers(parameters)
    for name, numbers in values.items():
        if len(set(numbers)) < len(numbers):
            raise errors.refuse(f"parameters[{name!r}]", parameters[name], "values that differ")
    columns = dict(zip(values, map(list, zip(*itertools.product(*values.values())))))
    return _Table(columns, (), {name: len(numbers) for name, numbers in values.items()}, {**values})


def _rows(parameters: Mapping[str, Any], dim: str, coords: Sequence[str]) -> _Table:
    """Returns a table with one run for each row of the columns. coords: columns that are carried along and not set."""
    missing = [name for name in coords if name not in parameters]
    if missing:
        raise errors.refuse("coords", missing[0], "names of columns of the table, or a dict of them")
    columns = {name: _column(f"parameters[{name!r}]", values, "iufU", "a list of numbers or texts of one line") if name in coords
               else _numbers({name: values})[name] for name, values in parameters.items()}
    lengths = {name: len(values) for name, values in columns.items()}
    rows = next(iter(lengths.values()))
    for name, length in lengths.items():
        if length != rows:
            raise errors.refuse(f"parameters[{name!r}]", parameters[name], f"{rows} values, as many as the first column has")
    if set(columns) <= set(coords):
        raise errors.refuse("coords", coords, "fewer names: at least one column must be set")
    return _Table(columns, coords, {dim: rows}, {name: (dim, values) for name, values in columns.items()})


def _table(parameters: Any, dim: Optional[str], coords: Union[Sequence[str], Mapping[str, ArrayLike]]) -> _Table:
    """Returns the table of the arguments of `sweep`. The index of a DataFrame counts as a column if it has a name."""
    import pandas as pd
    columns, index = parameters, None
    if isinstance(parameters, pd.DataFrame):
        index = parameters.index.name
        columns = parameters if index is None else parameters.reset_index()
        if not columns.columns.is_unique:
            raise errors.refuse("parameters", list(columns.columns), "names that differ")
    if not isinstance(columns, (Mapping, pd.DataFrame)) or not len(columns):
        raise errors.refuse("parameters", parameters, 'a dict of names and lists of values, {"layer1.mua": [0.1, 0.2]}, or a DataFrame')
    if isinstance(coords, str) or not isinstance(coords, (Sequence, Mapping)):
        raise errors.refuse("coords", coords, "names of columns of the table, or a dict of them")
    if dim is not None:
        errors.text("dim", dim)
    if isinstance(columns, Mapping) and dim is None and not coords:
        return _grid(columns)
    held = {errors.text("parameters", str(name)): values for name, values in columns.items()}
    held.update(coords if isinstance(coords, Mapping) else {})
    labels = [*coords, *([] if index is None else [str(index)])]
    return _rows(held, str(dim or index or "row"), labels)


def _common(rows: Sequence[Fields]) -> tuple[list[str], list[str]]:
    """Returns the names of arrays that all rows have in the same size, and the names of all others. For example, a surface may be a plane in some
    rows."""
    names = list(dict.fromkeys(name for row in rows for name in row.names()))
    sizes = [{name: row[name].shape for name in row.names()} for row in rows]
    everywhere = [name for name in names if all(size.get(name) == sizes[0].get(name, ()) for size in sizes)]
    return everywhere, [name for name in names if name not in everywhere]


def _stack(rows: Sequence[Fields], table: _Table) -> xr.Dataset:
    """Returns the arrays of all rows, stacked along the new dimensions, which come first."""
    import xarray as xr
    shape, dims, first = tuple(table.sizes.values()), tuple(table.sizes), rows[0]
    everywhere, elsewhere = _common(rows)
    if elsewhere:
        errors.warn(" ".join(elsewhere) + ": left out, as not all rows have them with as many facets")
    stacked = {name: (dims + first[name].dims, np.stack([row[name].values for row in rows]).reshape(shape + first[name].shape), first[name].attrs) for name in everywhere}
    axes = {name: (one.dims, one.values, one.attrs) for name, one in first.held.items() if any(name in first[other].dims for other in everywhere)}
    attrs = {key: value for key, value in first.attrs.items() if all(row.attrs.get(key) == value for row in rows)}
    return xr.Dataset(stacked, {**axes, **table.coords}, attrs)


def _kept(result: Fields, table: _Table, variables: Optional[Sequence[str]]) -> Fields:
    """Returns the result of a row with the wanted variables alone. None keeps all."""
    for name in (*table.sizes, *table.labels):
        if name in result:
            raise errors.refuse("coords" if name in table.labels else "dim", name, "a name that no quantity or axis has")
    missing = [name for name in variables or () if name not in result.names()]
    if missing:
        raise errors.refuse("variables", missing[0], "one of " + " ".join(result.names()))
    return result if variables is None else Fields({name: result[name] for wanted in variables for name in (wanted, *result[wanted].dims)}, result.attrs)


def fly_sweep(scene: Union[Scene, Path], table: _Table, variables: Optional[Sequence[str]], output_dir: Optional[Path], progress: Wanted,
              options: Mapping[str, Any], silent: str = NONE) -> xr.Dataset:
    """Flies the rows of a table. silent: pattern of notes that are no warnings."""
    if variables is not None and not isinstance(variables, (list, tuple)):
        raise errors.refuse("variables", variables, "a list of names, or None for everything")
    with Progress(progress) as shown_progress:
        rows = fly(scene, option_words(options), shown_progress, table=table.text(), output_dir=output_dir, silent=silent, keep=lambda row: _kept(row, table, variables))
    return _stack(rows, table)


@shown
def sweep(scene: Union[Scene, Path], parameters: Union[Mapping[str, ArrayLike], pd.DataFrame], *, dim: Optional[str] = None,
          coords: Union[Sequence[str], Mapping[str, ArrayLike]] = (), variables: Optional[Sequence[str]] = None,
          output_dir: Optional[Path] = None, progress: Wanted = None, **options: Unpack[SweepOptions]) -> xr.Dataset:
    """Simulates a scene for all combinations of values, or for the rows of a table.

    Args:
        scene: A Scene, or the path of an `.mci` file with one run.
        parameters: {name: values}, with names as `set` takes them: layer1.mua, boundary0.height, above.n, beam.angle, photons, seed. All
            combinations are simulated. With `dim` or `coords`, and always as a DataFrame, it is a table: one run for each row.
        dim: Name of the dimension of a table; None is "row". If a column has that name, its values are the axis.
        coords: Names of columns that are carried along and not set, or {name: values} of numbers or texts.
        variables: Names of the arrays to keep; None keeps all.
        output_dir: Folder in which the result of each row stays; with resume=True a stopped sweep goes on there.
        progress: As of `run`.
        **options: As of `run`. reweight=True takes rows that differ in mua alone from one flight, with A_z and A_rz by every eighth interaction.

    Returns:
        An xarray.Dataset with the results of all rows. The parameters are further dimensions, in front of the axes.

    Raises:
        InputError: A parameter, the scene or an option is refused.

    Examples:
        >>> sweep("scene.mci", {"layer1.mua": []})
        Traceback (most recent call last):
        ...
        clustermcml.errors.InputError: parameters['layer1.mua'] = [] (expected a list of at least one number)
    """
    return fly_sweep(scene, _table(parameters, dim, coords), variables, output_dir, progress, options)
