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
expect_code 0 merge part1/skinmap.mco part2/skinmap.mco -o two.mco
test "$(cat err)" = "clustermcml: note: replaces two.mco of 30000 photons" || complain "no word of the result replaced: $(cat err)"
expect_code 0 merge two.mco part3/skinmap.mco -o steps.mco --quiet
# What a killed merge left goes, what is another file's stays.
touch all.mco.123-0.tmp other.mco.123-0.tmp
expect_code 0 merge part1/skinmap.mco part2/skinmap.mco part3/skinmap.mco -o all.mco --quiet
test ! -e all.mco.123-0.tmp && test -e other.mco.123-0.tmp && test ! -e all.lock || complain "left: $(ls)"
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
    for key in ("se_RAT", "se_A_z", "se_Rd_r", "se_Rd_a", "se_Tt_r", "se_Tt_a", "se_A_rz", "se_Rd_ra", "se_Tt_ra"):
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
    grep -q '^clustermcml: skinmap.h5: scene = beam disk of radius 0.5 cm .*angle 70, .* (expected beam disk .*angle 75, ' err || complain "a beam: $(cat err)"
fi
expect_error 2 "part1/skinmap.mco: seed = 1, run 1 (expected a seed that two.mco does not have)" merge two.mco part1/skinmap.mco -o out.mco
expect_code 0 "$scene" --photons 100 --seed 9 --set layer1.mua=0.5 --quiet -o .
expect_error 2 "skinmap.mco: layer1.mua = 0.5 (expected 5, as in part1/skinmap.mco)" merge part1/skinmap.mco skinmap.mco -o out.mco
expect_code 0 "$scene" --photons 100 --seed 9 --set boundary0.height=0.5 --quiet -o .
expect_error 2 "skinmap.mco: scene = set boundary0.height = 0.5 (expected beam disk of radius 0.5 cm at (0 0) cm, angle 75, azimuth 0 degrees, as in part1/skinmap.mco)" \
    merge part1/skinmap.mco skinmap.mco -o out.mco
expect_error 2 "merge: -o is missing (expected the name of the result, .mco or .h5)" merge two.mco part3/skinmap.mco
expect_error 2 "merge: -o a.txt (expected a name that ends in .mco or .h5)" merge two.mco part3/skinmap.mco -o a.txt
expect_error 2 "merge: -o two.mco would overwrite its input two.mco" merge two.mco part3/skinmap.mco -o two.mco
sed '/^# merged/d' two.mco >bare.mco
expect_error 2 "bare.mco: has no seed or no standard errors (expected a result of this program)" merge bare.mco part3/skinmap.mco -o out.mco

