"""bodies.py FOLDER ROUNDS PROGRAM...: steps per second with bodies and without (bench/bodies.sh).
SPDX-License-Identifier: MIT"""
import json
import math
import os
import statistics
import subprocess
import sys

SAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "samples")
FEW, MANY = 2000, 150000  # photons: what a run takes beside its steps falls out of the difference
EDGE_PARTS = 71  # 20 * 71^2 = 100820 triangles
OTHER = "1.5 1 50 0.5"  # medium of the bodies in S6a


def icosahedron():
    """Corners of length 1, and faces seen from outside, counter-clockwise."""
    t = (1 + math.sqrt(5)) / 2
    corners = [(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t), (0, -1, -t), (0, 1, -t),
               (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
             (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11),
             (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    return corners, faces


def write_ball(path, radius, parts):
    """A sphere: each edge of an icosahedron cut into so many parts, and its corners put onto the sphere."""
    corners, faces = icosahedron()
    numbers, vertices, triangles = {}, [], []

    def vertex(weights, face):
        p = [sum(w * corners[c][k] for w, c in zip(weights, face)) for k in range(3)]
        size = math.sqrt(sum(x * x for x in p))
        p = tuple(round(radius * x / size, 9) for x in p)
        if p not in numbers:
            vertices.append(p)
            numbers[p] = len(vertices)
        return numbers[p]

    for face in faces:
        at = {(i, j): vertex((i, j, parts - i - j), face) for i in range(parts + 1) for j in range(parts + 1 - i)}
        for i, j in at:
            if i + j < parts:
                triangles.append((at[i, j], at[i + 1, j], at[i, j + 1]))
            if i + j < parts - 1:
                triangles.append((at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]))
    with open(path, "w") as file:
        file.writelines("v %.9g %.9g %.9g\n" % v for v in vertices)
        file.writelines("f %d %d %d\n" % t for t in triangles)


def sample(name):
    with open(os.path.join(SAMPLES, name)) as file:
        return file.read().splitlines()


def scenes():
    """Name, lines and name of the scene without bodies."""
    lines = sample("thick.mci")
    layer = next(k for k, line in enumerate(lines) if line.startswith("1.4 ")) + 1
    bodies = {"S6a-mesh-1e5": f'i "ball.obj" {OTHER} shift=0,0,-0.25', "S6a-sphere-0.1": f"i sphere 0 0 0.25 0.1 {OTHER}",
              "S6a-sphere-0.05": f"i sphere 0 0 0.25 0.05 {OTHER}"}
    yield "S6a", lines, "S6a"
    for name, body in bodies.items():
        yield name, lines[:layer] + [body] + lines[layer:], "S6a"
    for name in ("vessel", "beads"):
        lines = sample(name + ".mci")
        yield name + "-none", [line for line in lines if not line.startswith("i ")], name + "-none"
        yield name, lines, name + "-none"


def fly(program, folder, name, photons, seed):
    command = [program, "run", name + ".mci", "--photons", str(photons), "--seed", str(seed), "--threads", "1", "--json",
               "--checkpoint", "off"]
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"bodies.py: {' '.join(command)}: exit {done.returncode}: {done.stderr.strip()}")
    return json.loads(done.stdout.strip().splitlines()[-1])


def measure(program, folder, name, seed):
    few, many = (fly(program, folder, name, photons, seed) for photons in (FEW, MANY))
    return {"ns": 1e9 * (many["cpu_s"] - few["cpu_s"]) / (many["steps"] - few["steps"]),
            "queries": many["queries"] / many["steps"], "lost": many["lost"]}


def main():
    folder, rounds, programs = os.path.join(sys.argv[1], "bodies"), int(float(sys.argv[2])), sys.argv[3:]
    os.makedirs(folder, exist_ok=True)
    write_ball(os.path.join(folder, "ball.obj"), 0.1, EDGE_PARTS)
    without = {}
    for name, lines, flat in scenes():
        without[name] = flat
        with open(os.path.join(folder, name + ".mci"), "w") as file:
            file.write("\n".join(lines) + "\n")
    runs = {(name, program): [] for name in without for program in programs}
    for number in range(rounds):
        for name, program in list(runs) if number % 2 == 0 else list(reversed(runs)):
            runs[name, program].append(measure(program, folder, name, number + 1))
    print("| scene | program | ns/step | steps per second over those without bodies | queries % | lost |")
    print("|---|---|---|---|---|---|")
    for (name, program), results in runs.items():
        ns = [r["ns"] for r in results]
        ratio = statistics.median(r["ns"] / mine for r, mine in zip(runs[without[name], program], ns))
        print(f"| {name} | {os.path.basename(program)} | {statistics.median(ns):.1f} ({min(ns):.1f}-{max(ns):.1f}) | {ratio:.2f} | "
              f"{100 * results[0]['queries']:.2f} | {sum(r['lost'] for r in results)} |")


main()
