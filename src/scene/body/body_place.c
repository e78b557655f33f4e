/* SPDX-License-Identifier: MIT */
#include "scene/body/body_place.h"

#include "geometry/vec3.h"
#include "scene/body/body_shape.h"
#include "scene/overlap_sheet.h"

#include <math.h>
#include <stdlib.h>

/* A body as the comparison sees it. */
struct solid {
    const struct cml_scene_body *body;
    int number;               /* of the body, from 0 */
    struct cml_convex convex; /* unless it is a mesh */
    struct cml_sheet sheet;   /* of a mesh */
    double lower[3], upper[3], volume;
    int inside; /* number of the smallest body found around it, -1: none */
    double inside_volume;
};

static bool is_mesh(const struct solid *solid)
{
    return solid->body->form == CML_BODY_MESH;
}

static cml_status make_solid(const struct cml_scene *scene, int k, struct solid *solid, struct cml_error *err)
{
    *solid = (struct solid){.body = &scene->bodies[k], .number = k, .inside = -1, .inside_volume = INFINITY};
    cml_body_box(solid->body, solid->lower, solid->upper);
    solid->volume = cml_body_volume(solid->body);
    if (is_mesh(solid)) return cml_sheet_create(&solid->body->mesh, 0, &solid->sheet, err);
    solid->convex = cml_body_convex(solid->body);
    return CML_OK;
}

static cml_status fail_pair(const struct cml_scene *scene, const struct solid *a, const struct solid *b,
                            const double at[3], struct cml_error *err)
{
    const struct solid *later = a->number > b->number ? a : b, *earlier = later == a ? b : a;
    return cml_fail(err, CML_E_INPUT, "%s:%d: body %d meets body %d (line %d) at (%g %g %g) cm", scene->file,
                    later->body->line, later->number + 1, earlier->number + 1, earlier->body->line, at[0],
                    at[1], at[2]);
}

static void put_inside(struct solid *inner, const struct solid *outer)
{
    if (!(outer->volume < inner->inside_volume)) return;
    inner->inside = outer->number;
    inner->inside_volume = outer->volume;
}

/* How a sphere or cylinder lies to a mesh: no triangle may meet its surface; then all of them lie inside it,
 * or it lies wholly on one side of the mesh. */
static enum cml_convex_order compare_with_mesh(const struct cml_convex *convex, const struct cml_sheet *sheet,
                                               const double lower[3], const double upper[3], double at[3])
{
    const struct cml_mesh *mesh = sheet->mesh;
    size_t inside = 0;
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        struct cml_convex triangle = {.form = CML_CONVEX_TRIANGLE};
        bool near = true;
        for (int k = 0; k < 3; k++) triangle.corner[k] = sheet->vertex[mesh->triangle[t][k]];
        for (int k = 0; k < 3; k++) {
            const double a = triangle.corner[0][k], b = triangle.corner[1][k], c = triangle.corner[2][k];
            near = near && fmin(a, fmin(b, c)) <= upper[k] && fmax(a, fmax(b, c)) >= lower[k];
        }
        if (!near) continue;
        const enum cml_convex_order order = cml_convex_compare(&triangle, convex, at);
        if (order == CML_CONVEX_MEET) return order;
        inside += order == CML_CONVEX_FIRST_INSIDE;
    }
    if (inside > 0) return CML_CONVEX_SECOND_INSIDE;
    return cml_sheet_is_below(sheet, convex->centre) ? CML_CONVEX_FIRST_INSIDE : CML_CONVEX_APART;
}

static enum cml_convex_order compare_meshes(const struct solid *a, const struct solid *b, double at[3])
{
    struct cml_sheet_overlap overlap;
    cml_sheet_contact(&a->sheet, &b->sheet, &overlap);
    if (overlap.contact != CML_APART) {
        cml_vec3_copy(overlap.at, at);
        return CML_CONVEX_MEET;
    }
    if (cml_sheet_is_below(&b->sheet, a->sheet.vertex[0])) return CML_CONVEX_FIRST_INSIDE;
    return cml_sheet_is_below(&a->sheet, b->sheet.vertex[0]) ? CML_CONVEX_SECOND_INSIDE : CML_CONVEX_APART;
}

