/* Checksums of shapes and beams. A result stores them, so that results of different surfaces are never mixed
 * up. SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"

/* Returns the CRC-32 of a boundary's coordinates and of its kind of normals, 0 for a plane. Coordinates count
 * in single precision, so that the last bit of a processor's sines does not show. The nominal depth and the
 * file's name do not count. */
uint32_t cml_boundary_checksum(const struct cml_boundary *boundary);

/* Returns the CRC-32 of a prepared mesh: its kind of normals, its coordinates in single precision and its
 * triangles; 0 for a mesh without triangles. */
uint32_t cml_mesh_checksum(const struct cml_mesh *mesh);

/* Returns the CRC-32 of a beam's pixels and of the table of its light, in single precision. */
uint32_t cml_beam_checksum(const struct cml_beam *beam);
