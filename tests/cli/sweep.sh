#!/bin/sh
# Tests --sweep. A row's result has the bytes of a run with --set of its cells, but for its name. The table of all rows agrees
# with the rows' files. Shapes are loaded once unless they change. All rows are validated before the first one flies, and a
# wrong cell is named. The .h5 has the parameters as axes if the table is a full grid.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
bare() { sed -e '/^# User time/d' -e 's/^[^ ]* \tA\t/NAME /' "$1"; }
mkdir "$work/rows" "$work/meshes"
cp meshes/ridges.obj "$work/meshes/"
sed 's,"../meshes/,"meshes/,' samples/ridges.mci >"$work/ridges.mci"

# One table sets media, a shape, the beam, photons and seeds.
cat >"$work/table.csv" <<'END'
# a comment
layer1.mua, boundary0.height , beam.angle,photons,seed

0.5,1,0,2000,1
2,1,30,2000,1   # of this row
0.5,0.5,0,1500,7
0.5,1,0,2000,2
END
expect_code 0 "$work/ridges.mci" --sweep "$work/table.csv" -o "$work/rows" --quiet --set layer1.g=0.7
test "$(wc -l <"$work/rows/ridges.sweep.csv")" -eq 5 || complain "the table: $(cat "$work/rows/ridges.sweep.csv")"
row=0
for set in "0.5 1 0 2000 1" "2 1 30 2000 1" "0.5 0.5 0 1500 7" "0.5 1 0 2000 2"; do
    row=$((row + 1))
    set -- $set
    mkdir "$work/single"
    expect_code 0 "$work/ridges.mci" --set layer1.g=0.7 --set layer1.mua=$1 --set boundary0.height=$2 --set beam.angle=$3 --set photons=$4 \
        --seed $5 -o "$work/single" --quiet
    bare "$work/single/ridges.mco" >"$work/a"
    bare "$work/rows/ridges-000$row.mco" >"$work/b"
    cmp -s "$work/a" "$work/b" || complain "row $row: not the bytes of a run with --set: $(diff "$work/a" "$work/b" | head -5)"
    # The table has the totals of the file, with more digits.
    wanted=$(awk '/^RAT/ { getline; a = $1; getline; b = $1; getline; c = $1; getline; print a, b, c, $1; exit }' "$work/rows/ridges-000$row.mco")
    found=$(awk -F, -v row=$row 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i } $1 == row {
        printf "%.6G %.6G %.6G %.6G %.4G %.4E\n", $at["Rsp"], $at["Rd"], $at["A"], $at["Tt"], $at["layer1.A"], $at["layer1.A_se"] }' "$work/rows/ridges.sweep.csv")
    wanted="$wanted $(awk '/^A_l/ { getline; print $1; exit }' "$work/rows/ridges-000$row.mco") $(awk '/^se_A_l/ { getline; print $1; exit }' "$work/rows/ridges-000$row.mco")"
    test "$found" = "$wanted" || complain "row $row: $found in the table, $wanted in the file"
    test "$(awk -F, -v row=$row '$1 == row { print $NF }' "$work/rows/ridges.sweep.csv")" = ridges-000$row.mco || complain "the file of row $row"
    rm -r "$work/single"
done
test "$(head -1 "$work/rows/ridges.sweep.csv")" = \
    "row,layer1.mua,boundary0.height,beam.angle,photons,seed,Rsp,Rsp_se,Rd,Rd_se,A,A_se,Tt,Tt_se,layer1.A,layer1.A_se,lost,file" ||
    complain "the header: $(head -1 "$work/rows/ridges.sweep.csv")"

# --json prints one object per row, with its number.
mkdir "$work/out.d"
expect_code 0 "$work/ridges.mci" --sweep "$work/table.csv" -o "$work/out.d" --json
test "$(grep -c '"row":[1-4],' "$work/out")" -eq 4 && test "$(wc -l <"$work/out")" -eq 4 || complain "--json: $(cat "$work/out")"
test "$(ls "$work/out.d" | grep -c -v -e 'ridges-000[1-4].mco$' -e 'ridges-000[1-4].h5$' -e '^ridges.sweep')" -eq 0 || complain "left: $(ls "$work/out.d")"

# Bodies: rows with other media, and a row whose layers lie elsewhere.
printf 'v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\nf 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n' \
    >"$work/octahedron.obj"
