"""The Python package against the files and the program: arrays equal what the files hold, scenes say what was meant, runs give what
the command line gives, an interrupt leaves a checkpoint, and every error names the argument, its value and what was expected."""
import io
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
sys.path.insert(0, os.path.join(TOP, "src", "python"))
try:
    import h5py
    import numpy as np
    import xarray as xr
except ImportError as error:
    print(error)
    sys.exit(77)
import clustermcml as mc  # noqa: E402
from clustermcml.program import _listen, find_program  # noqa: E402
from clustermcml.progress import Progress  # noqa: E402

SLAB = mc.Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1)
SKIN = os.path.join(TOP, "samples", "skin7.mci")


def command(*words):
    """Standard output of the program."""
    return subprocess.run([find_program(), *words], stdout=subprocess.PIPE, check=True, text=True).stdout


def numbers_of(path, key, count):
    """The first `count` numbers of a section of an .mco, as its text has them."""
    with open(path, encoding="utf-8") as file:
        body = re.split(r"(?m)^%s( #.*)?$" % key, file.read())[-1]
    return [float(word) for word in re.sub("#.*", "", body).split()[:count]]


class Files(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        scene = mc.Scene([mc.Layer(1.34, 0.2, 0, 0, 0.02), SLAB], photons=2000, nr=7, nz=5, na=3, dr=0.05, dz=0.03,
                         map=mc.Map(4, 3, 0.1, 0.2, angles=True, volume=True), facets=True, format="A",
                         bottom=mc.Heightfield([0, 0.1], [0.02, 0]))
        scene.write(os.path.join(cls.folder.name, "a.mci"))
        command(os.path.join(cls.folder.name, "a.mci"), "--quiet", "-o", cls.folder.name)
        cls.mco, cls.h5 = (os.path.join(cls.folder.name, "a" + end) for end in (".mco", ".h5"))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_mco(self):
        data = mc.read(self.mco)
        for name, shape in (("A_l", 2), ("A_z", 5), ("Rd_r", 7), ("Tt_a", 3), ("A_rz", (7, 5)), ("Rd_ra", (7, 3))):
            np.testing.assert_array_equal(data[name].values, np.reshape(numbers_of(self.mco, name, np.prod(shape)), shape), name)
        np.testing.assert_array_equal(data.Rd_r_se.values, numbers_of(self.mco, "se_Rd_r", 7))
        self.assertEqual(data.photons, 2000)
        self.assertEqual(data.attrs["seed"], 1)
        np.testing.assert_array_equal(data.layer_n, [1.34, 1.4])

    def test_h5(self):
        data = mc.read(self.h5)
        with h5py.File(self.h5) as file:
            arrays = [name for name in file if isinstance(file[name], h5py.Dataset)]
            self.assertEqual(sorted(data.variables), sorted(arrays))
            for name in arrays:
                np.testing.assert_array_equal(data[name].values, file[name][()], name)
                self.assertEqual(data[name].attrs["units"], file[name].attrs["units"].decode())
        self.assertEqual(data.Rd_xya.dims, ("y", "x", "alpha"))

    def test_both_say_the_same(self):
        mco, h5 = mc.read(self.mco), mc.read(self.h5)
        self.assertLessEqual(set(mco.variables), set(h5.variables))
        for name in mco.variables:
            np.testing.assert_allclose(mco[name], h5[name], rtol=6e-4, atol=1e-12, err_msg=name)
            self.assertEqual((mco[name].dims, mco[name].attrs["units"]), (h5[name].dims, h5[name].attrs["units"]), name)
            self.assertEqual(mco[name].attrs.get("ancillary_variables"), h5[name].attrs.get("ancillary_variables"), name)
        for name in ("photons", "seed", "run", "engine", "sampling", "version", "title"):
            self.assertEqual(mco.attrs[name], h5.attrs[name], name)

    def test_original_mcml(self):
        """Its files end behind Tt_ra, and have no errors."""
        path = os.path.join(self.folder.name, "old.mco")
        with open(self.mco, encoding="utf-8") as file, open(path, "w", encoding="utf-8") as old:
            old.write(file.read().split("\n# clustermcml")[0])
        data = mc.read(path)
        xr.testing.assert_equal(data.Tt_ra, mc.read(self.mco).Tt_ra)
        self.assertNotIn("Rd_se", data)

    def test_damaged(self):
        path = os.path.join(self.folder.name, "cut.mco")
        with open(self.mco, encoding="utf-8") as file, open(path, "w", encoding="utf-8") as cut:
            cut.write(file.read()[:900])
        for name, content in (("not.mco", "hello"), ("not.h5", "hello"), ("not.txt", "hello")):
            with open(os.path.join(self.folder.name, name), "w", encoding="utf-8") as file:
                file.write(content)
        for name, text in (("cut.mco", "not a whole .mco"), ("not.mco", "not an .mco"), ("not.h5", "not an .h5"),
                           ("not.txt", "expected a name that ends in .mco or .h5"), ("none.h5", "a file that is there")):
            with self.assertRaisesRegex(mc.InputError, text):
                mc.read(os.path.join(self.folder.name, name))


class Scenes(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = os.path.join(self.folder.name, "scene.mci")

    def checked(self, scene):
        scene.write(self.path)
        return json.loads(command("check", "--json", self.path))

    def test_everything_arrives(self):
        scene = mc.Scene([mc.Layer(1.37, 0.1, 50.5, -0.3, 1e-3), SLAB], n_above=1.1, n_below=1.2, photons=12345, dr=0.1, dz=0.2, nr=3,
                         nz=4, na=5, beam=mc.Beam("gaussian", 0.1, at=(0.01, -0.02), angle=30, azimuth=45),
                         map=mc.Map(6, 7, 0.1, 0.3, volume=True, top=-0.1))
        told = self.checked(scene)
        self.assertEqual(told["layers"], [{"n": 1.37, "mua": 0.1, "mus": 50.5, "g": -0.3, "d": 1e-3},
                                          {"n": 1.4, "mua": 1.0, "mus": 100.0, "g": 0.9, "d": 0.1}])
        self.assertEqual((told["n_above"], told["n_below"], told["photons"]), (1.1, 1.2, 12345))
        self.assertEqual(told["grid"], {"dz": 0.2, "dr": 0.1, "nz": 4, "nr": 3, "na": 5})
        self.assertEqual([told["map"][key] for key in ("nx", "ny", "dx", "dy", "volume")], [6, 7, 0.1, 0.3, True])
        with open(self.path, encoding="utf-8") as file:
            self.assertIn("beam gaussian 0.1 at=0.01,-0.02 angle=30 azimuth=45\n", file.read())

    def vertices(self):
        command("mesh", self.path, "-o", self.folder.name)
        name = next(name for name in os.listdir(self.folder.name) if name.endswith("boundary0.obj"))
        with open(os.path.join(self.folder.name, name), encoding="utf-8") as file:
            return np.array([line.split()[1:4] for line in file if line.startswith("v ")], dtype=float)

    def test_heightmap_lies_as_the_array_says(self):
        heights = np.zeros((5, 7))
        heights[3, 1] = 0.02  # above the middle, left of it
        self.checked(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, mc.Heightmap(heights, 0.1, 0.2))]))
        peak = max(self.vertices(), key=lambda vertex: vertex[2])
        np.testing.assert_allclose(peak, [-0.2, 0.2, 0.02], atol=1e-7)

    def test_heightmap_is_repeated(self):
        heights = np.array([[0, 0.02, 0.01], [0, 0.01, 0.02]])
        for tile, period in ((True, "0.3 x 0.2"), ("mirror", "0.4 x 0.2")):
            scene = mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, mc.Heightmap(heights, 0.1, tile=tile))])
            self.assertIn(f"repeated every {period} cm", self.checked(scene)["boundaries"][0]["reason"])

    def test_mesh_from_arrays(self):
        vertices = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0.1, 0.2, 0.05]]
        faces = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
        mesh = mc.Mesh(vertices=vertices, faces=faces, units="mm", shift=(0, 0, 0.001))
        self.assertEqual(self.checked(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, mesh)]))["boundaries"][0]["kind"], "mesh")
        peak = max(self.vertices(), key=lambda vertex: vertex[2])
        np.testing.assert_allclose(peak, [0.01, 0.02, 0.006], atol=1e-9)

    def test_errors_name_argument_value_and_what_was_expected(self):
        cases = [(lambda: mc.Layer(1.4, -1, 1, 0, 1), r"Layer\.mua = -1 \(expected a number >= 0\)"),
                 (lambda: mc.Layer(1.4, 1, 1, 2, 1), r"Layer\.g = 2 \(expected"),
                 (lambda: mc.Layer(1.4, 1, 1, 0, "1"), r"Layer\.d = '1' \(expected"),
                 (lambda: mc.Layer(1.4, 1, float("nan"), 0, 1), r"Layer\.mus = nan \(expected"),
                 (lambda: mc.Layer(1.4, 1, 1, 0, 1, top="a.obj"), r"Layer\.top = 'a\.obj' \(expected"),
                 (lambda: mc.Beam("disc", 1), r"Beam\.kind = 'disc' \(expected"), (lambda: mc.Beam("disk"), r"Beam\.radius = None"),
                 (lambda: mc.Beam(angle=90), r"Beam\.angle = 90"), (lambda: mc.Beam(at=1), r"Beam\.at = 1 \(expected 2 numbers"),
                 (lambda: mc.Map(0, 1, 1, 1), r"Map\.nx = 0"), (lambda: mc.Map(1, 1, 1, 1, top=1), r"Map\.top = 1"),
                 (lambda: mc.Heightfield([0, 1], [0]), r"Heightfield\.h = \[0\] \(expected 2 finite"),
                 (lambda: mc.Heightfield([1, 2], [0, 0]), r"Heightfield\.r = \[1, 2\]"),
                 (lambda: mc.Heightmap([1.0, 2.0], 1), r"Heightmap\.heights = \[1\.0, 2\.0\]"),
                 (lambda: mc.Mesh("none.obj"), r"Mesh\.path = 'none\.obj' \(expected"), (lambda: mc.Mesh(), r"Mesh\.path = None"),
                 (lambda: mc.Heightmap([[0, 0], [0, 0]], 1, tile="twice"), r"Heightmap\.tile = 'twice' \(expected"),
                 (lambda: mc.Mesh(vertices=[[0, 0, 0]], faces=[[0, 1, 2]]), r"Mesh\.faces = .* \(expected indices from 0 to 0"),
                 (lambda: mc.Scene([]), r"Scene\.layers = \[\] \(expected"), (lambda: mc.Scene([SLAB], photons=0.5), r"Scene\.photons = 0\.5"),
                 (lambda: mc.Scene([SLAB], nr=2.5), r"Scene\.nr = 2\.5"), (lambda: mc.Scene([SLAB], beam=None), r"Scene\.beam = None")]
        for make, text in cases:
            with self.assertRaisesRegex(mc.InputError, text):
                make()


