"""Scattering by spheres: mus, g and the phase function by Mie's theory, which the package miepython computes.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from . import errors
from .phases import Phase

PER_CM = 1e4  # 1/um in 1/cm
FINE = 1e-4  # largest error of the mean cosine and of the integral of the table
MOST = 2**16  # most intervals of the table


@dataclass(frozen=True)
class Mie:
    """Scattering and absorption by spheres in a medium. `Layer(n=n_medium, mua=..., mus=found.mus, g=found.g, d=..., phase=found.phase)` scatters as they do.

    Attributes:
        mus: Scattering coefficient [1/cm].
        mua: Absorption coefficient of the spheres, without that of the medium [1/cm].
        g: Mean cosine of the scattering angle.
        phase: Phase function, as a table.
    """

    mus: float
    mua: float
    g: float
    phase: Phase


def _miepython() -> Any:
    cure = "miepython 3 or later is missing (expected it for mc.mie: pip install 'miepython>=3')"
    try:
        import miepython
    except ImportError:
        raise errors.ClustermcmlError(cure, 5) from None
    if not hasattr(miepython, "efficiencies_mx"):  # versions 1 and 2 have other names
        raise errors.ClustermcmlError(cure, 5)
    return miepython


def _moments(cosines: Any, density: Any) -> tuple[float, float]:
    """Returns the integral over all directions, and the mean cosine, of a density that is linear between falling cosines."""
    a, b, p, q = cosines[:-1], cosines[1:], density[:-1], density[1:]
    whole = float(((a - b) * (p + q) / 2).sum())
    return 2 * np.pi * whole, float(((a - b) * (p * (2 * a + b) + q * (a + 2 * b)) / 6).sum()) / whole


def _table(package: Any, m: complex, sizes: Any, shares: Any, g: float) -> Phase:
    """Returns the phase function of a mixture. shares: of the scattered light, by size parameter. The steps of the angle are
    halved until the table has the mean cosine and the integral of the theory."""
    count = 180
    while True:
        angles = np.linspace(0, 180, count + 1)
        cosines = np.cos(np.radians(angles))
        density = sum(share * np.asarray(package.i_unpolarized(m, float(x), cosines, norm="one")) for x, share in zip(sizes, shares))
        whole, mean = _moments(cosines, density)
        if abs(whole - 1) < FINE and abs(mean - g) < FINE:
            return Phase("table", angles=angles, densities=density)
        if count >= MOST:
            raise errors.ClustermcmlError(f"phase function of size parameter {max(sizes):g}: {count} angles give g {mean:g} for {g:g} (expected smaller spheres)", 4)
        count *= 2


def _sizes(diameter: Any, weights: Any) -> tuple[Any, Any]:
    """Returns diameters and their shares by number."""
    expected = "a number > 0, or a list of them"
    diameters = np.atleast_1d(errors.array("diameter_um", diameter, "iuf", expected)).astype(float)
    if diameters.ndim != 1 or not diameters.size or not (diameters > 0).all():
        raise errors.refuse("diameter_um", diameter, expected)
    if weights is None:
        if diameters.size > 1:
            raise errors.refuse("weights", weights, "a number >= 0 for each diameter: how many spheres have it")
        return diameters, np.ones(1)
    expected = f"numbers >= 0, not all 0, one for each diameter: {diameters.size}"
    shares = np.atleast_1d(errors.array("weights", weights, "iuf", expected)).astype(float)
    if shares.shape != diameters.shape or (shares < 0).any() or not shares.any():
        raise errors.refuse("weights", weights, expected)
    return diameters[shares > 0], shares[shares > 0] / shares.sum()


def mie(diameter_um: npt.ArrayLike, n: complex, n_medium: float, wavelength_nm: float, *, volume_fraction: Optional[float] = None,
        number_density: Optional[float] = None, weights: Optional[npt.ArrayLike] = None) -> Mie:
    """Returns how spheres in a medium scatter unpolarized light, by Mie's theory. Needs the package miepython, 3 or later.

    Each sphere scatters alone, which holds up to a volume fraction of about 0.01 to 0.1.

    Args:
        diameter_um: Diameter of the spheres [um]; of a size distribution a list.
        n: Refractive index of the spheres; absorbing ones have an imaginary part, of any sign.
        n_medium: Refractive index of the medium.
        wavelength_nm: Wavelength in vacuum [nm].
        volume_fraction: Volume of the spheres in a unit of volume, 0 to 1.
        number_density: Number of spheres in 1 cm3, in place of the volume fraction.
        weights: Of a size distribution, how many spheres have each diameter, in any unit.

    Returns:
        A Mie with mus, mua, g and phase.

    Raises:
        InputError: An argument is refused.
        ClustermcmlError: miepython is missing.
    """
    diameters, shares = _sizes(diameter_um, weights)
    try:
        index = complex(n)
    except (TypeError, ValueError):
        raise errors.refuse("n", n, "a refractive index, real or complex") from None
    errors.above_zero("n", index.real)
    m = complex(index.real, -abs(index.imag)) / errors.above_zero("n_medium", n_medium)  # miepython's sign of absorption
    sizes = np.pi * diameters * n_medium / (errors.above_zero("wavelength_nm", wavelength_nm) / 1000)
    if (volume_fraction is None) == (number_density is None):
        raise errors.refuse("volume_fraction", volume_fraction, "a volume fraction or a number density, not both")
    if volume_fraction is not None:
        density = errors.number("volume_fraction", volume_fraction, 0, 1, "a number from 0 to 1") / float(shares @ (np.pi / 6 * diameters**3))
    else:
        density = errors.at_least_zero("number_density", number_density) / PER_CM**3
    package = _miepython()
    extinct, scattered, _, cosines = (np.array(column, dtype=float) for column in zip(*(package.efficiencies_mx(m, float(x))[:4] for x in sizes)))
    areas = shares * np.pi / 4 * diameters**2  # um2
    mus, mut = density * float(areas @ scattered) * PER_CM, density * float(areas @ extinct) * PER_CM
    parts = areas * scattered / float(areas @ scattered)
    g = float(parts @ cosines)
    return Mie(mus, max(mut - mus, 0.0) if m.imag else 0.0, g, _table(package, m, sizes, parts, g))
