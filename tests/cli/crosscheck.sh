#!/bin/sh
# Tests crosscheck: every sample without a mesh agrees on all engines. A difference between engines is found, dumped and can
# be traced.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
expect_code 0 devices
grep -q '^0\*\? ' "$work/out" || { echo "no OpenCL device"; exit 77; }

checked=0 turn=0
for sample in samples/*.mci samples/shapes/*.mci; do
    grep -q '^\(#@ \)\?\(m\|i "\)' "$sample" && continue
    turn=$(((turn + 1) % 2)) # every second one, or all where the environment has ALL_CASES
    test $turn = 1 || test -n "${ALL_CASES:-}" || continue
    photons=${ALL_CASES:+4e3}
    case $sample in
        */skin7.mci | */thick.mci | */fig7text.mci) photons=1e3 ;;
    esac
    expect_code 0 crosscheck "$sample" --photons "${photons:-1e3}"
    grep -q '^opencl against .*: agree$' "$work/out" || complain "$sample: $(cat "$work/out")"
    grep -q 'residue [^0]' "$work/out" && complain "$sample: $(cat "$work/out")"
    checked=$((checked + 1))
done
test "$checked" -ge 7 || complain "only $checked samples were checked"

# Packets start in the same way on planes and on meshes: on a mesh without heights every packet has the fate that it has on
# the plane, for any seed.
for seed in 1 2 ${ALL_CASES:+3 4 5 6}; do
    expect_code 0 crosscheck samples/shapes/flat50.mci --photons 1e4 --seed $seed
    grep -q 'equal fates and steps: 100 % (0 of 10000 packets differ; another geometry)' "$work/out" ||
        complain "flat50, seed $seed: $(cat "$work/out")"
done

# Rough cones, planes and bodies use the same source text on a device.
printf '1.0\n1\nrough.mco A\n2000\n0.02 0.02\n20 20 5\n2\n1\nrough ggx 0.4\nb 5 0 0.1 1e-5 0.1 0 0.1 1e-5 0.1 0 0.1\n1.4 1 50 0.8 0.3\n%s\nrough beckmann 0.3\n1.3 1 20 0.8 0.2\nrough ggx 0.6\n1\n' \
    'i sphere 0 0 0.2 0.05 1.5 1 10 0.5 rough=beckmann,0.5' >"$work/rough.mci"
expect_code 0 crosscheck "$work/rough.mci"
grep -q '^opencl against .*: agree$' "$work/out" || complain "rough: $(cat "$work/out")"

# A coarse mesh is another surface than the cones, and crosscheck finds it.
expect_code 1 crosscheck samples/shapes/hinoise.mci --photons 2e4 --tolerance 0.1 --rings inscribed --dump "$work/dump"
grep -q '^cpu (mesh) against cpu (cones): DISAGREE$' "$work/out" || complain "a coarse mesh agrees"
grep -q '^opencl against cpu (cones): agree$' "$work/out" || complain "opencl does not agree"
test "$(cat "$work/err")" = "clustermcml: hinoise.mco: 1 of 2 comparisons disagree" || complain "$(cat "$work/err")"
expect_code 1 crosscheck samples/shapes/hinoise.mci --photons 2e4 --tolerance 0.1 --rings inscribed --json
python3 -c 'import json, sys
told = json.loads(sys.stdin.read())
ways = {way["name"]: way for way in told["ways"]}
assert not told["agree"] and not ways["cpu (mesh)"]["agree"] and ways["opencl"]["agree"], told
assert ways["opencl"]["equal"] == told["photons"] == 20000 > ways["cpu (mesh)"]["equal"], told
mean = ways["cpu (mesh)"]["Rd"] - ways["cpu (cones)"]["Rd"]
assert abs(mean - ways["cpu (mesh)"]["differences"]["Rd"]["mean"]) < 1e-9, told' <"$work/out" || complain "--json: $(cat "$work/out")"
photon=$(awk '!/^#/ { print $1; exit }' "$work/dump")
fate=$(awk '!/^#/ { print $2; exit }' "$work/dump")
expect_code 0 trace samples/shapes/hinoise.mci "$photon" --engine opencl
tail -n 1 "$work/out" | grep -q "^# $fate" || complain "photon $photon: dump says $fate, trace $(tail -n 1 "$work/out")"
expect_error 2 "samples/vein.mci:17: body 1 is a mesh (expected spheres and cylinders; the opencl engine flies no meshes)" crosscheck samples/vein.mci
expect_code 2 crosscheck samples/ridges.mci --dump "$work/none"
test ! -e "$work/none" || complain "a refused crosscheck left its dump"
test -z "$(cat "$work/out")" || complain "a refused crosscheck wrote to standard output"
expect_code 3 crosscheck samples/fig5.mci --device 99

# Maps and facets are ignored.
sed "s/^\([0-9].*\)# nz, nr, na/\1\nmap 3 3 0.1 0.1 volume\nfacets #/" samples/fig5.mci >"$work/maps.mci"
grep -q '^facets' "$work/maps.mci" || complain "no facets line"
expect_code 0 crosscheck "$work/maps.mci" --photons 1e3
finish
