"""Tests standard errors of quantities to which one packet adds many times: counts how often runs lie within one of their errors of the mean.

There are six scenes, two with lattice sampling and two with bodies. An argument is the number of runs of each. Only numbers with 300 packets or
more in a run count. The share within 1 error, of each quantity over all scenes and bins, must be 68 +- 5 % with 400 runs. With the 20 runs that fit
into seconds it must be 68 +- 20 %, which still shows an error that is half or twice as large."""
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
from fields import h5py, numpy  # noqa: E402

RUNS = int(sys.argv[1]) if len(sys.argv) > 1 else 20
WITHIN = 0.05 if RUNS >= 400 else 0.2
PACKETS = 300
SCRATCH = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # the test writes many files, each of which is synced
NAMES = ("A_l", "A_body", "A_rz", "Rd_ra", "Tt_ra", "A_xyz", "flux_body", "boundary0_irradiance_below", "boundary0_exitance_above", "body_irradiance_outside",
         "body_exitance_inside")
HILL = {b: "b 4 0.1 0.1 0.08 0.2 -0.02 0.2 -0.1 0.1" for b in (0, 1)}
SPHERE = "1.4 2 20 0.7 0.4\ni sphere 0 0 0.15 0.1 1.5 8 5 0.5"
SCENES = {
    "lattice": ({"layers": ["1.34 0.5 5 0.5 0.1", "1.4 1 10 0.8 0.3"]}, "lattice"),
    "thick": ({"layers": ["1.4 1 50 0.9 0.05", "1.4 0.2 50 0.9 1"]}, "random"),
    "hill": ({"layers": ["1.3 1 4 0 1"], "surfaces": HILL}, "random"),
    "white": ({"layers": ["1 0.01 100 0.5 0.02"]}, "random"),
    "sphere": ({"layers": [SPHERE], "extra": ["beam disk 0.2"]}, "random"),
    "two bodies": ({"layers": ["1.4 0.5 3 0 0.2", SPHERE.replace("0.15", "0.4") + "\ni cylinder -1 0 0.27 1 0 0.27 0.02 1.4 30 5 0.5"],
                    "extra": ["beam gaussian 0.1"]}, "lattice"),
}


def fly(scene, sampling):
    """Returns {name: [runs][numbers]} of quantities and their errors."""
    found = {}
    with tempfile.TemporaryDirectory(dir=SCRATCH) as keep:
        scene = {**scene, "extra": [*scene.get("extra", []), "map 3 3 0.2 0.2 volume", "facets"]}
        text = cml.repeated(RUNS, photons=2000, kind=".h5", grid="0.04 0.05", bins="10 10 2", **scene).replace(".h5 A", ".h5 B")
        for record in cml.run(text, "--seed", 47, "--threads", 1, "--sampling", sampling, keep=keep):
            with h5py.File(record["output"]) as file:
                for name in [n + end for n in NAMES if n in file for end in ("", "_se")]:
                    found.setdefault(name, []).append(file[name][:].astype(float).ravel())
    return {name: numpy.array(values) for name, values in found.items()}


def main():
    verdict, shares = cml.Verdict("coverage of media"), {name: [] for name in NAMES}
    for title, (scene, sampling) in SCENES.items():
        found = fly(scene, sampling)
        for name in [name for name in NAMES if name in found]:
            values, errors = found[name], found[name + "_se"]
            mean = values.mean(axis=0)
            chosen = (mean > 0) & (mean**2 > PACKETS * values.var(axis=0))
            within = (abs(values - mean)[:, chosen] <= errors[:, chosen]).mean(axis=0)
            shares[name].extend(within)
            print(f"{title}, {name}: {chosen.sum()} numbers, {100 * within.mean() if len(within) else 0:.1f} % within one error")
    for name, share in shares.items():
        print(f"{name}: {len(share)} numbers, {100 * numpy.mean(share):.1f} % within one error")
        verdict.check(name, len(share) > 1 and abs(numpy.mean(share) - 0.68) <= WITHIN, f"{share}")
    verdict.finish()


main()
