"""Faces and ports: what touches boundary 0 from above, such as steel and fibres. They are the `face` and `port` lines of a scene.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Optional, Sequence, Union

from . import errors
from .surfaces import shortest, vector

SHAPES = {"disk": ("radius",), "ring": ("r1", "r2"), "rectangle": ("width", "height")}
NUMBERS = ("radius", "r1", "r2", "width", "height")


def check_name(name: str, value: Any) -> None:
    """Refuses all but the name of a port."""
    if not (isinstance(value, str) and re.fullmatch(r"[A-Za-z0-9_]{1,24}", value)):
        raise errors.refuse(name, value, "1 to 24 letters, digits and underscores")


def check_shape(thing: Any, used: Sequence[str], known: Sequence[str], owner: str) -> None:
    """Checks that a part of a scene has the numbers of its shape, `used`, and no others that are known. owner: the part, in messages."""
    for key in known:
        name, value = f"{type(thing).__name__}.{key}", getattr(thing, key)
        if key in ("nx", "ny") and key in used:
            errors.whole(name, value, 1, 1_000_000_000)
        elif key in used:
            (errors.at_least_zero if key == "r1" else errors.above_zero)(name, value)
        elif value is not None:
            raise errors.refuse(name, value, f"None for {owner}")


def _check_area(thing: "Face | Port") -> None:
    """Checks the shape and the place of a face or a port."""
    check_shape(thing, SHAPES[thing.shape] if thing.shape else (), NUMBERS, f"a {thing.shape}" if thing.shape else "the whole plane")
    vector(type(thing).__name__ + ".at", thing.at, 2)
    if thing.shape is None and tuple(thing.at) != (0.0, 0.0):
        raise errors.refuse(type(thing).__name__ + ".at", thing.at, "(0, 0) for the whole plane")


def check_reflector(thing: Any, key: str) -> None:
    """Checks the law of a face or a backing, which stands under `key`, and that it has the numbers of its law and no others."""
    name, law = type(thing).__name__, getattr(thing, key)
    errors.choice(f"{name}.{key}", law, "mirror", "lambertian", "metal")
    for number, used, most in (("R", law != "metal", 1), ("n", law == "metal", 100), ("k", law == "metal", 100)):
        value = getattr(thing, number)
        if used:
            errors.number(f"{name}.{number}", value, 0, most, f"a number from 0 to {most}")
        elif value is not None:
            raise errors.refuse(f"{name}.{number}", value, f"None for {law}")


def reflector_numbers(thing: Any) -> list[str]:
    """Returns the numbers of a law as words."""
    return [shortest(value) for value in (thing.R, thing.n, thing.k) if value is not None]


def _shape_words(thing: "Face | Port") -> list[str]:
    return [] if thing.shape is None else [thing.shape, *(shortest(getattr(thing, key)) for key in SHAPES[thing.shape])]


def place_words(thing: Any) -> list[str]:
    """Returns the word for `at`; none at the origin."""
    return ["at=" + ",".join(map(shortest, thing.at))] if tuple(thing.at) != (0.0, 0.0) else []


@dataclass
class Face:
    """An opaque surface that touches boundary 0: steel, black epoxy, white plastic.

    Attributes:
        R: Reflectance of a mirror or a Lambertian face, 0 to 1.
        shape: "disk", "ring" or "rectangle"; None covers the whole plane.
        radius: Radius of a disk [cm].
        at: x and y of its middle [cm]; default (0, 0).
        law: "mirror" or "lambertian", which send back the share R, or "metal", which reflects by Fresnel's formula; default "mirror".
        n: Real part of the index of a metal.
        k: Imaginary part of the index of a metal.
        r1: Inner radius of a ring [cm].
        r2: Outer radius of a ring [cm].
        width: Width of a rectangle over x [cm].
        height: Width of a rectangle over y [cm].

    Examples:
        >>> Face(0.6, "disk", radius=0.3).line()
        'face disk 0.3 0.6'
        >>> Face(0.9, law="lambertian").line()
        'face 0.9 lambertian'
        >>> Face(shape="ring", r1=0.1, r2=0.2, law="metal", n=2.5, k=3.4, at=(0, 0.1)).line()
        'face ring 0.1 0.2 metal 2.5 3.4 at=0,0.1'
    """

    R: Optional[float] = None
    shape: Optional[str] = None
    radius: Optional[float] = None
    at: Sequence[float] = (0.0, 0.0)
    law: str = "mirror"
    n: Optional[float] = None
    k: Optional[float] = None
    r1: Optional[float] = None
    r2: Optional[float] = None
    width: Optional[float] = None
    height: Optional[float] = None

    def __post_init__(self) -> None:
        if self.shape is not None:
            errors.choice("Face.shape", self.shape, *SHAPES)
        _check_area(self)
        check_reflector(self, "law")

    def line(self) -> str:
        numbers = reflector_numbers(self)
        law = {"mirror": numbers, "lambertian": [*numbers, "lambertian"], "metal": ["metal", *numbers]}[self.law]
        return " ".join(["face", *_shape_words(self), *law, *place_words(self)])


@dataclass
class Port:
    """A medium that fills all above a part of boundary 0: a fibre, glass, epoxy, or a hole.

    Attributes:
        shape: "disk", "ring" or "rectangle"; default "disk".
        radius: Radius of a disk [cm].
        n: Refractive index, 0.01 to 100.
        at: x and y of its middle [cm]; default (0, 0).
        name: Name for beams and detectors; None is its number among the ports, from 1.
        r1: Inner radius of a ring [cm].
        r2: Outer radius of a ring [cm].
        width: Width of a rectangle over x [cm].
        height: Width of a rectangle over y [cm].

    Examples:
        >>> Port("disk", radius=0.01, n=1.46, at=(0.011, 0), name="out").line()
        'port disk 0.01 n=1.46 at=0.011,0 name=out'
    """

    shape: str = "disk"
    radius: Optional[float] = None
    n: float = 1.0
    at: Sequence[float] = (0.0, 0.0)
    name: Optional[str] = None
    r1: Optional[float] = None
    r2: Optional[float] = None
    width: Optional[float] = None
    height: Optional[float] = None

    def __post_init__(self) -> None:
        errors.choice("Port.shape", self.shape, *SHAPES)
        _check_area(self)
        errors.number("Port.n", self.n, 0.01, 100, "a number from 0.01 to 100")
        if self.name is not None:
            check_name("Port.name", self.name)

    def line(self) -> str:
        name = [] if self.name is None else [f"name={self.name}"]
        return " ".join(["port", *_shape_words(self), f"n={shortest(self.n)}", *place_words(self), *name])


Top = Union[Face, Port]
