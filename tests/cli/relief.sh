#!/bin/sh
# Tests random reliefs: the words of check, factors and shifts, equal bytes from equal seeds, energy balance, and refusals.
# The heightmap that mesh writes is the same surface.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
scene() { # NAME LINE
    printf '1.0\n1\n%s.mco A\n5000\n0.01 0.01\n20 20 5\nbeam rectangle 0.0128 0.0128\n1\n1\n%s\n1.4 1 50 0.8 0.3\n1\n' "$1" "$2" >"$work/$1.mci"
}
drawn() { # FILE: rms height, rms slope, correlation length of what check printed
    sed -n 's/^    drawn: rms height \([^ ]*\) cm, rms slope \([^ ]*\), correlation length \([^ ]*\) cm, over a period$/\1 \2 \3/p' "$1"
}

scene one 'm gaussian 0.3 0.002 tile seed=4 points=64'
expect_code 0 check "$work/one.mci"
grep -q 'tile of boundary 0: 64 x 64 heights, 0.0002 x 0.0002 cm apart, repeated every 0.0128 x 0.0128 cm' "$work/out" ||
    complain "check does not describe the tile: $(cat "$work/out")"
drawn "$work/out" | awk '{ exit !($2 == 0.3 && $3 > 0.0015 && $3 < 0.0025) }' || complain "what was drawn: $(drawn "$work/out")"

# Factors of --set scale heights and slopes, or all lengths.
expect_code 0 check "$work/one.mci"
drawn "$work/out" >"$work/plain"
expect_code 0 check "$work/one.mci" --set boundary0.height=0.5 --set boundary0.scale=2
drawn "$work/out" | paste - "$work/plain" | awk '{ exit !($2 == 0.15 && $1 - $4 < 1e-9 && $4 - $1 < 1e-9 && $3 - 2 * $6 < 1e-8 && 2 * $6 - $3 < 1e-8) }' ||
    complain "a scaled relief: $(drawn "$work/out"), plain $(cat "$work/plain")"

# The file that mesh writes, read again, has the same slopes in single precision and gives the same light within errors.
expect_code 0 mesh "$work/one.mci" -o "$work"
grep -q "one period as heights -> $work/one.mco.boundary0.gsf" "$work/out" || complain "mesh: $(cat "$work/out")"
scene read 'm "one.mco.boundary0.gsf" tile'
expect_code 0 check "$work/one.mci"
sed -n 's/.*rms slope \(.*\), mean.*/\1/p' "$work/out" >"$work/a"
expect_code 0 check "$work/read.mci"
sed -n 's/.*rms slope \(.*\), mean.*/\1/p' "$work/out" >"$work/b"
paste "$work/a" "$work/b" | awk '{ exit !($1 > 0.2 && ($1 - $2) ^ 2 < 1e-10) }' || complain "slopes drawn $(cat "$work/a"), read $(cat "$work/b")"
for name in one read; do expect_code 0 "$work/$name.mci" --quiet -o "$work"; done
sed -n '/^RAT/,/^$/p' "$work/one.mco" >"$work/a"
sed -n '/^RAT/,/^$/p' "$work/read.mco" >"$work/b"
paste "$work/a" "$work/b" | awk 'NR > 1 && NF > 2 { n++; if (($1 - $(NF / 2 + 1)) ^ 2 > 1e-4) exit 1 } END { exit n != 4 }' ||
    complain "drawn: $(cat "$work/a") read: $(cat "$work/b")"

# A seed always gives the same surface, and another seed gives another one.
scene again 'm gaussian 0.3 0.002 tile seed=4 points=64'
scene other 'm gaussian 0.3 0.002 tile seed=5 points=64'
for name in one again other; do
    expect_code 0 mesh "$work/$name.mci" -o "$work"
done
cmp -s "$work/one.mco.boundary0.gsf" "$work/again.mco.boundary0.gsf" || complain "the same seed is another surface"
cmp -s "$work/one.mco.boundary0.gsf" "$work/other.mco.boundary0.gsf" && complain "another seed is the same surface"

# Original MCML ignores the line, and so does --ignore-heightfields.
scene hidden '#@ m gaussian 0.3 0.002 tile spectrum=fractal:0.7 points=32 shift=0,0,0.001'
expect_code 0 check "$work/hidden.mci"
grep -q '^  boundary 0: mean height 0.001 cm over a period$' "$work/out" || complain "a shifted relief: $(grep mean "$work/out")"
expect_code 0 check "$work/hidden.mci" --ignore-heightfields
grep -q 'drawn' "$work/out" && complain "an ignored relief was drawn"

refused() { # LINE MESSAGE
    scene bad "$1"
    expect_error 2 "$work/bad.mci:10: boundary 0: $2" check "$work/bad.mci"
}
refused 'm gaussian' 'rms slope is missing (expected a number of 1e-4..10)'
refused 'm gaussian 20 0.1 tile' 'rms slope = 20 (expected a number of 1e-4..10)'
refused 'm gaussian 0.2 tile' 'length = tile (expected a correlation length of 1e-30..1e30 cm)'
refused 'm gaussian 0.2 0.01' 'option is missing (expected the word tile: a drawn relief is repeated)'
refused 'm gaussian 0.2 0.01 tile=mirror' 'tile = mirror (expected the word tile alone)'
refused 'm gaussian 0.2 0.01 tile points=100' 'points = 100 (expected a power of two of 16..8192)'
refused 'm gaussian 0.2 0.01 tile seed=-1' 'seed = -1 (expected a whole number of 0..2^53)'
refused 'm gaussian 0.2 0.01 tile spectrum=fractal:1.5' 'spectrum = fractal:1.5 (expected gaussian, exponential, or fractal:H with H of 0.01..1)'
refused 'm gaussian 0.2 0.01 tile skirt=1' 'option = skirt=1 (expected tile, seed=, points=, spectrum=, shift= or normals=)'
finish
