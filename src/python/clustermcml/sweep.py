"""Sweeps: a scene flown for all combinations of some values.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import csv
import itertools
import math
import os
import tempfile
import warnings
from typing import Any, Mapping, Optional, Sequence, Union

import numpy as np
import xarray as xr

from . import errors
from .program import fly, option_words, result_of, scene_file
from .scene import Scene


def _checked(parameters: Mapping[str, Sequence[float]]) -> dict[str, list[float]]:
    """The values as lists of numbers, each list without doubles."""
    if not isinstance(parameters, Mapping) or not parameters:
        raise errors.refuse("parameters", parameters, 'a dict of names and lists of values, {"layer1.mua": [0.1, 0.2]}')
    checked = {}
    for name, values in parameters.items():
        expected = "a list of at least one number"
        numbers = errors.array(f"parameters[{name!r}]", values, "iuf", expected)
        if numbers.ndim != 1 or not numbers.size:
            raise errors.refuse(f"parameters[{name!r}]", values, expected)
        checked[name] = [float(value) for value in numbers]
        if len(set(checked[name])) < len(checked[name]):
            raise errors.refuse(f"parameters[{name!r}]", values, "values that differ")
    return checked


def _write_table(path: str, parameters: Mapping[str, Sequence[float]]) -> None:
    """A row for each combination, the last name running first."""
    with open(path, "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(parameters)
        table.writerows([[repr(value) for value in row] for row in itertools.product(*parameters.values())])


def _common(rows: Sequence[xr.Dataset]) -> tuple[list[str], list[str]]:
    """Names of the arrays that all rows have in one size, and of the others: a surface may be a plane in some rows."""
    names = list(dict.fromkeys(str(name) for row in rows for name in row.data_vars))
    sizes = [{name: row[name].shape for name in row.data_vars} for row in rows]
    everywhere = [name for name in names if all(size.get(name) == sizes[0].get(name, ()) for size in sizes)]
    return everywhere, [name for name in names if name not in everywhere]


def _stack(rows: Sequence[xr.Dataset], parameters: Mapping[str, Sequence[float]]) -> xr.Dataset:
    """The rows' arrays along the parameters, in front of their own axes."""
    shape, dims = [len(values) for values in parameters.values()], list(parameters)
    stacked = xr.Dataset(attrs={key: value for key, value in rows[0].attrs.items() if all(row.attrs.get(key) == value for row in rows)})
    everywhere, elsewhere = _common(rows)
    if elsewhere:
        warnings.warn(" ".join(elsewhere) + ": left out, as not all rows have them with as many facets", stacklevel=3)
    for name in everywhere:
        first = rows[0][name]
        values = np.stack([row[name].values for row in rows])
        stacked[name] = xr.DataArray(values.reshape(shape + list(first.shape)), dims=dims + list(first.dims), attrs=first.attrs)
    own = {name: axis for name, axis in rows[0].coords.items() if name in stacked.dims}
    return stacked.assign_coords({**own, **{name: list(values) for name, values in parameters.items()}})


def sweep(scene: Union[Scene, str, os.PathLike[str]], parameters: Mapping[str, Sequence[float]], *,
          variables: Optional[Sequence[str]] = None, output_dir: Union[None, str, os.PathLike[str]] = None,
          progress: Optional[bool] = None, **options: Any) -> xr.Dataset:
    """Flies a scene for all combinations of values, and returns one Dataset with the parameters as further dimensions, first.

    parameters: {name: values}, names as `--set` takes them: layer1.mua, boundary0.height, above.n, beam.angle, photons, seed.
    variables: names of what is kept, None for everything. Meshes are built once for all rows that leave them as they are. All else
    is as for `run`; with output_dir each row's result stays there, and resume=True goes on where an interrupt has stopped.

    >>> sweep("scene.mci", {"layer1.mua": []})
    Traceback (most recent call last):
    ...
    clustermcml.errors.InputError: parameters['layer1.mua'] = [] (expected a list of at least one number)
    """
    checked = _checked(parameters)
    if variables is not None and not isinstance(variables, (list, tuple)):
        raise errors.refuse("variables", variables, "a list of names, or None for everything")
    with tempfile.TemporaryDirectory(prefix="clustermcml_") as scratch:
        folder = errors.folder("output_dir", scratch if output_dir is None else output_dir)
        table = os.path.join(scratch, "sweep.csv")
        _write_table(table, checked)
        words = ["--sweep", table, *option_words(options)]
        rows = []
        with scene_file(scene, folder) as path:
            for one in sorted(fly(path, folder, words, progress, scratch, math.prod(map(len, checked.values()))), key=lambda one: int(one["row"])):
                result = result_of(one)
                missing = [name for name in variables or () if name not in result]
                if missing:
                    raise errors.refuse("variables", missing[0], "one of " + " ".join(map(str, result.data_vars)))
                rows.append(result if variables is None else result[list(variables)])
    return _stack(rows, checked)
