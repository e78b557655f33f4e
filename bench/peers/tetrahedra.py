"""The slab below a mesh, filled with tetrahedra by tetgen, as an input of MMC.

Around the mesh, level, the slab goes on to HALF_WIDTH cm: one that ended with the mesh would lose light through its sides. Where no quality is asked of them, tetgen makes as few tetrahedra as the triangles allow, which is
what MMC flies fastest.

SPDX-License-Identifier: MIT
"""
import json
import math
import subprocess

HALF_WIDTH = 50.0  # of the slab [cm]
NS_OF_FLIGHT = 1000  # more than any packet lives
MM = 10.0  # in a cm


def read_obj(path):
    """(vertices [cm, z down], triangles of indices from 1) of an OBJ file that says no more."""
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
    """The border as a polygon of indices from 1: the edges that only one triangle has, one behind the other."""
    edges = {edge for a, b, c in triangles for edge in ((a, b), (b, c), (c, a))}
    follows = {a: b for a, b in edges if (b, a) not in edges}
    polygon = [next(iter(follows))]
    while follows[polygon[-1]] != polygon[0]:
        polygon.append(follows[polygon[-1]])
    return polygon


def skirt(border, vertices, corners):
    """Four level polygons between the border and the square around it, cut from each corner to the vertex next to it."""
    if sum(vertices[a - 1][0] * vertices[b - 1][1] - vertices[b - 1][0] * vertices[a - 1][1]
           for a, b in zip(border, border[1:] + border[:1])) < 0:
        border = border[::-1]  # as the corners go round
    cuts = [min(range(len(border)), key=lambda i: math.dist(vertices[border[i] - 1][:2], vertices[corner - 1][:2]))
            for corner in corners]
    for k, first in enumerate(cuts):
        last = cuts[(k + 1) % 4]
        part = border[first:last + 1] if first < last else border[first:] + border[:last + 1]
        yield [*part, corners[(k + 1) % 4], corners[k]]


def write_poly(obj, d, path):
    """tetgen's input: https://wias-berlin.de/software/tetgen/fformats.poly.html. The mesh's border lies at z = 0."""
    vertices, triangles = read_obj(obj)
    square = [(-HALF_WIDTH, -HALF_WIDTH), (HALF_WIDTH, -HALF_WIDTH), (HALF_WIDTH, HALF_WIDTH), (-HALF_WIDTH, HALF_WIDTH)]
    top, bottom = ([len(vertices) + first + k for k in range(4)] for first in (1, 5))
    vertices = vertices + [(x, y, z) for z in (0.0, d) for x, y in square]
    around = [0, 1, 2, 3, 0]
    sides = [[top[a], top[b], bottom[b], bottom[a]] for a, b in zip(around, around[1:])]
    polygons = [*triangles, *skirt(outline(triangles), vertices, top), *sides, bottom]
    with open(path, "w", encoding="ascii") as stream:
        stream.write("%d 3 0 0\n" % len(vertices))
        stream.writelines("%d %.9g %.9g %.9g\n" % (i, *v) for i, v in enumerate(vertices, 1))
        stream.write("%d 0\n" % len(polygons))
        stream.writelines("1\n%d %s\n" % (len(polygon), " ".join(map(str, polygon))) for polygon in polygons)
        stream.write("0\n0\n")


def read_tetgen(path, kind):
    """Rows of numbers, without their index, of a .node or .ele file."""
    with open(path) as stream:
        rows = [line.split() for line in stream if line.strip() and not line.startswith("#")]
    return [[kind(word) for word in row[1:]] for row in rows[1:]]


def fill(obj, d, stem):
    """(vertices [cm], tetrahedra of indices from 1) between the top and a level bottom at depth d [cm]. stem: of the files
    to and from tetgen; in its last part a dot would begin a number."""
    write_poly(obj, d, stem + ".poly")
    subprocess.run(["tetgen", "-pQ", stem + ".poly"], check=True, stdout=subprocess.DEVNULL)
    return read_tetgen(stem + ".1.node", float), read_tetgen(stem + ".1.ele", int)


def write_mmc(mesh, layer, position, direction, path):
    """MMC's input for a pencil beam that is in the slab already. layer: (n, mua, mus, g, d) as in .mci, [1/cm]."""
    vertices, tetrahedra = mesh
    n, mua, mus, g, _ = layer
    media = [{"mua": 0, "mus": 0, "g": 1, "n": 1}, {"mua": mua / MM, "mus": mus / MM, "g": g, "n": n}]
    scene = {"Mesh": {"MeshID": "slab", "InitElem": 1, "MeshNode": [[MM * x for x in v] for v in vertices],
                      "MeshElem": [t + [1] for t in tetrahedra]},
             "Domain": {"Media": media},
             "Session": {"Photons": 1, "RNGSeed": 1, "ID": "slab", "DoMismatch": 1},
             "Forward": {"T0": 0, "T1": NS_OF_FLIGHT * 1e-9, "Dt": NS_OF_FLIGHT * 1e-9},
             "Optode": {"Source": {"Pos": [MM * x for x in position], "Dir": direction}}}
    with open(path, "w") as stream:
        json.dump(scene, stream)
