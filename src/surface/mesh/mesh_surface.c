/* SPDX-License-Identifier: MIT */
#include "surface/mesh/mesh_surface.h"

#include "surface/mesh/grid_walk.h"
#include "surface/mesh/mesh_facet.h"
#include "surface/mesh/mesh_line.h"
#include "surface/mesh/rounding.h"
#include "surface/mesh/sheet_mesh.h"

#include <math.h>
#include <stdlib.h>

#if CML_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
typedef struct RTCRayQueryContext query_context;
#define FILTER_FLAG RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS
#else
#include <embree3/rtcore.h>
typedef struct RTCIntersectContext query_context;
#define FILTER_FLAG RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION
#endif

struct cml_mesh_surface {
    struct cml_mesh_body body;
    _Atomic ssize_t embree_bytes;  /* kept by Embree's threads */
    RTCScene exact;                /* boxes around triangles that are tested in double */
    RTCScene fast;                 /* Embree's own single-precision triangles; NULL where there are cells */
    struct cml_grid_mesh grid;     /* traversed in Embree's stead; regular or of a sheet */
    struct cml_mesh_period period; /* n 0: the mesh is not repeated */
};

/* Embree hands the context through to the callbacks, so the double-precision query rides behind it. */
struct query {
    query_context context;
    struct cml_mesh_query ray;
    struct cml_mesh_line *line; /* NULL unless the whole line is followed */
    bool contact_only;          /* only looks for facets that the packet may be beyond */
};

/* Embree calls it for every box that the ray meets. Later boxes are of no interest once a hit is closer. */
static void intersect_triangle(const struct RTCIntersectFunctionNArguments *arguments)
{
    struct query *query = (struct query *)(void *)arguments->context;
    struct cml_mesh_query *q = &query->ray;
    const int primitive = (int)arguments->primID;
    double t, weight[3];
    if (!arguments->valid[0]) return;
    if (query->line) {
        cml_line_add(query->line, primitive);
        return;
    }
    if (primitive == q->exclude) return;
    cml_query_test_contact(q, primitive);
    if (query->contact_only) return;
    if (!cml_query_intersect(q, primitive, &t, weight)) return;
    cml_query_add_hit(q, primitive, t, weight);
    struct RTCRayHit *rayhit = (struct RTCRayHit *)(void *)arguments->rayhit;
    const float t_far = (float)(q->t - q->t_entry + 2 * q->body->err_float);
    if (t_far < rayhit->ray.tfar) rayhit->ray.tfar = t_far > 0 ? t_far : 0;
    rayhit->hit.geomID = arguments->geomID;
    rayhit->hit.primID = arguments->primID;
#if CML_EMBREE_MAJOR >= 4
    arguments->valid[0] = -1;
#endif
}

/* Larger by err_float: whatever a float does to box and ray, Embree meets the box of every triangle that the
 * ray meets in double. */
static void triangle_bounds(const struct RTCBoundsFunctionArguments *arguments)
{
    const struct cml_mesh_surface *surface = arguments->geometryUserPtr;
    const struct cml_mesh *mesh = &surface->body.mesh;
    const uint32_t *v = mesh->triangle[arguments->primID];
    float *lower = &arguments->bounds_o->lower_x, *upper = &arguments->bounds_o->upper_x;
    for (int k = 0; k < 3; k++) {
        const double a = mesh->vertex[v[0]][k], b = mesh->vertex[v[1]][k], c = mesh->vertex[v[2]][k];
        lower[k] = (float)(fmin(a, fmin(b, c)) - surface->body.err_float);
        upper[k] = (float)(fmax(a, fmax(b, c)) + surface->body.err_float);
    }
}

/* From the entry point to distance `leave`. */
static void fill_ray(const struct cml_mesh_query *q, double leave, struct RTCRayHit *rayhit)
{
    *rayhit = (struct RTCRayHit){0};
    rayhit->ray.org_x = (float)q->entry[0];
    rayhit->ray.org_y = (float)q->entry[1];
    rayhit->ray.org_z = (float)q->entry[2];
    rayhit->ray.dir_x = (float)q->direction[0];
    rayhit->ray.dir_y = (float)q->direction[1];
    rayhit->ray.dir_z = (float)q->direction[2];
    rayhit->ray.tfar = (float)(leave - q->t_entry + 2 * q->body->err_float);
    rayhit->ray.mask = 0xffffffffu;
    rayhit->hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rayhit->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
}

