# The files that `cmake --install` copies. The manual page and the completion come from the program's own help;
# their templates stand in this folder. package.cmake makes a Debian package of these files.
# SPDX-License-Identifier: MIT
set(here ${CMAKE_CURRENT_LIST_DIR})
set(pages ${CMAKE_CURRENT_BINARY_DIR}/pages)

# The date is that of the commit, so that the same source gives the same bytes.
execute_process(COMMAND git -C ${CMAKE_CURRENT_SOURCE_DIR} log -1 --date=format:%Y-%m-%d --format=%cd
                OUTPUT_VARIABLE CLUSTERMCML_DATE OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
execute_process(COMMAND git -C ${CMAKE_CURRENT_SOURCE_DIR} log -1 --format=%cD
                OUTPUT_VARIABLE CLUSTERMCML_TIME OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT CLUSTERMCML_DATE)
    string(TIMESTAMP CLUSTERMCML_DATE "%Y-%m-%d" UTC)
    string(TIMESTAMP CLUSTERMCML_TIME "%a, %d %b %Y %H:%M:%S +0000" UTC)
endif()

# A program built for another machine cannot print its help, unless an emulator runs it.
set(CLUSTERMCML_PAGES ON)
if(CMAKE_CROSSCOMPILING AND NOT CMAKE_CROSSCOMPILING_EMULATOR)
    set(CLUSTERMCML_PAGES OFF)
    message(STATUS "no manual page and no completion: the program does not run on this machine")
endif()

function(cml_fill template output)
    add_custom_command(OUTPUT ${pages}/${output} DEPENDS ${pages}/help ${here}/help.awk ${here}/${template}
        COMMAND ${AWK} -v version=${PROJECT_VERSION} -v date=${CLUSTERMCML_DATE}
                -v datadir=${CMAKE_INSTALL_DATADIR} -f ${here}/help.awk ${pages}/help ${here}/${template}
                > ${pages}/${output})
endfunction()

install(TARGETS clustermcml RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(FILES README.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT plain)
# without the scripts that build from source, and those that make the samples
install(DIRECTORY samples meshes DESTINATION ${CMAKE_INSTALL_DATADIR}/clustermcml
        FILES_MATCHING PATTERN "*.mci" PATTERN "*.obj" PATTERN "*.gsf" PATTERN "*.asc" PATTERN "*.md" PATTERN "*.png"
        PATTERN "*.txt" PATTERN "*.ipynb")
# The Python package, for plot, compare and view; in a wheel it lies above the program.
if(NOT SKBUILD)
    install(DIRECTORY src/python/clustermcml DESTINATION ${CMAKE_INSTALL_DATADIR}/clustermcml/python
            FILES_MATCHING PATTERN "*.py" PATTERN "*.csv" PATTERN "py.typed" PATTERN "__pycache__" EXCLUDE)
endif()
install(PROGRAMS samples/slurm.sh samples/slurm-array.sh DESTINATION ${CMAKE_INSTALL_DATADIR}/clustermcml/samples)
if(CLUSTERMCML_PAGES)
    find_program(AWK NAMES mawk gawk awk REQUIRED)
    file(MAKE_DIRECTORY ${pages})
    add_custom_command(OUTPUT ${pages}/help DEPENDS clustermcml ${here}/help.cmake
        COMMAND ${CMAKE_COMMAND} -D "PROGRAM=${CMAKE_CROSSCOMPILING_EMULATOR};$<TARGET_FILE:clustermcml>"
                -D OUTPUT=${pages}/help -P ${here}/help.cmake VERBATIM)
    cml_fill(clustermcml.1.in clustermcml.1)
    cml_fill(clustermcml.bash.in clustermcml)
    add_custom_target(pages ALL DEPENDS ${pages}/clustermcml.1 ${pages}/clustermcml)
    install(FILES ${pages}/clustermcml.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT plain)
    install(FILES ${pages}/clustermcml DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
else()
    add_custom_target(pages DEPENDS clustermcml)
endif()

include(${here}/package.cmake)
