/* SPDX-License-Identifier: MIT */
#include "surface/mesh/mesh_surface.h"

#include "surface/mesh/grid_walk.h"
#include "surface/mesh/mesh_line.h"

#include <float.h>
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
    RTCDevice device;
    _Atomic ssize_t embree_bytes; /* kept by Embree's threads */
    RTCScene exact;               /* boxes around triangles that are tested in double */
    RTCScene fast;                /* Embree's own single-precision triangles; NULL where there is a grid */
    struct cml_grid_mesh grid;    /* of a regular grid, walked in Embree's stead; else without cells */
};

/* Embree hands the context through to the callbacks, so the double-precision query rides behind it. */
struct query {
    query_context context;
    struct cml_mesh_query ray;
    struct cml_mesh_line *line; /* NULL unless the whole line is followed */
    bool feels;                 /* only looks for facets that the packet may be beyond */
};

static void intersect(const struct RTCIntersectFunctionNArguments *arguments)
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
    cml_query_feel(q, primitive);
    if (query->feels) return;
    if (!cml_query_cross(q, primitive, &t, weight)) return;
    cml_query_take(q, primitive, t, weight);
    struct RTCRayHit *rayhit = (struct RTCRayHit *)(void *)arguments->rayhit;
    const float reach = (float)(q->t - q->base + 2 * q->body->inflation);
    if (reach < rayhit->ray.tfar) rayhit->ray.tfar = reach > 0 ? reach : 0;
    rayhit->hit.geomID = arguments->geomID;
    rayhit->hit.primID = arguments->primID;
#if CML_EMBREE_MAJOR >= 4
    arguments->valid[0] = -1;
#endif
}

static void bounds(const struct RTCBoundsFunctionArguments *arguments)
{
    const struct cml_mesh_surface *surface = arguments->geometryUserPtr;
    const struct cml_mesh *mesh = &surface->body.mesh;
    const uint32_t *v = mesh->triangle[arguments->primID];
    float *lower = &arguments->bounds_o->lower_x, *upper = &arguments->bounds_o->upper_x;
    for (int k = 0; k < 3; k++) {
        const double a = mesh->vertex[v[0]][k], b = mesh->vertex[v[1]][k], c = mesh->vertex[v[2]][k];
        lower[k] = (float)(fmin(a, fmin(b, c)) - surface->body.inflation);
        upper[k] = (float)(fmax(a, fmax(b, c)) + surface->body.inflation);
    }
}

/* The line from q->near, at q->base, to a distance. */
static void aim_from_near(const struct cml_mesh_query *q, double leave, struct RTCRayHit *rayhit)
{
    *rayhit = (struct RTCRayHit){0};
    rayhit->ray.org_x = (float)q->near[0];
    rayhit->ray.org_y = (float)q->near[1];
    rayhit->ray.org_z = (float)q->near[2];
    rayhit->ray.dir_x = (float)q->direction[0];
    rayhit->ray.dir_y = (float)q->direction[1];
    rayhit->ray.dir_z = (float)q->direction[2];
    rayhit->ray.tfar = (float)(leave - q->base + 2 * q->body->inflation);
    rayhit->ray.mask = 0xffffffffu;
    rayhit->hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rayhit->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
}

static bool aim(struct cml_mesh_query *q, double back, struct RTCRayHit *rayhit)
{
    double leave;
    if (!cml_query_approach(q, back, &leave)) return false;
    aim_from_near(q, leave, rayhit);
    return true;
}

/* The whole line, ahead and behind. */
static bool aim_at_all(struct cml_mesh_query *q, struct RTCRayHit *rayhit)
{
    double leave;
    if (!cml_query_approach_all(q, &leave)) return false;
    aim_from_near(q, leave, rayhit);
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
    if (aim(&query->ray, 0, &rayhit)) intersect_scene(surface->exact, query, &rayhit, NULL);
}

/* Whether a packet that stands on no facet lies within rounding of one. A ray that grazes that facet may be
 * told nothing of it by Embree, in whose single precision it lies behind the ray's beginning. */
static void feel_around(const struct cml_mesh_surface *surface, struct query *query)
{
    struct RTCRayHit rayhit;
    double leave;
    if (!cml_query_approach(&query->ray, 0, &leave) || query->ray.base > 0) return;
    aim_from_near(&query->ray, query->ray.base, &rayhit);
    query->feels = true;
    intersect_scene(surface->exact, query, &rayhit, NULL);
    query->feels = false;
}

/* By how much, in heights, triangles are enlarged for Embree: in single precision it lets rays pass between
 * those that meet at a corner or that they graze, most easily a ray along an edge. */
static const float rim = 1e-3f;

/* Barycentric weights in the triangle itself; Embree's coordinates are those in the enlarged one. */
static void find_weights(float u, float v, double weight[3])
{
    const float coordinate[3] = {1 - u - v, u, v};
    for (int k = 0; k < 3; k++) weight[k] = coordinate[k] + 3 * (double)rim * (coordinate[k] - 1.0 / 3);
}

