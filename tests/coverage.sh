#!/bin/bash
# Prints which code the tests execute: coverage.sh [ARGUMENTS FOR CTEST], which are -LE 'long|house' by default.
# Builds with clang's coverage and assertions in build-coverage, runs the tests, and prints lines and branches by room. Lines
# that no test executed are listed in build-coverage/gaps.txt. Exit code 1 if a room is below 95 % of its lines or a test
# fails. Needs llvm-cov besides the needs of tests/run.sh, and about half an hour on 2 cores.
# Counters lie in files that processes share as memory, so killed processes count, too. Code executed by an OpenCL device does
# not count; the same source text counts where it flies on the processor.
# SPDX-License-Identifier: MIT
set -eu
cd "$(dirname "$0")/.."
for tool in clang llvm-profdata llvm-cov; do
    command -v $tool >/dev/null || { echo "$tool is missing (Debian: clang, llvm)"; exit 77; }
done
CC=clang CXX=clang++ cmake --preset coverage -DCLUSTERMCML_TESTS=ON >/dev/null
build=$PWD/build-coverage
cmake --build "$build" --parallel 2 >"$build/build.log" 2>&1 || { cat "$build/build.log"; exit 1; }

test $# -gt 0 || set -- -LE 'long|house'
rm -rf "$build/raw"
mkdir "$build/raw"
failed=0
LLVM_PROFILE_FILE="$build/raw/%m%c.profraw" ctest --test-dir "$build" -j2 "$@" >"$build/ctest.log" 2>&1 || failed=1
sed -n '/% tests passed/,$p' "$build/ctest.log"

llvm-profdata merge -sparse "$build"/raw/*.profraw -o "$build/all.profdata"
programs=()
while read -r program; do
    programs+=(-object "$program")
done < <(find "$build" -maxdepth 2 -type f -perm -1 ! -path '*/CMakeFiles/*' ! -name '*.so' ! -name clustermcml | sort)
llvm-cov export -format=lcov -instr-profile "$build/all.profdata" "$build/clustermcml" "${programs[@]}" >"$build/lcov.txt"
python3 -B tests/coverage.py "$build/lcov.txt" "$build/gaps.txt" || failed=1
exit $failed
