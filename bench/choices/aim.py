#!/usr/bin/env python3
"""Measures the gain of --aim: aim.py [--runs N] [--photons N] [--only SCENE,...] [--program PATH] [--out DIR]

Each scene is simulated N times with and without --aim Tt, in turns, on one thread, under a beam of 0.3 cm. In some scenes the top or an inner
boundary is rough, and light goes down into flat layers. In others the bottom is rough, and packets are split on their way instead. Fibres far from
a pencil are aimed at by name. A plain flight would see a packet or none in such a fibre. Its counted error is therefore that of the ring of equal
width on which the fibre lies, reduced by the ratio of areas and by the share of light that its aperture accepts in an aimed flight. The fibre
lies on one place of the relief, the ring on many, so their light differs by a percent or two.

The gain in time to equal error is the mean square of the counted errors over that of the expected ones (of counted ones, in windows), times the
ratio of processor times. For rare light, the counted error comes from few packets, which makes its gain uncertain by some tens of percent. Through
the thickest slab, plain flights see no light. There the variance of a photon's contribution is its share times the mean weight, by weight, of
arriving packets. Roulette makes this weight equal at all depths that little light reaches, so that it is measured behind a thinner slab. Errors of
Tt(r) are those of ten bins, added as squares. Further columns: the gain of windows that `plan` predicts, processor seconds before the flight, and
the difference between expected and counted values in units of its error. Leaves aim.md in DIR.

SPDX-License-Identifier: MIT
"""
import json
import math
import os
import resource
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command
import tables

RIPPLE = "b 6 0.002 0.03 -0.002 0.03 0.002 0.03 -0.002 0.03 0.002 0.03 0 0.3"
SKIN = "1.4 0.3 120 0.8 3"
# name: medium or layers, mesh of the top, radius of the fibre, distance, its aperture, photons in units of --photons
FIBRES = {
    "fibre of 0.01 at 1 cm": (SKIN, "0.018", 0.01, 1.0, "", 1),
    "fibre of 0.01 at 0.3 cm": (SKIN, "0.018", 0.01, 0.3, "", 1),
    "fibre of 0.01 at 0.3 cm, 0.22": (SKIN, "0.018", 0.01, 0.3, "na=0.22", 1),
    "fibre of 0.05 at 0.5 cm, 0.5": (SKIN, "0.018", 0.05, 0.5, "na=0.5", 1),
    "fibre of 0.05 at 1 cm, 0.22": (SKIN, "0.018", 0.05, 1.0, "na=0.22", 1),
    "skin7 fibre of 0.01 at 1 cm": ("S5", "0.0009", 0.01, 1.0, "", 1),
    "skin7 fibre of 0.02 at 0.3 cm, 0.22": ("S5", "0.0009", 0.02, 0.3, "na=0.22", 1),
}
# name: medium or layers, boundary that is rough, amplitude of a mesh [cm] or a line, photons in units of --photons, layer whose absorption is shown
SCENES = {
    "S6a rough top": ("S6a", 0, "0.018", 1, None),
    "skin7 rough top": ("S5", 0, "0.0009", 1, 7),
    "skin7 layer 5 rough": ("S5", 4, RIPPLE, 1, 7),
    "slab 1.5 cm rough top": ("1.4 0.5 100 0.9 1.5", 0, "0.018", 1, None),
    "slab 3.2 cm rough top": ("1.4 0.5 100 0.9 3.2", 0, "0.018", 4, None),
    "S6a rough bottom": ("S6a", 1, "0.018", 1, None),
    "skin7 rough bottom": ("S5", 7, "0.018", 1, None),
    "slab 1.5 cm rough bottom": ("1.4 0.5 100 0.9 1.5", 1, "0.018", 1, None),
    "slab 3.2 cm rough bottom": ("1.4 0.5 100 0.9 3.2", 1, "0.018", 4, None),
    "slab 4.95 cm rough bottom": ("1.4 0.5 100 0.9 4.95", 1, "0.018", 4, None),
}
# name: a thinner scene, whose plain flights show the weight of arriving packets
THINNER = {"slab 4.95 cm rough bottom": "slab 3.2 cm rough bottom"}
DR, NR = 0.5, 10


def scene_of(name):
    """Returns medium, rough boundary, its shape, photons in units of --photons, and lines for light and detectors."""
    if name in SCENES:
        return *SCENES[name][:4], ["beam disk 0.3"]
    medium, rough, size, away, aperture, factor = FIBRES[name]
    disk = "detector disk %g at=%g,0 " % (size, away)
    ring = "detector ring %.17g %.17g name=ring" % (away - size, away + size)
    return medium, 0, rough, factor, [disk + aperture + " name=fibre", disk + "name=open", ring]


def write(name, folder):
    """Writes the scene's file with a coarse grid. Returns its path, and its photons in units of --photons."""
    medium, boundary, rough, factor, extra = scene_of(name)
    lines = cases.data_lines(medium) if " " not in medium else [
        "1.0", "1", "x.mco A", "1000", "0.1 0.1", "1 1 1", "1", "1.0", medium, "1.0"]
    if not rough.startswith("b "):
        mesh = os.path.join(folder, "rough%s.obj" % rough)
        cases.make_surface("mesh", "1e4", rough, mesh)
        rough = 'm "%s"' % mesh
    lines.insert(cases.ABOVE + 1 + boundary, rough)
    path = os.path.join(folder, "scene.mci")
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join([lines[0], "1", "x.mco A", lines[3], *extra, "0.1 %g" % DR, "1 %d 1" % NR] + lines[6:]) + "\n")
    return path, factor


