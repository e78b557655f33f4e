/* Do mesh boundaries cross themselves or each other? Part of the overlap check.
 * A sheet is a mesh at its depth together with its outer plane. All decisions are exact for the coordinates
 * as rounded to the scene's frame. SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/box_tree.h"
#include "geometry/footprint.h"
#include "geometry/mesh.h"
#include "base/status.h"
#include "geometry/triangle.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A closed mesh is a sheet without an outer plane. */
struct cml_sheet {
    const struct cml_mesh *mesh;
    double (*vertex)[3]; /* [mesh->num_vertices] in the scene's frame, cm; owned */
    bool *on_border;     /* [mesh->num_vertices], owned */
    double z_plane;      /* of the outer plane, cm */
    double top, bottom;  /* least and greatest z, the plane included, cm */
    struct cml_boxtree *tree;
    struct cml_footprint *footprint;
};

/* `z` is the boundary's nominal depth; the mesh must outlive the sheet. On failure the sheet is cleared. */
CML_NODISCARD cml_status cml_sheet_create(const struct cml_mesh *mesh, double z, struct cml_sheet *sheet,
                                          struct cml_error *err);

void cml_sheet_clear(struct cml_sheet *sheet);

#define CML_SHEET_OUTER_PLANE UINT32_MAX /* stands for a triangle in a overlap */

struct cml_sheet_overlap {
    enum cml_contact contact;
    double at[3];         /* in the scene's frame, cm */
    double depth;         /* how far the upper sheet reaches below the lower one here, cm; 0: not known */
    uint32_t triangle[2]; /* where depth is not known: of the first sheet, of the second */
};

/* Triangles that meet elsewhere than at their common corners, but not of different parts of a union, or that
 * meet the outer plane outside the border. */
void cml_sheet_against_itself(const struct cml_sheet *sheet, struct cml_sheet_overlap *overlap);

/* `upper` must lie above `lower` everywhere. Finds the deepest vertex on the wrong side; only where all are
 * right, triangles that meet all the same. */
void cml_sheet_against_sheet(const struct cml_sheet *upper, const struct cml_sheet *lower,
                             struct cml_sheet_overlap *overlap);

/* Whether and where the surfaces meet, whatever lies inside of what. */
void cml_sheet_contact(const struct cml_sheet *a, const struct cml_sheet *b,
                       struct cml_sheet_overlap *overlap);

/* A corner of a part of a closed mesh. */
static inline const double *cml_sheet_part_start(const struct cml_sheet *sheet, size_t part)
{
    return sheet->vertex[sheet->mesh->triangle[sheet->mesh->part_start[part]][0]];
}

/* Whether a point (scene's frame, cm) that is not on the sheet lies below it; of a closed mesh: inside. */
bool cml_sheet_is_below(const struct cml_sheet *sheet, const double point[3]);
