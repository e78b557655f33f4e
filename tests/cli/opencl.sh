#!/bin/sh
# Tests the opencl engine at the command line: every sample that it can fly, against the cpu engine, and every possible error
# of a device: one clear line, the right exit code, nothing written.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
expect_code 0 devices
grep -q '^0\*\? ' "$work/out" || { echo "no OpenCL device"; exit 77; }
sample=samples/fig5.mci
mkdir "$work/results"

# Expects a failure of the device: exit code 3, a last line that matches, no file.
expect_device_error() { # PATTERN ARGUMENTS...
    pattern=$1
    shift
    expect_code 3 "$@" --engine opencl -o "$work/results" --quiet
    tail -n 1 "$work/err" | grep -q -e "^clustermcml: $pattern" || complain "$*: $(tail -n 1 "$work/err")"
    test -z "$(ls "$work/results")" || complain "$*: wrote $(ls "$work/results")"
}

# Devices that do not exist, and texts that name no device.
expect_device_error "no OpenCL device 99: there " $sample --device 99
expect_error 2 "--device x (expected a number, several like 0,1, or all)" $sample --engine opencl --device x --quiet
expect_error 2 "--device 0, (expected a number, several like 0,1, or all)" $sample --engine opencl --device 0, --quiet
expect_error 2 "--device  (expected a number, several like 0,1, or all)" $sample --engine opencl --device "" --quiet
expect_code 2 samples/ridges.mci --engine opencl -o "$work/results" --quiet
test "$(grep -v "^clustermcml: note: " "$work/err")" = "clustermcml: samples/ridges.mci: boundary 0 is a mesh (expected planes and heightfields; the opencl engine flies no meshes)" ||
    complain "mesh: $(cat "$work/err")"
test -z "$(ls "$work/results")" || complain "a refused mesh left files"

# Quantities that only the other engines record.
for line in "map 3 3 0.1 0.1" "map 3 3 0.1 0.1 volume" facets "time 10 5" "directions 3 4" fluence "detector disk 1" 'photons "exits"'; do
    sed "s/^\([0-9].*\)# nz, nr, na/\1\n$line #/" $sample >"$work/maps.mci"
    grep -q "^$line" "$work/maps.mci" || complain "$line was not inserted"
    expect_code 2 "$work/maps.mci" --engine opencl -o "$work/results" --quiet
    without="records no maps, volumes or facets"
    case $line in time*) without="keeps no time" ;; directions* | fluence) without="scores none" ;; detector*) without="has none" ;; photons*) without="saves none" ;; esac
    grep -q "^clustermcml: $work/maps.mci:[0-9]*: a ${line%% *} line and --engine opencl, which $without (expected --engine cpu)$" "$work/err" ||
        complain "$line: $(cat "$work/err")"
    test "$(wc -l <"$work/err")" = 1 || complain "$line: more than one line"
    test -z "$(ls "$work/results")" || complain "$line: a refused run left files"
done

# Errors of the compiler: bad options, refused source text (its whole log is shown), another layout of structs.
expect_device_error "opencl device 0 (.*): " $sample --build-options "--no-such-option"
expect_device_error "opencl device 0 (.*): the kernel does not compile: .*error" $sample --build-options "-D cml_step=1"
test "$(wc -l <"$work/err")" -gt 1 || complain "the build log is not shown"
expect_device_error "opencl device 0 (.*): layout entry 0 is " $sample --build-options "-D CML_DOUBLE"

# A device fails at some call, at once or in the middle of the flight.
with_fault() { # "FUNCTION N CODE" PATTERN
    CML_FAULT=$1 LD_PRELOAD=$OPENCL_FAULT
    export CML_FAULT LD_PRELOAD
    expect_device_error "$2" $sample --photons 1e5
    unset CML_FAULT LD_PRELOAD
}
if test -n "${OPENCL_FAULT:-}"; then
    export CML_DEVICE_BYTES=100000 # more memory than the device has
    with_fault "none 1 0" "opencl device 0 (.*): .* take .* MiB (expected at most .*"
    unset CML_DEVICE_BYTES
    with_fault "clGetPlatformIDs 1 -1001" "there is no OpenCL device (see clustermcml devices)"
    with_fault "clCreateBuffer 1 -61" "opencl device 0 (.*): .*: CL_INVALID_BUFFER_SIZE (-61)"
    with_fault "clCreateBuffer 6 -4" "opencl device 0 (.*): memory for .*: CL_MEM_OBJECT_ALLOCATION_FAILURE (-4)"
    with_fault "clEnqueueNDRangeKernel 1 -5" "opencl device 0 (.*): .*: CL_OUT_OF_RESOURCES (-5)"
    with_fault "clEnqueueNDRangeKernel 20 -2" "opencl device 0 (.*): launching the kernel: CL_DEVICE_NOT_AVAILABLE (-2)"
    with_fault "clEnqueueReadBuffer 9 -5" "opencl device 0 (.*): reading results: CL_OUT_OF_RESOURCES (-5)"
