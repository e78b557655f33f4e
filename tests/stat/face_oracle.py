"""Tests a probe in contact, `face` and `port` lines, against an independent program (face_oracle.c): totals, light kept by
layers, faces and a backing, light in detectors, light that leaves upward by radius, angle, time, direction and pixel, and
fluence by voxels that reach above boundary 0.

    face_oracle.py [short|long [PACKETS [SCENE ...]]]

Scenes written out here cover shapes, laws, overlaps, and every way in which light comes in or is seen. `long` adds random
scenes. N = 1e5 packets a scene on both sides, 4e5 with ALL_CASES, 2e6 in `long` (random scenes: 4e5). Statistic: z, at most
Sidak's limit at a level of 1e-4 for all numbers, and the mean of z^2 (oracle.py)."""
import math
import os
import random
import sys
import tempfile
from dataclasses import dataclass, field

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import oracle  # noqa: E402

ORACLE = os.environ.get("FACE_ORACLE", "build/tests/face_oracle")
NR, DR, NA, NT, DIR_T, DIR_P = 20, 0.02, 15, 8, 6, 4
NX, NY, NZ, DX, DY, DZ, TOP = 4, 3, 5, 0.15, 0.2, 0.1, -0.2  # a map, and its voxels
LAWS = {"mirror": 1, "metal": 2, "lambertian": 3, "port": 4}
SHAPES = {"disk": (1, 1), "ring": (2, 2), "rectangle": (3, 2)}  # number of the shape, and of its sizes
LIGHTS = {"parallel": 0, "isotropic": 1, "lambertian": 2, "na": 3}


@dataclass
class Scene:
    name: str
    top: list  # lines on boundary 0
    layers: list  # "n mua mus g d" of each layer
    beams: list = field(default_factory=lambda: ["pencil"])  # the words behind `beam`
    detectors: list = field(default_factory=list)  # the words behind `detector`
    n: tuple = (1, 1)
    backing: str = ""
    end: float = 200  # end of the gates [ps]
    before: str = ""  # "#@ " before lines on top
    map: bool = True  # not where light is split off a clear layer 1, whose fluence the other program does not know


def keys_of(words):
    """Returns the pairs KEY=VALUE of a line; words without a value have ""."""
    return {key: value for key, _, value in (word.partition("=") for word in words)}


def shape_numbers(words, keys):
    """Returns the numbers of a shape, and how many words it has; no shape covers all."""
    kind, sizes = SHAPES.get(words[0], (0, 0)) if words else (0, 0)
    size = [*words[1:1 + sizes], 0, 0][:2]
    return [kind, *size, *keys.get("at", "0,0").split(",")], sizes + (kind > 0)


def surface_numbers(words):
    """Returns the numbers of the law of a face or a backing: R [mirror|lambertian], or metal N K."""
    if words[:1] == ["metal"]:
        return [LAWS["metal"], *words[1:3]]
    return [LAWS["lambertian" if "lambertian" in words else "mirror"], words[0], 0] if words else [0, 0, 0]


def line_numbers(line):
    word, *rest = line.split()
    keys = keys_of(rest)
    shape, used = shape_numbers(rest, keys)
    return shape + ([LAWS["port"], keys["n"], 0] if word == "port" else surface_numbers(rest[used:]))


def port_numbers(top):
    """Returns the number of the line of each port by its name."""
    found = {}
    for i, line in enumerate(top):
        if line.startswith("port"):
            found[keys_of(line.split()).get("name", str(len(found) + 1))] = i
    return found


def placed(words, ports):
    """Returns the numbers of what has a port or a shape, and its pairs KEY=VALUE."""
    keys = keys_of(words)
    if words[0] == "port":
        return [ports[words[1]], 0, 0, 0, 0, 0], keys
    shape = shape_numbers(words, keys)[0] if words[0] != "pencil" else [1, 0, 0, *keys.get("at", "0,0").split(",")]
    return [-1, *shape], keys


def beam_numbers(line, ports):
    place, keys = placed(line.split(), ports)
    light, _, aperture = keys.get("light", "parallel").partition(":")
    return [*place, int("z" in keys), *(keys.get(key, 0) for key in ("z", "angle", "azimuth")), LIGHTS[light], aperture or 0, keys.get("share", 1)]


def detector_numbers(line, ports):
    place, keys = placed(line.split(), ports)
    return [*place, *(keys.get(key, 0) for key in ("z", "na", "angle", "azimuth")), int("diffuse" in keys)]


