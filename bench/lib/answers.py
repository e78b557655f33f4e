"""Writes the table of the top README: answers.py README.md. Each question of the benches has its answer, one number from a stored result, its
command and its figure.

SPDX-License-Identifier: MIT
"""
import os
import re
import sys

import tables


def kept(path):
    return os.path.join(tables.BENCH, path)


def rows(path, **wanted):
    return [row for row in tables.read_csv(kept(path))[1] if all(row[key] == value for key, value in wanted.items())]


def cells(path, *first):
    """Returns the cells of the row of a table in a text file that begins with these words."""
    with open(kept(path), encoding="utf-8") as stream:
        found = [line.strip().strip("|").split("|") for line in stream if line.startswith("| " + " | ".join(first) + " |")]
    return [cell.strip() for cell in found[0]]


def speed(case, key):
    return float(rows("speed/results/speed-amd-epyc-2core.csv", case=case, threads="1")[0][key])


def efficiency(ranks):
    with open(kept("speed/results/scaling-amd-epyc-2core.txt"), encoding="utf-8") as stream:
        return next(line.split()[-1] for line in stream if line.split()[:2] == [ranks, "1e+08"])


def reading(path, pattern):
    """Returns a number from the sentences that a script wrote into a README."""
    with open(kept(path), encoding="utf-8") as stream:
        return re.search(pattern, stream.read())[1]


def worst_z(path):
    """Returns (numbers that were compared, the largest deviate) of a table of unbiased.py."""
    with open(kept(path), encoding="utf-8") as stream:
        scenes = [line.split("|") for line in stream if re.match(r"\| \w+ \| (yes)? *\|", line)]
    return sum(int(scene[3]) for scene in scenes), max(abs(float(scene[5].split()[0])) for scene in scenes)


def farthest(path, columns):
    """Returns (rows of a table, for each of these columns the deviate farthest from 0)."""
    with open(kept(path), encoding="utf-8") as stream:
        table = [line.strip().strip("|").split("|") for line in stream if line.startswith("| ")][1:]
    return len(table), *("%.1f" % max(abs(float(row[column])) for row in table) for column in columns)


def roughness():
    """Returns the errors, for n 1.5 in air, of rough faces by statistics (root mean square) and of smooth faces (worst)."""
    return tuple(reading("accuracy/results/roughness.md", r"n 1\.5 in air, " + pattern) for pattern in (
        r"statistics against the mean of .* by ([\d.]+) %", r"smooth faces: .* ([\d.]+) % at alpha 0\.5"))


def natural_events():
    flown = [row for name in ("natural", "natural-irregular", "natural-bodies-tiles")
             for row in rows("stability/results/atlas-%s.csv" % name, status="flown")]
    events = sum(int(row[key] or 0) for row in flown for key in ("lost", "wrong", "missed", "spurious", "nan"))
    return "%d events in %.2g crossings" % (events, sum(int(row["crossings"]) for row in flown))


def times_mmc(top, triangles):
    """Returns how many times as fast as MMC the program is below a top of scene A."""
    with open(kept("peers/results/mmc-amd-epyc-2core.md"), encoding="utf-8") as stream:
        found = [line.strip("| \n").split(" | ") for line in stream if line.startswith("| A | %s | %s |" % (top, triangles))]
    return found[0][6].split()[0]


LIGHT = "speed/results/light-amd-epyc-2core.md"


