"""Tests the places and directions in which packets of every beam start, and totals under spread light.

- Place and direction: matched clear layers, so that packets leave as they start. The light that leaves in each ring or angle
  is compared with the quantiles of the shape or the light on a grid of 500 by 500. Both samplings are tested; the lattice
  spreads more evenly than the binomial error says, so it may only come closer.
- Adding-doubling (`exact`) under `lambertian`, `na:` and tables, and several beams at once. `exact` itself is compared with
  the integral of exp(-mua d / cos) for absorbing matched layers, to 1e-5.
- Isotropic light in an absorber ends as exp(-mut r) / (4 pi r^2). In a scatterer the mean square distance of interaction n
  from the source is (2 / mut^2) (n / (1 - g) - g (1 - g^n) / (1 - g)^2); absorbed weight is the sum over n with (1 - a) a^(n
  - 1).
- Starts across a mesh body: its absorption along straight ways, by the planes of its facets.
- Shares: numbers of packets by largest remainder, to the last one. Engines: the same packets.
- Reciprocity of a rough plate between equal media: as much `lambertian` light goes down through it as comes up when the light
  shines from below.
N = 5e4 a case; statistic: z, level 1e-4 over all.
usage: sources.py [GROUP N]: one of the groups, with N packets a case, and grids of 1000 by 1000, which serve 1e6 at most."""
import json
import math
import os
import struct
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

PHOTONS, GRID = 50000, 1000 if sys.argv[1:] else 500
DR, NR, NA = 0.02, 20, 18
TABLE = ((0, 1.0), (10, 3.0), (25, 0.5), (40, 2.0), (60, 0.0))
PIXELS = ((0, 1, 3, 0), (2, 0, 0, 1), (0, 0, 5, 0))  # the first row is at the largest y


def gsf(path):
    """Writes PIXELS as a .gsf, 0.4 by 0.15 cm."""
    header = "Gwyddion Simple Field 1.0\nXRes = 4\nYRes = 3\nXReal = 4\nYReal = 1.5\nXYUnits = mm\n".encode()
    with open(path, "wb") as file:
        file.write(header + b"\0" * (4 - len(header) % 4))
        file.write(b"".join(struct.pack("<4f", *row) for row in PIXELS))


def table(path):
    with open(path, "w", encoding="utf-8") as file:
        file.write("# degrees, intensity\n" + "".join(f"{t} {i}\n" for t, i in TABLE))


def fly(text, *options, files=()):
    with tempfile.TemporaryDirectory() as keep:
        for make, name in files:
            make(os.path.join(keep, name))
        record = cml.run(text, *options, keep=keep)[0]
        return record, cml.read_sections(record["output"])


# ---- quantiles: points of a shape along its own axes, angles of a light to its axis ----

def ring(u, v):
    r = math.sqrt(0.01 + u * (0.04 - 0.01))
    return r * math.cos(2 * math.pi * v), r * math.sin(2 * math.pi * v)


def rectangle(u, v):
    return 0.3 * (u - 0.5), 0.1 * (v - 0.5)


def image(u, v):
    rows = [sum(row) for row in PIXELS]
    row, down = part(rows, u)
    column, along = part(PIXELS[row], v)
    return 0.1 * (column + along - 2), 0.05 * (1.5 - row - down)


def part(weights, u):
    left = u * sum(weights)
    for k, weight in enumerate(weights):
        if left < weight:
            return k, left / weight
        left -= weight
    raise ValueError(u)


def table_angles(count=20000):
    """Returns quantiles of TABLE's angle, from sums over a fine grid."""
    sums, angles, total = [0.0], [0.0], 0.0
    for (t0, i0), (t1, i1) in zip(TABLE, TABLE[1:]):
        for k in range(count):
            t = math.radians(t0 + (t1 - t0) * (k + 0.5) / count)
            total += (i0 + (i1 - i0) * (k + 0.5) / count) * math.sin(t) * (t1 - t0)
            sums.append(total)
            angles.append(math.radians(t0 + (t1 - t0) * (k + 1) / count))
    quantiles, at = [], 0
    for k in range(GRID):
        while sums[at + 1] < (k + 0.5) / GRID * total:
            at += 1
        quantiles.append(angles[at])
    return quantiles


def cone(sine):
    widest = 1 - math.sqrt(1 - sine * sine)
    return [math.acos(1 - widest * (k + 0.5) / GRID) for k in range(GRID)]


