"""Numbers of a fit that know nothing of light: interpolation, the best point of a net, and roots of matrices.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

from typing import Any, Callable

import numpy as np


def lagrange(grid: Any, x: float) -> tuple[int, Any]:
    """Returns the first of four places of an even grid around x, and their weights for cubic interpolation."""
    t = (x - grid[0]) / (grid[1] - grid[0])
    first = int(np.clip(np.floor(t) - 1, 0, len(grid) - 4))
    s = t - first
    return first, np.array([np.prod([(s - m) / (k - m) for m in range(4) if m != k]) for k in range(4)])


def start(residual: Callable[[Any], Any], low: Any, high: Any) -> Any:
    """Returns the best point of an even net between the bounds."""
    n = {1: 41, 2: 17}.get(len(low), 7)
    net = np.stack(np.meshgrid(*[np.linspace(a, b, n) for a, b in zip(low, high)], indexing="ij"), -1).reshape(-1, len(low))
    return min(net, key=lambda u: float(np.sum(residual(u) ** 2)))


def root(correlation: Any) -> Any:
    """Returns a matrix R with R R^T = correlation."""
    values, axes = np.linalg.eigh(correlation)
    return axes * np.sqrt(np.maximum(values, 0))
