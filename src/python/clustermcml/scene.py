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
from .bodies import Body, Cylinder, Sphere, check_medium
from .detectors import Detector
from .options import Path
from .photons import Saved
from .phases import Phase
from .surfaces import ROUGH, SURFACE, Rough, Surface, shortest, vector
from .top import NUMBERS, Face, Port, Top, check_name, check_reflector, check_shape, place_words, reflector_numbers

MOST_PHOTONS = 2**48
TAKEN = re.compile(r"photons|seed|above|below|backing|(layer|body|boundary|beam|detector|face|port)\d*")  # other names whose numbers can be set


class Text(str):
    """The text of a scene's file, in which names of files are absolute."""


@dataclass
class Layer:
    """A layer, and the boundary above it.

    Attributes:
        n: Refractive index, 0.01 to 100.
        mua: Absorption coefficient [1/cm].
        mus: Scattering coefficient [1/cm].
        g: Mean cosine of scattering, -1 to 1.
        d: Nominal thickness [cm].
        top: Shape of the upper boundary; None is a plane.
        bodies: What lies inside the layer: a list of Sphere, Cylinder and Body; default ().
        phase: How the layer scatters; None is the function of Henyey and Greenstein with this g.
        name: Name for `set`, `sweep` and `fit`: `gel.mua` in place of `layer1.mua`.
        top_rough: Roughness of the upper boundary below the resolution of its shape; None is smooth.

    Examples:
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
        errors.optional("Layer.top_rough", self.top_rough, *ROUGH)
        if self.name is not None and not (isinstance(self.name, str) and re.fullmatch("[A-Za-z_][A-Za-z0-9_]{0,23}", self.name)):
            raise errors.refuse("Layer.name", self.name, "1 to 24 letters, digits and underscores, the first of them no digit")
        if self.name is not None and TAKEN.fullmatch(self.name):
            raise errors.refuse("Layer.name", self.name, "a name that no other part of a scene has")
        if not isinstance(self.bodies, (list, tuple)) or not all(isinstance(item, (Sphere, Cylinder, Body)) for item in self.bodies):
            raise errors.refuse("Layer.bodies", self.bodies, "a list of Sphere, Cylinder and Body")
        check_medium(self)
        errors.at_least_zero("Layer.d", self.d)
        errors.optional("Layer.top", self.top, *SURFACE)


SHAPES = {"pencil": (), "disk": ("radius",), "gaussian": ("radius",), "ring": ("r1", "r2"), "rectangle": ("width", "height"), "image": (), "port": ()}
LIGHTS = ("parallel", "lambertian", "isotropic")  # besides na:N, and files
LIGHT_EXPECTED = ", ".join(LIGHTS) + ", na:N or the path of a file that is there"


@dataclass
class Beam:
    """A light source: its shape, its place, and the directions of its light.

    Attributes:
        kind: Shape: "pencil", "disk", "gaussian", "ring", "rectangle", "image" or "port" (evenly over a Port); default "pencil".
        radius: Radius of a disk, or 1/e2 radius of a Gaussian beam [cm].
        at: x and y of the point where the axis meets z = 0 [cm]; default (0, 0).
        angle: Angle between the axis and z [degrees]: below 90, or up to 180 with `z`; default 0.
        azimuth: Direction of the tilt, from x towards y [degrees]; default 0.
        z: Depth where the light starts [cm]; None starts above all surfaces.
        light: Directions about the axis: "parallel", "lambertian", "isotropic", "na:0.22", or the path of a table of angles [degrees] and
            intensities; default "parallel".
        share: Share of the light among several beams, in any unit; default 1.
        r1: Inner radius of a ring [cm].
        r2: Outer radius of a ring [cm].
        width: Width of a rectangle over x [cm].
        height: Width of a rectangle over y [cm].
        file: Path of a `.gsf` image; its pixels are brightnesses.
        radial: Whether r in the results counts from `at`; of a single beam; default False.
        tile: Whether a rectangle covers one period of the scene's tiles, at any angle; default False.
        port: Name of the Port in which the light of a "port" starts.

    Examples:
        >>> Beam("disk", 0.5, angle=60).line()
        'beam disk 0.5 angle=60'
        >>> Beam("ring", r1=0.1, r2=0.2, z=0.05, light="isotropic").line()
        'beam ring 0.1 0.2 z=0.05 light=isotropic'
        >>> Beam("rectangle", tile=True, angle=45).line()
        'beam rectangle tile angle=45'
        >>> Beam("port", port="in", light="na:0.22").line()
        'beam port in light=na:0.22'
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
    port: Optional[str] = None

    def __post_init__(self) -> None:
        errors.choice("Beam.kind", self.kind, *SHAPES)
        errors.flag("Beam.tile", self.tile)
        if self.tile and self.kind != "rectangle":
            raise errors.refuse("Beam.tile", self.tile, f"False for a {self.kind} beam")
        check_shape(self, self._numbers(), NUMBERS, f"a {self.kind} beam" + " of a tile" * self.tile)
        if (self.kind == "image") != (self.file is not None):
            raise errors.refuse("Beam.file", self.file, "the path of a .gsf file for an image, else None")
        if self.file is not None:
            errors.existing_file("Beam.file", self.file)
        vector("Beam.at", self.at, 2)
        self._check_port()
        if self.z is not None:
            errors.finite("Beam.z", self.z)
        angle = errors.finite("Beam.angle", self.angle)
        if not 0 <= angle <= 180 or (self.z is None and angle >= 90):
            raise errors.refuse("Beam.angle", self.angle, "degrees, 0 <= angle < 90" if self.z is None else "degrees, 0 <= angle <= 180")
        errors.finite("Beam.azimuth", self.azimuth)
        self._light_word()
        errors.above_zero("Beam.share", self.share)
        errors.flag("Beam.radial", self.radial)

    def _check_port(self) -> None:
        if self.kind != "port":
            if self.port is not None:
                raise errors.refuse("Beam.port", self.port, f"None for a {self.kind} beam")
            return
        check_name("Beam.port", self.port)
        if tuple(self.at) != (0.0, 0.0) or self.z is not None:
            raise errors.refuse("Beam.at" if self.z is None else "Beam.z", self.at if self.z is None else self.z, "the default for a port, which has its place")

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
        words = ["beam", self.kind, *([] if self.port is None else [self.port])] + ["tile"] * self.tile + [shortest(getattr(self, name)) for name in self._numbers()]
        words += [errors.quoted_file("Beam.file", self.file)] if self.file is not None else []
        words += place_words(self)
        words += [] if self.z is None else [f"z={shortest(self.z)}"]
        words += [f"{name}={shortest(getattr(self, name))}" for name in ("angle", "azimuth") if getattr(self, name) != 0]
        words += [] if self.light == "parallel" else ["light=" + self._light_word()]
        words += [] if self.share == 1 else [f"share={shortest(self.share)}"]
        return " ".join(words + (["radial=beam"] if self.radial else []))


