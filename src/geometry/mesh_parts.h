/* The steps of cml_mesh_prepare, shared only by the mesh_*.c files. Each expects the ones above it to have
 * succeeded. SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/mesh.h"

#define CML_NO_OPPOSITE UINT32_MAX

/* Half-edge 3t + k runs from vertex k to vertex k + 1 (mod 3) of triangle t; corner 3t + k is at vertex k. */
struct cml_mesh_work {
    struct cml_mesh *mesh;
    const struct cml_mesh_source *source; /* or NULL */
    struct cml_mesh_notes notes;
    uint32_t *origin;   /* [num_triangles] number of the triangle before any was dropped */
    uint32_t *opposite; /* [3 num_triangles] half-edge on the other side, or CML_NO_OPPOSITE at the border */
    uint8_t *turned;    /* [num_triangles] whether cml_mesh_orient has turned it */
};

/* Refuses what is not finite or out of range; welds; drops degenerate triangles and unused vertices. */
CML_NODISCARD cml_status cml_mesh_clean(struct cml_mesh_work *work, struct cml_error *err);

/* Whether triangle t uses a vertex twice or has an area of exactly zero. */
bool cml_mesh_is_degenerate(const struct cml_mesh *mesh, size_t t);

/* Finds the opposites; refuses an edge with more than two triangles. */
CML_NODISCARD cml_status cml_mesh_pair_edges(struct cml_mesh_work *work, struct cml_error *err);

/* Turns triangles until all of a part agree with its first; refuses parts with one side, and several of a
 * sheet; of a body mesh->part and part_start. */
CML_NODISCARD cml_status cml_mesh_orient(struct cml_mesh_work *work, struct cml_error *err);

/* Refuses a vertex whose triangles are not one fan. */
CML_NODISCARD cml_status cml_mesh_check_fans(const struct cml_mesh_work *work, struct cml_error *err);

/* Finds the border loop, refuses holes, closed bodies, a border that is not horizontal (unless mesh->skirt is
 * given) or crosses itself; turns the whole sheet when its border says that it is upside down. */
CML_NODISCARD cml_status cml_mesh_find_border(struct cml_mesh_work *work, struct cml_error *err);

/* In a closed mesh: refuses an edge of one triangle only and a part without volume, turns all triangles
 * outwards of what they bound. */
CML_NODISCARD cml_status cml_mesh_turn_outwards(struct cml_mesh_work *work, struct cml_error *err);

/* Adds mesh->skirt around the simple loop mesh->border: two triangles per edge, wound like the sheet, and as
 * many new vertices, in the order of the loop, which become the border, at the border's mean depth. That
 * triangles cross is not looked for; one without area is refused. Of *work only the notes are kept up to
 * date. */
CML_NODISCARD cml_status cml_mesh_add_skirt(struct cml_mesh_work *work, struct cml_error *err);

/* Adds to the refusal in *err how many corners of edges with one face nearly meet others, and how far apart
 * these are; nothing where none do. num_triangles: as many as cml_mesh_pair_edges has seen. */
void cml_mesh_tell_near_corners(const struct cml_mesh_work *work, size_t num_triangles,
                                struct cml_error *err);

/* The largest side of the mesh's box, cm. */
double cml_mesh_extent(const struct cml_mesh *mesh);

/* mesh->vertex_normal from triangles and border. */
CML_NODISCARD cml_status cml_mesh_find_normals(struct cml_mesh *mesh, struct cml_error *err);

/* "PATH:LINE: MESSAGE" with the parts that `work` knows; line <= 0 is left out. */
CML_NODISCARD CML_PRINTF(4, 5) cml_status
    cml_mesh_fail(const struct cml_mesh_work *work, int line, struct cml_error *err, const char *format, ...);

/* Line of triangle t in its file, 0 when unknown. */
int cml_mesh_triangle_line(const struct cml_mesh_work *work, size_t t);

/* A position for a message, "(x, y, height h) cm"; returns `text`. */
const char *cml_mesh_place(const double position[3], char text[112]);

static inline uint32_t cml_half_edge_from(const struct cml_mesh *mesh, uint32_t edge)
{
    return mesh->triangle[edge / 3][edge % 3];
}

static inline uint32_t cml_half_edge_to(const struct cml_mesh *mesh, uint32_t edge)
{
    return mesh->triangle[edge / 3][(edge % 3 + 1) % 3];
}
