#!/bin/sh
# Tests the Debian package that cpack makes: lintian has no error and no warning, dependencies are found, and its program
# runs.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
build=$(dirname "$program")
for tool in cpack dpkg-deb dpkg-shlibdeps lintian; do
    command -v $tool >/dev/null || { echo "$tool is missing"; exit 77; }
done
test -f "$build/CPackConfig.cmake" || { echo "$build makes no package"; exit 77; }

cpack --config "$build/CPackConfig.cmake" -B "$work" >"$work/out" 2>&1 || complain "cpack: $(cat "$work/out")"
package=$(echo "$work"/clustermcml_*.deb)
lintian --fail-on error,warning "$package" >"$work/out" 2>&1 || complain "lintian: $(cat "$work/out")"

field() { # NAME
    dpkg-deb -f "$package" "$1"
}
test "$(field Section)" = science || complain "section $(field Section)"
test "$(field Version)" = "$("$program" --version | head -n 1 | cut -d' ' -f2)" || complain "version $(field Version)"
for library in libc6 libembree libjansson4 zlib1g; do
    field Depends | grep -q "$library" || complain "depends on no $library: $(field Depends)"
done
dpkg-deb -x "$package" "$work/root"
program=$work/root/usr/bin/clustermcml
expect_code 0 check "$work/root/usr/share/clustermcml/samples/mixed.mci"
finish
