#!/bin/sh
# Checks the types of the Python package by mypy's strict rules. mypy must also find the wrong calls below, options
# included. Types of libraries other than numpy are read only if the environment has ALL_CASES, because they double the
# time.
# SPDX-License-Identifier: MIT
command -v mypy >/dev/null || { echo "mypy is missing"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat >"$work/calls.py" <<'END'
import clustermcml as mc
mc.run("a.mci", photons=1e5, roulette=[0.003, 0.01], set={"layer1.mua": 1}, output_dir=".", threads=2)
mc.sweep("a.mci", {"layer1.mua": [1, 2]}, dim="row", engine="cpu")
mc.Mesh([[0, 0, 0]], [[0, 0, 0]])
mc.run("a.mci", photon=1)  # wrong
mc.run("a.mci", photons="many")  # wrong
mc.exact("a.mci", photons=1)  # wrong
mc.check("a.mci", engine="gpu")  # wrong
mc.Layer(n=1.4, mua=1, mus=100, g=0.9, d="thick")  # wrong
END
sed -n '/^\[tool.mypy\]/,$p' pyproject.toml >"$work/mypy.toml"
test -n "${ALL_CASES:-}" || printf '\n[[tool.mypy.overrides]]\nmodule = ["xarray.*", "pandas.*", "matplotlib.*", "scipy.*"]\nfollow_imports = "skip"\n' >>"$work/mypy.toml"
# One run of mypy checks the package and the calls, because most of the time goes into reading the types of libraries.
mypy --config-file "$work/mypy.toml" --cache-dir /dev/null src/python/clustermcml "$work/calls.py" >"$work/found"
sed -n 's|^\(.*/\)\{0,1\}\([^/]*:[0-9]*\): error.*|\2|p' "$work/found" | sort -u >"$work/lines"
grep -n '# wrong' "$work/calls.py" | sed 's/^\([0-9]*\):.*/calls.py:\1/' | sort -u | cmp -s - "$work/lines" || { cat "$work/found"; exit 1; }
