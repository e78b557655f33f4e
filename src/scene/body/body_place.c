/* SPDX-License-Identifier: MIT */
#include "scene/body/body_place.h"

#include "geometry/vec3.h"
#include "scene/body/body_shape.h"
#include "scene/overlap_sheet.h"

#include <stdlib.h>

/* A body as the comparison sees it. */
struct solid {
    const struct cml_scene_body *body;
    struct cml_sheet *sheet; /* sheet of a mesh; NULL for other forms */
    double volume;           /* volume of the body's bounding box, cm^3 */
    int number;              /* number of the body, from 0 */
    int host;                /* medium directly around the body */
};

/* All bodies, sorted first by layer and volume, later by host, and the state of the search. */
struct placing {
    const struct cml_scene *scene;
    size_t count;
    struct solid *solid; /* [count] bodies in the current order */
    double (*box)[2][3]; /* [count] their bounding boxes */
    size_t first;        /* first solid of the range whose tree is searched */
    cml_status status;   /* status of the comparisons; a failure ends them */
    struct cml_error *err;
};

/* Prepares body k for comparison with other bodies: its box's volume, by which bodies are ordered, and for a
 * mesh its sheet. */
static cml_status make_solid(const struct cml_scene *scene, int k, struct cml_sheet *sheet,
                             struct solid *solid, struct cml_error *err)
{
    const struct cml_scene_body *body = &scene->bodies[k];
    double lower[3], upper[3];
    cml_body_box(body, lower, upper);
    *solid = (struct solid){.body = body, .number = k, .host = body->layer, .volume = 1};
    for (int i = 0; i < 3; i++) solid->volume *= upper[i] - lower[i];
    if (body->form != CML_BODY_MESH) return CML_OK;
    solid->sheet = sheet;
    return cml_sheet_create(&body->mesh, 0, sheet, err);
}

/* Refuses two bodies that touch or overlap at the place `at`. The message is about the line that comes later
 * in the file. */
static cml_status fail_pair(const struct cml_scene *scene, const struct solid *a, const struct solid *b,
                            enum cml_convex_order order, const double at[3], struct cml_error *err)
{
    const struct solid *later = a->number > b->number ? a : b, *earlier = later == a ? b : a;
    const bool overlap = order == CML_CONVEX_OVERLAP;
    return cml_fail(err, CML_E_INPUT, "%s:%d: body %d %s body %d (line %d) at (%g %g %g) cm%s", scene->file,
                    later->body->line, later->number + 1, overlap ? "overlaps" : "meets", earlier->number + 1,
                    earlier->body->line, at[0], at[1], at[2],
                    overlap ? " (expected all parts of one inside the other, or none)"
                            : " (expected bodies apart, or one inside the other)");
}

/* Arguments and findings of a search among the triangles of a mesh near a sphere or cylinder. */
struct facets {
    const struct cml_sheet *sheet;
    const struct cml_convex *convex;
    size_t inside; /* number of triangles inside the sphere or cylinder; SIZE_MAX: one meets its surface */
    double *at;
};

/* Notes how a sphere or cylinder lies to one facet of a mesh. The search among the facets' boxes calls it
 * for each facet that comes near. */
static void compare_with_facet(void *context, uint32_t t)
{
    struct facets *facets = context;
    struct cml_convex triangle = {.form = CML_CONVEX_TRIANGLE};
    if (facets->inside == SIZE_MAX) return;
    for (int k = 0; k < 3; k++)
        triangle.corner[k] = facets->sheet->vertex[facets->sheet->mesh->triangle[t][k]];
    const enum cml_convex_order order = cml_convex_compare(&triangle, facets->convex, facets->at);
    facets->inside += order == CML_CONVEX_FIRST_INSIDE;
    if (order == CML_CONVEX_MEET) facets->inside = SIZE_MAX;
}

size_t cml_compare_with_facets(const struct cml_sheet *sheet, const struct cml_convex *convex,
                               const double lower[3], const double upper[3], double at[3])
{
    struct facets facets = {.sheet = sheet, .convex = convex, .at = at};
    cml_boxtree_touching(sheet->tree, lower, upper, compare_with_facet, &facets);
    return facets.inside;
}

/* Tells how a sphere or cylinder lies to a mesh; at: a common point, if they meet. If no triangle meets its
 * surface, either all triangles lie inside it, or none does and it lies wholly on one side of the mesh. */
static enum cml_convex_order compare_with_mesh(const struct cml_scene_body *body,
                                               const struct cml_sheet *sheet, double at[3])
{
    const struct cml_convex convex = cml_body_convex(body);
    double lower[3], upper[3];
    cml_body_box(body, lower, upper);
    const size_t inside = cml_compare_with_facets(sheet, &convex, lower, upper, at);
    if (inside == SIZE_MAX) return CML_CONVEX_MEET;
    if (inside == sheet->mesh->num_triangles) return CML_CONVEX_SECOND_INSIDE;
    cml_vec3_copy(convex.centre, at);
    if (inside > 0) return CML_CONVEX_OVERLAP;
    return cml_sheet_is_below(sheet, convex.centre) ? CML_CONVEX_FIRST_INSIDE : CML_CONVEX_APART;
}

