#!/bin/sh
# Tests --aim on several ranks: expected values have the bytes of one rank, and so have flights with windows for all light
# below or for a detector. This holds if expected values decide how many photons fly, and if a stopped or killed run continues
# on other ranks.
# SPDX-License-Identifier: MIT
. tests/lib/cluster.sh
printf '1.0\n1\nx.mco A\n1000\ndetector disk 0.05 at=0.3,0 name=near\n0.01 0.01\n20 20 3\n%s\n' \
    "2\n1.0\nb 3 0.05 0.1 -0.05 0.2 0 0.1\n1.4 1 60 0.8 0.3\n1.5 2 20 0.5 0.4\n1.0" | sed 's/\\n/\n/g' >"$work/x.mci"
value() { # KEY FILE
    grep -o "\"$1\":[^,}]*" "$2" | sed 's/.*://;q'
}

for options in "--photons 20000 --aim Tt,Tt_r" "--photons 20000 --aim near" "--photons 64 --target-error 0.01 --aim Tt"; do
    # shellcheck disable=SC2086 # several options on purpose
    expect_code 0 "$work/x.mci" $options --threads 1 --json -o "$work"
    mv "$work/x.mco" "$work/expected"
    for shape in "2 1" "3 2"; do
        set -- $shape
        # shellcheck disable=SC2086
        ranks "$1" "$work/x.mci" $options --threads "$2" --quiet -o "$work"
        expect_bits "$options on $1 ranks x $2 threads" "$work/x.mco" "$work/expected"
    done
done
# The expected Tt is known to 1 %, the counted one is not.
awk -v Tt="$(value Tt_expected "$work/out")" -v e="$(value Tt_expected_se "$work/out")" -v counted="$(value Tt_se "$work/out")" \
    'BEGIN { exit !(e <= 0.01 * Tt && counted > 0.01 * Tt) }' || complain "--target-error: $(cat "$work/out")"

# A run is killed or stopped, and continued on two ranks.
expect_code 0 "$work/x.mci" --photons 1.5e5 --aim Tt,near --quiet -o "$work"
mv "$work/x.mco" "$work/expected"
for end in "KILL 137" "TERM 75"; do
    rm -f "$work"/x.mco*
    "$program" "$work/x.mci" --photons 1.5e5 --aim Tt,near --threads 1 --checkpoint 0.1 -o "$work" >"$work/out" 2>"$work/err" &
    run=$!
    until test -e "$work/x.mco.checkpoint" || ! kill -0 $run 2>/dev/null; do sleep 0.02; done
    kill -"${end% *}" $run
    code=0
    wait $run || code=$?
    test $code -eq "${end#* }" || complain "${end% *}: exit $code, $(cat "$work/err")"
    ranks 2 "$work/x.mci" --photons 1.5e5 --aim Tt,near --resume --quiet -o "$work"
    expect_bits "${end% *}, and continued" "$work/x.mco" "$work/expected"
done
expect_error 2 "$work/x.mco.checkpoint: the checkpoint is of another run: 'aim Tt,near' there, 'no aim' here (expected that run; without --resume or --more this one begins anew)" \
    "$work/x.mci" --photons 1.5e5 --resume --quiet -o "$work"
finish
