"""Situations in which methods may fail: the scenes of the atlas, the aims of their packets, and the expected outcome.

build(DIR, full) writes the files and returns the situations. Lengths are in cm. Media are thin enough that packets often cross boundaries, because
only a crossing can go wrong. Only the standard library is needed."""
import math
import os
import random

# situations without a mesh version: some would need 1e7 triangles, and meshes of spheres and cylinders 1e-6 cm apart would intersect
NO_MESH = {"rings-1e5", "beads-1e4", "nested-spheres-1e-6cm", "nested-cylinders-1e-6cm", "body-1e-6cm-below-plane"}


class Situation:
    """A scene of the atlas. aims: where packets aim (tests/stability/atlas.c). refused: words of the program's refusal, or None if the scene is
    accepted. big: the scene takes minutes to read and to check."""

    def __init__(self, name, mci, aims=("face",), refused=None, big=False):
        self.name, self.mci, self.aims, self.refused, self.big = name, mci, aims, refused, big

    def path(self, directory):
        return os.path.join(directory, self.name + ".mci")


def scene(layers, surfaces=None, above=1.0, below=1.0, beam=None, photons=20000, bodies=()):
    """Returns the text of a scene. layers: (n, mua, mus, g, d); surfaces: {boundary: its line}; bodies: lines after the last layer."""
    surfaces = surfaces or {}
    lines = ["1.0", "1", "out.mco A", str(photons), "0.01 0.01", "10 10 1"] + ([beam] if beam else [])
    lines += [str(len(layers)), repr(above)]
    for i, layer in enumerate(layers):
        lines += [surfaces[i]] if i in surfaces else []
        lines.append(" ".join(repr(x) for x in layer))
    lines += bodies
    lines += [surfaces[len(layers)]] if len(layers) in surfaces else []
    return "\n".join(lines + [repr(below)]) + "\n"


def rings(heights, spacing):
    spacing = spacing if isinstance(spacing, list) else [spacing] * len(heights)
    return f"b {len(heights)} " + " ".join(f"{h!r} {s!r}" for h, s in zip(heights, spacing))


def noise(n, size, seed=1):
    dice = random.Random(seed)
    return [dice.uniform(-size, size) for _ in range(n - 1)] + [0.0]


# --- meshes ---

def obj(vertices, triangles):
    return ("".join("v %r %r %r\n" % tuple(v) for v in vertices) +
            "".join("f %d %d %d\n" % tuple(i + 1 for i in t) for t in triangles))


def grid_mesh(nx, ny, width, depth, height, seed=1, shift=(0.0, 0.0)):
    """Returns a rough sheet of width x depth with nx x ny cells, flat at its border."""
    dice = random.Random(seed)
    vertices, triangles = [], []
    for i in range(nx + 1):
        for j in range(ny + 1):
            inner = 0 < i < nx and 0 < j < ny
            vertices.append(((i / nx - 0.5) * width + shift[0], (j / ny - 0.5) * depth + shift[1],
                             dice.uniform(-height, height) if inner else 0.0))
    for i in range(nx):
        for j in range(ny):
            a = i * (ny + 1) + j
            b, c, d = a + ny + 1, a + ny + 2, a + 1
            triangles += [(a, b, c), (a, c, d)]
    return vertices, triangles


def write_large_grid(path, cells, width, height, seed=1):
    """Writes obj(*grid_mesh(cells, cells, width, width, height, seed)) row by row, so that 1e7 triangles take no memory."""
    dice = random.Random(seed)
    places = [repr((i / cells - 0.5) * width) for i in range(cells + 1)]
    with open(path, "w", encoding="ascii") as file:
        for i, x in enumerate(places):
            inner = [repr(dice.uniform(-height, height)) if 0 < i < cells else "0.0" for _ in range(cells - 1)]
            file.write("".join([f"v {x} {y} {z}\n" for y, z in zip(places, ["0.0", *inner, "0.0"])]))
        for a in range(1, cells * (cells + 1), cells + 1):
            b = a + cells + 1
            file.write("".join([f"f {a + k} {b + k} {b + k + 1}\nf {a + k} {b + k + 1} {a + k + 1}\n"
                                for k in range(cells)]))


def moved(mesh, reach, seed=1):
    """Returns the sheet with its inner vertices moved by up to `reach` in x and y, so that the grid is no longer regular."""
    dice = random.Random(seed)
    vertices, triangles = mesh
    ends = [max(abs(v[axis]) for v in vertices) for axis in (0, 1)]
    return [(x + dice.uniform(-reach, reach), y + dice.uniform(-reach, reach), z)
            if abs(x) < ends[0] and abs(y) < ends[1] else (x, y, z) for x, y, z in vertices], triangles


