"""Reads `.mco` files, this program's and those of original MCML.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import re
from typing import Any, Iterator

import numpy as np
import xarray as xr

from . import errors

TOTALS = ("Rsp", "Rd", "A", "Tt")
LAYER = ("n", "mua", "mus", "g", "d")
END = "   Last line: # end"  # says, behind the time, that the file ends so; those of original MCML and of older versions do not
BOOKS = {
    "launched": "launched", "gained": "gained in roulette", "specular": "specular (Rsp)", "reflected": "reflected (Rd)",
    "transmitted": "transmitted (Tt)", "absorbed": "absorbed (A)", "roulette": "lost in roulette", "trapped": "trapped", "lost": "lost",
    "overflow_r": "scored in the last r bin from beyond it", "overflow_z": "absorbed below the last z bin",
    "above": "absorbed above z = 0",
}

# name: axes, unit, what it is; as the .h5 files say it
QUANTITIES = {
    "Rsp": ((), "1", "specular reflectance"),
    "Rd": ((), "1", "diffuse reflectance"),
    "A": ((), "1", "absorbed fraction"),
    "Tt": ((), "1", "transmittance"),
    "A_l": (("layer",), "1", "absorption by layer"),
    "A_backing": ((), "1", "kept by the backing"),
    "Tt_expected": ((), "1", "transmittance, by what flat layers let through"),
    "A_l_expected": (("layer",), "1", "absorption by layer, by what flat layers absorb; above them as counted"),
    "A_body": (("body",), "1", "absorption by body"),
    "flux_body": (("body", "side"), "1", "weight at each body's surface: arrives outside, inside, leaves outside, inside"),
    "A_z": (("z",), "1/cm", "absorption by depth; what lies outside is in the outermost bins"),
    "Rd_r": (("r",), "1/cm2", "diffuse reflectance by radius; the last bin holds what lies beyond"),
    "Rd_a": (("alpha",), "sr-1", "diffuse reflectance by angle"),
    "Tt_r": (("r",), "1/cm2", "transmittance by radius; the last bin holds what lies beyond"),
    "Tt_a": (("alpha",), "sr-1", "transmittance by angle"),
    "A_rz": (("r", "z"), "1/cm3", "absorption by radius and depth"),
    "phi_z": (("z",), "1", "fluence by depth, over all radii"),
    "phi_rz": (("r", "z"), "1/cm2", "fluence by radius and depth"),
    "Rd_ra": (("r", "alpha"), "1/(cm2 sr)", "diffuse reflectance by radius and angle"),
    "Tt_ra": (("r", "alpha"), "1/(cm2 sr)", "transmittance by radius and angle"),
}
for _name, _meaning in (("Rd", "diffuse reflectance"), ("Tt", "transmittance"), ("A", "absorption")):
    QUANTITIES[_name + "_t"] = (("gate",), "1/ps", _meaning + " by time")
    QUANTITIES[_name + "_t_later"] = ((), "1", _meaning + " later than all gates")
for _name, _meaning in (("Rd", "diffuse reflectance"), ("Tt", "transmittance"), ("Rsp", "specular reflectance")):
    QUANTITIES[_name + "_dir"] = (("theta", "phi"), "1/sr", _meaning + " by direction")
for _by in ("mua", "mus"):
    for _name in ("Rd", "A", "Tt", "A_backing", "A_l", "A_body", "Rd_r", "Rd_a", "Tt_r", "Tt_a"):
        QUANTITIES[f"d{_name}_d{_by}"] = ((*QUANTITIES[_name][0], "inside"), {"1/cm2": "1/cm", "sr-1": "cm/sr"}.get(QUANTITIES[_name][1], "cm"),
                                          f"derivative of {_name} by {_by}")
# a section of one number: its name, what it is, its unit
NUMBER = re.compile(r"^([A-Za-z]\w*) # (.+) \[([^]]+)\]\n *\S+\n(?=\n|\Z)", re.MULTILINE)
# of every detector, behind detector_NAME
OF_DETECTORS = {
    "": ((), "1", "detected"),
    "_t": (("gate",), "1/ps", "detected by time"),
    "_t_later": ((), "1", "detected later than all gates"),
    "_path": (("medium",), "cm", "mean path of detected light by medium"),
    "_interactions": (("medium",), "1", "mean interactions of detected light by medium"),
    "_deepest": ((), "cm", "mean largest depth of detected light"),
    "_dmua": (("inside",), "cm", "derivative of detected by mua"),
    "_dmus": (("inside",), "cm", "derivative of detected by mus"),
}
QUANTITIES.update({name + "_control": ((), "1", "the same with the flat twin as control variate") for name in (*TOTALS, "A_backing")})
QUANTITIES.update({"book_" + name: ((), "1", meaning) for name, meaning in BOOKS.items()})
QUANTITIES["residue"] = ((), "1", "launched + gained - all fates, in 2^-31 packets")
QUANTITIES["lost"] = ((), "1", "packets lost to numerical failure")
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
    "body": ("1", "body, from 1, in the order of the file"),
    "medium": ("1", "medium: 0 above, layers from 1, below, then bodies"),
    "inside": ("1", "medium inside: layers from 1, then bodies"),
    "side": ("1", "arrives outside, inside, leaves outside, inside"),
    "gate": ("ps", "time, middle of the gate"),
    "theta": ("rad", "angle of flight from the outward vertical, middle of the bin"),
    "phi": ("rad", "azimuth of flight, from x towards y, middle of the bin"),
}


def _sections(text: str) -> dict[str, list[str]]:
    """{key: the words of its lines}; comments are left out. The name of the output, with which InParm begins, is one word."""
    sections: dict[str, list[str]] = {}
    key = ""
    for line in text.split("\n"):
        words = line.split("#")[0].split()
        if key == "InParm" and words and not sections[key]:
            sections[key] = [re.sub(r"(?<!\s)\s+[A-Za-z]\s*(#.*)?$", "", line)]
            continue
        if words and re.fullmatch(r"[A-Za-z]\w*", words[0]) and words[0].lower() != "nan" and (words[0] != "A" or key):
            key = words.pop(0)
            sections[key] = []
        if key:
            sections[key] += words
    return sections


def _middles(bins: int, width: float) -> Any:
    return (np.arange(bins) + 0.5) * width


def _count(name: str, word: str, most: int) -> int:
    """A whole number of bins or layers: the file has at least a digit and a blank for each."""
    if not 1 <= int(word) <= most:
        raise ValueError(f"{name} = {word} (expected a whole number from 1 to {most}, which the file can hold)")
    return int(word)


def _grid(words: Iterator[str], most: int) -> tuple[dict[str, Any], list[list[float]], float, float]:
    """Axes, layers and the indices beyond them from the words of InParm, which original MCML writes: name, format, photons, dz,
    dr, nz, nr, na, number of layers, n above, five numbers for each layer, n below. most: as many bins, or layers, as the file can hold."""
    dz, dr = float(next(words)), float(next(words))
    nz, nr, na, layers = (_count(name, next(words), most) for name in ("nz", "nr", "na", "number of layers"))
    above = float(next(words))
    media = [[float(next(words)) for _ in LAYER] for _ in range(layers)]
    below = float(next(words))
    axes = {"r": _middles(nr, dr), "z": _middles(nz, dz), "alpha": _middles(na, np.pi / 2 / na), "layer": np.arange(1.0, layers + 1)}
    return axes, media, above, below


def _provenance(text: str) -> dict[str, Any]:
    """What the lines of comment behind the arrays say; empty for a file of original MCML. Merged results have several seeds."""
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
    known["boundaries"] = "\n".join(re.findall(r"^# (boundary \d+: .*)$", text, re.MULTILINE))
    phases = re.findall(r"^# (phase of .*|backing: .*)$", text, re.MULTILINE)
    if phases:
        known["phases"] = "\n".join(phases)
    detectors = re.findall(r"^# (detector \w+: .*)$", text, re.MULTILINE)
    if detectors:
        known["detectors"] = "\n".join(detectors)
    sampling = re.search(r"^# sampling (\w+)", text, re.MULTILINE)
    if sampling:
        known["sampling"] = sampling[1]
    return known


def _known(text: str) -> dict[str, Any]:
    """All quantities that the file may have, those of its detectors too, and numbers that only the file's own comments know."""
    names = re.findall(r"^# detector (\w+): ", text, re.MULTILINE)
    known = {**QUANTITIES, **{f"detector_{name}{ending}": what for name in names for ending, what in OF_DETECTORS.items()}}
    numbers = {name: ((), {"-": "1"}.get(unit, unit), meaning) for name, meaning, unit in NUMBER.findall(text)}
    return {**known, **{name: what for name, what in numbers.items() if name not in known}}


