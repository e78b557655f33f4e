#!/bin/sh
# Tests --aim, which computes expected values of light below a level. Counted results must not change, gates and detectors
# included. Expected values must have the same bytes for any number of threads, with --keep and --more. Quantities that cannot
# be aimed at are refused by name. stat.tail judges the numbers.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
warm_python
mkdir "$work/a" "$work/b" "$work/c" "$work/d"
grid='20000\n0.01 0.01\n20 20 3\ntime 100 4\ndetector disk 0.2\nfluence\n'
hill='b 3 0.05 0.1 -0.05 0.2 0 0.1\n'
bodies='i sphere 0 0 0.45 0.05 1.5 1 20 0.5\n'
scene() { # LAYERS: number, index above, and lines up to that of the medium below
    printf '1.0\n1\nx.mco A\n%b%b1.0\n' "$grid" "$1" >"$work/x.mci"
}
layers="3\n1.0\n${hill}1.4 1 60 0.8 0.3\n1.5 2 20 0.5 0.1\n1.33 0.5 5 0 0.2\n"
scene "$layers"

# Prints an .mco without the expected values of --aim and without its time.
counted() { # FILE
    awk '/^(se_)?(Tt|A_l)_expected #/ { skip = 1 } !skip; /^$/ { skip = 0 }' "$1" | sed '/^# User time/d' | cat -s
}
same() { # TEXT A B
    sed '/^# User time/d' "$2" >"$work/1"
    sed '/^# User time/d' "$3" >"$work/2"
    cmp -s "$work/1" "$work/2" || complain "$1: other bytes"
}

expect_code 0 "$work/x.mci" --quiet -o "$work/a"
for options in "--threads 1" "--threads 3 --chunk 7" "--threads 2 --chunk 1e6"; do
    # shellcheck disable=SC2086 # several options on purpose
    expect_code 0 "$work/x.mci" --aim Tt,A_l:3 $options --quiet -o "$work/b"
    test -e "$work/c/x.mco" || cp "$work/b/x.mco" "$work/b/x.h5" "$work/c"
    same "$options" "$work/b/x.mco" "$work/c/x.mco"
done
counted "$work/a/x.mco" >"$work/plain"
counted "$work/b/x.mco" | cmp -s - "$work/plain" || complain "--aim changes what is counted"
for key in Tt_expected A_l_expected se_Tt_expected se_A_l_expected; do
    whole "$work/b/x.mco" | grep -q "^$key #" || complain "no $key"
done
expect_code 0 "$work/x.mci" --aim A_l:2 --photons 12001 --keep --threads 2 --quiet -o "$work/b"
expect_code 0 "$work/x.mci" --aim A_l:2 --more 7999 --quiet -o "$work/b"
same "--more" "$work/b/x.mco" "$work/c/x.mco"
expect_code 2 "$work/x.mci" --more 5 --quiet -o "$work/b"
grep -q "of another run: 'aim A_l:2' there, 'no aim' here" "$work/err" || complain "extended without --aim: $(cat "$work/err")"
expect_code 0 "$work/x.mci" --aim Tt -o "$work/b"
grep -Eq '^  Tt   0\.[0-9]+ \+- [0-9.e-]+ expected, as by [0-9.]+ times the photons$' "$work/out" ||
    complain "summary: $(cat "$work/out")"
grep -Eq '^  A of layer 3 0\.[0-9]+ \+- [0-9.e-]+ expected' "$work/out" || complain "summary: $(cat "$work/out")"

expect_code 0 "$work/x.mci" --aim Tt --seed 2 --quiet -o "$work/a"
of() { whole "$2" | sed -n "/^$1 #/{n;p;}"; }

# Expected values are tested by `compare`, stand in the tables of a sweep, and are printed by `plan` beside Tt.
expect_code 0 compare "$work/a/x.mco" "$work/c/x.mco"
grep -q '^Tt_expected 1 bins in 1 tests, worst z ' "$work/out" && grep -q '^A_l_expected 3 bins in 4 tests, .* at ' "$work/out" ||
    complain "compare: $(cat "$work/out")"
