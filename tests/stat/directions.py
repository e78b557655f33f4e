"""Tests the directions of light that leaves (P7) against directions that are known without flights.

- A clear slab under slanted light: all of Rsp, Rd and Tt is in the bin of the beam's own angle and azimuth, and nothing
  elsewhere.
- A cone under vertical light: mirrored light leaves at twice the cone's slope, evenly by azimuth.
- A turbid slab: sums over azimuths are Rd_a and Tt_a of the same packets, and sums over all bins the totals. Light that is
  split off goes straight up. A bin lies within one of its errors of the mean over other runs in 66.7 % of cases (Student's t
  of 16 groups; random draws).
Statistic: z, level 1e-4 over all."""
import math
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

NT, NP, RUNS, PHOTONS = 9, 12, 30, 10000
WIDTH = math.pi / 2 / NT
SR = [(math.cos(i * WIDTH) - math.cos((i + 1) * WIDTH)) * 2 * math.pi / NP for i in range(NT)]
LINE = f"directions {NT} {NP}"


def sections_of(text, *options):
    with tempfile.TemporaryDirectory() as keep:
        return [(record, cml.read_sections(record["output"])) for record in cml.run(text, *options, keep=keep)]


def shares(found, key):
    return [value * SR[i // NP] for i, value in enumerate(found[key + "_dir"])]


def mirrors(verdict):
    for azimuth in (70, 160, 250, 340):
        text = cml.mci(["1.5 0 0 0 0.6"], photons=20000, extra=[f"beam pencil angle=42 azimuth={azimuth}", LINE])
        record, found = sections_of(text)[0]
        cml.check_balance(verdict, "mirrors", record)
        for key in ("Rsp", "Rd", "Tt"):
            only = [i for i, share in enumerate(shares(found, key)) if share > 0]
            verdict.check(f"mirrors {key}", only == [4 * NP + azimuth // 30], f"light in bins {only} at azimuth {azimuth}")


def cone(verdict):
    """Tests a cone of slope 0.2, which mirrors light to 22.6 degrees."""
    text = cml.mci(["1.5 0 0 0 1"], photons=200000, extra=["beam disk 0.5", LINE], surfaces={0: "b 2  0.2 1  0 1"}, n_below=1.5)
    found = sections_of(text, "--sampling", "random")[0][1]
    for i, share in enumerate(shares(found, "Rsp")):
        if i // NP == 2:
            verdict.z(f"cone, azimuth {i % NP}", share, found["se_Rsp_dir"][i] * SR[2], sum(shares(found, "Rsp")) / NP)
        else:
            verdict.check("cone", share == 0, f"{share} in bin {i}")


def slab(verdict):
    text = cml.repeated(RUNS, ["1.4 1 50 0.8 0.1"], photons=PHOTONS, extra=[LINE], bins=f"10 10 {NT}")
    runs = sections_of(text, "--sampling", "random")
    for record, found in runs:
        cml.check_balance(verdict, "slab", record)
        verdict.check("slab, split off", abs(shares(found, "Rsp")[0] - record["Rsp"]) < 1e-8, "not straight up")
        for key in ("Rd", "Tt"):
            part = shares(found, key)
            verdict.check(f"slab {key}", abs(sum(part) - record[key]) < 1e-7, f"sums to {sum(part)}, not {record[key]}")
            for i in range(NT):
                by_angle = found[key + "_a"][i] * 2 * math.pi * math.sin((i + 0.5) * WIDTH) * WIDTH
                verdict.check(f"slab {key}_a[{i}]", abs(sum(part[i * NP:][:NP]) - by_angle) < 1e-4 * by_angle + 1e-9,
                              f"{sum(part[i * NP:][:NP])}, not {by_angle}")
    coverage(verdict, [found for _, found in runs])


def coverage(verdict, runs):
    within = tried = 0
    for key in ("Rd_dir", "Tt_dir"):
        for i in range(2 * NP, 8 * NP):
            values = [found[key][i] for found in runs]
            for k, found in enumerate(runs):
                others = (sum(values) - values[k]) / (len(values) - 1)
                within += abs(values[k] - others) < found["se_" + key][i] * math.sqrt(1 + 1 / (len(values) - 1))
                tried += 1
    verdict.check("errors", abs(within / tried - 0.667) < 0.03, f"{within} of {tried} within one error")
    print(f"errors of directions: {within / tried:.3f} of {tried} within one")


def main():
    verdict = cml.Verdict("directions")
    mirrors(verdict)
    cone(verdict)
    slab(verdict)
    verdict.finish()


main()
