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

# Skips the test where Python lacks what pictures and comparisons need.
need_package() {
    "${CLUSTERMCML_PYTHON:-python3}" -c "import h5py, matplotlib, xarray" 2>/dev/null || { echo "python3 lacks h5py, matplotlib or xarray"; exit 77; }
}

# Pictures in $work must have no two texts at one place.
check_texts() {
    for picture in "$work"/*.svg; do
        grep -q '<svg' "$picture" || continue
        python3 tests/lib/svg_text.py "$picture" >"$work/texts" 2>&1 || complain "$(cat "$work/texts")"
    done
}

finish() {
    test "$failures" -eq 0 || exit 1
}

# An .mco file, and behind it as sections, errors as se_NAME, what only the .h5 beside it has.
whole() { # FILE
    "${CLUSTERMCML_PYTHON:-/usr/bin/python3}" -B tests/lib/cml.py "$1"
}