static enum cml_convex_order compare_solids(const struct solid *a, const struct solid *b, double at[3])
{
    if (is_mesh(a) && is_mesh(b)) return compare_meshes(a, b, at);
    if (is_mesh(b)) return compare_with_mesh(&a->convex, &b->sheet, a->lower, a->upper, at);
    if (!is_mesh(a)) return cml_convex_compare(&a->convex, &b->convex, at);
    const enum cml_convex_order order = compare_with_mesh(&b->convex, &a->sheet, b->lower, b->upper, at);
    return order == CML_CONVEX_FIRST_INSIDE    ? CML_CONVEX_SECOND_INSIDE
           : order == CML_CONVEX_SECOND_INSIDE ? CML_CONVEX_FIRST_INSIDE
                                               : order;
}

static cml_status compare_pair(const struct cml_scene *scene, struct solid *a, struct solid *b,
                               struct cml_error *err)
{
    double at[3] = {0};
    for (int k = 0; k < 3; k++)
        if (a->lower[k] > b->upper[k] || b->lower[k] > a->upper[k]) return CML_OK;
    const enum cml_convex_order order = compare_solids(a, b, at);
    if (order == CML_CONVEX_MEET) return fail_pair(scene, a, b, at, err);
    if (order == CML_CONVEX_FIRST_INSIDE) put_inside(a, b);
    if (order == CML_CONVEX_SECOND_INSIDE) put_inside(b, a);
    return CML_OK;
}

static cml_status check_self(const struct cml_scene *scene, const struct solid *solid, struct cml_error *err)
{
    struct cml_sheet_overlap overlap;
    if (!is_mesh(solid)) return CML_OK;
    cml_sheet_against_itself(&solid->sheet, &overlap);
    if (overlap.contact == CML_APART) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "%s:%d: body %d meets itself at (%g %g %g) cm: triangles %u and %u",
                    scene->file, solid->body->line, solid->number + 1, overlap.at[0], overlap.at[1],
                    overlap.at[2], (unsigned)overlap.triangle[0], (unsigned)overlap.triangle[1]);
}

static int compare_starts(const void *left, const void *right)
{
    const struct solid *a = left, *b = right;
    if (a->lower[0] != b->lower[0]) return a->lower[0] < b->lower[0] ? -1 : 1;
    return a->number - b->number;
}

/* Sorted along x, a body is compared with those that begin before it ends [sweep and prune]. */
static cml_status compare_all(const struct cml_scene *scene, struct solid *solids, struct cml_error *err)
{
    const size_t n = (size_t)scene->num_bodies;
    for (size_t i = 0; i < n; i++) CML_TRY(make_solid(scene, (int)i, &solids[i], err));
    for (size_t i = 0; i < n; i++) CML_TRY(check_self(scene, &solids[i], err));
    qsort(solids, n, sizeof *solids, compare_starts);
    for (size_t i = 0; i < n; i++)
        for (size_t j = i + 1; j < n && solids[j].lower[0] <= solids[i].upper[0]; j++)
            if (solids[i].body->layer == solids[j].body->layer)
                CML_TRY(compare_pair(scene, &solids[i], &solids[j], err));
    return CML_OK;
}

cml_status cml_scene_place_bodies(struct cml_scene *scene, struct cml_error *err)
{
    const size_t n = (size_t)scene->num_bodies;
    if (n == 0) return CML_OK;
    struct solid *solids = calloc(n, sizeof *solids);
    if (!solids) return cml_fail_memory(err, (double)(n * sizeof *solids), "the check of bodies");
    const cml_status status = compare_all(scene, solids, err);
    for (size_t i = 0; i < n; i++) {
        struct cml_scene_body *body = &scene->bodies[solids[i].number];
        if (status == CML_OK)
            body->host = solids[i].inside < 0 ? body->layer : cml_body_medium(scene, solids[i].inside);
        cml_sheet_clear(&solids[i].sheet);
    }
    free(solids);
    return status;
}
