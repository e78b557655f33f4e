#!/bin/sh
# Every sample with few packets in three of six ways, the next one in the other three, or in all where the environment
# has ALL_CASES: as it is, all boundaries as meshes, on the engine reference, and with maps, a volume and facets in .mco
# and .h5 files. For a program that was built with sanitizers: what they find ends it with another exit code than 0, and
# their report is printed. No packet may be lost, and all weight must be accounted for.
# CLUSTERMCML=build-asan/clustermcml sh tests/sanitize/samples.sh
# SPDX-License-Identifier: MIT
. tests/sanitize/lib.sh
ALL_CASES=${ALL_CASES:+all}

odd=1
for sample in samples/*.mci samples/shapes/*.mci; do
    if test "$odd$ALL_CASES" != 0; then
        expect_sound "$sample" --photons 300 --threads 2
        expect_sound "$sample" --photons 100 --engine reference --boundaries mesh
        expect_sound "$(with_maps B "$sample")" --photons 300 --boundaries mesh
    fi
    if test "$odd$ALL_CASES" != 1; then
        expect_sound "$sample" --photons 300 --threads 2 --boundaries mesh
        expect_sound "$sample" --photons 100 --engine reference
        expect_sound "$(with_maps A "$sample")" --photons 300 --threads 2
    fi
    odd=$((1 - odd))
done
echo "$flights flights"
finish
