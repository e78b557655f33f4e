/* Queries of a boundary mesh: chooses the search, calls Embree, and combines all tests.
 * SPDX-License-Identifier: MIT */
#include "surface/mesh/mesh_surface.h"

#include "geometry/vec3.h"
#include "surface/mesh/grid_walk.h"
#include "surface/mesh/mesh_line.h"
#include "surface/tree/rounding.h"
#include "surface/tree/facet_tree.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#if CML_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
typedef struct RTCRayQueryContext query_context;
#else
#include <embree3/rtcore.h>
typedef struct RTCIntersectContext query_context;
#endif

#define MAP_BYTES 16777216 /* bytes of the map of safe distances, besides a quarter of all other memory */

struct cml_mesh_surface {
    struct cml_centred_mesh centred;
    _Atomic ssize_t embree_bytes; /* counted by Embree's threads */
    RTCScene boxes;               /* Embree's boxes around triangles, which are tested in double */
    struct cml_grid_mesh grid;    /* cells that a query walks, for a sheet */
    struct cml_facet_tree
        tree; /* tree that is searched if the mesh has no cells; a tree without nodes is not used */
    const struct cml_tree_level *level; /* the tree's search for this processor */
    struct cml_safe_map map;            /* safe distances for a mesh with a tree; without distances: not
                                           used */
    struct cml_mesh_period period;      /* n is 0 if the mesh is not repeated */
};

/* A query. Embree passes the context to its callbacks, so the double-precision ray is stored behind the
 * context. */
struct query {
    query_context context;
    struct cml_mesh_query ray;
    struct cml_mesh_line
        *line; /* the test of the whole line against all facets (mesh_line.h) while it runs, else NULL */
    bool contact_only; /* only looks for facets that the packet may be beyond */
};

/* Tests in double precision whether a ray meets a triangle, and keeps the crossing if it is the best.
 * Returns true if it may be the packet's next crossing. */
static bool test_triangle(struct cml_mesh_query *q, int primitive)
{
    double t, weight[3];
    cml_query_test_contact(q, primitive);
    if (!cml_query_intersect(q, primitive, &t, weight)) return false;
    cml_query_add_hit(q, primitive, t, weight);
    return true;
}

/* Tests the triangle in a box that a ray meets; Embree calls it back for each box. A hit shortens the ray,
 * so that Embree skips boxes behind. For a line that is followed exactly, the facet is only collected. */
static void intersect_triangle(const struct RTCIntersectFunctionNArguments *arguments)
{
    struct query *query = (struct query *)(void *)arguments->context;
    struct cml_mesh_query *q = &query->ray;
    const int primitive = (int)arguments->primID;
    if (!arguments->valid[0]) return;
    if (query->line) {
        cml_line_add(query->line, primitive);
        return;
    }
    if (primitive == q->exclude) return;
    if (query->contact_only) cml_query_test_contact(q, primitive);
    if (query->contact_only || !test_triangle(q, primitive)) return;
    struct RTCRayHit *rayhit = (struct RTCRayHit *)(void *)arguments->rayhit;
    const float t_far = (float)(q->t - q->t_entry + 2 * q->centred->err_float);
    if (t_far < rayhit->ray.tfar) rayhit->ray.tfar = t_far > 0 ? t_far : 0;
    rayhit->hit.geomID = arguments->geomID;
    rayhit->hit.primID = arguments->primID;
#if CML_EMBREE_MAJOR >= 4
    arguments->valid[0] = -1;
#endif
}

/* Gives Embree the box of a triangle, enlarged by err_float. Whatever float does to box and ray, Embree then
 * meets the box of every triangle that the ray meets in double. */
static void triangle_bounds(const struct RTCBoundsFunctionArguments *arguments)
{
    const struct cml_mesh_surface *surface = arguments->geometryUserPtr;
    const struct cml_mesh *mesh = &surface->centred.mesh;
    const uint32_t *v = mesh->triangle[arguments->primID];
    float *lower = &arguments->bounds_o->lower_x, *upper = &arguments->bounds_o->upper_x;
    for (int k = 0; k < 3; k++) {
        const double a = mesh->vertex[v[0]][k], b = mesh->vertex[v[1]][k], c = mesh->vertex[v[2]][k];
        lower[k] = (float)(fmin(a, fmin(b, c)) - surface->centred.err_float);
        upper[k] = (float)(fmax(a, fmax(b, c)) + surface->centred.err_float);
    }
}

