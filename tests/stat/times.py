"""Tests the times at which light leaves and is absorbed (P11), against times that are known without flights.

- A clear slab under slanted light: light reflected to and fro k times leaves after 2 k + 1, or 2 k, times n d / (c cos), and
  no light is outside those gates. Also a glass on a scatterer, through which packets come without an event.
- A turbid slab of two layers, and of one: gates times exp(-x c t / n), summed, are Rd and Tt with x more absorption in all
  layers. The same sum over a layer's absorption gives A mua / (mua + x) of that layer. Truth: adding-doubling, at 8 values of
  x. The slope at 0 is the mean time. Within a gate the light counts as that of its middle, which is off by 0.05 ps at most.
  The error is below x c w / (2 n) = 0.4 % of light that is not spread at all, some percent of Tt.
- One layer absorbs in a gate mua c / n times the light that is still inside; gates of layers and bodies sum to their
  absorption.
- The same light in a scene with a mesh, a heightfield's cones and a body of equal index: no gate differs from planes by more
  than chance.
N = 20 runs of 1e4; statistic: z from the spread of the runs (19 degrees of freedom), level 1e-4 over all."""
import json
import math
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

C = 0.0299792458  # speed of light, cm/ps
RUNS, PHOTONS = 20, 10000
END, GATES = 400, 8000
EXTRA = 0.05, 0.1, 0.2, 0.5, 1, 2, 4, 8  # more absorption, 1/cm


def sections_of(text, *options):
    with tempfile.TemporaryDirectory() as keep:
        records = cml.run(text, *options, keep=keep)
        return [(record, cml.read_sections(record["output"])) for record in records]


def exact(layers):
    with tempfile.TemporaryDirectory() as keep:
        path = os.path.join(keep, "scene.mci")
        with open(path, "w", encoding="utf-8") as file:
            file.write(cml.mci(layers))
        done = subprocess.run([cml.PROGRAM, "exact", path, "--json", "--tolerance", "1e-8"], capture_output=True, text=True, check=True)
        return json.loads(done.stdout)


def clear_slab(verdict):
    """Tests a clear slab: n = 1.5, d = 0.6 cm, light at 40 degrees; gates of 1 ps."""
    n, d, angle = 1.5, 0.6, math.radians(40)
    sine = math.sin(angle) / n
    once = n * d / math.sqrt(1 - sine * sine) / C
    cosine = math.sqrt(1 - sine * sine)
    rs = ((math.cos(angle) - n * cosine) / (math.cos(angle) + n * cosine)) ** 2
    rp = ((cosine - n * math.cos(angle)) / (cosine + n * math.cos(angle))) ** 2
    r = (rs + rp) / 2
    text = cml.mci([f"{n} 0 0 0 {d}"], photons=200000, extra=["beam pencil angle=40", "time 250 250"])
    record, found = sections_of(text)[0]
    cml.check_balance(verdict, "clear slab", record)
    for name, first in (("Tt_t", 1), ("Rd_t", 2)):
        share = {}
        for k in range(first, 200, 2):
            gate = int(k * once)
            part = (1 - r) ** 2 * r ** (k - 1)
            share[gate if gate < 250 else "later"] = share.get(gate if gate < 250 else "later", 0) + part
        for gate, value in enumerate(found[name]):
            truth = share.get(gate, 0)
            error = math.sqrt(max(truth * (1 - truth), 1e-30) / record["photons"])
            if truth * record["photons"] > 100:
                verdict.z(f"clear slab {name}[{gate}]", value, error, truth)
            elif truth == 0:
                verdict.check(f"clear slab {name}[{gate}]", value == 0, f"{value} where no light is")


