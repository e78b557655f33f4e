"""Tests standard errors of pixels and facets: counts how often 150 independent runs lie within 1 and 2 errors of the mean of all runs.

An argument is the number of runs (long.coverage_maps: 500). Errors come from 16 groups of packets, with random sampling and with the lattice.
Tested are pixels of Rd_xy and Tt_xy, bins of Rd_xya, and rings of Rd, if 60 packets or more arrive in a run. Student's distribution with 15 degrees
of freedom gives shares of 66.7 and 93.6 %. With 500 runs, shares may differ by 7 and 5.5 %, which is 3.3 and 5 deviations, because groups of four
packets are skewed. With 150 runs they may differ by 12.8 and 10 %; errors that are a third too small or half too large exceed this."""
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
from fields import h5py, numpy  # noqa: E402

RUNS, PHOTONS, PACKETS = int(sys.argv[1]) if len(sys.argv) > 1 else 150, 10000, 60
WIDER = (500 / RUNS) ** 0.5
SCRATCH = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # the test writes many files, each of which is synced
NAMES = ["Rd_xy", "Tt_xy", "Rd_xya", "boundary0_Rd"]


def fly(keep, sampling):
    text = cml.repeated(RUNS, ["1.4 0.2 9 0.5 0.3"], kind=".h5", photons=PHOTONS, bins="1 1 2",
                        surfaces={0: "b 3 0.1 0.2 0.05 0.3 0 0"},
                        extra=["beam disk 0.3 at=0.05,0.1", "map 5 4 0.2 0.25 angles", "facets"])
    found = {name: [] for name in NAMES + [name + "_se" for name in NAMES]}
    for record in cml.run(text.replace(".h5 A", ".h5 B"), "--seed", 43, "--threads", 1, "--sampling", sampling, keep=keep):
        with h5py.File(record["output"]) as file:
            for name, values in found.items():
                values.append(file[name][:].astype(float).ravel())
    return {name: numpy.array(values) for name, values in found.items()}


def check(verdict, sampling, name, values, errors):
    mean = values.mean(axis=0)
    chosen = (mean > 0) & (mean**2 > PACKETS * values.var(axis=0))
    near = abs(values - mean)[:, chosen]
    one, two = (near <= errors[:, chosen]).mean(axis=0), (near <= 2 * errors[:, chosen]).mean(axis=0)
    print(f"{sampling} {name}: {chosen.sum()} bins; within 1: {100 * one.mean():.1f} % ({100 * one.min():.1f}..."
          f"{100 * one.max():.1f}), within 2: {100 * two.mean():.1f} % ({100 * two.min():.1f}...{100 * two.max():.1f})")
    verdict.check(name, bool(numpy.all((abs(one - 0.667) <= 0.07 * WIDER) & (abs(two - 0.936) <= 0.055 * WIDER))), sampling)
    verdict.check(name, chosen.sum() >= 2, f"{sampling}: bins with enough packets")


def main():
    verdict = cml.Verdict("coverage of maps")
    for sampling in ("random", "lattice"):
        with tempfile.TemporaryDirectory(dir=SCRATCH) as keep:
            found = fly(keep, sampling)
        for name in NAMES:
            check(verdict, sampling, name, found[name], found[name + "_se"])
    verdict.finish()


main()
