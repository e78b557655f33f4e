"""Finds the absorption and scattering that explain measured reflectance and transmittance.

One flight gives the results for every absorption, by weights of its packets (`--reweight`). For mus, flights with equal random
numbers are made at a few values and interpolated, and more are added until one lies at the solution. There, a last flight (the
anchor) is made with random numbers of its own and with derivatives. Values then come from the anchor alone, and slopes mostly
from the other flights. The noise of values and slopes is therefore independent.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import dataclasses
import os
import re
from typing import TYPE_CHECKING, Any, Callable, Mapping, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import errors
from .command_line import picture_name
from .fields import Fields
from .integrating_sphere import SphereScene, sphere_scene
from .least_squares import TINY, correlation, jacobian, lagrange, minimum, root, start, unlikely
from .measured import PROFILES, SPHERES, TOTALS, Data, read_measured
from .options import FitOptions, Path, option_words, shown
from .program import fly
from .progress import Progress, Wanted
from .relit import told_of
from .scene import Scene, Text
from .scene_files import scratch_folder
from .sweep import table_text

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .spectrum import Media

NAMES = "names like layer1.mua, layer2.mus, body1.mua, or with the name of a layer: gel.mua"
ROWS = {0: 1, 1: 25, 2: 13, 3: 7}  # number of fitted mua: rows of a flight's table along each mua
BRACKET = 0.2  # distance of the first flights from the middle of the bounds, in ln mus
NEAR = 0.6  # distance within which flights tell slopes, in ln mus
CURVED = 0.01  # noise of logarithms that hides a curvature of 1
SETTLED = 0.2  # largest distance between the solution and the flight that gives the values, in standard errors
REACH = 2.0  # as SETTLED, if an anchor follows; also the largest distance between the solution and the anchor
OTHER_SEED = 2**40  # difference between the seed of the anchor (the last flight, with derivatives) and those of all others
NOISY = 0.3  # largest share of a parameter's information that may be noise of the slopes
BATCHES = 64  # number of batches from which the program computes errors
REDRAWN = 100  # number of redrawn flights for the error of a correlation


@dataclasses.dataclass(frozen=True)
class Fit:
    """The result of `fit`. `print` shows the values, their errors, correlations and chi square, and in words what the data cannot tell.

    Attributes:
        values: Value of each parameter.
        errors: Standard error of each parameter.
        correlation: Array of the correlations of the parameters, in their order.
        correlation_errors: Errors of these correlations by the noise of the flights.
        chi2: Chi square.
        degrees: Degrees of freedom.
        words: What the data cannot tell; "" where they tell all.
        prediction: What the model says of each name that was measured.
        prediction_errors: Standard errors of the prediction.
        flights: How many flights were simulated.
        measured: What was measured, by name; of profiles in the bins that were known.
        measured_errors: Standard errors of what was measured.
        places: Middles of the bins of each profile.
    """

    values: dict[str, float]
    errors: dict[str, float]
    correlation: Any
    correlation_errors: Any
    chi2: float
    degrees: int
    words: str
    prediction: dict[str, Any]
    prediction_errors: dict[str, Any]
    flights: int
    measured: dict[str, Any]
    measured_errors: dict[str, Any]
    places: dict[str, Any]

    @property
    def covariance(self) -> Any:
        """Returns the covariance of the parameters, in their order."""
        sigma = np.array(list(self.errors.values()))
        return self.correlation * np.outer(sigma, sigma)

    def plot(self, output: Path, of: Optional[str] = None) -> None:
        """Draws a profile of the model beside the measured one; totals and values stand below it.

        Args:
            output: Path of the picture: .svg, .png, .pdf or .eps.
            of: Name of the profile; None is the first.
        """
        profiles = [name for name in self.measured if name in PROFILES]
        if not profiles or of not in (None, *profiles):
            raise errors.refuse("of", of, "a profile that was measured" + (": " + " ".join(profiles) if profiles else ", of which there is none"))
        from .plot import main as plot
        name = of or profiles[0]
        totals = [f"{kind}: model {self.prediction[kind]:.4g}, measured {value:.4g} ± {self.measured_errors[kind]:.2g}"
                  for kind, value in self.measured.items() if kind not in PROFILES]
        found = [f"{kind} = {errors.rounded(value, self.errors[kind], '±')}" for kind, value in self.values.items()]
        with scratch_folder() as scratch:
            files = [os.path.join(scratch, file) for file in ("model.csv", "measured.csv")]
            for file, values, sigmas in zip(files, (self.prediction, self.measured), (self.prediction_errors, self.measured_errors)):
                np.savetxt(file, np.stack([self.places[name], values[name], sigmas[name]], axis=1), delimiter=",", fmt="%.9g")
            plot(["--of", name, "--label", "model", "--label", "measured", "--caption", "; ".join(found + totals), "--quiet", "--output",
                  picture_name(os.path.abspath(os.fspath(output))), *files])

    def __str__(self) -> str:
        lines = [f"{name} = {errors.rounded(value, self.errors[name])}" for name, value in self.values.items()]
        names = list(self.values)
        lines += [f"correlation of {names[i]} and {names[k]}: {self.correlation[i, k]:+.2f} +- {self.correlation_errors[i, k]:.2f}" for i in range(len(names)) for k in range(i)]
        judged = f"chi square {self.chi2:.3g} with {self.degrees} degree{'s' * (self.degrees > 1)} of freedom"
        if self.degrees <= 0:
            judged = f"no freedom to judge the fit: measured numbers {self.degrees + len(names)}, parameters {len(names)}"
        lines.append(f"{judged}, {self.flights} flight{'s' * (self.flights != 1)}")
        return "\n".join(lines + ([self.words] if self.words else []))


def _bounds(parameters: Any) -> tuple[list[str], list[str], dict[str, tuple[float, float]]]:
    """Returns the names of the mua and of the mus, and the logarithms of their bounds."""
    if not isinstance(parameters, Mapping) or not parameters:
        raise errors.refuse("parameters", parameters, 'a dict of bounds, {"layer1.mua": (0.01, 10), "layer1.mus": (10, 500)}')
    limits: dict[str, tuple[float, float]] = {}
    for name, pair in parameters.items():
        if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*\.(mua|mus)", name):
            raise errors.refuse("parameters", name, NAMES)
        what = f"parameters[{name!r}]"
        try:
            low, high = (errors.above_zero(what, number) for number in pair)
        except TypeError:
            raise errors.refuse(what, pair, "a lower and an upper bound > 0") from None
        if not low < high:
            raise errors.refuse(what, pair, "a lower bound below the upper one")
        limits[name] = (float(np.log(low)), float(np.log(high)))
    mua = [name for name in limits if name.endswith(".mua")]
    if len(mua) not in ROWS:
        raise errors.refuse("parameters", mua, f"at most {max(ROWS)} mua")
    return mua, [name for name in limits if name.endswith(".mus")], limits


def _numbered(scene: Union[Scene, Path], names: list[str]) -> list[str]:
    """Returns the names with layerN in place of a layer's own name in the scene."""
    if all(re.fullmatch(r"(layer|body)\d+\..*", name) for name in names):
        return names
    layers = {layer.get("name"): f"layer{i}" for i, layer in enumerate(told_of(scene)["layers"], 1)}
    found = []
    for name in names:
        owner, _, kind = name.partition(".")
        if owner not in layers and not re.fullmatch(r"(layer|body)\d+", owner):
            raise errors.refuse("parameters", name, NAMES)
        found.append(f"{layers.get(owner, owner)}.{kind}")
    for i, name in enumerate(found):
        if name in found[:i]:
            raise errors.refuse("parameters", names[i], "each number once")
    return found


