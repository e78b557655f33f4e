"""Tests if two results agree within their noise: totals, every bin of every array that both have, and the sums of these arrays.

Every number is first turned into weight per launched packet. The test is z = (a - b) / (error of the difference).

Errors: files of this program carry standard errors. For a file without errors (original MCML), the ratio of the mean square to
the mean of a packet's score is taken from the other file, over a range of bins with enough packets. If neither file has errors,
or the other file was sampled on a lattice, the ratio is set to 1, the largest value for scores up to 1. The test may then miss
real differences, but invents none. If both files have errors, the larger of two variances counts: the sum of both, and the
variance common to both. A run of few packets cannot understate the common one by luck. Printed digits count as a rounding
error.

Few packets: neighbouring bins are joined until the smaller run has ENOUGH packets of the mean weight in them. Errors of
reflected and transmitted bins add in squares, because a packet ends in one bin. Errors of absorbed light and of fluence add
linearly, because a packet scores in many bins; time gates of absorbed light correlate by up to 0.9. The sum of an array is one
more test, which finds a small difference in many bins. z is a deviate of Student's t, turned into the normal deviate of equal
tail. Sidak's correction over all tests is exact for independent tests and conservative for correlated ones. Means and
derivatives are tested number by number and have no sum.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import json
import math
import os
import re
import sys
from itertools import zip_longest
from typing import Any, NamedTuple, Optional, Union

import numpy as np

from . import errors
from .command_line import Parser, check_overwrite, picture_path, print_text, readable, shown_path
from .fields import OF_DETECTED, Field, Fields
from .pictures import draw_comparison
from .results import read_as

ENOUGH = 20.0  # least number of packets of the mean weight, in the smaller run, that make a test
WIDER = 500.0  # number of packets that tell the scatter of scores
BATCHES, GROUPS = 64, 16  # numbers of parts of a run that errors come from; arrays of cells, directions and facets use groups of batches
TOTALS = ("Rsp", "Rd", "A", "Tt", "A_face", "A_backing")
OF_MCML = ("A_z", "Rd_r", "Rd_a", "Tt_r", "Tt_a")
GIVEN = re.compile(r"(layer|body)_(n|mua|mus|g|d)|body_of_facet|(\w+_)?area")  # arrays that repeat the scene or belong to a shape, and are not tested
MOST = 1e100  # squares of larger numbers would overflow
LISTED = 5  # number of the worst tests that are shown
UNITS = {"r": "r [cm]", "z": "z [cm]", "gate": "t [ps]", "alpha": "a [rad]"}


class Group(NamedTuple):
    """Neighbouring bins that are tested together, or a whole array: sums over the bins, in both files."""

    first: int
    last: int
    measure: float  # value times measure is weight per packet
    mean: tuple[float, float]
    squares: tuple[float, float]  # sum of the squared errors of the bins
    linear: tuple[float, float]
    rounding: float  # variance of the difference that comes from printed digits


class Test(NamedTuple):
    """One test. Values and errors are means over its bins, in the unit of the files."""

    name: str
    first: int
    last: int
    value: tuple[float, float]
    error: tuple[float, float]
    z: float
    p: float
    whole: bool  # True for the sum over all bins


class Array:
    """One array of both files, and the tests of its bins."""

    def __init__(self, name: str, results: list[Fields], known: list[bool]) -> None:
        array = results[0][name]
        self.name, self.dims, self.shape, self.axes, self.units = name, array.dims, array.shape, array.axes, array.attrs.get("units", "1")
        self.packets = [float(result.attrs["photons"]) for result in results]
        self.lends = [result.attrs.get("sampling", "random") != "lattice" for result in results]
        self.total = name in TOTALS
        self.alone = "inside" in self.dims or "side" in self.dims or OF_DETECTED.fullmatch(name) is not None
        facets = bool(re.search("_(irradiance|exitance)_", name)) or any(str(dim).endswith("facet") for dim in self.dims)
        self.deep = facets or bool({"z", "z_volume", "layer", "body"} & set(self.dims)) or name.startswith(("A_", "phi_"))  # a packet scores in many bins
        self.split = any("aim" in result.attrs for result in results)  # a packet may end in several places
        cells = facets or "z_volume" in self.dims or name in ("A_rz", "Rd_ra", "Tt_ra") or name.startswith(("Rd_rt", "Tt_rt", "phi_rzt"))
        self.freedom = float((GROUPS if cells or _is_of_cells(self.dims) or "theta" in self.dims else BATCHES) - 1)
        self.need_errors = self.alone or cells or bool({"layer", "body"} & set(self.dims)) and name != "A_l_expected"
        self.value = [np.ravel(result[name].values).astype(float) for result in results]
        self.error: list[Any] = [self._errors(result, known[k]) for k, result in enumerate(results)]
        self.bounded = name == "A_z"
        self.measure = _measures(array)
        self.width = _width(array.axes[array.dims[0]]) if len(self.dims) == 1 and self.dims[0] in UNITS else 1.0

    def _errors(self, result: Fields, known: bool) -> Any:
        found = np.ravel(result[self.name + "_se"].values).astype(float) if known and self.name + "_se" in result else None
        if found is not None and (self.alone or not np.isnan(found).any()):
            return found
        return np.zeros(1) if self.name == "Rsp" and not known else None

    def _add(self, i: int, digits: int) -> Group:
        """Returns bin i as a group: means, errors, and the rounding of printed digits in both files."""
        measure, mean, sigma, rounding = float(self.measure[i]), [0.0, 0.0], [0.0, 0.0], 0.0
        for k in (0, 1):
            value = float(self.value[k][i])
            mean[k] = value * measure
            sigma[k] = float(self.error[k][i]) * measure if self.error[k] is not None else 0.0
            if value != 0:
                rounding += (10 ** (math.floor(math.log10(abs(value))) + 1 - digits) / math.sqrt(12) * measure) ** 2
        return Group(i, i, measure, (mean[0], mean[1]), (sigma[0] ** 2, sigma[1] ** 2), (sigma[0], sigma[1]), rounding)

    def bins(self) -> list[Group]:
        return [self._add(i, 6 if self.total else 5) for i in range(self.value[0].size)]

    def own_variance(self, group: Group, k: int) -> float:
        """Returns the variance of one packet's score in file k, from the errors of that file. Absorbed weight is at most the
        launched weight."""
        n = self.packets[k]
        if not self.deep or group.first == group.last:
            return n * group.squares[k]
        most = n * group.linear[k] ** 2
        return min(most, group.mean[k]) if self.bounded else most

    def typical_score(self, bins: list[Group], group: Group, k: int) -> float:
        """Returns the mean square over the mean of a packet's score in file k.

        The bins of the group are used if they hold enough packets. Otherwise a wider range is used, because in few packets the
        scatter is large when the mean is. If the whole profile has too few packets, returns 1, the largest ratio for scores up
        to 1."""
        n, mean, below, above = self.packets[k], group.mean[k], group.first - 1, group.last + 1
        square = n * group.squares[k] + mean ** 2
        while _packets(n, mean, square) < WIDER and (below >= 0 or above < len(bins)):
            for i in (below, above):
                if 0 <= i < len(bins):
                    mean += bins[i].mean[k]
                    square += n * bins[i].squares[k] + bins[i].mean[k] ** 2
            below, above = below - 1, above + 1
        return square / mean if _packets(n, mean, square) >= WIDER else 1.0

    def estimate(self, bins: list[Group], group: Group, mean: float) -> list[float]:
        """Returns variances per packet if a file has no errors: mean square less squared mean.

        The mean is that of both files, or the file's own if that is larger, so that a chance excess is not overrated. If
        one file has errors, it lends its mean square to the other. A file that was sampled on a lattice cannot lend, because its errors
        do not show the scatter of single packets; it keeps its own variance."""
        lender = 0 if self.error[0] is not None else 1
        lent = self.error[lender] is not None
        says = lent and self.lends[lender]
        score = self.typical_score(bins, group, lender) if says else 1.0
        own = self.own_variance(group, lender) if lent else 0.0
        variance = [max(own, score * max(mean, group.mean[k]) - mean ** 2) for k in (0, 1)]
        if lent and not says:
            variance[lender] = own
        return variance

    def spread(self, bins: list[Group], group: Group) -> tuple[list[float], float]:
        """Returns the variance of one packet's score in both files, and the number of packets of the mean weight that the
        smaller run has in the group."""
        n = self.packets
        mean = (n[0] * group.mean[0] + n[1] * group.mean[1]) / (n[0] + n[1])
        both = self.error[0] is not None and self.error[1] is not None
        v = [self.own_variance(group, k) for k in (0, 1)] if both else self.estimate(bins, group, mean)
        return v, _packets(min(n), mean, (n[0] * v[0] + n[1] * v[1]) / (n[0] + n[1]))

    def test(self, bins: list[Group], group: Group, whole: bool = False) -> Test:
        """Tests a group of bins. If both files have errors, the larger of two variances counts. Degrees of freedom: Welch,
        Biometrika 34 (1947) 28."""
        n, (v, _) = self.packets, self.spread(bins, group)
        variance = (v[0] / n[0], v[1] / n[1])
        common = (n[0] * v[0] + n[1] * v[1]) / (n[0] + n[1]) * (1 / n[0] + 1 / n[1])
        known, freedom, total = [error is not None for error in self.error], self.freedom, variance[0] + variance[1]
        if not any(known) or not total > 0:
            freedom = math.inf
        elif all(known):
            freedom *= total ** 2 / (variance[0] ** 2 + variance[1] ** 2)
        difference, noise = group.mean[0] - group.mean[1], math.sqrt(max(total, common) + group.rounding)
        z = 0.0 if difference == 0 else _normal_of_student(difference / noise if noise > 0 else math.copysign(math.inf, difference), freedom)
        value, error = (group.mean[0] / group.measure, group.mean[1] / group.measure), (math.sqrt(max(variance[0], 0)) / group.measure, math.sqrt(max(variance[1], 0)) / group.measure)
        return Test(self.name, group.first, group.last, value, error, z, math.erfc(abs(z) / math.sqrt(2)), whole)

    def groups(self, bins: list[Group]) -> list[Group]:
        """Joins bins to groups. A group ends when both runs together have enough packets; a choice by one run would favour its
        chance. The rest joins the last group."""
        closed: list[Group] = []
        open_: Optional[Group] = None
        for bin_ in bins:
            open_ = bin_ if open_ is None else _join(open_, bin_)
            if self.spread(bins, open_)[1] >= ENOUGH:
                closed.append(open_)
                open_ = None
        if closed and open_ is not None:
            closed[-1] = _join(closed[-1], open_)
        return closed

    def tests(self) -> list[Test]:
        bins = self.bins()
        found = self.groups(bins)
        tests = [self.test(bins, group) for group in found]
        if len(found) > 1:
            self.bounded, self.deep = self.name.startswith("A_"), self.deep or self.split
            tests.append(self.test(bins, _all(bins), True))
        return tests

    def tests_alone(self, seen: list[tuple[float, float]]) -> list[Test]:
        """Tests every number alone, if both errors are known and enough packets were seen."""
        if min(self.packets) < BATCHES * ENOUGH or not all(value >= math.sqrt(ENOUGH) * error for value, error in seen):
            return []
        good = [i for i in range(self.value[0].size) if all(np.isfinite(self.value[k][i]) and self.error[k][i] > 0 for k in (0, 1))]
        return [self.test([], self._add(i, 5)) for i in good]

    def place(self, test: Test) -> str:
        """Names the bins of a test: "r [cm] 0.12..0.13", "layer 2", "x = 0.1 cm, y = -0.2 cm, z = 0.05 cm and 3 more"."""
        if test.whole:
            return "the sum"
        if not self.dims:
            return ""
        if len(self.dims) == 1 and self.dims[0] in UNITS:
            low, high = self.ends(test)
            return f"{UNITS[str(self.dims[0])]} {low:.4g}..{high:.4g}"
        more = test.last - test.first
        if self.dims[0] in ("layer", "body") and len(self.dims) == 1:
            return f"{self.dims[0]} {test.first + 1}" + (f"..{test.last + 1}" if more else "")
        return ", ".join(_place_on(self.axes[dim], int(i)) for dim, i in zip(self.dims, np.unravel_index(test.first, self.shape))) + (f" and {more} more" if more else "")

    def ends(self, test: Test) -> tuple[float, float]:
        return test.first * self.width, (test.last + 1) * self.width


def _is_of_cells(dims: tuple[Any, ...]) -> bool:
    """True if an array has pixels, voxels or facets."""
    return any(str(dim) in ("x", "y", "z_volume") or str(dim).endswith(("facet", "_x", "_y")) for dim in dims)


def _place_on(axis: Field, i: int) -> str:
    """Returns the middle of bin i on the axis with its unit, or the number of the bin if the axis counts.

    >>> _place_on(Field([0.05, 0.15], ("z_volume",), {"units": "cm"}, "z_volume"), 1), _place_on(Field([1, 2], ("layer",), {"units": "1"}, "layer"), 1)
    ('z = 0.15 cm', 'layer 2')
    """
    name = {"gate": "t", "z_volume": "z"}.get(axis.name, re.sub(r"^detector_\w+_(?=[xy]$)", "", axis.name))
    unit = axis.attrs.get("units", "1")
    return f"{name} {axis.values[i]:g}" if unit == "1" else f"{name} = {axis.values[i]:.4g} {unit}"


def _packets(n: float, mean: float, variance: float) -> float:
    """Returns the number of packets of the mean weight that arrive from n launched packets, if one packet's score has this mean
    and variance."""
    if not mean > 0:
        return 0.0
    return n * mean * (mean / variance) if variance > 0 else math.inf


def _join(a: Group, b: Group) -> Group:
    return Group(a.first, b.last, a.measure + b.measure, (a.mean[0] + b.mean[0], a.mean[1] + b.mean[1]),
                 (a.squares[0] + b.squares[0], a.squares[1] + b.squares[1]), (a.linear[0] + b.linear[0], a.linear[1] + b.linear[1]), a.rounding + b.rounding)


def _all(bins: list[Group]) -> Group:
    whole = bins[0]
    for bin_ in bins[1:]:
        whole = _join(whole, bin_)
    return whole


def _width(axis: Field) -> float:
    """Returns the width of the bins of an axis. Bins from zero give it by their first middle. Pixels and voxels, which may
    begin anywhere, give it by two middles.

    >>> _width(Field([0.5, 1.5], ("r",), name="r"))
    1.0
    """
    values = axis.values
    return float(2 * values[0] if axis.name in ("r", "z", "alpha", "gate", "theta", "phi") or values.size < 2 else values[1] - values[0])


def _measures(array: Field) -> Any:
    """Returns the factor of each number that turns it into weight per packet: areas of rings, widths of bins and solid angles
    (projected beside r).

    Pixels and voxels get their equal size and facets get 1. Any factor will do there, as long as both files have the same."""
    measure = np.ones(array.shape)
    for at, dim in enumerate(array.dims):
        axis, width = array.axes[dim], _width(array.axes[dim]) if array.axes[dim].size and dim not in ("layer", "body", "medium", "inside", "side") else 1.0
        if dim == "r":
            factor: Any = 2 * np.pi * (np.arange(axis.size) + 0.5) * width ** 2
        elif dim == "alpha" and array.dims[0] == "r":
            factor = 2 * np.pi * math.sin(width / 2) * np.sin(2 * (np.arange(axis.size) + 0.5) * width)
        elif dim == "alpha" and len(array.dims) == 1:
            factor = 2 * np.pi * np.sin((np.arange(axis.size) + 0.5) * width) * width
        elif dim == "theta":
            factor = 2 * np.sin((np.arange(axis.size) + 0.5) * width) * math.sin(width / 2)
        elif dim in ("z", "gate", "phi", "x", "y", "z_volume"):
            factor = np.full(axis.size, width)
        else:
            continue
        measure *= factor.reshape([-1 if i == at else 1 for i in range(len(array.dims))])
    return np.ravel(measure)


def _normal_of_student(t: float, freedom: float) -> float:
    """Returns the normal deviate whose tail equals that of Student's t (Wallace, Ann. Math. Statist. 30 (1959) 1121)."""
    if not (freedom < math.inf and abs(t) < math.inf):
        return t
    return math.copysign((8 * freedom + 1) / (8 * freedom + 3) * math.sqrt(freedom * math.log1p(t * t / freedom)), t)


