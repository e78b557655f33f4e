#!/bin/sh
# Makes the results of a version from its scenes, with a program of that version: make.sh PROGRAM tests/files/compat/VERSION
# A release adds a folder: scenes that use what is new, then this script. Files of earlier versions are never made again.
# SPDX-License-Identifier: MIT
set -eu
program=$(realpath "$1")
cd "$2"
"$program" run layers.mci --quiet
"$program" run shapes.mci --quiet
mkdir stopped
"$program" run layers.mci --photons 3e6 --checkpoint 1 -o stopped --quiet &
sleep 1
kill -TERM $!
wait $! || test $? -eq 75
cp stopped/layers.mco.checkpoint .
if "$program" run layers.mci --part 1/2 --quiet; then # 0.1.0 knew no parts
    "$program" run layers.mci --part 2/2 --quiet
fi
rm -rf stopped ./*.vti ./*.vtp
xz -9ef ./*.mco* ./*.h5
