# Compiles for the machine $WHEEL_ARCH with gcc 12 of Debian 12, against the root of Debian 11 in $WHEEL_ROOT. Its glibc has
# no symbols later than those of 2.31, and CMakeLists.txt beside this file avoids the five of 2.29 that are called.
# SPDX-License-Identifier: MIT
set(root $ENV{WHEEL_ROOT})
set(triplet $ENV{WHEEL_ARCH}-linux-gnu)
if(NOT CMAKE_HOST_SYSTEM_PROCESSOR STREQUAL "$ENV{WHEEL_ARCH}")
    set(CMAKE_SYSTEM_NAME Linux)
    set(CMAKE_SYSTEM_PROCESSOR $ENV{WHEEL_ARCH})
    # the compiler's own headers of a later glibc would come first
    set(CMAKE_C_FLAGS_INIT "-isystem ${root}/usr/include/${triplet} -isystem ${root}/usr/include")
    set(library /usr/${triplet}/include/c++/12) # before the root's, which it wraps
    set(CMAKE_CXX_FLAGS_INIT "-nostdinc++ -isystem ${library} -isystem ${library}/${triplet} ${CMAKE_C_FLAGS_INIT}")
    set(CMAKE_CROSSCOMPILING_EMULATOR qemu-$ENV{WHEEL_ARCH}-static -L ${root})
endif()
set(CMAKE_C_COMPILER ${triplet}-gcc-12)
set(CMAKE_CXX_COMPILER ${triplet}-g++-12)
set(CMAKE_SYSROOT ${root})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(kind LIBRARY INCLUDE PACKAGE)
    set(CMAKE_FIND_ROOT_PATH_MODE_${kind} ONLY)
endforeach()
set(ENV{PKG_CONFIG_LIBDIR} ${root}/usr/local/lib/pkgconfig)

# Without -B and -L gcc would take the start files and libpthread of the machine that compiles.
foreach(kind EXE SHARED MODULE)
    set(CMAKE_${kind}_LINKER_FLAGS_INIT
        "-B${root}/usr/lib/${triplet}/ -L${root}/usr/lib/${triplet} -L${root}/lib/${triplet} -static-libstdc++")
endforeach()
# The runtime of OpenMP is the root's, where CMake would take the compiler's.
set(OpenMP_C_FLAGS -fopenmp CACHE STRING "")
set(OpenMP_C_LIB_NAMES gomp CACHE STRING "")
set(OpenMP_gomp_LIBRARY ${root}/usr/lib/${triplet}/libgomp.so.1 CACHE FILEPATH "")
# h5cc of the machine would name its libraries
set(HDF5_DIR ${root}/usr/local/share/cmake CACHE PATH "")
set(HDF5_USE_STATIC_LIBRARIES ON)
