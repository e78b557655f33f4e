#!/usr/bin/env python3
"""Compares clustermcml, MMC and Mitsuba 3 on the same meshes and media: peers.py --mmc PATH [--quick] [--shared] [--only SHAPE,...] [--rounds N]
[--program PATH] [--out DIR]

There are eight shapes, each in four media, on one thread. This program without re-entry is compared with MMC, whose tetrahedra end at the surface,
by MMC's fastest tracer S and by B. This program with re-entry is compared with Mitsuba. All sample at random; this program and MMC play MCML's
roulette. Only flights count. All programs take turns, a run that others disturbed is repeated, and ratios are formed within a round. Beside the
speeds stand the absorbed shares, and their difference in units of its error. The error of a peer is taken from as many packets of this program.
`pip install mitsuba`; tetgen for MMC.

Leaves peers.md in DIR, in a quarter of an hour. --quick: one round of few photons, good for shares only. --shared: for a machine that others use.
Times are user seconds less those of a start, nothing is repeated, and Mitsuba takes part only if installed. bench/peers/README.md says more.

SPDX-License-Identifier: MIT
"""
import importlib.metadata
import importlib.util
import json
import math
import os
import shutil
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command
import mmc
import runs
import shapes
import slab
import tables

MEDIA = {medium: cases.data_lines(medium)[cases.ABOVE + 1] for medium in ("S2", "A", "S6a")}
MEDIA["skin"] = "1.4 0.3 120 0.8 0.5"
INSIDE = "1.5 1 50 0.5"  # medium of the ball
GRID = "1e4"  # triangles of the wrapped grids
LEVEL = "18"  # triangles of the level top above a body: MMC finds no packet in tetrahedra as wide as the slab
BALL, PARTS, DEPTH = 0.1, 4, 0.25  # radius, parts of an edge (320 triangles), depth [cm]
SHAPES = {
    "overhang": lambda path: shutil.copy(os.path.join(cases.ROOT, "meshes", "overhang.obj"), path),
    "cave": lambda path: cases.make_surface("cave", GRID, cases.AMPLITUDE, path),
    "mushrooms": lambda path: cases.make_surface("mushrooms", GRID, cases.AMPLITUDE, path),
    "ring": lambda path: shapes.write_handle(path, 1),
    "tunnel": lambda path: shapes.write_handle(path, -1),
    "tube": lambda path: shapes.write_handle(path, 1, 9),
    "ball": lambda path: shapes.write_ball(path, BALL, PARTS, -DEPTH),
    "skin": lambda path: shutil.copy(os.path.join(cases.ROOT, "meshes", "ridges.obj"), path),
}
TRACERS = ("S", "B")  # tracers of MMC: the fastest, and the faster of those that are right below overhangs
HALF_WIDTH = 30.0  # half the width of Mitsuba's slab [cm]
UNIT = 100  # units in a cm: Mitsuba moves rays off surfaces by some 1e-4 units
SECONDS = 0.4  # length of a run [s]; --shared runs are half as long; --quick makes only the pilots
FEW = 2000  # photons of a run that measures the start
BROKEN = 4  # standard errors of a difference from which a peer's result is called broken
HERE = os.path.dirname(os.path.abspath(__file__))


