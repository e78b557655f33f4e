"""Tests faces and ports on boundary 0 by laws that hold for any probe.

- A port of n above changes nothing: all sums are the same. A port over everything is n above of its index.
- A face over all of boundary 0, with light from inside, is a backing of the scene turned over.
- Weight in integers: what leaves through all ports and the open plane is Rsp + Rd; a disk detector on its port sees what the
  port does; a white face over a clear layer keeps nothing.
- Reciprocity: N1^2 A1 P(1 to 2) = N2^2 A2 P(2 to 1) for lambertian light between two ports, beside each law of a face.
- Options: light aimed at a port, at Tt or at a layer has the means of a flight without aim; a row by reweighting has those of
  its own flight.
- Evenness: stripes of two indices in a white face, with light by N^2 times their width, are a furnace. The mean path in the
  layer is 4 n^2 d p / sum(N^2 w), p being the period and w the widths of the stripes; the mean number of interactions is mus
  times this path. Lit stripes are short ports on top of long ones.
N: 1e5 packets a run (4e4 for evenness, in 40 runs); statistic: z, level 1e-4 over all; the spread of 40 runs has 39 degrees of
freedom."""
import math
import os
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

PHOTONS = cml.repeats(400000)
SLAB = "1.4 0.5 20 0.8 0.5"
LAWS = {"mirror": "0.7", "lambertian": "0.8 lambertian", "metal": "metal 0.18 3.43"}
LISTS = ("Rd_r", "Rd_a", "Tt_r", "Tt_a", "A_z", "A_l")


def text_of(layers, top=(), lines=(), n=(1, 1), backing="", photons=PHOTONS, runs=1):
    """Returns the text of an .mci file: a scene `runs` times."""
    text = ["1.0", f"{runs}"]
    for i in range(runs):
        text += [f"face{i}.mco A", f"{photons}", *lines, "0.05 0.05", "10 10 6", f"{len(layers)}", f"{n[0]}", *top, *layers]
        text += [f"backing {backing}"] * bool(backing) + [f"{n[1]}"]
    return "\n".join(text) + "\n"


def fly(verdict, name, *words, seed=1, **more):
    """Returns the record of a run and the sections of its file."""
    with tempfile.TemporaryDirectory() as folder:
        record, = cml.run(text_of(*words, **more), "--seed", seed, keep=folder)
        cml.check_balance(verdict, name, record)
        return record, cml.read_sections(record["output"])


def units(record, name):
    """Returns a number of a record in the integers in which weight is summed."""
    return round(record[name] * record["photons"] * 2**31)


def same(verdict, name, a, b):
    """Checks that two runs have the same sums, to the last digit."""
    for key in ("Rsp", "Rd", "A", "Tt"):
        verdict.check(f"{name}: {key}", a[0][key] == b[0][key], f"{a[0][key]!r}, not {b[0][key]!r}")
    for key in LISTS:
        verdict.check(f"{name}: {key}", a[1][key] == b[1][key])


def nothing_new(verdict):
    beams = ["beam disk 0.1 at=0.1,0 light=na:0.3", "beam pencil z=0.1 light=isotropic share=0.5"]
    everywhere = "port rectangle 100 100 n="
    plain = fly(verdict, "no port", [SLAB], lines=beams, n=(1.33, 1))
    for name, top in (("holes", ["port disk 0.2 n=1.33", "port ring 0.3 0.5 n=1.33 at=0.1,0"]), ("hole everywhere", [everywhere + "1.33"]), ("hole in a face", ["face disk 0.4 0.5", everywhere + "1.33"])):
        same(verdict, name, fly(verdict, name, [SLAB], top, beams, n=(1.33, 1)), plain)
    other = fly(verdict, "n above", [SLAB], lines=beams[1:], n=(1.5, 1))
    same(verdict, "port everywhere", fly(verdict, "port everywhere", [SLAB], [everywhere + "1.5"], beams[1:], n=(1, 1)), other)
    lit = fly(verdict, "lit port", [SLAB], [everywhere + "1.33", "port disk 0.1 n=1.33 at=0.1,0"], ["beam port 2 light=na:0.3", beams[1]], seed=2)
    between(verdict, "lit port", lit, plain, dict(zip(LISTS, LISTS)) | {key: key for key in ("Rsp", "Rd", "A", "Tt")})