/* Whether all weights are at least `least`. More than `clearly` above 0, whatever single precision does to
 * them, they are those of a place inside, and less than that below of one outside. */
static const double clearly = 1e-5;
static bool is_within(const double weight[3], double least)
{
    return weight[0] > least && weight[1] > least && weight[2] > least;
}

/* Which of Embree's hits count: not the triangle the packet stands on, only those that lead away from its
 * side, and none behind it. Beside an edge the enlarged triangles tell of facets that the line itself passes
 * by. */
static bool counts(struct cml_mesh_query *q, int primitive, double *t, double *along)
{
    *t = cml_query_facet_distance(q, primitive, along);
    q->doubt = q->doubt || fabs(*t * *along) <= q->touch;
    return primitive != q->exclude && (q->below ? *along : -*along) > 0 && cml_query_is_ahead(q, *t, *along);
}

/* Keeps the first one ahead that leads back to the packet's side: it can only come after one that leads away.
 * Not one that the line passes beside, within the rim. */
static void filter_hit(const struct RTCFilterFunctionNArguments *arguments)
{
    struct cml_mesh_query *q = &((struct query *)(void *)arguments->context)->ray;
    const struct RTCHit *hit = (const struct RTCHit *)(const void *)arguments->hit;
    const int primitive = (int)hit->primID;
    double t, along, weight[3];
    if (counts(q, primitive, &t, &along)) return;
    arguments->valid[0] = 0;
    if (primitive == q->exclude || !((q->below ? along : -along) < 0 && t > q->reach)) return;
    find_weights(hit->u, hit->v, weight);
    if (is_within(weight, -clearly)) q->back = fmin(q->back, t);
}

/* The closest hit that counts; false when there is none. A filter costs Embree half as much again, so a
 * packet that stands on nothing tries without one first: what it then meets is nearly always what counts. */