/* The part of the ray inside the mesh's box; false when there is none. */
static bool make_ray(struct cml_mesh_query *q, double back, struct RTCRayHit *rayhit)
{
    double leave;
    if (!cml_query_clip_ray(q, back, &leave)) return false;
    fill_ray(q, leave, rayhit);
    return true;
}

/* The whole line, ahead and behind. */
static bool make_line(struct cml_mesh_query *q, struct RTCRayHit *rayhit)
{
    double leave;
    if (!cml_query_clip_line(q, &leave)) return false;
    fill_ray(q, leave, rayhit);
    return true;
}

/* Where versions 3 and 4 differ: the filter is handed over in the context or in the arguments. */
static void intersect_scene(RTCScene scene, struct query *query, struct RTCRayHit *rayhit,
                            RTCFilterFunctionN filter)
{
#if CML_EMBREE_MAJOR >= 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    rtcInitRayQueryContext(&query->context);
    arguments.context = &query->context;
    arguments.filter = filter;
    if (filter) arguments.flags |= RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
    rtcIntersect1(scene, rayhit, &arguments);
#else
    rtcInitIntersectContext(&query->context);
    query->context.filter = filter;
    rtcIntersect1(scene, &query->context, rayhit);
#endif
}

static void query_exact(const struct cml_mesh_surface *surface, struct query *query)
{
    struct RTCRayHit rayhit;
    if (make_ray(&query->ray, 0, &rayhit)) intersect_scene(surface->exact, query, &rayhit, NULL);
}

/* Contact test around the packet: whether one that stands on no facet lies within rounding of one. A ray at a
 * small angle to that facet may be told nothing of it by Embree, in whose single precision it lies behind the
 * ray's beginning. Only boxes at the origin are asked for: the ray's length is that of their err_float. */
static void test_contact_around(const struct cml_mesh_surface *surface, struct query *query)
{
    struct RTCRayHit rayhit;
    double leave;
    if (!cml_query_clip_ray(&query->ray, 0, &leave) || query->ray.t_entry > 0) return;
    fill_ray(&query->ray, query->ray.t_entry, &rayhit);
    query->contact_only = true;
    intersect_scene(surface->exact, query, &rayhit, NULL);
    query->contact_only = false;
}

static bool is_within(const double weight[3], double least)
{
    return weight[0] > least && weight[1] > least && weight[2] > least;
}

/* Whether a hit of Embree's is a crossing to look for: not of the triangle that the packet stands on,
 * exiting, and not behind the packet. The enlarged triangles tell of facets that the line itself misses, so
 * the contact test comes along for free. */
static bool is_exit(struct cml_mesh_query *q, int primitive, double *t, double *along)
{
    *t = cml_query_plane_distance(q, primitive, along);
    q->in_doubt = q->in_doubt || fabs(*t * *along) <= q->contact_distance;
    return primitive != q->exclude && (q->below ? *along : -*along) > 0 && cml_query_is_ahead(q, *t, *along);
}

/* Lets Embree go on past hits that are no exit, and keeps the first entering crossing ahead: it can only come
 * after an exiting one. Not one that the line passes beside, within the enlargement. */
static void filter_hit(const struct RTCFilterFunctionNArguments *arguments)
{
    struct cml_mesh_query *q = &((struct query *)(void *)arguments->context)->ray;
    const struct RTCHit *hit = (const struct RTCHit *)(const void *)arguments->hit;
    const int primitive = (int)hit->primID;
    double t, along, weight[3];
    if (is_exit(q, primitive, &t, &along)) return;
    arguments->valid[0] = 0;
    if (primitive == q->exclude || !((q->below ? along : -along) < 0 && t > q->err_query)) return;
    cml_facet_weights(hit->u, hit->v, weight);
    if (is_within(weight, -err_weight_embree)) q->t_entering = fmin(q->t_entering, t);
}

/* The closest exit; false when there is none. A filter costs Embree half as much again, so a packet that
 * stands on nothing tries without one first: what it then meets is nearly always an exit. */
