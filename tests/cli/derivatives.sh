#!/bin/sh
# Tests --derivatives: other results do not change by a bit; derivatives have the same bytes for any number of threads, after
# a stop and with --more; engines agree within rounding; unsupported scenes are refused by name. stat.derivatives judges the
# numbers.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
bare() { sed -e '/^# User time/d' "$1"; }
same() { # FILE FILE WHAT
    bare "$1" >"$work/a"
    bare "$2" >"$work/b"
    cmp -s "$work/a" "$work/b" || complain "$3: $(diff "$work/a" "$work/b" | head -5)"
}
# Prints the sections of an .mco that are not derivatives.
rest() { bare "$1" | awk '/^(se_)?d(Rd|Tt|A)|_dmu[as] / { of = 1 } !of; /^$/ { of = 0 }'; }
scene() { printf '1.0\n1\n%s A\n%s\n%s\n0.02 0.02\n20 20 5\n2\n1\n1.37 0.5 50 0.8 0.05\nb 3 0.01 0.1 -0.01 0.1 0 0\n1.4 0.2 30 0.9 0.3\ni sphere 0 0 0.2 0.05 1.5 1 9 0.5\n1\n' "$@"; }
mkdir "$work/one" "$work/three" "$work/without" "$work/stopped" "$work/grown" "$work/reference"

