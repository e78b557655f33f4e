"""Closes the slab below a mesh, or around a body: for Mitsuba as a surface, for MMC filled with tetrahedra by tetgen.

Around the mesh the slab goes on, level, because a slab that ended with the mesh would lose light through its sides. Without a demand for quality,
tetgen makes as few tetrahedra as the triangles allow, which MMC flies fastest.

SPDX-License-Identifier: MIT
"""
import json
import math
import subprocess

HALF_WIDTH = 50.0  # half the width of MMC's slab [cm]
NS_OF_FLIGHT = 1000  # longer than any packet lives
MM = 10.0  # mm in a cm


def read_obj(path):
    """Reads an OBJ file of vertices and triangles alone. Returns (vertices [cm, z down], triangles of indices from 1)."""
    vertices, triangles = [], []
    with open(path, encoding="utf-8") as stream:
        for words in map(str.split, stream):
            if words[:1] == ["v"]:
                x, y, up = map(float, words[1:])
                vertices.append((x, y, 0.0 - up))
            elif words[:1] == ["f"]:
                triangles.append([int(word) for word in words[1:]])
    return vertices, triangles


def outline(triangles):
    """Returns the border as a polygon of indices from 1: the edges of only one triangle, in order."""
    edges = {edge for a, b, c in triangles for edge in ((a, b), (b, c), (c, a))}
    follows = {a: b for a, b in edges if (b, a) not in edges}
    polygon = [next(iter(follows))]
    while follows[polygon[-1]] != polygon[0]:
        polygon.append(follows[polygon[-1]])
    return polygon


def skirt(border, vertices, corners):
    """Yields four level polygons between the border and the square around it. Cuts run from each corner to the vertex next to it."""
    if sum(vertices[a - 1][0] * vertices[b - 1][1] - vertices[b - 1][0] * vertices[a - 1][1]
           for a, b in zip(border, border[1:] + border[:1])) < 0:
        border = border[::-1]  # the direction of the corners
    cuts = [min(range(len(border)), key=lambda i: math.dist(vertices[border[i] - 1][:2], vertices[corner - 1][:2]))
            for corner in corners]
    for k, first in enumerate(cuts):
        last = cuts[(k + 1) % 4]
        part = border[first:last + 1] if first < last else border[first:] + border[:last + 1]
        yield [*part, corners[(k + 1) % 4], corners[k]]


def shell(obj, d, half):
    """Returns the slab between the mesh, whose border lies at z = 0, and a level bottom at depth d: (vertices [cm, z down], polygons of indices
    from 1, counter-clockwise seen from outside). half: its half width."""
    vertices, triangles = read_obj(obj)
    square = [(-half, -half), (half, -half), (half, half), (-half, half)]
    top, bottom = ([len(vertices) + first + k for k in range(4)] for first in (1, 5))
    vertices = vertices + [(x, y, z) for z in (0.0, d) for x, y in square]
    around = [0, 1, 2, 3, 0]
    sides = [[top[b], top[a], bottom[a], bottom[b]] for a, b in zip(around, around[1:])]
    level = [polygon[::-1] for polygon in skirt(outline(triangles), vertices, top)]
    return vertices, [*triangles, *level, *sides, bottom[::-1]]


