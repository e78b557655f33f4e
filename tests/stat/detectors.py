"""Tests the light that detectors see (P13), against packets that are traced one by one and compared with the definition of
every detector.

- Weights, mean path and interactions by medium, and mean largest depth, to the digits that a trace has. Scenes: a hill over
  two layers under a tilted wide beam, and under one at normal incidence on a plane, of which a part is split off. Detectors:
  disks, rings and rectangles at several levels and axes on both sides.
- Shapes that tile the plane: their sums are Rsp + Rd or Tt, in units of weight.
- Hundreds of detectors give the same numbers in lines of the scene, in the lines of a file, and one by one.
- Time gates of a detector, times exp(-x c t / n), summed, give its light in a flight with x more absorption in all layers.
- A camera that is focused on one of three points of light along a slope sees it in one pixel. It sees the others where their
  cones cross the level of focus, by geometry.
- Reciprocity, over a hill, furrows that go on for ever and a mesh with overhangs: light from one disk with the cosine law
  into another, divided by the area of the latter, is the same the other way round. An argument N sets the number of packets
  (`long.detectors`).
- Path and largest depth of light that flies straight down in a clear slab are known but for rounding, and so lie within 2.45
  errors.
- The errors of a detector and of a pixel cover the mean over other runs in 68 % of cases, also if split-off light enters.
Statistic: exact; z-scores; for the last one the share within one error."""
import concurrent.futures
import math
import os
import random
import re
import struct
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

PACKETS, UNIT, LIGHT = 300, 2.0**31, 0.0299792458  # UNIT: weight units per packet; LIGHT: cm/ps
HILL = {"layers": ["1.4 1 40 0.7 0.2", "1.5 0.5 20 0.5 0.3"], "surfaces": {0: "b 3  0.25 0.1  0.1 0.4  0 1"}, "n_below": 1.3}
SLAB = {"layers": ["1.4 1 40 0.7 0.2"]}
NUMBER = r"[-+0-9.e]+"


class Detector:
    """A detector as its line describes it; sees() follows the definition alone."""

    def __init__(self, shape, sizes, at=(0, 0), z=None, side="top", na=None, angle=0, azimuth=0, diffuse=False):
        self.shape, self.sizes, self.at, self.z, self.side = shape, sizes, at, z, side
        self.na, self.angle, self.azimuth, self.diffuse = na, angle, azimuth, diffuse

    def line(self, name):
        words = [f"detector {self.shape}", *map(repr, self.sizes), f"at={self.at[0]!r},{self.at[1]!r}", f"side={self.side}", f"name={name}"]
        words += [] if self.z is None else [f"z={self.z!r}"]
        words += [] if self.na is None else [f"na={self.na!r}", f"angle={self.angle!r}", f"azimuth={self.azimuth!r}"]
        return " ".join(words + (["diffuse"] if self.diffuse else []))

    def sees(self, scene, side, fresh, place, direction):
        if side != self.side or (fresh and self.diffuse) or direction[2] == 0:
            return False
        bottom = sum(float(layer.split()[4]) for layer in scene["layers"])
        z = self.z if self.z is not None else (0 if side == "top" else bottom)
        t = (z - place[2]) / direction[2]
        x, y = (place[i] + t * direction[i] - self.at[i] for i in range(2))
        if self.na is not None:
            tilt, turn = math.radians(self.angle), math.radians(self.azimuth)
            axis = (math.sin(tilt) * math.cos(turn), math.sin(tilt) * math.sin(turn), math.cos(tilt) * (-1 if side == "top" else 1))
            cosine = sum(a * b for a, b in zip(axis, direction))
            n = 1.0 if side == "top" else scene.get("n_below", 1.0)
            if cosine < 0 or (self.na < n and math.sqrt(max(0, 1 - cosine**2)) > self.na / n):
                return False
        if self.shape == "rectangle":
            return abs(x) <= self.sizes[0] / 2 and abs(y) <= self.sizes[1] / 2
        radii = [0, *self.sizes][-2:]
        return radii[0] <= math.hypot(x, y) < radii[1]


