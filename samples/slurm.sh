#!/bin/bash
# A run on a cluster with Slurm, without job arrays: it checkpoints, stops when its time is over or it is preempted,
# and is requeued until it is done.  sbatch samples/slurm.sh scene.mci [options of clustermcml]
# CLUSTERMCML names the program.
#SBATCH --job-name=clustermcml
#SBATCH --nodes=2
#SBATCH --ntasks-per-node=2
#SBATCH --cpus-per-task=16
#SBATCH --time=04:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
# Two minutes before the time is over, to the ranks themselves: they write a checkpoint and return 75.
#SBATCH --signal=USR2@120
# SPDX-License-Identifier: MIT
set -u
program=${CLUSTERMCML:-clustermcml}
# No OMP_PLACES: where Slurm does not confine tasks to their cores, all ranks of a node would bind to its first ones.
export OMP_NUM_THREADS=${SLURM_CPUS_PER_TASK:-1}

# --resume begins anew where there is no checkpoint, so the first attempt needs no other command. Let the shell wait:
# a preempted batch script gets SIGTERM, which the ranks get too.
trap : TERM USR2
started=$(mktemp)
trap 'rm -f "$started"' EXIT
srun --mpi=pmix --cpus-per-task="$OMP_NUM_THREADS" --kill-on-bad-exit=1 "$program" "$@" --resume &
step=$!
code=0
wait $step || code=$?
while kill -0 $step 2>/dev/null; do # a trapped signal ends wait, not the step
    wait $step
    code=$?
done

# 75: stopped, resumable. A launcher may return something else when it was itself told to stop, and a preempted job
# may be killed before it says anything: then a checkpoint that is newer than this attempt says the same. USR2 (140) that
# comes before the ranks have met, on a machine that is slow to start them, leaves the checkpoint of the attempt before.
directory=. before=
for word; do # the value of -o among the arguments
    case $before in -o | --output-dir) directory=$word ;; esac
    case $word in --output-dir=*) directory=${word#*=} ;; -o?*) directory=${word#-o} ;; esac
    before=$word
done
is_there() { # [TESTS OF find]
    find "$directory" -maxdepth 1 -name '*.checkpoint' "$@" 2>/dev/null | grep -q .
}
if test $code -eq 75 || { test $code -eq 140 && is_there; } || { test $code -ge 128 && is_there -newer "$started"; }; then
    echo "stopped with $code, requeued: scontrol requeue ${SLURM_JOB_ID:-?}"
    scontrol requeue "$SLURM_JOB_ID"
    exit 75
fi
exit $code
