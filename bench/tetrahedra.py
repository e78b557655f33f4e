"""The slab below a rough top of rough.py, filled with tetrahedra by tetgen, as an input of MMC.

The top spans 4 x 4 cm; around it, level, the slab goes on to HALF_WIDTH cm: one that ended with the top would lose light
through its sides. Where no quality is asked of them, tetgen makes as few tetrahedra as the triangles allow, which is
what MMC flies fastest.

SPDX-License-Identifier: MIT
"""
import json
import subprocess

HALF_WIDTH = 50.0  # of the slab [cm]
NS_OF_FLIGHT = 1000  # more than any packet lives
MM = 10.0  # in a cm


def read_grid(obj):
    """(vertices [cm, z down], triangles of indices from 1, cells on a side) of an OBJ file of rough.py."""
    vertices, triangles = [], []
    with open(obj) as stream:
        for words in map(str.split, stream):
            if words[0] == "v":
                x, y, up = map(float, words[1:])
                vertices.append((x, y, 0.0 - up))
            elif words[0] == "f":
                triangles.append([int(word) for word in words[1:]])
    return vertices, triangles, round((len(triangles) / 2) ** 0.5)


def facets(triangles, cells):
    """Polygons of indices from 1 around the slab; its eight corners follow the (cells + 1)^2 vertices of the top."""
    row = cells + 1
    top, bottom = ([row * row + first + k for k in range(4)] for first in (1, 5))
    borders = [range(1, row + 1), range(row, row * row + 1, row), range(row * row, row * cells, -1),
               range(row * cells + 1, 0, -row)]
    around = [0, 1, 2, 3, 0]
    skirt = [[*border, top[b], top[a]] for border, a, b in zip(borders, around, around[1:])]
    sides = [[top[a], top[b], bottom[b], bottom[a]] for a, b in zip(around, around[1:])]
    return triangles + skirt + sides + [bottom]


def write_poly(obj, d, path):
    """tetgen's input: https://wias-berlin.de/software/tetgen/fformats.poly.html"""
    vertices, triangles, cells = read_grid(obj)
    square = [(-HALF_WIDTH, -HALF_WIDTH), (HALF_WIDTH, -HALF_WIDTH), (HALF_WIDTH, HALF_WIDTH), (-HALF_WIDTH, HALF_WIDTH)]
    vertices = vertices + [(x, y, z) for z in (0.0, d) for x, y in square]
    polygons = facets(triangles, cells)
    with open(path, "w") as stream:
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
