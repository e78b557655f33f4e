#!/bin/sh
# Tests that --target-error stops at the first round (N, 2N, 4N ... photons) that is good enough, for any ranks and threads.
# SPDX-License-Identifier: MIT
. tests/lib/cluster.sh

value() { # KEY FILE: the first of that name
    grep -o "\"$1\":[^,}]*" "$2" | sed 's/.*://;q'
}

# Returns 0 if every total above 1e-3 has a relative error of at most E.
good_enough() { # E FILE
    awk -v e="$1" -v Rd="$(value Rd "$2")" -v A="$(value A "$2")" -v Tt="$(value Tt "$2")" \
        -v sRd="$(value Rd_se "$2")" -v sA="$(value A_se "$2")" -v sTt="$(value Tt_se "$2")" \
        'BEGIN { exit !((Rd < 1e-3 || sRd <= e * Rd) && (A < 1e-3 || sA <= e * A) && (Tt < 1e-3 || sTt <= e * Tt)) }'
}

# 100 photons become 128, so that batches have equal length.
expect_code 0 samples/mcml_sample.mci --photons 100 --target-error 0.02 --json -o "$work"
cp "$work/out" "$work/last"
photons=$(value photons "$work/last")
good_enough 0.02 "$work/last" || complain "stopped too early: $(cat "$work/last")"
echo "0.02 after $photons photons"
mv "$work/mcml_sample.mco" "$work/expected"
for n in 128 256 512 1024 2048 4096 8192 16384 32768 65536; do
    test "$n" -lt "$photons" || break
    expect_code 0 samples/mcml_sample.mci --photons $n --json -o "$work"
    good_enough 0.02 "$work/out" && complain "$n photons were good enough"
done
test "$n" -eq "$photons" || complain "$photons photons are no round"

# Totals are those of a plain run of the same number of photons, but the batches differ.
expect_code 0 samples/mcml_sample.mci --photons "$photons" --json -o "$work"
for key in Rd A Tt Rd_se A_se Tt_se; do
    test "$(value $key "$work/out")" = "$(value $key "$work/last")" || complain "$key of a plain run differs"
done

for shape in "1 2" "2 1" "4 1"; do
    set -- $shape
    ranks "$1" samples/mcml_sample.mci --photons 100 --target-error 0.02 --threads "$2" --quiet -o "$work"
    expect_bits "$1 ranks x $2 threads" "$work/mcml_sample.mco" "$work/expected"
done
finish
