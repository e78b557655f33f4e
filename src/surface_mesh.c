/* SPDX-License-Identifier: MIT */
#include "surface_mesh.h"

#include "footprint.h"
#include "surface_hit.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#if CML_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
typedef struct RTCRayQueryContext query_context;
#else
#include <embree3/rtcore.h>
typedef struct RTCIntersectContext query_context;
#endif

struct cml_mesh_surface {
    struct cml_mesh mesh; /* vertices relative to centre */
    double centre[3];     /* in query coordinates: x and y from the beam's axis, z in the boundary's frame */
    double
        axis[2]; /* the scene's z axis relative to centre: where the field of an analytic normal is centred */
    double lower[3], upper[3]; /* box, inflated, relative to centre */
    double inflation;          /* how much every box grows: more than the rounding of ray and box to float */
    struct cml_footprint *footprint;
    RTCDevice device;
    _Atomic ssize_t embree_bytes; /* kept by Embree's threads */
    RTCScene scene;
};

/* Embree hands the context through to the callback, so the double-precision query rides behind it. */
struct query {
    query_context context;
    const struct cml_mesh_surface *surface;
    double origin[3], direction[3]; /* relative to centre */
    double base;                    /* distance at which the ray enters the mesh's box */
    double near[3]; /* that point: triangles are tested from there, so that a far origin costs no digits */
    double blur;    /* rounding of its coordinates */
    double coarse;  /* more than rounding can make of any edge product */
    double slack;   /* the rounding of the packet's position: how far behind the origin a crossing may lie */
    double least;   /* -slack, or where the line crosses `exclude` when the packet came straight through it */
    int below, exclude;
    double t;         /* best so far */
    double weight[3]; /* its barycentric weights */
    double seam[3];   /* sum of unit facet normals when the best lies on an edge */
    int primitive;    /* -1: none */
    bool on_seam;
};

/* Below this share of a triangle's area a barycentric weight counts as 0: the hit lies on the opposite edge.
 */
static const double on_edge = 1e-12;

static void subtract(const double a[3], const double b[3], double c[3])
{
    for (int k = 0; k < 3; k++) c[k] = a[k] - b[k];
}

