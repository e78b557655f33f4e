#!/bin/sh
# Installs the package by pip into clean virtual environments, with every Python from 3.9 on that this machine has. Then
# five lines of Python draw a picture, and the first reader of samples/output.md runs, which needs nothing else. The
# notebook of samples runs from first to last cell. Skipped without a package registry.
# SPDX-License-Identifier: MIT
set -u
here=$PWD
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
tried=0
for python in python3.9 python3.10 python3.11 python3.12 python3.13; do
    $python -c "" 2>/dev/null || continue
    $python -m venv "$work/$python" || { echo "$python makes no virtual environment"; continue; }
    pip="$work/$python/bin/pip"
    $pip download --quiet --no-deps --dest "$work" scikit-build-core >/dev/null 2>&1 || { echo "no package registry"; exit 77; }
    $pip install --quiet . matplotlib nbconvert ipykernel || { echo "$python: pip install . failed"; exit 1; }
    (cd "$work" && "$work/$python/bin/python" -c '
import clustermcml as mc
skin = mc.Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1, top=mc.Heightfield(r=[0, 0.1], h=[0.02, 0]))
result = mc.run(mc.Scene([skin], photons=1e4))
result.Rd_r.plot()[0].figure.savefig("picture.png")
') && test -s "$work/picture.png" || { echo "$python: no picture"; exit 1; }
    "$work/$python/bin/clustermcml" --version | grep -q '^clustermcml ' || { echo "$python: no program"; exit 1; }
    sed -n '/^```python$/,/^```$/p' samples/output.md | sed -e 1d -e '/^```$/,$d' >"$work/reader.py"
    "$work/$python/bin/clustermcml" samples/skinmap.mci --photons 2e4 --quiet -o "$work" || exit 1
    (cd "$work" && "$work/$python/bin/python" reader.py) || { echo "$python: no result read"; exit 1; }
    cp "$here/samples/notebook.ipynb" "$work" # what it writes lies beside it
    (cd "$work" && "$work/$python/bin/jupyter" nbconvert --execute --to html notebook.ipynb >"$work/said" 2>&1) ||
        { cat "$work/said"; echo "$python: the notebook failed"; exit 1; }
    test "$(grep -c 'data:image/png' "$work/notebook.html")" -ge 4 || { echo "$python: a notebook without pictures"; exit 1; }
    CLUSTERMCML="$work/$python/bin/clustermcml" "$work/$python/bin/python" tests/python/commands.py Meshes || exit 1
    echo "$python: installed, flown, drawn"
    rm "$work/picture.png"
    tried=1
done
test $tried -eq 1 || { echo "no Python from 3.9 on"; exit 77; }