static bool closest_hit(const struct cml_mesh_surface *surface, struct query *query, struct RTCRayHit *rayhit,
                        double *t, double *along)
{
    const struct RTCRayHit before = *rayhit;
    if (query->ray.exclude < 0) {
        intersect_scene(surface->fast, query, rayhit, NULL);
        if (rayhit->hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
        if (is_exit(&query->ray, (int)rayhit->hit.primID, t, along)) return true;
        *rayhit = before;
    }
    query->ray.t_entering = INFINITY;
    intersect_scene(surface->fast, query, rayhit, filter_hit);
    const bool found = rayhit->hit.geomID != RTC_INVALID_GEOMETRY_ID &&
                       is_exit(&query->ray, (int)rayhit->hit.primID, t, along);
    if (query->ray.t_entering < (found ? *t : query->ray.t)) query->ray.in_doubt = true;
    return found;
}

static bool note_facet(struct RTCPointQueryFunctionArguments *arguments)
{
    *(bool *)arguments->userPtr = true;
    arguments->query->radius = 0;
    return true;
}

/* Whether a path beside a closed mesh ends where it does if Embree has missed a facet. */
static bool ends_beside_facet(const struct cml_mesh_surface *surface, const struct cml_mesh_query *q)
{
    const double distance = cml_query_missed_distance(q);
    if (distance < q->err_query) return false;
    struct RTCPointQuery query = {.x = (float)(q->origin[0] + q->t * q->direction[0]),
                                  .y = (float)(q->origin[1] + q->t * q->direction[1]),
                                  .z = (float)(q->origin[2] + q->t * q->direction[2]),
                                  .radius = (float)distance};
    struct RTCPointQueryContext context;
    bool found = false;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(surface->exact, &query, &context, note_facet, &found);
    return found;
}

/* Embree's own triangles find the hit, whose distance is computed again in double. The exact query decides
 * where the hit is at a small angle, near an edge, or where nothing was found although the path is endless,
 * passes the border, or leaves the mesh's depths. The whole line decides where an entering crossing comes
 * first: an exit before it was missed, at an edge from which the packet starts, which no float can tell from
 * a place beside it. The ray starts a little behind the packet, which rounding may have put beyond a facet.
 */
static void query_embree(const struct cml_mesh_surface *surface, struct query *query)
{
    struct cml_mesh_query *q = &query->ray;
    struct RTCRayHit rayhit;
    double t = INFINITY, along = 0; /* for want of a hit */
    if (q->contact_distance >= 0 && q->exclude != CML_OFF_FACETS) test_contact_around(surface, query);
    if (!make_ray(q, 2 * q->body->err_float, &rayhit)) return;
    const bool found = closest_hit(surface, query, &rayhit, &t, &along);
    double weight[3];
    cml_facet_weights(rayhit.hit.u, rayhit.hit.v, weight);
    if (found && is_within(weight, err_weight_embree) && fabs(along) > err_sine_embree)
        cml_query_add_inner_hit(q, (int)rayhit.hit.primID, q->body->plane[rayhit.hit.primID], t, weight);
    else if (found || !(q->t < INFINITY) || cml_query_may_have_missed(q) || ends_beside_facet(surface, q))
        query_exact(surface, query);
}

/* In doubt: every triangle along the whole line, by exact signs. Returns whether the path ends beside one. */
static bool query_line(const struct cml_mesh_surface *surface, struct query *query, double t_max)
{
    struct cml_mesh_line line;
    struct RTCRayHit rayhit;
    cml_line_begin(&line, &query->ray, t_max);
    query->line = &line;
    if (make_line(&query->ray, &rayhit)) intersect_scene(surface->exact, query, &rayhit, NULL);
    cml_line_decide(&line, &query->ray);
    return line.ends_near_facet;
}

/* Undecided traversals are rare: at edges and small angles only. */
static void query_grid(const struct cml_mesh_surface *surface, struct query *query)
{
    if (!cml_grid_walk(&surface->grid, &query->ray)) query_exact(surface, query);
}

/* Packets that stand near an edge go the exact way at once: the fast ones would only send them there. The
 * outer plane is left out where the traversal has shown that the ray stays over the grid. */
static inline int hit_mesh(const struct cml_mesh_surface *surface, const double p[3], const double u[3],
                           int below, double t_max, int exclude, int undeflected, int exact,
                           double err_position, struct cml_mesh_crossing *crossing)
{
    struct query query;
    query.line = NULL;
    query.contact_only = false;
    cml_query_begin(&query.ray, &surface->body, p, u, below, t_max, exclude, undeflected, err_position);
    if (exact || query.ray.starts_on_edge)
        query_exact(surface, &query);
    else if (surface->grid.levels)
        query_grid(surface, &query);
    else
        query_embree(surface, &query);
    if (exact || !surface->grid.levels || !cml_grid_walk_covers(&surface->grid, &query.ray))
        cml_query_intersect_outer_plane(&query.ray);
    crossing->ends_near_facet = cml_query_is_doubtful(&query.ray) && query_line(surface, &query, t_max);
    return cml_query_finish(&query.ray, p, u, crossing);
}

/* Where the mesh is, and more than rounding: from the boundary's depth, cm. */
static void find_depths(const struct cml_mesh_surface *surface, double err_position, double *low,
                        double *high)
{
    const struct cml_mesh_body *body = &surface->body;
    const double more = 2 * err_line_factor * err_position + body->err_float;
    *low = body->lower[2] + body->centre[2] - more;
    *high = body->upper[2] + body->centre[2] + more;
}

/* What a segment has found, as a crossing of the whole path. */
static int finish_tile(const struct cml_mesh_surface *surface, const struct cml_tile_path *path,
                       struct cml_mesh_crossing *crossing)
{
    crossing->t += path->from;
    for (int k = 0; k < 2; k++) crossing->point[k] = path->p[k] + crossing->t * path->u[k];
    crossing->primitive = cml_tile_primitive(&surface->period, crossing->primitive);
    return crossing->primitive >= 0;
}

/* Segment by segment. One that begins on the way has the rounding of how far it is, too. */
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

/* A tile's cells are those of one copy, and a shading normal is that of a place in a facet. Vectors look up
 * eight times the number of a cell in 32 bits. */
const struct cml_grid_mesh *cml_mesh_surface_grid(const struct cml_mesh_surface *surface,
                                                  const struct cml_mesh_body **body)
{
    const struct cml_grid_mesh *grid = &surface->grid;
    *body = &surface->body;
    if (!grid->levels || surface->period.n[0] || surface->body.mesh.normals != CML_NORMALS_FACET) return NULL;
    return cml_grid_mesh_places(&grid->level[0]) < (size_t)1 << 27 ? grid : NULL;
}

/* One for all, kept to the end: Embree takes a pthread key for each, of which a process has 1024. */
static RTCDevice device;

static bool count_memory(void *context, ssize_t bytes, bool post)
{
    (void)post;
    struct cml_mesh_surface *surface = context;
    surface->embree_bytes += bytes;
    return true;
}

static RTCScene new_scene(const struct cml_mesh_surface *surface)
{
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST | FILTER_FLAG);
    rtcSetSceneBuildQuality(scene, surface->body.mesh.num_triangles > 1000000 ? RTC_BUILD_QUALITY_MEDIUM
                                                                              : RTC_BUILD_QUALITY_HIGH);
    return scene;
}