def spiked(mesh, i, height):
    """Returns the sheet with vertex i raised."""
    x, y, z = mesh[0][i]
    return mesh[0][:i] + [(x, y, z + height)] + mesh[0][i + 1:], mesh[1]


def corner_cube(size):
    """Returns three faces at right angles to one another, deepest in the middle: light from above returns in its own direction."""
    corners = [(size * math.cos(a), size * math.sin(a), 0.0) for a in (0.0, 2 * math.pi / 3, 4 * math.pi / 3)]
    return corners + [(0.0, 0.0, -size / math.sqrt(2))], [(0, 1, 3), (1, 2, 3), (2, 0, 3)]


def mushroom(n, stem, cap, height):
    """Returns rings of n vertices: foot, stem, underside of the cap, its rim and its top. The mesh overhangs with edges of 90 degrees."""
    profile = [(2 * cap, 0.0), (stem, 0.0), (stem, height), (cap, height), (cap, 1.5 * height)]
    vertices = [(r * math.cos(2 * math.pi * k / n), r * math.sin(2 * math.pi * k / n), z) for r, z in profile
                for k in range(n)] + [(0.0, 0.0, 1.5 * height)]
    triangles = []
    for ring in range(len(profile) - 1):
        for k in range(n):
            a, b = ring * n + k, ring * n + (k + 1) % n
            triangles += [(a, b, b + n), (a, b + n, a + n)]
    last = (len(profile) - 1) * n
    return vertices, triangles + [(last + k, last + (k + 1) % n, len(vertices) - 1) for k in range(n)]


def icosphere_pole(n):
    """Returns a dome with one vertex on the axis, where a beam along the axis strikes it."""
    vertices, triangles = [(0.0, 0.0, 0.5)], []
    for ring in range(1, 5):
        for k in range(n):
            angle, tilt = 2 * math.pi * k / n, math.pi / 8 * ring
            vertices.append((0.5 * math.sin(tilt) * math.cos(angle), 0.5 * math.sin(tilt) * math.sin(angle),
                             0.0 if ring == 4 else 0.5 * math.cos(tilt)))
    triangles += [(0, 1 + k, 1 + (k + 1) % n) for k in range(n)]
    for ring in range(3):
        for k in range(n):
            a, b = 1 + ring * n + k, 1 + ring * n + (k + 1) % n
            triangles += [(a, a + n, b + n), (a, b + n, b)]
    return vertices, triangles


# --- situations ---

TURBID = (1.4, 0.1, 2.0, 0.9, 1.0)
AIMED = ("face", "edge", "vertex", "drop", "along")
GRAZING = tuple(f"1e-{k}" for k in range(2, 8))
HILLS = noise(30, 0.03)


def slab(surface, medium=TURBID, **more):
    return scene([medium], {0: surface}, **more)


