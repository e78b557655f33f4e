"""RGL's `.bsdf` files: tables of reflection that Mitsuba 3 and pbrt-v4 read as `measured` (Dupuy, Jakob, ACM Trans. Graph. 37, 274 (2018)).

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import struct
from typing import Any, Mapping, Optional

import numpy as np

from . import errors
from .command_line import write

HEAD = b"tensor_file\0\1\0"
KINDS = {"uint8": 1, "float32": 10}


def tensor_bytes(fields: Mapping[str, Any]) -> bytes:
    """Returns the bytes of a tensor file with named arrays, float32 or uint8, little-endian."""
    heads = [struct.pack("<H", len(name)) + name.encode() + struct.pack("<HB", array.ndim, KINDS[str(array.dtype)]) for name, array in fields.items()]
    offset = len(HEAD) + 4 + sum(len(head) + 8 + 8 * array.ndim for head, array in zip(heads, fields.values()))
    text, data = HEAD + struct.pack("<I", len(fields)), b""
    for head, array in zip(heads, fields.values()):
        text += head + struct.pack(f"<Q{array.ndim}Q", offset + len(data), *array.shape)
        data += np.ascontiguousarray(array, array.dtype.newbyteorder("<")).tobytes()
    return text + data


def write_bsdf(path: str, table: Any, theta_i: Any, description: str, wavelengths: Optional[Any]) -> None:
    """Writes a table of reflection as a .bsdf file. table: f cos theta_o [theta_i, channel, v, u], at least 0. theta_i: angles
    of incidence [rad], rising from 0. wavelengths: [nm], or None for r, g, b."""
    luminance = table.mean(axis=1)
    largest = luminance.max(axis=(1, 2), keepdims=True)
    luminance = np.maximum(luminance, np.where(largest > 0, 1e-6 * largest, 1.0))  # renderers sample by luminance: every direction must stay possible
    single = np.float32
    fields = {"theta_i": single(theta_i), "phi_i": np.zeros(1, single), "ndf": np.ones((2, 2), single), "sigma": np.full((2, 2), 0.25, single),
              "vndf": np.ones((1, len(theta_i), 2, 2), single), "luminance": single(luminance[None])}
    if wavelengths is None:
        fields["rgb"] = single(table[None])
    else:
        fields.update({"spectra": single(table[None]), "wavelengths": single(wavelengths)})
    fields.update({"description": np.frombuffer(description.encode(), np.uint8), "jacobian": np.ones(1, np.uint8)})
    write(path, tensor_bytes(fields))


def read_bsdf(path: str) -> dict[str, Any]:
    """Reads the arrays of a `.bsdf` file, a tensor file of Mitsuba and pbrt.

    Args:
        path: Path of the file.

    Returns:
        {name: array}.
    """
    name = errors.existing_file("path", path)
    with open(name, "rb") as file:
        content = file.read()
    try:
        if content[:len(HEAD)] != HEAD:
            raise ValueError("no tensor file")
        place, found = len(HEAD) + 4, {}
        for _ in range(struct.unpack_from("<I", content, len(HEAD))[0]):
            length = struct.unpack_from("<H", content, place)[0]
            key = content[place + 2:place + 2 + length].decode()
            axes, kind, offset = struct.unpack_from("<HBQ", content, place + 2 + length)
            shape = struct.unpack_from(f"<{axes}Q", content, place + 13 + length)
            dtype = {number: np.dtype(word).newbyteorder("<") for word, number in KINDS.items()}[kind]
            found[key] = np.frombuffer(content, dtype, int(np.prod(shape)), offset).reshape(shape)
            place += 13 + length + 8 * axes
        return found
    except (ValueError, KeyError, struct.error) as error:
        raise errors.unreadable(name, "a .bsdf file", error) from error
