"""Curves for radial profiles: sums of exponentials, sums of Gaussians, and Burley's profile.

A profile is a list of shares of the light: one share for each ring between two radii, and one for the light beyond the last
radius. A sum has the cumulative distribution 1 - sum w exp(-x), with x = r / d for exponentials and x = (r / sigma)^2 / 2 for
Gaussians.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import itertools
import warnings
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from . import errors

TERMS = {"exponentials": 3, "gaussians": 6}
ENOUGH = 0.02  # L1 beyond the noise above which a fourth exponential is tried
STARTS = (0.03, 0.1, 0.3, 1.0, 2.0)  # starting lengths, in units of the mean radius
CLOSEST = 1.3  # least ratio of neighbouring lengths: closer lengths get large weights of opposite signs, and fit no better
SMOOTHED = 9  # bins over which the light is averaged for the weights of the fit
NEGATIVE = -1e-9  # lower limit of a sum that may touch 0, because of rounding
LEAST = 1e-9  # share that a darker bin counts as in the weights of the fit, which would otherwise grow without limit
MARGIN = 1e-6  # distance from 0 that is kept by a sum that would be negative
WIDE = (1e-4, 1e2)  # bounds of lengths in units of the mean radius


@dataclass
class Curve:
    """A fitted sum. lengths: d or sigma [cm]. weights_se, lengths_se: standard errors from the noise of the flight. shares: of
    the light, as in Shares."""

    weights: Any
    weights_se: Any
    lengths: Any
    lengths_se: Any
    shares: Any
    L1: float


@dataclass
class Shares:
    """A profile. edges: radii between bins [cm], from 0. light, light_se: share of the light in each bin, and last the share
    beyond all bins. The sum is 1."""

    edges: Any
    light: Any
    light_se: Any

    def weights(self) -> Any:
        """Returns weights of residuals: 1 / sqrt(light). The light is averaged over neighbours, so that its noise does not bias
        the fit."""
        from scipy.ndimage import uniform_filter1d
        smooth = np.append(uniform_filter1d(self.light[:-1], SMOOTHED, mode="nearest"), self.light[-1])
        return 1 / np.sqrt(np.maximum(smooth, LEAST))

    def mean_radius(self) -> float:
        """Returns the mean radius [cm] of the light. Light beyond the last edge counts as on it."""
        middles = (self.edges[1:] + self.edges[:-1]) / 2
        return float(self.light[:-1] @ middles + self.light[-1] * self.edges[-1])

    def noise(self) -> float:
        """Returns the mean L1 between the true profile and this noisy one."""
        return float(np.sqrt(2 / np.pi) * self.light_se.sum())

    def error_of(self, shares: Any) -> float:
        """Returns L1 of a model: the integral of |model - S| 2 pi r dr / Rd."""
        return float(np.abs(shares - self.light).sum())


def need_scipy() -> None:
    """Raises an exception with the cure if scipy is missing."""
    try:
        import scipy  # noqa: F401
    except ImportError:
        raise errors.ClustermcmlError("scipy is missing (expected it for fits of profiles: apt-get install python3-scipy, or pip install scipy)", 5) from None


def shares_of(kind: str, edges: Any, lengths: Any) -> Any:
    """Returns the shares of the light of every single term, [terms, bins + 1]."""
    x = edges / np.asarray(lengths)[:, None]
    below = 1 - np.exp(-x * x / 2 if kind == "gaussians" else -x)
    return np.diff(below, axis=1, append=1.0)


def _weights(terms: Any, profile: Shares, scale: Any, positive: bool) -> Any:
    """Returns the weights, of sum 1, that bring the sum of the terms nearest to the profile."""
    from scipy.optimize import nnls
    if positive:
        heavy = 1e3 * np.linalg.norm(scale * profile.light)
        found, _ = nnls(np.vstack([(terms * scale).T, np.full(len(terms), heavy)]), np.append(profile.light * scale, heavy))
        return found / found.sum()
    rest = np.linalg.lstsq(((terms[:-1] - terms[-1]) * scale).T, (profile.light - terms[-1]) * scale, rcond=None)[0]
    return np.append(rest, 1 - rest.sum())


def _lengths(steps: Any) -> Any:
    """Returns lengths in units of the mean radius. steps: logarithms of the first length and of the ratios of neighbours."""
    return np.exp(np.cumsum(steps))


def _search(kind: str, profile: Shares, start: Any, positive: bool) -> tuple[float, Any, Any]:
    """Finds the best sum from one start. Returns its cost, weights and lengths."""
    from scipy.optimize import least_squares
    scale, unit, count = profile.weights(), profile.mean_radius(), len(start)

    def residual(steps: Any) -> Any:
        terms = shares_of(kind, profile.edges, unit * _lengths(steps))
        return (_weights(terms, profile, scale, positive) @ terms - profile.light) * scale
    first = np.log(np.append(start[0], np.divide(start[1:], start[:-1])))
    low = np.append(np.log(WIDE[0]), np.full(count - 1, np.log(CLOSEST)))
    high = np.append(np.log(WIDE[1]), np.full(count - 1, np.log(WIDE[1])))
    found = least_squares(residual, first, bounds=(low, high), xtol=1e-8, ftol=1e-8, max_nfev=100)
    lengths = unit * _lengths(found.x)
    return float(found.cost), _weights(shares_of(kind, profile.edges, lengths), profile, scale, positive), lengths


def _positive(profile: Shares, weights: Any, lengths: Any) -> tuple[float, Any, Any]:
    """Finds the best sum of exponentials that is nowhere negative. weights, lengths: a start that is negative somewhere.
    Returns cost, weights and lengths."""
    from scipy.optimize import minimize
    scale, unit, count = profile.weights(), profile.mean_radius(), len(weights)

    def parts(x: Any) -> tuple[Any, Any]:
        return np.append(x[: count - 1], 1 - x[: count - 1].sum()), unit * _lengths(x[count - 1 :])

    def cost(x: Any) -> float:
        w, d = parts(x)
        return 500 * float((((w @ shares_of("exponentials", profile.edges, d) - profile.light) * scale) ** 2).sum())
    start = np.concatenate([weights[:-1], np.log(np.append(lengths[0] / unit, lengths[1:] / lengths[:-1]))])
    limits = [(None, None)] * (count - 1) + [tuple(np.log(WIDE))] + [(np.log(CLOSEST), np.log(WIDE[1]))] * (count - 1)
    r = np.append(0.0, np.geomspace(lengths.min() / 10, 10 * lengths.max(), 60))

    def above(x: Any) -> Any:
        w, d = parts(x)
        return unit * (w / d) @ np.exp(-r / d[:, None]) - MARGIN
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = minimize(cost, start, method="SLSQP", bounds=limits, constraints={"type": "ineq", "fun": above}, options={"maxiter": 200, "ftol": 1e-10})
    return (found.fun / 1000, *parts(found.x))


def lowest(weights: Any, lengths: Any) -> float:
    """Returns the least value of S r over all radii, relative to its largest. A negative result means that the sum is no
    density."""
    r = np.append(0.0, np.geomspace(lengths.min() / 100, 40 * lengths.max(), 400))
    values = (weights / lengths) @ np.exp(-r / lengths[:, None])
    return float((values / np.abs(values).max()).min())


def _errors(profile: Shares, weights: Any, lengths: Any) -> tuple[Any, Any]:
    """Returns standard errors of weights and lengths of exponentials: errors of the bins, carried through the least squares.
    The last weight is 1 minus all others."""
    terms, x = shares_of("exponentials", profile.edges, lengths), profile.edges / lengths[:, None]
    slope = -np.diff(x * np.exp(-x), axis=1, append=0.0)
    free = weights != 0  # a weight held at 0 by its bound has no error, and its length has no meaning
    J = np.vstack([(terms[:-1] - terms[-1])[free[:-1]], (weights[:, None] * slope)[free]]).T
    scale = profile.weights()[:, None]
    spread = np.linalg.pinv(J * scale) * scale.T * profile.light_se
    covariance = spread @ spread.T
    count = int(free[:-1].sum())
    weights_se, lengths_se = np.zeros(len(weights)), np.full(len(weights), np.nan)
    weights_se[:-1][free[:-1]] = np.sqrt(np.diag(covariance)[:count])
    weights_se[-1] = np.sqrt(max(covariance[:count, :count].sum(), 0.0))
    lengths_se[free] = lengths[free] * np.sqrt(np.diag(covariance)[count:])
    return weights_se, lengths_se


def _curve(kind: str, profile: Shares, weights: Any, lengths: Any) -> Curve:
    shares = weights @ shares_of(kind, profile.edges, lengths)
    if kind == "gaussians":  # unknown errors: linear ones were up to 4 times too small, because neighbours overlap and the search ends in a flat valley
        weights_se, lengths_se = np.full((2, len(weights)), np.nan)
    else:
        weights_se, lengths_se = _errors(profile, weights, lengths)
    return Curve(weights, weights_se, lengths, lengths_se, shares, profile.error_of(shares))


def _exponentials(profile: Shares, count: int) -> Curve:
    """Fits the best sum of `count` exponentials that is nowhere negative. If there is none, the sum has fewer terms."""
    for number in range(count, 0, -1):
        found = [_search("exponentials", profile, np.array(start), False) for start in itertools.combinations(STARTS, number)]
        best = min(found, key=lambda one: one[0])
        found += [_positive(profile, *best[1:])] if lowest(*best[1:]) < NEGATIVE else []
        sound = [one for one in found if lowest(one[1], one[2]) >= NEGATIVE]
        if sound:
            return _curve("exponentials", profile, *min(sound, key=lambda one: one[0])[1:])
    raise AssertionError("a single exponential is positive")


def fit_sum(kind: str, profile: Shares, terms: Optional[int] = None) -> Curve:
    """Fits the best sum of exponentials with signed weights, or of Gaussians with positive weights. terms: number of terms.

    With terms=None there are six Gaussians, or three exponentials; four exponentials if three are off by more than 2 % beyond
    the noise."""
    need_scipy()
    count = terms or TERMS[kind]
    if kind == "gaussians":
        return _curve(kind, profile, *_search(kind, profile, np.geomspace(0.1, 3, count), True)[1:])
    found = _exponentials(profile, count)
    if terms is None and found.L1**2 > profile.noise() ** 2 + ENOUGH**2:
        found = min(found, _exponentials(profile, count + 1), key=lambda one: one.L1)
    return found


def fit_burley(profile: Shares) -> Curve:
    """Fits Burley's profile: exponentials of the lengths d and 3 d with the weights 1/4 and 3/4."""
    need_scipy()
    from scipy.optimize import minimize_scalar
    scale, unit, weights, ratios = profile.weights(), profile.mean_radius(), np.array([0.25, 0.75]), np.array([1.0, 3.0])

    def shares(step: float) -> Any:
        return weights @ shares_of("burley", profile.edges, unit * np.exp(step) * ratios)

    found = minimize_scalar(lambda step: float((((shares(step) - profile.light) * scale) ** 2).sum()), bounds=np.log(WIDE), method="bounded", options={"xatol": 1e-10})
    d = float(unit * np.exp(found.x))
    slope = (shares(found.x + 1e-4) - shares(found.x - 1e-4)) / 2e-4 * scale
    error = d * float(np.linalg.norm(slope * scale * profile.light_se) / (slope @ slope))
    return Curve(weights, np.zeros(2), d * ratios, error * ratios, shares(found.x), profile.error_of(shares(found.x)))


