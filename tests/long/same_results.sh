#!/bin/sh
# Compares everything that two programs write, one from before a change and one from after it.
# OLD and NEW fly the same scenes with the same options, and all their output is compared byte by byte: files, standard
# output, standard error and exit code. Removed first are times, speeds, measured memory, the version, and the number of
# queries, which near bodies depends on the order in which threads fly.
# An .h5 file is compared as text (all attributes, data sets and values), since a version of another length moves the bytes
# behind it.
#
#   tests/long/same_results.sh OLD NEW [SAMPLE...]
#   PHOTONS=2000 MASK='s/MiB//' tests/long/same_results.sh old/build/clustermcml build/clustermcml samples/fig7.mci
#
# Without SAMPLE: all of samples, samples/shapes and bench/lib/scenes, each unchanged and with maps, a volume and facets.
# - run: engines cpu, reference and opencl, with 1 and 2 threads on 1 and 2 ranks; every option that changes a result
# - check, mesh, trace, crosscheck, exact, view, compare and plot; devices, --help and --version
# Left out are results that depend on time: plan, and the moments of checkpoints (--keep, --more).
# A refusal by an engine or option must have the same words. A refusal is expected only of opencl, crosscheck, exact,
# --boundaries cone, --run 2 and --sweep; elsewhere a program that fails counts as a difference, even if both do.
#
# PHOTONS: per run of engine cpu, default 20000; a tenth of it on the others, which are slower
# MASK: further lines for sed -E that remove an intended difference
#
# Prints one line per difference: scene, arguments (engine cpu if none is named; -n N: on N ranks), file, first lines that
# differ. Then "N comparisons, M differ".
# Exit code 0: none differ, 1: some do, 2: usage, 77: mpiexec or h5py is missing.
# ctest does not run it, as it needs two programs.
# SPDX-License-Identifier: MIT
set -u

fail() { # TEXT
    echo "same_results.sh: $1" >&2
    exit 2
}

absolute() { # FILE
    echo "$(cd "$(dirname "$1")" && pwd)/$(basename "$1")"
}

[ $# -ge 2 ] || fail "expected OLD NEW [SAMPLE...]"
for program in "$1" "$2"; do
    { [ -f "$program" ] && [ -x "$program" ]; } || fail "$program: not a program"
done
old=$(absolute "$1") new=$(absolute "$2")
shift 2
samples=
for sample; do
    [ -f "$sample" ] || fail "$sample: no such file"
    samples="$samples $(absolute "$sample")"
done
cd "$(dirname "$0")/../.." || exit 2
root=$PWD
[ "$samples" ] || samples=$(ls "$root"/samples/*.mci "$root"/samples/shapes/*.mci "$root"/bench/lib/scenes/*.mci)

photons=${PHOTONS:-20000}
case $photons in '' | *[!0-9]*) fail "PHOTONS=$photons: not a whole number" ;; esac
few=$((photons / 10 + 1))

. tests/lib/cluster.sh
trap 'exit 2' HUP INT PIPE TERM # so that the work folder goes then, too
export PATH="/usr/bin:$PATH" # Debian packages h5py and matplotlib for its own Python, which compare, plot and view start
python=/usr/bin/python3
"$python" -c 'import h5py' 2>/dev/null || { echo "h5py is missing"; exit 77; }

# Both programs are started as ./clustermcml from folders of their own, so that paths and command lines are the same.
program=./clustermcml
mkdir "$work/old" "$work/new" "$work/kept" "$work/scenes"
printf 'seed\n3\n4\n' >"$work/scenes/seeds.csv"
ln -s "$old" "$work/old/clustermcml"
ln -s "$new" "$work/new/clustermcml"
comparisons=0 differing=0 refusals=0 input=/dev/null

mask='/^# User time:/s/:.*/: TIME/
/^# end$/d
s/clustermcml [0-9][0-9.]*( \([^)]*\))?/clustermcml VERSION/
s/"version":"[^"]*"/"version":VERSION/
s/^(\/ @version = ).*/\1VERSION/
/^\/ @identity = /d
/^call(\/|$| )/d
s/built in [^ ]* s, [^ ]* MiB/built in TIME, MEASURED/
s/^  [^ ]* s, ([0-9]+ photons, )?[^ ]* photons\/s, /  TIME, /
s/, [^ ]* ns\/step/, TIME/
s/^(  an error of 1 % takes:).*/\1 TIME/
/^ *[0-9]+ %, .* elapsed, /d
s/"rank_s":\[[^]]*\]/"rank_s":TIME/
s/all ranks: idle .*/all ranks: TIME/
s/memory: at most [^ ]* MiB/memory: MEASURED/
s/^( +[0-9]+ +[0-9]+)( +[0-9]+\.[0-9]+){4}$/\1 TIME/
s/"(build_s|MiB|seconds|cpu_s|ns_per_step|photons_per_s|queries|[A-Za-z]+_1pc_s|idle|communication)":[^],}]*/"\1":TIME/g
s/"memory_bytes":[0-9]+/"memory_bytes":MEASURED/g
s/Process name: .*/Process name: RANK/'