def between(verdict, name, a, b, pairs):
    """Compares two runs. pairs: names of totals or lists in a and b; a - before the name in b: this list from its end."""
    for mine, other in pairs.items():
        if mine in a[0] and mine not in LISTS:
            verdict.z(f"{name}: {mine}", a[0][mine], a[0][mine + "_se"], b[0][other], b[0][other + "_se"])
            continue
        columns = [a[1][mine], a[1]["se_" + mine], b[1][other.lstrip("-")], b[1]["se_" + other.lstrip("-")]]
        if other.startswith("-"):
            columns = columns[:2] + [column[::-1] for column in columns[2:]]
        for i, row in enumerate(zip(*columns)):
            verdict.z(f"{name}: {mine} {i}", *row)


def turned_over(verdict, name, law):
    """A face over everything, against the backing of the same scene upside down."""
    layers, light = [SLAB, "1.5 1 10 0 0.2"], "light=isotropic"
    faced = fly(verdict, name, layers, [f"face {law}"], [f"beam disk 0.1 z=0.3 {light}"], n=(1, 1.33), seed=3)
    backed = fly(verdict, name, layers[::-1], (), [f"beam disk 0.1 z=0.4 {light}"], n=(1.33, 1), backing=law, seed=4)
    verdict.check(f"{name}: nothing leaves through a face", faced[0]["Rsp"] == faced[0]["Rd"] == 0)
    between(verdict, name, faced, backed, {"A_face": "A_backing", "Tt": "Rd", "A": "A", "Tt_r": "Rd_r", "Tt_a": "Rd_a", "A_l": "-A_l"})


def integers(verdict):
    top = ["face disk 0.45 0.5 lambertian", "port disk 0.12 n=1.44 at=-0.1,0 name=cladding", "port disk 0.1 n=1.46 at=-0.1,0 name=core",
           "port ring 0.1 0.15 n=1.3 at=0.25,0 name=ring", "port rectangle 0.1 0.1 n=1 at=0,0.3 name=slit"]
    parts = ["port cladding", "port core", "port ring", "port slit", "ring 0.45 1000"]
    twins = {"port core na=0.3": "disk 0.1 at=-0.1,0 na=0.3", "port core": "disk 0.1 at=-0.1,0", "port ring": "ring 0.1 0.15 at=0.25,0", "port slit": "rectangle 0.1 0.1 at=0,0.3"}
    words = sorted({*parts, *twins, *twins.values(), "port core diffuse"})
    record, _ = fly(verdict, "integers", [SLAB], top, ["beam port core light=na:0.5", *(f"detector {word} name=d{i}" for i, word in enumerate(words))], n=(1.2, 1))
    seen = {word: units(record, f"detector_d{i}") for i, word in enumerate(words)}
    specular, all_up = units(record, "Rsp"), units(record, "Rsp") + units(record, "Rd")
    verdict.check("all ports and the open plane", sum(seen[part] for part in parts) == all_up, f"{seen} {all_up}")
    for port, shape in twins.items():
        verdict.check(f"{shape} on its port", seen[port] == seen[shape] > 0, f"{seen}")
    verdict.check("light that never was inside", seen["port core"] - seen["port core diffuse"] == specular > 0, f"{seen} {specular}")
    white, _ = fly(verdict, "white face", ["1.4 0 20 0.8 0.5"], ["face 1", "port disk 0.1 n=1.5"], ["beam port 1"])
    verdict.check("a white face", white["A"] == white["A_face"] == 0)


