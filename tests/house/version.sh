#!/bin/sh
# The version is set in CMakeLists.txt. The program, the manual page, the Debian package and the Python package take the
# version from there. The files below cannot, and must state the same one: version.sh VERSION.
# SPDX-License-Identifier: MIT
set -eu
status=0
same() # FILE, WHAT, its value, the value that is expected
{
    test "$3" = "$4" || { echo "$1: $2 is '$3' (expected '$4')"; status=1; }
}
notes=samples/manual/release-notes.md
latest=$(sed -n 's/^## //p' "$notes" | head -n 1) # "0.2.0 (2026-11-29)"
same "$notes" "the latest version" "${latest%% *}" "$1"
same CITATION.cff version "$(sed -n 's/^version: *//p' CITATION.cff)" "$1"
same CITATION.cff date-released "($(sed -n 's/^date-released: *//p' CITATION.cff))" "${latest#* }"
same src/cli/install/recipe.yaml version "$(sed -n 's/^  version: \([0-9.]*\)$/\1/p' src/cli/install/recipe.yaml)" "$1"
same src/cli/install/codemeta.json version "$(sed -n 's/^  "version": "\(.*\)",$/\1/p' src/cli/install/codemeta.json)" "$1"
test -d "tests/files/compat/$1" || { echo "tests/files/compat/$1: is missing (make.sh there says how to make it)"; status=1; }
grep -q 'project\\(clustermcml VERSION' pyproject.toml || { echo "pyproject.toml: takes no version from CMakeLists.txt"; status=1; }
exit $status