def detectors(count, dice):
    """Returns random detectors, large enough to see some of few packets."""
    found = []
    for _ in range(count):
        shape = dice.choice(["disk", "ring", "rectangle"])
        sizes = {"disk": [dice.uniform(0.2, 1)], "ring": [dice.uniform(0, 0.3), dice.uniform(0.4, 1)],
                 "rectangle": [dice.uniform(0.3, 2), dice.uniform(0.3, 2)]}[shape]
        found.append(Detector(shape, [round(size, 3) for size in sizes], (round(dice.uniform(-0.4, 0.4), 3), round(dice.uniform(-0.4, 0.4), 3)),
                              dice.choice([None, -0.3, -0.1, 0.05, 0.7]), dice.choice(["top", "top", "bottom"]),
                              dice.choice([None, 0.4, 0.9, 1.3]), dice.choice([0, 20, 65]), dice.choice([0, 130, -40]), dice.random() < 0.3))
    return found


class Packet:
    """A packet as `trace` prints it: its fate, its end, the light split off at its launch, and its path by medium."""

    def __init__(self, path, index, engine, media):
        done = subprocess.run([cml.PROGRAM, "trace", path, str(index), "--engine", engine], capture_output=True, text=True, check=True).stdout
        rows = [line.split() for line in done.splitlines() if re.match(r" *\d+  ", line)]
        events = [(row[1], int(row[2]), [float(word) for word in row[3:]]) for row in rows]
        self.told = {name: float(weight) for name, weight in re.findall(r"^# seen by (\w+), (\S+) of a packet$", done, re.M)}
        self.fate = re.search(r"^# (\w+)", done.splitlines()[-1])[1]
        self.start, self.end = events[0][2], events[-1][2]
        self.length, self.interactions, self.momentum, self.deepest = [0.0] * media, [0] * media, [0.0] * media, -math.inf
        counts = events[0][1] > 0
        for (what, medium, place), before in zip(events[1:], events):
            if counts:
                self.length[before[1]] += math.dist(place[:3], before[2][:3])
                if what == "interact":
                    self.interactions[medium] += 1
                    self.momentum[medium] += math.dist(place[3:6], before[2][3:6]) ** 2 / 2
            if counts or what in ("reflect", "transmit"):
                self.deepest = max(self.deepest, place[2])
            counts = counts or what in ("reflect", "transmit")
        self.deepest = max(self.deepest, self.start[2]) if events[0][1] > 0 else self.deepest

    def seen(self, scene, detector):
        """Returns what the detector sees of the packet: a list of [weight, path by medium, interactions, momentum transfer,
        largest depth]."""
        parts = []
        if self.start[6] < 1 and detector.sees(scene, "top", True, self.start[:2] + [0], (0, 0, -1)):
            parts.append((1 - self.start[6], *[[0] * len(self.length)] * 3, 0))
        if self.fate in ("reflected", "transmitted", "specular") and \
                detector.sees(scene, "bottom" if self.fate == "transmitted" else "top", self.fate == "specular", self.end[:3], self.end[3:6]):
            parts.append((self.end[6], self.length, self.interactions, self.momentum, self.deepest))
        return parts


def brute_force(verdict, name, scene, beam, engine, dice):
    found, media = detectors(40, dice), len(scene["layers"]) + 2
    with tempfile.TemporaryDirectory() as folder:
        text = cml.mci(scene["layers"], photons=PACKETS, surfaces=scene.get("surfaces"), n_below=scene.get("n_below", 1.0),
                       extra=[beam, *(d.line(f"d{k}") for k, d in enumerate(found))])
        record = cml.run(text, "--engine", engine, keep=folder)[0]
        cml.check_balance(verdict, name, record)
        sections = cml.read_sections(record["output"])
        path = os.path.join(folder, "scene.mci")
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            packets = list(pool.map(lambda i: Packet(path, i, engine, media), range(PACKETS)))
    for k, detector in enumerate(found):
        parts = [part for packet in packets for part in packet.seen(scene, detector)]
        weight, what = sum(part[0] for part in parts), f"{name}, {detector.line('d')}"
        told = sum(packet.told.get(f"d{k}", 0) for packet in packets)
        verdict.check(what, abs(told - weight) < 1e-6, f"traces tell of {told}, not {weight}")
        verdict.check(what, abs(record[f"detector_d{k}"] - weight / PACKETS) < 2e-9, f"{record[f'detector_d{k}']}, not {weight / PACKETS}")
        means = [record[f"detector_d{k}_deepest"], *sections[f"detector_d{k}_path"], *sections[f"detector_d{k}_interactions"], *sections[f"detector_d{k}_momentum"]]
        if not parts:
            verdict.check(what, means[0] is None and all(math.isnan(mean) for mean in means[1:]), f"sees nothing, of {means}")
            continue
        expected = [sum(part[0] * value for part, value in zip(parts, column)) / weight
                    for column in zip(*([part[4], *part[1], *part[2], *part[3]] for part in parts))]
        for mean, value in zip(means, expected):
            verdict.check(what, abs(mean - value) < 1e-5 * abs(value) + 2e-6, f"means {means}, not {expected}")
    verdict.check(name, sum(record[f"detector_d{k}"] > 0 for k in range(len(found))) > 20, "few detectors see anything")