LAMBERTIAN = [math.acos(math.sqrt((k + 0.5) / GRID)) for k in range(GRID)]
SPHERE = [math.acos(1 - 2 * (k + 0.5) / GRID) for k in range(GRID)]


def expected_rings(shape, at, angle, azimuth):
    """Returns shares in rings about the z axis, of packets that go straight through z = 0. Along the axis's azimuth the shape
    is longer by 1 / cos."""
    shares = [0.0] * NR
    c, s, longer = math.cos(math.radians(azimuth)), math.sin(math.radians(azimuth)), 1 / math.cos(math.radians(angle))
    for i in range(GRID):
        for k in range(GRID):
            x, y = shape((i + 0.5) / GRID, (k + 0.5) / GRID)
            r = math.hypot(at[0] + longer * x * c - y * s, at[1] + longer * x * s + y * c)
            shares[min(int(r / DR), NR - 1)] += 1 / GRID**2
    return shares


def expected_angles(quantiles, angle):
    """Returns shares in bins of the angle to the vertical, up and down."""
    down, up = [0.0] * NA, [0.0] * NA
    ca, sa = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    turns = [math.cos(2 * math.pi * (k + 0.5) / GRID) for k in range(GRID)] if angle else [1.0]
    for t in quantiles:
        for turn in turns:
            z = ca * math.cos(t) - sa * math.sin(t) * turn
            side = down if z > 0 else up
            side[min(int(math.acos(min(1, abs(z))) / (math.pi / 2 / NA)), NA - 1)] += 1 / len(quantiles) / len(turns)
    return down, up


def binomial(verdict, name, found, shares):
    for i, (value, share) in enumerate(zip(found, shares, strict=True)):
        verdict.z(f"{name} {i}", value, math.sqrt((share * (1 - share) + 1 / PHOTONS) / PHOTONS), share)


def weights(record, sections, key):
    """Returns shares of packets in rings or angles."""
    if key.endswith("_r"):
        return [value * 2 * math.pi * (i + 0.5) * DR * DR for i, value in enumerate(sections[key])]
    step = math.pi / 2 / NA
    return [value * 2 * math.pi * math.sin((i + 0.5) * step) * step for i, value in enumerate(sections[key])]


def scene(beam, n=1.0, d=1e-4):
    return cml.mci([f"{n} 0 0 0 {d}"], photons=PHOTONS, grid=f"1 {DR}", bins=f"1 {NR} {NA}", n_above=n, n_below=n, extra=[beam])


def places(verdict):
    cases = [("ring", "ring 0.1 0.2", ring), ("rectangle", "rectangle 0.3 0.1", rectangle), ("image", 'image "p.gsf"', image)]
    for name, shape, quantile in cases:
        for at, angle, azimuth, z in (((0, 0), 0, 0, 0), ((0.1, 0.06), 50, 30, 0), ((-0.1, 0.06), 30, 120, -0.3)):
            moved = math.tan(math.radians(angle)) * z  # horizontal shift between the depth z, where the light starts, and z = 0, where it must arrive at `at`
            start = [at[0] + moved * math.cos(math.radians(azimuth)), at[1] + moved * math.sin(math.radians(azimuth))]
            level = f"z={z}" if z else ""
            beam = f"beam {shape} at={start[0]:.9f},{start[1]:.9f} angle={angle} azimuth={azimuth} {level}"
            shares = expected_rings(quantile, at, angle, azimuth)
            for sampling in ("random", "lattice"):
                record, sections = fly(scene(beam), "--sampling", sampling, "--seed", 9, files=[(gsf, "p.gsf")])
                cml.check_balance(verdict, name, record)
                binomial(verdict, f"{name} {angle} {sampling} ring", weights(record, sections, "Tt_r"), shares)


