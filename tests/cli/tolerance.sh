#!/bin/sh
# Tests --tolerance: the boundaries that become planes, those that do not, and the stated reasons. Every command, engine,
# number of threads and resumed run flies the same surfaces. Without --tolerance no curved boundary becomes a plane.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

scene() { # NAME BEAM NR-LINES N-ABOVE SURFACE LAYER N-BELOW
    printf '1.0\n1\n%s.mco A\n20000\nbeam %s\n%s\n50 50 10\n1\n%s\n%s\n%s\n%s\n' "$@" >"$work/$1.mci"
}
# Height times mut plus slope is below the tolerance in these scenes; the change that a plane makes is not (stat.tolerance).
scene grazing "pencil at=-0.02,0 angle=88.9" "0.01 0.01" 1.0 "b 2 0.002 0.05 0 0.05" "1.4 0.5 0.5 0 1" 1.0
scene critical "disk 0.05 angle=42.2" "0.01 0.01" 1.5 "b 2 0.0015 0.1 0 0.1" "1.0 0.1 1 0 1" 1.0
lens=$(awk 'BEGIN { n = 41; printf "b %d", n
    for (i = 0; i < n; i++) printf " %.9g %.9g", 0.00225 * (1 - (i / (n - 1))^2), 1 / (n - 1) }')
scene lens "disk 0.9" "1 0.1" 1.0 "$lens" "1.59 0 0 0 100" 1.59
for case in grazing:0.05 critical:0.02 lens:0.01; do
    expect_code 0 check "$work/${case%:*}.mci" --tolerance "${case#*:}"
    grep -q "boundary 0: cone at .*, as a plane [A-Z][a-z_]* is off by more than ${case#*:})" "$work/out" ||
        complain "$case: $(grep 'boundary 0' "$work/out")"
done

# A heightmap with a bump, and one that is level but for a tenth of a micrometre.
map() { # NAME HEIGHT
    { printf 'ncols 5\nnrows 5\nxllcorner 0\nyllcorner 0\ncellsize 0.1\n'
        printf '0 0 0 0 0\n0 0 0 0 0\n0 0 %s 0 0\n0 0 0 0 0\n0 0 0 0 0\n' "$2"; } >"$work/$1.asc"
    scene "$1" "pencil" "0.02 0.02" 1.0 "m \"$1.asc\" units=cm" "1.4 1 10 0 0.5" 1.0
}
map bump 0.02
map level 1e-5
expect_code 0 check "$work/bump.mci" --tolerance 0.05
grep -q "boundary 0: mesh at .*, as a plane [A-Z][a-z_]* is off by more than 0.05)" "$work/out" || complain "$(cat "$work/out")"
expect_code 0 check "$work/level.mci" --tolerance 0.05
grep -q "boundary 0: plane at z = 0 cm (mesh, as a plane [A-Z][a-z_]* is off by at most 0.0[0-4]" "$work/out" ||
    complain "$(cat "$work/out")"

scene ripple pencil "0.02 0.02" 1.0 "b 5 0 0.1 1e-5 0.1 0 0.1 1e-5 0.1 0 0.1" "1.4 1 10 0 0.5" 1.0
for quiet in ripple level; do
    for options in "" "--boundaries auto" "--boundaries mesh --tolerance 0.05"; do
        expect_code 0 check "$work/$quiet.mci" $options
        grep -q "boundary 0: \(cone\|mesh\) at z = 0 cm" "$work/out" || complain "$quiet $options: $(cat "$work/out")"
        ! grep 'boundary 0:.*as a plane' "$work/out" || complain "$quiet $options was tried as a plane"
    done
done

# The choice of surfaces is the same for all options: compares all lines of the .mco, which names it, but time, engine and
# seed.
choice() { # OPTIONS...
    expect_code 0 "$work/ripple.mci" --tolerance 0.05 --quiet -o "$work" "$@"
    grep '^# *boundary\|boundary 0' "$work/ripple.mco"
}
first=$(choice --threads 1)
case $first in *"plane at z = 0 cm (radial heightfield, as a plane "*) ;; *) complain "ripple: $first" ;; esac
for options in "--threads 3" "--chunk 7" "--seed 9" "--engine reference" "--ignore-absorption" "--photons 7"; do
    # shellcheck disable=SC2086 # several words on purpose
    test "$(choice $options)" = "$first" || complain "$options: $(choice $options)"
done
expect_code 0 devices
! grep -q '^0\*\? ' "$work/out" || test "$(choice --engine opencl)" = "$first" || complain "opencl: $(choice --engine opencl)"
choice --seed 4 --threads 1 >"$work/none"
grep -v '^# User time' "$work/ripple.mco" >"$work/one"
choice --seed 4 --threads 3 >"$work/none"
grep -v '^# User time' "$work/ripple.mco" | cmp -s - "$work/one" || complain "3 threads: other bits"

# A stopped run continues with the same surfaces. The signal may also come after the end of the run.
long="$work/ripple.mci --tolerance 0.05 --photons 1e6 -o $work"
expect_code 0 $long --quiet
grep -v '^# User time' "$work/ripple.mco" >"$work/one"
"$program" $long --threads 1 >"$work/out" 2>"$work/err" &
run=$!
until grep -qs "^  boundary 1" "$work/out" || ! kill -0 $run; do sleep 0.02; done
kill -TERM $run
code=0
wait $run || code=$?
test $code -eq 75 || test $code -eq 0 || complain "SIGTERM: exit $code"
expect_code 0 $long --quiet --resume
grep -v '^# User time' "$work/ripple.mco" | cmp -s - "$work/one" || complain "resumed: other bits"
finish
