#!/usr/bin/env python3
"""Fits the oxygenation of skin to spectra of a fibre probe in contact, with the probe's face and without: probe.py [DIR] [PHOTONS]

Six fibres of 200 um collect light around a seventh, in a steel tip. A spectrum from 450 to 750 nm is simulated for skin with 70 % of oxygen, and 1 %
of noise is added. Four numbers are fitted to the spectrum: oxygenation, blood, melanin, scattering. The model interpolates in a table of flights,
whose absorption comes by reweighting. Leaves a picture, probe.svg, in DIR (default: the current directory). PHOTONS is the number of photons of each
flight, by default 3e5. The script needs scipy and matplotlib; it takes about 160 s of processor time.

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

G = 0.8
NAMES = ("oxygenation", "blood", "melanin", "scattering")
TRUE = (0.7, 0.02, 0.02, 46.0)
BOUNDS = ((0, 0.002, 0.005, 30), (1, 0.06, 0.06, 65))
HEMOGLOBIN = np.loadtxt(os.path.join(os.path.dirname(os.path.abspath(__file__)), "hemoglobin.csv"), delimiter=",", skiprows=5)
WAVELENGTH = np.arange(450, 751, 10.0)
TABLE = {"mus": np.geomspace(85, 390, 6), "mua1": np.array([1, 3, 8, 20, 60]), "mua2": np.geomspace(0.3, 20, 7)}


def skin(oxygenation, blood, melanin, scattering, nm=WAVELENGTH):
    """Returns mua of epidermis and dermis, and mus of both [1/cm], by wavelength. Sources: samples/manual/tutorial/09-spectrum.md."""
    base = 0.244 + 85.3 * np.exp(-(nm - 154) / 66.2)
    oxy, deoxy = (np.interp(nm, HEMOGLOBIN[:, 0], HEMOGLOBIN[:, i]) for i in (1, 2))
    whole = 2.303 * 150 / 64500 * (oxygenation * oxy + (1 - oxygenation) * deoxy)
    return melanin * 6.6e11 * nm**-3.33 + (1 - melanin) * base, blood * whole + (1 - blood) * base, scattering * (nm / 500) ** -1.421 / (1 - G)


def scene(kind, photons):
    """Returns skin below the probe. kind: "contact", or the medium that stands for the face: "air" or "glass"."""
    fibre = mc.Fibre(core=0.01, na=0.22, n=1.46, cladding=0.011)
    probe = mc.Probe.six_around_one(fibre, fill=1.5, face=mc.Face(0.5, "disk", radius=0.3))
    layers = [mc.Layer(1.4, 3, 200, G, 0.006), mc.Layer(1.4, 3, 200, G, 0.2)]
    if kind == "contact":
        return mc.Scene(layers, n_below=1.4, photons=photons, top=probe.top, beam=probe.beam, detectors=probe.detectors, nr=1, nz=1, na=1)
    cores = [port for port in probe.top if isinstance(port, mc.Port) and port.name]
    seen = [mc.Detector("disk", radius=fibre.core, at=core.at, na=fibre.na, diffuse=True, name=core.name) for core in cores[1:]]
    return mc.Scene(layers, n_above=1.0 if kind == "air" else fibre.n, n_below=1.4, photons=photons, beam=mc.Beam("disk", fibre.core, light=f"na:{fibre.na}"), detectors=seen,
                    nr=1, nz=1, na=1)


def collected(flown):
    """Returns the light in the six fibres, and its error."""
    light = sum(flown[f"detector_f{i}"] for i in range(1, 7))
    return light.values, np.sqrt(sum(flown[f"detector_f{i}_se"] ** 2 for i in range(1, 7))).values


def model(kind, photons):
    """Flies the table. Returns a function of the four numbers that gives the light in the fibres by wavelength."""
    mus, mua1, mua2 = np.meshgrid(*TABLE.values(), indexing="ij")
    rows = {"layer1.mus": mus.ravel(), "layer2.mus": mus.ravel(), "layer1.mua": mua1.ravel(), "layer2.mua": mua2.ravel()}
    flown = mc.sweep(scene(kind, photons), rows, dim="row", variables=[f"detector_f{i}{end}" for i in range(1, 7) for end in ("", "_se")], seed=2, reweight=True, ignore_absorption=True)
    logs = np.log(collected(flown)[0]).reshape(mus.shape)
    grid = RegularGridInterpolator([np.log(axis) for axis in TABLE.values()], logs, method="cubic")

    def light(numbers):
        mua1, mua2, mus = skin(*numbers)
        return np.exp(grid(np.log(np.stack([mus, mua1, mua2], axis=1))))
    return light


def fit(light, measured):
    """Returns the four numbers and their errors: those of 1 % of noise."""
    found = least_squares(lambda numbers: (light(numbers) / measured - 1) / 0.01, TRUE, bounds=BOUNDS, x_scale=TRUE, diff_step=1e-4)
    return found.x, np.sqrt(np.diag(np.linalg.inv(found.jac.T @ found.jac))), 2 * found.cost


def main(folder, photons):
    mua1, mua2, mus = skin(*TRUE)
    rows = {"layer1.mua": mua1, "layer2.mua": mua2, "layer1.mus": mus, "layer2.mus": mus}
    flown = mc.sweep(scene(KINDS[0], photons), rows, dim="row", seed=1, ignore_absorption=True)
    light, error = collected(flown)
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


KINDS = ("contact", "glass", "air")
if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else ".", float(sys.argv[2]) if len(sys.argv) > 2 else 3e5)