def tiles(verdict):
    """Tests rings, quarters of the plane, and strips: on both sides of a hill under a disk, and over a slab that splits light
    off."""
    for scene in (HILL, SLAB):
        lines, parts = [], {}
        for side in ("top", "bottom"):
            rings = [f"detector ring {a} {b} name={side}_r{a} side={side}"
                     for a, b in ((0, 1), (1, 3), (3, 1000000))]
            quarters = [f"detector rectangle 1e6 1e6 at={x},{y} side={side} name={side}_q{i}"
                        for i, (x, y) in enumerate(((-5e5, -5e5), (5e5, -5e5), (-5e5, 5e5), (5e5, 5e5)))]
            strips = [f"detector rectangle {0.1 if -20 < i < 20 else 1e6} 1e6 at={i * 0.1 if -20 < i < 20 else math.copysign(5e5 + 1.95, i)!r},0"
                      f" side={side} name={side}_s{i + 20}" for i in range(-20, 21)]
            lines += rings + quarters + strips
            for key in "rqs":
                parts[side, key] = [line for line in rings + quarters + strips if f"name={side}_{key}" in line]
        text = cml.mci(scene["layers"], photons=20000, surfaces=scene.get("surfaces"), n_below=scene.get("n_below", 1.0),
                       extra=["beam disk 0.7", *lines])
        record = cml.run(text)[0]
        units = record["photons"] * UNIT
        totals = {"top": round((record["Rsp"] + record["Rd"]) * units), "bottom": round(record["Tt"] * units)}
        for (side, key), group in parts.items():
            names = [re.search(r"name=(\w+)", line)[1] for line in group]
            verdict.check(f"tiles {key} {side}", sum(round(record[f"detector_{name}"] * units) for name in names) == totals[side],
                          f"do not sum to {totals[side]}")


def hundreds(verdict):
    """Tests a grid of 20 x 20 disks against single ones: a detector's light does not depend on its neighbours, nor on the
    file that describes it."""
    disks = [f"detector disk 0.04 at={0.1 * i - 1!r},{0.1 * k - 1!r} na=0.5 name=g{i}_{k}" for i in range(20) for k in range(20)]
    chosen = random.Random(3).sample(range(400), 8)
    scene = {"photons": 20000, "surfaces": HILL["surfaces"], "n_below": 1.3}
    many = cml.run(cml.mci(HILL["layers"], extra=disks, **scene))[0]
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "grid.txt"), "w", encoding="utf-8") as file:
            file.writelines(line[len("detector "):] + "\n" for line in disks)
        table = cml.run(cml.mci(HILL["layers"], extra=['detector table "grid.txt"'], **scene), keep=folder)[0]
    seen = [{key: record[key] for key in record if key.startswith("detector_")} for record in (many, table)]
    verdict.check("hundreds", len(seen[0]) >= 800 and seen[0] == seen[1], "a table differs")
    for k in chosen:
        alone = cml.run(cml.mci(HILL["layers"], extra=[disks[k]], **scene))[0]
        name = "detector_" + re.search(r"name=(\w+)", disks[k])[1]
        verdict.check(f"hundreds, {name}", many[name] == alone[name] and many[name + "_se"] == alone[name + "_se"], "differs alone")


