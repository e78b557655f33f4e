#!/bin/sh
# Tests failures on any rank: all ranks end with one message and one exit code, and no file is spoilt.
# SPDX-License-Identifier: MIT
. tests/lib/cluster.sh
sample=samples/fig5.mci

expect_ranks_error 3 2 "$work/missing.mci: cannot be read: No such file or directory (expected a file)" "$work/missing.mci"
expect_ranks_error 3 2 "--seed x (expected a whole number from 0 to 9007199254740992)" $sample --seed x
expect_ranks_error 3 5 "$sample: cannot be made (File exists; expected a folder)" $sample -o $sample/none
printf '1.0\n1\nx.mco A\nten\n' >"$work/wrong.mci"
expect_ranks_error 3 2 "$work/wrong.mci:4: photons = ten (expected a whole number of 1..2^48)" "$work/wrong.mci"

# A single rank fails: too little memory for the result, or other options than rank 0's. Two programs of one mpiexec are not
# used: Open MPI 5.0.7's mpiexec crashes if its command line holds a colon.
two_kinds() { # COMMAND OF RANK 0 and of rank 1, each one word to sh -c
    code=0
    mpiexec $mpi_options -n 2 sh -c 'test "${OMPI_COMM_WORLD_RANK:-$PMI_RANK}" -eq 0 || shift; exec sh -c "$1"' sh "$1" "$2" \
        >"$work/out" 2>"$work/err" || code=$?
    grep '^clustermcml' "$work/err" >"$work/said"
}
big=$work/big.mci
sed 's/^5*[0-9]* [0-9]* 1  *# nz.*/1000 5000 1/' bench/lib/scenes/S6b.mci >"$big"
grep -q '^1000 5000 1' "$big" || complain "no big grid"
run="$program $big --photons 100 --quiet -o $work --threads 1"
two_kinds "$run" "ulimit -v 300000; $run"
test $code -eq 2 && grep -q '^clustermcml: out of memory: [0-9]* MiB for the result$' "$work/said" &&
    test "$(wc -l <"$work/said")" -eq 1 || complain "no memory on rank 1: $code, $(cat "$work/err")"
for other in "--seed 2" "--error-of A_l:1" "--aim A_l:2"; do
    two_kinds "$program $sample -o $work --target-error 0.1" "$program $sample -o $work --target-error 0.1 $other"
    test $code -eq 2 && grep -q 'rank 1 has another program or other options than rank 0' "$work/said" &&
        test "$(wc -l <"$work/said")" -eq 1 || complain "$other on rank 1: $code, $(cat "$work/err")"
done
test ! -e "$work/fig5.mco" && test ! -e "$work/S6b.mco" || complain "a failed run wrote a result"

