"""Reads `.h5` files.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

from typing import Any

import h5py
import xarray as xr

from . import errors


WHOLE = ("photons", "seed", "run")  # attributes that are whole numbers; the file has floating-point ones


def _plain(value: Any) -> Any:
    """A value as Python has it: numpy's scalars as numbers, its bytes as text."""
    value = value.item() if hasattr(value, "item") else value
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


def _attributes(item: Any) -> dict[str, Any]:
    return {name: _plain(item.attrs[name]) for name in ("units", "long_name", "ancillary_variables") if name in item.attrs}


def _variable(item: h5py.Dataset, name: str) -> xr.DataArray:
    """An array with its axes, which are the dimension scales; a scale is its own axis."""
    is_scale = item.attrs.get("CLASS") == b"DIMENSION_SCALE"
    dims = [name] if is_scale else [scales.keys()[0] for scales in item.dims]
    return xr.DataArray(item[()], dims=dims, attrs=_attributes(item))


def read_h5(path: str) -> xr.Dataset:
    """The Dataset of an `.h5` file: all its arrays, and as attributes those of the file and how the program was called."""
    try:
        with h5py.File(path, "r") as file:
            if "Rd" not in file:
                raise errors.InputError(f"{path}: not a result (expected the array Rd in it)")
            data = xr.Dataset({name: _variable(item, name) for name, item in file.items() if isinstance(item, h5py.Dataset)})
            attributes = {name: _plain(value) for name, value in file.attrs.items()}
            call = {"call_" + name: _plain(item[()]) for name, item in file["call"].items()} if "call" in file else {}
    except OSError as error:
        raise errors.InputError(f"{path}: not an .h5 file ({error})") from error
    attributes.update({name: int(attributes[name]) for name in WHOLE if name in attributes})
    data.attrs = {**attributes, **call}
    return data
