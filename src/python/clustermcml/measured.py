"""Measured data as a fit takes it: names, values and standard errors.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import dataclasses
from typing import Any, Callable, Mapping, Union

import numpy as np

from . import errors
from .commands import check
from .options import Path
from .scene import Scene

TOTALS = ("Rd", "Tt", "R")  # R = Rsp + Rd, which an integrating sphere may see
PROFILES = ("Rd_r", "Tt_r", "Rd_a", "Tt_a")
SPHERES = ("M_R", "M_T")  # readings of a single integrating sphere with a port
DETECTOR = "detector_"  # names begin so for light that a detector has seen
SLACK = 4  # standard errors by which a number may lie below 0 or above all light
LEAST, MOST = 1e-30, 1e30  # limits of errors and profiles, whose squares must fit into doubles


@dataclasses.dataclass(frozen=True)
class Data:
    """All measured numbers in a row. names: name of each number; places: its bin in a profile, or -1 for a total."""

    names: list[str]
    places: list[int]
    values: Any
    errors: Any
    sizes: dict[str, int]  # number of values given for each name
    sides: dict[str, str]  # side on which the light of a detector or a profile leaves: R (top) or T (bottom)

    def pick(self, of: Callable[[str], Any]) -> Any:
        """Returns the measured places of the arrays that `of` gives by name, as one array."""
        whole = {name: np.atleast_1d(of(name)) for name in dict.fromkeys(self.names)}
        return np.array([whole[name][max(place, 0)] for name, place in zip(self.names, self.places)], dtype=float)

    def bins(self, name: str) -> list[int]:
        """Returns the measured bins of a profile."""
        return [place for other, place in zip(self.names, self.places) if other == name]

    def profiles(self) -> list[str]:
        """Returns the names of the measured profiles."""
        return [name for name in dict.fromkeys(self.names) if name in PROFILES]

    def parted(self, numbers: Any) -> dict[str, Any]:
        """Splits numbers by name: floats for totals, arrays of the measured bins for profiles."""
        found: dict[str, Any] = {}
        for name in dict.fromkeys(self.names):
            own = numbers[[i for i, other in enumerate(self.names) if other == name]]
            found[name] = own if name in PROFILES else float(own[0])
        return found


def _sides(scene: Union[Scene, Path], measured: Mapping[str, Any]) -> dict[str, str]:
    """Returns the side on which the light of each profile and measured detector leaves: R (top) or T (bottom)."""
    seen = {DETECTOR + one["name"]: one["side"] for one in check(scene)[0].get("detectors") or ()} if any(map(is_detector, measured)) else {}
    for name in filter(is_detector, measured):
        if name not in seen:
            raise errors.refuse("measured", name, "detectors of the scene, " + (" ".join(seen) or "which has none"))
    return {**{name: name[0] for name in PROFILES}, **{name: name[-1] for name in SPHERES}, **{name: "R" if side == "top" else "T" for name, side in seen.items()}}


def is_detector(name: Any) -> bool:
    """True for the name of light that a detector has seen."""
    return isinstance(name, str) and name.startswith(DETECTOR)


def check_name(where: str, name: Any) -> None:
    """Refuses a name that cannot be measured."""
    if name not in TOTALS + PROFILES + SPHERES and not is_detector(name):
        raise errors.refuse(where, name, "names among " + " ".join(TOTALS + PROFILES + SPHERES) + ", and detector_NAME")


def check_number(where: str, name: str, value: float, error: float) -> None:
    """Refuses a number that no light gives, by more than SLACK errors. Percents and wrong signs are found so, because a total
    is a share of the launched light."""
    errors.number(f"{where}: error", error, LEAST, MOST, f"a standard error > 0, from {LEAST:g} to {MOST:g}")
    most, light = (MOST, ">= 0") if name in PROFILES else (1 + SLACK * error, "from 0 to 1")
    errors.number(f"{where}: value", value, -SLACK * error, most, f"a number {light}, or at most {SLACK} standard errors beyond")


def read_measured(measured: Any, scene: Union[Scene, Path]) -> Data:
    """Checks what was measured, and returns it in the order given. Bins of profiles become single numbers."""
    if not isinstance(measured, Mapping) or not measured:
        raise errors.refuse("measured", measured, 'a dict, {"Rd": (value, error), "Rd_r": (values, errors)}')
    names: list[str] = []
    places: list[int] = []
    values: list[float] = []
    sigmas: list[float] = []
    sizes: dict[str, int] = {}
    for name, pair in measured.items():
        check_name("measured", name)
        try:
            value, error = (np.atleast_1d(np.asarray(numbers, dtype=float)) for numbers in pair)
            value, error = np.broadcast_arrays(value, error)
        except (TypeError, ValueError):
            raise errors.refuse(f"measured[{name!r}]", pair, "a value and its standard error, of profiles arrays, nan where nothing is known") from None
        known = ~np.isnan(value)
        if value.ndim != 1 or (name not in PROFILES) != (value.size == 1) or not known.any() or not np.all(error[known] > 0):
            raise errors.refuse(f"measured[{name!r}]", pair, "a value and its standard error > 0, of profiles a value for each bin")
        sizes[name] = value.size
        if name.endswith("_r"):
            known[-1] = False  # the last bin of a result also holds the light beyond the grid
            if not known.any():
                raise errors.refuse(f"measured[{name!r}]", pair, "values of other bins than the last, which holds what lies beyond")
        for i in np.flatnonzero(known):
            check_number(f"measured[{name!r}]", name, float(value[i]), float(error[i]))
            names.append(name)
            places.append(int(i) if name in PROFILES else -1)
            values.append(float(value[i]))
            sigmas.append(float(error[i]))
    for one, other in (("Rd", "R"), ("Rd_r", "Rd_a"), ("Tt_r", "Tt_a")):
        if one in measured and other in measured:
            raise errors.refuse("measured", f"{one} and {other}", "one of them, as the same packets tell both")
    sides = _sides(scene, measured)
    for one in filter(is_detector, measured):
        for other in PROFILES:
            if other in measured and sides[other] == sides[one]:
                raise errors.refuse("measured", f"{one} and {other}", "one of them, as the same packets tell both")
    for one in filter(SPHERES.__contains__, measured):
        for other in measured:
            if other != one and (sides[other] if other in sides else other[0]) == sides[one]:
                raise errors.refuse("measured", f"{one} and {other}", "one of them, as the same packets tell both")
    return Data(names, places, np.array(values), np.array(sigmas), sizes, sides)
