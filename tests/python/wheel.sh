#!/bin/sh
# The wheel of samples/wheel.sh in bare Debian 12, Debian 13 and Ubuntu 24.04, made by debootstrap with python3, Open MPI and MPICH: an
# ordinary user installs it, flies five lines of Python to a picture, and all samples to the results that $CLUSTERMCML writes
# here. Two ranks under both MPI libraries fly some to these results, too. Python of Debian 11 is too old for the package:
# there the program flies alone.
#
#     ROOTS=/var/tmp/roots sh tests/python/wheel.sh     roots stay there; the next run makes none
#     WHEEL=FILE sh tests/python/wheel.sh               that wheel, and none is built
#
# Exit code: 0 all made roots passed, 1 one failed, 77 no root could be made. Needs the user root, debootstrap and archives.
# SPDX-License-Identifier: MIT
set -u
program=${CLUSTERMCML:-$PWD/build/clustermcml}
test "$(id -u)" -eq 0 && command -v debootstrap >/dev/null || { echo "needs the user root and debootstrap"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf --one-file-system "$work"' EXIT
trap 'exit 130' INT TERM HUP
roots=${ROOTS:-$work/roots}
mkdir -p "$roots" "$work/here"
wheel=${WHEEL:-}
test -n "$wheel" || { sh samples/wheel.sh "$work/wheel" && wheel=$(ls "$work"/wheel/*.whl); } || exit 1
case $wheel in
*-manylinux_2_28_x86_64.whl) ;;
*) echo "$wheel: is not for glibc 2.28"; exit 1 ;;
esac
test "$(stat -c %s "$wheel")" -le 40000000 || { echo "$wheel has more than 40 MB"; exit 1; }

# Runs in a root as an ordinary user, without network namespaces; mounts go with the process.
as_user() { # ROOT COMMANDS
    unshare --mount --pid --fork --kill-child sh -euc '
        mount -t proc proc "$1/proc"
        mount -t devpts devpts "$1/dev/pts"
        mount -t tmpfs tmpfs "$1/dev/shm"
        exec chroot --userspec=1234:1234 "$1" env -i PATH=/usr/bin:/bin HOME=/home/user LANG=C.UTF-8 \
            PIP_CERT=/home/user/ca.crt sh -euc "cd; $2"' sh "$1" "$2" </dev/null
}

# Ubuntu's keys are those that Debian 13 packages.
make_root() { # SUITE
    test ! -e "$roots/$1/usr/bin/mpiexec.mpich" || return 0
    archive=http://deb.debian.org/debian keys= script=
    test "$1" != noble || {
        make_root trixie && chroot "$roots/trixie" sh -c 'apt-get update -q && apt-get install -y -q ubuntu-keyring' || return 1
        archive=http://archive.ubuntu.com/ubuntu script=gutsy
        keys="--components=main,universe --keyring=$roots/trixie/usr/share/keyrings/ubuntu-archive-keyring.gpg"
    }
    # Word splitting is meant.
    unshare --mount debootstrap --variant=minbase --include=python3,python3-venv,openmpi-bin,mpich $keys "$1" "$roots/$1" $archive $script
}

fly='for scene in *.mci shapes/*.mci; do
    flown=$OUT/$(basename "$scene" .mci)
    mkdir -p "$flown"
    $PROGRAM "$scene" --photons 2000 --threads 2 --quiet -o "$flown"
done'
# Each process of Ubuntu 24.04's MPICH (4.2.0-5build3) is alone, those of a C program too: its library asks PMIx, its mpiexec
# speaks PMI. There MPICH is that of the package registry.
ranks='for mpi in openmpi mpich; do
    mpiexec=mpiexec.$mpi
    if grep -q Ubuntu /etc/os-release && test $mpi = mpich; then
        $HOME/venv/bin/pip install -q --disable-pip-version-check mpich==5.0.2
        mpiexec=$HOME/venv/bin/mpiexec
        export LD_LIBRARY_PATH=$HOME/venv/lib
    fi
    for scene in $RANKED; do
        mkdir -p "$HOME/$mpi/$scene"
        $mpiexec $(test $mpi = mpich || echo --oversubscribe) -n 2 $PROGRAM $scene.mci --photons 2000 --threads 1 \
            --verbose -o "$HOME/$mpi/$scene" >"$HOME/told" 2>&1 || { cat "$HOME/told"; exit 1; }
        grep -q "2 ranks" "$HOME/told" || { cat "$HOME/told"; exit 1; }
    done
done'
alone='rm -rf whole
    python3 -m zipfile -e ./*.whl whole
    cd whole/clustermcml
    chmod +x bin/clustermcml
    OUT=$HOME/flown PROGRAM=$PWD/bin/clustermcml
    cd share/clustermcml/samples'
try='rm -rf venv picture.png
    python3 -m venv venv
    venv/bin/pip install -q --disable-pip-version-check ./*.whl
    venv/bin/clustermcml --version
    venv/bin/clustermcml --version | grep -q "^MPI at run time, HDF5 yes, OpenCL yes"
    venv/bin/clustermcml devices || test $? -eq 6
    venv/bin/python five.py
    test -s picture.png
    cp -r venv/lib/python3*/site-packages/clustermcml/share/clustermcml/ share
    venv/bin/clustermcml plot scene.h5 -o drawn.svg
    test -s drawn.svg
    OUT=$HOME/flown PROGRAM=$HOME/venv/bin/clustermcml
    cd share/samples'
cat >"$work/five.py" <<'END'
import clustermcml as mc
skin = mc.Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1, top=mc.Heightfield(r=[0, 0.1], h=[0.02, 0]))
result = mc.run(mc.Scene([skin], photons=1e4), output_dir=".")
result.Rd_r.plot()[0].figure.savefig("picture.png")
END
(cd samples && OUT=$work/here PROGRAM=$program sh -euc "$fly") || { echo "$program flies no samples"; exit 1; }

# The content of a result but for the time, the commit and the call.
content() { # FILE
    case $1 in
    *.h5) /usr/bin/python3 -B tests/lib/h5_text.py "$1" | sed -e '/^\/ @version = /d' -e '/^\/ @identity = /d' -e '/^call/d' ;;
    *) sed -e '/^# User time/d' -e 's/^\(# clustermcml [0-9.]*\) (.*/\1/' "$1" ;;
    esac
}

