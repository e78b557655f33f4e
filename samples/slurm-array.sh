#!/bin/bash
# Runs one run, or one sweep, as a job array. Every task simulates its part of the photons (--part) into DIR, with
# checkpoints, and is requeued until it is done. A second call joins the parts, with the same bytes as those of one run.
#     sbatch --array=1-8 samples/slurm-array.sh DIR scene.mci --sweep table.csv [options of clustermcml]
#     sh samples/slurm-array.sh DIR                   in a job of its own, in the same folder, when all tasks are done
# If a part is missing or not finished, the call names it and writes nothing (exit code 2). Its task must then run
# again:
#     sbatch --array=3 --export=ALL,PARTS=8 samples/slurm-array.sh DIR scene.mci ...
# DIR/merged.json gets an object for each run or row, with totals and their errors. CLUSTERMCML names the program.
#SBATCH --job-name=clustermcml
#SBATCH --array=1-8
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=16
#SBATCH --time=04:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=USR2@120
# SPDX-License-Identifier: MIT
set -u
program=${CLUSTERMCML:-clustermcml}
directory=${1:?expected the folder of the study: slurm-array.sh DIR [scene.mci ...]}
shift

fail() {
    echo "slurm-array.sh: $1" >&2
    exit 2
}

# Without a scene, the parts are joined. Parts of other runs, and parts that exist twice, are refused.
if test $# -eq 0; then
    set -- "$directory"/*.part[0-9]*of*[0-9]
    test -e "$1" || fail "$directory: no parts (expected the files NAME.partKofN of the tasks)"
    "$program" merge "$@" --json >"$directory/merged.json.new" || exit
    mv "$directory/merged.json.new" "$directory/merged.json"
    exit
fi

export OMP_NUM_THREADS=${SLURM_CPUS_PER_TASK:-1}
parts=${PARTS:-$SLURM_ARRAY_TASK_COUNT}
trap : TERM USR2
said=$(mktemp 2>/dev/null || TMPDIR=. mktemp)
touch "$said.begun"
trap 'rm -f "$said" "$said.begun"' EXIT
srun --mpi=pmix --cpus-per-task="$OMP_NUM_THREADS" --kill-on-bad-exit=1 "$program" "$@" --part "$SLURM_ARRAY_TASK_ID/$parts" \
    -o "$directory" --resume 2> >(trap '' TERM USR2; exec tee "$said" >&2) &
step=$!
code=0
wait $step || code=$?
while kill -0 $step 2>/dev/null; do # a trapped signal ends wait, not the step
    wait $step
    code=$?
done

# The task is requeued, as in slurm.sh, if --resume would continue, or if it has left a new checkpoint.
if test $code -eq 75 || test $code -ge 128; then
    sleep 1 # tee may be behind
    if grep -q ' to fly; --resume continues' "$said" ||
        find -L "$directory" -name "*.part${SLURM_ARRAY_TASK_ID}of$parts" -newer "$said.begun" 2>/dev/null | grep -q .; then
        scontrol requeue "$SLURM_JOB_ID"
        exit 75
    fi
    echo "stopped with $code before it wrote a checkpoint, not requeued: if its time was over, --time is too short"
fi
exit $code
