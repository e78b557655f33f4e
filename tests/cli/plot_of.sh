#!/bin/sh
# plot: what --of names is drawn with the numbers of the file, from .mco and .h5 alike; options of axes, names, colours.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
command -v gnuplot >/dev/null || { echo "gnuplot is missing"; exit 77; }

# Three layers, of which the middle one absorbs nothing. The first bin holds what is absorbed in the hill above z = 0, too.
cat >"$work/scene.mci" <<'END'
1.0
1
scene.mco A
20000
0.01 0.02
60 40 9
map 8 4 0.1 0.1
detector map 3 2 0.2 0.1 at=0.1,0.3 z=-0.2 name=a_map_of
detector ring 0.05 2 name=far
time 60 20
3
1
b 1 0.05 0.1 0 0
1.4 2 30 0.8 0.1
1.4 0 30 0.8 0.1
1.4 4 30 0.8 0.4
1
END
sed -i 's/^b .*/b 2 0.05 0.1 0 0.1/' "$work/scene.mci"
expect_code 0 "$work/scene.mci" --quiet -o "$work"
a=$work/scene.mco
h5=0
test -e "$work/scene.h5" && h5=1
on_map() { # COMMAND...: a program without HDF5 draws no maps
    test $h5 = 0 || "$@"
}

# Everything as gnuplot draws it.
printf 'z A error\n0.1 0.5 0.1\n0.2 0.25 0.05\n' >"$work/others.csv"
for of in Rd_r Tt_r Rd_a Tt_a A_z fluence; do
    expect_code 0 plot "$a" "$work/others.csv" --of $of -o "$work/$of.svg" --label "a label" --label "Li et al." --title "A title"
    for text in 'a label' 'Li et al.' 'A title'; do
        grep -q ">$text<" "$work/$of.svg" || complain "--of $of: no $text"
    done
done
for of in A_rz A_rz_se fluence_rz; do
    expect_code 0 plot "$a" --of $of -o "$work/$of.svg" --title "A title"
    grep -q 'depth z \[cm\]' "$work/$of.svg" && grep -q '/cm[²³]\]' "$work/$of.svg" || complain "--of $of: axes without units"
done
grep -q 'φ(z) = A(z)/μa  \[-\]' "$work/fluence.svg" || complain "a fluence without its unit"
expect_code 0 plot "$a" "$a" --label one --label two --xrange 0.1:0.3 --yrange 1e-3: -o "$work/ranges.svg"
on_map expect_code 0 plot "$work/scene.h5" "$work/scene.h5" --of Rd --label one --label two --percentile 90 --title "A title" \
    -o "$work/maps.svg"
for text in one two 'A title'; do
    on_map grep -q ">$text<" "$work/maps.svg" || complain "maps: no $text"
done
check_texts
mkdir "$work/surface"
expect_code 0 "$work/scene.mci" --ignore-absorption --quiet -o "$work/surface"
expect_code 0 plot "$work/surface/scene.mco" --of Rd_t -o "$work/gates.svg" # gates, and none of absorption

# What gnuplot is told:
keep_gnuplot_script
told() {
    grep -qF -e "$1" "$work/script" || complain "$2: gnuplot is not told $1"
}

