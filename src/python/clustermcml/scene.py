"""Scenes as Python objects, which write the `.mci` files that the program reads.

Lengths are in cm, coefficients in 1/cm, angles in degrees, as in the files; z points down, heights of surfaces up.
Nothing is computed here: the program reads, checks and flies what is written.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any, Optional, Sequence, Union

import numpy as np

from . import errors
from .surface_files import write_gsf, write_obj

MOST_PHOTONS = 2**48


def _shortest(value: float) -> str:
    """A number as the file has it: as few digits as give the same number again."""
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))


def _vector(name: str, value: Any, length: int) -> tuple[float, ...]:
    expected = f"{length} numbers"
    try:
        values = tuple(value)
    except TypeError:
        raise errors.refuse(name, value, expected) from None
    if len(values) != length:
        raise errors.refuse(name, value, expected)
    return tuple(errors.finite(name, item) for item in values)


@dataclass
class Heightfield:
    """A surface of revolution about the z axis.

    r: radii of the samples [cm], from 0, rising. h: heights above the boundary's depth [cm], linear between samples and
    constant beyond the last one.

    >>> Heightfield(r=[0, 0.1], h=[0.02, 0])
    Heightfield(r=[0, 0.1], h=[0.02, 0])
    """

    r: Sequence[float]
    h: Sequence[float]

    def __post_init__(self) -> None:
        r, h = (np.asarray(values, dtype=float) for values in (self.r, self.h))
        if r.ndim != 1 or r.size < 1 or not np.all(np.isfinite(r)) or r[0] != 0 or np.any(np.diff(r) <= 0):
            raise errors.refuse("Heightfield.r", self.r, "radii that begin with 0 and rise")
        if h.shape != r.shape or not np.all(np.isfinite(h)):
            raise errors.refuse("Heightfield.h", self.h, f"{r.size} finite heights, one for each radius")

    def line(self, directory: str, stem: str) -> str:
        """The line of the `.mci`; writes no file."""
        r, h = np.asarray(self.r, dtype=float), np.asarray(self.h, dtype=float)
        spacing = np.append(np.diff(r), 0.0)
        samples = "  ".join(f"{_shortest(height)} {_shortest(step)}" for height, step in zip(h, spacing))
        return f"b {r.size}  {samples}"


@dataclass
class Heightmap:
    """A surface given by a height for every point of a grid.

    heights: array [ny, nx] in cm above the boundary's depth; y rises with the first index, x with the second. dx, dy: distance of grid points
    in x and y [cm], dy None: as dx. shift: x, y and up [cm] of the map's middle. The file keeps heights in single precision.

    >>> Heightmap(np.zeros((2, 3)), dx=0.01).dy is None
    True
    """

    heights: Any
    dx: float
    dy: Optional[float] = None
    shift: Sequence[float] = (0.0, 0.0, 0.0)
    scale: float = 1.0

    def __post_init__(self) -> None:
        heights = np.asarray(self.heights)
        if heights.ndim != 2 or min(heights.shape) < 2 or heights.dtype.kind not in "iuf":
            raise errors.refuse("Heightmap.heights", self.heights, "an array of heights [ny, nx], at least 2 x 2")
        if not np.all(np.isfinite(heights)):
            raise errors.refuse("Heightmap.heights", self.heights, "finite heights")
        errors.above_zero("Heightmap.dx", self.dx)
        if self.dy is not None:
            errors.above_zero("Heightmap.dy", self.dy)
        errors.above_zero("Heightmap.scale", self.scale)
        _vector("Heightmap.shift", self.shift, 3)

    def line(self, directory: str, stem: str) -> str:
        """Writes DIRECTORY/STEM.gsf; the line of the `.mci` in that directory."""
        write_gsf(os.path.join(directory, stem + ".gsf"), np.asarray(self.heights), self.dx, self.dx if self.dy is None else self.dy)
        return _mesh_line(stem + ".gsf", {"scale": self.scale, "shift": tuple(self.shift)})


def _mesh_line(path: str, options: dict[str, Any]) -> str:
    """The line `m` of a file, with the options that are no defaults."""
    usual = {"up": "z", "rotate": 0.0, "units": "cm", "scale": 1.0, "shift": (0.0, 0.0, 0.0), "normals": "face", "skirt": None}
    words = [f'm "{path}"']
    for key, value in options.items():
        if value == usual[key]:
            continue
        if isinstance(value, tuple):
            words.append(f"{key}={','.join(_shortest(number) for number in value)}")
        else:
            words.append(f"{key}={value if isinstance(value, str) else _shortest(value)}")
    return " ".join(words)


@dataclass
class Mesh:
    """A surface as triangles: a file (`.obj`, `.gsf`, `.asc`), or vertices and faces.

    vertices: array [n, 3]; x, y and up. faces: array [m, 3] of indices into the vertices, from 0. units: of the file's or the
    array's numbers (cm mm um m). up: the axis of the file that points up (z, -z, y, -y, x, -x). rotate: degrees about the vertical.
    scale: factor on all coordinates. shift: cm; x, y and up. normals: "face" or "vertex". skirt: cm, None for none.
    """

    path: Optional[Union[str, os.PathLike[str]]] = None
    vertices: Any = None
    faces: Any = None
    units: str = "cm"
    up: str = "z"
    rotate: float = 0.0
    scale: float = 1.0
    shift: Sequence[float] = (0.0, 0.0, 0.0)
    normals: str = "face"
    skirt: Optional[float] = None

    def __post_init__(self) -> None:
        if (self.path is None) == (self.vertices is None):
            raise errors.refuse("Mesh.path", self.path, "either a path, or vertices and faces")
        if self.path is None:
            self._check_arrays()
        else:
            errors.existing_file("Mesh.path", self.path)
        for name, known in (("units", "cm mm um m"), ("up", "z -z y -y x -x"), ("normals", "face vertex")):
            if getattr(self, name) not in known.split():
                raise errors.refuse("Mesh." + name, getattr(self, name), "one of " + known)
        errors.finite("Mesh.rotate", self.rotate)
        errors.above_zero("Mesh.scale", self.scale)
        _vector("Mesh.shift", self.shift, 3)
        if self.skirt is not None:
            errors.above_zero("Mesh.skirt", self.skirt)

    def _check_arrays(self) -> None:
        vertices, faces = np.asarray(self.vertices), np.asarray(self.faces)
        if vertices.ndim != 2 or vertices.shape[1] != 3 or vertices.dtype.kind not in "iuf" or not np.all(np.isfinite(vertices)):
            raise errors.refuse("Mesh.vertices", self.vertices, "an array [n, 3] of finite numbers")
        if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
            raise errors.refuse("Mesh.faces", self.faces, "an array [m, 3] of whole numbers")
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise errors.refuse("Mesh.faces", self.faces, f"indices from 0 to {len(vertices) - 1}")

    def line(self, directory: str, stem: str) -> str:
        """Writes DIRECTORY/STEM.obj where the mesh is no file; the line of the `.mci` in that directory."""
        path = stem + ".obj"
        if self.path is None:
            write_obj(os.path.join(directory, path), np.asarray(self.vertices), np.asarray(self.faces))
        else:
            path = errors.existing_file("Mesh.path", self.path)
        names = ("up", "rotate", "units", "scale", "shift", "normals", "skirt")
        options = {name: getattr(self, name) for name in names}
        options["shift"] = tuple(self.shift)
        return _mesh_line(path, options)


Surface = Union[Heightfield, Heightmap, Mesh]


def _check_surface(name: str, value: object) -> None:
    if value is not None and not isinstance(value, (Heightfield, Heightmap, Mesh)):
        raise errors.refuse(name, value, "a Heightfield, a Heightmap, a Mesh, or None for a plane")


@dataclass
class Layer:
    """A layer and the boundary above it.

    n: index of refraction. mua, mus: absorption and scattering [1/cm]. g: mean cosine of scattering. d: thickness [cm].
    top: the surface that is its upper boundary, None for a plane.

    >>> Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1)
    Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1, top=None)
    """

    n: float
    mua: float
    mus: float
    g: float
    d: float
    top: Optional[Surface] = None

    def __post_init__(self) -> None:
        errors.number("Layer.n", self.n, 0.01, 100, "a number from 0.01 to 100")
        errors.at_least_zero("Layer.mua", self.mua)
        errors.at_least_zero("Layer.mus", self.mus)
        errors.number("Layer.g", self.g, -1, 1, "a number from -1 to 1")
        errors.above_zero("Layer.d", self.d)
        _check_surface("Layer.top", self.top)


@dataclass
class Beam:
    """How light arrives. kind: "pencil", "disk" (of `radius` cm) or "gaussian" (1/e2 radius). at: x, y [cm] where the axis meets
    z = 0. angle: degrees between the axis and z; azimuth: degrees from x towards y.

    >>> Beam("disk", 0.5, angle=60).line()
    'beam disk 0.5 angle=60'
    """

    kind: str = "pencil"
    radius: Optional[float] = None
    at: Sequence[float] = (0.0, 0.0)
    angle: float = 0.0
    azimuth: float = 0.0

    def __post_init__(self) -> None:
        if self.kind not in ("pencil", "disk", "gaussian"):
            raise errors.refuse("Beam.kind", self.kind, "pencil, disk or gaussian")
        if self.kind == "pencil" and self.radius is not None:
            raise errors.refuse("Beam.radius", self.radius, "None for a pencil beam")
        if self.kind != "pencil":
            errors.above_zero("Beam.radius", self.radius)
        _vector("Beam.at", self.at, 2)
        if not 0 <= errors.finite("Beam.angle", self.angle) < 90:
            raise errors.refuse("Beam.angle", self.angle, "degrees, 0 <= angle < 90")
        errors.finite("Beam.azimuth", self.azimuth)

    def line(self) -> str:
        words = ["beam", self.kind] + ([] if self.radius is None else [_shortest(self.radius)])
        if tuple(self.at) != (0.0, 0.0):
            words.append("at=" + ",".join(_shortest(value) for value in self.at))
        words += [f"{name}={_shortest(getattr(self, name))}" for name in ("angle", "azimuth") if getattr(self, name) != 0]
        return " ".join(words)


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
        if errors.finite("Map.top", self.top) != 0 and not self.volume:
            raise errors.refuse("Map.top", self.top, "0 without volume=True")

    def line(self) -> str:
        words = ["map", str(int(self.nx)), str(int(self.ny)), _shortest(self.dx), _shortest(self.dy)]
        words += ["angles"] * self.angles + ["volume"] * self.volume
        return " ".join(words + ([f"top={_shortest(self.top)}"] if self.top else []))


@dataclass
class Scene:
    """Layers from above to below, what lies beyond them, light, and what is recorded.

    n_above, n_below: indices of refraction beyond the layers. bottom: the surface below the last layer, None for a plane.
    dr, dz: widths of the bins of r and z [cm]; nr, nz, na: their numbers, and that of the angle. facets: irradiance and
    exitance of every triangle. format: "B" leaves an `.h5`, with all digits; "A" an `.mco`, with the five of original MCML.

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
    beam: Beam = field(default_factory=Beam)
    map: Optional[Map] = None
    facets: bool = False
    format: str = "B"

    def __post_init__(self) -> None:
        if self.format not in ("A", "B"):
            raise errors.refuse("Scene.format", self.format, "A or B")
        if isinstance(self.layers, Layer) or not len(self.layers) or not all(isinstance(item, Layer) for item in self.layers):
            raise errors.refuse("Scene.layers", self.layers, "a list of Layer, at least one")
        for name in ("n_above", "n_below"):
            errors.number("Scene." + name, getattr(self, name), 0.01, 100, "a number from 0.01 to 100")
        errors.whole("Scene.photons", self.photons, 1, MOST_PHOTONS)
        for name in ("dr", "dz"):
            errors.above_zero("Scene." + name, getattr(self, name))
        for name in ("nr", "nz", "na"):
            errors.whole("Scene." + name, getattr(self, name), 1, 2**31 - 1)
        _check_surface("Scene.bottom", self.bottom)
        for name, kind in (("beam", Beam), ("map", Map)):
            value = getattr(self, name)
            if not isinstance(value, kind) and not (name == "map" and value is None):
                raise errors.refuse("Scene." + name, value, "a " + kind.__name__)

    def text(self, output: str, directory: str = ".") -> str:
        """The text of the `.mci` whose result is OUTPUT; surfaces that are arrays are written to DIRECTORY."""
        stem = os.path.splitext(output)[0]
        lines = ["1.0", "1", f"{output} {self.format}", str(int(self.photons)), f"{_shortest(self.dz)} {_shortest(self.dr)}",
                 f"{int(self.nz)} {int(self.nr)} {int(self.na)}"]
        lines += [self.beam.line()] if self.beam != Beam() else []
        lines += [self.map.line()] if self.map is not None else []
        lines += ["facets"] * self.facets
        lines += [str(len(self.layers)), _shortest(self.n_above)]
        for index, surface in enumerate([*(layer.top for layer in self.layers), self.bottom]):
            lines += [surface.line(directory, f"{stem}.surface{index}")] if surface else []
            if index < len(self.layers):
                layer = self.layers[index]
                lines.append(" ".join(map(_shortest, (layer.n, layer.mua, layer.mus, layer.g, layer.d))))
        return "\n".join([*lines, _shortest(self.n_below), ""])

    def write(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes the `.mci` PATH, and beside it the surfaces that are arrays. The result will have the same name with `.mco`."""
        path = os.fspath(path)
        name = os.path.splitext(os.path.basename(path))[0]
        text = self.text(name + ".mco", os.path.dirname(os.path.abspath(path)))
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
