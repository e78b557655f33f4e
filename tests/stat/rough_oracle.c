/* An independent program for rough boundaries: it flies packets one by one in double precision and tests
 * every shape by brute force. It shares nothing with kernels or src.
 *
 * Standard input holds only numbers, in the order of the reading functions; tests/stat/rough_oracle.py
 * writes them. SPDX-License-Identifier: MIT */
#include "rough_oracle.h"

#include <stdio.h>
#include <stdlib.h>

#define MOST 16        /* limit of media, boundaries, bodies */
#define MOST_FACETS 64 /* limit of a boundary */
#define MOST_BINS 4096 /* limit of directions, of each side */
#define MOST_EVENTS 1000000

enum { PARALLEL, ISOTROPIC, LAMBERTIAN };
enum { RSP, RD, TT, BACKING, TRAPPED, LOST, ABSORBED, TOTALS = ABSORBED + MOST };

struct medium {
    double n, mua, mus, g;
};
struct boundary {
    double z, reach; /* triangles cover |x|, |y| < reach, or a cone r < reach; beyond lies the plane at z */
    double peak;     /* height of the cone above z */
    struct face face;
    int facets, shaded;
    /* normals point up */
    struct vec corner[MOST_FACETS][3], corner_normal[MOST_FACETS][3], normal[MOST_FACETS];
};
struct body {
    struct vec middle;
    double r;
    int around; /* medium around the body */
    struct face face;
};
struct hit {
    double t;
    struct vec normal, facet; /* both point against the packet */
    int beyond, body;         /* medium behind the surface, and number of the body or -1 */
    struct face face;
    bool last; /* the boundary above the medium below */
};

static struct {
    int layers, bodies, light, starts_inside, nt, np;
    double packets, x, y, z, angle, azimuth, radius;
    struct backing backing;
    struct medium medium[2 * MOST];
    struct boundary boundary[MOST];
    struct body body[MOST];
} scene;
static struct {
    double now[TOTALS], sum[TOTALS], square[TOTALS], bin[3][MOST_BINS], bin_square[3][MOST_BINS];
} tally;

/* ---- geometry ---- */

static void meet(struct hit *hit, double t, struct vec normal, int beyond, int body, struct face face)
{
    if (t < hit->t) *hit = (struct hit){t, normal, normal, beyond, body, face, beyond == scene.layers + 1};
}

/* Returns the normal at q, interpolated between the corners' normals by the areas opposite to them. */
static struct vec shaded(const struct boundary *s, int f, struct vec q)
{
    struct vec sum = {0, 0, 0};
    for (int k = 0; k < 3; k++) {
        const struct vec a = s->corner[f][(k + 1) % 3], b = s->corner[f][(k + 2) % 3];
        sum = along(sum, dot(cross(along(b, -1, a), along(q, -1, a)), s->normal[f]), s->corner_normal[f][k]);
    }
    return unit(sum);
}

static void meet_facet(const struct boundary *s, int f, double side, int beyond, struct vec p, struct vec v,
                       struct hit *hit)
{
    const struct vec *a = s->corner[f], n = s->normal[f];
    if (side * dot(v, n) >= 0) return;
    const double t = dot(along(a[0], -1, p), n) / dot(v, n);
    const struct vec q = along(p, t, v);
    bool inside = t >= 0 && t < hit->t;
    for (int k = 0; inside && k < 3; k++)
        inside = dot(cross(along(a[(k + 1) % 3], -1, a[k]), along(q, -1, a[k])), n) >= 0;
    if (!inside) return;
    meet(hit, t, scaled(n, side), beyond, -1, s->face);
    if (s->shaded) hit->normal = scaled(shaded(s, f, q), side);
}

/* Finds the crossing with the cone r = reach (1 + (z - boundary's z) / peak). */
static void meet_cone(const struct boundary *s, double side, int beyond, struct vec p, struct vec v,
                      struct hit *hit)
{
    const double k = s->reach / s->peak, R = s->reach + k * (p.z - s->z);
    const double a = v.x * v.x + v.y * v.y - k * k * v.z * v.z, b = p.x * v.x + p.y * v.y - k * v.z * R;
    const double c = p.x * p.x + p.y * p.y - R * R, square = b * b - a * c;
    for (int sign = -1; sign <= 1 && square > 0; sign += 2) {
        const double t = (-b + sign * sqrt(square)) / a;
        const struct vec q = along(p, t, v);
        const double r = hypot(q.x, q.y);
        const struct vec up = unit((struct vec){q.x / (k * r), q.y / (k * r), -1});
        if (t >= 0 && r < s->reach && R + k * t * v.z > 0 && side * dot(v, up) < 0)
            meet(hit, t, scaled(up, side), beyond, -1, s->face);
    }
}

