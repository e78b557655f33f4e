# libclustermcml, shared and static. It has one rank, whatever MPI the program has: the linker takes nothing from the archive
# that cluster_load.c defines. SPDX-License-Identifier: MIT
set(here ${CMAKE_CURRENT_LIST_DIR})
file(STRINGS ${here}/clustermcml.h CML_API REGEX "#define CLM_API ")
string(REGEX REPLACE ".* " "" CML_API ${CML_API})

add_library(cml_single OBJECT src/run/cluster/cluster_load.c src/run/cluster/cluster_single.c)
target_compile_definitions(cml_single PRIVATE ${CML_BUILD})
set_target_properties(cml_single PROPERTIES POSITION_INDEPENDENT_CODE ON)
target_link_libraries(cml_single PRIVATE cml_options)
set(CML_LIBRARY $<TARGET_OBJECTS:cml_api> $<TARGET_OBJECTS:cml_single>)

add_library(clustermcml_shared SHARED ${CML_LIBRARY})
set_target_properties(clustermcml_shared PROPERTIES OUTPUT_NAME clustermcml EXPORT_NAME clustermcml
    VERSION ${CML_API} SOVERSION ${CML_API} LINKER_LANGUAGE CXX LINK_DEPENDS ${here}/exports.map)
target_include_directories(clustermcml_shared INTERFACE $<BUILD_INTERFACE:${here}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_link_libraries(clustermcml_shared PRIVATE cml)
target_link_options(clustermcml_shared PRIVATE LINKER:--version-script=${here}/exports.map LINKER:--no-undefined LINKER:--as-needed)

# The static library is one object, whose other symbols are local.
set(archive ${CMAKE_CURRENT_BINARY_DIR}/libclustermcml.a)
set(object ${CMAKE_CURRENT_BINARY_DIR}/libclustermcml.o)
add_custom_command(OUTPUT ${archive} DEPENDS cml ${CML_LIBRARY} COMMAND_EXPAND_LISTS VERBATIM
    COMMAND ${CMAKE_C_COMPILER} -r -nostdlib -o ${object} ${CML_LIBRARY} $<TARGET_FILE:cml>
    COMMAND ${CMAKE_OBJCOPY} --wildcard --keep-global-symbol=clm_* ${object}
    COMMAND ${CMAKE_COMMAND} -E rm -f ${archive}
    COMMAND ${CMAKE_AR} rcs ${archive} ${object})
add_custom_target(clustermcml_static ALL DEPENDS ${archive})
set(CML_PRIVATE_LIBS $<TARGET_LINKER_FILE:embree> ${OpenMP_C_LIBRARIES} ${JANSSON_LINK_LIBRARIES} ${ZLIB_LIBRARIES} stdc++ m pthread)
if(CLUSTERMCML_HDF5)
    list(PREPEND CML_PRIVATE_LIBS ${HDF5_C_HL_LIBRARIES} ${HDF5_C_LIBRARIES})
endif()
if(CLUSTERMCML_OPENCL)
    list(APPEND CML_PRIVATE_LIBS ${OpenCL_LIBRARIES})
endif()

# In a wheel the Python package needs the shared library alone.
if(SKBUILD)
    install(TARGETS clustermcml_shared LIBRARY DESTINATION lib NAMELINK_SKIP)
    return()
endif()
file(RELATIVE_PATH CML_PC_PREFIX ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
foreach(library ${CML_PRIVATE_LIBS})
    string(REGEX REPLACE "^([^/$].*)$" "-l\\1" library "${library}")
    string(APPEND CML_PC_PRIVATE " ${library}")
endforeach()
configure_file(${here}/clustermcml.pc.in clustermcml.pc.in @ONLY)
file(GENERATE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/clustermcml.pc INPUT ${CMAKE_CURRENT_BINARY_DIR}/clustermcml.pc.in)
include(CMakePackageConfigHelpers)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/clustermcml)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/clustermcml-config-version.cmake COMPATIBILITY SameMinorVersion)
# the Debian package, which is of the program, leaves the component out
install(TARGETS clustermcml_shared EXPORT clustermcml LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT library)
install(EXPORT clustermcml FILE clustermcml-config.cmake NAMESPACE clustermcml:: DESTINATION ${package} COMPONENT library)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/clustermcml-config-version.cmake DESTINATION ${package} COMPONENT library)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/clustermcml.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT library)
install(FILES ${archive} DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
install(FILES ${here}/clustermcml.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT library)
