/* An independent program for a probe in contact: flat layers whose top is touched by opaque faces and by
 * ports of other indices. It flies packets one by one in double precision and shares nothing with kernels
 * or src.
 *
 * Standard input holds only numbers, in the order of the reading functions; tests/stat/face_oracle.py writes
 * them. SPDX-License-Identifier: MIT */
#include "rough_oracle.h"

#include <stdio.h>
#include <stdlib.h>

#define MOST 16       /* limit of layers, lines on top, beams, detectors */
#define MOST_BINS 256 /* limit of bins of a list, and of voxels */
#define MOST_EVENTS 100000
#define LIGHT_SPEED 0.0299792458 /* cm/ps */

enum { LAMBERTIAN = METAL + 1, PORT };          /* laws of a line on top, behind MIRROR and METAL */
enum { WHOLE, DISK, RING, RECTANGLE };          /* shapes; a disk of radius 0 is a pencil */
enum { PARALLEL, ISOTROPIC, COSINE, APERTURE }; /* directions of a beam's light */
/* totals; behind KEPT stand layers, then detectors, then voxels */
enum { RSP, RD, TT, FACE, BACKING, TRAPPED, KEPT };
enum { SEEN = KEPT + MOST, VOXELS = SEEN + MOST, SUMS = VOXELS + MOST_BINS };
enum { RD_R, RD_A, RD_T, RSP_DIR, RD_DIR, RD_XY, LISTS };

struct shape {
    int kind;
    double size[2], x, y;
};
struct line { /* a face or a port */
    struct shape shape;
    int law;
    struct backing face;
    double n;
};
struct layer {
    double n, mua, mus, g, bottom;
};
struct beam {
    int port; /* number of the line, or -1 */
    struct shape shape;
    int inside, light;
    double z, angle, azimuth, aperture, share;
};
struct detector {
    int port; /* number of the line, or -1 */
    struct shape shape;
    double z, aperture, angle, azimuth; /* aperture 0: all directions */
    int diffuse;
};
struct packet {
    struct vec p, v;
    double w, clock;
    int layer;
};

static struct {
    int layers, lines, beams, detectors, nr, na, nt, dir_t, dir_p, nx, ny, nz;
    double packets, above, below, dr, dt, dx, dy, dz, top; /* top: of the voxels, above boundary 0 */
    int backing_law;
    struct backing backing;
    struct layer layer[MOST + 1]; /* from 1 */
    struct line line[MOST];
    struct beam beam[MOST];
    struct detector detector[MOST];
} scene;
static struct {
    double now[SUMS], sum[SUMS], square[SUMS];
    double bin[LISTS][MOST_BINS], bin_square[LISTS][MOST_BINS];
} tally;

static bool holds(const struct shape *s, double x, double y)
{
    x -= s->x;
    y -= s->y;
    const double r = hypot(x, y);
    if (s->kind == DISK) return r <= s->size[0];
    if (s->kind == RING) return s->size[0] <= r && r < s->size[1];
    if (s->kind == RECTANGLE) return 2 * fabs(x) <= s->size[0] && 2 * fabs(y) <= s->size[1];
    return true;
}

/* Returns the number of the line that counts at a place, -1 on the open plane. */
static int line_at(struct vec p)
{
    for (int k = scene.lines - 1; k >= 0; k--)
        if (holds(&scene.line[k].shape, p.x, p.y)) return k;
    return -1;
}

/* Returns the index above a place; a face, 0. */
static double index_above(int line)
{
    return line < 0 ? scene.above : scene.line[line].law == PORT ? scene.line[line].n : 0;
}

static struct vec axis_of(double angle, double azimuth, double sign)
{
    const double a = angle * PI / 180, p = azimuth * PI / 180;
    return (struct vec){sin(a) * cos(p), sin(a) * sin(p), sign * cos(a)};
}

/* ---- light that has left ---- */

