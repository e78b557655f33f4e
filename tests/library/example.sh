#!/bin/sh
# Tests the program in samples/manual/developers/c-library.md as a user builds it: from the installed files, with pkg-config and with
# CMake, in C11 and in C++11, with the shared and with the static library. Its numbers are those of the command line, to all
# digits. valgrind finds no leak. The same of a scene of which an .mco and an .h5 are written.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
build=$(dirname "$program")
test -f "$build/cmake_install.cmake" || { echo "$program stands in no build folder"; exit 77; }
command -v pkg-config >/dev/null || { echo "pkg-config is missing"; exit 77; }

cmake --install "$build" --prefix "$work/usr" --component library >"$work/out" 2>&1 || complain "install: $(cat "$work/out")"
PKG_CONFIG_PATH=$(dirname "$(find "$work/usr" -name clustermcml.pc)")
export PKG_CONFIG_PATH
lib=$(pkg-config --variable=libdir clustermcml)
sed -n '/^```c$/,/^```$/{/^```/!p;}' samples/manual/developers/c-library.md >"$work/example.c"
cp "$work/example.c" "$work/example.cpp"

built() { # NAME COMMAND...
    name=$1
    shift
    "$@" -o "$work/$name" >"$work/out" 2>&1 || complain "$name: $(cat "$work/out")"
    LD_LIBRARY_PATH=$lib "$work/$name" samples/fig5.mci >"$work/$name.out" 2>"$work/$name.err" || complain "$name: $(cat "$work/$name.err")"
    cmp -s "$work/expected" "$work/$name.out" || complain "$name: $(cat "$work/$name.out")"
}

for mua in 0.1 0.2 0.3; do
    expect_code 0 samples/fig5.mci --photons 1e5 --seed 7 --set layer1.mua=$(python3 -c "print('%.17g' % sum([0.1] * round($mua * 10)))") --json -o "$work"
    python3 -c "import json, sys; told = json.load(sys.stdin); print('mua $mua: Rd = %.17g +- %.1g' % (told['Rd'], told['Rd_se']))" <"$work/out"
done >"$work/expected"
built shared ${CC:-cc} -std=c11 -Wall -Wextra -Werror -pedantic "$work/example.c" $(pkg-config --cflags --libs clustermcml)
built c++ ${CXX:-c++} -std=c++11 -Wall -Wextra -Werror -pedantic "$work/example.cpp" $(pkg-config --cflags --libs clustermcml)
built static ${CC:-cc} -std=c11 "$work/example.c" $(pkg-config --cflags clustermcml) "$lib/libclustermcml.a" \
    $(pkg-config --static --libs clustermcml | sed 's/-lclustermcml//')
LD_LIBRARY_PATH=$lib "$work/shared" >/dev/null 2>&1 && complain "without a scene the example succeeds"
LD_LIBRARY_PATH=$lib "$work/shared" samples/none.mci >"$work/out" 2>"$work/err"
grep -q 'samples/none.mci' "$work/err" && test "$(wc -l <"$work/err")" -eq 1 || complain "a missing scene: $(cat "$work/err")"

mkdir "$work/project"
printf '%s\n' 'cmake_minimum_required(VERSION 3.22)' 'project(example C)' "find_package(clustermcml $(pkg-config --modversion clustermcml) REQUIRED)" \
    'add_executable(example ../example.c)' 'target_link_libraries(example PRIVATE clustermcml::clustermcml)' >"$work/project/CMakeLists.txt"
cmake -S "$work/project" -B "$work/project/build" -DCMAKE_PREFIX_PATH="$work/usr" >"$work/out" 2>&1 &&
    cmake --build "$work/project/build" >>"$work/out" 2>&1 || complain "find_package: $(cat "$work/out")"
"$work/project/build/example" samples/fig5.mci 2>/dev/null | cmp -s - "$work/expected" || complain "find_package: other numbers"

if command -v valgrind >/dev/null; then
    LD_LIBRARY_PATH=$lib valgrind --quiet --leak-check=full --errors-for-leak-kinds=definite,indirect,possible \
        --error-exitcode=9 "$work/shared" samples/fig5.mci >"$work/out" 2>"$work/err" || complain "valgrind: $(grep == "$work/err" | head -40)"
fi
exit $((failures > 0))
