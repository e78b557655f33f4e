#!/bin/sh
# C, C++ and OpenCL C as clang-format writes it with the .clang-format of this repository.
# SPDX-License-Identifier: MIT
set -eu
command -v clang-format >/dev/null || { echo "clang-format is missing"; exit 77; }
find src kernels tests bench \( -name '*.c' -o -name '*.h' -o -name '*.cpp' -o -name '*.cl' \) -print0 |
    xargs -0 clang-format --dry-run -Werror