static void bin(int list, int i, int most, double w)
{
    if (i >= most) i = most - 1;
    tally.bin[list][i] += w;
    tally.bin_square[list][i] += w * w;
}

/* Returns the pixel of a place, -1 beyond the map. */
static int pixel_at(struct vec p)
{
    const double x = floor(p.x / scene.dx + scene.nx / 2.0), y = floor(p.y / scene.dy + scene.ny / 2.0);
    return x >= 0 && x < scene.nx && y >= 0 && y < scene.ny ? (int)y * scene.nx + (int)x : -1;
}

/* Scores the fluence of a straight flight in the voxel of a random place on it. */
static void pass_along(struct vec p, struct vec v, double length, double w)
{
    if (scene.nz == 0) return;
    const struct vec q = along(p, draw() * length, v);
    const double z = floor((q.z - scene.top) / scene.dz);
    const int pixel = pixel_at(q);
    if (pixel >= 0 && z >= 0 && z < scene.nz)
        tally.now[VOXELS + (int)z * scene.nx * scene.ny + pixel] += w * fabs(length);
}

static bool detected(const struct detector *d, struct vec p, struct vec v, int line, int what)
{
    if (d->diffuse && what == RSP) return false;
    if (d->port >= 0 && d->port != line) return false;
    if (d->port < 0) {
        const struct vec q = along(p, (d->z - p.z) / v.z, v);
        if (!holds(&d->shape, q.x, q.y)) return false;
    }
    if (d->aperture == 0) return true;
    const double cosine = dot(v, axis_of(d->angle, d->azimuth, -1)), n = index_above(line);
    return cosine >= 0 && (d->aperture >= n || sqrt(fmax(0, 1 - cosine * cosine)) <= d->aperture / n);
}

static void leave_upward(int what, const struct packet *packet, int line)
{
    const struct vec p = packet->p, v = packet->v;
    const double w = packet->w, angle = acos(fmin(1, -v.z)) / (PI / 2);
    const double azimuth = v.x == 0 && v.y == 0 ? 0 : atan2(v.y, v.x) / (2 * PI);
    const int t = (int)fmin(scene.dir_t - 1, angle * scene.dir_t);
    const int a = (int)fmin(scene.dir_p - 1, (azimuth < 0 ? azimuth + 1 : azimuth) * scene.dir_p);
    tally.now[what] += w;
    pass_along(p, v, scene.top / v.z, w);
    bin(what == RSP ? RSP_DIR : RD_DIR, t * scene.dir_p + a, MOST_BINS, w);
    if (what == RD) {
        if (pixel_at(p) >= 0) bin(RD_XY, pixel_at(p), MOST_BINS, w);
        bin(RD_R, (int)fmin(1e6, hypot(p.x, p.y) / scene.dr), scene.nr, w);
        bin(RD_A, (int)(angle * scene.na), scene.na, w);
        bin(RD_T, (int)fmin(1e6, packet->clock / scene.dt), scene.nt + 1, w);
    }
    for (int k = 0; k < scene.detectors; k++)
        if (detected(&scene.detector[k], p, v, line, what)) tally.now[SEEN + k] += w;
}

/* ---- surfaces ---- */

/* Turns a packet back at an opaque surface. up: the packet comes from below and goes on downward. */
static void turn_back(struct packet *packet, int law, const struct backing *face, double n, bool up, int book)
{
    const double kept = law == METAL ? kept_back(face, fabs(packet->v.z), n) : face->reflectance;
    tally.now[book] += packet->w * (1 - kept);
    packet->w *= kept;
    if (law == LAMBERTIAN)
        packet->v = about((struct vec){0, 0, up ? 1 : -1}, sqrt(draw()), 2 * PI * draw());
    else
        packet->v.z = -packet->v.z;
}