printf '1.0\n1\nbodies.mco A\n2000\n0.1 0.1\n20 20 5\n2\n1\n1.4 0.1 5 0.8 0.1\n1.4 1 20 0.8 1\n' >"$work/bodies.mci"
printf 'i sphere 0 0 0.6 0.2 1.5 2 10 0.5\ni "octahedron.obj" 1 2 10 0.5 scale=0.2 shift=0.5,0,-0.6\n1\n' >>"$work/bodies.mci"
printf 'body1.mua,body2.n,layer1.d\n2,1,0.1\n5,1.4,0.1\n5,1.4,0.15\n' >"$work/bodies.csv"
mkdir "$work/bodies"
expect_code 0 "$work/bodies.mci" --sweep "$work/bodies.csv" -o "$work/bodies" --quiet
row=0
for set in "2 1 0.1" "5 1.4 0.1" "5 1.4 0.15"; do
    row=$((row + 1))
    set -- $set
    mkdir "$work/single"
    expect_code 0 "$work/bodies.mci" --set body1.mua=$1 --set body2.n=$2 --set layer1.d=$3 -o "$work/single" --quiet
    bare "$work/single/bodies.mco" >"$work/a"
    bare "$work/bodies/bodies-000$row.mco" >"$work/b"
    cmp -s "$work/a" "$work/b" || complain "bodies, row $row: not the bytes of a run with --set: $(diff "$work/a" "$work/b" | head -5)"
    rm -r "$work/single"
done

# The format of results is that of the scene file.
sed 's/^ridges.mco A/ridges.mco B/' "$work/ridges.mci" >"$work/binary.mci"
mkdir "$work/binary"
expect_code 0 "$work/binary.mci" --sweep "$work/table.csv" -o "$work/binary" --quiet
test "$(ls "$work/binary" | grep -c 'ridges-000[1-4].h5$')" -eq 4 && test ! -e "$work/binary/ridges-0001.mco" ||
    complain "format B: $(ls "$work/binary")"

# Nothing flies if a row is wrong.
wrong() { # MESSAGE TABLE
    printf "$2" >"$work/wrong.csv"
    rm -rf "$work/none"
    mkdir "$work/none"
    expect_error 2 "$work/wrong.csv$1" "$work/ridges.mci" --sweep "$work/wrong.csv" -o "$work/none"
    test -z "$(ls "$work/none")" || complain "$1: wrote $(ls "$work/none")"
}
wrong ":3: column 2, layer1.mua = -1 (expected a coefficient of 0..1e30 1/cm)" 'layer1.g,layer1.mua\n0.5,1\n0.5,-1\n'
wrong ":2: column 1, layer1.mua = x (expected a coefficient of 0..1e30 1/cm)" 'layer1.mua\nx\n'
wrong ":3: number of cells = 1 (expected 2, as many as names)" 'layer1.mua,layer1.g\n1,0\n1\n'
wrong ":2: number of cells = 3 (expected 2, as many as names; commas part cells, decimals have a point)" 'layer1.mua,layer1.g\n1,0,1\n'
wrong ":1: column 1 = layer1.mua; layer1.g (expected one name; commas part the columns)" 'layer1.mua; layer1.g\n1; 0,5\n'
wrong ":2: column 1, layer1.mua = 0;5 (expected a coefficient of 0..1e30 1/cm, without ;)" 'layer1.mua\n0;5\n'
wrong ":2: column 2, layer1.g is missing (expected a value)" 'layer1.mua,layer1.g\n1,\n'
wrong ":1: column 2 = layer1.mua (expected a name that no other column has)" 'layer1.mua,layer1.mua\n1,1\n'
wrong ":1: column 2 is missing (expected a name like layer1.mua)" 'layer1.mua,\n1,1\n'
wrong ":1: the first row is missing (expected a value for every name)" 'layer1.mua\n'
wrong ":2: the line of names is missing (expected layer1.mua, photons or others)" '# nothing\n\n'
wrong ":2: column 1, seed = -3 (expected a whole number from 0 to 9007199254740992)" 'seed\n-3\n'
wrong ":2: column 1, seed = 9007199254740993 (expected a whole number from 0 to 9007199254740992)" 'seed\n9007199254740993\n'
wrong ":3: column 1, boundary0.scale = 0 (expected a number of 1e-30..1e30)" 'boundary0.scale\n1\n0\n'
wrong ":1: label = a_b (expected a name that no other column has, with _ for /)" 'layer1.mua,"a/b","a_b"\n1,2,3\n'
wrong ":1: label = a/b (expected a name that no other column has, with _ for /)" '"a_b",layer1.mua,"a/b"\n1,2,3\n'
wrong ":2: label = . (expected a name other than .)" '# names\nlayer1.mua,"."\n1,2\n'
wrong ":1: label = detector/1 (expected a name that the table of results has not already)" '"detector/1",layer1.mua\n1,2\n'
# A column is a parameter or a label. A label in quotes must have a name that nothing in the scene has. A name without quotes
# that is far from all settable names is a label, with a note. A name that is close to one is refused, and the message tells
# the way out.
label="the name without quotation marks, if it is to be set; a label has a name that nothing in the scene has"
wrong ":1: column 1 = layer1.mua (expected $label)" '"layer1.mua",layer1.mus\n.5,20\n5,20\n'
wrong ":1: column 2 = boundary0.height (expected $label)" 'layer1.mua,"boundary0.height"\n1,1\n'
wrong ":1: column 2 = seed (expected $label)" 'layer1.mua,"seed"\n1,1\n'
wrong ":1: column 2 = photons (expected $label)" 'layer1.mua,"photons"\n1,100\n'
for near in mua layer2.mua layer1_mua photon angel; do
    printf "layer1.mus,$near\n20,1\n" >"$work/wrong.csv"
    expect_code 2 "$work/ridges.mci" --sweep "$work/wrong.csv" -o "$work"
    grep -q "column 2, $near = 1 (expected a name that the run in line [0-9]* knows: .*; a label stands in quotation marks)$" "$work/err" ||
        complain "a name near one that is set: $(cat "$work/err")"