def fields():
    """Yields situations with radial heightfields and planes."""
    fine = noise(200, 2e-7, 3)
    ramp = [0.02 * math.sin(i / 900.0) for i in range(99999)] + [0.0]
    thin = [h + 1e-5 for h in HILLS]
    yield Situation("planes", scene([TURBID, (1.0, 0.0, 0.0, 0.0, 0.5), (1.5, 1.0, 10.0, 0.0, 0.2)]))
    yield Situation("grazing-rings", slab(rings(HILLS, 0.03)), GRAZING)
    yield Situation("ridges-and-tip", slab(rings(HILLS, 0.03)), AIMED)
    yield Situation("cone-tip", slab(rings([0.5, 0.0], 0.05)), AIMED)
    yield Situation("pit-tip", slab(rings([-0.5, 0.0], 0.05)), AIMED)
    yield Situation("walls-1e3", slab(rings([0.1 * (i % 2) for i in range(40)] + [0.0], 1e-4)), AIMED)
    yield Situation("walls-5e3", slab(rings([0.1 * (i % 2) for i in range(40)] + [0.0], 2e-5)), AIMED)
    yield Situation("walls-1e4", slab(rings([0.1 * (i % 2) for i in range(40)] + [0.0], 1e-5)), refused="slope")
    yield Situation("rings-1e-6cm", slab(rings(fine, 1e-6), (1.4, 1e5, 1e6, 0.9, 1e-3)), AIMED)
    yield Situation("rings-1e-6cm-far", scene([TURBID], {0: rings(noise(200, 1e-6, 3) + [0.0, 0.0],
                                                                    [1e-6] * 200 + [1.0, 1.0])}), AIMED)
    yield Situation("rings-1e5", slab(rings(ramp, 1e-4)), AIMED)
    yield Situation("layer-1e-5cm", scene([(1.4, 0.1, 10.0, 0.5, 1e-5), (1.5, 0.1, 10.0, 0.5, 1.0)],
                                          {0: rings(HILLS, 0.03), 1: rings(HILLS, 0.03)}), AIMED)
    yield Situation("touching-planes", scene([TURBID, (1.5, 0.1, 2.0, 0.5, 0.0), TURBID]))
    yield Situation("touching-fields", scene([(1.4, 0.1, 10.0, 0.5, 0.1), TURBID],
                                             {0: rings([-0.1, 0.0], 0.1)}), refused="touch")
    yield Situation("crossing-fields", scene([(1.4, 0.1, 10.0, 0.5, 0.01), TURBID], {0: rings(HILLS, 0.03)}),
                    refused="cross")
    for k in (-4, 0, 4):
        mu = 10.0 ** -k
        yield Situation(f"mean-free-path-1e{k}", slab(rings(HILLS, 0.03), (1.4, mu / 100, mu, 0.5, 1.0)))
    for g in (-1.0, -0.999, 0.999, 1.0):
        yield Situation(f"g={g:g}", slab(rings(HILLS, 0.03), (1.4, 0.1, 10.0, g, 1.0)))
    for n in (1.0, 1.0000001, 2.0, 4.0):
        yield Situation(f"n={n:g}" if n != 1.0000001 else "n-all-but-matched",
                        slab(rings(HILLS, 0.03), (n, 0.1, 10.0, 0.5, 1.0)), ("face", "vertex", "1e-4"))
    yield Situation("wide-1e3cm", slab(rings(noise(30, 30.0), 30.0), (1.4, 1e-4, 2e-3, 0.9, 1000.0)), AIMED)
    yield Situation("groove-1deg", scene([(1.5, 0.0, 0.0, 0.0, 2.0)], {1: rings([1.0, 0.0], 0.00873)}), AIMED)
    yield Situation("scale-1e-6", slab(rings([h * 1e-6 for h in HILLS], 0.03e-6), (1.4, 1e5, 2e6, 0.9, 1e-6)), AIMED)


def mesh_lines(directory):
    """Writes the meshes. Returns their names without .obj."""
    wedge = grid_mesh(24, 24, 2.0, 2.0, 0.05)
    meshes = {
        "rough": wedge,
        "irregular": moved(wedge, 0.25 * 2.0 / 24),
        "spiked": spiked(grid_mesh(24, 24, 2.0, 2.0, 0.01), 6 * 25 + 6, 0.3),
        "needles": grid_mesh(2, 400, 200.0, 4.0, 1e-3, 5),
        "grooves": grid_mesh(4, 400, 100.0, 4.0, 4e-3, 6),
        "corner": corner_cube(0.5),
        "mushroom": mushroom(24, 0.1, 0.3, 0.2),
        "mushroom-coarse": mushroom(5, 0.1, 0.3, 0.2),
        "mushroom-fine": mushroom(300, 0.1, 0.3, 0.2),
        "dome": icosphere_pole(10),
        "fine": grid_mesh(60, 60, 6e-3, 6e-3, 3e-5, 7, (100.0, 0.0)),
        "fine-near": grid_mesh(60, 60, 6e-3, 6e-3, 3e-5, 7),
        "wide": grid_mesh(40, 40, 1e3, 1e3, 10.0, 8),
        "flat": grid_mesh(20, 20, 2.0, 2.0, 0.0),
        "walls": grid_mesh(40, 40, 4e-3, 4e-3, 0.05, 9),
        "walls-steepest": grid_mesh(40, 40, 4e-3, 4e-3, 0.17, 9),
        "twice": (wedge[0], wedge[1] + wedge[1][:1]),
        "degenerate": (wedge[0], wedge[1] + [(0, 0, 5), (7, 7, 7)]),
        "hole": (wedge[0], wedge[1][:300] + wedge[1][301:]),
        "flipped": (wedge[0], [t if i % 3 else t[::-1] for i, t in enumerate(wedge[1])]),
        "soup": ([wedge[0][i] for t in wedge[1] for i in t],
                 [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(len(wedge[1]))]),
    }
    for name, (vertices, triangles) in meshes.items():
        with open(os.path.join(directory, name + ".obj"), "w", encoding="ascii") as file:
            file.write(obj(vertices, triangles))
    return {name: f'm "{name}.obj"' for name in meshes}


