"""Tests of strange folders and file systems, in which a run must fly and its result be read. lib/system_fault.c makes the faults."""
import os
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import mc, xr  # noqa: E402


class Folders(unittest.TestCase):
    def test_a_file_system_without_locks(self):
        """A run's .h5 file is read on a file system without locks, such as NFS."""
        script = ("import sys; sys.path.insert(0, sys.argv[1]); import clustermcml as mc\n"
                  "assert mc.run(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1)], photons=1000)).photons == 1000")
        subprocess.run([sys.executable, "-c", script, sys.path[0]], check=True,
                       env={**os.environ, "LD_PRELOAD": os.environ["SYSTEM_FAULT"], "CML_LOCKS": "95"})

    def test_names_that_are_no_utf8(self):
        """--json and the summary show bytes of names that are not UTF-8 as \\xNN."""
        scene = mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1)], photons=100)
        with tempfile.TemporaryDirectory() as folder:
            strange = os.path.join(folder, os.fsdecode(b"caf\xe9 \xc3\xa9\x1b"))
            os.mkdir(strange)
            flown = mc.run(scene, output_dir=strange)
            os.remove(os.path.join(strange, "scene.mci"))
            xr.testing.assert_equal(mc.run(scene, output_dir=strange, resume=True), flown)
            self.assertEqual(mc.sweep(scene, {"seed": [1, 2]}, output_dir=strange).sizes["seed"], 2)


if __name__ == "__main__":
    unittest.main()