"$CLUSTERMCML_PYTHON" -c 'import h5py, sys
with h5py.File(sys.argv[1], "r+") as file: file["Tt_expected"][()] *= 1.1' "$work/c/x.h5"
expect_code 1 compare "$work/a/x.mco" "$work/c/x.mco"
printf 'layer2.mua\n2\n4\n' >"$work/t.csv"
expect_code 0 "$work/x.mci" --aim Tt --sweep "$work/t.csv" --quiet -o "$work/d"
awk -F, -v tt="$(of Tt_expected "$work/b/x.mco")" -v a="$(of A_l_expected "$work/b/x.mco")" '
    NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i }
    NR == 2 { t = $at["Tt_expected"] / tt - 1; l = $at["layer1.A_expected"] / a - 1; se = $at["layer3.A_expected_se"] }
    END { exit !(t * t < 1e-9 && l * l < 1e-9 && se > 0) }' "$work/d/x.sweep.csv" || complain "sweep: $(cat "$work/d/x.sweep.csv")"
expect_code 0 plan "$work/x.mci" --photons 2048
grep -q ' Tt_expected *$' "$work/out" || complain "plan: $(cat "$work/out")"

# Refusals of wrong aims and limits.
some='an aim that at least 1e-20 of the light reaches, not 0'
grid='20000\n0.01 0.01\n20 20 3\n'
scene "$layers"
file=$work/x.mci:3
expect_error 2 "$file: --aim Rd (expected Tt, Tt_r, A_l:N of layer N or the name of a detector)" "$work/x.mci" --aim Rd --quiet -o "$work/d"
for name in Tt, Tt,A_l:0 A_l:01 A_l:+1 A_l:1x; do
    expect_error 2 "--aim $name (expected Tt, Tt_r, A_l:N of layer N or the name of a detector, or several with commas)" "$work/x.mci" --aim $name
done
expect_error 2 "$file: --aim A_l:1 (expected a layer from 2 to 3, with others above it)" "$work/x.mci" --aim Tt,A_l:1 --quiet -o "$work/d"
expect_error 2 "$file: --aim A_l:4 (expected a layer from 2 to 3, with others above it)" "$work/x.mci" --aim A_l:4 --quiet -o "$work/d"
if "$program" devices 2>/dev/null | grep -q '^0'; then
    expect_code 2 "$work/x.mci" --aim Tt --engine opencl --boundaries cone --quiet -o "$work/d"
    grep -q -- '--aim and --engine opencl' "$work/err" || complain "opencl: $(cat "$work/err")"
fi
scene "1\n1.0\n1.4 1 60 0.8 0.3\nbacking 0.5\n"
expect_error 2 "$file: --aim Tt (expected no backing)" "$work/x.mci" --aim Tt --quiet -o "$work/d"
squares="no line map, facets, directions, photons or detector map: this aim splits packets"
for line in 'map 2 2 0.1 0.1' 'facets' 'directions 3 3' 'detector map 2 2 0.1 0.1' 'photons "p"'; do
    grid="20000\n0.01 0.01\n20 20 3\n$line\n"
    scene "1\n1.0\n1.4 1 60 0.8 0.3\n"
    expect_error 2 "$file: --aim Tt_r (expected $squares)" "$work/x.mci" --aim Tt_r --quiet -o "$work/d"
    expect_code 0 "$work/x.mci" --aim Tt --photons 100 --quiet -o "$work/d"
done
grid='20000\n0.01 0.01\n20 20 3\n'
scene "$layers"
expect_error 2 "--derivatives (expected no --aim beside it that splits packets)" \
    "$work/x.mci" --aim Tt_r --derivatives --quiet -o "$work/d"
