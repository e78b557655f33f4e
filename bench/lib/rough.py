#!/usr/bin/env python3
"""Makes rough tops for the bench: rough.py mesh|moved|kept|spiked|cave|mushrooms TRIANGLES AMPLITUDE FILE.obj, or rough.py rings N AMPLITUDE
FILE.txt.

mesh: a regular grid over 4 x 4 cm with about TRIANGLES triangles. Heights are a sum of sines of random direction
and phase (wavelengths 0.2 to 1 cm), scaled to a maximum of AMPLITUDE cm and faded to exactly 0 at the border.
moved: the same surface, but inner vertices are moved by up to 0.22 of a cell in x and y, and have its height there.
kept: inner vertices are moved by up to 0.3 of a cell and keep their heights. Facets are steeper, as in scans.
spiked: the regular grid, with the vertex at x = y = 1 cm raised by 0.1 cm.
cave: the regular grid, wrapped around one bottle of 0.4 cm below x = y = 0: overhanging walls under a narrow neck.
mushrooms: the regular grid, wrapped around 16 x 16 mushrooms of 0.1 cm, whose caps overhang their stems.
rings: N rings over 0.5 cm, a sum of sines of random phase in r (wavelengths 0.04 to 0.4 cm), 0 at the last ring.

The surface is one fixed function of x and y, or of r. The number of primitives only sets how finely it is sampled. Random heights for every vertex
would grow steeper with every refinement, and would measure the effect of slopes instead of numbers. Grids coarser than the waves (1000 triangles,
10 rings) sample some other rough surface of that amplitude. Only the standard library is needed. Equal calls write equal bytes, because heights are
rounded to 1e-6 cm.

SPDX-License-Identifier: MIT
"""
import math
import random
import sys

MESHES = ("mesh", "moved", "kept", "spiked", "cave", "mushrooms")
SIDE, FADE = 4.0, 0.4  # side of the mesh, and width of its fading border [cm]
RADIUS = 0.5  # radius of the last ring [cm]
WAVES = 24
MOVED, KEPT = 0.22, 0.3  # largest distance by which vertices are moved in x and y [cells]
ACROSS = 0.48  # largest dx - dy: vertices moved by more across the diagonal of a cell could turn a triangle over
# Profile of a mushroom, from outside to its top: (share of the radius on the grid, share of the radius, share of the height). Upside down, the
# profile is a bottle.
PROFILE = ((1.0, 1.0, 0.0), (0.8, 0.4, 0.0), (0.6, 0.4, 0.5), (0.45, 0.8, 0.6), (0.25, 0.7, 0.9), (0.0, 0.0, 1.0))
CAVE, MUSHROOM, MUSHROOMS = 0.4, 0.1, 16  # radius and depth of the cave, radius and height of a mushroom [cm], number of mushrooms along an axis
SPIKE_AT, SPIKE = 1.0, 0.1  # x = y of the raised vertex, and its height [cm]


def wavelengths(longest, shortest):
    """Returns WAVES wavelengths in equal ratios."""
    return [longest * (shortest / longest) ** (i / (WAVES - 1)) for i in range(WAVES)]


def plane_waves():
    """Returns (kx, ky, phase) of every wave of the mesh."""
    draw = random.Random(1)
    waves = []
    for length in wavelengths(1.0, 0.2):
        k, turn, phase = 2 * math.pi / length, draw.uniform(0, math.pi), draw.uniform(0, 2 * math.pi)
        waves.append((k * math.cos(turn), k * math.sin(turn), phase))
    return waves


def fade(x):
    """Returns a smooth factor from 0 at the border to 1 at the distance FADE from it."""
    t = min((SIDE / 2 - abs(x)) / FADE, 1.0)
    return t * t * (3 - 2 * t)


def raw_heights(cells):
    """Returns coordinates and unscaled heights of (cells + 1)^2 grid points, row by row."""
    xs = [SIDE * (i / cells - 0.5) for i in range(cells + 1)]
    waves, fades = plane_waves(), [fade(x) for x in xs]
    # sin(a + b) = sin a cos b + cos a sin b: sines are computed per row and per column, not per point
    sines = [[math.sin(kx * x) for kx, _, _ in waves] for x in xs]
    cosines = [[math.cos(kx * x) for kx, _, _ in waves] for x in xs]
    grid = []
    for y, fade_y in zip(xs, fades):
        p = [math.cos(ky * y + phase) for _, ky, phase in waves]
        q = [math.sin(ky * y + phase) for _, ky, phase in waves]
        grid.append([fade_x * fade_y * sum(s * a + c * b for s, c, a, b in zip(sine, cosine, p, q))
                     for fade_x, sine, cosine in zip(fades, sines, cosines)])
    return xs, grid


def scale_of(grid, amplitude):
    return amplitude / max(abs(h) for row in grid for h in row)


def heights(cells, amplitude):
    """Returns coordinates and heights [cm] of (cells + 1)^2 grid points, row by row."""
    xs, grid = raw_heights(cells)
    scale = scale_of(grid, amplitude)
    return xs, [[scale * h for h in row] for row in grid]


