"""Tests rough boundaries against an independent program (rough_oracle.c): totals, light kept by layers, bodies and a backing,
and light by direction.

    rough_oracle.py [short|long [PACKETS [SCENE ...]]]

Scenes written out here cover the lines of `rough` and the objects that they affect. `long` adds random scenes. N = 1e5
packets a scene on both sides, 4e5 with ALL_CASES, 2e6 in `long` (random scenes: 4e5). Statistic: z, at most 4.5, and the mean
of z^2 (oracle.py)."""
import math
import os
import random
import sys
import tempfile
from dataclasses import dataclass, field

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import oracle  # noqa: E402

ORACLE = os.environ.get("ROUGH_ORACLE", "build/tests/rough_oracle")
NT, NP = 9, 4
FACE = {"": 0, "ggx": 1, "beckmann": 2}
LIGHT = {"": 0, "isotropic": 1, "lambertian": 2}
ROOF = [  # a pyramid of half width 1, in heights over z = 0
    (x1, y1, 0, x2, y2, 0, 0.1, 0.05, 0.8) for x1, y1, x2, y2 in ((-1, -1, 1, -1), (1, -1, 1, 1), (1, 1, -1, 1), (-1, 1, -1, -1))]
PIT = [(*t[:8], -0.5) for t in ROOF]
LOW = [(*t[:8], 0.15) for t in ROOF]


@dataclass
class Body:
    line: str  # a sphere as in an .mci file: centre x y z and radius [cm], then n mua mus g
    rough: str = ""
    around: int = 1  # number of the layer around the body
    inside: int = 0  # number of the body around it, from 1


@dataclass
class Scene:
    name: str
    layers: list  # "n mua mus g d" of each layer
    rough: list  # one per boundary: "", or kind and alpha
    n: tuple = (1, 1)
    beam: dict = field(default_factory=dict)  # keys: at, z, angle, azimuth, disk, light
    backing: str = ""
    bodies: list = field(default_factory=list)
    mesh: list = None  # triangles of boundary 0
    shaded: bool = False  # option normals=vertex
    hill: float = 0  # height of a cone of radius 0.5
    before: str = ""  # "#@ " before lines of this program


def top_normal(mesh):
    """Returns the normal at the top of a pyramid: the mean of the faces' normals, weighted by their angles there."""
    total = [0, 0, 0]
    for facet in mesh:
        top = facet[6:]
        a, b = ([facet[k + i] - top[i] for i in range(3)] for k in (0, 3))
        cross = [a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3] for i in range(3)]
        angle = math.acos(sum(x * y for x, y in zip(a, b)) / (math.hypot(*a) * math.hypot(*b)))
        total = [t + angle * c / math.hypot(*cross) * math.copysign(1, cross[2]) for t, c in zip(total, cross)]
    return [t / math.hypot(*total) for t in total]


def boundary_numbers(scene, b, z):
    mesh = (scene.mesh or []) if b == 0 else []
    reach = 1 if mesh else 0.5 if b == 0 and scene.hill else 0
    numbers = [z, *face_numbers(scene.rough[b]), reach, scene.hill if b == 0 else 0, int(b == 0 and scene.shaded), len(mesh)]
    for facet in mesh:
        corners = [*facet, *([0, 0, 1] * 2 + top_normal(mesh) if scene.shaded else [])]
        numbers += [-value if i % 3 == 2 else value for i, value in enumerate(corners)]
    return numbers


def face_numbers(rough):
    kind, alpha = rough.split() if rough else ("", 0)
    return [FACE[kind] if float(alpha) > 0 else 0, alpha]


def oracle_numbers(scene, seed, packets):
    beam = scene.beam
    word = scene.backing.split() or [""]
    kind = {"": 0, "metal": 2}.get(word[0], 1)
    numbers = [seed, packets, NT, NP, LIGHT[beam.get("light", "")], int("z" in beam), *beam.get("at", (0, 0)), beam.get("z", 0),
               beam.get("angle", 0), beam.get("azimuth", 0), beam.get("disk", 0), kind, word[0] if kind == 1 else 0,
               *(word[1:3] if kind == 2 else (0, 0)), len(scene.layers), scene.n[0], 0, 0, 0]
    z = 0
    for layer in scene.layers:
        numbers += layer.split()[:4]
    numbers += [scene.n[1], 0, 0, 0]
    for b in range(len(scene.rough)):
        numbers += boundary_numbers(scene, b, z)
        z += float(scene.layers[b].split()[4]) if b < len(scene.layers) else 0
    numbers.append(len(scene.bodies))
    for body in scene.bodies:
        values = body.line.split()
        around = len(scene.layers) + 1 + body.inside if body.inside else body.around
        numbers += [*values[:4], around, *face_numbers(body.rough), *values[4:]]
    return numbers