@dataclass
class Map:
    """A map of the light that leaves, over x and y, centred on the origin.

    Attributes:
        nx: Number of pixels along x.
        ny: Number of pixels along y.
        dx: Width of a pixel along x [cm].
        dy: Width of a pixel along y [cm].
        angles: Whether every pixel has bins of the angle, too; default False.
        volume: Whether absorption is tallied in nx by ny by nz voxels; default False.
        top: Depth of the first voxels [cm]; default 0.

    Examples:
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
        """Returns the line of the .mci file."""
        words = ["map", str(int(self.nx)), str(int(self.ny)), shortest(self.dx), shortest(self.dy)]
        words += [name for name in ("angles", "volume") if getattr(self, name)]
        return " ".join(words + ([f"top={shortest(self.top)}"] if self.top else []))


@dataclass
class Time:
    """Gates of time, equally long, for light that leaves or is absorbed.

    Attributes:
        end: End of the last gate [ps]; the first begins at 0.
        n: Number of gates.
        radii: Whether each gate has the scene's bins of r, too; default False.

    Examples:
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
        """Returns the line of the .mci file."""
        return f"time {shortest(self.end)} {int(self.n)}" + " radii" * self.radii


@dataclass
class Directions:
    """Bins of direction for light that leaves.

    Attributes:
        nt: Number of bins of the angle from the outward vertical.
        np: Number of bins of the azimuth.

    Examples:
        >>> Directions(nt=18, np=36).line()
        'directions 18 36'
    """

    nt: int
    np: int

    def __post_init__(self) -> None:
        errors.whole("Directions.nt", self.nt, 1, 3600)
        errors.whole("Directions.np", self.np, 1, 3600)

    def line(self) -> str:
        """Returns the line of the .mci file."""
        return f"directions {int(self.nt)} {int(self.np)}"


