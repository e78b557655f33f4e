"""Absorption, scattering and refractive index of tissue and other media over wavelength, each with its source.

Wavelengths are in nm, coefficients in 1/cm. Tables stand in the folder `spectra`, one file for each source.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import functools
import importlib.resources
import os
from dataclasses import dataclass, field
from typing import Any, Callable, Mapping, Optional, Union

import numpy as np
import numpy.typing as npt

from . import errors

LN10 = 2.303  # turns log10 into ln, with the digits of the table of hemoglobin
HEMOGLOBIN = 64500.0  # g of hemoglobin in one mole, as its table says
SKIN = "S. L. Jacques, Skin optics, Oregon Medical Laser Center News, January 1998, omlc.org/news/jan98/skinoptics.html"
DING = "Ding, Lu, Wooden, Kragel, Hu, Phys. Med. Biol. 51, 1479 (2006), Cauchy's formula"
DATABASE = ", by refractiveindex.info"


@dataclass(frozen=True, eq=False)
class Absorber:
    """An absorber. Its absorption coefficient grows in proportion to its amount.

    Attributes:
        name: Name, for messages.
        nm: Rising wavelengths of a table, or the first and the last wavelength of a formula.
        mua: Absorption coefficients at amount 1 at these wavelengths, or a formula: a function of the wavelengths.
        amount: Unit of the amount: "share of volume" or "mol/L"; default "share of volume".
        source: Where the numbers come from.

    Examples:
        >>> ink = Absorber("ink", [500, 600], [2.0, 1.0], source="my spectrometer")
        >>> ink([500, 550]).tolist()
        [2.0, 1.5]
    """

    name: str
    nm: npt.ArrayLike
    mua: Union[npt.ArrayLike, Callable[[Any], Any]]
    amount: str = "share of volume"
    source: str = ""

    def __post_init__(self) -> None:
        errors.text("Absorber.name", self.name)
        nm = wavelengths("Absorber.nm", self.nm, 2)
        if not callable(self.mua):
            expected = f"{nm.size} numbers >= 0, one for each wavelength"
            mua = errors.array("Absorber.mua", self.mua, "iuf", expected)
            if mua.shape != nm.shape or (mua < 0).any():
                raise errors.refuse("Absorber.mua", self.mua, expected)

    def __call__(self, nm: npt.ArrayLike) -> Any:
        """Returns the absorption coefficients [1/cm] of amount 1; between rows of a table they are interpolated."""
        own, wanted = np.asarray(self.nm, dtype=float), _within(self.name, nm, np.asarray(self.nm, dtype=float))
        return self.mua(wanted) if callable(self.mua) else np.interp(wanted, own, np.asarray(self.mua, dtype=float))


def wavelengths(name: str, nm: Any, least: int = 1) -> Any:
    """Returns wavelengths as an array of floats. Refuses all but a list of rising numbers > 0."""
    expected = "a list of rising wavelengths [nm]" + (f", at least {least}" if least > 1 else "")
    array = errors.array(name, nm, "iuf", expected).astype(float)
    if array.ndim != 1 or array.size < least or array[0] <= 0 or (np.diff(array) <= 0).any():
        raise errors.refuse(name, nm, expected)
    return array


def _within(name: str, nm: Any, own: Any) -> Any:
    """Returns wavelengths as an array. Refuses those outside of the wavelengths `own` at which something is known."""
    wanted = errors.array("nm", nm, "iuf", "wavelengths [nm]").astype(float)
    outside = wanted[(wanted < own[0]) | (wanted > own[-1])]
    if outside.size:
        raise errors.refuse("nm", float(outside[0]), f"{own[0]:g} to {own[-1]:g} nm, where {name} is known")
    return wanted


# Tables: {name: (file, factor to 1/cm at amount 1, unit of the amount)}
TABLES = {"HbO2": ("hemoglobin.csv", LN10, "mol/L"), "Hb": ("hemoglobin.csv", LN10, "mol/L"), "water": ("water.csv", 1.0, "share of volume"),
          "fat": ("fat.csv", 1.0, "share of volume"), "bilirubin": ("bilirubin.csv", LN10, "mol/L"), "carotene": ("carotene.csv", LN10, "mol/L")}

# Formulas: {name: absorber}
FORMULAS = {"melanosome": Absorber("melanosome", (250, 1200), lambda nm: 6.6e11 * nm**-3.33, source=SKIN),
            "bloodless skin": Absorber("bloodless skin", (350, 1100), lambda nm: 0.244 + 85.3 * np.exp(-(nm - 154) / 66.2), source=SKIN)}

# Refractive indices: {name: (first wavelength, last wavelength, formula of the wavelength in um, source)}
INDICES: dict[str, tuple[float, float, Callable[[Any], Any], str]] = {
    "water": (182, 1129, lambda um: _sellmeier(um, (5.684027565e-1, 5.101829712e-3), (1.726177391e-1, 1.821153936e-2),
                                               (2.086189578e-2, 2.620722293e-2), (1.130748688e-1, 1.069792721e1)),
              "M. Daimon, A. Masumura, Appl. Opt. 46, 3811 (2007), 20 C" + DATABASE),
    "fused silica": (210, 6700, lambda um: _sellmeier(um, (0.6961663, 0.0684043**2), (0.4079426, 0.1162414**2), (0.8974794, 9.896161**2)),
                     "I. H. Malitson, J. Opt. Soc. Am. 55, 1205 (1965), 20 C" + DATABASE),
    "epidermis": (325, 1557, lambda um: 1.4134 + 7.9079596e-3 / um**2 - 3.899784e-10 / um**4, DING),
    "dermis": (325, 1557, lambda um: 1.3696 + 3.9168026e-3 / um**2 - 2.5587704e-9 / um**4, DING),
}

# Reduced scattering: {tissue: numbers of reduced_scattering}, of table 2 of S. L. Jacques, Phys. Med. Biol. 58, R37 (2013)
TISSUES: dict[str, dict[str, float]] = {"skin": {"a": 46.0, "b": 1.421}, "brain": {"a": 24.2, "b": 1.611}, "soft": {"a": 18.9, "b": 1.286},
                                        "breast": {"a": 18.7, "b": 0.685, "rayleigh": 0.288}}


def _sellmeier(um: Any, *terms: tuple[float, float]) -> Any:
    return np.sqrt(1 + sum(strength * um**2 / (um**2 - square) for strength, square in terms))


def absorber(name: str) -> Absorber:
    """Returns an absorber of this package by its name.

    Args:
        name: HbO2, Hb, water, fat, bilirubin, carotene, melanosome or "bloodless skin".

    Returns:
        An Absorber: a function of the wavelength that returns 1/cm, with its `source` and the unit of its `amount`.

    Examples:
        >>> absorber("water").amount, absorber("water")([700]).round(4).tolist()
        ('share of volume', [0.006])
        >>> absorber("ink")
        Traceback (most recent call last):
        ...
        clustermcml.errors.InputError: absorber = 'ink' (expected one of HbO2 Hb water fat bilirubin carotene melanosome bloodless skin)
    """
    errors.choice("absorber", name, *TABLES, *FORMULAS)
    return FORMULAS[name] if name in FORMULAS else _table(name)


@functools.lru_cache(maxsize=None)
def _table(name: str) -> Absorber:
    file, factor, amount = TABLES[name]
    lines = (importlib.resources.files(__package__) / "spectra" / file).read_text("utf-8").splitlines()
    told = [line[2:] for line in lines if line.startswith("# ")]
    head, *rows = [line.split(",") for line in lines if not line.startswith("#")]
    numbers = np.array(rows, dtype=float)
    return Absorber(name, numbers[:, 0], factor * numbers[:, head.index(name)], amount, " ".join(told[1:]))


def blood(share: float, saturation: float, hemoglobin: float = 150.0) -> dict[Union[str, Absorber], float]:
    """Returns the amounts of HbO2 and Hb in a medium with blood.

    Args:
        share: Share of the volume that is blood, 0 to 1.
        saturation: Share of the hemoglobin that is oxygenated, 0 to 1.
        hemoglobin: Hemoglobin in whole blood [g/L].

    Returns:
        {"HbO2": mol/L, "Hb": mol/L}, for `Medium`.
    """
    errors.number("share", share, 0, 1, "a share of the volume, 0 to 1")
    errors.number("saturation", saturation, 0, 1, "an oxygenation, 0 to 1")
    moles = share * errors.at_least_zero("hemoglobin", hemoglobin) / HEMOGLOBIN
    return {"HbO2": moles * saturation, "Hb": moles * (1 - saturation)}


def reduced_scattering(nm: npt.ArrayLike, a: float, b: float, rayleigh: float = 0.0) -> Any:
    """Returns reduced scattering coefficients mus' = a (rayleigh x^-4 + (1 - rayleigh) x^-b) with x = nm / 500, in the unit of a.

    Equations 1 and 2 of S. L. Jacques, Phys. Med. Biol. 58, R37 (2013).

    Args:
        nm: Wavelengths [nm].
        a: mus' at 500 nm [1/cm].
        b: Power of scattering by large structures.
        rayleigh: Share of scattering by structures much smaller than the wavelength, 0 to 1.
    """
    x = np.asarray(nm, dtype=float) / 500
    return a * (rayleigh * x**-4 + (1 - rayleigh) * x**-b)


def index(name: str, nm: npt.ArrayLike) -> Any:
    """Returns refractive indices.

    Args:
        name: water, "fused silica", epidermis or dermis.
        nm: Wavelengths [nm].

    Examples:
        >>> index("fused silica", [587.6]).round(4).tolist()
        [1.4585]
    """
    errors.choice("index", name, *INDICES)
    low, high, formula, _ = INDICES[name]
    return formula(_within(f"the index of {name}", nm, np.array([low, high])) / 1000)


@dataclass(frozen=True)
class Medium:
    """A medium over wavelength. What is None stays as the scene has it.

    Attributes:
        absorbers: {absorber: amount}: names as `absorber` takes them, or objects of Absorber; mua is their sum. Empty leaves mua to the scene.
        a: mus' at 500 nm [1/cm]; needs b and g, because mus = mus' / (1 - g).
        b: Power of scattering, as `reduced_scattering` has it.
        rayleigh: Share of Rayleigh scattering, 0 to 1; default 0.
        g: Mean cosine of scattering, -1 to 1.
        n: Refractive index: a number, or a name as `index` takes it.

    Examples:
        >>> dermis = Medium({**blood(0.02, 0.75), "bloodless skin": 0.98}, **TISSUES["skin"], g=0.8, n=1.4)
        >>> {name: values.round(3).tolist() for name, values in dermis.columns([500, 600]).items()}
        {'mua': [2.929, 0.988], 'mus': [230.0, 177.505], 'g': [0.8, 0.8], 'n': [1.4, 1.4]}
    """

    absorbers: Mapping[Union[str, Absorber], float] = field(default_factory=dict)
    a: Optional[float] = None
    b: Optional[float] = None
    rayleigh: float = 0.0
    g: Optional[float] = None
    n: Union[float, str, None] = None

    def __post_init__(self) -> None:
        if not isinstance(self.absorbers, Mapping):
            raise errors.refuse("Medium.absorbers", self.absorbers, '{absorber: amount}, {"water": 0.7}')
        for name, amount in self.absorbers.items():
            if not isinstance(name, Absorber):
                absorber(name)  # refuses unknown names
            errors.at_least_zero(f"Medium.absorbers[{getattr(name, 'name', name)!r}]", amount)
        if self.a is not None:
            errors.at_least_zero("Medium.a", self.a)
            errors.finite("Medium.b", self.b)
        elif self.b is not None:
            raise errors.refuse("Medium.b", self.b, "None without a")
        errors.number("Medium.rayleigh", self.rayleigh, 0, 1, "a share from 0 to 1")
        if self.g is not None or self.a is not None:
            errors.number("Medium.g", self.g, -1, 1 if self.a is None else np.nextafter(1, 0),
                          "a number from -1 to 1" if self.a is None else "a number from -1 to below 1, as mus = mus' / (1 - g)")
        if isinstance(self.n, str):
            errors.choice("Medium.n", self.n, *INDICES)
        elif self.n is not None:
            errors.number("Medium.n", self.n, 0.01, 100, "a number from 0.01 to 100, or a name: " + ", ".join(INDICES))

    def columns(self, nm: npt.ArrayLike) -> dict[str, Any]:
        """Returns mua, mus, g and n at these wavelengths, as far as the medium has them."""
        nm = np.asarray(nm, dtype=float)
        found: dict[str, Any] = {}
        if self.absorbers:
            found["mua"] = sum(amount * (name if isinstance(name, Absorber) else absorber(name))(nm) for name, amount in self.absorbers.items())
        if self.a is not None and self.b is not None and self.g is not None:
            found["mus"] = reduced_scattering(nm, self.a, self.b, self.rayleigh) / (1 - self.g)
        if self.g is not None:
            found["g"] = np.full(nm.shape, float(self.g))
        if self.n is not None:
            found["n"] = index(self.n, nm) if isinstance(self.n, str) else np.full(nm.shape, float(self.n))
        return found


def read_absorber(path: Union[str, os.PathLike[str]], name: str, column: Optional[str] = None) -> Absorber:
    """Reads an absorber from a table.

    Args:
        path: Path of a `.csv` whose first line has names: nm, then columns of absorption coefficients [1/cm]. # begins a comment.
        name: Name of the absorber.
        column: Name of its column; None is `name`.

    Returns:
        An Absorber of amount "share of volume".
    """
    from .channels import channel_table
    columns = channel_table(f"nm={os.fspath(path)}")
    wanted = name if column is None else column
    if wanted not in columns:
        raise errors.refuse("column", wanted, "one of " + " ".join(columns))
    return Absorber(name, columns["nm"], columns[wanted], source=os.fspath(path))
