#!/bin/sh
# Flies every sample with few packets in two of six ways, in turns, or in all six if the environment has ALL_CASES.
# The ways: unchanged, all boundaries as meshes, with the engine reference, and with maps, a volume and facets in .mco and .h5
# files. The program must be built with sanitizers: a report ends it with another exit code than 0 and is printed. No packet
# may be lost, and all weight must be accounted for. CLUSTERMCML=build-asan/clustermcml sh tests/sanitize/samples.sh
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
