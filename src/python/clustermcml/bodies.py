"""Bodies inside a layer, each a medium of its own: spheres, cylinders and closed meshes.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional

from . import errors
from .options import Path
from .phases import Phase
from .surfaces import ROUGH, Mesh, Rough, shortest


def check_medium(owner: Any) -> None:
    """Checks the numbers of a layer or a body, and how it scatters."""
    name = type(owner).__name__
    errors.number(name + ".n", owner.n, 0.01, 100, "a number from 0.01 to 100")
    errors.at_least_zero(name + ".mua", owner.mua)
    errors.at_least_zero(name + ".mus", owner.mus)
    errors.number(name + ".g", owner.g, -1, 1, "a number from -1 to 1")
    errors.optional(name + ".phase", owner.phase, Phase, "a Phase or None")


def _check_body(body: "Sphere | Cylinder | Body") -> None:
    check_medium(body)
    errors.optional(type(body).__name__ + ".rough", body.rough, *ROUGH)


def _rough_word(rough: Optional[Rough]) -> str:
    return f" rough={rough.words(',')}" if rough else ""


@dataclass
class Sphere:
    """A sphere inside a layer.

    Attributes:
        x: x of the centre [cm].
        y: y of the centre [cm].
        z: Depth of the centre [cm].
        r: Radius [cm].
        n: Refractive index.
        mua: Absorption coefficient [1/cm].
        mus: Scattering coefficient [1/cm].
        g: Mean cosine of scattering.
        phase: How the body scatters; None is the function of Henyey and Greenstein.
        rough: Roughness of its surface.

    Examples:
        >>> Sphere(0, 0, 0.1, 0.05, n=1.4, mua=5, mus=20, g=0.5).line("", "")
        'i sphere 0 0 0.1 0.05 1.4 5 20 0.5'
    """

    x: float
    y: float
    z: float
    r: float
    n: float
    mua: float
    mus: float
    g: float
    phase: Optional[Phase] = None
    rough: Optional[Rough] = None

    def __post_init__(self) -> None:
        for name in ("x", "y", "z"):
            errors.finite("Sphere." + name, getattr(self, name))
        errors.above_zero("Sphere.r", self.r)
        _check_body(self)

    def line(self, directory: Path, stem: str) -> str:
        """The line of the `.mci`; writes no file."""
        return "i sphere " + " ".join(map(shortest, (self.x, self.y, self.z, self.r, self.n, self.mua, self.mus, self.g))) + _rough_word(self.rough)


@dataclass
class Cylinder:
    """A cylinder with flat ends inside a layer.

    Attributes:
        x1: x of the middle of the first end [cm].
        y1: y of the middle of the first end [cm].
        z1: Depth of the middle of the first end [cm].
        x2: x of the middle of the second end [cm].
        y2: y of the middle of the second end [cm].
        z2: Depth of the middle of the second end [cm].
        r: Radius [cm].
        n: Refractive index.
        mua: Absorption coefficient [1/cm].
        mus: Scattering coefficient [1/cm].
        g: Mean cosine of scattering.
        phase: How the body scatters; None is the function of Henyey and Greenstein.
        rough: Roughness of its surface.
    """

    x1: float
    y1: float
    z1: float
    x2: float
    y2: float
    z2: float
    r: float
    n: float
    mua: float
    mus: float
    g: float
    phase: Optional[Phase] = None
    rough: Optional[Rough] = None

    def __post_init__(self) -> None:
        for name in ("x1", "y1", "z1", "x2", "y2", "z2"):
            errors.finite("Cylinder." + name, getattr(self, name))
        errors.above_zero("Cylinder.r", self.r)
        _check_body(self)

    def line(self, directory: Path, stem: str) -> str:
        """The line of the `.mci`; writes no file."""
        ends = (self.x1, self.y1, self.z1, self.x2, self.y2, self.z2, self.r)
        return "i cylinder " + " ".join(map(shortest, (*ends, self.n, self.mua, self.mus, self.g))) + _rough_word(self.rough)


@dataclass
class Body:
    """A closed mesh inside a layer.

    Attributes:
        mesh: Mesh whose heights count up from z = 0 of the scene: a ball 0.25 cm deep has shift=(0, 0, -0.25).
        n: Refractive index.
        mua: Absorption coefficient [1/cm].
        mus: Scattering coefficient [1/cm].
        g: Mean cosine of scattering.
        phase: How the body scatters; None is the function of Henyey and Greenstein.
        union: Whether closed parts of the mesh may cross; inside is then what is inside of any part; default False.
        rough: Roughness of its surface.
    """

    mesh: Mesh
    n: float
    mua: float
    mus: float
    g: float
    phase: Optional[Phase] = None
    union: bool = False
    rough: Optional[Rough] = None

    def __post_init__(self) -> None:
        if not isinstance(self.mesh, Mesh):
            raise errors.refuse("Body.mesh", self.mesh, "a Mesh")
        errors.flag("Body.union", self.union)
        _check_body(self)

    def line(self, directory: Path, stem: str) -> str:
        """The line of the `.mci` in that directory; writes DIRECTORY/STEM.obj where the mesh is no file."""
        name, options = self.mesh.words(directory, stem)
        return " ".join(["i", name, *map(shortest, (self.n, self.mua, self.mus, self.g)), *options, *(["union"] if self.union else [])]) + _rough_word(self.rough)
