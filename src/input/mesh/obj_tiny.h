/* The C face of tinyobjloader. SPDX-License-Identifier: MIT */
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define CML_OBJ_TINY_FAILED SIZE_MAX

/* Reads the faces of an OBJ text: corner[] becomes the vertex numbers (from 0, relative ones resolved) of all
 * faces one after the other. Returns how many there are, of which the first `capacity` are stored, or
 * CML_OBJ_TINY_FAILED when the library gives up or memory runs out. Throws nothing. */
size_t cml_obj_tiny_corners(const char *text, size_t size, uint32_t *corner, size_t capacity);

#ifdef __cplusplus
}
#endif
