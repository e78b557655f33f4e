"""Fits parameters of media, such as a saturation or a share of blood, to a measured spectrum.

A round simulates all wavelengths, with derivatives by mua and mus of each medium and random numbers of its own at each wavelength.
Between rounds the logarithm of each number is taken as linear in sqrt(mua) and ln mus, and the media are computed as they are. A
parameter that moves other numbers (thickness, index) takes two more sweeps for its slopes. Rounds end where the solution stays. A
last round with other random numbers gives the values. Its errors count the data, the noise of the values, and the noise of the
slopes: the information is the product of slopes of two independent rounds, which noise does not raise.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import dataclasses
import os
from typing import Any, Callable, Mapping, Optional, Union

import numpy as np

from . import errors
from .fit import NOISY, OTHER_SEED, REDRAWN, Fit, _fly_rows, _noise, _numbered, _numbers, _numbers_of, _slope
from .least_squares import TINY, correlation, minimum, unlikely
from .measured import PROFILES, Data, check_name, check_number, read_measured
from .media import wavelengths as rising
from .options import Path
from .scene import Scene
from .spectrum import columns_of
from .sweep import _rows

STEP = 2**30  # difference between the seeds of neighbouring wavelengths
NEAR = 0.5  # largest distance, in standard errors, between the solution and the round that it comes from
WORSE = 2  # factor of chi square by which a step was too long
WIDTH = 0.02  # share of the bounds by which a number other than mua and mus is moved for its slopes
OPEN = 1e-9  # share of the largest information below which the data leave a direction open
KINDS = (".mua", ".mus")
EXPECTED = '{"Rd": (values, errors)} with one for each wavelength, nan where nothing is known'


class SpectrumFit(Fit):
    """The result of `fit` with media: a Fit whose data stand at wavelengths. `places` holds the wavelengths [nm] of each name."""

    def plot(self, output: Path, of: Optional[str] = None) -> None:
        """Draws the spectrum of the model and the measured one.

        Args:
            output: Path of the picture: .svg, .png, .pdf or .eps.
            of: Name of what was measured; None draws all.
        """
        if of not in (None, *self.measured):
            raise errors.refuse("of", of, "one of " + " ".join(self.measured))
        from .pictures import COLOURS, add_caption, drawing, save
        with drawing():
            from matplotlib.figure import Figure
            figure = Figure(layout="constrained")
            axes = figure.subplots()
            for colour, name in zip(COLOURS * len(self.measured), self.measured if of is None else [of]):
                axes.errorbar(self.places[name], self.measured[name], self.measured_errors[name], fmt="o", color=colour, label=f"{name}, measured")
                axes.plot(self.places[name], self.prediction[name], color=colour, label=f"{name}, model")
            axes.set(xlabel="wavelength [nm]", ylabel="share of the launched light")
            axes.legend(fontsize="small")
            add_caption(figure, "; ".join(f"{name} = {errors.rounded(value, self.errors[name], '±')}" for name, value in self.values.items()))
            save(figure, os.path.abspath(os.fspath(output)))


@dataclasses.dataclass(frozen=True)
class _Parameters:
    """The parameters as numbers u: logarithms where the lower bound is above 0, else the values themselves."""

    names: list[str]
    low: Any
    high: Any
    logs: Any  # whether u is a logarithm

    def values(self, u: Any) -> dict[str, float]:
        return {name: float(np.exp(x) if log else x) for name, x, log in zip(self.names, u, self.logs)}

    def factors(self, u: Any) -> Any:
        """Returns the derivatives of the values by u."""
        return np.where(self.logs, np.exp(np.where(self.logs, u, 0)), 1.0)


@dataclasses.dataclass(frozen=True)
class _Spectra:
    """The measured numbers. rows: for each wavelength, the index of the wavelength and the numbers known there."""

    nm: Any
    rows: list[tuple[int, Data]]

    def join(self, of: Callable[[int, Data], Any]) -> Any:
        return np.concatenate([of(i, data) for i, data in self.rows])

    def names(self) -> list[str]:
        return list(dict.fromkeys(name for _, data in self.rows for name in data.names))

    def parted(self, numbers: Any) -> dict[str, Any]:
        """Splits numbers by name: arrays over the wavelengths at which the name was measured."""
        names = [name for _, data in self.rows for name in data.names]
        return {name: np.array([x for x, other in zip(numbers, names) if other == name]) for name in self.names()}


def _parameters(parameters: Any) -> _Parameters:
    if not isinstance(parameters, Mapping) or not parameters or not all(isinstance(name, str) for name in parameters):
        raise errors.refuse("parameters", parameters, 'a dict of bounds, {"saturation": (0, 1), "blood": (0.001, 0.1)}')
    lows, highs = [], []
    for name, pair in parameters.items():
        try:
            low, high = (errors.finite(f"parameters[{name!r}]", number) for number in pair)
        except TypeError:
            raise errors.refuse(f"parameters[{name!r}]", pair, "a lower and an upper bound") from None
        if not low < high:
            raise errors.refuse(f"parameters[{name!r}]", pair, "a lower bound below the upper one")
        lows.append(low)
        highs.append(high)
    logs = np.array(lows) > 0
    least, most = (np.where(logs, np.log(np.where(logs, ends, 1)), ends) for ends in (lows, highs))
    return _Parameters(list(parameters), least, most, logs)


def _read(measured: Any, nm: Any, scene: Union[Scene, Path]) -> _Spectra:
    if not isinstance(measured, Mapping) or not measured:
        raise errors.refuse("measured", measured, EXPECTED)
    found: dict[str, tuple[Any, Any]] = {}
    for name, pair in measured.items():
        check_name("measured", name)
        try:
            value, sigma = (np.asarray(numbers, dtype=float) for numbers in pair)
            value, sigma = np.broadcast_arrays(value, sigma)
        except (TypeError, ValueError):
            raise errors.refuse(f"measured[{name!r}]", pair, EXPECTED) from None
        if name in PROFILES or value.shape != nm.shape or np.isnan(value).all():
            raise errors.refuse(f"measured[{name!r}]", pair, "totals or detectors: " + EXPECTED)
        for i in np.flatnonzero(~np.isnan(value)):
            check_number(f"measured[{name!r}] at {nm[i]:g} nm", name, float(value[i]), float(sigma[i]))
        found[name] = value, sigma
    first = {name: (float(value[~np.isnan(value)][0]), float(sigma[~np.isnan(value)][0])) for name, (value, sigma) in found.items()}
    sides = read_measured(first, scene).sides  # refuses names that the scene does not have, or that hold the same light
    rows = []
    for i in range(len(nm)):
        names = [name for name, (value, _) in found.items() if not np.isnan(value[i])]
        if names:
            values, sigmas = (np.array([found[name][end][i] for name in names]) for end in (0, 1))
            rows.append((i, Data(names, [-1] * len(names), values, sigmas, {}, sides)))
    return _Spectra(nm, rows)


class _Problem:
    """The scene, the model of its media, and the options: what a round simulates."""

    def __init__(self, scene: Union[Scene, Path], model: Any, spectra: _Spectra, parameters: _Parameters, options: Mapping[str, Any]) -> None:
        self.scene, self.model, self.spectra, self.parameters = scene, model, spectra, parameters
        self.seed = errors.whole("seed", options.get("seed") or 1, 0, 2**53)
        self.options = {name: value for name, value in options.items() if name != "seed"}
        self.flown = 0
        first = self.columns((parameters.low + parameters.high) / 2)
        self.slopes = [name for name in first if name.endswith(KINDS)]
        self.places = dict(zip(self.slopes, _numbered(scene, self.slopes)))
        ends = [{name: values for name, values in self.columns(u).items() if name not in self.slopes} for u in self._ends()]
        here = {name: values for name, values in first.items() if name not in self.slopes}
        self.others = [k for k in range(len(parameters.names)) if any(not np.array_equal(ends[k][name], here[name]) for name in here)]

    def _ends(self) -> Any:
        middle = (self.parameters.low + self.parameters.high) / 2
        return [np.where(np.arange(len(middle)) == k, self.parameters.high, middle) for k in range(len(middle))]

    def columns(self, u: Any) -> dict[str, Any]:
        values = self.parameters.values(u)
        try:
            media = self.model(**values)
        except TypeError as error:
            raise errors.refuse("media", self.model, f"a function of {', '.join(values)} that returns media; {error}") from error
        return columns_of(media, self.spectra.nm)

    def inside(self, u: Any) -> Any:
        return np.clip(u, self.parameters.low, self.parameters.high)

    def coordinates(self, u: Any) -> Any:
        """Returns [wavelengths, mua and mus]: sqrt(mua) and ln mus, in which logarithms of results are nearly straight."""
        columns = self.columns(self.inside(u))
        if not self.slopes:
            return np.zeros((len(self.spectra.nm), 0))
        return np.stack([np.sqrt(columns[name]) if name.endswith(".mua") else np.log(np.maximum(columns[name], TINY)) for name in self.slopes], axis=-1)

    def fly(self, columns: Mapping[str, Any], seed: int, more: list[str], arrays: list[str]) -> list[dict[str, Any]]:
        """Simulates all wavelengths. Returns, for each, the arrays of the numbers and those that are wanted. more: further options."""
        nm = self.spectra.nm
        seeds = [(self.seed + seed + STEP * i) % 2**53 for i in range(len(nm))]
        self.flown += len(nm)
        names = [name for _, data in self.spectra.rows for name in _numbers_of(data)] + arrays
        return _fly_rows(self.scene, ["--ignore-absorption", *more], _rows({**columns, "seed": seeds}, "nm", ()).text(), self.options, names)

    def numbers(self, row: Mapping[str, Any], i: int, data: Data) -> tuple[Any, Any]:
        """Returns the model's numbers at a wavelength, and their errors. Numbers of which no packet tells are refused."""
        model, sigma = _numbers(data, row)
        if not (model > 0).all():
            raise errors.refuse("photons", row["photons"], f"more: no packet tells {data.names[int(np.argmin(model))]} at {self.spectra.nm[i]:g} nm")
        return model, sigma


