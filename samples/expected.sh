#!/bin/sh
# Measures the table of samples/manual/recipes/samples.md: expected.sh [PROGRAM], by default build/clustermcml. Every
# sample runs with its own number of photons and seed 1, and the table is rewritten in place. Beside the program's
# numbers stand those of tests/reference, which come from other programs.
# SPDX-License-Identifier: MIT
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(dirname "$here")
program=${1:-$root/build/clustermcml}
case $program in /*) ;; *) program=$PWD/$program ;; esac
reference=$root/tests/reference
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Prints Rd and Tt with their errors as the sum of a profile. Columns: bin, r, Rd_r, error, Tt_r, error. Without columns
# of errors, the error is at most that of 1e7 packets of weight 1.
sum_profile() { # FILE HAS_ERRORS
    awk -F, -v errors="$2" '
        /^[0-9]/ {
            if (!dr) dr = 2 * $2
            area = 6.283185307179586 * ($1 + 0.5) * dr * dr
            R += area * $3; T += area * (errors ? $5 : $4)
            if (errors) { r += (area * $4) ^ 2; t += (area * $6) ^ 2 }
        }
        END {
            if (!errors) { r = R * (1 - R) / 1e7; t = T * (1 - T) / 1e7 }
            printf "%.5f ± %.5f | %.5f ± %.5f\n", R, sqrt(r), T, sqrt(t)
        }' "$reference/profiles/$1"
}

# Prints Rd and Tt from adding-doubling, whose R includes the specular part.
adding_doubling() { # UR1 UT1 Rsp
    awk -v R="$1" -v T="$2" -v S="$3" 'BEGIN { printf "%.5f ± 0.00000 | %.5f ± 0.00000\n", R - S, T }'
}

independent() { # SAMPLE
    case $1 in
    mcml_sample.mci) adding_doubling $(awk -F, '/^S4 / { print $3, $4, $5 }' "$reference/layers.csv") ;;
    skin7.mci) adding_doubling $(awk -F, '/^S5 / { print $3, $4, $5 }' "$reference/layers.csv") ;;
    thick.mci) adding_doubling $(awk -F, '/S6a/ { r = ($1 - 1) / ($1 + 1); print $7, $8, r * r }' \
        "$reference/slabs.csv") ;;
    fig5.mci) sum_profile S1.csv 1 ;;
    fig6.mci) sum_profile S2.csv 1 ;;
    fig7.mci) sum_profile S3fig7.csv 0 ;;
    shapes/plane.mci | shapes/flat50.mci) sum_profile flat50.b.csv 0 ;;
    shapes/lohill.mci | shapes/hicrater.mci | shapes/lonoise.mci | shapes/hinoise.mci)
        sum_profile "$(basename "$1" .mci).reentry.csv" 0 ;;
    *) echo "- | -" ;;
    esac
}

row() { # SAMPLE OTHERS, one JSON line on standard input
    awk -v sample="$1" -v others="$2" '
        function value(key) {
            return match($0, "\"" key "\":[^,}]*") ? substr($0, RSTART + length(key) + 3, RLENGTH - length(key) - 3) : "?"
        }
        function measured(key) { return sprintf("%.5f ± %.5f", value(key), value(key "_se")) }
        {
            sub(/"bodies":\[[^]]*\]/, "") # which have an A of their own
            output = value("output"); gsub(/"|.*\//, "", output)
            printf "| `%s` | `%s` | %.0e | %s | %s | %s | %s | %s | %.0f |\n", sample, output,
                value("photons"), measured("Rsp"), measured("Rd"), measured("A"), measured("Tt"), others,
                value("seconds") < 1 ? 1 : value("seconds")
        }'
}

cd "$here"
page=manual/recipes/samples.md
status=0
: >"$work/table"
for sample in *.mci shapes/*.mci; do
    if "$program" run "$sample" --json --output-dir "$work" >"$work/json"; then
        row "$sample" "$(independent "$sample")" <"$work/json" | tee -a "$work/table" >&2
    else
        echo "$sample failed and keeps its old row" >&2
        grep -F "| \`$sample\` |" "$page" >>"$work/table" || true
        status=1
    fi
done
awk -v table="$work/table" '
    /^\| `.*\.mci` \|/ { next }
    { print }
    /^\| sample \|/ { totals = 1 }
    /^\|---/ && totals { while ((getline line < table) > 0) print line }' "$page" >"$work/page"
cat "$work/page" >"$page"
exit $status
