#!/bin/sh
# Tests rough boundaries: alpha 0 and equal indices give the bytes of the smooth scene, a tiny alpha gives its totals. Also
# tests threads, settings, sweeps, backings, the words of check and the summary, and refusals.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
scene() { # NAME TOP BOTTOM [N]
    printf '1.0\n1\n%s.mco A\n20000\n0.01 0.01\n20 20 5\n1\n1\n%s\n%s 1 50 0.8 0.3\n%s\n1\n' "$1" "$2" "${4:-1.4}" "$3" >"$work/$1.mci"
}
plain() { sed -e '/^# User time/d' -e '/output file name/d' -e '/^rough /d' "$1"; }
totals() { sed -n '/^RAT/,/^$/s/ *#.*//p' "$1" | sed 1d; }

scene smooth '# nothing' '# nothing'
scene zero 'rough ggx 0' 'rough beckmann 0'
expect_code 0 "$work/smooth.mci" --quiet -o "$work"
expect_code 0 "$work/zero.mci" --quiet -o "$work"
plain "$work/smooth.mco" >"$work/a"
plain "$work/zero.mco" >"$work/b"
cmp -s "$work/a" "$work/b" || complain "alpha 0 is not smooth: $(diff "$work/a" "$work/b" | head -5)"

scene matched 'rough ggx 1' 'rough beckmann 1' 1
scene matched0 '# nothing' '# nothing' 1
expect_code 0 "$work/matched.mci" --quiet -o "$work"
expect_code 0 "$work/matched0.mci" --quiet -o "$work"
plain "$work/matched.mco" | grep -v '^# boundary' >"$work/a"
plain "$work/matched0.mco" | grep -v '^# boundary' >"$work/b"
cmp -s "$work/a" "$work/b" || complain "equal indices are rough: $(diff "$work/a" "$work/b" | head -5)"

# Facets turned by 1e-4 change no total beyond its errors, some 0.003.
for kind in ggx beckmann; do
    scene fine "rough $kind 1e-4" "rough $kind 1e-4"
    expect_code 0 "$work/fine.mci" --quiet --seed 2 -o "$work"
    totals "$work/fine.mco" >"$work/a"
    totals "$work/smooth.mco" | paste - "$work/a" | awk 'NF == 2 { n++; if (($1 - $2) ^ 2 > 0.012 ^ 2) exit 1 } END { exit n != 4 }' ||
        complain "$kind 1e-4 is not smooth: $(totals "$work/smooth.mco" | paste - "$work/a")"
done

scene both 'rough ggx 0.3' 'rough beckmann 0.5'
expect_code 0 "$work/both.mci" -o "$work"
grep -q '^  boundary 0: plane at z = 0 cm, rough ggx 0.3 (no surface given)$' "$work/out" &&
    grep -q '^  boundary 1: plane at z = 0.3 cm, rough beckmann 0.5 (no surface given)$' "$work/out" &&
    grep -q 'books: residue 0,.* lost 0$' "$work/out" || complain "the summary: $(cat "$work/out")"
mv "$work/both.mco" "$work/threads.mco"
expect_code 0 "$work/both.mci" --quiet --threads 1 -o "$work"
plain "$work/both.mco" >"$work/a"
plain "$work/threads.mco" | cmp -s - "$work/a" || complain "one thread has other bytes"
totals "$work/smooth.mco" | paste - "$work/a" | cmp -s "$work/a" - && complain "rough is smooth"

# Settings give the bytes of a file that holds the number.
scene set 'rough ggx 0.1' 'rough beckmann 0'
expect_code 0 "$work/set.mci" --quiet --set boundary0.alpha=0.3 --set boundary1.alpha=0.5 -o "$work"
totals "$work/set.mco" >"$work/a"
totals "$work/both.mco" | cmp -s - "$work/a" || complain "--set boundary0.alpha: $(cat "$work/a")"
printf 'boundary0.alpha,boundary1.alpha\n0.3,0.5\n0,0\n' >"$work/table.csv"
expect_code 0 "$work/set.mci" --quiet --sweep "$work/table.csv" -o "$work"

