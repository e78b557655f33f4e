"""Reflection and transmission of a scene by directions, for renderers and for comparison with goniometers.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import os
import warnings
from typing import TYPE_CHECKING, Any, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from . import errors
from .brdf_fit import Fitted, fit_bins, reciprocity
from .brdf_flight import Bins, Setup, fly_angles, fly_packets, kind_of
from .channels import channel_rows, channel_table
from .command_line import MOST_THREADS, Parser, file_stem, print_text, shown_path
from .gloss import CELLS, cells_of
from .material import Material
from .mco import NUMERAL
from .options import Path
from .relit import told_of
from .scene import MOST_PHOTONS, Scene
from .scene_files import as_file

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

ANGLES = (0, 10, 20, 30, 40, 50, 60, 65, 70, 75, 80, 85)
BINS = (18, 36)
STEEPEST = 89.0  # largest angle of incidence [degrees]
POOR, FAR = 1.5, 0.03  # a fit is poor if chi^2 per degree of freedom and the relative distance from the bins beyond noise are both above these limits
GLOSS, MOST_SAVED = 1_000_000, 2_000_000  # packets that fill the cells of a lobe at each angle: the least and the largest number
LEAST = 1e-6  # a lobe exists if light that was never inside is a larger share of all light
EXACT = 1e-5  # sine of the angle around the mirrored direction that counts as exact, because saved directions are in single precision


# ---- arguments ----

def _angles(angles: Any) -> Any:
    values = errors.array("angles", ANGLES if angles is None else angles, "iuf", "a list of angles [degrees]").astype(float)
    if values.ndim != 1 or not len(values) or values.min() < 0 or values.max() > STEEPEST or (np.diff(values) <= 0).any():
        raise errors.refuse("angles", angles, f"rising angles from 0 to {STEEPEST:g} degrees")
    return values


def _bins(bins: Any) -> tuple[int, int]:
    if not isinstance(bins, (tuple, list)) or len(bins) != 2:
        raise errors.refuse("bins", bins, "two numbers, of theta and of phi")
    nt, across = errors.whole("bins[0]", bins[0], 2, 900), errors.whole("bins[1]", bins[1], 4, 1800)
    if across % 2:
        raise errors.refuse("bins[1]", across, "an even number")
    return nt, across


# ---- one channel ----

def _albedo(result: Any, back: bool) -> dict[str, float]:
    """Returns the totals of the lit side and of the other side. The error of the lit side comes from a detector that sees the
    whole side."""
    up, down = float(result.Rd) + float(result.Rsp), float(result.Tt)
    up_se, down_se = float(np.hypot(result.Rd_se, result.Rsp_se)), float(result.Tt_se)
    lit, lit_se, far, far_se = (down, float(result.detector_lit_se), up, up_se) if back else (up, float(result.detector_lit_se), down, down_se)
    kept = {name: float(result[name]) for name in ("A_backing", "A_backing_se") if name in result}
    return {**kept, "albedo_R": lit, "albedo_R_se": lit_se, "albedo_T": far, "albedo_T_se": far_se, "A": float(result.A), "A_se": float(result.A_se),
            **{f"mirror_{side}{end}": float(result[f"detector_{name}{end}"]) for side, name in (("R", "mirror"), ("T", "through")) for end in ("", "_se")}}


def _directions(setup: Setup, channel: int, i: int, result: Any, bins: Bins) -> dict[str, Any]:
    """Returns the shares of light in the bins at one angle of incidence, without exact mirror images.
    `in`: light that comes back from inside the scene. `gloss`: light reflected at the surface. `t`: light that went through."""
    of = {name: bins.shares(result[name + "_dir"].values, result[name + "_dir_se"].values) for name in ("Rd", "Rsp", "Tt")}
    angle, mirror, inner = np.radians(setup.angles[i]), float(result.detector_mirror), float(result.detector_mirror_in)
    through = np.radians(setup.through(setup.angles[i], channel))
    if setup.back:
        up = (of["Rd"][0] + of["Rsp"][0], np.hypot(of["Rd"][1], of["Rsp"][1]))
        parts = {"in": bins.without(*of["Tt"], mirror, angle), "t": bins.without(*up, float(result.detector_through), through)}
        parts["gloss"] = (np.zeros_like(parts["in"][0]),) * 2
    else:
        parts = {"in": bins.without(*of["Rd"], inner, angle), "gloss": bins.without(*of["Rsp"], mirror - inner, angle),
                 "t": bins.without(*of["Tt"], float(result.detector_through), through)}
    return {name + end: values for name, pair in parts.items() for end, values in zip(("", "_se"), pair)}


def _half_cells(setup: Setup, channel: int, photons: int, gloss: bool) -> Any:
    """Returns f in the cells of half vectors [angle of incidence, v, u]. Exact mirror images are left out. Light that a rough
    face sends near the mirrored direction stays."""
    found = []
    for i, angle in enumerate(np.radians(setup.angles)):
        weights, flights = fly_packets(setup, channel, i, min(max(photons, GLOSS), MOST_SAVED), gloss)
        image = np.array([np.sin(angle), 0.0, np.cos(angle)])
        apart = np.linalg.norm(np.cross(flights, image), axis=1) > EXACT
        found.append(cells_of(weights[apart], flights[apart], angle, CELLS))
    return np.array(found)


def _is_lobe(shares: Any) -> bool:
    return bool(shares["gloss"].sum(axis=(1, 2)).max() > LEAST)


def _surface(numbers: Mapping[str, float]) -> tuple[tuple[str, float], ...]:
    """Returns the numbers of a channel on which a lobe depends: all except mua, mus, g and d."""
    return tuple(item for item in numbers.items() if not item[0].endswith((".mua", ".mus", ".g", ".d")))


def _fit(setup: Setup, channel: int, shares: Mapping[str, Any], bins: Bins) -> Fitted:
    """Returns the better of two fits by chi^2: one for a smooth face, and one in powers of the outer cosines, which suits a
    rough face."""
    near, layer, _ = setup.outer(channel)
    tried = [fit_bins(shares["in"], shares["in_se"], np.radians(setup.angles), index, bins) for index in dict.fromkeys([layer / near, 1.0])]
    return min(tried, key=lambda fitted: fitted.chi2)


def _misfit(shares: Mapping[str, Any], fitted: Fitted) -> float:
    """Returns the relative distance (rms, weighted by light) of the fit from the bins, beyond the distance that noise explains."""
    light = shares["in"].sum()
    noise = np.sqrt((shares["in_se"] ** 2).sum() * shares["in"].size) / light if light > 0 else 0.0
    return float(np.sqrt(max(fitted.chi2 - 1, 0.0)) * noise)


def _pairs(setup: Setup, shares: Mapping[str, Any], fitted: Fitted, bins: Bins) -> Any:
    """Tests reciprocity of the bins of one channel, [pair, 4]. Means over the azimuth are compared. Over tiles, which may have
    a direction, only the plane of incidence is compared."""
    step = bins.np // 2 if kind_of(setup.told) == "tiles" else 1
    both = (shares["in"] + shares["gloss"])[:, :, ::step], np.hypot(shares["in_se"], shares["gloss_se"])[:, :, ::step]
    area = bins.projected() * both[0].shape[2]
    with np.errstate(divide="ignore", invalid="ignore"):
        narrow = fitted.middles.mean(axis=2) / fitted.means.mean(axis=2)
    narrow = np.where(np.isfinite(narrow) & (narrow > 0.5) & (narrow < 2), narrow, 1.0)
    found = reciprocity(both[0].sum(axis=2) / area, np.sqrt((both[1] ** 2).sum(axis=2)) / area, setup.angles, bins, narrow)
    return np.array(found).reshape(-1, 4)


# ---- all of it ----

def _lobes(setup: Setup, channels: Sequence[Mapping[str, Any]], poor: bool) -> Any:
    """Returns f in half-vector cells [channel, angle, v, u]. Channels with equal surfaces share one flight of the lobe."""
    made: dict[Any, Any] = {}
    found = []
    for c, channel in enumerate(channels):
        key = c if poor else _surface(setup.sets[c])
        if key not in made:
            made[key] = _half_cells(setup, c, int(max(channel["photons"])), not poor)
        found.append(made[key])
    return np.array(found)


def _dataset(setup: Setup, labels: Sequence[Any], channels: Sequence[Mapping[str, Any]], half: Any, bins: Bins) -> xr.Dataset:
    """Returns the BRDFs of all channels as one xarray.Dataset."""
    import xarray as xr
    axes = {"theta_i": setup.angles, "theta": np.degrees(bins.middles()).round(9), "phi": np.degrees(bins.azimuths()).round(9)}
    lead, area = (["channel"] if labels else []), bins.projected()[:, None]

    def stacked(values: Any, dims: Sequence[str], units: str, text: str) -> Any:
        array = np.stack(values) if labels else np.asarray(values[0])
        return xr.DataArray(array, dims=[*lead, *dims], attrs={"units": units, "long_name": text})

    data = xr.Dataset(coords={name: (name, values, {"units": "degree"}) for name, values in axes.items()})
    whole = ["theta_i", "theta", "phi"]
    for name, parts, text in (("f_r", ("in", "gloss"), "BRDF without mirror images"), ("f_gloss", ("gloss",), "BRDF of light that was never inside"),
                              ("f_t", ("t",), "BTDF of flux without straight light; radiance has n_below^2 / n_above^2 more")):
        data[name] = stacked([sum(c["bins"][part] for part in parts) / area for c in channels], whole, "1/sr", text)
        errors_ = [np.sqrt(sum(c["bins"][part + "_se"] ** 2 for part in parts)) / area for c in channels]
        data[name + "_se"] = stacked(errors_, whole, "1/sr", "standard error of " + name)
    data["f_fit"] = stacked([c["fit"].means for c in channels], whole, "1/sr", "smooth fit of light that was inside, mean over each bin")
    data["fit"] = stacked([c["fit"].coefficients for c in channels], ["term"], "1/sr", "coefficients of the fit")
    data["chi2"] = stacked([c["fit"].chi2 for c in channels], [], "1", "chi^2 per degree of freedom of the fit")
    data["misfit"] = stacked([c["misfit"] for c in channels], [], "1", "relative distance of the fit from the bins beyond noise")
    data["index"] = stacked([c["index"] for c in channels], [], "1", "n of the lit layer over that of the medium before it, as the fit takes it; 1 under a rough face")
    for name in channels[0]["totals"][0]:
        data[name] = stacked([[total[name] for total in c["totals"]] for c in channels], ["theta_i"], "1", name.replace("_se", ", standard error"))
    data["photons"] = stacked([c["photons"] for c in channels], ["theta_i"], "1", "packets")
    if half is not None:
        data["f_half"] = stacked(half, ["theta_i", "half_phi", "half_theta"], "1/sr", "BRDF in cells of half vectors, as .bsdf files have them")
    return data.assign_coords(channel=("channel", labels)) if labels else data


def _projected(data: xr.Dataset, bins: Bins) -> xr.Dataset:
    import xarray as xr
    weights = xr.DataArray(bins.projected(), dims=["theta"], attrs={"units": "sr", "long_name": "projected solid angle of a bin"})
    return data.assign(projected=weights)


def brdf(scene: Union[Scene, Path], angles: Optional[ArrayLike] = None, photons: Optional[float] = None, target_error: Optional[float] = 0.01,
         back: bool = False, *, channels: Union[Mapping[str, Any], pd.DataFrame, None] = None, bins: Sequence[int] = BINS, seed: int = 1,
         threads: Optional[int] = None) -> Material:
    """Computes the BRDF and BTDF of a scene by a sweep of the angle of incidence.

    Args:
        scene: A Scene, or the path of an `.mci` file. Its own beams and tallies are left out.
        angles: Angles of incidence [degrees], rising, from 0 to 89.
        photons: Photons at each angle; None takes the scene's.
        target_error: Rounds follow until the relative error of the albedo is at most this; None simulates no further rounds.
        back: Whether light comes from below.
        channels: Columns, as a dict or a DataFrame: nm (wavelengths) or channel (r, g, b), and what is set, as in {"nm": [450, 650], "layer1.mua": [3, 1]}.
        bins: Numbers of bins of theta and phi.
        seed: The same seed gives the same bytes.
        threads: Number of threads.

    Returns:
        A Material, which has the arrays and writes files for renderers.

    Examples:
        >>> brdf("scene.mci", angles=[0, 95])
        Traceback (most recent call last):
        ...
        clustermcml.errors.InputError: angles = [0, 95] (expected rising angles from 0 to 89 degrees)
    """
    values, sides, (labels, sets) = _angles(angles), Bins(*_bins(bins)), channel_rows(channels)
    errors.flag("back", back)
    photons = None if photons is None else errors.whole("photons", photons, 1, MOST_PHOTONS)
    target_error = None if target_error is None else errors.number("target_error", target_error, 1e-9, 1, "a number from 1e-9 to 1, or None")
    errors.whole("seed", seed, 0, 2**40)
    options = {name: value for name, value in (("photons", photons), ("target_error", target_error), ("threads", threads)) if value is not None}
    with as_file(scene) as (path, _):
        setup = Setup(path, told_of(scene if isinstance(scene, Scene) else path), values, sets, (sides.nt, sides.np), back, int(seed), options)
        flown = fly_angles(setup)
        found: list[dict[str, Any]] = []
        for c, results in enumerate(flown):
            by_angle = [_directions(setup, c, i, result, sides) for i, result in enumerate(results)]
            shares = {name: np.stack([one[name] for one in by_angle]) for name in by_angle[0]}
            fitted = _fit(setup, c, shares, sides)
            found.append({"bins": shares, "fit": fitted, "misfit": _misfit(shares, fitted), "index": fitted.index,
                          "totals": [_albedo(result, back) for result in results], "photons": [float(result.attrs["photons"]) for result in results]})
        poor = any(c["fit"].chi2 > POOR and c["misfit"] > FAR for c in found)
        lobe = any(_is_lobe(c["bins"]) for c in found)
        half = _lobes(setup, found, poor) if poor or lobe else None
    data = _projected(_dataset(setup, labels, found, half, sides), sides)
    pairs = _pairs(setup, found[0]["bins"], found[0]["fit"], sides)
    data["reciprocity"] = (("pair", "of_pair"), pairs, {"long_name": "angles [degrees], f(i, o) / f(o, i) - 1, z: self-test of the first channel"})
    near, layer, far = setup.outer(0)
    first = flown[0][0].attrs
    data.attrs.update({"scene": "Scene" if isinstance(scene, Scene) else shown_path(os.fspath(scene)), "version": first["version"], "identity": first["identity"], "seed": int(seed),
                       "side": "back" if back else "front", "n_lit": near, "n_layer": layer, "n_other": far, "half": "all" if poor else "gloss" if lobe else "none"})
    return Material(data)


# ---- command ----

def _report_lines(material: Material) -> list[str]:
    """Returns the lines that the command prints for a material."""
    lines = []
    labels = material.channels() or [""]
    for c, label in enumerate(labels):
        for i, angle in enumerate(material.data["theta_i"].values):
            values = {name: float(material._each(name)[c, i]) for name in ("albedo_R", "albedo_R_se", "albedo_T", "A", "mirror_R", "mirror_T")}
            ground = f", A_backing {material._each('A_backing')[c, i]:.5f}" if "A_backing" in material.data else ""
            share = float((material._each("f_gloss")[c, i] * material.data["projected"].values[:, None]).sum())
            gloss = "" if material.data.attrs["side"] == "back" else f"gloss {share:.5f}, "  # light from below: gloss cannot be told from other light
            lines.append(f"{label} {angle:4g} degrees: R {values['albedo_R']:.5f} +- {values['albedo_R_se']:.5f}, T {values['albedo_T']:.5f}, A {values['A']:.5f}{ground}; "
                         f"{gloss}mirror image {values['mirror_R']:.5f}, straight through {values['mirror_T']:.5f}".strip())
    lines.append("fit of light that was inside: chi^2 per degree of freedom " + " ".join(f"{value:.2f}" for value in np.atleast_1d(material.data["chi2"].values))
                 + ", beyond noise " + " ".join(f"{100 * value:.1f} %" for value in np.atleast_1d(material.data["misfit"].values)))
    pairs = material.data["reciprocity"].values
    if len(pairs):
        lines.append(f"reciprocity of the bins: f(i, o) and f(o, i) differ by {100 * np.median(abs(pairs[:, 2])):.1f} % (median of {len(pairs)} pairs), worst z {abs(pairs[:, 3]).max():.1f}")
    return lines


def _write_all(material: Material, stem: str) -> list[str]:
    """Writes all files of the command. Returns their names."""
    labels = material.channels()
    kinds = [".rgb.bsdf"] if labels == ["r", "g", "b"] else [".bsdf"] if labels else [".bsdf", ".rgb.bsdf"]
    names = [stem + ".brdf.h5", stem + ".brdf.txt", *(stem + kind for kind in kinds)]
    material.to_h5(names[0])
    material.to_text(names[1])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for name in names[2:]:
            material.to_bsdf(name)
    return names


def main(words: list[str]) -> int:
    parser = Parser("brdf", "scene.mci", "Flies a scene in light from several angles and writes its BRDF and BTDF: NAME.brdf.h5 and NAME.brdf.txt (tables), NAME.bsdf and NAME.rgb.bsdf "
                    "(for Mitsuba 3 and pbrt-v4).", "clustermcml brdf samples/paint_gloss.mci -o paint --photons 1e6")
    parser.add_argument("scene", metavar="scene.mci")
    parser.add_argument("-o", "--output", metavar="NAME", help="beginning of the names of all files; default: that of the scene")
    parser.add_argument("--angles", metavar="A,B,...", help="angles of incidence [degrees]; default " + ",".join(map(str, ANGLES)))
    parser.add_argument("--photons", metavar="N", type=parser.whole(1, MOST_PHOTONS), help="packets at each angle; default: the scene's")
    parser.add_argument("--target-error", metavar="E", type=parser.number("a number from 1e-9 to 1", 1e-9, 1), default=0.01, help="relative error of every albedo, default 0.01: more rounds fly")
    parser.add_argument("--label", metavar="nm=TABLE.csv", help="a channel for each row of a table: NAME is its column of wavelengths, or channel for r, g and b")
    parser.add_argument("--back", action="store_true", help="light comes from below")
    parser.add_argument("--seed", metavar="N", type=parser.whole(0, 2**40), default=1, help="default 1")
    parser.add_argument("--threads", metavar="N", type=parser.whole(1, MOST_THREADS), help="default: all cores")
    parser.add_argument("--quiet", action="store_true", help="prints nothing")
    given = parser.parse_args(words)
    angles = None
    if given.angles is not None:
        cells = given.angles.split(",")
        if not all(NUMERAL.fullmatch(cell) for cell in cells):
            raise errors.InputError(f"--angles {given.angles} (expected angles in degrees, as 0,30,60)")
        angles = [float(cell) for cell in cells]
    stem = file_stem("brdf", given.output, (".brdf.h5", ".brdf.txt", ".bsdf", ".rgb.bsdf"), given.scene, given.label)
    material = brdf(given.scene, angles, given.photons, given.target_error, given.back, channels=channel_table(given.label) if given.label else None,
                    seed=given.seed, threads=given.threads)
    names = _write_all(material, stem)
    if material.mirror_note():
        warnings.warn(material.mirror_note())
    return 0 if given.quiet else print_text("\n".join([*_report_lines(material), *map(shown_path, names), ""]))