class _Round:
    """A round at u: the model near u. logs: logarithms of all numbers; noise: their covariance, as numbers and no logarithms."""

    def __init__(self, problem: _Problem, u: Any, seed: int = 0) -> None:
        self.problem, self.u = problem, u
        spectra, columns = problem.spectra, problem.columns(u)
        arrays = ["A_l", *(_slope(name, kind[1:]) + end for name in spectra.names() for kind in KINDS for end in ("", "_se"))]
        self.flights = problem.fly(columns, seed, ["--derivatives"], arrays)
        told = [problem.numbers(self.flights[i], i, data) for i, data in spectra.rows]
        self.wavelength = spectra.join(lambda i, data: np.full(len(data.names), i))
        self.values = np.concatenate([model for model, _ in told])
        self.logs, self.noise = np.log(self.values), np.zeros((len(self.values),) * 2)
        start = 0
        for (i, data), (model, sigma) in zip(spectra.rows, told):
            part = slice(start, start + len(model))
            row = self.flights[i]
            self.noise[part, part] = _noise(data, model, sigma, np.ones(len(model)), row, row["photons"])
            start = part.stop
        self.x = problem.coordinates(u)
        self.slopes, self.slopes_se = (np.stack([spectra.join(self._slope(name, columns[name], end)) for name in problem.slopes], axis=-1) / self.values[:, None]
                                       if problem.slopes else np.zeros((len(self.values), 0)) for end in ("", "_se"))
        self.others = np.zeros((len(self.values), len(u)))
        for k in problem.others:
            self.others[:, k] = self._difference(columns, k, seed)

    def _slope(self, name: str, values: Any, end: str) -> Callable[[int, Data], Any]:
        """Returns derivatives by sqrt(mua) or ln mus of the numbers at a wavelength, 0 where they are not known."""
        place, _, kind = self.problem.places[name].partition(".")

        def of(i: int, data: Data) -> Any:
            row = self.flights[i]
            inside = int(place.lstrip("layerbody")) - 1 + (len(row["A_l"]) if place.startswith("body") else 0)
            factor = 2 * np.sqrt(values[i]) if kind == "mua" else values[i]
            words = [_slope(other, kind) + end for other in data.names]
            return factor * np.nan_to_num(np.array([row[word][inside] for word in words]))
        return of

    def _difference(self, columns: Mapping[str, Any], k: int, seed: int) -> Any:
        """Returns slopes of the logarithms by parameter k through numbers other than mua and mus: two sweeps with equal random numbers."""
        problem, parameters = self.problem, self.problem.parameters
        h = WIDTH * (parameters.high[k] - parameters.low[k])
        ends = [np.clip(self.u[k] + side * h, parameters.low[k], parameters.high[k]) for side in (-1, 1)]
        logs = []
        for end in ends:
            moved = problem.columns(np.where(np.arange(len(self.u)) == k, end, self.u))
            flights = problem.fly({name: columns[name] if name in problem.slopes else moved[name] for name in moved}, seed, [], [])
            logs.append(np.concatenate([np.log(problem.numbers(flights[i], i, data)[0]) for i, data in problem.spectra.rows]))
        return (logs[1] - logs[0]) / (ends[1] - ends[0])

    def model(self, u: Any, slopes: Optional[Any] = None) -> Any:
        """Returns the numbers at u. slopes: in place of those of the round."""
        moved = (self.problem.coordinates(u) - self.x)[self.wavelength]
        straight = ((self.slopes if slopes is None else slopes) * moved).sum(axis=1)
        return np.exp(np.minimum(self.logs + straight + self.others @ (u - self.u), 1.0))  # no number is above all light

    def jacobian(self, u: Any, values: Any) -> Any:
        """Returns derivatives of the numbers `values` at u."""
        return values[:, None] * (np.einsum("npc,nc->np", self.bends(u), self.slopes) + self.others)

    def bends(self, u: Any) -> Any:
        """Returns derivatives [numbers, parameters, mua and mus] of the coordinates by the parameters, from within the bounds."""
        found = []
        for k, e in enumerate(np.eye(len(u))):
            ends = [self.problem.inside(u + side * 1e-4 * e) for side in (-1, 1)]
            found.append((self.problem.coordinates(ends[1]) - self.problem.coordinates(ends[0])) / (ends[1] - ends[0])[k])
        return np.stack(found, axis=1)[self.wavelength]

    def jacobian_noise(self, u: Any, values: Any) -> Any:
        """Returns standard errors of `jacobian`, without those of slopes through other numbers than mua and mus."""
        return values[:, None] * np.sqrt(np.einsum("npc,nc->np", self.bends(u) ** 2, self.slopes_se**2))


