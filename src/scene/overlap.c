/* The overlap check of scene.h: classifies boundaries, chooses the pairs that can meet, and writes the
 * messages. Touching counts as overlap, because a layer must have an inside everywhere. Only planes may
 * touch, as layers of no thickness do in original MCML. SPDX-License-Identifier: MIT */
#include "scene/overlap_radial.h"
#include "scene/overlap_sheet.h"
#include "scene/radial.h"
#include "scene/scene.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* A boundary as the overlap check sees it. Flat heightfields, meshes and tiles count as planes. */
struct shape {
    int number;
    const struct cml_boundary *boundary;
    bool is_mesh, is_plane, is_tile;
    struct cml_radial_surface field; /* the radial surface; not set if is_mesh or is_tile */
    /* Set for every mesh, even a flat one, which is checked against itself. */
    struct cml_sheet sheet;
    double top, bottom; /* least and greatest z, cm */
};

static double zero[1];
static const struct cml_radial level = {1, zero, zero};

/* Makes a shape a plane. A plane is a heightfield of one sample, so that cml_radial_against_* can compare
 * planes, too. */
static void make_plane(struct shape *shape, double z)
{
    shape->is_plane = true;
    shape->field = (struct cml_radial_surface){&level, z};
    shape->top = shape->bottom = z;
}

/* Makes the shape that represents a repeated heightmap in the search for overlaps: a plane if all heights
 * are equal, otherwise the range of depths that the heights span. z: the boundary's nominal depth. */
static void make_tile(struct shape *shape, const struct cml_heightmap *tile, double z)
{
    if (cml_tile_is_flat(tile)) {
        make_plane(shape, z - tile->h[0]);
        return;
    }
    shape->is_tile = true;
    cml_depth_range(tile->h, (size_t)tile->nx * (size_t)tile->ny, z, &shape->top, &shape->bottom);
}

/* Makes the form of boundary `number` that the search for overlaps compares: plane, radial heightfield, tile
 * or sheet of triangles. A shape whose heights are all equal becomes a plane, which is quickest to
 * compare. */
static cml_status make_shape(const struct cml_boundary *boundary, int number, struct shape *shape,
                             struct cml_error *err)
{
    const struct cml_radial *radial = &boundary->radial;
    double z = 0.0;
    *shape = (struct shape){.number = number, .boundary = boundary};
    if (boundary->form == CML_FORM_PLANE) {
        make_plane(shape, boundary->z);
    } else if (boundary->form == CML_FORM_RADIAL && cml_radial_is_flat(radial)) {
        make_plane(shape, boundary->z - radial->h[0]);
    } else if (boundary->form == CML_FORM_RADIAL) {
        shape->field = (struct cml_radial_surface){radial, boundary->z};
        cml_depth_range(radial->h, (size_t)radial->n, boundary->z, &shape->top, &shape->bottom);
    } else if (boundary->form == CML_FORM_TILE) {
        make_tile(shape, &boundary->tile, boundary->z);
    } else {
        CML_TRY(cml_sheet_create(&boundary->mesh, boundary->z, &shape->sheet, err));
        shape->is_mesh = !cml_mesh_is_flat(&boundary->mesh, &z);
        if (!shape->is_mesh) make_plane(shape, boundary->z + z);
        shape->top = shape->sheet.top;
        shape->bottom = shape->sheet.bottom;
    }
    return CML_OK;
}

/* Room for "triangle 4294967295 of boundary 2147483647 and the outer plane of boundary 2147483647". */
struct phrase {
    char text[128];
};

/* Names a triangle of a boundary, or the plane outside its border, for a message. */
static struct phrase name_part(uint32_t triangle, int boundary)
{
    struct phrase phrase;
    if (triangle == CML_SHEET_OUTER_PLANE)
        snprintf(phrase.text, sizeof phrase.text, "the outer plane of boundary %d", boundary);
    else
        snprintf(phrase.text, sizeof phrase.text, "triangle %u of boundary %d", (unsigned)triangle, boundary);
    return phrase;
}

/* Returns the .mci line of the lower boundary, or that of the upper one if the lower one is a plane without a
 * line. */
static int line_of(const struct shape *upper, const struct shape *lower)
{
    return lower->boundary->line > 0 ? lower->boundary->line : upper->boundary->line;
}

static const char apart[] = "(expected boundaries that neither cross nor touch)";

/* Refuses two boundaries that touch at a point. */
static cml_status fail_touch(const struct cml_scene *scene, const struct shape *upper,
                             const struct shape *lower, const double at[3], struct cml_error *err)
{
    return cml_fail(err, CML_E_INPUT, "%s:%d: boundaries %d and %d touch at (%g %g %g) cm %s", scene->file,
                    line_of(upper, lower), upper->number, lower->number, at[0], at[1], at[2], apart);
}

/* Refuses two boundaries of which the lower one does not stay below the upper one. `at`: a point where they
 * cross; `depth`: how far the upper one reaches below the lower one there, cm. */