/* Lets light reflect, or pass to the index n2. Returns true if the light has passed. */
static bool passes(struct vec *v, double n1, double n2)
{
    double ct = 0;
    if (n1 == n2) return true;
    if (draw() <= fresnel(fabs(v->z), n1, n2, &ct)) {
        v->z = -v->z;
        return false;
    }
    *v = unit((struct vec){v->x * n1 / n2, v->y * n1 / n2, copysign(ct, v->z)});
    return true;
}

/* Lets a packet meet the boundary over (up) or under its layer. Returns false if the packet has left. */
static bool meet(struct packet *packet, bool up)
{
    const double n = scene.layer[packet->layer].n;
    const int beyond = packet->layer + (up ? -1 : 1);
    if (beyond == 0) {
        const int k = line_at(packet->p);
        if (k >= 0 && scene.line[k].law != PORT) {
            turn_back(packet, scene.line[k].law, &scene.line[k].face, n, true, FACE);
            return true;
        }
        if (!passes(&packet->v, n, index_above(k))) return true;
        leave_upward(RD, packet, k);
        return false;
    }
    if (beyond > scene.layers) {
        if (scene.backing_law) {
            turn_back(packet, scene.backing_law, &scene.backing, n, false, BACKING);
            return true;
        }
        if (!passes(&packet->v, n, scene.below)) return true;
        tally.now[TT] += packet->w;
        return false;
    }
    if (passes(&packet->v, n, scene.layer[beyond].n)) packet->layer = beyond;
    return true;
}

/* ---- launch ---- */

static struct vec place_in(const struct shape *s)
{
    const double a = 2 * PI * draw(), xi = draw();
    if (s->kind == RECTANGLE)
        return (struct vec){s->x + (xi - 0.5) * s->size[0], s->y + (draw() - 0.5) * s->size[1], 0};
    const double in = s->kind == RING ? s->size[0] : 0, out = s->kind == RING ? s->size[1] : s->size[0];
    const double r = sqrt(in * in + xi * (out * out - in * in));
    return (struct vec){s->x + r * cos(a), s->y + r * sin(a), 0};
}

static struct vec direction_of(const struct beam *b, double n)
{
    const struct vec axis = axis_of(b->angle, b->azimuth, 1);
    const double widest = b->aperture < n ? 1 - sqrt(1 - b->aperture * b->aperture / (n * n)) : 1;
    if (b->light == ISOTROPIC) return about(axis, 2 * draw() - 1, 2 * PI * draw());
    if (b->light == COSINE) return about(axis, sqrt(draw()), 2 * PI * draw());
    if (b->light == APERTURE) return about(axis, 1 - draw() * widest, 2 * PI * draw());
    return b->angle == 0 ? (struct vec){0, 0, 1} : axis;
}

/* Returns a place of the shape, which lies across the axis about (x, y, z). */
static struct vec place_across(const struct beam *b, double z)
{
    const struct vec across = axis_of(b->angle + 90, b->azimuth, 1), side = axis_of(90, b->azimuth + 90, 1);
    const struct vec p = place_in(&b->shape), middle = {b->shape.x, b->shape.y, z};
    return along(along(middle, p.x - middle.x, across), p.y - middle.y, side);
}

/* Splits the specular part off a packet that comes straight down from the index n. */
static void split_off(struct packet *packet, double n, int line)
{
    const struct layer *layer = scene.layer;
    double ct = 0, r = n == layer[1].n ? 0 : fresnel(1, n, layer[1].n, &ct);
    if (layer[1].mua + layer[1].mus == 0 && scene.layers > 1) {
        const double r2 = layer[1].n == layer[2].n ? 0 : fresnel(1, layer[1].n, layer[2].n, &ct);
        r += (1 - r) * (1 - r) * r2 / (1 - r * r2);
        packet->layer = 2;
        packet->clock = layer[1].bottom * layer[1].n / LIGHT_SPEED;
    }
    const struct packet back = {.p = packet->p, .v = {0, 0, -1}, .w = r};
    if (r > 0) leave_upward(RSP, &back, line);
    packet->w -= r;
    packet->p.z = scene.layer[packet->layer - 1].bottom;
}

