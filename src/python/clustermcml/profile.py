"""Subsurface profiles for renderers: the distances from a pencil of light at which the light comes out again.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Mapping, Optional, Sequence, Union

import numpy as np

from . import errors
from .channels import OfChannels, channel_rows, channel_table
from .command_line import MOST_THREADS, Parser, file_stem, path_of, picture_path, print_text, shown_path, write
from .options import Path
from .pictures import COLOURS, drawing, save
from .profile_fits import Curve, Shares, fit_burley, fit_sum, scaled, single_albedo
from .profile_flight import BINS, LIGHT, Flight, Target, bin_width, fly_profile
from .relit import told_of
from .scene import Layer, Scene
from .scene_files import as_file

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

KINDS = ("exponentials", "gaussians", "burley", "openpbr")
ERROR = 0.01
CHANNEL_COLOURS = {"r": COLOURS[1], "g": COLOURS[2], "b": COLOURS[0], "flown": "#808080"}
WALK = 300_000  # packets of a random walk
FINER = 10  # bins of a random walk for each bin of the profile
FORMULAS = {"exponentials": "S = Rd sum w exp(-r / d) / (2 pi d r); cdf = 1 - sum w exp(-r / d)",
            "gaussians": "S = Rd sum w exp(-r^2 / (2 sigma^2)) / (2 pi sigma^2); cdf = 1 - sum w exp(-r^2 / (2 sigma^2))",
            "burley": "S = Rd (exp(-r / d) + exp(-r / (3 d))) / (8 pi d r); cdf = 1 - exp(-r / d) / 4 - 3/4 exp(-r / (3 d))",
            "openpbr": "index-matched isotropic half space of the single-scattering albedo `albedo` and the mean free path `subsurface_radius_cm`"}


# ---- the result ----

@dataclass(repr=False)
class Profile(OfChannels):
    """The result of `profile`. Its arrays are attributes: `found.S` is `found.data.S`.

    S and S_se are the light that leaves per area and launched packet, over r [1/cm2], and its standard error. cdf is the share of that light within the
    outer edge of the bin. Rd and Rd_se are all of that light, Rsp is what the surface has reflected, mean_r is the mean radius [cm], and noise is
    the mean of the integral of abs(S - truth) 2 pi r dr / Rd. With channels S is over channel and bin, and r is a coordinate [channel, bin],
    because every channel has bins of its own width.

    Attributes:
        data: xarray.Dataset of all arrays.
        threads: Number of threads for the flights of `fit("openpbr")`.
    """

    data: xr.Dataset
    threads: Optional[int] = None
    _fits: dict[str, list[Any]] = field(default_factory=dict, repr=False)

    def _shares(self, channel: int) -> Shares:
        r, cdf, Rd = (self._each(name)[channel] for name in ("r", "cdf", "Rd"))
        width = 2 * r[0]
        edges = width * np.arange(len(r) + 1)
        area = 2 * np.pi * r * width / Rd
        return Shares(edges, np.append(self._each("S")[channel] * area, 1 - cdf[-1]), np.append(self._each("S_se")[channel] * area, self._each("beyond_se")[channel]))

    # ---- fits ----

    def _walk(self, channel: int) -> dict[str, Any]:
        """Flies a random walk, as renderers do, with the Rd and the mean radius of the profile. Returns its parameters and its
        error L1."""
        profile, Rd = self._shares(channel), float(self._each("Rd")[channel])
        albedo, light = single_albedo(Rd), str(self.data.attrs["light"])
        scene = Scene([Layer(n=1, mua=1 - albedo, mus=albedo, g=0, d=1e8)])
        with as_file(scene) as (path, _):
            target = Target(path, None, light, "random walk", {}, self.threads)
            seed = int(self.data.attrs["seed"])
            width = bin_width(target, seed) / FINER
            flown = fly_profile(target, width, WALK, None, seed + 2**38, BINS * FINER)
        radius, shares = scaled(profile, Shares(width * np.arange(BINS * FINER + 1), flown.light / flown.Rd, flown.light_se / flown.Rd))
        return {"subsurface_color": Rd, "subsurface_radius_cm": radius, "albedo": albedo, "Rd_walk": flown.Rd, "L1": profile.error_of(shares), "shares": shares}

    def _fitted(self, kind: str, terms: Optional[int] = None) -> list[Any]:
        """Returns a fit for each channel. Fits with the usual number of terms are made once and kept."""
        errors.choice("kind", kind, *KINDS)
        if terms is not None and kind not in ("exponentials", "gaussians"):
            raise errors.refuse("terms", terms, f"None for {kind}")
        if terms is None and kind in self._fits:
            return self._fits[kind]
        found: list[Any] = []
        for channel in range(max(len(self.channels()), 1)):
            if kind == "openpbr":
                found.append(self._walk(channel))
            elif kind == "burley":
                found.append(fit_burley(self._shares(channel)))
            else:
                found.append(fit_sum(kind, self._shares(channel), None if terms is None else errors.whole("terms", terms, 1, 5 if kind == "exponentials" else 12)))
        if terms is None:
            self._fits[kind] = found
        return found

    def fit(self, kind: str = "exponentials", terms: Optional[int] = None) -> xr.Dataset:
        """Fits a curve to S.

        Args:
            kind: "exponentials" (three with signed weights, four where three are off by more than 2 %), "gaussians" (six with weights above 0), "burley", or
                "openpbr", a random walk that is simulated for this.
            terms: Another number of exponentials or Gaussians.

        Returns:
            An xarray.Dataset: w, d or sigma [cm] with their errors over term; L1, the integral of abs(model - S) 2 pi r dr / Rd with the noise of S included;
                the model's S and cdf over r. attrs["formula"] says what the parameters mean.
        """
        import xarray as xr
        found, labels = self._fitted(kind, terms), self.channels()
        dims, axis = (["channel"] if labels else []), self.data["S"].dims[-1:]

        def stacked(values: Sequence[Any], over: Sequence[Any] = ()) -> Any:
            most = max(np.size(value) for value in values)
            padded = [np.append(value, np.full(most - np.size(value), np.nan)) if over else value for value in values]
            return [*dims, *over], np.array(padded) if labels else np.asarray(padded[0])
        data = {name: stacked(values, over) for name, (values, over) in _parameters(kind, found).items()}
        shares = [one["shares"] if isinstance(one, dict) else one.shares for one in found]
        area = [2 * np.pi * r * 2 * r[0] / Rd for r, Rd in zip(self._each("r"), self._each("Rd"))]
        data["S"] = stacked([part[:-1] / ring for part, ring in zip(shares, area)], axis)
        data["cdf"] = stacked([np.cumsum(part[:-1]) for part in shares], axis)
        return xr.Dataset(data, coords=self.data.coords, attrs={"kind": kind, "formula": FORMULAS[kind]})

    # ---- files ----

    def _json_fit(self, kind: str) -> dict[str, Any]:
        found, many = self._fitted(kind), bool(self.channels())
        names = {"w": "w", "w_se": "w_se", "d": "d_cm", "d_se": "d_se_cm", "sigma": "sigma_cm", "sigma_se": "sigma_se_cm"}
        values = {names.get(name, name): [np.asarray(value).tolist() for value in values] for name, (values, _) in _parameters(kind, found).items()}
        return {name: _without_nan(value if many else value[0]) for name, value in values.items()}

    def record(self) -> dict[str, Any]:
        """Returns what `to_json` writes, as a dict of numbers, or of lists over channels where there are any."""
        many = bool(self.channels())

        def of(name: str) -> Any:
            values = self.data[name].values.tolist()
            return [int(value) for value in values] if many and name == "photons" else int(values) if name == "photons" else values
        told: dict[str, Any] = {str(self.data.attrs["label"]): self.channels()} if many else {}
        told.update({"n": of("n"), "light": self.data.attrs["light"], "Rd": of("Rd"), "Rd_se": of("Rd_se"), "Rsp": of("Rsp"), "mean_r_cm": of("mean_r"), "noise": of("noise")})
        told["fits"] = {kind: {**self._json_fit(kind), "formula": FORMULAS[kind]} for kind in KINDS}
        told.update({name: self.data.attrs[name] for name in ("scene", "version", "identity", "seed")})
        return {**told, "photons": of("photons")}

    def to_json(self, path: Path) -> None:
        """Writes totals, all fits and the parameters of the random walk, each with its error.

        Args:
            path: A name that ends in .json.
        """
        write(path_of(path, ".json"), (json.dumps(self.record(), indent=1) + "\n").encode())

    def to_csv(self, path: Path) -> None:
        """Writes the columns r_mid_cm, S_per_cm2, S_se and cdf, behind the channel where there are any.

        Args:
            path: A name that ends in .csv.
        """
        labels = self.channels()
        lines = [(f"{self.data.attrs['label']}," if labels else "") + "r_mid_cm,S_per_cm2,S_se,cdf"]
        for c, label in enumerate(labels or [None]):
            head = "" if label is None else f"{label:g}," if isinstance(label, float) else f"{label},"
            lines += [head + ",".join(map(repr, row)) for row in np.stack([self._each(name)[c] for name in ("r", "S", "S_se", "cdf")], axis=1).tolist()]
        write(path_of(path, ".csv"), ("\n".join(lines) + "\n").encode())

    def plot(self, path: Path) -> None:
        """Draws S with a band of one standard error, and light per radius, with the fits; of channels with the exponentials alone.

        Args:
            path: Path of the picture: .svg, .png, .pdf or .eps.
        """
        name, labels = picture_path(path), self.channels()
        kinds = KINDS[:1] if labels else KINDS[:3]
        with drawing():
            from matplotlib.figure import Figure
            figure = Figure(figsize=(10.5, 4.4), layout="constrained")
            left, right = figure.subplots(1, 2)
            for c, label in enumerate(labels or ["flown"]):
                r, S, error, colour = self._each("r")[c], self._each("S")[c], self._each("S_se")[c], CHANNEL_COLOURS.get(label, COLOURS[c % len(COLOURS)])
                text = f"{label:g} nm" if isinstance(label, float) else label
                curves = [(text, S, {"color": colour, "lw": 1.4 if labels else 3.0})]
                for k, kind in enumerate(kinds):
                    curve = self._fitted(kind)[c]
                    curves.append((None if labels else f"{kind}, L1 {curve.L1:.3f}", curve.shares[:-1] * self._each("Rd")[c] / (4 * np.pi * r * r[0]),
                                   {"color": "#000000" if labels else COLOURS[k], "lw": 1.1, "ls": "--" if labels else "-"}))
                left.fill_between(r, np.maximum(S - error, 1e-300), S + error, color=colour, alpha=0.3, lw=0)
                for words, values, look in curves:
                    left.plot(r, values, label=words, **look)
                    right.plot(r, 2 * np.pi * r * values / self._each("Rd")[c], label=words, **look)
            left.set(yscale="log", xlabel="r [cm]", ylabel="S [1/cm2]", ylim=_span(self.data["S"].values))
            right.set(xlabel="r [cm]", ylabel="2 pi r S / Rd [1/cm]", xlim=(0, 3 * float(self.data["mean_r"].max())), ylim=(0, None))
            right.legend(fontsize="small")
            figure.suptitle(f"{os.path.basename(self.data.attrs['scene'])}, {self.data.attrs['light']} light" + (": dashed, exponentials" if labels else ""))
            save(figure, name)


def _span(values: Any) -> tuple[float, float]:
    light = values[values > 0]
    return max(float(light.min()), float(light.max()) * 1e-8) / 2, float(light.max()) * 2


def _without_nan(value: Any) -> Any:
    """Returns nested lists with None in place of NaN and infinity, which JSON cannot hold. Terms of weight 0 have such lengths and errors."""
    if isinstance(value, list):
        return [_without_nan(one) for one in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _parameters(kind: str, found: Sequence[Any]) -> dict[str, tuple[list[Any], Sequence[str]]]:
    """Returns the numbers of a fit by name: the values of every channel, and the axis over which they stand."""
    if kind == "openpbr":
        return {name: ([one[name] for one in found], ()) for name in found[0] if name != "shares"}
    curves: Sequence[Curve] = found
    if kind == "burley":
        return {"d": ([one.lengths[0] for one in curves], ()), "d_se": ([one.lengths_se[0] for one in curves], ()), "L1": ([one.L1 for one in curves], ())}
    length = "sigma" if kind == "gaussians" else "d"
    parts = {"w": "weights", "w_se": "weights_se", length: "lengths", length + "_se": "lengths_se"}
    return {**{name: ([getattr(one, part) for one in curves], ("term",)) for name, part in parts.items()}, "L1": ([one.L1 for one in curves], ())}


# ---- the flight ----

def _period(told: Mapping[str, Any], shown: object) -> Optional[Sequence[float]]:
    """Returns the period [cm] of the scene's tiles, or None for planes. Refuses all other scenes."""
    expected = "planes and tiles alone, which are the same everywhere"
    if told.get("bodies"):
        raise errors.refuse("scene", shown, f"{expected}; this one has bodies")
    if told.get("top"):
        raise errors.refuse("scene", shown, f"{expected}; faces and ports touch this one")
    for number, boundary in enumerate(told["boundaries"]):
        if boundary["kind"] != "plane" and "period" not in boundary:
            raise errors.refuse("scene", shown, f"{expected}; boundary {number} is neither")
    periods = [boundary["period"] for boundary in told["boundaries"] if "period" in boundary]
    if any(period != periods[0] for period in periods):
        raise errors.refuse("scene", shown, f"tiles of one period, these have {periods}")
    return periods[0] if periods else None