# check --json lists roughness for rough boundaries and bodies, and for no others.
printf '1.0\n1\nx.mco A\n200\n0.02 0.02\n20 20 5\n2\n1\nrough ggx 0.6\n1.4 1 20 0.8 0.5\ni sphere 0 0 0.2 0.05 1.5 1 10 0.5 rough=beckmann,0.5\ni sphere 0 0 0.4 0.05 1.5 1 10 0.5\n1.5 1 20 0.8 0.5\nrough ggx 0\n1\n' >"$work/told.mci"
expect_code 0 check "$work/told.mci" --json
python3 - "$work/out" <<'EOF' || complain "check --json: $(cat "$work/out")"
import json, sys
told = json.load(open(sys.argv[1]))
assert [b.get("rough") for b in told["boundaries"]] == [{"kind": "ggx", "alpha": 0.6}, None, None]
assert [b.get("rough") for b in told["bodies"]] == [{"kind": "beckmann", "alpha": 0.5}, None]
EOF

# trace prints one line for each event at a rough boundary, with each engine that traces.
shape() { # NAME RIPPLE
    printf '1.0\n1\n%s.mco A\n20000\n0.02 0.02\n20 20 5\n1\n1\nrough ggx 0.6\nb 5 0 0.1 %s 0.1 0 0.1 %s 0.1 0 0.1\n1.4 1 20 0.8 0.5\ni sphere 0 0 0.2 0.05 1.5 1 10 0.5 rough=beckmann,0.5\nrough beckmann 0.8\n1\n' "$1" "$2" "$2" >"$work/$1.mci"
}
shape hill 0.03
for photon in 0 1 2 3; do
    expect_code 0 trace "$work/hill.mci" "$photon"
    grep -v '^#.*photon' "$work/out" >"$work/a"
    test "$(grep -c '^# rough: [1-9][0-9]* steps\?$' "$work/a")" -eq "$(grep -c ' \(reflect\|transmit\) ' "$work/a")" || complain "trace of photon $photon: $(cat "$work/a")"
    expect_code 0 trace "$work/hill.mci" "$photon" --engine reference
    test "$(grep -c '^# rough' "$work/out")" -gt 0 || complain "no rough event of photon $photon on engine reference"
done
for photon in 0 1 2 3 4 5 6 7 8 9; do "$program" trace "$work/hill.mci" "$photon"; done | grep -q '^# rough: [2-9] steps$' || complain "no walk of two steps"

# A nearly flat surface becomes a plane of the same roughness.
shape ripple 1e-6
sed -i '/^i sphere/d' "$work/ripple.mci"
expect_code 0 "$work/ripple.mci" --tolerance 0.05 -o "$work"
grep -q '^  boundary 0: plane at z = 0 cm, rough ggx 0.6 (radial heightfield, as a plane' "$work/out" || complain "--tolerance: $(cat "$work/out")"

# --aim below the last rough boundary has expected values, and only there.
scene aimed 'rough ggx 0.6' '# nothing'
expect_code 0 "$work/aimed.mci" --aim Tt --json --quiet -o "$work"
python3 -c 'import json, sys
told = json.loads(sys.stdin.read())
assert told["Tt_expected"] and abs(told["Tt"] - told["Tt_expected"]) < 4 * told["Tt_se"], told' <"$work/out" || complain "--aim Tt: $(cat "$work/out")"
expect_code 0 "$work/both.mci" --aim Tt --json --quiet -o "$work"
! grep -q Tt_expected "$work/out" || complain "--aim Tt knows what comes out of a rough face"

# A rough mirror absorbs nothing. A facet with reflectance R that light meets twice absorbs twice.
scene mirror '# nothing' 'rough ggx 1
backing 1 mirror'
expect_code 0 "$work/mirror.mci" -o "$work"
grep -q '^  A_backing 0.000000' "$work/out" || complain "a perfect mirror keeps light: $(grep -i backing "$work/out")"

# Adding-doubling walks on facets a stated number of times, with the same result in each call. A run compares its totals with
# it, and `check` says so beforehand.
expect_code 0 exact "$work/both.mci"
cp "$work/out" "$work/a"
grep -q 'adding-doubling, order [0-9]*, 524288 walks at each rough boundary$' "$work/out" &&
    grep -Eq '^  Rd   0\.[0-9]{9} \+- 0\.000[0-9]*$' "$work/out" || complain "exact: $(cat "$work/out")"
expect_code 0 exact "$work/both.mci"
cmp -s "$work/out" "$work/a" || complain "exact says something else the second time"
expect_code 0 "$work/both.mci" -o "$work"
grep -Eq '^  Tt   0\.[0-9]{6} \+- 0\.[0-9]{6}   exact 0\.[0-9]{7} \+- 0\.00[0-9]*$' "$work/out" || complain "run: $(cat "$work/out")"
expect_code 0 check "$work/both.mci"
grep -q 'by adding-doubling: Rsp 0\.0' "$work/out" || complain "check: $(cat "$work/out")"