/* Fills the ray that Embree traces in single precision: from the entry point into the mesh's box to the
 * distance `leave`, where the ray leaves the box. */
static void fill_ray(const struct cml_mesh_query *q, double leave, struct RTCRayHit *rayhit)
{
    *rayhit = (struct RTCRayHit){.ray.mask = 0xffffffffu};
    rayhit->ray.org_x = (float)q->entry[0];
    rayhit->ray.org_y = (float)q->entry[1];
    rayhit->ray.org_z = (float)q->entry[2];
    rayhit->ray.dir_x = (float)q->direction[0];
    rayhit->ray.dir_y = (float)q->direction[1];
    rayhit->ray.dir_z = (float)q->direction[2];
    rayhit->ray.tfar = (float)(leave - q->t_entry + 2 * q->centred->err_float);
    rayhit->hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rayhit->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
}

/* Fills Embree's ray with the whole line, ahead and behind. Returns false if the line misses the box. */
static bool make_line(struct cml_mesh_query *q, struct RTCRayHit *rayhit)
{
    double leave;
    if (!cml_query_clip_line(q, &leave)) return false;
    fill_ray(q, leave, rayhit);
    return true;
}

/* Asks Embree which boxes of triangles a ray meets; Embree calls back for each. The calls of versions 3 and
 * 4 differ. */
static void intersect_boxes(const struct cml_mesh_surface *surface, struct query *query,
                            struct RTCRayHit *rayhit)
{
#if CML_EMBREE_MAJOR >= 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    rtcInitRayQueryContext(&query->context);
    arguments.context = &query->context;
    rtcIntersect1(surface->boxes, rayhit, &arguments);
#else
    rtcInitIntersectContext(&query->context);
    rtcIntersect1(surface->boxes, &query->context, rayhit);
#endif
}

/* Tests every triangle whose box the ray meets, in double precision; Embree finds the boxes. */
static void query_exact(const struct cml_mesh_surface *surface, struct query *query)
{
    struct RTCRayHit rayhit;
    double leave;
    if (!cml_query_clip_ray(&query->ray, &leave)) return;
    fill_ray(&query->ray, leave, &rayhit);
    intersect_boxes(surface, query, &rayhit);
}

/* Tests if a packet that stands on no facet lies within rounding of a facet. Embree may miss such a facet if
 * the ray is at a small angle to it, since in single precision the facet may lie behind the ray's beginning.
 * The ray is only as long as the boxes' err_float, so only boxes at the origin are found. */
static void test_contact_around(const struct cml_mesh_surface *surface, struct query *query)
{
    struct RTCRayHit rayhit;
    double leave;
    if (!cml_query_clip_ray(&query->ray, &leave) || query->ray.t_entry > 0) return;
    fill_ray(&query->ray, query->ray.t_entry, &rayhit);
    query->contact_only = true;
    intersect_boxes(surface, query, &rayhit);
    query->contact_only = false;
}

/* Answers a query with Embree's boxes, in double. First looks for facets beyond which the packet may stand,
 * if the query needs them; then tests every triangle whose box the ray meets. */
static void query_embree(const struct cml_mesh_surface *surface, struct query *query)
{
    if (query->ray.contact_distance >= 0 && query->ray.exclude != CML_OFF_FACETS)
        test_contact_around(surface, query);
    query_exact(surface, query);
}

/* Returns the ray in single precision, from its entry point, for the tree. */
static struct cml_tree_ray tree_ray(const struct cml_mesh_query *q)
{
    struct cml_tree_ray ray = {.length = (float)fmin(q->t - q->t_entry, (double)FLT_MAX),
                               .margin = (float)(q->centred->err_margin + q->err_query + q->err_entry),
                               .below = q->below,
                               .exclude = q->exclude};
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = (float)q->entry[k];
        ray.direction[k] = (float)q->direction[k];
    }
    return ray;
}