def by_oracle(scene, seed, packets):
    values = list(oracle.ask(ORACLE, oracle_numbers(scene, seed, packets)))
    media = len(scene.layers) + 2 + len(scene.bodies)
    found = dict(zip(("Rsp", "Rd", "Tt", "A_backing", "trapped", "lost"), values))
    for i in range(len(scene.layers)):
        found[f"A_l {i + 1}"] = values[6 + 1 + i]
    for i in range(len(scene.bodies)):
        found[f"A_body {i + 1}"] = values[6 + len(scene.layers) + 2 + i]
    for i, what in enumerate(("Rsp", "Rd", "Tt")):
        begin = 6 + media + i * NT * NP
        found[what + "_dir"] = values[begin:begin + NT * NP]
    return found


def beam_line(beam):
    words = [f"beam disk {beam['disk']}" if "disk" in beam else "beam pencil"]
    words += [f"at={beam['at'][0]},{beam['at'][1]}"] if "at" in beam else []
    words += [f"{key}={beam[key]}" for key in ("z", "angle", "azimuth", "light") if key in beam]
    return " ".join(words)


def program_text(scene, packets, folder):
    lines = ["1.0", "1", "rough.mco A", f"{packets}", beam_line(scene.beam), f"directions {NT} {NP}", "0.01 0.01", "10 10 5",
             f"{len(scene.layers)}", f"{scene.n[0]}"]
    for b, rough in enumerate(scene.rough):
        lines += [f"b 2 {scene.hill} 0.5 0 1"] if b == 0 and scene.hill else []
        if b == 0 and scene.mesh:
            path = os.path.join(folder, "shape.obj")
            with open(path, "w", encoding="utf-8") as file:
                for facet in scene.mesh:
                    for k in range(0, 9, 3):
                        file.write("v {} {} {}\n".format(*facet[k:k + 3]))
                for i in range(len(scene.mesh)):
                    file.write(f"f {3 * i + 1} {3 * i + 2} {3 * i + 3}\n")
            lines.append(f'm "{path}"' + (" normals=vertex" if scene.shaded else ""))
        lines += [f"{scene.before}rough {rough}"] if rough else []
        if b == len(scene.layers):
            break
        lines.append(scene.layers[b])
        for body in scene.bodies:
            if body.around == b + 1:
                lines.append(f"i sphere {body.line}" + (f" rough={body.rough.replace(' ', ',')}" if body.rough else ""))
    lines += [f"{scene.before}backing {scene.backing}"] if scene.backing else []
    return "\n".join(lines + [f"{scene.n[1]}"]) + "\n"


def by_program(scene, seed, packets):
    with tempfile.TemporaryDirectory() as folder:
        told, sections = oracle.fly(scene.name, program_text(scene, packets, folder), seed, folder)
    found = {key: (told[key], told[key + "_se"]) for key in ("Rsp", "Rd", "Tt")}
    found["A_backing"] = (told.get("A_backing", 0), told.get("A_backing_se", 0))
    for i in range(len(scene.layers)):
        found[f"A_l {i + 1}"] = (told["A_l"][i], told["A_l_se"][i])
    for i, body in enumerate(told.get("bodies", [])):
        found[f"A_body {i + 1}"] = (body["A"], body["A_se"])
    found |= {key: oracle.profile(sections, key, oracle.sectors(NT, NP)) for key in ("Rsp_dir", "Rd_dir", "Tt_dir")}
    return found, told


