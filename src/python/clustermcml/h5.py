"""Reads `.h5` files, which may come from strangers.

The reader first checks type, shape and size of everything that it reads. It follows no link out of the file. It reads nothing
of variable length, because the HDF5 library trusts the lengths that stand in the file.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import functools
import math
import os
from typing import Any, Callable

import h5py

from . import errors
from .fields import WHOLE, Field, Fields

MOST_DEFLATED = 1032  # most bytes that deflate can make of one byte


def _need(holds: bool, what: str, expected: str) -> None:
    if not holds:
        raise ValueError(f"{what} (expected {expected})")


def _plain(value: Any) -> Any:
    """Returns a value as plain Python: scalars of numpy as numbers, bytes as text."""
    value = value.item() if hasattr(value, "item") else value
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


def _is_plain(kind: h5py.h5t.TypeID) -> bool:
    """True if values of this HDF5 type are numbers or texts of fixed length."""
    text = isinstance(kind, h5py.h5t.TypeStringID) and not kind.is_variable_str()
    return text or isinstance(kind, (h5py.h5t.TypeFloatID, h5py.h5t.TypeIntegerID))


def _sorted(iterate: Callable[..., None]) -> list[str]:
    """Returns the names that HDF5 iterates, sorted. Python sorts them, because HDF5 1.10 crashes when it sorts damaged names."""
    found: list[bytes] = []
    iterate(found.append, order=h5py.h5.ITER_NATIVE)
    return sorted(name.decode() for name in found)


class _File:
    """An HDF5 file that is read once. left: bytes of the file that no array or attribute has claimed yet."""

    def __init__(self, file: h5py.File, size: int) -> None:
        self.file, self.left = file, size

    def _take(self, what: str, size: int) -> None:
        _need(size <= self.left, f"{what} takes {size} bytes", f"at most {self.left}, which the file has left")
        self.left -= size

    def names(self, group: h5py.Group) -> list[str]:
        """Returns the names of a group's own members. Refuses links, which could lead into other files or a pipe."""
        names = _sorted(group.id.links.iterate)
        for name in names:
            _need(group.id.links.get_info(name.encode()).type == h5py.h5l.TYPE_HARD, f"{name} is a link", "none")
        return names

    def attribute(self, item: h5py.HLObject, name: str) -> Any:
        held = h5py.h5a.open(item.id, name.encode())
        _need(held.shape == () and _is_plain(held.get_type()), f"attribute {name} is an array or of a strange type",
              "a number or a text of fixed length")
        self._take("attribute " + name, held.get_storage_size())
        return _plain(item.attrs[name])

    def attributes(self, item: h5py.Dataset) -> dict[str, Any]:
        return {name: self.attribute(item, name) for name in ("units", "long_name", "ancillary_variables") if name in item.attrs}

    def values(self, item: h5py.Dataset, name: str) -> Any:
        """Reads an array. Refuses it unless its bytes stand in this file, or deflate can make them from bytes in this file."""
        plan = item.id.get_create_plist()
        filters = [plan.get_filter(i)[0] for i in range(plan.get_nfilters())]
        known = {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE}
        _need(not item.is_virtual and not item.external, f"{name} lies in other files", "its values in this one")
        _need(len(filters) == len(set(filters) & known), f"{name} has the filters {filters}", "deflate and shuffle at most")
        _need(item.shape is not None and _is_plain(item.id.get_type()), f"{name} is of a strange type", "numbers, or texts of fixed length")
        _need(all(part <= whole for part, whole in zip(item.chunks or (), item.shape)), f"{name} has chunks of {item.chunks}",
              f"at most its shape {item.shape}")
        stored = item.id.get_storage_size()
        self._take(name, stored)
        size, most = math.prod(item.shape) * item.id.get_type().get_size(), stored * (MOST_DEFLATED if filters else 1)
        _need(size <= most, f"{name} promises {size} bytes", f"at most {most}, as {stored} are stored")
        chunks = math.prod(-(-whole // part) for part, whole in zip(item.chunks or (), item.shape))
        _need(not item.chunks or item.id.get_num_chunks() == chunks, f"{name} lacks chunks", f"{chunks} of them: no values are made up")
        return item[()]

    def scaled(self, scale: h5py.Dataset) -> list[tuple[int, int]]:
        """Returns the arrays whose axis is this scale: the address of each array, and which of its dimensions."""
        if "REFERENCE_LIST" not in scale.attrs:
            return []
        held = h5py.h5a.open(scale.id, b"REFERENCE_LIST")
        kind = held.dtype
        _need(len(held.shape) == 1 and kind.names == ("dataset", "dimension") and kind["dimension"].kind == "i"
              and h5py.check_ref_dtype(kind["dataset"]) is h5py.Reference, "attribute REFERENCE_LIST is of a strange type", "references")
        self._take("attribute REFERENCE_LIST", held.get_storage_size())
        return [(h5py.h5o.get_info(h5py.h5r.dereference(reference, self.file.id)).addr, int(dimension))
                for reference, dimension in scale.attrs["REFERENCE_LIST"] if reference]

    def fields(self, needed: str) -> Fields:
        file, names = self.file, self.names(self.file)
        _need(needed in names, "another kind of file", f"the array {needed} in it")
        items = {name: item for name, item in ((name, file[name]) for name in names) if isinstance(item, h5py.Dataset)}
        scales = [name for name, item in items.items() if "CLASS" in item.attrs and self.attribute(item, "CLASS") == "DIMENSION_SCALE"]
        axes = {place: name for name in scales for place in self.scaled(items[name])}
        data = {}
        for name, item in items.items():
            values, address = self.values(item, name), h5py.h5o.get_info(item.id).addr
            dims = [name] if name in scales else [axes.get((address, i), "") for i in range(values.ndim)]
            _need(all(dims), f"{name} has an axis without a name", "dimension scales")
            data[name] = Field(values, tuple(dims), self.attributes(item))
        attributes = {name: self.attribute(file, name) for name in _sorted(functools.partial(h5py.h5a.iterate, file.id))}
        _need(attributes.get("photons", 1) >= 1, f"photons = {attributes.get('photons')}", "1 at least")
        attributes.update({name: int(attributes[name]) for name in WHOLE if name in attributes})
        if "call" in names:
            attributes.update({"call_" + name: _plain(self.values(file["call"][name], name)) for name in self.names(file["call"])})
        return Fields(data, attributes)


def read_h5(path: str, needed: str = "Rd", what: str = "a result") -> Fields:
    """Reads all arrays of an `.h5` file, its attributes, and the call of the program. needed: the array that shows of which kind the file is, `what`."""
    try:
        with h5py.File(path, "r", locking=False) as file:
            return _File(file, os.path.getsize(path)).fields(needed)
    except Exception as error:  # any: h5py and HDF5 raise many kinds of exceptions for damaged bytes
        raise errors.unreadable(path, f"an .h5 file of {what}", error) from error