def _arrays(width: float, flight: Flight, n: float) -> dict[str, Any]:
    r = (np.arange(BINS) + 0.5) * width
    area, Rd = 2 * np.pi * r * width, flight.Rd
    shares = Shares(width * np.arange(BINS + 1), flight.light / Rd, flight.light_se / Rd)
    return {"r": r, "S": flight.light[:-1] / area, "S_se": flight.light_se[:-1] / area, "cdf": 1 - np.cumsum(shares.light[::-1])[::-1][1:], "Rd": Rd, "Rd_se": flight.Rd_se,
            "beyond": flight.light[-1], "beyond_se": shares.light_se[-1], "Rsp": flight.Rsp, "mean_r": shares.mean_radius(), "noise": flight.noise(), "photons": flight.photons, "n": n}


UNITS = {"r": ("cm", "distance from where light came in"), "S": ("cm-2", "light that leaves per area and launched packet"), "S_se": ("cm-2", "standard error of S"),
         "cdf": ("1", "share of that light within the outer edge of the bin"), "Rd": ("1", "diffuse reflectance"), "Rd_se": ("1", "standard error of Rd"),
         "beyond": ("1", "light beyond the bins, per launched packet"), "beyond_se": ("1", "standard error of the share of Rd beyond the bins"),
         "Rsp": ("1", "specular reflectance"), "mean_r": ("cm", "mean of r"), "noise": ("1", "expected L1 of S"), "photons": ("1", "packets"), "n": ("1", "index of the first layer")}


