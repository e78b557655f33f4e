#!/bin/sh
# --control flat: scene and twin on several ranks have the bytes of one, also where rank 0 decides how many photons fly.
# SPDX-License-Identifier: MIT
. tests/lib/cluster.sh

for options in "--photons 20000" "--photons 100 --target-error 0.02"; do
    expect_code 0 samples/shapes/lonoise.mci $options --control flat --threads 1 --quiet -o "$work"
    mv "$work/lonoise.mco" "$work/expected"
    grep -q '^control #' "$work/expected" || complain "$options: no section"
    for shape in "1 2" "2 1" "4 1"; do
        set -- $shape
        ranks "$1" samples/shapes/lonoise.mci $options --control flat --threads "$2" --quiet -o "$work"
        expect_bits "$options on $1 ranks x $2 threads" "$work/lonoise.mco" "$work/expected"
    done
done
expect_ranks_error 2 2 "--control flat (expected no --ignore-heightfields beside it)" samples/shapes/lonoise.mci \
    --control flat --ignore-heightfields
finish
