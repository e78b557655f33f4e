"""Tests the surface shapes of the 2019 report as cones and as meshes.

flat50, lohill, hicrater, lonoise and hinoise, with and without re-entry, are compared with an independent double-precision
reference with exact cones (1e7 photons or more). hihill and locrater have no reference: cones are compared with a mesh with
another seed. N = 2.5e5 per run, 1e6 with ALL_CASES; bins of 20 rings; level 1e-4 over all numbers. The mesh's own bias at the
default tolerance is far below the noise."""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import profiles  # noqa: E402

PHOTONS = cml.repeats(1000000)
CURVED = ["lohill", "hicrater", "lonoise", "hinoise"]
# a flat field has no re-entry; its second reference is another run
CASES = [(shape, how) for shape in CURVED for how in ("reentry", "noreentry")] + [("flat50", "noreentry"), ("flat50", "b")]


def fly(verdict, shape, how, kind, *more):
    """Returns (record, sections) of one run; its weight must balance."""
    options = ["--boundaries", kind, *more] + (["--no-reentry"] if how == "noreentry" else [])
    record, sections = profiles.simulate(f"shapes/{shape}.mci", PHOTONS, *options)
    cml.check_balance(verdict, f"{shape} {how} {kind}", record)
    return record, sections


def main():
    verdict = cml.Verdict("shapes")
    crater_Rd = {}
    for shape, how in CASES:
        table = profiles.reference(f"{shape}.{how}.csv")
        truth = {"Rd_r": table["Rd_r_per_cm2"], "Tt_r": table["Tt_r_per_cm2"]}
        for kind in ("cone", "mesh"):
            record, sections = fly(verdict, shape, how, kind)
            profiles.compare(verdict, f"{shape} {how} {kind}", PHOTONS, sections, truth, 0.32, group=20)
            if shape == "hicrater":
                crater_Rd[how] = (record["Rd"], record["Rd_se"])
    for shape in ("hihill", "locrater"):
        _, cones = fly(verdict, shape, "reentry", "cone")
        _, mesh = fly(verdict, shape, "reentry", "mesh", "--seed", 8)
        profiles.compare(verdict, f"{shape} mesh against cones", PHOTONS, mesh, cones, 1.0, group=20)
    (inside, e1), (first, e2) = crater_Rd["reentry"], crater_Rd["noreentry"]
    verdict.check("re-entry into the crater lowers Rd", first - inside > 5 * (e1 + e2), f"{first} to {inside}")
    verdict.finish(profiles.student_limit(len(verdict.rows)))


main()
