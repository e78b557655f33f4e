#!/bin/sh
# Tests --sweep with --reweight: rows that differ only in mua come from one flight, other rows from as few flights as
# possible, and rows in which a medium is clear have flights of their own. Bytes are the same for any number of threads and
# after a stop; engines agree within rounding. Quantities that rows of one flight cannot have are refused by name.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
bare() { sed -e '/^# User time/d' "$1"; }
same_rows() { # DIR DIR WHAT
    for file in "$1"/*.mco "$1"/*.csv; do
        bare "$file" >"$work/a"
        bare "$2/$(basename "$file")" >"$work/b"
        cmp -s "$work/a" "$work/b" || complain "$3: $(basename "$file"): $(diff "$work/a" "$work/b" | head -5)"
    done
}
printf '1.0\n1\ntwo.mco A\n20000\n0.02 0.02\n20 20 5\n2\n1\n1.37 0.5 50 0.8 0.05\n1.4 0.2 30 0.9 0.3\n1\n' >"$work/two.mci"
printf 'layer1.mua,layer2.mua,layer1.mus,"name"\n0.5,0.2,50,a\n1,2,50,b\n5,0.3,50,c\n1,2,60,d\n0,0.2,50,e\n9,90,50,f\n' >"$work/t.csv"
mkdir "$work/one" "$work/three" "$work/reference" "$work/own" "$work/stopped" "$work/whole"

# Rows with another mus, and a row whose first layer does not absorb, have flights of their own.
expect_code 0 "$work/two.mci" --sweep "$work/t.csv" --reweight -o "$work/one" --threads 1
grep -q ': 6 rows of .* in 3 flights$' "$work/out" || complain "flights: $(cat "$work/out")"
test "$(cat "$work/err")" = "clustermcml: note: Tt of 1 of 4 rows comes of fewer than 100 effective packets, that of row 6 of $(sed -n \
    's/.*row 6 of \([0-9]*\) packets:.*/\1/p' "$work/err") packets: there its standard error is rough" || complain "note: $(cat "$work/err")"
for how in "--reweight:3" ":6"; do # check knows it before
    expect_code 0 check "$work/two.mci" --sweep "$work/t.csv" ${how%:*}
    test "$(tail -1 "$work/out")" = "  6 rows of $work/t.csv: ${how#*:} flights" || complain "check $how: $(tail -1 "$work/out")"
done
expect_code 0 check "$work/two.mci" --sweep "$work/t.csv" --reweight --json
grep -q '"sweep":{"rows":6,"flights":3}' "$work/out" || complain "check --json: $(cat "$work/out")"
expect_code 0 "$work/two.mci" --sweep "$work/t.csv" --reweight -o "$work/three" --threads 3 --chunk 77 --quiet
same_rows "$work/one" "$work/three" "threads"

# The row with the least absorption, and rows alone in their flights, equal flights of their own but for the rounding of their
# weights.
expect_code 0 "$work/two.mci" --sweep "$work/t.csv" --ignore-absorption -o "$work/own" --quiet
expect_code 0 "$work/two.mci" --sweep "$work/t.csv" --reweight -o "$work/reference" --quiet --engine reference
for row in 1 4 5; do
    for engine in one reference; do
        awk -F, -v row=$row 'NR == FNR { if ($1 == row) for (i = 8; i <= 19; i++) want[i] = $i; next } $1 == row {
            for (i = 8; i <= 19; i++) if (($i - want[i]) ^ 2 > 1e-12 && (FILENAME !~ /reference/ || ($i - want[i]) ^ 2 > 1e-7)) print row, i, $i, want[i] }' \
            "$work/own/two.sweep.csv" "$work/$engine/two.sweep.csv" >"$work/differ"
        test ! -s "$work/differ" || complain "row $row of $engine: $(cat "$work/differ")"
    done
done

# A medium without scattering gives up light as trapped where it is clear. Rows in which it is clear fly apart, and the others
# absorb that light.
printf '1.0\n1\ntrap.mco A\n500\n0.02 0.02\n5 5 1\nbeam pencil z=0.15 light=isotropic\n3\n1\n1 0 0 0 0.1\ni sphere 0.05 0 0.05 0.01 1 0 0 0\n1.5 0 0 0 0.1\n1 0 0 0 0.1\n1\n' >"$work/trap.mci"
printf 'layer2.mua\n0\n1e-3\n3e-3\n' >"$work/trap.csv"
expect_code 0 "$work/trap.mci" --sweep "$work/trap.csv" -o "$work/own" --quiet
expect_code 0 "$work/trap.mci" --sweep "$work/trap.csv" --reweight -o "$work/three" --quiet
awk -F, 'FNR == 1 { for (i = 1; i <= NF; i++) if ($i == "A") column = i; next } NR == FNR { own[$1] = $column; next }
    ($column - own[$1]) ^ 2 > 1e-6 || (own[$1] > 0.7) != ($1 > 1) { print "row", $1, $column, own[$1] } END { if (NR != 8) print NR, "lines" }' \
    "$work/own/trap.sweep.csv" "$work/three/trap.sweep.csv" >"$work/differ"
