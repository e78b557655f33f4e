#!/bin/sh
# Checks the pictures of the benches that texts show: no text crosses another one or leaves the picture, and the background is
# white, because a page may be dark.
# SPDX-License-Identifier: MIT
set -eu
exec python3 tests/lib/svg_text.py $(find bench -name "*.svg" | sort)