def directions(verdict):
    cases = [("lambertian", "light=lambertian", LAMBERTIAN, 0, 1.0), ("na", "light=na:0.6", cone(0.6), 0, 1.0),
             ("na slanted", "light=na:0.4 angle=40", cone(0.4), 40, 1.0), ("table", 'light="t.txt"', table_angles(), 0, 1.0),
             ("na inside", "light=na:0.7 z=0.00005 angle=110", cone(0.5), 110, 1.4),
             ("lambertian inside", "light=lambertian z=0.00005 angle=60", LAMBERTIAN, 60, 1.4),
             ("isotropic", "light=isotropic z=0.00005 angle=20", SPHERE, 20, 1.2)]
    for name, light, quantiles, angle, n in cases:
        down, up = expected_angles(quantiles, angle)
        for sampling in ("random", "lattice"):
            record, sections = fly(scene("beam pencil " + light, n), "--sampling", sampling, "--seed", 5, files=[(table, "t.txt")])
            cml.check_balance(verdict, name, record)
            binomial(verdict, f"{name} {sampling} down", weights(record, sections, "Tt_a"), down)
            binomial(verdict, f"{name} {sampling} up", weights(record, sections, "Rd_a"), up)


# ---- totals ----

STACKS = [["1.4 1 20 0.8 0.1"], ["1.0 2 10 0.5 0.2"], ["1.5 0.1 3 0.8 0.2", "1.33 0.5 1 -0.4 0.3"],
          ["1.5 0 0 0 0.1", "1.37 0.5 20 0.8 0.2"], ["1.6 3 0 0 0.1"]]
LIGHTS = [["beam disk 0.1 light=lambertian"], ["beam pencil light=na:0.9"], ["beam pencil light=na:0.3 angle=55"],
          ['beam disk 0.2 light="t.txt"'],
          ["beam pencil", "beam disk 0.1 light=lambertian share=2", "beam pencil angle=30 share=1.5", "beam pencil light=na:0.5"]]


def exact(text):
    with tempfile.TemporaryDirectory() as scratch:
        table(os.path.join(scratch, "t.txt"))
        path = os.path.join(scratch, "scene.mci")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return json.loads(subprocess.run([cml.PROGRAM, "exact", path, "--json"], capture_output=True, text=True, check=True).stdout)


def slabs(verdict):
    for i, layers in enumerate(STACKS):
        for k, beams in enumerate(LIGHTS):
            if (i + k) % 5 == 4:  # twenty of the combinations
                continue
            text = cml.mci(layers, photons=PHOTONS, extra=beams)
            record, _ = fly(text, "--seed", 77 + 5 * i + k, "--ignore-absorption", files=[(table, "t.txt")])
            expected = exact(text)
            cml.check_balance(verdict, f"slab {i} {k}", record)
            for key in ("Rsp", "Rd", "A", "Tt"):
                verdict.z(f"slab {i} light {k} {key}", record[key], cml.total_error(record, key, expected[key]) or 1e-9,
                          expected[key], expected[key + "_error"])


def absorbers(verdict):
    """Tests light that only goes straight: the quadrature takes quantiles, or the widest angle in steps."""
    for light, quantiles in (("light=lambertian", LAMBERTIAN), ("light=na:0.9", cone(0.9)), ('light="t.txt"', table_angles())):
        for mua in (0.5, 5):
            got = exact(cml.mci([f"1.0 {mua} 0 0 0.2"], extra=["beam pencil " + light]))["Tt"]
            truth = sum(math.exp(-mua * 0.2 / math.cos(t)) for t in quantiles) / len(quantiles)
            verdict.check(f"absorber {light} {mua}", abs(got - truth) < 1e-5, f"{got} and {truth}")


