# Writes all that `clustermcml help` can print into one file: cmake -D PROGRAM=COMMAND -D OUTPUT=FILE -P help.cmake
# A line stands before each part: @list, @options or @command NAME.
# SPDX-License-Identifier: MIT
cmake_policy(VERSION 3.22)
# a program under the address sanitizer must not fail because a library leaks memory
set(ENV{ASAN_OPTIONS} detect_leaks=0)

function(cml_ask part)
    execute_process(COMMAND ${PROGRAM} help ${ARGN} OUTPUT_VARIABLE answer RESULT_VARIABLE code)
    if(NOT code EQUAL 0)
        message(FATAL_ERROR "${PROGRAM} help ${ARGN}: ${code}")
    endif()
    file(APPEND ${OUTPUT} "@${part} ${ARGN}\n${answer}")
    set(answer "${answer}" PARENT_SCOPE)
endfunction()

# Finds the names of the items below a heading of the list.
function(cml_items heading result)
    string(REGEX REPLACE ".*\n${heading}\n" "" items "${list}")
    string(REGEX REPLACE "\n\n.*" "" items "\n${items}")
    string(REGEX MATCHALL "\n  \\[?[a-z]+" names "${items}")
    string(REGEX REPLACE "[\n[ ]" "" names "${names}")
    set(${result} ${names} PARENT_SCOPE)
endfunction()

file(WRITE ${OUTPUT} "")
cml_ask(list)
set(list "${answer}")
cml_ask(options options)
cml_items("commands" commands)
foreach(name ${commands})
    cml_ask(command ${name})
endforeach()
