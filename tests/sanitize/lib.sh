# Helpers of the scripts in this folder, beside lib/cli.sh.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

# Writes a scene that records every map, volume and facet, with results as .h5 if this program has them, else .mco. A scene
# that asks for maps itself keeps its own. Prints the new scene's name.
with_maps() { # FORMAT SCENE
    lines=
    grep -q '^map' "$2" || lines='/# nz, nr, na/a map 40 30 0.05 0.05 angles volume\nfacets'
    sed -E -e "s/^([^ #]+\\.mco) A/\\1 $1/" -e "s#^((i|m|beam|phase) [^\"]*)\"([^/])#\\1\"$PWD/$(dirname "$2")/\\3#" -e "$lines" "$2" >"$work/$(basename "$2")"
    echo "$work/$(basename "$2")"
}

# Flies a scene and expects no sanitizer report, no lost packet, and all weight accounted for.
expect_sound() { # ARGUMENTS...
    expect_code 0 "$@" --json -o "$work/got"
    runs=$(grep -c . "$work/out")
    sound=$(grep -cE '"lost":0,.*"residue":0[,.]' "$work/out")
    test "$runs" -ge 1 && test "$sound" -eq "$runs" || complain "clustermcml $*: $(cat "$work/out")"
    flights=$((flights + 1))
}
flights=0
mkdir "$work/got"