def limit_of(level: float, tests: int) -> float:
    """Returns the |z| that one of `tests` tests must exceed, so that all tests together keep the level (Sidak, J. Amer.
    Statist. Assoc. 62 (1967) 626).

    >>> round(limit_of(0.05, 1), 4)
    1.96
    """
    p = -math.expm1(math.log1p(-level) / max(tests, 1))
    low, high = 0.0, 40.0
    for _ in range(100):
        low, high = ((low + high) / 2, high) if math.erfc((low + high) / 2 / math.sqrt(2)) > p else (low, (low + high) / 2)
    return low


class Comparison:
    """The tests of two results. p: probability of a difference as large as the largest by chance, corrected for the number of
    tests."""

    def __init__(self, paths: list[str], names: list[str]) -> None:
        self.names = names
        self.results = [read_as(path) for path in paths]
        self.known = [_has_errors(result) for result in self.results]
        self.arrays: dict[str, Array] = {}
        self.found: dict[str, list[Test]] = {}
        self.left_out: list[str] = []
        self._check_grids()
        untallied = [not _tallied(result) for result in self.results]
        self.untallied = untallied[0] + 2 * untallied[1]
        for name in self._names():
            self._test(name)
        self.tests = [test for name in self.arrays for test in self.found[name]]
        self.worst = sorted(self.tests, key=lambda test: -abs(test.z))[:LISTED]
        self.p = -math.expm1(len(self.tests) * math.log1p(-self.worst[0].p)) if self.worst and self.worst[0].p < 1 else 1.0

    def _names(self) -> list[str]:
        """Returns the names of arrays that both results have: first totals, then original MCML's profiles, then all others."""
        both = [name for name in self.results[0].names() if name in self.results[1]]
        first = [name for name in TOTALS + OF_MCML if name in both]
        return first + [name for name in both if name not in first and not name.endswith("_se") and not GIVEN.fullmatch(name)]

    def _check_grids(self) -> None:
        """Refuses results whose bins differ. Materials may differ, because that is often the question."""
        a, b = self.results
        for dim, size, field in (("z", "nz", "dz"), ("r", "nr", "dr"), ("alpha", "na", ""), ("gate", "time: number of gates", "time: width of a gate"),
                                 ("theta", "directions: NT", ""), ("phi", "directions: NP", "")):
            if dim not in a or dim not in b:
                continue
            pairs = [(size, a[dim].size, b[dim].size)] + ([(field, _width(a[dim]), _width(b[dim]))] if field else [])
            for name, one, other in reversed(pairs):
                if abs(one - other) > 1e-5 * one:  # a length has six digits in an .mco file
                    raise errors.InputError(f"{self.names[1]}: {name} = {other:g} (expected {one:g}, as in {self.names[0]})")

    def _test(self, name: str) -> None:
        """Tests one array. Maps and voxels that both files have, but that cannot be tested, are noted in left_out. Other arrays
        that cannot be tested are skipped silently."""
        a, b = (result[name] for result in self.results)
        cells = _is_of_cells(a.dims)
        both = all(name + "_se" in result for result in self.results)
        if cells and not (both and _same_axes(a, b)):
            self.left_out.append(name)
        if cells and not (both and all(self.known) and _same_axes(a, b)):
            return
        mcml = name in TOTALS or name in OF_MCML
        if not (mcml or both) or not _same_axes(a, b) or name in ("A_z", "A_rz") and self.untallied:
            return
        array = Array(name, self.results, self.known)
        for k in (0, 1):
            self._check(array, k)
        if array.need_errors and any(error is None for error in array.error):
            return
        self.arrays[name], self.found[name] = array, array.tests_alone(self._seen(name)) if array.alone else array.tests()

    def _seen(self, name: str) -> list[tuple[float, float]]:
        """Returns the light that the detector of a mean has seen, with its error, in both files. Other arrays give an empty
        list."""
        mean = OF_DETECTED.fullmatch(name)
        return [(float(result[mean[1]]), float(result[mean[1] + "_se"])) for result in self.results if mean and mean[1] + "_se" in result]

    def _check(self, array: Array, k: int) -> None:
        """Refuses numbers that no run writes. NaN is allowed as the error of a single packet and as the mean of nothing."""
        least = -MOST if array.alone else 0.0
        none = array.alone or array.packets[k] < BATCHES
        for numbers, low, ending in ((array.value[k], least, ""), (array.error[k], 0.0, "_se")):
            if numbers is None:
                continue
            bad = np.flatnonzero(~((numbers >= low) & (numbers <= MOST)) & ~(np.isnan(numbers) & none))
            if bad.size:
                at = "".join(f"[{i}]" for i in np.unravel_index(bad[0], array.shape)) if array.shape else ""
                raise errors.InputError(f"{self.names[k]}: {array.name}{ending}{at} = {numbers[bad[0]]:g} (expected a number from {low:g} to {MOST:g})")

    def told(self, alpha: float) -> dict[str, Any]:
        """Returns the object that --json prints."""
        quantities = {}
        for name, array in self.arrays.items():
            tests = self.found[name]
            worst = max(tests, key=lambda test: abs(test.z), default=None)
            quantities[name] = {"bins": array.value[0].size if tests else 0, "tests": len(tests), "worst": self._json(worst) if worst else None,
                                "first": [test.first for test in tests if not test.whole], "z": [_finite(test.z) for test in tests if not test.whole],
                                "z_sum": next((_finite(test.z) for test in tests if test.whole), None)}
        return {"a": shown_path(self.names[0]), "b": shown_path(self.names[1]), "packets": [int(result.attrs["photons"]) for result in self.results],
                "tests": len(self.tests), "p": self.p, "alpha": alpha, "agree": not self.p < alpha, "quantities": quantities,
                "worst": [self._json(test) for test in self.worst]}

    def _json(self, test: Test) -> dict[str, Any]:
        array = self.arrays[test.name]
        lower, upper = array.ends(test) if len(array.dims) == 1 and array.dims[0] in UNITS else (0.0, 0.0)
        return {"quantity": test.name, "first": test.first, "last": test.last, "lower": lower, "upper": upper, "sum": test.whole, "a": test.value[0],
                "a_se": test.error[0], "b": test.value[1], "b_se": test.error[1], "z": _finite(test.z), "p": test.p, "unit": array.units}

    # ---- for people ----

    def summary(self, alpha: float) -> str:
        """Returns the summary for people: files, notes, totals, arrays, the worst tests, the verdict."""
        lines = [self._file(k) for k in (0, 1)] + self._notes() + [f"{'':5} {'a':>12} {'error':>10} {'b':>12} {'error':>10} {'z':>8}"]
        lines += [f"{test.name:5} {test.value[0]:12.6g} {test.error[0]:10.2g} {test.value[1]:12.6g} {test.error[1]:10.2g} {test.z:+8.2f}" for test in self.tests if test.name in TOTALS]
        for name, array in self.arrays.items():
            tests = self.found[name]
            if name in TOTALS or not tests and name not in OF_MCML:
                continue
            if not tests:
                lines.append(f"{name:5} not tested: too few packets")
                continue
            worst = max(tests, key=lambda test: abs(test.z))
            at = array.place(worst)
            lines.append(f"{name:5} {array.value[0].size} bins in {len(tests)} tests, worst z {worst.z:+.2f}" + (f" at {at}" if at else ""))
        if self.untallied:
            lines.append(f"A_z   not tested: {['', 'a did not tally it', 'b did not tally it', 'neither run tallied it'][self.untallied]}")
        lines.append("worst:")
        for t in self.worst:
            unit = self.arrays[t.name].units
            lines.append(f"  z {t.z:+6.2f}  p {t.p:<8.2g}  {t.name:4} {t.value[0]:11.5g} +- {t.error[0]:<8.2g} {t.value[1]:11.5g} +- {t.error[1]:<8.2g} {'-' if unit == '1' else unit:5} {self.arrays[t.name].place(t)}".rstrip())
        verdict = "they differ" if self.p < alpha else "no difference"
        return "\n".join(lines + [f"p = {self.p:.3g} (Sidak over {len(self.tests)} tests): {verdict} at the level {alpha:g}", ""])

    def _file(self, k: int) -> str:
        """Returns the line about file k. It says where the errors come from, because the weight of a difference depends on it."""
        words = "standard errors from the file"
        if not self.known[k]:
            words = "no standard errors: upper bounds"
            if self.known[1 - k]:
                lends = self.results[1 - k].attrs.get("sampling", "random") != "lattice"
                words = "no standard errors: variances of the other file" if lends else words + " (--sampling random in the other would find more)"
        return f"{'ab'[k]}: {shown_path(self.names[k])}, {self.results[k].attrs['photons']} packets, {words}"

    def _notes(self) -> list[str]:
        """Returns notes on what may explain a difference, or an agreement, and is not tested itself: seeds, layers, materials."""
        a, b = self.results
        notes = []
        if "seed" in a.attrs and all(a.attrs.get(name) == b.attrs.get(name) for name in ("seed", "run")):
            notes.append(f"both runs have seed {a.attrs['seed']}: they share their noise, so that agreement says little")
        layers = [result["layer"].size for result in self.results]
        if layers[0] != layers[1]:
            notes.append(f"{layers[0]} and {layers[1]} layers")
        for layer in range(min(layers)):
            for number in ("n", "mua", "mus", "g", "d"):
                one, other = (float(result["layer_" + number].values[layer]) for result in self.results)
                if one != other:
                    notes.append(f"layer {layer + 1}: {number} = {one:g} and {other:g}")
        for words in ("beam", "phases"):
            lines = [str(result.attrs.get(words, "")).strip().splitlines() for result in self.results]
            for line, other_line in zip_longest(*lines, fillvalue="none") if all(lines) else ():
                if line != other_line:
                    notes.append(f"{line} and {other_line}")
        if self.left_out:
            notes.append("without errors, or with other bins: " + ", ".join(self.left_out))
        return ["note: " + note for note in notes]


