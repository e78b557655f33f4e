/* Code, included by bundle_launch_inl.h only: places and directions of the photons in the launch queue.
 * Vector loops do what cml_place (kernels/source.h) does for one packet, for beams whose packets differ in
 * nothing else.
 * It is compiled once for each level of the processor (engine_cpu_level.c says why).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle_loops_inl.h"

/* True if the queue can place the photons: one beam from above all surfaces. Images and tables need a search,
 * which vector loops do not do. Photons of other beams start with another weight, in another medium, or all
 * alike. */
static int cml_queue_can_place(const struct cml_setup *setup, const struct cml_source *source)
{
    const int alike = source->shape == CML_BEAM_PENCIL && source->light == CML_LIGHT_PARALLEL;
    const int inclined = source->port && source->axis.z < 1;
    return !setup->apart && !alike && !inclined && !source->inside && source->shape != CML_BEAM_IMAGE &&
           source->light != CML_LIGHT_TABLE;
}

/* Draws the words that place the photons, as cml_draw_launch does. */
CML_LOOP void cml_queue_draw_launch(struct cml_stream stream, struct cml_launch_queue *queue)
{
    const cml_u32 radius = CML_LATTICE_LAUNCH_RADIUS, polar = CML_LATTICE_LAUNCH_POLAR;
    const cml_u32 radius_z = cml_lattice_generator(radius), polar_z = cml_lattice_generator(polar),
                  radius_shift = queue->shifts[radius / 4u].w[radius % 4u],
                  polar_shift = queue->shifts[polar / 4u].w[polar % 4u];
    const int even = stream.lattice > 0u;
#pragma omp simd
    for (int i = 0; i < CML_QUEUE; i++) {
        const cml_u32 point = queue->reversed[i];
        const struct cml_block random =
            cml_threefry(stream, queue->index_low[i], queue->index_high[i], 0, CML_PURPOSE_LAUNCH);
        queue->launch[0][i] = cml_even_or_random(even, point * radius_z + radius_shift, random.w[0]);
        queue->launch[1][i] = random.w[1];
        queue->launch[2][i] = cml_even_or_random(even, point * polar_z + polar_shift, random.w[2]);
        queue->launch[3][i] = random.w[3];
    }
}

/* Returns the random words of the launch of photon i of the queue. */
static inline struct cml_block cml_queue_launch(const struct cml_launch_queue *queue, int i)
{
    const struct cml_block draw = {
        {queue->launch[0][i], queue->launch[1][i], queue->launch[2][i], queue->launch[3][i]}};
    return draw;
}

/* Finds the places of all photons on the shape of the beam, and writes them to x and y of the queue. shape:
 * constant, so that the loop contains no other shape. */
static inline void cml_queue_offsets(const struct cml_world *world, struct cml_launch_queue *queue,
                                     const int shape)
{
    struct cml_source source = world->sources[0];
    source.shape = shape;
#pragma omp simd
    for (int i = 0; i < CML_QUEUE; i++) {
        real x, y;
        cml_source_offset(world, &source, cml_queue_launch(queue, i), &x, &y);
        queue->x[i] = x;
        queue->y[i] = y;
    }
}

/* Runs cml_queue_offsets with the loop for the beam's shape. */
CML_LOOP void cml_queue_place_on_shape(const struct cml_world *world, struct cml_launch_queue *queue)
{
    switch (world->sources[0].shape) {
    case CML_BEAM_PENCIL:
        memset(queue->x, 0, sizeof queue->x);
        memset(queue->y, 0, sizeof queue->y);
        break;
    case CML_BEAM_DISK:
        cml_queue_offsets(world, queue, CML_BEAM_DISK);
        break;
    case CML_BEAM_GAUSSIAN:
        cml_queue_offsets(world, queue, CML_BEAM_GAUSSIAN);
        break;
    case CML_BEAM_RING:
        cml_queue_offsets(world, queue, CML_BEAM_RING);
        break;
    default:
        cml_queue_offsets(world, queue, CML_BEAM_RECTANGLE);
    }
}