def turn(a, b, c):
    """Returns twice the area of the triangle in x and y, above 0 if it is counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def cut(polygon, vertices):
    """Returns the triangles of a polygon. A level polygon is cut ear by ear; any other is convex."""
    at = [vertices[i - 1] for i in polygon]
    if len({p[2] for p in at}) > 1:
        return [[polygon[0], b, c] for b, c in zip(polygon[1:], polygon[2:])]
    ears, left = [], list(range(len(polygon)))
    sign = 1 if sum(p[0] * q[1] - q[0] * p[1] for p, q in zip(at, at[1:] + at[:1])) > 0 else -1
    while len(left) > 2:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            others = (at[i] for i in left if i not in (a, b, c))
            if sign * turn(at[a], at[b], at[c]) > 0 and not any(
                    min(sign * turn(at[a], at[b], p), sign * turn(at[b], at[c], p), sign * turn(at[c], at[a], p)) >= 0 for p in others):
                break
        ears.append([polygon[a], polygon[b], polygon[c]])
        left.remove(b)
    return ears


def write_ply(shape, path, unit):
    """Writes a closed surface as triangles, z up, with `unit` units in a cm."""
    vertices, polygons = shape
    triangles = [three for polygon in polygons for three in ([polygon] if len(polygon) == 3 else cut(polygon, vertices))]
    with open(path, "w", encoding="ascii") as stream:
        stream.write("ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
                     "element face %d\nproperty list uchar int vertex_indices\nend_header\n" % (len(vertices), len(triangles)))
        stream.writelines("%.9g %.9g %.9g\n" % (unit * x, unit * y, -unit * z) for x, y, z in vertices)
        stream.writelines("3 %d %d %d\n" % tuple(i - 1 for i in three) for three in triangles)


def write_poly(shape, body, d, path):
    """Writes tetgen's input: https://wias-berlin.de/software/tetgen/fformats.poly.html. With a body, the body is region 2 and the slab region 1."""
    vertices, polygons = shape
    regions = []
    if body:
        polygons = polygons + [[len(vertices) + i for i in triangle] for triangle in body[1]]
        vertices = vertices + body[0]
        middle = [sum(p[k] for p in body[0]) / len(body[0]) for k in range(3)]
        regions = [(0.9 * HALF_WIDTH, 0.9 * HALF_WIDTH, 0.5 * d), middle]
    with open(path, "w", encoding="ascii") as stream:
        stream.write("%d 3 0 0\n" % len(vertices))
        stream.writelines("%d %.9g %.9g %.9g\n" % (i, *v) for i, v in enumerate(vertices, 1))
        stream.write("%d 0\n" % len(polygons))
        stream.writelines("1\n%d %s\n" % (len(polygon), " ".join(map(str, polygon))) for polygon in polygons)
        stream.write("0\n%d\n" % len(regions))
        stream.writelines("%d %.9g %.9g %.9g %d 0\n" % (i, *p, i) for i, p in enumerate(regions, 1))


def read_tetgen(path, kind):
    """Returns the rows of a .node or .ele file as numbers, without their index."""
    with open(path) as stream:
        rows = [line.split() for line in stream if line.strip() and not line.startswith("#")]
    return [[kind(word) for word in row[1:]] for row in rows[1:]]


def fill(obj, d, stem, body=None):
    """Fills the space between the top and a level bottom at depth d [cm]. Returns (vertices [cm], tetrahedra of indices from 1 with their medium:
    1, or 2 in the body).

    body: a closed mesh as read_obj returns it. stem: of the files to and from tetgen; a dot in its last part would begin a number."""
    write_poly(shell(obj, d, HALF_WIDTH), body, d, stem + ".poly")
    subprocess.run(["tetgen", "-pAQ" if body else "-pQ", stem + ".poly"], check=True, stdout=subprocess.DEVNULL)
    cells = read_tetgen(stem + ".1.ele", float)
    return read_tetgen(stem + ".1.node", float), [[*map(int, cell[:4]), int(cell[4]) if body else 1] for cell in cells]


def write_mmc(mesh, layers, position, direction, path):
    """Writes MMC's input for a pencil beam that is in the slab already. layers: (n, mua, mus, g) of each medium as in .mci, [1/cm]."""
    vertices, tetrahedra = mesh
    media = [{"mua": 0, "mus": 0, "g": 1, "n": 1}]
    media += [{"mua": mua / MM, "mus": mus / MM, "g": g, "n": n} for n, mua, mus, g in layers]
    scene = {"Mesh": {"MeshID": "slab", "InitElem": 1, "MeshNode": [[MM * x for x in v] for v in vertices], "MeshElem": tetrahedra},
             "Domain": {"Media": media},
             "Session": {"Photons": 1, "RNGSeed": 1, "ID": "slab", "DoMismatch": 1},
             "Forward": {"T0": 0, "T1": NS_OF_FLIGHT * 1e-9, "Dt": NS_OF_FLIGHT * 1e-9},
             "Optode": {"Source": {"Pos": [MM * x for x in position], "Dir": direction}}}
    with open(path, "w") as stream:
        json.dump(scene, stream)
