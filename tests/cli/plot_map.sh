#!/bin/sh
# Maps: pictures that are complete or absent, pixels at their place, centimetres of one length, scales as asked for.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
command -v gnuplot >/dev/null || { echo "gnuplot is missing"; exit 77; }
/usr/bin/python3 -c "import h5py" 2>/dev/null || { echo "h5py is missing"; exit 77; }
expect_code 0 samples/skinmap.mci --photons 2e4 --quiet -o "$work"
map=$work/skinmap.h5
test -e "$map" || { echo "built without HDF5"; exit 77; }

# What gnuplot itself draws.
expect_code 0 plot "$map" --of Rd -o "$work/one.svg" --caption "A <caption> of maps"
test "$(cat "$work/out")" = "$work/one.svg" || complain "plot does not name its picture"
for text in '<svg' 'skinmap.h5' 'Rd(x,y)  \[1/cm²\]' 'x \[cm\]' 'y \[cm\]' 'A &lt;caption> of maps' '<image' '</svg>'; do
    grep -q -e "$text" "$work/one.svg" || complain "the svg has no $text"
done
if command -v xmllint >/dev/null; then
    xmllint --noout "$work/one.svg" 2>"$work/xml" || complain "the svg is not XML: $(cat "$work/xml")"
fi
for scale in --log --linear; do
    expect_code 0 plot "$map" "$map" "$map" "$map" -o "$work/four.png" --of Tt $scale --quiet
    test ! -s "$work/out" || complain "--quiet was not quiet"
    test "$(head -c 4 "$work/four.png" | tail -c 3)" = PNG || complain "four.png is no PNG"
done
odd="$work/a'b\"c\$d_{e}^f\\g\`h\`<i>&%s@~#.h5"
cp "$map" "$odd"
expect_code 0 plot "$odd" "$map" --of boundary1_exitance_above -o "$work/odd.svg"
grep -q 'boundary1_exitance_above' "$work/odd.svg" || complain "the array is not named"
grep -q 'd_{e}^f' "$work/odd.svg" || complain "the odd name is not above its map"

for of in "" "--of Rd" "--of Rd_xy"; do
    expect_error 2 "$work/skinmap.map.vti (expected the .h5 beside it, which has the same map, and --of)" plot "$work/skinmap.map.vti" $of -o "$work/none.svg"
done
expect_error 2 "$work/skinmap.mco (expected a map, like $map)" plot "$map" "$work/skinmap.mco" --of Rd -o "$work/none.svg"
expect_error 2 "--of Rd (expected one of Rd_r, Tt_r, Rd_a, Tt_a, A_z, Rd_t, Tt_t, A_t, detector_NAME_t, phi_z, fluence, A_rz, A_rz_se, phi_rz, phi_rz_se, fluence_rz, Rd_dir, Tt_dir, Rsp_dir; or an array of a map)" plot "$work/skinmap.mco" --of Rd -o "$work/none.svg"
sed '/^se_A_rz/,/^$/d' "$work/skinmap.mco" >"$work/noerrors.mco"
expect_error 2 "$work/noerrors.mco: no A_rz_se (expected a result with standard errors of it)" plot "$work/noerrors.mco" --of A_rz_se -o "$work/none.svg"
expect_code 5 plot "$map" --of Rd -o "$work/missing/none.svg"

# What gnuplot is told:
keep_gnuplot_script
make_map() { # FILE "NX NY DX DY" VALUES...
    /usr/bin/python3 - "$@" <<'EOF'
import sys
import h5py
nx, ny, dx, dy = map(float, sys.argv[2].split())
with h5py.File(sys.argv[1], "w") as file:
    file["Rd_xy"] = [[float(sys.argv[3 + int(nx) * j + i]) for i in range(int(nx))] for j in range(int(ny))]
    file["Rd_xy"].attrs.create("units", "1/cm2", dtype="S6")
    file["x"], file["y"] = ([(i + 0.5) * width for i in range(int(n))] for n, width in ((nx, dx), (ny, dy)))
EOF
}
told() { # TEXT
    grep -qF -e "$1" "$work/script" || complain "$2: gnuplot is not told $1"
}
not_told() {
    grep -qF -e "$1" "$work/script" && complain "$2: gnuplot is told $1"
}

