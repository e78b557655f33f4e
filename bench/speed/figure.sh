#!/bin/sh
# Draws a result of speed.sh: figure.sh speed.csv speed.svg (or .png). Needs gnuplot.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/../lib/lib.sh"
[ $# -eq 2 ] || fail "usage: figure.sh speed.csv speed.svg"
need gnuplot
[ -r "$1" ] || fail "$1: cannot be read"
case $2 in *.png) terminal=pngcairo ;; *) terminal=svg ;; esac
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# one file per series, by medium, surface and kind, and one for the ratio to original MCML
grep -v '^#' "$1" | awk -F, -v work="$work" '
    NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
    $at["threads"] == 1 {
        file = work "/" $at["medium"] "-" $at["surface"] "-" $at["kind"]
        print $at["primitives"], $at["ns_per_step"], $at["ns_per_step_min"], $at["ns_per_step_max"] >file
    }
    $at["mcml_to_ours"] != "" {
        print $at["case"], $at["mcml_to_ours"], $at["mcml_to_ours_min"], $at["mcml_to_ours_max"] >(work "/mcml")
    }'
bars=0
[ ! -s "$work/mcml" ] || bars=1
gnuplot -e "work='$work'; out='$2'; kind='$terminal'; bars=$bars" "$here/speed.gp"
