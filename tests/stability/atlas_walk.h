/* The functions of atlas.h for one precision. The file is compiled in float and in double, each for several
 * levels of the processor (ATLAS_LEVEL, see CMakeLists.txt), which give the same bits.
 *
 * A position counts as inside its medium if it lies on the right side of both boundaries, or if it is beyond
 * one of them by less than the rounding of its coordinates.
 * SPDX-License-Identifier: MIT */
#include "atlas.h"
#include "base/clock.h"
#include "engine/terminated_packets_inl.h"
#include "engine/world_parts.h"
#include "geometry/vec3.h"

#define PASTE_NAME(precision, level) atlas_fly_##precision##_##level
#define NAME(precision, level) PASTE_NAME(precision, level)

/* Distance by which a position may lie beyond a boundary, in units of the rounding of its largest
 * coordinate. */
#ifdef CML_DOUBLE
#define ROUNDINGS 1024
#else
#define ROUNDINGS 32
#endif
#define MAX_EVENTS 300    /* events of one packet, after which a new packet is aimed */
#define MAX_ATTEMPTS 1000 /* attempts to find a start that is clearly inside a medium */

struct walker {
    const struct atlas_flight *flight;
    struct atlas_count *count;
    const struct cml_world *world;
    struct cml_deposits deposits;
    struct dice dice;
    struct cml_packet packet;
    double scale;  /* thickness of the thickest layer [cm] */
    double extent; /* largest |z| of any boundary in its own frame [cm] */
    double before; /* largest size of the positions where this flight and the one before it began */
};

/* ---- where a packet is ---- */

static double size_of(struct cml_vec p)
{
    return fabs((double)p.x) + fabs((double)p.y) + fabs((double)p.z);
}

/* Returns the rounding of a position, which includes that of the positions that it was flown from. Near 0,
 * its own coordinates have little rounding. */
static double rounding(const struct walker *walker, struct cml_vec p)
{
    const struct cml_setup *setup = &walker->world->setup;
    const double size = fmax(size_of(p), walker->before) + fabs((double)setup->x0) + fabs((double)setup->y0);
    const int medium = walker->packet.medium, body = medium - walker->flight->surfaces->count - 1;
    const int layer = body < 0 ? medium : walker->flight->scene->bodies[body].layer;
    const double span = (double)walker->world->media[layer].span;
    return ROUNDINGS * (double)CML_EPSILON * (size + span + walker->extent);
}

/* Writes p, from the frame of `medium`, as seen from boundary b. b = -1: as seen from the bodies of the
 * medium. */
static void seen_from(const struct walker *walker, int medium, int b, struct cml_vec p, double q[3])
{
    const struct cml_setup *setup = &walker->world->setup;
    q[0] = (double)p.x + (double)setup->x0;
    q[1] = (double)p.y + (double)setup->y0;
    q[2] = (double)p.z - (b == medium ? (double)walker->world->media[medium].span : 0);
}

/* True if p lies between the boundaries of a layer. A body lies inside its own layer. */
static bool in_layer(const struct walker *walker, int medium, struct cml_vec p, bool clearly)
{
    if (medium > walker->flight->surfaces->count) return true;
    for (int b = medium > 0 ? medium - 1 : 0; b <= medium && b < walker->flight->surfaces->count; b++) {
        const struct oracle *oracle = &walker->flight->oracle[b];
        double q[3];
        seen_from(walker, medium, b, p, q);
        const bool right = oracle_below(oracle, q) == (b < medium);
        if (clearly ? !right || oracle_near(oracle, q, rounding(walker, p))
                    : !right && !oracle_near(oracle, q, rounding(walker, p)))
            return false;
    }
    return true;
}

/* True if p is in the medium, widened by rounding, or narrowed by rounding if `clearly`. */
static bool in_medium(const struct walker *walker, int medium, struct cml_vec p, bool clearly)
{
    double q[3];
    seen_from(walker, medium, -1, p, q);
    return in_layer(walker, medium, p, clearly) &&
           oracle_bodies_allow(walker->flight->bodies, medium, q, rounding(walker, p), clearly);
}

