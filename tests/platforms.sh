#!/bin/sh
# Builds the program on several platforms and runs its tests there. Prints one row of the table in tests/README.md for each.
#
#     sh tests/platforms.sh [debian12] [debian13] [ubuntu2404] [clang] [arm64] [debug] [threads]     none: all
#     KEEP=/var/tmp/roots sh tests/platforms.sh arm64     roots and logs stay there; the next run installs nothing
#     QUICK=1 sh tests/platforms.sh debian13              four labels instead of the whole of tests/run.sh
#
# - debian12, debian13, ubuntu2404: the two commands of README.md in a bare root that debootstrap makes
# - clang: on Debian 13 without gcc; arm64: cross-compiled on Debian 13, run by qemu-user
# - debug, threads (32 threads, however few the cores): on this machine
# Each platform builds a clean clone of HEAD and flies the samples. The .mco files must be those of a Release build on this
# machine, byte by byte but for the line of time. Roots need the user root, debootstrap and a package archive; mounts are in a
# namespace of their own and end with it. Roots lie in $TMPDIR and are removed, unless KEEP names a folder.
#
# Exit code: 0 all passed, 1 one failed, 77 none failed but no root could be made for one, 2 usage.
# SPDX-License-Identifier: MIT
set -eu
top=$(cd "$(dirname "$0")/.." && pwd)
known="debian12 debian13 ubuntu2404 clang arm64 debug threads"
for name in "$@"; do
    case " $known " in *" $name "*) ;; *) echo "platforms.sh: $name (expected: $known)" >&2; exit 2 ;; esac
done
test $# -gt 0 || set -- $known

work=$(mktemp -d)
trap 'rm -rf --one-file-system "$work"' EXIT
trap 'exit 130' INT TERM HUP
roots=${KEEP:-$work/roots}
mkdir -p "$roots"
roots=$(cd "$roots" && pwd)

configure="cmake -S . -B build -DCLUSTERMCML_WERROR=ON -DCLUSTERMCML_TESTS=ON"
build="cmake --build build --parallel 2"
check="ctest --test-dir build --output-on-failure --timeout 86400 -j2 -L" # emulated, a test may take an hour
install="export DEBIAN_FRONTEND=noninteractive; apt-get update -q; apt-get install -y -q --no-install-recommends"
fly='for scene in samples/*.mci samples/shapes/*.mci; do
    flown=build/flown/$(basename "$scene" .mci)
    mkdir -p "$flown"
    $EMULATOR build/clustermcml "$scene" --photons 2000 --threads ${THREADS:-2} --quiet -o "$flown"
done'

# Runs commands in a root, as root. Mounts and processes that they leave end with their namespaces. The root is mounted on
# itself, because commands that mount within it expect "/" to be a mount.
in_root() { # ROOT COMMANDS
    unshare --mount --pid --fork --kill-child sh -euc '
        mount --bind "$1" "$1"
        mount -t proc proc "$1/proc"
        mount -t sysfs -o ro sysfs "$1/sys"
        mount -t devpts devpts "$1/dev/pts"
        mount -t tmpfs tmpfs "$1/dev/shm"
        trap "exit 130" INT TERM HUP
        chroot "$1" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 sh -euc "$2" &
        wait $!' sh "$1" "$2" </dev/null
}

# Runs commands in the clone that the root holds. The root HERE stands for this machine.
in_clone() { # ROOT COMMANDS
    if test "$1" = "$roots/HERE"; then
        (cd "$1/root/clustermcml" && sh -euc "$2" </dev/null)
    else
        in_root "$1" "cd /root/clustermcml; $2"
    fi
}

clone() { # ROOT
    mkdir -p "$1/root"
    rm -rf "$1/root/clustermcml"
    git clone -q --no-hardlinks "$top" "$1/root/clustermcml"
}

