#!/bin/bash
# Runs a scene on a cluster with Slurm, without job arrays:  sbatch samples/slurm.sh scene.mci [options of clustermcml]
# The run writes checkpoints, stops when its time is over or it is preempted, and is requeued until it is done, as long
# as every attempt writes a checkpoint. CLUSTERMCML names the program.
#SBATCH --job-name=clustermcml
#SBATCH --nodes=2
#SBATCH --ntasks-per-node=2
#SBATCH --cpus-per-task=16
#SBATCH --time=04:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
# The signal goes to the ranks themselves, two minutes before the time is over. They write a checkpoint and return 75.
# Without the signal they do so at SIGTERM, which comes when the time is over; Slurm then waits KillWait (30 s).
#SBATCH --signal=USR2@120
# SPDX-License-Identifier: MIT
set -u
program=${CLUSTERMCML:-clustermcml}
# OMP_PLACES stays unset: if Slurm does not confine tasks to their cores, all ranks of a node would bind to its first
# ones.
export OMP_NUM_THREADS=${SLURM_CPUS_PER_TASK:-1}

# --resume begins anew without a checkpoint, so that the first attempt needs no other command. The shell only waits: a
# preempted batch script gets SIGTERM, which the ranks get too.
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

# Exit code 75 means that the run was stopped, and its last line says that --resume continues. A run that was stopped
# before it began does not say so, because requeuing would repeat this for ever. A launcher may return another code if
# it was itself told to stop, and a preempted job may be killed before it says anything. A checkpoint that is newer than
# this attempt then counts instead.
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
