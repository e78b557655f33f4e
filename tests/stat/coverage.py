"""Tests that standard errors from batches are true, although packets of a batch depend on each other (--sampling lattice).

Counts how often 400 independent runs (with ALL_CASES: 800) lie within 1 and 2 of their own errors from the expected value.
Scenes are a thin slab and a hill, at 1000 photons (15 or 16 in a batch) and at 12345. Counted are totals, and every bin of
Rd_r, Rd_a, Tt_r, Tt_a, A_z with 300 packets or more in a run: with few packets per batch the spread is skewed and itself
uncertain. Shares must be 68 +- 9.9 % and 95 +- 5.7 % (of 800 runs: 7 and 4 %), which are 4.2 and 5.2 deviations, per number.
Errors that are 1.3 times too large or small exceed these bounds. The expected values are the means over all runs, 20 times
sharper than one run. The means of the totals must agree with adding-doubling, or with random sampling for the hill, by
Sidak's limit.

Lights and shapes over a thin slab: 100 runs of 2048 photons, 32 in a batch, and 40 of 32768 (with ALL_CASES: 131072). The
spread of the runs relative to their own errors is the root of the mean over all bins of 10 packets or more. It must be 0.9 to
1.1 for profiles, whose errors come from 64 batches, and for directions, whose errors come from 16 groups. Bins depend on each
other, so the noise of the ratio comes from leaving out one run after the other; 3 times the noise is allowed beyond the
bounds. Errors from squares per packet were up to 3 times too large. A lattice that put points of a launch side by side made
errors 2 times too small."""
import os
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import slabs  # noqa: E402

RUNS, PACKETS = 800 if "ALL_CASES" in os.environ else 400, 300
WIDER = (800 / RUNS) ** 0.5
SCRATCH = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # a folder in memory: the runs write many files and wait for the disk after each
TOTALS, PROFILES = ["Rd", "A", "Tt"], ["A_z", "Rd_r", "Rd_a", "Tt_r", "Tt_a"]
THIN = {"layers": ["1.34 0.1 1 0.5 0.1"], "grid": "0.01 0.02", "bins": "10 10 8"}
HILL = {"layers": ["1.3 1 1 0 1"], "grid": "0.1 0.1", "bins": "10 10 8",
        "surfaces": {b: "b 4 0.1 0.1 0.08 0.2 -0.02 0.2 -0.1 0.1" for b in (0, 1)}}
LIGHTS = {"isotropic": "pencil z=0.25 light=isotropic", "lambertian": "pencil z=0.1 light=lambertian",
          "aperture": "gaussian 0.1 light=na:0.8", "rectangle": "rectangle 0.3 0.2 z=0.25 angle=30 light=isotropic", "disk": "disk 0.2",
          "pencil": "pencil"}
CLEAR = {"layers": ["1.4 0.5 1 0.8 0.5"], "grid": "0.1 0.1", "bins": "5 5 3"}
LIT = ((2048, 100), (cml.repeats(131072), 40))  # (photons, runs) under other lights and shapes
LIT_PACKETS, NOISES, KINDS = 10, 3, {"profiles": PROFILES, "directions": ["Rd_dir", "Tt_dir"]}


DIRECTIONS = [key + error for key in KINDS["directions"] for error in ("", "_se")]  # a file has thirty arrays more


def fly(scene, photons, runs, *options):
    """Returns the records of `runs` runs, with the sections of their files."""
    with tempfile.TemporaryDirectory(dir=SCRATCH) as keep:
        text = cml.repeated(runs, photons=photons, **scene)
        records = cml.run(text, "--seed", 41, "--threads", 1, *options, keep=keep)
        for record in records:
            record.update(cml.read_sections(record["output"], DIRECTIONS))
    return records


def numbers(records):
    """Returns (name, values, errors) of every total and bin."""
    for key in TOTALS:
        yield key, [record[key] for record in records], [record[key + "_se"] for record in records]
    for key in PROFILES:
        for i in range(len(records[0][key])):
            yield f"{key}[{i}]", [record[key][i] for record in records], [record["se_" + key][i] for record in records]