# Two decades and less are linear unless told, more are log unless told.
make_map "$work/near.h5" "3 2 1 1" 0 1 2 3 4 100
make_map "$work/far.h5" "3 2 1 1" 0 1 2 3 4 101
scale_of() { # log|linear FILE OPTIONS...
    wanted_scale=$1
    shift
    expect_code 0 plot "$@" --of Rd -o "$work/scale.svg"
    case $wanted_scale in
    log) told 'set logscale cb' "$*" && told 'grey: no light' "$*" ;;
    linear) not_told 'set logscale cb' "$*" || not_told 'grey: no light' "$*" || told 'set cbrange [0:' "$*" ;;
    esac
}
scale_of linear "$work/near.h5"
scale_of log "$work/far.h5"
scale_of log "$work/near.h5" --log
scale_of linear "$work/far.h5" --linear
scale_of log "$work/near.h5" "$work/far.h5"
told 'set cbrange [1:101]' "two maps"

# Pixels: x fastest, y from below, 100 and 150 times each; no light is no colour on a log scale.
expect_code 0 plot "$work/far.h5" --of Rd -o "$work/scale.svg"
pixels=$(sed -n '/^\$map0/,/^EOD/p' "$work/script" | sed '1d;$d' | uniq -c | awk '{print $1 ": " $2, $101, $102, $201, $202, $301, NF}')
test "$pixels" = "150: NaN NaN 1 1 2 2 301
150: 3 3 4 4 101 101 301" || complain "pixels: $pixels"
told 'matrix using (0.005 + $1 * 0.01):(0.00333333333 + $2 * 0.00666666667):3' "places"

# Cuts through voxels, against their image; z points down.
for cut in x=-0.2 y=0.1 z=0.03; do
    expect_code 0 plot "$work/skinmap.h5" --of A_xyz --cut $cut --linear -o "$work/cut.svg"
    told "A_xyz  [1/cm3], ${cut%=*} = ${cut#*=} cm" "$cut"
    python3 - "$work/skinmap.volume.vti" $cut >"$work/cut" 2>&1 3<"$work/script" <<'EOF' || complain "cut $cut: $(cat "$work/cut")"