/* Returns the number of parts of a that lie inside b; a and b must not meet. at: a corner of one such
 * part. */
static size_t count_inside(const struct cml_sheet *a, const struct cml_sheet *b, double at[3])
{
    size_t inside = 0;
    for (size_t k = 0; k < a->mesh->num_parts; k++) {
        const double *corner = cml_sheet_part_start(a, k);
        if (!cml_sheet_is_below(b, corner)) continue;
        cml_vec3_copy(corner, at);
        inside++;
    }
    return inside;
}

/* Tells how two mesh bodies lie to each other. If their surfaces are apart, a lies inside b only if all parts
 * of a do and no part of b lies inside a: a part of a might enclose a part, or a cavity, of b. A body in a
 * cavity of another one is apart from it. */
static enum cml_convex_order compare_meshes(const struct solid *a, const struct solid *b, double at[3])
{
    struct cml_sheet_overlap overlap;
    cml_sheet_contact(a->sheet, b->sheet, &overlap);
    if (overlap.contact != CML_APART) {
        cml_vec3_copy(overlap.at, at);
        return CML_CONVEX_MEET;
    }
    const size_t of_a = count_inside(a->sheet, b->sheet, at), of_b = count_inside(b->sheet, a->sheet, at);
    if (of_a == 0 && of_b == 0) return CML_CONVEX_APART;
    if (of_a == a->sheet->mesh->num_parts && of_b == 0) return CML_CONVEX_FIRST_INSIDE;
    return of_b == b->sheet->mesh->num_parts && of_a == 0 ? CML_CONVEX_SECOND_INSIDE : CML_CONVEX_OVERLAP;
}

/* Says how two bodies lie to each other: apart, one inside the other, or meeting; at: a common point, if
 * they meet. For each pair of forms another function decides. The order is turned round if the arguments had
 * to change places. */
static enum cml_convex_order compare_solids(const struct solid *a, const struct solid *b, double at[3])
{
    if (a->sheet && b->sheet) return compare_meshes(a, b, at);
    if (b->sheet) return compare_with_mesh(a->body, b->sheet, at);
    if (!a->sheet) {
        const struct cml_convex one = cml_body_convex(a->body), other = cml_body_convex(b->body);
        return cml_convex_compare(&one, &other, at);
    }
    const enum cml_convex_order order = compare_with_mesh(b->body, a->sheet, at);
    return order == CML_CONVEX_FIRST_INSIDE    ? CML_CONVEX_SECOND_INSIDE
           : order == CML_CONVEX_SECOND_INSIDE ? CML_CONVEX_FIRST_INSIDE
                                               : order;
}

/* Refuses a body whose mesh crosses or touches itself. */
static cml_status check_self(const struct cml_scene *scene, const struct solid *solid, struct cml_error *err)
{
    struct cml_sheet_overlap overlap;
    if (!solid->sheet) return CML_OK;
    cml_sheet_against_itself(solid->sheet, &overlap);
    if (overlap.contact == CML_APART) return CML_OK;
    return cml_fail(
        err, CML_E_INPUT,
        "%s:%d: body %d meets itself at (%g %g %g) cm: triangles %u and %u (expected a surface that "
        "does not)",
        scene->file, solid->body->line, solid->number + 1, overlap.at[0], overlap.at[1], overlap.at[2],
        (unsigned)overlap.triangle[0], (unsigned)overlap.triangle[1]);
}

/* Orders bodies by layer, then by the volume of their boxes. No body lies inside one that comes before it,
 * whose box is smaller. */
static int compare_volumes(const void *left, const void *right)
{
    const struct solid *a = left, *b = right;
    if (a->body->layer != b->body->layer) return a->body->layer - b->body->layer;
    if (a->volume != b->volume) return a->volume < b->volume ? -1 : 1;
    return a->number - b->number;
}

/* Orders bodies by the medium or body that surrounds them, then by number. */
static int compare_hosts(const void *left, const void *right)
{
    const struct solid *a = left, *b = right;
    return a->host != b->host ? a->host - b->host : a->number - b->number;
}

/* Sorts the bodies, and puts their boxes in the new order. */
static void sort(struct placing *p, int (*compare)(const void *, const void *))
{
    qsort(p->solid, p->count, sizeof *p->solid, compare);
    for (size_t i = 0; i < p->count; i++) cml_body_box(p->solid[i].body, p->box[i][0], p->box[i][1]);
}

/* True if body i lies in body j, or if the comparison failed. The search for the smallest such body calls
 * it. */