def behind_glass(verdict):
    """Tests clear glass on an absorber that is so thick that no scattered light matters: all of A is within the first mm."""
    found = sections_of(cml.mci(["1.5 0 0 0 1", "1.5 1e5 0 0 1"], extra=["time 100 100"], n_below=1.5))[0][1]
    gate = int(1.5 * 1 / C)
    verdict.check("glass", abs(found["A_t"][gate] - sum(found["A_t"])) < 1e-9 and found["A_t"][gate] > 0.9, str(found["A_t"]))


def turbid(verdict, layers):
    """Tests turbid layers. layers: mua mus g d of each."""
    n, mua = 1.4, layers[0][0]

    def lines(extra):
        return [f"{n} {mine + extra} {mus} {g} {d}" for mine, mus, g, d in layers]

    runs = sections_of(cml.repeated(RUNS, lines(0), photons=PHOTONS, extra=[f"time {END} {GATES}"]))
    width = END / GATES
    shift = 1e-4
    low, high = exact(lines(-shift)), exact(lines(shift))
    for key in ("Rd", "Tt"):
        truth = -(high[key] - low[key]) / (2 * shift) * n / C
        check_mean(verdict, f"turbid mean time of {key}",
                   [sum((i + 0.5) * width * value * width for i, value in enumerate(found[key + "_t"])) for _, found in runs], truth)
    for x in EXTRA:
        darker = exact(lines(x))
        kernel = [math.exp(-x * C * (i + 0.5) * width / n) * width for i in range(GATES)]
        for key in ("Rd", "Tt", "A")[:2 if len(layers) > 1 else 3]:
            part = mua / (mua + x) if key == "A" else 1
            sums = [sum(map(float.__mul__, kernel, found[key + "_t"])) for _, found in runs]
            check_mean(verdict, f"turbid, {len(layers)}, {key} with mua + {x}", sums, darker[key] * part)
        for k, (mine, *_) in enumerate(layers):
            sums = [sum(map(float.__mul__, kernel, found["A_lt"][k * GATES:(k + 1) * GATES])) for _, found in runs]
            check_mean(verdict, f"turbid, {len(layers)}, A_lt of layer {k + 1} with mua + {x}", sums, darker["A_l"][k] * mine / (mine + x))
    for record, found in runs:
        cml.check_balance(verdict, "turbid", record)
        found.update(Rsp=record["Rsp"], A_l=record["A_l"])  # an .mco has these rounded
        for key in ("Rd", "Tt", "A"):
            total = sum(found[key + "_t"]) * width + found[key + "_t_later"][0]
            verdict.check(f"turbid {key}_t", abs(total - record[key]) < 1e-7, f"sums to {total}, not {record[key]}")
        by_medium(verdict, "turbid", found, GATES, width)
    decay(verdict, layers, [found for _, found in runs])


def by_medium(verdict, name, found, gates, width):
    """Checks that gates of layers and bodies sum to their absorption, and gates of media to A_t."""
    together = [0.0] * gates
    for key, of_time, media in (("A_l", "A_lt", len(found["A_l"])), ("A_body", "A_body_t", len(found.get("A_body", [])))):
        for k in range(media):
            times = found[of_time][k * gates:(k + 1) * gates]
            total = sum(times) * width + found[of_time + "_later"][k]
            verdict.check(f"{name} {of_time}", abs(total - found[key][k]) < 1e-12, f"sums to {total}, not {found[key][k]}")
            together = [a + b for a, b in zip(together, times)]
    off = max(abs(a - b) for a, b in zip(together, found["A_t"]))
    verdict.check(f"{name} A_lt", off < 1e-12, f"differs from A_t by {off}")