# Prints the part of a file that must be the same for both programs.
comparable() { # FILE
    case $1 in
    */stdout | */stderr | *.mco) LC_ALL=C sed -E "$mask
${MASK-}" "$1" ;;
    *.checkpoint) echo "a checkpoint" ;; # of a refused run: it holds the version of the program, in a checksum too
    *.h5) { "$python" -B "$root/tests/lib/h5_text.py" "$1" || echo "$1 cannot be read"; } | LC_ALL=C sed -E "$mask
${MASK-}" ;;
    *.vti | *.vtp) LC_ALL=C sed '/^<!-- run /d' "$1" ;; # the identity sums up the version
    *) cat "$1" ;;
    esac
}

difference() { # FILE WHAT
    differing=$((differing + 1))
    echo "$title: $1: $2"
}

# Prints a line that differs, shortened and without control characters.
shown() { # MARK
    LC_ALL=C grep -am1 "^$1" "$work/diff" | LC_ALL=C tr -cd '\040-\176' | cut -c1-120
}

compare_file() { # FILE
    comparisons=$((comparisons + 1))
    a=$work/old/got/$1 b=$work/new/got/$1
    cmp -s "$a" "$b" && return
    [ -f "$a" ] || { difference "$1" "only NEW writes it" && return; }
    [ -f "$b" ] || { difference "$1" "only OLD writes it" && return; }
    comparable "$a" >"$work/a"
    comparable "$b" >"$work/b"
    LC_ALL=C diff -a "$work/a" "$work/b" >"$work/diff" && return
    difference "$1" "line $(sed -n '1s/[^0-9].*//p' "$work/diff"): $(shown '<') | $(shown '>')"
}

# A program that does nothing, or always fails, writes the same as itself. The exit code of OLD is therefore compared with the
# expected one.
check_code() { # ARGUMENTS...
    comparisons=$((comparisons + 1))
    code=$(cat "$work/old/got/exit")
    case "$code $*" in
    0\ *" run "*)
        find "$work/old/got" -name '*.mco' -o -name '*.h5' | grep -q . || difference exit "OLD writes no result"
        ;;
    0\ * | 1\ *" compare "* | 1\ *crosscheck*) ;;
    2\ *opencl* | 2\ *"--boundaries cone"* | 2\ *"--run 2"* | 2\ *crosscheck* | 2\ *" exact "* | 2\ *"--sweep"*)
        refusals=$((refusals + 1))
        ;;
    *) difference exit "OLD fails with $code: $(head -n 1 "$work/old/got/stderr")" ;;
    esac
}

# Each program has a folder of its own for temporary files, because two mpiexec that share one may remove each other's files.
one_side() { # old|new COMMAND...
    cd "$work/$1" || exit
    shift
    rm -rf got
    mkdir -p got tmp
    export TMPDIR="$PWD/tmp"
    code=0
    "$@" >got/stdout 2>got/stderr <"$input" || code=$?
    echo "$code" >got/exit
}

# Runs a command for both programs, and compares all files that they leave in the folder got.
both() { # COMMAND...
    one_side old "$@" &
    one_side new "$@" &
    wait
    for file in $({ (cd "$work/old/got" && find . -type f); (cd "$work/new/got" && find . -type f); } | sort -u); do
        compare_file "${file#./}"
    done
    check_code "$@"
}

# Sets the words before a difference: the scene and the arguments, without the scene's path.
entitle() { # ARGUMENTS...
    title="$name: $(echo "$*" | sed -e "s# $scene##" -e "s#$work/##g")"
}

alone() { # ARGUMENTS...
    entitle "$@"
    both "$program" "$@"
}

on_ranks() { # N ARGUMENTS...
    entitle -n "$@"
    both ranks "$@"
}

keep() { # NAME: the files that OLD wrote last, for compare and plot
    rm -rf "$work/kept/$1"
    cp -R "$work/old/got" "$work/kept/$1"
}

fly_engine() { # ENGINE PHOTONS
    for threads in 1 2; do
        alone run "$scene" --engine "$1" --photons "$2" --threads "$threads" -o got
        on_ranks 2 run "$scene" --engine "$1" --photons "$2" --threads "$threads" -o got
    done
}

