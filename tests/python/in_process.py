"""Tests of flights in this process, by libclustermcml: arrays and attributes are those of the program's .h5, to the bit, also of 20 runs at once and of
rows of sweeps; no process starts and no folder is made; an interrupt stops a run, a sweep, a fit; many flights take no more memory; messages are
those of the program; and without the library the program gives the same."""
import ctypes
import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import types
import unittest
import unittest.mock
import warnings

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import TOP, mc, np, xr  # noqa: E402
from clustermcml import library  # noqa: E402
from clustermcml.h5 import read_h5  # noqa: E402
from clustermcml.program import find_program  # noqa: E402
from clustermcml.progress import Progress  # noqa: E402

SLAB = mc.Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1)
WHOLE = "ALL_CASES" in os.environ
MEASURED = {"seconds", "cpu_s", "photons_per_s", "call_command", "call_input_file"}  # attributes that differ


def sample(name):
    return os.path.join(TOP, "samples", name + ".mci")


def no_process(*_, **__):
    raise AssertionError("a process was started")


def no_folder(*_, **__):
    raise AssertionError("a folder was made")


def rows(scene, **options):
    """Flies a sweep in which two rows in three have the same mus."""
    return mc.sweep(scene, {"layer1.mua": [0.5, 2, 0.3], "layer1.mus": [60, 90, 60], "seed": [4, 5, 4]}, dim="case", photons=1000, **options)


def bits(result):
    """Returns the bytes of all arrays of a Dataset, without how long it took."""
    return {name: array.values.tobytes() for name, array in result.variables.items()}


def fly_ridges(seed):
    return bits(mc.run(sample("ridges"), photons=500, seed=seed))


def memory():
    """Returns the kilobytes that this process holds."""
    with open("/proc/self/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS"))


