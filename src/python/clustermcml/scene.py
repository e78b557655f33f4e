"""Scenes as Python objects, which write the `.mci` files that the program reads.

Lengths are in cm, coefficients in 1/cm, angles in degrees, as in the files; z points down, heights of surfaces up.
Nothing is computed here: the program reads, checks and flies what is written.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field
from typing import Optional, Sequence, Union

from . import errors
from .bodies import Body, Cylinder, Sphere
from .detectors import Detector
from .photons import Saved
from .phases import Phase, check_phase
from .surfaces import Rough, Surface, check_rough, check_surface, shortest, vector

MOST_PHOTONS = 2**48
TAKEN = re.compile(r"photons|seed|above|below|backing|(layer|body|boundary|beam|detector)\d*")  # other names whose numbers can be set


@dataclass
class Layer:
    """A layer and the boundary above it.

    n: index of refraction. mua, mus: absorption and scattering [1/cm]. g: mean cosine of scattering. d: thickness [cm].
    top: the surface that is its upper boundary, None for a plane. bodies: what lies inside: Sphere, Cylinder, Body.
    phase: how it scatters, None for Henyey and Greenstein's function of that g. name: another one than layer1, layer2 ... in what is set
    and swept: `gel.mua`. top_rough: how rough that boundary is below the resolution of its shape.

    >>> Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1, name="gel")
    Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1, top=None, bodies=(), phase=None, name='gel', top_rough=None)
    """

    n: float
    mua: float
    mus: float
    g: float
    d: float
    top: Optional[Surface] = None
    bodies: Sequence[Union[Sphere, Cylinder, Body]] = ()
    phase: Optional[Phase] = None
    name: Optional[str] = None
    top_rough: Optional[Rough] = None

    def __post_init__(self) -> None:
        check_rough("Layer.top_rough", self.top_rough)
        if self.name is not None and not (isinstance(self.name, str) and re.fullmatch("[A-Za-z_][A-Za-z0-9_]{0,23}", self.name)):
            raise errors.refuse("Layer.name", self.name, "1 to 24 letters, digits and underscores, the first of them no digit")
        if self.name is not None and TAKEN.fullmatch(self.name):
            raise errors.refuse("Layer.name", self.name, "a name that no other part of a scene has")
        if not isinstance(self.bodies, (list, tuple)) or not all(isinstance(item, (Sphere, Cylinder, Body)) for item in self.bodies):
            raise errors.refuse("Layer.bodies", self.bodies, "a list of Sphere, Cylinder and Body")
        errors.number("Layer.n", self.n, 0.01, 100, "a number from 0.01 to 100")
        errors.at_least_zero("Layer.mua", self.mua)
        errors.at_least_zero("Layer.mus", self.mus)
        errors.number("Layer.g", self.g, -1, 1, "a number from -1 to 1")
        errors.at_least_zero("Layer.d", self.d)
        check_surface("Layer.top", self.top)
        check_phase("Layer.phase", self.phase)


SHAPES = {"pencil": (), "disk": ("radius",), "gaussian": ("radius",), "ring": ("r1", "r2"), "rectangle": ("width", "height"), "image": ()}
LIGHTS = ("parallel", "lambertian", "isotropic")  # besides na:N, and files
LIGHT_EXPECTED = ", ".join(LIGHTS) + ", na:N or the path of a file that is there"


@dataclass
class Beam:
    """How light arrives. kind: "pencil", "disk" (of `radius` cm), "gaussian" (1/e2 radius), "ring" (between `r1` and `r2`), "rectangle"
    (`width` by `height`, or with tile=True as large as one period of the scene's tiles is at its angle) or "image" (of a .gsf `file`).
    at: x, y [cm] where the axis meets z = 0. z: None, light starts above all surfaces; or the depth [cm] where it starts. angle: degrees
    between the axis and z; azimuth: degrees from x towards y. light: "parallel", "lambertian", "isotropic", "na:0.22", or the path of a
    table of angles and intensities. share: of the light of several beams. radial: r in results counts from `at`.

    >>> Beam("disk", 0.5, angle=60).line()
    'beam disk 0.5 angle=60'
    >>> Beam("ring", r1=0.1, r2=0.2, z=0.05, light="isotropic").line()
    'beam ring 0.1 0.2 z=0.05 light=isotropic'
    >>> Beam("rectangle", tile=True, angle=45).line()
    'beam rectangle tile angle=45'
    """

    kind: str = "pencil"
    radius: Optional[float] = None
    at: Sequence[float] = (0.0, 0.0)
    angle: float = 0.0
    azimuth: float = 0.0
    z: Optional[float] = None
    light: Union[str, os.PathLike[str]] = "parallel"
    share: float = 1.0
    r1: Optional[float] = None
    r2: Optional[float] = None
    width: Optional[float] = None
    height: Optional[float] = None
    file: Optional[Union[str, os.PathLike[str]]] = None
    radial: bool = False
    tile: bool = False

    def __post_init__(self) -> None:
        errors.choice("Beam.kind", self.kind, *SHAPES)
        errors.flag("Beam.tile", self.tile)
        if self.tile and self.kind != "rectangle":
            raise errors.refuse("Beam.tile", self.tile, f"False for a {self.kind} beam")
        for name in ("radius", "r1", "r2", "width", "height"):
            value = getattr(self, name)
            if name not in self._numbers() and value is not None:
                raise errors.refuse("Beam." + name, value, f"None for a {self.kind} beam" + (" of a tile" if self.tile else ""))
            if name in self._numbers():
                (errors.at_least_zero if name == "r1" else errors.above_zero)("Beam." + name, value)
        if (self.kind == "image") != (self.file is not None):
            raise errors.refuse("Beam.file", self.file, "the path of a .gsf file for an image, else None")
        if self.file is not None:
            errors.existing_file("Beam.file", self.file)
        vector("Beam.at", self.at, 2)
        if self.z is not None:
            errors.finite("Beam.z", self.z)
        angle = errors.finite("Beam.angle", self.angle)
        if not 0 <= angle <= 180 or (self.z is None and angle >= 90):
            raise errors.refuse("Beam.angle", self.angle, "degrees, 0 <= angle < 90" if self.z is None else "degrees, 0 <= angle <= 180")
        errors.finite("Beam.azimuth", self.azimuth)
        self._light_word()
        errors.above_zero("Beam.share", self.share)
        errors.flag("Beam.radial", self.radial)

    def _numbers(self) -> Sequence[str]:
        """Returns the names of the numbers that follow the kind."""
        return () if self.tile else SHAPES[self.kind]

    def _light_word(self) -> str:
        """Returns the value of `light` as a word of the line. A file becomes its absolute path."""
        if isinstance(self.light, str) and (self.light in LIGHTS or re.fullmatch(r"na:\S+", self.light)):
            return self.light
        return errors.quoted_file("Beam.light", self.light, LIGHT_EXPECTED)

    def line(self) -> str:
        """The line of the `.mci`; files by absolute paths."""
        words = ["beam", self.kind] + ["tile"] * self.tile + [shortest(getattr(self, name)) for name in self._numbers()]
        words += [errors.quoted_file("Beam.file", self.file)] if self.file is not None else []
        if tuple(self.at) != (0.0, 0.0):
            words.append("at=" + ",".join(shortest(value) for value in self.at))
        words += [] if self.z is None else [f"z={shortest(self.z)}"]
        words += [f"{name}={shortest(getattr(self, name))}" for name in ("angle", "azimuth") if getattr(self, name) != 0]
        words += [] if self.light == "parallel" else ["light=" + self._light_word()]
        words += [] if self.share == 1 else [f"share={shortest(self.share)}"]
        return " ".join(words + (["radial=beam"] if self.radial else []))


@dataclass
class Map:
    """Maps over x and y: nx by ny pixels of dx by dy cm, centred on the origin. angles: every pixel by angle, too. volume: absorption
    in nx by ny by nz voxels, in layers of dz from the depth `top` [cm] down.

    >>> Map(81, 61, 0.012, 0.012, volume=True, top=-0.02).line()
    'map 81 61 0.012 0.012 volume top=-0.02'
    """

    nx: int
    ny: int
    dx: float
    dy: float
    angles: bool = False
    volume: bool = False
    top: float = 0.0

    def __post_init__(self) -> None:
        for name in ("nx", "ny"):
            errors.whole("Map." + name, getattr(self, name), 1, 2**31 - 1)
        for name in ("dx", "dy"):
            errors.above_zero("Map." + name, getattr(self, name))
        for name in ("angles", "volume"):
            errors.flag("Map." + name, getattr(self, name))
        if errors.finite("Map.top", self.top) != 0 and not self.volume:
            raise errors.refuse("Map.top", self.top, "0 without volume=True")

    def line(self) -> str:
        words = ["map", str(int(self.nx)), str(int(self.ny)), shortest(self.dx), shortest(self.dy)]
        words += [name for name in ("angles", "volume") if getattr(self, name)]
        return " ".join(words + ([f"top={shortest(self.top)}"] if self.top else []))


@dataclass
class Time:
    """Gates of time: n of them from 0 to end [ps], all as long. What comes later is counted as such.
    radii: each gate also has the scene's radial bins.

    >>> Time(end=2000, n=200).line()
    'time 2000 200'
    """

    end: float
    n: int
    radii: bool = False

    def __post_init__(self) -> None:
        errors.above_zero("Time.end", self.end)
        errors.whole("Time.n", self.n, 1, 100_000)
        errors.flag("Time.radii", self.radii)

    def line(self) -> str:
        return f"time {shortest(self.end)} {int(self.n)}" + " radii" * self.radii


@dataclass
class Directions:
    """Where to what leaves goes: nt even bins of the angle from the outward vertical, np of the azimuth.

    >>> Directions(nt=18, np=36).line()
    'directions 18 36'
    """

    nt: int
    np: int

    def __post_init__(self) -> None:
        errors.whole("Directions.nt", self.nt, 1, 3600)
        errors.whole("Directions.np", self.np, 1, 3600)

    def line(self) -> str:
        return f"directions {int(self.nt)} {int(self.np)}"


@dataclass
class Backing:
    """What lies under the last layer and sends light back. kind: "mirror" or "lambertian", which send back the share R of it, or
    "metal", of index n + i k, by Fresnel's formula.

    >>> Backing("lambertian", R=0.9).line()
    'backing 0.9 lambertian'
    >>> Backing("metal", n=0.18, k=3.43).line()
    'backing metal 0.18 3.43'
    """

    kind: str = "mirror"
    R: Optional[float] = None
    n: Optional[float] = None
    k: Optional[float] = None

    def __post_init__(self) -> None:
        errors.choice("Backing.kind", self.kind, "mirror", "lambertian", "metal")
        metal = self.kind == "metal"
        for name, used, most in (("R", not metal, 1), ("n", metal, 100), ("k", metal, 100)):
            value = getattr(self, name)
            if used:
                errors.number("Backing." + name, value, 0, most, f"a number from 0 to {most}")
            elif value is not None:
                raise errors.refuse("Backing." + name, value, f"None for {self.kind}")

    def line(self) -> str:
        numbers = " ".join(shortest(value) for value in (self.R, self.n, self.k) if value is not None)
        return f"backing metal {numbers}" if self.kind == "metal" else f"backing {numbers} {self.kind}"


@dataclass
class Scene:
    """Layers from above to below, what lies beyond them, light, and what is recorded.

    n_above, n_below: indices of refraction beyond the layers. bottom: the surface below the last layer, None for a plane; bottom_rough: how rough it is; backing: what
    lies under it and sends light back, n_below then has no effect.
    beam: a Beam, or a list of them. dr, dz: widths of the bins of r and z [cm]; nr, nz, na: their numbers, and that of the angle. facets: irradiance and
    exitance of every triangle. fluence: track length per volume over r and z, and with a map's volume over its voxels; "time": by the gates of `time`, too. time: when light leaves or is absorbed. directions: where to it leaves. detectors: what sees it by place and
    angle. saved: packets one by one, in a file. format: "B" leaves an `.h5`, with all digits; "A" an `.mco`, with the five of original MCML.

    >>> slab = Scene([Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1)], photons=1000)
    >>> print(slab.text("slab.mco"))
    1.0
    1
    slab.mco B
    1000
    0.01 0.01
    100 100 30
    1
    1
    1.4 1 100 0.9 0.1
    1
    <BLANKLINE>
    """

    layers: Sequence[Layer]
    n_above: float = 1.0
    n_below: float = 1.0
    bottom: Optional[Surface] = None
    photons: int = 100_000
    dr: float = 0.01
    dz: float = 0.01
    nr: int = 100
    nz: int = 100
    na: int = 30
    beam: Union[Beam, Sequence[Beam]] = field(default_factory=Beam)
    map: Optional[Map] = None
    facets: bool = False
    time: Optional[Time] = None
    directions: Optional[Directions] = None
    format: str = "B"
    backing: Optional[Backing] = None
    detectors: Sequence[Detector] = ()
    fluence: Union[bool, str] = False
    saved: Optional[Saved] = None
    bottom_rough: Optional[Rough] = None

    def __post_init__(self) -> None:
        errors.choice("Scene.format", self.format, "A", "B")
        errors.flag("Scene.facets", self.facets)
        if isinstance(self.fluence, str):
            errors.choice("Scene.fluence", self.fluence, "time")
        else:
            errors.flag("Scene.fluence", self.fluence)
        if not isinstance(self.layers, (list, tuple)) or not self.layers or not all(isinstance(item, Layer) for item in self.layers):
            raise errors.refuse("Scene.layers", self.layers, "a list of Layer, at least one")
        names = [layer.name for layer in self.layers if layer.name]
        if len(set(names)) < len(names):
            raise errors.refuse("Scene.layers", names, "layers whose names differ")
        for name in ("n_above", "n_below"):
            errors.number("Scene." + name, getattr(self, name), 0.01, 100, "a number from 0.01 to 100")
        errors.whole("Scene.photons", self.photons, 1, MOST_PHOTONS)
        for name in ("dr", "dz"):
            errors.above_zero("Scene." + name, getattr(self, name))
        for name in ("nr", "nz", "na"):
            errors.whole("Scene." + name, getattr(self, name), 1, 2**31 - 1)
        check_surface("Scene.bottom", self.bottom)
        check_rough("Scene.bottom_rough", self.bottom_rough)
        several = isinstance(self.beam, (list, tuple)) and bool(self.beam) and all(isinstance(beam, Beam) for beam in self.beam)
        if not isinstance(self.beam, Beam) and not several:
            raise errors.refuse("Scene.beam", self.beam, "a Beam, or a list of Beam")
        if not isinstance(self.backing, Backing) and self.backing is not None:
            raise errors.refuse("Scene.backing", self.backing, "a Backing or None")
        if not isinstance(self.map, Map) and self.map is not None:
            raise errors.refuse("Scene.map", self.map, "a Map")
        if not isinstance(self.time, Time) and self.time is not None:
            raise errors.refuse("Scene.time", self.time, "a Time")
        if not isinstance(self.directions, Directions) and self.directions is not None:
            raise errors.refuse("Scene.directions", self.directions, "Directions")
        if not isinstance(self.saved, Saved) and self.saved is not None:
            raise errors.refuse("Scene.saved", self.saved, "a Saved or None")
        if not isinstance(self.detectors, (list, tuple)) or not all(isinstance(detector, Detector) for detector in self.detectors):
            raise errors.refuse("Scene.detectors", self.detectors, "a list of Detector")

    def beams(self) -> Sequence[Beam]:
        """All beams, one or several."""
        return [self.beam] if isinstance(self.beam, Beam) else self.beam

    def text(self, output: str, directory: str = ".") -> str:
        """The text of the `.mci` whose result is OUTPUT; surfaces that are arrays are written to DIRECTORY."""
        stem = os.path.splitext(output)[0]
        quoted = f'"{output}"' if re.search(r"\s", output) else output
        lines = ["1.0", "1", f"{quoted} {self.format}", str(int(self.photons)), f"{shortest(self.dz)} {shortest(self.dr)}",
                 f"{int(self.nz)} {int(self.nr)} {int(self.na)}"]
        lines += [beam.line() for beam in self.beams() if len(self.beams()) > 1 or beam.line() != Beam().line()]
        lines += [self.map.line()] if self.map is not None else []
        lines += ["facets"] if self.facets else []
        lines += ["fluence time" if isinstance(self.fluence, str) else "fluence"] if self.fluence else []
        lines += [self.time.line()] if self.time is not None else []
        lines += [self.directions.line()] if self.directions is not None else []
        lines += [detector.line() for detector in self.detectors]
        lines += [self.saved.line()] if self.saved else []
        lines += [str(len(self.layers)), shortest(self.n_above)]
        for index, surface in enumerate([*(layer.top for layer in self.layers), self.bottom]):
            lines += [surface.line(directory, f"{stem}.surface{index}")] if surface else []
            rough = self.layers[index].top_rough if index < len(self.layers) else self.bottom_rough
            lines += [f"rough {rough.words()}"] if rough else []
            if index < len(self.layers):
                layer = self.layers[index]
                lines.append(" ".join([*map(shortest, (layer.n, layer.mua, layer.mus, layer.g, layer.d)), *([f"name={layer.name}"] if layer.name else [])]))
                lines += [layer.phase.line(directory, f"{stem}.layer{index + 1}")] if layer.phase else []
                for k, body in enumerate(layer.bodies):
                    name = f"{stem}.layer{index + 1}body{k}"
                    lines.append(body.line(directory, name))
                    lines += [body.phase.line(directory, name)] if body.phase else []
        lines += [self.backing.line()] if self.backing else []
        return "\n".join([*lines, shortest(self.n_below), ""])

    def write(self, path: Union[str, os.PathLike[str]], comment: str = "") -> None:
        """Writes the `.mci` PATH, and beside it the surfaces that are arrays. The result will have the same name with `.mco`.
        comment: lines before all others, each with # before it and a line feed behind."""
        path = os.fspath(path)
        if "\0" in path:
            raise errors.refuse("path", path, "a name without NUL characters")
        name = os.path.splitext(os.path.basename(path))[0]
        text = self.text(name + ".mco", os.path.dirname(os.path.abspath(path)))
        with open(path, "w", encoding="utf-8") as file:
            file.write(comment + text)
