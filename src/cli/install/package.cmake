# `cpack` in the build folder makes clustermcml_VERSION_ARCH.deb, for the distribution it is built on. In Debian the
# manual page is compressed, and LICENSE gives way to a copyright file.
# SPDX-License-Identifier: MIT
find_program(GZIP gzip)
if(NOT GZIP OR NOT CLUSTERMCML_PAGES)
    return()
endif()

# The maintainer is the one who makes the package: DEBFULLNAME and DEBEMAIL, as for Debian's own tools.
set(maintainer "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
if(NOT maintainer MATCHES "^[^ ].* <.+>$")
    set(maintainer "clustermcml authors <authors@clustermcml.invalid>")
endif()

set(debian ${CMAKE_CURRENT_BINARY_DIR}/debian)
file(WRITE ${debian}/changelog "clustermcml (${PROJECT_VERSION}) unstable; urgency=medium

  * Source: ${PROJECT_VERSION} ${CLUSTERMCML_GIT}
  * samples/manual/release-notes.md lists the changes.

 -- ${maintainer}  ${CLUSTERMCML_TIME}
")
# LICENSE has a title, the copyright line and the text. In a copyright file a dot stands for an empty line.
file(READ LICENSE license)
string(REGEX MATCH "Copyright \\(c\\) ([^\n]*)\n\n(.*)$" matched "${license}")
set(holder "${CMAKE_MATCH_1}")
string(STRIP "${CMAKE_MATCH_2}" text)
string(REPLACE "\n\n" "\n.\n" text "${text}")
string(REPLACE "\n" "\n " text "${text}")
file(WRITE ${debian}/copyright "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: clustermcml

Files: *
Copyright: ${holder}
License: Expat
 ${text}
")
add_custom_command(OUTPUT ${debian}/changelog.gz ${debian}/clustermcml.1.gz
    DEPENDS ${debian}/changelog ${pages}/clustermcml.1
    COMMAND ${GZIP} -9nc ${debian}/changelog > ${debian}/changelog.gz
    COMMAND ${GZIP} -9nc ${pages}/clustermcml.1 > ${debian}/clustermcml.1.gz)
add_custom_target(debian ALL DEPENDS ${debian}/changelog.gz ${debian}/clustermcml.1.gz)
# otherwise both targets would write the manual page at the same time
add_dependencies(debian pages)
install(FILES ${debian}/changelog.gz ${debian}/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR}
        COMPONENT debian EXCLUDE_FROM_ALL)
install(FILES ${debian}/clustermcml.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT debian EXCLUDE_FROM_ALL)

set(CPACK_GENERATOR DEB)
set(CPACK_INSTALL_CMAKE_PROJECTS
    "${CMAKE_BINARY_DIR};clustermcml;Unspecified;/;${CMAKE_BINARY_DIR};clustermcml;debian;/")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
    WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_CONTACT "${maintainer}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Monte Carlo light transport in layered turbid media")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "clustermcml reads the input files of MCML, in which boundaries between layers
may also be radial heightfields or triangle meshes. It flies photon packets on
all cores, on OpenCL devices or on several machines (MPI), and writes MCML's
output files with standard errors, maps (HDF5, VTK), plots and comparisons.")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-h5py, python3-matplotlib, python3-scipy, python3-xarray")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "openmpi-bin, pocl-opencl-icd")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