/* Starts a packet of a beam. Returns false if the packet does not enter the layers. */
static bool launch(const struct beam *b, struct packet *packet)
{
    *packet = (struct packet){.w = 1, .layer = 1};
    if (b->inside) {
        packet->p = place_across(b, b->z);
        while (scene.layer[packet->layer].bottom < packet->p.z) packet->layer++;
        packet->v = direction_of(b, scene.layer[packet->layer].n);
        return true;
    }
    packet->v = direction_of(b, b->port >= 0 ? scene.line[b->port].n : scene.above);
    if (b->port >= 0) {
        packet->p = place_in(&scene.line[b->port].shape);
    } else {
        const struct vec start = place_across(b, 0);
        packet->p = along(start, -start.z / packet->v.z, packet->v);
    }
    pass_along(packet->p, packet->v, scene.top / packet->v.z, 1); /* backwards, along the way here */
    const int k = b->port >= 0 ? b->port : line_at(packet->p);
    const double n = index_above(k);
    if (b->port < 0 && n != scene.above) {
        tally.now[FACE] += 1;
        return false;
    }
    if (b->light == PARALLEL && b->angle == 0) {
        split_off(packet, n, k);
        return true;
    }
    if (passes(&packet->v, n, scene.layer[1].n)) return true;
    leave_upward(RSP, packet, k);
    return false;
}

/* ---- flight ---- */

static void scatter(struct packet *packet, const struct layer *layer)
{
    const double lost = packet->w * layer->mua / (layer->mua + layer->mus), g = layer->g;
    tally.now[KEPT + packet->layer - 1] += lost;
    packet->w -= lost;
    if (packet->w < 1e-3) packet->w = draw() < 0.1 ? packet->w / 0.1 : 0;
    const double s = g == 0 ? 0 : (1 - g * g) / (1 - g + 2 * g * draw());
    const double cosine = g == 0 ? 2 * draw() - 1 : (1 + g * g - s * s) / (2 * g);
    packet->v = about(packet->v, fmax(-1, fmin(1, cosine)), 2 * PI * draw());
}

static void fly(struct packet *packet)
{
    double depth = -log(draw());
    for (long events = 0; packet->w > 0; events++) {
        const struct layer *layer = &scene.layer[packet->layer];
        const double mut = layer->mua + layer->mus, way = mut > 0 ? depth / mut : INFINITY;
        const bool up = packet->v.z < 0;
        const double z = up ? layer[-1].bottom : layer->bottom;
        const double reach = packet->v.z == 0 ? INFINITY : fmax(0, (z - packet->p.z) / packet->v.z);
        const double step = fmin(way, reach);
        if (events > MOST_EVENTS || step == INFINITY) {
            tally.now[TRAPPED] += packet->w;
            return;
        }
        pass_along(packet->p, packet->v, step, packet->w);
        packet->p = along(packet->p, step, packet->v);
        packet->clock += step * layer->n / LIGHT_SPEED;
        depth -= step * mut;
        if (way < reach) {
            scatter(packet, layer);
            depth = -log(draw());
            continue;
        }
        packet->p.z = z;
        if (!meet(packet, up)) return;
    }
}