def oracle_numbers(scene, seed, packets):
    ports = port_numbers(scene.top)
    numbers = [seed, packets, NR, DR, NA, NT, scene.end / NT, DIR_T, DIR_P, *((NX, NY, NZ) if scene.map else (0, 0, 0)), DX, DY, DZ, TOP, len(scene.layers), scene.n[0]]
    numbers += " ".join(scene.layers).split() + surface_numbers(scene.backing.split()) + [scene.n[1]]
    for rows in (map(line_numbers, scene.top), (beam_numbers(line, ports) for line in scene.beams), (detector_numbers(line, ports) for line in scene.detectors)):
        rows = list(rows)
        numbers += [len(rows), *(number for row in rows for number in row)]
    return numbers


def by_oracle(scene, seed, packets):
    values = oracle.ask(ORACLE, oracle_numbers(scene, seed, packets))
    found = {name: next(values) for name in ("Rsp", "Rd", "Tt", "A_face", "A_backing", "trapped")}
    found |= {f"A_l {i + 1}": next(values) for i in range(len(scene.layers))}
    found |= {f"detector {i + 1}": next(values) for i in range(len(scene.detectors))}
    sizes = {"Rd_r": NR, "Rd_a": NA, "Rd_t": NT + 1, "Rsp_dir": DIR_T * DIR_P, "Rd_dir": DIR_T * DIR_P}
    sizes |= {"Rd_xy": NX * NY, "phi_xyz": NX * NY * NZ} if scene.map else {}
    return found | {name: [next(values) for _ in range(size)] for name, size in sizes.items()}


def program_text(scene, packets):
    return "\n".join(["1.0", "1", "face.mco A", f"{packets}", *("beam " + line for line in scene.beams), f"time {scene.end} {NT}",
                      f"directions {DIR_T} {DIR_P}", *([f"map {NX} {NY} {DX} {DY} volume top={TOP}", "fluence"] if scene.map else []), *(f"detector {line} name=d{i}" for i, line in enumerate(scene.detectors, 1)),
                      f"{DZ} {DR}", f"{NZ} {NR} {NA}", f"{len(scene.layers)}", f"{scene.n[0]}", *(scene.before + line for line in scene.top),
                      *scene.layers, *([f"backing {scene.backing}"] if scene.backing else []), f"{scene.n[1]}"]) + "\n"


def annuli(count, step):
    return [math.pi * step * step * (2 * i + 1) for i in range(count)]


def by_program(scene, seed, packets):
    with tempfile.TemporaryDirectory() as folder:
        told, sections = oracle.fly(scene.name, program_text(scene, packets), seed, folder)
    found = {key: (told.get(key, 0), told.get(key + "_se", 0)) for key in ("Rsp", "Rd", "Tt", "A_face", "A_backing")}
    found |= {f"A_l {i + 1}": (told["A_l"][i], told["A_l_se"][i]) for i in range(len(scene.layers))}
    found |= {f"detector {i + 1}": (told[f"detector_d{i + 1}"], told[f"detector_d{i + 1}_se"]) for i in range(len(scene.detectors))}
    lists = {"Rd_r": annuli(NR, DR), "Rd_a": oracle.sectors(NA, 1), "Rd_t": [scene.end / NT] * NT}
    lists |= {key: oracle.sectors(DIR_T, DIR_P) for key in ("Rsp_dir", "Rd_dir")}
    lists |= {"Rd_xy": [DX * DY] * NX * NY, "phi_xyz": [DX * DY * DZ] * NX * NY * NZ} if scene.map else {}
    found |= {name: oracle.profile(sections, name, sizes) for name, sizes in lists.items()}
    found["Rd_t"].append((told["Rd_t_later"], told["Rd_t_later_se"]))
    return found, told


