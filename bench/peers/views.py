#!/usr/bin/env python3
"""Tests if Mitsuba 3 sees the same light: views.py [--photons N] [--rays N] [--program PATH] [--out DIR]

Three rough surfaces, one of which overhangs, lie above a turbid slab. Two things are compared: the directions in which the light of a slanted beam
leaves (`directions`), and the picture that a slanted camera takes of a surface under a lamp (`detector map`). Mitsuba follows rays backwards. Rays
of the beam end in an environment that shines from the bins of directions, three bins at a time as red, green and blue. Rays of a pixel, evenly over
its area and the camera's cone, end in a lamp of radiance 1. Errors come from the spread of single rays in both programs. `pip install mitsuba
h5py`. Leaves views.md, and views.csv with all bins and pixels, in DIR; takes some minutes on one thread. bench/peers/README.md says more.

SPDX-License-Identifier: MIT
"""
import importlib.metadata
import importlib.util
import math
import os
import random
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command
import slab
import tables

sys.path.insert(0, os.path.join(cases.ROOT, "tests", "lib"))
import cml  # noqa: E402

LAYER = [1.4, 1, 60, 0.8, 0.25]  # n mua mus g d
SURFACES = {
    "overhang": lambda path: os.path.join(cases.ROOT, "meshes", "overhang.obj"),
    "skin": lambda path: os.path.join(cases.ROOT, "meshes", "ridges.obj"),
    "rough": lambda path: cases.make_surface("moved", "1000", cases.AMPLITUDE_A, path) or path,
}
NT, NP = 3, 2
BEAM = (0.1, 30, 40)  # radius, angle, azimuth
LAMP, LAMP_Z = 0.6, -0.5  # width, depth [cm]
PIXELS, PIXEL, NA, ANGLE, AZIMUTH, FOCUS = 3, 0.15, 0.5, 45, 70, -0.1
UNIT, HALF_WIDTH, FAR = 100, 30.0, 2.0  # units of a cm; half width of the slab [cm]; distance at which rays begin [cm]
BROKEN = []  # rays of Mitsuba that brought NaN
TITLES = ("surface", "seen", "bins or pixels", "ours", "error of a difference", "largest z", "z of their sum")


def axis(angle, azimuth):
    """Returns a direction and the two directions across it, z up. Light goes up along the first."""
    a, p = math.radians(angle), math.radians(azimuth)
    return ((math.sin(a) * math.cos(p), math.sin(a) * math.sin(p), math.cos(a)),
            (math.cos(a) * math.cos(p), math.cos(a) * math.sin(p), -math.sin(a)), (-math.sin(p), math.cos(p), 0.0))


def combine(*terms):
    return [sum(factor * vector[k] for factor, vector in terms) for k in range(3)]


# ---- ours ----

def ours(mesh, work, photons, extra):
    """Returns {name: (values, errors)} of the arrays of a run."""
    import h5py
    text = cml.mci([" ".join(map(str, LAYER))], photons=photons, surfaces={0: 'm "%s"' % mesh}, extra=extra)
    cml.run(text.replace("out.mco A", "out.h5 B"), "--sampling", "random", keep=work)
    with h5py.File(os.path.join(work, "out.h5")) as file:
        return {name: (file[name][()].ravel().tolist(), file[name + "_se"][()].ravel().tolist()) for name in file if name + "_se" in file}


