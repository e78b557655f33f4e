#!/bin/sh
# Every sample with few packets in two of six ways, the next ones in the other ones, or in all where the environment
# has ALL_CASES: as it is, all boundaries as meshes, on the engine reference, and with maps, a volume and facets in .mco
# and .h5 files. For a program that was built with sanitizers: what they find ends it with another exit code than 0, and
# their report is printed. No packet may be lost, and all weight must be accounted for.
# CLUSTERMCML=build-asan/clustermcml sh tests/sanitize/samples.sh
# SPDX-License-Identifier: MIT
. tests/sanitize/lib.sh
ALL_CASES=${ALL_CASES:+all}

turn=0
for sample in samples/*.mci samples/shapes/*.mci; do
    mesh="--boundaries mesh"
    case $ALL_CASES$sample in samples/beads.mci) mesh= ;; esac # its spheres are meshes in ten seconds
    if test "${ALL_CASES:-$turn}" = "${ALL_CASES:-0}"; then
        expect_sound "$sample" --photons 300 --threads 2
        expect_sound "$sample" --photons 100 --engine reference $mesh
    fi
    if test "${ALL_CASES:-$turn}" = "${ALL_CASES:-1}"; then
        expect_sound "$(with_maps B "$sample")" --photons 300 $mesh
        expect_sound "$sample" --photons 100 --engine reference
    fi
    if test "${ALL_CASES:-$turn}" = "${ALL_CASES:-2}"; then
        expect_sound "$sample" --photons 300 --threads 2 $mesh
        expect_sound "$(with_maps A "$sample")" --photons 300 --threads 2
    fi
    turn=$(((turn + 1) % 3))
done
echo "$flights flights"
finish
