"""Tests of mc.sphere and of fits to readings of an integrating sphere. The gain is held against rays traced in a sphere with flat ports, the errors
against the spread over seeds.

SPDX-License-Identifier: MIT
"""
import os
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import mc, np  # noqa: E402
from clustermcml.integrating_sphere import Instrument  # noqa: E402

SPHERE = {"port": 0.5, "radius": 2.5, "wall": 0.96, "ports": 0.015}
BOUNDS = {"layer1.mua": (0.1, 2), "layer1.mus": (50, 200)}
RAYS = 250_000
TRUTH = {"layer1.mua": 0.5, "layer1.mus": 100}


def slab(**values):
    return mc.Scene([mc.Layer(n=1.4, mua=0.5, mus=100, g=0.9, d=0.2)], **{"nr": 50, "dr": 0.05, "photons": 20000, **values})


def lambertian(normal, dice):
    """Returns directions by the cosine law about unit vectors [n, 3]."""
    sent = dice.standard_normal(normal.shape)
    sent = normal + sent / np.linalg.norm(sent, axis=1, keepdims=True)
    return sent / np.linalg.norm(sent, axis=1, keepdims=True)


def detected(start, reflectance, dice, count=RAYS):
    """Traces rays in a sphere of radius 1 and returns the share that reaches the detector. Its flat sample port lies at the bottom, a black entrance
    at the top, a black detector at the side; all other surface reflects by the cosine law. start: "sample" or "wall", opposite the sample."""
    port = SPHERE["port"] / SPHERE["radius"]
    floor = -np.sqrt(1 - port**2)
    holes = 2 * SPHERE["ports"] / 2  # two holes of half the area each: the cap 1 - z < ports
    if start == "sample":
        radius, turn = port * np.sqrt(dice.random(count)), 2 * np.pi * dice.random(count)
        place = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.full(count, floor)], axis=1)
        normal = np.tile([0.0, 0.0, 1.0], (count, 1))
    else:
        place = np.tile(np.array([0.6, 0.0, 0.8]), (count, 1))
        normal = -place
    seen = 0
    while len(place):
        way = lambertian(normal, dice)
        along = np.sum(place * way, axis=1)
        end = place + (-along + np.sqrt(along**2 + 1 - np.sum(place**2, axis=1)))[:, None] * way
        end /= np.linalg.norm(end, axis=1, keepdims=True)
        seen += int((end[:, 0] > 1 - holes).sum())
        sample = end[:, 2] < floor
        lives = (dice.random(len(end)) < np.where(sample, reflectance, SPHERE["wall"])) & (end[:, 0] <= 1 - holes) & (end[:, 2] <= 1 - holes)
        place, way, end, sample = (of[lives] for of in (place, way, end, sample))
        down = place + ((floor - place[:, 2]) / np.where(sample, way[:, 2], 1))[:, None] * way  # a ray to the sample ends on the flat port
        place = np.where(sample[:, None], down, end)
        normal = np.where(sample[:, None], [0.0, 0.0, 1.0], -end)
    return seen / count


class Gains(unittest.TestCase):
    def test_gains_are_those_of_rays(self):
        """Ratios of readings equal those of traced rays within 4 errors, for samples darker and brighter than the standard."""
        instrument, dice = Instrument(**SPHERE), np.random.default_rng(3)
        standard, open_ = detected("sample", 0.99, dice), detected("wall", 0, dice)
        for reflectance in (0.1, 0.6):
            traced = detected("sample", reflectance, dice)
            for reference, name in ((standard, "M_R"), (open_, "M_T")):
                error = traced / reference * np.sqrt((1 / traced + 1 / reference) / RAYS)
                value = instrument.reading(name, 1.0, 0.0, reflectance, 0.0)[0]
                cap = instrument.share * value if name == "M_T" else 0  # the equation of M_T takes a flat port for a part of the sphere
                self.assertLess(abs(traced / reference - value), 4 * error + cap, (name, reflectance, traced / reference, value))
                if (name, reflectance) == ("M_R", 0.1):
                    self.assertLess(error, 0.06 * abs(1 - value))

    def test_slopes_are_those_of_differences(self):
        instrument, h = Instrument(**SPHERE), 1e-5
        for name in ("M_R", "M_T"):
            ends = [instrument.reading(name, 0.3 + 2 * step, 0, 0.5 - 3 * step, 0)[0] for step in (-h, h)]
            self.assertAlmostEqual(instrument.slope(name, 0.3, 2, 0.5, -3), (ends[1] - ends[0]) / (2 * h), 7)
        value, error = instrument.reading("M_R", 0.3, 0.003, 0.5, 0.01)
        parts = [instrument.reading("M_R", 0.303, 0, 0.5, 0)[0] - value, instrument.reading("M_R", 0.3, 0, 0.51, 0)[0] - value]
        self.assertAlmostEqual(error, np.hypot(*parts), 5)


