#!/bin/sh
# Tests that a machine without the packages for building is told all of them at once, and the ways to get them.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
without="-DCMAKE_DISABLE_FIND_PACKAGE_embree=ON -DCMAKE_DISABLE_FIND_PACKAGE_ZLIB=ON"
cmake -S . -B "$work/build" -DCLUSTERMCML_TESTS=OFF $without >"$work/out" 2>"$work/err" && complain "configured without Embree and zlib"
said=$(tr -s '\n ' '  ' <"$work/err")
case $said in
*"clustermcml needs Embree 3.12 or later, zlib: "*samples/packages.sh*samples/wheel.sh*conda-forge*) ;;
*) complain "$said" ;;
esac
test "$(grep -c 'CMake Error' "$work/err")" -eq 1 || complain "more than one error: $said"
finish
