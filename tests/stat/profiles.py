"""Tests scenes S1, S2, S3 (figures 5 to 7 of the 2019 report, figure 7 as its text says) bin by bin against original MCML's
transport code with a sound generator (1e9, 2.4e9, 1.2e8 photons), and figure 7 as it was really made. N = 4e6, 2e6, 1e6;
statistic: Student deviates per bin, level 1e-4 over all bins."""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import profiles  # noqa: E402

CASES = [("S1", "fig5.mci", 4000000), ("S2", "fig6.mci", 2000000), ("S3", "fig7text.mci", 1000000)]

verdict = cml.Verdict("profiles")
for name, scene, photons in CASES:
    record, sections = profiles.simulate(scene, photons)
    table = profiles.reference(name + ".csv")
    cml.check_balance(verdict, name, record)
    profiles.compare(verdict, name, photons, sections, table, {"Rd_r": table["Rd_r_sem"], "Tt_r": table["Tt_r_sem"]})
record, sections = profiles.simulate("fig7.mci", 1000000)
table = profiles.reference("S3fig7.csv")
truth = {"Rd_r": table["Rd_r_per_cm2"], "Tt_r": table["Tt_r_per_cm2"]}
profiles.compare(verdict, "figure 7", 1000000, sections, truth, 0.3, group=10)
verdict.finish(profiles.student_limit(len(verdict.rows)))
