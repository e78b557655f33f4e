"""Tests of flights in this process, by libclustermcml: arrays and attributes are those of the program's .h5, to the bit, also of 20 runs at once;
no process starts; an interrupt stops a flight; many flights take no more memory; and messages are those of the program."""
import ctypes
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock
import warnings

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import TOP, mc, np  # noqa: E402
from clustermcml import library  # noqa: E402
from clustermcml.h5 import read_h5  # noqa: E402
from clustermcml.program import find_program  # noqa: E402
from clustermcml.progress import Progress  # noqa: E402

SLAB = mc.Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1)
WHOLE = "ALL_CASES" in os.environ


def sample(name):
    return os.path.join(TOP, "samples", name + ".mci")


def no_process(*_, **__):
    raise AssertionError("a process was started")


def memory():
    """Returns the kilobytes that this process holds."""
    with open("/proc/self/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS"))


class InProcess(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def of_program(self, path, *words):
        """Returns the result of the program, which it writes into an .h5."""
        subprocess.run([find_program(), path, "--quiet", "--output", "a.h5", "-o", self.folder, *words], check=True)
        return read_h5(os.path.join(self.folder, "a.h5"))

    def two_runs(self):
        path = os.path.join(self.folder, "two.mci")
        with open(path, "w", encoding="utf-8") as file:
            file.write("1.0\n2\n" + "".join(f"{name}.mco A\n100\n0.01 0.01\n2 2 2\n1\n1.0\n1.4 1 10 0.8 0.1\n1.0\n" for name in "ab"))
        return path

    def same(self, result, expected):
        """Fails unless a Dataset has all arrays and attributes of a file, and no other."""
        self.assertEqual(sorted(result.variables), sorted(expected.held))
        for name, array in expected.held.items():
            np.testing.assert_array_equal(result[name].values, array.values, name)
            self.assertEqual((result[name].dtype, result[name].dims, result[name].attrs), (array.values.dtype, array.dims, array.attrs), name)
        for name, value in expected.attrs.items():
            if not name.startswith("call_") and name != "title":
                self.assertEqual(result.attrs[name], value, name)

    @unittest.mock.patch("clustermcml.program._start", no_process)
    def test_bits(self):
        """Maps, voxels, facets, bodies, detectors, gates, tiles, expected values, derivatives."""
        for name, words, options in (("skinmap", [], {}), ("vein", ["--derivatives"], {"derivatives": True}), ("fibres", [], {}), ("pattern", ["--seed", "3"], {"seed": 3}),
                                     ("thick", ["--aim", "Tt", "--target-error", "0.3"], {"aim": "Tt", "target_error": 0.3}), ("fig5", ["--engine", "reference"], {"engine": "reference"})):
            with self.subTest(name):
                given = ["--set", "layer1.mua=0.2", "--photons", "2000", *words]
                self.same(mc.run(sample(name), set={"layer1.mua": 0.2}, photons=2000, **options), self.of_program(sample(name), *given))

    @unittest.mock.patch("clustermcml.program._start", no_process)
    def test_twenty_at_once(self):
        """Runs in threads share nothing."""
        names = ("fig5", "vein", "ridges", "furrows")
        expected = {name: self.of_program(sample(name), "--photons", "1000") for name in names}
        found = {}

        def fly(k):
            found[k] = mc.run(sample(names[k % 4]), photons=1000, threads=1 + k % 3)
        threads = [threading.Thread(target=fly, args=(k,)) for k in range(20)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(found), 20)
        for k, result in found.items():
            self.same(result, expected[names[k % 4]])

    @unittest.mock.patch("clustermcml.program._start", no_process)
    def test_interrupt(self):
        """Ctrl-C ends a flight that would take days, and the next flight is as ever."""
        main = threading.get_ident()

        def interrupt():
            time.sleep(0.7)
            signal.pthread_kill(main, signal.SIGINT)
        threading.Thread(target=interrupt).start()
        begin = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            mc.run(sample("thick"), photons=1e13, threads=1)
        print(f"an interrupt ended the flight after {time.monotonic() - begin - 0.7:.2f} s", file=sys.stderr)
        self.same(mc.run(sample("fig5"), photons=1000), self.of_program(sample("fig5"), "--photons", "1000"))

    def test_memory(self):
        """Flights leave nothing behind."""
        loaded = library.find(find_program(), {})
        count, held = 10000 if WHOLE else 900, []
        with library.Scene(loaded, sample("fig5"), ["--photons", "100", "--threads", "1"], str) as scene:
            for k in range(count):
                self.assertEqual(loaded.clm_scene_set_number(scene.scene, 0, b"layer1.mua", ctypes.c_double(0.1 + k / count)), 0)
                result = scene.fly(["--seed", str(k)], Progress(False))
                held += [memory()] if k % (count // 3) == count // 3 - 1 else []
        self.assertEqual(result["layer_mua"].values[0], 0.1 + (count - 1) / count)
        self.assertLess(held[-1] - held[0], 600, held)

    def test_progress(self):
        """Photons and their rate are shown while the run flies."""
        shown = []
        with unittest.mock.patch.object(Progress, "show", lambda self, percent, text: shown.append((percent, text))):
            mc.run(sample("thick"), photons=3e5, threads=1, progress=True)
        self.assertTrue(shown and shown == sorted(shown, key=lambda one: one[0]), shown)
        self.assertRegex(shown[0][1], "^[0-9.e+]+ photons/s, [0-9]+ s left$")

    def test_messages(self):
        """Refusals name the scene and the argument as the program does; notes are warnings."""
        for call, text in ((lambda: mc.run(mc.Scene([SLAB], beam=mc.Beam(z=0.1))), "^Scene: beam: "), (lambda: mc.run(sample("fig5"), photons=-1), "--photons"),
                           (lambda: mc.run(sample("fig5"), set={"layer1.mu": 1}), r"--set: layer1.mu = 1 \(expected"),
                           (lambda: mc.run(self.two_runs()), "expected a file with one run, this one has 2"), (lambda: mc.run(os.devnull), "/dev/null")):
            with self.assertRaisesRegex(mc.InputError, text):
                call()
        heights = np.array([[0, 0.01, 0.02], [0.01, 0, 0.01], [0, 0.02, 0.01]])
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            mc.run(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, mc.Heightmap(heights, 0.1))], photons=10))
        self.assertIn("Scene: a pencil meets boundary 0 at one point", " ".join(str(one.message) for one in told))

    def test_files_need_the_program(self):
        """With a folder for its files, a run is the program's."""
        with unittest.mock.patch("clustermcml.program._start", no_process), self.assertRaisesRegex(AssertionError, "a process"):
            mc.run(sample("fig5"), photons=100, output_dir=self.folder)


if __name__ == "__main__":
    unittest.main()