def point_source(verdict):
    """Tests A_z of light's first flight, and the mean square distance of absorption."""
    mut, nz, dz = 5.0, 120, 0.05
    text = cml.mci([f"1.3 {mut} 0 0 6"], photons=PHOTONS, grid=f"{dz} 0.05", bins=f"{nz} 1 1", n_above=1.3, n_below=1.3,
                   extra=["beam pencil light=isotropic z=3"])
    record, sections = fly(text, "--sampling", "random", "--seed", 3)
    cml.check_balance(verdict, "point", record)
    shares = [0.0] * nz
    for i in range(4 * GRID):
        s = -math.log((i + 0.5) / 4 / GRID) / mut
        for k in range(GRID // 2):
            shares[min(max(int((3 + s * (1 - 2 * (k + 0.5) / (GRID // 2))) / dz), 0), nz - 1)] += 0.5 / GRID**2
    binomial(verdict, "first flight", [value * dz for value in sections["A_z"]], shares)
    a, g, mut = 0.8, 0.6, 20.0
    text = cml.mci([f"1.3 {(1 - a) * mut} {a * mut} {g} 6"], photons=20000, grid="0.02 0.02", bins="300 150 1", n_above=1.3,
                   n_below=1.3, extra=["beam pencil light=isotropic z=3"])
    squares = []
    for seed in range(12):
        record, sections = fly(text, "--seed", seed)
        z2 = sum(v * 0.02 * ((0.02 * (i + 0.5) - 3) ** 2) for i, v in enumerate(sections["A_z"])) / record["A"]
        squares.append(3 * (z2 - 0.02**2 / 12))  # every direction is alike; Sheppard's correction for bins
    truth = sum((1 - a) * a ** (n - 1) * 2 / mut**2 * (n / (1 - g) - g * (1 - g**n) / (1 - g) ** 2) for n in range(1, 400))
    mean = sum(squares) / len(squares)
    error = math.sqrt(sum((x - mean) ** 2 for x in squares) / (len(squares) - 1) / len(squares))
    verdict.z("mean square distance", mean, error, truth, 0.3 * error)  # 11 degrees of freedom


def shares(verdict):
    """Tests three beams that each end in a place of their own, so their numbers of packets show. Also tests that split-off
    light belongs to its own beam."""
    up, down, above = "beam pencil z=0.05 angle=180", "beam pencil z=0.05 share=2", "beam pencil z=-1 angle=180 share=3"
    text = cml.mci(["1.0 0 0 0 0.1"], photons=100003, extra=[up, down, above])
    record, _ = fly(text, "--seed", 2)
    cml.check_balance(verdict, "shares", record)
    for key, number in (("Rd", 16667), ("Tt", 33334), ("Rsp", 50002)):
        verdict.check(f"shares {key}", round(record[key] * 100003, 6) == number, f"{record[key] * 100003} of {number}")
    record, _ = fly(cml.mci(["1.5 9 0 0 1"], photons=1000, extra=["beam pencil", "beam pencil z=0.1 share=3"]), "--seed", 2)
    cml.check_balance(verdict, "split off", record)
    verdict.check("split off", abs(record["Rsp"] - 0.04 * 0.25) < 1e-9, f"Rsp {record['Rsp']}")


def reciprocity(verdict):
    """Tests a tile of 8 by 8 heights, lit over one period from above and from below."""
    for height, layer in ((0.02, "1.4 0.5 30 0.7 0.1"), (0.05, "1.5 0 10 0.3 0.15"), (0.08, "1.3 1 5 0.8 0.2")):
        heights = [[height * math.sin(2.1 * x + 0.3 * y * y) * math.cos(1.3 * y) for x in range(8)] for y in range(8)]

        def asc(path, rows=heights):
            with open(path, "w", encoding="utf-8") as file:
                file.write("ncols 8\nnrows 8\nxllcorner 0\nyllcorner 0\ncellsize 0.05\n")
                file.write("".join(" ".join(f"{value:.6f}" for value in row) + "\n" for row in rows))

        found = []
        for beam in ("beam rectangle 0.4 0.4 light=lambertian", "beam rectangle 0.4 0.4 light=lambertian z=0.9 angle=180"):
            text = cml.mci([layer], photons=PHOTONS, surfaces={0: 'm "t.asc" tile=as-is units=cm'}, extra=[beam])
            record, _ = fly(text, "--seed", 8, "--ignore-absorption", files=[(asc, "t.asc")])
            cml.check_balance(verdict, "reciprocity", record)
            found.append(record)
        verdict.z(f"reciprocity {height}", found[0]["Tt"], found[0]["Tt_se"], found[1]["Rd"], found[1]["Rd_se"])


def mesh_bodies(verdict):
    """Tests a clear layer with an absorbing octahedron of 0.1 cm, of equal index. Light that starts across it, level or
    slanted, inside or beside it, is absorbed along its way to the surface, whose planes are sx x + sy y + sz z = 0.1."""
    def octahedron(path):
        with open(path, "w", encoding="utf-8") as file:
            file.write("v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\nf 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\n"
                       "f 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n")

    mua, size, width = 8.0, 0.1, 0.24
    for angle, azimuth in ((0, 0), (180, 0), (70, 25), (110, 200)):
        ca, sa, cp, sp = (f(math.radians(t)) for t in (angle, azimuth) for f in (math.cos, math.sin))
        u, own_x, own_y = (sa * cp, sa * sp, ca), (ca * cp, ca * sp, -sa), (-sp, cp, 0.0)
        truth, cells = 0.0, 120
        for i in range(cells):
            for k in range(cells):
                p = [width * (((i + 0.5) / cells - 0.5) * x + ((k + 0.5) / cells - 0.5) * y) for x, y in zip(own_x, own_y)]
                begin, end = 0.0, math.inf  # the part of the way inside: behind each of its planes
                for signs in range(8):
                    s = [1 - 2 * (signs >> j & 1) for j in range(3)]
                    speed, left = sum(x * y for x, y in zip(s, u)), size - sum(x * y for x, y in zip(s, p))
                    if speed > 0:
                        end = min(end, left / speed)
                    else:
                        begin = max(begin, left / speed)
                truth += -math.expm1(-mua * max(0, end - begin)) / cells**2
        text = cml.mci([f"1.3 0 0 0 1\ni \"o.obj\" 1.3 {mua} 0 0 scale={size} shift=0,0,-0.5"], photons=PHOTONS, n_above=1.3, n_below=1.3,
                       extra=[f"beam rectangle {width} {width} z=0.5 angle={angle} azimuth={azimuth}"])
        for engine in ("cpu", "reference"):
            record, _ = fly(text, "--engine", engine, "--seed", 6, files=[(octahedron, "o.obj")])
            cml.check_balance(verdict, f"octahedron {angle}", record)
            verdict.z(f"octahedron {angle} {engine}", record["A"], math.sqrt(truth / PHOTONS), truth)


def engines(verdict):
    """Tests beams that cut cones and start in a sphere, in both precisions and on a device: the same packets but for one in a
    thousand."""
    text = cml.mci(["1.4 1 20 0.8 0.2", "1.3 0.5 5 0.5 0.2\ni sphere 0.1 0 0.3 0.05 1.5 2 10 0.5"], photons=20000,
                   surfaces={0: "b 4 0.1 0.1 0 0.1 0.08 0.1 0 1", 1: "b 3 0.03 0.1 0 0.1 0 1"},
                   extra=["beam disk 0.3 z=0.02 angle=35 light=na:0.5", "beam disk 0.2 light=lambertian", "beam pencil share=0.5",
                          "beam rectangle 0.05 0.02 at=0.1,0 z=0.3 light=isotropic"])
    records = {}
    for engine in ("cpu", "reference", "opencl"):
        try:
            records[engine], _ = fly(text, "--engine", engine, "--seed", 4)
        except RuntimeError as error:
            verdict.check(engine, engine == "opencl" and "exit 3" in str(error), str(error))
            continue
        cml.check_balance(verdict, engine, records[engine])
        for key in ("Rsp", "Rd", "A", "Tt"):
            off = abs(records[engine][key] - records["cpu"][key])
            verdict.check(f"{engine} {key}", off < 1e-3, f"{off} from cpu")


def refusals(verdict):
    """Tests refusals of sources that only the surfaces of a scene make wrong."""
    for beam, expected in (("beam pencil z=0", "beam: at z = (0 0 0) (expected a place inside a medium, more than 1e-10 cm from its surface"),
                           ("beam disk 0.1 z=1 at=0.3,0", "beam: at z = (0.3 0 1) (expected a place inside a medium"),
                           ("beam pencil light=na:1.45 z=0.5", "beam: light = na:1.45 (expected at most n = 1.4"),
                           ("beam pencil z=1.5", "beam: z = 1.5 (expected a source that lies above the backing"),
                           ("beam disk 0.6 angle=60 z=0.5", "beam: z = 0.5 (expected a source that lies above the backing")):
        layer = "1.4 1 2 0.9 1" + ("\nbacking 0.5" if "backing" in expected else "")
        try:
            fly(cml.mci([layer], extra=[beam]))
            verdict.check(beam, False, "was not refused")
        except RuntimeError as error:
            verdict.check(beam, "exit 2" in str(error) and expected in str(error), str(error))


def main():
    global PHOTONS
    groups = (places, directions, slabs, absorbers, point_source, shares, reciprocity, mesh_bodies, engines,
              refusals)
    if len(sys.argv) > 1:
        groups, PHOTONS = [group for group in groups if group.__name__ == sys.argv[1]], int(sys.argv[2])
    verdict = cml.Verdict("sources")
    for group in groups:
        group(verdict)
    verdict.finish()


main()