/* Finds the crossing with boundary b from the medium above it (`down`) or below it. */
static void meet_boundary(int b, bool down, struct vec p, struct vec v, struct hit *hit)
{
    const struct boundary *s = &scene.boundary[b];
    const int beyond = down ? b + 1 : b;
    const double side = down ? 1 : -1;
    for (int f = 0; f < s->facets; f++) meet_facet(s, f, side, beyond, p, v, hit);
    if (s->peak != 0) meet_cone(s, side, beyond, p, v, hit);
    if (side * v.z <= 0) return;
    const double t = fmax(0, (s->z - p.z) / v.z);
    const struct vec q = along(p, t, v);
    if (s->peak != 0 ? hypot(q.x, q.y) >= s->reach : fabs(q.x) >= s->reach || fabs(q.y) >= s->reach)
        meet(hit, t, (struct vec){0, 0, -side}, beyond, -1, s->face);
}

static void meet_body(int k, bool inside, bool stands, struct vec p, struct vec v, struct hit *hit)
{
    const struct body *s = &scene.body[k];
    const struct vec from = along(p, -1, s->middle);
    const double b = dot(from, v), c = stands ? 0 : dot(from, from) - s->r * s->r, root = b * b - c;
    if (!inside && (stands || b >= 0 || root < 0)) return;
    const double t = inside ? sqrt(fmax(0, root)) - b : -b - sqrt(root);
    const struct vec out = unit(along(from, t, v));
    meet(hit, t, scaled(out, inside ? -1 : 1), inside ? s->around : scene.layers + 2 + k, k, s->face);
}

static struct hit nearest(int medium, int stands_on, struct vec p, struct vec v)
{
    struct hit hit = {.t = INFINITY, .body = -1};
    if (medium <= scene.layers) meet_boundary(medium, true, p, v, &hit);
    if (medium >= 1 && medium <= scene.layers + 1) meet_boundary(medium - 1, false, p, v, &hit);
    for (int k = 0; k < scene.bodies; k++) {
        const bool inside = medium == scene.layers + 2 + k;
        if (inside || scene.body[k].around == medium) meet_body(k, inside, stands_on == k, p, v, &hit);
    }
    return hit;
}

static int medium_at(struct vec p)
{
    int medium = 0;
    while (medium <= scene.layers && p.z > scene.boundary[medium].z) medium++;
    for (int again = 0; again < scene.bodies; again++)
        for (int k = 0; k < scene.bodies; k++) {
            const struct vec from = along(p, -1, scene.body[k].middle);
            if (scene.body[k].around == medium && dot(from, from) < scene.body[k].r * scene.body[k].r)
                medium = scene.layers + 2 + k;
        }
    return medium;
}

/* ---- a packet ---- */

static void book(int what, double w)
{
    tally.now[what] += w;
}

static void book_direction(int what, struct vec v, double w)
{
    const double cosine = what == TT ? v.z : -v.z, azimuth = atan2(v.y, v.x);
    const int t = (int)fmin(scene.nt - 1, acos(fmin(1, cosine)) / (PI / 2) * scene.nt);
    const int p = (int)fmin(scene.np - 1, (azimuth < 0 ? azimuth + 2 * PI : azimuth) / (2 * PI) * scene.np);
    const int bin = t * scene.np + (v.x == 0 && v.y == 0 ? 0 : p);
    tally.bin[what][bin] += w;
    tally.bin_square[what][bin] += w * w;
    book(what, w);
}

static struct vec deflected(struct vec v, double g)
{
    const double s = g == 0 ? 0 : (1 - g * g) / (1 - g + 2 * g * draw());
    const double cosine = g == 0 ? 2 * draw() - 1 : (1 + g * g - s * s) / (2 * g);
    return about(v, fmax(-1, fmin(1, cosine)), 2 * PI * draw());
}

/* Draws a packet's start, on a disk across the axis, and its direction *v. */
static struct vec start(struct vec *v)
{
    const double A = scene.angle * PI / 180, P = scene.azimuth * PI / 180, r = scene.radius * sqrt(draw()),
                 a = 2 * PI * draw();
    const struct vec axis = {sin(A) * cos(P), sin(A) * sin(P), cos(A)},
                     own_x = {cos(A) * cos(P), cos(A) * sin(P), -sin(A)};
    const struct vec own_y = {-sin(P), cos(P), 0},
                     middle = {scene.x, scene.y, scene.starts_inside ? scene.z : 0};
    const struct vec p = along(along(middle, r * cos(a), own_x), r * sin(a), own_y);
    *v = axis;
    if (A == 0) *v = (struct vec){0, 0, 1};
    if (A == PI) *v = (struct vec){0, 0, -1};
    if (scene.light == ISOTROPIC) *v = about(axis, 2 * draw() - 1, 2 * PI * draw());
    if (scene.light == LAMBERTIAN) *v = about(axis, sqrt(draw()), 2 * PI * draw());
    return scene.starts_inside ? p : along(p, -(p.z + 10) / v->z, *v);
}