grid='20000\n0.01 0.01\n20 20 3\ntime 100 4\ndetector disk 0.2\nfluence\n'
scene "1\n1.0\n1.4 100 60 0.8 30\n"
expect_error 2 "$file: --aim Tt_r (expected $some)" "$work/x.mci" --aim Tt_r --quiet -o "$work/d"
grid='20000\n0.01 0.01\n20 20 3\ndetector disk 0.2 name=Tt\n'
scene "1\n1.0\n1.4 1 60 0.8 0.3\n"
expect_error 2 "$file: --aim Tt (expected another name for the detector: Tt and Tt_r mean light that leaves below)" "$work/x.mci" --aim Tt --quiet -o "$work/d"
scene "1\n1.0\n1.4 1 60 0.8 0.3\n"
expect_error 2 "$file: --aim A_l:1 (expected Tt: there is one layer)" "$work/x.mci" --aim A_l:1 --quiet -o "$work/d"

# A quantity below 1e-20 of the light, too small for its sum, is refused as an aim; beside another aim it is printed as 0.
grid='20000\n0.01 0.01\n20 20 3\n'
scene "2\n1.0\n1.4 1 60 0.8 0.3\n1.4 1 100 0.9 12\n1.0\n"
least="expected an aim that at least 1e-20 of the light reaches"
expect_error 2 "$file: --aim Tt ($least)" "$work/x.mci" --aim A_l:2,Tt --quiet -o "$work/d"
expect_code 0 "$work/x.mci" --photons 1000 --aim A_l:2 -o "$work/d"
grep -qx '  Tt   0 +- 0 expected' "$work/out" || complain "Tt of 1e-30: $(grep Tt "$work/out")"
scene "3\n1.0\n1.4 1 60 0.8 0.3\n1.4 1 100 0.9 12\n1.4 1 100 0.9 1\n1.0\n"
expect_error 2 "$file: --aim A_l:3 ($least)" "$work/x.mci" --aim A_l:3 --quiet -o "$work/d"

# A detector that has seen nothing is proposed as an aim if it can be one; otherwise plan says why it cannot.
unseen() { # WORDS-BEHIND LINES-OF-THE-GRID
    grid="100\n0.01 0.01\n20 20 3\n$2\n"
    scene "1\n1.0\n1.4 1 60 0.8 0.3\n"
    expect_code 0 "$work/x.mci" -o "$work/d"
    grep -qx "  detector far: saw none of 100 photons$1" "$work/out" || complain "unseen: expected $1, got $(grep detector "$work/out")"
}
far='detector disk 0.01 at=2,0 name=far'
unseen '; --aim far would split packets on their way to it' "$far"
unseen '' "$far\nphotons \"p\""
expect_code 0 plan "$work/x.mci" --photons 1024
grep -qx "  without aim: $file: --aim far (expected $squares)" "$work/out" || complain "plan: $(cat "$work/out")"
unseen '' 'detector ring 0.001 0.2 na=0.0001 name=far'

# An aim is checked for all rows and runs before the first one flies.
unflown() { # MESSAGE ARGUMENTS
    rm -rf "$work/none"
    mkdir "$work/none"
    message=$1
    shift
    expect_error 2 "$message" "$@" --quiet -o "$work/none"
    test -z "$(ls "$work/none")" || complain "$message: wrote $(ls "$work/none")"
}
grid='100\n0.01 0.01\n20 20 3\n'
scene "2\n1.0\n1.4 1 50 0.8 0.2\n1.5 2 30 0.7 0.2\n${hill}"
expect_error 2 "$file: --aim A_l:1 (expected layer 2, with another above it)" "$work/x.mci" --aim A_l:1 --quiet -o "$work/d"
printf 'layer2.mua\n2\n1e5\n' >"$work/t.csv"
for aim in Tt Tt_r; do
    unflown "$work/t.csv:3: row 2, layer2.mua = 1e5: $file: --aim $aim (expected $some)" "$work/x.mci" --sweep "$work/t.csv" --aim $aim
