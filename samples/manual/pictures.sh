#!/bin/sh
# Draws every picture of the manual: one command per picture. SPDX-License-Identifier: MIT
# sh samples/manual/pictures.sh      needs clustermcml (CLUSTERMCML names another program) and its Python package
set -eu
cd "$(dirname "$0")"
program=$(realpath "${CLUSTERMCML:-../../build/clustermcml}")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# scene PAGE NAME.mci: the scene of a page whose first line is "# NAME.mci", as a file in $folder.
scene() {
    awk -v first="# $2" '/^```/ { on = 0 } start { on = $0 == first } on { print } { start = $0 == "```mci" }' "$1" >"$folder/$2"
    ln -sfn "$(realpath ../../meshes)" "$folder/meshes"
}

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
