"""Lets Mitsuba 3 (`pip install mitsuba`) look at a slab in white light: mitsuba_slab.py SCENE.json PHOTONS SEED...

A radiancemeter looks down at x = y = 0 on closed surfaces of scattering media, in constant light of radiance 1 from everywhere. By reciprocity, it
sees the share of a pencil along its ray that leaves again; the rest is absorbed. Integrator volpath, variant scalar_rgb. Its roulette ends 5 % of
the paths at every scattering, whatever their weight, which makes the variance of hundreds of scatterings infinite. Roulette therefore begins after
LATE scatterings (rr_depth), where little weight is left, and only ends paths that leak out of the slab.

SCENE.json: {"unit": units of length in a cm, "shapes": [{"file": PLY, "n": [inside, outside], "media": [name or null, the same], "rough":
[distribution, alpha] (default: smooth)}], "media": {name: [mua, mus, g]}, 1/cm, "angle": of the radiancemeter, degrees (default 0)}. Prints a line
of JSON for each seed: processor seconds of the flight, the absorbed share.

SPDX-License-Identifier: MIT
"""
import json
import math
import sys
import time

import mitsuba as mi

mi.set_variant("scalar_rgb")
mi.set_log_level(mi.LogLevel.Error)
LATE = 5000
HEIGHT = 1.0  # height of the radiancemeter above x = y = z = 0 [cm]


def medium(mua, mus, g, unit):
    return mi.load_dict({"type": "homogeneous", "albedo": mus / (mua + mus), "sigma_t": (mua + mus) / unit,
                         "phase": {"type": "hg", "g": g}})


def load(scene, photons, lights=None):
    """Loads a scene. lights: parts of the scene in place of the constant light."""
    unit, tilt = scene["unit"], math.radians(scene.get("angle", 0))
    media = {name: medium(*numbers, unit) for name, numbers in scene["media"].items()}
    parts = {"type": "scene", "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": LATE},
             **(lights or {"light": {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}}}),
             "sensor": {"type": "radiancemeter", "origin": [-HEIGHT * unit * math.tan(tilt), 0, HEIGHT * unit],
                        "direction": [math.sin(tilt), 0, -math.cos(tilt)],
                        "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}, "component_format": "float32"},
                        "sampler": {"type": "independent", "sample_count": photons}}}
    for k, shape in enumerate(scene["shapes"]):
        sides = {side: media[name] for side, name in zip(("interior", "exterior"), shape["media"]) if name}
        kind, alpha = shape.get("rough", ("", 0))
        facets = {"type": "roughdielectric", "distribution": kind, "alpha": alpha} if alpha else {"type": "dielectric"}
        parts["shape%d" % k] = {"type": "ply", "filename": shape["file"], "face_normals": True, **sides,
                                "bsdf": {**facets, "int_ior": shape["n"][0], "ext_ior": shape["n"][1]}}
    return mi.load_dict(parts)


def main():
    with open(sys.argv[1], encoding="utf-8") as stream:
        scene = load(json.load(stream), int(sys.argv[2]))
    for seed in sys.argv[3:]:
        begin = time.process_time()
        seen = mi.render(scene, seed=int(seed)).array[0]
        print(json.dumps({"seconds": time.process_time() - begin, "absorbed": 1 - seen, "version": mi.__version__}), flush=True)


if __name__ == "__main__":
    main()