class Readings(unittest.TestCase):
    def test_a_sphere_that_loses_nothing_gives_the_totals(self):
        """With a port that is as wide as all light, comparison gives R and Tt. So does substitution of a sample as bright as the standard for R."""
        result = mc.run(slab(nr=40, dr=0.5))
        seen = mc.sphere(result, 19.5)
        self.assertAlmostEqual(float(seen.M_R), float(result.Rsp + result.Rd), 12)
        self.assertAlmostEqual(float(seen.M_T), float(result.Tt), 12)
        self.assertEqual((float(seen.R_lost), float(seen.T_lost)), (0, 0))
        self.assertAlmostEqual(float(mc.sphere(result, 19.5, specular=False).M_R), float(result.Rd), 12)
        self.assertAlmostEqual(float(mc.sphere(result, 19.5, radius=40, wall=0.9, diffuse=0.95, standard=0.95).M_R), float(seen.M_R), 12)

    def test_lost_light_is_that_of_saved_packets(self):
        """Rings and saved packets of one run give the same readings, and the same errors in the mean. Packets allow a port between bins' edges."""
        ratios = []
        for seed in range(1, 6):
            with tempfile.TemporaryDirectory() as folder:
                result = mc.run(slab(photons=5000, saved=mc.Saved("all")), output_dir=folder, seed=seed, sampling="random")
                saved = mc.read_photons(os.path.join(folder, "all.photons.h5"))
            rings, packets = mc.sphere(result, 0.5), mc.sphere(result, 0.5, saved=saved)
            for name in ("M_R", "M_T", "R_lost", "T_lost"):
                self.assertAlmostEqual(float(rings[name]), float(packets[name]), 6, name)
            ratios += [float(rings[name] / packets[name]) for name in ("M_R_se", "M_T_se")]
        self.assertLess(abs(np.mean(ratios) - 1), 0.1)  # each is known to 9 %
        self.assertGreater(float(rings.R_lost), 0.01)
        between = mc.sphere(result, 0.513, saved=saved)
        self.assertTrue(float(rings.M_R) < float(between.M_R) < float(mc.sphere(result, 0.55).M_R))

    def test_errors_are_the_spread_over_seeds(self):
        """The spread of readings over 60 seeds, which is known to 9 %, equals their errors. The diffuse reflectance has an error of its own."""
        seeds = mc.sweep(slab(photons=2000), {"seed": list(range(1, 61))}, variables=["Rsp", "Rsp_se", "Rd", "Rd_se", "Tt", "Tt_se", "Rd_r", "Rd_r_se", "Tt_r", "Tt_r_se"])
        dice = np.random.default_rng(1)
        seen = [mc.sphere(seeds.isel(seed=i), diffuse=(0.45 + 0.05 * dice.standard_normal(), 0.05), **SPHERE) for i in range(60)]
        for name in ("M_R", "M_T"):
            spread, error = np.std([float(one[name]) for one in seen], ddof=1), np.mean([float(one[name + "_se"]) for one in seen])
            self.assertLess(abs(np.log(spread / error)), 0.35, (name, spread, error))
        lost = [float(one.R_lost) for one in seen]
        self.assertLess(np.std(lost), 1.35 * np.mean([float(one.R_lost_se) for one in seen]))

    def test_refusals(self):
        result = mc.run(slab(photons=200))
        for values, text in (({"port": 0.51}, r"port = 0.51 .expected a multiple of dr = 0.05, below nr dr = 2.5; or saved packets"), ({"port": 2.5}, "port = 2.5 "),
                             ({"wall": 0.9}, "wall and radius together"), ({"wall": 0.9, "radius": 0.4}, "radius = 0.4 .expected a radius of at least that of the port, 0.5"),
                             ({"wall": 1, "radius": 5}, "wall = 1 "), ({"wall": 0.9, "radius": 5, "ports": 1, "diffuse": 0.5}, "ports = 1 "),
                             ({"wall": 0.9, "radius": 5}, "diffuse = None"), ({"diffuse": 0.5}, "diffuse = 0.5 .expected None without a wall"),
                             ({"standard": 0}, "standard = 0 "), ({"specular": 1}, "specular = 1 "), ({"wall": 0.9, "radius": 5, "diffuse": 1.5}, "diffuse = 1.5 ")):
            with self.assertRaisesRegex(mc.InputError, text):
                mc.sphere(result, **{"port": 0.5, **values})


