#!/bin/sh
# Tests that signals, even two in a row, stop a run in a way that it can be resumed. --checkpoint off leaves signals alone.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
scene=samples/thick.mci

# Starts a run and waits until it flies.
begin() { # LINE ARGUMENTS...: LINE is the last of its announcement
    line=$1
    shift
    rm -f "$work/out"
    "$program" "$@" --threads 1 -o "$work" >"$work/out" 2>"$work/err" &
    run=$!
    until grep -qs "^$line" "$work/out" || ! kill -0 $run; do sleep 0.02; done
}
long="$scene --photons 1e8"

for signal in TERM HUP USR1 USR2 XCPU; do
    rm -f "$work"/thick.mco*
    begin "  boundary 1" $long
    kill -$signal $run
    code=0
    wait $run || code=$?
    test $code -eq 75 || complain "SIG$signal: exit $code, not 75: $(cat "$work/err")"
    grep -q "^clustermcml: thick.mco: stopped with [0-9]* of 100000000 packets to fly; --resume continues from $work/thick.mco.checkpoint$" \
        "$work/err" || complain "SIG$signal: $(cat "$work/err")"
    test "$(echo "$work"/thick*)" = "$work/thick.mco.checkpoint" || complain "SIG$signal: $(ls "$work")"
done
expect_error 2 "--no-clobber: $work/thick.mco.checkpoint is that of a stopped run (expected --resume, which continues it, or no such file)" \
    $scene --photons 1000 --no-clobber --quiet -o "$work"
# A shell's background jobs ignore SIGINT, and an ignored signal stays ignored, so another parent starts the program.
python3 - "$program" "$work" <<'E2' || complain "SIGINT"
import signal, subprocess, sys, time
program, work = sys.argv[1:]
run = subprocess.Popen([program, "samples/thick.mci", "--photons", "1e8", "-o", work], stdout=subprocess.PIPE,
                       stderr=subprocess.DEVNULL, text=True)
while not run.stdout.readline().startswith("  boundary 1"):
    pass
run.send_signal(signal.SIGINT)
run.stdout.read()
sys.exit(run.wait() != 75)
E2

# Before the flight, --tolerance computes which surfaces may be planes. A checkpoint would have no content yet, so a signal
# ends the program at once.
"$program" samples/shapes/hihill.mci --tolerance 1e-5 --photons 1e8 --threads 1 -o "$work" >"$work/out" 2>"$work/err" &
run=$!
until test -e "$work/hihill.lock" || ! kill -0 $run; do sleep 0.02; done
kill -TERM $run
code=0
wait $run || code=$?
test $code -eq 75 || complain "before the flight: exit $code, not 75: $(cat "$work/err")"
test "$(cat "$work/err")" = 'clustermcml: stopped before the flight: nothing was written' || complain "before the flight: $(cat "$work/err")"
test "$(ls "$work" | grep -c '^hihill\.[^l]')" = 0 || complain "before the flight: $(ls "$work")"
rm -f "$work"/hihill*

# A launcher sends a signal to the process and to its group: both arrive before the program can look at the first. (unit.stop
# tests a later one.)
rm -f "$work"/thick.mco*
begin "  boundary 1" $long --engine reference
kill -STOP $run
kill -TERM $run
kill -USR1 $run
kill -CONT $run
code=0
wait $run || code=$?
test $code -eq 75 || complain "two signals: exit $code, not 75: $(cat "$work/err")"
test -e "$work/thick.mco.checkpoint" || complain "two signals: there is no checkpoint"

# A packet has 5e6 boundary events, totally reflected below the flank of a cone. A signal does not wait for its end, and its
# scores so far are discarded.
printf '1.0\n1\nlong.mco A\n1\nbeam pencil at=0.05,0\n0.01 0.01\n1 1 1\n1\n1\nb 2 0.17320508075688773 0.1 0 0\n2 2e-7 0 0 0.5\n1\n' \
    >"$work/long.mci"
expect_code 0 "$work/long.mci" --quiet -o "$work"
mv "$work/long.mco" "$work/expected.mco"
rm -f "$work/long.h5"
begin "  boundary 1" "$work/long.mci"
kill -TERM $run
code=0
wait $run || code=$?
test $code -eq 75 || complain "a long-lived packet: exit $code"
test "$(cat "$work/err")" = "clustermcml: long.mco: stopped; some packets would not end, so all that flew since the last \
checkpoint is lost; --resume continues from $work/long.mco.checkpoint, or begins anew without that file" ||
    complain "a long-lived packet: $(cat "$work/err")"
test ! -e "$work/long.mco" || complain "a long-lived packet: a result of a stopped run"
expect_code 0 "$work/long.mci" --resume --quiet -o "$work"
sed '/^# User time/d' "$work/long.mco" >"$work/a"
sed '/^# User time/d' "$work/expected.mco" >"$work/b"
cmp -s "$work/a" "$work/b" || complain "a long-lived packet: other bits after a stop"
rm -f "$work"/long.mco*

rm "$work/thick.mco.checkpoint"
begin "  boundary 1" $long --checkpoint off
kill -TERM $run
code=0
wait $run || code=$?
test $code -eq 143 || complain "--checkpoint off: exit $code"
test ! -e "$work/thick.mco.checkpoint" || complain "--checkpoint off: there is a checkpoint"

