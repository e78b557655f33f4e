"""Tests scenes with parts that are far away from the rest.

Light from 1 to 1e9 cm away, alone or as a first beam that launches nothing, must leave results as with light from nearby,
within two standard errors. Compared are Rd over a mesh and over rings of each engine, also on two ranks, and the light of a
detector over a plane. Light straight from a far lamp, or from below, is compared with the same light nearby; gates with the
time of flight. A part that is too far from the rest is refused with the figure.
SPDX-License-Identifier: MIT"""
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

DISTANCES = ("1", "1e3", "1e6", "1e9")
LAYER = "1.4 0.5 20 0.8 1"
RINGS = "b 6  0.06 0.1  0 0.1  0.06 0.1  0 0.1  0.05 0.2  0 0"
SIDE = 20
HANGS = 300  # time limit (s) against packets that never end


def sheet():
    """Writes a sheet of 800 triangles over a square of 2 cm."""
    points = [(i / 10 - 1, j / 10 - 1) for j in range(SIDE + 1) for i in range(SIDE + 1)]
    rim = [max(abs(x), abs(y)) > 0.99 for x, y in points]
    text = "".join(f"v {x} {y} {0 if edge else 0.1 * math.sin(7.3 * x) * math.cos(5.1 * y):.6f}\n" for (x, y), edge in zip(points, rim))
    for j in range(SIDE):
        for i in range(SIDE):
            a = j * (SIDE + 1) + i + 1
            text += f"f {a} {a + 1} {a + SIDE + 2}\nf {a} {a + SIDE + 2} {a + SIDE + 1}\n"
    return text


def scene(photons, surface, beams, lines=()):
    return cml.mci([LAYER], name="far.mco", photons=photons, grid="0.01 0.02", bins="50 50 1", extra=(*lines, *beams.splitlines()),
                   surfaces={0: surface} if surface else None)


def fly(text, *options, ranks=1):
    """Returns exit code, record and standard error of a run."""
    with open("scene.mci", "w", encoding="utf-8") as file:
        file.write(text)
    command = [cml.PROGRAM, "run", "scene.mci", "--json", "--quiet", *options]
    if ranks > 1:
        command = ["mpiexec", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), *command]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=HANGS)
    except subprocess.TimeoutExpired:
        return -1, None, f"no end within {HANGS} s"
    return done.returncode, json.loads(done.stdout) if done.stdout.startswith("{") else None, done.stderr.strip()


def compare(verdict, name, photons, surface, beams, *options, lines=(), keys=("Rd",), ranks=1):
    """Compares the results of the first light with those of all others, with the same random numbers."""
    near = None
    for light in beams:
        code, record, said = fly(scene(photons, surface, light, lines), *options, ranks=ranks)
        verdict.check(f"{name}, {light} flies", code == 0 and record, f"exit {code}: {said}")
        near = near or record
        for key in keys if record else ():
            off, error = abs(record[key] - near[key]), near[f"{key}_se"]
            verdict.check(f"{name}, {light}: {key}", off <= 2 * error and error > 0, f"{record[key]} for {near[key]} +- {error}")


def shifted(distance, angle):
    """Returns a lamp at this distance from (0, 0, 0), along an axis of this angle, that lights a spot 0.3 cm wide."""
    t = math.radians(angle)
    return f"at={-distance * math.sin(t):.12g},0 z={-distance * math.cos(t):.12g} angle={angle} light=na:{0.3 / distance:.9g}"


def straight(distance):
    """Returns a disk of light that comes from this distance to (0, 0, 0), at 40.5 degrees."""
    t = math.radians(40.5)
    return f"beam disk 0.3 at={-distance * math.sin(t):.15g},0 z={-distance * math.cos(t):.15g} angle=40.5"


def second(distance, line="beam disk 0.3 angle=40.5"):
    """Returns a beam behind a first beam that is so far away and launches nothing."""
    return f"beam pencil at=-{distance},0 z=-{distance} angle=45 share=1e-9\n{line}"


def both(verdict, name, photons, surface, distances, *options, ranks=1):
    compare(verdict, f"{name}, one", photons, surface, [straight(float(d)) for d in distances], *options, ranks=ranks)
    compare(verdict, f"{name}, two", photons, surface, [second(d) for d in distances], *options, ranks=ranks)