def _finite(z: float) -> float:
    """Bounds z for JSON, which has no infinity. An infinite z is a difference without any noise."""
    return min(max(z, -1e300), 1e300)


def _has_errors(result: Fields) -> bool:
    """True if the result has standard errors of its totals. Fewer packets than batches have none."""
    return result.attrs["photons"] >= BATCHES and all(name + "_se" in result and not np.isnan(float(result[name + "_se"])) for name in TOTALS[:4])


def _tallied(result: Fields) -> bool:
    return "A_z" in result and bool((result["A_z"].values > 0).any()) or not float(result["A"]) > 0


def _same_axes(a: Field, b: Field) -> bool:
    """True if the axes of two arrays are equal up to their printed digits."""
    if a.dims != b.dims or a.shape != b.shape:
        return False
    for dim in a.dims:
        one, other = (array.axes[dim].values.astype(float) for array in (a, b))
        if one.size and not (abs(one - other) <= 1e-5 * (abs(one[0]) + abs(one[-1]))).all():
            return False
    return True


def compare(a: Union[str, os.PathLike[str]], b: Union[str, os.PathLike[str]], alpha: float = 0.01, output: Union[str, os.PathLike[str], None] = None) -> dict[str, Any]:
    """Tests whether two results agree within their noise.

    Args:
        a: Path of an `.mco` or `.h5`.
        b: Path of another result on the same grid.
        alpha: Level of the test, above 0 and below 1.
        output: Path of a picture of z over every profile: .svg, .png, .pdf or .eps; None draws nothing.

    Returns:
        A dict with `agree`, `p`, the `worst` tests, and the tests of all `quantities`.
    """
    errors.number("alpha", alpha, math.ulp(0.0), 1 - 2**-53, "a number above 0 and below 1")
    picture = None if output is None else picture_path(output)
    files = [errors.existing_file("a", a), errors.existing_file("b", b)]
    comparison = _compared(files, files)
    if picture is not None:
        draw_comparison(comparison, alpha, picture)
    return comparison.told(alpha)