@dataclasses.dataclass(frozen=True)
class _Known:
    """The knowledge of the parameters from two rounds. lost: which the data leave open; noisy: which are known mostly by noise of the slopes."""

    covariance: Any
    lost: Any
    noisy: Any


def _known(one: Any, other: Any) -> _Known:
    """Returns the covariance of the parameters from slopes of two independent rounds, in standard errors of the numbers."""
    information = one.T @ other
    s, v = np.linalg.eigh((information + information.T) / 2)
    own = (one.T @ one + other.T @ other) / 2
    lost = s <= OPEN * max(float(np.linalg.eigvalsh(own)[-1]), TINY)
    inverse = (v[:, ~lost] / s[~lost]) @ v[:, ~lost].T
    covariance = inverse @ own @ inverse
    return _Known(covariance, (np.abs(v[:, lost]) > 0.1).any(axis=1), np.diag(covariance) > np.diag(inverse) / (1 - NOISY))


class _Squares:
    """The least squares of a round: numbers in standard errors of the data and of the model's noise."""

    def __init__(self, problem: _Problem, here: _Round, slopes: Optional[Any] = None) -> None:
        self.problem, self.here, self.slopes = problem, here, slopes
        spectra = problem.spectra
        self.data, sigma = (spectra.join(lambda _, data: data.values), spectra.join(lambda _, data: data.errors))
        expected = np.sqrt(np.clip(self.data / here.values, 0.25, 4))  # noise of the model where it equals the data
        self.factor = np.linalg.cholesky(np.diag(sigma**2) + here.noise * np.outer(expected, expected))

    def whitened(self, numbers: Any) -> Any:
        return np.linalg.solve(self.factor, numbers)

    def residual(self, u: Any) -> Any:
        return self.whitened(self.here.model(u, self.slopes) - self.data)

    def chi2(self, u: Any) -> float:
        return float(np.sum(self.residual(u) ** 2))

    def solved(self, u: Any) -> Any:
        return minimum(self.residual, u, self.problem.parameters.low, self.problem.parameters.high)


