"""Merges results of one scene that were flown with different seeds.

The parts of one run (`clustermcml run --part`) are joined by `clustermcml merge` instead, exactly to the last bit.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import os
import re
import warnings
from typing import TYPE_CHECKING, Any, Sequence, Union

import numpy as np

from . import errors
from .fields import MEASURED, OF_DETECTED, OF_THE_SCENE
from .results import read

if TYPE_CHECKING:
    import xarray as xr
    Result = Union[xr.Dataset, str, os.PathLike[str]]

OF_A_RUN = {"title", "photons", "seed", "run", "merged", "identity", "version", "source", "engine", "sampling", "roulette_below", "roulette_weight", "lost_indices", *MEASURED}  # attributes in which results may differ
DIGITS = 1e-5  # relative precision of the scene's numbers in an .mco
SUMS = ("lost", "residue")
STREAM = re.compile(r"seed (\d+), run (\d+)")


def _words(name: str, value: Any) -> list[str]:
    """Returns an attribute as lines for comparison. Folders of files, names of saved photons and the number of photons are left
    out, because they change no light. The input's first two lines are left out, too: names of outputs, and number of photons."""
    if not isinstance(value, str):
        return [f"{value:g}" if isinstance(value, float) else str(value)]
    lines = value.strip("\n").split("\n")[2 if name == "input" else 0:]
    return [line.split(" from ")[0] for line in lines if not line.startswith("photons")]


def _differ(name: str, what: str, value: object, first: str, expected: object) -> errors.InputError:
    return errors.InputError(f"{name}: {what} = {value} (expected {expected}, as in {first})")


def _check_alike(names: Sequence[str], data: Sequence[xr.Dataset]) -> None:
    """Refuses results whose scene, grid or options differ from those of the first."""
    first = data[0]
    for name, other in zip(names[1:], data[1:]):
        for key in (str(key) for key in first.attrs if key in other.attrs and key not in OF_A_RUN and not str(key).startswith("call_")):
            one, two = _words(key, first.attrs[key]), _words(key, other.attrs[key])
            if key == "boundaries" and len(one) != len(two):  # an .mco file lacks the lines of bodies
                one, two = ([line for line in lines if not line.startswith("body")] for lines in (one, two))
            if one != two:
                at = next((i for i, pair in enumerate(zip(one, two)) if pair[0] != pair[1]), min(len(one), len(two)))
                raise _differ(name, key, (two + ["nothing"])[at], names[0], (one + ["nothing"])[at])
        if ("A_z_se" in first) != ("A_z_se" in other):  # an .mco has zeros where --ignore-absorption was given; an .h5 leaves the arrays out
            raise _differ(name, "absorption by place", "on" if "A_z_se" in other else "off", names[0], "on" if "A_z_se" in first else "off")
        for key in (str(key) for key in first.variables if key in other.variables):
            mine, others = first[key], other[key]
            if mine.dims != others.dims or mine.shape != others.shape:
                raise _differ(name, f"shape of {key}", others.shape, names[0], mine.shape)
            apart = ~np.isclose(mine.values, others.values, rtol=DIGITS, atol=0, equal_nan=True).ravel() if key in first.coords or OF_THE_SCENE.fullmatch(key) else np.array([False])
            if apart.any():
                at = np.flatnonzero(apart)[0]
                raise _differ(name, f"{key}[{at}]", others.values.ravel()[at], names[0], mine.values.ravel()[at])


def _streams(name: str, data: xr.Dataset) -> list[tuple[int, int]]:
    """Returns the random numbers of a result as (seed, run) of each run in it."""
    said = data.attrs.get("merged", f"seed {data.attrs.get('seed')}, run {data.attrs.get('run')}")
    found = [(int(seed), int(run)) for seed, run in STREAM.findall(str(said))]
    if not found or "Rsp_se" not in data or "photons" not in data.attrs:
        raise errors.InputError(f"{name}: no seed or no standard errors (expected a result of clustermcml)")
    return found


def _check_seeds(names: Sequence[str], data: Sequence[xr.Dataset]) -> list[tuple[int, int]]:
    """Refuses two results with the same random numbers, because they hold the same packets."""
    owner: dict[tuple[int, int], str] = {}
    for name, result in zip(names, data):
        for stream in _streams(name, result):
            if stream in owner:
                raise errors.InputError(f"{name}: seed = {stream[0]}, run {stream[1]} (expected a seed that {owner[stream]} does not have)")
            owner[stream] = name
    return list(owner)