/* True if z alone shows that a point is in the medium, according to oracle_below for both boundaries. */
static bool is_in_clear(const struct walker *walker, int medium, real z)
{
    const bool *hosts = walker->flight->bodies->hosts;
    if (hosts && (medium > walker->flight->surfaces->count || hosts[medium])) return false;
    const struct oracle *oracle = walker->flight->oracle;
    const double below = (double)z - (double)walker->world->media[medium].span;
    return (medium == 0 || (double)z > oracle[medium - 1].lowest) &&
           (medium == walker->flight->surfaces->count || below < oracle[medium].highest);
}

static bool is_sound(const struct cml_packet *packet)
{
    return isfinite(packet->p.x) && isfinite(packet->p.y) && isfinite(packet->p.z) &&
           fabs((double)cml_dot(packet->u, packet->u) - 1) < 1e-5;
}

/* ---- aiming ---- */

static real moved_by_ulps(real x, int ulps)
{
    for (; ulps > 0; ulps--)
        x = (real)(sizeof(real) == sizeof(float) ? nextafterf((float)x, INFINITY)
                                                 : nextafter((double)x, INFINITY));
    for (; ulps < 0; ulps++)
        x = (real)(sizeof(real) == sizeof(float) ? nextafterf((float)x, -INFINITY)
                                                 : nextafter((double)x, -INFINITY));
    return x;
}

/* Returns the index of a random boundary or body. Bodies are counted after the boundaries. */
static int choose_boundary(struct walker *walker)
{
    const int boundaries = walker->flight->surfaces->count, bodies = walker->flight->surfaces->bodies.count;
    if (bodies > 0 && dice_below(&walker->dice, 8) > 0) return boundaries + dice_below(&walker->dice, bodies);
    return dice_below(&walker->dice, boundaries);
}

static double depth_of(const struct walker *walker, int boundary)
{
    const struct cml_surface_set *surfaces = walker->flight->surfaces;
    return boundary < surfaces->count ? surfaces->item[boundary].depth
                                      : surfaces->bodies.item[boundary - surfaces->count].depth;
}

/* Returns a random place on a boundary or body, of the kind that the aim asks for. On a plane, it lies
 * within the scene's own scale. */
static struct place choose_place(struct walker *walker, int boundary)
{
    static const enum place_kind kinds[NUM_AIMS] = {
        [AIM_FACE] = PLACE_FACE,   [AIM_EDGE] = PLACE_EDGE,  [AIM_VERTEX] = PLACE_VERTEX,
        [AIM_DROP] = PLACE_VERTEX, [AIM_ALONG] = PLACE_EDGE, [AIM_GRAZE] = PLACE_FACE};
    const enum place_kind kind = kinds[walker->flight->aim];
    const int body = boundary - walker->flight->surfaces->count;
    if (body >= 0) return oracle_body_place(walker->flight->bodies, body, kind, &walker->dice);
    struct place place = oracle_place(&walker->flight->oracle[boundary], kind, &walker->dice);
    if (walker->flight->surfaces->item[boundary].kind != CML_SURFACE_PLANE) return place;
    for (int axis = 0; axis < 2; axis++) place.point[axis] *= walker->scale;
    place.size = walker->scale;
    return place;
}

static void choose_direction(struct walker *walker, const struct place *place, double u[3])
{
    const double sign = dice_below(&walker->dice, 2) ? 1 : -1;
    dice_direction(&walker->dice, u);
    if (walker->flight->aim == AIM_DROP) {
        u[0] = u[1] = 0;
        u[2] = sign;
    } else if (walker->flight->aim == AIM_ALONG) {
        for (int axis = 0; axis < 3; axis++) u[axis] = sign * place->tangent[axis];
    } else if (walker->flight->aim == AIM_GRAZE) {
        double across[3];
        cml_vec3_cross(place->normal, place->tangent, across);
        const double phi = dice_between(&walker->dice, 0, 6.283185307179586);
        const double up = sign * sin(walker->flight->angle), flat = cos(walker->flight->angle);
        for (int axis = 0; axis < 3; axis++)
            u[axis] =
                flat * (cos(phi) * place->tangent[axis] + sin(phi) * across[axis]) + up * place->normal[axis];
    }
}

