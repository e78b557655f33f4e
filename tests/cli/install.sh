#!/bin/sh
# Tests `cmake --install`: the installed program flies a sample, and the manual page renders without a warning. Manual page
# and completion know every option, command and text of the help, and every word that an option takes. The conda recipe asks
# for the packages that the Python package needs. samples/wheel.sh uses only options that the pip of Debian 12 knows.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
build=$(dirname "$program")
test -f "$build/cmake_install.cmake" || { echo "$program stands in no build folder"; exit 77; }
command -v bash >/dev/null || { echo "bash is missing"; exit 77; }

DESTDIR=$work/root cmake --install "$build" --prefix /usr >"$work/out" 2>&1 || complain "install: $(cat "$work/out")"
share=$work/root/usr/share
installed=$work/root/usr/bin/clustermcml
for file in doc/clustermcml/LICENSE doc/clustermcml/README.md doc/clustermcml/CITATION.cff; do
    cmp -s "$(basename $file)" "$share/$file" || complain "$file: missing, or another than here"
done
for file in samples/*.mci samples/*.md samples/shapes/*.mci samples/slurm.sh meshes/*.obj meshes/*.gsf meshes/*.asc; do
    cmp -s "$file" "$share/clustermcml/$file" || complain "$file: not installed"
done
test -x "$share/clustermcml/samples/slurm.sh" || complain "samples/slurm.sh: not executable"

# A sample reads a mesh beside it, with both programs; the result names the mesh as the command line does.
mkdir "$work/here" "$work/there"
expect_code 0 samples/mixed.mci --photons 1e4 --quiet -o "$work/here"
program=$installed
(cd "$share/clustermcml" && "$program" samples/mixed.mci --photons 1e4 --quiet -o "$work/there") || complain "the installed program fails"
for folder in here there; do
    grep -av '^# User time' "$work/$folder/mixed.mco" >"$work/$folder/bits"
done
cmp -s "$work/here/bits" "$work/there/bits" && test -s "$work/here/bits" || complain "the installed program gives other results"

expect_code 0 help options
options=$(grep -oE -e '^  (-[a-z], )?--[a-z-]+' "$work/out" | tr -d ' ' | tr ',' '\n' | sort -u)
expect_code 0 help
commands=$(sed -n '/^commands/,/^$/s/^  \[*\([a-z][a-z]*\).*/\1/p' "$work/out" | sort -u)
topics=$(sed -n '/^pages/,/^$/s/^  \([a-z][a-z]*\) .*/\1/p' "$work/out")
test "$(echo "$options" | wc -l)" -gt 30 && test "$(echo $commands | wc -w)" -ge 10 && test "$(echo $topics | wc -w)" -ge 3 ||
    complain "the help reads as $options, $commands, $topics"

page=$share/man/man1/clustermcml.1
if command -v man >/dev/null; then
    LC_ALL=C.UTF-8 MANWIDTH=200 MAN_KEEP_FORMATTING= man --warnings -l "$page" >"$work/page" 2>"$work/err" || complain "man: $(cat "$work/err")"
    test ! -s "$work/err" || complain "man warns: $(cat "$work/err")"
    for option in $options; do
        grep -qE -e "(^|[ ,])$option( |,|\$)" "$work/page" || complain "the manual page has no $option"
    done
    for command in $commands; do
        grep -qE "^ +clustermcml \[?$command\]?( |\$)" "$work/page" || complain "the manual page has no command $command"
    done
    for code in 0 1 2 3 4 5 75; do
        grep -qE "^ +$code +[a-z]" "$work/page" || complain "the manual page has no exit code $code"
    done
    grep -nE '^ *(## |\| |```)|`[a-z]' "$work/page" && complain "the manual page has marks of Markdown"
    for folder in $(sed -n 's/^ *PREFIX\///p' "$work/page"); do
        test -d "$work/root/usr/$folder" || complain "the manual page names $folder, which is not there"
    done
    grep -q "^$("$program" --version | head -n 1 | cut -d' ' -f1-2) " "$work/page" || complain "the manual page has another version"
else
    echo "man is missing: the manual page is not rendered"
fi
if command -v mandoc >/dev/null; then
    mandoc -T lint "$page" >"$work/out" 2>&1 || complain "mandoc: $(cat "$work/out")"
fi

# Prints the words that the shell would offer: complete WORD... completes the last word.
complete() {
    bash -c '. "$1"; shift; COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)); _clustermcml; printf "%s\n" "${COMPREPLY[@]}"' \
        bash "$share/bash-completion/completions/clustermcml" clustermcml "$@"
}
test "$(complete a.mci -)" = "$(complete a.mci "")" && complain "an option is completed as a file is"
for command in $commands; do
    expect_code 0 help "$command"
    own=$(grep -oE -e '^  (-[a-z], )?--[a-z-]+' "$work/out" | tr -d ' ' | tr ',' '\n' | sort -u)
    test "$(complete "$command" - | sort -u)" = "$own" || complain "$command: other options: $(complete "$command" -)"
done
test "$(complete a.mci -)" = "$(complete run -)" || complain "without a command: $(complete a.mci -)"
test "$(complete --quiet check a.mci -)" = "$(complete check -)" || complain "a command behind an option is not seen"
test "$(complete help inp)" = input || complain "help inp completes to $(complete help inp)"
(cd "$work/here" && complete "") | sort -u | grep -v -e mixed.mco -e mixed.h5 -e bits >"$work/out"
test "$(cat "$work/out")" = "$commands" || complain "completion offers other commands: $(cat "$work/out")"
test "$(complete a.mci --eng)" = --engine || complain "--eng completes to $(complete a.mci --eng)"
test "$(complete a.mci --photons "")" = "" || complain "a number completes to $(complete a.mci --photons "")"
# The words that an option takes are those that its own error message lists.
for option in --engine --boundaries --normals --rings --mesh-search; do
    "$program" samples/fig5.mci $option none 2>"$work/err" && complain "$option none was taken"
    words=$(sed 's/.*(expected \(one of \)*\(.*\))/\2/; s/, / /g; s/ or / /g' "$work/err" | tr ' ' '\n' | sort)
    test "$(complete a.mci $option "" | sort)" = "$words" || complain "$option completes to $(complete a.mci $option "")"
done

# The conda recipe asks for every Python package that pip would install.
run_needs=$(sed -n '/^  run:/,/^$/s/^    - \([a-z0-9-]*\).*/\1/p' src/cli/install/recipe.yaml)
needs=$(sed -n 's/^dependencies = \[\(.*\)\]/\1/p' pyproject.toml | tr -d '",')
test -n "$needs" || complain "pyproject.toml names no dependencies"
for package in $needs; do
    echo "$run_needs" | grep -qxE "${package%%[<>=]*}(-base)?" || complain "src/cli/install/recipe.yaml: no $package under run"
done
# pip 23.0.1 of Debian 12 knows --config-settings, but not its short form.
grep -nE '(^|[^ ] ) *-C[ a-z]' samples/wheel.sh && complain "samples/wheel.sh: -C is unknown to pip 23.0.1"
finish