static void cross_product(const double a[3], const double b[3], double c[3])
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot_product(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* d . ((a - p) x (b - p)) of the edge from vertex i to j. Computed from the lower index to the higher, so
 * that the two triangles of an edge get exactly opposite numbers. */
static double edge_product(const struct query *q, uint32_t i, uint32_t j)
{
    const double(*vertex)[3] = (const double(*)[3])q->surface->mesh.vertex;
    const bool swap = i > j;
    double a[3], b[3], c[3];
    subtract(vertex[swap ? j : i], q->near, a);
    subtract(vertex[swap ? i : j], q->near, b);
    cross_product(a, b, c);
    const double w = dot_product(q->direction, c);
    return swap ? -w : w;
}

/* Whether an edge product below 0 may be 0 but for rounding. */
static bool is_rounding(const struct query *q, double product, uint32_t i, uint32_t j)
{
    if (product < -q->coarse) return false;
    const double *a = q->surface->mesh.vertex[i], *b = q->surface->mesh.vertex[j];
    double sum_a = 0, sum_b = 0, edge = 0;
    for (int k = 0; k < 3; k++) {
        sum_a += fabs(a[k] - q->near[k]);
        sum_b += fabs(b[k] - q->near[k]);
        edge += fabs(a[k] - b[k]);
    }
    return product >= -(4 * DBL_EPSILON * sum_a * sum_b + q->blur * edge);
}

static void facet_normal(const struct cml_mesh *mesh, int primitive, double normal[3])
{
    const uint32_t *v = mesh->triangle[primitive];
    double ab[3], ac[3];
    subtract(mesh->vertex[v[1]], mesh->vertex[v[0]], ab);
    subtract(mesh->vertex[v[2]], mesh->vertex[v[0]], ac);
    cross_product(ab, ac, normal);
}

static void normalise(double v[3])
{
    const double k = 1 / sqrt(dot_product(v, v));
    for (int i = 0; i < 3; i++) v[i] *= k;
}

/* Distance from the near point to the triangle's plane, but never outside the triangle: at grazing incidence
 * the plane alone says little. */
static double triangle_distance(const struct query *q, const uint32_t v[3], const double normal[3],
                                double along)
{
    double low = INFINITY, high = -INFINITY, t = 0;
    for (int k = 0; k < 3; k++) {
        double to_corner[3];
        subtract(q->surface->mesh.vertex[v[k]], q->near, to_corner);
        const double reach = dot_product(q->direction, to_corner);
        low = fmin(low, reach);
        high = fmax(high, reach);
        if (k == 0) t = dot_product(to_corner, normal) / along;
    }
    return fmax(low, fmin(t, high));
}

/* Crossing of one triangle away from the packet's side; on success *t and the barycentric weights. A ray
 * within rounding of an edge meets the triangles on both sides of it: exact signs alone leave pinholes at
 * vertices, where the signs of several edges have to agree, and along the border, beyond which the plane
 * begins. */
static bool cross_triangle(const struct query *q, int primitive, double *t, double weight[3])
{
    const uint32_t *v = q->surface->mesh.triangle[primitive];
    const double sign = q->below ? 1 : -1;
    double normal[3];
    for (int k = 0; k < 3; k++) {
        const uint32_t i = v[(k + 1) % 3], j = v[(k + 2) % 3];
        weight[k] = sign * edge_product(q, i, j);
        if (!(weight[k] >= 0 || is_rounding(q, weight[k], i, j))) return false;
    }
    facet_normal(&q->surface->mesh, primitive, normal);
    const double along = dot_product(q->direction, normal);
    if (!(sign * along > 0)) return false;
    *t = q->base + triangle_distance(q, v, normal, along);
    const double sum = weight[0] + weight[1] + weight[2];
    for (int k = 0; k < 3; k++) weight[k] = sum > 0 ? weight[k] / sum : 1.0 / 3;
    return *t >= q->least;
}

/* The best crossing so far. One at the same place, on a shared edge, adds its facet to the seam's mean
 * normal. */
static void take(struct query *q, int primitive, double t, const double weight[3])
{
    const bool seam = weight[0] < on_edge || weight[1] < on_edge || weight[2] < on_edge;
    double normal[3];
    facet_normal(&q->surface->mesh, primitive, normal);
    normalise(normal);
    if (q->on_seam && seam && fabs(t - q->t) <= q->slack) {
        for (int k = 0; k < 3; k++) q->seam[k] += normal[k];
        return;
    }
    if (t >= q->t) return;
    q->t = t;
    q->primitive = primitive;
    q->on_seam = seam;
    for (int k = 0; k < 3; k++) {
        q->seam[k] = normal[k];
        q->weight[k] = weight[k];
    }
}

static void intersect(const struct RTCIntersectFunctionNArguments *arguments)
{
    struct query *q = (struct query *)(void *)arguments->context;
    const int primitive = (int)arguments->primID;
    double t, weight[3];
    if (!arguments->valid[0] || primitive == q->exclude) return;
    if (!cross_triangle(q, primitive, &t, weight)) return;
    take(q, primitive, t, weight);
    struct RTCRayHit *rayhit = (struct RTCRayHit *)(void *)arguments->rayhit;
    const float reach = (float)(q->t - q->base + 2 * q->surface->inflation);
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
    const uint32_t *v = surface->mesh.triangle[arguments->primID];
    float *lower = &arguments->bounds_o->lower_x, *upper = &arguments->bounds_o->upper_x;
    for (int k = 0; k < 3; k++) {
        const double a = surface->mesh.vertex[v[0]][k], b = surface->mesh.vertex[v[1]][k],
                     c = surface->mesh.vertex[v[2]][k];
        lower[k] = (float)(fmin(a, fmin(b, c)) - surface->inflation);
        upper[k] = (float)(fmax(a, fmax(b, c)) + surface->inflation);
    }
}

/* The part of the ray inside the mesh's box, so that only numbers of the mesh's own size are rounded to
 * float. */
static bool clip_to_box(const struct query *q, double t_max, double *enter, double *leave)
{
    *enter = 0;
    *leave = t_max;
    for (int k = 0; k < 3; k++) {
        const double lower = q->surface->lower[k] - q->origin[k], upper = q->surface->upper[k] - q->origin[k];
        if (q->direction[k] == 0) {
            if (lower > 0 || upper < 0) return false;
            continue;
        }
        const double a = lower / q->direction[k], b = upper / q->direction[k];
        *enter = fmax(*enter, fmin(a, b));
        *leave = fmin(*leave, fmax(a, b));
    }
    return *enter <= *leave;
}

static void query_triangles(struct query *q)
{
    double enter, leave;
    if (!clip_to_box(q, q->t, &enter, &leave)) return;
    q->base = enter;
    q->blur = DBL_EPSILON * enter;
    double size = 0;
    for (int k = 0; k < 3; k++) {
        q->near[k] = q->origin[k] + enter * q->direction[k];
        q->blur += DBL_EPSILON * (fabs(q->origin[k]) + fabs(q->near[k]));
        size += q->surface->upper[k] - q->surface->lower[k];
    }
    q->coarse = 2 * (4 * DBL_EPSILON * size + q->blur) * size;
    struct RTCRayHit rayhit = {0};
    rayhit.ray.org_x = (float)q->near[0];
    rayhit.ray.org_y = (float)q->near[1];
    rayhit.ray.org_z = (float)q->near[2];
    rayhit.ray.dir_x = (float)q->direction[0];
    rayhit.ray.dir_y = (float)q->direction[1];
    rayhit.ray.dir_z = (float)q->direction[2];
    rayhit.ray.tfar = (float)(leave - enter + 2 * q->surface->inflation);
    rayhit.ray.mask = 0xffffffffu;
    rayhit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rayhit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if CML_EMBREE_MAJOR >= 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    rtcInitRayQueryContext(&q->context);
    arguments.context = &q->context;
    rtcIntersect1(q->surface->scene, &rayhit, &arguments);
#else
    rtcInitIntersectContext(&q->context);
    rtcIntersect1(q->surface->scene, &q->context, &rayhit);
#endif
}

/* The plane outside the footprint. */
static void query_outer_plane(struct query *q)
{
    const double uz = q->direction[2];
    if (q->exclude == CML_OUTER_PLANE || !(q->below ? uz < 0 : uz > 0)) return;
    const double t = (q->surface->mesh.z_border - q->origin[2]) / uz;
    if (!(t >= q->least) || !(t < q->t)) return;
    const double x = q->origin[0] + t * q->direction[0], y = q->origin[1] + t * q->direction[1];
    if (cml_footprint_contains(q->surface->footprint, x, y)) return;
    q->t = t;
    q->primitive = CML_OUTER_PLANE;
}

/* Upward normal of the cone that the triangle stands for. */
static void analytic_normal(const struct query *q, const double point[3], double normal[3])
{
    const double x = point[0] - q->surface->axis[0], y = point[1] - q->surface->axis[1], r = hypot(x, y);
    const double m = q->surface->mesh.slope[q->primitive], k = 1 / sqrt(1 + m * m);
    normal[0] = r > 0 ? m * k * x / r : 0;
    normal[1] = r > 0 ? m * k * y / r : 0;
    normal[2] = r > 0 ? -k : -1;
}

static void interpolated_normal(const struct query *q, double normal[3])
{
    const struct cml_mesh *mesh = &q->surface->mesh;
    const uint32_t *v = mesh->triangle[q->primitive];
    for (int k = 0; k < 3; k++)
        normal[k] = q->weight[0] * mesh->vertex_normal[v[0]][k] +
                    q->weight[1] * mesh->vertex_normal[v[1]][k] + q->weight[2] * mesh->vertex_normal[v[2]][k];
    normalise(normal);
}

/* P1: at a vertex the angle-weighted mean normal, on an edge the mean of its facets; there it is the facet as
 * well, for no single facet can decide. Elsewhere facet and normal are what their names say. */
static void fill_normals(const struct query *q, const double point[3], struct cml_mesh_crossing *crossing)
{
    const struct cml_mesh *mesh = &q->surface->mesh;
    int corner = -1;
    for (int k = 0; k < 3; k++)
        if (q->weight[k] > 1 - 2 * on_edge) corner = k;
    for (int k = 0; k < 3; k++)
        crossing->facet[k] =
            corner >= 0 ? mesh->vertex_normal[mesh->triangle[q->primitive][corner]][k] : q->seam[k];
    const double sign = q->below ? 1 : -1;
    if (!(sign * dot_product(q->direction, crossing->facet) > 0)) /* a mean may turn away from the ray */
        facet_normal(mesh, q->primitive, crossing->facet);
    normalise(crossing->facet);
    for (int k = 0; k < 3; k++) crossing->normal[k] = crossing->facet[k];
    if (q->on_seam) return;
    if (mesh->normals == CML_NORMALS_ANALYTIC)
        analytic_normal(q, point, crossing->normal);
    else if (mesh->normals == CML_NORMALS_VERTEX)
        interpolated_normal(q, crossing->normal);
}

/* Distance along the query's line to the plane of a primitive. */
static double plane_distance(const struct query *q, int primitive)
{
    const struct cml_mesh *mesh = &q->surface->mesh;
    double normal[3] = {0, 0, 1}, to_plane[3] = {0, 0, mesh->z_border - q->origin[2]};
    if (primitive != CML_OUTER_PLANE) {
        facet_normal(mesh, primitive, normal);
        subtract(mesh->vertex[mesh->triangle[primitive][0]], q->origin, to_plane);
    }
    return dot_product(to_plane, normal) / dot_product(q->direction, normal);
}

int cml_mesh_surface_hit(const struct cml_mesh_surface *surface, const double p[3], const double u[3],
                         int below, double t_max, int exclude, int straight, double slack,
                         struct cml_mesh_crossing *crossing)
{
    struct query q = {.surface = surface, .below = below, .exclude = exclude, .t = t_max, .slack = slack};
    q.primitive = -1;
    subtract(p, surface->centre, q.origin);
    for (int k = 0; k < 3; k++) q.direction[k] = u[k];
    q.least = exclude >= 0 && straight ? fmax(-slack, fmin(plane_distance(&q, exclude), slack)) : -slack;
    query_triangles(&q);
    query_outer_plane(&q);
    if (q.primitive < 0) return 0;
    crossing->t = q.t > 0 ? q.t : 0;
    crossing->primitive = q.primitive;
    double local[3];
    for (int k = 0; k < 3; k++) {
        local[k] = q.origin[k] + crossing->t * u[k];
        crossing->point[k] = p[k] + crossing->t * u[k];
        crossing->normal[k] = crossing->facet[k] = k == 2 ? -1 : 0;
    }
    if (q.primitive == CML_OUTER_PLANE)
        crossing->point[2] = surface->mesh.z_border + surface->centre[2];
    else
        fill_normals(&q, local, crossing);
    return 1;
}

/* Vertices relative to the middle of the box; queries subtract it once, in double. */
static void centre_mesh(struct cml_mesh_surface *surface, double x0, double y0)
{
    struct cml_mesh *mesh = &surface->mesh;
    double middle[3], diagonal = 0;
    for (int k = 0; k < 3; k++) {
        middle[k] = 0.5 * (mesh->lower[k] + mesh->upper[k]);
        diagonal = hypot(diagonal, mesh->upper[k] - mesh->lower[k]);
    }
    for (size_t i = 0; i < mesh->num_vertices; i++)
        for (int k = 0; k < 3; k++) mesh->vertex[i][k] -= middle[k];
    mesh->z_border -= middle[2];
    surface->inflation = 1e-6 * diagonal;
    for (int k = 0; k < 3; k++) {
        mesh->lower[k] -= middle[k];
        mesh->upper[k] -= middle[k];
        surface->lower[k] = mesh->lower[k] - 2 * surface->inflation;
        surface->upper[k] = mesh->upper[k] + 2 * surface->inflation;
    }
    surface->centre[0] = middle[0] - x0;
    surface->centre[1] = middle[1] - y0;
    surface->centre[2] = middle[2];
    surface->axis[0] = -middle[0];
    surface->axis[1] = -middle[1];
}

static bool count_memory(void *context, ssize_t bytes, bool post)
{
    (void)post;
    struct cml_mesh_surface *surface = context;
    surface->embree_bytes += bytes;
    return true;
}

static cml_status build_tree(struct cml_mesh_surface *surface, struct cml_error *err)
{
    surface->device = rtcNewDevice(NULL);
    if (!surface->device)
        return cml_fail(err, CML_E_DEVICE, "Embree cannot start (error %d)", (int)rtcGetDeviceError(NULL));
    rtcSetDeviceMemoryMonitorFunction(surface->device, count_memory, surface);
    surface->scene = rtcNewScene(surface->device);
    rtcSetSceneFlags(surface->scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(surface->scene, surface->mesh.num_triangles > 1000000 ? RTC_BUILD_QUALITY_MEDIUM
                                                                                  : RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(surface->device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, (unsigned)surface->mesh.num_triangles);
    rtcSetGeometryUserData(geometry, surface);
    rtcSetGeometryBoundsFunction(geometry, bounds, NULL);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    rtcSetGeometryMask(geometry, 0xffffffffu);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(surface->scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(surface->scene);
    const enum RTCError error = rtcGetDeviceError(surface->device);
    if (error == RTC_ERROR_NONE) return CML_OK;
    return cml_fail(err, error == RTC_ERROR_OUT_OF_MEMORY ? CML_E_INPUT : CML_E_DEVICE,
                    "Embree cannot build a tree of %zu triangles (error %d)", surface->mesh.num_triangles,
                    (int)error);
}

cml_status cml_mesh_surface_create(struct cml_mesh *mesh, double x0, double y0,
                                   struct cml_mesh_surface **surface, struct cml_error *err)
{
    struct cml_mesh_surface *made = calloc(1, sizeof *made);
    *surface = NULL;
    if (!made) return cml_fail_memory(err, sizeof *made, "a mesh surface");
    made->mesh = *mesh;
    *mesh = (struct cml_mesh){0};
    centre_mesh(made, x0, y0);
    cml_status status = cml_footprint_create(&made->mesh, &made->footprint, err);
    if (status == CML_OK) status = build_tree(made, err);
    if (status != CML_OK)
        cml_mesh_surface_free(made);
    else
        *surface = made;
    return status;
}

void cml_mesh_surface_free(struct cml_mesh_surface *surface)
{
    if (!surface) return;
    if (surface->scene) rtcReleaseScene(surface->scene);
    if (surface->device) rtcReleaseDevice(surface->device);
    cml_footprint_free(surface->footprint);
    cml_mesh_clear(&surface->mesh);
    free(surface);
}

uint64_t cml_mesh_surface_triangles(const struct cml_mesh_surface *surface)
{
    return surface->mesh.num_triangles;
}

double cml_mesh_surface_bytes(const struct cml_mesh_surface *surface)
{
    const struct cml_mesh *mesh = &surface->mesh;
    return (double)surface->embree_bytes + (double)mesh->num_triangles * sizeof *mesh->triangle +
           (double)mesh->num_vertices * (sizeof *mesh->vertex + sizeof *mesh->vertex_normal);
}

const char *cml_mesh_surface_backend(void)
{
    return "Embree " RTC_VERSION_STRING;
}
