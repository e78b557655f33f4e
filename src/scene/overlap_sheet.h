/* Part of the overlap check: do mesh boundaries cross themselves or each other?
 * A sheet is a mesh at its depth together with the horizontal outer plane that continues the mesh beyond its
 * border.
 *
 *     ____________/\_/\__/\_____________
 *     outer plane    mesh    outer plane
 *
 * All decisions are exact for the coordinates as rounded to the scene's frame.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/box_tree.h"
#include "geometry/footprint.h"
#include "geometry/mesh.h"
#include "base/status.h"
#include "geometry/triangle.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A mesh in the scene's frame with a search tree, and its outer plane. A closed mesh has no outer plane. */
struct cml_sheet {
    const struct cml_mesh *mesh;
    double (*vertex)[3]; /* [mesh->num_vertices] vertices in the scene's frame, cm; owned */
    bool *on_border;     /* [mesh->num_vertices] true for vertices on the border; owned */
    double z_plane;      /* depth of the outer plane, cm; NAN for a closed mesh */
    double top, bottom;  /* least and greatest z of the mesh and its outer plane, cm */
    struct cml_boxtree *tree;
    struct cml_footprint *footprint;
};

/* Makes the sheet of a mesh whose boundary has the nominal depth `z`. The mesh must outlive the sheet. On
 * failure the sheet is cleared. */
CML_NODISCARD cml_status cml_sheet_create(const struct cml_mesh *mesh, double z, struct cml_sheet *sheet,
                                          struct cml_error *err);

void cml_sheet_clear(struct cml_sheet *sheet);

/* Stands in for a triangle's number when the outer plane meets something. */
#define CML_SHEET_OUTER_PLANE UINT32_MAX

/* A place where sheets cross or touch. */
struct cml_sheet_overlap {
    enum cml_contact contact;
    double at[3]; /* place of the overlap in the scene's frame, cm */
    /* Vertical distance by which the upper sheet reaches below the lower one here, cm; 0: not known. */
    double depth;
    /* Numbers of the triangles that meet, of the first and of the second sheet. Messages name them if the
     * depth is not known. */
    uint32_t triangle[2];
};

/* Finds triangles of a sheet that meet elsewhere than at their common corners, or that meet the outer plane
 * outside the border. Different parts of a union may meet. */
void cml_sheet_against_itself(const struct cml_sheet *sheet, struct cml_sheet_overlap *overlap);

/* Checks that `upper` lies above `lower` everywhere. Reports the deepest vertex on the wrong side; if there
 * is none, two triangles that cross or touch. */
void cml_sheet_against_sheet(const struct cml_sheet *upper, const struct cml_sheet *lower,
                             struct cml_sheet_overlap *overlap);

/* Finds a place where two surfaces cross or touch. Which of them lies above or inside the other does not
 * matter. */
void cml_sheet_contact(const struct cml_sheet *a, const struct cml_sheet *b,
                       struct cml_sheet_overlap *overlap);

/* Returns a corner of one part of a closed mesh, scene's frame, cm. */
static inline const double *cml_sheet_part_start(const struct cml_sheet *sheet, size_t part)
{
    return sheet->vertex[sheet->mesh->triangle[sheet->mesh->part_start[part]][0]];
}

/* True if the point (scene's frame, cm), which must not lie on the sheet, lies below it; for a closed mesh:
 * inside it. */
bool cml_sheet_is_below(const struct cml_sheet *sheet, const double point[3]);