def _compared(paths: list[str], names: list[str]) -> Comparison:
    comparison = Comparison(paths, names)
    if not comparison.tests:
        packets = [result.attrs["photons"] for result in comparison.results]
        raise errors.InputError(f"compare: {names[0]} and {names[1]}: {packets[0]:g} and {packets[1]:g} packets (expected more packets: no number has enough to be compared)")
    return comparison


def main(words: list[str]) -> int:
    """Runs the command `compare`. The exit code is 1 if the results differ, which scripts can tell from an error."""
    parser = Parser("compare", "a.mco b.mco", "Tests the totals, every bin of every array and the sums of arrays of two results on the same grid, ours or original "
                    "MCML's. Prints z and a p-value that is corrected for the number of tests. Exit code 1 where they differ.", "clustermcml compare a.mco b.mco -o z.svg")
    parser.add_argument("files", nargs=2, metavar="FILE", help=".mco or .h5")
    parser.add_output("a picture of z over every profile: .svg, .png, .pdf or .eps")
    parser.add_argument("--alpha", type=parser.number("a number above 0 and below 1", math.ulp(0.0), 1 - 2**-53), default=0.01, metavar="A", help="p below it is a difference, default 0.01")
    parser.add_argument("--json", action="store_true", help="one line with one object on standard output, nothing else there")
    parser.add_argument("--quiet", action="store_true", help="no summary")
    given = parser.parse_args(words)
    check_overwrite("compare", given.output, given.files)
    comparison = _compared([readable(path) for path in given.files], given.files)
    if given.output is not None:
        draw_comparison(comparison, given.alpha, given.output)
    text = json.dumps(comparison.told(given.alpha), separators=(",", ":")) + "\n" if given.json else "" if given.quiet else comparison.summary(given.alpha)
    code = print_text(text) if text else 0
    if code or not comparison.p < given.alpha:
        return code
    worst = comparison.worst[0]
    print(f"clustermcml: {shown_path(given.files[0])} and {shown_path(given.files[1])} differ: p = {comparison.p:.3g}, worst z = {worst.z:+.2f} in {worst.name}", file=sys.stderr)
    return 1