static void fly_packet(double share) /* share: place of the packet among the shares of the beams, below 1 */
{
    struct packet packet;
    int k = 0;
    while (k < scene.beams - 1 && share >= scene.beam[k].share) share -= scene.beam[k++].share;
    if (launch(&scene.beam[k], &packet)) fly(&packet);
    for (int i = 0; i < SUMS; i++) {
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

static int count(int least, int most)
{
    const double value = number();
    if (!(value >= least && value <= most)) exit(2);
    return (int)value;
}

static struct shape read_shape(void)
{
    struct shape s = {.kind = count(WHOLE, RECTANGLE)};
    for (int i = 0; i < 2; i++) s.size[i] = number();
    s.x = number();
    s.y = number();
    return s;
}

static int read_surface(struct backing *surface) /* Returns the law. */
{
    const int law = count(0, PORT);
    const double value = number(), k = number();
    *surface = (struct backing){law == METAL ? METAL : MIRROR, value, value + k * I};
    return law;
}

static struct beam read_beam(void)
{
    struct beam b = {.port = count(-1, MOST), .shape = read_shape(), .inside = count(0, 1)};
    b.z = number();
    b.angle = number();
    b.azimuth = number();
    b.light = count(PARALLEL, APERTURE);
    b.aperture = number();
    b.share = number();
    return b;
}

static struct detector read_detector(void)
{
    struct detector d = {.port = count(-1, MOST), .shape = read_shape(), .z = number()};
    d.aperture = number();
    d.angle = number();
    d.azimuth = number();
    d.diffuse = count(0, 1);
    return d;
}

static void read_scene(void)
{
    seed((uint64_t)number());
    scene.packets = number();
    scene.nr = count(1, MOST_BINS);
    scene.dr = number();
    scene.na = count(1, MOST_BINS);
    scene.nt = count(1, MOST_BINS - 1);
    scene.dt = number();
    scene.dir_t = count(1, 16);
    scene.dir_p = count(1, 16);
    scene.nx = count(0, 6);
    scene.ny = count(0, 6);
    scene.nz = count(0, 6);
    scene.dx = number();
    scene.dy = number();
    scene.dz = number();
    scene.top = number();
    scene.layers = count(1, MOST);
    scene.above = number();
    for (int i = 1; i <= scene.layers; i++) {
        struct layer *layer = &scene.layer[i];
        layer->n = number();
        layer->mua = number();
        layer->mus = number();
        layer->g = number();
        layer->bottom = layer[-1].bottom + number();
    }
    scene.backing_law = read_surface(&scene.backing);
    scene.below = number();
    scene.lines = count(0, MOST);
    for (int i = 0; i < scene.lines; i++) {
        scene.line[i].shape = read_shape();
        scene.line[i].law = read_surface(&scene.line[i].face);
        scene.line[i].n = scene.line[i].face.reflectance;
    }
    scene.beams = count(1, MOST);
    for (int i = 0; i < scene.beams; i++) scene.beam[i] = read_beam();
    scene.detectors = count(0, MOST);
    for (int i = 0; i < scene.detectors; i++) scene.detector[i] = read_detector();
}

static void print(double sum, double square)
{
    const double N = scene.packets, mean = sum / N;
    printf("%.17g %.17g\n", mean, sqrt(fmax(0, square / N - mean * mean) / N));
}

int main(void)
{
    read_scene();
    double shares = 0;
    for (int i = 0; i < scene.beams; i++) shares += scene.beam[i].share;
    for (int i = 0; i < scene.beams; i++) scene.beam[i].share /= shares;
    for (double i = 0; i < scene.packets; i++) fly_packet((i + 0.5) / scene.packets);
    for (int i = 0; i < KEPT + scene.layers; i++) print(tally.sum[i], tally.square[i]);
    for (int i = 0; i < scene.detectors; i++) print(tally.sum[SEEN + i], tally.square[SEEN + i]);
    const int size[LISTS] = {
        scene.nr,           scene.na, scene.nt + 1, scene.dir_t * scene.dir_p, scene.dir_t * scene.dir_p,
        scene.nx * scene.ny};
    for (int k = 0; k < LISTS; k++)
        for (int i = 0; i < size[k]; i++) print(tally.bin[k][i], tally.bin_square[k][i]);
    for (int i = 0; i < scene.nx * scene.ny * scene.nz; i++)
        print(tally.sum[VOXELS + i], tally.square[VOXELS + i]);
    return 0;
}