def move_inner(rows, reach, height=None):
    """Moves the inner vertices (x, y, h) by up to `reach` cells in x and y, to height(x, y), or at unchanged height without it."""
    draw, cells = random.Random(3), len(rows) - 1
    for row in rows[1:-1]:
        for i in range(1, cells):
            dx, dy = draw.uniform(-reach, reach), draw.uniform(-reach, reach)
            while abs(dx - dy) > ACROSS:
                dx, dy = draw.uniform(-reach, reach), draw.uniform(-reach, reach)
            x, y, h = row[i]
            x, y = x + dx * SIDE / cells, y + dy * SIDE / cells
            row[i] = x, y, height(x, y) if height else h


def raise_spike(rows):
    cells = len(rows) - 1
    i = min(round((SPIKE_AT / SIDE + 0.5) * cells), cells - 1)
    x, y, h = rows[i][i]
    rows[i][i] = x, y, h + SPIKE


def on_profile(share):
    """Returns (share of the radius, share of the height) to which a vertex of the regular grid is moved."""
    for (a, r0, h0), (b, r1, h1) in zip(PROFILE, PROFILE[1:]):
        if share >= b:
            t = (a - share) / (a - b)
            return r0 + t * (r1 - r0), h0 + t * (h1 - h0)


def wrap(rows, count, radius, height):
    """Wraps the grid around count x count mushrooms, or bottles if height is negative."""
    pitch = SIDE / count
    for row in rows:
        for i, (x, y, h) in enumerate(row):
            x0, y0 = ((min(int((at + SIDE / 2) / pitch), count - 1) + 0.5) * pitch - SIDE / 2 for at in (x, y))
            share = math.hypot(x - x0, y - y0) / radius
            if share < 1:
                r, rise = on_profile(share)
                k = r / share if share else 0.0
                row[i] = x0 + k * (x - x0), y0 + k * (y - y0), h + rise * height


def mesh_vertices(kind, cells, amplitude):
    """Returns rows of vertices (x, y, h) [cm]. Vertices of the border are the same for all kinds."""
    xs, raw = raw_heights(cells)
    scale, waves = scale_of(raw, amplitude), plane_waves()
    rows = [[(x, y, scale * h) for x, h in zip(xs, row)] for y, row in zip(xs, raw)]
    if kind == "moved":
        move_inner(rows, MOVED, lambda x, y: scale * fade(x) * fade(y) * sum(
            math.sin(kx * x + ky * y + phase) for kx, ky, phase in waves))
    elif kind == "kept":
        move_inner(rows, KEPT)
    elif kind == "spiked":
        raise_spike(rows)
    elif kind == "cave":
        wrap(rows, 1, CAVE, -CAVE)
    elif kind == "mushrooms":
        wrap(rows, MUSHROOMS, MUSHROOM, MUSHROOM)
    return rows


def write_mesh(kind, triangles, amplitude, name):
    cells = max(2, round(math.sqrt(triangles / 2)))
    top = "rough top" if kind == "mesh" else "rough top, " + kind
    with open(name, "w", newline="\n") as stream:
        stream.write("# %s, %d triangles, +-%g cm; written by bench/lib/rough.py\n" % (top, 2 * cells * cells, amplitude))
        for row in mesh_vertices(kind, cells, amplitude):
            # + 0.0 turns -0.0 into 0.0
            stream.write("".join("v %.6f %.6f %.6f\n" % (x, y, round(h, 6) + 0.0) for x, y, h in row))
        for j in range(cells):
            lines = []
            for i in range(cells):
                a = j * (cells + 1) + i + 1
                c = a + cells + 1
                lines.append("f %d %d %d\nf %d %d %d\n" % (a, a + 1, c + 1, a, c + 1, c))
            stream.write("".join(lines))


def write_rings(rings, amplitude, name):
    draw = random.Random(2)
    waves = [(2 * math.pi / length, draw.uniform(0, 2 * math.pi)) for length in wavelengths(0.4, 0.04)]
    spacing = RADIUS / rings
    profile = [sum(math.sin(k * i * spacing + phase) for k, phase in waves) for i in range(rings)]
    scale = amplitude / max(abs(h) for h in profile)
    samples = ["%.6f %.6g" % (round(scale * h, 6) + 0.0, spacing) for h in profile] + ["0 1"]
    with open(name, "w", newline="\n") as stream:
        stream.write("%d\n%s\n" % (len(samples), "\n".join(samples)))


def main(arguments):
    if len(arguments) != 4 or arguments[0] not in MESHES + ("rings",):
        sys.exit("usage: rough.py %s|rings NUMBER AMPLITUDE FILE" % "|".join(MESHES))
    kind, number, amplitude, name = arguments[0], int(float(arguments[1])), float(arguments[2]), arguments[3]
    if kind == "rings":
        write_rings(number, amplitude, name)
    else:
        write_mesh(kind, number, amplitude, name)


if __name__ == "__main__":
    main(sys.argv[1:])
