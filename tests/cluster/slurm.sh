#!/bin/sh
# samples/slurm.sh with stand-ins for srun and scontrol: what it starts, and when it has itself requeued.
# SPDX-License-Identifier: MIT
. tests/lib/cluster.sh
mkdir "$work/bin" "$work/run"
cat >"$work/bin/srun" <<E2
#!/bin/sh
while case \$1 in -*) true ;; *) false ;; esac; do shift; done
exec mpiexec -n 2 $mpi_options "\$@"
E2
printf '#!/bin/sh\necho "$@" >>"%s/requeued"\n' "$work" >"$work/bin/scontrol"
chmod +x "$work/bin/srun" "$work/bin/scontrol"
root=$PWD

attempt() { # SIGNAL or nothing: returns the script's exit code, after the signal to the ranks
    code=0
    rm -f "$work/out"
    (cd "$work/run" && PATH=$work/bin:$PATH CLUSTERMCML=$program SLURM_JOB_ID=7 SLURM_CPUS_PER_TASK=1 \
        exec bash "$root/samples/slurm.sh" "$root/samples/thick.mci" --photons 1e6 >"$work/out" 2>"$work/err") &
    script=$!
    if test -n "$1"; then
        until grep -qs '^  boundary 1' "$work/out" || ! kill -0 $script; do sleep 0.05; done
        for launcher in $(cat /proc/$script/task/$script/children); do
            kill -"$1" $(cat /proc/$launcher/task/$launcher/children)
        done
    fi
    wait $script || code=$?
}

expect_code 0 samples/thick.mci --photons 1e6 --quiet -o "$work"
attempt USR2
test $code -eq 75 && test "$(cat "$work/requeued")" = "requeue 7" || complain "signalled: $code, $(cat "$work/out" "$work/err")"
attempt ""
test $code -eq 0 && test "$(wc -l <"$work/requeued")" -eq 1 || complain "done: $code, $(cat "$work/out" "$work/err")"
expect_bits "requeued" "$work/run/thick.mco" "$work/thick.mco"
finish