static bool closest(const struct cml_mesh_surface *surface, struct query *query, struct RTCRayHit *rayhit,
                    double *t, double *along)
{
    const struct RTCRayHit fresh = *rayhit;
    if (query->ray.exclude < 0) {
        intersect_scene(surface->fast, query, rayhit, NULL);
        if (rayhit->hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
        if (counts(&query->ray, (int)rayhit->hit.primID, t, along)) return true;
        *rayhit = fresh;
    }
    query->ray.back = INFINITY;
    intersect_scene(surface->fast, query, rayhit, filter_hit);
    const bool found = rayhit->hit.geomID != RTC_INVALID_GEOMETRY_ID &&
                       counts(&query->ray, (int)rayhit->hit.primID, t, along);
    if (query->ray.back < (found ? *t : query->ray.t)) query->ray.doubt = true;
    return found;
}

/* Sine of the angle to the facet below which single precision cannot tell which facet comes first. */
static const double grazing = 1e-2;

/* The fast way: Embree's own triangles find the hit, whose distance is computed again in double. Where it
 * grazes its triangle, is not clearly inside its triangle, or nothing was found on a way without end, past
 * the border, or out of the mesh's depths, the exact query decides. Where a facet that leads back comes
 * first, the whole line does: the fast way has missed one before it, at an edge from which the packet starts,
 * which no float can tell from one beside it. The ray starts a little behind the packet, because rounding may
 * have put it beyond a facet.
 */
static void query_fast(const struct cml_mesh_surface *surface, struct query *query)
{
    struct cml_mesh_query *q = &query->ray;
    struct RTCRayHit rayhit;
    double t = INFINITY, along = 0; /* for want of a hit */
    if (q->touch >= 0) feel_around(surface, query);
    if (!aim(q, 2 * q->body->inflation, &rayhit)) return;
    const bool found = closest(surface, query, &rayhit, &t, &along);
    double weight[3];
    find_weights(rayhit.hit.u, rayhit.hit.v, weight);
    if (found && is_within(weight, clearly) && fabs(along) > grazing)
        cml_query_take_inside(q, (int)rayhit.hit.primID, q->body->plane[rayhit.hit.primID], t, weight);
    else if (found || !(q->t < INFINITY) || cml_query_may_have_missed(q))
        query_exact(surface, query);
}

/* In doubt: every triangle along the whole line, by exact signs. Returns whether the path ends beside one. */
static bool query_line(const struct cml_mesh_surface *surface, struct query *query, double t_max)
{
    struct cml_mesh_line line;
    struct RTCRayHit rayhit;
    cml_line_begin(&line, &query->ray, t_max);
    query->line = &line;
    if (aim_at_all(&query->ray, &rayhit)) intersect_scene(surface->exact, query, &rayhit, NULL);
    cml_line_decide(&line, &query->ray);
    return line.ends_beside;
}

static void query_walked(const struct cml_mesh_surface *surface, struct query *query)
{
    if (!cml_grid_walk(&surface->grid, &query->ray)) query_exact(surface, query);
}

int cml_mesh_surface_hit(const struct cml_mesh_surface *surface, const double p[3], const double u[3],
                         int below, double t_max, int exclude, int straight, int exact, double slack,
                         struct cml_mesh_crossing *crossing)
{
    struct query query;
    query.line = NULL;
    query.feels = false;
    cml_query_begin(&query.ray, &surface->body, p, u, below, t_max, exclude, straight, slack);
    if (exact || query.ray.on_edge)
        query_exact(surface, &query);
    else if (surface->grid.cell)
        query_walked(surface, &query);
    else
        query_fast(surface, &query);
    if (exact || !surface->grid.cell || !cml_grid_covers(&surface->grid, &query.ray))
        cml_query_outer_plane(&query.ray);
    crossing->ends_beside = cml_query_is_doubtful(&query.ray) && query_line(surface, &query, t_max);
    return cml_query_finish(&query.ray, p, u, crossing);
}

static bool count_memory(void *context, ssize_t bytes, bool post)
{
    (void)post;
    struct cml_mesh_surface *surface = context;
    surface->embree_bytes += bytes;
    return true;
}

static RTCScene new_scene(const struct cml_mesh_surface *surface)
{
    RTCScene scene = rtcNewScene(surface->device);
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
    RTCGeometry geometry = rtcNewGeometry(surface->device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, (unsigned)surface->body.mesh.num_triangles);
    rtcSetGeometryUserData(geometry, surface);
    rtcSetGeometryBoundsFunction(geometry, bounds, NULL);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    commit(surface->exact, geometry);
}

/* A triangle as Embree gets it: every side moved outwards by `rim` of its height. */
static void enlarge(const struct cml_mesh *mesh, const uint32_t v[3], float corner[9])
{
    for (int axis = 0; axis < 3; axis++) {
        double middle = 0;
        for (int k = 0; k < 3; k++) middle += mesh->vertex[v[k]][axis] / 3;
        for (int k = 0; k < 3; k++) {
            const double at = mesh->vertex[v[k]][axis];
            corner[3 * k + axis] = (float)(at + 3 * (double)rim * (at - middle));
        }
    }
}

/* False when Embree has no memory for the buffers; its own error then says so. */
static bool build_fast(struct cml_mesh_surface *surface)
{
    const struct cml_mesh *mesh = &surface->body.mesh;
    surface->fast = new_scene(surface);
    RTCGeometry geometry = rtcNewGeometry(surface->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                              3 * sizeof(float), 3 * mesh->num_triangles);
    uint32_t *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                3 * sizeof(uint32_t), mesh->num_triangles);
    if (!vertices || !indices) {
        rtcReleaseGeometry(geometry);
        return false;
    }
    for (size_t i = 0; i < mesh->num_triangles; i++) enlarge(mesh, mesh->triangle[i], vertices + 9 * i);
    for (size_t i = 0; i < 3 * mesh->num_triangles; i++) indices[i] = (uint32_t)i;
    commit(surface->fast, geometry);
    return true;
}

static cml_status build_trees(struct cml_mesh_surface *surface, struct cml_error *err)
{
    surface->device = rtcNewDevice(NULL);
    if (!surface->device)
        return cml_fail(err, CML_E_DEVICE, "Embree cannot start (error %d)", (int)rtcGetDeviceError(NULL));
    rtcSetDeviceMemoryMonitorFunction(surface->device, count_memory, surface);
    if (surface->grid.cell || build_fast(surface)) build_exact(surface);
    const enum RTCError error = rtcGetDeviceError(surface->device);
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
    if (status == CML_OK) status = build_trees(made, err);
    if (status != CML_OK)
        cml_mesh_surface_free(made);
    else
        *surface = made;
    return status;
}

void cml_mesh_surface_free(struct cml_mesh_surface *surface)
{
    if (!surface) return;
    if (surface->exact) rtcReleaseScene(surface->exact);
    if (surface->fast) rtcReleaseScene(surface->fast);
    if (surface->device) rtcReleaseDevice(surface->device);
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

uint64_t cml_mesh_surface_triangles(const struct cml_mesh_surface *surface)
{
    return surface->body.mesh.num_triangles;
}

double cml_mesh_surface_bytes(const struct cml_mesh_surface *surface)
{
    const struct cml_mesh *mesh = &surface->body.mesh;
    return (double)surface->embree_bytes + cml_grid_mesh_bytes(&surface->grid) +
           (double)mesh->num_triangles * (sizeof *mesh->triangle + sizeof *surface->body.plane) +
           (double)mesh->num_vertices * (sizeof *mesh->vertex + sizeof *mesh->vertex_normal);
}

const char *cml_mesh_library(void)
{
    return "Embree " RTC_VERSION_STRING;
}

bool cml_mesh_surface_is_walked(const struct cml_mesh_surface *surface)
{
    return surface->grid.cell != NULL;
}
