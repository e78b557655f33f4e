# Parts that the tests of several ranks share, beside lib/cli.sh. `ranks N ARGUMENTS...` runs the program on N ranks,
# which may be more than there are cores.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
command -v mpiexec >/dev/null || { echo "mpiexec is missing"; exit 77; }
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_WAIT_POLICY=passive
mpi_options=
mpiexec --version | grep -q 'Open MPI\|OpenRTE' && mpi_options="--oversubscribe --bind-to none --mca odls_base_sigkill_timeout 0"

ranks() { # N ARGUMENTS...
    number=$1
    shift
    mpiexec -n "$number" $mpi_options "$program" "$@"
}

# Runs N ranks and checks that the exit code is CODE, and that the program said exactly one line, "clustermcml:
# MESSAGE".
expect_ranks_error() { # N CODE MESSAGE ARGUMENTS...
    number=$1 wanted=$2 message=$3
    shift 3
    code=0
    ranks "$number" "$@" >"$work/out" 2>"$work/err" </dev/null || code=$?
    test "$code" -eq "$wanted" || complain "$number ranks, $*: exit $code, not $wanted"
    test "$(grep '^clustermcml' "$work/err")" = "clustermcml: $message" || complain "$number ranks, $*: $(cat "$work/err")"
}

# Prints a hash of an .mco file without its line of time.
bits() { # FILE
    grep -av '^# User time' "$1" | sha256sum
}

expect_bits() { # WHAT FILE EXPECTED
    test "$(bits "$2")" = "$(bits "$3")" || complain "$1: other bits"
}
