"""The shapes of boundaries, and the files of those that are arrays.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from typing import Any, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from . import errors
from .options import Path

HIGHEST = 1e30  # largest |height| [cm], as in the program's own files
CM = 0.01  # m


def shortest(value: float) -> str:
    """Returns a number as text, with as few digits as give the same number again."""
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))


def vector(name: str, value: Any, length: int) -> tuple[float, ...]:
    """Returns a sequence of `length` finite numbers as a tuple. Refuses all else."""
    expected = f"{length} numbers"
    try:
        values = tuple(value)
    except TypeError:
        raise errors.refuse(name, value, expected) from None
    if len(values) != length:
        raise errors.refuse(name, value, expected)
    return tuple(errors.finite(name, item) for item in values)


def write_gsf(path: str, heights: Any, dx: float, dy: float) -> None:
    """Writes a Gwyddion Simple Field (gwyddion.net/documentation/user-guide-en/gsf.html). heights: [ny, nx] in cm, y rising
    with the first index. The file has single-precision floats in m, the row of the largest y first. XReal and YReal are widths
    of all pixels."""
    ny, nx = heights.shape
    header = (f"Gwyddion Simple Field 1.0\nXRes = {nx}\nYRes = {ny}\nXReal = {float(nx * dx * CM)!r}\nYReal = {float(ny * dy * CM)!r}\n"
              "XYUnits = m\nZUnits = m\n").encode("ascii")
    with open(path, "wb") as file:
        file.write(header + b"\0" * (4 - len(header) % 4))
        file.write(np.ascontiguousarray(heights[::-1].astype(float) * CM, dtype="<f4").tobytes())


def write_obj(path: str, vertices: Any, faces: Any) -> None:
    """Writes a Wavefront OBJ file. vertices: [n, 3]. faces: [m, 3], counted from 0 here, from 1 in the file."""
    with open(path, "w", encoding="ascii") as file:
        file.writelines(f"v {float(x)!r} {float(y)!r} {float(z)!r}\n" for x, y, z in vertices)
        file.writelines(f"f {a} {b} {c}\n" for a, b, c in (faces.astype(np.int64) + 1).tolist())


@dataclass
class Heightfield:
    """A surface of revolution about the z axis.

    Attributes:
        r: Radii of the samples [cm], rising from 0.
        h: Heights above the boundary's depth [cm], linear between samples and constant beyond the last one.

    Examples:
        >>> Heightfield(r=[0, 0.1], h=[0.02, 0])
        Heightfield(r=[0, 0.1], h=[0.02, 0])
    """

    r: Sequence[float]
    h: Sequence[float]

    def __post_init__(self) -> None:
        expected = "radii that begin with 0 and rise"
        r = errors.array("Heightfield.r", self.r, "iuf", expected).astype(float)
        if r.ndim != 1 or r.size < 1 or r[0] != 0 or np.any(np.diff(r) <= 0):
            raise errors.refuse("Heightfield.r", self.r, expected)
        expected = f"{r.size} finite heights, one for each radius"
        if errors.array("Heightfield.h", self.h, "iuf", expected).shape != r.shape:
            raise errors.refuse("Heightfield.h", self.h, expected)

    def line(self, directory: Path, stem: str) -> str:
        """The line of the `.mci`; writes no file."""
        r, h = np.asarray(self.r, dtype=float), np.asarray(self.h, dtype=float)
        spacing = np.append(np.diff(r), 0.0)
        samples = "  ".join(f"{shortest(height)} {shortest(step)}" for height, step in zip(h, spacing))
        return f"b {r.size}  {samples}"


@dataclass
class Heightmap:
    """A surface given by a height at every point of a grid.

    Attributes:
        heights: Array [ny, nx] of heights above the boundary's depth [cm]; y rises with the first index, x with the second. A DataArray with
            the dimensions x and y may have them in any order. The file keeps heights in single precision.
        dx: Distance of grid points along x [cm].
        dy: Distance of grid points along y [cm]; None is dx.
        shift: x, y and height of the middle of the map [cm]; default (0, 0, 0).
        scale: Factor on all coordinates; default 1.
        tile: True repeats the map over the whole plane, "mirror" repeats it with its mirror image, and "as-is" repeats it however its ends fit; default False.

    Examples:
        >>> Heightmap(np.zeros((2, 3)), dx=0.01).dy is None
        True
    """

    heights: Any
    dx: float
    dy: Optional[float] = None
    shift: Sequence[float] = (0.0, 0.0, 0.0)
    scale: float = 1.0
    tile: Union[bool, str] = False

    def __post_init__(self) -> None:
        _check_tile("Heightmap.tile", self.tile)
        expected = "an array of finite heights [ny, nx], at least 2 x 2; mc.Mesh(path) reads a file"
        self.heights = _turned(self.heights)
        heights = errors.array("Heightmap.heights", self.heights, "iuf", expected)
        if heights.ndim != 2 or min(heights.shape) < 2 or np.max(np.abs(heights.astype(float))) > HIGHEST:
            raise errors.refuse("Heightmap.heights", self.heights, expected)
        errors.above_zero("Heightmap.dx", self.dx)
        if self.dy is not None:
            errors.above_zero("Heightmap.dy", self.dy)
        errors.above_zero("Heightmap.scale", self.scale)
        vector("Heightmap.shift", self.shift, 3)

    def line(self, directory: Path, stem: str) -> str:
        """Writes DIRECTORY/STEM.gsf. Returns the line that names the file in an `.mci` of that directory."""
        write_gsf(os.path.join(directory, stem + ".gsf"), np.asarray(self.heights), self.dx, self.dx if self.dy is None else self.dy)
        options = {"scale": self.scale, "shift": tuple(self.shift), "tile": self.tile}
        return " ".join([f'm "{stem}.gsf"', *_option_words(options)])


def _turned(heights: Any) -> Any:
    """Returns a DataArray with y before x. Refuses arrays with only one of both dimensions, and falling coordinates, because
    their meaning is not clear."""
    if not {"x", "y"} & set(getattr(heights, "dims", ())):
        return heights
    falls = [name for name in ("y", "x") if name in heights.coords and name in heights.dims and np.any(np.diff(heights[name].values.astype(float)) <= 0)]
    if set(heights.dims) != {"x", "y"} or falls:
        raise errors.refuse("Heightmap.heights", tuple(heights.dims), "the dimensions y and x, with rising coordinates")
    return heights.transpose("y", "x")


def _check_tile(name: str, value: object) -> None:
    if not isinstance(value, (bool, np.bool_)) and not (isinstance(value, str) and value in ("mirror", "as-is")):
        raise errors.refuse(name, value, 'True, False, "mirror" or "as-is"')


def _option_words(options: dict[str, Any]) -> list[str]:
    """Returns the options of a mesh that differ from the defaults, as words of the line."""
    usual = {"up": "z", "rotate": 0.0, "units": "cm", "scale": 1.0, "shift": (0.0, 0.0, 0.0), "normals": "face", "skirt": None, "tile": False, "weld": None}
    words = []
    for key, value in options.items():
        if value == usual[key]:
            continue
        if isinstance(value, (bool, np.bool_)):
            words.append(key)
        elif isinstance(value, tuple):
            words.append(f"{key}={','.join(shortest(number) for number in value)}")
        else:
            words.append(f"{key}={value if isinstance(value, str) else shortest(value)}")
    return words


@dataclass
class Mesh:
    """A surface of triangles: Mesh(path), or Mesh(vertices, faces).

    Attributes:
        path: Path of an `.obj`, `.stl`, `.ply`, `.gsf` or `.asc` file.
        vertices: Array [n, 3] of x, y and height.
        faces: Array [m, 3] of indices of vertices, from 0.
        units: Unit of the numbers: "cm", "mm", "um" or "m"; default "cm".
        up: Axis of the file that points up: "z", "-z", "y", "-y", "x" or "-x"; default "z".
        rotate: Rotation about the vertical [degrees]; default 0.
        scale: Factor on all coordinates; default 1.
        shift: x, y and height that are added [cm]; default (0, 0, 0).
        normals: "face" reflects at the triangles, "vertex" at interpolated normals; default "face".
        skirt: Width of a skirt around a border that is not level [cm]; None is no skirt.
        tile: As of Heightmap; of a `.gsf` or `.asc` file; default False.
        weld: Distance below which corners become one [cm]; None joins equal corners only.
    """

    path: Union[None, str, os.PathLike[str], ArrayLike] = None
    vertices: Optional[ArrayLike] = None
    faces: Optional[ArrayLike] = None
    units: str = "cm"
    up: str = "z"
    rotate: float = 0.0
    scale: float = 1.0
    shift: Sequence[float] = (0.0, 0.0, 0.0)
    normals: str = "face"
    skirt: Optional[float] = None
    tile: Union[bool, str] = False
    weld: Optional[float] = None

    def __post_init__(self) -> None:
        if self.faces is None and self.vertices is not None:  # Mesh(vertices, faces) by position: the first argument is no path
            self.path, self.vertices, self.faces = None, self.path, self.vertices
        if (self.path is None) == (self.vertices is None and self.faces is None):
            raise errors.refuse("Mesh.path", self.path, "either a path, or vertices and faces")
        if self.path is None:
            self._check_arrays()
        else:
            errors.existing_file("Mesh.path", self.path)
        for name, known in (("units", "cm mm um m"), ("up", "z -z y -y x -x"), ("normals", "face vertex")):
            errors.choice("Mesh." + name, getattr(self, name), *known.split())
        _check_tile("Mesh.tile", self.tile)
        errors.finite("Mesh.rotate", self.rotate)
        errors.above_zero("Mesh.scale", self.scale)
        vector("Mesh.shift", self.shift, 3)
        for name in ("skirt", "weld"):
            if getattr(self, name) is not None:
                errors.above_zero("Mesh." + name, getattr(self, name))

    def _check_arrays(self) -> None:
        expected = "an array [n, 3] of finite numbers"
        vertices = errors.array("Mesh.vertices", self.vertices, "iuf", expected)
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            raise errors.refuse("Mesh.vertices", self.vertices, expected)
        expected = "an array [m, 3] of whole numbers"
        faces = errors.array("Mesh.faces", self.faces, "iu", expected)
        if faces.ndim != 2 or faces.shape[1] != 3 or faces.size == 0:
            raise errors.refuse("Mesh.faces", self.faces, expected)
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise errors.refuse("Mesh.faces", self.faces, f"indices from 0 to {len(vertices) - 1}")

    def words(self, directory: Path, stem: str) -> tuple[str, list[str]]:
        """Returns the name of the mesh's file in quotes, and its options. Writes DIRECTORY/STEM.obj if the mesh is given by
        arrays."""
        name = f'"{stem}.obj"' if self.path is None else errors.quoted_file("Mesh.path", self.path)
        if self.path is None:
            write_obj(os.path.join(directory, stem + ".obj"), np.asarray(self.vertices), np.asarray(self.faces))
        options = {key: getattr(self, key) for key in ("up", "rotate", "units", "scale", "shift", "normals", "skirt", "tile", "weld")}
        options["shift"] = tuple(self.shift)
        return name, _option_words(options)

    def line(self, directory: Path, stem: str) -> str:
        """Returns the line of the mesh for an `.mci` in that directory."""
        name, options = self.words(directory, stem)
        return " ".join(["m", name, *options])


@dataclass
class Relief:
    """A random surface of Gaussian heights, drawn by the program and repeated over the whole plane.

    Attributes:
        slope: rms gradient of the facets, the Sdq of ISO 25178; 1e-4 to 10.
        length: Correlation length [cm].
        seed: Number of the surface; another seed is another surface; default 1.
        points: Heights along each axis, ten to a length; a power of two from 16 to 8192; default 512.
        spectrum: "gaussian", "exponential", or "fractal:H" with a Hurst exponent H; default "gaussian".
        shift: x, y and height that are added [cm]; default (0, 0, 0).

    Examples:
        >>> Relief(slope=0.3, length=0.002).points
        512
    """

    slope: float
    length: float
    seed: int = 1
    points: int = 512
    spectrum: str = "gaussian"
    shift: Sequence[float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        errors.number("Relief.slope", self.slope, 1e-4, 10, "a number of 1e-4 to 10")
        errors.above_zero("Relief.length", self.length)
        errors.whole("Relief.seed", self.seed, 0, 2**53)
        if errors.whole("Relief.points", self.points, 16, 8192) & (self.points - 1):
            raise errors.refuse("Relief.points", self.points, "a power of two of 16 to 8192")
        if not isinstance(self.spectrum, str) or not re.fullmatch(r"gaussian|exponential|fractal:[0-9.e-]+", self.spectrum):
            raise errors.refuse("Relief.spectrum", self.spectrum, '"gaussian", "exponential" or "fractal:H"')
        vector("Relief.shift", self.shift, 3)

    def line(self, directory: Path, stem: str) -> str:
        """The line of the `.mci`; writes no file."""
        words = [f"m gaussian {shortest(self.slope)} {shortest(self.length)} tile seed={self.seed} points={self.points} spectrum={self.spectrum}"]
        return " ".join(words + _option_words({"shift": tuple(self.shift)}))


@dataclass
class Rough:
    """Roughness of a boundary or a body below the resolution of its shape.

    Attributes:
        kind: "ggx" or "beckmann".
        alpha: 0 (smooth), or 1e-4 to 2. With "beckmann" it is the rms gradient of the facets.

    Examples:
        >>> Rough("ggx", 0.2).words()
        'ggx 0.2'
    """

    kind: str
    alpha: float

    def __post_init__(self) -> None:
        errors.choice("Rough.kind", self.kind, "ggx", "beckmann")
        if errors.number("Rough.alpha", self.alpha, 0, 2, "0, or a number of 1e-4 to 2") not in (0.0,) and self.alpha < 1e-4:
            raise errors.refuse("Rough.alpha", self.alpha, "0, or a number of 1e-4 to 2")

    def words(self, separator: str = " ") -> str:
        """Returns kind and alpha as a line of the `.mci` has them."""
        return f"{self.kind}{separator}{shortest(self.alpha)}"


Surface = Union[Heightfield, Heightmap, Mesh, Relief]
SURFACE = (Heightfield, Heightmap, Mesh, Relief), "a Heightfield, a Heightmap, a Mesh, a Relief, or None for a plane"  # for errors.optional
ROUGH = Rough, "a Rough, or None for a smooth surface"
