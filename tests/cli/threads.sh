#!/bin/sh
# Tests the number of threads. Without --threads there are as many threads as the process may use cores, even if OpenMP binds
# its threads before main begins. A note tells if more are asked for than the process may use, or if the system starts fewer.
# Also tests a mesh without further threads, and stacks that are small, huge or too small.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
unset OMP_NUM_THREADS OMP_PLACES OMP_PROC_BIND
cores=$(nproc)
first=$(taskset -cp $$ | sed 's/.*: *\([0-9]*\).*/\1/')

threads_of() { # COMMAND...: prints the number of threads, leaves notes in $work/err
    rm -f "$work/fig5.mco" # replacing it is noted
    "$@" samples/fig5.mci --photons 1e3 --json -o "$work" 2>"$work/err" | sed 's/.*"threads":\([0-9]*\).*/\1/'
}

expect_threads() { # WHAT NUMBER COMMAND...
    what=$1 number=$2
    shift 2
    found=$(threads_of "$@")
    test "$found" = "$number" || complain "$what: $found threads, not $number: $(cat "$work/err")"
}

expect_silence() { # WHAT
    test ! -s "$work/err" || complain "$1: $(cat "$work/err")"
}

expect_threads "no word about threads" "$cores" "$program"
expect_silence "no word about threads"
for bind in true spread close; do
    expect_threads "OMP_PROC_BIND=$bind" "$cores" env OMP_PROC_BIND=$bind "$program"
    expect_threads "OMP_PROC_BIND=$bind, asked for" "$cores" env OMP_PROC_BIND=$bind OMP_NUM_THREADS="$cores" "$program"
    expect_silence "OMP_PROC_BIND=$bind, asked for"
done
expect_threads "bound to one core" 1 taskset -c "$first" "$program"
expect_threads "two threads on one core" 2 taskset -c "$first" env OMP_NUM_THREADS=2 "$program"
grep -q '^clustermcml: note: 2 threads on 1 core ' "$work/err" || complain "two threads on one core: $(cat "$work/err")"
expect_threads "OMP_THREAD_LIMIT" 1 env OMP_THREAD_LIMIT=1 OMP_NUM_THREADS="$cores" "$program"

# The system refuses to start more threads: those that fly are counted and give the same bytes; if there are none, the caller
# flies.
bits() { grep -v '^# User time' "$work/fig5.mco" | cksum; }
expected=$(bits)
unset OMP_NUM_THREADS
for refused in 1 2 3; do
    expect_threads "thread $refused is refused" $refused env LD_PRELOAD="$SYSTEM_FAULT" CML_THREADS=$refused \
        OMP_NUM_THREADS=4 "$program"
    test "$(grep -v ' threads on ' "$work/err")" = "clustermcml: note: $refused of 4 threads: the system starts no more" ||
        complain "thread $refused is refused: $(cat "$work/err")"
    test "$(bits)" = "$expected" || complain "thread $refused is refused: other bytes"
done

# A mesh needs no thread but the caller, with any engine. CML_THREADS=0 refuses those of TBB, too.
without_threads() { # ARGUMENTS
    LD_PRELOAD="$SYSTEM_FAULT" CML_THREADS=0 "$program" "$@" >"$work/out" 2>"$work/err" ||
        complain "no thread, $*: exit $?: $(cat "$work/err")"
}
without_threads check samples/skinmap.mci
for option in --threads=1 --threads=4 --engine=reference; do
    without_threads samples/skinmap.mci $option --photons 100 -o "$work"
done

# The program sets the size of stacks itself, not OpenMP or the limit of the process, which may be gigabytes.
for limit in 256 1000000 unlimited; do
    (
        ulimit -s $limit && ulimit -v 3000000 || exit 0
        expect_threads "ulimit -s $limit" 4 env OMP_STACKSIZE=16k OMP_NUM_THREADS=4 "$program"
        grep -v ' threads on ' "$work/err" >"$work/notes" && complain "ulimit -s $limit: $(cat "$work/notes")"
        finish
    ) || complain "ulimit -s $limit"
    test "$(bits)" = "$expected" || complain "ulimit -s $limit: other bytes"
done
for limit in 16 64 128 255; do # an environment needs some of the stack, too
    code=0
    (ulimit -s $limit && exec env -i "$program" samples/fig5.mci --photons 1e3 --quiet -o "$work") 2>"$work/err" || code=$?
    test $code -eq 2 && test "$(cat "$work/err")" = "clustermcml: ulimit -s is $limit KiB (expected 256 or more)" ||
        complain "ulimit -s $limit: exit $code: $(cat "$work/err")"
done
finish
