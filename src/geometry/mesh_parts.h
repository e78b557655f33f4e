/* The steps of cml_mesh_prepare, shared only by the mesh_*.c files. Each step expects the steps above it to
 * have succeeded. SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/mesh.h"

#define CML_NO_OPPOSITE UINT32_MAX

/* The state of cml_mesh_prepare. Half-edge 3t + k runs from vertex k to vertex k + 1 (mod 3) of triangle t;
 * corner 3t + k is at vertex k:
 *
 *            2
 *      3t+2 / \ 3t+1
 *          0---1
 *           3t */
struct cml_mesh_work {
    struct cml_mesh *mesh;
    const struct cml_mesh_source *source; /* where the mesh stands in its file, or NULL */
    struct cml_mesh_notes notes;
    uint32_t *origin;   /* [num_triangles] number that each triangle had before triangles were dropped */
    uint32_t *opposite; /* [3 num_triangles] half-edge of the neighbour, or CML_NO_OPPOSITE at the border */
    size_t num_paired;  /* number of triangles whose edges are paired */
    uint8_t *turned;    /* [num_triangles] true if cml_mesh_orient has reversed the triangle */
};

/* Refuses coordinates that are not finite or too large; joins equal vertices, or near ones; drops degenerate
 * triangles and unused vertices. */
CML_NODISCARD cml_status cml_mesh_clean(struct cml_mesh_work *work, struct cml_error *err);

/* True if triangle t uses a vertex twice or has an area of exactly zero. */
bool cml_mesh_is_degenerate(const struct cml_mesh *mesh, size_t t);

/* Finds each half-edge's opposite. Refuses an edge with more than two triangles. */
CML_NODISCARD cml_status cml_mesh_pair_edges(struct cml_mesh_work *work, struct cml_error *err);

/* Reverses triangles until all triangles of a part agree with the part's first triangle. Refuses a part that
 * has only one side, like a Moebius strip. Refuses a boundary's mesh if it has several parts, and then leaves
 * them in mesh->part. For a body sets mesh->part and part_start. */
CML_NODISCARD cml_status cml_mesh_orient(struct cml_mesh_work *work, struct cml_error *err);

/* Refuses a vertex whose triangles are not one fan. */
CML_NODISCARD cml_status cml_mesh_check_fans(const struct cml_mesh_work *work, struct cml_error *err);

/* Finds the border loop. Refuses holes, closed bodies, a border that is not horizontal (unless mesh->skirt is
 * set), and a border that crosses itself. Reverses the whole sheet if its border shows that it is upside
 * down. */
CML_NODISCARD cml_status cml_mesh_find_border(struct cml_mesh_work *work, struct cml_error *err);

/* Checks and orients a closed mesh: refuses an edge of only one triangle and a part without volume, and turns
 * all normals out of the solid. */
CML_NODISCARD cml_status cml_mesh_turn_outwards(struct cml_mesh_work *work, struct cml_error *err);

/* Adds a skirt of width mesh->skirt around the simple loop mesh->border, ending at the border's mean depth.
 * Each edge gets two triangles, wound like the sheet, and each vertex a new vertex; the new vertices become
 * the border, in the loop's order. Triangles that cross are not searched for; a triangle without area is
 * refused. In *work only the notes are updated. */
CML_NODISCARD cml_status cml_mesh_add_skirt(struct cml_mesh_work *work, struct cml_error *err);

/* A function that returns whether a copy of the mesh can be prepared with another weld=. */
typedef bool cml_mesh_trial(const struct cml_mesh_work *work, double weld);

/* Adds to the refusal in *err what the user should know of corners: how many of edges with one face nearly
 * meet others, their largest distance, and which weld= joins them; how far the parts of a sheet are from each
 * other; or how many corners the given weld= has joined. Adds nothing if nothing of this is so. */
void cml_mesh_tell_of_corners(const struct cml_mesh_work *work, cml_mesh_trial *try_weld,
                              struct cml_error *err);

/* Returns a hash of three coordinates. -0.0 has another one than 0.0. */
size_t cml_mesh_hash(const double p[3]);

/* Some vertices of a mesh, in cubic cells whose width is the largest distance that is asked for. The time of
 * a search does not depend on the number of vertices elsewhere. */
struct cml_mesh_near {
    const struct cml_mesh *mesh; /* borrowed */
    double width;                /* cm, > 0 */
    uint32_t *first, *next;      /* [mask + 1], [num_vertices] lists of vertices, by the hash of their cell */
    size_t mask;
};

/* Begins without vertices. Fails if memory runs out. End in any case: near = {0} is allowed. */
CML_NODISCARD cml_status cml_mesh_near_begin(struct cml_mesh_near *near, const struct cml_mesh *mesh,
                                             double width, struct cml_error *err);
void cml_mesh_near_end(struct cml_mesh_near *near);

/* Adds a vertex, which must not have been added. */
void cml_mesh_near_add(struct cml_mesh_near *near, uint32_t vertex);

/* A callback of cml_mesh_near_visit. distance: from vertex to other, cm. */
typedef void cml_mesh_near_call(void *context, uint32_t vertex, uint32_t other, double distance);

/* Calls `call` for each other added vertex that is nearer to `vertex` than the width; for some more than
 * once. */
void cml_mesh_near_visit(const struct cml_mesh_near *near, uint32_t vertex, cml_mesh_near_call *call,
                         void *context);

/* Returns the largest side of the mesh's box, cm. */
double cml_mesh_extent(const struct cml_mesh *mesh);

/* Computes mesh->vertex_normal from the triangles and the border. */
CML_NODISCARD cml_status cml_mesh_find_normals(struct cml_mesh *mesh, struct cml_error *err);

/* Refuses a mesh: "PATH:LINE: MESSAGE", as far as `work` knows path and line; line <= 0 is left out. Returns
 * CML_E_INPUT. */
CML_NODISCARD CML_PRINTF(4, 5) cml_status
    cml_mesh_fail(const struct cml_mesh_work *work, int line, struct cml_error *err, const char *format, ...);

/* Returns the line of triangle t in its file; 0 if unknown. */
int cml_mesh_triangle_line(const struct cml_mesh_work *work, size_t t);

/* Prints a position for a message, "(x, y, height h) cm". Returns `text`. */
const char *cml_mesh_place(const double position[3], char text[112]);

/* Returns the vertex at which a half-edge begins. */
static inline uint32_t cml_half_edge_from(const struct cml_mesh *mesh, uint32_t edge)
{
    return mesh->triangle[edge / 3][edge % 3];
}

/* Returns the vertex at which a half-edge ends. */
static inline uint32_t cml_half_edge_to(const struct cml_mesh *mesh, uint32_t edge)
{
    return mesh->triangle[edge / 3][(edge % 3 + 1) % 3];
}