/* Moves all photons from their places on the shape to their starts, on their lines. light: constant. */
static inline void cml_queue_aim(const struct cml_world *world, struct cml_launch_queue *queue,
                                 const int light)
{
    struct cml_source source = world->sources[0];
    const real n = world->media[source.medium].n;
    source.light = light;
#pragma omp simd
    for (int i = 0; i < CML_QUEUE; i++) {
        const struct cml_vec u = light == CML_LIGHT_PARALLEL
                                     ? source.axis
                                     : cml_source_direction(world, &source, cml_queue_launch(queue, i), n);
        const struct cml_vec at =
            cml_along(cml_along(source.middle, queue->x[i], source.e1), queue->y[i], source.e2);
        const struct cml_vec p = cml_along(at, (source.start - at.z) / u.z, u);
        queue->x[i] = p.x;
        queue->y[i] = p.y;
        queue->ux[i] = u.x;
        queue->uy[i] = u.y;
        queue->uz[i] = u.z;
    }
}

/* Runs cml_queue_aim with the loop for the beam's light. */
CML_LOOP void cml_queue_place_above(const struct cml_world *world, struct cml_launch_queue *queue)
{
    switch (world->sources[0].light) {
    case CML_LIGHT_PARALLEL:
        cml_queue_aim(world, queue, CML_LIGHT_PARALLEL);
        break;
    case CML_LIGHT_EVEN:
        cml_queue_aim(world, queue, CML_LIGHT_EVEN);
        break;
    default:
        cml_queue_aim(world, queue, CML_LIGHT_COSINE);
    }
}

/* Takes the photons of the queue through the plane below them. matched: constant; 1: indices are equal, so
 * that nothing is drawn. */
static inline void cml_queue_cross(const struct cml_world *world, real z, struct cml_launch_queue *queue,
                                   const int matched)
{
    const struct cml_stream stream = world->setup.stream;
    const struct cml_queue_crossing entry = cml_queue_crossing_of(&world->setup, queue, 0);
    const real n1 = world->media[0].n, n2 = world->media[1].n;
#pragma omp simd
    for (int i = 0; i < CML_QUEUE; i++) {
        const struct cml_vec p = {queue->x[i], queue->y[i], z},
                             u = {queue->ux[i], queue->uy[i], queue->uz[i]};
        const real t = -z / u.z, ahead = t > 0 ? t : (real)0;
        const struct cml_vec q = cml_along(p, ahead, u);
        struct cml_vec v = u;
        int transmitted = 1;
        if (!matched) {
            const cml_u32 word = cml_queue_reflection(stream, queue, i, entry);
            v = cml_plane_direction(u, n1, n2, cml_uniform(word), &transmitted);
        }
        const int through = transmitted & (u.z > 0) & (t < CML_INFINITY);
        queue->through[i] = through;
        queue->x[i] = cml_pick(through, q.x, p.x);
        queue->y[i] = cml_pick(through, q.y, p.y);
        queue->ux[i] = cml_pick(through, v.x, u.x);
        queue->uy[i] = cml_pick(through, v.y, u.y);
        queue->uz[i] = cml_pick(through, v.z, u.z);
    }
}

/* Takes the photons of the queue through the plane z = 0 of the first layer (P5), as cml_bundle_reach_planes
 * and cml_bundle_reflect_or_refract do: photons that are transmitted start there. z: where all photons start,
 * cm. The medium above is clear. */
CML_LOOP void cml_queue_enter(const struct cml_world *world, real z, struct cml_launch_queue *queue)
{
    if (world->media[0].n == world->media[1].n)
        cml_queue_cross(world, z, queue, 1);
    else
        cml_queue_cross(world, z, queue, 0);
}

/* Places all photons of the queue, whose indices and points of the lattice are filled. */
static void cml_queue_place(const struct cml_world *world, struct cml_launch_queue *queue)
{
    cml_queue_draw_launch(world->setup.stream, queue);
    cml_queue_place_on_shape(world, queue);
    cml_queue_place_above(world, queue);
}