@dataclasses.dataclass(frozen=True)
class _Flight:
    """A flight at one value of each mus: all measured numbers, over a grid of mua. mus: logarithms."""

    mus: Any
    logs: Any  # logarithms of the model's numbers [rows along each mua ..., numbers]
    covariance: Callable[[tuple[int, ...]], Any]  # returns the covariance of the model's noise at a place of the grid
    seed: int
    places: dict[str, Any]  # middles of the measured bins of each profile


@dataclasses.dataclass(frozen=True)
class _Anchor:
    """The anchor: a flight at one value of all parameters, with random numbers of its own. u: logarithms of the parameters."""

    u: Any
    logs: Any  # [numbers] logarithms of the model's numbers
    slopes: Any  # [numbers, parameters] derivatives of logs by u
    errors: Any  # standard errors of slopes, inf if unknown
    covariance: Any  # covariance of the noise of the numbers


def _measures(data: Data, result: Any) -> Any:
    """Returns the factors that turn measured numbers into shares of the launched light: areas of rings, or solid angles."""
    def of(name: str) -> Any:
        if name not in PROFILES:
            return 1.0
        places = result["r" if name.endswith("_r") else "alpha"]
        width = 2 * places[0]
        return 2 * np.pi * (places * width if name.endswith("_r") else np.sin(places) * width)
    return data.pick(of)


