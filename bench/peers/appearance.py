#!/usr/bin/env python3
"""Does Mitsuba 3 render our .bsdf files as it renders the slab itself? appearance.py [--photons N] [--rays N] [--rounds N] [--program PATH] [--out DIR]

Flies a slab with rough faces (n 1.5, mua 1, mus 40, g 0.5, d 0.1, beckmann 0.03), writes slab.bsdf and slab.rgb.bsdf, and asks Mitsuba's
plugin `measured` three things: whether its values are those that a reader of 30 lines finds in the file; what albedo its samples have;
how bright the slab is at nine exits in three distant lights of 12 degrees radius, beside Mitsuba's own volpath through `roughdielectric`
faces. `pip install mitsuba`. Leaves appearance.md in DIR. bench/peers/README.md says more.
SPDX-License-Identifier: MIT
"""
import importlib.metadata
import math
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import command
import picture
import tables

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "src", "python"))

N, MUA, MUS, G, D, ALPHA = 1.5, 1, 40, 0.5, 0.1, 0.03
UNIT, HALF_WIDTH, FAR, RADIUS = 100, 20.0, 1e4, math.radians(12)  # units of a cm, cm, cm, rad
LIGHTS = (15, 45, 65)  # degrees from the vertical, on the side of -x; red, green and blue
EXITS = [(theta, phi) for theta in (10, 40, 65) for phi in (20, 90, 160)]  # phi 0 is the mirror side
TITLES = ("exit", "light from", "volpath", ".bsdf", "difference", "z")
ANGLES = [*range(0, 81, 5), 85]


def fly(program, folder, photons):
    """Simulates the material and returns it. Its files stand in the folder."""
    os.environ["CLUSTERMCML"] = program
    import clustermcml as mc
    rough = mc.Rough("beckmann", ALPHA)
    scene = mc.Scene([mc.Layer(n=N, mua=MUA, mus=MUS, g=G, d=D, top_rough=rough)], bottom_rough=rough)
    material = mc.brdf(scene, angles=ANGLES, photons=photons, target_error=None)
    for kind in (".bsdf", ".rgb.bsdf"):
        material.to_bsdf(os.path.join(folder, "slab" + kind))
    return material


def direction(theta, phi):
    """Returns a direction upwards from angles in degrees."""
    t, p = math.radians(theta), math.radians(phi)
    return [math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t)]


# ---- values of the file ----

def looked_up(fields, name, light, exit_):
    """f cos of the exit, by bilinear interpolation, as bsdf_file.py describes the file. Both are unit vectors, light at azimuth 0."""
    import numpy as np
    half = np.add(light, exit_)
    half /= np.linalg.norm(half)
    table, angles = fields[name][0, :, 0].astype(float), fields["theta_i"].astype(float)
    last = table.shape[-1] - 1
    x, y = math.sqrt(2 * math.acos(half[2]) / math.pi) * last, (math.atan2(half[1], half[0]) + math.pi) / (2 * math.pi) * last
    theta = math.acos(light[2])
    i = min(max(int(np.searchsorted(angles, theta, side="right")) - 1, 0), len(angles) - 2)
    a, b = min(int(x), last - 1), min(int(y), last - 1)
    x, y, z = x - a, y - b, (theta - angles[i]) / (angles[i + 1] - angles[i])
    cells = (1 - z) * table[i, b:b + 2, a:a + 2] + z * table[i + 1, b:b + 2, a:a + 2]
    return float(np.array([1 - y, y]) @ cells @ np.array([1 - x, x]))


def compare_values(folder, variant, kind, name, pairs):
    """Returns the largest relative difference between Mitsuba's values and those of this reader."""
    import mitsuba as mi
    import numpy as np
    import clustermcml as mc
    mi.set_variant(variant)
    path = os.path.join(folder, "slab" + kind)
    plugin, fields = mi.load_dict({"type": "measured", "filename": path}), mc.read_bsdf(path)
    dice, worst = np.random.default_rng(1), 0.0
    for _ in range(pairs):
        theta_i, theta_o = np.degrees(np.arccos(dice.random(2)))
        light, exit_ = direction(theta_i, 0), direction(theta_o, dice.uniform(0, 360))
        place = mi.SurfaceInteraction3f()
        place.wi, place.wavelengths = light, mi.Color0f() if variant == "scalar_rgb" else [400, 500, 600, 700]
        own = looked_up(fields, name, light, exit_)
        worst = max(worst, abs(plugin.eval(mi.BSDFContext(), place, exit_)[0] - own) / max(own, 1e-3))
    return worst


def sampled_albedo(folder, theta, rays):
    """Returns (mean, error) of the albedo of Mitsuba's samples of the file."""
    import mitsuba as mi
    import numpy as np
    mi.set_variant("scalar_rgb")
    plugin, dice = mi.load_dict({"type": "measured", "filename": os.path.join(folder, "slab.rgb.bsdf")}), np.random.default_rng(2)
    place = mi.SurfaceInteraction3f()
    place.wi = direction(theta, 0)
    weights = np.array([plugin.sample(mi.BSDFContext(), place, dice.random(), dice.random(2))[1][0] for _ in range(rays)])
    return float(weights.mean()), float(weights.std() / math.sqrt(rays))


# ---- the slab in light ----