def _rounds(problem: _Problem, most: int) -> tuple[_Round, Any, bool]:
    """Returns the best of at most `most` rounds, the solution from it, and whether the solution stays where the round was."""
    best: Optional[_Squares] = None
    u = (problem.parameters.low + problem.parameters.high) / 2
    for _ in range(most):
        here = _Squares(problem, _Round(problem, u))
        if best is not None and here.chi2(u) > WORSE * max(best.chi2(best.here.u), len(here.data)):  # the step was too long
            u = (u + best.here.u) / 2
            continue
        best, found = here, here.solved(u)
        slopes = here.whitened(here.here.jacobian(u, here.here.values))
        known = _known(slopes, slopes)
        near = np.abs(found - u) <= NEAR * np.sqrt(np.diag(known.covariance)) + 1e-6
        u = found
        if (near | known.lost).all():
            return best.here, u, True
    assert best is not None
    return best.here, u, False


def _words(parameters: _Parameters, u: Any, known: _Known, chi2: float, degrees: int, settled: bool) -> str:
    """Returns warnings for the user, empty if all is well."""
    told = []

    def listed(which: Any) -> str:
        return " and ".join(name for name, one in zip(parameters.names, which) if one)
    stopped = np.minimum(u - parameters.low, parameters.high - u) < 1e-6
    if known.lost.any():
        told.append(f"The data do not tell {listed(known.lost)}: many of their values explain them as well.")
    if stopped.any():
        told.append(f"A bound stopped {listed(stopped)}: its standard error is that without it.")
    if (known.noisy & ~known.lost).any():
        told.append(f"Much of what the data seem to tell of {listed(known.noisy & ~known.lost)} is noise of the flights' slopes: more photons, for values and errors to be trusted.")
    if unlikely(chi2, degrees):
        told.append(f"The model does not explain the data: chi square {chi2:.3g} is no chance.")
    if not settled:
        told.append("The last round still moved the solution: more `flights` would settle it.")
    return " ".join(told)