# A sweep meets these failures before its first row. Four ranks fly rows of their own; two fly each row together.
version=$("$program" --version | sed -n 's/^clustermcml //p')
LC_ALL=C sed "s/$version/$(echo "$version" | tr 0-9 1-90)/g" "$program" >"$work/other"
chmod +x "$work/other"
mkdir "$work/rows"
for rows in 2 4; do
    echo layer1.g >"$work/g.csv"
    for row in $(seq $rows); do echo 0.$row >>"$work/g.csv"; done
    run="samples/thick.mci --photons 1000 --threads 1 --quiet -o $work/rows --sweep $work/g.csv"
    for other in "$program $run --set layer1.mua=9" "$program $run --no-reentry" "$program $run --engine reference" \
        "$program $run --json" "$program $run -o $work" "$program ${run% --sweep*}" "$work/other $run"; do
        two_kinds "exec timeout 20 $program $run" "exec timeout 20 $other"
        test $code -eq 2 && grep -q 'rank 1 has another program or other options than rank 0' "$work/said" &&
            test "$(wc -l <"$work/said")" -eq 1 || complain "$rows rows, $other: $code, $(cat "$work/err")"
        test "$(ls -A "$work/rows")" = "" || complain "$rows rows, $other: $(ls -A "$work/rows")"
        rm -f "$work"/rows/*
    done
done

# The system starts no threads for a rank. Without the thread that answers others the rank cannot take part; otherwise it
# flies with one thread.
run="$program $sample --photons 1000 --threads 2 --quiet -o $work"
two_kinds "$run" "LD_PRELOAD=$SYSTEM_FAULT CML_THREADS=1 $run"
test $code -eq 5 && test "$(cat "$work/said")" = "clustermcml: rank 1: the thread that answers other ranks cannot start" ||
    complain "no service thread: $code, $(cat "$work/err")"
two_kinds "$run" "LD_PRELOAD=$SYSTEM_FAULT CML_THREADS=2 $run"
test $code -eq 0 && grep -q '^clustermcml: note: rank 1: 1 of 2 threads: the system starts no more$' "$work/said" ||
    complain "no flying thread: $code, $(cat "$work/err")"
rm "$work/fig5.mco"

c=$work/thick.mco.checkpoint

# A rank stops answering: after the patience there is one message, and the checkpoint can be resumed.
begin() { # ARGUMENTS: starts 2 ranks of a long run, waits until a checkpoint is there; sets launcher and children
    mpiexec -n 2 $mpi_options "$program" samples/thick.mci --photons 1e8 --checkpoint 0.2 --quiet -o "$work" "$@" \
        >"$work/out" 2>"$work/err" &
    launcher=$!
    until test "$(cat "$c" 2>/dev/null | wc -c)" -gt 10000 || ! kill -0 $launcher; do sleep 0.1; done
    children=$(cat /proc/$launcher/task/$launcher/children)
}
begin --patience 1
for child in $children; do last=$child; done
kill -STOP "$last"
code=0
wait $launcher || code=$?
test $code -eq 5 && grep -q '^clustermcml: contact lost: nothing heard from rank 1 on .* for 1 s ' "$work/err" ||
    complain "a stopped rank: $code, $(cat "$work/err")"
test ! -e "$work/thick.mco" && test -e "$work/thick.mco.checkpoint" || complain "a stopped rank: $(ls "$work")"

# A damaged checkpoint is reported, and the older one is used instead.
refuse() { # MESSAGE ARGUMENTS...
    message=$1
    shift
    expect_error 2 "$message" samples/thick.mci --photons 1e8 --resume --quiet -o "$work" "$@"
}
refuse "$c: the checkpoint is of another run: 'seed 1' there, 'seed 2' here (expected that run; without --resume or --more this one begins anew)" --seed 2
refuse "$c: the checkpoint is of another run: 'photons 100000000' there, 'photons 1000' here (expected that run; without --resume or --more this one begins anew)" --photons 1e3
refuse "$c: the checkpoint is of another run: 'engine cpu' there, 'engine reference' here (expected that run; without --resume or --more this one begins anew)" --engine reference
{ cat samples/thick.mci; echo "# more"; } >"$work/thick.mci"
code=0
"$program" "$work/thick.mci" --photons 1e8 --resume -o "$work" >"$work/out" 2>"$work/err" || code=$?
test $code -eq 2 && grep -q "another run: the file thick.mci has other contents, [0-9]* bytes there, [0-9]* bytes here" "$work/err" ||
    complain "another scene: $code, $(cat "$work/err")"
test -e "$c.old" || cp "$c" "$c.old"
truncate -s 1000 "$c"
begin --resume
kill -USR2 $launcher
code=0
wait $launcher || code=$?
test $code -eq 75 || complain "resumed from the older checkpoint: $code, $(cat "$work/err")"
grep -q "note: $c: the checkpoint is damaged (checksum); continuing from $c.old" "$work/err" ||
    complain "no word of the older checkpoint: $(cat "$work/err")"
truncate -s 1000 "$c"
truncate -s 0 "$c.old"
refuse "$c.old: the checkpoint is damaged (cut short)"
rm -f "$c" "$c.old"

# The disk is full, or became read-only: existing results stay.
expect_code 0 samples/thick.mci --photons 1000 --quiet -o "$work"
unshare -m true 2>/dev/null || { echo "not tested: full and read-only disk (no right to mount)"; finish; exit 77; }
cat >"$work/disk.sh" <<'E2'
. tests/lib/cluster.sh
disk=$work/disk
mkdir "$disk"
mount -t tmpfs -o size=1000k none "$disk"
cp "$1/thick.mco" "$disk/"
say="cannot be written (No space left on device)"
code=0
ranks 2 samples/thick.mci --photons 5e5 --checkpoint 0.2 --quiet -o "$disk" 2>"$work/err" || code=$?
test $code -eq 5 || complain "full disk: exit $code: $(cat "$work/err")"
grep -q "^clustermcml: note: $disk/thick.mco.checkpoint: $say" "$work/err" &&
    test "$(grep '^clustermcml: [^n]' "$work/err")" = "clustermcml: $disk/thick.mco: $say" ||
    complain "full disk: $(cat "$work/err")"
test "$(ls "$disk")" = thick.mco && expect_bits "full disk" "$disk/thick.mco" "$1/thick.mco"
mount -o remount,ro "$disk"
expect_ranks_error 2 5 "$disk/thick.mco: cannot be written (Read-only file system)" samples/thick.mci -o "$disk"
expect_bits "read-only disk" "$disk/thick.mco" "$1/thick.mco"
umount "$disk"
finish
E2
unshare -m sh "$work/disk.sh" "$work" || complain "disks"
finish