static void commit(RTCScene scene, RTCGeometry geometry)
{
    rtcSetGeometryMask(geometry, 0xffffffffu);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
}

static void build_exact(struct cml_mesh_surface *surface)
{
    surface->exact = new_scene(surface);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, (unsigned)surface->body.mesh.num_triangles);
    rtcSetGeometryUserData(geometry, surface);
    rtcSetGeometryBoundsFunction(geometry, triangle_bounds, NULL);
    rtcSetGeometryIntersectFunction(geometry, intersect_triangle);
    commit(surface->exact, geometry);
}

/* False when Embree has no memory for the buffers; its own error then says so. */
static bool build_fast(struct cml_mesh_surface *surface)
{
    const struct cml_mesh *mesh = &surface->body.mesh;
    surface->fast = new_scene(surface);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                              3 * sizeof(float), 3 * mesh->num_triangles);
    uint32_t *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                3 * sizeof(uint32_t), mesh->num_triangles);
    if (!vertices || !indices) {
        rtcReleaseGeometry(geometry);
        return false;
    }
    for (size_t i = 0; i < mesh->num_triangles; i++) cml_facet_enlarge(mesh, i, vertices + 9 * i);
    for (size_t i = 0; i < 3 * mesh->num_triangles; i++) indices[i] = (uint32_t)i;
    commit(surface->fast, geometry);
    return true;
}