# Results that a folder does not have as they are here; NAME: a sample, or all.
others() { # FOLDER NAME...
    folder=$1
    shift
    (cd "$work/here" && find "$@" -name '*.mco' -o -name '*.h5') >"$work/names"
    while read -r file; do
        text=$work/here/$file.text
        test -s "$text" || content "$work/here/$file" >"$text"
        content "$folder/$file" 2>&1 | cmp -s - "$text" && test -s "$text" || echo "$folder/$file"
    done <"$work/names"
}

made=0 failed=0 ranked="fig5 furrows"
for suite in bullseye bookworm trixie noble; do
    (make_root $suite) >"$work/log" 2>&1 || { echo "$suite: no root can be made: $(grep -v '^I:' "$work/log" | tail -n 1)"; continue; }
    made=$((made + 1))
    root=$roots/$suite
    rm -rf "$root/home/user"
    mkdir "$root/home/user"
    cp "$wheel" "$work/five.py" "$root/home/user"
    cp /etc/ssl/certs/ca-certificates.crt "$root/home/user/ca.crt" # of the package registry, as it is reached from here
    cp /etc/resolv.conf /etc/hosts "$root/etc"
    chown -R 1234:1234 "$root/home/user"
    commands=$try
    test $suite != bullseye || commands=$alone
    begin=$(date +%s)
    if as_user "$root" "$commands; RANKED='$ranked'; $fly; $ranks" >"$work/log" 2>&1; then
        differ=$(others "$root/home/user/openmpi" $ranked; others "$root/home/user/mpich" $ranked; others "$root/home/user/flown" .)
        test -z "$differ" && echo "$suite: installed and flown in $(($(date +%s) - begin)) s, $(find "$work/here" -name '*.mco' -o -name '*.h5' | wc -l) results as here" && continue
        echo "$suite: other results: $differ"
    else
        echo "$suite: failed" && cat "$work/log"
    fi
    failed=1
done
test $made -gt 0 || exit 77
exit $failed
