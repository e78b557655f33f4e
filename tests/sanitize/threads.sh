#!/bin/sh
# Runs the engines cpu and reference under clang's thread sanitizer, with more threads than cores and pieces so small that
# threads meet often.
# Tested are plain runs, maps and facets, rounds of --target-error, threads bound to cores, stops by a signal and continued
# runs. Builds in build-tsan, without MPI and OpenCL, which are not instrumented; neither is HDF5, which only one thread
# calls. Left out: the threads of MPI, and crosscheck, whose loop uses OpenMP, because OpenMP's runtime is not instrumented
# either.
# SPDX-License-Identifier: MIT
set -eu
cd "$(dirname "$0")/../.."
command -v clang >/dev/null || { echo "clang is missing"; exit 77; }
CC=clang CXX=clang++ cmake --preset tsan -DCLUSTERMCML_TESTS=ON >/dev/null
cmake --build build-tsan --parallel 2 --target clustermcml unit_work
CLUSTERMCML=$PWD/build-tsan/clustermcml
set +e
. tests/sanitize/lib.sh
export TSAN_OPTIONS="halt_on_error=1:exitcode=66:ignore_noninstrumented_modules=1"
export OMP_PLACES=threads
busy="--threads 4 --chunk 16"

(cd tests && ../build-tsan/tests/unit_work) >"$work/out" 2>&1 || complain "unit.work: $(cat "$work/out")"

for sample in samples/thick.mci samples/two_runs.mci samples/wedge.mci samples/skinmap.mci samples/shapes/hinoise.mci; do
    for kind in auto mesh; do
        expect_sound "$sample" $busy --photons 4000 --boundaries $kind
        expect_sound "$sample" $busy --photons 1000 --boundaries $kind --engine reference
    done
    expect_sound "$(with_maps A "$sample")" $busy --photons 4000
    expect_sound "$(with_maps A "$sample")" $busy --photons 1000 --engine reference
done
for engine in cpu reference; do
    expect_sound samples/mcml_sample.mci $busy --engine $engine --photons 100 --target-error 0.05
    OMP_PROC_BIND=spread expect_sound samples/thick.mci $busy --engine $engine --photons 1000
done

# A run is stopped twice by a signal once there is a checkpoint: the second run begins with the checkpoint of the first one.
for engine in cpu reference; do
    for resume in "" --resume; do
        before=$(stat -c %i "$work/thick.mco.checkpoint" 2>&1)
        "$CLUSTERMCML" samples/thick.mci $busy --engine $engine --photons 1e9 --checkpoint 0.1 $resume -o "$work" \
            >"$work/out" 2>"$work/err" &
        run=$!
        until test "$(stat -c %i "$work/thick.mco.checkpoint" 2>&1)" != "$before" || ! kill -0 $run; do sleep 0.05; done
        kill -TERM $run
        code=0
        wait $run || code=$?
        test $code -eq 75 || complain "$engine, stopped: exit $code: $(cat "$work/err")"
    done
    rm "$work/thick.mco.checkpoint"
done
echo "$flights flights"
finish
