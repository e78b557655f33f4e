"""Standard errors from batches tell the truth, though packets of a batch depend on each other (--sampling lattice).

How often 800 independent runs lie within 1 and 2 of their own errors from the expected value, for a thin slab and for a
hill, at 1000 photons (15 or 16 in a batch) and at 12345. Totals, and every bin of Rd_r, Rd_a, Tt_r, Tt_a, A_z, that get
300 packets or more in a run: with few packets per batch their spread is skewed and itself uncertain. Shares must be
68 +- 7 % and 95 +- 4 %: with 800 runs these are 4.2 and 5.2 deviations, per number. The expected values are the means over
all runs, 28 times sharper than one run; the means of the totals must agree with adding-doubling, for the hill with random
sampling, by Sidak's limit."""
import os
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import slabs  # noqa: E402

RUNS, PACKETS = 800, 300
SCRATCH = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # many files, each of them synced
TOTALS, PROFILES = ["Rd", "A", "Tt"], ["A_z", "Rd_r", "Rd_a", "Tt_r", "Tt_a"]
THIN = {"layers": ["1.34 0.1 1 0.5 0.1"], "grid": "0.01 0.02", "bins": "10 10 8"}
HILL = {"layers": ["1.3 1 1 0 1"], "grid": "0.1 0.1", "bins": "10 10 8",
        "surfaces": {b: "b 4 0.1 0.1 0.08 0.2 -0.02 0.2 -0.1 0.1" for b in (0, 1)}}


def fly(scene, photons, runs, *options):
    """Records of `runs` runs, with the sections of their files."""
    with tempfile.TemporaryDirectory(dir=SCRATCH) as keep:
        text = cml.repeated(runs, photons=photons, **scene)
        records = cml.run(text, "--seed", 41, "--threads", 1, *options, keep=keep)
        for record in records:
            record.update(cml.read_sections(record["output"]))
    return records


def numbers(records):
    """(name, values, errors) of every total and bin."""
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
        verdict.check(f"{name} {key}", abs(within[0] - 0.68) <= 0.07 and abs(within[1] - 0.95) <= 0.04, f"{within}")
    for k, column in enumerate(zip(*shares), 1):
        print(f"{name}: {len(column)} numbers, {100 * statistics.fmean(column):.1f} % within {k} "
              f"({100 * min(column):.1f} to {100 * max(column):.1f})")
    verdict.check(name, len(shares) >= least, f"only {len(shares)} totals and bins have enough packets")


def check_means(verdict, name, records, truth):
    """truth: {total: (value, error)}."""
    for key, (expected, uncertain) in truth.items():
        values = [record[key] for record in records]
        verdict.z(f"{name} {key}", statistics.fmean(values), statistics.stdev(values) / RUNS**0.5, expected, uncertain)


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
    verdict.finish()


main()
