# Puts texts into one C array, each under its file's name without the ending:
# cmake -D TEXTS=FILE,FILE... -D OUTPUT=FILE -P help_texts.cmake
# SPDX-License-Identifier: MIT
cmake_policy(VERSION 3.22)
string(REPLACE "," ";" TEXTS "${TEXTS}")
set(rows "")
set(arrays "")
foreach(file ${TEXTS})
    get_filename_component(name ${file} NAME_WE)
    file(READ ${file} bytes HEX)
    string(REGEX REPLACE "(................................)" "\\1\n" bytes "${bytes}")
    string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
    string(APPEND arrays "static const char text_${name}[] = {\n${bytes}0};\n")
    string(APPEND rows "    {\"${name}\", text_${name}},\n")
endforeach()
file(WRITE ${OUTPUT} "#include \"cli/options/help.h\"

${arrays}
const struct cml_help_text cml_help_texts[] = {
${rows}    {0, 0},
};
")
