"""Tests backings: surfaces under the last boundary that send light back.

- Lambertian, R = 0, 0.5, 1: adding-doubling of the slab alone, lit from above and with diffuse light from below. The surface
  is added by van de Hulst's series R + T R' t / (1 - R' r); `exact` itself agrees with it within 1e-7.
- Mirror, R = 1: the slab of twice the thickness, whose upper half sees its mirror image. R = 0: the slab alone. R = 0.5 under
  slanted light: the geometric series of an absorbing slab with Fresnel's reflectance at its top, and adding-doubling with
  scattering.
- Metal: Fresnel's reflectance with a complex index, at ten angles. The slab is clear and has the index of the medium above,
  so every packet keeps the same share, within 2e-6.
- An .obj file as backing: a groove of two slopes at right angles, from which all packets come straight back with R(45
  degrees)^2.
- A radial shape and its mesh as backing: `crosscheck`, packet by packet between engines, totals between cones and triangles.
N = 4e4 a case; statistic: z, level 1e-4 over all."""
import cmath
import functools
import json
import math
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

PHOTONS = 40000
SLABS = [(1.4, 0.5, 50, 0.8, 0.05), (1.0, 2, 20, 0, 0.1), (1.33, 1, 300, 0.95, 0.02)]
METALS = {"gold": (0.183, 3.434), "aluminium": (1.373, 7.618)}  # complex indices at 633 nm
KEYS = ("Rsp", "Rd", "A", "Tt", "A_backing")


def scene(slab, backing="", n_above=1.0, n_below=1.0, beam="", photons=PHOTONS, shape=""):
    layer = " ".join(map(str, slab))
    text = cml.mci([layer], photons=photons, n_above=n_above, n_below=n_below, extra=[beam] if beam else [])
    head, below = text.rstrip("\n").rsplit("\n", 1)
    return "\n".join([head] + [line for line in (shape, backing) if line] + [below, ""])


@functools.cache
def exact(folder, text):
    path = os.path.join(folder, "exact.mci")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    found = subprocess.run([cml.PROGRAM, "exact", path, "--json"], capture_output=True, text=True, check=True)
    return json.loads(found.stdout)


def reflected(totals):
    return totals["Rsp"] + totals["Rd"]


def added(folder, slab, R):
    """Returns the light that comes back from a slab on a lambertian surface, and the light that the surface keeps."""
    n = slab[0]
    down = exact(folder, scene(slab, n_below=n))
    up = exact(folder, scene(slab, n_above=n, beam="beam pencil light=lambertian"))
    arrives = down["Tt"] / (1 - R * reflected(up))
    return reflected(down) + arrives * R * up["Tt"], arrives * (1 - R)


def mirrored(folder, slab, R):
    if R == 0:
        alone = exact(folder, scene(slab, n_below=slab[0]))
        return reflected(alone), alone["Tt"]
    double = exact(folder, scene((*slab[:4], 2 * slab[4])))
    return reflected(double) + double["Tt"], 0.0


def compare(verdict, name, folder, text, expected, seed, *options):
    record = cml.run(text, "--seed", seed, "--ignore-absorption", *options, keep=folder)[0]
    cml.check_balance(verdict, name, record)
    verdict.check(name, record["Tt"] == 0, f"Tt = {record['Tt']}")
    for key, value in expected.items():
        found = reflected(record) if key == "R" else record[key]
        error = record["Rd_se" if key == "R" else key + "_se"] or 1e-9
        verdict.z(f"{name} {key}", found, error, value)
    return record


def slabs(verdict, folder):
    for i, slab in enumerate(SLABS):
        for kind, oracle in (("lambertian", added), ("mirror", mirrored)):
            for R in (0, 0.5, 1):
                text = scene(slab, f"backing {R} {kind}")
                name, totals = f"slab {i} {kind} {R}", exact(folder, text)
                if (kind, R) != ("mirror", 0.5):
                    light, kept = oracle(folder, slab, R)
                    gaps = (reflected(totals) - light, totals["A_backing"] - kept)
                    verdict.check(name, max(map(abs, gaps)) < 1e-7, f"exact is off by {gaps}")
                else:
                    light, kept = reflected(totals), totals["A_backing"]
                compare(verdict, name, folder, text, {"R": light, "A_backing": kept, "A": 1 - light - kept}, 10 * i + int(2 * R))


