"""Arrays with named axes, as readers make them: as little of xarray.Dataset as pictures and comparisons need, for xarray takes longer to
import than a picture to draw.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

OF_THE_SCENE = re.compile(r"layer_\w+|body_(n|mua|mus|g|of_facet)|(boundary\d+|body)_area")  # arrays that belong to the scene and are equal in all results
WHOLE = ("photons", "seed", "run", "covers", "found", "limit")  # attributes that are whole numbers, which a file stores as floating-point numbers
MEASURED = ("seconds", "cpu_s", "steps", "photons_per_s", "threads", "ranks")  # keys of --json that become attributes
OF_DETECTED = re.compile(r"(detector_\w+)_(path|interactions|momentum|deepest)")  # means over the packets that a detector has seen


@dataclass
class Field:
    """An array with named axes. axes: a Field for each of its dims."""

    values: Any
    dims: tuple[str, ...] = ()
    attrs: dict[str, Any] = field(default_factory=dict)
    name: str = ""
    axes: dict[str, Field] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.values = np.asarray(self.values)

    def __float__(self) -> float:
        return float(self.values)

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(self.values.shape)

    @property
    def size(self) -> int:
        return int(self.values.size)

    def times(self, factor: Any) -> Field:
        """Returns the field times a number, or times numbers along its last axis."""
        return replace(self, values=self.values * factor)

    def turned(self) -> Field:
        """Returns the field with its axes in reverse order."""
        return replace(self, values=self.values.T, dims=self.dims[::-1])

    def part(self, dim: str, which: Union[int, slice]) -> Field:
        """Returns the field at one place of an axis, or over a range of it.

        >>> r = Field([0.5, 1.5, 2.5], ("r",), name="r")
        >>> Field([7, 8, 9], ("r",), axes={"r": r}).part("r", slice(1, None)).axes["r"].values.tolist()
        [1.5, 2.5]
        """
        at, axes = self.dims.index(dim), dict(self.axes)
        values, axis = self.values[(slice(None),) * at + (which,)], axes.pop(dim)
        if isinstance(which, slice):
            return replace(self, values=values, axes={**axes, dim: replace(axis, values=axis.values[which])})
        return replace(self, values=values, dims=self.dims[:at] + self.dims[at + 1:], axes=axes)

    def nearest(self, dim: str, place: float) -> Field:
        """Returns the field in the bin whose middle is nearest to `place`. If two are as near, the later one counts."""
        distance = abs(self.axes[dim].values - place)
        return self.part(dim, int(np.flatnonzero(distance == distance.min())[-1]))


class Fields:
    """All arrays of a file by name, axes included, and the attributes of the run. Refuses arrays whose sizes differ from those
    of their axes."""

    def __init__(self, held: dict[str, Field], attrs: dict[str, Any]) -> None:
        self.attrs, self.held = attrs, held
        used = {dim for one in held.values() for dim in one.dims}
        for name, one in held.items():
            one.name = name
            bad = name in used and one.dims != (name,) or len(set(one.dims)) < len(one.dims)
            if bad or [held[dim].size for dim in one.dims] != list(one.shape):
                raise ValueError(f"{name} has the sizes {list(one.shape)} (expected those of its axes {' '.join(one.dims)})")
            one.axes = {dim: held[dim] for dim in one.dims}

    def __contains__(self, name: str) -> bool:
        return name in self.held

    def __getitem__(self, name: str) -> Field:
        return self.held[name]

    def get(self, name: str) -> Optional[Field]:
        return self.held.get(name)

    def names(self) -> list[str]:
        """Returns the names of all arrays except axes."""
        return [name for name, one in self.held.items() if one.dims != (name,)]

    def dataset(self) -> xr.Dataset:
        """Returns all arrays as an xarray.Dataset."""
        import xarray as xr
        return xr.Dataset({name: xr.DataArray(one.values, dims=one.dims, attrs=one.attrs) for name, one in self.held.items()}, attrs=self.attrs)


def spread_over_mua(result: Fields, name: str) -> Field:
    """Returns absorption divided by mua of the layer in which a bin lies. NaN in bins that several media share, and where nothing absorbs."""
    array = result[name]
    z, layers = array.axes["z"].values, result["layer_mua"].values
    edges = np.concatenate(([0.0], np.cumsum(result["layer_d"].values)))
    low, high = z - z[0], z + z[0]
    mua = layers[np.clip(np.searchsorted(edges, z, side="right") - 1, 0, layers.size - 1)]
    shapes = [(float(a), float(b)) for of in ("boundary", "body") if f"{of}_z_min" in result
              for a, b in zip(result[f"{of}_z_min"].values, result[f"{of}_z_max"].values) if a < b]
    mixed = low > edges[-1]
    for top, bottom in [(edge, edge) for edge in edges[1:-1]] + shapes:
        mixed |= (low < bottom - 1e-9) & (high > top + 1e-9)
    with np.errstate(divide="ignore", invalid="ignore"):
        return array.times(np.where(mixed | (mua == 0), np.nan, 1 / mua))