/* Returns the share that a smooth plane splits off light that comes straight down. *medium: where the rest
 * goes on. */
static double split_off(int *medium)
{
    const struct boundary *s = scene.boundary;
    const struct medium *m = scene.medium;
    if (scene.light != PARALLEL || scene.starts_inside || scene.angle != 0 || s[0].facets || s[0].peak != 0 ||
        s[0].face.kind)
        return 0;
    double ct, r = m[0].n == m[1].n ? 0 : fresnel(1, m[0].n, m[1].n, &ct);
    *medium = 1;
    if (m[1].mua + m[1].mus > 0 || scene.layers < 2 || s[1].face.kind) return r;
    const double r2 = m[1].n == m[2].n ? 0 : fresnel(1, m[1].n, m[2].n, &ct);
    *medium = 2;
    return r + (1 - r) * (1 - r) * r2 / (1 - r * r2);
}

/* Reflects or refracts light at a surface about `normal`; *v is the new direction. *kept: share that a
 * backing sends back. Returns true if the light passes. */
static bool turn(const struct hit *hit, struct vec normal, double n1, double n2,
                 const struct backing *backing, struct vec *v, double *kept)
{
    struct vec x, y;
    frame(normal, &x, &y);
    struct vec local = {dot(*v, x), dot(*v, y), dot(*v, normal)};
    double ct = 0;
    bool passes = false;
    *kept = 1;
    if (hit->face.kind) {
        passes = walk(hit->face, n1, n2, backing, &local, kept);
        if (passes) local.z = -local.z;
    } else if (backing || draw() <= fresnel(-local.z, n1, n2, &ct)) {
        if (backing) *kept = kept_back(backing, -local.z, n1);
        local.z = -local.z;
    } else {
        passes = true;
        local = (struct vec){local.x * n1 / n2, local.y * n1 / n2, -ct};
    }
    *v = unit(along(along(scaled(x, local.x), local.y, y), local.z, normal));
    return passes;
}

/* Lets light meet a surface, which gives it a new direction, weight and medium. If the shaded normal
 * contradicts the facet, the facet decides. Returns false if the walk on facets had no end. */
static bool cross_surface(const struct hit *hit, int *medium, struct vec *v, double *w)
{
    const double n1 = scene.medium[*medium].n, n2 = scene.medium[hit->beyond].n;
    const bool backed = scene.backing.kind && hit->last && *medium == scene.layers;
    const struct backing *backing = backed ? &scene.backing : NULL;
    if (!backed && n1 == n2) {
        *medium = hit->beyond;
        return true;
    }
    const struct vec from = *v;
    uint64_t before[4];
    for (int i = 0; i < 4; i++) before[i] = state[i];
    double kept;
    bool passes = dot(*v, hit->normal) < 0 && turn(hit, hit->normal, n1, n2, backing, v, &kept);
    if (dot(from, hit->normal) >= 0 || (dot(*v, hit->facet) > 0) == passes) {
        *v = from;
        for (int i = 0; i < 4; i++) state[i] = before[i];
        passes = turn(hit, hit->facet, n1, n2, backing, v, &kept);
    }
    if (kept < 0) return false;
    book(BACKING, *w * (1 - kept));
    *w *= kept;
    if (passes) *medium = hit->beyond;
    return true;
}

/* Flies a packet until a free path ends. Returns false if the packet has left or is lost. */
static bool fly(struct vec *p, struct vec *v, double *w, int *medium, int *stands_on, bool *entered)
{
    double depth = -log(draw());
    for (int events = 0; events < MOST_EVENTS; events++) {
        const struct medium *m = &scene.medium[*medium];
        const struct hit hit = nearest(*medium, *stands_on, *p, *v);
        const double way = m->mua + m->mus > 0 ? depth / (m->mua + m->mus) : INFINITY;
        *entered = *entered || (*medium != 0 && *medium != scene.layers + 1);
        if (way < hit.t) {
            *p = along(*p, way, *v);
            *stands_on = -1;
            return true;
        }
        if (hit.t == INFINITY) {
            if (*medium == 0 && v->z < 0)
                book_direction(*entered ? RD : RSP, *v, *w);
            else if (*medium == scene.layers + 1 && v->z > 0)
                book_direction(TT, *v, *w);
            else
                book(LOST, *w);
            return false;
        }
        depth -= hit.t * (m->mua + m->mus);
        *p = along(*p, hit.t, *v);
        *stands_on = hit.body;
        if (!cross_surface(&hit, medium, v, w)) {
            book(LOST, *w);
            return false;
        }
    }
    book(TRAPPED, *w);
    return false;
}

