#!/bin/sh
# Tests which symbols the shared and the static library have: abi.sh SHARED STATIC. They are those of tests/library/symbols.txt,
# which clustermcml.h declares. The soname has the number CLM_API. A change of the list that breaks callers raises CLM_API.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
list=tests/library/symbols.txt
nm -D --defined-only "$1" | awk '{ print $3 }' | LC_ALL=C sort | cmp - $list || complain "$1: other symbols than in $list"
nm -g --defined-only "$2" | awk 'NF == 3 { print $3 }' | LC_ALL=C sort | cmp - $list || complain "$2: other symbols than in $list"
grep -o '\bclm_[a-z_]*(' src/api/clustermcml.h | tr -d '(' | LC_ALL=C sort -u | comm -23 $list - | grep . && complain "clustermcml.h lacks these"
test "$(wc -l <$list)" -le 30 || complain "more than 30 functions"
number=$(sed -n 's/^#define CLM_API //p' src/api/clustermcml.h)
readelf -d "$1" | grep -q "SONAME.*\[libclustermcml.so.$number\]" || complain "the soname is not libclustermcml.so.$number"
readelf -d "$1" | grep -q "NEEDED.*libmpi" && complain "$1 needs MPI"
exit $((failures > 0))
