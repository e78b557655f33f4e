"""The report's surface shapes, with and without re-entry, as cones and as meshes, against an independent
double-precision reference with exact cones (1e7 photons or more).
N = 1e6 per run; broad bins of 20 rings and totals; level 1e-4 over all numbers. The mesh's own bias at the default
tolerance is far below the noise."""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import profiles  # noqa: E402

PHOTONS = 1000000
CASES = ["lohill", "hicrater", "lonoise", "hinoise"]

verdict = cml.Verdict("shapes")
crater_Rd = {}
for shape in CASES:
    for reentry in ("reentry", "noreentry"):
        table = profiles.reference(f"{shape}.{reentry}.csv")
        truth = {"Rd_r": table["Rd_r_per_cm2"], "Tt_r": table["Tt_r_per_cm2"]}
        for kind in ("cone", "mesh"):
            options = ["--boundaries", kind] + (["--no-reentry"] if reentry == "noreentry" else [])
            record, sections = profiles.simulate(f"shapes/{shape}.mci", PHOTONS, *options)
            name = f"{shape} {reentry} {kind}"
            cml.books(verdict, name, record)
            if shape == "hicrater":
                crater_Rd[reentry] = (record["Rd"], record["Rd_se"])
            profiles.compare(verdict, name, PHOTONS, sections, truth, 0.32, group=20)
(inside, e1), (first, e2) = crater_Rd["reentry"], crater_Rd["noreentry"]
verdict.check("re-entry into the crater lowers Rd", first - inside > 5 * (e1 + e2), f"{first} to {inside}")
verdict.finish(profiles.student_limit(len(verdict.rows)))
