#!/bin/sh
# Draws every picture of the manual: one command per picture. SPDX-License-Identifier: MIT
# sh samples/manual/pictures.sh      needs clustermcml (CLUSTERMCML names another program) and its Python package
set -eu
cd "$(dirname "$0")"
program=$(realpath "${CLUSTERMCML:-../../build/clustermcml}")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Writes the scene of a page to $folder. `scene PAGE NAME.mci` takes the block whose first line is "# NAME.mci".
scene() {
    awk -v first="# $2" '/^```/ { on = 0 } start { on = $0 == first } on { print } { start = $0 == "```mci" }' "$1" >"$folder/$2"
    ln -sfn "$(realpath ../../meshes)" "$folder/meshes"
}

# Runs the blocks of a page in a folder of its own, and keeps pictures that its commands draw: `page PAGE DRAWN=KEPT
# ...`. A block of Python runs with all those before it, whose names it may use.
page() {
    text=$(realpath "$1")
    shift
    work=$(mktemp -d "$folder/page.XXXXXX")
    ln -s "$(realpath ..)" "$work/samples"
    ln -s "$(realpath ../../meshes)" "$work/meshes"
    awk '
        /^```/ && kind { if (kind != "sh") print "END_OF_BLOCK"; if (kind == "python") print "python3 names.py"; kind = ""; next }
        /^```(mci|python|sh)$/ { kind = substr($0, 4); first = 1; if (kind == "python") print "cat >>names.py <<\"END_OF_BLOCK\"\nimport clustermcml as mc"; next }
        kind == "mci" && first { print "cat >" $2 " <<\"END_OF_BLOCK\"" }
        kind { print; first = 0 }' "$text" >"$work/blocks.sh"
    printf "svg.hashsalt: clustermcml\nsvg.fonttype: none\n" >"$work/matplotlibrc" # equal numbers give equal bytes
    mkdir "$work/bin"
    ln -s "$program" "$work/bin/clustermcml"
    (cd "$work" && SOURCE_DATE_EPOCH=0 PATH=$work/bin:$PATH CLUSTERMCML=$program PYTHONPATH=$(realpath samples/../src/python) sh -eu blocks.sh >/dev/null)
    for kept; do
        cp "$work/${kept%%=*}" "pictures/${kept#*=}"
    done
}

# input
scene input/index.md skin.mci
"$program" view "$folder/skin.mci" -o pictures/input_skin.svg
python3 pictures_input.py input_grid
scene input/layers.md skin3.mci
"$program" view "$folder/skin3.mci" -o pictures/input_layers.svg
scene input/boundaries.md shapes.mci
"$program" view "$folder/shapes.mci" -o pictures/input_boundaries.svg
python3 pictures_input.py input_tile
python3 pictures_input.py input_reliefs
python3 pictures_input.py input_rough
scene input/bodies.md bodies.mci
"$program" view "$folder/bodies.mci" -o pictures/input_bodies.svg
python3 pictures_input.py input_phase
python3 pictures_input.py input_backing
scene input/faces.md pair.mci
"$program" view "$folder/pair.mci" -o pictures/faces.svg
"$program" view ../foil.mci -o pictures/input_foil.svg
python3 pictures_input.py input_mcml
python3 pictures_beams.py beam_shapes
python3 pictures_beams.py beam_light
python3 pictures_beams.py beam_axis
scene input/beams.md three_beams.mci
"$program" view "$folder/three_beams.mci" -o pictures/three_beams.svg
python3 pictures_beams.py detector
python3 pictures_beams.py scores
scene input/detectors.md hill.mci
"$program" run "$folder/hill.mci" --photons 4e6 -o "$folder" --quiet
"$program" plot "$folder/hill.h5" --of detector_cam_map --linear --percentile 99.5 --title "A hill, lit from the right" \
    -o pictures/hill_camera.svg
scene input/saved-packets.md exits.mci
"$program" run "$folder/exits.mci" -o "$folder" --quiet
python3 pictures_beams.py saved_packets "$folder/exits.photons.h5"
scene input/sweeps.md slab.mci
printf 'skin.mua,skin.mus\n0.1,50\n0.2,50\n0.4,50\n0.1,100\n0.2,100\n0.4,100\n' >"$folder/table.csv"
"$program" run "$folder/slab.mci" --sweep "$folder/table.csv" -o "$folder" --quiet
"$program" plot "$folder/slab.sweep.csv" --of Rd --over skin.mua --by skin.mus -o pictures/sweep.svg

