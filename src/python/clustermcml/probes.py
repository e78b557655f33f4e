"""Layouts of fibre probes in contact: the faces, ports, beams and detectors that a scene needs.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Optional, Sequence

from . import errors
from .detectors import Detector
from .options import ProbeOptions, shown
from .scene import Beam
from .top import Face, Port, Top

if TYPE_CHECKING:
    from typing_extensions import Unpack

MOST_FIBRES = 400


@dataclass
class Fibre:
    """An optical fibre of a `Probe`.

    Attributes:
        core: Radius of the core [cm].
        na: Numerical aperture.
        n: Refractive index of the core; default 1.46.
        cladding: Outer radius of the cladding [cm], whose index is sqrt(n^2 - na^2); None leaves the cladding out.

    Examples:
        >>> Fibre(0.01, na=0.22, cladding=0.011)
        Fibre(core=0.01, na=0.22, n=1.46, cladding=0.011)
    """

    core: float
    na: float
    n: float = 1.46
    cladding: Optional[float] = None

    def __post_init__(self) -> None:
        errors.above_zero("Fibre.core", self.core)
        errors.number("Fibre.n", self.n, 0.01, 100, "a number from 0.01 to 100")
        if not errors.above_zero("Fibre.na", self.na) < self.n:
            raise errors.refuse("Fibre.na", self.na, f"below n, {self.n:g}")
        if self.cladding is not None:
            errors.number("Fibre.cladding", self.cladding, self.core, 1e300, f"a number >= core, {self.core:g}")

    def outer(self) -> float:
        """Returns the outer radius [cm]."""
        return self.core if self.cladding is None else self.cladding

    def ports(self, at: tuple[float, float], name: str) -> list[Top]:
        """Returns the lines of the fibre at a place: its cladding, and the core under its name."""
        cladding = [] if self.cladding is None else [Port("disk", radius=self.cladding, n=math.sqrt(self.n * self.n - self.na * self.na), at=at)]
        return [*cladding, Port("disk", radius=self.core, n=self.n, at=at, name=name)]


@dataclass
class Probe:
    """A probe of equal fibres that touches the layers. The cores are ports named f0, f1, f2 ...

    Make one with `Probe.six_around_one`, `Probe.ring` or `Probe.linear`, and give its lists to a `Scene`. Options of all three:

    - `fill`: refractive index of the epoxy, a disk or rectangle around all fibres; default: no epoxy.
    - `face`: a `Face` below all, such as steel; default: none.
    - `lit`: numbers of the fibres that bring light; default (0,).
    - `read`: numbers of the fibres that collect light; default: all that are not lit.
    - `group`: name of the sum of all that is collected, `detector_GROUP` in results; default: no sum.

    Attributes:
        top: List of Face and Port, for `Scene.top`.
        beam: List of Beam, the light of the lit fibres.
        detectors: List of Detector, `detector_f1` and so on in results.

    Examples:
        >>> probe = Probe.six_around_one(Fibre(0.01, na=0.22), face=Face(0.5, "disk", radius=0.3))
        >>> [port.name for port in probe.top if isinstance(port, Port)]
        ['f0', 'f1', 'f2', 'f3', 'f4', 'f5', 'f6']
        >>> probe.beam[0].line(), probe.detectors[0].line()
        ('beam port f0 light=na:0.22', 'detector port f1 na=0.22')
    """

    top: list[Top] = field(default_factory=list)
    beam: list[Beam] = field(default_factory=list)
    detectors: list[Detector] = field(default_factory=list)

    @classmethod
    @shown
    def six_around_one(cls, fibre: Fibre, spacing: Optional[float] = None, **options: Unpack[ProbeOptions]) -> "Probe":
        """Six fibres, f1 to f6, around f0.

        Args:
            fibre: The fibre.
            spacing: Distance of neighbours from middle to middle [cm]; None lets them touch.
            **options: fill, face, lit, read and group of `Probe`.
        """
        _check_fibre(fibre)
        return cls.ring(fibre, 2 * fibre.outer() * (1 + 1e-9) if spacing is None else spacing, **options)

    @classmethod
    @shown
    def ring(cls, fibre: Fibre, radius: float, count: int = 6, centre: bool = True, **options: Unpack[ProbeOptions]) -> "Probe":
        """Fibres on a circle, the first of them on the x axis, and f0 in the middle.

        Args:
            fibre: The fibre.
            radius: Radius of the circle through the middles of the fibres [cm].
            count: Number of fibres on the circle.
            centre: Whether f0 is in the middle; otherwise f0 is the first on the circle.
            **options: fill, face, lit, read and group of `Probe`.
        """
        _check_fibre(fibre)
        errors.above_zero("radius", radius)
        turns = [2 * math.pi * i / count for i in range(errors.whole("count", count, 1, MOST_FIBRES))]
        errors.flag("centre", centre)
        places = [(0.0, 0.0)] * centre + [(_cut(radius * math.cos(turn)), _cut(radius * math.sin(turn))) for turn in turns]
        return cls._made(fibre, places, {"shape": "disk", "radius": radius + fibre.outer()}, **options)

    @classmethod
    @shown
    def linear(cls, fibre: Fibre, places: Sequence[float], **options: Unpack[ProbeOptions]) -> "Probe":
        """Fibres in a row along x.

        Args:
            fibre: The fibre.
            places: x of f0, f1 ... [cm].
            **options: fill, face, lit, read and group of `Probe`.
        """
        _check_fibre(fibre)
        if not isinstance(places, (list, tuple)) or not 1 <= len(places) <= MOST_FIBRES:
            raise errors.refuse("places", places, f"a list of 1 to {MOST_FIBRES} numbers")
        xs = [errors.finite("places", x) for x in places]
        size = {"width": max(xs) - min(xs) + 2 * fibre.outer(), "height": 2 * fibre.outer(), "at": ((max(xs) + min(xs)) / 2, 0.0)}
        return cls._made(fibre, [(x, 0.0) for x in xs], {"shape": "rectangle", **size}, **options)

    @classmethod
    def _made(cls, fibre: Fibre, places: Sequence[tuple[float, float]], around: dict[str, Any], fill: Optional[float] = None, face: Optional[Face] = None,
              lit: Sequence[int] = (0,), read: Optional[Sequence[int]] = None, group: Optional[str] = None) -> "Probe":
        """Returns the probe of fibres at these places. around: shape of the epoxy."""
        nearest = min((math.dist(a, b) for i, a in enumerate(places) for b in places[:i]), default=math.inf)
        if nearest < 2 * fibre.outer() * (1 - 1e-9):  # touching is allowed
            raise errors.refuse("fibre", fibre, f"an outer radius up to {nearest / 2:g}, half the least distance of two fibres")
        if face is not None and not isinstance(face, Face):
            raise errors.refuse("face", face, "a Face or None")
        lit = _numbers("lit", lit, len(places))
        read = [i for i in range(len(places)) if i not in lit] if read is None else _numbers("read", read, len(places))
        top: list[Top] = [*([] if face is None else [face]), *([] if fill is None else [Port(n=fill, **around)])]
        for i, at in enumerate(places):
            top += fibre.ports(at, f"f{i}")
        return cls(top, [Beam("port", port=f"f{i}", light=f"na:{fibre.na!r}") for i in lit], [Detector("port", port=f"f{i}", na=fibre.na, group=group) for i in read])


def _cut(length: float) -> float:
    """Returns a length [cm] without the rounding errors of sines, 0 above all."""
    return round(length, 12) + 0.0


def _check_fibre(fibre: Any) -> None:
    if not isinstance(fibre, Fibre):
        raise errors.refuse("fibre", fibre, "a Fibre")


def _numbers(name: str, value: Any, count: int) -> list[int]:
    """Returns the numbers of fibres as a list of int."""
    if not isinstance(value, (list, tuple, range)):
        raise errors.refuse(name, value, "a list of numbers of fibres")
    return [errors.whole(name, i, 0, count - 1) for i in value]