static cml_status fail_deep(const struct cml_scene *scene, const struct shape *upper,
                            const struct shape *lower, const double at[3], double depth,
                            struct cml_error *err)
{
    const int a = upper->number, b = lower->number;
    return cml_fail(err, CML_E_INPUT,
                    "%s:%d: boundaries %d and %d cross at (%g %g %g) cm: boundary %d reaches %g cm below "
                    "boundary %d %s",
                    scene->file, line_of(upper, lower), a, b, at[0], at[1], at[2], a, depth, b, apart);
}

/* True if the overlap involves a triangle of the mesh's skirt. A mesh lists the skirt's triangles last. */
static bool is_of_skirt(const struct cml_boundary *boundary, const struct cml_sheet_overlap *overlap)
{
    const size_t first = boundary->mesh.num_triangles - boundary->mesh_notes.skirt;
    for (int i = 0; i < 2; i++)
        if (overlap->triangle[i] != CML_SHEET_OUTER_PLANE && overlap->triangle[i] >= first) return true;
    return false;
}

/* Writes the error about a mesh boundary that crosses or touches itself. */
static cml_status fail_self(const struct cml_scene *scene, const struct shape *shape,
                            const struct cml_sheet_overlap *overlap, struct cml_error *err)
{
    char where[16] = "", with[64];
    const int line = shape->boundary->line;
    const double *at = overlap->at;
    if (line > 0) snprintf(where, sizeof where, ":%d", line);
    if (overlap->triangle[1] == CML_SHEET_OUTER_PLANE)
        snprintf(with, sizeof with, "triangle %u and its outer plane", (unsigned)overlap->triangle[0]);
    else
        snprintf(with, sizeof with, "triangles %u and %u", (unsigned)overlap->triangle[0],
                 (unsigned)overlap->triangle[1]);
    return cml_fail(err, CML_E_INPUT, "%s%s: boundary %d %s itself at (%g %g %g) cm: %s%s", scene->file,
                    where, shape->number, overlap->contact == CML_CROSS ? "crosses" : "touches", at[0], at[1],
                    at[2], with,
                    is_of_skirt(shape->boundary, overlap) ? ", of its skirt (expected another skirt=)"
                                                          : " (expected a surface that does not)");
}

/* Refuses two neighbouring mesh boundaries that cross or touch, or of which the lower one lies above. The
 * message names the two triangles or how deep the upper boundary reaches. */
static cml_status compare_sheets(const struct cml_scene *scene, const struct shape *upper,
                                 const struct shape *lower, struct cml_error *err)
{
    struct cml_sheet_overlap overlap;
    cml_sheet_against_sheet(&upper->sheet, &lower->sheet, &overlap);
    if (overlap.contact == CML_APART) return CML_OK;
    const double *at = overlap.at;
    if (overlap.depth > 0.0) return fail_deep(scene, upper, lower, at, overlap.depth, err);
    const struct phrase one = name_part(overlap.triangle[0], upper->number);
    const struct phrase other = name_part(overlap.triangle[1], lower->number);
    return cml_fail(err, CML_E_INPUT, "%s:%d: boundaries %d and %d %s at (%g %g %g) cm: %s and %s %s",
                    scene->file, line_of(upper, lower), upper->number, lower->number,
                    overlap.contact == CML_CROSS ? "cross" : "touch", at[0], at[1], at[2], one.text,
                    other.text, apart);
}

/* Refuses two neighbouring boundaries that cross or touch, of which at least one is a plane or a radial
 * heightfield. */
static cml_status compare_fields(const struct cml_scene *scene, const struct shape *upper,
                                 const struct shape *lower, struct cml_error *err)
{
    struct cml_closest closest = {.gap = INFINITY};
    if (upper->is_mesh)
        cml_radial_against_mesh(&lower->field, upper->sheet.mesh, upper->sheet.footprint, upper->boundary->z,
                                true, &closest);
    else if (lower->is_mesh)
        cml_radial_against_mesh(&upper->field, lower->sheet.mesh, lower->sheet.footprint, lower->boundary->z,
                                false, &closest);
    else
        cml_radial_against_radial(&upper->field, &lower->field, &closest);
    const double *at = closest.at;
    if (closest.gap < -closest.err_gap) return fail_deep(scene, upper, lower, at, -closest.gap, err);
    if (closest.gap > closest.err_gap || (upper->is_plane && lower->is_plane)) return CML_OK;
    return fail_touch(scene, upper, lower, at, err);
}

/* Finds a place where a tile touches the depth z, for the message: its first sample at exactly this depth
 * goes to at[0], at[1]. */
static void find_sample(const struct cml_boundary *boundary, double z, double at[3])
{
    const struct cml_heightmap *tile = &boundary->tile;
    const size_t nx = (size_t)tile->nx;
    size_t i = 0;
    while (boundary->z - tile->h[i] != z) i++;
    at[0] = tile->x0 + (double)(i % nx) * tile->dx;
    at[1] = tile->y0 + (double)(i / nx) * tile->dy;
}

