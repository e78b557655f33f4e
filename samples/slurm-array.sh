#!/bin/bash
# A study as a job array: every task flies the same scene or sweep with a seed of its own, the task's number, into DIR/part-SEED,
# with checkpoints, and is requeued until it is done. Then the parts become one.
#     sbatch --array=1-8 samples/slurm-array.sh DIR scene.mci --sweep table.csv [options of clustermcml]
#     sh samples/slurm-array.sh DIR                   in a job of its own, when all tasks are done: all parts to DIR/*.mco and *.h5
# A part that lacks a result of another one is named, and nothing merged (exit code 2): it is flown again, or removed.
# DIR/merged.json gets an object a file, with totals and their errors. CLUSTERMCML names the program.
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

# Names of the results of all parts.
results() {
    find "$directory"/part-*/ -maxdepth 1 \( -name '*.mco' -o -name '*.h5' ! -name '*.sweep.h5' \) -exec basename {} \; | sort -u
}

# Every part has every result, and none that was begun is missing.
check_parts() {
    for part in "$directory"/part-*/; do
        test -d "$part" || fail "$directory: no parts (expected the folders part-SEED of the tasks)"
        results | while IFS= read -r name; do
            test -e "$part$name" || fail "$part$name: missing (expected the results of all parts)"
        done || exit
        for checkpoint in "$part"*.checkpoint; do
            begun=${checkpoint%.checkpoint}
            test ! -e "$checkpoint" || test -e "$begun" || test -e "${begun%.*}.h5" || fail "$begun: not finished (expected it done in all parts)"
        done
    done
    test -n "$(results)" || fail "$directory: no results in the parts (expected .mco or .h5 files)"
}

# No scene: the parts become one, result by result. Parts of other scenes, and seeds that are there twice, are refused.
if test $# -eq 0; then
    check_parts
    results | while IFS= read -r name; do
        "$program" merge "$directory"/part-*/"$name" -o "$directory/$name" --json || exit
    done >"$directory/merged.json"
    exit
fi

export OMP_NUM_THREADS=${SLURM_CPUS_PER_TASK:-1}
part=$directory/part-$SLURM_ARRAY_TASK_ID
mkdir -p "$part"
trap : TERM USR2
said=$(mktemp 2>/dev/null || TMPDIR=. mktemp)
touch "$said.begun"
trap 'rm -f "$said" "$said.begun"' EXIT
srun --mpi=pmix --cpus-per-task="$OMP_NUM_THREADS" --kill-on-bad-exit=1 "$program" "$@" --seed "$SLURM_ARRAY_TASK_ID" \
    -o "$part" --resume 2> >(trap '' TERM USR2; exec tee "$said" >&2) &
step=$!
code=0
wait $step || code=$?
while kill -0 $step 2>/dev/null; do # a trapped signal ends wait, not the step
    wait $step
    code=$?
done

# As in slurm.sh: requeued is what says that --resume continues, or has left a new checkpoint.
if test $code -eq 75 || test $code -ge 128; then
    sleep 1 # tee may be behind
    if grep -q ' to fly; --resume continues' "$said" ||
        find -L "$part" -name '*.checkpoint' -newer "$said.begun" 2>/dev/null | grep -q .; then
        scontrol requeue "$SLURM_JOB_ID"
        exit 75
    fi
    echo "stopped with $code before it wrote a checkpoint, not requeued: if its time was over, --time is too short"
fi
exit $code
