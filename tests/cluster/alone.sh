#!/bin/sh
# Tests a build without MPI (-DCLUSTERMCML_MPI=OFF, in CLUSTERMCML_ALONE): the same bits, checkpoints and resume. It refuses
# to run as several copies, which would all write the same files; srun without PMI starts such copies of any build. Beside
# an adapter (CLUSTERMCML_ADAPTER) it finds MPI at run time. run.sh passes the thread sanitizer's build, by another
# compiler, which is slow; hence few packets.
# SPDX-License-Identifier: MIT
. tests/lib/cluster.sh
alone=${CLUSTERMCML_ALONE:?names no program}
scene=samples/shapes/hinoise.mci

expect_code 0 $scene --photons 5e3 --quiet -o "$work"
mv "$work/hinoise.mco" "$work/expected"
fly_alone="to fly in one process: env -u"
(
    export SLURM_NTASKS=4 SLURM_STEP_NUM_TASKS=4
    expect_error 2 "a launcher started 4 processes (SLURM_STEP_NUM_TASKS=4), but each sees only itself (expected the launcher of the MPI library that this program uses, or srun --mpi=pmix); $fly_alone SLURM_STEP_NUM_TASKS clustermcml ..." $scene --photons 100 -o "$work"
    SLURM_STEP_NUM_TASKS=1
    expect_code 0 $scene --photons 100 --quiet -o "$work"
    unset SLURM_STEP_NUM_TASKS # within a batch script
    expect_code 0 $scene --photons 100 --quiet -o "$work"
    finish
) || complain "srun without PMI"
program=$alone
expect_code 0 $scene --photons 5e3 --quiet -o "$work" --threads 2
sed '/^# clustermcml/d' "$work/hinoise.mco" >"$work/a"
sed '/^# clustermcml/d' "$work/expected" >"$work/b"
expect_bits "without MPI" "$work/a" "$work/b"
ranks 1 $scene --photons 5e3 --quiet -o "$work" || complain "one copy under mpiexec"
# Every copy prints the message unless mpiexec ends it first, before or within its line. Each has a file of its own, because
# mpiexec may mix two messages; a line without an end is left out.
code=0
mpiexec -n 2 $mpi_options sh -c 'exec "$0" "$1" 2>"$2/copy.$$"' "$program" $scene "$work" >"$work/out" 2>&1 </dev/null || code=$?
test $code -eq 2 || complain "two copies without MPI: exit $code"
said=$(for copy in "$work"/copy.*; do while read -r line; do echo "$line"; done <"$copy"; done | sort -u)
adapter=$(dirname "$(realpath "$program")")/cluster_openmpi.so
mpiexec --version | grep -q 'Open MPI\|OpenRTE' || adapter=${adapter%openmpi.so}mpich.so
case $said in
"clustermcml: a launcher started 2 processes ("*"_SIZE=2), but $adapter is missing (an adapter: clustermcml help adapter); $fly_alone "*_SIZE" clustermcml ...") ;;
*) complain "two copies without an adapter said: $said" ;;
esac
(
    export PMI_SIZE=2 CLUSTERMCML_MPI_LIBRARY=/nope
    expect_error 3 "CLUSTERMCML_MPI_LIBRARY: /nope: cannot open shared object file: No such file or directory" $scene
    unset CLUSTERMCML_MPI_LIBRARY
    # libraries that cannot be opened stand for none
    mkdir "$work/none"
    why=
    for name in libmpi.so.12 libmpich.so.12 libmpi_abi.so.1 libmpi_abi.so.0 libmpi.so.40; do
        : >"$work/none/$name"
        why="$why${why:+; }$work/none/$name: file too short"
    done
    export LD_LIBRARY_PATH="$work/none"
    expect_error 2 "a launcher started 2 processes (PMI_SIZE=2), but no MPI library was found ($why; expected one on the search path, or CLUSTERMCML_MPI_LIBRARY=FILE); $fly_alone PMI_SIZE clustermcml ..." $scene
    finish
) || complain "no MPI library"
# Commands that do not fly need no MPI. `check` counts the memory that its process holds, so its rounded
# number may be another one under mpiexec.
printed() { sed 's/^\(  memory: at most\) [0-9.]* MiB/\1 N MiB/' "$1"; } # FILE
for any in "$alone" "$CLUSTERMCML"; do
    for words in --version "help beam" "help adapter" "check $scene" "exact samples/fig5.mci" devices "merge --help" "run --help"; do
        PMI_SIZE=2 "$any" $words >"$work/out" 2>&1 </dev/null || complain "PMI_SIZE=2 $any $words: $(cat "$work/out")"
    done
    for words in --version "check samples/fig5.mci" "exact samples/fig5.mci"; do
        "$any" $words >"$work/expected.txt"
        mpiexec -n 2 $mpi_options "$any" $words >"$work/out" 2>&1 </dev/null &&
            test "$(printed "$work/out")" = "$(printed "$work/expected.txt")" ||
            complain "two copies of $any $words: $(cat "$work/out")"
    done
done

if test -n "${CLUSTERMCML_ADAPTER:-}"; then
    mkdir "$work/bin"
    cp "$alone" "$work/bin/program"
    cp "$CLUSTERMCML_ADAPTER" "$work/bin"
    program=$work/bin/program
    ranks 2 $scene --photons 5e3 -o "$work" >"$work/out" 2>&1 </dev/null || complain "two ranks with an adapter: $(cat "$work/out")"
    grep -q '2 ranks' "$work/out" || complain "an adapter was not used: $(cat "$work/out")"
    sed '/^# clustermcml/d' "$work/hinoise.mco" >"$work/a"
    expect_bits "with an adapter" "$work/a" "$work/b"
    export CLUSTERMCML_MPI_LIBRARY=libno.so
    expect_ranks_error 1 3 "CLUSTERMCML_MPI_LIBRARY: libno.so: cannot open shared object file: No such file or directory" $scene -o "$work"
    unset CLUSTERMCML_MPI_LIBRARY
    adapter=$work/bin/${CLUSTERMCML_ADAPTER##*/}
    sed -i 's/0\.[0-9]\.0 /0.0.0 /' "$adapter"
    ranks 1 $scene -o "$work" >"$work/out" 2>&1 </dev/null && complain "an adapter of another build was used"
    grep -q "^clustermcml: $adapter: is of build 0.0.0 .* (expected build .*: install both together)$" "$work/out" ||
        complain "an adapter of another build: $(cat "$work/out")"
fi
program=$alone

rm -f "$work"/thick*
expect_code 0 samples/thick.mci --photons 1e5 --quiet -o "$work"
mv "$work/thick.mco" "$work/expected"
"$program" samples/thick.mci --photons 1e5 -o "$work" >"$work/out" 2>&1 &
run=$!
until grep -qs '^  boundary 1' "$work/out" || ! kill -0 $run; do sleep 0.02; done
kill -TERM $run
code=0
wait $run || code=$?
test $code -eq 75 || complain "stopped without MPI: exit $code"
expect_code 0 samples/thick.mci --photons 1e5 --quiet --resume -o "$work"
expect_bits "resumed without MPI" "$work/thick.mco" "$work/expected"
finish