static bool lies_in(void *context, uint32_t i, uint32_t j)
{
    struct placing *p = context;
    const struct solid *inner = &p->solid[p->first + i], *outer = &p->solid[p->first + j];
    double at[3];
    if (p->status != CML_OK) return true;
    const enum cml_convex_order order = compare_solids(inner, outer, at);
    const bool fails = order == CML_CONVEX_MEET || order == CML_CONVEX_OVERLAP;
    if (fails) p->status = fail_pair(p->scene, inner, outer, order, at, p->err);
    return order == CML_CONVEX_FIRST_INSIDE || fails;
}

/* Compares two bodies that have the same host (a cml_boxtree_pair). If the bodies are not apart, writes an
 * error to p->status and returns true, which ends the search. */
static bool fails_beside(void *context, uint32_t i, uint32_t j)
{
    struct placing *p = context;
    const struct solid *a = &p->solid[p->first + i], *b = &p->solid[p->first + j];
    double at[3];
    cml_body_point(a->body, at);
    const enum cml_convex_order order = compare_solids(a, b, at);
    if (order == CML_CONVEX_APART) return false;
    p->status = fail_pair(p->scene, a, b, order, at, p->err);
    return true;
}

/* Finds for each body of a layer the smallest body around it. */
static void find_hosts(struct placing *p, const struct cml_boxtree *tree, size_t count)
{
    for (uint32_t i = 0; i < count && p->status == CML_OK; i++) {
        const uint32_t j = cml_boxtree_first_around(tree, i, lies_in, p);
        if (j < count) p->solid[p->first + i].host = cml_body_medium(p->scene, p->solid[p->first + j].number);
    }
}

/* Compares the bodies of one layer, to find the smallest body around each; or the bodies of one host, to
 * refuse bodies that meet. */
static cml_status compare_range(struct placing *p, size_t count, bool hosts)
{
    struct cml_boxtree *tree;
    if (count < 2) return CML_OK;
    CML_TRY(cml_boxtree_create_boxes((const double(*)[2][3])p->box + p->first, count, &tree, p->err));
    if (hosts)
        find_hosts(p, tree, count);
    else
        cml_boxtree_own_pairs(tree, fails_beside, p);
    cml_boxtree_free(tree);
    return p->status;
}

/* Compares each body with its host and with the bodies that share its host. This suffices: a body lies inside
 * its host, so inside all that encloses the host and beside all that lies beside the host. */
static cml_status compare_all(struct placing *p)
{
    size_t end;
    sort(p, compare_volumes);
    for (p->first = 0; p->first < p->count; p->first = end) {
        for (end = p->first; end < p->count && p->solid[end].body->layer == p->solid[p->first].body->layer;)
            end++;
        CML_TRY(compare_range(p, end - p->first, true));
    }
    sort(p, compare_hosts);
    for (p->first = 0; p->first < p->count; p->first = end) {
        for (end = p->first; end < p->count && p->solid[end].host == p->solid[p->first].host;) end++;
        CML_TRY(compare_range(p, end - p->first, false));
    }
    return CML_OK;
}

/* Finds for each body the body or layer in which it lies, and refuses bodies that meet. sheets: room for the
 * search structures of all mesh bodies. */
static cml_status place(struct placing *p, struct cml_sheet *sheets)
{
    for (size_t i = 0, meshes = 0; i < p->count; i++) {
        CML_TRY(make_solid(p->scene, (int)i, &sheets[meshes], &p->solid[i], p->err));
        meshes += p->solid[i].sheet != NULL;
    }
    for (size_t i = 0; i < p->count; i++) CML_TRY(check_self(p->scene, &p->solid[i], p->err));
    return compare_all(p);
}

cml_status cml_scene_place_bodies(struct cml_scene *scene, struct cml_error *err)
{
    const size_t count = (size_t)scene->num_bodies;
    size_t meshes = 0;
    if (count == 0) return CML_OK;
    for (size_t i = 0; i < count; i++) meshes += scene->bodies[i].form == CML_BODY_MESH;
    CML_FREED struct cml_sheet *sheets = calloc(meshes + 1, sizeof *sheets);
    CML_FREED struct solid *solid = calloc(count, sizeof *solid);
    CML_FREED double(*box)[2][3] = malloc(count * sizeof *box);
    if (!sheets || !solid || !box)
        return cml_fail_memory(err, (double)(count * (sizeof *solid + sizeof *box)), "the check of bodies");
    struct placing p = {.scene = scene, .count = count, .solid = solid, .box = box, .err = err};
    const cml_status status = place(&p, sheets);
    for (size_t i = 0; status == CML_OK && i < count; i++)
        scene->bodies[solid[i].number].host = solid[i].host;
    for (size_t i = 0; i < meshes; i++) cml_sheet_clear(&sheets[i]);
    return status;
}