/* Finds the place where a tile and a plane, or two tiles, come closest: it goes to at[]. Returns false for
 * other pairs, of which only the ranges of depth can be compared. */
static bool find_closest(const struct shape *upper, const struct shape *lower, double *gap, double at[3])
{
    if (upper->is_tile && lower->is_tile)
        return cml_tile_closest(&upper->boundary->tile, upper->boundary->z, &lower->boundary->tile,
                                lower->boundary->z, gap, at);
    if (!upper->is_plane && !lower->is_plane) return false;
    *gap = lower->top - upper->bottom;
    at[2] = upper->bottom;
    find_sample((upper->is_tile ? upper : lower)->boundary, upper->is_tile ? upper->bottom : lower->top, at);
    return true;
}

/* Compares two boundaries of which one is a tile. Refuses boundaries that overlap, and boundaries whose gap
 * cannot be computed exactly, because the other surface has no period or a different period. */
static cml_status compare_tiles(const struct cml_scene *scene, const struct shape *upper,
                                const struct shape *lower, struct cml_error *err)
{
    double gap, at[3];
    if (!find_closest(upper, lower, &gap, at))
        return cml_fail(
            err, CML_E_INPUT,
            "%s:%d: boundaries %d and %d, of which one is a tile, lie at depths of %g..%g and %g..%g "
            "cm (expected depths that do not overlap, or two tiles of the same cells)",
            scene->file, line_of(upper, lower), upper->number, lower->number, upper->top, upper->bottom,
            lower->top, lower->bottom);
    const double err_gap = 8.0 * DBL_EPSILON * (fabs(upper->bottom) + fabs(lower->top));
    if (gap < -err_gap) return fail_deep(scene, upper, lower, at, -gap, err);
    if (gap > err_gap) return CML_OK;
    return fail_touch(scene, upper, lower, at, err);
}

/* Refuses two neighbouring boundaries that cross or touch. Most pairs lie at entirely different depths and
 * cost nothing; for the others, their forms decide which function compares. */
static cml_status compare(const struct cml_scene *scene, const struct shape *upper, const struct shape *lower,
                          struct cml_error *err)
{
    if (upper->bottom < lower->top) return CML_OK;
    if (upper->is_tile || lower->is_tile) return compare_tiles(scene, upper, lower, err);
    if (upper->is_mesh && lower->is_mesh) return compare_sheets(scene, upper, lower, err);
    return compare_fields(scene, upper, lower, err);
}

/* Refuses a mesh boundary that crosses or touches itself. */
static cml_status check_self(const struct cml_scene *scene, const struct shape *shape, struct cml_error *err)
{
    struct cml_sheet_overlap overlap;
    if (shape->boundary->form != CML_FORM_MESH) return CML_OK;
    cml_sheet_against_itself(&shape->sheet, &overlap);
    return overlap.contact == CML_APART ? CML_OK : fail_self(scene, shape, &overlap, err);
}

/* Boundaries that the next one is compared with: the last one above it that is not a plane, and the deepest
 * plane. */
struct above {
    struct shape curved, plane; /* the two shapes; a shape whose member `boundary` is NULL does not exist */
};

/* Compares a boundary with the two boundaries of `above`. Two are enough, because all other boundaries above
 * lie above these two. Among planes only the deepest counts, because planes may touch each other. The nearer
 * of the two is compared first, so that the message names the place where the user must look. */
static cml_status compare_with_above(const struct cml_scene *scene, const struct above *above,
                                     const struct shape *shape, struct cml_error *err)
{
    const bool plane_first = above->plane.number > above->curved.number;
    for (int i = 0; i < 2; i++) {
        const struct shape *upper = (i == 0) == plane_first ? &above->plane : &above->curved;
        if (upper->boundary) CML_TRY(compare(scene, upper, shape, err));
    }
    return CML_OK;
}

/* Keeps the shape if it replaces the curved boundary or the plane that the next boundaries are compared
 * with. */
static void keep_above(struct above *above, struct shape *shape)
{
    if (!shape->is_plane) {
        cml_sheet_clear(&above->curved.sheet);
        above->curved = *shape;
        return;
    }
    cml_sheet_clear(&shape->sheet); /* only a flat mesh has one here */
    if (!above->plane.boundary || shape->bottom >= above->plane.bottom) above->plane = *shape;
}

/* Each boundary is compared with itself and with those above it that could reach it, which `above` keeps. */
cml_status cml_scene_check_overlap(const struct cml_scene *scene, struct cml_error *err)
{
    struct above above = {.curved.boundary = NULL};
    cml_status status = CML_OK;
    for (int i = 0; status == CML_OK && i <= scene->num_layers; i++) {
        struct shape shape;
        status = make_shape(&scene->boundaries[i], i, &shape, err);
        if (status == CML_OK) status = check_self(scene, &shape, err);
        if (status == CML_OK) status = compare_with_above(scene, &above, &shape, err);
        keep_above(&above, &shape);
    }
    cml_sheet_clear(&above.curved.sheet);
    return status;
}
