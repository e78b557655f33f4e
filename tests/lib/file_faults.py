"""Parts that the tests of failing files share: one run that writes every kind of file, under lib/file_fault.c.

lib/system_fault.c provides a clock that ticks at every look. The run therefore writes several checkpoints on any machine, and the same ones on one
thread. --resume stands in every command line, because the .h5 holds the command line. Only the standard library is needed."""
import os
import re
import shutil
import subprocess
import sys
import tempfile

PROGRAM = os.environ.get("CLUSTERMCML", "build/clustermcml")
SCENE = os.path.join(os.path.dirname(__file__), "..", "..", "samples", "skinmap.mci")
NAMES = ["skinmap.boundary0.vtp", "skinmap.h5", "skinmap.map.vti", "skinmap.mco", "skinmap.volume.vti"]


def coarse_scene():
    """Returns the sample with pixels three times as wide: it writes every kind of file, each in several writes but not many."""
    with open(SCENE, encoding="utf-8") as file:
        text = re.sub("^map .*", "map 27 21 0.036 0.036 volume top=-0.02", file.read(), flags=re.MULTILINE)
    return text.replace("../meshes", os.path.join(os.path.dirname(os.path.abspath(SCENE)), "..", "meshes"))


class Folder:
    """An output folder. `expected` has the files that the run leaves there, and `calls` the calls that made them."""

    def __init__(self):
        self.root = os.path.realpath(tempfile.mkdtemp())
        self.path = os.path.join(self.root, "out")
        os.mkdir(self.path)
        self.scene = os.path.join(self.root, "skinmap.mci")
        with open(self.scene, "w", encoding="utf-8") as file:
            file.write(coarse_scene())
        if self.run(seed=8).returncode:
            raise RuntimeError("the run without faults fails")
        self.older = self.read()
        if "skinmap.h5" not in self.older:
            print("the program was built without HDF5")
            sys.exit(77)
        self.clear()
        log = os.path.join(self.root, "log")
        self.run({"CML_FAULT_LOG": log}).check_returncode()
        self.expected = self.read()
        with open(log, encoding="utf-8") as file:
            self.calls = [tuple(line.split()) for line in file]  # (call, file); temporary files are called NAME.tmp
        if sorted(self.expected) != NAMES or ("link", "skinmap.mco.checkpoint.old") not in self.calls:
            raise RuntimeError(f"left {sorted(self.expected)} by {self.calls}")

    def __enter__(self):
        return self

    def __exit__(self, *unused):
        shutil.rmtree(self.root)

    def clear(self, older=False):
        """Empties the folder, or leaves only an older result there."""
        for name in os.listdir(self.path):
            os.remove(os.path.join(self.path, name))
        for name, data in self.older.items() if older else []:
            with open(os.path.join(self.path, name), "wb") as file:
                file.write(data)

    def read(self):
        """Returns {name: bytes without the line of time}. The checkpoint that --resume leaves of a finished run is skipped."""
        files = {}
        for name in os.listdir(self.path):
            with open(os.path.join(self.path, name), "rb") as file:
                data = file.read()
            if name != "skinmap.mco.checkpoint" or data[40:48] != b"\1" + 7 * b"\0":
                files[name] = re.sub(rb"# User time.*\n", b"", data)
        return files

    def start(self, faults=None, threads=1, ranks=0, seed=7, photons="2000"):
        preload = os.environ["FILE_FAULT"] + ":" + os.environ["SYSTEM_FAULT"]
        preloaded = {"LD_PRELOAD": preload, "CML_FAULT_FOLDER": self.path + "/", **(faults or {})}
        words = ["env", f"OMP_NUM_THREADS={threads}"]
        if faults is not None:
            words += [f"{name}={value}" for name, value in preloaded.items()] + ["CML_CLOCK=tick"] * (ranks == 0)
        words += [PROGRAM, self.scene, "--photons", photons, "--seed", str(seed), "--chunk", "100", "--quiet",
                  "--checkpoint", "1e-9", "--resume", "-o", self.path]
        if ranks:
            words = ["mpiexec", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", *words]
        return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def run(self, faults=None, **options):
        """Runs the program and returns the finished process. With faults=None nothing is preloaded, and the clock is the machine's."""
        process = self.start(faults, **options)
        out, err = process.communicate()
        return subprocess.CompletedProcess(process.args, process.returncode, out, err)

    def occurrences(self):
        """Returns {(call, file): number of times}, in the order of first occurrence."""
        counts = {}
        for call in self.calls:
            counts[call] = counts.get(call, 0) + 1
        return counts

    def wrong_files(self, allowed):
        """Returns the names of final files whose bytes are none of the allowed ones."""
        return [name for name, data in self.read().items()
                if name in NAMES and data not in [files.get(name) for files in allowed]]


def fault(call, n, action, name):
    """Returns the environment for lib/file_fault.c."""
    return {"CML_FAULT": f"{call} {n} {action} {name}"}
