# Puts the pages of the manual into one C array, each under its path without the ending:
# cmake -D MANUAL=FOLDER -D OUTPUT=FILE -P help_texts.cmake
# SPDX-License-Identifier: MIT
cmake_policy(VERSION 3.22)
file(GLOB_RECURSE pages RELATIVE ${MANUAL} ${MANUAL}/*.md)
list(REMOVE_ITEM pages python/api.md) # names docstrings only
list(SORT pages)
set(rows "")
set(arrays "")
set(number 0)
foreach(page ${pages})
    string(REGEX REPLACE "\\.md$" "" name ${page})
    get_filename_component(word ${name} NAME)
    if(word STREQUAL "index" AND name MATCHES "/")
        get_filename_component(word ${name} DIRECTORY)
    endif()
    file(READ ${MANUAL}/${page} bytes HEX)
    string(REGEX REPLACE "(................................)" "\\1\n" bytes "${bytes}")
    string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${bytes}")
    string(APPEND arrays "static const char text_${number}[] = {\n${bytes}0};\n")
    string(APPEND rows "    {\"${name}\", \"${word}\", text_${number}},\n")
    math(EXPR number "${number} + 1")
endforeach()
file(WRITE ${OUTPUT} "#include \"cli/options/manual.h\"

${arrays}
const struct cml_manual_page cml_manual[] = {
${rows}    {0, 0, 0},
};
")