scene two.mco 20000 "map 5 5 0.1 0.1 angles volume
facets
fluence
detector ring 0 0.1 name=a
detector disk 0.1 na=0.5 at=0.1,0 name=b
photons \"exits\"
directions 6 6" >"$work/two.mci"
expect_code 0 "$work/two.mci" -o "$work/without" --quiet
expect_code 0 "$work/two.mci" --derivatives -o "$work/one" --threads 1
rest "$work/without/two.mco" >"$work/a"
rest "$work/one/two.mco" >"$work/b"
cmp -s "$work/a" "$work/b" || complain "the rest differs: $(diff "$work/a" "$work/b" | head -5)"
for file in "$work/without"/*.vt?; do
    sed '/^<!-- run /d' "$file" >"$work/a" # which says that it is another run
    sed '/^<!-- run /d' "$work/one/$(basename "$file")" | cmp -s - "$work/a" || complain "$(basename "$file") differs"
done
/usr/bin/python3 - "$work/without/exits.photons.h5" "$work/one/exits.photons.h5" <<'END' || complain "saved packets differ"
import sys
try:
    import h5py
except ImportError:  # as without HDF5
    sys.exit(0)
without, one = map(h5py.File, sys.argv[1:])
columns = []
without.visititems(lambda name, part: columns.append(name) if getattr(part, "shape", ()) else None)
assert "weight" in " ".join(columns), columns
assert all(without[name][()].tobytes() == one[name][()].tobytes() for name in columns)
END
grep -q '^  body 1: dRd_dmua -[0-9.]* +- [0-9.]*, dTt_dmua .* cm$' "$work/out" || complain "summary: $(cat "$work/out")"
expect_code 0 "$work/two.mci" --derivatives -o "$work/three" --threads 3 --chunk 77 --quiet
same "$work/one/two.mco" "$work/three/two.mco" threads

# The engine `reference` computes in double precision, so its results differ slightly, by rounding.
scene two.mco 5000 >"$work/two.mci"
expect_code 0 "$work/two.mci" --derivatives -o "$work/three" --quiet
expect_code 0 "$work/two.mci" --derivatives --engine reference -o "$work/reference" --json
whole "$work/three/two.mco" >"$work/three/whole.txt"
python3 - "$work/out" "$work/three/whole.txt" <<'END' || complain "reference"
import json, sys
record = json.load(open(sys.argv[1]))
sections = open(sys.argv[2]).read()
for name in ("dRd_dmua", "dTt_dmus"):
    words = sections.split("\n" + name + " #")[1].split("\n")[1:4]
    for a, b in zip(record[name], map(float, words)):
        assert abs(a - b) < 0.02 * abs(b), (name, a, b)
END

# A run that is stopped, resumed and extended equals one run.
scene whole.mco 200000 >"$work/whole.mci"
expect_code 0 "$work/whole.mci" --derivatives -o "$work/one" --quiet
"$program" "$work/whole.mci" --derivatives -o "$work/stopped" --quiet 2>"$work/err" &
sleep 0.2
kill -TERM $!
wait $! && echo "the run was faster than the signal"
expect_code 0 "$work/whole.mci" --derivatives -o "$work/stopped" --quiet --resume
same "$work/one/whole.mco" "$work/stopped/whole.mco" resumed
expect_code 0 "$work/whole.mci" --derivatives -o "$work/grown" --quiet --photons 50000 --keep
expect_code 0 "$work/whole.mci" --derivatives -o "$work/grown" --quiet --more 150000
same "$work/one/whole.mco" "$work/grown/whole.mco" "--more"

first() { awk -v key="$2" '$1 == key { getline; print $1; exit }' "$1"; }
# An unknown derivative is nan, null in JSON, and stays so.
printf '1.0\n1\nglass.mco A\n100\n0.02 0.02\n5 5 3\n1\n1\n1.5 0 0 0 0.1\n1\n' >"$work/glass.mci"
expect_code 0 "$work/glass.mci" --derivatives -o "$work/one" --quiet
expect_code 0 "$work/glass.mci" --derivatives --seed 2 -o "$work/three" --json
grep -q '"dRd_dmus":\[null\]' "$work/out" || complain "--json: $(cat "$work/out")"

# If packets are given up as trapped, derivatives by mua of clear media are unknown, and all others are known. The summary
# says how much light was trapped.
printf '1.0\n1\ntrap.mco A\n500\n0.02 0.02\n5 5 1\nbeam pencil z=0.15 light=isotropic\n3\n1\n1 0.1 0 0 0.1\n1.5 0 0 0 0.1\n1 0 0 0 0.1\n1\n' >"$work/trap.mci"
expect_code 0 "$work/trap.mci" --derivatives -o "$work/one"
grep -q "note: trap.mco: derivatives by mua of clear media are NaN, as 3[0-9]* packets were given up as trapped in one" "$work/err" || complain "no note: $(cat "$work/err")"
sed -n '/^  Tt /{n;p;}' "$work/out" | grep -q '^  trapped 0\.7[0-9]* of the light, given up in a clear medium: ' || complain "summary of trapped light: $(cat "$work/out")"
whole "$work/one/trap.mco" | awk '/^d(Rd|A|Tt)_dmua / { name = $1; getline; if (tolower($1) ~ /nan/) print name, 1; getline; if (tolower($1) !~ /nan/) print name, 2; getline; if (tolower($1) !~ /nan/) print name, 3; n++ }
    END { if (n != 3) print n }' >"$work/differ"
test ! -s "$work/differ" || complain "derivatives of trapped light: $(cat "$work/differ")"
expect_code 0 "$work/trap.mci" --derivatives --set layer1.n=1.5 --set layer3.n=1.5 --set below.n=1.5 --set above.n=1.5 -o "$work/three"
grep -q trapped "$work/out" "$work/err" && complain "trapped without a mirror: $(cat "$work/err")"
whole "$work/three/trap.mco" >"$work/three/whole.txt"
test "$(first "$work/three/whole.txt" dRd_dmua | grep -ci nan)" = 0 || complain "no derivative without trapped light"

# Refusals.
printf 'layer1.mua\n1\n' >"$work/t.csv"
for option in "--engine opencl" "--reweight --sweep $work/t.csv"; do
    case $option in
        --engine*) name=$option ;;
        *) name=${option%% *} ;;
    esac
    expect_error 2 "--derivatives (expected no $name beside it)" "$work/two.mci" --derivatives $option
done
scene two.mco 9 "fluence
time 5 1000" >"$work/more.mci"
expect_error 2 "$work/more.mci:6: a time line and --derivatives (expected no such line)" "$work/more.mci" --derivatives
finish