done
printf 'layer1.d\n0.2\n1e8\n' >"$work/t.csv"
unflown "$work/t.csv:3: row 2, layer1.d = 1e8: $file: --aim A_l:2 (expected $some)" "$work/x.mci" --sweep "$work/t.csv" --aim A_l:2
{ sed 's/^1$/2/' "$work/x.mci" && sed -n '3,$p' "$work/x.mci" | sed 's/x.mco/y.mco/; s/^1.5 2 30/1.5 1e5 3e4/'; } >"$work/y.mci"
unflown "$work/y.mci:13: --aim Tt (expected $some)" "$work/y.mci" --aim Tt
# An error that only the flight finds names the row, and no result is written.
awk -v mci="$work/m.mci" -v csv="$work/t.csv" 'BEGIN {
    n = 60
    printf "1.0\n1\nm.mco A\n100\n0.01 0.01\n10 10 3\n%d\n1.0\nb 3 0.001 0.05 0.0 0.05 0.0005 0.1\n", n >mci
    for (i = 1; i <= n; i++) print "1.4 0.1 5 0.8 0.02" >mci
    print "1.0" >mci
    for (r = 0; r < 3; r++)
        for (i = 1; i <= n; i++) printf "%s%s", r == 0 ? "layer" i ".n" : r == 2 ? 1 + 0.02 * i : 1.4, i < n ? "," : "\n" >csv
}'
expect_code 2 "$work/m.mci" --sweep "$work/t.csv" --aim Tt --quiet -o "$work/d"
grep -q "^clustermcml: $work/t.csv:3: row 2, layer1.n = 1.02, .*: $work/m.mci:3: --aim Tt: adding-doubling takes more than 640 directions$" "$work/err" ||
    complain "found in flight: $(cat "$work/err")"
test ! -e "$work/d/m.sweep.csv" || complain "found in flight: wrote a table"
grid='20000\n0.01 0.01\n20 20 3\ntime 100 4\ndetector disk 0.2\nfluence\n'

# An aim flies in weight windows, without expected values, if it is named as counted (Tt_r), if a shape reaches below, or if
# the level does not lie above its layer.
windows() { # OPTIONS: in force, without expected values, and the same bytes on any threads
    rm -f "$work"/[abc]/x.mco
    # shellcheck disable=SC2086,SC2048
    expect_code 0 "$work/x.mci" $* --threads 1 -o "$work/a"
    grep -q ' parts of packets a photon were split off$' "$work/out" && ! grep -q ' expected' "$work/out" || complain "$*: $(cat "$work/out")"
    # shellcheck disable=SC2086,SC2048
    expect_code 0 "$work/x.mci" $* --threads 3 --chunk 7 --quiet -o "$work/b"
    same "$*" "$work/a/x.mco" "$work/b/x.mco"
}
scene "2\n1.0\n1.4 1 60 0.8 0.8\n1.4 1 60 0.8 0.3\nb 3 0.05 0.1 -0.05 0.2 0 0.1\n"
expect_code 0 plan "$work/x.mci" --photons 2048
grep -Eq '^  Through planes in place of all shapes comes [0-9.e-]+ of the light: --aim Tt_r would' "$work/out" || complain "plan: $(cat "$work/out")"
slits='detector rectangle 0.02 0.02 at=0.6,0 name=square\ndetector rectangle 0.0005 0.8 at=0.6,0 name=slit\ndetector rectangle 0.02 0.02 at=0.6,0 na=0.25 name=narrow\n'
grid="100\n${slits}0.01 0.01\n20 20 3\n"
scene "2\n1.0\n1.4 1 60 0.8 0.8\n1.4 1 60 0.8 0.3\nb 3 0.05 0.1 -0.05 0.2 0 0.1\n"
expect_code 0 plan "$work/x.mci" --photons 2048
sed -n 's/.*--aim [sn].* would take some \([0-9.e+]*\) times less time for it.$/\1/p' "$work/out" | paste -s |
    awk '{ exit !($1 / $2 > 8 && $1 / $2 < 10 && $3 / $1 > 3.3 && $3 / $1 < 3.6) }' || complain "plan, slit, aperture: $(cat "$work/out")"
