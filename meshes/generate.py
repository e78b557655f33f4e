#!/usr/bin/env python3
"""Writes the meshes and heightmaps of this folder: generate.py [DIRECTORY], by default beside this script.

Meshes: lengths in cm, heights up, faces counter-clockwise seen from above. Only the standard library is needed; the
numbers are rounded to 1e-6 cm, so that every machine writes the same bytes.
SPDX-License-Identifier: MIT
"""
import math
import os
import struct
import sys


def write(directory, name, title, vertices, faces):
    lines = ["# %s" % title, "# written by meshes/generate.py; cm, heights up; SPDX-License-Identifier: MIT"]
    for vertex in vertices:
        # + 0.0 turns -0.0 into 0.0
        lines.append("v " + " ".join("%.6f" % (round(c, 6) + 0.0) for c in vertex))
    for face in faces:
        lines.append("f " + " ".join(str(i + 1) for i in face))
    with open(os.path.join(directory, name), "w", newline="\n") as stream:
        stream.write("\n".join(lines) + "\n")


def wedge():
    """A ramp of slope 1/7 along x with a steep back, on a flat skirt; no symmetry."""
    outer = [(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)]
    inner = [(-0.4, -0.35, 0), (0.4, -0.35, 0), (0.4, 0.4, 0), (-0.4, 0.4, 0)]
    top = [(0.3, -0.25, 0.1), (0.3, 0.3, 0.1)]
    faces = []
    for i in range(4):
        j = (i + 1) % 4
        faces += [(i, j, 4 + j), (i, 4 + j, 4 + i)]
    faces += [(4, 8, 9), (4, 9, 7)]  # the ramp
    faces += [(5, 6, 9), (5, 9, 8)]  # its back
    faces += [(4, 5, 8), (6, 7, 9)]  # its sides
    return outer + inner + top, faces


def ridges():
    """Skin: two sets of oblique, skewed ridges that fade out towards the border."""
    n = 50

    def height(x, y):
        u = (x * math.cos(0.35) + y * math.sin(0.35)) / 0.4
        v = (y * math.cos(0.2) - x * math.sin(0.2)) / 0.7
        fade = (1 - x ** 4) * (1 - y ** 4)
        return 0.006 * fade * (math.sin(2 * math.pi * u) + 0.35 * math.sin(4 * math.pi * u + 0.7)
                               + 0.4 * math.sin(2 * math.pi * v + 1.1))

    vertices, faces = [], []
    for j in range(n + 1):
        for i in range(n + 1):
            x, y = -1 + 2 * i / n, -1 + 2 * j / n
            vertices.append((x, y, 0 if i in (0, n) or j in (0, n) else height(x, y)))
    for j in range(n):
        for i in range(n):
            a, b = j * (n + 1) + i, (j + 1) * (n + 1) + i
            faces += [(a, a + 1, b + 1), (a, b + 1, b)] if (i + j) % 2 else [(a, a + 1, b), (a + 1, b + 1, b)]
    return vertices, faces


def prism():
    """A roof along y: two slopes of 45 degrees that meet at a right angle, upright gables."""
    vertices = [(-0.5, -1, 0), (0.5, -1, 0), (0.5, 1, 0), (-0.5, 1, 0), (0, -1, 0.5), (0, 1, 0.5)]
    return vertices, [(0, 4, 5), (0, 5, 3), (1, 2, 5), (1, 5, 4), (0, 1, 4), (2, 3, 5)]


def pyramid():
    """Four faces and a tip above the origin."""
    vertices = [(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0), (0, 0, 0.25)]
    return vertices, [(i, (i + 1) % 4, 4) for i in range(4)]


def overhang():
    """A leaning mushroom: the cap overhangs the stem, so the surface is not a function of x and y."""
    n = 24
    profile = [(0.5, 0, 0), (0.15, 0, 0), (0.12, 0.1, 0.01), (0.3, 0.12, 0.03), (0.32, 0.16, 0.03),
               (0.25, 0.24, 0.03), (0.12, 0.29, 0.03)]  # radius, height, shift along x
    vertices, faces = [], []
    for radius, height, shift in profile:
        for i in range(n):
            angle = 2 * math.pi * i / n
            vertices.append((shift + radius * math.cos(angle), radius * math.sin(angle), height))
    tip = len(vertices)
    vertices.append((0.03, 0, 0.3))
    for ring in range(len(profile) - 1):
        for i in range(n):
            a, b = ring * n + i, ring * n + (i + 1) % n
            faces += [(a, b, b + n), (a, b + n, a + n)]
    last = (len(profile) - 1) * n
    faces += [(last + i, last + (i + 1) % n, tip) for i in range(n)]
    return vertices, faces


def spikes():
    """Ten by ten pyramids, 0.1 cm wide and 0.5 cm high: slope 10. The origin is on no edge."""
    n, width, height = 10, 0.1, 0.5
    x0, y0 = -0.47, -0.48
    vertices = [(x0 + width * i, y0 + width * j, 0) for j in range(n + 1) for i in range(n + 1)]
    faces = []
    for j in range(n):
        for i in range(n):
            tip, a, b = len(vertices), j * (n + 1) + i, (j + 1) * (n + 1) + i
            vertices.append((x0 + width * (i + 0.5), y0 + width * (j + 0.5), height))
            faces += [(a, a + 1, tip), (a + 1, b + 1, tip), (b + 1, b, tip), (b, a, tip)]
    return vertices, faces


