#!/bin/sh
# Flies every sample with 2e4 photons and another seed than in the table of samples/manual/recipes/samples.md. No packet may
# be lost, and the weight must balance. Totals must agree with the table within 5 standard errors, and so must the table with
# the independent results beside it.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
table=samples/manual/recipes/samples.md

# Prints "name value error" for the totals of one JSON line; names: Rsp Rd A Tt.
json_value() { # KEY OUTPUT
    sed -n "/\/$2\"/s/.*\"$1\":\([^,}]*\).*/\1/p" "$work/json"
}

# Expects agreement within 5 sigma of both errors; half of the last digit in the table is allowed on top.
agree() { # WHAT VALUE ERROR EXPECTED ERROR
    awk -v a="$2" -v s="$3" -v b="$4" -v t="$5" 'BEGIN {
        exit !((a - b) ^ 2 <= (5 * sqrt(s * s + t * t) + 1e-5) ^ 2)
    }' || complain "$1: $2 +- $3, the table says $4 +- $5"
}

compare_row() { # SAMPLE OUTPUT RSP ERR RD ERR A ERR TT ERR RD* ERR TT* ERR ("-" and nothing where there is none)
    sample=$1 output=$2
    shift 2
    test "$(json_value lost "$output")" = 0 || complain "$sample: packets were lost"
    test "$(json_value trapped "$output")" = 0 || complain "$sample: packets were trapped"
    awk -v r="$(json_value residue "$output")" 'BEGIN { exit !(r == 0) }' || complain "$sample: the weight does not balance"
    Rd="$3 $4" Tt="$7 $8" independent_Rd="${9:-} ${10:-}" independent_Tt="${11:-} ${12:-}"
    for total in Rsp Rd A Tt; do
        agree "$output $total" "$(json_value $total "$output")" "$(json_value ${total}_se "$output")" "$1" "$2"
        shift 2
    done
    test "$independent_Tt" = " " && return
    agree "table, $output Rd*" $Rd $independent_Rd
    agree "table, $output Tt*" $Tt $independent_Tt
}

rows=0
for sample in samples/*.mci samples/shapes/*.mci; do
    name=${sample#samples/}
    expect_code 0 "$sample" --photons 2e4 --seed 2 --json -o "$work"
    cp "$work/out" "$work/json"
    grep -F "| \`$name\` |" $table >"$work/rows" || complain "$sample is not in the table"
    while read -r row; do
        # Columns 2 (sample), 3 (output), 5 to 10 (totals), without the signs between them.
        set -- $(printf '%s\n' "$row" | awk -F'|' '{ gsub(/[`±]|^-$| - /, " "); print $2, $3, $5, $6, $7, $8, $9, $10 }')
        compare_row "$@"
        rows=$((rows + 1))
    done <"$work/rows"
done
test "$rows" -eq "$(grep -c '^| `.*\.mci` |' $table)" || complain "the table has rows without a sample"
finish
