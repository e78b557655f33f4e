#!/usr/bin/env python3
"""Draws figures 5 to 10 of the report "MCML with Boundary Surfaces" (2019) again, from our own runs, with the report's
curves (figures/*.csv) dashed beside them, furrows.mci as a shaded mesh, the maps of furrows.mci, vein.mci and pattern.mci, the runs
of samples/two_runs.mci and pulse.mci, the fluence of head.mci, what sees gloss.mci, camera.mci and fibres.mci, and the beams of
fibre.mci, lamp.mci and glow.mci:
    figures.py [--quick] [--photons N] [--program PATH] [--out DIR]
by default 3e6 packets (--quick: 1e5), 30 times as many of flat scenes, which are fast, and 10/3 times of maps, of build/clustermcml into bench/out.
SPDX-License-Identifier: MIT
"""
import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command
import picture

CURVES = os.path.join(cases.BENCH, "accuracy", "figures")
SCENES = ("fig5", "fig6", "fig7", *("shapes/" + shape for shape in ("flat50", "lohill", "hihill", "locrater", "hicrater", "lonoise", "hinoise")),
          "two_runs", "pulse", "vein", "pattern", "head", "gloss")
MAPS = ("furrows", "camera")  # facets and pixels are small
BEAMS = ("fibre", "lamp", "glow")
MAP = ["--of", "Rd", "--percentile", "99.9", "--linear"]
FLAT = ("Solid: this program, {flat} packets, with a band of one standard error. Dashed: the report's curves of CUDAMCML and of "
        "the program of 2019, read from its graphics, where its flat scenes are sound: they agree within print and noise.")
KERNEL = ("Solid: this program, {n} packets, with a band of one standard error; dotted: the heightfield, on top and bottom. Dashed: the "
          "report's curves of 2019. The flat one is sound. The others differ because that program's surfaces were not those drawn: the "
          "outer half of the samples became a staircase of planes, normals were off by 17 to 89 degrees")
# figure: caption, files (its curves are those of the same names) and options
REPORT = {
    "figure5": (FLAT, ("fig5",)), "figure6": (FLAT, ("fig6",)),
    "figure7": (FLAT + " Made with layers of 0.15 cm, as the report's figure was, not of 1.5 cm as its text says.", ("fig7",)),
    "figure8": (KERNEL + ", and light on the axis passed the tips unhindered.", ("flat50", "lohill", "hihill")),
    "figure9": (KERNEL + ", its packets began at z = 0, above the crater's floor, and light that left could not come back.",
                ("flat50", "locrater", "hicrater")),
    "figure10": (KERNEL + ", crossings were missed, and light that left could not come back, without which hinoise reflects 1.8 "
                 "times as much.", ("flat50", "lonoise", "hinoise")),
}
OTHERS = {
    "skin": (None, ["furrows.h5", "--of", "boundary0_exitance_above", "--linear", "--percentile", "99.9", "--label", "Furrowed skin in light from the left"]),
    "furrows": ("Diffuse reflectance of furrowed skin that goes on for ever, under a disk of light of 0.2 cm in radius from the left, 15 degrees "
                "above it, {many} packets. The texture repeats every 0.16 cm; the beam does not. Slopes that face the light are a quarter "
                "brighter than those that turn away.", ["furrows.h5", *MAP, "--label", "Furrows of skin, slanting light"]),
    "vein": ("Diffuse reflectance of skin at 532 nm over a winding vein, 0.012 cm in radius and 0.014 to 0.034 cm below the surface, under a disk "
             "of light of 0.35 cm in radius, {n} packets.", ["vein.h5", *MAP, "--label", "A vein under skin"]),
    "pattern": ("Diffuse reflectance of a turbid plate under a projected pattern of stripes, {n} packets.",
                ["pattern.h5", *MAP, "--label", "Stripes on a turbid plate"]),
    "hill": ("A slab with and without a hill, {n} packets each.",
             ["two_runs_hill.mco", "two_runs_flat.mco", "--label", "with a hill", "--label", "flat"]),
    "pulse": ("Diffuse reflectance of a pulse by time, {n} packets each, over a layer five times as dark from 0.8 cm down, and over none.",
              ["pulse.mco", "pulse_even.mco", "--of", "Rd_t", "--label", "darker below 0.8 cm", "--label", "even"]),
    "head": ("Fluence in a head at 800 nm, {n} packets, bins of 0.5 mm. Between 1 and 1.2 cm of depth lies the clear fluid around the brain, "
             "which guides light.", ["head.mco", "--of", "phi_rz", "--crange", "1e-5:10", "--label", "Scalp, skull, clear fluid, grey and white matter"]),
    "gloss": ("Gloss of a white tile with a wavy glaze, weight per sr, under light that comes down towards +x at 45 degrees, {n} packets.",
              ["gloss.mco", "--of", "Rsp_dir", "--log", "--label", "Gloss"]),
    "white": ("What comes back from inside the same tile.",
              ["gloss.mco", "--of", "Rd_dir", "--linear", "--percentile", "99", "--label", "Diffuse part"]),
    "camera": ("A hill 0.2 cm high as a camera sees it that stands at -x and looks down at 45 degrees, NA 0.3, focused half way up; light from "
               "the other side, 60 degrees from the vertical, {many} packets. On the focused plane a pixel is 0.25 mm.",
               ["camera.h5", "--of", "detector_cam_map", "--percentile", "99.9", "--linear", "--label", "A hill, seen at 45 degrees"]),
    "fibres": ("Share of the light of one fibre on furrowed skin that comes into another, both 0.06 cm wide, NA 0.39, by the distance between "
               "their axes, {few} packets.", ["fibres.sweep.csv", "--of", "detector_far", "--over", "detector2.x", "--log", "--label", "Two fibres on skin"]),
}


