#!/bin/sh
# merge: means weighted by photons and their errors, worked out here; from .mco and .h5, to both, in one step and in two; its
# errors are those of one run of as many photons; equal seeds and different scenes are refused with the first difference.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
cd "$work" || exit 1
root=$OLDPWD
case $program in /*) ;; *) program=$root/$program ;; esac
scene=$root/samples/skinmap.mci
h5=yes
for seed in 1 2 3; do
    mkdir part$seed
    expect_code 0 "$scene" --photons ${seed}0000 --seed $seed --quiet -o part$seed
    test -e part$seed/skinmap.h5 || h5=no
done
expect_code 0 merge part1/skinmap.mco part2/skinmap.mco part3/skinmap.mco -o all.mco --json
grep -q '^{"output":"all.mco","inputs":\["part1/skinmap.mco",.*"photons":60000,"Rsp":.*"Tt_se":[0-9.e-]*,"version":' out || complain "--json: $(cat out)"
expect_code 0 merge part1/skinmap.mco part2/skinmap.mco -o two.mco --quiet
expect_code 0 merge two.mco part3/skinmap.mco -o steps.mco --quiet
files="all.mco steps.mco"
if test $h5 = yes; then
    expect_code 0 merge part1/skinmap.h5 part2/skinmap.h5 part3/skinmap.h5 -o all.h5 --quiet
    expect_code 0 merge part1/skinmap.h5 part2/skinmap.mco part3/skinmap.h5 -o mixed.mco --quiet
fi
expect_code 0 "$scene" --photons 60000 --seed 4 --quiet -o .
mv skinmap.mco one.mco
cat >check.py <<'END'
import math, re, sys

def read(path):
    with open(path) as file:
        text = file.read()
    data, key = {"photons": float(re.search(r"(\d+) \t\t\t# No. of photons", text).group(1))}, None
    for line in text[text.index("\nRAT"):].splitlines():
        words = line.split("#")[0].split()
        if words and re.fullmatch(r"[A-Za-z]\w*", words[0]):
            key = words.pop(0)
            data[key] = []
        if key:
            data[key] += map(float, words)
    return data

parts = [read(f"part{seed}/skinmap.mco") for seed in (1, 2, 3)]
total = sum(part["photons"] for part in parts)
one, bad = read("one.mco"), 0
for path in sys.argv[1:]:
    merged = read(path)
    assert merged["photons"] == total
    for key in ("RAT", "A_l", "A_z", "Rd_r", "Rd_a", "Tt_r", "Tt_a", "A_rz", "Rd_ra", "Tt_ra", "books"):
        for i, value in enumerate(merged[key]):
            mean = sum(part["photons"] * part[key][i] for part in parts) / total
            bad += abs(value - mean) > 3e-4 * abs(mean) + 1e-12  # numbers have five digits
    for key in ("se_RAT", "se_A_z", "se_Rd_r", "se_Rd_a", "se_Tt_r", "se_Tt_a"):
        for i, value in enumerate(merged[key]):
            error = math.sqrt(sum((part["photons"] * part[key][i]) ** 2 for part in parts)) / total
            bad += abs(value - error) > 3e-4 * error
    # against one run of as many photons: errors of totals from 64 batches are known to 9 %
    for i in (1, 2):
        ratio = merged["se_RAT"][i] / one["se_RAT"][i]
        z = (merged["RAT"][i] - one["RAT"][i]) / math.hypot(merged["se_RAT"][i], one["se_RAT"][i])
        bad += not 0.6 < ratio < 1.6 or abs(z) > 4
    assert merged["residue"] == [0] and merged["lost"] == [0]
sys.exit(f"{bad} wrong numbers" if bad else 0)
END
test $h5 = no || files="$files mixed.mco"
python3 check.py $files >texts 2>&1 || complain "$files: $(cat texts)"
if test $h5 = yes; then
    expect_error 2 "part1/skinmap.h5: seed = 1, run 1 (expected a seed that all.h5 does not have)" merge all.h5 part1/skinmap.h5 -o out.h5
    expect_code 0 compare all.mco all.h5 --alpha 0.5
    expect_error 2 "merge: -o out.mco (expected an .h5: none of the results says n of the media outside)" \
        merge part1/skinmap.h5 part2/skinmap.h5 -o out.mco
    sed -e 's/angle=75/angle=70/' -e "s,\"../meshes/,\"$root/meshes/," "$scene" >other.mci
    expect_code 0 other.mci --photons 100 --seed 8 --quiet -o .
    expect_code 2 merge part1/skinmap.h5 skinmap.h5 -o out.h5
    grep -q '^clustermcml: skinmap.h5: scene = scene beam disk 0.5 angle=70 .* (expected scene beam disk 0.5 angle=75 ' err || complain "a beam: $(cat err)"
fi
expect_error 2 "part1/skinmap.mco: seed = 1, run 1 (expected a seed that two.mco does not have)" merge two.mco part1/skinmap.mco -o out.mco
expect_code 0 "$scene" --photons 100 --seed 9 --set layer1.mua=0.5 --quiet -o .
expect_error 2 "skinmap.mco: layer1.mua = 0.5 (expected 5, as in part1/skinmap.mco)" merge part1/skinmap.mco skinmap.mco -o out.mco
expect_code 0 "$scene" --photons 100 --seed 9 --set boundary0.height=0.5 --quiet -o .
expect_error 2 "skinmap.mco: scene = set boundary0.height = 0.5 (expected boundary 0: mesh at z = 0 cm, 5000 triangles (mesh, a regular grid), as in part1/skinmap.mco)" \
    merge part1/skinmap.mco skinmap.mco -o out.mco
expect_error 2 "merge: -o is missing (expected the name of the result, .mco or .h5)" merge two.mco part3/skinmap.mco
expect_error 2 "merge: -o a.txt (expected a name that ends in .mco or .h5)" merge two.mco part3/skinmap.mco -o a.txt
expect_error 2 "merge: -o two.mco would overwrite its input two.mco" merge two.mco part3/skinmap.mco -o two.mco
sed '/^# merged/d' two.mco >bare.mco
expect_error 2 "bare.mco: has no seed or no standard errors (expected a result of this program)" merge bare.mco part3/skinmap.mco -o out.mco
test ! -e out.mco && test ! -e out.h5 || complain "a refused merge wrote"
finish