@dataclass
class Backing:
    """A reflector under the last layer. The index below the layers then has no effect.

    Attributes:
        kind: "mirror" or "lambertian", which send back the share R, or "metal", which reflects by Fresnel's formula; default "mirror".
        R: Reflectance of a mirror or a Lambertian backing, 0 to 1.
        n: Real part of the index of a metal.
        k: Imaginary part of the index of a metal.

    Examples:
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
        check_reflector(self, "kind")

    def line(self) -> str:
        """Returns the line of the .mci file."""
        numbers = reflector_numbers(self)
        return " ".join(["backing", "metal", *numbers] if self.kind == "metal" else ["backing", *numbers, self.kind])


@dataclass
class Scene:
    """Layers from above to below, the light, and what is recorded.

    Attributes:
        layers: List of Layer, at least one.
        n_above: Refractive index above the layers; default 1.
        n_below: Refractive index below the layers; default 1.
        bottom: Shape of the boundary below the last layer; None is a plane.
        photons: Number of photons; `run(photons=...)` overrides it; default 1e5.
        dr: Width of the bins of r [cm]; default 0.01.
        dz: Width of the bins of z [cm]; default 0.01.
        nr: Number of bins of r; default 100.
        nz: Number of bins of z; default 100.
        na: Number of bins of the exit angle, from 0 to 90 degrees; default 30.
        beam: Beam, or list of Beam; default a pencil beam at the origin.
        map: Map of the light that leaves.
        facets: Whether irradiance and exitance of every facet are recorded; default False.
        time: Gates of time.
        directions: Bins of direction.
        format: "B" leaves an `.h5` with all digits, "A" an `.mco` with the five digits of original MCML; default "B".
        backing: Reflector under the last layer.
        detectors: List of Detector; default ().
        fluence: True records fluence over r and z, and in the voxels of a map; "time" also over the gates of `time`; default False.
        saved: Saves packets one by one into a file.
        bottom_rough: Roughness of the boundary below the last layer.
        top: List of Face and Port that touch boundary 0; later ones lie on top. Default ().

    Examples:
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
    top: Sequence[Top] = ()

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
        several = isinstance(self.beam, (list, tuple)) and bool(self.beam) and all(isinstance(beam, Beam) for beam in self.beam)
        if not isinstance(self.beam, Beam) and not several:
            raise errors.refuse("Scene.beam", self.beam, "a Beam, or a list of Beam")
        for name, kinds, expected in (("bottom", *SURFACE), ("bottom_rough", *ROUGH), ("backing", Backing, "a Backing or None"), ("map", Map, "a Map"),
                                      ("time", Time, "a Time"), ("directions", Directions, "Directions"), ("saved", Saved, "a Saved or None")):
            errors.optional("Scene." + name, getattr(self, name), kinds, expected)
        if not isinstance(self.detectors, (list, tuple)) or not all(isinstance(detector, Detector) for detector in self.detectors):
            raise errors.refuse("Scene.detectors", self.detectors, "a list of Detector")
        if not isinstance(self.top, (list, tuple)) or not all(isinstance(item, (Face, Port)) for item in self.top):
            raise errors.refuse("Scene.top", self.top, "a list of Face and Port")

    def beams(self) -> Sequence[Beam]:
        """All beams, one or several."""
        return [self.beam] if isinstance(self.beam, Beam) else self.beam

    def text(self, output: str, directory: Path = ".") -> str:
        """Returns the text of the `.mci` file, and writes surfaces that are arrays into a folder.

        Args:
            output: Name of the result.
            directory: Folder for the surfaces.
        """
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
        lines += [str(len(self.layers)), shortest(self.n_above), *(item.line() for item in self.top)]
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
        """Writes the scene as an `.mci` file, and beside it the surfaces that are arrays.

        The result will have the same name with `.mco`, or `.h5` with format "B".

        Args:
            path: Path of the `.mci` file.
            comment: Lines before all others, each with # before it and a line feed behind it.
        """
        path = os.fspath(path)
        if "\0" in path:
            raise errors.refuse("path", path, "a name without NUL characters")
        name = os.path.splitext(os.path.basename(path))[0]
        text = self.text(name + ".mco", os.path.dirname(os.path.abspath(path)))
        with open(path, "w", encoding="utf-8") as file:
            file.write(comment + text)
