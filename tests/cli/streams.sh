#!/bin/sh
# Tests standard streams that are closed, full or without a reader, and disks that are full at any size.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
scene=samples/shapes/hihill.mci
expect_code 0 $scene --photons 1000 --quiet -o "$work"
cp "$work/hihill.mco" "$work/a.mco"
cp "$work/hihill.h5" "$work/a.h5"
expect_code 0 plot "$work/a.mco" -o "$work/whole.svg"

# Closed streams: everything is written as usual but for standard output, whose failure is reported like any failed write.
closed() { # CODE FILE COMMAND...: FILE must be as it was
    wanted=$1
    file=$2
    shift 2
    rm -f "$work/$file" "$work/hihill.h5"
    code=0
    (eval "$*") || code=$?
    test $code -eq "$wanted" || complain "$*: exit $code, not $wanted"
}
for streams in '<&-' '>&-' '2>&-' '<&- >&- 2>&-'; do
    told=0
    case $streams in *'>&- 2'* | '>&-') told=5 ;; esac
    closed $told plot.svg "\"$program\" plot \"$work/a.mco\" -o \"$work/plot.svg\" $streams"
    cmp -s "$work/plot.svg" "$work/whole.svg" || complain "plot $streams: another picture"
    closed 0 hihill.mco "\"$program\" $scene --photons 1000 --quiet -o \"$work\" $streams"
    grep -v '^# User time' "$work/hihill.mco" >"$work/one"
    grep -v '^# User time' "$work/a.mco" | cmp -s - "$work/one" || complain "run $streams: another result"
done

for words in "$scene --photons 100 -o $work" "check $scene" help --version 'trace samples/thick.mci 3'; do
    closed 5 none "\"$program\" $words >&- 2>\"$work/err\""
    test "$(cat "$work/err" | grep -v ' note: ')" = 'clustermcml: standard output cannot be written' || complain "$words >&-: $(cat "$work/err")"
done

# An input that is an endless device; a name that is not UTF-8.
expect_error 2 '/dev/zero: cannot be read: it is a device (expected a file)' /dev/zero
name=$(printf 'caf\351.mci')
sed 's/hihill.mco/caf.mco/' $scene >"$work/$name"
expect_code 0 "$work/$name" --photons 100 --json -o "$work"
python3 -c 'import json, sys; scene = json.load(sys.stdin)["scene"]; sys.exit(not scene.endswith("/caf\\xe9.mci"))' <"$work/out" ||
    complain "not UTF-8: $(cat "$work/out" "$work/err")"
rm "$work/$name"

# Names with control or invisible characters: they are escaped on standard output, and stay valid names in JSON.
name=$(printf 'a\302\233b\342\200\256c\342\200\213d\357\273\277\303\251\377.mco')
LC_ALL=C sed "s/hihill.mco/$name/" $scene >"$work/strange.mci"
expect_code 0 "$work/strange.mci" --photons 100 -o "$work"
grep -qF '  -> '"$work"'/a\xc2\x9bb\xe2\x80\xaec\xe2\x80\x8bd\xef\xbb\xbfé\xff.mco' "$work/out" || complain "strange: $(cat "$work/out")"
printf '"\302\233\033[31m","\342\200\256",seed\n\302\233,\033[31m,1\n' >"$work/strange.csv"
expect_code 0 $scene --photons 100 --sweep "$work/strange.csv" -o "$work"
test "$(LC_ALL=C tr -cd '\033\233\256' <"$work/out" | wc -c)" = 0 && grep -qF '\x1b[31m=\xc2\x9b' "$work/out" || complain "labels: $(cat -v "$work/out")"
python3 - "$program" <<'EOF' || complain "characters that are not seen"
import subprocess, sys
for code in [0xad, 0x34f, 0x115f, 0x17b5, 0x180e, 0x200d, 0x3164, 0xfdd0, 0xfe0f, 0xffa0, 0xfff0, 0xfffe, 0x1bca0, 0x1d173, 0x1ffff, 0xe0041, 0x10ffff]:
    told = subprocess.run([sys.argv[1], f"é{chr(code)}.mci"], capture_output=True).stderr.decode()
    assert f"é{''.join(f'{chr(92)}x{byte:02x}' for byte in chr(code).encode())}.mci" in told, told
EOF
name=$(printf 'a\302\233b\342\200\256c\177d\363\240\201\201.mci')
cp $scene "$work/$name"
expect_code 0 "$work/$name" --photons 100 --json -o "$work"
python3 -c 'import json, sys; text = open(sys.argv[1], encoding="utf-8").read()
sys.exit(not json.loads(text)["scene"].endswith("/a\x9bb\u202ec\x7fd\U000e0041.mci") or "\U000e0041" in text or "\u202e" in text or "\x7f" in text)' "$work/out" || complain "JSON: $(cat -v "$work/out")"
rm -f "$work"/*

# Standard output is full, or has no reader: the result is written, and the exit code says that it was not printed (no reader:
# like other tools).
closed 5 hihill.mco "\"$program\" $scene --photons 1000 --json -o \"$work\" >/dev/full 2>\"$work/err\""
grep -q "standard output cannot be written" "$work/err" || complain "full: $(cat "$work/err")"
mkfifo "$work/pipe"
for words in "$scene --photons 1000 --json -o $work" 'trace samples/thick.mci 3' help; do
    (exec 3<"$work/pipe") & # opens it, and reads nothing: the end of all commands, without a word
    closed 141 hihill.mco "\"$program\" $words >\"$work/pipe\" 2>\"$work/err\""
    case $words in *json*) test -s "$work/hihill.mco" || complain "pipe: no result" ;; esac
    test ! -s "$work/err" || complain "pipe: $(cat "$work/err")"
    wait
done
rm "$work"/*

# Full disks: a limit on the size of files takes their place. It doubles from 8 kB until the result fits. An incomplete file
# never appears under its name.
mkdir "$work/disk"
full() { # SCENE FILE
    rm -f "$work/disk"/*
    expect_code 0 "$1" --photons 1000 --quiet -o "$work/disk"
    size=$(stat -c %s "$work/disk/$2")
    kib=8
    while test $((kib * 1024)) -lt "$size"; do
        rm -f "$work/disk"/*
        code=0
        (
            ulimit -f $((2 * kib)) # blocks of 512 bytes
            "$program" "$1" --photons 1000 --quiet -o "$work/disk" 2>"$work/err"
        ) || code=$?
        test $code -eq 5 || complain "$2 at $kib KiB: exit $code, not 5: $(cat "$work/err")"
        test ! -e "$work/disk/$2" || complain "$2 at $kib KiB: half a file"
        ls "$work/disk" | grep -q -e '\.tmp$' -e '\.lock$' && complain "$2 at $kib KiB left $(ls "$work/disk")"
        kib=$((kib * 2))
    done
}
full $scene hihill.mco
full samples/skinmap.mci skinmap.h5
full samples/skinmap.mci skinmap.map.vti
finish
