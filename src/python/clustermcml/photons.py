"""Packets that have left, one by one: the `photons` lines of a scene, and the files that these write.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Optional, Union

import numpy as np

from . import errors
from .fields import Fields

if TYPE_CHECKING:
    import pandas as pd


@dataclass
class Saved:
    """Saves packets that leave, one by one, to NAME.photons.h5 beside the result. `read_photons` reads the file.

    Attributes:
        name: Name of the file, without folder and ending.
        detected: Whether only packets that a detector sees are saved; default False.
        limit: Most packets in the file, those with the smallest numbers, of several beams of each; None is a million.

    Examples:
        >>> Saved("exits", limit=1e5).line()
        'photons "exits" limit=100000'
    """

    name: str
    detected: bool = False
    limit: Optional[int] = None

    def __post_init__(self) -> None:
        if not errors.text("Saved.name", self.name) or any(sign in '/"' for sign in self.name):
            raise errors.refuse("Saved.name", self.name, "a name of a file, without a folder")
        errors.flag("Saved.detected", self.detected)
        if self.limit is not None:
            errors.whole("Saved.limit", self.limit, 1, 1_000_000_000)

    def line(self) -> str:
        words = ["photons", f'"{self.name}"'] + (["detected"] if self.detected else [])
        return " ".join(words + ([] if self.limit is None else [f"limit={int(self.limit)}"]))


def read_photons(path: Union[str, os.PathLike[str]]) -> pd.DataFrame:
    """Reads the packets in a file NAME.photons.h5 as a table, one row for each.

    Args:
        path: Path of the file.

    Returns:
        A pandas.DataFrame, whose index are the packets' numbers, for `trace`. Its columns are weight, x, y, z, ux, uy, uz, touches, deepest,
            time and side, with detectors detector, of merged files result, and by medium path_0, interactions_0, momentum_0, path_1 ...
            Media are 0 above, layers from 1, below, then bodies. `attrs` has the attributes of the file: divide sums by `covers`.

    Raises:
        InputError: The file is not a file of saved packets.
    """
    name = errors.existing_file("path", path)
    from .h5 import read_h5
    data = read_h5(name, "weight", "saved photons")
    try:
        return _table(data)
    except (KeyError, TypeError, ValueError) as error:  # a value is no number where a whole number should be
        raise errors.unreadable(name, "an .h5 file of saved photons", error) from error


def _table(data: Fields) -> pd.DataFrame:
    """Returns saved packets as a pandas.DataFrame, with a column for each medium of a property that media have."""
    import pandas as pd
    columns = {}
    for name in data.names():
        values = data[name]
        if len(values.dims) == 1:
            columns[name] = values.values
        else:
            columns.update({f"{name}_{medium}": values.values[:, medium] for medium in range(values.shape[1])})
    table = pd.DataFrame(columns, index=pd.Index(pd.Series(data["index"].values).astype(np.int64), name="index"))
    for name in ("touches", "side", "detector", "result", *(name for name in columns if name.startswith("interactions_"))):
        if name in table:
            table[name] = table[name].astype(np.int64)
    table.attrs.update(data.attrs)
    return table
