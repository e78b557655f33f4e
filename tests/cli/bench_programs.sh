#!/bin/sh
# Tests that every program of bench/*/*.c runs through: one table on standard output, as many columns in every row as in its
# heading, and positive counts and times. The numbers themselves are not judged here. These programs are those of
# `cmake --build build --target benches`, compiled in less time.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
build=$(dirname "$program")/tests
for source in bench/*/*.c; do
    test -x "$build/bench_$(basename "$source" .c)" || { echo "bench_$(basename "$source" .c) is not built"; exit 77; }
done

# Expects rows below the heading in which all but the first column are numbers, or empty where a row has no such number.
expect_table() { # HEADING ROWS POSITIVE-COLUMN COMMAND ARGUMENTS...
    heading=$1 rows=$2 column=$3
    shift 3
    name=$1
    "$build/$@" >"$work/out" 2>"$work/err" </dev/null || complain "$*: exit $?: $(cat "$work/err")"
    test "$(head -n 1 "$work/out")" = "$heading" || complain "$name: heading $(head -n 1 "$work/out")"
    # A comma within quotes does not separate columns.
    sed '1!s/"[^"]*"/row/' "$work/out" | awk -F, -v rows="$rows" -v column="$column" '
        NR == 1 { columns = NF; next }
        NF != columns || $column !~ /^[0-9.]+$/ || $column <= 0 { print "row " NR ": " $0; bad = 1 }
        { for (i = 2; i <= NF; i++) if ($i !~ /^(-?[0-9]+(\.[0-9]+)?)?$/) { print "no number: " $i; bad = 1 } }
        END { if (NR - 1 != rows) print NR - 1 " rows"; exit bad || NR - 1 != rows }' >"$work/judged" ||
        complain "$*: $(cat "$work/judged")"
}

busy=scene,launched,interactions,boundary_events,lanes_in_passes,lanes_at_planes,ns
expect_table $busy 2 7 bench_busy samples/mcml_sample.mci samples/wedge.mci
for kind in cone mesh; do
    expect_table scene,queries,ns,classify,intervals,search,reflect,cross 1 3 bench_curved samples/shapes/hihill.mci $kind
done
expect_table scene,steps,asked,met 2 4 bench_asked samples/shapes/hihill.mci samples/shapes/hinoise.mci
expect_table part,share,ns 4 3 bench_queries samples/shapes/hihill.mci
expect_table part,share,ns 4 3 bench_queries samples/shapes/hihill.mci --mesh
expect_table stage,ns_alone,ns_saved_when_left_out 11 2 bench_stages

sed 's/^40 50 1 /1 1 1 /' samples/mcml_sample.mci >"$work/one-bin.mci"
means=quantity,first,last,mean,mean_error,reference,reference_error,deviation,packets,independent,reported,within_1,within_2
expect_table $means 9 4 bench_unbiased "$work/one-bin.mci" 20 1000 1
# A profile of one bin holds its total.
awk -F, '{ mean[$1] = $4 } END { exit !(mean["A"] == mean["A_z"] && mean["Rd"] == mean["Rd_r"] && mean["Tt"] == mean["Tt_r"]) }' "$work/out" ||
    complain "bench_unbiased: profiles are not their totals: $(cat "$work/out")"

for bench in "bench_busy" "bench_queries" "bench_curved" "bench_asked"; do
    code=0
    "$build/$bench" "$work/none.mci" mesh >"$work/out" 2>"$work/err" || code=$?
    test $code -eq 2 || complain "$bench none.mci: exit $code, not 2"
    test "$(cat "$work/err")" = "$bench: $work/none.mci: cannot be read: No such file or directory (expected a file)" ||
        complain "$bench none.mci: $(cat "$work/err")"
done
finish