def reciprocity(verdict, law):
    """Light from port a to port b, and back."""
    one, two = (1.46, math.pi * 0.15**2), (1.2, 0.3 * 0.2)
    top = [f"face disk 0.6 {LAWS[law]}", "port disk 0.15 n=1.46 at=-0.15,0 name=a", "port rectangle 0.3 0.2 n=1.2 at=0.2,0.05 name=b"]
    found = []
    for lit, seen, (n, area) in (("a", "b", one), ("b", "a", two)):
        record, _ = fly(verdict, law, ["1.33 0.2 10 0.5 0.3", "1.5 1 40 0.8 0.2"], top, [f"beam port {lit} light=lambertian", f"detector port {seen} name=other"], seed=5 + len(found))
        found += [n * n * area * record["detector_other"], n * n * area * record["detector_other_se"]]
    verdict.z(f"{law}: there and back", *found)


def options(verdict):
    """Means of flights with --aim and --reweight, against plain flights of another seed."""
    top = ["face disk 0.5 0.6", "port disk 0.05 n=1.46 name=in", "port disk 0.1 n=1.3 at=0.3,0 name=out"]
    lines = ["beam port in light=na:0.3", "detector port out na=0.6 name=out"]
    layers, names = ["1.4 0.5 20 0.8 0.2", "1.5 1 10 0 0.5"], ("Rd", "A", "A_face", "Tt", "detector_out")
    plain, _ = fly(verdict, "plain", layers, top, lines, seed=11)
    with tempfile.TemporaryDirectory() as folder:
        rows = os.path.join(folder, "rows.csv")
        with open(rows, "w", encoding="ascii") as file:
            file.write("layer1.mua, layer2.mua\n0.1, 1\n0.5, 1\n3, 0.2\n")
        records = {f"--aim {what}": cml.run(text_of(layers, top, lines), "--seed", 12, "--aim", what, keep=folder)[0] for what in ("out", "Tt", "A_l:2")}
        records["a row"] = cml.run(text_of(layers, top, lines), "--seed", 13, "--sweep", rows, "--reweight", keep=folder)[1]
    for name, record in records.items():
        for key in names:
            verdict.z(f"{name}: {key}", record[key], record[key + "_se"], plain[key], plain[key + "_se"])


def evenness(verdict):
    """Stripes of n 2 and 1.2 with white faces between them, 0.5 cm apart, over a scattering layer on a white ground."""
    runs, period, widths = 40, 0.5, {2.0: 0.15, 1.2: 0.2}
    top = ["face 1"]
    for k in range(-16, 17):
        top += [f"port rectangle {w} 40 n={n} at={k * period + 0.2 * (n == 1.2)},0" for n, w in widths.items()]
    top += [f"port rectangle {w} 1 n={n} at={0.2 * (n == 1.2)},0 name=lit{k}" for k, (n, w) in enumerate(widths.items())]
    lines = [f"beam port lit{k} light=lambertian share={n * n * w}" for k, (n, w) in enumerate(widths.items())]
    layers = [(1.4, 10, 0.2), (1.6, 0, 0.05), (1.3, 30, 0.1)]
    text = text_of([f"{n} 0 {mus} 0 {d}" for n, mus, d in layers], top, lines, backing="1 lambertian", photons=PHOTONS // 40, runs=runs)
    records = cml.run(text, "--seed", 9)
    for record in records:
        cml.check_balance(verdict, "evenness", record)
        verdict.check("evenness", record["A_face"] == record["trapped"] == 0)
    counts = [(record["steps"] - record["crossings"]) / record["photons"] for record in records]
    law = sum(4 * n * n * mus * d for n, mus, d in layers) * period / sum(n * n * w for n, w in widths.items())
    verdict.z("evenness: interactions", statistics.fmean(counts), statistics.stdev(counts) / math.sqrt(runs), law)


def main():
    verdict = cml.Verdict("faces and ports")
    nothing_new(verdict)
    for name, law in LAWS.items():
        turned_over(verdict, name, law)
        reciprocity(verdict, name)
    integers(verdict)
    options(verdict)
    evenness(verdict)
    verdict.finish()


main()
