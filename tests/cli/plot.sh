#!/bin/sh
# Tests plot: pictures of results, of curves from other programs, and of sweeps. Pictures are complete or absent, and hold the
# numbers of their files.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
warm_python
for sample in fig5 shapes/hinoise shapes/plane; do
    expect_code 0 samples/$sample.mci --photons 2e4 --quiet -o "$work"
done
has() { # PICTURE TEXT...
    drawn=$1
    shift
    for text; do grep -qF -- "$text" "$work/$drawn" || complain "$drawn has no $text"; done
    tail -3 "$work/$drawn" | grep -q '</svg>' || complain "$drawn has no end"
}

# Curves, also of other programs; heightfields; any characters of a name are drawn as they are. The same input gives the same
# bytes.
expect_code 0 plot "$work/hinoise.mco" -o "$work/one.svg"
test "$(cat "$work/out")" = "$work/one.svg" || complain "plot does not name its picture"
has one.svg '>height  [cm]<' '>r·Rd_r(r)  [1/cm]<' '>radius r  [cm]<' '>hinoise<'
cp "$work/one.svg" "$work/before.svg"
expect_code 0 plot "$work/hinoise.mco" -o "$work/one.svg" --quiet
cmp -s "$work/one.svg" "$work/before.svg" && test ! -s "$work/out" || complain "other bytes, or --quiet was not quiet"
expect_code 0 plot "$work/fig5.mco" -o "$work/flat.svg"
grep -q 'height  \[cm\]' "$work/flat.svg" && complain "a plane has an axis of heights"
odd="$work/a'b\"c\$d_{e}^f\\g\`h\`<i>&%s@~#.mco"
cp "$work/plane.mco" "$odd"
expect_code 0 plot tests/reference/profiles/hinoise.reentry.csv "$odd" "$work/fig5.mco" -o "$work/odd.svg" --caption "A <caption> \$x\$ $(printf 'word %.0s' $(seq 40))"
has odd.svg 'd_{e}^f' 'hinoise.reentry.csv' 'stroke-dasharray' 'A &lt;caption&gt; '
! command -v xmllint >/dev/null || xmllint --noout "$work/odd.svg" 2>"$work/xml" || complain "the svg is not XML: $(cat "$work/xml")"
for kind in PNG:PNG pdf:%PDF- EPS:%!PS-Adobe; do
    expect_code 0 plot "$work/hinoise.mco" "$work/plane.mco" -o "$work/a.${kind%%:*}" --of Rd_a --style /dev/null
    head -c 20 "$work/a.${kind%%:*}" | tr -d '\0' | grep -q "${kind#*:}" || complain "a.${kind%%:*} is none"
done
printf 'image.cmap: magma\nfont.size: 7\n' >"$work/journal.mplstyle"
expect_code 0 plot "$work/fig5.mco" --of A_rz -o "$work/map.svg" --style "$work/journal.mplstyle"
grep -q 'font: [0-9]* *7px' "$work/map.svg" || complain "--style does nothing"

# Wrong files are refused in one line, and nothing is written.
refused() { expect_error 2 "$@" -o "$work/none.svg"; }
expect_error 2 "--output p.jpg (expected a name that ends in .svg, .png, .pdf or .eps)" plot "$work/fig5.mco" -o p.jpg
refused "$work/missing.mco: cannot be opened (No such file or directory)" plot "$work/missing.mco"
refused "--xrange 2:1 (expected A:B with A below B; A: and :B leave the other end open)" plot "$work/fig5.mco" --xrange 2:1
refused "--cut w (expected an axis and a place, as y=0)" plot "$work/fig5.mco" --of A_rz --cut w
refused "--cut q=1 (expected an axis of A_rz: r z)" plot "$work/fig5.mco" --of A_rz --cut q=1
refused "--over (expected with the table of a sweep, NAME.sweep.csv)" plot "$work/fig5.mco" --over a
expect_error 5 "$work/none/f.svg: cannot be written (No such file or directory)" plot "$work/fig5.mco" -o "$work/none/f.svg"
expect_code 2 plot "$work/fig5.mco" --of none -o "$work/none.svg"
grep -q "no array none (expected one of fluence fluence_rz .* A_z" "$work/err" || complain "$(cat "$work/err")"
printf 'r_mid_cm,Rd_r_per_cm2\n0.5,x\n1,2\n' >"$work/bad.csv"
expect_code 2 plot "$work/bad.csv" --of Rd_r -o "$work/none.svg"
grep -q "bad.csv:2: 0.5 x (expected 2 numbers" "$work/err" || complain "$(cat "$work/err")"
test ! -e "$work/none.svg" || complain "a refused plot left a picture"

# Sweeps are drawn over each column, with lines named by the columns that differ, and in colours.
printf '1.0\n1\ngrid.mco A\n300\n0.1 0.1\n5 5 2\n1\n1\n1.4 1 50 0.8 0.1\n1\n' >"$work/grid.mci"
printf 'layer1.mua,layer1.mus\n3,50\n0.5,50\n1,50\n0.5,20\n1,20\n' >"$work/grid.csv"
expect_code 0 "$work/grid.mci" --sweep "$work/grid.csv" --quiet -o "$work"
grid=$work/grid.sweep.csv
expect_code 0 plot "$grid" -o "$work/sweep.svg" --title "A title"
has sweep.svg '>layer1.mus = 20<' '>layer1.mus = 50<' '>layer1.mua  [1/cm]<' '>Rd  [-]<' '>A title<'
expect_code 0 plot "$grid" "$grid" --over layer1.mua,layer1.mus --of A -o "$work/swept.svg"
has swept.svg '>layer1.mus  [1/cm]<' 'grey: no row'
expect_code 2 plot "$grid" --of nix -o "$work/none.svg"
grep -q -e "--of nix (expected a column of $grid: row, layer1.mua, " "$work/err" || complain "$(cat "$work/err")"

