"""A single integrating sphere: how much of the light of a sample its port lets in, and how much more light its walls make of it.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Mapping, Optional, Sequence, Union

import numpy as np

from . import errors
from .options import Path
from .relit import light_lines, relit_text, told_of
from .scene import Scene, Text
from .scene_files import as_file

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    Diffuse = Union[float, tuple[float, float], xr.Dataset]

SIDES = {"M_R": ("R", "top", 0), "M_T": ("T", "bottom", 1)}  # letter, side of a detector, side of saved packets
GAP = 1e-4  # distance of diffuse light from the lowest point of the sample, in radii of the port
PLACES = 1e-6  # largest distance of the port's edge from the edge of a bin, in bins


@dataclass(frozen=True)
class Instrument:
    """An integrating sphere. Without a wall the measurement is one by comparison, where walls have no effect."""

    port: float
    radius: Optional[float] = None
    wall: Optional[float] = None
    ports: float = 0.0
    standard: float = 0.99
    specular: bool = True

    def __post_init__(self) -> None:
        errors.above_zero("port", self.port)
        errors.number("standard", self.standard, 1e-3, 1, "a reflectance above 0, up to 1")
        errors.flag("specular", self.specular)
        if (self.wall is None) != (self.radius is None):
            raise errors.refuse("wall", self.wall, "wall and radius together, or none of them: a measurement by comparison")
        if self.wall is not None and self.radius is not None:
            errors.number("wall", self.wall, 0, 0.9999, "a reflectance from 0 to 0.9999")
            errors.number("radius", self.radius, self.port, 1e300, f"a radius of at least that of the port, {self.port:g}")
            errors.number("ports", self.ports, 0, 1 - self.share, f"the share of the sphere's area that other ports take, from 0 to {1 - self.share:g}")

    @property
    def share(self) -> float:
        """Share of the sphere's area that the sample's port takes."""
        return 0.0 if self.radius is None else float(1 - np.sqrt(1 - (self.port / self.radius) ** 2)) / 2

    def gain(self, reflectance: Any) -> Any:
        return 1.0 if self.wall is None else 1 / (1 - (1 - self.share - self.ports) * self.wall - self.share * reflectance)

    def reading(self, name: str, light: Any, light_se: Any, diffuse: Any, diffuse_se: Any) -> tuple[Any, Any]:
        """Returns what the instrument measures, and its error. light: share of the beam that enters the sphere. diffuse: reflectance of
        the sample for light from the sphere."""
        gain, reference = self.gain(diffuse), self.gain(self.standard if name == "M_R" else 0.0)
        return light * gain / reference, np.hypot(light_se * gain, light * self.share * gain**2 * diffuse_se) / reference

    def slope(self, name: str, light: Any, dlight: Any, diffuse: Any, ddiffuse: Any) -> Any:
        """Returns the derivative of a reading. dlight, ddiffuse: derivatives of the light and of the diffuse reflectance."""
        gain, reference = self.gain(diffuse), self.gain(self.standard if name == "M_R" else 0.0)
        return (dlight * gain + light * self.share * gain**2 * ddiffuse) / reference


# ---- readings of a result ----

def _rings(result: xr.Dataset, name: str, port: float) -> tuple[float, float]:
    """Returns the light within the port and its error. A packet leaves once, so rings are correlated as the bins of a count are."""
    if name not in result or name + "_se" not in result:
        raise errors.refuse("result", name, "a Dataset of a run, with its errors")
    r, photons = result["r"].values, float(result.attrs["photons"])
    width = 2 * r[0]
    count = round(port / width)
    if abs(port / width - count) > PLACES or not 1 <= count < r.size:
        raise errors.refuse("port", port, f"a multiple of dr = {width:.9g}, below nr dr = {width * r.size:.9g}; or saved packets")
    areas = 2 * np.pi * r[:count] * width
    light, spread = result[name].values[:count] * areas, result[name + "_se"].values[:count] * areas
    return float(light.sum()), float(np.sqrt(max((spread**2).sum() - (light.sum() ** 2 - (light**2).sum()) / photons, 0.0)))


def _packets(saved: pd.DataFrame, side: int, port: float) -> tuple[float, float]:
    count = saved.attrs.get("covers")
    if count is None or {"weight", "x", "y", "side"} - set(saved.columns) or saved.attrs.get("detected"):
        raise errors.refuse("saved", "a table", "the table of read_photons, of all packets and not of detected ones")
    weight = saved["weight"][(saved["side"] == side) & (np.hypot(saved["x"], saved["y"]) <= port)].to_numpy(float)
    return float(weight.sum() / count), float(np.sqrt(max((weight**2).sum() - weight.sum() ** 2 / count, 0.0)) / count)


def _light(result: xr.Dataset, name: str, instrument: Instrument, saved: Optional[pd.DataFrame]) -> tuple[float, float]:
    letter, _, side = SIDES[name]
    light, error = _rings(result, "Rd_r" if letter == "R" else "Tt_r", instrument.port) if saved is None else _packets(saved, side, instrument.port)
    if letter == "R" and instrument.specular:
        return light + float(result["Rsp"]), float(np.hypot(error, result["Rsp_se"]))
    return light, error


def _diffuse(argument: str, value: Any, name: str, instrument: Instrument) -> tuple[float, float]:
    """Returns the reflectance of the sample for diffuse light on its port, and the error."""
    import xarray as xr
    if instrument.wall is None:
        if value is not None:
            raise errors.refuse(argument, value, "None without a wall")
        return 0.0, 0.0
    if isinstance(value, xr.Dataset):
        return _light(value, name, Instrument(instrument.port), None)
    expected = "a reflectance from 0 to 1, alone or with its error, or a Dataset of diffuse light on the port"
    try:
        number, error = value if isinstance(value, (tuple, list)) else (value, 0.0)
    except ValueError:
        raise errors.refuse(argument, value, expected) from None
    return errors.number(argument, number, 0, 1, expected), errors.number(argument, error, 0, 1, expected)


def sphere(result: xr.Dataset, port: float, *, radius: Optional[float] = None, wall: Optional[float] = None, ports: float = 0.0, standard: float = 0.99,
           diffuse: Optional[Diffuse] = None, diffuse_below: Optional[Diffuse] = None, specular: bool = True,
           saved: Optional[pd.DataFrame] = None) -> xr.Dataset:
    """Returns what a single integrating sphere measures of a sample: M_R with the sphere above, M_T with the sphere below.

    Light that leaves the sample beyond the port is lost. Without `wall`, sample and reference stay in the sphere (comparison, dual beam): M_R is the
    reflected light within the port, and M_T the transmitted light. With `wall` and `radius`, sample and reference take turns in one port
    (substitution, single beam), and the walls add a gain. With the shares of area a_s = (1 - sqrt(1 - (port / radius)^2)) / 2 of the sample and
    a_w = 1 - a_s - ports of the wall, a sphere without a baffle has the gain G(r) = 1 / (1 - a_w wall - a_s r), and

        M_R = standard R G(r) / (standard G(standard)) = R G(r) / G(standard)
        M_T = T G(r) / G(0)

    The equations take a flat port for a part of the sphere, so that M_T is too small by a share a_s at most.
    R and T are the light within the port, and r is the reflectance of the sample for diffuse light from the sphere, within the port as well. The
    reference of M_R is a standard in the sample's port; that of M_T is the beam in the sphere whose sample port is open. Sources: J. W.
    Pickering et al., Appl. Opt. 32, 399-410 (1993); S. A. Prahl, Inverse Adding-Doubling, manual, single sphere.

    Args:
        result: A Dataset of `run`, `read` or `merge`. The port lies around the z axis.
        port: Radius of the sample's port [cm], a multiple of the scene's dr unless `saved` is given.
        radius: Radius of the sphere [cm].
        wall: Reflectance of the wall.
        ports: Share of the sphere's area that all other ports and the detector take; they reflect nothing.
        standard: Reflectance of the reference standard.
        diffuse: Reflectance r for light from above: a number, a pair of number and standard error, or a Dataset of a run whose beam is
            `Beam("disk", radius=port, light="lambertian")`. Needed with `wall`.
        diffuse_below: As diffuse, for light from below; None is a sample that is alike from both sides.
        specular: Whether specular reflection stays in the sphere. False lets it out through the entrance port.
        saved: Table of `read_photons` of the same run, which allows any port.

    Returns:
        An xarray.Dataset of M_R and M_T, the light that is lost beyond the port (R_lost, T_lost), and their standard errors (M_R_se ...).

    Raises:
        InputError: An argument is refused, or the port's edge lies within a bin of r.
    """
    import xarray as xr
    if not isinstance(result, xr.Dataset) or result["Rd"].ndim:
        raise errors.refuse("result", result, "a Dataset of one run")
    instrument = Instrument(port, radius, wall, ports, standard, specular)
    found: dict[str, tuple[float, str]] = {}
    for name, (argument, reflectance) in {"M_R": ("diffuse", diffuse), "M_T": ("diffuse_below", diffuse if diffuse_below is None else diffuse_below)}.items():
        light, error = _light(result, name, instrument, saved)
        own = name if argument == "diffuse" or diffuse_below is not None else "M_R"
        value, value_se = instrument.reading(name, light, error, *_diffuse(argument, reflectance, own, instrument))
        letter = SIDES[name][0]
        whole = float(result["Rd"]) + (float(result["Rsp"]) if instrument.specular else 0.0) if letter == "R" else float(result["Tt"])
        lost = max(whole - light, 0.0)
        found[name], found[name + "_se"] = (value, "reflectance" if letter == "R" else "transmittance"), (value_se, "standard error")
        found[letter + "_lost"] = (lost, "light that leaves beyond the port")
        found[letter + "_lost_se"] = (float(np.sqrt(lost * (1 - lost) / float(result.attrs["photons"]))), "standard error, at most")
    return xr.Dataset({name: xr.DataArray(number, attrs={"units": "1", "long_name": text}) for name, (number, text) in found.items()})


# ---- flights of a fit ----

@dataclass(frozen=True)
class SphereScene:
    """A scene with detectors of the port's size, and the same sample in diffuse light from each sphere. texts: of the scene, under "", and in the
    light of each sphere, by name."""

    instrument: Instrument
    texts: dict[str, Text]
    measured: Sequence[str]

    def rows(self, fly: Callable[..., list[dict[str, Any]]], words: Sequence[str], table: str, options: Mapping[str, Any], names: Sequence[str]) -> list[dict[str, Any]]:
        """Flies all scenes, and returns the rows of the first with M_R and M_T, their errors, and their derivatives where they are known."""
        own = [f"detector_sphere_{SIDES[name][0]}{kind}{end}" for name in self.measured for kind in ("", "_dmua", "_dmus") for end in ("", "_se")]

        def of(light: str) -> list[dict[str, Any]]:
            fixed = {key: value for key, value in (options.get("set") or {}).items() if not (light and key.startswith("beam"))}
            return fly(self.texts[light], words, table, {**options, "set": fixed}, [*names, *own])
        flown = {light: of(light) for light in self.texts}
        for i, row in enumerate(flown[""]):
            for name in self.measured:
                seen = "detector_sphere_" + SIDES[name][0]
                other = flown[name][i] if name in flown else {seen: 0.0, seen + "_se": 0.0}
                row[name], row[name + "_se"] = self.instrument.reading(name, row[seen], row[seen + "_se"], other[seen], other[seen + "_se"])
                for kind in (kind for kind in ("_dmua", "_dmus") if seen + kind in row):
                    row[name + kind], row[name + kind + "_se"] = (
                        self.instrument.slope(name, row[seen], row[seen + kind + end], other[seen], other.get(seen + kind + end, 0.0)) for end in ("", "_se"))
        return flown[""]


def sphere_scene(scene: Union[Scene, Path], measured: Sequence[str], sphere: Any) -> SphereScene:
    """Returns the scenes that a fit of M_R and M_T flies. sphere: arguments of `sphere` that describe the instrument."""
    known = ("port", "radius", "wall", "ports", "standard", "specular")
    if not isinstance(sphere, Mapping) or "port" not in sphere or set(sphere) - set(known):
        raise errors.refuse("sphere", sphere, f"a dict with port, and of {' '.join(known[1:])} those that differ from mc.sphere's, for M_R and M_T")
    instrument = Instrument(**sphere)
    bottom = told_of(scene)["boundaries"][-1]["z"]
    with as_file(scene) as (path, _):
        eyes = {name: f"detector disk {instrument.port!r} side={SIDES[name][1]} name=sphere_{SIDES[name][0]}" for name in measured}
        direct = [line + (" diffuse" if name == "M_R" and not instrument.specular else "") for name, line in eyes.items()]
        texts = {"": relit_text(path, [*map(" ".join, light_lines(path, "beam", "detector")), *direct])}
        if instrument.wall is not None:
            turned = {"M_R": "", "M_T": f" z={bottom + GAP * instrument.port!r} angle=180"}
            texts.update({name: relit_text(path, [f"beam disk {instrument.port!r}{turned[name]} light=lambertian", *eyes.values()]) for name in measured})
    return SphereScene(instrument, texts, list(measured))
