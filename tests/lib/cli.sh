# What the tests of the command line share. Source it with the source directory as the current one; $program is the
# program, $work an empty directory that goes when the test ends.
# SPDX-License-Identifier: MIT
set -u
program=${CLUSTERMCML:-$PWD/build/clustermcml}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0

complain() { # TEXT
    echo "FAILED: $1"
    failures=$((failures + 1))
}

# Runs the program; its exit code must be CODE. Output goes to $work/out and $work/err.
expect_code() { # CODE ARGUMENTS...
    wanted=$1
    shift
    code=0
    "$program" "$@" >"$work/out" 2>"$work/err" </dev/null || code=$?
    test "$code" -eq "$wanted" || complain "clustermcml $*: exit $code, not $wanted: $(cat "$work/err")"
}

# The same, and the whole of standard error must be "clustermcml: MESSAGE".
expect_error() { # CODE MESSAGE ARGUMENTS...
    wanted=$1
    message=$2
    shift 2
    expect_code "$wanted" "$@"
    test "$(cat "$work/err")" = "clustermcml: $message" || complain "clustermcml $*: $(cat "$work/err")"
    test ! -s "$work/out" || complain "clustermcml $*: wrote to standard output"
}

# From now on a stand-in for gnuplot keeps the script that it is given in $work/script, and draws nothing.
keep_gnuplot_script() {
    mkdir "$work/bin"
    printf '#!/bin/sh\ncat >"%s"\necho picture\n' "$work/script" >"$work/bin/gnuplot"
    chmod +x "$work/bin/gnuplot"
    PATH=$work/bin:$PATH
}

# Pictures in $work that gnuplot itself drew must have no two texts at one place.
check_texts() {
    for picture in "$work"/*.svg; do
        grep -q '<svg' "$picture" || continue
        python3 tests/lib/svg_text.py "$picture" >"$work/texts" 2>&1 || complain "$(cat "$work/texts")"
    done
}

finish() {
    test "$failures" -eq 0 || exit 1
}