def _error(errors_: Any, values: Any, mean: Any, photons: Any) -> Any:
    """Returns the standard error of a mean over all packets. A result of one packet has no error, and is taken to scatter like
    the others. If all results have one packet, their spread gives the error."""
    known = photons > 1
    if not known.any():
        return np.sqrt(((values - mean) ** 2).sum(0) / (len(values) - 1) / len(values))
    weights = photons[known] / np.sqrt(photons.sum() * photons[known].sum())
    return np.sqrt(np.tensordot(weights**2, errors_[known] ** 2, 1))


def _mean_of_detected(light: Any, values: Any, errors_: Any) -> tuple[Any, Any]:
    """Returns the mean of a detector's means and its error, weighted by the light that each result has detected. Results
    without light do not count."""
    seen = light > 0
    if not seen.any():
        return np.full(values.shape[1:], np.nan), np.full(values.shape[1:], np.nan)
    weights = light[seen] / light[seen].sum()
    return np.tensordot(weights, values[seen], 1), np.sqrt(np.tensordot(weights**2, errors_[seen] ** 2, 1))


def _joined(data: Sequence[xr.Dataset], names: Sequence[str]) -> dict[str, Any]:
    """Returns the merged arrays, in double precision."""
    photons = np.array([float(result.attrs["photons"]) for result in data])
    stack = {name: np.stack([np.asarray(result[name].values, float) for result in data]) for name in names}
    joined: dict[str, Any] = {}
    for name in (name for name in names if not name.endswith("_se")):
        values, errors_, detected = stack[name], stack.get(name + "_se"), OF_DETECTED.fullmatch(name)
        if OF_THE_SCENE.fullmatch(name):
            joined[name] = values[0]
        elif name in SUMS:
            joined[name] = values.sum(0)
        elif detected and errors_ is not None and detected[1] in stack:
            joined[name], joined[name + "_se"] = _mean_of_detected(photons * stack[detected[1]], values, errors_)
        else:
            joined[name] = np.tensordot(photons / photons.sum(), values, 1)
            if errors_ is not None:
                joined[name + "_se"] = _error(errors_, values, joined[name], photons)
    return joined


def merge(results: Sequence[Result]) -> xr.Dataset:
    """Joins results of one scene that were simulated with different seeds.

    A value becomes the mean over all packets, sum(N x) / sum(N), and its error that of independent runs, sqrt(sum((N se)^2)) / sum(N). Means of
    what a detector has seen count by its light. `lost`, `residue` and the attribute `photons` are sums.

    Args:
        results: List of Datasets of `run` or `read`, or of paths of `.mco` and `.h5` files; two or more.

    Returns:
        An xarray.Dataset. Its attribute `merged` has the seeds. Arrays that not all results have are left out, with a warning.

    Raises:
        InputError: The results differ in scene, grid or options, or have equal seeds.
    """
    import xarray as xr
    if isinstance(results, (str, xr.Dataset)) or not isinstance(results, Sequence) or len(results) < 2:
        raise errors.refuse("results", results, "a list of two Datasets or paths, or more")
    data = [result if isinstance(result, xr.Dataset) else read(errors.existing_file(f"results[{i}]", result)) for i, result in enumerate(results)]
    names = [f"results[{i}]" if isinstance(result, xr.Dataset) else os.fspath(result) for i, result in enumerate(results)]
    streams = _check_seeds(names, data)
    _check_alike(names, data)
    common = [str(name) for name in data[0].data_vars if all(name in other for other in data)]
    left = sorted({str(name) for result in data for name in result.data_vars} - set(common))
    if left:
        warnings.warn(f"merge: left out what not all results have: {', '.join(left)}", stacklevel=2)
    arrays = {name: data[0][name].copy(data=values.astype(data[0][name].dtype)) for name, values in _joined(data, common).items()}
    attributes = {name: value for name, value in data[0].attrs.items() if all(name in other.attrs and np.array_equal(other.attrs[name], value) for other in data[1:])}
    for name in ("seed", "run", "identity", "lost_indices"):
        attributes.pop(name, None)
    attributes.update(photons=sum(int(result.attrs["photons"]) for result in data), merged="".join(f"seed {seed}, run {run}\n" for seed, run in streams))
    return xr.Dataset(arrays, coords=data[0].coords, attrs=attributes)