def call(*words, **where):
    done = subprocess.run(words, check=False, **where)
    if done.returncode:
        sys.exit(done.returncode)


def curves_of(scene):
    """Returns the paths of the report's curves of a scene, those of CUDAMCML included if the report has them."""
    names = [scene + "-%s-2019.csv" % of for of in ("CUDAMCML", "clustermcml")] if scene.startswith("fig") else [scene + "-2019.csv"]
    return [os.path.join(CURVES, name) for name in names]


def fly(program, out, photons):
    def run(scene, number, *options):
        call(program, os.path.join(cases.ROOT, "samples", scene + ".mci"), *options, "--photons", str(number), "--ignore-absorption", "--quiet", "-o", out)
    for scene in SCENES:
        run(scene, 30 * photons if scene.startswith("fig") else photons)
    for scene in MAPS:
        run(scene, 10 * photons // 3)
    distances = os.path.join(out, "distances.csv")
    with open(distances, "w") as stream:
        stream.write("detector2.x\n" + "".join("%g\n" % (i * 0.05) for i in range(2, 10)))
    run("fibres", photons // 9, "--sweep", distances)


def main():
    parser = command.parser(__doc__, "quick")
    parser.add_argument("--photons", type=command.count)
    arguments = parser.parse_args()
    picture.need(parser, "h5py", "matplotlib", "xarray")
    photons, out = arguments.photons or (100000 if arguments.quick else 3000000), os.path.abspath(arguments.out)
    os.makedirs(out, exist_ok=True)
    fly(arguments.program, out, photons)
    drawn = {name: (caption, [scene + ".mco" for scene in scenes] + [curve for scene in scenes for curve in curves_of(scene)])
             for name, (caption, scenes) in REPORT.items()}
    for name, (caption, words) in {**drawn, **OTHERS}.items():
        below = ["--caption", caption.format(n=photons, flat=30 * photons, many=10 * photons // 3, few=photons // 9)] if caption else []
        call(arguments.program, "plot", *words, *below, "--quiet", "-o", name + ".svg", cwd=out)
        print(os.path.join(out, name + ".svg"), flush=True)
    for scene in BEAMS:
        with open(os.path.join(out, scene + ".txt"), "w") as stream:
            call(arguments.program, "view", os.path.join(cases.ROOT, "samples", scene + ".mci"), "-o", os.path.join(out, scene + ".svg"), stdout=stream)


if __name__ == "__main__":
    main()
