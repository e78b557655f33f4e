/* SPDX-License-Identifier: MIT */
#include "oracle_body.h"

#include "geometry/vec3.h"

#include <math.h>

#define MOST_COLUMNS 128 /* along one axis */
#define TURN 6.283185307179586

static bool is_mesh(const struct oracle_bodies *bodies, int k)
{
    return bodies->surfaces->item[k].kind == CML_SURFACE_MESH;
}

/* ---- columns ---- */

static int column_of(const struct oracle_bodies *bodies, int axis, double x)
{
    const double column = (x - bodies->corner[axis]) * bodies->per_column[axis];
    return column > 0 ? (column < bodies->size ? (int)column : bodies->size - 1) : 0;
}

/* Writes the first and the last column of a rectangle along both axes. */
static void columns_of(const struct oracle_bodies *bodies, const double lower[3], const double upper[3],
                       int low[2], int high[2])
{
    for (int axis = 0; axis < 2; axis++) {
        low[axis] = column_of(bodies, axis, lower[axis]);
        high[axis] = column_of(bodies, axis, upper[axis]);
    }
}

/* Counts the entries of every column or, if `entry` exists, writes them. first[] moves by as many. */
static void enter_bodies(struct oracle_bodies *bodies)
{
    for (int k = 0; k < bodies->surfaces->count; k++) {
        const struct cml_body_surface *surface = &bodies->surfaces->item[k];
        int low[2], high[2];
        columns_of(bodies, surface->lower, surface->upper, low, high);
        for (int i = low[0]; i <= high[0]; i++)
            for (int j = low[1]; j <= high[1]; j++) {
                uint32_t *next = &bodies->first[i * bodies->size + j];
                if (bodies->entry) bodies->entry[*next] = (uint32_t)k;
                ++*next;
            }
    }
}

static void *allocate(size_t count, size_t size)
{
    void *memory = calloc(count + 1, size);
    if (!memory) abort();
    return memory;
}

static void create_columns(struct oracle_bodies *bodies)
{
    const struct cml_body_surfaces *surfaces = bodies->surfaces;
    bodies->size = (int)fmin(MOST_COLUMNS, ceil(sqrt(surfaces->count)));
    for (int axis = 0; axis < 2; axis++) {
        double lower = INFINITY, upper = -INFINITY;
        for (int k = 0; k < surfaces->count; k++) {
            lower = fmin(lower, surfaces->item[k].lower[axis]);
            upper = fmax(upper, surfaces->item[k].upper[axis]);
        }
        bodies->corner[axis] = lower;
        bodies->per_column[axis] = bodies->size / (upper - lower);
    }
    const size_t columns = (size_t)bodies->size * (size_t)bodies->size;
    bodies->first = allocate(columns, sizeof *bodies->first);
    enter_bodies(bodies);
    uint32_t total = 0;
    for (size_t i = 0; i <= columns; i++) {
        const uint32_t count = bodies->first[i];
        bodies->first[i] = total;
        total += count;
    }
    bodies->entry = allocate(total, sizeof *bodies->entry);
    enter_bodies(bodies);
    memmove(&bodies->first[1], &bodies->first[0], columns * sizeof *bodies->first);
    bodies->first[0] = 0;
}

void oracle_bodies_create(const struct cml_scene *scene, const struct cml_body_surfaces *surfaces,
                          struct oracle_bodies *bodies)
{
    *bodies = (struct oracle_bodies){.scene = scene, .surfaces = surfaces};
    if (surfaces->count == 0) return;
    bodies->def = allocate((size_t)surfaces->count, sizeof *bodies->def);
    bodies->mesh = allocate((size_t)surfaces->count, sizeof *bodies->mesh);
    for (int k = 0; k < surfaces->count; k++) {
        if (!is_mesh(bodies, k)) continue;
        bodies->def[k] = (struct cml_surface_def){.kind = CML_SURFACE_MESH, .mesh = surfaces->item[k].mesh};
        oracle_create(&bodies->def[k], &bodies->mesh[k]);
    }
    bodies->hosts = allocate((size_t)(scene->num_layers + 2 + surfaces->count), sizeof *bodies->hosts);
    for (int k = 0; k < surfaces->count; k++) bodies->hosts[scene->bodies[k].host] = true;
    create_columns(bodies);
}