done
mkdir "$work/labels"
printf 'wavelength,layer1.mua\n500,1\n600,2\n' >"$work/plain.csv"
sed 's/wavelength/"wavelength"/' "$work/plain.csv" >"$work/quoted.csv"
for file in quoted plain; do
    expect_code 0 "$work/ridges.mci" --sweep "$work/$file.csv" --photons 300 --quiet -o "$work/labels"
    cp "$work/labels/ridges.sweep.csv" "$work/$file.out"
done
cmp -s "$work/quoted.out" "$work/plain.out" || complain "a label without marks: $(diff "$work/quoted.out" "$work/plain.out")"
test "$(cat "$work/err")" = "clustermcml: note: $work/plain.csv:1: column 1, wavelength, is a label: the scene has no number of that name" ||
    complain "a label without marks: $(cat "$work/err")"
expect_code 0 check "$work/ridges.mci" --sweep "$work/plain.csv"

# A layer's name can be used in columns. Columns with numbers of layers are noted if other layers may be meant, but not where
# names are used.
sed 's/^1.4 0.1 5 .*/& name=gel/' "$work/bodies.mci" >"$work/gel.mci"
for file in layer1 gel; do
    printf "$file.mua,$file.d\n2,0.1\n3,0.1\n" >"$work/named.csv"
    mkdir "$work/$file"
    expect_code 0 "$work/gel.mci" --sweep "$work/named.csv" --photons 300 --quiet -o "$work/$file"
    test ! -s "$work/err" || complain "a layer with a name: $(cat "$work/err")"
    grep -v -e '^# User time' -e '^# set' "$work/$file/bodies-0002.mco" >"$work/$file.out"
    grep -q "^# set $file.mua = 3$" "$work/$file/bodies-0002.mco" || complain "$file.mua is not in the result"
done
cmp -s "$work/layer1.out" "$work/gel.out" || complain "gel.mua: $(diff "$work/layer1.out" "$work/gel.out")"
printf 'layer1.mua,gel.mua\n1,2\n' >"$work/wrong.csv"
expect_error 2 "$work/wrong.csv:2: column 2, gel.mua = 2 (expected one value, but layer1.mua of $work/wrong.csv has set it to 1)" \
    "$work/gel.mci" --sweep "$work/wrong.csv" -o "$work"
# With --reweight, rows in which the first layer is clear fly apart, whatever its name.
printf 'gel.mua\n0\n1\n2\n' >"$work/clear.csv"
expect_code 0 check "$work/gel.mci" --sweep "$work/clear.csv" --reweight --json
grep -q '"sweep":{"rows":3,"flights":2}' "$work/out" || complain "a clear layer with a name: $(cat "$work/out")"
numbered() { # SCENE NOTES
    expect_code 0 check "$1" --sweep "$work/named.csv"
    test "$(cat "$work/err")" = "$2" || complain "layers by number: $(cat "$work/err")"
}
behind="name=NAME behind the numbers of a layer lets columns say NAME.mua"
printf 'layer2.mua\n2\n' >"$work/named.csv"
numbered "$work/gel.mci" "clustermcml: note: $work/named.csv: layer2 counts from above, in a scene of 2 layers and 2 bodies; $behind"
sed '/^i /d' "$work/bodies.mci" >"$work/two.mci"
numbered "$work/two.mci" "clustermcml: note: $work/named.csv: layer2 counts from above, in a scene of 2 layers and 0 bodies; $behind"
printf 'layer2.mua,layer1.mua\n2,1\n' >"$work/named.csv"
numbered "$work/two.mci" ""

