#!/bin/sh
# C, C++ and OpenCL C as clang-format 14 (Debian 12) writes it with the .clang-format of this repository. Other versions
# write macros otherwise.
# SPDX-License-Identifier: MIT
set -eu
command -v clang-format >/dev/null || { echo "clang-format is missing"; exit 77; }
case $(clang-format --version) in
*" version 14."*) ;;
*) echo "clang-format is not version 14: $(clang-format --version)"; exit 77 ;;
esac
find src kernels tests bench \( -name '*.c' -o -name '*.h' -o -name '*.cpp' -o -name '*.cl' \) -print0 |
    xargs -0 clang-format --dry-run -Werror
