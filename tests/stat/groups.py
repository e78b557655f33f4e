"""Tests groups of detectors: sums of what several detectors see (P13).

- Exact: the sum and its gates are those of the members in units of weight, with either engine, in the rows of a sweep that
  share a flight, and where one packet comes to two members. A mean is the mean of the members' means by light, and a derivative
  the sum of their derivatives.
- Errors: two members at one place see the same packets, so the error of their sum is twice that of one, and 1.4 times what a
  sum in quadrature gives. The spread of 100 seeds must agree with it.
- Aims: plain flights and flights with --aim at a group agree, in a scene with symmetry about the beam, beside a body, and at
  fibres in a steel face, with apertures and without. The errors of a packet must be as much smaller as the aim is for.
Statistic: z, level 1e-4 over all; 100 values give their spread to 7 %, which is held to 25 %."""
import csv
import math
import os
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

SKIN = "1.4 0.5 100 0.8 0.4"
UNIT = 2.0**31  # units of weight of a packet


def six(radius, size, x=0.0):
    """Returns the lines of six fibres on a circle about (x, 0)."""
    places = [(x + radius * math.cos(k * math.pi / 3), radius * math.sin(k * math.pi / 3)) for k in range(6)]
    return [f"detector disk {size} at={at[0]:.9f},{at[1]:.9f} name=f{k} group=six" for k, at in enumerate(places)]


def members(found, end=""):
    """Returns the sums over the members f0, f1 ... of an array, cell by cell."""
    return [math.fsum(cells) for cells in zip(*(values for name, values in found.items() if name in {f"detector_f{k}{end}" for k in range(6)}))]


def whole(values, scale):
    """Returns values in whole units of weight. A value that is none gives NaN."""
    units = [value * scale for value in values]
    return [round(unit) if abs(unit - round(unit)) < 0.1 else math.nan for unit in units]


def sums(verdict, engine, photons):
    """Compares a group of overlapping fibres with its members."""
    lines = ["time 200 4", "detector disk 0.096 name=around", *six(0.05, 0.045)]
    with tempfile.TemporaryDirectory() as folder:
        record = cml.run(cml.mci([SKIN], photons=photons, extra=lines), "--engine", engine, keep=folder)[0]
        found = cml.read_sections(record["output"])
    seen = whole(found["detector_six"], photons * UNIT)
    verdict.check(engine, seen == whole(members(found), photons * UNIT) and seen[0] > 0, f"{seen} is not the sum of the members")
    gates = whole(found["detector_six_t"], photons * UNIT * 50)
    verdict.check(f"{engine}, gates", gates == whole(members(found, "_t"), photons * UNIT * 50) and sum(gates) > 0, str(gates))
    verdict.check(engine, found["detector_around"][0] < found["detector_six"][0], "light that comes to two members counts once")
    light = [found[f"detector_f{k}"][0] for k in range(6)]
    for mean, at in (("path", 1), ("interactions", 1), ("momentum", 1), ("deepest", 0)):
        expected = math.fsum(w * found[f"detector_f{k}_{mean}"][at] for k, w in enumerate(light)) / math.fsum(light)
        value = found[f"detector_six_{mean}"][at]
        verdict.check(f"{engine}, {mean}", abs(value - expected) < 1e-9 * expected, f"{value}, of the members {expected}")


def rows(verdict):
    """Compares groups in the rows of a sweep that share a flight, and in derivatives."""
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "t.csv"), "w", encoding="utf-8") as file:
            file.write("layer1.mua\n0.5\n1\n2\n")
        text = cml.mci([SKIN], photons=20000, extra=six(0.05, 0.04))
        path = os.path.join(folder, "scene.mci")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        subprocess.run([cml.PROGRAM, "run", path, "--sweep", os.path.join(folder, "t.csv"), "--reweight", "--quiet", "-o", folder], check=True)
        with open(os.path.join(folder, "out.sweep.csv"), encoding="utf-8") as file:
            table = list(csv.DictReader(file))
        for row in table:
            value, expected = float(row["detector_six"]), math.fsum(float(row[f"detector_f{k}"]) for k in range(6))
            verdict.check(f"row {row['layer1.mua']}", 0 < value and abs(value - expected) < 1e-12, f"{value}, of the members {expected}")
        record = cml.run(text, "--derivatives", keep=folder)[0]
        found = cml.read_sections(record["output"])
    for by in ("mua", "mus"):
        value, expected = found[f"detector_six_d{by}"][0], members(found, f"_d{by}")[0]
        verdict.check(f"derivative by {by}", value != 0 and abs(value - expected) < 1e-9 * abs(expected), f"{value}, of the members {expected}")