def sheets(line):
    """Yields situations with open triangle meshes. line: {name: its line in the .mci}."""
    yield Situation("grazing-mesh", slab(line["rough"]), GRAZING)
    yield Situation("vertices-and-edges", slab(line["rough"]), AIMED)
    yield Situation("irregular-mesh", slab(line["irregular"]), AIMED + GRAZING[::2])
    yield Situation("spiked-mesh", slab(line["spiked"]), AIMED + GRAZING[::2])
    yield Situation("needles-1e4", slab(line["needles"]), AIMED)
    yield Situation("grooves-1e3", slab(line["grooves"]), AIMED)
    yield Situation("mesh-walls-1e3", slab(line["walls"]), AIMED)
    yield Situation("mesh-walls-5e3", slab(line["walls-steepest"]), AIMED)
    yield Situation("mesh-layer-1e-5cm", scene([(1.4, 0.1, 10.0, 0.5, 1e-5), (1.5, 0.1, 10.0, 0.5, 1.0)],
                                               {0: line["rough"], 1: line["rough"]}), AIMED)
    yield Situation("features-1e-4cm-at-1e2cm", slab(line["fine"], (1.4, 30.0, 1e3, 0.5, 1.0),
                                                     beam="beam pencil at=100,0"), AIMED)
    yield Situation("features-1e-4cm-beam-1e2cm-off", slab(line["fine-near"], (1.4, 30.0, 1e3, 0.5, 1.0),
                                                           beam="beam pencil at=100,0"), AIMED)
    yield Situation("mesh-wide-1e3cm", slab(line["wide"], (1.4, 1e-4, 2e-3, 0.9, 1000.0)), AIMED)
    yield Situation("corner-cube-clear", scene([(4.0, 0.0, 0.0, 0.0, 1.0)], {1: line["corner"]}), AIMED)
    yield Situation("corner-cube", scene([(4.0, 0.01, 0.1, 0.0, 1.0)], {1: line["corner"]}), AIMED)
    yield Situation("overhang", slab(line["mushroom"]), AIMED + ("1e-4",))
    yield Situation("overhang-coarse", slab(line["mushroom-coarse"]), AIMED + GRAZING[::2])
    yield Situation("overhang-fine", slab(line["mushroom-fine"]), AIMED + GRAZING[::2])
    yield Situation("overhang-pencil-on-rim", slab(line["mushroom"], beam="beam pencil at=0.3,0"))
    yield Situation("overhang-pencil-on-edge", slab(line["mushroom"], beam="beam pencil at=0.2,0"))
    yield Situation("overhang-below", scene([TURBID], {1: line["mushroom"]}), AIMED)
    yield Situation("overhang-n=1", scene([(1.0, 0.1, 10.0, 0.5, 1.0)], {0: line["mushroom"]}), AIMED)
    yield Situation("pole-of-a-dome", slab(line["dome"] + " normals=vertex"), AIMED)
    yield Situation("dome-n=1-smooth", slab(line["dome"] + " normals=vertex", (1.0, 10.0, 1e3, 0.5, 1.0)), AIMED)
    yield Situation("smooth-rough", slab(line["rough"] + " normals=vertex"), AIMED + GRAZING[::2])
    yield Situation("flat-mesh", slab(line["flat"]), AIMED)
    yield Situation("degenerate-triangles", slab(line["degenerate"]), AIMED)
    yield Situation("turned-triangles", slab(line["flipped"]), AIMED)
    yield Situation("triangles-alone", slab(line["soup"]), AIMED)
    yield Situation("duplicate-triangle", slab(line["twice"]), refused="edge")
    yield Situation("hole", slab(line["hole"]), refused="hole")
    yield Situation("touching-meshes", scene([(1.4, 0.1, 10.0, 0.5, 0.0), TURBID],
                                             {0: line["rough"], 1: line["rough"]}), refused="touch")
    yield Situation("crossing-meshes", scene([(1.4, 0.1, 10.0, 0.5, 0.01), TURBID], {0: line["rough"]}),
                    refused="cross")


def tile_lines(directory):
    """Writes heightmaps that are repeated. Returns their names without .asc."""
    def rough(nx, ny, height, seed=1):
        """Returns a random heightmap that is lower at one end, so that no step is higher than the one across the seam."""
        dice = random.Random(seed)
        return [[dice.uniform(-height, height) * (0.5 if (i == 0 or j == 0) and nx > 2 else 1) for i in range(nx)]
                for j in range(ny)]
    waves = [[0.02 * math.sin(2 * math.pi * i / 32) for i in range(32)]] * 2
    maps = {
        "tile": (rough(24, 24, 0.05), 2.0 / 24),
        "tile-fine": (rough(20, 30, 2e-4), 1e-3),
        "tile-2x2": (rough(2, 2, 0.02), 0.05),
        "tile-odd": (rough(7, 5, 0.02), 0.05),
        "tile-waves": (waves, 0.01),
        "tile-walls": (rough(16, 16, 5e-3), 1e-4),
        "tile-far": (rough(40, 40, 3e-5), 1e-4),
    }
    for name, (rows, cell) in maps.items():
        with open(os.path.join(directory, name + ".asc"), "w", encoding="ascii") as file:
            file.write(f"ncols {len(rows[0])}\nnrows {len(rows)}\ncellsize {cell!r}\n")
            file.writelines(" ".join(map(repr, row)) + "\n" for row in rows)
    return {name: f'm "{name}.asc" units=cm tile' for name in maps}


