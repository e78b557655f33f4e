"""Parts that tests against independent programs share: numbers of both programs side by side, and the verdict over all scenes.

A scene is an object with a `name`. A number is (value, error), and a list of numbers is a profile, whose bins are joined until the
independent program has some 100 packets in each. Statistic: z, and the mean of z^2 over all numbers: at most 1 and 4.5 times its
error, sqrt(2 / tests)."""
import json
import math
import os
import statistics
import subprocess
import sys

import cml


def ask(program, numbers):
    """Returns an iterator over the lines that an independent program prints, each (value, error)."""
    done = subprocess.run([program], input=" ".join(map(str, numbers)), capture_output=True, text=True, check=True)
    return iter([tuple(map(float, line.split())) for line in done.stdout.splitlines()])


def fly(name, text, seed, folder):
    """Flies the text of an .mci file in a folder. Returns the JSON record and the sections of the result."""
    path = os.path.join(folder, "scene.mci")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    done = subprocess.run([cml.PROGRAM, path, "--json", "--output-dir", folder, "--seed", str(seed)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{name}: exit {done.returncode}: {done.stderr}")
    told = json.loads(done.stdout)
    return told, cml.read_sections(told["output"])


def profile(sections, name, sizes):
    """Returns a section's values and errors, times the sizes of its bins."""
    return [(value * size, error * size) for value, error, size in zip(sections[name], sections["se_" + name], sizes)]


def sectors(rows, columns):
    """Returns the solid angles of bins of directions."""
    edges = [math.cos(t * math.pi / 2 / rows) for t in range(rows + 1)]
    return [(a - b) * 2 * math.pi / columns for a, b in zip(edges, edges[1:]) for _ in range(columns)]


def compare(verdict, scene, ours, told, theirs, packets, never):
    """Compares every number that both programs give, by z. never: light that must not be in the independent program."""
    cml.check_balance(verdict, scene.name, told)
    verdict.check(f"{scene.name}: the other program", all(theirs.pop(key)[0] == 0 for key in never), "lost packets")
    before = len(verdict.rows)

    def test(name, a, b):
        if a == b == (0, 0) or (abs(a[0] - b[0]) < 1e-7 and a[1] < 1e-7 and b[1] < 1e-7):  # no light, or split off without error
            return
        verdict.z(f"{scene.name}: {name}", a[0], cml.error_of(*a, packets), b[0], cml.error_of(*b, packets))

    for key, expected in theirs.items():
        if not isinstance(expected, list):
            test(key, ours[key], expected)
            continue
        for first, last, *pair in cml.joined(ours[key], expected):
            test(f"{key} {first}-{last}", tuple(pair[:2]), tuple(pair[2:]))
    return [score for score, _ in verdict.rows[before:]]


def judge(title, written, drawn, usual, by_program, by_oracle, never, limit=None):
    """Judges all scenes of the command line: [short|long [PACKETS [SCENE ...]]]. usual: packets of a scene."""
    whole, chosen = sys.argv[1:2] == ["long"], sys.argv[3:]
    packets = int(float(sys.argv[2])) if len(sys.argv) > 2 else 2000000 if whole else cml.repeats(usual)
    scenes = [(scene, packets) for scene in written]
    scenes += [(drawn(i), packets // 5) for i in range(60)] if whole else []
    verdict, squares = cml.Verdict(title), []
    for i, (scene, number) in enumerate(scenes):
        if chosen and scene.name not in chosen:
            continue
        theirs = by_oracle(scene, i + 1, number)
        scores = compare(verdict, scene, *by_program(scene, i + 1, number), theirs, number, never)
        squares += [score * score for score in scores]
        print(f"{scene.name}: {len(scores)} numbers, worst |z| {max(scores):.2f}, mean z^2 {statistics.fmean(squares[-len(scores):]):.2f}", flush=True)
    mean = statistics.fmean(squares)
    verdict.check("mean of z^2", mean < 1 + 4.5 * math.sqrt(2 / len(squares)), f"{mean:.3f} of {len(squares)} numbers")
    verdict.finish(limit=limit)