def _noise(data: Data, model: Any, sigma: Any, measures: Any, told: Mapping[str, float], photons: float) -> Any:
    """Returns the covariance of the model's numbers.

    A packet ends once, so that light in one place is missing at all others. Totals scatter less than by chance; their
    covariance follows from A, because Rd and Tt share the light that is not absorbed."""
    shares, spread = model * measures, sigma * measures
    covariance = -np.outer(shares, shares) / photons
    inside = [(i, k) for i, name in enumerate(data.names) for k, other in enumerate(data.names)
              if name not in TOTALS and other in TOTALS and data.sides[name] == other[0]]
    for i, k in inside:  # all light of the bin or the detector is also light of the total
        covariance[i, k] += spread[i] ** 2 + shares[i] ** 2 / photons
        covariance[k, i] = covariance[i, k]
    up, down = ([i for i, name in enumerate(data.names) if name in names] for names in (("Rd", "R"), ("Tt",)))
    for i in up:
        for k in down:
            covariance[i, k] = covariance[k, i] = (told["A_se"] ** 2 - told["Rd_se"] ** 2 - told["Tt_se"] ** 2) / 2
    np.fill_diagonal(covariance, spread**2)
    return covariance / np.outer(measures, measures)


def _numbers(data: Data, told: Mapping[str, Any]) -> tuple[Any, Any]:
    """Returns the model's numbers in one row, and their errors."""
    def of(name: str) -> Any:
        if name not in PROFILES:
            return told["Rsp"] + told["Rd"] if name == "R" else told[name]
        given, there = data.sizes[name], told[name].size
        if given != there:
            raise errors.refuse(f"measured[{name!r}]", f"{given} values", f"{there}, as many as the scene has bins, nan where nothing is known")
        return told[name]

    def error_of(name: str) -> Any:
        return told["Rd_se" if name == "R" else name + "_se"]
    return data.pick(of), data.pick(error_of)


def _numbers_of(data: Data) -> list[str]:
    """Returns the names of the arrays that a fit to the data reads, without slopes."""
    return [name + end for name in ("Rsp", "Rd", "Tt", "A", *data.names) for end in ("", "_se")] + ["r", "alpha"] * bool(data.profiles())


def _row(found: Fields) -> dict[str, Any]:
    """Returns the values of all arrays of a row, its photons and its seed."""
    return {**{name: one.values for name, one in found.held.items()}, "photons": found.attrs["photons"], "seed": found.attrs["seed"]}


def _fly_rows(scene: Union[Scene, SphereScene, Text, Path], words: Sequence[str], table: str, options: Mapping[str, Any], names: Sequence[str]) -> list[dict[str, Any]]:
    """Flies all rows of a table, or the scene where it is "", and returns their values by name. words: further options. names: of the arrays to read."""
    if isinstance(scene, SphereScene):
        return scene.rows(_fly_rows, words, table, options, names)
    shown = options["progress"]
    silent = "effective packets|counts from above"  # most rows are far from the solution and their noise does not matter; the user chose parameters by name
    given = option_words({name: value for name, value in options.items() if name != "progress"}, FitOptions)
    shown.begin("flight")
    rows = [_row(row) for row in fly(scene, [*words, *given], shown, table=table, silent=silent, names=names)]
    if rows[0]["photons"] < BATCHES:
        raise errors.refuse("photons", rows[0]["photons"], f"at least {BATCHES}: errors come of so many batches")
    return rows