def _dataset(found: Sequence[Mapping[str, Any]], labels: Sequence[Any]) -> xr.Dataset:
    """Returns the profiles of all channels as one xarray.Dataset."""
    import xarray as xr
    data = xr.Dataset()
    for name, (units, text) in UNITS.items():
        values = np.array([one[name] for one in found])
        dims = (["channel"] if labels else []) + ["bin"] * (values.ndim - 1)
        data[name] = (dims, values if labels else values[0], {"units": units, "long_name": text})
    return data.set_coords("r").assign_coords(channel=("channel", list(labels))) if labels else data.set_coords("r").swap_dims({"bin": "r"})


def profile(scene: Union[Scene, Path], light: str = "normal", photons: Optional[float] = None, target_error: Optional[float] = ERROR, *,
            channels: Union[Mapping[str, Any], pd.DataFrame, None] = None, seed: int = 1, threads: Optional[int] = None) -> Profile:
    """Computes the subsurface profile of a scene of planes or tiles: how far from its entry light leaves.

    400 bins hold 99.9 % of the light. Over tiles the profile is the mean over the period.

    Args:
        scene: A Scene, or the path of an `.mci` file. Its own beams and tallies are left out.
        light: "normal" (a pencil straight down) or "diffuse" (from all directions by the cosine law).
        photons: Number of photons; None takes the scene's.
        target_error: Rounds follow until the noise is at most this; None simulates no further rounds.
        channels: Columns, as a dict or a DataFrame: nm (wavelengths) or channel (r, g, b), and what is set, as in {"nm": [450, 650], "layer1.mua": [3, 1]}.
        seed: The same seed gives the same bytes.
        threads: Number of threads.

    Returns:
        A Profile, which has the arrays, fits curves and writes files.

    Examples:
        >>> profile("scene.mci", light="red")
        Traceback (most recent call last):
        ...
        clustermcml.errors.InputError: light = 'red' (expected one of normal diffuse)
    """
    errors.choice("light", light, *LIGHT)
    labels, sets = channel_rows(channels)
    errors.whole("seed", seed, 0, 2**38 - 1)
    if target_error is not None:
        errors.number("target_error", target_error, 1e-6, 1, "a number of 1e-6 to 1, or None")
    shown = "Scene" if isinstance(scene, Scene) else shown_path(os.fspath(scene))
    with as_file(scene) as (path, _):
        told = told_of(scene if isinstance(scene, Scene) else path)
        period = _period(told, shown)
        number = errors.whole("photons", told["photons"] if photons is None else photons, 1000, 2**48)
        found, attrs = [], dict[str, Any]()
        for numbers in sets:
            target = Target(path, period, light, shown, numbers, threads)
            width = bin_width(target, int(seed))
            flight = fly_profile(target, width, number, target_error, int(seed))
            found.append(_arrays(width, flight, float(numbers.get("layer1.n", told["layers"][0]["n"]))))
            attrs = attrs or dict(flight.attrs)
    data = _dataset(found, labels)
    data.attrs.update({"scene": shown, "light": light, "version": attrs["version"], "identity": attrs["identity"], "seed": int(seed)})
    if labels:
        data.attrs["label"] = "nm" if isinstance(labels[0], float) else "channel"
    return Profile(data, threads)


