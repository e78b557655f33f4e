#!/usr/bin/env python3
"""Renders red paint whose face is glossy, satin or matt: paint_brdf.py [DIR] [PHOTONS]

Simulates the paint of paint_gloss.mci with three pigments for red, green and blue light, at three alphas of its `rough` line, by default with 1e5
photons at each angle. Leaves glossy.rgb.bsdf, satin.rgb.bsdf and matt.rgb.bsdf in DIR, by default the current directory. With Mitsuba 3 (pip
install mitsuba) it renders a ball of each paint beside a lambertian one, paint_brdf.png; without it, it draws the lobes, paint_brdf.svg. Needs the
Python package (or PYTHONPATH=src/python and CLUSTERMCML=build/clustermcml in a checkout).

SPDX-License-Identifier: MIT
"""
import importlib.util
import os
import sys
import warnings

import clustermcml as mc
import numpy as np

PIGMENT = {"channel": ["r", "g", "b"], "layer1.mua": [3.0, 150.0, 300.0]}  # 1/cm
ALPHAS = {"glossy": 0.05, "satin": 0.2, "matt": 0.5}
ANGLES = [0, 20, 40, 60, 75, 85]
SIZE, RAYS = 170, 192  # pixels along a side of a ball's picture, and rays for each pixel


def paint(alpha):
    """Returns the scene: the layer of paint_gloss.mci on a primer of the same binder."""
    layer = mc.Layer(n=1.5, mua=2, mus=1500, g=0.6, d=0.02, top_rough=mc.Rough("beckmann", alpha))
    return mc.Scene([layer], n_below=1.5)


def make(folder, photons):
    """Simulates all paints and writes their files. Returns the materials by name."""
    made = {}
    for name, alpha in ALPHAS.items():
        made[name] = mc.brdf(paint(alpha), ANGLES, photons, target_error=None, channels=PIGMENT)
        path = os.path.join(folder, name + ".rgb.bsdf")
        made[name].to_bsdf(path)
        albedo = ", ".join("%.3f" % value for value in made[name].albedo_R.sel(theta_i=0))
        print(f"{path}: albedo at 0 degrees {albedo}; fit chi^2 {float(made[name].chi2.max()):.2f}, lobe {float(made[name].f_gloss.max()):.3g} per sr")
    return made


def ball(bsdf):
    """Renders a ball under an even sky and a round lamp. Returns an array of colours."""
    import mitsuba as mi
    turn = mi.ScalarTransform4f()
    lamp = turn.look_at(origin=[-6, 6, 7], target=[0, 0, 0], up=[0, 1, 0]) @ turn.scale(1.2)
    scene = mi.load_dict({
        "type": "scene", "integrator": {"type": "direct"}, "ball": {"type": "sphere", "bsdf": bsdf},
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 0.35}},
        "lamp": {"type": "disk", "to_world": lamp, "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 40.0}}},
        "sensor": {"type": "perspective", "fov": 24.5, "to_world": turn.look_at(origin=[0, 0, 5], target=[0, 0, 0], up=[0, 1, 0]), "sampler": {"type": "independent"},
                   "film": {"type": "hdrfilm", "width": SIZE, "height": SIZE, "pixel_format": "rgba", "rfilter": {"type": "box"}}}})
    seen = np.array(mi.render(scene, spp=RAYS))
    return seen[..., :3] + (1 - seen[..., 3:]) if seen.shape[2] == 4 else seen


def on_white(colours):
    """Returns linear colours as sRGB. Pixels beside the ball are white."""
    y, x = (np.mgrid[:SIZE, :SIZE] + 0.5) / SIZE * 2 - 1
    colours = np.where((x**2 + y**2 < 0.915)[..., None], colours, 1.0)
    c = np.clip(colours, 0, 1)
    return np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1 / 2.4) - 0.055)


def render(made, folder):
    import matplotlib.image
    import mitsuba as mi
    mi.set_variant("scalar_rgb")
    albedo = [float(value) for value in made["satin"].albedo_R.sel(theta_i=0)]
    kinds = [{"type": "diffuse", "reflectance": {"type": "rgb", "value": albedo}}]
    kinds += [{"type": "measured", "filename": os.path.join(folder, name + ".rgb.bsdf")} for name in made]
    picture = np.concatenate([on_white(ball(kind)) for kind in kinds], axis=1)
    path = os.path.join(folder, "paint_brdf.png")
    matplotlib.image.imsave(path, picture, metadata={"Software": None})
    print(f"{path}: lambertian, " + ", ".join(made))


def draw(made, folder):
    import matplotlib
    matplotlib.use("svg")
    import matplotlib.pyplot as plt
    plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "clustermcml", "axes.grid": True, "legend.frameon": False})
    figure, panels = plt.subplots(1, len(made), figsize=(4.2 * len(made), 3.6), sharey=True)
    for axes, (name, material) in zip(panels, made.items()):
        for channel, colour in zip("rgb", ("#D55E00", "#009E73", "#0072B2")):
            f = material.f_r.sel(channel=channel, theta_i=40)
            half = f.sizes["phi"] // 2
            angles = np.concatenate([-f.theta.values[::-1], f.theta.values])
            axes.plot(angles, np.concatenate([f[::-1, half], f[:, 0]]), color=colour, label=channel)
        axes.set(yscale="log", ylim=(1e-3, 20), xlim=(-90, 90), xticks=range(-90, 91, 45), title=f"{name}, alpha {ALPHAS[name]:g}", xlabel="exit, light from -40 [degrees]")
    panels[0].set(ylabel="f [1/sr]")
    panels[0].legend()
    figure.tight_layout()
    path = os.path.join(folder, "paint_brdf.svg")
    figure.savefig(path, metadata={"Date": None, "Creator": None})
    print(path)


def main():
    folder, photons = (sys.argv[1:] + [".", "1e5"][len(sys.argv) - 1:])[:2]
    os.makedirs(folder, exist_ok=True)
    warnings.simplefilter("ignore")
    made = make(folder, float(photons))
    (render if importlib.util.find_spec("mitsuba") else draw)(made, folder)


if __name__ == "__main__":
    main()