class Fits(unittest.TestCase):
    def readings(self, scene, instrument, result):
        """Returns readings of a scene by its one long flight, and one in diffuse light, with errors of 0.5 %."""
        port = instrument["port"]
        light = mc.run(mc.Scene(scene.layers, nr=50, dr=0.05, beam=mc.Beam("disk", radius=port, light="lambertian")), photons=1e5, seed=88) if "wall" in instrument else None
        seen = mc.sphere(result, diffuse=light, **instrument)
        return {name: (float(seen[name]), 0.005 * float(seen[name])) for name in ("M_R", "M_T")}

    def test_a_fit_with_lost_light_finds_what_a_fit_without_misses(self):
        """A fit of M_R and M_T finds mua and mus. A fit that takes them for R and Tt misses mua by more than five of its errors."""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "slab.mci")
            slab(beam=mc.Beam("disk", radius=0.1), detectors=[mc.Detector("disk", radius=0.1, name="own")]).write(path)
            scene = slab(beam=mc.Beam("disk", radius=0.1))
            result = mc.run(scene, photons=1e5, seed=77)
            for instrument in (SPHERE, {"port": 0.5, "specular": False}):
                data = self.readings(scene, instrument, result)
                fit = mc.fit(path, BOUNDS, data, sphere=instrument, photons=2e4)
                for name, value in TRUTH.items():
                    self.assertLess(abs(fit.values[name] - value), 4 * fit.errors[name], (instrument, name))
                    self.assertLess(fit.errors[name], 0.05 * value)
                self.assertAlmostEqual(fit.prediction["M_R"], data["M_R"][0], 3)
                without = mc.fit(path, BOUNDS, {"R" if instrument is SPHERE else "Rd": data["M_R"], "Tt": data["M_T"]}, photons=2e4)
                self.assertGreater(without.values["layer1.mua"] - 0.5, 5 * without.errors["layer1.mua"])

    def test_refusals(self):
        seen = {"M_R": (0.3, 0.01), "M_T": (0.3, 0.01)}
        for measured, sphere, text in ((seen, None, "sphere = None .expected a dict with port"), (seen, {"port": 0.5, "baffle": 1}, "a dict with port, and of radius wall"),
                                       ({"Rd": (0.3, 0.01), "M_R": (0.3, 0.01)}, SPHERE, "M_R and Rd. .expected one of them"),
                                       ({"M_R": (1.7, 0.01)}, SPHERE, "from 0 to 1")):
            with self.assertRaisesRegex(mc.InputError, text):
                mc.fit(slab(), BOUNDS, measured, sphere=sphere, photons=100)


if __name__ == "__main__":
    unittest.main()