test ! -s "$work/differ" || complain "trapped light: $(cat "$work/differ")"
for how in layer2:2: layer2:1:layer2.mus=1 body1:2: body1:1:body1.mus=1; do
    column=${how%%:*} set=${how##*:} how=${how#*:}
    printf '%s.mua\n0\n1e-3\n3e-3\n' $column >"$work/trap.csv"
    # shellcheck disable=SC2086 # no word where there is no setting
    expect_code 0 check "$work/trap.mci" --sweep "$work/trap.csv" --reweight ${set:+--set $set}
    grep -q ": ${how%%:*} flights*\$" "$work/out" || complain "clear in a row of $column $set: $(tail -1 "$work/out")"
done
printf 'layer2.mua,layer2.mus\n0,0\n1e-3,0\n0,1\n1e-3,1\n' >"$work/trap.csv"
expect_code 0 check "$work/trap.mci" --sweep "$work/trap.csv" --reweight
grep -q ": 3 flights$" "$work/out" || complain "mus of a row: $(tail -1 "$work/out")"

# Detectors, gates and directions of rows agree with flights of their own. Light that was never inside counts, below a clear
# layer and below a rough one.
sed -e '4a time 20 30\ndirections 4 6\ndetector ring 0 0.1 name=a\ndetector disk 0.1 na=0.5 at=0.1,0 name=b' -e 's/^20000$/5000/' "$work/two.mci" >"$work/seen.mci"
sed 's/^1.37 /b 4 0.05 0.1 0.15 0.05 0.04 0.02 -0.03 0\n1.5 0 0 0 0.1\n&/; s/^2$/3/' "$work/seen.mci" >"$work/rough.mci"
printf 'layer2.mua\n0.5\n2\n' >"$work/seen.csv"
mkdir "$work/seen_one" "$work/seen_three" "$work/seen_reference" "$work/seen_own"
for scene in seen rough; do
    expect_code 0 "$work/$scene.mci" --sweep "$work/seen.csv" --reweight -o "$work/seen_one" --quiet --threads 1
    expect_code 0 "$work/$scene.mci" --sweep "$work/seen.csv" --reweight -o "$work/seen_three" --quiet --threads 3 --chunk 77
    expect_code 0 "$work/$scene.mci" --sweep "$work/seen.csv" --reweight -o "$work/seen_reference" --quiet --engine reference
    expect_code 0 "$work/$scene.mci" --sweep "$work/seen.csv" -o "$work/seen_own" --quiet
    same_rows "$work/seen_one" "$work/seen_three" "$scene on threads"
    whole "$work/seen_own/two-0001.mco" >"$work/own_whole"
    for engine in one reference; do # numbers of a section: within rounding of those of its own flight, in which one packet may go another way, or interact in another gate
        whole "$work/seen_$engine/two-0001.mco" >"$work/other_whole"
        awk -v most=$(test $engine = one && echo 1e-6 || echo 3e-2) '/^[a-zA-Z_]+/ { key = $1; n = 0; next } /^#|^$/ { next } { n++ }
            key !~ /^(se_)?(R_dir|[RTA]d?t?_t(_later)?|Rd_dir|Tt_dir|Rsp_dir|detector_[ab](_t|_t_later|_path|_interactions|_deepest)?)$/ { next }
            NR == FNR { want[key, n] = $1; if ($1 ^ 2 > top[key] ^ 2) top[key] = $1; next }
            { seen[key]; d = $1 - want[key, n]; if (d * d > (most * top[key] * (key ~ /A_t/ ? 100 : 1)) ^ 2) print key, n, $1, want[key, n] }
            END { for (k in top) if (!(k in seen)) print k, "is missing"; if (length(top) != 42) print length(top), "sections" }' \
            "$work/own_whole" "$work/other_whole" >"$work/differ"
        test ! -s "$work/differ" || complain "$scene of $engine: $(head -20 "$work/differ")"
    done
done

# The sum of A_z of a row near the limit comes from few samples; beyond the limit there are none.
for mua in 60000:"note: A_z of 1 of 2 rows comes of fewer than 100 effective packets, that of row 2 of " \
    70000:"note: rows have no A_z and A_rz: in medium 1 a row has mua above 1250 times mus (or, where mus = 0, times the mua of the palest row)"; do
    printf 'layer1.mua\n0.5\n%s\n' "${mua%%:*}" >"$work/dark.csv"
    expect_code 0 "$work/two.mci" --sweep "$work/dark.csv" --reweight -o "$work/three" --quiet
    grep -qF "${mua#*:}" "$work/err" || complain "dark row: $(cat "$work/err")"
done

# Means for many detectors, media and rows would take too much memory. They are left out, with a note.
awk 'FNR == 5 { for (i = 0; i < 100; i++) print "detector disk 0.1" } { print } /^1.37/ { for (i = 0; i < 1000; i++)
    print "i sphere", i % 25 * 0.01, int(i / 25) * 0.01, 0.025, 0.004, 1.37, 1, 50, 0.8 }' "$work/two.mci" | sed 's/^20000$/10/' >"$work/many.mci"