import re
import struct
import sys
data = open(sys.argv[1], "rb").read()
n = list(map(int, re.search(rb'WholeExtent="0 (\d+) 0 (\d+) 0 (\d+)', data).groups()))
corner = list(map(float, re.search(rb'Origin="(\S+) (\S+) ([^"]+)', data).groups()))
width = list(map(float, re.search(rb'Spacing="(\S+) (\S+) ([^"]+)', data).groups()))
begin = data.index(b"_", data.index(b"<AppendedData")) + 1
values = struct.unpack_from(f"<{n[0] * n[1] * n[2]}f", data, begin + 8)
axis, place = "xyz".index(sys.argv[2][0]), float(sys.argv[2][2:])
at = [0, 0, 0]
at[axis] = int((place - corner[axis]) / width[axis])
across, along = [i for i in range(3) if i != axis]
rows = re.search(r"^\$map0.*\n((?:.*\n)*?)EOD", open(3).read(), re.M)[1].splitlines()
repeat = [-(-300 // n[i]) if n[i] < 300 else 1 for i in (across, along)]
assert len(rows) == n[along] * repeat[1], len(rows)
for at[along] in range(n[along]):
    row = rows[at[along] * repeat[1]].split()[::repeat[0]]
    for at[across] in range(n[across]):
        true = values[(at[2] * n[1] + at[1]) * n[0] + at[0]]
        assert abs(float(row[at[across]]) - true) <= 1e-4 * true, (at, row[at[across]], true)
EOF
done
expect_error 2 "--cut y=9 (expected a place of -0.366 to 0.366 cm, in the voxels of $work/skinmap.h5)" \
    plot "$work/skinmap.h5" --of A_xyz --cut y=9 -o "$work/none.svg"
expect_error 2 "--cut (expected with --of A_xyz or phi_xyz of an .h5)" plot "$work/skinmap.h5" --of Rd_xy --cut y=0 -o "$work/none.svg"
expect_error 2 "--cut w=0 (expected x=, y= or z= and a place in cm)" plot "$work/skinmap.h5" --of A_xyz --cut w=0 -o "$work/none.svg"

# A centimetre is as long in x as in y, whatever the map.
for shape in "3 2 1 1" "3 2 0.01 0.001" "3 2 1e-3 9e4" "2 3 1 0.5"; do
    make_map "$work/shape.h5" "$shape" 1 2 3 4 5 6
    expect_code 0 plot "$work/shape.h5" "$work/shape.h5" --of Rd -o "$work/shape.svg"
    awk -v shape="$shape" '
        /^set terminal/ { sub(/.*size /, ""); split($1, size, ",") }
        /^set [xy]range/ { gsub(/[^-+0-9.e:]/, "", $3); split($3, end, ":"); span[$2] = end[2] - end[1] }
        /^set [lrtb]margin/ { at[$2] = $5 }
        END {
            x = (at["rmargin"] - at["lmargin"]) * size[1] / span["xrange"]
            y = (at["tmargin"] - at["bmargin"]) * size[2] / span["yrange"]
            inside = at["lmargin"] > 0 && at["rmargin"] < 1 && at["bmargin"] > 0 && at["tmargin"] < 1
            if (!(inside && x / y > 0.98 && x / y < 1.02)) { print shape, x, y; exit 1 }
        }' "$work/script" >"$work/ratio" || complain "lengths differ: $(cat "$work/ratio")"
done

# 2500 pixels a side become 834 means of 3 x 3; the last has one pixel.
make_map "$work/big.h5" "2500 1 1 1" $(seq 1 2500)
expect_code 0 plot "$work/big.h5" --of Rd -o "$work/big.svg" --linear
means=$(sed -n '/^\$map0/,/^EOD/p' "$work/script" | sed '1d;$d' | uniq -c | awk '{print $1, $2, $3, $835, NF - 1}')
test "$means" = "300 2 5 2500 834" || complain "means: $means"

# A map without light, and one of one pixel.
make_map "$work/dark.h5" "3 2 1 1" 0 0 0 0 0 0
for scale in --log --linear; do
    expect_code 0 plot "$work/dark.h5" --of Rd $scale -o "$work/dark.svg"
    told 'no light' "a dark map"
done
PATH=${PATH#"$work/bin:"}
make_map "$work/pixel.h5" "1 1 1 1" 7
for map in dark pixel far near big shape; do
    for scale in --log --linear; do
        expect_code 0 plot "$work/$map.h5" --of Rd $scale -o "$work/$map.svg"
        tail -3 "$work/$map.svg" | grep -q '</svg>' || complain "$map $scale has no picture"
    done
done

check_texts

# Curves on linear axes: no log axis, ticks from 0 on.
expect_code 0 plot "$work/skinmap.mco" -o "$work/log.svg"
PATH=$work/bin:$PATH
expect_code 0 plot "$work/skinmap.mco" -o "$work/curve.svg"
told 'set logscale y' "curves"
expect_code 0 plot "$work/skinmap.mco" -o "$work/curve.svg" --linear
not_told 'set logscale y' "linear curves"
told 'set yrange [0:' "linear curves"
ls "$work" | grep -q -e none -e '\.tmp$' && complain "a failed plot left a file"
finish