/* Finds a ray's first crossing with the search tree in single precision. What the tree cannot decide for
 * certain is decided in double precision, facet by facet; if the tree lost the overview (blurred), Embree
 * searches instead. */
static void query_tree(const struct cml_mesh_surface *surface, struct query *query)
{
    static const double inner[3] = {1 / 3.0, 1 / 3.0, 1 / 3.0};
    struct cml_mesh_query *q = &query->ray;
    struct cml_tree_answer answer;
    double leave;
    if (!cml_query_enter(q)) return;
    const struct cml_tree_ray ray = tree_ray(q);
    surface->level->ask(&surface->tree, &ray, &answer);
    q->in_doubt = answer.re_enters;
    if (answer.blurred) {
        query_embree(surface, query);
    } else if (answer.doubts) {
        if (!cml_query_clip_ray(q, &leave)) return;
        for (int i = 0; i < answer.doubts; i++) test_triangle(q, answer.doubt[i]);
        if (answer.facet >= 0) test_triangle(q, answer.facet);
    } else if (answer.facet >= 0) {
        const double t = cml_query_plane_distance(q, answer.facet);
        cml_query_add_inner_hit(q, answer.facet, q->centred->plane[answer.facet], t, inner);
        const bool shades = q->centred->mesh.normals == CML_NORMALS_VERTEX && q->primitive == answer.facet;
        if (shades) cml_query_set_hit(q, answer.facet, t);
    }
}

/* Decides a query in doubt: tests every triangle along the whole line by exact signs. Returns true if the
 * path ends beside a facet. */
static bool query_line(const struct cml_mesh_surface *surface, struct query *query, double t_max)
{
    struct cml_mesh_line line;
    struct cml_line_parts parts;
    struct RTCRayHit rayhit;
    cml_line_begin(&line, &query->ray, t_max, &parts);
    query->line = &line;
    for (bool more = make_line(&query->ray, &rayhit); more; more = cml_line_goes_on(&line))
        intersect_boxes(surface, query, &rayhit);
    cml_line_decide(&line, &query->ray);
    return line.ends_near_facet;
}

/* Queries the cells. Undecided walks are rare: only at edges and at small angles. */
static void query_grid(const struct cml_mesh_surface *surface, struct query *query)
{
    if (!cml_grid_walk(&surface->grid, &query->ray)) query_exact(surface, query);
}

/* Finds the first crossing. The fastest search comes first, and leaves to the next one whatever it cannot
 * decide for certain:
 *
 *   the cells (grid_walk.h), else the tree (facet_tree.h), else Embree's boxes
 *         |  undecided, or in doubt
 *         v
 *   triangles in double (mesh_query.h): those in doubt, or all whose boxes the ray meets
 *         |
 *         v
 *   the outer plane  ------------------------------------------> the crossing, or none
 *         |  an edge, contact with a facet, the wrong side
 *         v
 *   the whole line by exact signs (mesh_line.h)  --------------> the crossing, or none
 *
 * Packets near an edge start with the triangles, because the faster searches would only send them there. The
 * outer plane is skipped if the walk has shown that the ray stays over the grid. */
static inline int hit_mesh(const struct cml_mesh_surface *surface, const double p[3], const double u[3],
                           int below, double t_max, int exclude, int undeflected, int exact,
                           double err_position, struct cml_mesh_crossing *crossing)
{
    struct query query;
    crossing->ends_near_facet = 0;
    query.line = NULL;
    query.contact_only = false;
    cml_query_begin(&query.ray, &surface->centred, p, u, below, t_max, exclude, undeflected, err_position);
    if (exact || query.ray.starts_on_edge)
        query_exact(surface, &query);
    else if (surface->grid.levels)
        query_grid(surface, &query);
    else if (surface->tree.nodes)
        query_tree(surface, &query);
    else
        query_embree(surface, &query);
    if (exact || !surface->grid.levels || !cml_grid_walk_covers(&surface->grid, &query.ray))
        cml_query_intersect_outer_plane(&query.ray);
    crossing->ends_near_facet = cml_query_is_doubtful(&query.ray) && query_line(surface, &query, t_max);
    return cml_query_finish(&query.ray, p, u, crossing);
}