sed -n 's/^  Through planes .* sees some \([0-9.e-]*\) of the light: .*/\1/p' "$work/out" | paste -s |
    awk '{ exit !($1 == $2 && $1 / $3 > 8 && $1 / $3 < 32) }' || complain "plan, aperture's share: $(cat "$work/out")"
grid='20000\n0.01 0.01\n20 20 3\ntime 100 4\ndetector disk 0.2\nfluence\n'
scene "2\n1.0\n1.4 1 60 0.8 0.8\n1.4 1 60 0.8 0.3\nb 3 0.05 0.1 -0.05 0.2 0 0.1\n"
windows --aim Tt
windows --aim A_l:2
windows --aim Tt_r
mv "$work/b/x.mco" "$work/deep.mco"
mv "$work/b/x.h5" "$work/deep.h5"
# The aim is a detector, alone or together with expected values.
grid='20000\n0.01 0.01\n20 20 3\ntime 100 4\ndetector disk 0.05 at=0.3,0 name=near\ndetector disk 0.05 at=-0.6,0 name=far\n'
scene "2\n1.0\n1.4 1 60 0.8 0.8\n1.4 1 60 0.8 0.3\nb 3 0.05 0.1 -0.05 0.2 0 0.1\n"
windows --aim far
mv "$work/a/x.mco" "$work/far.mco"
mv "$work/a/x.h5" "$work/far.h5"
windows --aim near,near
# with so many packets that some come to the other detector, too
expect_code 0 "$work/x.mci" --aim near --photons 300000 --seed 2 --quiet -o "$work/d"
expect_code 0 compare "$work/d/x.mco" "$work/far.mco" --alpha 1e-4
expect_code 0 "$work/x.mci" --aim near --photons 12001 --keep --threads 2 --quiet -o "$work/c"
expect_code 0 "$work/x.mci" --aim near --more 7999 --quiet -o "$work/c"
same "--more" "$work/c/x.mco" "$work/b/x.mco"
expect_code 2 "$work/x.mci" --more 5 --quiet -o "$work/c"
grep -q "of another run: 'aim near' there, 'no aim' here" "$work/err" || complain "extended without windows: $(cat "$work/err")"
expect_code 0 "$work/x.mci" --aim near --seed 2 --quiet -o "$work/d"
# --error-of DETECTOR with --aim: the run ends at the error asked for and not before; plan estimates the photons for a flight
# with the same aim.
expect_code 0 "$work/x.mci" --aim far --photons 2048 --target-error 0.02 --error-of far --json -o "$work/d"
cp "$work/out" "$work/until"
expect_code 0 plan "$work/x.mci" --aim far --photons 4096 --target-error 0.02 --error-of far --json
python3 - "$work/until" "$work/out" <<'PYTHON' || complain "--error-of: $(cat "$work/until" "$work/out")"
import json, sys
until, plan = (json.load(open(path)) for path in sys.argv[1:])
assert until["detector_far_se"] <= 0.02 * until["detector_far"] and until["photons"] > 20000
assert all(0.3 < row["error_of"]["photons"] / until["photons"] < 2 for row in plan["plans"]) and not plan["gains"]
PYTHON
expect_code 0 plan "$work/x.mci" --photons 1024 --error-of A_l:2 --aim near
grep -q ' A_l:2 *$' "$work/out" && grep -qx '  All of this is with --aim near.' "$work/out" || complain "plan --error-of: $(cat "$work/out")"
expect_error 2 "--error-of (expected --target-error beside it)" "$work/x.mci" --error-of far
# without --aim as counted, which takes more photons than what is expected
for aim in "" "--aim A_l:2"; do
    # shellcheck disable=SC2086
    expect_code 0 plan samples/fibres.mci --photons 2048 --error-of A_l:2 --json $aim
    sed 's/.*"error_of":{"photons":\([0-9.e+]*\).*/\1/' "$work/out"
