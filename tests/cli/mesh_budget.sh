#!/bin/sh
# Tests --mesh-budget: meshes of too many triangles are refused in one line, before they take memory; large meshes are
# announced.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

scene() { # NAME BOUNDARY
    printf '1.0\n1\n%s.mco A\n100\n0.01 0.01\n10 10 5\n1\n1.0\n%s\n1.4 1 10 0.9 1\n1.0\n' "$1" "$2" >"$work/$1.mci"
}
refused() { # MESSAGE ARGUMENTS...
    message=$1
    shift
    expect_error 2 "$work/$message" "$@"
}

# The message states the number of triangles that would be made.
scene field "b 3 0.1 0.5 0.05 0.5 0 1"
expect_code 0 check "$work/field.mci" --boundaries mesh --mesh-budget 256
grep -q 'boundary 0: mesh at z = 0 cm, 256 triangles' "$work/out" || complain "$(cat "$work/out")"
remedy="a larger --tolerance or --mesh-budget, or --boundaries cone)"
for command in check mesh run crosscheck; do
    refused "field.mci:9: boundary 0 needs 256 triangles, 8.34e-05 GiB (expected at most 255, or $remedy" \
        $command "$work/field.mci" --boundaries mesh --mesh-budget 255 --quiet
done
expect_code 0 check "$work/field.mci" --mesh-budget 1 # cones

# Every face of an OBJ file counts as its triangles, whatever else stands on the line.
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n#f 1 2 3\n  f 1/1 2 3 \\\n 4 # 5\ng f 1 2 3\n' >"$work/quad.obj"
scene quad 'm "quad.obj"'
expect_code 0 check "$work/quad.mci" --boundaries mesh --mesh-budget 2
grep -q 'mesh at z = 0 cm, 2 triangles' "$work/out" || complain "$(cat "$work/out")"
refused "quad.mci:9: boundary 0 needs 2 triangles, 6.52e-07 GiB (expected at most 1, or a coarser mesh or a larger --mesh-budget)" \
    check "$work/quad.mci" --mesh-budget 1

# The count includes the skirt, after merging; a larger tolerance reduces it.
{
    printf 'ncols 9\nnrows 9\nxllcorner 0\nyllcorner 0\ncellsize 0.1\nNODATA_value -1\n'
    awk 'BEGIN { for (y = 0; y < 9; y++) { for (x = 0; x < 9; x++) printf "%g ", (x * x + y * y) / 1000; print "" } }'
} >"$work/map.asc"
scene map 'm "map.asc" units=cm'
expect_code 0 check "$work/map.mci" --tolerance 1e-12
made=$(sed -n 's/.*mesh at z = 0 cm, \([0-9]*\) triangles.*/\1/p' "$work/out")
expect_code 0 check "$work/map.mci" --tolerance 1e-12 --mesh-budget "$made"
expect_code 2 check "$work/map.mci" --tolerance 1e-12 --mesh-budget $((made - 1))
grep -q "^clustermcml: $work/map.mci:9: boundary 0 needs $made triangles, .* (expected at most $((made - 1)), or " "$work/err" ||
    complain "$(cat "$work/err")"
expect_code 2 check "$work/map.mci" --tolerance 1e-12 --mesh-budget 1
grep -q "boundary 0 needs $made triangles" "$work/err" || complain "only counted: $(cat "$work/err")"
expect_code 0 check "$work/map.mci" --tolerance 0.1 --mesh-budget $((made - 1))

# A short file that asks for millions of triangles is counted, not made. It has 100 rings: 9e5 triangles at a tolerance of
# 3e-7, 5e6 at 1e-8.
scene rough "b 100 $(awk 'BEGIN { for (i = 0; i < 100; i++) printf "%.4f 0.0002 ", (i * 37 % 100) / 1e4 }')"
cat >"$work/most.py" <<'P'
import resource, subprocess, sys
code = subprocess.run(sys.argv[2:], check=False).returncode
used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
sys.exit(code if used < int(sys.argv[1]) * 1024 else f"{used} KiB")
P
expect_code 2 check "$work/rough.mci" --boundaries mesh --tolerance 1e-8
grep -Eq ': boundary 0 needs [4-9][0-9]{6} triangles, 1\.[0-9]+ GiB \(expected at most [1-4][0-9]{0,6}, or ' "$work/err" ||
    complain "the default: $(cat "$work/err")"
code=0
python3 "$work/most.py" 150 "$program" check "$work/rough.mci" --boundaries mesh --tolerance 1e-8 2>"$work/err" || code=$?
test $code -eq 2 || complain "refused after it took memory: $(cat "$work/err")"

# On a terminal, a mesh that takes more than a second is announced; not in a log, and not with --quiet.
cat >"$work/terminal.py" <<'P'
import os, pty, subprocess, sys
ours, its = pty.openpty()
process = subprocess.Popen(sys.argv[1:], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=its)
os.close(its)
said = b""
try:
    while part := os.read(ours, 4096):
        said += part
except OSError:  # the end of a terminal
    pass
print(said.decode(), end="")
sys.exit(process.wait())
P
large="trace $work/rough.mci 0 --boundaries mesh --tolerance 1e-6"
# shellcheck disable=SC2086 # words on purpose
said=$(python3 "$work/terminal.py" "$program" $large) || complain "on a terminal: $said"
echo "$said" | grep -Eq "rough.mci:9: boundary 0: making a mesh of [0-9.e+]* triangles, some [1-9] s" ||
    complain "not announced: $said"
# shellcheck disable=SC2086
said=$(python3 "$work/terminal.py" "$program" $large --quiet) || complain "quiet: $said"
test -z "$said" || complain "--quiet was not quiet: $said"
# shellcheck disable=SC2086
expect_code 0 $large
test ! -s "$work/err" || complain "announced in a log: $(cat "$work/err")"
finish
