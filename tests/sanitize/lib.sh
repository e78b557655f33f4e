# What the scripts of this folder share, beside lib/cli.sh.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

# Results as .h5 where this program has them, .mco otherwise; every map, volume and facet is recorded. A scene that asks
# for maps itself keeps its own. Prints the new scene's name.
with_maps() { # FORMAT SCENE
    lines=
    grep -q '^map' "$2" || lines='/# nz, nr, na/a map 40 30 0.05 0.05 angles volume\nfacets'
    sed -E -e "s/^([^ #]+\\.mco) A/\\1 $1/" -e "s#^((i|m|beam|phase) [^\"]*)\"([^/])#\\1\"$PWD/$(dirname "$2")/\\3#" -e "$lines" "$2" >"$work/$(basename "$2")"
    echo "$work/$(basename "$2")"
}

# Flies: nothing that a sanitizer complains of, no packet lost, all weight accounted for.
expect_sound() { # ARGUMENTS...
    expect_code 0 "$@" --json -o "$work/got"
    runs=$(grep -c . "$work/out")
    sound=$(grep -cE '"lost":0,.*"residue":0[,.]' "$work/out")
    test "$runs" -ge 1 && test "$sound" -eq "$runs" || complain "clustermcml $*: $(cat "$work/out")"
    flights=$((flights + 1))
}
flights=0
mkdir "$work/got"
