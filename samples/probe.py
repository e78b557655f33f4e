#!/usr/bin/env python3
"""Fits the oxygenation of skin to spectra of a fibre probe in contact, with the probe's face and without: probe.py [DIR] [PHOTONS]

Six fibres of 200 um collect light around a seventh, in a steel tip. A spectrum from 450 to 750 nm is simulated for skin with 70 % of oxygen, and 1 %
of noise is added. Four numbers are fitted to the spectrum: oxygenation, blood, melanin, scattering. The model interpolates in a table of flights,
whose absorption comes by reweighting. Leaves a picture, probe.svg, in DIR (default: the current directory). PHOTONS is the number of photons of each
flight, by default 3e5. The script needs scipy and matplotlib; it takes about 180 s of processor time.

SPDX-License-Identifier: MIT
"""
import os
import sys

import clustermcml as mc
import matplotlib
import numpy as np
from scipy.interpolate import RegularGridInterpolator
from scipy.optimize import least_squares

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

KINDS = ("contact", "glass", "air")
NAMES = ("oxygenation", "blood", "melanin", "scattering")
TRUE = (0.7, 0.02, 0.02, 46.0)
BOUNDS = ((0, 0.002, 0.005, 30), (1, 0.06, 0.06, 65))
WAVELENGTH = np.arange(450, 751, 10.0)
TABLE = {"layer1.mus": np.geomspace(85, 390, 6), "layer1.mua": np.array([1, 3, 8, 20, 60]), "layer2.mua": np.geomspace(0.3, 20, 7)}


def skin(oxygenation, blood, melanin, scattering):
    """Returns the media of epidermis and dermis."""
    base = {"a": scattering, "b": 1.421, "g": 0.8}
    return {"layer1": mc.media.Medium({"melanosome": melanin, "bloodless skin": 1 - melanin}, **base),
            "layer2": mc.media.Medium({**mc.media.blood(blood, oxygenation), "bloodless skin": 1 - blood}, **base)}


def scene(kind, photons):
    """Returns skin below the probe. kind: "contact", or the medium that stands for the face: "air" or "glass"."""
    fibre = mc.Fibre(core=0.01, na=0.22, n=1.46, cladding=0.011)
    probe = mc.Probe.six_around_one(fibre, fill=1.5, face=mc.Face(0.5, "disk", radius=0.3), group="all")
    layers = [mc.Layer(1.4, 3, 200, 0.8, 0.006), mc.Layer(1.4, 3, 200, 0.8, 0.2)]
    ours = {"top": probe.top, "beam": probe.beam, "detectors": probe.detectors}
    if kind != "contact":
        cores = [port for port in probe.top if isinstance(port, mc.Port) and port.name][1:]
        seen = [mc.Detector("disk", radius=fibre.core, at=core.at, na=fibre.na, diffuse=True, name=core.name, group="all") for core in cores]
        ours = {"n_above": 1.0 if kind == "air" else fibre.n, "beam": mc.Beam("disk", fibre.core, light=f"na:{fibre.na}"), "detectors": seen}
    return mc.Scene(layers, n_below=1.4, photons=photons, nr=1, nz=1, na=1, **ours)


def model(kind, photons):
    """Flies the table. Returns a function of the four numbers that gives the light in the fibres by wavelength."""
    rows = dict(zip(TABLE, (numbers.ravel() for numbers in np.meshgrid(*TABLE.values(), indexing="ij"))))
    flown = mc.sweep(scene(kind, photons), {**rows, "layer2.mus": rows["layer1.mus"]}, dim="row", variables=["detector_all"], seed=2, reweight=True, ignore_absorption=True)
    logs = np.log(flown.detector_all.values).reshape([len(axis) for axis in TABLE.values()])
    grid = RegularGridInterpolator([np.log(axis) for axis in TABLE.values()], logs, method="cubic")

    def light(numbers):
        epidermis, dermis = (medium.columns(WAVELENGTH) for medium in skin(*numbers).values())
        return np.exp(grid(np.log(np.stack([epidermis["mus"], epidermis["mua"], dermis["mua"]], axis=1))))
    return light


def fit(light, measured):
    """Returns the four numbers and their errors: those of 1 % of noise."""
    found = least_squares(lambda numbers: (light(numbers) / measured - 1) / 0.01, TRUE, bounds=BOUNDS, x_scale=TRUE, diff_step=1e-4)
    return found.x, np.sqrt(np.diag(np.linalg.inv(found.jac.T @ found.jac))), 2 * found.cost


def main(folder, photons):
    flown = mc.spectrum(scene("contact", photons), skin(*TRUE), WAVELENGTH, seed=1, ignore_absorption=True)
    light, error = flown.detector_all.values, flown.detector_all_se.values
    print(f"light in six fibres at {WAVELENGTH[0]:.0f} nm: {light[0]:.3e} +- {error[0]:.1e}")
    noise = 1 + 0.01 * np.random.default_rng(1).standard_normal(light.shape)
    figure, axes = plt.subplots(layout="constrained")
    axes.errorbar(WAVELENGTH, 1e3 * light * noise, 1e3 * error, fmt="k.", label="measured")
    for kind in KINDS:
        found, errors, chi2 = fit(curve := model(kind, photons), light * noise)
        axes.plot(WAVELENGTH, 1e3 * curve(found), label=f"{kind}: oxygenation {found[0]:.2f}")
        axes.plot(WAVELENGTH, 1e3 * curve(TRUE), ":", color=axes.lines[-1].get_color())
        print(f"{kind}: " + ", ".join(f"{name} {value:.3g} +- {width:.1g} (true {true:g})" for name, value, width, true in zip(NAMES, found, errors, TRUE))
              + f"; chi2 {chi2:.0f} of {len(light) - 4}; light {np.mean(curve(TRUE) / light):.3f} of what is measured", flush=True)
    axes.set(xlabel="wavelength [nm]", ylabel="light in six fibres [1e-3]")
    axes.legend()
    figure.savefig(os.path.join(folder, "probe.svg"))


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else ".", float(sys.argv[2]) if len(sys.argv) > 2 else 3e5)