fi

# Options that the kernel of the 2019 program had, and a flight of a single photon, give the results of the cpu engine.
same_as_cpu() { # OUTPUT ARGUMENTS...
    output=$1
    shift
    for engine in cpu opencl; do
        expect_code 0 "$@" --engine $engine --quiet -o "$work"
        grep -v -e '^# User time' -e engine "$work/$output" >"$work/$engine"
    done
    cmp -s "$work/cpu" "$work/opencl" || complain "$*: opencl differs from cpu"
}
same_as_cpu hinoise.mco samples/shapes/hinoise.mci --photons 3001 --ignore-absorption
same_as_cpu hinoise.mco samples/shapes/hinoise.mci --photons 3001 --ignore-heightfields
same_as_cpu hinoise.mco samples/shapes/hinoise.mci --photons 3001 --no-reentry
same_as_cpu fig5.mco $sample --photons 1

# Kernel binaries are cached; a damaged cache, or none, does no harm. The cache of pocl itself stays where it is, because a
# kernel takes pocl 15 seconds.
POCL_CACHE_DIR=${XDG_CACHE_HOME:-${HOME:-$work}/.cache}/pocl/kcache
XDG_CACHE_HOME=$work/cache HOME=$work
export POCL_CACHE_DIR XDG_CACHE_HOME HOME
same_as_cpu fig5.mco $sample --photons 1001
binary=$(ls "$work"/cache/clustermcml/*.bin) || complain "no binary was cached"
for spoil in 'printf broken >' 'truncate -s -1' 'truncate -s 0'; do
    eval "$spoil \"\$binary\""
    same_as_cpu fig5.mco $sample --photons 1001
    test "$(wc -c <"$binary")" -gt 1000 || complain "a spoilt binary was not replaced"
done
# A cache that another user could have written or changed is not used, which is said once.
refuses_cache() { # WHAT NAME
    rm -f "$work/fig5.mco"
    expect_code 0 $sample --engine opencl --photons 1001 --quiet -o "$work"
    test "$(cat "$work/err")" = "clustermcml: note: $2 in the cache of OpenCL binaries is not used (expected one of your own that others may not write)" ||
        complain "$1: $(cat "$work/err")"
    test -s "$work/fig5.mco" || complain "$1: nothing was flown"
}
name=${binary##*/} folder=${binary%/*}
chmod 666 "$binary"
refuses_cache "a file that others may write" "$name"
expect_code 0 $sample --engine opencl --photons 1001 --quiet -o "$work"
test ! -s "$work/err" && test "$(stat -c %a "$binary")" = 600 || complain "a binary was not written anew: $(cat "$work/err")"
mv "$binary" "$work/target"
ln -s "$work/target" "$binary"
refuses_cache "a link" "$name"
rm "$binary" "$work/target"
mkfifo "$binary"
refuses_cache "a pipe" "$name"
rm "$binary"
for rights in 777 720; do
    chmod $rights "$folder"
    refuses_cache "a folder that others may write" "$folder"
    test -z "$(ls "$folder")" || complain "a binary was written into a folder that others may write"
done
chmod 700 "$folder"
mv "$folder" "$work/elsewhere"
ln -s "$work/elsewhere" "$folder"
refuses_cache "a link to a folder" "$folder"
rm "$folder"
mkdir "$folder"
if chown 12345 "$folder" 2>"$work/out"; then
    refuses_cache "a folder of another user" "$folder"
    chown "$(id -u)" "$folder"
    expect_code 0 $sample --engine opencl --photons 1001 --quiet -o "$work"
    chown 12345 "$folder/$name"
    refuses_cache "a file of another user" "$name"
fi
unset XDG_CACHE_HOME HOME
same_as_cpu fig5.mco $sample --photons 1001
finish