def _fly(scene: Union[Scene, SphereScene, Path], grids: Mapping[str, Any], mus: Mapping[str, float], data: Data, options: Mapping[str, Any]) -> _Flight:
    """Flies a sweep over the grids of mua at one set of mus. Returns what was measured of it, at each point of the grids."""
    rows = [[*row, *mus.values()] for row in np.stack(np.meshgrid(*map(np.exp, grids.values()), indexing="ij"), -1).reshape(-1, len(grids))] \
        if grids else [list(mus.values())]
    told = _fly_rows(scene, ["--reweight", "--ignore-absorption"], table_text([[*grids, *mus], *rows]), options, _numbers_of(data))
    numbers = [_numbers(data, row) for row in told]
    shape = tuple(len(grid) for grid in grids.values())

    def covariance(place: tuple[int, ...]) -> Any:
        index = int(np.ravel_multi_index(place, shape)) if shape else 0
        return _noise(data, *numbers[index], _measures(data, told[index]), told[index], told[index]["photons"])
    logs = np.log(np.maximum([model for model, _ in numbers], TINY))
    return _Flight(np.log(list(mus.values())), logs.reshape(*shape, -1), covariance, told[0]["seed"],
                   {name: told[0]["r" if name.endswith("_r") else "alpha"][data.bins(name)] for name in data.profiles()})


def _slope(name: str, kind: str) -> str:
    return f"d{'Rd' if name == 'R' else name}_d{kind}" if name in TOTALS + PROFILES else f"{name}_d{kind}"


def _anchor(scene: Union[Scene, SphereScene, Path], names: list[str], u: Any, data: Data, options: Mapping[str, Any]) -> _Anchor:
    """Flies the scene at the parameters exp(u) with derivatives. Returns the logarithm of the model there, its slopes by u, and the noise of both."""
    kinds = list(dict.fromkeys(name[-3:] for name in names))
    slopes = [_slope(name, kind) for name in dict.fromkeys(data.names) for kind in kinds]
    fixed = {**options, "set": {**(options.get("set") or {}), **dict(zip(names, map(float, np.exp(u))))}}
    (row,) = _fly_rows(scene, ["--derivatives"], "", fixed, ["A_l", *_numbers_of(data), *(name + end for name in slopes for end in ("", "_se"))])
    model, sigma = _numbers(data, row)

    def column(parameter: str, suffix: str) -> Any:
        """Returns derivatives by one parameter, or their errors; NaN if unknown."""
        place, _, kind = parameter.partition(".")
        k = int(re.sub("[a-z]*", "", place)) - 1 + (len(row["A_l"]) if place.startswith("body") else 0)

        def of(name: str) -> Any:
            return row[_slope(name, kind) + suffix][..., k]
        return data.pick(of)
    known = np.maximum(model, TINY)
    turns, noise = (np.stack([column(name, suffix) for name in names], axis=1) * np.exp(u) / known[:, None] for suffix in ("", "_se"))
    told = np.isfinite(turns) & (noise > 0)
    return _Anchor(u, np.log(known), np.where(told, turns, 0), np.where(told, noise, np.inf),
                   _noise(data, model, sigma, _measures(data, row), row, row["photons"]))