# Numbers: those of the file, times what the name says, at the middles of bins.
numbers() { # NAME FILE
    expect_code 0 plot "$2" --of "$1" -o "$work/numbers.svg"
    python3 - "$1" "$a" "$work/script" >"$work/wrong" <<'END' || complain "--of $1 of $2: $(cat "$work/wrong")"
import math
import sys
name, mco, script = sys.argv[1:]
lines = [line.split("#")[0].split() for line in open(mco)]
def section(key, count):
    start = next(i for i, line in enumerate(open(mco)) if line.split()[:1] == [key])
    words = [word for line in lines[start + 1:] for word in line]
    return [float(word) for word in words[:count]]
nz, nr, na, dz, dr = 60, 40, 9, 0.01, 0.02
mua = lambda z: 0 if z < dz else 2 if z < 0.1 else 0 if z < 0.2 else 4
text = open(script).read()
if "_rz" in name:
    grid = section("se_A_rz" if name == "A_rz_se" else "A_rz", nr * nz)
    rows = text.split("$map0 << EOD\n")[1].split("EOD")[0].strip().split("\n")
    repeat, stretch = len(rows) // (nz - 1), len(rows[0].split()) // (nr - 1)
    want = [[grid[r * nz + z] / (1 if name != "fluence_rz" else mua((z + .5) * dz) or math.nan) for r in range(nr - 1)] for z in range(nz - 1)]
    got = [[float(word) for word in row.split()[::stretch]] for row in rows[::repeat]]
    pairs = [(g, w if w > 0 else math.nan) for gs, ws in zip(got, want) for g, w in zip(gs, ws)]
    assert len(got) == nz - 1 and len(pairs) == (nz - 1) * (nr - 1), (len(got), len(pairs))
    assert f"set yrange [{(nz - 1) * dz:.9g}:0]" in text, "z does not point down"
else:
    key, n, step, last = {"fluence": ("A_z", nz, dz, 1), "A_z": ("A_z", nz, dz, 1), "Rd_r": ("Rd_r", nr, dr, 1), "Tt_r": ("Tt_r", nr, dr, 1),
                          "Rd_a": ("Rd_a", na, math.pi / 2 / na, 0), "Tt_a": ("Tt_a", na, math.pi / 2 / na, 0),
                          "detector_far_t": (name, 20, 3, 0)}[name]
    values, errors = section(key, n), section("se_" + key, n)
    points = [[float(word) for word in line.split()] for line in text.split("$c0_0 << EOD\n")[1].split("EOD")[0].split("\n") if line]
    want = []
    for i in range(n - last):
        x = (i + .5) * step
        f = 1 if name != "fluence" else 1 / mua(x) if mua(x) else 0
        if values[i] * f > 0:
            want.append((x, values[i] * f, None, (values[i] + errors[i]) * f))
    assert len(points) == len(want), (len(points), len(want))
    pairs = [(g, w) for gs, ws in zip(points, want) for g, w in zip(gs, ws) if w is not None]
assert all(math.isnan(g) == math.isnan(w) for g, w in pairs), "other gaps"
worst = max(0 if math.isnan(g) and math.isnan(w) else abs(g - w) / abs(w) if w == w else 9 for g, w in pairs)
print("off by", worst)
sys.exit(worst > 2e-4)
END
}
for of in Rd_r Tt_r Rd_a Tt_a A_z fluence A_rz A_rz_se fluence_rz detector_far_t; do
    numbers $of "$a"
    test $h5 = 0 || numbers $of "$work/scene.h5"
done

told 'detector_far_t  [1/ps]' "gates of a detector"
expect_error 2 "$a: no detector_near_t (expected gates of one of its detectors)" plot "$a" --of detector_near_t -o "$work/none.svg"

# A layer without absorption is a gap in the curve, not a line across it.
expect_code 0 plot "$a" --of fluence -o "$work/gap.svg"
gaps=$(sed -n '/^\$c0_0/,/^EOD/p' "$work/script" | grep -c '^$')
test "$gaps" -ge 1 || complain "no gap where nothing absorbs"

