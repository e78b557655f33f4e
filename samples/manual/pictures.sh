#!/bin/sh
# Draws every picture of the manual: one command per picture. SPDX-License-Identifier: MIT
# sh samples/manual/pictures.sh      needs clustermcml (CLUSTERMCML names another program) and its Python package
set -eu
cd "$(dirname "$0")"
program=$(realpath "${CLUSTERMCML:-../../build/clustermcml}")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# output and python
"$program" run ../two_runs.mci --photons 1e6 -o "$folder" --quiet
"$program" plot "$folder/two_runs_flat.mco" "$folder/two_runs_hill.mco" --of Rd_r --label flat --label hill --xrange 0:0.9 -o pictures/output-plot.svg
"$program" run ../skinmap.mci --photons 1e6 -o "$folder" --quiet
"$program" plot "$folder/skinmap.h5" --of Rd --linear --label "R(x, y) of samples/skinmap.mci" -o pictures/output-map.svg
"$program" view ../mixed.mci -o pictures/python-view.svg