def tiles(line):
    """Yields situations with heightmaps repeated over the whole plane.

    Packets are aimed at copies up to 20 periods from the middle, half of them at the seams. Packets that graze fly over many copies. No packet is
    aimed along the straight waves, because a packet that flies exactly along them never leaves."""
    yield Situation("tile", slab(line["tile"]), AIMED + GRAZING)
    yield Situation("tile-below", scene([TURBID], {1: line["tile"]}), AIMED)
    yield Situation("tile-many-periods", slab(line["tile-fine"], (1.4, 0.01, 0.2, 0.9, 1.0)), AIMED + GRAZING[::2])
    yield Situation("tile-2x2", slab(line["tile-2x2"]), AIMED + GRAZING[::2])
    yield Situation("tile-odd", slab(line["tile-odd"]), AIMED)
    yield Situation("tile-mirror", slab(line["tile-odd"] + "=mirror"), AIMED)
    yield Situation("tile-waves", slab(line["tile-waves"]), AIMED[:-1] + ("1e-4",))
    yield Situation("tile-walls-1e2", slab(line["tile-walls"]), AIMED)
    yield Situation("tile-smooth", slab(line["tile"] + " normals=vertex"), AIMED)
    yield Situation("tile-n=1", scene([(1.0, 0.1, 10.0, 0.5, 1.0)], {0: line["tile"]}), AIMED)
    yield Situation("tile-clear", scene([(1.5, 0.0, 0.0, 0.0, 0.2), TURBID], {0: line["tile"], 1: line["tile"]}), AIMED)
    yield Situation("tile-layer-1e-5cm", scene([(1.4, 0.1, 10.0, 0.5, 1e-5), (1.5, 0.1, 10.0, 0.5, 1.0)],
                                               {0: line["tile"], 1: line["tile"]}), AIMED)
    yield Situation("tile-features-1e-4cm-at-1e2cm", slab(line["tile-far"], (1.4, 30.0, 1e3, 0.5, 1.0),
                                                          beam="beam pencil at=100,0"), AIMED)
    yield Situation("tile-over-mesh", scene([(1.4, 0.1, 10.0, 0.5, 0.02), TURBID],
                                            {0: line["tile"], 1: 'm "rough.obj"'}), refused="of which one is a tile")
    yield Situation("tiles-touching", scene([(1.4, 0.1, 10.0, 0.5, 0.0), TURBID],
                                            {0: line["tile"], 1: line["tile"]}), refused="touch")
    yield Situation("tiles-crossing", scene([(1.4, 0.1, 10.0, 0.5, 0.01), TURBID],
                                            {0: line["tile"], 1: line["tile"] + "=mirror"}), refused="tile")


# --- bodies ---

BODY = (1.6, 0.1, 2.0, 0.5)


def inside(line, medium=BODY):
    return "i " + line + " " + " ".join(map(repr, medium))


def sphere(x, y, z, r, medium=BODY):
    return inside(f"sphere {x!r} {y!r} {z!r} {r!r}", medium)


def cylinder(ends, r, medium=BODY):
    return inside("cylinder " + " ".join(map(repr, ends)) + f" {r!r}", medium)