done >"$work/photons"
awk 'NR == 1 { counted = $1 } END { exit !(counted > 1.5 * $1) }' "$work/photons" || complain "plan of counted A_l: $(cat "$work/photons")"
# one packet has a mean and no error of it; the summary says how little has come, and how many photons flew
expect_code 0 samples/fibres.mci --photons 500 --seed 5 -o "$work/d"
grep -Eqx '  detector near [0-9.]+ \+- [0-9.]+, of 1 of 64 batches: too few to trust' "$work/out" || complain "one packet: $(cat "$work/out")"
whole "$work/d/fibres.mco" | grep -A1 '^se_detector_near_path' | grep -q NAN || complain "an error of one packet: $(whole "$work/d/fibres.mco" | grep -A1 detector_near_path)"
expect_code 0 samples/thick.mci --photons 2000 --target-error 0.02 -o "$work/d"
grep -q '^thick.mco: at least 2000 photons' "$work/out" && grep -Eq '^  .* s, [0-9]{5,} photons, ' "$work/out" || complain "--target-error: $(cat "$work/out")"
for name in far,near A_l:01 A_l:+1; do
    expect_error 2 "--error-of $name (expected A_l:N of layer N or the name of a detector)" "$work/x.mci" --error-of $name
done
expect_code 2 "$work/x.mci" --target-error 0.03 --photons 20000 --aim near --resume --error-of A_l:2 --quiet -o "$work/c"
grep -q "of another run: 'no error_of' there, 'error_of A_l:2' here" "$work/err" || complain "another --error-of: $(cat "$work/err")"
for name in none A_l:3; do
    expect_error 2 "$file: --error-of $name (expected A_l:N of layer 1 to 2, or the name of a detector)" "$work/x.mci" --target-error 0.1 --error-of $name --quiet -o "$work/d"
done
only="expected one detector, and beside it only Tt and A_l:N of flat layers below all shapes"
for aim in far,near near,Tt_r A_l:2,near; do
    expect_error 2 "$file: --aim $aim ($only)" "$work/x.mci" --aim $aim --quiet -o "$work/d"
done
scene "$layers"
expect_code 0 "$work/x.mci" --aim Tt,far -o "$work/a"
grep -q ' expected' "$work/out" && grep -q ' were split off$' "$work/out" || complain "--aim Tt,far: $(cat "$work/out")"
grid='20000\n0.01 0.01\n20 20 3\ntime 100 4\ndetector disk 0.2\nfluence\n'
scene "2\n1.0\n1.4 1 60 0.8 0.8\n1.4 1 60 0.8 0.3\nb 3 0.05 0.1 -0.05 0.2 0 0.1\n"
# all scored quantities agree with a plain run: gates, fluence, a detector
expect_code 0 "$work/x.mci" --seed 2 --quiet -o "$work/a"
expect_code 0 compare "$work/a/x.mco" "$work/deep.mco" --alpha 1e-4
# Splitting is limited to 64 parts per event and 1e6 per photon.
limited() { # KEY TEXT, and layers
    scene "$3"
    expect_code 0 "$work/x.mci" --aim "$4" --json -o "$work/a"
    grep -q "\"$1\":[1-9]" "$work/out" || complain "no $1: $(cat "$work/out")"
    expect_code 0 "$work/x.mci" --aim "$4" -o "$work/a"
    grep -Eq "^  [0-9]+ splits into $2\$" "$work/out" || complain "$2: $(cat "$work/out")"
}
grid='4000\n0.01 0.01\n20 20 3\ndetector rectangle 0.005 0.005 at=2,0 name=far\n'
limited spent 'fewer parts than wanted: of a photon come at most 1e6 on average' "1\n1.0\n1.4 0.3 120 0.8 3\n" far
limited clipped '64 parts, the most, of packets that were to have more' "1\n1.0\n1.4 30 5 0.8 0.5\n" Tt_r
finish
