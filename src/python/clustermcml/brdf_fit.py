"""A smooth, reciprocal fit of the light that was inside a flat material, and a test of the reciprocity of its bins.

    f = T(mi) T(mo) sum over m < 3, k <= l < 5 of c_klm (ai^k ao^l + ai^l ao^k) (sin ti sin to)^m cos(m phi)

i is the direction of incidence and o that of exit; ti and to are their angles, mi and mo the cosines. T is Fresnel's
transmission from the medium above into the first layer, and a is the cosine inside that layer. Few terms suffice, because
Chandrasekhar's solution for a half space has such products. With an index of 1, T is 1 and a is the outer cosine. This form
suits light behind a rough face, which also lets grazing light through.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .brdf_flight import Bins

POWERS, AZIMUTHS = 5, 3
PAIRS = [(k, l) for k in range(POWERS) for l in range(k, POWERS)]
TERMS = len(PAIRS) * AZIMUTHS
NODES = 16  # points of integration over a bin of theta


def transmission(cosine: Any, index: float) -> tuple[Any, Any]:
    """Returns Fresnel's transmission of unpolarised light into a medium of this relative index, and the cosine in the medium.
    Both are 0 at total reflection."""
    square = 1 - (1 - cosine**2) / index**2
    inside = np.sqrt(np.maximum(square, 0))
    with np.errstate(divide="ignore", invalid="ignore"):
        across = ((cosine - index * inside) / (cosine + index * inside)) ** 2
        along = ((index * cosine - inside) / (index * cosine + inside)) ** 2
    return np.where(square > 0, 1 - (across + along) / 2, 0.0), inside


@dataclass
class Shape:
    """The functions of one angle whose products are the terms of the fit. index: n of the first layer over n of the medium
    above."""

    index: float

    def at(self, theta: Any) -> Any:
        """Returns T a^k sin^m at the angle theta [rad] as [AZIMUTHS (m), POWERS (k), ...]."""
        theta = np.asarray(theta, float)
        through, inside = transmission(np.cos(theta), self.index)
        return np.stack([np.stack([through * inside**k * np.sin(theta) ** m for k in range(POWERS)]) for m in range(AZIMUTHS)])

    def over(self, edges: Any) -> Any:
        """Returns the means of T a^k sin^m over bins between edges [rad], weighted by projected solid angle: [AZIMUTHS, POWERS,
        bins]."""
        theta = edges[:-1, None] + (np.arange(NODES) + 0.5) / NODES * np.diff(edges)[:, None]
        weights = np.sin(theta) * np.cos(theta)
        return (self.at(theta) * weights).sum(axis=-1) / weights.sum(axis=-1)


def _terms(i: Any, o: Any, azimuth: Any) -> Any:
    """Returns the terms [TERMS, ...]: products of the functions of both angles with azimuth = cos(m phi) [AZIMUTHS, ...]."""
    return np.stack([(i[m, k] * o[m, l] + i[m, l] * o[m, k]) * azimuth[m] for m in range(AZIMUTHS) for k, l in PAIRS])


def evaluate(coefficients: Any, index: float, theta_i: Any, theta_o: Any, phi: Any) -> Any:
    """Returns the fit [1/sr] at angles [rad], which may be arrays of one shape. Swapping theta_i and theta_o gives the same
    bits."""
    shape = Shape(index)
    azimuth = np.stack([np.cos(m * np.asarray(phi, float)) for m in range(AZIMUTHS)])
    return np.tensordot(coefficients, _terms(shape.at(theta_i), shape.at(theta_o), azimuth), 1)


@dataclass
class Fitted:
    """A fit of one channel. index: relative n of the fit. coefficients: [TERMS]. means: means of the fit over the bins.
    middles: the fit in the middles of the bins, at each angle of incidence. chi2: chi^2 per degree of freedom."""

    index: float
    coefficients: Any
    means: Any
    middles: Any
    chi2: float


def fit_bins(shares: Any, errors: Any, angles: Any, index: float, bins: Bins) -> Fitted:
    """Fits shares [angle of incidence, theta, phi] by least squares. The variance of a bin is taken proportional to its light,
    with the factor of its row. The measured errors of single bins would favour bins that are too dark by chance."""
    projected = bins.projected()[:, None]
    shape, half = Shape(index), np.pi / bins.np
    phi = bins.azimuths()
    azimuth = np.stack([np.cos(m * phi) * np.sinc(m * half / np.pi) for m in range(AZIMUTHS)])[:, None, None, :]
    at = shape.at(angles)[..., :, None, None]
    terms = _terms(at, shape.over(bins.edges())[..., None, :, None], azimuth).reshape(TERMS, -1)
    spread = (errors**2).sum(axis=(1, 2)) / np.maximum(shares.sum(axis=(1, 2)), 1e-300)
    f = (shares / projected).ravel()
    expected = np.broadcast_to(shares.mean(axis=2, keepdims=True), shares.shape)
    coefficients, chi2 = np.zeros(TERMS), 0.0
    scale = np.abs(terms).max(axis=1)
    scale[scale == 0] = 1
    for _ in range(2):
        floor = 1e-3 * shares.sum(axis=(1, 2), keepdims=True) / shares[0].size
        sigma = np.sqrt(spread[:, None, None] * np.maximum(expected, floor) + 1e-300) / projected
        weights = 1 / np.maximum(sigma.ravel(), 1e-150)
        coefficients = np.linalg.lstsq((terms / scale[:, None] * weights).T, f * weights, rcond=1e-12)[0] / scale
        means = coefficients @ terms
        chi2 = float((((f - means) * weights) ** 2).sum() / max(f.size - TERMS, 1))
        expected = means.reshape(shares.shape) * projected
    middles = np.tensordot(coefficients, _terms(at, shape.at(bins.middles())[..., None, :, None], azimuth), 1)
    return Fitted(index, coefficients, means.reshape(shares.shape), middles, chi2)


def reciprocity(f: Any, errors: Any, angles: Any, bins: Bins, fitted: Any) -> list[tuple[float, float, float, float]]:
    """Compares f(i, o) with f(o, i) for pairs of angles of incidence that are middles of bins. Returns tuples: both angles
    [degrees], f(i, o) / f(o, i) - 1, and z.

    f: means over the azimuth of raw bins [angle, theta]. fitted: the fit in the middles of bins over its mean there, which
    corrects for the width of the bins."""
    width = 90 / bins.nt
    places = {i: round(angle / width) for i, angle in enumerate(angles) if abs(angle / width - round(angle / width)) < 1e-6 and 0 < angle}
    pairs = []
    for i, place in places.items():
        for j, other in places.items():
            if i < j and f[i, other] > 0 and f[j, place] > 0:
                a, b = f[i, other] * fitted[i, other], f[j, place] * fitted[j, place]
                error = np.hypot(errors[i, other] * fitted[i, other], errors[j, place] * fitted[j, place])
                pairs.append((float(angles[i]), float(angles[j]), float(a / b - 1), float((a - b) / error)))
    return pairs
