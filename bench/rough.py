#!/usr/bin/env python3
"""Rough tops for the bench: rough.py mesh TRIANGLES AMPLITUDE FILE.obj, or rough.py rings N AMPLITUDE FILE.txt.

mesh: a regular grid over 4 x 4 cm with about TRIANGLES triangles; its heights are a sum of sines of random direction
and phase (wavelengths 0.2 to 1 cm), scaled to a maximum of AMPLITUDE cm and faded to exactly 0 at the border.
rings: N rings over 0.5 cm, a sum of sines of random phase in r (wavelengths 0.04 to 0.4 cm), 0 at the last ring.

The surface is one fixed function of x and y, or of r; the number of primitives only says how finely it is sampled.
Noise that is drawn for every vertex would grow steeper with every refinement, and would measure slopes instead of
numbers. Grids coarser than the waves (1000 triangles, 10 rings) see some other rough surface of that amplitude.
Only the standard library is needed, and the same call writes the same bytes: heights are rounded to 1e-6 cm.
SPDX-License-Identifier: MIT
"""
import math
import random
import sys

SIDE, FADE = 4.0, 0.4  # of the mesh [cm]
RADIUS = 0.5  # of the rings [cm]
WAVES = 24


def wavelengths(longest, shortest):
    """WAVES wavelengths in equal ratios."""
    return [longest * (shortest / longest) ** (i / (WAVES - 1)) for i in range(WAVES)]


def plane_waves():
    """(kx, ky, phase) of every wave of the mesh."""
    draw = random.Random(1)
    waves = []
    for length in wavelengths(1.0, 0.2):
        k, turn, phase = 2 * math.pi / length, draw.uniform(0, math.pi), draw.uniform(0, 2 * math.pi)
        waves.append((k * math.cos(turn), k * math.sin(turn), phase))
    return waves


def fade(x):
    """From 0 at the border to 1 within FADE of it, smoothly."""
    t = min((SIDE / 2 - abs(x)) / FADE, 1.0)
    return t * t * (3 - 2 * t)


def heights(cells, amplitude):
    """The heights of (cells + 1)^2 grid points, row by row."""
    xs = [SIDE * (i / cells - 0.5) for i in range(cells + 1)]
    waves, fades = plane_waves(), [fade(x) for x in xs]
    # sin(a + b) = sin a cos b + cos a sin b: sines per row and per column instead of per point
    sines = [[math.sin(kx * x) for kx, _, _ in waves] for x in xs]
    cosines = [[math.cos(kx * x) for kx, _, _ in waves] for x in xs]
    grid = []
    for y, fade_y in zip(xs, fades):
        p = [math.cos(ky * y + phase) for _, ky, phase in waves]
        q = [math.sin(ky * y + phase) for _, ky, phase in waves]
        grid.append([fade_x * fade_y * sum(s * a + c * b for s, c, a, b in zip(sine, cosine, p, q))
                     for fade_x, sine, cosine in zip(fades, sines, cosines)])
    scale = amplitude / max(abs(h) for row in grid for h in row)
    return xs, [[scale * h for h in row] for row in grid]


def write_mesh(triangles, amplitude, name):
    cells = max(2, round(math.sqrt(triangles / 2)))
    xs, grid = heights(cells, amplitude)
    with open(name, "w", newline="\n") as stream:
        stream.write("# rough top, %d triangles, +-%g cm; written by bench/rough.py\n" % (2 * cells * cells, amplitude))
        for y, row in zip(xs, grid):
            # + 0.0 turns -0.0 into 0.0
            stream.write("".join("v %.6f %.6f %.6f\n" % (x, y, round(h, 6) + 0.0) for x, h in zip(xs, row)))
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
    if len(arguments) != 4 or arguments[0] not in ("mesh", "rings"):
        sys.exit("usage: rough.py mesh|rings NUMBER AMPLITUDE FILE")
    write = write_mesh if arguments[0] == "mesh" else write_rings
    write(int(float(arguments[1])), float(arguments[2]), arguments[3])


if __name__ == "__main__":
    main(sys.argv[1:])