# Nor has a bin a fluence that two media share, by what the file says: a plane within bin 2, a hill within bin 5, one from edge to
# edge over bins 7 to 9, a rod in bins 14 to 16 at 0.1 to 0.2502 cm from the axis, where the beam is not, a mesh in bins 18 and 19 at 0.17 to 0.2256 cm,
# the last boundary within bin 22. Layers of one mua may share bin 12; bins 10 and 20 begin with a layer.
printf 'v 0 0 -0.185\nv 0.05 0 -0.195\nv 0 0.05 -0.195\nv 0 -0.05 -0.195\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n' >"$work/grain.obj"
cat >"$work/shared.mci" <<'END'
1.0
1
shared.mco A
20000
beam pencil at=-0.2,0
map 4 4 0.1 0.1
0.01 0.02
30 20 1
7
1
1.4 1 5 0.5 0.025
1.4 2 5 0.5 0.03
b 2 0.002 0.1 0 0.1
1.4 1 5 0.5 0.045
b 2 0.03 0.1 0 0.1
1.4 3 5 0.5 0.025
1.4 3 5 0.5 0.015
1.4 3 6 0.5 0.06
i cylinder 0.1 0 0.155 0.25 0 0.155 0.01 1.4 9 1 0
i "grain.obj" 1.4 9 1 0 shift=0.17,0,0
1.4 2 6 0.5 0.025
1
END
gaps() { # FILE: bins that have no fluence are those, and the pictures say why
    for of in fluence fluence_rz; do
        expect_code 0 plot "$1" --of $of --linear -o "$work/shared.svg"
        cp "$work/script" "$work/$of"
    done
    grep -q 'gaps: bins that two media share' "$work/fluence" && grep -q 'grey: no light, nothing absorbs, or two media' "$work/fluence_rz" ||
        complain "$1: the pictures do not say what gaps are"
    python3 - "$work/shared.mco" "$work/fluence" "$work/fluence_rz" >"$work/wrong" <<'END' || complain "gaps of $1: $(cat "$work/wrong")"
import math
import sys
mco, curve, colours = (open(name).read() for name in sys.argv[1:])
rows = {2, 5, 7, 8, 9} | set(range(22, 29))
points = [line.split() for line in curve.split("$c0_0 << EOD\n")[1].split("EOD")[0].split("\n") if line]
drawn = {round(float(point[0]) / 0.01 - 0.5) for point in points}
assert drawn == set(range(29)) - rows - {14, 15, 16, 18, 19}, sorted(drawn)
A = [float(word) for word in mco.split("A_rz\n")[1].split("#")[0].split()[:600]]
mua = lambda z: 1 if z < 2 or 5 < z < 7 else 2 if z < 5 or z > 19 else 3
pixels = [line.split() for line in colours.split("$map0 << EOD\n")[1].split("EOD")[0].strip().split("\n")]
tall, wide = len(pixels) // 29, len(pixels[0]) // 19
for z in range(29):
    for r in range(19):
        shared = z in rows or (14 <= z <= 16 and 5 <= r <= 12) or (18 <= z <= 19 and 8 <= r <= 11)
        value, want = float(pixels[z * tall][r * wide]), A[r * 30 + z] / mua(z)
        good = math.isnan(value) if shared else abs(value - want) <= 1e-2 * want or (want == 0 and math.isnan(value))
        assert good, (z, r, value, want)
END
}
expect_code 0 "$work/shared.mci" --quiet -o "$work"
gaps "$work/shared.mco"
test $h5 = 0 || gaps "$work/shared.h5"
# Files that do not say so: those of older versions, and of the program of 2019, which has a copy of its input.
where="(expected a result that names its depths, for a fluence: fly the scene again)"
sed '/^# boundary/s/ (z = [^)]*)//' "$work/shared.mco" >"$work/older.mco"
expect_error 2 "$work/older.mco: does not say where boundary 2 lies $where" plot "$work/older.mco" --of fluence -o "$work/none.svg"
sed '/^# body/s/ (z = [^)]*)//' "$work/shared.mco" >"$work/older.mco"
expect_error 2 "$work/older.mco: does not say where a body lies $where" plot "$work/older.mco" --of fluence_rz -o "$work/none.svg"
sed -e 's/^InParm/InParam/' -e '/^# bo/d' -e 's/^1.4.*# layer 3/b 2 0.002 0.1 0 0.1\n&/' "$work/shared.mco" >"$work/older.mco"
expect_error 2 "$work/older.mco: does not say where a curved boundary lies $where" plot "$work/older.mco" --of fluence -o "$work/none.svg"
expect_code 0 plot "$work/older.mco" --of A_z -o "$work/told.svg"

# Ranges, and error bars of curves of others.
expect_code 0 plot "$a" "$work/others.csv" --of A_z --xrange 0.05:0.3 --yrange 0.1:10 -o "$work/told.svg"
told 'set xrange [0.05:0.3]' --xrange
told 'set yrange [0.1:10]' --yrange
told 'with yerrorbars' "three columns"
told '0.1 0.5 0.4 0.6' "three columns"
on_map expect_code 0 plot "$work/scene.h5" --of Rd --crange 0.5:2 --xrange :0.2 -o "$work/told.svg"
on_map told 'set cbrange [0.5:2]' --crange
on_map told 'set xrange [-0.4:0.2]' --xrange
/usr/bin/python3 - "$work/hot.h5" <<'END'
import sys
import h5py
with h5py.File(sys.argv[1], "w") as file:
    file["Rd_xy"] = [[10.0 * j + i + 1 if 10 * j + i < 99 else 1e4 for i in range(10)] for j in range(10)]
    file["Rd_xy"].attrs.create("units", "1/cm2", dtype="S6")
    file["x"] = file["y"] = [i + 0.5 for i in range(10)]
END
on_map expect_code 0 plot "$work/hot.h5" --of Rd --percentile 99 -o "$work/told.svg"
on_map told 'set cbrange [0:99]' "a hot pixel left out"
on_map expect_code 0 plot "$work/hot.h5" --of Rd --linear -o "$work/told.svg"
on_map told 'set cbrange [0:10000]' "all pixels"

range="A:B with A below B; A: and :B leave the other end open"
for value in 1 1:1 2:1 : a:b ''; do
    expect_error 2 "--xrange $value (expected $range)" plot "$a" --xrange "$value" -o "$work/none.svg"
