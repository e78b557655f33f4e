#!/bin/bash
# Builds the fuzzers and runs them one after the other: run.sh TIME [TARGET ...]. TIME per target is like 30 (seconds), 90s,
# 10m or 2h, or a number of executions like runs=1000000. A target that is written TARGET:N gets N executions instead.
# Prints one line per target. Exit code 1 if a fuzzer crashed, hung or leaked; its input is then kept below build-asan/found.
# The seed is 1 unless FUZZ_SEED is set. With one seed and a number of executions the inputs are the same each time; with a
# time, their number varies.
# SPDX-License-Identifier: MIT
set -eu
cd "$(dirname "$0")/../.."
root=$PWD
build=$root/build-asan
usage="usage: tests/fuzz/run.sh SECONDS|TIME{s,m,h}|runs=N [TARGET[:N] ...]"
limit=${1:?$usage}
shift
all="mci fly obj heightmap mco options checkpoint sweep"
targets=${*:-$all}
case $limit in
    runs=*) limit=-$limit ;;
    *h) limit=-max_total_time=$((${limit%h} * 3600)) ;;
    *m) limit=-max_total_time=$((${limit%m} * 60)) ;;
    *) limit=-max_total_time=$((${limit%s})) ;;
esac
command -v clang >/dev/null || { echo "clang is missing"; exit 77; }

test -e "$build/CMakeCache.txt" || CC=clang CXX=clang++ cmake --preset asan >/dev/null
cmake --build "$build" --parallel 2 --target clustermcml fuzzers >"$build/build.log" 2>&1 || { cat "$build/build.log"; exit 1; }

# A small quarantine: freed blocks stay poisoned for long enough, and memory stays in the cache.
export ASAN_OPTIONS=quarantine_size_mb=8:malloc_context_size=8:allocator_may_return_null=1:detect_leaks=1
export UBSAN_OPTIONS=print_stacktrace=1
export LSAN_OPTIONS=suppressions=$root/tests/lsan.supp:print_suppressions=0
export OMP_NUM_THREADS=1

# Files are written to memory, if there is such a folder.
memory=/tmp
[ -w /dev/shm ] && memory=/dev/shm
FUZZ_FOLDER=$(mktemp -d "$memory/cml_fuzz_XXXXXX")
export FUZZ_FOLDER
trap 'rm -rf "$FUZZ_FOLDER"' EXIT

rm -rf "$build/seeds"
sh tests/fuzz/corpus.sh "$build/clustermcml" "$build/seeds"
mkdir -p "$build/found"

number() { sed -n "s/^stat::$1: *//p" "$2"; }

failed=0
for word in $targets; do
    target=${word%:*} most_runs=
    [ "$word" = "$target" ] || most_runs=-runs=${word#*:}
    log=$build/found/$target.log
    rm -rf "$build/grown/$target"
    mkdir -p "$build/grown/$target"
    most=4096 # bytes; only what must hold a grid or a mesh is longer
    case $target in mci | fly | mco) most=8192 ;; esac
    code=0
    "$build/tests/fuzz/fuzz_$target" -seed="${FUZZ_SEED:-1}" "${most_runs:-$limit}" -max_len=$most -timeout=20 -rss_limit_mb=2048 \
        -dict="tests/fuzz/$target.dict" -print_final_stats=1 -artifact_prefix="$build/found/$target-" \
        "$build/grown/$target" "$build/seeds/$target" >"$log" 2>&1 || code=$?
    crashes=$(grep -c '^artifact_prefix=' "$log" || true)
    cover=$(sed -n 's/.* cov: \([0-9]*\) ft: .*/\1/p' "$log" | tail -n 1)
    printf '%-10s %9s executions, %6s a second, %5s edges covered, %5s new inputs, %s crashes\n' "$target" \
        "$(number number_of_executed_units "$log")" "$(number average_exec_per_sec "$log")" "${cover:-0}" \
        "$(number new_units_added "$log")" "$crashes"
    [ "$code" -eq 0 ] && continue
    failed=1
    grep -E 'ERROR|SUMMARY|runtime error|does not hold|Test unit written' "$log" | head -n 5
done
exit $failed
