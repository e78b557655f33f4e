"""Folders and file systems that are strange: a run flies and its result is read all the same. The faults are those of lib/system_fault.c."""
import os
import subprocess
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import mc  # noqa: E402


class Folders(unittest.TestCase):
    def test_a_file_system_without_locks(self):
        """NFS: a run's .h5 file is read all the same."""
        script = ("import sys; sys.path.insert(0, sys.argv[1]); import clustermcml as mc\n"
                  "assert mc.run(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1)], photons=1000)).photons == 1000")
        subprocess.run([sys.executable, "-c", script, sys.path[0]], check=True,
                       env={**os.environ, "LD_PRELOAD": os.environ["SYSTEM_FAULT"], "CML_LOCKS": "95"})


if __name__ == "__main__":
    unittest.main()