printf 'layer1.x\n1\n' >"$work/wrong.csv"
expect_code 2 "$work/ridges.mci" --sweep "$work/wrong.csv" -o "$work"
grep -q "^clustermcml: $work/wrong.csv:2: column 1, layer1.x = 1 (expected a name that the run in line [0-9]* knows: photons, " "$work/err" ||
    complain "an unknown name: $(cat "$work/err")"
printf 'layer1.d\n1\n0.0001\n' >"$work/wrong.csv"
expect_code 2 samples/mixed.mci --sweep "$work/wrong.csv" -o "$work"
grep -q "^clustermcml: $work/wrong.csv:3: row 2, layer1.d = 0.0001: samples/mixed.mci:[0-9]*: boundaries 0 and 1 cross at" "$work/err" || complain "boundaries that cross: $(cat "$work/err")"
# A start of light that a row makes impossible is found before the first row flies, and the message names the row. The same
# holds for runs of one file.
printf '1.0\n1\nstart.mco A\n100\nbeam pencil z=0.2 light=na:0.5\n0.1 0.1\n2 2 2\n1\n1.0\n1.4 1 9 0.8 1\n' >"$work/start.mci"
{ cat "$work/start.mci" && echo 'backing 0.5' && echo 1; } >"$work/backed.mci"
echo 1 >>"$work/start.mci"
unstarted() { # SCENE MESSAGE TABLE
    printf "$3" >"$work/wrong.csv"
    expect_error 2 "$work/wrong.csv:3: row 2, $2" "$1" --sweep "$work/wrong.csv" -o "$work/none"
    test -z "$(ls "$work/none")" || complain "$2: wrote $(ls "$work/none")"
    expect_error 2 "$work/wrong.csv:3: row 2, $2" check "$1" --sweep "$work/wrong.csv"
}
unstarted "$work/start.mci" "beam.z = 1: $work/start.mci:5: beam: at z = (0 0 1) (expected a place inside a medium, more than 9.5e-07 cm from its surface; it lies on one)" \
    'beam.z\n0.5\n1\n'
unstarted "$work/start.mci" "beam.na = 1.3, beam.z = -1: $work/start.mci:5: beam: light = na:1.3 (expected at most n = 1 of the medium that it starts in)" \
    'beam.na,beam.z\n1.3,0.5\n1.3,-1\n'
unstarted "$work/backed.mci" "beam.z = 1.5: $work/backed.mci:5: beam: z = 1.5 (expected a source that lies above the backing with all its points)" \
    'beam.z\n0.5\n1.5\n'
{ sed 's/^1$/2/' "$work/start.mci" | sed '8s/2/1/'; sed -n '3,$p' "$work/start.mci" | sed 's/start/second/; s/z=0.2/z=1/'; } >"$work/second.mci"
expect_error 2 "$work/second.mci:14: beam: at z = (0 0 1) (expected a place inside a medium, more than 9.5e-07 cm from its surface; it lies on one)" \
    "$work/second.mci" -o "$work/none"
test -z "$(ls "$work/none")" || complain "the first of two runs wrote $(ls "$work/none")"
printf 'layer1.mua\n1\n' >"$work/one.csv"
expect_error 2 "$work/one.csv:2: column 1, layer1.mua = 1 (expected one value, but --set has set it to 2)" \
    "$work/ridges.mci" --sweep "$work/one.csv" --set layer1.mua=2 -o "$work"
for option in photons seed; do
    printf "$option\n3\n" >"$work/two.csv"
    expect_error 2 "$work/two.csv:2: column 1, $option = 3 (expected no value beside that of --$option)" \
        "$work/ridges.mci" --sweep "$work/two.csv" --$option 5 -o "$work"
