"""Tests rough layers and bodies in a furnace: diffuse light from all sides, without absorption, so radiance over n^2 is the
same everywhere.

Shares of the beams: n^2 of their side, n0^2 above and nL^2 below. For any shape of the boundaries then:
- the share n0^2 / (n0^2 + nL^2) of the light leaves above, the rest below;
- light that leaves below obeys the cosine law, bin by bin of the angle;
- the mean path in a layer is 4 V n^2 / (S0 n0^2 + SL nL^2), with V over one period of its tile, S0 and SL the level areas of
  the beams. The mean number of interactions is the sum of mus times path over the layers. Its error is the spread of the
  runs.
- A pit in a plane, radial or with overhangs, counts in V. Its light comes from a square so much wider that the missing rest
  does not show. The same holds for a pit of the medium below.
- A body in a medium that goes on all around is lit evenly from everywhere, through disks of radius R that cover it, one for
  each of many directions: the mean path in each medium is V n^2 / (pi R^2 n0^2).
A wrong refraction, crossing or free path shows. A reflectance that is wrong by the same factor from both sides does not.
N = 40 runs of 1800 a scene; statistic: z from the spread of the runs (39 degrees of freedom), level 1e-4 over all.
usage: furnace.py [N]: N packets a run."""
import math
import os
import random
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

RUNS, PHOTONS, NA = 40, 1800, 6
CELLS, CELL = 8, 0.05
PERIOD = CELLS * CELL


def heights(amplitude):
    """Returns a period of heights whose mean is not 0, so that it counts in the thickness of the layers beside it."""
    return [[amplitude * (0.4 + math.sin(2.1 * x + 0.3 * y * y) * math.cos(1.3 * y)) for x in range(CELLS)] for y in range(CELLS)]


def write_tile(path, rows):
    with open(path, "w", encoding="ascii") as file:
        file.write(f"ncols {CELLS}\nnrows {CELLS}\nxllcorner 0\nyllcorner 0\ncellsize {CELL}\n")
        file.write("".join(" ".join(repr(h) for h in row) + "\n" for row in rows))


def mean_height(rows):
    """Returns the mean height over a period. Diagonals of cells alternate: half of the corners have eight triangles, the
    others four."""
    return statistics.fmean(h * (4 / 3 if (x + y) % 2 else 2 / 3) for y, row in enumerate(rows) for x, h in enumerate(row))


def furnace(verdict, name, layers, amplitudes, n_below=1.0, n_above=1.0):
    """Tests one furnace. layers: (n, mus, g, d); amplitudes: of the boundaries that are tiles."""
    with tempfile.TemporaryDirectory() as keep:
        surfaces, lift = {}, [0.0] * (len(layers) + 1)
        for b, amplitude in amplitudes.items():
            rows = heights(amplitude)
            write_tile(os.path.join(keep, f"{b}.asc"), rows)
            surfaces[b] = f'm "{b}.asc" tile=as-is units=cm'
            lift[b] = mean_height(rows)
        up, down = n_above**2 / (n_above**2 + n_below**2), n_below**2 / (n_above**2 + n_below**2)
        beam = f"beam rectangle {PERIOD} {PERIOD} light=lambertian"
        text = cml.repeated(RUNS, [f"{n} 0 {mus} {g} {d}" for n, mus, g, d in layers], photons=PHOTONS, bins=f"1 1 {NA}",
                            surfaces=surfaces, n_above=n_above, n_below=n_below,
                            extra=[f"{beam} share={up!r}", f"{beam} z=3 angle=180 share={down!r}"])
        records = cml.run(text, "--seed", 5, keep=keep)
        below = [cml.read_sections(record["output"])["Tt_a"] for record in records]
    for record in records:
        cml.check_balance(verdict, name, record)
    spread(verdict, f"{name}: above", [record["Rsp"] + record["Rd"] for record in records], up)
    da = math.pi / 2 / NA
    for i in range(NA):
        law = math.sin((i + 1) * da) ** 2 - math.sin(i * da) ** 2
        width = 2 * math.pi * math.sin((i + 0.5) * da) * da
        spread(verdict, f"{name}: below, angle {i}", [angles[i] * width for angles in below], down * law)
    law = sum(4 * n * n * mus * (d + lift[i] - lift[i + 1]) for i, (n, mus, _, d) in enumerate(layers))
    spread(verdict, f"{name}: interactions", [(record["steps"] - record["crossings"]) / PHOTONS for record in records],
           law / (n_above**2 + n_below**2))


