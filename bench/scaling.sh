#!/bin/sh
# Measures what ranks cost each other, and predicts what a thousand would: scaling.sh [--program PATH] [--out DIR]
# [--photons N]; by default build/clustermcml, bench/out, 2e6. Leaves scaling.txt. bench/README.md says how to read it.
# SPDX-License-Identifier: MIT
set -eu
here=$(cd "$(dirname "$0")" && pwd)
program=$here/../build/clustermcml
out=$here/out
photons=2e6
usage() { echo "scaling.sh [--program PATH] [--out DIR] [--photons N]"; exit "$1"; }
while [ $# -gt 0 ]; do
    case $1 in
    --program | --out | --photons)
        [ $# -ge 2 ] || usage 2
        case $1 in --program) program=$2 ;; --out) out=$2 ;; --photons) photons=$2 ;; esac
        shift
        ;;
    -h | --help) usage 0 ;;
    *) usage 2 >&2 ;;
    esac
    shift
done
[ -x "$program" ] || { echo "$program is no program: build it first (see README.md)" >&2; exit 2; }
command -v mpiexec >/dev/null || { echo "mpiexec is missing" >&2; exit 2; }
mkdir -p "$out"
python3 -B "$here/scaling.py" "$program" "$photons" | tee "$out/scaling.txt"