def our_directions(mesh, work, photons):
    """Yields the shares of the launched light by bin, both of light that was in the material and of light that was not."""
    arrays = ours(mesh, work, photons, ["beam disk %g angle=%g azimuth=%g" % BEAM, "directions %d %d" % (NT, NP)])
    edges = [math.cos(math.pi / 2 * k / NT) for k in range(NT + 1)]
    for i in range(NT * NP):
        sr = (edges[i // NP] - edges[i // NP + 1]) * 2 * math.pi / NP
        (value, error), (more, other) = (tuple(column[i] for column in arrays[name]) for name in ("Rd_dir", "Rsp_dir"))
        yield sr * (value + more), sr * math.hypot(error, other)


def our_picture(mesh, work, photons):
    arrays = ours(mesh, work, photons, [
        "beam rectangle %g %g z=%g light=lambertian" % (LAMP, LAMP, LAMP_Z),
        "detector map %d %d %g %g z=%g na=%g angle=%g azimuth=%g name=camera" % (PIXELS, PIXELS, PIXEL, PIXEL, FOCUS, NA, ANGLE, AZIMUTH)])
    return zip(*arrays["detector_camera_map"])


# ---- Mitsuba ----

def load(mesh, work, more):
    import mitsuba_slab
    path = os.path.join(work, "slab.ply")
    slab.write_ply(slab.shell(mesh, LAYER[4], HALF_WIDTH), path, UNIT)
    return mitsuba_slab.load({"unit": UNIT, "media": {"0": LAYER[1:4]}, "shapes": [{"file": path, "n": [LAYER[0], 1.0], "media": ["0", None]}]},
                             1, more)


def sky(mi, colours):
    """Returns an environment of radiance 1 from some bins, one bin in each colour. Edges of bins lie between two pixels. Columns begin at y and run
    against the azimuth."""
    import numpy as np
    rows, columns = 600 * NT, 1200 * NP
    theta, phi = np.arange(rows // 2) * 2 * NT // rows, ((columns // 4 - 1 - np.arange(columns)) % columns) * NP // columns
    image = np.zeros((rows, columns, 3), dtype=np.float32)
    for k, i in enumerate(colours):
        image[:rows // 2, :, k] = np.outer(theta == i // NP, phi == i % NP)
    turned = mi.ScalarTransform4f().rotate([1, 0, 0], 90)  # the poles of the image are those of y
    return {"type": "envmap", "bitmap": mi.Bitmap(image), "to_world": turned}


def follow(mi, scene, rays, draw):
    """Follows rays. Returns means and errors of the light that they bring, by colour. draw: () -> (start [cm], direction, factor). Rays that bring
    NaN are counted and replaced."""
    integrator, sampler = scene.integrator(), mi.load_dict({"type": "independent", "sample_count": rays})
    sampler.seed(random.getrandbits(31))
    sums, squares = [0.0] * 3, [0.0] * 3
    done = 0
    while done < rays:
        start, direction, factor = draw()
        light = integrator.sample(scene, sampler, mi.RayDifferential3f([UNIT * x for x in start], direction))[0]
        if not math.isfinite(sum(light)):
            BROKEN.append(start)
            continue
        done += 1
        for k in range(3):
            sums[k] += factor * light[k]
            squares[k] += (factor * light[k])**2
    return [(total / rays, math.sqrt(max(square - total**2 / rays, 0)) / rays) for total, square in zip(sums, squares)]


def their_directions(mi, mesh, work, rays):
    up, across, other = axis(-BEAM[1], BEAM[2])  # the beam comes along -up

    def draw():
        r, turn = BEAM[0] * math.sqrt(random.random()), 2 * math.pi * random.random()
        return combine((FAR, up), (-r * math.cos(turn), across), (r * math.sin(turn), other)), combine((-1, up)), 1
    for first in range(0, NT * NP, 3):
        yield from follow(mi, load(mesh, work, {"light": sky(mi, range(first, first + 3))}), rays, draw)


def lamp(mi):
    down = mi.ScalarTransform4f().translate([0, 0, -UNIT * LAMP_Z]).rotate([1, 0, 0], 180).scale([UNIT * LAMP / 2, UNIT * LAMP / 2, 1])
    return {"type": "rectangle", "to_world": down, "bsdf": {"type": "null"},
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}}}


def their_picture(mi, mesh, work, rays):
    scene, (up, across, other) = load(mesh, work, {"light": lamp(mi)}), axis(ANGLE, AZIMUTH)
    least = math.sqrt(1 - NA**2)  # cosine of the cone's half-angle
    solid = 2 * math.pi * (1 - least)
    for i in range(PIXELS * PIXELS):
        corner = [PIXEL * (i % PIXELS - PIXELS / 2), PIXEL * (i // PIXELS - PIXELS / 2)]

        def draw():
            c, turn = least + (1 - least) * random.random(), 2 * math.pi * random.random()
            s = math.sqrt(1 - c * c)
            leaves = combine((c, up), (s * math.cos(turn), across), (s * math.sin(turn), other))
            at = (corner[0] + PIXEL * random.random(), corner[1] + PIXEL * random.random(), -FOCUS)
            return combine((1, at), (FAR, leaves)), combine((-1, leaves)), leaves[2] * solid / (math.pi * LAMP**2)
        yield follow(mi, scene, rays, draw)[0]


# ---- all of it ----

def compare(surface, seen, names, mine, theirs):
    for name, (value, error), (other, its_error) in zip(names, mine, theirs):
        yield {"surface": surface, "seen": seen, "place": name, "ours": value, "ours_se": error, "mitsuba": other, "mitsuba_se": its_error,
               "z": (other - value) / math.hypot(error, its_error)}


def rows(mi, work, photons, rays):
    for surface, make in SURFACES.items():
        mesh = make(os.path.join(work, surface + ".obj"))
        bins = ["Rd_dir[%d][%d]" % (t, p) for t in range(NT) for p in range(NP)]
        yield from compare(surface, "directions", bins, our_directions(mesh, work, photons), their_directions(mi, mesh, work, rays))
        pixels = ["camera[%d][%d]" % (y, x) for y in range(PIXELS) for x in range(PIXELS)]
        yield from compare(surface, "picture", pixels, our_picture(mesh, work, photons), their_picture(mi, mesh, work, rays))


def summary(found):
    """Yields a row for all bins, or pixels, of a surface: least and most, the mean error of a difference, the largest z and the mean of z."""
    for surface, seen in sorted({(row["surface"], row["seen"]) for row in found}):
        some = [row for row in found if (row["surface"], row["seen"]) == (surface, seen)]
        of = [row["ours"] for row in some]
        relative = [math.hypot(row["ours_se"], row["mitsuba_se"]) / row["ours"] for row in some]
        z = [row["z"] for row in some]
        yield [surface, seen, len(some), "%.3f to %.3f" % (min(of), max(of)), "%.1f %%" % (100 * sum(relative) / len(some)),
               "%+.1f" % max(z, key=abs), "%+.1f" % (sum(z) / math.sqrt(len(z)))]


def main():
    parser = command.parser(__doc__, photons=1000000, rays=15000)
    arguments = parser.parse_args()
    for module in ("mitsuba", "h5py"):
        if not importlib.util.find_spec(module):
            parser.error("%s is missing: pip install %s" % (module, module))
    cml.PROGRAM = arguments.program
    import mitsuba_slab
    random.seed(1)
    with tempfile.TemporaryDirectory() as work:
        found = list(rows(mitsuba_slab.mi, work, arguments.photons, arguments.rays))
    about = tables.machine(arguments.program, 1)
    z = [row["z"] for row in found]
    lines = [tables.measured(about) + "; Mitsuba %s; %g packets, %g rays to three bins of directions, or a pixel." % (
        importlib.metadata.version("mitsuba"), arguments.photons, arguments.rays), "", *tables.table(TITLES, summary(found)), "",
        "Of all %d the largest z is %+.1f, their root mean square %.2f; rays of Mitsuba's that brought NaN and were left out: %d." % (
            len(z), max(z, key=abs), math.sqrt(sum(x * x for x in z) / len(z)), len(BROKEN))]
    tables.keep(os.path.join(arguments.out, "views.md"), lines)
    tables.write_csv(os.path.join(arguments.out, "views.csv"), about, found)


if __name__ == "__main__":
    main()