static cml_status build_trees(struct cml_mesh_surface *surface, struct cml_error *err)
{
    if (!device && !(device = rtcNewDevice(NULL)))
        return cml_fail(err, CML_E_DEVICE, "Embree cannot start (error %d)", (int)rtcGetDeviceError(NULL));
    rtcSetDeviceMemoryMonitorFunction(device, count_memory, surface);
    if (surface->grid.levels || build_fast(surface)) build_exact(surface);
    rtcSetDeviceMemoryMonitorFunction(device, NULL, NULL);
    const enum RTCError error = rtcGetDeviceError(device);
    if (error == RTC_ERROR_NONE) return CML_OK;
    return cml_fail(err, error == RTC_ERROR_OUT_OF_MEMORY ? CML_E_INPUT : CML_E_DEVICE,
                    "Embree cannot build a tree of %zu triangles (error %d)",
                    surface->body.mesh.num_triangles, (int)error);
}

cml_status cml_mesh_surface_create(struct cml_mesh *mesh, double x0, double y0, enum cml_mesh_search search,
                                   struct cml_mesh_surface **surface, struct cml_error *err)
{
    struct cml_mesh_surface *made = calloc(1, sizeof *made);
    *surface = NULL;
    if (!made) return cml_fail_memory(err, sizeof *made, "a mesh surface");
    cml_status status = cml_mesh_body_create(mesh, x0, y0, &made->body, err);
    if (status == CML_OK && search == CML_SEARCH_AUTO)
        status = cml_grid_mesh_find(&made->body, &made->grid, err);
    if (status == CML_OK && search == CML_SEARCH_AUTO && made->grid.levels == 0)
        status = cml_sheet_mesh_find(&made->body, &made->grid, err);
    if (status == CML_OK) status = build_trees(made, err);
    if (status != CML_OK)
        cml_mesh_surface_free(made);
    else
        *surface = made;
    return status;
}

cml_status cml_mesh_surface_create_tile(struct cml_mesh *mesh, double x0, double y0,
                                        enum cml_mesh_search search, const struct cml_mesh_period *period,
                                        struct cml_mesh_surface **surface, struct cml_error *err)
{
    CML_TRY(cml_mesh_surface_create(mesh, x0, y0, search, surface, err));
    (*surface)->period = *period;
    (*surface)->period.corner[0] -= x0;
    (*surface)->period.corner[1] -= y0;
    return CML_OK;
}

void cml_mesh_surface_free(struct cml_mesh_surface *surface)
{
    if (!surface) return;
    if (surface->exact) rtcReleaseScene(surface->exact);
    if (surface->fast) rtcReleaseScene(surface->fast);
    cml_grid_mesh_clear(&surface->grid);
    cml_mesh_body_clear(&surface->body);
    free(surface);
}

const struct cml_mesh *cml_mesh_surface_mesh(const struct cml_mesh_surface *surface, double middle[3])
{
    middle[0] = -surface->body.axis[0];
    middle[1] = -surface->body.axis[1];
    middle[2] = surface->body.centre[2];
    return &surface->body.mesh;
}

uint64_t cml_mesh_surface_primitives(const struct cml_mesh_surface *surface)
{
    const struct cml_mesh_period *period = &surface->period;
    return period->n[0] ? cml_tile_primitives(period) : surface->body.mesh.num_triangles;
}

size_t cml_mesh_surface_triangle(const struct cml_mesh_surface *surface, size_t primitive)
{
    return surface->period.n[0] ? (size_t)cml_tile_triangle(&surface->period, (int)primitive) : primitive;
}

const struct cml_mesh_period *cml_mesh_surface_period(const struct cml_mesh_surface *surface)
{
    return &surface->period;
}

double cml_mesh_surface_bytes(const struct cml_mesh_surface *surface)
{
    return (double)surface->embree_bytes + cml_grid_mesh_bytes(&surface->grid) +
           cml_mesh_body_bytes(&surface->body);
}

const char *cml_mesh_library(void)
{
    return "Embree " RTC_VERSION_STRING;
}

const char *cml_mesh_surface_walk(const struct cml_mesh_surface *surface)
{
    return surface->grid.cell ? "a regular grid" : surface->grid.levels ? "a sheet" : NULL;
}
