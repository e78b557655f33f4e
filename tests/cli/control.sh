#!/bin/sh
# --control flat: words, files, refusals, and a run that is stopped while its twin flies. unit.control and stat.control
# judge the numbers.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
hill=samples/shapes/hihill.mci

value() { # KEY FILE: of the JSON line, the first of that name
    grep -o "\"$1\":[^],}]*" "$2" | sed 's/.*://;q'
}

same() { # WHAT A B: two .mco files, but for their times
    sed '/^# User time/d' "$2" >"$work/a"
    sed '/^# User time/d' "$3" >"$work/b"
    cmp -s "$work/a" "$work/b" || complain "$1: other bits"
}

expect_code 0 $hill --photons 2e4 --quiet -o "$work"
mv "$work/hihill.mco" "$work/plain"
expect_code 0 $hill --photons 2e4 --control flat -o "$work"
for key in Rsp Rd A Tt; do
    grep -Eq "^  $key +0\.[0-9]{6} \+- 0\.[0-9]{6}   control 0\.[0-9]{7} \+- 0\.[0-9]{7}$" "$work/out" ||
        complain "summary of $key: $(cat "$work/out")"
done
grep -q '^  control: the flat twin took ' "$work/out" || complain "no word of the twin's time: $(cat "$work/out")"
test "$(ls "$work")" = "$(printf 'err\nhihill.mco\nout\nplain')" || complain "files: $(ls "$work")"

# the file has one section more, and nothing else
mv "$work/hihill.mco" "$work/controlled"
sed '/^control #/,/^$/d' "$work/controlled" >"$work/head"
same "a run with a twin" "$work/head" "$work/plain"
sed -e '1,/^control #/d' -e '/^$/,$d' "$work/controlled" >"$work/section"
test "$(wc -l <"$work/section")" -eq 8 || complain "section: $(cat "$work/section")"
expect_code 0 compare "$work/controlled" "$work/plain"

# the same numbers on any number of threads, and in JSON
expect_code 0 $hill --photons 2e4 --control flat --threads 3 --chunk 100 --json -o "$work"
same "3 threads" "$work/hihill.mco" "$work/controlled"
for key in Rsp Rd A Tt; do value ${key}_control "$work/out"; done >"$work/json"
for key in Rsp Rd A Tt; do value ${key}_control_se "$work/out"; done >>"$work/json"
paste "$work/section" "$work/json" | awk '{ d = $1 - $2; bad += d * d > 1e-12 * $2 * $2 } END { exit NR != 8 || bad }' ||
    complain "JSON: $(paste "$work/section" "$work/json")"
awk -v a="$(value Tt_control_se "$work/out")" -v b="$(value Tt_se "$work/out")" 'BEGIN { exit !(a > 0 && a < 0.8 * b) }' ||
    complain "no gain: $(cat "$work/out")"
test "$(value control_cpu_s "$work/out")" != null || complain "no time of the twin: $(cat "$work/out")"
expect_code 0 $hill --photons 2e4 --json -o "$work"
test "$(value Rd_control "$work/out")" = null || complain "control without a twin: $(cat "$work/out")"

# every engine; a plane top above a hill, whose specular part is split off in the twin, too
expect_code 0 $hill --photons 2e3 --control flat --engine reference --json -o "$work"
test "$(value Rd_control "$work/out")" != null || complain "reference: $(cat "$work/out")"
for glass in '1.5 0 0 0 0.1' '1.5 1 1 0 0.1'; do
    printf '1.0\n1\nx.mco A\n20000\n0.1 0.1\n2 2 1\n2\n1.0\n%s\nb 2 0.05 0.3 0 0.1\n1.4 1 10 0.5 0.4\n1.0\n' "$glass" >"$work/x.mci"
    expect_code 0 "$work/x.mci" --control flat --json -o "$work"
    awk -v a="$(value Rsp "$work/out")" -v b="$(value Rsp_control "$work/out")" \
        -v t="$(value Tt "$work/out")" -v u="$(value Tt_control "$work/out")" -v e="$(value Tt_se "$work/out")" \
        'BEGIN { exit !((a - b) ^ 2 < 1e-18 && a > 0.039 && a < 0.041 && (t - u) ^ 2 < (5 * e) ^ 2) }' ||
        complain "$glass: $(cat "$work/out")"
done

# nothing to control, and what is refused
expect_code 0 samples/mcml_sample.mci --photons 1e3 --control flat --json -o "$work"
test "$(cat "$work/err")" = "clustermcml: note: mcml_sample.mco: --control flat has nothing to do where all boundaries are planes" ||
    complain "planes: $(cat "$work/err")"
test "$(value Rd_control "$work/out")" = null || complain "planes: $(cat "$work/out")"
printf '1.0\n1\nx.mco A\n20000\n0.1 0.1\n2 2 1\n1\n1.0\n1.4 0 0 0 0.5\ni sphere 0 0 0.2 0.1 1.4 1 10 0.8\n1.0\n' >"$work/x.mci"
expect_error 2 "$work/x.mci:10: layer 1 = clear, with bodies (expected no --control flat: its twin counts other light as specular)" \
    "$work/x.mci" --control flat --quiet -o "$work"
expect_error 2 "--control round (expected flat)" $hill --control round
expect_error 2 "--control flat (expected no --ignore-heightfields beside it)" $hill --control flat --ignore-heightfields

# Stopped while the twin flies: the scene's result waits in its checkpoint, which is written when it is complete. How many
# photons a twin needs until a signal meets it is tried.
rm -f "$work"/hihill*
photons=1000000
code=0
while test $code -eq 0 && test $photons -lt 10000000000; do
    rm -f "$work"/hihill*
    "$program" $hill --photons $photons --control flat --ignore-absorption --checkpoint 1e6 --threads 1 --quiet -o "$work" 2>"$work/err" &
    run=$!
    until test -e "$work/hihill.mco.checkpoint" || ! kill -0 $run 2>"$work/gone"; do sleep 0.01; done
    kill -TERM $run 2>"$work/gone"
    code=0
    wait $run || code=$?
    test $code -eq 75 || photons=$((4 * photons))
done
test $code -eq 75 || complain "stopped twin: exit $code: $(cat "$work/err")"
grep -q "^clustermcml: hihill.mco: stopped with [0-9]* of $photons packets to fly; --resume continues from $work/hihill.mco.control.checkpoint$" \
    "$work/err" || complain "stopped twin: $(cat "$work/err")"
expect_code 2 $hill --photons $photons --ignore-absorption --resume -o "$work" --quiet
grep -q 'of another run' "$work/err" || complain "resumed without --control: $(cat "$work/err")"
expect_code 0 $hill --photons $photons --control flat --ignore-absorption --resume --threads 2 --quiet -o "$work"
mv "$work/hihill.mco" "$work/resumed"
test "$(echo "$work"/hihill*)" = "$work/hihill.mco.checkpoint" || complain "left after the resume: $(ls "$work")"
expect_code 0 $hill --photons $photons --control flat --ignore-absorption --checkpoint off --quiet -o "$work"
same "resumed while the twin flew" "$work/resumed" "$work/hihill.mco"
finish
