# Puts the kernel and the headers it includes into one C array: cmake -D KERNELS=DIR -D OUTPUT=FILE -P opencl_text.cmake
# A header is put where it is included first, without its #pragma once, and left out where it is included again.
# SPDX-License-Identifier: MIT
cmake_policy(VERSION 3.22)
file(READ ${KERNELS}/transport.cl text)
set(seen "")
while(text MATCHES "#include \"([a-z_]+\\.h)\"\n")
    set(line "${CMAKE_MATCH_0}")
    set(header "")
    if(NOT CMAKE_MATCH_1 IN_LIST seen)
        list(APPEND seen ${CMAKE_MATCH_1})
        file(READ ${KERNELS}/${CMAKE_MATCH_1} header)
        string(REPLACE "#pragma once\n" "" header "${header}")
    endif()
    string(FIND "${text}" "${line}" place)
    string(LENGTH "${line}" length)
    math(EXPR behind "${place} + ${length}")
    string(SUBSTRING "${text}" 0 ${place} before)
    string(SUBSTRING "${text}" ${behind} -1 behind)
    set(text "${before}${header}${behind}")
endwhile()
file(WRITE ${OUTPUT}.text "${text}")
file(READ ${OUTPUT}.text bytes HEX)
string(REGEX REPLACE "(................................)" "\\1\n" bytes "${bytes}")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
file(WRITE ${OUTPUT} "#include <stddef.h>
extern const char cml_opencl_text[];
extern const size_t cml_opencl_text_size;
const char cml_opencl_text[] = {\n${bytes}0};
const size_t cml_opencl_text_size = sizeof cml_opencl_text - 1;
")