done
# An axis that gnuplot cannot draw, told or with the end that the data have.
ends="expected a length of 1e-4 of its ends or more, and ends of 1e-30..1e30"
no_axis() { # "FROM to TO" OPTION RANGE FILE...
    axis=$1 option=$2 told=$3
    shift 3
    expect_error 2 "$option: the axis would go from $axis ($ends)" plot "$@" "$option" "$told" -o "$work/none.svg"
}
no_axis "-1e+308 to 1e+308" --xrange -1e308:1e308 "$a"
no_axis "0.5 to 0.5" --xrange 0.5:0.50000001 "$a"
no_axis "1e+31 to 1e+32" --yrange 1e31:1e32 "$a"
on_map no_axis "-1e+308 to 1e+308" --xrange -1e308:1e308 "$work/scene.h5" --of Rd
# One on which nothing would stand.
expect_error 2 "--xrange beyond all that is lit (expected some of 0:0.8)" plot "$a" --xrange 1:2 -o "$work/none.svg"
expect_error 2 "--xrange beyond all that is lit (expected some of 0:0.8)" plot "$a" --xrange :-5 -o "$work/none.svg"
on_map expect_error 2 "--yrange beyond all that is lit (expected some of -0.2:0.2)" plot "$work/scene.h5" --of Rd --yrange 5: -o "$work/none.svg"
on_map no_axis "0 to 9.99989e-321" --crange 0:1e-320 "$work/scene.h5" --of Rd
expect_code 0 plot "$a" --xrange -1e30:1e30 -o "$work/told.svg"
on_map expect_code 0 plot "$work/scene.h5" --of Rd --crange 0:1e-30 -o "$work/told.svg" # from 0: not on a log scale
expect_error 2 "--percentile 0 (expected a number above 0, up to 100)" plot "$a" --percentile 0 -o "$work/none.svg"
expect_error 2 "--label given 1 times (expected once for each of 2 files)" plot "$a" "$a" --label x -o "$work/none.svg"
expect_error 2 "--crange (expected with maps only)" plot "$a" --crange 1:2 -o "$work/none.svg"
expect_error 2 "--percentile (expected with maps only)" plot "$a" --percentile 99 -o "$work/none.svg"
expect_error 2 "--percentile (expected without --crange)" plot "$a" --of A_rz --percentile 9 --crange 1:2 -o "$work/none.svg"
expect_error 2 "--yrange (expected numbers above 0 on a log scale, or --linear)" plot "$a" --yrange 0:1 -o "$work/none.svg"
expect_error 2 "$work/others.csv (expected a result, for --of A_rz)" plot "$work/others.csv" --of A_rz -o "$work/none.svg"
sed 's/^1.4 [24]/1.4 0/' "$work/scene.mci" >"$work/clear.mci"
mkdir "$work/clear"
expect_code 0 "$work/clear.mci" --quiet -o "$work/clear"
expect_error 2 "$work/clear/scene.mco: mua = 0 in all layers (expected a layer that absorbs, for a fluence)" \
    plot "$work/clear/scene.mco" --of fluence -o "$work/none.svg"

# .h5: the same result as the .mco, to the digits that an .mco prints; what is no such file is refused.
if test $h5 = 1; then
    expect_code 0 compare "$a" "$work/scene.h5"
    grep -q 'both runs have seed 1' "$work/out" && grep -q '^p = 1 ' "$work/out" || complain "$(cat "$work/out")"
    expect_code 0 plot "$work/scene.h5" --of Tt_xy -o "$work/told.svg"
    told 'Tt_xy  [1/cm²]' "a map from an .h5"
    for array in detector_a_map_of_map detector_a_map_of_map_se; do
        expect_code 0 plot "$work/scene.h5" --of $array -o "$work/told.svg"
        told "$array  [1/cm²]" "a camera's picture from an .h5"
        told 'matrix using (-0.199' "$array"
    done
    names=$("$program" plot "$a" --of none -o "$work/none.svg" 2>&1 | sed 's/.*(expected \(one of .*\); or.*/\1/')
    for none in Rd_z Rd_ra A_rz_gates; do
        expect_error 2 "$work/scene.h5: no map $none (expected a data set over y and x, or $names)" plot "$work/scene.h5" --of $none -o "$work/none.svg"
    done
    cp "$a" "$work/false.h5"
    expect_error 2 "$work/false.h5: cannot be read as an HDF5 file (expected the .h5 file of a run)" plot "$work/false.h5" -o "$work/none.svg"
    expect_error 2 "$work/none.h5: cannot be read: No such file or directory (expected an .h5 file)" plot "$work/none.h5" -o "$work/none.svg"
    expect_error 2 "$work/false.h5: cannot be read as an HDF5 file (expected the .h5 file of a run)" compare "$a" "$work/false.h5"
else
    touch "$work/any.h5"
    expect_error 2 "$work/any.h5: this program was built without HDF5" plot "$work/any.h5" -o "$work/none.svg"
fi
ls "$work" | grep -q -e none -e '\.tmp$' && complain "a failed plot left a file"
finish
