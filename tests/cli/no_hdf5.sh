#!/bin/sh
# Tests a program built without HDF5 (CLUSTERMCML_ALONE). It refuses by name every line and option whose results only an .h5
# file holds, and writes nothing. All other scenes give the .mco of the program with HDF5 (CLUSTERMCML), byte by byte, and no
# .h5; sweeps, --classic and --resume too.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
alone=${CLUSTERMCML_ALONE:?names no program}
none="(expected no such line: this program was built without HDF5)"

scene() { # LINE OF_THE_RUN LINE_OF_THE_LAYER FORMAT: writes plain.mci; a line of the run is line 7
    printf '%s\n' 1.0 1 "plain.mco $3" 2000 '0.01 0.02' '20 15 3' ${1:+"$1"} 1 1.0 '1.4 1 90 0.8 0.2' ${2:+"$2"} 1.0 >"$work/plain.mci"
}

# Both programs agree on the lines that need an .h5: report_files.c lists the quantities that do not fit into an .mco.
refused() { # NUMBER WORD: plain.mci
    expect_error 2 "$work/plain.mci:$1: line = $2 $none" "$work/plain.mci" --quiet -o "$work/got"
}

mkdir "$work/got" "$work/expected"
program=$alone
for line in 'map 4 4 0.1 0.1' facets 'time 100 5' 'directions 3 4' fluence 'detector disk 0.1 na=0.2' 'photons "exits"'; do
    scene "$line" "" A
    refused 7 "${line%% *}"
done
scene "" 'i sphere 0 0 0.1 0.05  1.5 1 10 0.9' A
refused 10 i
scene "" 'backing 0.5' A
refused 10 backing
scene "" "" B
expect_error 2 "$work/plain.mci:3: format = B (expected A: this program was built without HDF5)" "$work/plain.mci" --quiet -o "$work/got"
scene "" "" A
expect_error 2 "run: --derivatives (expected none: this program was built without HDF5)" "$work/plain.mci" --derivatives --quiet -o "$work/got"
expect_error 2 "run: --aim (expected none: this program was built without HDF5)" "$work/plain.mci" --aim Tt --quiet -o "$work/got"
test -z "$(ls -A "$work/got")" || complain "refused runs wrote $(ls -A "$work/got")"

# Checks that both programs wrote these files in the folder got alike, and no other file.
same() {
    for file in "$@"; do
        for side in got expected; do sed -e '/^# User time/d' -e '/^# clustermcml/d' "$work/$side/$file" >"$work/$side.text"; done
        cmp -s "$work/got.text" "$work/expected.text" || complain "$file has other bytes without HDF5"
    done
    test "$(ls "$work/got")" = "$(printf '%s\n' "$@")" || complain "without HDF5 there is $(ls "$work/got"), not $*"
    rm -f "$work/got"/* "$work/expected"/*
}
both() { # ARGUMENTS...
    program=${CLUSTERMCML:-$PWD/build/clustermcml}
    expect_code 0 "$@" --quiet -o "$work/expected"
    program=$alone
    expect_code 0 "$@" --quiet -o "$work/got"
}
both "$work/plain.mci"
same plain.mco
both "$work/plain.mci" --classic
same plain.mco
both samples/two_runs.mci --photons 2000
same two_runs_flat.mco two_runs_hill.mco
printf '%s\n' layer1.mua 0.5 2 >"$work/rows.csv"
both "$work/plain.mci" --sweep "$work/rows.csv"
rm -f "$work/got"/*.sweep.csv
same plain-0001.mco plain-0002.mco

expect_code 0 "$work/plain.mci" --quiet -o "$work/got"
before=$(stat -c %Y.%i "$work/got/plain.mco")
expect_code 0 "$work/plain.mci" --resume --quiet -o "$work/got"
test "$(stat -c %Y.%i "$work/got/plain.mco")" = "$before" || complain "--resume flew a finished run again"
finish