/* Finds the range of depths of the mesh, widened by more than rounding, from the boundary's depth, cm. */
static void find_depths(const struct cml_mesh_surface *surface, double err_position, double *low,
                        double *high)
{
    const struct cml_centred_mesh *centred = &surface->centred;
    const double more = 2 * err_line_factor * err_position + centred->err_float;
    *low = centred->lower[2] + centred->centre[2] - more;
    *high = centred->upper[2] + centred->centre[2] + more;
}

/* Turns the crossing that a search in one copy of a repeated mesh has found into a crossing of the whole
 * path. Returns 0 if there is none. */
static int finish_tile(const struct cml_mesh_surface *surface, const struct cml_tile_path *path,
                       struct cml_mesh_crossing *crossing)
{
    crossing->t += path->from;
    for (int k = 0; k < 2; k++) crossing->point[k] = path->p[k] + crossing->t * path->u[k];
    crossing->primitive = cml_tile_primitive(&surface->period, crossing->primitive);
    return crossing->primitive >= 0;
}

/* Follows a path over a repeated mesh, copy by copy, to its first crossing; 0: there is none. A segment that
 * begins on the way also has the rounding of its distance from the path's origin. */
static int hit_tile(const struct cml_mesh_surface *surface, const double p[3], const double u[3], int below,
                    double t_max, int exclude, int undeflected, int exact, double err_position,
                    struct cml_mesh_crossing *crossing)
{
    struct cml_tile_path path;
    double low, high;
    find_depths(surface, err_position, &low, &high);
    crossing->ends_near_facet = 0;
    for (bool more = cml_tile_begin(&surface->period, p, u, t_max, exclude, low, high, &path); more;
         more = cml_tile_next(&path))
        if (hit_mesh(surface, path.origin, u, below, path.to - path.from, path.exclude, undeflected, exact,
                     err_position + 4 * DBL_EPSILON * path.from, crossing))
            return finish_tile(surface, &path, crossing);
    if (path.to < t_max) crossing->ends_near_facet = 0;
    if (cml_tile_is_too_long(&path)) crossing->ends_near_facet = CML_PATH_TOO_LONG;
    return 0;
}

int cml_mesh_surface_hit(const struct cml_mesh_surface *surface, const double p[3], const double u[3],
                         int below, double t_max, int exclude, int undeflected, int exact,
                         double err_position, struct cml_mesh_crossing *crossing)
{
    return (surface->period.n[0] ? hit_tile : hit_mesh)(surface, p, u, below, t_max, exclude, undeflected,
                                                        exact, err_position, crossing);
}

/* Narrows a stretch, a range of path lengths that have the same answer, by a facet close to the line. Returns
 * true if the line leaves this facet behind at its beginning, or hits it at t_hit within rounding. Otherwise
 * returns false: no stretch is then known. */
static bool bound_stretch(const struct cml_mesh_query *q, int primitive, double margin, double t_hit,
                          struct cml_mesh_stretch *stretch)
{
    const double *plane = q->centred->plane[primitive];
    const double along = (q->below ? 1 : -1) * cml_vec3_dot(q->direction, plane);
    const double height = plane[3] - cml_vec3_dot(q->origin, plane), reach = 3 * margin / fabs(along);
    const double t = cml_query_plane_distance(q, primitive);
    if (along < 0 && fabs(height) <= 2 * margin) {
        stretch->least = fmax(stretch->least, reach);
        return true;
    }
    stretch->most = fmin(stretch->most, t - reach);
    stretch->from = fmax(stretch->from, t + reach);
    return along > 0 && fabs(t - t_hit) <= reach;
}