def lights(mi, phi):
    """Discs far away that face the middle of the slab: red, green, blue. Where both have room, each has a twin of half its radiance on the other side of the plane of the
    exit at this azimuth: as bright by symmetry, and met twice as often."""
    found = {}
    for i, theta in enumerate(LIGHTS):
        apart = 2 * math.asin(math.sin(math.radians(theta)) * abs(math.sin(math.radians(phi))))
        azimuths = (180, 2 * phi - 180) if apart > 2 * RADIUS else (180,)
        for k, azimuth in enumerate(azimuths):
            place = [FAR * UNIT * x for x in direction(theta, azimuth)]
            size = FAR * UNIT * math.tan(RADIUS)
            turn = mi.ScalarTransform4f().look_at(origin=place, target=[0, 0, 0], up=[0, 1, 0]) @ mi.ScalarTransform4f().scale(size)
            value = [float(i == c) / len(azimuths) for c in range(3)]
            found[f"light{i}{k}"] = {"type": "disk", "to_world": turn, "emitter": {"type": "area", "radiance": {"type": "rgb", "value": value}}}
    return found


def slab(mi, folder, measured):
    """The slab, whose top is at z = 0: its table, or its faces and medium."""
    if measured:
        turn = mi.ScalarTransform4f().scale(HALF_WIDTH * UNIT)
        return {"type": "rectangle", "to_world": turn, "bsdf": {"type": "measured", "filename": os.path.join(folder, "slab.rgb.bsdf")}}
    turn = mi.ScalarTransform4f().translate([0, 0, -D * UNIT / 2]) @ mi.ScalarTransform4f().scale([HALF_WIDTH * UNIT, HALF_WIDTH * UNIT, D * UNIT / 2])
    medium = {"type": "homogeneous", "albedo": MUS / (MUS + MUA), "sigma_t": (MUS + MUA) / UNIT, "phase": {"type": "hg", "g": G}}
    return {"type": "cube", "to_world": turn, "interior": medium,
            "bsdf": {"type": "roughdielectric", "distribution": "beckmann", "alpha": ALPHA, "int_ior": N, "ext_ior": 1.0}}


def radiance(folder, exit_, measured, rays, seed):
    """Returns the radiance of the slab's middle at an exit, by light."""
    import mitsuba as mi
    import numpy as np
    mi.set_variant("scalar_rgb")
    way = direction(*exit_)
    path = {"type": "path", "max_depth": 2} if measured else {"type": "volpath", "max_depth": -1, "rr_depth": 5000}
    sensor = {"type": "radiancemeter", "origin": [10 * UNIT * x for x in way], "direction": [-x for x in way], "sampler": {"type": "independent", "sample_count": rays},
              "film": {"type": "hdrfilm", "width": 1, "height": 1, "pixel_format": "rgb", "component_format": "float32", "rfilter": {"type": "box"}}}
    scene = mi.load_dict({"type": "scene", "integrator": path, "slab": slab(mi, folder, measured), "sensor": sensor, **lights(mi, exit_[1])})
    return np.array(mi.render(scene, spp=rays, seed=seed)).reshape(3)


def rows_of(folder, rays, rounds):
    """Radiance at every exit in every light, by both."""
    import numpy as np
    rows, found = [], {}
    for exit_ in EXITS:
        own = np.array([radiance(folder, exit_, False, rays // rounds, seed) for seed in range(rounds)])
        table = np.array([radiance(folder, exit_, True, 40000, seed) for seed in range(4)])
        for i, theta in enumerate(LIGHTS):
            mean, error = own[:, i].mean(), own[:, i].std(ddof=1) / math.sqrt(rounds)
            ours, noise = table[:, i].mean(), table[:, i].std(ddof=1) / 2
            off, total = ours / mean - 1, math.hypot(error, noise) / mean
            found.setdefault(theta, []).append((off, total))
            rows.append(["%d, %d" % exit_, theta, "%.5f ± %.5f" % (mean, error), "%.5f ± %.5f" % (ours, noise), "%+.1f ± %.1f %%" % (100 * off, 100 * total), "%+.1f" % (off / total)])
            print(*rows[-1], file=sys.stderr, flush=True)
    return rows, found


def mean_by_light(found):
    """Returns a line of text for each light: the mean over its exits, weighted by 1 / error**2."""
    lines = []
    for theta, values in found.items():
        weights = [1 / error**2 for _, error in values]
        mean = sum(off * weight for (off, _), weight in zip(values, weights)) / sum(weights)
        lines.append("%d degrees %+.1f ± %.1f %%" % (theta, 100 * mean, 100 / math.sqrt(sum(weights))))
    return "Mean difference over the exits, light from " + ", ".join(lines) + "."


def main():
    parser = command.parser(__doc__, photons=1000000, rays=(2400000, 1000), rounds=(8, 4))
    arguments = parser.parse_args()
    picture.need(parser, "mitsuba", "xarray", "h5py")
    with tempfile.TemporaryDirectory() as folder:
        material = fly(arguments.program, folder, arguments.photons)
        values = [compare_values(folder, *words, 2000) for words in (("scalar_rgb", ".rgb.bsdf", "rgb"), ("scalar_spectral", ".bsdf", "spectra"))]
        albedos = ["at %d degrees %.4f ± %.4f, flown %.4f" % (theta, *sampled_albedo(folder, theta, 40000), float(material.albedo_R.sel(theta_i=theta) - material.mirror_R.sel(theta_i=theta)))
                   for theta in (0, 40, 70)]
        rows, found = rows_of(folder, arguments.rays, arguments.rounds)
    about = tables.machine(arguments.program, arguments.rounds)
    words = ["Largest relative difference of values: %.1e (scalar_rgb), %.1e (scalar_spectral). Albedo by Mitsuba's samples: %s." % (*values, "; ".join(albedos)), "",
             mean_by_light(found)]
    tables.keep(os.path.join(arguments.out, "appearance.md"), [
        tables.measured(about) + "; Mitsuba %s; %d packets at each of %d angles; %d rays for each exit." % (importlib.metadata.version("mitsuba"), arguments.photons, len(ANGLES), arguments.rays),
        "", *tables.table(TITLES, rows), "", *words])


if __name__ == "__main__":
    main()