def box(size):
    """Returns a box of twelve triangles with corners of 90 degrees."""
    vertices = [(size * i, size * j, size * k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return vertices, [t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]


def stone(n, radius, height, seed=1):
    """Returns a ball of n rings of 2 n vertices, each moved along its radius by up to `height`."""
    dice = random.Random(seed)
    vertices = [(0.0, 0.0, radius)]
    for i in range(1, n):
        for k in range(2 * n):
            tilt, turn, r = math.pi * i / n, math.pi * k / n, radius + dice.uniform(-height, height)
            vertices.append((r * math.sin(tilt) * math.cos(turn), r * math.sin(tilt) * math.sin(turn),
                             r * math.cos(tilt)))
    vertices.append((0.0, 0.0, -radius))
    last, m = len(vertices) - 1, 2 * n
    triangles = []
    for k in range(m):
        a, b = k, (k + 1) % m
        triangles += [(0, 1 + a, 1 + b), (last, last - m + b, last - m + a)]
        for ring in range(n - 2):
            i, j = 1 + ring * m + a, 1 + ring * m + b
            triangles += [(i, i + m, j + m), (i, j + m, j)]
    return vertices, triangles


def closed(mesh, depth):
    """Returns a sheet closed by a floor, which runs from its border to one vertex below."""
    vertices, triangles = mesh
    edges = {(t[i], t[(i + 1) % 3]) for t in triangles for i in range(3)}
    border = [(a, b) for a, b in edges if (b, a) not in edges]
    return vertices + [(0.0, 0.0, -depth)], triangles + [(b, a, len(vertices)) for a, b in sorted(border)]


def mushroom_body(cap):
    return closed(mushroom(24, 0.05, cap, 0.2), 0.1)


def joined(*meshes):
    """Returns one mesh of several parts, each moved by its (x, y, z)."""
    vertices, triangles = [], []
    for (points, faces), (dx, dy, dz) in meshes:
        triangles += [tuple(i + len(vertices) for i in t) for t in faces]
        vertices += [(x + dx, y + dy, z + dz) for x, y, z in points]
    return vertices, triangles


def body_files(directory):
    """Writes closed meshes, which lie in the middle of a layer of 1 cm. Returns their names without .obj."""
    needles = [(x * 30, y, z) for x, y, z in stone(16, 0.01, 0.002)[0]]
    here = (0.0, 0.0, 0.0)
    inner = [(x * (1 - 1e-6), y * (1 - 1e-6), z * (1 - 1e-6)) for x, y, z in stone(12, 0.3, 0.05)[0]]
    meshes = {
        "parts": joined((stone(12, 0.15, 0.03), (-0.2, 0.0, 0.1)), (box(0.1), (0.2, 0.05, 0.0)), (stone(6, 0.1, 0.03, 2), (0.0, 0.3, -0.2)),
                        (mushroom_body(0.1), (0.0, -0.35, 0.0))),
        "shells": joined((stone(12, 0.3, 0.03), here), (stone(8, 0.2, 0.03, 2), here), (box(0.07), here), (stone(6, 0.04, 0.01, 3), here)),
        "shell-1e-6": joined((stone(12, 0.3, 0.05), here), ((inner, stone(12, 0.3, 0.05)[1]), here)),
        "boxes-1e-9": joined((box(0.1), (-0.1, 0.0, 0.0)), (box(0.1), (0.1 + 1e-9, 0.03, 0.02)), (box(0.1), (-0.12, 0.05, 0.2 + 1e-9))),
        "union": joined((stone(12, 0.2, 0.04), (-0.05, 0.0, 0.0)), (stone(8, 0.15, 0.03, 2), (0.1, 0.1, 0.1)), (box(0.13), (0.07, -0.05, -0.05)),
                        (stone(6, 0.05, 0.01, 3), (-0.05, 0.0, 0.0)), ((needles, stone(16, 0.01, 0.002)[1]), here)),
        "union-boxes": joined((box(0.1), here), (box(0.1), (0.07, 0.03, 0.0)), (box(0.05), (0.22, 0.01, 0.02)), (box(0.06), here),
                              (box(0.1), (-0.2 - 1e-9, 0.03, 0.02))),
        "crossing": joined((box(0.1), here), (box(0.1), (0.05, 0.03, 0.02))),
        "box": box(0.2),
        "stone": stone(12, 0.3, 0.05),
        "stone-inside": (inner, stone(12, 0.3, 0.05)[1]),
        "needle": (needles, stone(16, 0.01, 0.002)[1]),
        "bottle": mushroom_body(0.3),
        "torn": (stone(12, 0.3, 0.05)[0], stone(12, 0.3, 0.05)[1][:-1]),
    }
    for name, (vertices, triangles) in meshes.items():
        with open(os.path.join(directory, name + ".obj"), "w", encoding="ascii") as file:
            file.write(obj([(x, y, z - 0.5) for x, y, z in vertices], triangles))
    return {name: f'"{name}.obj"' for name in meshes}


def round_bodies():
    """Yields situations with spheres and cylinders. Their edges and vertices are poles, seams, rims, and circles in the planes of the axes. `along`
    and angles to the surface aim along tangents."""
    def of(bodies, medium=TURBID, **more):
        return scene([medium], bodies=bodies, **more)
    oblique, upright, level = (-0.2, 0.3, 0.2, 0.4, -0.1, 0.7), (0.1, 0.0, 0.2, 0.1, 0.0, 0.8), (-0.7, 0.1, 0.5, 0.7, 0.1, 0.5)
    shells = [1e-6 * i for i in range(4)]
    clear = (1.6, 0.0, 0.0, 0.0)
    beads = [sphere(0.01 * (i % 50) - 0.245, 0.01 * (i // 50 % 50) - 0.245, 0.02 + 0.02 * (i // 2500), 0.0045,
                    (1.9, 2.0, 50.0, 0.0) if i % 2 else (1.0, 0.0, 0.0, 0.0)) for i in range(10000)]
    every = AIMED + GRAZING
    yield Situation("sphere", of([sphere(0.1, 0.2, 0.5, 0.3)]), every)
    yield Situation("cylinder-oblique", of([cylinder(oblique, 0.15)]), every)
    yield Situation("cylinder-upright", of([cylinder(upright, 0.15)]), AIMED + GRAZING[::2])
    yield Situation("cylinder-level", of([cylinder(level, 0.15)]), AIMED + GRAZING[::2])
    yield Situation("cylinder-wire", of([cylinder((-3.0, 0.1, 0.5, 3.0, 0.2, 0.4), 1e-3)]), AIMED)
    yield Situation("cylinder-disk", of([cylinder((0.1, 0.0, 0.5, 0.10001, 0.0, 0.50005), 0.3)]), AIMED)
    yield Situation("sphere-air", of([sphere(0.1, 0.2, 0.5, 0.3, (1.0, 0.0, 0.0, 0.0))], (1.5, 0.1, 2.0, 0.5, 1.0)), every)
    yield Situation("sphere-clear", of([sphere(0.1, 0.2, 0.5, 0.3, clear)], (1.0, 0.01, 0.2, 0.5, 1.0)), AIMED)
    yield Situation("sphere-n=1", of([sphere(0.0, 0.0, 0.5, 0.3, (1.0, 0.5, 10.0, 0.5))], (1.0, 0.1, 2.0, 0.5, 1.0)), every)
    yield Situation("cylinder-n=1", of([cylinder(oblique, 0.15, (1.0, 0.5, 10.0, 0.5))], (1.0, 0.1, 2.0, 0.5, 1.0)),
                    AIMED + GRAZING[::2])
    yield Situation("nested-spheres-1e-6cm", of([sphere(0.1, 0.2, 0.5, 0.3 - d, (1.3 + 1e5 * d, 0.1, 2.0, 0.5))
                                                 for d in shells]), every)
    yield Situation("nested-cylinders-1e-6cm",
                    of([cylinder((0.1, 0.0, 0.2 + d, 0.1, 0.0, 0.8 - d), 0.15 - d, (1.3 + 1e5 * d, 0.1, 2.0, 0.5))
                        for d in shells]), every)
    yield Situation("nested-ball-in-tube", of([cylinder(level, 0.1), sphere(0.0, 0.1, 0.5, 0.09, (1.0, 0.0, 0.0, 0.0)),
                                               sphere(0.03, 0.1, 0.5, 0.05, BODY)]), AIMED)
    yield Situation("body-1e-6cm-below-plane", of([sphere(0.0, 0.0, 0.300001, 0.3),
                                                   cylinder((0.5, 0.0, 1e-6, 0.5, 0.0, 1 - 1e-6), 0.1)]), AIMED)
    yield Situation("beads-1e4", scene([(1.5, 0.5, 10.0, 0.8, 0.1)], bodies=beads), AIMED + GRAZING[::2])
    yield Situation("sphere-scale-1e-6", of([sphere(1e-7, 2e-7, 5e-7, 3e-7, (1.6, 1e5, 2e6, 0.5))],
                                            (1.4, 1e5, 2e6, 0.9, 1e-6)), AIMED)
    yield Situation("sphere-1e-4cm-at-1e2cm", of([sphere(100.0, 0.0, 0.5, 1e-4, (1.6, 30.0, 1e3, 0.5)),
                                                  cylinder((100.001, 0.0, 0.5, 100.002, 0.0, 0.5), 1e-4)],
                                                 (1.4, 30.0, 1e3, 0.5, 1.0), beam="beam pencil at=100,0"), AIMED)
    yield Situation("sphere-wide-1e3cm", of([sphere(100.0, 0.0, 500.0, 300.0, (1.6, 1e-4, 2e-3, 0.5))],
                                            (1.4, 1e-4, 2e-3, 0.9, 1000.0)), AIMED)
    yield Situation("sphere-mean-free-path-1e-4", of([sphere(0.1, 0.2, 0.5, 0.3, (1.6, 1e2, 1e4, 0.5))]), AIMED)
    yield Situation("spheres-touching", of([sphere(0.0, 0.0, 0.5, 0.2), sphere(0.4, 0.0, 0.5, 0.2)]), refused="meets")
    yield Situation("sphere-through-cylinder", of([sphere(0.0, 0.0, 0.5, 0.2), cylinder(level, 0.15)]), refused="meets")
    yield Situation("sphere-through-plane", of([sphere(0.0, 0.0, 0.2, 0.3)]), refused="meets")


def mesh_bodies(line, body):
    """Yields situations with closed meshes. line: {name: line of a boundary}; body: {name: words that name a body}."""
    def of(bodies, medium=TURBID, **more):
        return scene([medium], bodies=bodies, **more)
    yield Situation("body-box", of([inside(body["box"])]), AIMED + GRAZING)
    yield Situation("body-stone", of([inside(body["stone"])]), AIMED + GRAZING)
    yield Situation("body-stone-smooth", of([inside(body["stone"]) + " normals=vertex"]), AIMED)
    yield Situation("body-stone-n=1", of([inside(body["stone"], (1.0, 0.5, 10.0, 0.5))], (1.0, 0.1, 2.0, 0.5, 1.0)), AIMED)
    yield Situation("body-box-air", of([inside(body["box"], (1.0, 0.0, 0.0, 0.0))], (1.5, 0.1, 2.0, 0.5, 1.0)), AIMED)
    yield Situation("body-needle", of([inside(body["needle"])]), AIMED)
    yield Situation("body-bottle", of([inside(body["bottle"])]), AIMED + GRAZING[::2])
    yield Situation("nested-stones-1e-6", of([inside(body["stone"]), inside(body["stone-inside"], (1.3, 0.1, 2.0, 0.5))]),
                    AIMED + GRAZING[::2])
    yield Situation("body-below-mesh", scene([TURBID], {0: line["rough"]}, bodies=[
        inside(body["box"]), sphere(0.0, 0.0, 0.5, 0.15, (1.0, 0.0, 0.0, 0.0))]), AIMED)
    yield Situation("body-below-tile", scene([TURBID], {0: line["tile"]}, bodies=[
        inside(body["stone"]), cylinder((-2.0, 0.5, 0.3, 2.0, 0.5, 0.3), 0.1)]), AIMED)
    yield Situation("body-parts", of([inside(body["parts"])]), AIMED + GRAZING[::2])
    yield Situation("body-shells", of([inside(body["shells"]), sphere(0.0, 0.0, 0.5, 0.02, (1.0, 0.0, 0.0, 0.0))]), AIMED + GRAZING[::2])
    yield Situation("body-shells-air", of([inside(body["shells"], (1.0, 0.0, 0.0, 0.0))], (1.5, 0.1, 2.0, 0.5, 1.0)), AIMED)
    yield Situation("body-shell-1e-6cm", of([inside(body["shell-1e-6"])]), AIMED + GRAZING[::2])
    yield Situation("body-boxes-1e-9cm", of([inside(body["boxes-1e-9"])]), AIMED + GRAZING[::2])
    yield Situation("body-union", of([inside(body["union"]) + " union"]), AIMED + GRAZING[::2])
    yield Situation("body-union-smooth-air", of([inside(body["union"], (1.0, 0.0, 0.0, 0.0)) + " union normals=vertex"], (1.5, 0.1, 2.0, 0.5, 1.0)), AIMED)
    yield Situation("body-union-n=1", of([inside(body["union"], (1.0, 0.5, 10.0, 0.5)) + " union"], (1.0, 0.1, 2.0, 0.5, 1.0)), AIMED)
    yield Situation("body-union-boxes", of([inside(body["union-boxes"]) + " union"]), AIMED + GRAZING[::2])
    yield Situation("body-crossing-parts", of([inside(body["crossing"])]), refused="itself")
    yield Situation("body-torn", of([inside(body["torn"])]), refused="edge")
    yield Situation("body-through-mesh", scene([TURBID], {0: line["rough"]}, bodies=[sphere(0.0, 0.0, 0.3, 0.3)]),
                    refused="meets")


def large(directory, sizes):
    for size in sizes:
        cells = math.isqrt(size // 2)
        name = f"triangles-1e{round(math.log10(size))}"
        write_large_grid(os.path.join(directory, name + ".obj"), cells, 4.0, 0.2 * 4.0 / cells)
        yield Situation(name, slab(f'm "{name}.obj"'), ("face", "vertex"), big=True)


def build(directory, full=False):
    sheet, tile = mesh_lines(directory), tile_lines(directory)
    situations = [*fields(), *sheets(sheet), *tiles(tile), *round_bodies(), *mesh_bodies(sheet | tile, body_files(directory))]
    if full:
        situations += large(directory, [10**6, 10**7])
    for situation in situations:
        with open(situation.path(directory), "w", encoding="ascii") as file:
            file.write(situation.mci.replace("out.mco", situation.name + ".mco"))
    return situations