class _Model:
    """The model: logarithms of all numbers at any mua and mus, interpolated from the flights.

    The last flight gives the values. Differences of the other flights give slopes along each mus and, if larger than the noise,
    curvatures, by least squares. A flight close by counts little, because its difference is mostly noise. A flight far away
    counts little, because more than curvature matters there. An anchor shifts the model to the anchor's values, and turns it
    towards the anchor's slopes as far as their noise is small."""

    def __init__(self, grids: Mapping[str, Any], flights: list[_Flight], anchor: Optional[_Anchor] = None) -> None:
        self.grids, self.others, self.last, self.anchor = list(grids.values()), flights[:-1], flights[-1], anchor
        dims = len(self.last.mus)
        steps = np.array([flight.mus - self.last.mus for flight in self.others]).reshape(len(self.others), dims)
        terms = np.hstack([steps, steps**2])
        weighted = terms.T / (1 + (np.abs(steps).max(axis=1, initial=0) / NEAR) ** 4)
        self.inverse = np.linalg.solve(weighted @ terms + np.diag([0.0] * dims + [CURVED**2] * dims), weighted)
        if anchor is not None:
            self.shift = anchor.logs - self.flown(anchor.u)
            spread = self.spread(anchor.u, np.sqrt(np.diag(anchor.covariance)) / np.exp(anchor.logs))
            self.turn = _share(spread, anchor.errors) * (anchor.slopes - jacobian(self.flown, anchor.u))

    def along(self, flight: _Flight, mua: Any) -> Any:
        logs = flight.logs
        for grid, x in zip(self.grids, mua):
            first, weights = lagrange(grid, x)
            logs = np.tensordot(weights, logs[first:first + 4], 1)
        return logs

    def flown(self, u: Any) -> Any:
        mua = u[:len(self.grids)]
        here = self.along(self.last, mua)
        differences = np.array([self.along(flight, mua) - here for flight in self.others]).reshape(-1, len(here))
        return here + self.shares(u)[:-1] @ differences

    def __call__(self, u: Any) -> Any:
        return self.flown(u) if self.anchor is None else self.flown(u) + self.shift + self.turn @ (u - self.anchor.u)

    def shares(self, u: Any) -> Any:
        """Returns the weight of each flight in the values at u. The last flight stands last."""
        step = u[len(self.grids):] - self.last.mus
        others = np.concatenate([step, step**2]) @ self.inverse
        return np.append(others, 1 - others.sum())

    def noise_at(self, u: Any) -> tuple[Any, Any]:
        """Returns the logarithms of the numbers near u, and their covariance, from the flight that gives the values."""
        if self.anchor is not None:
            return self.anchor.logs, self.anchor.covariance
        place = tuple(int(np.abs(grid - x).argmin()) for grid, x in zip(self.grids, u))
        return self.last.logs[place], self.last.covariance(place)

    def spread(self, u: Any, noise: Any) -> Any:
        """Returns standard errors [numbers, parameters] of slopes made of flights whose numbers have the standard errors
        `noise`, as if flights were independent of each other."""
        return np.outer(noise, np.linalg.norm(jacobian(self.shares, u), axis=0))

    def slopes_noise(self, u: Any, noise: Any) -> tuple[Any, Any]:
        """Returns standard errors of the slopes in use, and the correlation between slopes along two parameters."""
        spread, turns = self.spread(u, noise), jacobian(self.shares, u)
        if self.anchor is not None:
            spread = spread * np.sqrt(1 - _share(spread, self.anchor.errors))
        lengths = np.maximum(np.linalg.norm(turns, axis=0), TINY)
        return spread, turns.T @ turns / np.outer(lengths, lengths)


def _share(spread: Any, errors: Any) -> Any:
    """Returns the weight of numbers with standard error `errors` in their best mean with numbers of standard error `spread`."""
    return spread**2 / (spread**2 + errors**2 + TINY)


def _errors(J: Any, noise: Any) -> tuple[Any, Any, Any]:
    """Returns the covariance of the logarithms, which parameters the data leave open, and which parameters are known mostly by
    noise of the slopes.

    noise: the part of J^T J that comes from the slopes' noise, with flights counted as independent. The noise is subtracted, up
    to 99 % in any direction."""
    _, s, v = np.linalg.svd(J)
    s = np.concatenate([s, np.zeros(len(v) - len(s))])
    lost = s <= 1e-6 * max(float(s[0]), TINY)
    root = v.T[:, ~lost] / s[~lost]
    share, axes = np.linalg.eigh(root.T @ noise @ root)
    honest = root @ axes / np.sqrt(1 - np.minimum(share, 0.99))
    return honest @ honest.T, (np.abs(v[lost]) > 0.1).any(axis=0), np.sum(root**2, axis=1) < (1 - NOISY) * np.sum(honest**2, axis=1)


@dataclasses.dataclass(frozen=True)
class _Solution:
    """The result of a least-squares fit. u: logarithms of the parameters; covariance: of u. lost, noisy: as _errors returns them. model: the numbers
    at the solution; noise: their standard errors. correlation_errors: errors of the correlation that come from this noise."""

    u: Any
    residual: Any
    covariance: Any
    sigma: Any
    lost: Any
    noisy: Any
    model: Any
    noise: Any
    correlation_errors: Any


