"""Flies a scene in parallel light from several angles and sorts the light that leaves by direction.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import dataclasses
import math
import os
import warnings
from dataclasses import dataclass
from typing import Any, Mapping, Optional, Sequence

import numpy as np

from . import errors
from .fields import Fields
from .options import option_words
from .program import ALL, fly
from .progress import Progress
from .relit import beam_shape, relit_text
from .scene import MOST_PHOTONS
from .scene_files import NONE, scratch_folder
from .sweep import table_text

CONE = 1e-3  # sine of the half-angle of the cone around the mirrored, or refracted, direction that counts as exact
WIDE = 1e6  # radius of a detector that sees a whole side [cm]
LEAST, DARK = 10000, 1e-3  # least number of packets with an error target; albedo below which no relative error is asked for
OPAQUE = 1e9  # mua of a first layer from which no light returns [1/cm]
EDGE = 1e-5  # a direction this near to the edge of two bins may lie in either [rad]


@dataclass
class Setup:
    """A scene, and the flights that are made with it. told: the answer of `check`. angles: of incidence [degrees]. sets:
    numbers of each channel, as `--set` takes them. bins: even bins over theta and phi. back: light comes from below."""

    path: str
    told: dict[str, Any]
    angles: Any
    sets: Sequence[Mapping[str, float]]
    bins: tuple[int, int]
    back: bool
    seed: int
    options: Mapping[str, Any]

    def index(self, name: str, channel: int) -> float:
        """Returns n of a medium ("above", "below", "layer1" ...) in a channel."""
        number = self.sets[channel].get(name + ".n")
        if number is not None:
            return float(number)
        return float(self.told["layers"][int(name[5:]) - 1]["n"] if name.startswith("layer") else self.told["n_" + name])

    def outer(self, channel: int) -> tuple[float, float, float]:
        """Returns n of the medium on the lit side, of the layer there, and of the medium on the other side."""
        layers = len(self.told["layers"])
        above, below = self.index("above", channel), self.index("below", channel)
        return (below, self.index(f"layer{layers}", channel), above) if self.back else (above, self.index("layer1", channel), below)

    def through(self, angle: float, channel: int) -> float:
        """Returns the angle [degrees] at which parallel light leaves on the other side, or 0 if it is totally reflected."""
        near, _, far = self.outer(channel)
        sine = near / far * math.sin(math.radians(angle))
        return math.degrees(math.asin(sine)) if sine < 1 else 0.0


def kind_of(told: Mapping[str, Any]) -> str:
    """Returns "planes", "tiles" or "hill". A hill is any scene that differs from place to place: other shapes, bodies, faces or ports."""
    curved = [boundary for boundary in told["boundaries"] if boundary["kind"] != "plane"]
    if told.get("bodies") or told.get("top") or not all("period" in boundary for boundary in curved):
        return "hill"
    return "tiles" if curved else "planes"


def _beam(setup: Setup) -> tuple[str, Optional[Sequence[float]]]:
    """Returns the line of the beam. Under tiles lit from below, also returns their period [cm], because the width of the beam
    follows the angle."""
    kind, place = kind_of(setup.told), ""
    if setup.back:
        if setup.told["backing"]:
            raise errors.InputError("--back: no light comes in from below a backing")
        if kind == "hill":
            raise errors.refuse("back", True, "a scene of planes or tiles, without bodies")
        place = f" z={setup.told['boundaries'][-1]['outer_z'] + 1.0!r} angle=180"
    if kind == "planes":
        return "beam pencil" + place, None
    if kind == "tiles" and not setup.back:
        return "beam rectangle tile", None
    if kind == "tiles":
        period = next(boundary["period"] for boundary in setup.told["boundaries"] if "period" in boundary)
        return f"beam rectangle {period[0]!r} {period[1]!r}{place}", period
    if len(setup.told["beams"]) != 1:
        raise errors.refuse("scene", f"{len(setup.told['beams'])} beams", "one beam, whose shape lights a surface that is no plane or tile")
    warnings.warn("the scene is not the same everywhere: the result is of the place that its beam lights, and of no material", stacklevel=4)
    return f"beam {beam_shape(setup.path) or 'pencil'}", None


def _table(setup: Setup, period: Optional[Sequence[float]], detectors: bool) -> list[dict[str, float]]:
    """Returns the table of the sweep: one row for each channel and angle."""
    rows = []
    for channel, numbers in enumerate(setup.sets):
        for i, angle in enumerate(setup.angles):
            row = {**numbers, "beam.angle": 180.0 - angle if setup.back else float(angle), "seed": setup.seed + 1000003 * i}
            row.update({"beam.w": period[0] * math.cos(math.radians(angle))} if period else {})
            if detectors:
                row.update({"detector2.angle": float(angle), "detector3.angle": float(angle), "detector4.angle": setup.through(angle, channel)})
            rows.append(row)
    return rows


def _fly(setup: Setup, lines: Sequence[str], rows: Sequence[Mapping[str, float]], options: Mapping[str, Any], silent: str, folder: Optional[str] = None) -> list[Fields]:
    """Flies the rows of a table. lines: of the light. folder: for the files of the program, which then flies."""
    table = table_text([rows[0], *(row.values() for row in rows)])
    with Progress(None) as progress:
        return fly(relit_text(setup.path, lines), ["--ignore-absorption", *option_words(options)], progress, table=table, output_dir=folder, silent=silent)


def fly_angles(setup: Setup) -> list[list[Any]]:
    """Flies all channels and angles. Returns the results, [channel][angle].

    Detector `lit` sees all light on the lit side. `mirror` sees the cone around the mirrored direction. `mirror_in` sees the
    same cone without light that was never inside. `through` sees the cone around the refracted direction."""
    beam, period = _beam(setup)
    near, far = ("bottom", "top") if setup.back else ("top", "bottom")
    lit, _, other = setup.outer(0)
    cone = f"detector disk {WIDE:g} angle=0 side="
    lines = [beam, f"directions {2 * setup.bins[0]} {2 * setup.bins[1]}", f"detector disk {WIDE:g} side={near} name=lit",
             f"{cone}{near} na={CONE * lit!r} name=mirror", f"{cone}{near} na={CONE * lit!r} name=mirror_in diffuse",
             f"{cone}{far} na={CONE * other!r} name=through"]
    options = {name: value for name, value in setup.options.items() if name not in ("photons", "target_error")}
    target, rows = setup.options.get("target_error"), _table(setup, period, True)
    first = int(setup.options.get("photons") or sum(beam["photons"] for beam in setup.told["beams"]))
    counts = [first if target is None else max(first, LEAST)] * len(rows)
    found: list[Any] = [None] * len(rows)
    left = list(range(len(rows)))
    while left:
        silent = NONE if counts == [counts[0]] * len(rows) else ALL
        for i, one in zip(left, _fly(setup, lines, [{**rows[i], "photons": counts[i]} for i in left], options, silent)):
            found[i] = one.dataset()
        more = {i: _factor(found[i], target) for i in left}
        left = [i for i in left if more[i] > 1]
        counts = [min(int(count * more.get(i, 1)), MOST_PHOTONS) for i, count in enumerate(counts)]
    angles = len(setup.angles)
    return [found[i:i + angles] for i in range(0, len(found), angles)]


def _factor(result: Any, target: Optional[float]) -> float:
    """Returns the factor by which a flight needs more packets to reach the relative error `target` of its albedo. The factor is
    1 if the target is reached, or if the albedo plus three errors is below DARK."""
    value, error = float(result.detector_lit), float(result.detector_lit_se)
    if target is None or error <= target * value or value + 3 * error < DARK:
        return 1.0
    return min(max(1.2 * (error / (target * value)) ** 2, 2.0), 32.0) if value > 0 else 32.0


def fly_packets(setup: Setup, channel: int, angle: int, photons: int, gloss: bool) -> tuple[Any, Any]:
    """Flies packets and returns those that leave on the lit side: weights per launched packet [n] and directions [n, 3], z
    outward.

    gloss: only light that was never inside. The lit layer is then opaque, which does not change this light and saves the flight
    of the rest."""
    from .photons import read_photons
    beam, period = _beam(setup)
    numbers = {name: value for name, value in setup.sets[channel].items() if not (gloss and name.endswith((".mua", ".mus")))}
    layer = f"layer{len(setup.told['layers'])}" if setup.back else "layer1"
    numbers.update({layer + ".mua": OPAQUE, layer + ".mus": 0.0} if gloss else {})
    one = dataclasses.replace(setup, angles=setup.angles[angle:angle + 1], sets=[numbers], seed=setup.seed + 1000003 * angle + 500)
    options = {name: value for name, value in setup.options.items() if name != "target_error"}
    with scratch_folder() as scratch:  # saved packets are a file
        _fly(setup, [beam, f'photons "leave" limit={photons}'], _table(one, period, False), {**options, "photons": photons}, ALL, scratch)
        table = read_photons(os.path.join(scratch, "leave-0001.photons.h5"))
    table = table[table["side"] == 1 if setup.back else table["side"] == 2 if gloss else table["side"] != 1]
    flights = table[["ux", "uy", "uz"]].to_numpy(float, copy=True)
    flights[:, 2] *= 1 if setup.back else -1
    return table["weight"].to_numpy(float) / photons, flights


# ---- bins ----

@dataclass
class Bins:
    """Bins of the exit direction with middles at 0, 90 / nt, 2 * 90 / nt ... degrees over theta, and 0, 360 / np ... over phi.
    Each bin joins two flown bins. The mirror image of an angle of incidence that is a multiple of the width therefore lies in
    the middle of a bin."""

    nt: int
    np: int

    def edges(self) -> Any:
        """Returns the edges of the bins over theta [rad], nt + 2 of them."""
        return np.concatenate([[0.0], (np.arange(self.nt) + 0.5) * (np.pi / 2 / self.nt), [np.pi / 2]])

    def middles(self) -> Any:
        """Returns the middles of the bins of the polar angle [rad]."""
        edges = self.edges()
        return (edges[:-1] + edges[1:]) / 2

    def azimuths(self) -> Any:
        """Returns the azimuths of the bins [rad]."""
        return np.arange(self.np) * (2 * np.pi / self.np)

    def projected(self) -> Any:
        """Returns the projected solid angle [sr] of the bins over theta, [nt + 1]. All azimuths have equal bins."""
        return np.diff(np.sin(self.edges()) ** 2) * np.pi / self.np

    def join(self, shares: Any) -> Any:
        """Adds up flown bins [2 nt, 2 np] in pairs to joined bins [nt + 1, np]."""
        rows = np.vstack([shares[:1], shares[1:-1].reshape(self.nt - 1, 2, -1).sum(axis=1), shares[-1:]])
        return np.asarray(np.roll(rows, 1, axis=1).reshape(self.nt + 1, self.np, 2).sum(axis=2))

    def shares(self, value: Any, error: Any) -> tuple[Any, Any]:
        """Returns weight per packet, and its error, in joined bins, from a quantity per sr in flown bins [2 nt, 2 np]."""
        edges = np.arange(2 * self.nt + 1) * (np.pi / 4 / self.nt)
        solid = (np.cos(edges[:-1]) - np.cos(edges[1:]))[:, None] * (np.pi / self.np)
        return self.join(value * solid), np.sqrt(self.join((error * solid) ** 2))

    def without(self, shares: Any, errors_: Any, mirror: float, angle: float) -> tuple[Any, Any]:
        """Returns shares without the light `mirror` that leaves exactly at `angle` [rad] and azimuth 0. If the angle is the
        edge of two bins, both get their common mean. Errors of these bins are set to those of equally bright light elsewhere."""
        if mirror <= 0:
            return shares, errors_
        shares, errors_, edges = shares.copy(), errors_.copy(), self.edges()
        hit = np.flatnonzero((edges[:-1] - EDGE <= angle) & (angle <= edges[1:] + EDGE))
        weights = self.projected()[hit]
        rest = max(float(shares[hit, 0].sum()) - mirror, 0.0)
        shares[hit, 0] = rest * weights / weights.sum()
        others = np.ones(shares.shape, bool)
        others[hit, 0] = False
        total = float(shares[others].sum())
        errors_[hit, 0] = np.sqrt(shares[hit, 0] * ((errors_[others] ** 2).sum() / total if total > 0 else 0.0))
        return shares, errors_