# ---- one pit in a plane: rings, or a mesh with overhangs ----

PIT, DEEP = ((0.06, 0.0), (0.1, 0.04), (0.07, 0.07)), 0.07  # (half width, depth) of squares, in cm, and the depth of the pit
RADII = ((0.0, -0.07), (0.05, -0.07), (0.09, -0.04), (0.11, 0.0))  # (r, height) of the radial pit, cm


def write_pit(path, sign):
    """Writes a pit of squares joined by their sides, the last one closed; the border lies far outside."""
    rings = [(0.2, 0.0), *PIT]
    with open(path, "w", encoding="ascii") as file:
        for half, down in rings:
            file.write("".join(f"v {x * half} {y * half} {-sign * down}\n" for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1))))
        for k in range(len(rings) - 1):
            for i in range(4):
                a, b = 4 * k + i + 1, 4 * k + (i + 1) % 4 + 1
                file.write(f"f {a} {b} {b + 4}\nf {a} {b + 4} {a + 4}\n")
        last = 4 * len(rings) - 3
        file.write(f"f {last} {last + 1} {last + 2}\nf {last} {last + 2} {last + 3}\n")


def pit_volume(kind):
    if kind == "mesh":
        return sum((h1 - h0) * 4 / 3 * (a * a + a * b + b * b) for (a, h0), (b, h1) in zip(PIT, PIT[1:]))
    return sum(-math.pi * (r1 - r0) * (h0 * (2 * r0 + r1) + h1 * (r0 + 2 * r1)) / 3 for (r0, h0), (r1, h1) in zip(RADII, RADII[1:]))


def pit(verdict, kind, boundary, layer, n_below=1.0):
    """Tests a pit. On top the pit is of the medium above, at the bottom it is a hill of the medium below; in both cases its
    volume is missing in the layer. Light that enters beyond the square would have to fly three times the layer's thickness
    to the pit; scattering is so strong that it does not arrive."""
    n, mus, g, d = layer
    half, sign = 0.45, 1 if boundary == 0 else -1
    up, down = 1 / (1 + n_below**2), n_below**2 / (1 + n_below**2)
    beam = f"beam rectangle {2 * half} {2 * half} light=lambertian"
    with tempfile.TemporaryDirectory() as keep:
        write_pit(os.path.join(keep, "pit.obj"), sign)
        samples = " ".join(f"{sign * h} {r1 - r0}" for (r0, h), (r1, _) in zip(RADII, (*RADII[1:], (1.0, 0))))
        line = 'm "pit.obj"' if kind == "mesh" else f"b {len(RADII)} {samples}"
        text = cml.repeated(RUNS, [f"{n} 0 {mus} {g} {d}"], photons=PHOTONS, bins="1 1 1", surfaces={boundary: line}, n_below=n_below,
                            extra=[f"{beam} share={up!r}", f"{beam} z={d + 1e-4} angle=180 share={down!r}"])
        records = cml.run(text, "--seed", 10 + 2 * boundary + (kind == "mesh"), keep=keep)
    name = f"pit {kind} {boundary}"
    for record in records:
        cml.check_balance(verdict, name, record)
    spread(verdict, f"{name}: above", [record["Rsp"] + record["Rd"] for record in records], up)
    spread(verdict, f"{name}: interactions", [(record["steps"] - record["crossings"]) / PHOTONS for record in records],
           4 * n * n * mus * (d - pit_volume(kind) / (4 * half * half)) / (1 + n_below**2))


# ---- bodies ----

