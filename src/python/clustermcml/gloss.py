"""Light that leaves, sorted by the half vector between the direction to the light and the direction of exit: the cells of RGL's
`.bsdf` files.

A cell holds the value at a node k / (M - 1) of u = sqrt(2 theta_m / pi) and v = (phi_m + pi) / (2 pi). theta_m and phi_m are
the angles of the half vector m, in the frame in which the light comes from azimuth 0. A lobe about the mirrored direction lies
at small u for every angle of incidence.

             light     m (half vector)
                  \    |    exit
                   \   |   /
                    \  |  /
    surface  ________\_|_/________

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

from typing import Any

import numpy as np

ENOUGH = 50  # least number of packets in a cell; cells with fewer are joined with neighbours
CELLS = 64  # along each axis
PARTS = 8  # parts of a cell along each axis in the integral of its solid angle


def exits(u: Any, v: Any, theta_i: float) -> tuple[Any, Any, Any]:
    """Returns three things about exits at u, v: the cosine of the exit, the azimuth of the flight against the light's [rad],
    and the cosine between light and half vector."""
    theta, phi = np.pi / 2 * u**2, 2 * np.pi * v - np.pi
    m = np.stack(np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)))
    light = np.array([np.sin(theta_i), 0.0, np.cos(theta_i)])
    along = np.tensordot(light, m, 1)
    out = 2 * along * m - light.reshape(3, *[1] * (m.ndim - 1))
    return out[2], np.arctan2(-out[1], -out[0]), along


def finer(cells: Any) -> Any:
    """Returns values at 2 n - 1 nodes along each axis from values at n nodes, by linear interpolation."""
    for axis in (0, 1):
        cells = np.moveaxis(cells, axis, 0)
        between = np.empty((2 * len(cells) - 1, *cells.shape[1:]))
        between[::2], between[1::2] = cells, (cells[1:] + cells[:-1]) / 2
        cells = np.moveaxis(between, 0, axis)
    return cells


def with_means(values: Any, angles: Any) -> Any:
    """Values at the nodes [angle, v, u] whose linear interpolation has the means over cells that the smooth function with these values has.
    Interpolation of the values themselves is too large where the function bends upwards, as all do towards the horizon."""
    found, once = np.array(values), values[:, :-1]  # the first and the last v are the same direction
    found[:, :-1] -= (np.roll(once, 1, axis=1) + np.roll(once, -1, axis=1) - 2 * once) / 12
    found[:, -1] = found[:, 0]
    found[:, :, 1:-1] -= np.diff(values, 2, axis=2) / 12
    if len(angles) > 2:
        low, high = np.diff(angles)[:-1, None, None], np.diff(angles)[1:, None, None]
        found[1:-1] -= low * high / 6 * (np.diff(values, axis=0)[1:] / high - np.diff(values, axis=0)[:-1] / low) / (low + high)
    return found


def beside(wanted: Any) -> Any:
    """The nodes [v, u] that are wanted, and the corners of all cells with one of these."""
    rows = wanted | np.roll(wanted, 1, axis=0) | np.roll(wanted, -1, axis=0)
    found = rows.copy()
    found[:, 1:] |= rows[:, :-1]
    found[:, :-1] |= rows[:, 1:]
    return found


def nodes(size: int) -> tuple[Any, Any]:
    """Returns u and v at all nodes, each [v, u]."""
    axis = np.arange(size) / (size - 1)
    v, u = np.meshgrid(axis, axis, indexing="ij")
    return u, v


def _measure(size: int, theta_i: float) -> Any:
    """Returns the projected solid angle [sr] of the exits above the horizon in each cell [v, u]."""
    steps = (size - 1) * PARTS
    middles = (np.arange(steps) + 0.5) / steps
    v, u = np.meshgrid(middles, middles, indexing="ij")
    cosine, _, along = exits(u, v, theta_i)
    solid = 4 * along * np.sin(np.pi / 2 * u**2) * np.pi * u * 2 * np.pi / steps**2
    cell = np.minimum((np.arange(steps) + PARTS // 2) // PARTS, size - 1)
    rows = np.zeros((size, steps))
    np.add.at(rows, cell, np.where((cosine > 0) & (along > 0), solid * cosine, 0.0))
    found = np.zeros((size, size))
    np.add.at(found.T, cell, rows.T)
    return found


def _mirrored(cells: Any) -> Any:
    """Returns cells [v, u] plus those at -phi_m, where an isotropic material has equal light."""
    return cells + cells[::-1]


def _blocks(cells: Any, side: int) -> Any:
    """Returns cells in which each has the sum over its block of side x side cells."""
    starts, block = np.arange(0, len(cells), side), np.arange(len(cells)) // side
    return np.add.reduceat(np.add.reduceat(cells, starts, axis=0), starts, axis=1)[block][:, block]


def cells_of(weights: Any, flights: Any, theta_i: float, size: int) -> Any:
    """Sorts packets by half vector. Returns f [1/sr] in cells [v, u].

    weights: per launched packet. flights: directions [n, 3], z outward; the light flies towards +x. Cells with fewer than
    ENOUGH packets share the mean of all such cells in the smallest block (2 x 2, 4 x 4 ...) in which these cells together have
    ENOUGH. No light is lost or counted twice."""
    half = flights + np.array([-np.sin(theta_i), 0.0, np.cos(theta_i)])
    half /= np.linalg.norm(half, axis=1)[:, None]
    theta = np.arctan2(np.hypot(half[:, 0], half[:, 1]), half[:, 2])
    phi = np.arctan2(-half[:, 1], -half[:, 0])
    u = np.rint(np.sqrt(2 * theta / np.pi) * (size - 1)).astype(int).clip(0, size - 1)
    v = np.rint((phi + np.pi) / (2 * np.pi) * (size - 1)).astype(int).clip(0, size - 1)
    light, count = np.zeros((size, size)), np.zeros((size, size))
    np.add.at(light, (v, u), weights)
    np.add.at(count, (v, u), 1)
    light, count, measure = _mirrored(light), _mirrored(count), _mirrored(_measure(size, theta_i))
    found, left = np.zeros((size, size)), np.ones((size, size), bool)
    for level in range(int(np.ceil(np.log2(size))) + 1):
        sums = [_blocks(np.where(left, part, 0), 1 << level) for part in (light, count, measure)]
        full = left & (sums[2] > 0) & ((sums[1] >= ENOUGH) | (1 << level >= size))
        found[full] = sums[0][full] / sums[2][full]
        left &= ~full
    return found
