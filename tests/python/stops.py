"""Tests of signals to a Python process that runs the program, and to the program itself. Each stops the run, leaves a checkpoint, and the message
says how to continue."""
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

ENDLESS = "1e9"  # photons of runs that are not resumed, so many that a late signal still finds them running


def ended(child):
    """True if a process is gone, or is a zombie for which nobody waits."""
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
        """Runs Python, sends it a signal after the first checkpoint, and returns its exit code and text. deaf: Python ignores SIGINT, as if a
        script had started it with &."""
        process = subprocess.Popen([sys.executable, "-c", script, sys.path[0], os.path.join(TOP, "samples", "thick.mci"), self.folder, photons],
                                   stderr=subprocess.PIPE, text=True, preexec_fn=lambda: deaf and signal.signal(signal.SIGINT, signal.SIG_IGN))
        checkpoint, lock = (os.path.join(self.folder, name) for name in ("thick.mco.checkpoint", "thick.lock"))
        while not os.path.exists(checkpoint) and process.poll() is None:
            time.sleep(0.02)
        process.send_signal(number)
        _, said = process.communicate()
        while os.path.exists(lock):  # without Python's wait, the program may still run
            time.sleep(0.02)
        self.assertTrue(os.path.exists(checkpoint))
        self.assertFalse(os.path.exists(os.path.join(self.folder, "thick.mco")))
        return process.returncode, said

    def test_interrupt(self):
        """Ctrl-C or another signal stops the program and leaves its checkpoint. Resuming gives the result of one run."""
        for number, deaf in ((signal.SIGTERM, False), (signal.SIGTERM, True), *((number, False) for number in (signal.SIGHUP, signal.SIGUSR1, signal.SIGUSR2, signal.SIGXCPU))):
            self.assertEqual(self.interrupted(number, deaf), (128 + number, ""))
            os.remove(os.path.join(self.folder, "thick.mco.checkpoint"))
        self.assertIn("KeyboardInterrupt", self.interrupted(signal.SIGINT, photons="1.2e6")[1])
        with unittest.mock.patch("clustermcml.program._start", side_effect=_start) as started:
            resumed = mc.run(os.path.join(TOP, "samples", "thick.mci"), photons=1.2e6, resume=True, output_dir=self.folder)
        self.assertEqual(started.call_count, 1, started.call_args_list)  # a large scene is loaded only once
        self.assertEqual(resumed.photons, 1200000)
        xr.testing.assert_equal(resumed, mc.run(os.path.join(TOP, "samples", "thick.mci"), photons=1.2e6, output_dir=os.path.join(self.folder, "whole")))

    def test_python_ends_first(self):
        """If Python is killed or runs in a thread, it cannot stop the program. The kernel then stops the program."""
        for number in (signal.SIGTERM, signal.SIGKILL, signal.SIGABRT):
            with self.subTest(number):
                self.assertEqual(self.interrupted(number, script=IN_A_THREAD)[0], -number)
                os.remove(os.path.join(self.folder, "thick.mco.checkpoint"))

    def test_commands_end_with_python(self):
        """Commands without a checkpoint end together with Python."""
        script = "import sys; sys.path.insert(0, sys.argv[1]); import clustermcml as mc; mc.crosscheck(sys.argv[2], photons=1e9)"
        process = subprocess.Popen([sys.executable, "-c", script, sys.path[0], os.path.join(TOP, "samples", "thick.mci")])
        child = ""
        while not child and process.poll() is None:
            with open(f"/proc/{process.pid}/task/{process.pid}/children", encoding="ascii") as file:
                child = file.read().strip()
            time.sleep(0.2)  # a little longer, until Python knows of its child
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(), 143)
        while not ended(child):  # may take a moment if Python did not know of its child yet
            time.sleep(0.02)

    def test_a_finished_run_is_not_flown_again(self):
        """Python finds a finished run by its result, like the shell, and runs it again only if the result is gone."""
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
            kept = os.stat(path).st_mtime_ns  # the checkpoint now tells that the run is finished
            self.assertEqual(mc.run(scene, photons=2000, output_dir=self.folder, resume=True).attrs["seconds"], flown.attrs["seconds"])
            self.assertEqual(os.stat(path).st_mtime_ns, kept)

    def test_a_program_that_is_stopped(self):
        """SIGTERM to the program, not to Python: the message says so, and how to continue."""
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
