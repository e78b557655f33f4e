"""Tests of sweeps over the rows of a table: each row equals the run with its values, and labels are carried along."""
import os
import subprocess
import sys
import tempfile
import unittest
import warnings

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import mc, np, xr  # noqa: E402
import pandas as pd  # noqa: E402
from clustermcml.program import find_program  # noqa: E402


def slab(mua=1.0, mus=100.0):
    return mc.Scene([mc.Layer(n=1.4, mua=mua, mus=mus, g=0.9, d=0.1)], photons=300, nr=4, nz=3, na=2)


MUA, MUS, NM, LEAF = [0.5, 1, 0.5], [100, 50, 20], [450, 500, 550], ["young", 'old, "dry"', "x#1"]


class Tables(unittest.TestCase):
    def check_rows(self, swept, dim):
        """Checks that each row equals the run with these values."""
        self.assertEqual(swept.Rd_ra.dims, (dim, "r", "alpha"))
        for i, (mua, mus) in enumerate(zip(MUA, MUS)):
            row = swept.isel({dim: i})
            xr.testing.assert_equal(row.drop_vars(set(row.coords) - {"r", "z", "alpha", "layer", "boundary"}), mc.run(slab(mua, mus)))
        np.testing.assert_array_equal(swept["layer1.mua"], MUA)
        self.assertEqual(swept["layer1.mus"].dims, (dim,))

    def test_rows_of_one_flight(self):
        """Rows of one flight, by reweighting, lie within 5 errors of rows with flights of their own, in the same order."""
        scene = mc.Scene([mc.Layer(1.4, 0.1, 50, 0.8, 0.1)], photons=20000, time=mc.Time(end=30, n=4), detectors=[mc.Detector("disk", radius=0.1, name="a")])
        values = {"layer1.mua": [2, 0.2], "layer1.mus": [30, 50]}
        swept, own = mc.sweep(scene, values, reweight=True), mc.sweep(scene, values, seed=2)
        for name in ("Rd", "Tt", "A_l", "A_z", "A_t", "detector_a_path", "detector_a_interactions", "detector_a_deepest"):
            self.assertEqual(swept[name].dims, own[name].dims)
            error = np.hypot(swept[name + "_se"], own[name + "_se"])
            self.assertTrue(bool((abs(swept[name] - own[name]) <= 5 * error + 1e-12).all()), name)
        self.assertEqual(swept.A_rz.dims, own.A_rz.dims)
        less = mc.sweep(scene, values, reweight=True, ignore_absorption=True)
        self.assertEqual([name for name in ("A_z", "A_rz", "A_t") if name in less], [])

    def test_lists(self):
        swept = mc.sweep(slab(), {"layer1.mua": MUA, "layer1.mus": np.array(MUS)}, dim="sample")
        self.check_rows(swept, "sample")
        self.assertNotIn("sample", swept.coords)
        labelled = mc.sweep(slab(), {"layer1.mua": MUA, "layer1.mus": MUS}, coords={"wavelength nm": NM, "leaf": LEAF}, dim="wavelength nm")
        self.check_rows(labelled, "wavelength nm")
        self.assertEqual(labelled.leaf.sel({"wavelength nm": 500}), LEAF[1])
        self.assertEqual(labelled["wavelength nm"].dtype.kind, "i")

    def test_data_frames(self):
        frame = pd.DataFrame({"nm": NM, "layer1.mua": MUA, "layer1.mus": MUS, "leaf": LEAF})
        self.check_rows(mc.sweep(slab(), frame, coords=["nm", "leaf"]), "row")
        indexed = mc.sweep(slab(), frame.set_index("nm"), coords=["leaf"])
        self.check_rows(indexed, "nm")
        np.testing.assert_array_equal(indexed.nm, NM)
        xr.testing.assert_equal(indexed, mc.sweep(slab(), frame, coords=["nm", "leaf"], dim="nm"))

    def test_a_label_is_nothing_that_is_set(self):
        for coords in ({"layer1.mua": [1, 2, 3]}, {"seed": [1, 2, 3]}, {"photons": [1, 2, 3]}):
            with self.assertRaisesRegex(mc.InputError, "^parameters: column 2 = .* .expected the name without quotation marks, if it is to be set"):
                mc.sweep(slab(), {"layer1.mus": MUS}, coords=coords)
        with self.assertWarnsRegex(UserWarning, "column 2, wavelength, is a label"):
            swept = mc.sweep(slab(), pd.DataFrame({"layer1.mus": MUS, "wavelength": NM}))
        self.assertEqual(swept["wavelength"].values.tolist(), NM)

    def test_a_layer_has_its_name(self):
        gel, glass = (mc.Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1, name=name) for name in ("gel", "glass"))
        named = mc.Scene([gel, glass], photons=300)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            swept = mc.sweep(named, {"glass.mua": [1, 5]})
        self.assertEqual(swept.Rd.dims, ("glass.mua",))
        with self.assertWarnsRegex(UserWarning, "layer2 counts from above, in a scene of 2 layers and 0 bodies"):
            other = mc.sweep(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1)] * 2, photons=300), {"layer2.mua": [1, 5]})
        self.assertEqual(swept.A_l.values.tolist(), other.A_l.values.tolist())
        self.assertEqual([layer["name"] for layer in mc.check(named)[0]["layers"]], ["gel", "glass"])
        for layers, message in (([gel, gel], "layers whose names differ"),):
            with self.assertRaisesRegex(mc.InputError, message):
                mc.Scene(layers)
        for name in ("layer2", "above", "seed", "2x", "a-b", "", "x" * 25, 1):
            with self.assertRaisesRegex(mc.InputError, "^Layer.name = "):
                mc.Layer(1.4, 1, 100, 0.9, 0.1, name=name)

    def test_labels_reach_the_table(self):
        """Labels stand in the table of a sweep in their own words, so that the table can be flown again."""
        with tempfile.TemporaryDirectory() as folder:
            mc.sweep(slab(), {"layer1.mua": MUA, "leaf": LEAF, "nm": NM}, coords=["leaf", "nm"], output_dir=folder)
            table = pd.read_csv(os.path.join(folder, "scene.sweep.csv"))
            self.assertEqual((list(table.leaf), list(table.nm), list(table["layer1.mua"])), (LEAF, NM, MUA))
            with open(os.path.join(folder, "scene.sweep.csv"), encoding="utf-8") as file:
                self.assertIn('row,layer1.mua,"leaf","nm",photons,', file.read())
            with xr.open_dataset(os.path.join(folder, "scene.sweep.h5"), engine="h5netcdf") as told:
                self.assertEqual(("leaf" in told, list(told.nm), told.nm.dims), (False, NM, ("row",)))

    def test_the_program_carries_labels(self):
        """The program carries labels through a full grid, in which they are no axes."""
        with tempfile.TemporaryDirectory() as folder:
            slab().write(os.path.join(folder, "a.mci"))
            with open(os.path.join(folder, "t.csv"), "w", encoding="utf-8") as file:
                file.write('# blanks, "" and # in labels\nlayer1.mua, "no / nm" ,layer1.mus,"a ""b"" #1"\n')
                file.writelines(f'{mua}, "{10 * mua + mus}" ,{mus}, "c, # d" # comment\n' for mua in (1, 2) for mus in (10, 20))
            subprocess.run([find_program(), os.path.join(folder, "a.mci"), "--sweep", os.path.join(folder, "t.csv"), "--quiet", "-o", folder], check=True)
            with xr.open_dataset(os.path.join(folder, "a.sweep.h5"), engine="h5netcdf") as told:
                self.assertEqual(told.Rd.dims, ("layer1.mua", "layer1.mus"))
                np.testing.assert_array_equal(told["no _ nm"], [[20, 30], [30, 40]])
            table = pd.read_csv(os.path.join(folder, "a.sweep.csv"))
            self.assertEqual((list(table["no / nm"]), set(table['a "b" #1'])), ([20, 30, 30, 40], {"c, # d"}))

    def test_refused(self):
        for parameters, more, text in (
                ({"layer1.mua": [1, 2], "layer1.mus": [1]}, {"dim": "a"}, r"parameters\['layer1.mus'\] = \[1\] .expected 2 values"),
                ({"layer1.mua": [1]}, {"coords": ["nm"]}, "coords = 'nm' .expected names of columns"),
                ({"layer1.mua": [1]}, {"coords": "layer1.mua"}, "coords = 'layer1.mua'"), ({"nm": [1]}, {"coords": ["nm"]}, "at least one column must be set"),
                ({"layer1.mua": ["a"]}, {"dim": "a"}, "a list of at least one number"), ({"layer1.mua": [1]}, {"dim": "r"}, "dim = 'r' .expected a name that no"),
                ({"layer1.mua": [1], "Rd": [1]}, {"coords": ["Rd"]}, "label = Rd"), ({"layer1.mua": [1], "a": ["x\ny"]}, {"coords": ["a"]}, "texts of one line"),
                (pd.DataFrame([[1, 2]], columns=["layer1.mua"] * 2), {}, "names that differ"), (5, {}, "a dict of names"),
                (pd.DataFrame(), {}, "parameters = ")):
            with self.assertRaisesRegex(mc.InputError, text):
                mc.sweep(slab(), parameters, **more)


if __name__ == "__main__":
    unittest.main()
