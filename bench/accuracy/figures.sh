#!/bin/sh
# Draws figures 5 to 10 of the report "MCML with Boundary Surfaces" (2019) again, from our own runs, with the report's
# curves (figures/*.csv) dashed beside them, the maps of samples/skinmap.mci, furrows.mci, vein.mci and pattern.mci, the runs
# of samples/two_runs.mci and pulse.mci, the fluence of head.mci, what sees gloss.mci, camera.mci and fibres.mci, and the beams of fibre.mci, lamp.mci and glow.mci:
#     figures.sh [--quick] [--photons N] [--program PATH] [--out DIR]
# by default 3e6 packets (--quick: 1e5) of build/clustermcml into bench/out.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/../lib/lib.sh"
quick= photons=
options quick "photons program out" "$@"
photons=${photons:-${quick:+100000}}
photons=${photons:-3000000}
need_number --photons "$photons"
need_program
need gnuplot
mkdir -p "$out"
for scene in fig5 fig6 fig7 shapes/flat50 shapes/lohill shapes/hihill shapes/locrater shapes/hicrater shapes/lonoise \
    shapes/hinoise two_runs pulse furrows vein pattern head gloss; do
    "$program" "$root/samples/$scene.mci" --photons "$photons" --ignore-absorption --quiet -o "$out"
done
# a map has as many pixels as a profile has bins, squared
for scene in skinmap camera; do
    "$program" "$root/samples/$scene.mci" --photons "${photons}0" --ignore-absorption --quiet -o "$out"
done
awk 'BEGIN { print "detector2.x"; for (i = 2; i <= 9; i++) print i * 0.05 }' >"$out/distances.csv"
"$program" "$root/samples/fibres.mci" --sweep "$out/distances.csv" --photons "$((photons / 3))" --ignore-absorption --quiet -o "$out"

flat="Solid: this program, $photons packets, with a band of one standard error. Dashed: the report's curves of CUDAMCML and of \
the program of 2019, read from its graphics, where its flat scenes are sound: they agree within print and noise."
kernel="Solid: this program, $photons packets, with a band of one standard error; dotted: the heightfield, on top and bottom. Dashed: the \
report's curves of 2019. The flat one is sound. The others differ because that program's surfaces were not those drawn: the \
outer half of the samples became a staircase of planes, normals were off by 17 to 89 degrees"
draw() { # FIGURE CAPTION FILES...
    figure=$1 caption=$2
    shift 2
    (cd "$out" && "$program" plot "$@" --caption "$caption" --quiet -o "$figure.svg")
    echo "$out/$figure.svg"
}
curves=$here/figures
draw figure5 "$flat" fig5.mco "$curves/fig5-CUDAMCML-2019.csv" "$curves/fig5-clustermcml-2019.csv"
draw figure6 "$flat" fig6.mco "$curves/fig6-CUDAMCML-2019.csv" "$curves/fig6-clustermcml-2019.csv"
draw figure7 "$flat Made with layers of 0.15 cm, as the report's figure was, not of 1.5 cm as its text says." \
    fig7.mco "$curves/fig7-CUDAMCML-2019.csv" "$curves/fig7-clustermcml-2019.csv"
draw figure8 "$kernel, and light on the axis passed the tips unhindered." flat50.mco lohill.mco hihill.mco \
    "$curves/flat50-2019.csv" "$curves/lohill-2019.csv" "$curves/hihill-2019.csv"
draw figure9 "$kernel, its packets began at z = 0, above the crater's floor, and light that left could not come back." flat50.mco locrater.mco hicrater.mco "$curves/flat50-2019.csv" "$curves/locrater-2019.csv" \
    "$curves/hicrater-2019.csv"
draw figure10 "$kernel, crossings were missed, and light that left could not come back, without which hinoise reflects 1.8 \
times as much." flat50.mco lonoise.mco hinoise.mco "$curves/flat50-2019.csv" \
    "$curves/lonoise-2019.csv" "$curves/hinoise-2019.csv"
draw skinmap "Diffuse reflectance of ridged skin in light from the left, 15 degrees above it, ${photons}0 packets; ridges are up to 0.01 cm high. \
Pixels of 0.12 mm: the tenth of them that faces the light most is 2.3 times as bright as the tenth that turns away most." skinmap.h5 --of Rd --percentile 99.9 --linear \
    --label "Ridges of skin, grazing light"
draw furrows "Diffuse reflectance of furrowed skin that goes on for ever, under a disk of light of 0.2 cm in radius from the left, 15 degrees \
above it, $photons packets. The texture repeats every 0.16 cm; the beam does not. Slopes that face the light are a quarter brighter than those that turn away." furrows.h5 --of Rd --percentile 99.9 --linear --label "Furrows of skin, slanting light"
draw vein "Diffuse reflectance of skin at 532 nm over a winding vein, 0.012 cm in radius and 0.014 to 0.034 cm below the surface, under a disk \
of light of 0.35 cm in radius, $photons packets." vein.h5 --of Rd --percentile 99.9 --linear --label "A vein under skin"
draw pattern "Diffuse reflectance of a turbid plate under a projected pattern of stripes, $photons packets." pattern.h5 \
    --of Rd --percentile 99.9 --linear --label "Stripes on a turbid plate"
for scene in fibre lamp glow; do "$program" check "$root/samples/$scene.mci" -o "$out/$scene.svg" >"$out/$scene.txt"; done
draw hill "A slab with and without a hill, $photons packets each." two_runs_hill.mco two_runs_flat.mco --label "with a hill" --label "flat"
draw pulse "Diffuse reflectance of a pulse by time, $photons packets each, over a layer five times as dark from 0.8 cm down, and over none." \
    pulse.mco pulse_even.mco --of Rd_t --label "darker below 0.8 cm" --label "even"
draw head "Fluence in a head at 800 nm, $photons packets, bins of 0.5 mm. Between 1 and 1.2 cm of depth lies the clear fluid around the brain, which guides light." \
    head.mco --of phi_rz --label "Scalp, skull, clear fluid, grey and white matter"
draw gloss "Gloss of a white tile with a wavy glaze, weight per sr, under light that comes down towards +x at 45 degrees, $photons packets." gloss.mco --of Rsp_dir --log \
    --label "Gloss"
draw white "What comes back from inside the same tile." gloss.mco --of Rd_dir --linear --percentile 99 --label "Diffuse part"
draw camera "A hill 0.2 cm high as a camera sees it that stands at -x and looks down at 45 degrees, NA 0.3, focused half way up; light from the other side, 60 degrees \
from the vertical, ${photons}0 packets. On the focused plane a pixel is 0.25 mm." camera.h5 --of detector_cam_map --percentile 99.9 --linear --label "A hill, seen at 45 degrees"
draw fibres "Share of the light of one fibre on furrowed skin that comes into another, both 0.06 cm wide, NA 0.39, by the distance between their axes, $((photons / 3)) packets." \
    fibres.sweep.csv --of detector_far --over detector2.x --log --label "Two fibres on skin"
for figure in figure5 figure6 figure7 figure8 figure9 figure10 hill pulse; do python3 -B "$lib/shrink_svg.py" "$out/$figure.svg"; done
