"""Reads `.mco` files of this program and of original MCML.

A file of this program holds MCML's arrays with their errors, and the weight balance. All other results of its run are read from
the `.h5` file beside it.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import math
import os
import re
import sys
import warnings
from typing import Any, Iterator, NamedTuple

import numpy as np

from . import errors
from .fields import Field, Fields

TOTALS = ("Rsp", "Rd", "A", "Tt")
WHOLE = ("A_l", "A_z", "Rd_r", "Rd_a", "Tt_r", "Tt_a", "A_rz", "Rd_ra", "Tt_ra")  # arrays that every file has after its totals
NUMERAL = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
END = "   Last line: # end"  # mark, after the time, that the file ends with this line; files of original MCML and of older versions have none
BESIDE = "\n# more of this run stands in the .h5 file beside this one"
BOOKS = {
    "launched": "launched", "gained": "gained in roulette", "specular": "specular (Rsp)", "reflected": "reflected (Rd)",
    "transmitted": "transmitted (Tt)", "absorbed": "absorbed (A)", "roulette": "lost in roulette", "trapped": "trapped", "lost": "lost",
    "overflow_r": "scored in the last r bin from beyond it", "overflow_z": "absorbed below the last z bin",
    "above": "absorbed above z = 0",
}

# unit of an array by its axes: arrays over r, z and angle are densities
UNITS = {(): "1", ("layer",): "1", ("z",): "1/cm", ("r",): "1/cm2", ("alpha",): "sr-1", ("r", "z"): "1/cm3", ("r", "alpha"): "1/(cm2 sr)"}

# name: axes, meaning; the .h5 files use the same words
QUANTITIES = {
    "Rsp": ((), "specular reflectance"),
    "Rd": ((), "diffuse reflectance"),
    "A": ((), "absorbed fraction"),
    "Tt": ((), "transmittance"),
    "A_l": (("layer",), "absorption by layer"),
    "A_z": (("z",), "absorption by depth; what lies outside is in the outermost bins"),
    "Rd_r": (("r",), "diffuse reflectance by radius; the last bin holds what lies beyond"),
    "Rd_a": (("alpha",), "diffuse reflectance by angle"),
    "Tt_r": (("r",), "transmittance by radius; the last bin holds what lies beyond"),
    "Tt_a": (("alpha",), "transmittance by angle"),
    "A_rz": (("r", "z"), "absorption by radius and depth"),
    "Rd_ra": (("r", "alpha"), "diffuse reflectance by radius and angle"),
    "Tt_ra": (("r", "alpha"), "transmittance by radius and angle"),
}
QUANTITIES.update({"book_" + name: ((), meaning) for name, meaning in BOOKS.items()})
QUANTITIES["residue"] = ((), "launched + gained - all fates, in 2^-31 packets")
QUANTITIES["lost"] = ((), "packets lost to numerical failure")
LAYER_QUANTITIES = {
    "n": ("1", "refractive index"),
    "mua": ("1/cm", "absorption coefficient"),
    "mus": ("1/cm", "scattering coefficient"),
    "g": ("1", "anisotropy of scattering"),
    "d": ("cm", "thickness"),
}
AXES = {
    "r": ("cm", "distance from the z axis, middle of the bin"),
    "z": ("cm", "depth, middle of the bin"),
    "alpha": ("rad", "angle from the outward vertical, middle of the bin"),
    "layer": ("1", "layer, from 1"),
}


def _lines(text: str) -> Iterator[tuple[int, str, list[str]]]:
    """Yields number, section and words of each line that has words. Lines with a section's name are left out.

    If two sections have the same name, the first counts. A comment begins at a # that begins a word. The first line of InParm,
    the name of the output, is one word. All other words are ASCII."""
    plain = re.sub(r"[^\x00-\x1b -\x7f]", "?", re.sub(r"#(?<!\S#).*", "", text))
    key, seen, named = "", {""}, False
    for number, (line, own) in enumerate(zip(plain.split("\n"), text.split("\n")), 1):
        words = line.split()
        if words and key == "InParm" and not named:
            named, words = True, [re.sub(r"(?<!\s)\s+[A-Za-z]\s*(#.*)?$", "", own)]
        elif words and words[0][0].isalpha() and re.fullmatch(r"\w+", words[0]) and words[0].lower() not in ("nan", "inf", "infinity"):
            key = "" if words[0] in seen else words[0]
            seen.add(key)
            words = []
        elif not words:
            continue
        yield number, key, words


class _Kind(NamedTuple):
    """The range of a number in InParm."""

    expected: str
    least: float
    most: float
    word: re.Pattern[str] = NUMERAL

    def fits(self, word: str) -> bool:
        return bool(self.word.fullmatch(word)) and self.least <= float(word) <= self.most and ("whole" not in self.expected or float(word) % 1 == 0)


POSITIVE = _Kind("a number above 0", math.ulp(0.0), sys.float_info.max)
NOT_NEGATIVE = _Kind("a number of 0 or more", 0, sys.float_info.max)
PHOTONS = _Kind("a whole number above 0, at most 2^53", 1, 2**53)
LAYER = {"n": POSITIVE, "mua": NOT_NEGATIVE, "mus": NOT_NEGATIVE, "g": _Kind("a number from -1 to 1", -1, 1), "d": NOT_NEGATIVE}


class _File:
    """The words of a file by section. Refuses impossible numbers by file and line, as the program does."""

    def __init__(self, path: str, text: str) -> None:
        self.path, self.text = path, text
        self.sections: dict[str, list[str]] = {}
        parameters = []
        for number, key, words in _lines(text):
            self.sections.setdefault(key, []).extend(words)
            if key == "InParm" and words:
                parameters.append((number, words))
        self.parameters = iter(parameters)

    def fields(self, **kinds: _Kind) -> list[float]:
        """Reads the numbers of the next line of InParm. Text after them is a comment, but one more number is a mistake."""
        number, words = next(self.parameters, (0, []))
        where = f"{self.path}:{number}" if number else self.path
        for i, (name, kind) in enumerate(kinds.items()):
            word = words[i] if i < len(words) else "nothing"
            if not kind.fits(word):
                raise errors.refuse(f"{where}: {name.replace('_', ' ')}", word, kind.expected)
        if len(words) > len(kinds) and NUMERAL.fullmatch(words[len(kinds)]):
            raise errors.refuse(f"{where}: number too many", words[len(kinds)], "the end of the line")
        return [float(word) for word in words[:len(kinds)]]

    def wrong(self, key: str, index: int, expected: str) -> errors.InputError:
        """Returns the exception for a bad number of a section, or for whatever stands in its place."""
        left, inside = index, False
        for number, of, words in _lines(self.text):
            if of == key and left < len(words) or inside and of != key:
                return errors.refuse(f"{self.path}:{number}: {key}[{index}]", words[left] if of == key else of or "nothing", expected)
            inside |= of == key
            left -= len(words) if of == key else 0
        return errors.refuse(f"{self.path}: {key}[{index}]", "nothing", expected)

    def numbers(self, key: str, count: int, none: bool = False, more: bool = False) -> Any:
        """Reads the numbers of a section, which must be `count`, or at least `count` with more=True. none: NaN is allowed."""
        words = self.sections.get(key, [])
        values = np.array([float(word) if NUMERAL.fullmatch(word) else np.nan if none and word.lower() == "nan" else np.inf for word in words[:count]])
        bad = np.flatnonzero(np.isinf(values))
        if len(bad) or len(values) < count:
            raise self.wrong(key, int(bad[0]) if len(bad) else len(values), f"a number, one of {count}")
        if len(words) > count and not more:
            raise self.wrong(key, count, f"the end of {count} number{'s' * (count > 1)}")
        return values


def _middles(bins: int, width: float) -> Any:
    return (np.arange(bins) + 0.5) * width


def _grid(file: _File) -> tuple[dict[str, Any], list[list[float]], float, float]:
    """Reads the lines of InParm that original MCML writes: dz dr, nz nr na, number of layers, n above, five numbers per layer,
    n below.

    Returns axes, layers, and n above and below. Numbers of bins and layers are limited by the size of the file: each needs a
    digit and a blank."""
    most = len(file.text) // 2
    count = _Kind(f"a whole number from 1 to {most}, which the file can hold", 1, most, re.compile("[+-]?[0-9]+"))
    dz, dr = file.fields(dz=POSITIVE, dr=POSITIVE)
    nz, nr, na = map(int, file.fields(nz=count, nr=count, na=count))
    (layers,) = map(int, file.fields(number_of_layers=count))
    (above,) = file.fields(n_above=POSITIVE)
    media = [file.fields(**LAYER) for _ in range(layers)]
    (below,) = file.fields(n_below=POSITIVE)
    axes = {"r": _middles(nr, dr), "z": _middles(nz, dz), "alpha": _middles(na, np.pi / 2 / na), "layer": np.arange(1.0, layers + 1)}
    return axes, media, above, below


def _provenance(text: str) -> dict[str, Any]:
    """Reads the comment lines after the arrays: version, engine, seed. Empty for a file of original MCML. Merged results have
    several seeds."""
    version = re.search(r"^# clustermcml (.*)", text, re.MULTILINE)
    if not version:
        return {}
    known: dict[str, Any] = {"version": version[1]}
    flown = re.search(r"^# engine (\w+), seed (\d+), run (\d+)", text, re.MULTILINE)
    if flown:
        known.update(engine=flown[1], seed=int(flown[2]), run=int(flown[3]))
    merged = re.findall(r"^# (merged .*\n)", text, re.MULTILINE)
    if merged:
        known["merged"] = "".join(merged)
    sampling = re.search(r"^# sampling (\w+)", text, re.MULTILINE)
    if sampling:
        known["sampling"] = sampling[1]
    return known


def _variable(name: str, axes: dict[str, Any], values: Any) -> Field:
    """Returns the Field of a quantity, or of its standard error NAME_se."""
    dims, meaning = QUANTITIES[name.removesuffix("_se")]
    long_name = "standard error" if name.endswith("_se") else meaning
    return Field(np.reshape(values, [axes[dim].size for dim in dims]), dims, {"units": UNITS[dims], "long_name": long_name})


def _numbers(file: _File, axes: dict[str, Any]) -> dict[str, Field]:
    """Reads all quantities of the file and their errors. Section `lost` also lists indices of packets, which are skipped."""
    def of(name: str, key: str) -> Any:
        return file.numbers(key, math.prod(axes[dim].size for dim in QUANTITIES[name][0]), key != name)
    sections = file.sections
    several = {"RAT": TOTALS, "se_RAT": [name + "_se" for name in TOTALS], "books": ["book_" + name for name in BOOKS], "lost": ["lost"]}
    numbers = dict(zip(TOTALS, file.numbers("RAT", len(TOTALS))))
    numbers.update({name: of(name, name) for name in WHOLE})
    numbers.update({name + "_se": of(name, "se_" + name) for name in WHOLE if "se_" + name in sections})
    if "residue" in sections:
        numbers["residue"] = of("residue", "residue")
    for key, names in several.items():
        if key in sections:
            numbers.update(zip(names, file.numbers(key, len(names), key == "se_RAT", key == "lost")))
    variables = {name: _variable(name, axes, values) for name, values in numbers.items()}
    for name, variable in variables.items():
        if name + "_se" in variables:
            variable.attrs["ancillary_variables"] = name + "_se"
    return variables


def _note_older(path: str, file: _File) -> None:
    """Warns of sections that version 0.1 wrote into an .mco, and that only an .h5 holds since."""
    version = re.search(r"^# clustermcml (0\.1\.[0-9]+)", file.text, re.MULTILINE)
    known = {"", "A1", "InParm", "RAT", "se_RAT", "lattice", "time", "books", *QUANTITIES, *("se_" + name for name in WHOLE)}
    older = [name for name in file.sections if name not in known and not name.startswith(("se_", "heightfield"))]
    if version and older:
        warnings.warn(f"{path}: {', '.join(older)} of version {version[1]} were not read: the .h5 of that run has them, if it wrote one", stacklevel=5)


def _with_fields(path: str, text: str, own: Fields) -> Fields:
    """Returns the result together with arrays that only the .h5 file beside it has, if both are of the same run. Otherwise the
    attribute `lacks` names the missing file."""
    if BESIDE not in text:
        return own
    from .h5 import read_h5
    name = re.sub(r"\.mco$", "", path, flags=re.IGNORECASE) + ".h5"
    identity = re.search(r" Identity: (\w+)", text[:1000])
    more = read_h5(name) if identity and os.path.isfile(name) else None
    if more is None or identity is None or more.attrs.get("identity") != identity[1]:
        warnings.warn(f"{path}: {name} is missing or of another run: only what original MCML's file holds was read", stacklevel=4)
        return Fields(own.held, {**own.attrs, "lacks": name})
    return Fields({**own.held, **{key: one for key, one in more.held.items() if key not in own}}, {**more.attrs, **own.attrs})


def read_mco(path: str) -> Fields:
    """Reads an `.mco` file. Names, axes and units are those of an `.h5` file."""
    try:
        with open(path, encoding="utf-8-sig", errors="replace", newline="") as stream:
            text = stream.read().replace("\r\n", "\n")  # a lone CR ends no line
        if not text.startswith("A1"):
            raise errors.InputError(f"{path}: not an .mco file (expected A1 at its beginning)")
        if "\0" in text:
            raise errors.InputError(f"{path}: it holds a NUL byte (expected a text file)")
        _, end, behind = text.partition("\n# end\n")
        if END in text[:1000] and not end:
            raise errors.InputError(f"{path}: last line is missing (expected # end; the file is cut off)")
        if END in text[:1000] and behind.strip(" \t\n"):
            raise errors.InputError(f"{path}: text behind # end (expected one result)")
        file = _File(path, text)
        own = _dataset(text, file)
    except errors.InputError:
        raise
    except Exception as error:  # any: Python and its libraries raise many kinds of exceptions for damaged words
        raise errors.unreadable(path, "a whole .mco file", error) from error
    _note_older(path, file)
    return _with_fields(path, text, own)


def _dataset(text: str, file: _File) -> Fields:
    _, (title,) = next(file.parameters, (0, [""]))
    (photons,) = file.fields(photons=PHOTONS)
    axes, media, above, below = _grid(file)
    data = _numbers(file, axes)  # the Dataset is made last, because adding a variable to one copies it
    for index, (name, (unit, meaning)) in enumerate(LAYER_QUANTITIES.items()):
        column = [layer[index] for layer in media]
        data["layer_" + name] = Field(column, ("layer",), {"units": unit, "long_name": meaning})
    for name, (unit, meaning) in ((name, AXES[name]) for name in axes):
        data[name] = Field(axes[name], (name,), {"units": unit, "long_name": meaning})
    return Fields(data, {"title": title, "photons": int(photons), "n_above": above, "n_below": below, **_provenance(text)})