# Reads sets of options from standard input, one set a line.
fly_options() { # PHOTONS
    while read -r options; do
        # shellcheck disable=SC2086 # each word is an argument
        alone run "$scene" $options --photons "$1" --threads 2 -o got
    done
}

fly_cpu_options() {
    fly_options "$photons" <<END
--json
--verbose
--boundaries plane
--boundaries cone
--boundaries mesh
--boundaries mesh --normals vertex
--boundaries mesh --normals facet
--boundaries mesh --rings inscribed
--boundaries mesh --mesh-search embree
--boundaries mesh --tolerance 0.01
--mesh-search embree
--tolerance 0.01
--no-reentry
--ignore-heightfields
--ignore-absorption
--target-error 0.03
--seed 7 --chunk 100
--sampling random
--roulette mcml
--set layer1.n=1.3
--sweep $work/scenes/seeds.csv
END
}

fly_slow_options() {
    fly_options "$few" <<END
--engine reference --json
--engine reference --boundaries plane
--engine reference --boundaries cone
--engine reference --boundaries mesh
--engine reference --boundaries mesh --normals facet
--engine reference --no-reentry
--engine opencl --json
--engine opencl --boundaries plane
--engine opencl --boundaries cone
--engine opencl --boundaries mesh
--engine opencl --no-reentry
--engine opencl --ignore-absorption
END
}

# Adds maps, a volume and facets to the scene, with results in format B.
add_maps() {
    lines=
    grep -q '^map' "$scene" || lines='/# nz, nr, na/a map 40 30 0.05 0.05 angles volume\nfacets'
    sed -E -e 's/^([^ #]+\.mco) A/\1 B/' -e "s#^((i|m|beam|phase) [^\"]*)\"([^/])#\1\"$(dirname "$scene")/\3#" -e "$lines" "$scene" \
        >"$work/scenes/$(basename "$scene")"
}

fly_maps() {
    fly_options "$photons" <<END
--json
--boundaries plane
--boundaries mesh
--mesh-search embree
END
    fly_options "$few" <<END
--engine reference
--engine opencl
END
    on_ranks 2 run "$scene" --photons "$photons" --threads 2 -o got
    input=$scene
    alone run - --photons "$photons" --threads 2 -o got
    input=/dev/null
}

describe() { # compares what check and mesh say and write
    for options in "" "--boundaries mesh" "--boundaries mesh --rings inscribed" "--tolerance 0.01"; do
        # shellcheck disable=SC2086 # each word is an argument
        alone check "$scene" $options
        # shellcheck disable=SC2086
        alone mesh "$scene" $options -o got
    done
    alone check "$scene" --json
    alone view "$scene" -o got/section.svg
    alone exact "$scene"
    alone exact "$scene" --json
}

follow() { # the events of single photons
    for engine in cpu reference; do
        for photon in 0 7 1234567; do
            alone trace "$scene" "$photon" --engine "$engine"
        done
    done
    alone trace "$scene" 11 --boundaries mesh
    alone trace "$scene" 11 --run 2
    alone crosscheck "$scene" --photons "$few" --threads 2
    alone crosscheck "$scene" --photons 100 --threads 2 --dump got/dump
}

# Both programs compare and draw the same two results of OLD.
judge() {
    alone run "$scene" --photons "$photons" --threads 2 -o got
    keep one
    alone run "$scene" --photons "$photons" --threads 2 -o got --seed 2
    keep two
    for mco in "$work"/kept/one/*.mco; do
        other=$work/kept/two/$(basename "$mco")
        alone compare "$mco" "$other" -o got/picture.svg
        alone compare "$mco" "$other" --json
        alone plot "$mco" "$other" -o got/picture.svg --caption "two seeds"
        alone plot "$mco" -o got/picture.svg --linear
    done
    for map in "$work"/kept/one/*.h5; do
        [ -f "$map" ] && [ -f "${map%.h5}.map.vti" ] || continue
        alone plot "$map" -o got/picture.svg --of Rd
        alone plot "$map" -o got/picture.svg --of Tt --log
    done
}

compare_scene() { # FILE
    scene=$1 name=${1#"$root"/}
    fly_engine cpu "$photons"
    fly_engine reference "$few"
    fly_engine opencl "$few"
    fly_cpu_options
    fly_slow_options
    describe
    follow
    judge
    add_maps
    scene=$work/scenes/$(basename "$scene") name="$name with maps"
    fly_maps
}

name="no scene" scene=none
alone --help
alone --version
alone devices
for sample in $samples; do
    compare_scene "$sample"
done
echo "$refusals runs were refused, as expected"
echo "$comparisons comparisons, $differing differ"
[ "$differing" -eq 0 ]