/* The tree lists the facets that are close to the line before the hit. Its margin is enlarged by the margin
 * of a path that ends near a facet. Each listed facet must either be left behind where the packet stands or
 * be among the facets hit. The answer then no longer depends on the path's length, unless the path ends
 * within the margin of such a facet. Only its last bits may depend on it: a facet behind the hit can make the
 * query compute the hit in another way. Therefore the hits for the shortest and for an infinite path are
 * compared. If they differ, no stretch is known. */
bool cml_mesh_surface_stretch(const struct cml_mesh_surface *surface, const double p[3], const double u[3],
                              int below, int exclude, int undeflected, double err_position,
                              struct cml_mesh_stretch *stretch)
{
    struct cml_mesh_query q;
    struct cml_mesh_crossing hit = {.t = INFINITY}, least_hit;
    struct cml_tree_answer answer;
    if (!surface->tree.nodes || surface->period.n[0] || surface->centred.mesh.unite || exclude < 0 ||
        exclude == CML_OUTER_PLANE)
        return false;
    cml_query_begin(&q, &surface->centred, p, u, below, INFINITY, exclude, undeflected, err_position);
    if (!cml_query_enter(&q) || q.t_entry > 0) return false;
    const int found = hit_mesh(surface, p, u, below, INFINITY, exclude, undeflected, 0, err_position, &hit);
    if (found && hit.primitive == CML_OUTER_PLANE) return false;
    struct cml_tree_ray ray = tree_ray(&q);
    const float margin = ray.margin += (float)(err_line_factor * q.err_query);
    if (found)
        ray.length =
            (float)(hit.t + 4 * margin / fabs(cml_vec3_dot(u, surface->centred.plane[hit.primitive])));
    surface->level->ask(&surface->tree, &ray, &answer);
    *stretch = (struct cml_mesh_stretch){0, INFINITY, found ? 0 : INFINITY};
    bool known = !answer.blurred && bound_stretch(&q, exclude, margin, hit.t, stretch);
    if (answer.facet >= 0) known = known && bound_stretch(&q, answer.facet, margin, hit.t, stretch);
    for (int i = 0; i < answer.doubts; i++)
        known = known && bound_stretch(&q, answer.doubt[i], margin, hit.t, stretch);
    if (!known || !(stretch->from > 0 && stretch->least < stretch->most)) return false;
    return !found || (hit_mesh(surface, p, u, below, stretch->from, exclude, undeflected, 0, err_position,
                               &least_hit) &&
                      memcmp(&hit, &least_hit, offsetof(struct cml_mesh_crossing, ends_near_facet)) == 0);
}

/* Vector loops cannot use the cells of a tile, which belong to one copy of the period, nor normals that vary
 * within a facet. They compute eight times a cell's number in 32 bits, so a grid of 2^27 cells is too large.
 * */
const struct cml_grid_mesh *cml_mesh_surface_grid(const struct cml_mesh_surface *surface,
                                                  const struct cml_centred_mesh **centred)
{
    const struct cml_grid_mesh *grid = &surface->grid;
    *centred = &surface->centred;
    if (!grid->levels || surface->period.n[0] || surface->centred.mesh.normals != CML_NORMALS_FACET)
        return NULL;
    return cml_grid_mesh_slots(&grid->level[0]) < (size_t)1 << 27 ? grid : NULL;
}

/* One Embree device for all meshes, kept until the program ends: Embree takes a pthread key for each device,
 * and a process has 1024. Embree builds in the calling thread alone, because TBB aborts the process if the
 * system refuses a thread. Building takes a sixth of the time of loading a mesh. The lock is held while a
 * tree is built, because a device has one monitor of its memory. */
static RTCDevice device;
static pthread_mutex_t device_lock = PTHREAD_MUTEX_INITIALIZER;
static const char only_the_caller[] = "threads=1,start_threads=0";

/* Adds to the memory that Embree has taken for a surface (a callback of Embree's device). */
static bool count_memory(void *context, ssize_t bytes, bool post)
{
    (void)post;
    ((struct cml_mesh_surface *)context)->embree_bytes += bytes;
    return true;
}

