"""Detectors, which see light that leaves: the `detector` lines of a scene.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Optional, Sequence, Union

from . import errors
from .surfaces import shortest, vector
from .top import check_name, check_shape, place_words

SHAPES = {"disk": ("radius",), "ring": ("r1", "r2"), "rectangle": ("width", "height"), "map": ("nx", "ny", "dx", "dy"), "table": (), "port": ()}


@dataclass
class Detector:
    """A detector: it sees packets that leave, where the line of their last flight crosses a level.

    Attributes:
        kind: "disk", "ring", "rectangle", "map", "port" (what leaves through a Port), or "table" (the detectors in the lines of a file); default "disk".
        radius: Radius of a disk [cm].
        at: x and y of its middle [cm]; default (0, 0).
        z: Depth of the level [cm], on which a camera is focused; None is the nominal plane of the side.
        side: "top" or "bottom"; default "top".
        na: Numerical aperture about its axis; None sees all directions.
        angle: Angle of its axis to the outward vertical [degrees]; needs `na`; default 0.
        azimuth: Direction of that tilt [degrees]; default 0.
        diffuse: Whether light that never was in the material is left out; default False.
        name: Name of its results, `detector_NAME`; None is its number, from 1, or the name of its port.
        group: Name of a sum of detectors on one side, `detector_GROUP`, to which this one belongs; None is no sum.
        r1: Inner radius of a ring [cm].
        r2: Outer radius of a ring [cm].
        width: Width of a rectangle over x [cm].
        height: Width of a rectangle over y [cm].
        nx: Number of pixels of a map along x.
        ny: Number of pixels of a map along y.
        dx: Width of a pixel along x [cm].
        dy: Width of a pixel along y [cm].
        file: Path of a table; each line is what stands behind the word `detector` of an `.mci`.
        port: Name of the Port through which the light of a "port" leaves.

    Examples:
        >>> Detector("disk", radius=0.01, na=0.22, at=(0.3, 0), name="far").line()
        'detector disk 0.01 at=0.3,0 na=0.22 name=far'
        >>> Detector("map", nx=80, ny=60, dx=0.01, dy=0.01, z=-0.05, na=0.1, angle=45, diffuse=True).line()
        'detector map 80 60 0.01 0.01 z=-0.05 na=0.1 angle=45 diffuse'
        >>> Detector("port", port="out", na=0.22).line()
        'detector port out na=0.22'
    """

    kind: str = "disk"
    radius: Optional[float] = None
    at: Sequence[float] = (0.0, 0.0)
    z: Optional[float] = None
    side: str = "top"
    na: Optional[float] = None
    angle: float = 0.0
    azimuth: float = 0.0
    diffuse: bool = False
    name: Optional[str] = None
    r1: Optional[float] = None
    r2: Optional[float] = None
    width: Optional[float] = None
    height: Optional[float] = None
    nx: Optional[int] = None
    ny: Optional[int] = None
    dx: Optional[float] = None
    dy: Optional[float] = None
    file: Optional[Union[str, os.PathLike[str]]] = None
    group: Optional[str] = None
    port: Optional[str] = None

    def __post_init__(self) -> None:
        errors.choice("Detector.kind", self.kind, *SHAPES)
        if (self.kind == "table") != (self.file is not None):
            raise errors.refuse("Detector.file", self.file, "the path of a file of detectors for a table, else None")
        if self.file is not None:
            errors.existing_file("Detector.file", self.file)
        check_shape(self, SHAPES[self.kind], sorted({name for names in SHAPES.values() for name in names}), f"a {self.kind}")
        vector("Detector.at", self.at, 2)
        errors.choice("Detector.side", self.side, "top", "bottom")
        for name in ("z", "na"):
            if getattr(self, name) is not None:
                (errors.finite if name == "z" else errors.above_zero)("Detector." + name, getattr(self, name))
        if self.kind == "port":
            check_name("Detector.port", self.port)
            if tuple(self.at) != (0.0, 0.0) or self.z is not None or self.side != "top":
                raise errors.refuse("Detector.at, z, side", (self.at, self.z, self.side), "the defaults for a port, which has its place")
        elif self.port is not None:
            raise errors.refuse("Detector.port", self.port, f"None for a {self.kind}")
        angle = errors.number("Detector.angle", self.angle, 0, 90, "degrees, 0 <= angle <= 90")
        azimuth = errors.number("Detector.azimuth", self.azimuth, -360, 360, "degrees, -360..360")
        if self.na is None and (angle != 0 or azimuth != 0):
            raise errors.refuse("Detector.angle", self.angle, "0 without na")
        errors.flag("Detector.diffuse", self.diffuse)
        for name, value in (("name", self.name), ("group", self.group)):
            if value is not None:
                check_name("Detector." + name, value)

    def line(self) -> str:
        """Returns the line of the detector in an .mci file."""
        if self.file is not None:
            return "detector table " + errors.quoted_file("Detector.file", self.file)
        words = ["detector", self.kind, *([] if self.port is None else [self.port])] + [shortest(getattr(self, name)) for name in SHAPES[self.kind]]
        words += place_words(self)
        words += [] if self.z is None else [f"z={shortest(self.z)}"]
        words += ["side=bottom"] if self.side == "bottom" else []
        words += [] if self.na is None else [f"na={shortest(self.na)}"]
        words += [f"{name}={shortest(getattr(self, name))}" for name in ("angle", "azimuth") if getattr(self, name) != 0]
        words += ["diffuse"] if self.diffuse else []
        return " ".join(words + [f"{name}={getattr(self, name)}" for name in ("name", "group") if getattr(self, name)])