def check(verdict, name, records, least):
    shares = []
    for key, values, errors in numbers(records):
        mean, variance = statistics.fmean(values), statistics.variance(values)
        if mean**2 <= PACKETS * variance:  # (mean / error)^2 is about the number of packets
            continue
        within = [sum(abs(v - mean) <= k * e for v, e in zip(values, errors)) / RUNS for k in (1, 2)]
        shares.append(within)
        verdict.check(f"{name} {key}", abs(within[0] - 0.68) <= 0.07 * WIDER and abs(within[1] - 0.95) <= 0.04 * WIDER, f"{within}")
    for k, column in enumerate(zip(*shares), 1):
        print(f"{name}: {len(column)} numbers, {100 * statistics.fmean(column):.1f} % within {k} "
              f"({100 * min(column):.1f} to {100 * max(column):.1f})")
    verdict.check(name, len(shares) >= least, f"only {len(shares)} totals and bins have enough packets")


def check_means(verdict, name, records, truth):
    """Checks the means of totals. truth: {total: (value, error)}."""
    for key, (expected, uncertain) in truth.items():
        values = [record[key] for record in records]
        verdict.z(f"{name} {key}", statistics.fmean(values), statistics.stdev(values) / RUNS**0.5, expected, uncertain)


def spread_over_error(records, keys):
    """Returns (number of bins with enough packets, root of the mean of variance over squared error, noise of that root)."""
    bins = []
    for key in keys:
        for column in zip(zip(*(record[key] for record in records)), zip(*(record["se_" + key] for record in records))):
            stated = statistics.fmean(error * error for error in column[1])
            if statistics.fmean(column[0])**2 > LIT_PACKETS * stated > 0:
                bins.append(column)

    runs = len(records)
    means = [statistics.fmean(values) for values, _ in bins]
    off = [[value - mean for value in values] for (values, _), mean in zip(bins, means)]
    sums = [(sum(values), sum(value * value for value in values), sum(error * error for error in errors)) for values, (_, errors) in zip(off, bins)]

    def ratio(without=None):
        """Takes one run out of the sums of all runs, because sums anew for each run left out would take most of the test's time."""
        kept, squared = runs - (without is not None), 0.0
        for values, (_, errors), (total, squares, stated) in zip(off, bins, sums):
            if without is not None:
                value, error = values[without], errors[without]
                total, squares, stated = total - value, squares - value * value, stated - error * error
            squared += (squares - total * total / kept) / (kept - 1) / (stated / kept)
        return (squared / len(bins))**0.5
    return len(bins), ratio(), statistics.pstdev(map(ratio, range(runs))) * (runs - 1)**0.5


def check_light(verdict, name, beam):
    for photons, runs in LIT:
        records = fly({**CLEAR, "extra": ["beam " + beam, "directions 6 12"]}, photons, runs)
        for kind, keys in KINDS.items():
            bins, ratio, noise = spread_over_error(records, keys)
            told = f"{bins} bins, spread over error {ratio:.3f} +- {noise:.3f}"
            print(f"{name}, {photons} photons, {kind}: {told}")
            verdict.check(f"{name}, {photons} photons, {kind}",
                          bins > 0 and noise < 0.1 and 0.9 - NOISES * noise <= ratio <= 1.1 + NOISES * noise, told)


def exact(layers, specular):
    ur1, ut1 = next((ur1, ut1) for _, stack, ur1, ut1, outside in slabs.rows() if stack == layers and outside == 1)
    return {"Rd": (ur1 - specular, 1e-6), "A": (1 - ur1 - ut1, 1e-6), "Tt": (ut1, 1e-6)}


def main():
    verdict = cml.Verdict("coverage")
    random = fly(HILL, 2000000, 1, "--sampling", "random")[0]
    for name, scene, least in (("thin", THIN, (3, 20)), ("hill", HILL, (9, 25))):
        for photons, fewest in zip((1000, 12345), least):
            records = fly(scene, photons, RUNS)
            truth = exact(scene["layers"], records[0]["Rsp"]) if scene is THIN else \
                {key: (random[key], random[key + "_se"]) for key in TOTALS}
            check(verdict, f"{name}, {photons} photons", records, fewest)
            check_means(verdict, f"{name}, {photons} photons", records, truth)
    for name, beam in LIGHTS.items():
        check_light(verdict, name, beam)
    verdict.finish()


main()