def _variable(name: str, known: dict[str, Any], axes: dict[str, Any], words: list[str]) -> xr.DataArray:
    """A quantity or, as NAME_se, its standard error."""
    dims, unit, meaning = known[name.removesuffix("_se")]
    values = np.array(words, dtype=float).reshape([axes[dim].size for dim in dims])
    long_name = "standard error" if name.endswith("_se") else meaning
    return xr.DataArray(values, dims=dims, attrs={"units": unit, "long_name": long_name})


def _numbers(sections: dict[str, list[str]], known: dict[str, Any], axes: dict[str, Any]) -> dict[str, xr.DataArray]:
    """All quantities that the file has, and their errors. Behind `lost` stand indices of packets."""
    words = {name: sections[name] for name in known if name in sections and name not in (*TOTALS, "lost")}
    words.update({name: [word] for name, word in zip(TOTALS, sections["RAT"])})
    words.update({key[3:] + "_se": values for key, values in sections.items() if key[3:] in known and key.startswith("se_")})
    words.update({name + "_se": [word] for name, word in zip(TOTALS, sections.get("se_RAT", []))})
    words.update({"book_" + name: [word] for name, word in zip(BOOKS, sections.get("books", []))})
    words.update({"lost": sections["lost"][:1]} if "lost" in sections else {})
    totals = (*TOTALS, "A_backing") if "A_backing" in sections else TOTALS
    control = [f"{name}_control{error}" for error in ("", "_se") for name in totals]
    words.update({name: [word] for name, word in zip(control, sections.get("control", []))})
    variables = {name: _variable(name, known, axes, values) for name, values in words.items()}
    for name, variable in variables.items():
        if name + "_se" in variables:
            variable.attrs["ancillary_variables"] = name + "_se"
    return variables


