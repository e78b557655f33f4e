/* Numbers that tell shapes apart, so that results of different surfaces are not taken for one another.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"

/* CRC-32 of coordinates in single precision, in which the last bit of a processor's sines does not show, and
 * of the kind of normals. The nominal depth and the file's name do not count. 0 for a plane. */
uint32_t cml_boundary_checksum(const struct cml_boundary *boundary);

/* CRC-32 of a prepared mesh, of its coordinates in single precision and of the kind of normals. */
uint32_t cml_mesh_checksum(const struct cml_mesh *mesh);

/* CRC-32 of the pixels of a beam and of the table of its light, in single precision. */
uint32_t cml_beam_checksum(const struct cml_beam *beam);