def decay(verdict, layers, runs):
    """Tests one layer: its absorption in a gate is mua c / n times the light that is inside then; twenty gates of the clock
    together. The light inside is taken at the middle of a gate, which is off by about (0.05 ps / 10 ps)^2 / 24 of it."""
    if len(layers) > 1:
        return
    rate, width, many = layers[0][0] * C / 1.4, END / GATES, 20
    for first in range(0, 1000, many):
        differences = []
        for found in runs:
            inside = 1 - found["Rsp"] - sum(sum(found[key][:first]) for key in ("Rd_t", "Tt_t", "A_t")) * width
            off = 0.0
            for gate in range(first, first + many):
                lost = sum(found[key][gate] for key in ("Rd_t", "Tt_t", "A_t")) * width
                off += found["A_lt"][gate] * width - rate * (inside - lost / 2) * width
                inside -= lost
            differences.append(off)
        check_mean(verdict, f"absorbed from {first * width} ps on, minus mua c / n times what is inside", differences, 0)


def check_mean(verdict, name, values, truth):
    mean = sum(values) / len(values)
    error = math.sqrt(sum((value - mean) ** 2 for value in values) / (len(values) - 1) / len(values))
    verdict.z(name, mean, error * 1.1, truth)  # 1.1: 19 degrees of freedom, at 4 errors


def errors(verdict, runs):
    """Tests how often a gate of a run, 5 ps, lies within one of its errors of the mean over the other runs."""
    within = tried = 0
    for key in ("Rd_t", "Tt_t", "A_t"):
        for gate in range(len(runs[0][key])):
            values = [found[key][gate] for found in runs]
            if sum(values) * 5 * PHOTONS < 300 * len(runs):
                continue
            for k, found in enumerate(runs):
                others = (sum(values) - values[k]) / (len(values) - 1)
                error = found["se_" + key][gate] * math.sqrt(1 + 1 / (len(values) - 1))
                within += abs(values[k] - others) < error
                tried += 1
    verdict.check("errors", tried > 200 and 0.61 < within / tried < 0.75, f"{within} of {tried} within one error")
    print(f"errors of gates: {within / tried:.3f} of {tried} within one")


def shapes(verdict):
    """Tests one scene whose surfaces are flown in other ways: all deviate from planes by chance only."""
    layers = ["1.4 0.5 50 0.8 0.1", "1.4 1 30 0.7 0.2"]
    extra = ["time 60 12"]
    body = ["1.4 0.5 50 0.8 0.1\ni sphere 0 0 0.05 0.03 1.4 0.5 50 0.8", layers[1]]
    flat = [found for _, found in sections_of(cml.repeated(RUNS, layers, photons=PHOTONS, extra=extra))]
    errors(verdict, flat)
    level = {0: "b 2  0 0.5  0 1", 1: "b 2  0 0.5  0 1"}
    others = {"cones": (layers, level, ("--boundaries", "cone")), "mesh": (layers, level, ("--boundaries", "mesh")), "body": (body, None, ())}
    for name, (media, surfaces, options) in others.items():
        text = cml.repeated(RUNS, media, photons=PHOTONS, extra=extra, surfaces=surfaces)
        flown = sections_of(text, "--seed", 7, *options)
        runs = [found for _, found in flown]
        by_medium(verdict, name, {**runs[0], "A_l": flown[0][0]["A_l"]}, 12, 5)
        for key in ("Rd_t", "Tt_t", "A_t"):
            for gate in range(12):
                a, b = [[found[key][gate] for found in which] for which in (flat, runs)]
                mean = [sum(x) / RUNS for x in (a, b)]
                error = [math.sqrt(sum((y - m) ** 2 for y in x) / (RUNS - 1) / RUNS) for x, m in zip((a, b), mean)]
                if min(mean) * PHOTONS * 5 > 300:
                    verdict.z(f"{name} {key}[{gate}]", mean[1], error[1] * 1.1, mean[0], error[0] * 1.1)


def main():
    verdict = cml.Verdict("times")
    clear_slab(verdict)
    behind_glass(verdict)
    turbid(verdict, ((0.2, 20, 0.5, 0.05), (0.4, 40, 0.8, 0.1)))
    turbid(verdict, ((0.5, 60, 0.7, 0.1),))
    shapes(verdict)
    verdict.finish()


main()
