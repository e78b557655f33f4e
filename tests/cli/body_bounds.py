"""Tests bodies against curved boundaries and against each other: `check` accepts bodies that just fit, and refuses those that
just do not, in one line with the place.

The boundaries are a cone and a pyramid, so the largest body that fits is known in closed form. Bodies are 1e-3 larger or
smaller.
Cone: depth -0.06 + 0.4 r up to r = 0.1. The distance from (0, z) is (z + 0.06) / sqrt(1 + 0.4^2).
Pyramid: depth -0.06 + 0.2 max(|x|, |y|) up to 0.3; the distance has sqrt(1 + 0.2^2) instead.
The second boundary has the same shape 0.5 cm deeper, so its tip is closest to bodies above it.
SPDX-License-Identifier: MIT"""
import math
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

TILE, TILE_ASC = 'm "tile.asc" tile units=cm', ("ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 0.1\n"
                                               "0 0.1 0\n0 0 0\n0 0 0\n")
CONE, PYRAMID = "b 3  0.06 0.1  0.02 0.05  0 1", 'm "pyramid.obj"'
PYRAMID_OBJ = "v 0 0 0.06\nv -0.3 -0.3 0\nv 0.3 -0.3 0\nv 0.3 0.3 0\nv -0.3 0.3 0\nf 1 2 3\nf 1 3 4\nf 1 4 5\nf 1 5 2\n"
OCTAHEDRON = ("v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n"
              "f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n")
MEDIUM = "1.4 1 10 0.8"


def octahedra(*places):
    """Writes one mesh of octahedra. places: (x, size) of each."""
    return ("".join(f"v {x + r * a} {r * b} {r * c}\n" for x, r in places
                    for a, b, c in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))) +
            "".join("f " + " ".join(str(int(i) + 6 * k) for i in face.split()[1:]) + "\n" for k in range(len(places))
                    for face in OCTAHEDRON.splitlines() if face[0] == "f"))


def sphere(z, r, x=0):
    return f"i sphere {x} 0 {z} {r:.9g} {MEDIUM}"


def upright(z1, z2, r, x=0):
    return f"i cylinder {x:.9g} 0 {z1:.9g} {x:.9g} 0 {z2:.9g} {r:.9g} {MEDIUM}"


def cylinder(z, r):
    return upright(z, z + 0.05, r)


def octahedron(z, r, x=0):
    return f'i "octahedron.obj" {MEDIUM} scale={r:.9g} shift={x:.9g},0,{-z}'


# boundary, its number, the body, depth, and the largest size that fits
FITS = [
    (CONE, 0, sphere, 0.03, 0.09 / math.hypot(1, 0.4)),
    (CONE, 1, sphere, 0.35, 0.09),
    (PYRAMID, 0, sphere, 0.03, 0.09 / math.hypot(1, 0.2)),
    (PYRAMID, 1, sphere, 0.35, 0.09),
    (CONE, 0, cylinder, -0.03, 0.03 / 0.4),
    (PYRAMID, 0, cylinder, -0.03, 0.03 / 0.2),
    (CONE, 0, octahedron, 0.03, 0.09),
    (PYRAMID, 0, octahedron, 0.03, 0.09),
    (CONE, 1, octahedron, 0.35, 0.09),
    (PYRAMID, 1, octahedron, 0.35, 0.09),
]
# A tile 0.1 cm high, of which only the depths count: these bodies just fit beside it with t = 0.999, and do not with 1.001.
TILED = [(0, lambda t: (sphere(0.25, 0.25 * t), octahedron(0.25, 0.25 * t), upright(0.25 * (1 - t), 0.3, 0.1))),
         (1, lambda t: (sphere(0.25, 0.15 * t), octahedron(0.25, 0.15 * t), upright(0.2, 0.4 * t, 0.1)))]
# bodies wholly beyond the boundary, within its range of depths
BEYOND = [(CONE, 0, sphere(-0.05, 0.001, 0.09), "lies beyond"), (PYRAMID, 0, sphere(-0.05, 0.001, 0.25), "lies beyond"),
          (PYRAMID, 0, octahedron(-0.03, 0.001, 0.25), "lies beyond")]