/* Returns the medium of a point of the scene. Boundaries lie in order. */
static int medium_at(const struct walker *walker, const double s[3])
{
    int medium = 0;
    while (medium < walker->flight->surfaces->count) {
        const double q[3] = {s[0], s[1], s[2] - walker->flight->surfaces->item[medium].depth};
        if (!oracle_below(&walker->flight->oracle[medium], q)) break;
        medium++;
    }
    if (medium == 0 || medium == walker->flight->surfaces->count) return medium;
    const double q[3] = {s[0], s[1], s[2] - walker->flight->surfaces->item[medium - 1].depth};
    return oracle_bodies_medium(walker->flight->bodies, medium, q);
}

/* Makes a new packet `distance` before the place. Its direction is computed from its rounded position, so
 * that it passes through the place as exactly as `real` allows. The packet is then moved by a few units in
 * the last place. */
static void aim(struct walker *walker, const struct place *place, int boundary, const double u[3],
                double distance)
{
    const struct cml_setup *setup = &walker->world->setup;
    struct cml_packet *packet = &walker->packet;
    const uint64_t index = packet->index + 1;
    double target[3], start[3], d[3];
    for (int axis = 0; axis < 3; axis++) {
        target[axis] = place->point[axis];
        if (axis == 2) target[2] += depth_of(walker, boundary);
        start[axis] = target[axis] - distance * u[axis];
    }
    *packet = (struct cml_packet){.index = index, .w = CML_WEIGHT_ONE, .on_boundary = -1, .on_primitive = -1};
    packet->medium = medium_at(walker, start);
    const double depth = (double)walker->world->media[packet->medium].depth;
    packet->p = cml_vec_of(start[0] - (double)setup->x0, start[1] - (double)setup->y0, start[2] - depth);
    d[0] = target[0] - (double)setup->x0 - (double)packet->p.x;
    d[1] = target[1] - (double)setup->y0 - (double)packet->p.y;
    d[2] = target[2] - depth - (double)packet->p.z;
    const double size = sqrt(cml_vec3_dot(d, d)), *way = walker->flight->aim == AIM_DROP ? u : d;
    const double unit = walker->flight->aim == AIM_DROP ? 1 : size;
    packet->u = cml_vec_of(way[0] / unit, way[1] / unit, way[2] / unit);
    if (walker->flight->aim != AIM_FACE) {
        packet->p.x = moved_by_ulps(packet->p.x, dice_below(&walker->dice, 5) - 2);
        packet->p.y = moved_by_ulps(packet->p.y, dice_below(&walker->dice, 5) - 2);
    }
    packet->entered = packet->medium > 0;
    packet->boundary_events = packet->medium > 0 || !(packet->u.z > 0);
}

/* Aims a new packet. Returns false if no start clearly inside a medium was found. */
static bool place_packet(struct walker *walker)
{
    walker->before = 0;
    for (int attempt = 0; attempt < MAX_ATTEMPTS; attempt++) {
        const int boundary = choose_boundary(walker);
        const struct place place = choose_place(walker, boundary);
        double u[3];
        choose_direction(walker, &place, u);
        const double distance = place.size * exp(dice_between(&walker->dice, log(1e-3), log(3)));
        aim(walker, &place, boundary, u, distance);
        if (is_sound(&walker->packet) && in_medium(walker, walker->packet.medium, walker->packet.p, true)) {
            cml_next_flight(walker->world, &walker->packet);
            return true;
        }
    }
    return false;
}

/* ---- flying ---- */

/* True if a flight to distance t stayed in its medium, at three points on the way. Their z lie between those
 * of the ends, with equal rounding. */
static bool stayed(const struct walker *walker, const struct cml_packet *from, real t)
{
    const int medium = from->medium;
    if (is_in_clear(walker, medium, from->p.z) &&
        is_in_clear(walker, medium, cml_along(from->p, t, from->u).z))
        return true;
    for (int quarter = 1; quarter < 4; quarter++) {
        const struct cml_vec p = cml_along(from->p, t * (real)quarter / 4, from->u);
        if (!in_medium(walker, medium, p, false)) return false;
    }
    return true;
}

