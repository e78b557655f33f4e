"""Tests that --target-error reaches its target and has no bias, from 64 starting photons on, where Tt is 0.0025.

300 runs of a slab whose Rd, A and Tt adding-doubling gives; in most runs no light passes in the first rounds. The relative
deviations must have a root mean square of at most 1.1 times the target (300 runs: an excess of 2.4 deviations if they reach
it) and none may exceed 5 targets. The mean of all runs, whose error is that of their spread, must agree by Sidak's limit,
although the end of a run depends on its results."""
import os
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import slabs  # noqa: E402

RUNS, TARGET = 300, 0.05
LAYER = "1 1 9 0.5 1.6"
SCRATCH = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # the runs write many files, each of them synced


def main():
    verdict = cml.Verdict("target_error")
    ur1, ut1 = next((ur1, ut1) for _, layers, ur1, ut1, outside in slabs.rows() if layers == [LAYER] and outside == 1)
    with tempfile.TemporaryDirectory(dir=SCRATCH) as keep:
        text = cml.repeated(RUNS, [LAYER], photons=64, grid="1 1", bins="1 1 1")
        records = cml.run(text, "--seed", 47, "--threads", 1, "--target-error", TARGET, keep=keep)
    for name, truth in (("Rd", ur1), ("A", 1 - ur1 - ut1), ("Tt", ut1)):
        values = [record[name] for record in records]
        off = [abs(value / truth - 1) / TARGET for value in values]
        rms = statistics.fmean(x * x for x in off) ** 0.5
        print(f"{name}: deviations of {rms:.2f} targets (root mean square), {max(off):.2f} at most")
        verdict.check(f"{name}: root mean square", rms <= 1.1, f"{rms:.2f} targets")
        verdict.check(f"{name}: most", max(off) <= 5, f"{max(off):.2f} targets")
        verdict.z(name, statistics.fmean(values), statistics.stdev(values) / RUNS**0.5, truth)
    photons = sorted(record["photons"] for record in records)
    print(f"{photons[0]} to {photons[-1]} photons, {statistics.fmean(photons):.0f} in the mean")
    verdict.finish()


main()