BALL, ROD, LARGE_OCTAHEDRON = sphere(0.25, 0.1), upright(0.2, 0.3, 0.05), octahedron(0.25, 0.1)
# Pairs of bodies. The second just fits beside or inside the first with t = 0.999, and meets it with 1.001.
PAIRS = [
    ("ball, octahedron", BALL, lambda t: octahedron(0.25, 0.05, 0.15 / t)),
    ("ball, side of a rod", BALL, lambda t: upright(0.2, 0.3, 0.05, 0.15 / t)),
    ("ball, end of a rod", BALL, lambda t: upright(0.35 / t, 0.45, 0.05)),
    ("rod, rod across", f"i cylinder -0.1 0 0.2 0.1 0 0.2 0.03 {MEDIUM}",
     lambda t: f"i cylinder 0 -0.1 {0.2 + 0.06 / t:.9g} 0 0.1 {0.2 + 0.06 / t:.9g} 0.03 {MEDIUM}"),
    ("rod, octahedron", ROD, lambda t: octahedron(0.25, 0.05, 0.1 / t)),
    ("octahedron, octahedron", LARGE_OCTAHEDRON, lambda t: octahedron(0.25, 0.05, 0.15 / t)),
    ("octahedron in a ball", BALL, lambda t: octahedron(0.25, 0.1 * t)),
    ("ball in an octahedron", LARGE_OCTAHEDRON, lambda t: sphere(0.25, 0.1 / math.sqrt(3) * t)),
    ("rod in a ball", BALL, lambda t: upright(0.19, 0.31, 0.08 * t)),
    ("ball in a rod", upright(0.1, 0.4, 0.1), lambda t: sphere(0.25, 0.1 * t)),
    ("rod in an octahedron", LARGE_OCTAHEDRON, lambda t: upright(0.22, 0.28, 0.07 / math.sqrt(2) * t)),
    ("octahedron in an octahedron", LARGE_OCTAHEDRON, lambda t: octahedron(0.25, 0.05, 0.05 * t)),
]


def parts(name, size, x=0, z=0.25, more=""):
    return f'i "{name}.obj" {MEDIUM} scale={size:.9g} shift={x:.9g},0,{-z}{more}'


# Meshes of several parts: a shell 0.1 cm wide around a cavity half as wide, two octahedra beside each other, and two that
# cross.
SHELL, TWO, UNION = parts("shell", 0.1), parts("two", 0.1), parts("crossing", 0.1, more=" union")
PAIRS += [
    ("octahedron in a cavity", SHELL, lambda t: octahedron(0.25, 0.02, 0.03 * t)),
    ("ball in a cavity", SHELL, lambda t: sphere(0.25, 0.05 / math.sqrt(3) * t)),
    ("shell in a cavity", SHELL, lambda t: parts("shell", 0.02, 0.03 * t)),
    ("ball between parts", TWO, lambda t: sphere(0.25, 0.1 * t)),
    ("two in a ball", sphere(0.25, 0.15), lambda t: parts("two", 0.05 * t)),
]
# host of the second body, as `check` says it
HOSTS = [(SHELL, octahedron(0.25, 0.04), "layer 1"), (SHELL, sphere(0.25, 0.02), "layer 1"), (SHELL, octahedron(0.25, 0.01, 0.07), "body 1"),
         (SHELL, sphere(0.25, 0.01, 0.07), "body 1"), (TWO, sphere(0.25, 0.05, 0.2), "body 1"), (TWO, sphere(0.25, 0.05), "layer 1"),
         (sphere(0.25, 0.11), SHELL, "body 1"), (octahedron(0.25, 0.2), parts("two", 0.05), "body 1"),
         (parts("shell", 0.24), parts("two", 0.03), "layer 1"), (UNION, sphere(0.25, 0.01, 0.07), "body 1"), (UNION, sphere(0.25, 0.01, -0.01), "body 1"),
         (UNION, octahedron(0.25, 0.01, -0.01), "body 1"), (sphere(0.25, 0.15), parts("crossing", 0.05, more=" union"), "body 1"), (UNION, octahedron(0.25, 0.02, 0.3), "layer 1"),
         (parts("shell", 0.1, more=" union"), octahedron(0.25, 0.02), "body 1")]
# bodies that are neither inside each other nor apart
OVERLAPS = [(SHELL, octahedron(0.25, 0.07)), (SHELL, sphere(0.25, 0.054)), (TWO, octahedron(0.25, 0.12, 0.2)),
            (TWO, sphere(0.25, 0.11, -0.2)), (parts("shell", 0.2), parts("shell", 0.15))]
# a body alone, and the message about it
ALONE = [(None, parts("touching", 0.1), "scene.mci:{}: body 1: touching.obj:22: the mesh touches itself at the vertex (0.1, 0, height -0.25) cm "),
         (None, parts("crossing", 0.1), "scene.mci:{}: body 1 meets itself at ("),
         (PYRAMID, parts("far", 0.005, 0.05, -0.04), "scene.mci:{}: body 1 lies beyond boundary 0 at ("),
         (None, parts("small", 0.1), "scene.mci:{}: body 1: half a width of a part = 1e-09 cm (expected at least ")]


def check(surface, number, *bodies):
    lines = cml.mci(["1.4 0.1 10 0.9 0.5"], surfaces={number: surface} if surface else None).splitlines()
    layer = next(k for k, line in enumerate(lines) if line.startswith("1.4 0.1"))
    with open("scene.mci", "w", encoding="utf-8") as file:
        file.write("\n".join(lines[: layer + 1] + list(bodies) + lines[layer + 1 :]) + "\n")
    run = subprocess.run([cml.PROGRAM, "check", "scene.mci"], capture_output=True, text=True)
    return run.returncode, run.stderr.strip() or run.stdout, layer + 2