def written_scenes():
    slab, thin = "1.5 1 20 0.8 0.5", "1.4 0.5 10 0.5 0.1"
    yield Scene("slab", [slab], ["beckmann 0.5"] * 2)
    yield Scene("slanted", [slab], ["ggx 0.5", "ggx 0.2"], beam={"angle": 45, "azimuth": 30})
    yield Scene("n falls", ["1.33 0.3 15 0.7 0.2"], ["ggx 2", "beckmann 0.0001"], n=(1.5, 1.6), beam={"angle": 70}, before="#@ ")
    yield Scene("smooth below", [slab, "1.4 2 30 0.9 0.1"], ["beckmann 1", "ggx 0", ""], n=(1, 1.4), beam={"angle": 20, "azimuth": 200})
    yield Scene("equal indices", [slab, "1.5 0.2 30 -0.3 0.05"], ["ggx 0.1", "ggx 1", "beckmann 2"], n=(1.5, 1), beam={"light": "lambertian"})
    yield Scene("window", ["1.5 0 0 0 0.1", "1.35 1 40 0.8 0.2"], ["", "ggx 0.4", ""])
    yield Scene("two smooth", ["1.5 0 0 0 0.1", "1.35 1 10 0.8 0.1"], ["", "", "beckmann 0.7"])
    yield Scene("clear", ["1.5 0 0 0 0.3"], ["beckmann 0.05", "ggx 0.05"], beam={"angle": 45})
    yield Scene("clear, coarse", ["1.7 0 0 0 0.3", "1.2 0 0 0 0.3"], ["ggx 1", "beckmann 0.3", "ggx 0.3"], beam={"angle": 60, "azimuth": 120})
    yield Scene("mirror", [thin], ["", "ggx 0.4"], backing="0.7", beam={"angle": 30})
    yield Scene("gold", ["1.5 0 0 0 0.1"], ["ggx 0.3", "beckmann 1"], backing="metal 0.18 3.43", beam={"angle": 50, "azimuth": 300})
    yield Scene("glass metal", [thin], ["beckmann 0.2", "ggx 1.5"], backing="metal 1.37 0.6")
    yield Scene("sphere", [slab], ["ggx 0.3", ""], beam={"at": (0.05, 0), "angle": 30},
                bodies=[Body("0 0 0.15 0.12 1.0 0 0 0", "ggx 0.6"), Body("0.2 0.1 0.3 0.1 1.8 2 5 0", "")])
    yield Scene("glow", ["1.4 0.5 10 0.5 0.4"], ["", "beckmann 0.5"], beam={"at": (0, 0.02), "z": 0.2, "light": "isotropic"},
                bodies=[Body("0 0 0.2 0.15 1.6 1 5 0.3", "beckmann 1"), Body("0.05 0 0.2 0.06 1.2 0 0 0", "ggx 0.1", inside=1)])
    yield Scene("from below", [slab], ["ggx 0.7", "beckmann 0.4"], n=(1, 1.2), beam={"z": 0.7, "angle": 140, "azimuth": 60})
    yield Scene("between", ["1.5 0 0 0 0.3"], ["ggx 0.2", "ggx 0.5"], beam={"z": 0.1, "light": "isotropic"})
    yield Scene("roof", [slab], ["ggx 0.3", "ggx 0.3"], mesh=ROOF, beam={"disk": 1.2, "angle": 20})
    yield Scene("shaded", [slab], ["ggx 0.3", ""], mesh=LOW, shaded=True, beam={"disk": 1.0, "angle": 10})
    yield Scene("hill", [slab], ["ggx 0.5", "beckmann 0.5"], hill=0.4, beam={"at": (0.1, 0), "disk": 0.4, "angle": 30})
    yield Scene("hollow", ["1.5 1 5 0.8 0.9"], ["beckmann 0.3", ""], n=(1.2, 1.5), hill=-0.6, beam={"disk": 0.5, "angle": 5})
    yield Scene("pit", ["1.5 0.3 3 0.5 0.9"], ["beckmann 0.6", ""], mesh=PIT, beam={"disk": 1.0})


def drawn_scene(number):
    """Returns a random scene of one to three layers."""
    dice = random.Random(number)

    def rough():
        return dice.choice(["", f"{dice.choice(['ggx', 'beckmann'])} {math.exp(dice.uniform(math.log(1e-2), math.log(2))):.3g}"]
                           + [f"{dice.choice(['ggx', 'beckmann'])} {dice.uniform(0.1, 2):.3g}"] * 3)

    def medium():
        clear = dice.random() < 0.2
        return f"{dice.choice([1, 1.2, 1.33, 1.4, 1.5, 2.2])} {0 if clear else dice.choice([0.2, 2])} {0 if clear else dice.choice([2, 20])} {dice.choice([-0.4, 0, 0.8])}"

    layers = [f"{medium()} {dice.choice([0.05, 0.2, 0.6])}" for _ in range(dice.randint(1, 3))]
    beam = dice.choice([{}, {"angle": dice.randint(1, 85), "azimuth": dice.randint(0, 359)}, {"light": "lambertian"}])
    backing = dice.choice(["", "", "", f"{dice.random():.2f}", f"metal {dice.uniform(0, 3):.2f} {dice.uniform(0, 5):.2f}"])
    faces = [rough() or "beckmann 0.3", *(rough() for _ in layers[1:]), rough() or "ggx 0.4"]
    bodies = []
    if float(layers[0].split()[4]) == 0.6:
        bodies = [Body(f"0 0 0.3 0.25 {medium()}", rough() or "ggx 0.3"), Body(f"0 0.05 0.3 0.15 {medium()}", rough() or "ggx 1", inside=1)]
    return Scene(f"lot {number}", layers, faces, n=(dice.choice([1, 1.5]), dice.choice([1, 1.33])), beam=beam, backing=backing, bodies=bodies)


oracle.judge("rough boundaries", written_scenes(), drawn_scene, 200000, by_program, by_oracle, ("lost", "trapped"), limit=4.5)