def written_scenes():
    slab, wet = "1.4 0.5 20 0.8 0.5", "1.33 0.2 10 0.5 0.3"
    pair = ["port disk 0.11 n=1.44 at=-0.11,0", "port disk 0.1 n=1.46 at=-0.11,0 name=in", "port disk 0.11 n=1.44 at=0.11,0", "port disk 0.1 n=1.46 at=0.11,0 name=out"]
    yield Scene("steel", ["face disk 0.3 0.6", *pair], [slab], ["port in light=na:0.22"],
                ["port out na=0.22", "port out", "port in na=0.22", "port in diffuse", "port 1", "disk 0.1 at=0.11,0 na=0.5", "ring 0.3 5"])
    yield Scene("white", ["face 0.9 lambertian", "port ring 0.05 0.1 n=1.5", "port rectangle 0.2 0.1 n=1 at=0.25,0.1 name=window"], [wet, "1.5 1 30 0.9 0.2"],
                ["port 1 light=lambertian"], ["port window", "port 1 na=0.7", "port window na=0.9 angle=30 azimuth=60"], n=(1.2, 1.4), end=100)
    yield Scene("gold", ["face disk 0.5 metal 0.18 3.43", "port rectangle 0.3 0.2 n=1.6 at=0,-0.2 name=a", "port disk 0.1 n=1.2 at=0,0.2 name=b"], [slab],
                ["port a"], ["port a", "port b", "port b na=0.4 angle=20", "port a diffuse"], n=(1.33, 1), before="#@ ")
    yield Scene("plate", ["face 0.3", "port disk 0.15 n=1.46 name=core", "port ring 0.15 0.3 n=1.7 name=rim"], ["1.5 0 0 0 0.1", "1.36 0.4 20 0.7 0.4"],
                ["port core", "port rim share=2"], ["port core", "port rim", "port core diffuse", "disk 0.3", "disk 0.2 z=-0.2 na=1"], n=(1, 1.36), map=False)
    yield Scene("slanted", ["face disk 0.4 0.5 lambertian at=0.1,0", "port disk 0.1 n=1.5 at=0.1,0.1 name=in", "port disk 0.15 n=1.3 at=0.1,-0.2 name=out"], [wet],
                ["port in angle=30 azimuth=40 light=na:0.3"], ["port out angle=25 azimuth=250 na=0.6", "port in angle=30 azimuth=40 na=0.4", "port out na=1.25", "disk 0.3 z=-0.3 at=0,-0.2"])
    yield Scene("stopped", ["face rectangle 0.6 0.4 0.7", "port rectangle 0.1 0.2 n=1.33 at=-0.1,0 name=hole", "port disk 0.1 n=1.5 at=0.15,0 name=glass"], [slab],
                ["disk 0.4 at=0.05,0 angle=25 azimuth=20 light=na:0.2"], ["port hole", "port glass", "port hole diffuse", "disk 0.4", "disk 0.5 z=-0.4 diffuse"], n=(1.33, 1))
    yield Scene("hole", ["face 0.6", "port disk 0.05 n=1 name=hole", "port ring 0.1 0.2 n=1 name=read", "face rectangle 0.1 0.1 metal 2 3 at=0.15,0"], [slab],
                ["disk 0.1"], ["port hole", "port read", "port hole diffuse na=0.5", "ring 0.1 0.2"])
    yield Scene("inside", ["port disk 0.1 n=1.8 at=0.05,0", "port ring 0.1 0.2 n=1.1 at=0.05,0", "face ring 0.2 0.25 metal 1.4 7.6 at=0.05,0"], ["1.5 0.3 5 0.3 0.4"],
                ["disk 0.05 at=0,0.1 z=0.15 light=isotropic"], ["port 1 na=1.2", "port 2 na=0.9", "disk 0.2 z=-0.3", "disk 0.25 na=0.8", "rectangle 0.2 0.3 at=0.1,0 z=-0.1 angle=20 na=0.7"])
    yield Scene("overlaps", ["port disk 0.4 n=1.55 name=epoxy", "face ring 0.1 0.2 0.2 lambertian at=0.1,0", "port disk 0.12 n=1.46 at=-0.1,0 name=a", "face rectangle 0.1 0.1 0.9 at=0.1,0.05",
                             "port rectangle 0.1 0.3 n=1.33 at=0.15,-0.2 name=b", "port disk 0.02 n=2 at=0.15,-0.2 name=c"], ["1.33 0.2 20 0.9 0.1", "1.45 1 30 0.7 0.4"],
                ["port a light=na:0.5", "port c light=lambertian share=0.5"], ["port epoxy", "port a", "port b", "port c", "disk 0.4 na=0.8", "ring 0.4 9"], n=(1.2, 1))
    yield Scene("backing", ["face 0.8", "port disk 0.1 n=1.4 at=0.1,0", "port disk 0.1 n=1 at=-0.1,0 name=air"], ["1.4 0.5 10 -0.4 0.15", "1.3 0 0 0 0.05"],
                ["port 1 angle=50 azimuth=120", "pencil at=-0.1,0.05 angle=40 share=0.5"], ["port air", "port 1", "port 1 na=1.39"], backing="0.8 lambertian")
    yield Scene("stripes", ["face metal 0.2 3", "port rectangle 0.1 2 n=1.2 at=-0.1,0", "port rectangle 0.1 2 n=2 at=0.1,0"], ["1.5 0.1 4 0 0.3", "1.5 0 0 0 0.1", "1.7 2 40 0.8 0.1"],
                ["port 1 light=lambertian", "port 2 light=lambertian share=2.7"], ["port 1", "port 2", "port 1 diffuse", "disk 0.2 at=0.1,0 z=-0.2 na=1.3"], n=(1.9, 1.2), backing="metal 1.4 7.6")
    yield Scene("open", ["face disk 0.1 0.95", "port disk 0.05 n=1.46 at=0,0.3"], [wet], ["disk 0.3 light=lambertian", "rectangle 0.2 0.2 at=0.2,0.3 z=0.1 angle=120 light=lambertian"],
                ["disk 0.2", "disk 0.05 at=0,0.3", "port 1 diffuse", "ring 0.1 0.3 na=0.5 angle=45"], n=(1.5, 1.33))
    yield Scene("black", ["port disk 0.4 n=2 name=hidden", "face 0", "port disk 0.2 n=1.33 name=same", "port disk 0.05 n=3 name=dense"], [wet], ["port dense light=na:2.9"], ["port same", "port dense", "port dense diffuse na=1", "port hidden"])