static void cross(struct walker *walker, const struct cml_packet *from, const struct cml_hit *hit)
{
    const double q[3] = {(double)hit->point.x + (double)walker->world->setup.x0,
                         (double)hit->point.y + (double)walker->world->setup.y0, (double)hit->point.z};
    const double margin = rounding(walker, from->p) + rounding(walker, hit->point);
    const int body = hit->boundary - walker->flight->surfaces->count;
    walker->count->spurious += body < 0 ? !oracle_near(&walker->flight->oracle[hit->boundary], q, margin)
                                        : !oracle_body_near(walker->flight->bodies, body, q, margin);
    walker->count->crossings++;
    cml_score_boundary_event(walker->world, &walker->deposits, &walker->packet, hit);
}

/* Makes one flight as cml_walk does, and counts the oracle's complaints. */
static void step(struct walker *walker)
{
    struct cml_packet *packet = &walker->packet;
    const struct cml_packet from = *packet;
    const real t_max = cml_free_path(walker->world, packet);
    struct cml_hit hit;
    const struct cml_boundary_intervals intervals = cml_find_intervals(walker->world, packet, t_max);
    walker->count->steps++;
    walker->before = fmax(walker->before, size_of(from.p));
    bool there = true;
    real t = (real)(4 * walker->extent);
    if (cml_nearest_hit(walker->world, packet, intervals, &hit)) {
        t = hit.t;
        cross(walker, &from, &hit);
    } else if (t_max < CML_INFINITY) {
        t = t_max;
        cml_interact(walker->world, &walker->deposits, packet, t_max);
        there = in_medium(walker, packet->medium, packet->p, false);
    } else {
        cml_leave_scene(walker->world, &walker->deposits, packet);
    }
    if (!is_sound(packet)) {
        walker->count->nan++;
    } else if (there && stayed(walker, &from, t)) {
        walker->before = size_of(from.p);
        return;
    } else {
        *(there ? &walker->count->missed : &walker->count->wrong) += 1;
    }
    if (packet->fate == CML_FATE_ALIVE) packet->fate = CML_FATE_ABSORBED;
}

static void fly_one(struct walker *walker)
{
    for (int event = 0; event < MAX_EVENTS && walker->packet.fate == CML_FATE_ALIVE; event++) step(walker);
    walker->count->trapped += walker->packet.fate == CML_FATE_TRAPPED;
    if (walker->packet.fate != CML_FATE_LOST) return;
    walker->count->lost++;
    walker->count->lost_cause = walker->packet.cause;
}

static void fly_all(struct walker *walker)
{
    const struct atlas_flight *flight = walker->flight;
    const struct atlas_count *count = walker->count;
    const double end = cml_now() + flight->max_seconds;
    for (uint64_t packets = 1; count->crossings < flight->crossings && count->steps < flight->max_steps;
         packets++) {
        if (!place_packet(walker)) return;
        fly_one(walker);
        if (packets % 256 == 0 && flight->max_seconds > 0 && cml_now() > end) return;
    }
}

cml_status NAME(ATLAS_PRECISION, ATLAS_LEVEL)(const struct atlas_flight *flight, struct atlas_count *count,
                                              struct cml_error *err)
{
    const struct cml_engine_options options = {.seed = flight->seed, .reentry = true};
    const struct cml_tally_grid grid = {.nr = 1,
                                        .nz = 1,
                                        .na = 1,
                                        .num_layers = flight->scene->num_layers,
                                        .num_bodies = flight->scene->num_bodies};
    struct cml_owned_world world;
    struct cml_tally tally;
    *count = (struct atlas_count){0};
    CML_TRY(cml_owned_world_create(flight->scene, flight->surfaces, &options, &world, err));
    const cml_status status = cml_tally_create(&grid, &tally, err);
    if (status == CML_OK) {
        struct walker walker = {.flight = flight, .count = count, .world = &world.world};
        walker.deposits = cml_deposits_of(&tally, NULL);
        walker.dice = dice_new(flight->seed);
        for (int b = 0; b < flight->surfaces->count; b++)
            walker.extent = fmax(walker.extent, fmax(fabs(flight->surfaces->item[b].lowest),
                                                     fabs(flight->surfaces->item[b].highest)));
        for (int m = 1; m <= flight->scene->num_layers; m++)
            walker.scale = fmax(walker.scale, flight->scene->media[m].d);
        fly_all(&walker);
        cml_tally_free(&tally);
    }
    cml_owned_world_free(&world);
    return status;
}