static void packet(void)
{
    struct vec v, p = start(&v);
    int medium = medium_at(p), stands_on = -1;
    const bool below = medium == scene.layers + 1;
    bool entered = below || (medium > 0);
    const double off = split_off(&medium);
    double w = 1 - off;
    if (off > 0) book_direction(RSP, (struct vec){0, 0, -1}, off);
    if (!entered && medium > 0) p.z = scene.boundary[medium - 1].z;
    while (w > 0 && fly(&p, &v, &w, &medium, &stands_on, &entered)) {
        const struct medium *m = &scene.medium[medium];
        const double lost = w * m->mua / (m->mua + m->mus);
        book(ABSORBED + medium, lost);
        w -= lost;
        if (w < 1e-3) w = draw() < 0.1 ? w / 0.1 : 0;
        v = deflected(v, m->g);
    }
    for (int i = 0; i < TOTALS; i++) {
        tally.sum[i] += tally.now[i];
        tally.square[i] += tally.now[i] * tally.now[i];
        tally.now[i] = 0;
    }
}

/* ---- numbers in, numbers out ---- */

static double number(void)
{
    double value;
    if (scanf("%lf", &value) != 1) exit(2);
    return value;
}

static int count(int most)
{
    const double value = number();
    if (!(value >= 0 && value <= most)) exit(2);
    return (int)value;
}

static struct vec vector(void)
{
    const double x = number(), y = number();
    return (struct vec){x, y, number()};
}

static struct face read_face(void)
{
    const int kind = count(BECKMANN);
    return (struct face){kind, number()};
}

static struct medium read_medium(void)
{
    const double n = number(), mua = number(), mus = number();
    return (struct medium){n, mua, mus, number()};
}

static void read_boundary(struct boundary *boundary)
{
    boundary->z = number();
    boundary->face = read_face();
    boundary->reach = number();
    boundary->peak = number();
    boundary->shaded = count(1);
    boundary->facets = count(MOST_FACETS);
    for (int f = 0; f < boundary->facets; f++) {
        struct vec *a = boundary->corner[f];
        struct vec *normal = boundary->corner_normal[f];
        for (int k = 0; k < 3; k++) a[k] = vector();
        for (int k = 0; k < 3 && boundary->shaded; k++) normal[k] = vector();
        const struct vec n = unit(cross(along(a[1], -1, a[0]), along(a[2], -1, a[0])));
        boundary->normal[f] = n;
        if (n.z < 0) continue; /* the facet points up already */
        boundary->normal[f] = scaled(n, -1);
        const struct vec corner = a[1], corner_normal = normal[1];
        a[1] = a[2], normal[1] = normal[2];
        a[2] = corner, normal[2] = corner_normal;
    }
}

static void read_scene(void)
{
    seed((uint64_t)number());
    scene.packets = number();
    scene.nt = count(90);
    scene.np = count(MOST_BINS / 90);
    scene.light = count(LAMBERTIAN);
    scene.starts_inside = count(1);
    scene.x = number(), scene.y = number(), scene.z = number();
    scene.angle = number(), scene.azimuth = number(), scene.radius = number();
    scene.backing.kind = count(METAL);
    scene.backing.reflectance = number();
    scene.backing.metal = number();
    scene.backing.metal += I * number();
    scene.layers = count(MOST / 2 - 2);
    for (int m = 0; m < scene.layers + 2; m++) scene.medium[m] = read_medium();
    for (int b = 0; b <= scene.layers; b++) read_boundary(&scene.boundary[b]);
    scene.bodies = count(MOST / 2);
    for (int k = 0; k < scene.bodies; k++) {
        struct body *body = &scene.body[k];
        body->middle = vector();
        body->r = number();
        body->around = count(MOST);
        body->face = read_face();
        scene.medium[scene.layers + 2 + k] = read_medium();
    }
}

static void print(double sum, double square)
{
    const double mean = sum / scene.packets;
    printf("%.9g %.3g\n", mean, sqrt(fmax(0, square / scene.packets - mean * mean) / scene.packets));
}

int main(void)
{
    read_scene();
    for (double i = 0; i < scene.packets; i++) packet();
    for (int i = 0; i < ABSORBED + scene.layers + 2 + scene.bodies; i++) print(tally.sum[i], tally.square[i]);
    for (int what = RSP; what <= TT; what++)
        for (int bin = 0; bin < scene.nt * scene.np; bin++)
            print(tally.bin[what][bin], tally.bin_square[what][bin]);
    return 0;
}