# Every array of an .h5 that has axes is drawn over them, and the numbers drawn are those of the file.
if "$program" --version | grep -q "HDF5 yes"; then
    printf '1.0\n1\nv.h5 B\n2e3\nmap 8 6 0.05 0.05 angles volume\nfluence\nfacets\ntime 100 10\ndirections 4 6\ndetector map 8 8 0.05 0.05 na=0.9 name=cam\n0.02 0.05\n10 8 4\n2\n1\nb 3  0.05 0.02  0.02 0.04  0 0.05\n1.4 1 50 0.7 0.2\ni sphere 0.1 0.1 0.1 0.05 1.4 5 50 0.7\n1.5 2 30 .8 .1\n1\n' >"$work/v.mci"
    expect_code 0 "$work/v.mci" --quiet -o "$work"
    "$CLUSTERMCML_PYTHON" tests/lib/drawn_arrays.py "$work/v.h5" 2>"$work/err" || complain "arrays: $(tail -n 3 "$work/err")"
    expect_code 0 plot "$work/v.h5" --of A_xyz --cut z=0.05 -o "$work/cut.svg"
    has cut.svg 'A_xyz  [1/cm³], z = 0.05' '>x  [cm]<' '>y  [cm]<'
    expect_code 0 plot "$work/v.h5" --of Rd_dir -o "$work/dir.svg"
    expect_code 0 plot "$work/v.h5" "$work/v.h5" --label one --label two --of Tt -o "$work/two.svg"
    has two.svg '>one<' '>two<' '>Tt  [1/cm²]'
    expect_code 0 plot "$work/v.h5" --of boundary0_irradiance_above -o "$work/facets.svg"
    has facets.svg '>heights 0 to 0.05 cm<' '>x  [cm]<' '>y  [cm]<'
    expect_code 0 plot "$work/v.h5" "$work/v.h5" --of body_irradiance_outside -o "$work/bodies.svg"
    refused "--cut y=9 (expected a place of -0.15 to 0.15 cm, in $work/v.h5)" plot "$work/v.h5" --of A_xyz --cut y=9
    refused "--of Rd_xya: over y x alpha (expected --cut at a place of one of them)" plot "$work/v.h5" --of Rd_xya
fi
check_texts

# Without Python, or with a Python that lacks the modules, plot ends with one line.
lacks() { # PYTHON LINE [FILE [PATH]]
    code=0
    PATH=${4:-$PATH} CLUSTERMCML_PYTHON=$1 "$program" plot "$work/${3:-fig5.mco}" -o "$work/none.svg" 2>"$work/err" || code=$?
    test $code -eq 5 && grep -q "^clustermcml: $2 *(\(.*; \)*expected Python 3.10 or later with packages: apt-get install " "$work/err" && test "$(wc -l <"$work/err")" -eq 1 ||
        complain "$2: $code $(cat "$work/err")"
    test ! -e "$work/none.svg" || complain "$2, and a picture"
}
lacks "$work/none" "plot: $work/none cannot be started"
mkdir "$work/empty"
lacks "" "plot: python3 cannot be started" fig5.mco "$work/empty"
with() { # STATEMENT that is run first
    printf 'import sys\n%s\nsys.argv = sys.argv[1:]\ncode = sys.argv.pop(1)\nexec(code)\n' "$1" >"$work/without.py"
    printf '#!/bin/sh\nshift\nexec "%s" "%s" -c "$@"\n' "$cold_python" "$work/without.py" >"$work/bare"
    chmod +x "$work/bare"
}
touch "$work/bare.h5"
with 'sys.modules["numpy"] = None'
lacks "$work/bare" "plot: .* has no module numpy"
with 'sys.modules["h5py"] = None'
lacks "$work/bare" "plot: .* has no module h5py" bare.h5
with 'sys.modules["matplotlib"] = None'
lacks "$work/bare" "plot: .* has no module matplotlib"
with 'sys.version_info = (3, 8, 18)'
lacks "$work/bare" "plot: .* is older than Python 3.10"

# An empty PYTHONPATH does not let modules of the current folder in. An error of a library becomes one line.
mkdir "$work/evil"
echo 'raise ValueError("of the current folder")' >"$work/evil/matplotlib.py"
(cd "$work/evil" && PYTHONPATH='' CLUSTERMCML_PYTHON=$cold_python "$program" plot "$work/fig5.mco" -o good.svg >/dev/null 2>"$work/err") || complain "a module of the folder: $(cat "$work/err")"
code=0
PYTHONPATH=$work/evil CLUSTERMCML_PYTHON=$cold_python "$program" plot "$work/fig5.mco" -o "$work/none.svg" 2>"$work/err" || code=$?
# The package is first on the path, but its imports are not.
test $code -eq 2 && test "$(cat "$work/err")" = "clustermcml: plot: ValueError: of the current folder (set CLUSTERMCML_TRACEBACK=1 to see where)" ||
    complain "a library's error: $code $(cat "$work/err")"
finish
