"""Large maps and volumes stay within the memory that is printed before the run; larger ones are refused with the figure.

A wide beam on a slab, so that pixels all over the map are touched. Peak resident memory against the printed line."""
import os
import re
import resource
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
from fields import h5py  # noqa: E402


def scene(line, nz=1):
    return cml.mci(["1 1 9 0 0.4"], photons=100000, bins=f"{nz} 1 1", grid=f"{0.4 / nz} 1", extra=["beam disk 2", line])


def run(text, keep):
    path = os.path.join(keep, "scene.mci")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return subprocess.run([cml.PROGRAM, "run", path, "--threads", "2", "-o", keep], capture_output=True, text=True,
                          check=False)


def peak_mib():
    """Of all children so far: the cases below rise."""
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024


def check(verdict, name, line, nz, least, dataset, shape):
    with tempfile.TemporaryDirectory() as keep:
        done = run(scene(line, nz), keep)
        printed = re.search(r"memory: at most (\d+) MiB", done.stdout)
        verdict.check(name, done.returncode == 0 and printed, done.stderr)
        peak, most = peak_mib(), int(printed[1])
        print(f"{name}: printed {most} MiB, peak {peak:.0f} MiB")
        verdict.check(name, least < peak <= most, f"peak {peak:.0f} MiB, printed {most} MiB")
        with h5py.File(os.path.join(keep, "out.h5")) as file:
            verdict.check(name, file[dataset].shape == shape)


def check_refusal(verdict):
    """Just under 2^31 cells, 48 GiB, and the .h5 file of four arrays in single precision, which is made in memory."""
    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2**30
    with tempfile.TemporaryDirectory() as keep:
        if memory < 52:
            done = run(scene("map 23000 23000 1e-4 1e-4"), keep)
            verdict.check("refusal", done.returncode == 2 and re.search(r"takes 55\.\d GiB", done.stderr), done.stderr)
            verdict.check("refusal", os.listdir(keep) == ["scene.mci"], "and nothing written")
        done = run(scene("map 24000 24000 1e-4 1e-4"), keep)
        verdict.check("refusal", done.returncode == 2 and "2.3e+09, 51.5 GiB" in done.stderr, done.stderr)


def main():
    verdict = cml.Verdict("memory")
    check(verdict, "volume", "map 200 200 0.02 0.02 volume", 200, 150, "A_xyz", (200, 200, 200))
    check(verdict, "map", "map 2000 2000 0.002 0.002", 1, 300, "Rd_xy", (2000, 2000))
    check_refusal(verdict)
    verdict.finish()


main()