def _solve(data: Data, model: _Model, low: Any, high: Any, u: Optional[Any]) -> _Solution:
    """Solves the least squares, first with the measured errors alone, then with the model's noise added. u: starting point, or
    None."""
    factor = np.diag(data.errors)

    def residual(u: Any) -> Any:
        return np.linalg.solve(factor, np.exp(model(u)) - data.values)
    u = minimum(residual, start(residual, low, high) if u is None else u, low, high)
    logs, covariance = model.noise_at(u)
    expected = np.sqrt(np.clip(data.values / np.exp(logs), 0.25, 4))
    noise = covariance * np.outer(expected, expected)
    both = np.diag(data.errors**2) + noise
    factor = np.linalg.cholesky(both)
    u = minimum(residual, u, low, high)
    sigma, there = np.maximum(np.sqrt(np.diag(noise)), TINY), np.exp(model(u))
    spread, alike = model.slopes_noise(u, sigma / there)
    spread *= there[:, None]
    slopes = alike * (spread.T @ (np.linalg.inv(both) * noise / np.outer(sigma, sigma)) @ spread)
    J = jacobian(residual, u)
    found, lost, noisy = _errors(J, slopes)

    turns = factor @ J

    def redrawn(dice: Any) -> Any:
        """Returns the correlation that other flights of equal noise would give, with slopes and a covariance redrawn from as
        many batches."""
        batches = root(noise) @ dice.standard_normal((len(noise), BATCHES - 1))
        drawn = root(noise / np.outer(sigma, sigma)) @ dice.standard_normal(turns.shape) @ root(alike).T
        other = np.linalg.cholesky(np.diag(data.errors**2) + batches @ batches.T / (BATCHES - 1))
        return correlation(_errors(np.linalg.solve(other, turns + spread * drawn), slopes)[0])
    dice = np.random.default_rng(1)
    return _Solution(u, residual(u), found, np.sqrt(np.diag(found)), lost, noisy, there, np.sqrt(np.diag(covariance)),
                     np.std([redrawn(dice) for _ in range(REDRAWN)], axis=0))


def _words(names: list[str], u: Any, low: Any, high: Any, found: _Solution, data: Data, settled: bool) -> str:
    """Returns warnings for the user: parameters that the data leave open, poor fits, values at a bound. Empty if all is well."""
    told, noisy, chi2 = [], found.noisy, float(found.residual @ found.residual)
    together = [name for name, lost in zip(names, found.lost) if lost]
    if together:
        told.append(f"The data do not tell {' and '.join(together)}: {len(data.values)} number{'s' * (len(data.values) > 1)} for {len(names)} parameters, "
                    "many of whose values explain them as well.")
    vague = [f"{name} (a factor of {np.exp(min(s, 9.0)):.2g})" for name, s, lost in zip(names, found.sigma, found.lost) if s > 0.5 and not lost]
    if vague:
        told.append(f"The data hardly tell {' and '.join(vague)}.")
    stopped = [f"{name} at {np.exp(x):.4g}" for name, x, a, b in zip(names, u, low, high) if min(x - a, b - x) < 1e-6]
    if stopped:
        told.append(f"A bound stopped {' and '.join(stopped)}: its standard error is that without it.")
    if noisy.any():
        told.append(f"Much of what the data seem to tell of {' and '.join(name for name, much in zip(names, noisy) if much)} is noise of the "
                    "flights' slopes: more photons, for values and errors to be trusted.")
    if unlikely(chi2, len(data.values) - len(names)):
        told.append(f"The model does not explain the data: chi square {chi2:.3g} is no chance.")
    if not settled:
        told.append("The last flight still moved the solution: more `flights` would settle it.")
    return " ".join(told)