done
expect_error 2 "--sweep $work/one.csv (expected a file with one run; samples/two_runs.mci has 2)" samples/two_runs.mci --sweep "$work/one.csv"
sed '5a photons "exits"' "$work/ridges.mci" >"$work/saved.mci"
expect_error 2 "$work/saved.mci:6: a photons line and --reweight, whose rows have no packets of their own (expected no such line)" \
    "$work/saved.mci" --sweep "$work/one.csv" --reweight -o "$work"
# Each row saves packets in a file of its own.
mkdir "$work/saved"
expect_code 0 "$work/saved.mci" --sweep "$work/one.csv" --photons 300 --quiet -o "$work/saved"
expect_code 0 "$work/saved.mci" --sweep "$work/one.csv" --photons 300 -o "$work/saved"
test "$(cat "$work/err")" = "clustermcml: note: replaces $work/saved/ridges.sweep.csv" || complain "no word of the table replaced: $(cat "$work/err")"
# A sweep whose rows have all finished, by their checkpoints, also counts as finished for --no-clobber.
mkdir "$work/done"
expect_code 0 "$work/saved.mci" --sweep "$work/one.csv" --photons 300 --quiet --resume -o "$work/done"
expect_code 0 "$work/saved.mci" --sweep "$work/one.csv" --photons 300 --quiet --resume --no-clobber -o "$work/done"
expect_code 2 "$work/saved.mci" --sweep "$work/one.csv" --photons 300 --quiet --no-clobber -o "$work/done"
rm "$work/done"/*.checkpoint
expect_code 2 "$work/saved.mci" --sweep "$work/one.csv" --photons 300 --quiet --resume --no-clobber -o "$work/done"
grep -q '^clustermcml: --no-clobber: .* exists (expected another name or folder, or no --no-clobber)$' "$work/err" || complain "rows without checkpoints: $(cat "$work/err")"
test -f "$work/saved/exits-0001.photons.h5" && test ! -f "$work/saved/exits.photons.h5" || complain "saved: $(ls "$work/saved")"
expect_error 2 "$work/missing.csv: cannot be read: No such file or directory (expected a file)" "$work/ridges.mci" --sweep "$work/missing.csv"
# A file that is too large is refused before it is read: a table of a sweep, or a file that the scene names.
truncate -s 20G "$work/large.csv"
large="cannot be read: it has 21474836480 bytes (expected a table of at most 268435456 bytes)"
expect_error 2 "$work/large.csv: $large" "$work/ridges.mci" --sweep "$work/large.csv"
for line in 'beam pencil light="large.csv"' 'detector table "large.csv"' 'phase table "large.csv"' 'b "large.csv"'; do
    { sed -n 1,4p "$work/two.mci"; case $line in beam* | det*) echo "$line" ;; esac; sed -n 5,8p "$work/two.mci"
        case $line in b\ *) echo "$line" ;; esac; sed -n 9p "$work/two.mci"; case $line in phase*) echo "$line" ;; esac
        sed -n '10,$p' "$work/two.mci"; } >"$work/names_large.mci"
    (ulimit -v 4000000 && exec "$program" check "$work/names_large.mci") >"$work/out" 2>"$work/err" && complain "$line: not refused"
    grep -q "$work/large.csv: $large\$" "$work/err" || complain "$line: $(cat "$work/err")"
done
rm "$work/large.csv"
code=0
yes 1,2 | head -c 268435457 | "$program" "$work/ridges.mci" --sweep - >"$work/out" 2>"$work/err" || code=$?
test $code = 2 && grep -q '^clustermcml: standard input: cannot be read: it has more than 268435456 bytes (expected a table of at most 268435456 bytes)$' "$work/err" ||
    complain "a large table through a pipe: $(cat "$work/err")"
cp "$work/one.csv" "$work/ridges.sweep.csv"
expect_code 2 "$work/ridges.mci" --sweep "$work/ridges.sweep.csv" -o "$work"
grep -q "it would overwrite the input $work/ridges.sweep.csv" "$work/err" || complain "the table would be overwritten: $(cat "$work/err")"
# --resume of a sweep that was flown without --resume flies all rows anew, and says so once. Results of more photons stay
# unless --replace is given, also for rows that come from one flight.
anew() { # PHOTONS ARGUMENTS... : rows in $work/anew
    photons=$1
    shift
    rm -f "$work/anew"/*.checkpoint
    expect_code 0 "$work/two.mci" --sweep "$work/named.csv" --photons $photons --quiet -o "$work/anew" "$@"
}
better() { # ARGUMENTS: nothing is replaced
    md5sum "$work/anew"/* >"$work/before"
    expect_code 2 "$work/two.mci" --photons 299 --resume --quiet -o "$work/anew" "$@"
    grep -q "^clustermcml: .*--resume: $work/anew/bodies.*\.mco of 300 photons is of another run, and would be replaced by 299 photons (expected --photons of as many, or --replace)$" \
        "$work/err" || complain "results of more photons: $(cat "$work/err")"
    md5sum "$work/anew"/* | cmp -s - "$work/before" || complain "results of more photons: $(ls -l "$work/anew")"
}
mkdir "$work/anew"
printf 'layer2.mua,layer1.mua\n2,1\n3,1\n4,1\n' >"$work/named.csv"
anew 300
expect_code 0 "$work/two.mci" --photons 300 --quiet -o "$work/anew"
better --sweep "$work/named.csv"
better --sweep "$work/named.csv" --reweight
better
begins="they begin anew; replaces $work/anew/bodies-0001.mco of 300 photons"
for more in "--resume" "--resume --replace" "--resume --reweight --replace"; do
    photons=300
    test "$more" = --resume || photons=299
    anew 300
    anew $photons $more
    test "$(grep -v effective "$work/err")" = "clustermcml: note: --resume finds no checkpoint of 3 of 3 rows whose results are there: $begins, and others" ||
        complain "$more: $(cat "$work/err")"
    anew 300
    rm -f "$work/anew"/bodies-000[23].mco
    expect_code 0 "$work/two.mci" --sweep "$work/named.csv" --photons 400 --quiet -o "$work/anew" --resume
    test "$(cat "$work/err")" = "clustermcml: note: --resume finds no checkpoint of 1 of 3 rows whose results are there: $begins" || complain "one row: $(cat "$work/err")"
    expect_code 0 "$work/two.mci" --sweep "$work/named.csv" --photons 400 --quiet -o "$work/anew" --resume
    test ! -s "$work/err" || complain "rows that are finished: $(cat "$work/err")"
done
expect_code 0 "$work/two.mci" --photons 299 --resume --replace --quiet -o "$work/anew"
grep -q '^299 ' "$work/anew/bodies.mco" || complain "--replace: $(sed -n 1,20p "$work/anew/bodies.mco")"
# The light of detectors is in both tables, under the names of the scene. It equals that of the rows' own records, also for
# rows that were finished before.
printf '1.0\n1\nseen.mco A\n2000\n0.1 0.1\n5 5 5\ndetector disk 0.2\ndetector ring 0.2 1 name=far\n1\n1\n1.4 1 50 0.8 0.2\n1\n' >"$work/seen.mci"
printf 'detector1.x,layer1.mua\n0,1\n0.3,1\n0.3,2\n' >"$work/seen.csv"
mkdir "$work/seen"
expect_code 0 "$work/seen.mci" --sweep "$work/seen.csv" -o "$work/seen" --json --resume
cp "$work/out" "$work/seen/json"
cp "$work/seen/seen.sweep.csv" "$work/seen/once"
expect_code 0 "$work/seen.mci" --sweep "$work/seen.csv" -o "$work/seen" --quiet --resume
cmp -s "$work/seen/once" "$work/seen/seen.sweep.csv" || complain "detectors: another table with --resume"
for name in detector_1 detector_1_se detector_far detector_far_se; do
    awk -F, -v name=$name 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == name) column = i } NR > 1 { printf "%.10g\n", $column }' \
        "$work/seen/seen.sweep.csv" >"$work/a"
    sed "s/.*\"$name\":\([^,]*\),.*/\1/" "$work/seen/json" | awk '{ printf "%.10g\n", $1 }' >"$work/b"
    test "$(sort -u "$work/a" | wc -l)" -ge 2 && cmp -s "$work/a" "$work/b" || complain "$name: $(cat "$work/a") in the table, $(cat "$work/b") of the rows"
done
# The message about lost packets names the row that loses them.
printf '1.0\n1\nlosing.mco A\n500\nbeam disk 0.1\n0.01 0.01\n10 10 3\n2\n1.0\nm "%s/meshes/furrows.gsf" tile\n1.4 1 50 0.8 0.3\n1.5 2 20 0.5 0.3\n1.0\n' "$PWD" >"$work/losing.mci"
printf 'boundary0.scale\n1e-5\n' >"$work/small.csv"
expect_code 4 "$work/losing.mci" --sweep "$work/small.csv" --quiet -o "$work"
grep -q "of 500 packets lost" "$work/err" || complain "a row that loses packets: $(cat "$work/err")"
finish
