#!/bin/sh
# Runs cross.opencl on a second implementation, Intel's OpenCL for CPUs, whose division and square root are not
# correctly rounded. The implementation is installed from the Python package registry into a folder that vanishes with
# the test (0.7 GB). Skipped without a registry. Called with the test program.
# SPDX-License-Identifier: MIT
set -u
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv" && "$work/venv/bin/pip" install --quiet intel-opencl-rt intel-cmplr-lib-rt >"$work/log" 2>&1 ||
    { echo "Intel's OpenCL cannot be installed: $(tail -n 1 "$work/log")"; exit 77; }
runtime=$work/venv/lib
loader=$(ldd "$1" | sed -n 's/.*libOpenCL.so.1 => \([^ ]*\).*/\1/p')
test -f "$runtime/libintelocl.so" && test -f "$loader" || { echo "no libintelocl.so in the package, or no loader"; exit 77; }
# Intel's own libraries come first, except its loader, which does not look into a folder of implementations.
mkdir "$work/loader" "$work/vendors"
ln -s "$loader" "$work/loader/libOpenCL.so.1"
echo "$runtime/libintelocl.so" >"$work/vendors/intel.icd"
OCL_ICD_VENDORS=$work/vendors LD_LIBRARY_PATH=$work/loader:$runtime "$1" >"$work/out" 2>&1
code=$?
cat "$work/out"
test $code -ne 77 || { echo "Intel's OpenCL shows no device"; exit 1; }
exit $code