def single_albedo(Rd: float) -> float:
    """Returns the single-scattering albedo a of an index-matched isotropic half space that reflects the share Rd of diffuse
    light.

    The formula is van de Hulst's: Rd = (1 - s) (1 - 0.139 s) / (1 + 1.17 s), s = sqrt(1 - a)."""
    b = 1.139 + 1.17 * Rd
    s = (b - np.sqrt(b * b - 4 * 0.139 * (1 - Rd))) / (2 * 0.139)
    return float(1 - s * s)


def scaled(profile: Shares, walk: Shares) -> tuple[float, Any]:
    """Scales a random walk that was flown with a mean free path of 1 cm to the profile's mean radius. Returns the mean free
    path [cm] that does so, and the shares of the scaled walk in the profile's bins."""
    need_scipy()
    from scipy.optimize import brentq
    below = np.append(0.0, np.cumsum(walk.light[:-1]))

    def shares(step: float) -> Any:
        return np.diff(np.interp(profile.edges / np.exp(step), walk.edges, below), append=1.0)

    def excess(step: float) -> float:
        return Shares(profile.edges, shares(step), 0.0).mean_radius() - profile.mean_radius()
    middle = np.log(profile.mean_radius() / walk.mean_radius())
    step = float(brentq(excess, middle - 5, middle + 5, xtol=1e-12))
    return float(np.exp(step)), shares(step)