class Way:
    """One program with its options on one scene.

    fly(photons, seed) returns (photons per second, absorbed share, disturbed). start: user seconds of few photons; with it, a second is a user
    second of the program. own_clock: a second is counted by the fly function itself."""

    def __init__(self, name, fly, pilot, own_clock=False):
        self.name, self.fly_once, self.photons, self.own_clock, self.runs, self.start = name, fly, pilot, own_clock, [], None

    def fly(self, photons, seed):
        rate, absorbed, disturbed = self.fly_once(photons, seed)
        return (rate, absorbed, disturbed) if self.start is None else ((photons - FEW) / (runs.spent - self.start), absorbed, False)

    def find_start(self):
        if not self.own_clock:
            self.start = min((self.fly_once(FEW, seed), runs.spent)[1] for seed in (1, 2))

    def calibrate(self, seconds):
        """Sets the number of photons. On a shared machine, the pilot must be long beside the occasional time of a start."""
        self.photons = runs.two_digits(seconds * self.fly(self.photons // (10 if self.start is None else 1), 1)[0])

    def rates(self):
        return [rate for rate, _, _ in self.runs]

    def absorbed(self):
        return statistics.fmean(share for _, share, _ in self.runs)


class Scene:
    """A shape in a medium, in the formats of every program."""

    def __init__(self, shape, medium, work):
        self.shape, self.medium, self.body = shape, medium, shape == "ball"
        self.obj = os.path.join(work, shape + ".obj")
        if not os.path.exists(self.obj):
            SHAPES[shape](self.obj)
        self.stem = os.path.join(work, "slab-%s-%s" % (shape, medium))
        self.layer = [float(word) for word in MEDIA[medium].split()]
        self.path = os.path.join(work, "%s-%s.mci" % (shape, medium))
        lines, at = cases.data_lines(medium if medium in cases.SCENES else "S6a"), cases.ABOVE + 1
        lines[at:at + 1] = [MEDIA[medium], 'i "%s" %s' % (self.obj, INSIDE)] if self.body else ['m "%s"' % self.obj, MEDIA[medium]]
        with open(self.path, "w", encoding="utf-8") as stream:
            stream.write("\n".join(lines) + "\n")
        self.triangles = len(slab.read_obj(self.obj)[1])
        self.top = os.path.join(work, "level.obj") if self.body else self.obj
        if self.body and not os.path.exists(self.top):
            cases.make_surface("moved", LEVEL, "0", self.top)
        self.tetrahedra, self.ways, self.spread, self.lost = 0, {}, {}, 0

    def inside(self):
        """Returns (n, mua, mus, g) of the slab, and of the body if there is one."""
        return [self.layer[:4]] + [[float(word) for word in INSIDE.split()]] * self.body

    def write_mmc(self, program):
        mesh = slab.fill(self.top, self.layer[-1], self.stem, slab.read_obj(self.obj) if self.body else None)
        self.tetrahedra = len(mesh[1])
        slab.write_mmc(mesh, self.inside(), *mmc.entry(program, self.path), self.stem + ".json")

    def write_mitsuba(self):
        surfaces = [slab.shell(self.top, self.layer[-1], HALF_WIDTH)] + [slab.read_obj(self.obj)] * self.body
        found = []
        for k, surface in enumerate(surfaces):
            found.append({"file": "%s-%d.ply" % (self.stem, k), "n": [self.inside()[k][0], self.layer[0] if k else 1.0],
                          "media": [str(k), str(k - 1) if k else None]})
            slab.write_ply(surface, found[k]["file"], UNIT)
        with open(self.stem + "-mitsuba.json", "w", encoding="utf-8") as stream:
            json.dump({"unit": UNIT, "shapes": found, "media": {str(k): medium[1:] for k, medium in enumerate(self.inside())}}, stream)


def fly_ours(scene, program, options, key):
    """Returns a function that runs this program, and that stores the spread of a packet's absorbed share under `key`."""
    case = cases.Case(scene.shape, scene.medium, scene.shape, scene.path, options)

    def fly(photons, seed):
        record = runs.fly_alone(program, case, photons, seed)
        entered = 1 - record["Rsp"] if key == "mmc" else 1.0
        scene.spread[key] = record["A_se"] * math.sqrt(photons) / entered
        scene.lost += record["lost"]
        return record["photons_per_s"], record["A"] / entered, record["disturbed"]
    return fly


def fly_mitsuba(scene):
    def fly(photons, seed):
        line = [sys.executable, "-B", os.path.join(HERE, "mitsuba_slab.py"), scene.stem + "-mitsuba.json", str(photons), str(seed)]
        text, _, disturbed = runs.run_alone(line, os.path.dirname(scene.stem))
        record = json.loads(text)
        return photons / record["seconds"], record["absorbed"], disturbed
    return fly


def prepare(scene, program, their_mmc, mitsuba):
    scene.write_mmc(program)
    alike = [option for option in mmc.ALIKE if option != "--no-reentry"]
    ways = [Way("ours", fly_ours(scene, program, alike + ["--no-reentry"], "mmc"), 200000),
            *(Way(tracer, lambda photons, seed, tracer=tracer: mmc.fly_mmc(their_mmc, scene.stem, photons, seed, tracer), 40000)
              for tracer in TRACERS)]
    if mitsuba:
        scene.write_mitsuba()
        ways += [Way("ours, re-entry", fly_ours(scene, program, alike, "mitsuba"), 200000), Way("Mitsuba", fly_mitsuba(scene), 10000, True)]
    scene.ways = {way.name: way for way in ways}


def apart(scene, ours, theirs, key):
    """Returns the difference by which the peer's absorbed share is larger, in units of its error."""
    each = [sum(way.photons for _ in way.runs) for way in (ours, theirs)]
    return (theirs.absorbed() - ours.absorbed()) / (scene.spread[key] * math.sqrt(sum(1 / photons for photons in each)))


def ratio(ours, theirs):
    ratios = [a / b for a, b in zip(ours.rates(), theirs.rates())]
    return "%.2f (%.2f-%.2f)" % (statistics.median(ratios), min(ratios), max(ratios))


TITLES = ("shape", "medium", "triangles", "tetrahedra", "lost", "absorbed", "by S", "z", "by B", "z")
SPEEDS = ("photons/s", "over S", "over B")
MITSUBA_TITLES, MITSUBA_SPEEDS = ("with re-entry", "by Mitsuba", "z"), ("with re-entry", "over Mitsuba")


def pairs(scene):
    """Returns the pairs that are compared: (this program, (peers), key of the errors)."""
    beside = (("ours", TRACERS, "mmc"), ("ours, re-entry", ("Mitsuba",), "mitsuba"))
    return [pair for pair in beside if pair[0] in scene.ways]


def row(scene, quick):
    """Returns the cells of a scene. A quick run measures no speeds."""
    ways, shares, speeds = scene.ways, [], []
    for ours, peers, key in pairs(scene):
        shares.append("%.5f" % ways[ours].absorbed())
        speeds.append("%.3g" % statistics.median(ways[ours].rates()))
        for peer in peers:
            shares += ["%.5f" % ways[peer].absorbed(), "%+.1f" % apart(scene, ways[ours], ways[peer], key)]
            speeds.append(ratio(ways[ours], ways[peer]))
    return [scene.shape, scene.medium, scene.triangles, scene.tetrahedra, scene.lost, *shares, *([] if quick else speeds)]


def broken(scenes):
    """Yields sentences on the peers whose shares are wrong."""
    for scene in scenes:
        for ours, peers, key in pairs(scene):
            for peer in peers:
                z = apart(scene, scene.ways[ours], scene.ways[peer], key)
                if abs(z) > BROKEN:
                    yield "%s of %s in %s: %+.1f %% (%.0f errors)" % (
                        peer if peer == "Mitsuba" else "MMC's " + peer, scene.shape, scene.medium,
                        100 * (scene.ways[peer].absorbed() / scene.ways[ours].absorbed() - 1), abs(z))


def how(rounds, disturbed, quick, shared):
    """Returns a description of the measurement."""
    if quick:
        return "few photons, once: no speeds"
    text = "median (least-most) of %d rounds, one thread" % rounds
    return text + ("; user seconds, on a machine that others use" if shared else "; disturbed by others: %d of our runs, %d of theirs" % disturbed)


def report(program, their_mmc, scenes, rounds, quick, shared, mitsuba):
    disturbed = tuple(sum(run[2] for scene in scenes for name, way in scene.ways.items() if name.startswith("ours") == mine for run in way.runs)
                      for mine in (True, False))
    versions = mmc.version(their_mmc) + ("; Mitsuba %s" % importlib.metadata.version("mitsuba") if mitsuba else "")
    yield tables.measured(tables.machine(program, rounds)) + "; MMC %s; %s." % (versions, how(rounds, disturbed, quick, shared))
    yield ""
    titles, speeds = (TITLES, SPEEDS) if not mitsuba else (TITLES + MITSUBA_TITLES, SPEEDS + MITSUBA_SPEEDS)
    yield from tables.table(titles + (() if quick else speeds), [row(scene, quick) for scene in scenes])
    yield ""
    yield "More than %d errors apart: %s." % (BROKEN, ". ".join(broken(scenes)) or "none")


def main():
    parser = command.parser(__doc__, rounds=(5, 5))
    parser.add_argument("--mmc", type=command.built, required=True)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--shared", action="store_true")
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    mitsuba = bool(importlib.util.find_spec("mitsuba"))
    if not arguments.shared and not mitsuba:
        parser.error("mitsuba is missing: pip install mitsuba")
    if not shutil.which("tetgen"):
        parser.error("tetgen is missing")
    if arguments.quick or arguments.shared:
        runs.REPEATS = 1
    if arguments.quick:
        arguments.rounds = 1
    with tempfile.TemporaryDirectory() as work:
        program = shutil.copy(arguments.program, os.path.join(work, "clustermcml"))  # a copy, which nobody rebuilds meanwhile
        scenes = [Scene(shape, medium, work) for shape in command.only(arguments.only, SHAPES, parser) for medium in MEDIA]
        for scene in scenes:
            prepare(scene, program, arguments.mmc, mitsuba)
            for way in scene.ways.values():
                if arguments.shared:
                    way.find_start()
                if not arguments.quick:
                    way.calibrate(SECONDS / 2 if arguments.shared else SECONDS)
        for index in range(arguments.rounds):
            for seed, scene in list(enumerate(scenes, index * len(scenes) + 1))[::1 if index % 2 == 0 else -1]:
                for way in scene.ways.values():
                    way.runs.append(way.fly(way.photons, seed))
        lines = list(report(arguments.program, arguments.mmc, scenes, arguments.rounds, arguments.quick, arguments.shared, mitsuba))
    tables.keep(os.path.join(arguments.out, "peers-shared.md" if arguments.shared else "peers.md"), lines)


if __name__ == "__main__":
    main()