refused() { # LINE MESSAGE
    scene bad "$1" '# nothing'
    expect_error 2 "$work/bad.mci:9: boundary 0: $2" check "$work/bad.mci"
}
refused 'rough' 'rough is missing (expected ggx or beckmann)'
refused 'rough phong 0.2' 'rough = phong (expected ggx or beckmann)'
refused 'rough ggx' 'rough alpha is missing (expected 0, or a number of 1e-4..2)'
refused 'rough ggx 3' 'rough alpha = 3 (expected 0, or a number of 1e-4..2)'
refused 'rough ggx 1e-5' 'rough alpha = 1e-5 (expected 0, or a number of 1e-4..2)'
refused 'rough ggx 0.2 0.3' 'rough alpha = 0.3 (expected the end of the line or a comment)'
scene bad 'rough ggx 0.2
rough ggx 0.3' '# nothing'
expect_error 2 "$work/bad.mci:10: line = rough ggx 0.3 (expected one rough line for boundary 0, which already has line 9)" check "$work/bad.mci"
scene bad '# nothing' 'rough ggx 0.2
backing 0.8 lambertian'
expect_error 2 "$work/bad.mci:12: backing = lambertian (expected mirror or metal beside a rough line: light from a lambertian backing has no facets)" check "$work/bad.mci"
printf '1.0\n1\nbad.mco A\n20\n0.01 0.01\n20 20 5\n1\n1\n1.4 1 50 0.8 0.3\ni sphere 0 0 0.1 0.01 1.5 0 0 0 rough=ggx\n1\n' >"$work/bad.mci"
expect_error 2 "$work/bad.mci:10: body 1: rough = ggx (expected ggx,ALPHA or beckmann,ALPHA, with ALPHA 0, or a number of 1e-4..2)" check "$work/bad.mci"
# Other words behind a layer are ignored, like in original MCML. Roughness is refused there, because it needs a line of its
# own.
for word in rough=ggx,0.3 "rough ggx 0.3"; do
    printf '1.0\n1\nbad.mco A\n20\n0.01 0.01\n20 20 5\n1\n1\n1.4 1 50 0.8 0.3 %s\n1\n' "$word" >"$work/bad.mci"
    expect_error 2 "$work/bad.mci:9: layer 1 = $word (expected a line \`rough KIND ALPHA\` before the layer whose top it is)" check "$work/bad.mci"
done
printf '1.0\n1\nbad.mco A\n20\n0.01 0.01\n20 20 5\n1\n1\n1.4 1 50 0.8 0.3 rough skin\n1\n' >"$work/bad.mci"
expect_code 0 check "$work/bad.mci"
# Text behind a sphere is ignored, but text that looks like an option must be one. A tab separates words, too.
words() { # WORDS
    printf '1.0\n1\nbad.mco A\n20\n0.01 0.01\n20 20 5\n1\n1\n1.4 1 50 0.8 0.3\ni sphere 0 0 0.1 0.01 1.5 0 0 0%b\n1\n' "$1" >"$work/bad.mci"
}
words '\trough=ggx,0.3 a bubble # rough=ggx,9'
expect_code 0 check "$work/bad.mci"
grep -q '^  body 1: sphere .*, rough ggx 0.3, in layer 1' "$work/out" || complain "rough= behind a tab: $(cat "$work/out")"
words ' rough=ggx,0.3 rough=beckmann,1'
expect_error 2 "$work/bad.mci:10: body 1: rough = beckmann,1 (expected this option only once)" check "$work/bad.mci"
words ' rogh=ggx,0.3'
expect_error 2 "$work/bad.mci:10: body 1: option = rogh=ggx,0.3 (expected rough=KIND,ALPHA, or none)" check "$work/bad.mci"
words ' rough ggx 0.3'
expect_error 2 "$work/bad.mci:10: body 1: option = rough (expected rough=KIND,ALPHA, or none)" check "$work/bad.mci"
expect_code 2 check "$work/both.mci" --set layer1.alpha=0.1
grep -q 'boundary0..1.alpha' "$work/err" || complain "the names of --set: $(cat "$work/err")"
finish
