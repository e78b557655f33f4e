#!/bin/sh
# Photons per second of the opencl engine:
#     opencl.sh [--device I] [--seconds S] [--rounds N] [--cpu] [--program PATH]
# Prints one row per scene: S1 to S6, the shape flat50 and the hill, as plane and as cones. The first run of a scene
# builds the kernel and is not timed; the number of photons is then raised until a run takes S seconds (default 2), and
# the median of N runs (default 5) is printed with its least and most. --cpu times the cpu engine in the same rounds.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/../lib/lib.sh"
device= seconds=2 rounds=5 cpu=
options cpu "device seconds rounds program" "$@"
need_number --seconds "$seconds"
need_number --rounds "$rounds"
need_program
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fly() { # ENGINE PHOTONS SCENE OPTIONS...: one JSON line
    engine=$1 photons=$2
    shift 2
    [ "$engine" = cpu ] || set -- "$@" ${device:+--device "$device"}
    "$program" "$@" --engine "$engine" --photons "$photons" --json -o "$work"
}

value() { # KEY, JSON on standard input
    sed "s/.*\"$1\":\([^,}]*\).*/\1/"
}

# Photons of a run that takes about the wanted time, at most 1e11.
calibrate() { # ENGINE SCENE OPTIONS...
    engine=$1 photons=10000
    shift
    while :; do
        took=$(fly "$engine" "$photons" "$@" | value seconds)
        next=$(awk -v n="$photons" -v t="$took" -v s="$seconds" 'BEGIN {
            if (t >= s / 2 || n >= 1e11) exit
            factor = t > 0 ? 1.2 * s / t : 20
            printf "%.0f", n * (factor > 20 ? 20 : factor)
        }')
        [ -n "$next" ] || break
        photons=$next
    done
    echo "$photons"
}

# median (least-most) of numbers, one per line
median() { # FORMAT
    sort -g | awk -v f="$1" '{ x[NR] = $1 } END {
        m = NR % 2 ? x[(NR + 1) / 2] : (x[NR / 2] + x[NR / 2 + 1]) / 2
        printf f " (" f "-" f ")", m, x[1], x[NR]
    }'
}

row() { # NAME SCENE OPTIONS...
    name=$1 scene=$2
    shift 2
    for engine in opencl ${cpu:+cpu}; do
        fly "$engine" 1000 "$scene" "$@" >/dev/null
        calibrate "$engine" "$scene" "$@" >"$work/$engine.photons"
        : >"$work/$engine"
    done
    round=0
    while [ $round -lt "$rounds" ]; do
        for engine in opencl ${cpu:+cpu}; do
            fly "$engine" "$(cat "$work/$engine.photons")" "$scene" "$@" --seed $((round + 1)) >>"$work/$engine"
        done
        round=$((round + 1))
    done
    for engine in opencl ${cpu:+cpu}; do
        lost=$(value lost <"$work/$engine" | awk '{ n += $1 } END { print n }')
        printf '| %s | %s | %s | %s | %s | %s |\n' "$name" "$engine" "$(cat "$work/$engine.photons")" \
            "$(value photons_per_s <"$work/$engine" | median %.3g)" \
            "$(value ns_per_step <"$work/$engine" | median %.3g)" "$lost"
    done
}

cd "$root"
"$program" --version
"$program" devices
echo
echo "| case | engine | photons | photons/s | ns/step | lost |"
echo "|---|---|---|---|---|---|"
row S1 samples/fig5.mci
row S2 samples/fig6.mci
row S3 samples/fig7text.mci
row S4 samples/mcml_sample.mci
row S5 samples/skin7.mci
row S6a samples/thick.mci
row S6b bench/lib/scenes/S6b.mci
row flat50 samples/shapes/flat50.mci
row flat50-cones samples/shapes/flat50.mci --boundaries cone
row hihill samples/shapes/hihill.mci
row hinoise samples/shapes/hinoise.mci