def absorber(verdict, folder):
    """Tests slanted light on an absorbing plate above a half mirror."""
    n, mua, d, R = 1.5, 3.0, 0.1, 0.5
    for angle in (0, 40, 75):
        c1 = math.cos(math.radians(angle))
        c2 = math.sqrt(1 - (math.sin(math.radians(angle)) / n) ** 2)
        r = (((c1 - n * c2) / (c1 + n * c2)) ** 2 + ((c2 - n * c1) / (c2 + n * c1)) ** 2) / 2
        t = math.exp(-mua * d / c2)
        arrives = (1 - r) * t / (1 - r * R * t * t)
        text = scene((n, mua, 0, 0, d), f"backing {R}", beam=f"beam pencil angle={angle}")
        name, light = f"absorber at {angle} degrees", r + arrives * R * t * (1 - r)
        compare(verdict, name, folder, text, {"R": light, "A_backing": arrives * (1 - R)}, 50 + angle)
        gap = reflected(exact(folder, text)) - light
        verdict.check(name, abs(gap) < 1e-7, f"exact is off by {gap}")


def metallic(n, angle, N, K):
    t, index = math.radians(angle), complex(N, K)
    c1, c2 = math.cos(t), cmath.sqrt(1 - (n * math.sin(t) / index) ** 2)
    rs, rp = (n * c1 - index * c2) / (n * c1 + index * c2), (index * c1 - n * c2) / (index * c1 + n * c2)
    return (abs(rs) ** 2 + abs(rp) ** 2) / 2


def metals(verdict, folder):
    n = 1.4
    for name, (N, K) in METALS.items():
        for angle in range(0, 90, 9):
            R = metallic(n, angle, N, K)
            text = scene((n, 0, 0, 0, 0.1), f"backing metal {N} {K}", n_above=n, beam=f"beam pencil angle={angle}", photons=200)
            record = cml.run(text, keep=folder)[0]
            gap = record["A_backing"] - (1 - R)
            verdict.check(f"{name} at {angle} degrees", abs(gap) < 2e-6, f"1 - R is off by {gap}")


def groove(verdict, folder):
    """Tests a groove; its ends are slopes, too, which no light meets."""
    n, h = 1.4, 0.2
    with open(os.path.join(folder, "groove.obj"), "w", encoding="ascii") as file:
        for x, y, z in ((-h, -1, 0), (h, -1, 0), (h, 1, 0), (-h, 1, 0), (0, -0.5, -h), (0, 0.5, -h)):
            file.write(f"v {x} {y} {z}\n")
        file.write("f 1 5 6 4\nf 2 3 6 5\nf 1 2 5\nf 3 4 6\n")
    for backing, R in (("0.6", 0.6), ("metal 0.183 3.434", metallic(n, 45, 0.183, 3.434))):
        for engine in ("cpu", "reference"):
            text = scene((n, 0, 0, 0, 0.3), "backing " + backing, n_above=n, beam="beam rectangle 0.3 0.8", photons=2000,
                         shape='m "groove.obj"').replace("\n10 10 1\n", "\n10 10 90\n")
            record = cml.run(text, "--engine", engine, keep=folder)[0]
            angles = cml.read_sections(record["output"])["Rd_a"]
            gap = record["Rd"] - R * R
            verdict.check(f"groove, {backing}, {engine}", abs(gap) < 2e-6 and not any(angles[1:]), f"Rd is off by {gap}; {angles[:4]}")
            verdict.check(f"groove, {backing}, {engine}", abs(record["A_backing"] + record["Rd"] - 1) < 1e-9, "A_backing")


def shapes(verdict, folder):
    shape = "b 3 0.02 0.1 0.01 0.1 0 1"
    for backing in ("backing 0.7", "backing 0.7 lambertian", "backing metal 0.183 3.434"):
        path = os.path.join(folder, "shape.mci")
        with open(path, "w", encoding="utf-8") as file:
            file.write(scene(SLABS[0], backing, shape=shape, photons=20000))
        found = subprocess.run([cml.PROGRAM, "crosscheck", path], capture_output=True, text=True, check=False)
        verdict.check(backing, found.returncode == 0 and "A_backing" in found.stdout, found.stdout + found.stderr)


def main():
    verdict = cml.Verdict("backings")
    with tempfile.TemporaryDirectory() as folder:
        slabs(verdict, folder)
        absorber(verdict, folder)
        metals(verdict, folder)
        groove(verdict, folder)
        shapes(verdict, folder)
    verdict.finish()


main()
