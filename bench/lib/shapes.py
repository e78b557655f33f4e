"""Closed and overhanging meshes for the bench, always with the same bytes. Lengths are in cm, heights up, faces counter-clockwise seen from
outside.

SPDX-License-Identifier: MIT
"""
import math

SIDE = 1.0  # side of the ground of a ring or tunnel [cm]
TURN, TUBE = 0.25, 0.1  # radii of the ring and of its tube [cm]
AROUND, ALONG = 16, 13  # corners of the tube, and sections of its half turn
OFF = (0.013, 0.007)  # shift of the whole mesh [cm], so that a pencil at x = y = 0 meets no edge


class Mesh:
    """A mesh: vertices, each only once, and faces of their indices from 1."""

    def __init__(self):
        self.numbers, self.faces = {}, []

    def vertex(self, *p):
        p = tuple(round(x, 9) + 0.0 for x in p)  # + 0.0 turns -0.0 into 0.0
        return self.numbers.setdefault(p, len(self.numbers) + 1)

    def quad(self, a, b, c, d):
        self.faces += [(a, b, c), (a, c, d)]

    def write(self, path):
        with open(path, "w", newline="\n") as file:
            file.writelines("v %.9g %.9g %.9g\n" % v for v in self.numbers)
            file.writelines("f %d %d %d\n" % f for f in self.faces)


def icosahedron():
    """Returns corners of an icosahedron, and faces counter-clockwise seen from outside."""
    t = (1 + math.sqrt(5)) / 2
    corners = [(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t), (0, -1, -t), (0, 1, -t),
               (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
             (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11),
             (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    return corners, faces


def write_ball(path, radius, parts, height=0.0):
    """Writes a sphere around that height. Each edge of an icosahedron is cut into `parts`, and all corners are put onto the sphere."""
    corners, faces = icosahedron()
    mesh = Mesh()

    def vertex(weights, face):
        p = [sum(w * corners[c][k] for w, c in zip(weights, face)) for k in range(3)]
        size = math.sqrt(sum(x * x for x in p))
        x, y, z = (radius * x / size for x in p)
        return mesh.vertex(x, y, z + height)

    for face in faces:
        at = {(i, j): vertex((i, j, parts - i - j), face) for i in range(parts + 1) for j in range(parts + 1 - i)}
        for i, j in at:
            if i + j < parts:
                mesh.faces.append((at[i, j], at[i + 1, j], at[i, j + 1]))
            if i + j < parts - 1:
                mesh.faces.append((at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]))
    mesh.write(path)


def section():
    """Yields ((x, y) on the circle of TUBE, (x, y) on the border of the half ground around it) at rising angles. Corners of the border are among
    them."""
    half = SIDE / 4, SIDE / 2
    corner = math.atan2(half[1], half[0])
    angles = [2 * math.pi * (k + 0.5) / AROUND for k in range(AROUND)]
    angles += [corner, math.pi - corner, math.pi + corner, 2 * math.pi - corner]
    for angle in sorted(angles):
        c, s = math.cos(angle), math.sin(angle)
        out = min(half[0] / abs(c), half[1] / abs(s))
        yield (TUBE * c, TUBE * s), (out * c, out * s)


def write_handle(path, side, sections=ALONG):
    """Writes a level square from which half a ring rises as a handle (side 1), or below which it leads as a tunnel (side -1). With fewer sections,
    the ring has one foot and ends in a cap: a bent tube."""
    mesh, points = Mesh(), list(section())

    def on_ground(p, sign):
        return mesh.vertex(sign * (p[0] - TURN) + OFF[0], p[1] + OFF[1], 0.0)

    def on_ring(p, turn):
        reach = TURN - p[0]
        height = side * reach * math.sin(turn) if 0 < turn < math.pi else 0.0
        return mesh.vertex(OFF[0] - reach * math.cos(turn), p[1] + OFF[1], height)

    end, middle = math.pi * sections / ALONG, (0.0, 0.0)
    for (p, q), (p_next, q_next) in zip(points, points[1:] + points[:1]):
        mesh.quad(on_ground(p, 1), on_ground(q, 1), on_ground(q_next, 1), on_ground(p_next, 1))
        if sections == ALONG:
            mesh.quad(on_ground(p_next, -1), on_ground(q_next, -1), on_ground(q, -1), on_ground(p, -1))
        else:
            mesh.faces.append((on_ground(middle, -1), on_ground(q_next, -1), on_ground(q, -1)))
            mesh.faces.append((on_ring(middle, end), on_ring(p, end), on_ring(p_next, end)))
        for k in range(sections):
            turn, turn_next = math.pi * k / ALONG, math.pi * (k + 1) / ALONG
            mesh.quad(on_ring(p, turn), on_ring(p_next, turn), on_ring(p_next, turn_next), on_ring(p, turn_next))
    mesh.write(path)
