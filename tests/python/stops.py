"""Signals to a Python process that flies, and to the program that flies for it: each stops, a checkpoint stays, and how to go on is said."""
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
from python_package import TOP, mc, xr  # noqa: E402
from clustermcml.program import _start  # noqa: E402

BEGINNING = ("import sys, threading; sys.path.insert(0, sys.argv[1]); import clustermcml as mc\n"
             "def fly(): mc.run(sys.argv[2], photons=float(sys.argv[4]), threads=1, checkpoint=0.1, output_dir=sys.argv[3])\n")
FLIGHT, IN_A_THREAD = BEGINNING + "fly()", BEGINNING + "thread = threading.Thread(target=fly); thread.start(); thread.join()"

ENDLESS = "1e9"  # photons of runs that are not resumed: however late the signal comes, they still fly


def ended(child):
    """Whether a process is gone, or a zombie for which nobody waits."""
    try:
        with open(f"/proc/{child}/stat", encoding="ascii") as file:
            return file.read().rpartition(")")[2].split()[0] == "Z"
    except (FileNotFoundError, ProcessLookupError):
        return True


class Stops(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def interrupted(self, number, deaf=False, script=FLIGHT, photons=ENDLESS):
        """Exit code and words of a Python process that gets this signal behind the first checkpoint of a run that it flies. deaf: to
        SIGINT, as one that a script starts with &."""
        process = subprocess.Popen([sys.executable, "-c", script, sys.path[0], os.path.join(TOP, "samples", "thick.mci"), self.folder, photons],
                                   stderr=subprocess.PIPE, text=True, preexec_fn=lambda: deaf and signal.signal(signal.SIGINT, signal.SIG_IGN))
        checkpoint, lock = (os.path.join(self.folder, name) for name in ("thick.mco.checkpoint", "thick.lock"))
        while not os.path.exists(checkpoint) and process.poll() is None:
            time.sleep(0.02)
        process.send_signal(number)
        _, said = process.communicate()
        while os.path.exists(lock):  # the program has not ended, where Python did not wait for it
            time.sleep(0.02)
        self.assertTrue(os.path.exists(checkpoint))
        self.assertFalse(os.path.exists(os.path.join(self.folder, "thick.mco")))
        return process.returncode, said

    def test_interrupt(self):
        """Ctrl-C, or what else stops the program, while it flies: the program stops, its checkpoint stays, and resuming gives the result of one run."""
        for number, deaf in ((signal.SIGTERM, False), (signal.SIGTERM, True), *((number, False) for number in (signal.SIGHUP, signal.SIGUSR1, signal.SIGUSR2, signal.SIGXCPU))):
            self.assertEqual(self.interrupted(number, deaf), (128 + number, ""))
            os.remove(os.path.join(self.folder, "thick.mco.checkpoint"))
        self.assertIn("KeyboardInterrupt", self.interrupted(signal.SIGINT, photons="1.2e6")[1])
        with unittest.mock.patch("clustermcml.program._start", side_effect=_start) as started:
            resumed = mc.run(os.path.join(TOP, "samples", "thick.mci"), photons=1.2e6, resume=True, output_dir=self.folder)
        self.assertEqual(started.call_count, 1, started.call_args_list)  # so a large scene is loaded once
        self.assertEqual(resumed.photons, 1200000)
        xr.testing.assert_equal(resumed, mc.run(os.path.join(TOP, "samples", "thick.mci"), photons=1.2e6))

    def test_python_ends_first(self):
        """Python is killed, or flies in a thread, and tells the program nothing: the kernel does, and the program stops."""
        for number in (signal.SIGTERM, signal.SIGKILL, signal.SIGABRT):
            with self.subTest(number):
                self.assertEqual(self.interrupted(number, script=IN_A_THREAD)[0], -number)
                os.remove(os.path.join(self.folder, "thick.mco.checkpoint"))

    def test_commands_end_with_python(self):
        """Those that fly without a checkpoint."""
        script = "import sys; sys.path.insert(0, sys.argv[1]); import clustermcml as mc; mc.crosscheck(sys.argv[2], photons=1e9)"
        process = subprocess.Popen([sys.executable, "-c", script, sys.path[0], os.path.join(TOP, "samples", "thick.mci")])
        child = ""
        while not child and process.poll() is None:
            with open(f"/proc/{process.pid}/task/{process.pid}/children", encoding="ascii") as file:
                child = file.read().strip()
            time.sleep(0.2)  # and some more once it is there: until Python knows of it
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(), 143)
        while not ended(child):  # which takes a moment where Python did not know of it yet
            time.sleep(0.02)

    def test_a_finished_run_is_not_flown_again(self):
        """As the shell finds it, by its result; one that is gone is."""
        mapped = mc.Scene([mc.Layer(n=1.4, mua=1, mus=50, g=0.8, d=0.1)], photons=2000, map=mc.Map(4, 4, 0.1, 0.1))
        for scene, name in ((os.path.join(TOP, "samples", "thick.mci"), "thick.mco"), (mapped, "scene.h5")):
            path = os.path.join(self.folder, name)
            mc.run(scene, photons=2000, output_dir=self.folder)
            written = os.stat(path)
            again = mc.run(scene, photons=2000, output_dir=self.folder, resume=True)
            self.assertEqual((os.stat(path).st_mtime_ns, os.stat(path).st_ino), (written.st_mtime_ns, written.st_ino), name)
            xr.testing.assert_equal(again, mc.read(path))
            self.assertNotIn("seconds", again.attrs)
            os.remove(path)
            with warnings.catch_warnings(record=True) as said:
                warnings.simplefilter("always")
                flown = mc.run(scene, photons=2000, output_dir=self.folder, resume=True)
            self.assertEqual(len({str(note.message) for note in said}), len(said), said)
            self.assertIn("seconds", flown.attrs)
            xr.testing.assert_equal(flown, again)
            kept = os.stat(path).st_mtime_ns  # and now by its checkpoint
            self.assertEqual(mc.run(scene, photons=2000, output_dir=self.folder, resume=True).attrs["seconds"], flown.attrs["seconds"])
            self.assertEqual(os.stat(path).st_mtime_ns, kept)

    def test_a_program_that_is_stopped(self):
        """SIGTERM to the program, not to Python: it says so, and how to go on."""
        def starts_and_is_stopped(words, *rest):
            process = _start(words, *rest)
            sign = os.path.join(words[words.index("-o") + 1], "thick.lock" if "off" in words else "thick.mco.checkpoint")

            def stop():
                while not os.path.exists(sign) and process.poll() is None:
                    time.sleep(0.02)
                process.terminate()
            threading.Thread(target=stop).start()
            return process

        scene = os.path.join(TOP, "samples", "thick.mci")
        for options, text in (({"checkpoint": 0.1, "output_dir": self.folder}, f"resume=True continues from {self.folder}/thick.mco.checkpoint$"),
                              ({"checkpoint": 0.1}, "run and sweep keep a checkpoint in output_dir, from which resume=True continues$"),
                              ({"checkpoint": "off"}, "^clustermcml was ended by SIGTERM$")):
            with unittest.mock.patch("clustermcml.program._start", starts_and_is_stopped), self.assertRaisesRegex(mc.ClustermcmlError, text):
                mc.run(scene, photons=1e8, threads=1, **options)


if __name__ == "__main__":
    unittest.main()
