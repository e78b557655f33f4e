#!/bin/sh
# samples/slurm-array.sh without Slurm: stand-ins for srun and scontrol. A task that is stopped asks to be requeued, and goes on
# when it is; the joined parts are what `merge` makes of runs of the same seeds.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
case $program in /*) ;; *) program=$PWD/$program ;; esac
mkdir "$work/bin" "$work/study" "$work/plain"
cat >"$work/bin/srun" <<'END'
#!/bin/sh
while case $1 in --*) true ;; *) false ;; esac do shift; done
if test -n "${STOP:-}"; then
    "$@" &
    until ls "$STOP"/*-0002.mco >/dev/null 2>&1; do sleep 0.01; done
    kill -TERM $!
    wait $!
    exit
fi
exec "$@"
END
printf '#!/bin/sh\necho "$*" >>"%s/asked"\n' "$work" >"$work/bin/scontrol"
chmod +x "$work/bin/srun" "$work/bin/scontrol"
printf 'layer1.mua\n0.5\n1\n' >"$work/two.csv"
{ echo layer1.mua; seq 1 200; } >"$work/long.csv"
task() { # SEED TABLE
    PATH=$work/bin:$PATH CLUSTERMCML=$program SLURM_ARRAY_TASK_ID=$1 SLURM_JOB_ID=9$1 SLURM_CPUS_PER_TASK=2 \
        bash samples/slurm-array.sh "$work/study" samples/thick.mci --sweep "$2" --photons 3000 --quiet
}
for seed in 1 2; do
    task $seed "$work/two.csv" || complain "task $seed: exit $?"
    expect_code 0 samples/thick.mci --photons 3000 --seed $seed --set layer1.mua=1 --output plain$seed.mco --quiet -o "$work/plain"
done
join() { CLUSTERMCML=$program sh samples/slurm-array.sh "$work/study" || complain "joining: exit $?"; }
join
for once_more in thick-0001.mco thick-0002.mco; do echo stale >"$work/study/$once_more"; done
join
expect_code 0 merge "$work/plain/plain1.mco" "$work/plain/plain2.mco" -o "$work/both.mco" --quiet
for file in "$work/both.mco" "$work/study/thick-0002.mco"; do
    sed -e '/^# User time/d' -e '/^# merged/d' -e 's/^[^ ]* \tA\t/NAME /' "$file" >"$file.bare"
done
cmp -s "$work/both.mco.bare" "$work/study/thick-0002.mco.bare" || complain "the joined row is not what merge makes"
test "$(wc -l <"$work/study/merged.json")" -eq 2 || complain "merged.json: $(cat "$work/study/merged.json")"

# parts that lack something, and no parts: said, and nothing written
refuses() { # EXPECTED TEXT
    code=0
    cp "$work/study/merged.json" "$work/before.json"
    CLUSTERMCML=$program sh samples/slurm-array.sh "$work/study" >"$work/out" 2>"$work/err" || code=$?
    test $code -eq 2 && grep -qF "$1" "$work/err" && test "$(wc -l <"$work/err")" -eq 1 || complain "exit $code: $(cat "$work/err") (expected $1)"
    cmp -s "$work/study/merged.json" "$work/before.json" || complain "merged.json was written"
}
mv "$work/study/part-2/thick-0002.mco" "$work/kept.mco"
refuses "part-2/thick-0002.mco: missing (expected the results of all parts)"
mv "$work/kept.mco" "$work/study/part-2/thick-0002.mco"
mkdir "$work/study/part-4"
refuses "part-4/thick-0001.mco: missing"
rmdir "$work/study/part-4"
touch "$work/study/part-2/thick-0003.mco.checkpoint"
refuses "part-2/thick-0003.mco: not finished (expected it done in all parts)"
touch "$work/study/part-1/thick-0002.mco.checkpoint" # of a finished run that keeps it
rm "$work/study/part-2/thick-0003.mco.checkpoint"
join
mkdir "$work/hidden"
mv "$work/study/part-1" "$work/study/part-2" "$work/hidden"
refuses "study: no parts (expected the folders part-SEED of the tasks)"
mkdir "$work/study/part-1"
refuses "study: no results in the parts (expected .mco or .h5 files)"
rmdir "$work/study/part-1"
mv "$work/hidden"/part-* "$work/study"
test ! -e "$work/asked" || complain "a finished task was requeued"

# stopped in the middle
code=0
STOP=$work/study/part-3 task 3 "$work/long.csv" 2>"$work/err" || code=$?
test $code -eq 75 && test "$(cat "$work/asked")" = "requeue 93" || complain "stopped: exit $code, $(cat "$work/asked" "$work/err")"
task 3 "$work/long.csv" || complain "requeued: exit $?"
test "$(ls "$work/study/part-3" | grep -c 'mco$')" -eq 200 || complain "requeued: $(ls "$work/study/part-3" | wc -l) files"
finish
