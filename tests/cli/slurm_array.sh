#!/bin/sh
# Tests samples/slurm-array.sh and samples/slurm.sh without Slurm, with stand-ins for srun and scontrol. A stopped task asks
# to be requeued, and goes on when it is; the joined parts have the bytes of one run. Neither script asks for more time if
# that time would be useless.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
case $program in /*) ;; *) program=$PWD/$program ;; esac
mkdir "$work/bin" "$work/study" "$work/plain"
cat >"$work/bin/srun" <<'END'
#!/bin/sh
while case $1 in --*) true ;; *) false ;; esac do shift; done
if test -n "${STOP:-}"; then
    "$@" &
    until ls $STOP 2>/dev/null | grep -q . || ! kill -0 $!; do sleep 0.01; done
    kill -${SIGNAL:-TERM} $!
    wait $!
    exit
fi
exec "$@"
END
printf '#!/bin/sh\necho "$*" >>"%s/asked"\n' "$work" >"$work/bin/scontrol"
chmod +x "$work/bin/srun" "$work/bin/scontrol"
printf 'layer1.mua\n0.5\n1\n' >"$work/two.csv"
{ echo layer1.mua; seq 1 200; } >"$work/long.csv"
task() { # PART TABLE OPTIONS...
    part=$1 table=$2
    shift 2
    PATH=$work/bin:$PATH CLUSTERMCML=$program SLURM_ARRAY_TASK_ID=$part SLURM_ARRAY_TASK_COUNT=2 SLURM_JOB_ID=9$part SLURM_CPUS_PER_TASK=2 \
        bash samples/slurm-array.sh "$work/study" samples/thick.mci --sweep "$table" --photons 3000 --quiet "$@"
}
for part in 1 2; do task $part "$work/two.csv" || complain "task $part: exit $?"; done
join() { CLUSTERMCML=$program sh samples/slurm-array.sh "$work/study" || complain "joining: exit $?"; }
join
for once_more in thick-0001.mco thick.sweep.csv; do echo stale >"$work/study/$once_more"; done
join
expect_code 0 samples/thick.mci --sweep "$work/two.csv" --photons 3000 --quiet -o "$work/plain"
for name in thick-0001.mco thick-0002.mco thick.sweep.csv; do
    sed '/^# User time/d' "$work/plain/$name" >"$work/expected"
    sed '/^# User time/d' "$work/study/$name" | cmp -s - "$work/expected" || complain "$name is not what one run makes"
done
test "$(wc -l <"$work/study/merged.json")" -eq 2 || complain "merged.json: $(cat "$work/study/merged.json")"

# Missing or incomplete parts are named, and nothing is written.
refuses() { # EXPECTED TEXT
    code=0
    cp "$work/study/merged.json" "$work/before.json"
    CLUSTERMCML=$program sh samples/slurm-array.sh "$work/study" >"$work/out" 2>"$work/err" || code=$?
    test $code -eq 2 && grep -qF "$1" "$work/err" && test "$(wc -l <"$work/err")" -eq 1 || complain "exit $code: $(cat "$work/err") (expected $1)"
    cmp -s "$work/study/merged.json" "$work/before.json" || complain "merged.json was written"
}
mkdir "$work/hidden"
mv "$work/study/thick-0002.mco.part2of2" "$work/hidden"
refuses "thick-0002.mco: part 2 of 2 is missing (expected all parts of the run)"
mv "$work"/study/*.part* "$work/hidden"
refuses "study: no parts (expected the files NAME.partKofN of the tasks)"
mv "$work/hidden"/*.part* "$work/study"
test ! -e "$work/asked" || complain "a finished task was requeued"
PARTS=2 task 1 "$work/two.csv" || complain "a task once more: exit $?"
join
rm "$work"/study/*

# stopped in the middle
code=0
STOP="$work/study/*-0002.mco.part1of2" task 1 "$work/long.csv" 2>"$work/err" || code=$?
test $code -eq 75 && test "$(cat "$work/asked")" = "requeue 91" || complain "stopped: exit $code, $(cat "$work/asked" "$work/err")"
task 1 "$work/long.csv" || complain "requeued: exit $?"
test "$(ls "$work/study" | grep -c 'mco.part1of2$')" -eq 200 || complain "requeued: $(ls "$work/study" | wc -l) files"

# ---- slurm.sh: a job that made progress is requeued; one that did not would be requeued for ever

mkdir "$work/job" "$work/job/d"
job() { # CODE ARGUMENTS...
    rm -f "$work/asked"
    wanted=$1 code=0
    shift
    PATH=$work/bin:$PATH CLUSTERMCML=$program SLURM_JOB_ID=7 bash samples/slurm.sh --checkpoint 0.05 "$@" >"$work/out" 2>"$work/err" || code=$?
    test $code -eq "$wanted" || complain "slurm.sh $*: exit $code, not $wanted: $(cat "$work/out" "$work/err")"
}
is_not_requeued() { # CODE
    grep -qx "stopped with $1 before it wrote a checkpoint, not requeued: if its time was over, --time is too short" "$work/out" &&
        test ! -e "$work/asked" || complain "requeued: $(cat "$work/out")"
}
flies() { # SIGNAL CODE ARGUMENTS...: a run that gets the signal when there is a checkpoint
    export SIGNAL=$1 STOP="$work/job/*.checkpoint $work/job/d/*.checkpoint"
    stopped=$2
    shift 2
    rm -f "$work"/job/*.* "$work"/job/d/*
    job 75 samples/thick.mci --photons 1e9 "$@"
    grep -q "^stopped with $stopped, requeued" "$work/out" && test "$(cat "$work/asked")" = "requeue 7" || complain "not requeued: $(cat "$work/out")"
}
flies TERM 75 -o "$work/job"
flies KILL 137 -o"$work/job" --output d/thick.mco
flies KILL 137 --output-dir="$work/job"
flies KILL 137 --output "$work/job/thick.mco"
flies KILL 137 --output="$work/job/d/thick.mco"
# A checkpoint far away counts, too: in the folder of an absolute output name, or behind a link. If the script finds none, the
# run's last line says that there is one.
mkdir "$work/far"
sed "s#^[^ ]*.mco A#$work/far/thick.mco A#" samples/thick.mci >"$work/far.mci"
STOP="$work/far/*.checkpoint" SIGNAL=TERM job 75 "$work/far.mci" --photons 1e9
grep -q "^stopped with 75, requeued" "$work/out" && test "$(cat "$work/asked")" = "requeue 7" || complain "an absolute name: $(cat "$work/out")"
ln -s "$work/far" "$work/link"
rm "$work"/far/*
STOP="$work/far/*.checkpoint" SIGNAL=KILL job 75 samples/thick.mci --photons 1e9 -o "$work/link"
grep -q "^stopped with 137, requeued" "$work/out" || complain "a link: $(cat "$work/out")"
unset STOP
printf '#!/bin/sh\ntest -z "${FATAL:-}" || kill -KILL $$\nexit 75\n' >"$work/bin/begins" # and gets no further
chmod +x "$work/bin/begins"
program=$work/bin/begins
touch -d 2001-01-01 "$work/job/d/thick.mco.checkpoint" # of an attempt before this one
job 75 samples/thick.mci -o "$work/job"
is_not_requeued 75
FATAL=yes job 137 samples/thick.mci -o "$work/job"
is_not_requeued 137
code=0
task 2 "$work/two.csv" >"$work/out" || code=$?
test $code -eq 75 || complain "an array's task: exit $code"
is_not_requeued 75
finish