def shapes(verdict):
    mesh = 'm "sheet.obj"'
    both(verdict, "mesh", 10000, mesh, DISTANCES)
    both(verdict, "mesh, reference", 2000, mesh, ("1", "1e6"), "--engine", "reference")
    both(verdict, "rings", 10000, RINGS, DISTANCES)
    both(verdict, "rings, reference", 2000, RINGS, ("1", "1e6"), "--engine", "reference")
    if shutil.which("mpiexec"):
        both(verdict, "mesh, two ranks", 4000, mesh, ("1", "1e6"), ranks=2)
    if subprocess.run([cml.PROGRAM, "devices"], capture_output=True, check=False).returncode == 0:
        both(verdict, "rings, opencl", 2000, RINGS, ("1", "1e6"), "--engine", "opencl")


def planes(verdict):
    fibre, seen = ("detector disk 0.02 at=0.1,0",), ("Rd", "detector_1")
    beside = [f"beam pencil at={d},0 share=1e-9\nbeam pencil" for d in ("1e6", "1e9")]
    compare(verdict, "fibre", 40000, None, [second("1", "beam pencil"), second("1e6", "beam pencil"), *beside], lines=fibre, keys=seen)
    for angle in (0, 40):
        lamps = [f"beam disk 0.1 {shifted(d, angle)}" for d in (1e3, 1e6, 1e9)]
        compare(verdict, f"lamp at {angle} degrees", 10000, 'm "sheet.obj"', lamps, lines=("detector disk 0.1 at=0.2,0",), keys=seen)
    compare(verdict, "from below", 10000, 'm "sheet.obj"', [f"beam disk 0.3 z={d} angle=180" for d in ("1.5", "1e6", "1e9")], keys=("Rd", "Tt"))
    moved = ["beam disk 0.3", "beam disk 0.3 at=1e6,0"]
    home = None
    for light, shift, at in zip(moved, ("", " shift=1e6,0,0"), ("0.2", "1000000.2")):
        code, record, said = fly(scene(10000, f'm "sheet.obj"{shift}', light, (f"detector disk 0.1 at={at},0",)))
        verdict.check(f"moved{shift} flies", code == 0, f"exit {code}: {said}")
        home = home or record
        for key in seen:
            verdict.check(f"moved{shift}", abs(record[key] - home[key]) <= home[f"{key}_se"], f"{key}: {record[key]} for {home[key]}")


def time(verdict):
    """Tests that light returns no earlier than it takes to fly from the distant lamp to the medium, and soon after."""
    way = 3e5 / 0.0299792458
    code, record, said = fly(scene(1000, None, "beam pencil z=-3e5", (f"time {1.01 * way:.9g} 101",)))
    verdict.check("time", code == 0, f"exit {code}: {said}")
    gates = cml.read_sections("far.mco")["Rd_t"]
    verdict.check("light in time", sum(gates[:99]) == 0 and sum(gates) * way / 100 > 0.99 * record["Rd"], str([g for g in gates if g > 0]))


def refusals(verdict):
    disk = "detector disk 0.02 at="
    near = (f"{disk}0.1,0",)
    for name, surface, beams, lines, what in (
            ("detectors", None, "beam pencil", (*near, f"{disk}1e6,0"), "scene.mci:6: detector 2 at (1e+06 0) cm: its half width is 0.02 cm (expected at least "),
            ("mesh", 'm "sheet.obj" shift=1e6,0,0', "beam pencil", near, "scene.mci:5: detector 1 at (0.1 0) cm: its half width is 0.02 cm (expected at least "),
            ("bins of a detector", None, "beam pencil", (f"{disk}1e6,0",), "scene.mci:6: beam 1 shines on bins of "),
            ("bins of a mesh", 'm "sheet.obj" shift=1e6,0,0', "beam pencil", (), "scene.mci:5: beam 1 shines on bins of "),
            ("flight", None, "beam pencil at=-1e5,0 z=1.5 angle=90", near, "scene.mci:6: beam: place = (-100000 0 1.5) (expected light that starts at most "),
            ("double", None, "beam pencil at=-1e16,0 z=-1e16 angle=45", near, "scene.mci:6: beam: z = -1e+16 (expected a nearer source: its axis ")):
        code, record, said = fly(scene(10, surface, beams, lines))
        verdict.check(name, code == 2 and not record and said.startswith(f"clustermcml: {what}") and "\n" not in said, f"exit {code}: {said}")


def main():
    verdict = cml.Verdict("far")
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        with open("sheet.obj", "w", encoding="utf-8") as file:
            file.write(sheet())
        shapes(verdict)
        planes(verdict)
        time(verdict)
        refusals(verdict)
    verdict.finish()


main()