def vein():
    """A winding vein below skin: a closed tube of 12 sides, 0.012 cm in radius, its middle 0.026 to 0.046 cm deep."""
    rings, sides, radius = 72, 12, 0.012

    def middle(t):
        return 0.06 * math.sin(5 * t) + 0.02 * math.sin(11 * t + 1), 0.8 * t - 0.4, -0.036 - 0.01 * math.sin(7 * t + 2)

    vertices, faces = [], []
    for i in range(rings):
        t = i / (rings - 1)
        along = [b - a for a, b in zip(middle(t - 1e-4), middle(t + 1e-4))]
        length = math.sqrt(sum(c * c for c in along))
        x, y, z = (c / length for c in along)
        level = math.hypot(x, y)
        right, up = (y / level, -x / level, 0), (-x * z / level, -y * z / level, level)
        for k in range(sides):
            c, s = radius * math.cos(2 * math.pi * k / sides), radius * math.sin(2 * math.pi * k / sides)
            vertices.append([m + c * r + s * u for m, r, u in zip(middle(t), right, up)])
    for i in range(0, (rings - 1) * sides, sides):
        for k in range(sides):
            a, b = i + k, i + (k + 1) % sides
            faces += [(a, b, b + sides), (a, b + sides, a + sides)]
    last = (rings - 1) * sides
    for k in range(sides):
        j = (k + 1) % sides
        faces += [(len(vertices), j, k), (len(vertices) + 1, last + k, last + j)]
    return vertices + [middle(0), middle(1)], faces


def gsf(nx, ny, step, height):
    """A Gwyddion Simple Field of heights that are `step` m apart."""
    head = "Gwyddion Simple Field 1.0\nXRes = %d\nYRes = %d\nXReal = %.9g\nYReal = %.9g\n" % (
        nx, ny, nx * step, ny * step)
    head += "XYUnits = m\nZUnits = m\nTitle = made by meshes/generate.py, not measured\n"
    heights = [round(height(i, j), 9) for j in range(ny) for i in range(nx)]
    return head.encode() + b"\0" * (4 - len(head) % 4) + struct.pack("<%df" % (nx * ny), *heights)


def skin():
    """A scan of skin: fine isotropic roughness over a shallow furrow, 96 x 64 heights 25 um apart."""
    nx, ny, step = 96, 64, 25e-6  # m
    waves = [(3.1 + 2.3 * k, 2.399963 * k, 1.7 * k * k) for k in range(24)]  # waves per width, direction, phase

    def height(i, j):
        x, y = i / nx, j / nx
        rough = sum(math.sin(2 * math.pi * f * (x * math.cos(a) + y * math.sin(a)) + p) / f for f, a, p in waves)
        return 6e-6 * rough - 12e-6 * math.exp(-((y - 0.25 - 0.1 * x) / 0.06) ** 2)

    return gsf(nx, ny, step, height)


def furrows():
    """Skin whose furrows meet in triangles, and whose ends fit: 64 x 64 heights 25 um apart, 60 um deep."""
    n = 64
    sets = ((2, 1, 0.3), (-1, 2, 1.1), (-1, -3, 2.0))  # waves along x and y in a period, phase

    def height(i, j):
        x, y = 2 * math.pi * i / n, 2 * math.pi * j / n
        deep = sum(math.exp((math.cos(k * x + l * y + p) - 1) / 0.12) for k, l, p in sets)
        rough = sum(math.sin(k * x + (11 - k) * y + k * k) for k in range(3, 9))
        return -4e-5 * min(deep, 1.5) + 4e-7 * rough

    return gsf(n, n, 25e-6, height)


def stripes():
    """No heights but an image, for a beam: three rows of stripes, 48 x 48 pixels of 1 x 1 cm."""
    n = 48

    def bright(i, j):
        return 1 - int((i + 0.5) / n / (0.25, 0.125, 0.0625)[j * 3 // n]) % 2

    return gsf(n, n, 0.01 / n, bright)


def grooves():
    """A turned plate: saw-tooth grooves along y, 60 x 40 heights in mm, 0.05 mm apart."""
    nx, ny = 60, 40
    lines = ["ncols %d" % nx, "nrows %d" % ny, "xllcorner 0", "yllcorner 0", "cellsize 0.05", "NODATA_value -9999"]
    for j in range(ny):
        lines.append(" ".join("%.4f" % (0.003 * ((i + j // 8) % 6) - 0.0075 + 0.0) for i in range(nx)))
    return ("\n".join(lines) + "\n").encode()


def main():
    directory = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__))
    for family in (wedge, ridges, prism, pyramid, overhang, spikes, vein):
        write(directory, family.__name__ + ".obj", family.__doc__.rstrip("."), *family())
    for heightmap, ending in ((skin, ".gsf"), (furrows, ".gsf"), (stripes, ".gsf"), (grooves, ".asc")):
        with open(os.path.join(directory, heightmap.__name__ + ending), "wb") as stream:
            stream.write(heightmap())


if __name__ == "__main__":
    main()
