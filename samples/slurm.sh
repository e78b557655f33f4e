#!/bin/bash
# A run on a cluster with Slurm, without job arrays: it checkpoints, stops when its time is over or it is preempted,
# and is requeued until it is done, while every attempt writes a checkpoint.  sbatch samples/slurm.sh scene.mci [options of clustermcml]
# CLUSTERMCML names the program.
#SBATCH --job-name=clustermcml
#SBATCH --nodes=2
#SBATCH --ntasks-per-node=2
#SBATCH --cpus-per-task=16
#SBATCH --time=04:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
# Two minutes before the time is over, to the ranks themselves: they write a checkpoint and return 75. Without it they do so
# at SIGTERM, which comes when the time is over; Slurm then waits KillWait (30 s).
#SBATCH --signal=USR2@120
# SPDX-License-Identifier: MIT
set -u
program=${CLUSTERMCML:-clustermcml}
# No OMP_PLACES: where Slurm does not confine tasks to their cores, all ranks of a node would bind to its first ones.
export OMP_NUM_THREADS=${SLURM_CPUS_PER_TASK:-1}

# --resume begins anew where there is no checkpoint, so the first attempt needs no other command. Let the shell wait:
# a preempted batch script gets SIGTERM, which the ranks get too.
trap : TERM USR2
said=$(mktemp 2>/dev/null || TMPDIR=. mktemp)
touch "$said.begun"
trap 'rm -f "$said" "$said.begun"' EXIT
srun --mpi=pmix --cpus-per-task="$OMP_NUM_THREADS" --kill-on-bad-exit=1 "$program" "$@" --resume \
    2> >(trap '' TERM USR2; exec tee "$said" >&2) &
step=$!
code=0
wait $step || code=$?
while kill -0 $step 2>/dev/null; do # a trapped signal ends wait, not the step
    wait $step
    code=$?
done

# 75: stopped, and its last line says that --resume continues; where it was stopped before it flew, as it would be for ever,
# it does not. A launcher may return something else when it was itself told to stop, and a preempted job may be killed before
# it says anything: a checkpoint that is newer than this attempt says the same.
directory=. output= before=
for word; do # the values of -o and --output among the arguments
    case $before in -o | --output-dir) directory=$word ;; --output) output=$word ;; esac
    case $word in --output-dir=*) directory=${word#*=} ;; --output=*) output=${word#*=} ;; -o?*) directory=${word#-o} ;; esac
    before=$word
done
case $output in /*) directory=${output%/*}/ ;; esac
got_on() {
    grep -q ' to fly; --resume continues' "$said" ||
        find -L "$directory" -name '*.checkpoint' -newer "$said.begun" 2>/dev/null | grep -q .
}
if test $code -eq 75 || test $code -ge 128; then
    sleep 1 # tee may be behind
    if got_on; then
        echo "stopped with $code, requeued: scontrol requeue ${SLURM_JOB_ID:-?}"
        scontrol requeue "$SLURM_JOB_ID"
        exit 75
    fi
    echo "stopped with $code before it wrote a checkpoint, not requeued: if its time was over, --time is too short"
fi
exit $code
