#!/bin/sh
# plot of sweeps and of directions: what is drawn are the numbers of the tables and files; columns that are not named are chosen by
# what tells rows apart, and what cannot be drawn is refused.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
command -v gnuplot >/dev/null || { echo "gnuplot is missing"; exit 77; }

# Two grids of rows, out of order, and a spectrum of two leaves with labels.
printf '1.0\n1\ngrid.mco A\n300\n0.1 0.1\n5 5 2\n1\n1\n1.4 1 50 0.8 0.1\n1\n' >"$work/grid.mci"
sed -e 's/grid/leaf/' -e '6a directions 3 8' "$work/grid.mci" >"$work/leaf.mci"
printf 'layer1.mua,layer1.mus\n3,50\n0.5,50\n1,50\n0.5,20\n1,20\n' >"$work/grid.csv"
printf '"nm",layer1.mua,layer1.mus,"leaf"\n500,3,50,old\n450,9,60,old\n500,2,50,"young, wet"\n450,5,60,"young, wet"\n' >"$work/leaf.csv"
for name in grid leaf; do expect_code 0 "$work/$name.mci" --sweep "$work/$name.csv" --quiet -o "$work"; done
grid=$work/grid.sweep.csv leaf=$work/leaf.sweep.csv

# Everything as gnuplot draws it.
expect_code 0 plot "$grid" -o "$work/grid.svg" --title "A title"
expect_code 0 plot "$leaf" "$leaf" --label one --label two --of A -o "$work/leaf.svg"
expect_code 0 plot "$grid" "$grid" --over layer1.mua,layer1.mus -o "$work/map.svg"
expect_code 0 plot "$work/leaf-0001.mco" --of Rd_dir -o "$work/dir.svg"
for text in 'grid.svg>layer1.mus = 20<' 'grid.svg>layer1.mua  \[1/cm\]<' 'grid.svg>Rd  \[-\]<' 'leaf.svg>one: leaf = young, wet<' 'leaf.svg>nm<' \
    'leaf.svg>two: leaf = old<' 'map.svg>layer1.mus  \[1/cm\]<' 'map.svg>grey: no row<' 'map.svg>0.5<' 'dir.svg>θ cos φ \[degree\]<' 'dir.svg>Rd(θ,φ)  \[1/sr\]<'; do
    grep -q "${text#*svg}" "$work/${text%%>*}" || complain "$text is not there"
done
check_texts