def laplace(verdict):
    """Tests gates against more absorption. Both media have the same index, and nothing is outside: gates of 0.1 ps, 280 of
    them for a cm of path."""
    n, width, lines = 1.4, 0.1, ["detector disk 0.2 na=0.8 name=near", "detector ring 0.2 0.6 name=far"]
    layers = lambda x: [f"{n} {0.5 + x} 40 0.7 0.2", f"{n} {0.2 + x} 60 0.8 0.4"]  # noqa: E731
    with tempfile.TemporaryDirectory() as folder:
        cml.run(cml.mci(layers(0), photons=100000, extra=[f"time {2000 * width} 2000", *lines]), keep=folder)
        sections = cml.read_sections(os.path.join(folder, "out.mco"))
    for x in (0.3, 1, 3):
        darker = cml.run(cml.mci(layers(x), photons=100000, extra=lines), "--seed", 2)[0]
        kernel = [math.exp(-x * LIGHT * (i + 0.5) * width / n) * width for i in range(2000)]
        for name in ("near", "far"):
            value = sum(map(float.__mul__, kernel, sections[f"detector_{name}_t"]))
            error = math.hypot(*map(float.__mul__, kernel, sections[f"se_detector_{name}_t"]))
            verdict.z(f"{name}, gates with {x} 1/cm more", value, error, darker[f"detector_{name}"], darker[f"detector_{name}_se"])


def focus(verdict):
    """Tests a camera with points of light that shine upwards by the cosine law. A cone of half angle t about an axis at 45
    degrees has the share sin^2 t cos 45."""
    points, na, pixel, photons = [(-0.3, -0.31, -0.2), (0.0, 0.01, -0.4), (0.3, 0.33, -0.6)], 0.2, 0.02, 60000
    lines = [f"beam pencil at={x},{y} z={z} angle=180 light=lambertian" for x, y, z in points]
    lines += [f"detector map 100 60 {pixel} {pixel} at=0.01,0 z={z} na={na} angle=45 name=c{k}" for k, (_, _, z) in enumerate(points)]
    with tempfile.TemporaryDirectory() as folder:
        record = cml.run(cml.mci(["1 100 0 0 0.1"], photons=photons, extra=lines), keep=folder)[0]
        share = na**2 * math.cos(math.pi / 4)
        for k, (_, _, level) in enumerate(points):
            verdict.z(f"camera on {level}", record[f"detector_c{k}"], math.sqrt(share * (1 - share) / photons), share)
            seen, left = picture(os.path.join(folder, f"out.detector_c{k}.vti"), pixel), record[f"detector_c{k}"]
            for x, y, z in points:
                low, high = (x + (z - level) * math.tan(math.pi / 4 + s * math.asin(na)) for s in ((-1, 1) if z >= level else (1, -1)))
                reach = abs(z - level) * na / math.cos(math.pi / 4 + math.asin(na)) + pixel
                inside = {place: w for place, w in seen.items() if low - pixel / 2 <= place[0] <= high + pixel / 2 and abs(place[1] - y) <= reach}
                expected = 1 if z == level else abs(z - level) / pixel  # width of the spot in pixels
                verdict.check(f"camera on {level}, point {z}", len(inside) == 1 if expected == 1 else len(inside) > expected, f"{len(inside)} pixels")
                verdict.z(f"camera on {level}, point {z}", sum(inside.values()), math.sqrt(share / 3 / photons), share / 3)
                left -= sum(inside.values())
            verdict.check(f"camera on {level}", abs(left) < 1e-6, f"{left} elsewhere")


