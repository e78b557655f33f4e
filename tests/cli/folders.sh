#!/bin/sh
# Tests folders: one that cannot be written to is found before the flight; one that disappears during the flight is reported.
# On file systems without locks (NFS) results are written, and --resume reads them.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
work=$(realpath "$work")
scene=samples/shapes/hihill.mci
mkdir "$work/folder"

# Root may write everywhere, so the test uses a read-only mount, or else another user.
if unshare -m true 2>/dev/null; then
    cat >"$work/mounted" <<E2
mount -t tmpfs -o ro none "$work/folder" && exec "$program" $scene --quiet -o "$work/folder"
E2
    code=0
    unshare -m sh "$work/mounted" 2>"$work/err" || code=$?
    reason="Read-only file system"
elif test "$(id -u)" -ne 0 || setpriv --reuid 65534 --regid 65534 --clear-groups "$program" --version >/dev/null 2>&1; then
    chmod 755 "$work"
    chmod 555 "$work/folder"
    other=
    test "$(id -u)" -ne 0 || other="setpriv --reuid 65534 --regid 65534 --clear-groups"
    code=0
    $other "$program" $scene --quiet -o "$work/folder" 2>"$work/err" || code=$?
    chmod 755 "$work/folder"
    reason="Permission denied"
else
    echo "no read-only folder: neither mounts nor another user"
    reason=
fi
if test -n "$reason"; then
    test $code -eq 5 || complain "read-only: exit $code, not 5"
    test "$(cat "$work/err")" = "clustermcml: $work/folder/hihill.mco: cannot be written ($reason)" ||
        complain "read-only: $(cat "$work/err")"
fi

# Errors of locks: 37 ENOLCK, 95 EOPNOTSUPP, 524 ENOTSUPP of the kernel. A run whose result exists is not flown again.
sed 's/^hihill.mco A/hihill.h5 B/' $scene >"$work/binary.mci"
for reason in 37 95 524; do
    mkdir "$work/nfs"
    for turn in 1 2; do
        LD_PRELOAD="$SYSTEM_FAULT" CML_LOCKS=$reason "$program" "$work/binary.mci" --photons 1e3 --resume -o "$work/nfs" \
            >"$work/out" 2>"$work/err" || complain "no locks, $reason: exit $?: $(cat "$work/err")"
    done
    grep -q '^  finished before' "$work/out" || complain "no locks, $reason: flown again: $(cat "$work/err")"
    rm -r "$work/nfs"
done

# The folder is removed when the first checkpoint is due: the program stops itself there and waits.
vanish() { # ARGUMENTS
    mkdir -p "$work/folder"
    LD_PRELOAD="$FILE_FAULT" CML_FAULT_FOLDER="$work/folder/" CML_FAULT="open 1 stop $1.mco.checkpoint.tmp" \
        "$program" "$2" --quiet -o "$work/folder" --photons "$3" --checkpoint 1e-9 2>"$work/err" &
    run=$!
    until grep -qs '^State:.*stopped' /proc/$run/status || ! kill -0 $run; do sleep 0.02; done
    rm -r "$work/folder"
    test -z "${4-}" || kill -"$4" $run
    kill -CONT $run
    code=0
    wait $run || code=$?
    test $code -eq 5 || complain "$1 vanished: exit $code, not 5"
    test ! -e "$work/folder" || complain "$1 vanished: the folder is there again"
}
vanish hihill $scene 1e5
note="clustermcml: note: $work/folder/hihill.mco.checkpoint: cannot be written (No such file or directory)"
test "$(head -n 1 "$work/err")" = "$note" || complain "no note: $(cat "$work/err")"
test "$(tail -n 1 "$work/err")" = "clustermcml: $work/folder/hihill.mco: cannot be written (No such file or directory)" ||
    complain "vanished: $(cat "$work/err")"
vanish hihill $scene 1e9 TERM
test "$(tail -n 1 "$work/err")" = "clustermcml: ${note#*note: }" || complain "vanished and stopped: $(cat "$work/err")"

# -o makes a missing folder and its parents. If nothing is flown, they are removed again.
expect_code 0 $scene --photons 20 --quiet -o "$work/new/one/two"
test -f "$work/new/one/two/hihill.mco" || complain "a new folder: $(ls -R "$work/new")"
expect_code 0 mesh $scene -o "$work/new/mesh/"
test -f "$work/new/mesh/hihill.mco.boundary0.obj" || complain "a new folder for meshes: $(ls "$work/new/mesh")"
: >"$work/new/file"
expect_error 5 "$work/new/file: cannot be made (File exists; expected a folder)" $scene -o "$work/new/file/none"
sed 's/hihill.mco/hihill.lock/' $scene >"$work/locked.mci"
expect_code 2 "$work/locked.mci" -o "$work/new/none"
test ! -e "$work/new/none" || complain "a folder of a file that is refused"
finish