def read_mco(path: str) -> xr.Dataset:
    """The Dataset of an `.mco` file, with the names, axes and units of an `.h5` file."""
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            text = file.read()
        if not text.startswith("A1"):
            raise errors.InputError(f"{path}: not an .mco file (expected A1 at its beginning)")
        _, end, behind = text.partition("\n# end\n")
        if END in text[:1000] and not end:
            raise errors.InputError(f"{path}: last line is missing (expected # end; the file is cut off)")
        if END in text[:1000] and behind.strip(" \t\n"):
            raise errors.InputError(f"{path}: text behind # end (expected one result)")
        return _dataset(text, _sections(text))
    except errors.InputError:
        raise
    except Exception as error:  # whatever Python and its libraries say of words that are not what they should be
        raise errors.unreadable(path, "a whole .mco file", error) from error


def _dataset(text: str, sections: dict[str, list[str]]) -> xr.Dataset:
    words = iter(sections["InParm"])
    title, photons = next(words), float(next(words))
    axes, media, above, below = _grid(words, len(text) // 2)
    if "A_body" in sections:
        axes["body"] = np.arange(1.0, len(sections["A_body"]) + 1)
        axes["side"] = np.arange(1.0, 5)
    if "dRd_dmua" in sections:
        axes["inside"] = np.arange(1.0, len(sections["dRd_dmua"]) + 1)
    if "time" in sections:
        gates = _count("number of gates", sections["time"][1], len(text) // 2)
        axes["gate"] = _middles(gates, float(sections["time"][0]) / gates)
    if "directions" in sections:
        nt, np_ = (_count("bins of directions", word, len(text) // 2) for word in sections["directions"][:2])
        axes["theta"], axes["phi"] = _middles(nt, np.pi / 2 / nt), _middles(np_, 2 * np.pi / np_)
    if re.search(r"^# detector ", text, re.MULTILINE):
        axes["medium"] = np.arange(len(media) + 2.0 + len(re.findall(r"^# body \d+: ", text, re.MULTILINE)))
    data = _numbers(sections, _known(text), axes)  # a Dataset last: each variable that is added to one copies it
    bodies = re.findall(r"^# body \d+: .*?; n (\S+), mua (\S+), mus (\S+) 1/cm, g (\S+)", text, re.MULTILINE)
    for index, (name, (unit, meaning)) in enumerate(LAYER_QUANTITIES.items()):
        column = [layer[index] for layer in media]
        data["layer_" + name] = xr.DataArray(column, dims="layer", attrs={"units": unit, "long_name": meaning})
        if bodies and name != "d":
            column = [float(body[index]) for body in bodies]
            data["body_" + name] = xr.DataArray(column, dims="body", attrs={"units": unit, "long_name": meaning})
    for name, (unit, meaning) in ((name, AXES[name]) for name in axes):
        data[name] = xr.DataArray(axes[name], dims=name, attrs={"units": unit, "long_name": meaning})
    return xr.Dataset(data, attrs={"title": title, "photons": int(photons), "n_above": above, "n_below": below, **_provenance(text)})