void oracle_bodies_free(struct oracle_bodies *bodies)
{
    for (int k = 0; k < bodies->surfaces->count; k++)
        if (is_mesh(bodies, k)) oracle_free(&bodies->mesh[k]);
    free(bodies->def);
    free(bodies->mesh);
    free(bodies->hosts);
    free(bodies->first);
    free(bodies->entry);
}

/* ---- one body ---- */

/* A sphere or cylinder in the frame of its layer. */
struct round {
    double centre[3], axis[3], e1[3], e2[3], length, radius;
};

static struct round round_of(const struct oracle_bodies *bodies, int k)
{
    const struct cml_scene_body *body = &bodies->scene->bodies[k];
    struct round round = {.radius = body->radius};
    cml_vec3_copy(body->centre, round.centre);
    round.centre[2] -= bodies->surfaces->item[k].depth;
    if (body->form == CML_BODY_SPHERE) return round;
    cml_vec3_subtract(body->end, body->centre, round.axis);
    round.length = sqrt(cml_vec3_dot(round.axis, round.axis));
    int least = 0;
    for (int axis = 0; axis < 3; axis++) {
        round.axis[axis] /= round.length;
        if (fabs(round.axis[axis]) < fabs(round.axis[least])) least = axis;
    }
    double other[3] = {0, 0, 0};
    other[least] = 1;
    cml_vec3_cross(round.axis, other, round.e1);
    const double size = sqrt(cml_vec3_dot(round.e1, round.e1));
    for (int axis = 0; axis < 3; axis++) round.e1[axis] /= size;
    cml_vec3_cross(round.axis, round.e1, round.e2);
    return round;
}

/* Returns the distance from the surface of body k, below 0 inside. */
static double distance_of(const struct oracle_bodies *bodies, int k, const double q[3])
{
    const struct round round = round_of(bodies, k);
    double d[3], across[3];
    cml_vec3_subtract(q, round.centre, d);
    if (bodies->scene->bodies[k].form == CML_BODY_SPHERE) return sqrt(cml_vec3_dot(d, d)) - round.radius;
    const double along = cml_vec3_dot(d, round.axis);
    for (int axis = 0; axis < 3; axis++) across[axis] = d[axis] - along * round.axis[axis];
    const double beside = sqrt(cml_vec3_dot(across, across)) - round.radius,
                 beyond = fmax(-along, along - round.length);
    return beside > 0 && beyond > 0 ? hypot(beside, beyond) : fmax(beside, beyond);
}

bool oracle_body_holds(const struct oracle_bodies *bodies, int k, const double q[3])
{
    return is_mesh(bodies, k) ? oracle_below(&bodies->mesh[k], q) : distance_of(bodies, k, q) < 0;
}

bool oracle_body_near(const struct oracle_bodies *bodies, int k, const double q[3], double distance)
{
    return is_mesh(bodies, k) ? oracle_near(&bodies->mesh[k], q, distance)
                              : fabs(distance_of(bodies, k, q)) <= distance;
}

/* ---- all bodies ---- */

static bool allows(const struct oracle_bodies *bodies, int k, bool inside, const double q[3], double distance,
                   bool clearly)
{
    const bool right = oracle_body_holds(bodies, k, q) == inside;
    if (clearly) return right && !oracle_body_near(bodies, k, q, distance);
    return right || oracle_body_near(bodies, k, q, distance);
}

bool oracle_bodies_allow(const struct oracle_bodies *bodies, int medium, const double q[3], double distance,
                         bool clearly)
{
    const int own = medium - bodies->scene->num_layers - 2;
    if (own >= 0 && !allows(bodies, own, true, q, distance, clearly)) return false;
    if (!bodies->hosts || !bodies->hosts[medium]) return true;
    const double lower[3] = {q[0] - distance, q[1] - distance, 0},
                 upper[3] = {q[0] + distance, q[1] + distance, 0};
    int low[2], high[2];
    columns_of(bodies, lower, upper, low, high);
    for (int i = low[0]; i <= high[0]; i++)
        for (int j = low[1]; j <= high[1]; j++) {
            const uint32_t *entry = &bodies->entry[bodies->first[i * bodies->size + j]],
                           *end = &bodies->entry[bodies->first[i * bodies->size + j + 1]];
            for (; entry < end; entry++)
                if (bodies->scene->bodies[*entry].host == medium &&
                    !allows(bodies, (int)*entry, false, q, distance, clearly))
                    return false;
        }
    return true;
}

