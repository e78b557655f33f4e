"""Channels of a material: wavelengths, or r, g and b, and the numbers that are set in each channel.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import csv
from typing import Any

import numpy as np

from . import errors
from .command_line import shown_path
from .mco import NUMERAL


class OfChannels:
    """A result. Its arrays stand in `data`, an xarray.Dataset, and are attributes. They may have an axis of channels."""

    data: Any

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "data":
            raise AttributeError(name)
        return getattr(self.data, name)

    def __getitem__(self, name: str) -> Any:
        return self.data[name]

    def __repr__(self) -> str:
        return f"{type(self).__name__} of {self.data!r}"

    def channels(self) -> list[Any]:
        """Returns the labels of the channels: wavelengths [nm], or r, g, b; an empty list of a result without channels."""
        return list(self.data["channel"].values.tolist()) if "channel" in self.data.dims else []

    def _each(self, name: str) -> Any:
        """Returns an array with the axis of channels first, also of a result without channels."""
        values = self.data[name].values
        return values if self.channels() else values[None]


def channel_rows(channels: Any) -> tuple[list[Any], list[dict[str, float]]]:
    """Returns the labels of the channels, and the numbers set in each. Labels stand in the column nm (wavelengths) or channel
    (r, g and b).

    >>> channel_rows({"channel": ["r", "g", "b"], "layer1.mua": [1, 2, 3]})[1][0]
    {'layer1.mua': 1.0}
    """
    if channels is None:
        return [], [{}]
    try:
        columns = {str(name): list(channels[name]) for name in channels}
    except TypeError:
        raise errors.refuse("channels", channels, "a dict of columns or a DataFrame") from None
    label = next((name for name in ("nm", "channel") if name in columns), "")
    labels = columns.pop(label, [])
    if not labels or not columns or any(len(values) != len(labels) for values in columns.values()):
        raise errors.refuse("channels", channels, "a column nm, or a column channel with r, g and b, and columns of the same length for what is set: layer1.mua ...")
    if label == "nm":
        labels = [errors.number("channels['nm']", value, 1, 1e7, "wavelengths [nm]") for value in labels]
        if len(labels) < 2 or (np.diff(labels) <= 0).any():
            raise errors.refuse("channels['nm']", labels, "at least two rising wavelengths [nm]")
    elif labels != ["r", "g", "b"]:
        raise errors.refuse("channels['channel']", labels, "['r', 'g', 'b']")
    numbers = {name: [errors.finite(f"channels[{name!r}]", value) for value in values] for name, values in columns.items()}
    for name in numbers:
        if name in ("photons", "seed") or name.startswith(("beam", "detector")):
            raise errors.refuse("channels", name, "numbers of the material")
    return labels, [{name: values[i] for name, values in numbers.items()} for i in range(len(labels))]


def channel_table(word: str) -> dict[str, Any]:
    """Returns the columns of the table that --label NAME=TABLE.csv names."""
    label, _, path = word.partition("=")
    name = errors.existing_file("--label", path, "NAME=TABLE.csv, NAME a column nm, or channel with r, g and b")
    try:
        with open(name, encoding="utf-8-sig", newline="") as file:
            rows = [[cell.strip() for cell in row] for row in csv.reader((line.partition("#")[0] for line in file), strict=True) if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise errors.unreadable(shown_path(path), "a table", error) from error
    if len(rows) < 2 or label not in rows[0] or len(set(rows[0])) < len(rows[0]):
        raise errors.InputError(f"{shown_path(path)}: no table with a column {label} (expected a first line of names, then numbers)")
    for number, row in enumerate(rows[1:], 1):
        if len(row) != len(rows[0]) or not all(NUMERAL.fullmatch(cell) for column, cell in zip(rows[0], row) if column != "channel"):
            raise errors.InputError(f"{shown_path(path)}: row {number} = {','.join(row)} (expected {len(rows[0])} numbers)")
    columns = {column: [row[i] if column == "channel" else float(row[i]) for row in rows[1:]] for i, column in enumerate(rows[0])}
    return {("nm" if column == label and label != "channel" else column): values for column, values in columns.items()}
