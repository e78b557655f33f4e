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
    """Reads the result in a file.

    Args:
        path: Path of an `.h5`, or of an `.mco` of this program or of original MCML.

    Returns:
        An xarray.Dataset of the arrays in the file. NAME_se is the standard error of NAME. Coordinates are the axes (r, z, alpha, layer, x,
            y ...), and each array has the attributes `units` and `long_name`. Attributes of the Dataset say how it was simulated.

    Raises:
        InputError: The file is not a result, is cut off, or holds numbers that no result has.
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