def answers():
    """Yields (question, answer, command, minutes, figure)."""
    yield ("How fast is it?", "%.0f times original MCML (S6a, one thread)" % speed("S6a", "mcml_to_ours"),
           "python3 bench/speed/speed.py", "9", "speed/results/speed-amd-epyc-2core.svg")
    yield ("What does a rough mesh cost?", "%.1f times a plane's step (S6a, 1e5 triangles)" % speed("S6a-rough-1e5", "to_flat"),
           "python3 bench/speed/speed.py --irregular", "9", "")
    yield ("What do bodies cost?", "%s of the speed without (S6a, 1e5 triangles)" % cells(
        "speed/results/bodies-amd-epyc-2core.md", "S6a-mesh-1e5")[2], "python3 bench/speed/bodies.py", "3", "")
    yield ("What do sources and phase functions cost?", "%.2f times a parallel packet for lambertian light (no medium), %s times a step for a table" % (
        float(cells(LIGHT, "disk 0.1 light=lambertian")[1].split()[0]) / float(cells(LIGHT, "disk 0.1")[1].split()[0]),
        cells(LIGHT, 'table "law.txt"')[2].split()[0]),
        "python3 bench/speed/light.py", "2", "")
    yield ("What do ranks cost each other?", "%s %% of 1000 ranks' time is flight (model, 1e8 bins)" % efficiency("1000"),
           "python3 bench/speed/scaling.py", "1", "")
    yield ("How accurate is it for its time?", "%s of the automatic choices exceed the tolerance" % reading(
        "accuracy/README.md", r"cases (\w+) exceed"), "python3 bench/accuracy/accuracy.py", "30", "accuracy/results/accuracy-amd-epyc-2core/lohill.svg")
    yield ("How long does an error take?", "%s times less than with MCML's sampling (mean of all)" % reading(
        "accuracy/README.md", r"error of Rd, A, Tt, ([\d.]+) in their geometric mean"), "python3 bench/accuracy/frontier.py", "4",
        "accuracy/results/frontier-amd-epyc-2core.svg")
    yield ("Both in one picture?", "%.2g core seconds to 0.1 %% of Rd (a hill, auto)" % float(
        rows("accuracy/results/summary-amd-epyc-2core.csv", scene="lohill", method="auto")[0]["s_Rd"]),
        "python3 bench/accuracy/summary.py", "1", "accuracy/results/summary-amd-epyc-2core.svg")
    yield ("When is a number as good as a relief?", "%s %% from reliefs of at most half a mean free path; smooth faces %s %% (alpha 0.5)" % roughness(),
        "python3 bench/accuracy/roughness.py", "10", "accuracy/results/roughness.svg")
    yield ("Are results unbiased, and their errors true?", "of %d numbers the worst is %.1f errors off" % worst_z(
        "accuracy/results/unbiased.md"), "python3 bench/accuracy/unbiased.py", "30", "")
    yield ("How far off are bodies as meshes?", "%s at the default tolerance (black sphere)" % cells(
        "accuracy/results/body_bias.md", "", "14580", "1e-3")[3], "python3 bench/accuracy/body_bias.py", "4", "")
    yield ("Are the report's figures right?", "its flat scenes are", "python3 bench/accuracy/figures.py", "10", "accuracy/results/figure8.svg")
    yield ("Where do methods fail?", natural_events(), "python3 bench/stability/atlas.py", "30", "")
    yield ("How fast is it beside tetrahedra?", "%s times MMC (A, 1e4 triangles)" % times_mmc("regular", "10082"),
           "python3 bench/peers/mmc.py --mmc PATH", "4", "")
    yield ("And below an overhang?", "%s (A) and %s (S6a) times MMC's B, %s and %s its S, %s and %s Mitsuba" % tuple(
        cells("peers/results/peers-shared-amd-epyc-2core.md", "overhang", medium)[column].split()[0]
        for column in (15, 14, 17) for medium in ("A", "S6a")), "python3 bench/peers/peers.py --mmc PATH --shared --only overhang", "3", "")
    yield ("What do MMC and Mitsuba 3 say of any mesh?", "of %d shares MMC's S is %s errors off, its B %s, Mitsuba %s at most" % farthest(
        "peers/results/peers-shared-amd-epyc-2core.md", (7, 9, 12)), "python3 bench/peers/peers.py --mmc PATH --shared", "15", "")
    yield ("What does MMC say of a vessel?", "the same: %s errors apart" % cells(
        "peers/results/vessel-intel-xeon-2core.md", "vessel")[3], "python3 bench/peers/vessel.py --mmc PATH", "2", "")
    yield ("What does single scattering at rough faces lose?", "%s of what leaves a slab (ggx 0.2), by Mitsuba 3" % cells(
        "peers/results/rough_faces.md", "ggx 0.2", "0")[4], "python3 bench/peers/rough_faces.py", "5", "")
    yield ("Does Mitsuba 3 render our .bsdf files as the slab itself?", "in light from %s" % reading("peers/results/appearance.md", r"exits, light from (.*)\."),
           "python3 bench/peers/appearance.py", "10", "")
    yield ("Which roulette?", "a window of %s" % reading("choices/results/roulette.md", r"figure: ([\d.,]+)\."),
           "python3 bench/choices/roulette.py", "2", "")
    yield ("What does --aim gain?", "%s in the time of Tt (S6a, rough), %s where it is 2.6e-6" % tuple(
        cells("choices/results/aim.md", scene)[6] for scene in ("S6a rough top", "slab 3.2 cm rough top")),
        "python3 bench/choices/aim.py", "2", "")
    yield ("Which generating vector for the lattice?", "its worst error is 1/%s of random's (1e6 photons)" % rows(
        "choices/results/lattice.csv", photons="1e6")[0]["random points over it"], "build/bench_lattice", "1", "")
    yield ("Does the lattice serve every beam?", "variance over random's is %s in the mean of isotropic light, its largest %s" % (
        cells("choices/results/lights.md", "isotropic")[4], cells("choices/results/lights.md", "isotropic")[3].split()[0]),
        "python3 bench/choices/lights.py", "15", "")
    yield ("Where does the time go?", "%s %% of the rays asked meet the boundary (S6a, rough)" % (
        100 - int(reading("parts/README.md", r"\| S6a-rough-1e5 \|.*\| (\d+) % \|"))), "python3 bench/parts/parts.py", "6", "")
    yield ("What does the kernel need on a GPU?", "%s registers (H100, all kinds of boundaries)" % rows(
        "parts/results/gpu-static.csv", device="sm_90", boundaries="cones, bodies")[0]["registers"],
        "python3 bench/parts/gpu_static.py", "1", "")
    yield ("How fast is an OpenCL device?", "prints a table; none is kept", "python3 bench/speed/opencl.py", "5", "")
    yield ("What do threads cost on a busy machine?", "prints a table; none is kept", "python3 bench/speed/busy_machine.py", "1", "")


def lines():
    return tables.table(("question", "answer", "command", "minutes", "figure"), [
        [question, answer, "`%s`" % command, minutes, "[figure](%s)" % figure if figure else ""]
        for question, answer, command, minutes, figure in answers()])


if __name__ == "__main__":
    tables.replace(sys.argv[1], "lib/answers.py", list(lines()))
