"""Tests that runs stay within the memory that is printed before them, and refuse scenes that need more than the machine has.

Scenes of many bodies, layers, triangles, cells of phase functions and pixels must come close to the printed figure. For maps, a wide beam on a slab
touches pixels everywhere. The peak of resident memory, which the system counts for one process, is compared with the printed line of `run` and of
`check`."""
import math
import os
import random
import re
import struct
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
from fields import h5py  # noqa: E402


# The system adds to a process's peak the memory of the process that started it. This starter holds little.
STARTER = """import os, sys
_, status, usage = os.wait4(os.spawnv(os.P_NOWAIT, sys.argv[2], sys.argv[2:]), 0)
open(sys.argv[1], "w").write(str(usage.ru_maxrss))
sys.exit(os.waitstatus_to_exitcode(status))"""


OCTAHEDRON = ("v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n"
              "f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n")


def scene(line, nz=1):
    return cml.mci(["1 1 9 0 0.4"], photons=100000, bins=f"{nz} 1 1", grid=f"{0.4 / nz} 1", extra=["beam disk 2", line])


def run(text, keep, command="run", more=()):
    """Runs a command on a scene. Returns the finished process, and its peak of memory in MiB."""
    path = os.path.join(keep, "scene.mci")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    where = [*more, "--threads", "2", *(["-o", keep] if command == "run" else [])]
    peak = os.path.join(keep, "peak")
    done = subprocess.run([sys.executable, "-c", STARTER, peak, cml.PROGRAM, command, path, *where], capture_output=True, text=True,
                          check=False)
    with open(peak, encoding="utf-8") as file:
        mib = int(file.read()) / 1024
    os.remove(peak)
    return done, mib


def printed(verdict, name, done):
    found = re.search(r"memory: at most (\d+) MiB", done.stdout)
    verdict.check(name, done.returncode == 0 and found, done.stderr)
    return int(found[1])


def check(verdict, name, line, nz, least, dataset, shape):
    with tempfile.TemporaryDirectory() as keep:
        done, peak = run(scene(line, nz), keep)
        most = printed(verdict, name, done)
        print(f"{name}: printed {most} MiB, peak {peak:.0f} MiB")
        verdict.check(name, least < peak <= most, f"peak {peak:.0f} MiB, printed {most} MiB")
        with h5py.File(os.path.join(keep, "out.h5")) as file:
            verdict.check(name, file[dataset].shape == shape)


def spheres(edge, shells):
    """Returns lines of spheres on a cubic grid below the surface, each with `shells` concentric spheres."""
    step = 0.9 / edge
    return [f"i sphere {(x + 0.5) * step - 0.45:.9g} {(y + 0.5) * step - 0.45:.9g} {(z + 0.5) * step + 0.05:.9g} "
            f"{0.45 * step * (s + 1) / shells:.9g} 1.3 1 10 0.8"
            for x in range(edge) for y in range(edge) for z in range(edge) for s in range(shells)]


def with_bodies(bodies):
    lines = cml.mci(["1.4 1 10 0.8 1"], photons=100).splitlines()
    return "\n".join(lines[:-1] + bodies + lines[-1:]) + "\n"


def write_waves(path, cells):
    """Writes a wavy sheet of 2 x 2 cm whose border lies at height 0."""
    with open(path, "w", encoding="utf-8") as file:
        for j in range(cells + 1):
            for i in range(cells + 1):
                inside = 0 < i < cells and 0 < j < cells
                file.write(f"v {2 * i / cells - 1} {2 * j / cells - 1} {0.01 * math.sin(0.3 * i) if inside else 0}\n")
        for j in range(cells):
            for i in range(cells):
                a = j * (cells + 1) + i + 1
                file.write(f"f {a} {a + 1} {a + cells + 2} {a + cells + 1}\n")


def write_phases(folder, count):
    """Writes tables of phase functions in which no two rows are alike, so that all cells have parts. The mean cosine is nearly 0."""
    dice, cosines = random.Random(5), [math.cos(math.radians(180 * k / 5000)) for k in range(5001)]
    for k in range(count):
        p = [dice.random() ** 8 for _ in cosines]
        pairs = list(zip(zip(cosines, p), zip(cosines[1:], p[1:])))
        mean = sum((a - b) * (p0 * (2 * a + b) + p1 * (a + 2 * b)) for (a, p0), (b, p1) in pairs) / 3
        mean /= sum((a - b) * (p0 + p1) for (a, p0), (b, p1) in pairs)
        with open(os.path.join(folder, f"{k}.txt"), "w", encoding="utf-8") as file:
            file.write("".join(f"{180 * i / 5000} {value}\n" for i, value in enumerate(p)))
        yield f'i sphere {0.1 * k} 0 0.5 0.04 1.3 1 10 {mean:.6f}\nphase table "{k}.txt"'


def write_image(path, edge):
    header = f"Gwyddion Simple Field 1.0\nXRes = {edge}\nYRes = {edge}\nXReal = 1\nYReal = 1\nXYUnits = cm\n".encode()
    with open(path, "wb") as file:
        file.write(header + b"\0" * (4 - len(header) % 4) + struct.pack("<f", 1) * edge**2)