# Numbers: points are those of the table, x rising; pixels too; a direction has the colour of its bin.
keep_gnuplot_script
cat >"$work/numbers.py" <<'END'
import csv, math, sys
script, table, of, over, by = sys.argv[1:]
rows, text = list(csv.DictReader(open(table))), open(script).read()
def near(a, b): return abs(float(a) - float(b)) < 6e-5 * abs(float(b)) or a == b
if "," in over:
    x, y = over.split(",")
    xs, ys = (sorted({float(row[name]) for row in rows}) for name in (x, y))
    lines = text.split("$map0 << EOD\n")[1].split("EOD")[0].strip().split("\n")
    down, across = len(lines) // len(ys), len(lines[0].split()) // len(xs)
    for j, b in enumerate(ys):
        for i, a in enumerate(xs):
            want = [row[of] for row in rows if (float(row[x]), float(row[y])) == (a, b)]
            got = lines[j * down + down // 2].split()[i * across + across // 2]
            assert near(got, want[0]) if want else got == "NaN", (a, b, got, want)
    sys.exit()
for k, value in enumerate(dict.fromkeys(row[by] for row in rows) if by else [None]):
    want = sorted((float(row[over]), float(row[of]), float(row[of] if of == "photons" else row[of + "_se"])) for row in rows if not by or row[by] == value)
    got = [list(map(float, line.split())) for line in text.split(f"$c0_{k} << EOD\n")[1].split("EOD")[0].strip().split("\n")]
    assert len(got) == len(want), (got, want)
    for (x, y, low, high), (a, b, e) in zip(got, want):
        assert near(x, a) and near(y, b) and (of == "photons" or near(high, b + e)), (x, y, high, a, b, e)
END
numbers() { # TABLE OF OVER BY, then what plot is told
    table=$1 of=$2 over=$3 by=$4
    shift 4
    expect_code 0 plot "$table" "$@" -o "$work/numbers.svg"
    python3 "$work/numbers.py" "$work/script" "$table" "$of" "$over" "$by" 2>"$work/wrong" || complain "plot $*: $(tail -n 1 "$work/wrong")"
}
numbers "$grid" Rd layer1.mua layer1.mus
numbers "$grid" Tt layer1.mus layer1.mua --of Tt --over layer1.mus
numbers "$leaf" Rd nm leaf
numbers "$leaf" A layer1.mua "" --of A --over layer1.mua
numbers "$leaf" A row leaf --of A --over row --by leaf
numbers "$leaf" photons row "" --of photons --over row
numbers "$grid" Rd layer1.mua,layer1.mus "" --over layer1.mua,layer1.mus
numbers "$leaf" A nm,layer1.mua "" --over nm,layer1.mua --of A

expect_code 0 plot "$work/leaf-0001.mco" --of Rd_dir --linear -o "$work/dir.svg"
python3 - "$work/script" "$work/leaf-0001.mco" 2>"$work/wrong" <<'END' || complain "directions: $(tail -n 1 "$work/wrong")"
import math, sys
rows = [line.split() for line in open(sys.argv[1]).read().split("$map0 << EOD\n")[1].split("EOD")[0].strip().split("\n")]
lines = open(sys.argv[2]).read().split("\nRd_dir ")[1].split("\n")[1:25]
n = len(rows)
for t in range(3):
    for p in range(8):
        theta, phi = (t + 0.5) * 30, (p + 0.5) * math.pi / 4
        x, y = (int((theta * f(phi) + 90) / 180 * n) for f in (math.cos, math.sin))
        assert abs(float(rows[y][x]) - float(lines[t * 8 + p])) < 2e-5, (t, p, rows[y][x], lines[t * 8 + p])
assert rows[2][2] == "NaN"
END

expect_code 0 plot "$grid" --logx -o "$work/log.svg"
grep -qx "set logscale x" "$work/script" && grep -qx "set xrange \[0.5:3\]" "$work/script" || complain "--logx: $(grep -n 'xrange\|logscale' "$work/script")"
expect_code 0 plot "$work/grid-0001.mco" --logx -o "$work/log.svg"
expect_error 2 "--logx (expected a lower axis above 0; it begins at 0)" plot "$grid" --logx --xrange 0:1
expect_error 2 "--logx (expected with curves only)" plot "$grid" --logx --over layer1.mua,layer1.mus

# Refused.
printf 'row,"a",layer1.mua,photons,seed,Rsp,Rd\n1,x,1,9,1,0,0.5\n2,x,1,9,1,0,0.6\n' >"$work/same.sweep.csv"
columns="row, layer1.mua, layer1.mus, photons, seed, Rsp, Rsp_se, Rd, Rd_se, A, A_se, Tt, Tt_se, layer1.A, layer1.A_se, lost, file"
expect_error 2 "--of nix (expected a column of $grid: $columns)" plot "$grid" --of nix
for name in A_t detector_far_path Rd_r; do
    expect_error 2 "--of $name (expected a column of $grid: $columns; of a row it stands in the result that the column file names)" plot "$grid" --of $name
done
expect_error 2 "--over file (expected a column of numbers)" plot "$grid" --over file
expect_error 2 "$work/same.sweep.csv: rows 1 and 2 both have layer1.mua = 1 (expected --by, a column that tells them apart)" plot "$work/same.sweep.csv" --over layer1.mua
expect_error 2 "$work/same.sweep.csv: row 2 has layer1.mua = 1 and seed = 1 as another (expected one row for each)" plot "$work/same.sweep.csv" --over layer1.mua,seed
expect_error 2 "$work/same.sweep.csv: rows (expected two that differ in a number, or --over)" plot "$work/same.sweep.csv"
expect_error 2 "--by (expected without two columns of --over)" plot "$grid" --over layer1.mua,layer1.mus --by seed
expect_error 2 "--over (expected with the table of a sweep, NAME.sweep.csv)" plot "$work/leaf-0001.mco" --over layer1.mua
expect_error 2 "$work/leaf-0001.mco (expected the table of a sweep, like $grid)" plot "$grid" "$work/leaf-0001.mco"
expect_error 2 "--crange (expected with maps only)" plot "$grid" --crange 0:1
expect_error 2 "$work/grid-0001.mco: no Rd_dir (expected the result of a scene with a directions line)" plot "$work/grid-0001.mco" --of Rd_dir
cp "$work/grid.csv" "$work/none.sweep.csv"
expect_error 2 "$work/none.sweep.csv: row and Rsp (expected columns of a sweep's results)" plot "$work/none.sweep.csv"

# compare: directions are tested, and a file whose sections are damaged is not called the same.
expect_code 0 "$work/leaf.mci" --photons 20000 --quiet -o "$work"
mv "$work/leaf.mco" "$work/a.mco"
expect_code 0 "$work/leaf.mci" --photons 20000 --seed 2 --quiet -o "$work"
expect_code 0 compare "$work/a.mco" "$work/leaf.mco"
grep -q '^Rd_dir 24 bins in 24 tests, worst z .* at direction \[bin\] ' "$work/out" || complain "compare: $(cat "$work/out")"
sed '/^Rd_dir /{n;s/.*/0.9/;}' "$work/a.mco" >"$work/b.mco"
expect_code 1 compare "$work/b.mco" "$work/leaf.mco" --quiet
damaged() { # SED MESSAGE
    sed "$1" "$work/a.mco" >"$work/b.mco"
    expect_error 2 "$work/b.mco: $2" compare "$work/b.mco" "$work/leaf.mco"
}
damaged '/^Rd_dir /{n;s/.*/nan/;}' "Rd_dir[0] = nan (expected one of 24 numbers)"
damaged '/^directions /,+2d' "se_Rd_dir without bins (expected the section directions before it)"
damaged '/^Tt_dir /d' "Tt_dir is missing (expected it with its bins)"
damaged '/^directions /{n;s/.*/3.5/;}' "directions = 3.5 8 (expected two numbers of bins)"
finish
