#!/bin/sh
# Tests ranks with OpenCL devices, which give the same bytes as one rank. crosscheck compares in one process only.
# SPDX-License-Identifier: MIT
. tests/lib/cluster.sh
expect_code 0 devices
grep -q '^0\*\? ' "$work/out" || { echo "no OpenCL device"; exit 77; }
expect_code 0 samples/shapes/hinoise.mci --photons 5000 --engine opencl --quiet -o "$work"
mv "$work/hinoise.mco" "$work/expected"
ranks 2 samples/shapes/hinoise.mci --photons 5000 --engine opencl --quiet -o "$work" || complain "opencl on 2 ranks"
expect_bits "opencl on 2 ranks" "$work/hinoise.mco" "$work/expected"
expect_ranks_error 2 2 "crosscheck: 2 ranks (expected one process)" crosscheck samples/fig5.mci --photons 100
finish
