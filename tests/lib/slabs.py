"""Compares every slab and layer stack of tests/reference with adding-doubling: total reflectance and transmittance.

Arguments of run_all: engine, packets per row, and the step between rows. Statistic: z of Rsp + Rd and of Tt. Its limit of 4.6 is the Sidak limit
for all 470 numbers at a level of 2e-3.
"""
import csv
import os

import cml

LIMIT = 4.6


def rows():
    with open(os.path.join(cml.REFERENCE, "slabs.csv"), encoding="utf-8") as file:
        for i, row in enumerate(csv.DictReader(file)):
            layer = " ".join(row[key] for key in ("n_slab", "mua", "mus", "g", "d"))
            yield f"slab {i + 1} ({layer})", [layer], float(row["UR1"]), float(row["UT1"]), float(row["n_outside"])
    with open(os.path.join(cml.REFERENCE, "layers.csv"), encoding="utf-8") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            yield row["scene"], row["layers"].split("|"), float(row["UR1"]), float(row["UT1"]), 1.0


def run_all(engine, photons, stride):
    verdict = cml.Verdict(f"slabs.{engine}.{photons}")
    chosen = [row for i, row in enumerate(rows()) if i % stride == 0 or row[0][:4] != "slab" or 216 <= i < 219]
    text = ["1.0", str(len(chosen))]
    for i, (_, layers, _, _, outside) in enumerate(chosen):
        scene = cml.mci(layers, name=f"{i}.mco", photons=photons, n_above=outside, n_below=outside)
        text.append("\n".join(scene.split("\n")[2:]))
    records = cml.run("\n".join(text), "--engine", engine, "--ignore-absorption", "--seed", 20260101)
    verdict.check("number of runs", len(records) == len(chosen), f"{len(records)}, expected {len(chosen)}")
    for (name, _, ur1, ut1, _), record in zip(chosen, records):
        cml.check_balance(verdict, name, record)
        verdict.z(name + " R", record["Rsp"] + record["Rd"], cml.total_error(record, "Rd", ur1 - record["Rsp"]), ur1)
        verdict.z(name + " T", record["Tt"], cml.total_error(record, "Tt", ut1), ut1)
    verdict.finish(LIMIT)
