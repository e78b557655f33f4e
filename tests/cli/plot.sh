#!/bin/sh
# Pictures are what their names say, complete or absent.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
command -v gnuplot >/dev/null || { echo "gnuplot is missing"; exit 77; }
for sample in fig5 shapes/hinoise shapes/plane; do
    expect_code 0 samples/$sample.mci --photons 2e4 --quiet -o "$work"
done

starts_with() { # FILE BYTES
    test "$(head -c 200 "$1" | tr -d '\0' | grep -c "$2")" -ge 1 || complain "$1 does not begin like $2"
}

expect_code 0 plot "$work/hinoise.mco" -o "$work/one.svg"
test "$(cat "$work/out")" = "$work/one.svg" || complain "plot does not name its picture"
starts_with "$work/one.svg" '<svg'
tail -3 "$work/one.svg" | grep -q '</svg>' || complain "the svg has no end"
grep -q 'height' "$work/one.svg" || complain "the heightfield is not drawn"
expect_code 0 plot "$work/fig5.mco" -o "$work/flat.svg"
grep -q 'height \[cm\]' "$work/flat.svg" && complain "a plane has an axis of heights"
expect_code 0 plot "$work/hinoise.mco" "$work/plane.mco" "$work/fig5.mco" -o "$work/three.PNG" --quiet
test ! -s "$work/out" || complain "--quiet was not quiet"
starts_with "$work/three.PNG" PNG

# Names are data, never commands or markup.
odd="$work/a'b\"c\$d_{e}^f\\g\`h\`<i>&%s@~#.mco"
cp "$work/plane.mco" "$odd"
expect_code 0 plot "$odd" "$work/fig5.mco" -o "$work/odd'\$name.svg"
if command -v xmllint >/dev/null; then
    xmllint --noout "$work/odd'\$name.svg" 2>"$work/xml" || complain "the svg is not XML: $(cat "$work/xml")"
fi
grep -q 'd_{e}^f' "$work/odd'\$name.svg" || complain "the odd name is not in the legend"

for name in p.jpg a.svg/b svg; do
    expect_error 2 "--output $name (expected a name that ends in .svg, .png, .pdf or .eps)" plot "$work/fig5.mco" -o $name
done
expect_code 0 plot "$work/fig5.mco" -o "$work/one.pdf"
starts_with "$work/one.pdf" '%PDF-'
tail -1 "$work/one.pdf" | grep -q '%%EOF' || complain "the PDF has no end"
expect_code 0 plot "$work/fig5.mco" -o "$work/one.EPS"
starts_with "$work/one.EPS" '%!PS-Adobe-.* EPSF'
expect_code 2 plot "$work/missing.mco" -o "$work/none.svg"
expect_code 2 plot samples/fig5.mci -o "$work/none.svg"
expect_code 5 plot "$work/fig5.mco" -o "$work/missing/none.svg"

# Curves of others: dashed, in the colour of the result that stands at the same place; a caption breaks into lines.
curve=tests/reference/profiles/hinoise.reentry.csv
expect_code 0 plot $curve "$work/hinoise.mco" -o "$work/curve.svg" --caption "A caption of <one> & 'two' words $(printf '%0200d' 0) end"
grep -q 'hinoise.reentry.csv' "$work/curve.svg" || complain "the curve is not in the legend"
grep -q 'stroke-dasharray' "$work/curve.svg" || complain "the curve is not dashed"
grep -q "A caption of &lt;one> &amp; 'two' words" "$work/curve.svg" || complain "the caption is missing"
test "$(grep -c '#0072B2\|rgb(  0, 114, 178)' "$work/curve.svg")" -ge 2 || complain "the curve has another colour"

# Whatever a caption or a name holds is drawn as it stands, and nothing in it is an order to gnuplot.
for text in "'at both ends'" "''two'' '''three'''" "'" "a \"quoted\" word\"" 'back\slash\' '`touch '"$work"'/called`7' '@x % $0'; do
    expect_code 0 plot "$work/fig5.mco" -o "$work/text.svg" --caption "$text"
    drawn=$(printf %s "$text" | sed 's/&/\&amp;/g; s/</\&lt;/g')
    grep -Fq ">$drawn</text>" "$work/text.svg" || complain "the caption $text is not drawn: $(cat "$work/err")"
    cp "$work/fig5.mco" "$work/$(printf %s "$text" | tr / :).mco"
    expect_code 0 plot "$work/$(printf %s "$text" | tr / :).mco" -o "$work/text.svg"
