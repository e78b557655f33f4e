"""Standard errors tell the truth: how often 800 independent runs lie within 1 and 2 of them from the expected value.

A slab whose total reflectance and transmittance adding-doubling gives; the expected values of bins are the means over all
runs, 28 times sharper than one run. Totals (errors from squares per packet) and every bin of Rd_r, Tt_r, Rd_a, Tt_a, A_z
that gets 300 packets or more in a run (errors from 64 batches: with few packets per batch their spread is skewed and
itself uncertain). Shares must be 68 +- 7 % and 95 +- 4 %: with 800 runs these are 4.2 and 5.2 deviations, per bin."""
import csv
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

RUNS, PHOTONS, PACKETS = 800, 20000, 300
SLAB = {"n_slab": "1.4", "n_outside": "1", "mua": "1", "mus": "9", "g": "0.5", "d": "0.4"}
SCRATCH = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # many files, each of them synced
KEYS = ["A_z", "Rd_r", "Rd_a", "Tt_r", "Tt_a"]


def truth():
    with open(os.path.join(cml.REFERENCE, "slabs.csv"), encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if all(float(row[k]) == float(v) for k, v in SLAB.items())]
    return float(rows[0]["UR1"]), float(rows[0]["UT1"])


def fly(keep):
    layer = " ".join(SLAB[key] for key in ("n_slab", "mua", "mus", "g", "d"))
    text = ["1.0", str(RUNS)]
    for i in range(RUNS):
        scene = cml.mci([layer], name=f"run{i}.mco", photons=PHOTONS, grid="0.04 0.08", bins="10 10 8")
        text.append("\n".join(scene.split("\n")[2:]))
    records = cml.run("\n".join(text), "--seed", 41, "--threads", 1, keep=keep)
    return records, [cml.read_sections(record["output"]) for record in records]


def check(verdict, name, values, errors, expected):
    within = [sum(abs(v - expected) <= k * e for v, e in zip(values, errors)) / len(values) for k in (1, 2)]
    print(f"{name}: {100 * within[0]:.1f} % within 1, {100 * within[1]:.1f} % within 2")
    verdict.check(name, abs(within[0] - 0.68) <= 0.07 and abs(within[1] - 0.95) <= 0.04, f"{within}")


def check_bins(verdict, key, sections):
    for i in range(len(sections[0][key])):
        values = [section[key][i] for section in sections]
        errors = [section["se_" + key][i] for section in sections]
        mean = sum(values) / RUNS
        variance = sum((v - mean) ** 2 for v in values) / (RUNS - 1)
        if mean > 0 and mean**2 > PACKETS * variance:  # (mean / error)^2 is at most the number of packets
            check(verdict, f"{key}[{i}]", values, errors, mean)
            yield 1


def main():
    verdict = cml.Verdict("coverage")
    ur1, ut1 = truth()
    with tempfile.TemporaryDirectory(dir=SCRATCH) as keep:
        records, sections = fly(keep)
    specular = records[0]["Rsp"]
    check(verdict, "Rd", [r["Rd"] for r in records], [r["Rd_se"] for r in records], ur1 - specular)
    check(verdict, "Tt", [r["Tt"] for r in records], [r["Tt_se"] for r in records], ut1)
    check(verdict, "A", [r["A"] for r in records], [r["A_se"] for r in records], 1 - ur1 - ut1)
    bins = sum(sum(check_bins(verdict, key, sections)) for key in KEYS)
    verdict.check("bins", bins >= 40, f"only {bins} bins have enough packets")
    verdict.finish()


main()