def refused(verdict, name, surface, number, body, what):
    code, said, line = check(surface, number, body)
    begin = f"clustermcml: scene.mci:{line}: body 1 {what} boundary {number} at ("
    verdict.check(name, code == 2 and said.startswith(begin) and "\n" not in said, f"{body}: {code}: {said}")


def too_small(verdict):
    """A body must be at least 32 steps of single precision, at its farthest coordinate, wide: a half width of a thousandth
    more is accepted, of a thousandth less refused."""
    step = 2.0**-23 * 0.5
    for what, body in (("radius", lambda size: sphere(0.3, size, x=0.5 - size)), ("radius", lambda size: upright(0.2, 0.3, size, x=0.5 - size)),
                       ("half the length", lambda size: upright(0.3, 0.3 + 2 * size, 0.1, x=0.4)),
                       ("half a width", lambda size: octahedron(0.3, size, x=0.5 - size))):
        other = sphere(0.3, 32.03 * step, x=32.03 * step - 0.5)  # with the other body, x counts from 0
        code, said, line = check(None, 0, other, body(32.03 * step))
        verdict.check(f"{what} fits", code == 0, f"{code}: {said}")
        code, said, line = check(None, 0, other, body(31.97 * step))
        begin = f"clustermcml: scene.mci:{line + 1}: body 2: {what} = 1.905"
        why = " cm away from the origin of the scene or the top of the layer)"
        verdict.check(f"{what} too small", code == 2 and said.startswith(begin) and said.endswith(why) and "\n" not in said, f"{code}: {said}")


def of_parts(verdict):
    """Tests hosts of bodies, and refusals, for bodies of several parts."""
    for first, second, host in HOSTS:
        code, said, _ = check(None, 0, first, second)
        body = next((line for line in said.splitlines() if line.strip().startswith("body 2: ")), said)
        verdict.check("host", code == 0 and f", in {host};" in body, f"{first}\n{second}: {code}: {body}")
    for first, second in OVERLAPS:
        for bodies in ((first, second), (second, first)):
            code, said, line = check(None, 0, *bodies)
            begin = f"clustermcml: scene.mci:{line + 1}: body 2 overlaps body 1 (line {line}) at ("
            end = ") cm (expected all parts of one inside the other, or none)"
            verdict.check("overlap", code == 2 and said.startswith(begin) and said.endswith(end), f"{bodies}: {code}: {said}")
    for surface, body, what in ALONE:
        code, said, line = check(surface, 0, body)
        verdict.check("parts", code == 2 and said.startswith("clustermcml: " + what.format(line)) and "\n" not in said, f"{body}: {code}: {said}")


def main():
    verdict = cml.Verdict("body_bounds")
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name, text in (("pyramid.obj", PYRAMID_OBJ), ("octahedron.obj", OCTAHEDRON), ("tile.asc", TILE_ASC), ("shell.obj", octahedra((0, 1), (0, 0.5))),
                           ("two.obj", octahedra((2, 1), (-2, 1))), ("touching.obj", octahedra((0, 1), (1.5, 0.5))),
                           ("crossing.obj", octahedra((0, 1), (1.5, 1))), ("far.obj", octahedra((0, 1), (40, 1))), ("small.obj", octahedra((0, 1), (2, 1e-8)))):
            with open(name, "w", encoding="utf-8") as file:
                file.write(text)
        for surface, number, body, z, size in FITS:
            name = f"{surface} {number}"
            code, said, _ = check(surface, number, body(z, size * 0.999))
            verdict.check(name, code == 0, f"{body(z, size * 0.999)}: {code}: {said}")
            refused(verdict, name, surface, number, body(z, size * 1.001), "meets")
        for surface, number, body, what in BEYOND:
            refused(verdict, f"beyond {surface}", surface, number, body, what)
        for number, bodies in TILED:
            for t in (0.999, 1.001):
                for body in bodies(t):
                    code, said, line = check(TILE, number, body)
                    begin = f"clustermcml: scene.mci:{line}: body 1 lies at depths of "
                    ok = code == 0 if t < 1 else code == 2 and said.startswith(begin) and "\n" not in said
                    verdict.check(f"tile {number}", ok, f"{body}: {code}: {said}")
        for name, first, second in PAIRS:
            for bodies in (lambda t: (first, second(t)), lambda t: (second(t), first)):
                code, said, _ = check(None, 0, *bodies(0.999))
                verdict.check(name, code == 0, f"fits: {code}: {said}")
                code, said, line = check(None, 0, *bodies(1.001))
                begin = f"clustermcml: scene.mci:{line + 1}: body 2 meets body 1 (line {line}) at ("
                verdict.check(name, code == 2 and said.startswith(begin) and "\n" not in said, f"meets: {code}: {said}")
        too_small(verdict)
        of_parts(verdict)
    verdict.finish()


main()
