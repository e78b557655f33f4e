#!/bin/sh
# Checks that C, C++ and OpenCL C are formatted by clang-format 14 (Debian 12) with the .clang-format of this repository.
# Other versions format macros differently.
# SPDX-License-Identifier: MIT
set -eu
command -v clang-format >/dev/null || { echo "clang-format is missing"; exit 77; }
case $(clang-format --version) in
*" version 14."*) ;;
*) echo "clang-format is not version 14: $(clang-format --version)"; exit 77 ;;
esac
find src kernels tests bench \( -name '*.c' -o -name '*.h' -o -name '*.cpp' -o -name '*.cl' \) -print0 |
    xargs -0 clang-format --dry-run -Werror
