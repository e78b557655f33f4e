"""Tests that every output file survives kill -9: at any moment it is the complete old file or the complete new file.

A run over the results of another seed is killed when one chosen file is being written (its .tmp exists), or some milliseconds later, for every file
in turn. A .tmp that is left shows that the kill came in the middle of a file. At least three of the five files must be hit so. A write that fails
(a limit on the size of files) must leave the old files and report the error."""
import glob
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
from fields import h5py, read_vtk  # noqa: E402

SUFFIXES = [".mco", ".h5", ".map.vti", ".volume.vti", ".boundary0.vtp"]
SCENE = cml.mci(["1.4 1 10 0.5 0.2"], name="run.mco", photons=10000, bins="10 300 40", surfaces={0: "b 3 0.1 0.5 -0.1 0.5 0 0"},
                extra=["beam disk 1", "map 200 150 0.01 0.01 volume", "facets"])


def contents(keep):
    """Returns {suffix: bytes} of all outputs. The line with the time is cut out of the .mco, because it differs between runs."""
    found = {}
    for suffix in SUFFIXES:
        with open(os.path.join(keep, "run" + suffix), "rb") as file:
            found[suffix] = b"\n".join(line for line in file.read().split(b"\n") if not line.startswith(b"# User time"))
    return found


def command(keep, seed):
    return [cml.PROGRAM, "run", os.path.join(keep, "scene.mci"), "--quiet", "--threads", "1", "--seed", str(seed), "-o", keep]


def make(keep, seed):
    subprocess.run(command(keep, seed), check=True)
    return contents(keep)


def kill_at(keep, suffix, delay):
    """Runs seed 2 and kills it `delay` seconds after the file was begun. True if this left the file unfinished."""
    temporary = os.path.join(keep, "run" + suffix + ".*-*.tmp")
    process = subprocess.Popen(command(keep, 2))
    while process.poll() is None and not glob.glob(temporary):
        pass
    time.sleep(delay)
    process.kill()
    process.wait()
    return bool(glob.glob(temporary))


def restore(keep, old):
    for name in os.listdir(keep):
        if name.startswith("run"):
            os.remove(os.path.join(keep, name))
    for name in os.listdir(old):
        shutil.copy(os.path.join(old, name), keep)


def check_complete(verdict, keep, what, before, after):
    now = contents(keep)
    for suffix in SUFFIXES:
        verdict.check(f"{what}: {suffix}", now[suffix] in (before[suffix], after[suffix]), "is neither old nor new")
    h5py.File(os.path.join(keep, "run.h5")).close()
    for suffix in SUFFIXES[2:]:
        read_vtk(os.path.join(keep, "run" + suffix))


def check_kills(verdict, keep, old, before, after):
    struck = dict.fromkeys(SUFFIXES, 0)
    for suffix in SUFFIXES:
        for attempt in range(8):
            restore(keep, old)
            struck[suffix] += kill_at(keep, suffix, 0.002 * (attempt % 3))
            check_complete(verdict, keep, f"killed at {suffix}, attempt {attempt}", before, after)
            if attempt > 2 and struck[suffix]:
                break
    print("kills that left a file unfinished:", ", ".join(f"{n} {suffix}" for suffix, n in struck.items()))
    verdict.check("kills", sum(n > 0 for n in struck.values()) >= 3, f"{struck}")


def check_full_disk(verdict, keep, old, before, after):
    restore(keep, old)

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))

    done = subprocess.run(["sh", "-c", "trap '' XFSZ; exec \"$@\"", "sh", *command(keep, 2)], preexec_fn=limit,
                          capture_output=True, text=True, check=False)
    verdict.check("no space", done.returncode == 5 and "cannot be written" in done.stderr, done.stderr)
    check_complete(verdict, keep, "no space", before, after)
    verdict.check("no space", not any(name.endswith(".tmp") for name in os.listdir(keep)), "leaves no .tmp")


def main():
    verdict = cml.Verdict("survive")
    with tempfile.TemporaryDirectory() as keep, tempfile.TemporaryDirectory() as old:
        with open(os.path.join(keep, "scene.mci"), "w", encoding="utf-8") as file:
            file.write(SCENE)
        after = make(keep, 2)
        before = make(keep, 1)
        verdict.check("seeds", all(before[suffix] != after[suffix] for suffix in SUFFIXES), "differ")
        for suffix in SUFFIXES:
            shutil.copy(os.path.join(keep, "run" + suffix), old)
        check_kills(verdict, keep, old, before, after)
        check_full_disk(verdict, keep, old, before, after)
    verdict.finish()


main()