# Draws pictures of some 1e7 packets, which bench/README.md and README also show.
python3 ../../bench/accuracy/figures.py --program "$program" --out "$folder/figures"
rsvg-convert -w 620 "$folder/figures/skin.svg" -o pictures/skin.png
for kept in furrows=tutorial-furrows head=tutorial-head camera=tutorial-camera gloss=tutorial-gloss \
    vein=recipe-vein pattern=recipe-pattern glow=recipe-glow pulse=recipe-pulse; do
    cp "$folder/figures/${kept%%=*}.svg" "pictures/${kept#*=}.svg"
done

# tutorial
page tutorial/01-flat-skin.md flat.svg=tutorial-flat.svg
page tutorial/02-rough-top.md ridges.svg=tutorial-ridges.svg horizon.svg=tutorial-horizon.svg
page tutorial/04-figure.md beside.svg=tutorial-beside.svg
page tutorial/06-vessel.md section.svg=tutorial-vessel.svg
page tutorial/09-spectrum.md spectrum.svg=tutorial-spectrum.svg
page tutorial/10-roughness.md heights.svg=tutorial-heights.svg
page tutorial/12-light.md fibre.svg=tutorial-apertures.svg bars.svg=tutorial-bars.svg
page tutorial/13-pulse.md pulse.svg=tutorial-pulse.svg
page tutorial/15-clear-layer.md depth.svg=tutorial-depth.svg

# recipes
page recipes/my-fibre-probe.md probe.svg=recipe-probe.svg
page recipes/lamp.md lamp.svg=recipe-lamp.svg
page recipes/paint-over-backing.md hiding.svg=recipe-hiding.svg
CLUSTERMCML=$program PYTHONPATH=../../src/python python3 ../rough_pictures.py "$folder" 1e6
cp "$folder/paint_gloss.svg" pictures/recipe-gloss.svg
cp "$folder/ground_glass.svg" pictures/recipe-haze.svg
cp "$folder/frosted_bead.svg" pictures/recipe-bead.svg
CLUSTERMCML=$program PYTHONPATH=../../src/python python3 ../paint_brdf.py pictures 1e5 && rm pictures/*.rgb.bsdf # needs Mitsuba 3
CLUSTERMCML=$program PYTHONPATH=../../src/python python3 ../skin_profile.py "$folder" 0.01
cp "$folder/skin_profile.svg" pictures
CLUSTERMCML=$program PYTHONPATH=../../src/python python3 ../materials.py "$folder" 0.02 profiles repository # recipes/materials.md, too
page recipes/spectrum.md blood.svg=recipe-spectrum.svg
page recipes/fit.md fit.svg=recipe-fit.svg
python3 pictures_recipes.py cluster pictures/recipe-cluster.svg
python3 pictures_recipes.py totals pictures/recipe-totals.svg
page recipes/stop-and-resume.md more.svg=recipe-more.svg
page recipes/gpu.md rings.svg=recipe-rings.svg
page recipes/original-mcml.md hill.svg=recipe-hill.svg

# output and python
"$program" run ../two_runs.mci --photons 1e6 -o "$folder" --quiet
"$program" plot "$folder/two_runs_flat.mco" "$folder/two_runs_hill.mco" --of Rd_r --label flat --label hill --xrange 0:0.9 -o pictures/output-plot.svg
"$program" run ../skinmap.mci --photons 1e6 -o "$folder" --quiet
"$program" plot "$folder/skinmap.h5" --of Rd --linear --label "R(x, y) of samples/skinmap.mci" -o pictures/output-map.svg
"$program" view ../mixed.mci -o pictures/python-view.svg
cp ../../bench/accuracy/results/summary-amd-epyc-2core.svg pictures/validation.svg

# instruments
page recipes/watts.md watts.svg=recipe-watts.svg
page recipes/integrating-sphere.md ports.svg=recipe-sphere.svg
python3 pictures_recipes.py phantom pictures/recipe-phantom.svg