# what a script does under a launcher: with one process it flies, twice, without and with a folder; with several it says so, and does all else
RANKS = """
import os, sys
sys.path[:] = sys.argv[1].split(os.pathsep)
import clustermcml as mc
path, folder, count, module = sys.argv[2:]
sys.modules[module], flies = sys, count == "1" or module == "mpi4py.MPI"
folder += "." + str(os.getpid())
scene = mc.Scene([mc.Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1)], photons=1000)
calls = [lambda: mc.run(scene), lambda: mc.run(path, photons=100, output_dir=folder), lambda: mc.sweep(scene, {"layer1.mua": [1, 2]})]
for call in 2 * calls:
    try:
        call()
        said = ""
    except mc.InputError as error:
        said = str(error)
    assert (said == "") == flies and (not said or " flies in one process, and a launcher started 2 (" in said and
                                      said.endswith("=2): start the program with mpiexec, or one Python without it; or import mpi4py.MPI, and let each process fly a run of its own")), said
for _ in range(2):
    assert mc.check(path) and mc.exact(scene) and mc.__version__, "no answer"
assert mc.read(os.path.join(os.path.dirname(folder), "a.h5")).Rd > 0 and (not flies or mc.read(os.path.join(folder, "fig5.mco")).Rd > 0)
open(folder + ".done", "w").close()
"""


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

    def test_rows_are_those_of_files(self):
        """Rows of a sweep equal those that the program writes into .h5 files: of one flight, with derivatives on a mesh, and of a file on a hill."""
        heights, path = np.random.default_rng(1).random((8, 8)) * 0.01, os.path.join(self.folder, "hill.mci")
        plane = mc.Scene([SLAB], nr=20, detectors=[mc.Detector("ring", r1=0.02, r2=0.05, name="near")], time=mc.Time(30, 4))
        mesh = mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, mc.Heightmap(heights, 0.1))], nr=20)
        mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, mc.Heightfield([0, 0.1], [0.02, 0]))], facets=True).write(path)
        for k, (scene, options) in enumerate(((plane, {"reweight": True}), (mesh, {"derivatives": True}), (path, {}))):
            with self.subTest(k), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                with unittest.mock.patch("clustermcml.program._start", no_process):
                    mine = rows(scene, **options)
                theirs = rows(scene, output_dir=os.path.join(self.folder, str(k)), **options)
                xr.testing.assert_identical(mine.assign_attrs(theirs.attrs), theirs)
                self.assertEqual(bits(mine), bits(theirs))
                self.assertEqual({name for name in {**mine.attrs, **theirs.attrs} if mine.attrs.get(name) != theirs.attrs.get(name)} - MEASURED, set())
                self.assertGreater(len(mine.data_vars), 40)

    @unittest.mock.patch("clustermcml.program._start", no_process)
    @unittest.mock.patch("tempfile.TemporaryDirectory", no_folder)
    def test_two_sweeps_at_once(self):
        """Sweeps and fits in two threads give the bits of one after the other, and a scene without files needs no folder."""
        bounds, seen = {"layer1.mua": (0.1, 2), "layer1.mus": (50, 200)}, {"Rd": (0.3, 0.003), "Tt": (0.36, 0.003)}
        works = {"plain": lambda: bits(rows(mc.Scene([SLAB]))), "shared": lambda: bits(rows(mc.Scene([SLAB]), reweight=True)),
                 "spectrum": lambda: bits(mc.spectrum(mc.Scene([SLAB], photons=500), {"layer1.mua": [1, 2, 3]}, [500, 600, 700])),
                 "fit": lambda: mc.fit(mc.Scene([SLAB], photons=500), bounds, seen).values}
        expected, found = {name: work() for name, work in works.items()}, {}

        def fly(name):
            found[name] = works[name]()
        threads = [threading.Thread(target=fly, args=(name,)) for name in works]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(found, expected)

    @unittest.mock.patch("clustermcml.program._start", no_process)
    def test_check_and_exact(self):
        """mc.check and mc.exact are the lines that the program prints, with its notes as warnings and its refusals, and need no process."""
        def plain(told):
            """Returns an answer without memory and time, which differ between processes."""
            return [{**run, "memory_bytes": 0, "boundaries": [{**one, "build_s": 0} for one in run["boundaries"]]} if "boundaries" in run else run for run in told]
        cases = [("check", name, (), {}) for name in ("skinmap", "vein", "fibres", "ridges", "pattern", "fig5")] + [("exact", name, (), {}) for name in ("skin7", "ridges")]
        cases += [("check", "thick", ("--threads", "3", "--set", "layer1.mua=0.2", "--ignore-absorption"), {"threads": 3, "set": {"layer1.mua": 0.2}, "ignore_absorption": True}),
                  ("exact", "thick", ("--set", "layer1.mua=0.2"), {"set": {"layer1.mua": 0.2}}), ("check", self.two_runs(), (), {}), ("exact", self.two_runs(), (), {})]
        for command, name, words, options in cases:
            path = name if os.sep in name else sample(name)
            with self.subTest(command=command, name=name), warnings.catch_warnings(record=True) as noted:
                warnings.simplefilter("always")
                mine = getattr(mc, command)(path, **options)
                said = subprocess.run([find_program(), command, path, "--json", *words], capture_output=True, text=True, check=True)
                self.assertEqual(repr(plain(mine)), repr(plain(map(json.loads, said.stdout.splitlines()))))
                planes = ["clustermcml: note: exact: a plane stands for boundary 0"] * (mine[0].get("planes") == [0])  # said by the answer of the program
                self.assertEqual([f"clustermcml: note: {one.message}" for one in noted], said.stderr.splitlines() + planes)
                self.assertEqual({one.filename for one in noted} - {__file__}, set())
        sealed = mc.Scene([SLAB], top=[mc.Face(0.5)])
        for call, text in ((lambda: mc.check(mc.Scene([SLAB], beam=mc.Beam(z=0.1))), "^Scene: beam: "), (lambda: mc.check(sample("fig5"), set={"layer1.mua": -1}), r"--set: layer1.mua = -1 \(expected"),
                           (lambda: mc.exact(mc.Scene([SLAB]), set={"layer2.mua": 1}), "a name that the Scene knows"), (lambda: mc.check(os.devnull), "/dev/null"),
                           (lambda: mc.check(sealed), "^Scene: beam = nothing of it passes boundary 0")):
            with self.assertRaisesRegex(mc.InputError, text):
                call()

    def test_an_older_library(self):
        """A library that lacks a function counts as none."""
        with unittest.mock.patch("ctypes.CDLL", return_value=types.SimpleNamespace(clm_api=lambda: library.API)):
            self.assertIsNone(library._load.__wrapped__(find_program()))

    def test_without_the_library(self):
        """A program that no library stands beside flies sweeps and fits by itself, with the same bits."""
        def fly():
            fitted = mc.fit(mc.Scene([SLAB], photons=500), {"layer1.mua": (0.1, 2), "layer1.mus": (50, 200)}, {"Rd_a": (np.full(30, 0.1), 0.01), "Tt": (0.36, 0.003)}, flights=3)
            return bits(mc.run(mc.Scene([SLAB], photons=500))), bits(rows(mc.Scene([SLAB]), reweight=True)), fitted.values, fitted.errors
        mine, alone = fly(), shutil.copy(find_program(), self.folder)
        with unittest.mock.patch.dict(os.environ, CLUSTERMCML=alone):
            with unittest.mock.patch("clustermcml.program._start", no_process), self.assertRaisesRegex(AssertionError, "a process"):
                rows(mc.Scene([SLAB]))
            self.assertEqual(fly(), mine)

    def test_a_forked_process(self):
        """A process that was forked after a flight, and during one, flies on."""
        expected = fly_ridges(1)
        other = threading.Thread(target=mc.run, args=(sample("thick"),), kwargs={"photons": 1e5})
        other.start()
        with multiprocessing.get_context("fork").Pool(2) as pool:
            self.assertEqual(pool.map_async(fly_ridges, [1, 1]).get(timeout=120), [expected] * 2)
        other.join()

    @unittest.mock.patch("clustermcml.program._start", no_process)
    def test_interrupt(self):
        """Ctrl-C ends a run, a sweep or a fit that would take days, and the next flight is as ever."""
        main = threading.get_ident()

        def interrupt():
            time.sleep(0.7)
            signal.pthread_kill(main, signal.SIGINT)
        self.addCleanup(signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, signal.default_int_handler))  # a test that was started with & ignores it
        endless = {"photons": 1e13, "threads": 1}
        for name, work in (("run", lambda: mc.run(sample("thick"), **endless)), ("sweep", lambda: mc.sweep(sample("thick"), {"layer1.mua": [1, 2]}, **endless)),
                           ("sweep of one flight", lambda: mc.sweep(sample("thick"), {"layer1.mua": [1, 2]}, reweight=True, **endless)),
                           ("fit", lambda: mc.fit(sample("thick"), {"layer1.mua": (1, 2)}, {"Rd": (0.3, 0.01)}, **endless))):
            threading.Thread(target=interrupt).start()
            begin = time.monotonic()
            with self.subTest(name), self.assertRaises(KeyboardInterrupt):
                work()
            print(f"an interrupt ended the {name} after {time.monotonic() - begin - 0.7:.2f} s", file=sys.stderr)
        self.same(mc.run(sample("fig5"), photons=1000), self.of_program(sample("fig5"), "--photons", "1000"))

    def test_a_second_interrupt(self):
        """Two interrupts in a row end a flight, and Python goes on: nothing is freed that the flight still uses."""
        script = f"""if True:
            import os, signal, sys, threading, time
            sys.path[:0] = {sys.path!r}
            import clustermcml as mc
            signal.signal(signal.SIGINT, signal.default_int_handler)
            def interrupt():
                for pause in (0.7, 0.02):
                    time.sleep(pause)
                    os.kill(os.getpid(), signal.SIGINT)
            threading.Thread(target=interrupt).start()
            for work in (lambda: mc.run({sample("vein")!r}, photons=1e12), lambda: time.sleep(2)):
                try:
                    work()
                except KeyboardInterrupt:
                    pass
            print(float(mc.run({sample("fig5")!r}, photons=1000).Rd))
        """
        child = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
        self.assertEqual((child.returncode, child.stdout), (0, f"{float(mc.run(sample('fig5'), photons=1000).Rd)}\n"), child.stderr)

    def test_a_function_stops_a_flight(self):
        """progress=function stops a run or sweep in any thread, by library and by program, and passes on what it raises; runs beside it go on."""
        stop, results = threading.Event(), []
        beside = threading.Thread(target=lambda: results.append(bits(mc.run(sample("fig5"), photons=2e5, threads=1))))

        def fly_on():
            with self.assertRaises(mc.ClustermcmlError) as stopped:
                mc.run(sample("thick"), photons=1e13, threads=1, progress=lambda *_: stop.is_set())
            results.append(stopped.exception.exit_code)
        endless = threading.Thread(target=fly_on)
        beside.start()
        endless.start()
        beside.join()
        self.assertEqual(results, [bits(mc.run(sample("fig5"), photons=2e5))])
        stop.set()
        endless.join()
        self.assertEqual(results[1:], [75])
        with tempfile.TemporaryDirectory() as folder:
            for place in ({}, {"output_dir": folder}):
                for work in (mc.run, lambda scene, **more: mc.sweep(scene, {"layer1.mua": [1, 2]}, **more)):
                    with self.subTest(place=place, work=work), self.assertRaisesRegex(OSError, "full"):
                        work(sample("thick"), threads=1, photons=1e13 if work is mc.run or not place else 1e4, progress=self.fails, **place)

    @staticmethod
    def fails(percent, text):
        raise OSError(f"full at {percent} %, {text}")

    def test_memory(self):
        """Flights leave nothing behind."""
        loaded = library.find(find_program(), [])
        count, held = 10000 if WHOLE else 900, []
        with library.Runs(loaded, sample("fig5"), ["--photons", "100", "--threads", "1"]) as scene:
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
        shown.clear()
        with unittest.mock.patch.object(Progress, "show", lambda self, percent, text: shown.append((self.part, percent, text))):
            mc.sweep(sample("thick"), {"seed": [1, 2]}, photons=3e5, threads=1)
            mc.fit(mc.Scene([SLAB], photons=100), {"layer1.mua": (0.1, 2)}, {"Rd": (0.3, 0.003)})
        self.assertEqual(shown, sorted(shown))
        self.assertTrue({("", 50, "1 of 2 rows"), ("", 100, "2 of 2 rows"), ("flight 1, ", 100, "25 of 25 rows")} <= set(shown), shown)
        self.assertTrue([percent for _, percent, text in shown if text == "0 of 2 rows" and 0 < percent < 50], shown)

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

    @unittest.skipUnless(shutil.which("mpiexec"), "mpiexec is missing")
    def test_ranks(self):
        """Under a launcher one process of Python flies as ever. Several refuse to fly, and do all else; with mpi4py each flies its own runs."""
        alone = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1"}
        self.of_program(sample("fig5"), "--photons", "1000")
        script = os.path.join(self.folder, "ranks.py")
        with open(script, "w", encoding="utf-8") as file:
            file.write(RANKS)
        for count, module, words in ((1, "other", ["mpiexec", "-n", "1"]), (2, "other", ["mpiexec", "-n", "2"]), (2, "mpi4py.MPI", ["mpiexec", "-n", "2"]),
                                     (2, "other", ["env", "PMI_SIZE=2"]), (2, "other", ["env", "SLURM_STEP_NUM_TASKS=2"])):
            with self.subTest(words[-1] + module):
                name = words[-1] + module
                done = subprocess.run([*words, sys.executable, script, os.pathsep.join(sys.path), sample("fig5"), os.path.join(self.folder, name), str(count),
                                       module], env=alone, stdin=subprocess.DEVNULL, capture_output=True, text=True)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(len([file for file in os.listdir(self.folder) if file.startswith(name + ".") and file.endswith(".done")]),
                                 count if words[0] == "mpiexec" else 1)

    def test_files_need_the_program(self):
        """With a folder for its files, a run is the program's."""
        with unittest.mock.patch("clustermcml.program._start", no_process), self.assertRaisesRegex(AssertionError, "a process"):
            mc.run(sample("fig5"), photons=100, output_dir=self.folder)


if __name__ == "__main__":
    unittest.main()
