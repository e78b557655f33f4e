#!/bin/sh
# Tests --part and merge: parts of a run, of all runs of a file, of the rows of a sweep, and of a run that --more extends.
# Joined parts must have the bytes of one run in every file. Parts that are missing, unfinished, doubled or of another run are
# named, and nothing is written. tests/cluster/parts.py tests several ranks, kills and all outputs.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
root=$PWD
case $program in /*) ;; *) program=$PWD/$program ;; esac
mkdir "$work/one" "$work/parts"

bare() { # FILE: its bytes but the time; of an .h5 all, as it is called alike
    sed '/^# User time/d' "$1"
}
compare() { # TEXT: the folders one and parts have the same files
    ls one >names
    ls parts | grep -v '\.part\|checkpoint' | cmp -s - names || complain "$1: $(ls parts)"
    while read -r name; do
        bare "one/$name" >a
        bare "parts/$name" | cmp -s - a || complain "$1: $name has other bytes"
    done <names
}
# Flies one run in the folder one and N parts in the folder parts; the command lines in both folders look alike.
both() { # N ARGUMENTS...
    count=$1
    shift
    rm -rf one/* parts/*
    (cd one && "$program" "$@" --quiet) 2>err || complain "$*: $(cat err)"
    rm -f one/*.checkpoint
    for k in $(seq "$count" -1 1); do
        (cd parts && "$program" "$@" --part "$k/$count" --quiet) >out 2>err || complain "$* --part $k/$count: $(cat err)"
    done
    test "$(ls parts | grep -vc '\.part')" -eq 0 || complain "$*: parts left $(ls parts)"
    (cd parts && "$program" merge --quiet ./*.part*) >out 2>err || complain "$*, merge: $(cat err)"
    test ! -s out || complain "$*: merge --quiet says $(cat out)"
    compare "$*"
}
cd "$work" || exit 1
both 2 "$root/samples/skinmap.mci" --photons 5001
both 3 "$root/samples/two_runs.mci" --photons 2000 --engine reference
both 7 "$root/samples/pulse.mci" --photons 1003 --seed 5 --set layer1.mua=0.7
both 2 "$root/samples/thick.mci" --photons 3000 --derivatives --threads=2
both 5 "$root/samples/thick.mci" --photons 3 # fewer photons than parts
printf 'layer1.mua,layer1.mus\n1,50\n2,50\n1,60\n' >rows.csv
both 3 "$root/samples/thick.mci" --sweep "$work/rows.csv" --photons 2000
both 2 "$root/samples/thick.mci" --sweep "$work/rows.csv" --photons 2000 --reweight
printf '1.0\n1\nx.mco A\n3000\n0.01 0.01\n20 20 3\ntime 100 4\ndetector disk 0.2\n2\n1.0\n1.4 1 60 0.8 0.8\n1.4 1 60 0.8 0.3\nb 3 0.05 0.1 -0.05 0.2 0 0.1\n1.0\n' >x.mci
both 3 "$work/x.mci" --aim Tt_r
printf '1.0\n1\nx.mco A\n3000\n0.01 0.01\n20 20 3\nbeam disk 0.1\nbeam disk 0.2 at=0.3,0 share=0.3\n1\n1.0\n1.4 1 60 0.8 0.3\n1.0\n' >x.mci
both 3 "$work/x.mci"
"$program" --version | grep -q 'HDF5 yes' && sed -i '6a photons "saved" limit=50' x.mci && both 4 "$work/x.mci" --tolerance 0.01

# Parts of extended runs: more photons, in parts, twice, and at once.
rm -rf one/* parts/*
scene=$root/samples/skinmap.mci
more() { # ARGUMENTS...
    (cd parts && "$program" "$scene" "$@" --quiet) 2>err || complain "$*: $(cat err)"
}
for k in 1 2; do more --photons 3001 --part $k/2; done
(cd parts && "$program" merge --keep --quiet skinmap.mco.part*) || complain "merge --keep"
for k in 3 1 2; do more --more 700 --part $k/3; done
cp parts/skinmap.mco.checkpoint kept
code=0
(cd parts && "$program" merge --quiet skinmap.mco.part1of3 skinmap.mco.part3of3) 2>err || code=$?
test "$code $(cat err)" = "2 clustermcml: skinmap.mco: part 2 of 3 is missing (expected all parts of the run)" || complain "--more: exit $code, $(cat err)"
cmp -s kept parts/skinmap.mco.checkpoint || complain "a refused merge touched the checkpoint"
(cd parts && "$program" merge --quiet skinmap.mco.part?of3) || complain "merge of --more"
more --more 300
rm parts/*.part*
for k in 1 2; do more --more 99 --part $k/2; done
(cd parts && "$program" merge --quiet skinmap.mco.part?of2) || complain "merge of --more, again"
(cd one && "$program" "$scene" --photons 4100 --quiet)
for name in skinmap.mco skinmap.map.vti skinmap.volume.vti; do
    test ! -e "one/$name" || test "$(bare "one/$name" | sha256sum)" = "$(bare "parts/$name" | sha256sum)" || complain "--more: $name has other bytes"
done

# Parts are stopped and resumed; a finished part stays.
rm -rf one/* parts/*
scene=$root/samples/thick.mci
cd parts || exit 1
"$program" "$scene" --photons 3e5 --part 1/2 --checkpoint 0.02 --quiet --threads 1 2>../err &
run=$!
until test -e thick.mco.part1of2 || ! kill -0 $run; do sleep 0.02; done
kill -TERM $run
code=0
wait $run || code=$?
test $code -eq 75 || complain "a part was not stopped: exit $code"
"$program" "$scene" --photons 3e5 --part 2/2 --quiet || complain "part 2/2"
left=$("$program" merge thick.mco.part* 2>&1 >/dev/null)
case $left in "clustermcml: thick.mco.part1of2: "*" photons of the part have not flown yet (expected a finished part; --resume continues it)") ;; *) complain "an open part: $left" ;; esac
"$program" "$scene" --photons 3e5 --part 1/2 --resume --quiet || complain "--resume of a part"
before=$(sha256sum thick.mco.part1of2)
"$program" "$scene" --photons 3e5 --part 1/2 --resume >../out || complain "--resume of a finished part"
grep -q '^  finished before$' ../out && test "$before" = "$(sha256sum thick.mco.part1of2)" || complain "a finished part: $(cat ../out)"
"$program" merge --json thick.mco.part* >../out || complain "merge --json"
grep -q '"photons":300000,' ../out && test "$(wc -l <../out)" -eq 1 || complain "--json: $(cat ../out)"
cd ../one && "$program" "$scene" --photons 3e5 --quiet
cd ..
compare "stopped"

# Wrong parts are refused in one line, and nothing is written.
rm -rf one/* parts/*
refuses() { # MESSAGE ARGUMENTS-OF-MERGE...
    message=$1
    shift
    expect_error 2 "$message" merge "$@"
    test ! -e thick.mco || complain "$message: wrote"
    rm -f thick.mco
}
cp "$root/samples/thick.mci" thick.mci
for k in 1 2 3; do expect_code 0 thick.mci --photons 1000 --part $k/3 --quiet; done
expect_code 0 thick.mci --photons 1000 --part 1/2 --quiet
refuses "thick.mco: part 2 of 3 is missing (expected all parts of the run)" thick.mco.part1of3 thick.mco.part3of3
refuses "thick.mco: part 3 of 3 is missing (expected all parts of the run)" thick.mco.part1of3 thick.mco.part2of3
cp thick.mco.part2of3 again
refuses "again: has photons that thick.mco.part2of3 has, too (expected each part once)" thick.mco.part?of3 again
refuses "thick.mco.part1of2: has photons that thick.mco.part1of3 has, too (expected each part once)" thick.mco.part?of3 thick.mco.part1of2
expect_code 0 thick.mci --photons 1000 --part 2/3 --seed 2 --quiet -o other
refuses "other/thick.mco.part2of3: the checkpoint is of another run: 'seed 2' there, 'seed 1' here (expected parts of one run)" \
    thick.mco.part1of3 other/thick.mco.part2of3 thick.mco.part3of3
refuses "none: cannot be read (No such file or directory)" thick.mco.part?of3 none
head -c 9000 thick.mco.part2of3 >cut
refuses "cut: the checkpoint is damaged (checksum), and there is no older one" thick.mco.part1of3 cut thick.mco.part3of3
refuses "rows.csv: is no part of a run (expected a file that run --part of this version wrote)" rows.csv
refuses "merge: no parts (expected those of a run, NAME.partKofN)" thick.mci
expect_code 0 thick.mci --photons 1000 --keep --quiet -o other
refuses "other/thick.mco.checkpoint: is no part of a run (expected a file that run --part of this version wrote)" other/thick.mco.checkpoint
sed 's/^1.0 /1.0  /' thick.mci >changed
cmp -s thick.mci changed && complain "nothing was changed"
mv thick.mci away
refuses "thick.mci: cannot be read: No such file or directory (expected a file)" thick.mco.part?of3
mv changed thick.mci
size=$(wc -c <away)
refuses "thick.mco.part1of3: the checkpoint is of another run: the file thick.mci has other contents, $size bytes there, $(wc -c <thick.mci) bytes here (expected parts of one run)" \
    thick.mco.part?of3
sed 's/^200000 /300000 /' away >thick.mci
cmp -s away thick.mci && complain "nothing was changed"
refuses "thick.mco.part1of3: the checkpoint is of another run: the file thick.mci has other contents, $size bytes there, $size bytes here (expected parts of one run)" \
    thick.mco.part?of3
mkdir moved && mv away moved/thick.mci
cp moved/thick.mci renamed.mci
refuses "merge: renamed.mci (expected the scene file of the parts, named thick.mci)" renamed.mci thick.mco.part?of3
expect_code 0 merge moved/thick.mci thick.mco.part?of3 -o moved --quiet
expect_code 0 moved/thick.mci --photons 1000 --quiet -o one
test "$(bare one/thick.mco | sha256sum)" = "$(bare moved/thick.mco | sha256sum)" || complain "a scene that was moved: other bytes"
expect_error 2 "--no-clobber: $work/moved/thick.mco exists (expected another name or folder, or no --no-clobber)" merge moved/thick.mci thick.mco.part?of3 -o moved --no-clobber
cp moved/thick.mci .
expect_error 2 "--no-clobber: thick.mco.part1of3 exists (expected another name or folder, or no --no-clobber)" thick.mci --photons 1000 --part 1/3 --no-clobber --quiet
expect_code 0 thick.mci --photons 1000 --part 1/3
grep -q "note: thick.mco.part1of3 is there; without --resume this part begins anew$" err || complain "no word of a part that is there: $(cat err)"
cp thick.mco.part1of3 thick.mco.part2of3
expect_error 2 "thick.mco.part2of3: is another part of the run (expected part 2 of 3, or no --resume)" thick.mci --photons 1000 --part 2/3 --resume --quiet
for wrong in 0/3 4/3 1 1/ /3 1/2/3 1/5000 -1/2 a/b; do
    expect_error 2 "--part $wrong (expected K/N, part K of N, with 1 <= K <= N <= 4096)" thick.mci --part $wrong
done
expect_error 2 "--part (expected no --target-error beside it)" thick.mci --part 1/2 --target-error 0.1
expect_error 2 "--part (expected no --json beside it)" thick.mci --part 1/2 --json
expect_error 2 "--part: /dev/null is no file (expected a result in a file)" thick.mci --part 1/2 --output /dev/null --quiet
expect_error 2 "--part: the command line is too long or has a line break (expected at most 4095 bytes in one line)" thick.mci --part 1/2 --set "layer1.mua=1
"

# `merge` needs all parts of every run of a file; the message names a run without parts.
for k in 1 2; do expect_code 0 "$root/samples/two_runs.mci" --photons 100 --part $k/2 --quiet; done
expect_code 2 merge two_runs_flat.mco.part*
grep -q '^clustermcml: two_runs_hill.mco: no part of it (expected all its parts)$' err || complain "half of the runs: $(cat err)"
expect_error 2 "thick.mco.part1of2: is a part of another run than two_runs_flat.mco.part1of2 (expected parts of one scene file with the same options)" \
    merge --quiet two_runs*.part?of2 thick.mco.part1of2 -o new
test "$(echo two_runs*.mco new)" = "two_runs*.mco new" && test ! -e new || complain "refused parts of two runs: wrote $(ls -d two_runs*.mco new)"
for k in 1 2; do expect_code 0 "$root/samples/thick.mci" --sweep rows.csv --photons 100 --part $k/2 --quiet -o rows; done
rm rows/thick-0003.mco.part2of2
expect_error 2 "rows.csv:4: row 3, layer1.mua = 1, layer1.mus = 60: thick-0003.mco: part 2 of 2 is missing (expected all parts of the run)" \
    merge rows/*.part* -o new
test ! -e new || complain "refused rows: wrote $(ls new)"

# Files that a killed process left beside parts are ignored.
: >two_runs_flat.mco.part1of2.lock
echo older >two_runs_flat.mco.part1of2.old
expect_error 2 "merge: no parts (expected those of a run, NAME.partKofN)" merge two_runs_flat.mco.part1of2.*
expect_code 0 merge --quiet two_runs*.part*
test -e two_runs_flat.mco || complain "beside a lock: no result"

# Files with foreign content stay.
echo mine >thick.mco.part1of3
cp thick.mco.part1of3 thick.mco
for words in "--part 1/3" "--part 1/3 --resume"; do
    expect_error 2 "$work/thick.mco.part1of3: is no file of this program (expected a part, or no file)" thick.mci --photons 1000 $words
done
expect_error 2 "$work/thick.mco: is no file of this program (expected a result, or no file)" thick.mci --photons 1000 --resume
test "$(cat thick.mco thick.mco.part1of3 | tr -d '\n')" = minemine || complain "a text file was replaced"
sed 's/thick.mco A/thick.h5 B/' thick.mci >binary.mci
foreign() { # NAME SCENE: --resume leaves a file that another program has written
    cp "$1" mine
    expect_error 2 "$work/$1: is no file of this program (expected a result, or no file)" "$2" --photons 100 --resume
    cmp -s "$1" mine || complain "$1 of another program was replaced"
    rm "$1"
}
echo "A1 paper is 594 mm by 841 mm." >thick.mco
foreign thick.mco thick.mci
printf '<?xml version="1.0"?>\n<svg/>\n' >skinmap.map.vti
foreign skinmap.map.vti "$root/samples/skinmap.mci"
if /usr/bin/python3 -c 'import h5py' 2>/dev/null; then # Debian packages h5py for its own
    /usr/bin/python3 -c 'import h5py; h5py.File("thick.h5", "w")["mine"] = [1.0]'
    foreign thick.h5 binary.mci
    /usr/bin/python3 -c 'import h5py; h5py.File("thick.h5", "w").attrs["source"] = "another program"'
    foreign thick.h5 binary.mci
    expect_code 0 binary.mci --photons 100 --quiet
    head -c 3000 thick.h5 >cut
    mv cut thick.h5
    expect_code 0 binary.mci --photons 100 --quiet --resume
fi
sed 's/thick.mco A/named.h5 A/' thick.mci >named.mci # text in spite of its name
for words in "" --resume; do expect_code 0 named.mci --photons 100 --quiet $words; done
finish
