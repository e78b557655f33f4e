#!/bin/sh
# Checks that every external symbol of the libraries begins with cml_, and those of clustermcml.h with clm_: prefix.sh LIBRARY...
# Symbols of C++ (the OBJ parser in obj_tiny.cpp) are mangled names and cannot clash with those of a C program.
# SPDX-License-Identifier: MIT
set -eu
command -v nm >/dev/null || { echo "nm is missing"; exit 77; }
test "$(nm -g --defined-only "$@" | grep -c ' [A-Z] cml_')" -gt 50 || { echo "no symbols in $*"; exit 1; }
bad=$(nm -g --defined-only "$@" | awk 'NF == 3 && $3 !~ /^(cml_|clm_|_Z|__odr_asan|DW\.ref\.)/ { print $3 }')
test -z "$bad" || { echo "external symbols without the prefix cml_:"; echo "$bad"; exit 1; }
