#!/bin/bash
# Checks everything that must hold before a change is good. Installs missing packages, builds with warnings as errors, and
# runs all tests but the long ones. Then runs the unit tests and all samples again under clang with the address and undefined
# behaviour sanitizers, the engines' threads under the thread sanitizer, each fuzzer for some seconds, and the program without
# MPI. Takes some 25 minutes on two free cores.
#
#     sh tests/run.sh          all of these
#     sh tests/run.sh NAME     builds, and runs the tests of one label (unit, cli, stat ...) or one test (unit.mci)
# SPDX-License-Identifier: MIT
set -eu
case ${1:-} in -*) sed -n '2,/^# SPDX/{/^# SPDX/!s/^# \{0,1\}//p;}' "$0"; exit 0 ;; esac
root=$(cd "$(dirname "$0")/.." && pwd)
cd "$root"
begun=$(date +%s)
now() { # WHAT: says when it begins
    echo "tests/run.sh, after $(($(date +%s) - begun)) s: $1"
}
now "packages of the build"
sh samples/packages.sh build
# A new build folder is one of Ninja, which asks the compiler alone: make starts five programs more for each of 150 targets.
export CMAKE_GENERATOR="${CMAKE_GENERATOR:-Ninja}"
cmake -S . -B build -DCMAKE_BUILD_TYPE=Release -DCLUSTERMCML_WERROR=ON -DCLUSTERMCML_TESTS=ON >/dev/null
if test $# -gt 0; then
    sh samples/packages.sh test
    cmake --build build --parallel 2
    case $1 in *.*) by=-R ;; *) by=-L ;; esac
    exec ctest --test-dir build $by "^$1\$" --no-tests=error --output-on-failure -j2
fi

# Installing takes one core: five in six packages, which the tests alone need, are installed beside the build.
now "the build and packages of the tests"
sh samples/packages.sh test >build/packages.log 2>&1 &
packages=$!
cmake --build build --parallel 2
wait $packages || { cat build/packages.log; exit 1; }

# Tests wait for files and for one another: the sanitizers' builds run in these gaps.
CC=clang CXX=clang++ cmake --preset asan >/dev/null
CC=clang CXX=clang++ cmake --preset tsan -DCLUSTERMCML_TESTS=ON >/dev/null
{
    nice -n 19 cmake --build build-asan --parallel 2 --target clustermcml units fuzzers >build-asan/build.log 2>&1 &&
        nice -n 19 cmake --build build-tsan --parallel 2 --target clustermcml unit_work >build-tsan/build.log 2>&1
} &
sanitized=$!
# pocl compiles each kernel twice, for any size of groups and for the size of the flight; the first one is enough.
export POCL_WORK_GROUP_SPECIALIZATION=0
now tests
ctest --test-dir build -LE long --output-on-failure -j4
now "the rest of the sanitizers' build"
wait $sanitized || { cat build-asan/build.log build-tsan/build.log; exit 1; }
export LSAN_OPTIONS=suppressions=$root/tests/lsan.supp:print_suppressions=0

# Fuzzers run for a number of executions, not a time, so that a change is judged by the same inputs on any machine. They run
# beside units and flights, as each fuzzer has one thread.
bash tests/fuzz/run.sh runs=50000 fly:4000 mci obj stl ply heightmap options checkpoint sweep mco:1250 &
fuzzers=$!
now "sanitized units and fuzzers"
ctest --test-dir build-asan -L unit --output-on-failure -j2
now "sanitized samples"
CLUSTERMCML=$root/build-asan/clustermcml sh tests/sanitize/samples.sh
now "threads under their sanitizer"
sh tests/sanitize/threads.sh
now "the rest of the fuzzers"
wait $fuzzers

# The program of the thread sanitizer is built without MPI.
export TSAN_OPTIONS=ignore_noninstrumented_modules=1
now "a build without MPI"
CLUSTERMCML=$root/build/clustermcml CLUSTERMCML_ALONE=$root/build-tsan/clustermcml sh tests/cluster/alone.sh
now "the end"