def processor():
    """Returns the processor seconds of all programs called so far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def fly(program, path, photons, seed, *options):
    began = processor()
    done = subprocess.run([program, path, "--photons", str(photons), "--seed", str(seed), "--threads", "1", "--ignore-absorption",
                           "--checkpoint", "off", "--json", "-o", os.path.dirname(path), *options],
                          stdout=subprocess.PIPE, check=True)
    return dict(json.loads(done.stdout), all_s=processor() - began, Tt_r_se=error_of_profile(os.path.join(os.path.dirname(path), "x.mco")))


def error_of_profile(path):
    """Returns the error of the light in all bins of Tt(r)."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    errors = text[text.index("\nse_Tt_r"):].split("\n")[2:2 + NR]
    return math.hypot(*(2 * math.pi * (i + 0.5) * DR ** 2 * float(error) for i, error in enumerate(errors)))


def planned(program, path, aim):
    """Returns the gain of windows that `plan` predicts."""
    done = subprocess.run([program, "plan", path, "--photons", "64", "--threads", "1", "--json"], stdout=subprocess.PIPE, check=True)
    return json.loads(done.stdout)["gains"].get(aim)


def square(records, key):
    return statistics.fmean(record[key] ** 2 for record in records)


def mean_error(records, key):
    return math.sqrt(square(records, key) / len(records))


def gain(plain, aimed, key, other, pace, share=1):
    """Returns the gain in time to equal error of `key`. share: the part of the light counted as `other` that belongs to `key`."""
    return share * square(plain, other + "_se") / square(aimed, key + "_se") * pace


def share_of(name, aimed):
    """Returns the share of a ring's light that comes to the fibre on it."""
    if name not in FIBRES:
        return 1
    accepted = sum(record["detector_fibre"] for record in aimed) / sum(record["detector_open"] for record in aimed)
    return FIBRES[name][2] / FIBRES[name][3] / 4 * accepted


def expect_errors(plain, aimed, name, arguments, folder):
    """Sets the errors of Tt and Tt(r) of plain flights that see nothing, from the weights of a thinner scene."""
    path, factor = write(name, folder)
    thinner = [fly(arguments.program, path, factor * arguments.photons, seed) for seed in range(1, arguments.runs + 1)]
    weight = statistics.fmean(r["photons"] * r["Tt_se"] ** 2 for r in thinner) / statistics.fmean(r["Tt"] for r in thinner)
    for record in plain:
        record["Tt_se"] = record["Tt_r_se"] = math.sqrt(weight * statistics.fmean(r["Tt"] for r in aimed) / record["photons"])


def row(name, arguments, folder):
    path, factor = write(name, folder)
    photons, layer = factor * arguments.photons, SCENES[name][4] if name in SCENES else None
    aim, other = ("fibre", "detector_ring") if name in FIBRES else ("Tt", "Tt")
    pairs = [(fly(arguments.program, path, photons, seed), fly(arguments.program, path, photons, seed, "--aim", aim))
             for seed in range(1, arguments.runs + 1)]
    plain, aimed = zip(*pairs)
    share = share_of(name, aimed)
    pace = statistics.median(a["cpu_s"] / b["cpu_s"] for a, b in pairs)
    before = statistics.median((b["all_s"] - b["cpu_s"]) - (a["all_s"] - a["cpu_s"]) for a, b in pairs)
    key = "Tt_expected" if "Tt_expected" in aimed[0] else "Tt" if aim == "Tt" else "detector_fibre"
    plan = "" if key == "Tt_expected" else "%.2g" % planned(arguments.program, path, "Tt_r" if aim == "Tt" else aim)
    if name in THINNER:
        expect_errors(plain, aimed, THINNER[name], arguments, folder)
    value = statistics.fmean(record[key] for record in aimed)
    apart = (value - share * statistics.fmean(record[other] for record in plain)) / math.hypot(
        mean_error(aimed, key + "_se"), share * mean_error(plain, other + "_se"))
    profile = "%.2g" % gain(plain, aimed, "Tt_r", "Tt_r", pace) if key == "Tt" else ""
    deep = ""
    if layer:
        deep = "%.2g" % (statistics.fmean(record["A_l_se"][layer - 1] ** 2 for record in plain) /
                         statistics.fmean(record["A_l_expected_se"][layer - 1] ** 2 for record in aimed) * pace)
    return [name, "%d" % photons, "%.4g" % value, "" if name in THINNER else "%+.1f" % apart, "%.2f" % (1 / pace), "%.1f" % before,
            "%.2g" % gain(plain, aimed, key, other, pace, share), plan, profile, "%.2g" % gain(plain, aimed, "Rd", "Rd", pace),
            "%.2g" % gain(plain, aimed, "A", "A", pace), deep]


def main():
    parser = command.parser(__doc__, runs=(6, 2), photons=200000)
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = [row(name, arguments, folder) for name in command.only(arguments.only, (*SCENES, *FIBRES), parser)]
    tables.keep(os.path.join(arguments.out, "aim.md"), [
        tables.measured(tables.machine(arguments.program, arguments.runs)) + "; %d runs." % arguments.runs, "",
        *tables.table(("scene", "photons", "Tt, or what the fibre sees", "apart, errors", "time of flight", "before it, s", "gain of it",
                       "as planned", "of Tt(r)", "of Rd", "of A", "of A of the deepest layer"), rows)])


if __name__ == "__main__":
    main()
