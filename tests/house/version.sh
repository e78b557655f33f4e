#!/bin/sh
# Checks that CITATION.cff has the version of CMakeLists.txt: version.sh VERSION. Program, manual page and package take the
# version from CMakeLists.txt; CITATION.cff cannot.
# SPDX-License-Identifier: MIT
set -eu
cited=$(sed -n 's/^version: *//p' CITATION.cff)
test "$cited" = "$1" || { echo "CITATION.cff has version $cited, CMakeLists.txt $1"; exit 1; }
