"""Closed and overhanging meshes for the bench.

SPDX-License-Identifier: MIT
"""
import math


def icosahedron():
    """Corners of length 1, and faces seen from outside, counter-clockwise."""
    t = (1 + math.sqrt(5)) / 2
    corners = [(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t), (0, -1, -t), (0, 1, -t),
               (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
             (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11),
             (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    return corners, faces


def write_ball(path, radius, parts):
    """A sphere: each edge of an icosahedron cut into so many parts, and its corners put onto the sphere."""
    corners, faces = icosahedron()
    numbers, vertices, triangles = {}, [], []

    def vertex(weights, face):
        p = [sum(w * corners[c][k] for w, c in zip(weights, face)) for k in range(3)]
        size = math.sqrt(sum(x * x for x in p))
        p = tuple(round(radius * x / size, 9) for x in p)
        if p not in numbers:
            vertices.append(p)
            numbers[p] = len(vertices)
        return numbers[p]

    for face in faces:
        at = {(i, j): vertex((i, j, parts - i - j), face) for i in range(parts + 1) for j in range(parts + 1 - i)}
        for i, j in at:
            if i + j < parts:
                triangles.append((at[i, j], at[i + 1, j], at[i, j + 1]))
            if i + j < parts - 1:
                triangles.append((at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]))
    with open(path, "w") as file:
        file.writelines("v %.9g %.9g %.9g\n" % v for v in vertices)
        file.writelines("f %d %d %d\n" % t for t in triangles)
