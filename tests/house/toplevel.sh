#!/bin/sh
# Checks that the top level holds these names and dotfiles, and nothing else.
# SPDX-License-Identifier: MIT
set -eu
allowed=" CMakeLists.txt CMakePresets.json README.md LICENSE CONTRIBUTING.md CITATION.cff pyproject.toml src kernels meshes samples tests bench "
git rev-parse --is-inside-work-tree >/dev/null 2>&1 || { echo "not a git checkout"; exit 77; }
status=0
for name in $(git ls-files | cut -d/ -f1 | sort -u); do
    case $name in .*) continue ;; esac
    case $allowed in *" $name "*) ;; *) echo "$name: not at the top level"; status=1 ;; esac
done
exit $status