def errors(verdict, seeds):
    """Compares the errors of a group with the spread of many seeds."""
    lines = ["detector disk 0.3 at=0.1,0 name=a group=twice", "detector disk 0.3 at=0.1,0 name=b group=twice"]
    text = cml.mci([SKIN], photons=2000, extra=lines)
    records = [cml.run(text, "--seed", seed, "--sampling", "random", "--quiet")[0] for seed in range(1, seeds + 1)]
    spread = statistics.stdev(record["detector_twice"] for record in records)
    error = math.sqrt(statistics.fmean(record["detector_twice_se"]**2 for record in records))
    verdict.check("errors", abs(error / spread - 1) < 0.25, f"{error} for a spread of {spread}")
    for record in records:
        verdict.check("errors of one", abs(record["detector_twice_se"] / record["detector_a_se"] - 2) < 1e-9, str(record))


def probe(radius, size, aperture):
    """Returns the lines on top and those of light and detectors: a fibre in steel with six others on a circle around it."""
    places = [(0, 0)] + [(radius * math.cos(k * math.pi / 3), radius * math.sin(k * math.pi / 3)) for k in range(6)]
    top = ["face disk 0.5 0.5"] + [f"port disk {size} n=1.46 at={x:.9f},{y:.9f}" for x, y in places]
    return {0: "\n".join(top)}, ["beam port 1"] + [f"detector port {k + 2} {aperture} name=f{k} group=six" for k in range(6)]


def aims(verdict, name, lines, least, body="", top=None):
    """Compares a flight with --aim at a group with a plain one. least: the gain in variance of a packet that is expected."""
    plain = cml.run(cml.mci([SKIN + body], photons=400000, extra=lines, surfaces=top), "--sampling", "random")[0]
    aimed = cml.run(cml.mci([SKIN + body], photons=20000, extra=lines, surfaces=top), "--sampling", "random", "--aim", "six")[0]
    verdict.z(name, aimed["detector_six"], aimed["detector_six_se"], plain["detector_six"], plain["detector_six_se"])
    gain = plain["detector_six_se"]**2 * plain["photons"] / (aimed["detector_six_se"]**2 * aimed["photons"])
    verdict.check(name, gain > least, f"the variance of a packet is {gain:.3g} times smaller, expected {least}")
    members_of_aim = math.fsum(aimed[f"detector_f{k}"] for k in range(6))
    verdict.check(name, abs(members_of_aim - aimed["detector_six"]) < 1e-12, "the aimed sum is not that of the members")
    print(f"  {name}: plain {plain['detector_six']:.4g} +- {plain['detector_six_se']:.2g}, aimed {aimed['detector_six']:.4g} +- "
          f"{aimed['detector_six_se']:.2g}, variance of a packet / {gain:.3g}")


def main():
    verdict = cml.Verdict("groups")
    sums(verdict, "cpu", 20000)
    sums(verdict, "reference", 5000)
    rows(verdict)
    errors(verdict, 100)
    aims(verdict, "aim in symmetry", six(0.3, 0.005), 20)
    aims(verdict, "aim beside a body", six(0.02, 0.008, 0.25), 5, "\ni sphere 0.1 0 0.2 0.05 1.5 5 100 0.8")
    for aperture, least in (("", 5), ("na=0.5", 10)):
        top, lines = probe(0.25, 0.01, aperture)
        aims(verdict, f"aim under a face, {aperture or 'no aperture'}", lines, least, top=top)
    verdict.finish()


if __name__ == "__main__":
    main()
