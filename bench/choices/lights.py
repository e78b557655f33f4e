#!/usr/bin/env python3
"""Tests if the lattice suits every beam, and if errors are true: lights.py [--runs N] [--only BEAM,...] [--program PATH] [--out DIR]

Independent runs of every shape and light of BEAMS over a thin flat slab and over a hill are made with lattice sampling. The spread of the runs is
compared with the errors that the runs state, and with the errors of 24 runs of 16384 photons with random sampling, whose variance falls as 1 /
photons. Ratios are means over all numbers of a kind with 20 packets or more. Their noise comes from leaving out one run after the other. Up to 4096
photons, all runs are made; with more photons there are fewer runs, at least 12.

Leaves lights.csv in DIR, with a row for each beam, scene, number of photons and kind, and lights.md with two tables. The first has the ratios of
all beams together, by kind and number of photons. The second has, by beam, the least and the largest of the ratios that differ from 1 most surely.
Needs numpy and h5py (Debian: python3-numpy, python3-h5py).

SPDX-License-Identifier: MIT
"""
import importlib.util
import math
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command
import tables

sys.path.insert(0, os.path.join(cases.ROOT, "tests", "lib"))
import cml  # noqa: E402

LED, STRIPES = (os.path.join(cases.ROOT, *path) for path in (("samples", "led.txt"), ("meshes", "stripes.gsf")))
BEAMS = {
    "pencil": "pencil", "disk": "disk 0.2", "gaussian": "gaussian 0.15", "ring": "ring 0.1 0.2", "rectangle": "rectangle 0.3 0.2",
    "image": 'image "%s"' % STRIPES, "isotropic": "pencil z=0.25 light=isotropic", "lambertian": "pencil light=lambertian",
    "lambertian inside": "pencil z=0.1 light=lambertian", "na": "gaussian 0.1 light=na:0.8", "table": 'pencil z=0.1 light="%s"' % LED,
    "lambertian disk": "disk 0.2 light=lambertian", "isotropic rectangle": "rectangle 0.3 0.2 z=0.25 light=isotropic"}
HILL = {0: "b 4 0.1 0.1 0.08 0.2 -0.02 0.2 -0.1 0.1"}
SCENES = {"slab": (dict(layers=["1.4 0.5 1 0.8 0.5"]), (1024, 2048, 3000, 10000, 16384, 50000, 131072, 1048576)),
          "hill": (dict(layers=["1.4 0.5 5 0.8 0.5"], surfaces=HILL), (2048, 10000, 16384))}
SCORED = ["map 8 8 0.1 0.1 volume", "facets", "directions 6 12", "fluence", "time 100 8", "detector map 6 6 0.1 0.1 na=0.5 name=camera"]
KINDS = {"totals": ("Rd", "Tt", "A"), "profiles": ("A_z", "Rd_r", "Tt_r", "Rd_a", "Tt_a"), "grids": ("A_rz", "Rd_ra", "Tt_ra"),
         "pixels": ("Rd_xy", "Tt_xy", "detector_camera_map"), "directions": ("Rd_dir", "Tt_dir"),
         "facets": ("boundary0_Rd", "boundary1_Tt", "boundary0_exitance_above"), "volume": ("A_xyz", "phi_rz", "phi_xyz"), "gates": ("Rd_t", "Tt_t")}
FEW, LEAST = 4096, 12  # photons up to which all runs are made; least number of runs
REFERENCE_PHOTONS, REFERENCE_RUNS, PACKETS = 16384, 24, 20
SPREAD, VARIANCE, NOISE = "spread over error", "variance over random's", "noise of "


class Numbers:
    """The numbers of a kind, [run][number], with their stated errors."""

    def __init__(self, values, errors):
        self.values, self.squares = values, errors ** 2
        self.stated = self.squares.mean(0)
        self.count = (self.stated > 0) & (values.mean(0) ** 2 > PACKETS * self.stated)

    def ratios(self, chosen, expected):
        """Returns {SPREAD, VARIANCE: ratio; NOISE + both: its standard error} of the chosen numbers. expected: their expected variance."""
        import numpy
        runs = len(self.values)

        def over(rows):
            variance = self.values[rows][:, chosen].var(0, ddof=1)
            return [math.sqrt((variance / self.squares[rows][:, chosen].mean(0)).mean()), float((variance / expected).mean())]
        without = numpy.array([over(numpy.arange(runs) != run) for run in range(runs)])
        noise = (without.std(0) * math.sqrt(runs - 1)).tolist()
        return dict(zip((SPREAD, VARIANCE, NOISE + SPREAD, NOISE + VARIANCE), over(numpy.arange(runs)) + noise))


