"""Results as Datasets, whatever the file.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import os
from typing import Union

import xarray as xr

from . import errors
from .h5 import read_h5
from .mco import read_mco


def read(path: Union[str, os.PathLike[str]]) -> xr.Dataset:
    """The result in a file, `.mco` (of this program or of original MCML) or `.h5`.

    Quantities have the names that `clustermcml help output` lists, their axes (r z alpha layer x y ...) as coordinates, and the
    attributes `units` and `long_name`; NAME_se is the standard error of NAME. Attributes of the Dataset say how it was flown.
    """
    name = errors.existing_file("path", path)
    readers = {".mco": read_mco, ".h5": read_h5}
    reader = readers.get(os.path.splitext(name)[1].lower())
    if reader is None:
        raise errors.refuse("path", os.fspath(path), "a name that ends in .mco or .h5")
    return reader(name)


def read_as(path: str) -> xr.Dataset:
    """The same by the name as it was typed, which messages then have: what is no `.h5` file is read as an `.mco` file."""
    return read_h5(path) if path.lower().endswith(".h5") else read_mco(path)
