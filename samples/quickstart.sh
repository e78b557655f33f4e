#!/bin/sh
# Leads from a bare Debian 12 to the first picture: installs missing packages, builds into build/, simulates skin in
# grazing light, and draws its brightness. May be run again. Takes no arguments.
# SPDX-License-Identifier: MIT
set -eu
case ${1:-} in -*) sed -n '2,/^# SPDX/{/^# SPDX/!s/^# \{0,1\}//p;}' "$0"; exit 0 ;; esac
root=$(cd "$(dirname "$0")/.." && pwd)
sh "$root/samples/packages.sh"

# A build folder that exists keeps its options; a new one needs no tests, whose libraries may be missing.
test -f "$root/build/CMakeCache.txt" || options="-DCMAKE_BUILD_TYPE=Release -DCLUSTERMCML_TESTS=OFF"
cmake -S "$root" -B "$root/build" ${options:-} >/dev/null
cmake --build "$root/build" --parallel "$(nproc)" --target clustermcml pages # what `cmake --install` needs

results=$root/build/quickstart
mkdir -p "$results"
cd "$results"
"$root/build/clustermcml" "$root/samples/skinmap.mci" --photons 2e6
"$root/build/clustermcml" plot skinmap.h5 --of Rd --percentile 99.9 --label "Ridged skin in grazing light" -o skinmap.png --quiet
echo "the picture: $results/skinmap.png"