def fly(scene, beam, photons, runs, sampling):
    """Returns {kind: Numbers} of independent runs."""
    import h5py
    import numpy
    found = {kind: ([], []) for kind in KINDS}
    with tempfile.TemporaryDirectory(dir="/dev/shm" if os.access("/dev/shm", os.W_OK) else None) as keep:
        text = cml.repeated(runs, photons=photons, kind=".h5", grid="0.1 0.1", bins="5 5 3", extra=["beam " + beam, *SCORED], **scene)
        for record in cml.run(text.replace(".h5 A", ".h5 B"), "--seed", 54, "--sampling", sampling, keep=keep):
            with h5py.File(record["output"]) as file:
                for kind, names in KINDS.items():
                    here = [name for name in names if name + "_se" in file]
                    for column, end in zip(found[kind], ("", "_se")):
                        column.append(numpy.concatenate([numpy.ravel(file[name + end][()]).astype(float) for name in here]))
    return {kind: Numbers(*map(numpy.array, columns)) for kind, columns in found.items()}


def rows_of(beam, runs):
    for title, (scene, counts) in SCENES.items():
        random = fly(scene, BEAMS[beam], REFERENCE_PHOTONS, REFERENCE_RUNS, "random")
        for photons in counts:
            here = max(LEAST, min(runs, runs * FEW // photons))
            for kind, even in fly(scene, BEAMS[beam], photons, here, "lattice").items():
                chosen = even.count & (random[kind].stated > 0)
                if chosen.any():
                    expected = random[kind].stated[chosen] * REFERENCE_PHOTONS / photons
                    yield {"beam": beam, "scene": title, "photons": photons, "kind": kind, "runs": here, "numbers": int(chosen.sum()),
                           **even.ratios(chosen, expected)}


def together(rows, key):
    """Returns the mean of a ratio over rows, with its noise."""
    mean = sum(row[key] for row in rows) / len(rows)
    return "%.2f(%.0f)" % (mean, 100 * math.sqrt(sum(row[NOISE + key] ** 2 for row in rows)) / len(rows))


def by_kind(rows, key):
    """Returns a table of all beams together: kinds by scenes and photons."""
    places = [(scene, photons) for scene, (_, counts) in SCENES.items() for photons in counts]
    lines = []
    for kind in KINDS:
        here = {place: [row for row in rows if (row["kind"], row["scene"], row["photons"]) == (kind, *place)] for place in places}
        lines.append([kind] + [together(found, key) if found else "-" for found in here.values()])
    return tables.table(["%s; 1 in () is 0.01" % key] + ["%s, %d" % place for place in places], lines)


def cell(row, key):
    return "%.2f(%.0f) (%s of %s, %d)" % (row[key], 100 * row[NOISE + key], row["kind"], row["scene"], row["photons"])


def summary(beam, rows):
    def surely(key, sign):
        return cell(max(rows, key=lambda row: sign * math.log(row[key]) - 2 * row[NOISE + key] / row[key]), key)
    mean = math.exp(sum(math.log(row[VARIANCE]) for row in rows) / len(rows))
    return [beam, surely(SPREAD, -1), surely(SPREAD, 1), surely(VARIANCE, 1), "%.2f" % mean]


def main():
    parser = command.parser(__doc__, runs=(100, LEAST))
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    for module in ("numpy", "h5py"):
        if importlib.util.find_spec(module) is None:
            parser.error("the module %s is missing" % module)
    cml.PROGRAM = arguments.program
    rows, lines = [], []
    for beam in command.only(arguments.only, BEAMS, parser):
        fresh = list(rows_of(beam, arguments.runs))
        rows += fresh
        lines.append(summary(beam, fresh))
        print(lines[-1], file=sys.stderr, flush=True)
    about = tables.machine(arguments.program, arguments.runs)
    tables.write_csv(os.path.join(arguments.out, "lights.csv"), about, rows)
    titles = ("beam", "least spread over error", "largest", "largest variance over random's", "geometric mean of all")
    tables.keep(os.path.join(arguments.out, "lights.md"),
                ["%s; %d runs." % (tables.measured(about), arguments.runs), "", *by_kind(rows, SPREAD), "", *by_kind(rows, VARIANCE), "",
                 *tables.table(titles, lines)])


if __name__ == "__main__":
    main()
