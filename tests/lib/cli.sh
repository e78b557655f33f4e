# Parts that the tests of the command line share. Source this file with the source directory as the current one.
# $program is the program, $work an empty directory that vanishes when the test ends.
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

# Runs the program and checks that its exit code is CODE. Output goes to $work/out and $work/err.
expect_code() { # CODE ARGUMENTS...
    wanted=$1
    shift
    code=0
    "$program" "$@" >"$work/out" 2>"$work/err" </dev/null || code=$?
    test "$code" -eq "$wanted" || complain "clustermcml $*: exit $code, not $wanted: $(cat "$work/err")"
}

# Runs the program and checks that its exit code is CODE, and that standard error is exactly "clustermcml: MESSAGE".
expect_error() { # CODE MESSAGE ARGUMENTS...
    wanted=$1
    message=$2
    shift 2
    expect_code "$wanted" "$@"
    test "$(cat "$work/err")" = "clustermcml: $message" || complain "clustermcml $*: $(cat "$work/err")"
    test ! -s "$work/out" || complain "clustermcml $*: wrote to standard output"
}

# From here on, Python commands run in children of one process that has its libraries already (see warm_python.py).
# $cold_python is a Python that starts anew. Skips the test if libraries are missing.
warm_python() {
    cold_python=${CLUSTERMCML_PYTHON:-/usr/bin/python3}
    warm=$(mktemp -d)
    "$cold_python" -B tests/lib/warm_python.py serve "$warm/socket" >"$warm/out" &
    warm_server=$!
    trap 'kill $warm_server; wait $warm_server; rm -rf "$warm" "$work"' EXIT
    until test -e "$warm/socket"; do
        kill -0 $warm_server 2>/dev/null || { cat "$warm/out"; wait $warm_server; code=$?; trap 'rm -rf "$warm" "$work"' EXIT; exit $code; }
        sleep 0.05
    done
    printf '#!/bin/sh\nexec "%s" -IS "%s" call "%s" "$@"\n' "$cold_python" "$PWD/tests/lib/warm_python.py" "$warm/socket" >"$warm/python"
    chmod +x "$warm/python"
    export CLUSTERMCML_PYTHON="$warm/python"
}

# Checks that no two texts overlap in the pictures of $work.
check_texts() {
    set --
    for picture in "$work"/*.svg; do
        if grep -q '<svg' "$picture"; then set -- "$@" "$picture"; fi
    done
    python3 tests/lib/svg_text.py "$@" >"$work/texts" 2>&1 || complain "$(cat "$work/texts")"
}

finish() {
    test "$failures" -eq 0 || exit 1
}

# Prints an .mco file, and after it, as sections, the arrays that only the .h5 beside it has. Errors are se_NAME.
whole() { # FILE
    "${CLUSTERMCML_PYTHON:-/usr/bin/python3}" -B tests/lib/cml.py "$1"
}
