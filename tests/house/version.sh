#!/bin/sh
# The version stands in CMakeLists.txt, from where program, manual page and package have it. CITATION.cff cannot read it
# there, and has the same: version.sh VERSION.
# SPDX-License-Identifier: MIT
set -eu
cited=$(sed -n 's/^version: *//p' CITATION.cff)
test "$cited" = "$1" || { echo "CITATION.cff has version $cited, CMakeLists.txt $1"; exit 1; }