/* Builds Embree's tree over the boxes of the triangles. Above 1e6 triangles a faster build with a lower
 * quality is used. */
static void build_boxes(struct cml_mesh_surface *surface)
{
    surface->boxes = rtcNewScene(device);
    rtcSetSceneFlags(surface->boxes, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(surface->boxes, surface->centred.mesh.num_triangles > 1000000
                                                ? RTC_BUILD_QUALITY_MEDIUM
                                                : RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, (unsigned)surface->centred.mesh.num_triangles);
    rtcSetGeometryUserData(geometry, surface);
    rtcSetGeometryBoundsFunction(geometry, triangle_bounds, NULL);
    rtcSetGeometryIntersectFunction(geometry, intersect_triangle);
    rtcSetGeometryMask(geometry, 0xffffffffu);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(surface->boxes, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(surface->boxes);
}

/* Builds Embree's tree under the lock. CML_E_INPUT: memory runs out. CML_E_DEVICE: Embree fails. */
static cml_status build_embree_alone(struct cml_mesh_surface *surface, struct cml_error *err)
{
    if (!device && !(device = rtcNewDevice(only_the_caller)))
        return cml_fail(err, CML_E_DEVICE, "Embree cannot start (error %d)", (int)rtcGetDeviceError(NULL));
    rtcSetDeviceMemoryMonitorFunction(device, count_memory, surface);
    build_boxes(surface);
    rtcSetDeviceMemoryMonitorFunction(device, NULL, NULL);
    const enum RTCError error = rtcGetDeviceError(device);
    if (error == RTC_ERROR_NONE) return CML_OK;
    return cml_fail(err, error == RTC_ERROR_OUT_OF_MEMORY ? CML_E_INPUT : CML_E_DEVICE,
                    "Embree cannot build a tree of %zu triangles (error %d)",
                    surface->centred.mesh.num_triangles, (int)error);
}

static cml_status build_embree(struct cml_mesh_surface *surface, struct cml_error *err)
{
    pthread_mutex_lock(&device_lock);
    const cml_status status = build_embree_alone(surface, err);
    pthread_mutex_unlock(&device_lock);
    return status;
}

/* Builds our own tree of facets for the best level that the processor can run. */
static cml_status build_tree(struct cml_mesh_surface *surface, struct cml_error *err)
{
    const struct cml_centred_mesh *centred = &surface->centred;
    const struct cml_tree_level *levels[CML_TREE_LEVELS];
    cml_tree_levels(levels);
    surface->level = levels[0];
    return cml_facet_tree_create(&centred->mesh, (const double(*)[4])centred->plane, centred->err_margin,
                                 &surface->tree, err);
}

/* Builds the fast search for facets: cells for a mesh that does not overhang, otherwise a tree; none if
 * Embree alone was asked for. */
static cml_status build_search(struct cml_mesh_surface *surface, enum cml_mesh_search search,
                               struct cml_error *err)
{
    struct cml_grid_mesh *grid = &surface->grid;
    const bool may_have_cells = search == CML_SEARCH_AUTO && !surface->centred.mesh.closed;
    if (search == CML_SEARCH_EMBREE) return CML_OK;
    if (may_have_cells) CML_TRY(cml_sheet_mesh_find(&surface->centred, grid, err));
    return grid->levels ? CML_OK : build_tree(surface, err);
}

/* Builds the map of safe distances. A body gets none: the map would be built once per body, and does not
 * pay. */
static cml_status build_map(struct cml_mesh_surface *surface, struct cml_error *err)
{
    if (!surface->tree.nodes || surface->centred.mesh.closed) return CML_OK;
    const double bytes = MAP_BYTES + 0.25 * cml_mesh_surface_bytes(surface);
    return cml_safe_map_create(&surface->centred, bytes, &surface->map, err);
}

/* Makes the surface of a mesh with all its search structures: the fast search, Embree's boxes and, unless it
 * is repeated, a map of safe distances. */
static cml_status create(struct cml_mesh *mesh, double x0, double y0, enum cml_mesh_search search,
                         bool repeated, struct cml_mesh_surface **surface, struct cml_error *err)
{
    struct cml_mesh_surface *made = calloc(1, sizeof *made);
    *surface = NULL;
    if (!made) return cml_fail_memory(err, sizeof *made, "a mesh surface");
    cml_status status = cml_centred_mesh_create(mesh, x0, y0, &made->centred, err);
    if (status == CML_OK) status = build_search(made, search, err);
    if (status == CML_OK) status = build_embree(made, err);
    if (status == CML_OK && !repeated) status = build_map(made, err);
    if (status != CML_OK)
        cml_mesh_surface_free(made);
    else
        *surface = made;
    return status;
}

cml_status cml_mesh_surface_create(struct cml_mesh *mesh, double x0, double y0, enum cml_mesh_search search,
                                   struct cml_mesh_surface **surface, struct cml_error *err)
{
    return create(mesh, x0, y0, search, false, surface, err);
}

/* Queries count x and y from (x0, y0), hence the period's corner is moved there. */
cml_status cml_mesh_surface_create_tile(struct cml_mesh *mesh, double x0, double y0,
                                        enum cml_mesh_search search, const struct cml_mesh_period *period,
                                        struct cml_mesh_surface **surface, struct cml_error *err)
{
    CML_TRY(create(mesh, x0, y0, search, true, surface, err));
    (*surface)->period = *period;
    (*surface)->period.corner[0] -= x0;
    (*surface)->period.corner[1] -= y0;
    return CML_OK;
}

void cml_mesh_surface_free(struct cml_mesh_surface *surface)
{
    if (!surface) return;
    if (surface->boxes) rtcReleaseScene(surface->boxes);
    cml_grid_mesh_clear(&surface->grid);
    cml_facet_tree_clear(&surface->tree);
    cml_safe_map_clear(&surface->map);
    cml_centred_mesh_clear(&surface->centred);
    free(surface);
}

const struct cml_mesh *cml_mesh_surface_mesh(const struct cml_mesh_surface *surface, double middle[3])
{
    middle[0] = -surface->centred.axis[0];
    middle[1] = -surface->centred.axis[1];
    middle[2] = surface->centred.centre[2];
    return &surface->centred.mesh;
}

uint64_t cml_mesh_surface_primitives(const struct cml_mesh_surface *surface)
{
    const struct cml_mesh_period *period = &surface->period;
    return period->n[0] ? cml_tile_primitives(period) : surface->centred.mesh.num_triangles;
}

size_t cml_mesh_surface_triangle(const struct cml_mesh_surface *surface, size_t primitive)
{
    return surface->period.n[0] ? (size_t)cml_tile_triangle(&surface->period, (int)primitive) : primitive;
}

double cml_mesh_surface_area(const struct cml_mesh_surface *surface, size_t primitive)
{
    const struct cml_mesh *mesh = &surface->centred.mesh;
    const uint32_t *corner = mesh->triangle[cml_mesh_surface_triangle(surface, primitive)];
    double normal[3];
    cml_vec3_area(mesh->vertex[corner[0]], mesh->vertex[corner[1]], mesh->vertex[corner[2]], normal);
    return 0.5 * cml_vec3_length(normal);
}

const struct cml_mesh_period *cml_mesh_surface_period(const struct cml_mesh_surface *surface)
{
    return &surface->period;
}

double cml_mesh_surface_bytes(const struct cml_mesh_surface *surface)
{
    return (double)surface->embree_bytes + cml_grid_mesh_bytes(&surface->grid) +
           cml_facet_tree_bytes(&surface->tree) + cml_safe_map_bytes(&surface->map) +
           cml_centred_mesh_bytes(&surface->centred);
}

const struct cml_safe_map *cml_mesh_surface_map(const struct cml_mesh_surface *surface)
{
    return surface->map.safe ? &surface->map : NULL;
}

const char *cml_mesh_library(void)
{
    return "Embree " RTC_VERSION_STRING;
}

bool cml_mesh_surface_is_sheet(const struct cml_mesh_surface *surface)
{
    return surface->grid.levels > 0;
}
