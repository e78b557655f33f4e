#!/bin/sh
# The types of the Python package hold, by mypy's strict rules.
# SPDX-License-Identifier: MIT
command -v mypy >/dev/null || { echo "mypy is missing"; exit 77; }
cache=$(mktemp -d)
trap 'rm -rf "$cache"' EXIT
mypy --config-file pyproject.toml --cache-dir "$cache"
