#!/bin/sh
# In the pictures of the benches, which the texts show, no text runs through another or leaves the picture,
# and all stands on white: a page may be dark.
# SPDX-License-Identifier: MIT
set -eu
exec python3 tests/lib/svg_text.py $(find bench -name "*.svg" | sort)