def drawn_shape(dice, most):
    a = dice.uniform(0.1, 1) * most
    return dice.choice([f"disk {a:.3g}", f"ring {a / 2:.3g} {a:.3g}", f"rectangle {a:.3g} {dice.uniform(0.1, 1) * most:.3g}"])


def drawn_scene(number):
    """Returns a random scene: one to three layers, faces and ports anywhere, and a lit port apart from them."""
    dice = random.Random(number)

    def index():
        return dice.choice([1, 1.2, 1.33, 1.4, 1.46, 1.5, 1.8])

    def place():
        return f"at={dice.uniform(-0.3, 0.3):.3g},{dice.uniform(-0.3, 0.3):.3g}"

    def law():
        return dice.choice([f"{dice.random():.2f}", f"{dice.random():.2f} lambertian", f"metal {dice.uniform(0.1, 3):.2f} {dice.uniform(0, 5):.2f}"])

    layers = [f"{index()} {dice.choice([0.2, 2])} {dice.choice([2, 20])} {dice.choice([-0.4, 0, 0.8])} {dice.choice([0.05, 0.2, 0.6])}" for _ in range(dice.randint(1, 3))]
    if len(layers) > 1 and dice.random() < 0.3:
        layers[0] = "1 0 0 0 0.05"  # of a higher index, it could trap light of a lambertian face
    top = [f"face {law()}"] if dice.random() < 0.5 else []
    for i in range(dice.randint(1, 6)):
        top.append(f"port {drawn_shape(dice, 0.4)} n={index()} {place()} name=p{i}" if dice.random() < 0.6 else f"face {drawn_shape(dice, 0.4)} {law()} {place()}")
    top.append(f"port {drawn_shape(dice, 0.3)} n={1.4} at=0.05,0.02 name=lit")
    light = dice.choice(["light=na:0.5", "light=na:1.3", "light=lambertian", "", "angle=35 azimuth=250", "angle=20 azimuth=70 light=na:0.6"])
    beams = [f"port lit {light}"] + [f"disk 0.3 {place()} z=0.02 light=isotropic share=0.5"] * (dice.random() < 0.3)
    detectors = [f"port {name} {dice.choice(['', 'diffuse', 'na=0.6', 'na=0.9 angle=40 azimuth=100'])}" for name in port_numbers(top)]
    detectors += [f"{drawn_shape(dice, 0.5)} {place()} {dice.choice(['', 'na=1', 'z=-0.2', 'z=-0.1 na=0.8 angle=30'])}"]
    return Scene(f"lot {number}", top, layers, beams, detectors, n=(index(), index()), backing=dice.choice(["", "", law()]), map="1 0 0 0 0.05" not in layers)


oracle.judge("a probe in contact", written_scenes(), drawn_scene, 400000, by_program, by_oracle, ("trapped",))