def picture(path, pixel):
    """Returns {(x, y): weight} of the pixels of a detector's .vti that have seen light, in scene coordinates."""
    with open(path, "rb") as file:
        data = file.read()
    begin = data.index(b"_", data.index(b"<AppendedData")) + 1
    values = struct.unpack_from(f"<{struct.unpack_from('<Q', data, begin)[0] // 4}f", data, begin + 8)
    nx = int(re.search(rb'WholeExtent="0 (\d+)', data)[1])
    x0, y0 = map(float, re.search(rb'Origin="(\S+) (\S+)', data).groups())
    return {(x0 + (i % nx + 0.5) * pixel, y0 + (i // nx + 0.5) * pixel): value * pixel**2 for i, value in enumerate(values) if value > 0}


def reciprocity(verdict, photons):
    top, radii, places = os.path.join(os.path.dirname(cml.SAMPLES), "meshes"), (0.2, 0.12), ("-0.15,0.05", "0.15,-0.1")
    for name, surface in (("hill", "b 3  0.25 0.1  0.1 0.4  0 1"), ("furrows", f'm "{top}/furrows.gsf" tile'), ("overhang", f'm "{top}/overhang.obj"')):
        ways = []
        for here, there in ((0, 1), (1, 0)):
            lines = [f"beam disk {radii[here]} at={places[here]} light=lambertian", f"detector disk {radii[there]} at={places[there]} name=it"]
            record = cml.run(cml.mci(["1.4 0.3 40 0.7 0.3"], n_below=1.4, photons=photons, surfaces={0: surface}, extra=lines), "--seed", 5 + here)[0]
            ways += [record["detector_it"] / radii[there] ** 2, record["detector_it_se"] / radii[there] ** 2]
        verdict.z(f"{name}, there and back", *ways)


def coverage(verdict):
    """Tests errors of a detector ring by ring. The slab splits off 0.028 of every packet into the first ring."""
    runs, edges = 60, [0, 0.05, 0.1, 0.2, 0.4]
    lines = [f"detector ring {a} {b}" for a, b in zip(edges, edges[1:])] + ["detector disk 1 na=0.3", "detector rectangle 0.5 0.5 side=bottom"]
    records = cml.run(cml.repeated(runs, SLAB["layers"], photons=6400, extra=lines))
    within = tried = 0
    for k in range(1, len(lines) + 1):
        for key in (f"detector_{k}", f"detector_{k}_deepest")[:1 if k == len(lines) else 2]:  # all light below has the same depth
            values = [record[key] for record in records]
            for value, record in zip(values, records):
                others = (sum(values) - value) / (runs - 1)
                within += abs(value - others) < record[key + "_se"] * math.sqrt(1 + 1 / (runs - 1))
                tried += 1
    verdict.check("errors", abs(within / tried - 0.683) < 0.05, f"{within} of {tried} within one error")
    print(f"errors of detectors: {within / tried:.3f} of {tried} within one")
def rounding(verdict, dice):
    """Tests light straight down from the middle of clear slabs: the path is half the thickness and the largest depth all of
    it, but for rounding. Rounding to a spacing is off by at most half of it, which is 1.73 times the standard deviation of
    that error; rounding to two spacings by at most 2.45 times."""
    for d in [0.05, *(dice.uniform(0.01, 1) for _ in range(19))]:
        with tempfile.TemporaryDirectory() as folder:
            text = cml.mci([f"1.0 0 0 0 {d!r}"], photons=256, extra=[f"beam pencil z={d / 2!r}", "detector disk 1 side=bottom name=it"])
            sections = cml.read_sections(cml.run(text, keep=folder)[0]["output"])
        for key, i, truth in (("detector_it_path", 1, d / 2), ("detector_it_deepest", 0, d)):
            value, error = sections[key][i], sections[f"se_{key}"][i]
            verdict.check(f"{d} cm: {key}", 0 < error < 1e-7 and abs(value - truth) <= 2.45 * error, f"{value} +- {error}, not {truth}")


def main():
    verdict, dice = cml.Verdict("detectors"), random.Random(7)
    reciprocity(verdict, int(sys.argv[1]) if len(sys.argv) > 1 else 50000)
    if len(sys.argv) > 1:
        verdict.finish()
    brute_force(verdict, "hill", HILL, "beam disk 0.5 angle=20 azimuth=30", "reference", dice)
    brute_force(verdict, "slab", SLAB, "beam disk 0.5", "cpu", dice)
    tiles(verdict)
    hundreds(verdict)
    laplace(verdict)
    focus(verdict)
    coverage(verdict)
    rounding(verdict, dice)
    verdict.finish()


main()