expect_code 0 "$work/many.mci" --sweep "$work/seen.csv" --reweight -o "$work/three" --quiet --ignore-absorption
grep -qF "note: rows have no means of detectors: 2 rows of 100 detectors and 1004 media take 5.14e+07" "$work/err" || complain "means: $(cat "$work/err")"

# --json prints one object per row, in the order of the table.
expect_code 0 "$work/two.mci" --sweep "$work/t.csv" --reweight -o "$work/three" --json
test "$(sed 's/.*"row":\([0-9]*\),.*"residue":\([0-9.]*\)[,}].*/\1:\2/' "$work/out" | tr '\n' ' ')" = "1:0.0 2:0.0 3:0.0 4:0.0 5:0.0 6:0.0 " ||
    complain "--json: $(cut -c1-300 "$work/out")"

# A sweep with gates and detectors is stopped and resumed.
expect_code 0 "$work/seen.mci" --sweep "$work/t.csv" --reweight -o "$work/whole" --photons 100000 --quiet
"$program" "$work/seen.mci" --sweep "$work/t.csv" --reweight -o "$work/stopped" --photons 100000 --quiet 2>"$work/err" &
sleep 0.3
kill -TERM $!
wait $! && echo "the run was faster than the signal"
expect_code 0 "$work/seen.mci" --sweep "$work/t.csv" --reweight -o "$work/stopped" --photons 100000 --quiet --resume
same_rows "$work/whole" "$work/stopped" "resumed"
expect_code 0 "$work/seen.mci" --sweep "$work/t.csv" --reweight -o "$work/stopped" --photons 100000 --quiet --resume
same_rows "$work/whole" "$work/stopped" "resumed again"
test -z "$(ls "$work/stopped" | grep 'old$')" || complain "resumed again: left $(ls "$work/stopped")"

# A sweep is stopped while rows are being written: the flight's checkpoint holds all rows.
sed -e 's/^20000/100/' -e 's/^20 20 5/20 200 90/' "$work/two.mci" >"$work/slow.mci"
awk 'BEGIN { print "layer1.mua"; for (i = 0; i < 60; i++) print 0.5 + i / 100 }' >"$work/many.csv"
mkdir "$work/halted" "$work/unhalted"
"$program" "$work/slow.mci" --sweep "$work/many.csv" --reweight -o "$work/halted" --quiet 2>"$work/err" &
until test -e "$work/halted/two-0001.mco"; do kill -0 $! || break; done
kill -TERM $!
wait $!
test $? = 75 && grep -q "two.mco: stopped with 60 of 60 rows to fly; --resume continues" "$work/err" || complain "stopped while writing: $(cat "$work/err")"
test ! -e "$work/halted/two-0060.mco" || complain "rows were written on"
expect_code 0 "$work/slow.mci" --sweep "$work/many.csv" --reweight -o "$work/halted" --quiet --resume
expect_code 0 "$work/slow.mci" --sweep "$work/many.csv" --reweight -o "$work/unhalted" --quiet
same_rows "$work/unhalted" "$work/halted" "stopped while writing"

# Refusals.
awk 'BEGIN { print "layer1.mua"; for (i = 0; i < 16000; i++) print 1 + i / 1000 }' >"$work/many.csv"
sed '4a time 1000 50000' "$work/two.mci" >"$work/more.mci"
for command in run check; do
    "$program" $command "$work/more.mci" --sweep "$work/many.csv" --reweight >/dev/null 2>"$work/err" && complain "$command: not refused"
    grep -q "more.mci: two-00001.mco takes [0-9.]*e+0[0-9] GiB (expected at most this machine's" "$work/err" || complain "$command: $(cat "$work/err")"
done
expect_error 2 "--reweight (expected --sweep beside it)" "$work/two.mci" --reweight
expect_error 2 "--reweight (expected --sweep beside it)" check "$work/two.mci" --reweight
printf 'layer1.mua\n1\n-1\n' >"$work/wrong.csv"
expect_error 2 "$work/wrong.csv:3: column 1, layer1.mua = -1 (expected a coefficient of 0..1e30 1/cm)" check "$work/two.mci" --sweep "$work/wrong.csv"
for option in --keep "--more 5" "--target-error 0.1" "--aim Tt" "--engine opencl"; do
    case $option in
        --keep | --more*) name="--keep or --more" ;;
        --engine*) name=$option ;;
        *) name=${option%% *} ;;
    esac
    expect_error 2 "--reweight (expected no $name beside it)" "$work/two.mci" --sweep "$work/t.csv" --reweight $option
done
for line in fluence:fluence "map 5 5 0.1 0.1:a map" "detector map 5 5 0.1 0.1:a detector map"; do
    sed "4a ${line%%:*}" "$work/two.mci" >"$work/more.mci"
    expect_error 2 "--reweight: two.mco has ${line#*:}, which rows cannot share (expected totals, profiles over r and angle, times, directions, detectors that are no maps, and absorption of layers and bodies)" \
        "$work/more.mci" --sweep "$work/t.csv" --reweight
done
finish