expect_error 2 "--checkpoint 0 (expected seconds above 0, up to 1e9)" $scene --checkpoint 0
expect_error 2 "--target-error 1 (expected a relative error between 0 and 1)" $scene --target-error 1
expect_error 2 "--patience x (expected seconds above 0, up to 1e9)" $scene --patience x

# Several runs: the first stays finished while the second is stopped twice. With --resume, small checkpoints say at the end
# that all runs are finished. With --resume once more nothing flies, and --json lists all runs.
sed -e 's/^1  *# number of runs/2/' -e 's/^thick.mco/first.mco/' -e 's/^200000 /1000 /' $scene >"$work/two.mci"
sed -e '1,/# number of runs/d' -e 's/^200000 /400000 /' $scene >>"$work/two.mci"
expect_code 0 "$work/two.mci" --checkpoint off --quiet -o "$work"
mkdir "$work/expected"
mv "$work/first.mco" "$work/thick.mco" "$work/expected/"
for resume in "" --resume; do
    begin "thick.mco: 400000" "$work/two.mci" $resume
    kill -TERM $run
    code=0
    wait $run || code=$?
    test $code -eq 75 || complain "the second run: exit $code: $(cat "$work/err")"
    touch -d 2001-01-01 "$work/first.mco"
done
expect_code 0 "$work/two.mci" --resume -o "$work"
grep -q '^  finished before: nothing was written, its results stand$' "$work/out" || complain "the first run flew again"
test "$(date -r "$work/first.mco" +%Y)" = 2001 || complain "the first result was written again"
for file in first.mco thick.mco; do
    sed '/^# User time/d' "$work/$file" >"$work/a"
    sed '/^# User time/d' "$work/expected/$file" >"$work/b"
    cmp -s "$work/a" "$work/b" || complain "$file: other bits after stops"
done
test "$(cd "$work" && echo *.checkpoint*)" = "first.mco.checkpoint thick.mco.checkpoint" || complain "checkpoints: $(ls "$work")"
test "$(cat "$work"/*.checkpoint | wc -c)" -le 16384 || complain "large checkpoints: $(ls -l "$work")"
touch -d 2001-01-01 "$work/thick.mco"
expect_code 0 "$work/two.mci" --resume --json -o "$work"
test "$(grep -c '^{"scene":.*"photons":1000,.*}$' "$work/out")" -eq 1 || complain "--json, the first run: $(cat "$work/out")"
test "$(grep -c '^{"scene":.*"photons":400000,.*}$' "$work/out")" -eq 1 || complain "--json, the second run: $(cat "$work/out")"
test "$(wc -l <"$work/out")" -eq 2 || complain "--json: $(cat "$work/out")"
test "$(date -r "$work/thick.mco" +%Y)" = 2001 || complain "a finished file flew again"
expect_error 2 "$work/first.mco.checkpoint: the checkpoint is of another run: 'seed 1' there, 'seed 2' here (expected that run; without --resume or --more this one begins anew)" \
    "$work/two.mci" --resume --seed 2 --json -o "$work"

# Without a checkpoint, a result that says to be of this run counts as finished; but not for --json, whose numbers have more
# digits.
names=again.mco
test "$("$program" --version | grep -c 'HDF5 yes')" -eq 0 || names="again.mco again.h5"
for name in $names; do
    "$program" $scene --photons 1000 --quiet -o "$work" --output $name || complain "$name"
    touch -d 2001-01-01 "$work/$name"
    expect_code 0 $scene --photons 1000 --resume -o "$work" --output $name
    grep -q '^  finished before: nothing was written, its results stand$' "$work/out" && test ! -s "$work/err" || complain "$name flew again: $(cat "$work/err")"
    test "$(date -r "$work/$name" +%Y)" = 2001 || complain "$name was written again"
    for other in "--photons 1000 --json" "--photons 1000 --roulette mcml" "--photons 1001"; do
        touch -d 2001-01-01 "$work/$name"
        expect_code 0 $scene $other --resume -o "$work" --output $name
        grep -q "finds no $work/$name.checkpoint: the run begins anew" "$work/err" || complain "$name, $other: $(cat "$work/err")"
        test "$(date -r "$work/$name" +%Y)" != 2001 || complain "$name, $other: nothing was flown"
        rm "$work/$name.checkpoint"
    done
done
# A result whose end is missing does not count as finished.
"$program" $scene --photons 1000 --quiet -o "$work" --output again.mco || complain "again"
head -n -1 "$work/again.mco" >"$work/cut" && mv "$work/cut" "$work/again.mco"
expect_code 0 $scene --photons 1000 --resume -o "$work" --output again.mco
grep -q "finds no $work/again.mco.checkpoint: the run begins anew, as $work/again.mco is no whole result; what is there" "$work/err" || complain "cut off: $(cat "$work/err")"

# Files beside the result say, too, of which run they are.
"$program" samples/skinmap.mci --photons 100 --quiet -o "$work" || complain "skinmap"
expect_code 0 samples/skinmap.mci --photons 100 --resume -o "$work"
grep -q '^  finished before: nothing was written, its results stand$' "$work/out" && test ! -s "$work/err" || complain "several files: $(cat "$work/err")"
finish