done
test ! -e "$work/called" || complain "a caption was run as a command"

# The title is the scene's name, without an ending of results.
if "$program" --version | grep -q "HDF5 yes"; then
    sed 's/^fig5.mco A/fig5.h5 B/' samples/fig5.mci >"$work/fig5.mci"
    expect_code 0 "$work/fig5.mci" --photons 1000 --quiet -o "$work"
    expect_code 0 plot "$work/fig5.h5" -o "$work/text.svg"
    grep -q '>fig5</text>' "$work/text.svg" || complain "the title of an .h5: $(grep -o '>fig5[^<]*<' "$work/text.svg")"
fi

# But for what XML does not have: the end of CDATA, controls, halves of surrogates, characters too long or beyond the last.
while read -r bytes drawn; do
    text=$(printf "$bytes") drawn=$(printf "$drawn")
    expect_code 0 plot "$work/fig5.mco" -o "$work/text.svg" --caption "$text" --title "$text" --label "$text"
    test "$(grep -Fc ">$drawn</text>" "$work/text.svg")" -ge 2 || complain "the caption $bytes is not drawn as $drawn"
    ! command -v xmllint >/dev/null || xmllint --noout "$work/text.svg" 2>"$work/xml" || complain "$bytes: the svg is not XML: $(cat "$work/xml")"
done <<'END'
a]]>b a?]>b
a]]]>b a]?]>b
a\355\240\200b a???b
a\355\277\277b a???b
a\340\237\277b a???b
a\360\217\277\277b a????b
a\364\220\200\200b a????b
a\357\277\276b a???b
a\001b\177 a?b?
\355\237\277\356\200\200\364\217\277\277\357\277\275 \355\237\277\356\200\200\364\217\277\277\357\277\275
END
bad_curve() { # MESSAGE TEXT
    printf "$2" >"$work/bad.csv"
    expect_error 2 "$work/bad.csv$1" plot "$work/bad.csv" -o "$work/none.svg"
}
columns="two or three columns of numbers: place, value, standard error"
bad_curve ": columns is missing (expected $columns)" ''
bad_curve ":1: columns = a (expected $columns)" 'a,b,c,d\n'
bad_curve ':1: rows is missing (expected 2 or more)' 'bin,r,Rd_r_per_cm2\n'
bad_curve ': Rd_r is missing (expected a column of this name, or Tt_r)' 'bin,r_mid_cm\n'
bad_curve ':3: Rd_r = x (expected a number of 0 or more)' '# c\nr_mid_cm,Rd_r_per_cm2\n0.5,x\n'
bad_curve ':3: standard error = -1 (expected a number of 0 or more)' '# c\nr value error\n0.5 1 -1\n'
bad_curve ':3: row is missing (expected as many columns as in the first line)' '1 2 3\n\n2 3\n'
bad_curve ':2: r_mid_cm = 1 (expected more than in the row before)' '1,1\n1,1\n'
bad_curve ':2: rows is missing (expected 2 or more)' 'r_mid_cm,Tt_r_per_cm2\n0,1\n'

# No text of any picture runs through another.
check_texts

# Without gnuplot, and with one that fails: one line, no picture, the old picture stays.
mkdir "$work/bin"
real=$program
program=$work/elsewhere
printf '#!/bin/sh\nPATH="%s" exec "%s" "$@"\n' "$work/bin" "$real" >"$program"
chmod +x "$program"
expect_error 5 "gnuplot cannot be started (No such file or directory); is it installed?" \
    plot "$work/fig5.mco" -o "$work/none.svg"
printf '#!/bin/sh\necho first >&2\necho broken >&2\nexit 3\n' >"$work/bin/gnuplot"
chmod +x "$work/bin/gnuplot"
cp "$work/one.svg" "$work/kept.svg"
expect_error 5 "gnuplot failed (broken)" plot "$work/fig5.mco" -o "$work/one.svg"
cmp -s "$work/one.svg" "$work/kept.svg" || complain "a failed plot changed the old picture"
ls "$work" | grep -q -e none -e '\.tmp$' && complain "a failed plot left a file"
finish