class Runs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def test_as_the_command_line(self):
        mine = mc.run(SKIN, photons=3000, seed=5, output_dir=self.folder)
        kept = mc.read(os.path.join(self.folder, "skin7.mco"))
        xr.testing.assert_equal(mine, kept)
        other = os.path.join(self.folder, "other")
        os.mkdir(other)
        command(SKIN, "--photons", "3000", "--seed", "5", "--quiet", "-o", other)
        xr.testing.assert_equal(mine, mc.read(os.path.join(other, "skin7.mco")))
        self.assertGreater(mine.attrs["steps"], 3000)

    def test_nothing_stays_without_a_folder(self):
        before = os.listdir(tempfile.gettempdir())
        mc.run(mc.Scene([SLAB], photons=100))
        self.assertEqual([name for name in os.listdir(tempfile.gettempdir()) if name.startswith("clustermcml_") and name not in before],
                         [])

    def test_errors_are_the_programs(self):
        scene = mc.Scene([SLAB], photons=100)
        for options, text in (({"seed": "x"}, r"--seed x \(expected a whole number"), ({"sead": 1}, "unknown option --sead"),
                              ({"json": True}, r"json = True"), ({"output_dir": "/none"}, r"output_dir = '/none' \(expected a folder")):
            with self.assertRaisesRegex(mc.InputError, text):
                mc.run(scene, **options)
        with self.assertRaisesRegex(mc.InputError, "scene = 'none.mci'"):
            mc.run("none.mci")

    def test_notes_are_warnings(self):
        with open(os.path.join(self.folder, "a.mci"), "w", encoding="utf-8") as file:
            file.write(mc.Scene([SLAB], photons=100).text("a.h5") + "b.mco A\n")  # a second run, beyond the number of runs
        with self.assertWarnsRegex(UserWarning, "a.mci"):
            mc.run(os.path.join(self.folder, "a.mci"), output_dir=self.folder)

    def test_interrupt(self):
        """Ctrl-C while it flies: the program stops, its checkpoint stays, and resuming gives the result of one run."""
        script = ("import sys; sys.path.insert(0, sys.argv[1]); import clustermcml as mc\n"
                  "mc.run(sys.argv[2], photons=4e6, threads=1, checkpoint=0.1, output_dir=sys.argv[3])")
        process = subprocess.Popen([sys.executable, "-c", script, sys.path[0], os.path.join(TOP, "samples", "thick.mci"), self.folder],
                                   stderr=subprocess.PIPE, text=True)
        checkpoint = os.path.join(self.folder, "thick.mco.checkpoint")
        while not os.path.exists(checkpoint) and process.poll() is None:
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate()
        self.assertIn("KeyboardInterrupt", said)
        self.assertTrue(os.path.exists(checkpoint))
        self.assertFalse(os.path.exists(os.path.join(self.folder, "thick.mco")))
        resumed = mc.run(os.path.join(TOP, "samples", "thick.mci"), photons=4e6, resume=True, output_dir=self.folder)
        self.assertEqual(resumed.photons, 4000000)
        xr.testing.assert_equal(resumed, mc.run(os.path.join(TOP, "samples", "thick.mci"), photons=4e6))

    def test_sweep(self):
        """Every combination is the run with these values."""
        scene = mc.Scene([SLAB, mc.Layer(1.5, 0.2, 10, 0, 0.1)], photons=500, nr=4, nz=3, na=2)
        swept = mc.sweep(scene, {"layer2.mua": [0.5, 0.1], "layer1.d": [0.1, 0.2, 0.3]})
        self.assertEqual(swept.Rd_ra.dims, ("layer2.mua", "layer1.d", "r", "alpha"))
        for mua in (0.5, 0.1):
            for d in (0.1, 0.2, 0.3):
                alone = mc.run(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, d), mc.Layer(1.5, mua, 10, 0, 0.1)], photons=500, nr=4, nz=3, na=2))
                one = swept.sel({"layer2.mua": mua, "layer1.d": d}).drop_vars(["layer2.mua", "layer1.d"])
                xr.testing.assert_equal(one, alone)
        self.assertNotIn("seconds", swept.attrs)
        self.assertEqual(swept.attrs["photons"], 500)

    def test_sweep_keeps_what_is_asked_for(self):
        scene = mc.Scene([SLAB], photons=100)
        swept = mc.sweep(scene, {"seed": [1, 2, 3]}, variables=["Rd", "Rd_se"], output_dir=self.folder)
        self.assertEqual(sorted(swept.data_vars), ["Rd", "Rd_se"])
        self.assertEqual(swept.Rd.shape, (3,))
        self.assertTrue(os.path.exists(os.path.join(self.folder, "scene-0003.h5")))
        for parameters, text in (({"layer1.mua": [1, 1]}, r"parameters\['layer1.mua'\] = \[1, 1\] \(expected values that differ"),
                                 ({"layer1.mua": 1}, "a list of at least one number"), ({}, "a dict of names"),
                                 ({"layer9.mua": [1]}, "layer9.mua"), ({"layer1.g": [2.0]}, "layer1.g")):
            with self.assertRaisesRegex(mc.InputError, text):
                mc.sweep(scene, parameters)
        with self.assertRaisesRegex(mc.InputError, "variables = 'Rx' .expected one of"):
            mc.sweep(scene, {"seed": [1]}, variables=["Rx"])

    def shown_of(self, call):
        """What is written to standard error with progress=True."""
        shown, real = io.StringIO(), sys.stderr
        sys.stderr = shown
        try:
            call()
        finally:
            sys.stderr = real
        return shown.getvalue()

    def test_progress(self):
        """The program's own bar, and rows of a sweep."""
        thick = os.path.join(TOP, "samples", "thick.mci")
        self.assertRegex(self.shown_of(lambda: mc.run(thick, photons=2e6, threads=1, progress=True)), r"\r\d+ %, .* left")
        rows = self.shown_of(lambda: mc.sweep(mc.Scene([SLAB], photons=100), {"seed": [1, 2]}, progress=True))
        self.assertIn("50 %, 1 of 2 rows", rows)
        self.assertIn("100 %, 2 of 2 rows", rows)
        self.assertEqual(self.shown_of(lambda: mc.run(thick, photons=1e6, progress=False)), "")

    def test_what_the_program_says_is_taken_apart(self):
        said = []
        with Progress(False) as progress:
            _listen(["[##..]  50 %  1e+06 photons/s  1 s, 1 s left\033[K", "\033[K", "clustermcml: note: hello"], progress, said)
        self.assertEqual(said, ["clustermcml: note: hello"])


if __name__ == "__main__":
    unittest.main()
