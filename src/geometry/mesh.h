/* Triangle meshes that serve as one boundary: data, orientation, border, footprint, diagnosis.
 * A boundary mesh is one orientable 2-manifold sheet with exactly one border loop, which lies on one
 * horizontal plane; outside the border's footprint the boundary goes on as that plane to infinity. It need
 * not be a height function. Coordinates are those of the boundary's frame: x, y of the scene, z down, z = 0
 * at the boundary's nominal depth, [cm]. Knows no files and no rays. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Which normal the physics uses at a hit. The facet always decides on which side a packet is. */
enum cml_normals {
    CML_NORMALS_FACET,
    CML_NORMALS_VERTEX,   /* interpolated angle-weighted vertex normals */
    CML_NORMALS_ANALYTIC, /* of the cone that the triangle stands for (tessellated heightfields only) */
};

struct cml_mesh {
    size_t num_vertices, num_triangles;
    double (*vertex)[3];     /* [num_vertices] cm */
    uint32_t (*triangle)[3]; /* [num_triangles] counter-clockwise seen from above: cross(b-a, c-a) points up
                              * (z < 0) wherever the sheet is a height function; see cml_mesh_prepare */
    uint32_t *border;        /* [num_border] vertex indices of the border loop, from the lowest one on, along
                              * the winding of the triangles: its signed area in (x, y) is negative */
    size_t num_border;
    double z_border;           /* depth of the border's plane in the boundary's frame, cm */
    double lower[3], upper[3]; /* bounding box, cm */
    enum cml_normals normals;
    bool closed;          /* a body without a border, instead of a sheet: asked of cml_mesh_prepare */
    bool unite;           /* of a body: inside is what is inside of any part; asked of cml_mesh_prepare, which
                           * leaves it where there are several */
    size_t num_parts;     /* of a body: closed surfaces without a common corner, or 0 */
    uint32_t *part;       /* [num_triangles] which of them a triangle belongs to; of a sheet NULL */
    uint32_t *part_start; /* [num_parts] the first triangle of each, rising; of a sheet NULL */
    double skirt; /* cm: width of the skirt that cml_mesh_prepare adds to a border that is not level; 0: none,
                   * such a border is refused */
    double (*vertex_normal)[3]; /* [num_vertices] unit, angle-weighted, pointing up; at the border the outer
                                 * plane counts with its own angle; always present after prepare */
    double *slope; /* [num_triangles] dz/dr of the cone, only with CML_NORMALS_ANALYTIC, else NULL */
};

void cml_mesh_clear(struct cml_mesh *mesh);

/* Room for vertices and triangles, of which there are none yet. The mesh is cleared when memory runs out. */
CML_NODISCARD cml_status cml_mesh_allocate(struct cml_mesh *mesh, size_t vertices, size_t triangles,
                                           const char *what, struct cml_error *err);

/* One more triangle, for which there is room. */
void cml_mesh_add_triangle(struct cml_mesh *mesh, size_t a, size_t b, size_t c);

/* Copies into a new mesh; used where a boundary hands its mesh on. */
CML_NODISCARD cml_status cml_mesh_copy(const struct cml_mesh *from, struct cml_mesh *to,
                                       struct cml_error *err);

/* What a loader knows of where things stand in its file, so that messages can point there. */
struct cml_mesh_source {
    const char *path;
    const int *vertex_line;   /* [num_vertices] or NULL */
    const int *triangle_line; /* [num_triangles] or NULL */
};

/* What cml_mesh_prepare changed; printed by `check`. */
struct cml_mesh_notes {
    size_t welded;     /* vertices that were bit-equal to another one */
    size_t degenerate; /* triangles of zero area that were dropped */
    size_t unused;     /* vertices that no triangle uses, dropped */
    size_t flipped;    /* triangles whose winding was turned */
    size_t cavities;   /* of a body: parts that are one */
    size_t bent;       /* polygons whose corners lie in no plane, cut into triangles by their reader */
    double bend;       /* cm: largest distance of such a corner from its polygon's mean plane */
    double levelled;   /* cm: span of the border's heights before it was levelled, where that is more than
                        * rounding; else 0 */
    size_t skirt;      /* triangles of the skirt, the last of the mesh */
    double skirt_rise; /* cm: the largest height that it overcomes */
};

/* Makes a soup of vertices and triangles a boundary: welds bit-equal vertices, drops degenerate triangles and
 * unused vertices, checks that it is one connected orientable 2-manifold sheet with one border loop on one
 * horizontal plane (within 1e-6 of the box's largest extent; z_border becomes their mean and the border's
 * vertices are put exactly on it; beyond 1e-6, mesh->skirt > 0 leads from the border outwards to its mean
 * height: mesh_skirt.c), orients all triangles so that "up" is the side of the medium above (the
 * border's outer plane decides), computes box, border, vertex normals. Vertices and triangles keep their
 * order, so that a prepared mesh comes through unchanged; a coordinate of -0.0 becomes 0.0. `source` and
 * `notes` may be NULL. Errors (CML_E_INPUT) name path, line and place: x, y and height (-z) in cm. Crossings
 * of the sheet with itself or with its outer plane are not looked for. After an error *mesh can only be
 * cleared. */
CML_NODISCARD cml_status cml_mesh_prepare(struct cml_mesh *mesh, const struct cml_mesh_source *source,
                                          struct cml_mesh_notes *notes, struct cml_error *err);

/* Prepares the mesh of a closed body (mesh->closed) as cml_mesh_prepare does, but it has no border, which is
 * refused with an edge of it; triangles turned so that their normals point outwards; num_border is 0 and
 * z_border the body's highest depth. It may have several parts: one inside another is a cavity, whose normals
 * point into it, one inside a cavity is solid again, and so on; but with mesh->unite each part is turned
 * outwards of itself. That parts cross is not looked for; one without a volume is refused. */

/* True when every vertex lies at the same depth: the boundary is then the plane z = *z. */
bool cml_mesh_is_flat(const struct cml_mesh *mesh, double *z);

/* Height and spacing statistics for `check`. */
struct cml_mesh_summary {
    double z_mean, z_rms, peak_to_valley; /* cm; weighted with the triangles' projected area; rms about the
                                           * mean */
    double slope_rms, slope_max;          /* [-], infinite where there are vertical walls */
    double edge_median, edge_min;         /* cm; NaN when memory runs out */
};
void cml_mesh_summarise(const struct cml_mesh *mesh, struct cml_mesh_summary *summary);