# What the scene is beyond layers: beam, shapes, bodies, re-entry. differs FIRST-LINE-OF-MESSAGE: a.mci and b.mci are told apart.
differs() {
    expect_code 0 a.mci --seed 1 --quiet -o .
    mv s.mco a.mco
    expect_code 0 b.mci --seed 2 --quiet -o .
    mv s.mco b.mco
    expect_code 2 merge a.mco b.mco -o out.mco
    grep -q "^clustermcml: b.mco: $1" err || complain "expected $1, got $(cat err)"
}
scene() { # LINES-OF-THE-RUN ABOVE BELOW
    printf '1.0\n1\ns.mco A\n100\n0.1 0.1\n3 4 2\n%b1\n1\n%b1.4 0.5 20 0.8 1\n%b1.5\n' "$1" "$2" "$3"
}
scene '' '' '' >a.mci
scene 'beam gaussian 0.1\n' '' '' >b.mci
differs 'scene = beam gaussian of radius 0.1 cm at (0 0) cm, angle 0, azimuth 0 degrees (expected boundary 0: plane'
scene '' 'b 3 0.06 0.1 0.02 0.2 0 1\n' '' >a.mci
scene '' 'b 3 0.07 0.1 0.02 0.2 0 1\n' '' >b.mci
differs 'scene = boundary 0: cone at z = 0 cm, 3 rings (.*), crc32 .* (expected boundary 0: cone at z = 0 cm, 3 rings (.*), crc32 '
sed 's/ 0.250000$/ 0.200000/' "$root/meshes/pyramid.obj" >flatter.obj
cmp -s flatter.obj "$root/meshes/pyramid.obj" && complain "flatter.obj is the pyramid"
scene '' "m \"$root/meshes/pyramid.obj\"\n" '' >a.mci
scene '' 'm "flatter.obj"\n' '' >b.mci
differs 'scene = boundary 0: mesh at z = 0 cm, [0-9]* triangles (.*), crc32 .* (expected boundary 0: mesh'
balls() { # RADIUS: of the last one, behind more than people are shown
    for i in $(seq 24); do printf 'i sphere 0 0 %s 0.01 1.5 1 0 0\n' "$(echo "$i" | awk '{ print $1 * 0.03 }')"; done
    printf 'i sphere 0 0 0.9 %s 1.3 1 0 0\n' "$1"
}
scene '' '' "$(balls 0.05)\n" >a.mci
scene '' '' "$(balls 0.04)\n" >b.mci
differs 'scene = body 25: sphere at (0 0 0.9) cm, r = 0.04 cm, in layer 1; n 1.3, .* (expected body 25: sphere at (0 0 0.9) cm, r = 0.05 cm'
cp a.mci b.mci
expect_code 0 a.mci --photons 5000 --seed 1 --quiet -o .
mv s.mco a.mco
expect_code 0 a.mci --photons 3000 --seed 2 --no-reentry --quiet -o .
expect_error 2 "s.mco: re-entry = off (expected on, as in a.mco)" merge a.mco s.mco -o out.mco
expect_code 0 a.mci --photons 3000 --seed 3 --no-reentry --quiet -o .
mv s.mco c.mco
expect_code 0 a.mci --photons 3000 --seed 4 --no-reentry --quiet -o .
expect_code 0 merge c.mco s.mco -o exits.mco --quiet
expect_error 2 "exits.mco: re-entry = off (expected on, as in a.mco)" merge a.mco exits.mco -o out.mco
expect_code 0 a.mci --photons 3000 --seed 5 --quiet -o .
mv s.mco b.mco
expect_code 0 merge a.mco b.mco -o bodies.mco --quiet
expect_code 0 a.mci --photons 3000 --seed 6 --quiet -o .
mv s.mco c2.mco
section() { awk -v key="$1" '$1 == key { on = 1; next } on && !/^[-+.0-9]/ { exit } on' "$2"; }
section A_body a.mco >a.txt
section A_body b.mco >b.txt
section A_body bodies.mco | paste a.txt b.txt - |
    awk '{ mean = (5 * $1 + 3 * $2) / 8; if (($3 - mean) ^ 2 > 1e-14) bad++; sum += $3 } END { exit !(NR == 25 && sum > 0 && !bad) }' ||
    complain "A_body of bodies.mco: $(section A_body bodies.mco)"
scene '' 'b 3 0.06 0.1 0.02 0.2 0 1\n' '' >a.mci
cp a.mci b.mci
expect_code 0 a.mci --seed 1 --quiet -o .
mv s.mco a.mco
expect_code 0 a.mci --seed 2 --quiet -o .
expect_code 0 merge a.mco s.mco -o rings.mco --quiet
section heightfield0 a.mco >a.txt
section heightfield0 rings.mco | cmp -s a.txt - && test -s a.txt || complain "heightfield0 of rings.mco: $(section heightfield0 rings.mco)"
if test $h5 = yes; then
    scene '' '' "$(balls 0.05)\n" | sed 's/mco A/h5 B/' >a.mci
    expect_code 0 a.mci --photons 5000 --seed 1 --quiet -o .
    mv s.h5 a.h5
    expect_code 0 merge a.h5 b.mco -o bodies.h5 --quiet
    expect_error 2 "c.mco: re-entry = off (expected on, as in bodies.h5)" merge bodies.h5 c.mco -o out.h5
    expect_code 0 merge bodies.h5 c2.mco -o again.mco --quiet
    section A_body again.mco | awk '{ sum += $1 } END { exit !(NR == 25 && sum > 0) }' || complain "A_body of again.mco"
fi

# One packet has no error; three of them have that of their spread, and beside more packets one counts as they do.
scene '' '' '' >a.mci
for seed in 1 2 3; do
    expect_code 0 a.mci --photons 1 --seed $seed -o .
    test "$(grep -c '(one packet: no standard error)' out)" -eq 4 || complain "the summary of one packet: $(cat out)"
    test "$(grep -c '^ *NAN$' s.mco)" -eq 48 || complain "errors of one packet: $(grep -c NAN s.mco), expected 4 + 1 + 3 + 2 (4 + 2) + 12 + 2 4 2"
    mv s.mco one$seed.mco