int oracle_bodies_medium(const struct oracle_bodies *bodies, int medium, const double q[3])
{
    if (!bodies->hosts || !bodies->hosts[medium]) return medium;
    const int column = column_of(bodies, 0, q[0]) * bodies->size + column_of(bodies, 1, q[1]);
    const uint32_t *end = &bodies->entry[bodies->first[column + 1]];
    for (const uint32_t *entry = &bodies->entry[bodies->first[column]]; entry < end; entry++) {
        const int k = (int)*entry;
        if (bodies->scene->bodies[k].host == medium && oracle_body_holds(bodies, k, q))
            return oracle_bodies_medium(bodies, cml_body_medium(bodies->scene, k), q);
    }
    return medium;
}

/* ---- places to aim at ---- */

static void set(double to[3], double a, const double u[3], double b, const double v[3])
{
    for (int axis = 0; axis < 3; axis++) to[axis] = a * u[axis] + b * v[axis];
}

/* Writes a random point of the unit circle. Half of the time the point lies on an axis. */
static void choose_angle(bool on_axis, struct dice *dice, double *c, double *s)
{
    static const double axes[5] = {1, 0, -1, 0, 1};
    const int axis = dice_below(dice, 8);
    const double phi = dice_between(dice, 0, TURN);
    *c = axis < 4 || on_axis ? axes[axis % 4 + 1] : cos(phi);
    *s = axis < 4 || on_axis ? axes[axis % 4] : sin(phi);
}

static struct place place_on_sphere(const struct round *round, enum place_kind kind, struct dice *dice)
{
    struct place place = {.size = round->radius};
    double other[3];
    dice_direction(dice, place.normal);
    dice_direction(dice, other);
    const int axis = dice_below(dice, 3), next = (axis + 1) % 3, last = (axis + 2) % 3;
    double c, s;
    choose_angle(kind == PLACE_VERTEX, dice, &c, &s);
    if (kind == PLACE_FACE) {
        cml_vec3_cross(place.normal, other, place.tangent);
        const double size = sqrt(cml_vec3_dot(place.tangent, place.tangent));
        for (int i = 0; i < 3; i++) place.tangent[i] /= size;
    } else {
        place.normal[axis] = place.tangent[axis] = 0;
        place.normal[next] = place.tangent[last] = c;
        place.normal[last] = s;
        place.tangent[next] = -s;
    }
    set(place.point, 1, round->centre, round->radius, place.normal);
    return place;
}

/* Returns a place on the side of a cylinder: anywhere, on one of four lines along it, or at an end of these.
 */
static struct place place_on_side(const struct round *round, enum place_kind kind, struct dice *dice)
{
    struct place place = {.size = round->length};
    double c, s, along = round->length * dice_uniform(dice);
    choose_angle(kind != PLACE_FACE, dice, &c, &s);
    if (kind == PLACE_VERTEX) along = dice_below(dice, 2) ? round->length : 0;
    set(place.normal, c, round->e1, s, round->e2);
    cml_vec3_copy(round->axis, place.tangent);
    set(place.point, 1, round->centre, along, round->axis);
    set(place.point, 1, place.point, round->radius, place.normal);
    return place;
}

/* Returns a place on an end of a cylinder: anywhere, on its rim, or in its middle. */
static struct place place_on_end(const struct round *round, enum place_kind kind, struct dice *dice)
{
    struct place place = {.size = round->radius};
    const double r = kind == PLACE_FACE ? round->radius * sqrt(dice_uniform(dice))
                                        : (kind == PLACE_EDGE ? round->radius : 0);
    const bool far = dice_below(dice, 2);
    double c, s, radial[3];
    choose_angle(false, dice, &c, &s);
    set(radial, c, round->e1, s, round->e2);
    set(place.tangent, -s, round->e1, c, round->e2);
    set(place.normal, far ? 1 : -1, round->axis, 0, round->axis);
    set(place.point, 1, round->centre, far ? round->length : 0, round->axis);
    set(place.point, 1, place.point, r, radial);
    return place;
}

struct place oracle_body_place(const struct oracle_bodies *bodies, int k, enum place_kind kind,
                               struct dice *dice)
{
    if (is_mesh(bodies, k)) return oracle_place(&bodies->mesh[k], kind, dice);
    const struct round round = round_of(bodies, k);
    if (bodies->scene->bodies[k].form == CML_BODY_SPHERE) return place_on_sphere(&round, kind, dice);
    return dice_below(dice, 2) ? place_on_side(&round, kind, dice) : place_on_end(&round, kind, dice);
}
