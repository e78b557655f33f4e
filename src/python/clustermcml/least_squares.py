"""Least squares within bounds, and the small parts around it that fits share.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

from typing import Any, Callable

import numpy as np

TINY = 1e-30  # stands for 0 in divisors and logarithms


def lagrange(grid: Any, x: float) -> tuple[int, Any]:
    """Returns the first of four places of an even grid around x, and their weights for cubic interpolation."""
    t = (x - grid[0]) / (grid[1] - grid[0])
    first = int(np.clip(np.floor(t) - 1, 0, len(grid) - 4))
    s = t - first
    return first, np.array([np.prod([(s - m) / (k - m) for m in range(4) if m != k]) for k in range(4)])


def jacobian(residual: Callable[[Any], Any], u: Any) -> Any:
    h = 1e-4
    return np.stack([(residual(u + h * e) - residual(u - h * e)) / (2 * h) for e in np.eye(len(u))], axis=1)


def minimum(residual: Callable[[Any], Any], u: Any, low: Any, high: Any) -> Any:
    """Minimises the sum of squares within bounds by steps of Levenberg and Marquardt. A parameter stopped at a bound stays
    there for a step."""
    damping, r = 1e-3, residual(u)
    for _ in range(200):
        J = jacobian(residual, u)
        gradient = J.T @ r
        free = ~(((u <= low) & (gradient > 0)) | ((u >= high) & (gradient < 0)))
        if not free.any() or damping > 1e10:
            break
        A = J[:, free].T @ J[:, free]
        step = np.zeros(len(u))
        step[free] = -np.linalg.lstsq(A + damping * np.diag(np.diag(A) + 1e-12), gradient[free], rcond=None)[0]
        there = np.clip(u + step, low, high)
        trial = residual(there)
        if trial @ trial <= r @ r:
            moved = np.abs(there - u).max()
            u, r, damping = there, trial, damping / 5
            if moved < 1e-7:
                break
        else:
            damping *= 5
    return u


def start(residual: Callable[[Any], Any], low: Any, high: Any) -> Any:
    """Returns the best point of an even net between the bounds."""
    n = {1: 41, 2: 17}.get(len(low), 7)
    net = np.stack(np.meshgrid(*[np.linspace(a, b, n) for a, b in zip(low, high)], indexing="ij"), -1).reshape(-1, len(low))
    return min(net, key=lambda u: float(np.sum(residual(u) ** 2)))


def root(correlation: Any) -> Any:
    """Returns a matrix R with R R^T = correlation."""
    values, axes = np.linalg.eigh(correlation)
    return axes * np.sqrt(np.maximum(values, 0))


def correlation(covariance: Any) -> Any:
    sigma = np.maximum(np.sqrt(np.diag(covariance)), TINY)
    return covariance / np.outer(sigma, sigma)


def unlikely(chi2: float, degrees: int) -> bool:
    """True if chi2 lies more than 4 standard deviations above its mean. Normal approximation: E. B. Wilson and M. M. Hilferty
    (1931)."""
    width = 2 / (9 * max(degrees, 1))
    return bool((chi2 / max(degrees, 1)) ** (1 / 3) > 1 - width + 4 * width**0.5)
