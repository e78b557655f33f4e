"""Prints the content of an .h5 file as text: one object, attribute or row of values a line, numbers with all digits.

Two such texts can be compared although the HDF5 library may lay out both files differently."""
import sys

import h5py
import numpy


def plain(value, file):
    """Returns a value as plain Python. A reference becomes the name of its target, and an array becomes a list."""
    if isinstance(value, h5py.Reference):
        return file[value].name if value else None
    if isinstance(value, (numpy.ndarray, numpy.void, list, tuple)):
        return [plain(item, file) for item in value]
    return value.item() if isinstance(value, numpy.generic) else value


def attributes(name, item, file):
    return [f"{name} @{key} = {plain(item.attrs[key], file)!r}" for key in sorted(item.attrs)]


def dataset(name, item, file):
    yield (f"{name} {item.dtype.str} {item.shape} chunks {item.chunks} {item.compression} {item.compression_opts} "
           f"shuffle {item.shuffle} fill {plain(item.fillvalue, file)!r}")
    values = item[()]
    rows = values.reshape(-1, values.shape[-1]) if numpy.ndim(values) > 1 else numpy.ravel(values)
    for i, row in enumerate(rows):
        yield f"{name} {i}: {plain(row, file)!r}"


def lines_of(file):
    yield from attributes("/", file, file)
    names = []
    file.visit(names.append)
    for name in sorted(names):
        item = file[name]
        yield from dataset(name, item, file) if isinstance(item, h5py.Dataset) else [f"{name} is a group"]
        yield from attributes(name, item, file)


if __name__ == "__main__":
    with h5py.File(sys.argv[1], "r") as opened:
        sys.stdout.writelines(line + "\n" for line in lines_of(opened))
