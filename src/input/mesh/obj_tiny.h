/* C interface to tinyobjloader, a library in C++. SPDX-License-Identifier: MIT */
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define CML_OBJ_TINY_FAILED SIZE_MAX

/* Reads the faces of an OBJ text. corner[] receives the vertex numbers of all faces, one after the other,
 * from 0, with relative numbers resolved. Returns how many there are; only the first `capacity` are stored.
 * Returns CML_OBJ_TINY_FAILED when the library gives up or memory runs out. Throws nothing. */
size_t cml_obj_tiny_corners(const char *text, size_t size, uint32_t *corner, size_t capacity);

#ifdef __cplusplus
}
#endif
