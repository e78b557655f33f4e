"""Reads results of any file as Datasets.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Union

from . import errors
from .fields import Fields
from .mco import read_mco

if TYPE_CHECKING:
    import xarray as xr


def read(path: Union[str, os.PathLike[str]]) -> xr.Dataset:
    """The result in a file, `.mco` (of this program or of original MCML) or `.h5`.

    Quantities have the names that `clustermcml help output` lists, their axes (r z alpha layer x y ...) as coordinates, and the
    attributes `units` and `long_name`; NAME_se is the standard error of NAME. Attributes of the Dataset say how it was flown.
    """
    name = errors.existing_file("path", path)
    if os.path.splitext(name)[1].lower() not in (".mco", ".h5"):
        raise errors.refuse("path", os.fspath(path), "a name that ends in .mco or .h5")
    return read_as(name).dataset()


def read_as(path: str) -> Fields:
    """Reads a result by the name as it was typed, which messages then show. Any file that is no `.h5` is read as an `.mco`."""
    if not path.lower().endswith(".h5"):
        return read_mco(path)
    from .h5 import read_h5
    return read_h5(path)