# ---- command ----

def _report_lines(found: Profile) -> list[str]:
    """Returns the lines that the command prints for each channel."""
    lines = []
    for c, label in enumerate(found.channels() or [""]):
        of = {name: found._each(name)[c] for name in ("Rd", "Rd_se", "mean_r", "noise", "photons")}
        lines.append(f"{label} Rd = {errors.rounded(of['Rd'], of['Rd_se'])}, mean r {of['mean_r']:.4g} cm, noise {of['noise']:.4f}, {of['photons']:g} packets".strip())
        curves = {kind: found._fitted(kind)[c] for kind in KINDS}
        lines += ["  " + ", ".join([f"{kind}: L1 {_error(curves[kind]):.4f}", *_terms(kind, curves[kind])]) for kind in KINDS]
    return lines


def _error(curve: Any) -> float:
    return float(curve["L1"] if isinstance(curve, dict) else curve.L1)


def _terms(kind: str, curve: Any) -> list[str]:
    if kind == "openpbr":
        return [f"color {curve['subsurface_color']:.4f}", f"radius {curve['subsurface_radius_cm']:.4g} cm"]
    if kind == "burley":
        return [f"d {errors.rounded(curve.lengths[0], curve.lengths_se[0])} cm"]
    return ["w " + " ".join(f"{value:.4f}" for value in curve.weights), ("sigma " if kind == "gaussians" else "d ") + " ".join(f"{value:.4g}" for value in curve.lengths) + " cm"]