def fit_spectrum(scene: Union[Scene, Path], parameters: Any, measured: Any, model: Any, wavelengths: Any, flights: int, options: Mapping[str, Any]) -> SpectrumFit:
    """Fits parameters of media: see `fit`."""
    if not callable(model):
        raise errors.refuse("media", model, "a function of the parameters that returns media as `spectrum` takes them")
    sought, nm = _parameters(parameters), rising("wavelengths", wavelengths)
    most = errors.whole("flights", flights, 2, 1000)
    spectra = _read(measured, nm, scene)
    problem = _Problem(scene, model, spectra, sought, options)
    first, start, settled = _rounds(problem, most - 1)
    last = _Round(problem, start, OTHER_SEED)
    squares = _Squares(problem, last, first.slopes)
    u = squares.solved(start)
    values = last.model(u, first.slopes)
    rounds = [(one.jacobian(u, values), one.jacobian_noise(u, values)) for one in (first, last)]
    known, dice = _known(*(squares.whitened(slopes) for slopes, _ in rounds)), np.random.default_rng(1)
    redrawn = [correlation(_known(*(squares.whitened(slopes + noise * dice.standard_normal(noise.shape)) for slopes, noise in rounds)).covariance)
               for _ in range(REDRAWN)]
    chi2, degrees = squares.chi2(u), len(values) - len(sought.names)
    sigma = np.where(known.lost, np.inf, np.sqrt(np.diag(known.covariance)) * sought.factors(u))
    return SpectrumFit(values=sought.values(u), errors=dict(zip(sought.names, map(float, sigma))), correlation=correlation(known.covariance),
                       correlation_errors=np.std(redrawn, axis=0), chi2=chi2, degrees=degrees, words=_words(sought, u, known, chi2, degrees, settled),
                       prediction=spectra.parted(values), prediction_errors=spectra.parted(np.sqrt(np.diag(last.noise))), flights=problem.flown,
                       measured=spectra.parted(squares.data), measured_errors=spectra.parted(spectra.join(lambda _, data: data.errors)),
                       places=spectra.parted(nm[last.wavelength]))