done
expect_code 0 a.mci --photons 1 --quiet --json -o .
grep -q '"Rd_se":null' out || complain "--json of one packet: $(cat out)"
expect_code 0 merge one1.mco one2.mco one3.mco -o three.mco --quiet
expect_code 0 a.mci --photons 3 --seed 4 --quiet -o .
expect_code 0 merge one1.mco s.mco -o four.mco --quiet
cat >spread.py <<'END'
import math, re, sys

def section(path, key):
    with open(path) as file:
        return [float(line.split()[0]) for line in re.search(rf"\n{key} [^\n]*\n((?:[^\n]+\n)+)", file.read()).group(1).splitlines()]

for key in ("RAT", "A_z", "Rd_r", "Rd_a", "Tt_r", "Tt_a"):
    values = [section(f"one{i}.mco", key)[-4 if key == "RAT" else 0:] for i in (1, 2, 3)]
    wanted = [math.sqrt(sum((x - sum(column) / 3) ** 2 for x in column) / 2 / 3) for column in zip(*values)]
    found = section("three.mco", "se_" + key)
    assert len(found) == len(wanted) and all(math.isclose(a, b, rel_tol=3e-4, abs_tol=1e-12) for a, b in zip(found, wanted)), (key, found, wanted)
    own, four = section("s.mco", "se_" + key), section("four.mco", "se_" + key)
    assert all(math.isclose(a, b * math.sqrt(3 / 4), rel_tol=3e-4, abs_tol=1e-12) for a, b in zip(four, own)), (key, four, own)
END
python3 spread.py 2>texts || complain "errors of single packets: $(cat texts)"

# What not all have is left out, and a note says so; where all have it, there is none.
scene '' '' '' >a.mci
expect_code 0 a.mci --photons 100 --seed 1 --quiet --aim Tt -o .
mv s.mco aimed.mco
expect_code 0 a.mci --photons 100 --seed 2 --quiet --derivatives -o .
mv s.mco scored.mco
expect_code 0 a.mci --photons 100 --seed 3 --quiet -o .
left="clustermcml: note: merge: left out what not all results have:"
expect_code 0 merge aimed.mco s.mco -o left.mco --quiet
test "$(cat err)" = "$left Tt_expected" || complain "left out of an aimed run: $(cat err)"
expect_code 0 merge s.mco scored.mco -o left.mco --quiet
grep -q "^$left dRd_dmua, .*, dTt_a_dmus$" err && test "$(wc -l <err)" -eq 1 || complain "left out of derivatives: $(cat err)"
cp s.mco plain.mco
for file in aimed scored plain; do
    case $file in aimed) options="--aim Tt" ;; scored) options=--derivatives ;; *) options= ;; esac
    expect_code 0 a.mci --photons 100 --seed 4 --quiet $options -o .
    expect_code 0 merge $file.mco s.mco -o left.mco --quiet
    test ! -s err || complain "left out of two alike: $(cat err)"
done
expect_code 0 a.mci --photons 3 --seed 4 --quiet -o .

# Numbers that no run writes.
damaged() { # SED MESSAGE
    sed "$1" one2.mco >damaged.mco
    cmp -s one2.mco damaged.mco && complain "$1 changed nothing"
    expect_error 2 "damaged.mco: $2" merge s.mco damaged.mco -o out.mco
}
sed 's/^1 # launched/nan # launched/' s.mco >damaged.mco
expect_error 2 "damaged.mco: books[0] = nan (expected one of 12 numbers)" merge one1.mco damaged.mco -o out.mco
damaged '/^se_Rd_a /{n;s/.*/inf/;}' "se_Rd_a[0] = inf (expected one of 2 numbers)"
damaged '/^se_Rd_a /{n;d;}' "se_Rd_a[1] = nothing (expected one of 2 numbers)"
damaged '/^se_Rd_a /{n;s/.*/-1/;}' "se_Rd_a[0] = -1 (expected a number from 0 to 1e+100)"
damaged '/^lost /{n;s/.*/-1/;}' "lost[0] = -1 (expected a number from 0 to 1e+100)"
damaged '/^A_l /{n;s/.*/-0.5/;}' "A_l[0] = -0.5 (expected a number from 0 to 1e+100)"
sed '/^se_Rd_a /{n;s/.*/nan/;}' s.mco >damaged.mco
expect_error 2 "damaged.mco: se_Rd_a[0] = nan (expected a number from 0 to 1e+100)" merge one1.mco damaged.mco -o out.mco

test ! -e out.mco && test ! -e out.h5 || complain "a refused merge wrote"
finish
