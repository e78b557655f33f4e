"""Flights of a subsurface profile: a pencil of light comes in, and distances to the places where the light leaves are counted.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Any, Mapping, Optional, Sequence

import numpy as np

from . import errors
from .fields import Fields
from .options import option_words
from .program import ALL, fly
from .progress import Progress
from .relit import relit_text
from .scene import Text
from .scene_files import scratch_folder

BINS = 400
INSIDE = 0.999  # share of the pilot's light within the bins
PILOT = 10_000
MOST_SAVED = 1_000_000  # packets of a round over tiles, which all stay in memory
SIDE = 32  # pencils of light along each side of a period
BATCHES = 64  # number of groups of pencils, whose spread gives the errors
OTHER_SEED = 2**40  # distance between the seeds of rounds
PILOT_SEED = 2**39
LIGHT = {"normal": "", "diffuse": " light=lambertian"}


@dataclass
class Flight:
    """A flight. light, light_se: share of the launched packets in every bin, and last the share beyond all bins. The sum of
    `light` is Rd."""

    photons: int
    light: Any
    light_se: Any
    Rd_se: float
    Rsp: float
    attrs: Mapping[str, Any]

    @property
    def Rd(self) -> float:
        return math.fsum(self.light)

    def noise(self) -> float:
        """Returns the mean of the integral of |S - truth| 2 pi r dr / Rd, if errors of the bins are normal."""
        return float(math.sqrt(2 / math.pi) * self.light_se.sum() / self.Rd)

    def joined(self, other: Flight) -> Flight:
        """Returns the mean of two flights, weighted by photons. Their errors are independent, because their seeds differ."""
        photons = self.photons + other.photons
        a, b = self.photons / photons, other.photons / photons
        return Flight(photons, a * self.light + b * other.light, np.hypot(a * self.light_se, b * other.light_se),
                      math.hypot(a * self.Rd_se, b * other.Rd_se), a * self.Rsp + b * other.Rsp, self.attrs)


@dataclass
class Target:
    """The scene and its light. period: of the tiles [cm], None for planes. light: "normal" or "diffuse". shown: name of the
    scene in messages."""

    path: str
    period: Optional[Sequence[float]]
    light: str
    shown: object
    numbers: Mapping[str, float]  # values of a channel, as --set takes them
    threads: Optional[int]

    def words(self, photons: int, seed: int) -> list[str]:
        return option_words({"photons": photons, "seed": seed, "threads": self.threads, "set": self.numbers, "ignore_absorption": True})

    def places(self, seed: int) -> Any:
        """Returns the places of the pencils of light, [n, 2] in cm. Over tiles, one pencil lies at random in each cell of a
        grid; the order is random, too."""
        if self.period is None:
            return np.zeros((1, 2))
        draw = np.random.Generator(np.random.PCG64(seed))
        y, x = np.divmod(np.argsort(draw.random(SIDE * SIDE), kind="stable"), SIDE)
        return (np.stack([x, y], axis=1) + draw.random((SIDE * SIDE, 2))) / SIDE * np.asarray(self.period)


def _fly(target: Target, lines: Sequence[str], grid: tuple[float, int], photons: int, seed: int, folder: Optional[str] = None) -> Fields:
    """Flies the scene with other lines for its light. grid: dr and nr. folder: for the files of the program, which then flies."""
    text = relit_text(target.path, lines).split("\n")
    head = 3 + len(lines)
    text[2], text[head + 1], text[head + 2] = "scene.h5 B", f"1 {grid[0]!r}", f"1 {grid[1]} 1"
    with Progress(None) as progress:
        return fly(Text("\n".join(text)), target.words(photons, seed), progress, output_dir=folder, silent=ALL)[0]


def fly_packets(target: Target, photons: int, seed: int) -> tuple[Any, Any, Any, Fields]:
    """Flies packets and returns those that leave upward from inside: distance [cm] from the pencil, weight, and number of the
    pencil. The result follows."""
    from .photons import read_photons
    places = target.places(seed)
    lines = [f"beam pencil at={x!r},{y!r}{LIGHT[target.light]}" for x, y in places.tolist()] + [f'photons "leave" limit={photons}']
    with scratch_folder() as scratch:  # saved packets are a file
        result = _fly(target, lines, (1.0, 1), photons, seed, scratch)
        table = read_photons(os.path.join(scratch, "leave.photons.h5"))
    table = table[table["side"] == 0]
    place = table.index.to_numpy() >> 48 if len(places) > 1 else np.zeros(len(table), int)
    offset = table[["x", "y"]].to_numpy(float) - places[place]
    return np.hypot(offset[:, 0], offset[:, 1]), table["weight"].to_numpy(float), place, result


def bin_width(target: Target, seed: int) -> float:
    """Returns the width of bins [cm] such that BINS of them hold 99.9 % of the light of a pilot flight."""
    radius, weight, *_ = fly_packets(target, PILOT, seed + PILOT_SEED)
    order = np.argsort(radius, kind="stable")
    sums = np.cumsum(weight[order])
    last = float(radius[order][np.searchsorted(sums, INSIDE * sums[-1])]) if len(sums) else 0.0
    if not last > 0:
        raise errors.refuse("scene", target.shown, "a material from which light comes back beside the place where it came in")
    return float(f"{last / BINS:.3g}")


def _fly_planes(target: Target, width: float, bins: int, photons: int, seed: int) -> Flight:
    result = _fly(target, ["beam pencil" + LIGHT[target.light]], (width, bins + 1), photons, seed)
    area = 2 * np.pi * (np.arange(bins + 1) + 0.5) * width**2
    return Flight(photons, result["Rd_r"].values * area, result["Rd_r_se"].values * area, float(result["Rd_se"]), float(result["Rsp"]), result.attrs)


def _fly_tiles(target: Target, width: float, bins: int, photons: int, seed: int) -> Flight:
    """Flies a scene of tiles. Errors come from the spread between batches of places."""
    radius, weight, place, result = fly_packets(target, photons, seed)
    which = np.minimum(radius / width, bins).astype(int)
    parts = np.bincount(place % BATCHES * (bins + 1) + which, weights=weight, minlength=BATCHES * (bins + 1)).reshape(BATCHES, -1)
    spread = math.sqrt(BATCHES) / photons
    return Flight(photons, parts.sum(axis=0) / photons, parts.std(axis=0, ddof=1) * spread, float(parts.sum(axis=1).std(ddof=1)) * spread,
                  float(result["Rsp"]), result.attrs)


def fly_profile(target: Target, width: float, photons: int, error: Optional[float], seed: int, bins: int = BINS) -> Flight:
    """Flies `photons` packets. If an error is given, further rounds with other seeds follow until the noise is below it."""
    one = _fly_planes if target.period is None else _fly_tiles
    step = 1 if target.period is None else SIDE * SIDE  # every place gets equally many packets
    most = 2**48 if target.period is None else MOST_SAVED // step * step
    need, turn = photons, 0
    total: Optional[Flight] = None
    while need > 0:
        more = min(most, -(-need // step) * step)
        flown = one(target, width, bins, more, seed + turn * OTHER_SEED)
        total = flown if total is None else total.joined(flown)
        turn, need = turn + 1, need - more
        if need <= 0 and error is not None and total.noise() > error:
            need = math.ceil(1.05 * total.photons * ((total.noise() / error) ** 2 - 1))
    assert total is not None
    if not total.Rd > 0:
        raise errors.refuse("scene", target.shown, "a material from which light comes back")
    return total