def check_scenes(verdict):
    """Checks that the peak is at most the printed memory, and at least 0.7 of it. The limit is half where 100 packets meet few of many media, and
    leave pages of sums untouched."""
    scenes = {
        "spheres side by side": with_bodies(spheres(40, 1)),
        "spheres in each other": with_bodies(spheres(5, 500)),
        "layers": cml.mci(["1.4 1 10 0.8 1e-5"] * 50000, photons=100),
        "bodies of meshes": with_bodies([f'i "ball.obj" 1.3 1 10 0.8 scale=1e-3 shift={0.01 * (k % 50)},{0.01 * (k // 50)},-0.5'
                                         for k in range(1000)]),
        "mesh": cml.mci(["1.4 1 10 0.8 1"], photons=100, surfaces={0: 'm "waves.obj"'}),
        "phase functions": None,
        "fluence": cml.mci(["1.4 1 10 0.8 1"], photons=20000, bins="100 600 1", grid="0.01 0.01", extra=["beam disk 6", "fluence"]),
        "image": cml.mci(["1.4 1 10 0.8 1"], photons=100, extra=['beam image "pattern.gsf"']),
    }
    for name, text in scenes.items():
        with tempfile.TemporaryDirectory() as keep:
            if name == "phase functions":
                text = with_bodies(list(write_phases(keep, 2)))
            if "pattern.gsf" in text:
                write_image(os.path.join(keep, "pattern.gsf"), 1500)
            if "waves.obj" in text:
                write_waves(os.path.join(keep, "waves.obj"), 300)
            with open(os.path.join(keep, "ball.obj"), "w", encoding="utf-8") as file:
                file.write(OCTAHEDRON)
            before = printed(verdict, name, run(text, keep, "check")[0])
            done, peak = run(text, keep)
            most = printed(verdict, name, done)
            print(f"{name}: check printed {before} MiB, run {most} MiB, peak {peak:.0f} MiB")
            for said in (before, most):
                verdict.check(name, (0.5 if "spheres" in name or name == "layers" else 0.7) * said < peak <= said, f"peak {peak:.0f} MiB, printed {said} MiB")


def check_rows(verdict):
    """Checks rows that share one flight, with time gates of their own in every batch."""
    text = cml.mci(["1.4 1 10 0.8 1"], photons=20000, extra=["time 100 1000"])
    with tempfile.TemporaryDirectory() as keep:
        more = ["--sweep", os.path.join(keep, "rows.csv"), "--reweight", "--checkpoint", "off"]
        with open(more[1], "w", encoding="utf-8") as file:
            file.write("layer1.mua\n" + "".join(f"{1 + i}\n" for i in range(8)))
        most = printed(verdict, "rows", run(text, keep, "check", more[:3])[0])
        done, peak = run(text, keep, more=more)
        print(f"rows: check printed {most} MiB, peak {peak:.0f} MiB")
        verdict.check("rows", done.returncode == 0 and 0.5 * most < peak <= most, done.stderr)


def check_refusal(verdict):
    """Checks the refusal of a map just under 2^31 cells: 48 GiB, and the .h5 file of four single-precision arrays, which is made in memory."""
    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2**30
    with tempfile.TemporaryDirectory() as keep:
        if memory < 52:
            done, _ = run(scene("map 23000 23000 1e-4 1e-4"), keep)
            verdict.check("refusal", done.returncode == 2 and re.search(r"takes 55\.\d GiB", done.stderr), done.stderr)
            verdict.check("refusal", os.listdir(keep) == ["scene.mci"], "and nothing written")
        done, _ = run(scene("map 24000 24000 1e-4 1e-4"), keep)
        verdict.check("refusal", done.returncode == 2 and "2.3e+09 (51.5 GiB)" in done.stderr, done.stderr)


def check_saved(verdict):
    """Checks that few photons need little memory, however large limit= is. --more also counts photons of earlier runs."""
    text = cml.mci(["1.4 1 10 0.8 1"], photons=100, extra=['photons "out" limit=1000000000'])
    with tempfile.TemporaryDirectory() as keep:
        done, _ = run(text, keep, "check")
        most = printed(verdict, "saved", done)
        verdict.check("saved", most < 100 and "at most 100 rows" in done.stdout, done.stdout)
        done, peak = run(text, keep, more=["--keep"])
        verdict.check("saved", done.returncode == 0 and peak <= printed(verdict, "saved", done) < 100, done.stderr)
        for photons in (200, 300):
            done, peak = run(text, keep, more=["--more", "100"])
            verdict.check("saved, more", done.returncode == 0 and peak <= printed(verdict, "saved, more", done) < 100, done.stderr)
            with h5py.File(os.path.join(keep, "out.photons.h5")) as file:
                rows, covers = len(file["index"]), file.attrs["covers"]
            verdict.check("saved, more", covers == photons and 0.2 * photons < rows <= photons, f"{rows} rows, {covers} covered")


def main():
    verdict = cml.Verdict("memory")
    check(verdict, "volume", "map 200 200 0.02 0.02 volume", 200, 150, "A_xyz", (200, 200, 200))
    check(verdict, "map", "map 2000 2000 0.002 0.002", 1, 300, "Rd_xy", (2000, 2000))
    check_scenes(verdict)
    check_rows(verdict)
    check_refusal(verdict)
    check_saved(verdict)
    verdict.finish()


main()