def main(words: list[str]) -> int:
    parser = Parser("profile", "scene.mci", "Flies a pencil of light onto a scene of planes or tiles and writes how far from it the light comes out: NAME.csv (table), NAME.json "
                    "(fits and parameters for renderers), NAME.svg (picture).", "clustermcml profile samples/skin7.mci -o skin")
    parser.add_argument("scene", metavar="scene.mci")
    parser.add_argument("-o", "--output", metavar="NAME", help="beginning of the names of all files; default: that of the scene")
    parser.add_argument("--light", metavar="KIND", default="normal", help="normal (default) or diffuse")
    parser.add_argument("--photons", metavar="N", type=parser.whole(1000, 2**48), help="packets of the first round; default: the scene's")
    parser.add_argument("--target-error", metavar="E", type=parser.number("a number from 1e-6 to 1", 1e-6, 1), default=ERROR, help=f"noise, as an L1, default {ERROR:g}: more rounds fly")
    parser.add_argument("--label", metavar="nm=TABLE.csv", help="a channel for each row of a table: NAME is its column of wavelengths, or channel for r, g and b")
    parser.add_argument("--seed", metavar="N", type=parser.whole(0, 2**38 - 1), default=1, help="default 1")
    parser.add_argument("--threads", metavar="N", type=parser.whole(1, MOST_THREADS), help="default: all cores")
    parser.add_argument("--quiet", action="store_true", help="prints nothing")
    given = parser.parse_args(words)
    endings = (".csv", ".json", ".svg")
    stem = file_stem("profile", given.output, endings, given.scene, given.label)
    found = profile(given.scene, given.light, given.photons, given.target_error, channels=channel_table(given.label) if given.label else None, seed=given.seed, threads=given.threads)
    names = [stem + ending for ending in endings]
    found.to_csv(names[0])
    found.to_json(names[1])
    found.plot(names[2])
    return 0 if given.quiet else print_text("\n".join([*_report_lines(found), *map(shown_path, names), ""]))