CLAMP = ((0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (3, 2), (3, 3), (0, 3))  # outline of a C, whose light leaves it and enters it again
CLAMP_CAPS = ((0, 1, 2, 3), (0, 3, 4, 7), (7, 4, 5, 6))


def write_clamp(path):
    with open(path, "w", encoding="ascii") as file:
        for z in (-1, 1):
            file.write("".join(f"v {(x - 1.5) * 0.03} {(y - 1.5) * 0.03} {z * 0.04}\n" for x, y in CLAMP))
        for lift in (1, 9):
            file.write("".join("f " + " ".join(str(i + lift) for i in cap) + "\n" for cap in CLAMP_CAPS))
        for i in range(8):
            k = (i + 1) % 8
            file.write(f"f {i + 1} {k + 1} {k + 9} {i + 9}\n")


def bodies(verdict):
    """Tests a sphere with a rod in it and, beside them, a clamp, in a clear layer 1 cm thick between media of the same index."""
    n0, radius, beams = 1.2, 0.19, 600
    ball, rod, clamp = 4 / 3 * math.pi * 0.08**3, math.pi * 0.04**2 * 0.08, 7 * 0.03**2 * 0.08
    lines = ["i sphere -0.1 0 0.5 0.08 1.3 0 15 0.5", "i cylinder -0.1 0 0.46 -0.1 0 0.54 0.04 1.6 0 60 0.8",
             'i "clamp.obj" 1.5 0 40 0.6 shift=0.09,0,-0.5 rotate=20']
    law = 15 * (ball - rod) * 1.3**2 + 60 * rod * 1.6**2 + 40 * clamp * 1.5**2
    draw = random.Random(8)
    with tempfile.TemporaryDirectory() as keep:
        write_clamp(os.path.join(keep, "clamp.obj"))
        text = ["1.0", str(RUNS)]
        for run in range(RUNS):
            lit = []
            for k in range(beams):  # directions evenly in cos, one in each of as many strips
                ca, p = 1 - 2 * (k + draw.random()) / beams, draw.uniform(0, 2 * math.pi)
                sa = math.sqrt(1 - ca * ca)
                x, y, z = -0.3 * sa * math.cos(p), -0.3 * sa * math.sin(p), 0.5 - 0.3 * ca
                lit.append(f"beam disk {radius} at={x!r},{y!r} z={z!r} angle={math.degrees(math.acos(ca))!r} azimuth={math.degrees(p)!r}")
            scene = cml.mci([f"{n0} 0 0 0 1\n" + "\n".join(lines)], name=f"run{run}.mco", photons=PHOTONS, bins="1 1 1", n_above=n0,
                            n_below=n0, extra=lit)
            text.append("\n".join(scene.split("\n")[2:]))
        records = cml.run("\n".join(text), "--seed", 7, keep=keep)
    for record in records:
        cml.check_balance(verdict, "bodies", record)
    spread(verdict, "bodies: interactions", [(record["steps"] - record["crossings"]) / PHOTONS for record in records],
           law / (math.pi * radius**2 * n0**2))


def spread(verdict, name, values, truth):
    verdict.z(name, statistics.fmean(values), statistics.stdev(values) / math.sqrt(len(values)), truth)


def main():
    global PHOTONS
    PHOTONS = int(sys.argv[1]) if len(sys.argv) > 1 else PHOTONS
    verdict = cml.Verdict("furnace")
    furnace(verdict, "planes", [(1.4, 30, 0.7, 0.1)], {})
    furnace(verdict, "rough top", [(1.4, 30, 0.7, 0.1)], {0: 0.05})
    furnace(verdict, "rough bottom", [(1.5, 20, 0.0, 0.15)], {1: 0.08})
    furnace(verdict, "all rough, on glass", [(1.3, 10, 0.8, 0.3), (1.5, 40, 0.5, 0.2)], {0: 0.06, 1: 0.05, 2: 0.09}, n_below=1.6)
    pit(verdict, "mesh", 0, (1.4, 40, 0.3, 0.1))
    pit(verdict, "mesh", 1, (1.3, 40, 0.0, 0.12), n_below=1.5)
    pit(verdict, "rings", 0, (1.5, 40, 0.2, 0.1))
    pit(verdict, "rings", 1, (1.4, 40, 0.0, 0.1))
    bodies(verdict)
    verdict.finish(limit=5.5)  # Student's distribution, 41 values at 1e-4 in all


if __name__ == "__main__":
    main()
