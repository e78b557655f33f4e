#!/bin/sh
# Tests --keep and --more: a result extended twice, by numbers of photons that are no multiple of anything, has the bytes of
# one run of all photons, maps and facets included. A stopped extension that is continued has them, too. Results that cannot
# be extended are refused.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
mkdir "$work/one" "$work/more" "$work/two"

# Compares the folders one and more: same files, same bytes, but for times and the command line (.h5).
compare() { # TEXT
    (cd "$work/one" && ls) >"$work/names"
    (cd "$work/more" && ls | grep -v checkpoint) | cmp -s - "$work/names" || complain "$1: $(ls "$work/more")"
    while read -r name; do
        case $name in *.h5) continue ;; esac
        sed '/^# User time/d' "$work/one/$name" >"$work/a"
        sed '/^# User time/d' "$work/more/$name" >"$work/b"
        cmp -s "$work/a" "$work/b" || complain "$1: $name has other bytes"
    done <"$work/names"
}

cat >"$work/voxels.mci" <<'EOF'
1.0
1
voxels.mco A
1000
0.02 0.02
5 5 3
fluence
map 5 4 0.02 0.02 volume top=-0.01
1
1
1.4 1 50 0.8 0.1
1
EOF
for scene in samples/skinmap.mci samples/two_runs.mci samples/pulse.mci "$work/voxels.mci"; do
    rm -f "$work"/one/* "$work"/more/*
    expect_code 0 $scene --photons 20001 --keep --threads 1 --quiet -o "$work/more"
    expect_code 0 $scene --more 7003 --threads 3 --quiet -o "$work/more"
    expect_code 0 $scene --more 1 --engine cpu --quiet -o "$work/more"
    expect_code 0 $scene --photons 27005 --quiet -o "$work/one"
    compare "$scene"
    expect_code 0 $scene --more 1 --resume --quiet -o "$work/more" # finished before
    compare "$scene, once more with --resume"
done

# An extension is stopped in the middle and continued; a second extension in its place is refused.
rm -f "$work"/one/* "$work"/more/*
more=$((${MORE:-400000}))
expect_code 0 samples/thick.mci --photons 1e4 --keep --quiet -o "$work/more"
"$program" samples/thick.mci --more $more --quiet -o "$work/more" --chunk 64 2>"$work/err" &
run=$!
# Waits until the extension has an unfinished checkpoint (byte 40).
until test "$(od -An -tu1 -j40 -N1 "$work/more/thick.mco.checkpoint")" -eq 0 || ! kill -0 $run 2>/dev/null; do sleep 0.02; done
kill -TERM $run
code=0
wait $run || code=$?
test $code -eq 75 || complain "the extension was not stopped: exit $code, $(cat "$work/err")"
checkpoint=$work/more/thick.mco.checkpoint
expect_error 2 "--more: $checkpoint is of a run that was stopped: --resume continues it" samples/thick.mci --more 5 --quiet -o "$work/more"
expect_code 0 samples/thick.mci --more $more --resume --quiet -o "$work/more"
expect_code 0 samples/thick.mci --photons $((more + 10000)) --quiet -o "$work/one"
compare "stopped"

expect_error 2 "$checkpoint: the checkpoint is of another run: 'seed 1' there, 'seed 2' here (expected that run; without --resume or --more this one begins anew)" \
    samples/thick.mci --more 5 --seed 2 --quiet -o "$work/more"
missing="(expected the checkpoint of a run that was flown with --keep)"
expect_error 2 "--more: $work/thick.mco.checkpoint is not there $missing" samples/thick.mci --more 5 --quiet -o "$work"
echo garbage >"$work/thick.mco.checkpoint"
expect_error 2 "--more: $work/thick.mco.checkpoint is damaged $missing" samples/thick.mci --more 5 --quiet -o "$work"
rm "$work/thick.mco.checkpoint"
expect_code 0 samples/thick.mci --photons 100 --resume --quiet -o "$work"
expect_error 2 "--more: $work/thick.mco.checkpoint has no tallies $missing" samples/thick.mci --more 5 --quiet -o "$work"
expect_error 2 "--more (expected no --photons beside it)" samples/thick.mci --more 5 --photons 10 -o "$work"
expect_error 2 "--more (expected no --target-error beside it)" samples/thick.mci --more 5 --target-error 0.1 -o "$work"
expect_error 2 "--keep (expected no --target-error beside it)" samples/thick.mci --keep --target-error 0.1 -o "$work"
expect_error 2 "--more 0 (expected a whole number from 1 to 281474976710656)" samples/thick.mci --more 0 -o "$work"

# --no-clobber lets an extension replace its own result, and no result of another run.
mkdir "$work/mine" "$work/theirs"
expect_code 0 samples/thick.mci --photons 100 --keep --quiet -o "$work/mine"
expect_code 0 samples/thick.mci --photons 100 --seed 2 --quiet -o "$work/theirs"
mv "$work/mine/thick.mco" "$work/own"
cp "$work/theirs/thick.mco" "$work/mine"
expect_error 2 "--no-clobber: $work/mine/thick.mco is of another run (expected that of the run that --more extends)" \
    samples/thick.mci --more 5 --no-clobber --quiet -o "$work/mine"
cmp -s "$work/mine/thick.mco" "$work/theirs/thick.mco" || complain "--more replaced another run's result"
mv "$work/own" "$work/mine/thick.mco"
expect_code 0 samples/thick.mci --more 5 --no-clobber --keep --quiet -o "$work/mine"
grep -q '^105 ' "$work/mine/thick.mco" || complain "--more --no-clobber did nothing"
expect_code 0 samples/thick.mci --more 5 --no-clobber --resume --keep --quiet -o "$work/mine"
cp "$work/theirs/thick.mco" "$work/mine"
expect_error 2 "--no-clobber: $work/mine/thick.mco exists, but $work/mine/thick.mco is of another run (expected all files of the run, or none of them)" \
    samples/thick.mci --more 5 --no-clobber --resume --quiet -o "$work/mine"

# --no-clobber also lets a stopped extension replace its own result.
rm "$work/mine"/*
expect_code 0 samples/thick.mci --photons 100 --keep --quiet -o "$work/mine"
cp "$work/mine/thick.mco" "$work/own"
"$program" samples/thick.mci --more 1e8 --no-clobber --threads 1 -o "$work/mine" >"$work/out" 2>"$work/err" &
run=$!
until grep -q 'boundary 1' "$work/out" || ! kill -0 $run; do sleep 0.02; done
kill -TERM $run
wait $run && complain "--more was not stopped"
cp "$work/theirs/thick.mco" "$work/mine"
expect_error 2 "--no-clobber: $work/mine/thick.mco is of another run (expected that of the run that --more extends)" \
    samples/thick.mci --more 1e8 --resume --no-clobber --quiet -o "$work/mine"
cmp -s "$work/mine/thick.mco" "$work/theirs/thick.mco" || complain "--more --resume replaced another run's result"
mv "$work/own" "$work/mine/thick.mco"
"$program" samples/thick.mci --more 1e8 --resume --no-clobber --threads 1 -o "$work/mine" >"$work/out" 2>"$work/err" &
run=$!
until grep -q 'boundary 1' "$work/out" || ! kill -0 $run; do sleep 0.02; done
kill -TERM $run
code=0
wait $run || code=$?
test $code -eq 75 || complain "--more --resume --no-clobber: $code: $(cat "$work/err")"

# A finished run whose result was removed is flown again.
cp "$work/thick.mco" "$work/expected"
rm "$work/thick.mco"
expect_code 0 samples/thick.mci --photons 100 --resume --quiet -o "$work"
grep -q "thick.mco.checkpoint is of a finished run, but its result thick.mco is gone: it begins anew" "$work/err" ||
    complain "no word of the lost result: $(cat "$work/err")"
sed '/^# User time/d' "$work/expected" >"$work/a"
sed '/^# User time/d' "$work/thick.mco" | cmp -s - "$work/a" || complain "a lost result has other bytes"

# A finished run with kept tallies writes its removed result again, and the tallies stay. Tallies of another run stay, too.
rm -f "$work/more"/*
for scene in samples/skinmap.mci samples/thick.mci; do
    name=$(basename $scene .mci)
    expect_code 0 $scene --photons 3000 --keep --quiet -o "$work/more"
    sed '/^# User time/d' "$work/more/$name.mco" >"$work/a"
    rm "$work/more/$name.mco"
    cp "$work/more/$name.mco.checkpoint" "$work/kept"
    expect_code 2 $scene --photons 3000 --seed 2 --resume --quiet -o "$work/more"
    cmp -s "$work/kept" "$work/more/$name.mco.checkpoint" || complain "$name: another run's checkpoint was touched"
    expect_code 0 $scene --photons 3000 --resume --json -o "$work/more"
    grep -q "its result $name.mco is gone: it is written again" "$work/err" || complain "no word of a lost result: $(cat "$work/err")"
    sed '/^# User time/d' "$work/more/$name.mco" | cmp -s - "$work/a" || complain "$name: a result that is written again has other bytes"
    expect_code 0 $scene --more 5 --quiet -o "$work/more"
done

# A finished run also writes again when any file beside the result is missing; every file has its former bytes.
cat >"$work/many.mci" <<'EOF'
1.0
1
many.mco A
200
0.02 0.02
5 5 3
fluence
map 5 4 0.02 0.02 volume top=-0.01
facets
detector map 4 4 0.1 0.1 name=seen
1
1
b 3  0.06 0.1  0.02 0.2  0 1
1.4 1 50 0.8 0.1
i sphere 0 0 0.05 0.01  1.4 1 50 0.8
1
EOF
"$program" --version | grep -q 'HDF5 yes' && sed -i '6a photons "many_saved" limit=50' "$work/many.mci"
mkdir "$work/many"
expect_code 0 "$work/many.mci" --keep --quiet -o "$work/many"
for path in "$work"/many/*; do
    name=$(basename "$path")
    case $name in many.mco | *.checkpoint) continue ;; esac
    mv "$path" "$work/taken"
    refused="--no-clobber: $work/many/many.mco exists, but $path is gone (expected all files of the run, or none of them)"
    expect_error 2 "$refused" "$work/many.mci" --resume --no-clobber --quiet -o "$work/many"
    expect_code 0 "$work/many.mci" --resume --quiet -o "$work/many"
    grep -q "its result $name is gone: it is written again" "$work/err" || complain "no word of $name: $(cat "$work/err")"
    cmp -s "$work/taken" "$path" || case $name in *.h5) test -s "$path" ;; *) false ;; esac || complain "$name: other bytes"
done
# An empty file, a part of a result, and a result of another run do not count as the run's own.
cp "$work/many/many.mco" "$work/whole"
harmed() { # WORDS COMMAND: what it prints takes the place of the result
    words=$1 harm=$2
    eval "$harm" >"$work/many/many.mco"
    cmp -s "$work/whole" "$work/many/many.mco" && complain "$harm does no harm"
    expect_code 0 "$work/many.mci" --resume --quiet -o "$work/many"
    grep -q "its result many.mco $words: it is written again" "$work/err" || complain "no word after $harm: $(cat "$work/err")"
    sed '/^# User time/d' "$work/many/many.mco" >"$work/a"
    sed '/^# User time/d' "$work/whole" | cmp -s - "$work/a" || complain "$harm: other bytes"
}
harmed 'is empty' true
harmed 'is no whole result' 'head -c 2000 "$work/whole"'
harmed 'is no whole result' 'head -n -6 "$work/whole"'
harmed 'is of another run' 'sed "s/Identity: ..../Identity: abcd/" "$work/whole"'
if test -e "$work/many/many_saved.photons.h5"; then
    mkdir "$work/strange"
    expect_code 0 "$work/many.mci" --seed 2 --quiet -o "$work/strange"
    for name in many_saved.photons.h5 many.map.vti many.boundary0.vtp; do
        cp "$work/strange/$name" "$work/many"
        expect_code 0 "$work/many.mci" --resume --quiet -o "$work/many"
        grep -q "its result $name is of another run: it is written again" "$work/err" || complain "no word of a strange $name: $(cat "$work/err")"
    done
fi
for name in many.map.vti many.boundary0.vtp; do
    cp "$work/many/$name" "$work/whole"
    head -c -1 "$work/whole" >"$work/many/$name"
    expect_code 0 "$work/many.mci" --resume --quiet -o "$work/many"
    grep -q "its result $name is no whole result: it is written again" "$work/err" || complain "no word of a cut $name: $(cat "$work/err")"
    cmp -s "$work/whole" "$work/many/$name" || complain "a cut $name: other bytes"
done
expect_code 0 samples/thick.mci --photons 100 --resume --quiet --output /dev/null # has no checkpoint
expect_code 0 "$work/many.mci" --resume -o "$work/many"
grep -q '^  finished before: nothing was written, its results stand$' "$work/out" || complain "all files are there: $(cat "$work/out" "$work/err")"
rm "$work/many/many.mco.checkpoint" # all its files say that they are of this run
expect_code 0 "$work/many.mci" --resume --no-clobber -o "$work/many"
grep -q '^  finished before: nothing was written, its results stand$' "$work/out" || complain "all files are there, and no checkpoint: $(cat "$work/out" "$work/err")"

# The JSON object of a finished run names files in their present folder, which was moved, and is otherwise the same.
mkdir "$work/there"
for output in thick.h5 thick.mco; do
    expect_code 0 samples/thick.mci --photons 100 --resume --output $output --json -o "$work/there"
    cp "$work/out" "$work/object"
    expect_code 0 samples/thick.mci --photons 100 --resume --output $output --json -o "$work/there"
    cmp -s "$work/out" "$work/object" || complain "another object: $(cat "$work/out")"
    mv "$work/there" "$work/moved"
    expect_code 0 samples/thick.mci --photons 100 --resume --output $output --json -o "$work/moved"
    grep -q "\"files\":\[\"$work/moved/$output\"\]" "$work/out" || complain "files of a folder that was moved: $(cat "$work/out")"
    mv "$work/moved" "$work/there"
done

# A run that would lose kept tallies notes the loss; with --no-clobber it is refused, and the tallies stay.
mkdir "$work/tallies"
expect_code 0 samples/thick.mci --photons 100 --keep --quiet -o "$work/tallies"
rm "$work/tallies/thick.mco"
expect_error 2 "--no-clobber: $work/tallies/thick.mco.checkpoint is that of a finished run with its tallies (expected --more, which extends it, --resume, or no such file)" \
    samples/thick.mci --photons 50 --no-clobber --quiet -o "$work/tallies"
expect_code 0 samples/thick.mci --photons 50 -o "$work/tallies"
grep -q "begins anew, and its tallies go$" "$work/err" || complain "no word of tallies that go: $(cat "$work/err")"

expect_code 0 samples/thick.mci --photons 200 -o "$work"
grep -q "thick.mco.checkpoint is of a finished run; without --more or --resume it begins anew$" "$work/err" ||
    complain "no word of the finished run: $(cat "$work/err")"

# A run that replaces a result notes the result and its photons; with --no-clobber it is refused, and the result stays.
grep -q "note: replaces $work/thick.mco of 100 photons$" "$work/err" || complain "no word of the result replaced: $(cat "$work/err")"
kept="--no-clobber: $work/thick.mco exists (expected another name or folder, or no --no-clobber)"
expect_code 0 samples/thick.mci --photons 200 --resume -o "$work"
test ! -s "$work/err" && grep -q '^  finished before: nothing was written, its results stand$' "$work/out" || complain "a result of this run, --resume: $(cat "$work/err")"
expect_code 0 samples/thick.mci --photons 300 --resume -o "$work"
grep -q "replaces $work/thick.mco of 200 photons$" "$work/err" || complain "no word with --resume: $(cat "$work/err")"
grep -q "note: --resume finds no $work/thick.mco.checkpoint: the run begins anew, as $work/thick.mco is of another run; what is there of its files is replaced$" "$work/err" ||
    complain "no word of the missing checkpoint: $(cat "$work/err")"
expect_code 0 samples/thick.mci --photons 300 --resume --no-clobber --quiet -o "$work"
test -s "$work/err" && complain "a finished run is noted: $(cat "$work/err")"
expect_error 2 "$kept" samples/thick.mci --photons 300 --no-clobber -o "$work"
# A result without a checkpoint still says if it is of this run.
rm "$work/thick.mco.checkpoint"
expect_code 0 samples/thick.mci --photons 300 --resume --no-clobber -o "$work"
test ! -s "$work/err" && grep -q '^  finished before: nothing was written, its results stand$' "$work/out" || complain "--no-clobber, a result of this run: $(cat "$work/err")"
expect_error 2 "$kept" samples/thick.mci --photons 301 --resume --no-clobber --quiet -o "$work"
grep -q '^300 ' "$work/thick.mco" || complain "--no-clobber replaced a result"
expect_code 0 samples/two_runs.mci --photons 100 --no-clobber --quiet -o "$work/two"
expect_code 0 samples/two_runs.mci --photons 100 --output-dir "$work/two"
grep -q "replaces $work/two/two_runs_hill.mco of 100 photons$" "$work/err" || complain "no word of two: $(cat "$work/err")"
# --no-clobber replaces no file of a run, including that of saved packets, whose name is not the result's.
sed -e '6a map 4 4 0.1 0.1' -e '6a photons "saved"' samples/thick.mci >"$work/saved.mci"
if "$program" --version | grep -q 'HDF5 yes'; then
    for name in saved.photons.h5 thick.h5 thick.map.vti; do
        mkdir "$work/$name.d"
        echo precious >"$work/$name.d/$name"
        expect_error 2 "--no-clobber: $work/$name.d/$name exists (expected another name or folder, or no --no-clobber)" "$work/saved.mci" --photons 200 --no-clobber -o "$work/$name.d"
        test "$(cat "$work/$name.d/$name")" = precious || complain "$name was replaced"
    done
    expect_code 0 "$work/saved.mci" --photons 200 -o "$work/saved.photons.h5.d"
    grep -q "note: replaces $work/saved.photons.h5.d/saved.photons.h5\$" "$work/err" || complain "no word of saved packets replaced: $(cat "$work/err")"
fi
finish