# Makes a bare root of a suite, once. Ubuntu's keys are those that Debian 13 packages.
make_base() { # SUITE
    test ! -d "$roots/base-$1" || return 0
    rm -rf --one-file-system "$roots/part"
    set -- "$1" http://deb.debian.org/debian
    test "$1" != noble || {
        make_base trixie && in_root "$roots/base-trixie" "$install ubuntu-keyring" || return 1
        set -- noble http://archive.ubuntu.com/ubuntu gutsy "--components=main,universe" \
            "--keyring=$roots/base-trixie/usr/share/keyrings/ubuntu-archive-keyring.gpg"
    }
    suite=$1 archive=$2 script=${3:-}
    shift $(($# < 3 ? $# : 3))
    unshare --mount debootstrap --variant=minbase "$@" "$suite" "$roots/part" "$archive" $script &&
        mv "$roots/part" "$roots/base-$suite"
}

make_root() { # NAME SUITE
    if test "$2" = HERE; then return 0; fi
    make_base "$2"
    test -d "$roots/$1" || { rm -rf "$roots/part" && cp -a "$roots/base-$2" "$roots/part" && mv "$roots/part" "$roots/$1"; }
}

# Prints the versions for the row; runs where the tests ran.
versions='version() { dpkg-query -W -f "\${Version}\n" "$1" 2>/dev/null | head -n 1 | sed "s/^[0-9]*://; s/[-+~].*//"; }
compiler=${CC:-gcc}
number=$($compiler --version | sed -n "1s/.* \([0-9][0-9.]*[0-9]\).*/\1/p")
mpi=$(version libopenmpi-dev) pocl=$(version pocl-opencl-icd)
echo "$compiler $number | $(version libembree-dev) | ${mpi:--} | ${pocl:--} | $(version libhdf5-dev)"'

# Prints "cli 3, unit 40, failed: unit.a unit.b, skipped: cli.c" from the output of ctest.
tests_of() { # LOG
    awk '/^ *[0-9]+\/[0-9]+ Test +#/ {
            match($0, /: [a-z]+\.[a-z0-9_]+/); name = substr($0, RSTART + 2, RLENGTH - 2)
            label = name; sub(/\..*/, "", label)
            if (/ Passed /) passed[label]++; else if (/\*\*\*Skipped/) skipped = skipped " " name; else failed = failed " " name
        }
        END {
            count = split("house unit cross cli cluster files python stat stability", labels, " ")
            for (i = 1; i <= count; i++) if (passed[labels[i]]) text = text (text ? ", " : "") labels[i] " " passed[labels[i]]
            print text (failed ? ", failed:" failed : "") (skipped ? ", skipped:" skipped : "")
        }' "$1"
}

# Prints an .mco file without its line of time, and without the lines that $mask removes.
science_of() { # FILE
    sed -e '/^# User time/d' -e "$mask" "$1"
}

# Prints how many .mco files have the same bytes as on this machine, and which differ.
compare_with_here() { # ROOT
    same=0 other=
    for file in $(cd "$work/expected" && find . -name '*.mco' | sort); do
        science_of "$work/expected/$file" >"$work/a"
        if test -f "$1/root/clustermcml/build/flown/$file" &&
            science_of "$1/root/clustermcml/build/flown/$file" | cmp -s - "$work/a"; then
            same=$((same + 1))
        else
            other="$other ${file##*/}"
        fi
    done
    echo "$same .mco the same${mask:+ but for the error of Rsp}${other:+, others:$other}"
    test -z "$other" && test "$same" -gt 0
}

# Flies the samples with a Release build of this machine, when the first platform needs them.
fly_here() {
    test ! -d "$work/expected" || return 0
    sh "$top/samples/packages.sh" test
    clone "$roots/HERE"
    in_clone "$roots/HERE" "$configure -DCMAKE_BUILD_TYPE=Release; $build --target clustermcml; EMULATOR=; $fly"
    mv "$roots/HERE/root/clustermcml/build/flown" "$work/expected"
}

settings() { # NAME: sets system (what the row says), suite, commands and mask
    mask=
    readme="sh samples/quickstart.sh; sh tests/run.sh; EMULATOR=; $fly"
    test -z "${QUICK:-}" || readme="sh samples/quickstart.sh; sh samples/packages.sh test
        $configure -DCMAKE_BUILD_TYPE=Release; $build; EMULATOR=; $fly; $check 'house|unit|cross|cli'"
    case $1 in
    debian12) system="Debian 12" suite=bookworm commands=$readme ;;
    debian13) system="Debian 13" suite=trixie commands=$readme ;;
    ubuntu2404) system="Ubuntu 24.04" suite=noble commands=$readme ;;
    clang)
        system="Debian 13 without gcc" suite=trixie
        commands="$install \$(sh samples/packages.sh names | grep -vx -e gcc -e g++)
            ! command -v gcc; export CC=clang CXX=clang++
            $configure -DCMAKE_BUILD_TYPE=Release; $build; EMULATOR=; $fly; $check 'unit|cross'" ;;
    arm64)
        # The error of an Rsp without chance is the rounding of a long double, which has more bits on aarch64.
        system="aarch64 (qemu-user)" suite=trixie mask='/^se_RAT/{n;d;}'
        commands="dpkg --add-architecture arm64
            $install crossbuild-essential-arm64 cmake make git pkg-config python3 qemu-user opencl-headers librandom123-dev \
                libgomp1:arm64 libembree-dev:arm64 libtinyobjloader-dev:arm64 libjansson-dev:arm64 zlib1g-dev:arm64 \
                libhdf5-dev:arm64 ocl-icd-opencl-dev:arm64 libcmocka-dev:arm64
            export CC=aarch64-linux-gnu-gcc CXX=aarch64-linux-gnu-g++
            export PKG_CONFIG_LIBDIR=/usr/lib/aarch64-linux-gnu/pkgconfig:/usr/share/pkgconfig
            $configure -DCMAKE_BUILD_TYPE=Release -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 \
                -DCMAKE_CROSSCOMPILING_EMULATOR=qemu-aarch64 -DCLUSTERMCML_MPI=OFF
            $build; EMULATOR=qemu-aarch64; $fly; $check unit" ;;
    debug)
        system="this machine, Debug" suite=HERE
        commands="$configure -DCMAKE_BUILD_TYPE=Debug; $build; EMULATOR=; $fly; $check 'unit|cli'" ;;
    threads)
        system="this machine, 32 threads on $(nproc) cores" suite=HERE
        commands="$configure -DCMAKE_BUILD_TYPE=Release; $build; EMULATOR=; THREADS=32; $fly
            export OMP_NUM_THREADS=32; $check 'unit|cross'" ;;
    esac
}