@shown
def fit(scene: Union[Scene, Path], parameters: Mapping[str, tuple[float, float]], measured: Mapping[str, Any], *, media: Optional[Callable[..., Media]] = None,
        wavelengths: Optional[npt.ArrayLike] = None, sphere: Optional[Mapping[str, Any]] = None, flights: int = 6, progress: Wanted = None,
        **options: Unpack[FitOptions]) -> Fit:
    """Fits absorption and scattering of layers and bodies, or parameters of media over wavelength, to measurements, by least squares.

    Args:
        scene: A Scene, or the path of an `.mci` file with one run.
        parameters: {name: (least, greatest)}, with names as `set` takes them: layer1.mua, layer2.mus, body1.mua. At most three are mua.
        measured: {name: (value, standard error)} of Rd, R = Rsp + Rd, Tt and detectors such as detector_near, which have no light in common;
            {name: (values, errors)} of Rd_r, Tt_r, Rd_a and Tt_a, in the units and bins of results, nan where nothing is known. The last bin of r is left out.
            M_R and M_T are readings of a single integrating sphere with a port, which `sphere` describes.
        media: Function that takes the parameters by name and returns media as `spectrum` takes them. Parameters are then any numbers, and
            `measured` has {name: (values, errors)} of totals and detectors, one for each wavelength, nan where nothing is known.
        wavelengths: Rising wavelengths [nm] of the data; with media.
        sphere: Arguments of `mc.sphere` that describe the instrument: {"port": 0.5, "radius": 5, "wall": 0.97, "standard": 0.99}.
        flights: Most flights; with media, most rounds of flights at all wavelengths.
        progress: As of `run`.
        **options: As of `run`: photons=1e5, seed=2. More photons lessen the model's own noise, which is part of the errors.

    Returns:
        A Fit.

    Examples:
        >>> fit("scene.mci", {"layer1.mua": (0.1, 10)}, {"Rd": (0.3, 0)})
        Traceback (most recent call last):
        ...
        clustermcml.errors.InputError: measured['Rd'] = (0.3, 0) (expected a value and its standard error > 0, of profiles a value for each bin)
    """
    if media is not None or wavelengths is not None:
        if sphere is not None:
            raise errors.refuse("sphere", sphere, "none beside media")
        from .spectrum_fit import fit_spectrum
        with Progress(progress) as shown_progress:
            return fit_spectrum(scene, parameters, measured, media, wavelengths, flights, {**options, "progress": shown_progress})
    mua, mus, limits = _bounds(parameters)
    data = read_measured(measured, scene)
    most = errors.whole("flights", flights, len(mus) + 1, 1000)
    flown = sphere_scene(scene, [name for name in SPHERES if name in measured], sphere) if sphere or {*SPHERES} & {*measured} else scene
    numbered = _numbered(scene, mua + mus)
    with Progress(progress) as shown_progress:
        return _fit_coefficients(flown, numbered, mua, mus, limits, data, most, {**options, "progress": shown_progress})


def _fit_coefficients(scene: Union[Scene, SphereScene, Path], numbered: list[str], mua: list[str], mus: list[str],
                      limits: Mapping[str, tuple[float, float]], data: Data, most: int, options: Mapping[str, Any]) -> Fit:
    """Fits mua and mus with at most `most` flights. numbered: names of both by number; limits: logarithms of the bounds."""
    names = mua + mus
    low, high = (np.array([limits[name][end] for name in names]) for end in (0, 1))
    grids = {name: np.linspace(*limits[name], ROWS[len(mua)]) for name in mua}

    def fly_at(x: Any) -> _Flight:
        return _fly(scene, grids, {name: float(np.exp(value)) for name, value in zip(mus, x)}, data, options)

    def moved(found: _Solution, place: Any, reach: float) -> bool:
        return bool(np.any(np.abs(found.u[len(mua):] - place) > np.maximum(reach * found.sigma[len(mua):], 1e-3)))
    first, half = (low + high)[len(mua):] / 2, np.minimum(BRACKET, (high - low)[len(mua):] / 4)
    flown = [fly_at(first - half + 2 * half * e) for e in [*np.eye(len(mus)), np.zeros(len(mus))]]
    own = bool(mus) and most > len(flown)
    found = _solve(data, _Model(grids, flown), low, high, None)
    flown.sort(key=lambda flight: -float(np.abs(flight.mus - found.u[len(mua):]).max(initial=0)))  # the flight closest to the solution comes last, because it gives the values
    while (open_ := moved(found, flown[-1].mus, REACH if own else SETTLED)) and len(flown) < most - own:
        flown.append(fly_at(found.u[len(mua):]))
        found = _solve(data, _Model(grids, flown), low, high, found.u)
    count = len(flown)
    seeded: dict[str, Any] = {**options, "seed": (flown[-1].seed + OTHER_SEED) % 2**53}
    while own and count < most:
        anchor = _anchor(scene, numbered, found.u, data, seeded)
        found, count = _solve(data, _Model(grids, flown, anchor), low, high, found.u), count + 1
        open_ = moved(found, anchor.u[len(mua):], REACH)
        if not open_:
            break
    u, r, sigma = found.u, found.residual, np.where(found.lost, np.inf, found.sigma)
    values = np.exp(u)
    return Fit(values=dict(zip(names, map(float, values))), errors=dict(zip(names, map(float, values * sigma))),
               correlation=correlation(found.covariance), correlation_errors=found.correlation_errors, chi2=float(r @ r), degrees=len(data.values) - len(names),
               words=_words(names, u, low, high, found, data, not open_), prediction=data.parted(found.model),
               prediction_errors=data.parted(found.noise), flights=count,
               measured=data.parted(data.values), measured_errors=data.parted(data.errors), places=flown[-1].places)
