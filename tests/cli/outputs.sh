#!/bin/sh
# Tests that outputs which would destroy a file are refused before a packet flies, and that two processes do not write the
# same file.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

# --classic ends the .mco after the sections of MCML and changes nothing else in them; --resume knows the file.
mkdir "$work/classic" "$work/ours"
expect_code 0 samples/two_runs.mci --photons 500 --quiet -o "$work/ours"
expect_code 0 samples/two_runs.mci --photons 500 --quiet --classic -o "$work/classic"
for run in flat hill; do
    sed '/^# clustermcml/,$d; s/   Last line: # end//; /^# User time/s/:.*Identity/Identity/' "$work/ours/two_runs_$run.mco" >"$work/1"
    sed '/^# User time/s/:.*Identity/Identity/' "$work/classic/two_runs_$run.mco" >"$work/2"
    diff "$work/1" "$work/2" >"$work/differ"
    test "$(grep -c '^[<>] .' "$work/differ")" -eq 0 && ! grep -q lattice "$work/2" || complain "--classic: $(cat "$work/differ")"
done
expect_code 0 samples/two_runs.mci --photons 500 --classic --resume -o "$work/classic"
test "$(grep -c 'finished before' "$work/out")" -eq 2 || complain "--classic --resume: $(cat "$work/out")"
rm -r "$work"/*
cd "$work" || exit 1

scene() { # OUTPUT [LINES]: a run of 1000 packets; lines stand where map, beam and m stand
    printf '1.0\n1\n%s A\n1000\n0.1 0.1\n2 2 1 # nz, nr, na\n%s1\n1.0\n%s1.4 1 10 0.5 1\n1.0\n' "$1" "${2-}" "${3-}"
}

refused() { # CODE MESSAGE ARGUMENTS...: as expect_error; all files stay as they are
    before=$(cat ./* 2>/dev/null | cksum)
    expect_error "$@"
    rm -f out err
    test "$(cat ./* 2>/dev/null | cksum)" = "$before" || complain "$2: something was written"
}

cat >wedge.obj <<'E2'
v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
v 0 0 0.1
f 1 2 5
f 2 3 5
f 3 4 5
f 4 1 5
E2

# Outputs with the name of an input are refused.
scene a.mco >a.mco
refused 2 'a.mco:3: output name = a.mco (expected another one: it would overwrite the input a.mco)' a.mco
refused 2 'run: --output ./a.mco would overwrite its input a.mco (expected another name)' a.mco --output ./a.mco
for name in a.txt fl.mci; do
    refused 2 "--output $name (expected a name that ends in .mco or .h5, or has no ending)" a.mco --output $name
done
scene ./wedge.obj '' 'm "wedge.obj"
' >b.mci
refused 2 'b.mci:3: output name = ./wedge.obj (expected another one: it would overwrite the input wedge.obj)' b.mci
ln -s b.mci link.mco
scene link.mco >c.mci
cp c.mci b.mci
refused 2 'b.mci:3: output name = link.mco (expected another one: it would overwrite the input b.mci)' b.mci
rm link.mco

# Two runs of a file must not have the same output.
(scene a.mco | sed 's/^1$/2/;q'; printf '2\n'; scene a.mco | sed 1,2d; scene ./a.mco | sed 1,2d) >two.mci
refused 2 "two.mci:11: output name = ./a.mco (expected another one: run 1, a.mco, writes a.mco, too)" two.mci
(printf '1.0\n2\n'; scene a.map.vti | sed 1,2d; scene a.mco 'map 2 2 0.1 0.1
' | sed 1,2d) >two.mci
refused 2 "two.mci:11: output name = a.mco (expected another one: run 1, a.map.vti, writes a.map.vti, too)" two.mci

# Output names must not have endings that the program uses itself.
for ending in checkpoint checkpoint.old lock tmp mci; do
    scene a.mco.$ending >c.mci
    refused 2 "c.mci:3: output name = a.mco.$ending (expected no ending .mci, .checkpoint, .checkpoint.old, .lock or .tmp)" c.mci
done

# A name of a file beside the output that is too long is found before the flight, not after.
long=$(printf '%0246d' 0)
scene $long.mco 'map 2 2 0.1 0.1 volume
' >c.mci
refused 5 "$PWD/$long.volume.vti: cannot be written (File name too long)" c.mci

# Outputs that are no regular files are refused.
mkdir folder && scene folder >c.mci
refused 5 'folder: cannot be written (a directory)' c.mci
mkdir d.map.vti && scene d.h5 'map 2 2 0.1 0.1
' | sed 's/^d.h5 A/d.h5 B/' >c.mci
refused 2 "$PWD/d.map.vti: cannot be written (a directory; expected a file, or none)" c.mci
test ! -e d.h5 || complain "flown before the directory was met"
rmdir d.map.vti
mkfifo pipe && scene pipe >c.mci
rm a.mco b.mci two.mci wedge.obj
expect_error 5 'pipe: cannot be written (no regular file)' c.mci
rm pipe
# /dev/null and /dev/stdout are written to; unit.atomic_file tests that no file is put in their place.

# An output that is a link: its target is written, the link stays.
ln -s target.mco link.mco && echo old >target.mco
scene link.mco >c.mci
expect_code 0 c.mci --quiet
test -L link.mco && grep -q '^RAT' target.mco || complain "the link's target was not written"

# A link that another user has made is not followed, and a link is no lock.
if test "$(id -u)" -eq 0; then
    ln -s target.mco others.mco && chown -h 65534 others.mco
    scene others.mco >c.mci
    refused 5 'others.mco: cannot be written (a link of another user)' c.mci
    ln -s target.mco d.map.vti && chown -h 65534 d.map.vti
    scene d.mco 'map 2 2 0.1 0.1
' >c.mci
    refused 5 'd.map.vti: cannot be written (a link of another user)' c.mci
    rm others.mco d.map.vti
else
    echo "no links of another user: only root can make them"
fi
: >empty && ln -s empty d.lock
scene d.mco >c.mci
refused 5 "$PWD/d.lock: Too many levels of symbolic links" c.mci
test -e empty || complain "a lock's link: its target was removed"
rm d.lock empty

# A replaced file keeps its mode, whatever the umask.
scene mode.mco >c.mci
: >mode.mco
for mode in 600 664; do
    chmod $mode mode.mco
    expect_code 0 c.mci --quiet
    test -s mode.mco && test "$(stat -c %a mode.mco)" = $mode || complain "mode $mode: now $(stat -c %a mode.mco)"
done

# A name that leads out of -o is allowed and noted.
scene ../elsewhere.mco >c.mci
expect_code 0 c.mci --quiet -o folder
grep -q "note: $PWD/elsewhere.mco is not below -o folder" err || complain "no note: $(cat err)"

# Plots follow the rules of results.
scene r.svg >c.mci
expect_code 0 c.mci --quiet
refused 2 'plot: -o ./r.svg would overwrite its input r.svg' plot r.svg -o ./r.svg
refused 2 'compare: -o r.svg would overwrite its input r.svg' compare r.svg r.svg -o r.svg

scene r.svg >c.mci && sed -i 's/^2 2 1/2 4 1/' c.mci
expect_code 0 c.mci --quiet

# A file that a killed command left is removed, and no lock stays.
scene hill.mco '' 'b 2 0.1 0.1 0 1
' >hill.mci
for call in 'crosscheck hill.mci --photons 100 --dump p.svg' 'mesh hill.mci -o .'; do
    for name in p.svg hill.mco.boundary0.obj; do : >$name.123-0.tmp; done
    "$program" $call >out 2>&1 || complain "$call: $(cat out)"
    case $call in mesh*) name=hill.mco.boundary0.obj ;; *) name=p.svg ;; esac
    test -s $name && test ! -e $name.123-0.tmp && test ! -e $name.lock || complain "$call: left $(ls)"
done
rm -f p.svg* hill.*

# Two processes write one output: the second is refused in one line, the first completes.
scene long.mco >c.mci
"$program" c.mci --photons 3e6 --threads 1 --quiet &
first=$!
until test -e long.lock || ! kill -0 $first 2>/dev/null; do sleep 0.02; done
expect_error 5 "$PWD/long.lock: locked by another process, which writes the same files (expected another name or folder, or that process to end first)" c.mci
wait $first || complain "the first writer failed"
test "$(grep -c '^RAT' long.mco)" -eq 1 || complain "the first writer's result is not complete"
test ! -e long.lock || complain "the lock is left"

# Files that killed processes left are removed; files of others stay.
: >long.mco.123-0.tmp
: >long.mco.checkpoint.9-12.tmp
: >other.mco.1-0.tmp
expect_code 0 c.mci --quiet
test "$(echo ./*.tmp)" = ./other.mco.1-0.tmp || complain "temporary files: $(echo ./*.tmp)"
rm other.mco.1-0.tmp

# A lock that a killed process left does not block.
: >long.lock
expect_code 0 c.mci --quiet
echo precious >long.lock
expect_error 5 "$PWD/long.lock: is no lock of this program (expected an empty file or none; move this file away)" c.mci
rm long.lock

# Many rounds of two writers: the file is always one of the two results, whole.
scene race.mco >c.mci
result() { grep -v '^# User time' race.mco | grep -v '^# engine' | cksum; }
expect_code 0 c.mci --quiet --seed 1 && one=$(result)
expect_code 0 c.mci --quiet --seed 2 && other=$(result)
test "$one" != "$other" || complain "the seed has no effect"
for round in $(seq "${ROUNDS:-10}"); do
    "$program" c.mci --quiet --seed 1 2>/dev/null & first=$!
    "$program" c.mci --quiet --seed 2 2>/dev/null & second=$!
    done=0
    wait $first && done=1
    wait $second && done=1
    test $done -eq 1 || complain "round $round: neither wrote"
    found=$(result)
    test "$found" = "$one" || test "$found" = "$other" || complain "round $round: neither's result"
done
ls ./*.tmp ./*.lock 2>/dev/null && complain "something is left"

finish