# Prints one row. The commands run outside of any condition, so that the first failing command ends them.
platform() { # NAME
    settings "$1"
    log=$roots/$1.log
    root=$roots/$1
    test "$suite" != HERE || root=$roots/HERE
    if test "$suite" != HERE && { test "$(id -u)" -ne 0 || ! command -v debootstrap >/dev/null; }; then
        echo "$1: no root can be made: needs the user root and debootstrap" >&2
        skipped=$((skipped + 1))
        return 0
    fi
    (make_root "$1" "$suite") >"$log" 2>&1 || {
        echo "$1: no root can be made: $(grep -v '^I:' "$log" | tail -n 1)" >&2
        skipped=$((skipped + 1))
        return 0
    }
    fly_here >"$log" 2>&1
    clone "$root"
    code=0
    tool=
    in_clone "$root" "$commands" >>"$log" 2>&1 || code=$?
    case $1 in clang) tool="CC=clang;" ;; arm64) tool="CC=aarch64-linux-gnu-gcc;" ;; esac
    bytes=$(compare_with_here "$root") || code=1
    echo "| $system | $(in_clone "$root" "$tool $versions") | $(tests_of "$log"); $bytes |"
    test "$code" -ne 0 || return 0
    echo "$1: failed${KEEP:+, see $log}" >&2
    tail -n 40 "$log" >&2
    failed=$((failed + 1))
}

failed=0 skipped=0
echo "| platform | compiler | Embree | Open MPI | PoCL | HDF5 | what passed |"
echo "|---|---|---|---|---|---|---|"
for name in "$@"; do platform "$name"; done
test "$failed" -eq 0 || exit 1
test "$skipped" -eq 0 || exit 77
