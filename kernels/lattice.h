/* Random numbers that are spread evenly over the photons of a batch: a randomly shifted rank-1 lattice rule.
 * It serves the first scatterings of every packet, its first two reflections, and its start.
 * Point p of a batch has in dimension d the word (reversed(p) z_d mod 2^32 + shift_d) mod 2^32, where
 * reversed(p) has the bits of p in reverse order. Then any 2^m points are a lattice, whatever m is, and a
 * batch may grow [Hickernell, Hong, L'Ecuyer, Lemieux: Extensible lattice sequences for quasi-Monte Carlo
 * quadrature, SIAM J. Sci. Comput. 22 (2000) 1117].
 * The shifts are random words of the batch. They make every single point uniform, so all means keep their
 * expected values [Cranley, Patterson, SIAM J. Numer. Anal. 13 (1976) 904]. Packets of one batch depend on
 * each other; batches do not.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "balance.h"
#include "rng.h"

/* Number of a packet's first interactions whose depth, cosine and azimuth come from the lattice. Later
 * interactions draw at random. */
#define CML_LATTICE_EVENTS 3u

/* Number of a packet's first boundary events with unequal indices whose reflection comes from the lattice.
 * Below a curved boundary the first event is the packet's entry, so there are two. */
#define CML_LATTICE_REFLECTIONS 2u

/* Dimensions of the lattice. Dimension 4 e + k is word k of interaction e, for k < 3. The dimensions with k =
 * 3, and those from 12 on, serve other draws: */
#define CML_LATTICE_REFLECTION 3u     /* reflection at a packet's first boundary event */
#define CML_LATTICE_SPARE 7u          /* not in use: it lies badly with dimension 0 if points are few */
#define CML_LATTICE_LAUNCH_RADIUS 11u /* word 0 of the launch */
#define CML_LATTICE_SECOND_REFLECTION 12u
#define CML_LATTICE_LAUNCH_POLAR 13u /* word 2 of the launch */
#define CML_LATTICE_DIMENSIONS 14u
#define CML_LATTICE_BLOCKS 4u /* blocks of four dimensions; the last is not full */

/* Returns the generator z_d of a dimension. `bench/choices/lattice.c` found these numbers and states the
 * criterion. They are selected by comparisons, because vector loops have no tables. */
CML_FN cml_u32 cml_lattice_generator(cml_u32 dimension)
{
    const cml_u32 e = dimension / 4u, k = dimension % 4u;
    const cml_u32 first = k == 0u ? 1u : (k == 1u ? 70295u : (k == 2u ? 715331u : 336347u));
    const cml_u32 second = k == 0u ? 321735u : (k == 1u ? 442827u : (k == 2u ? 663857u : 587937u));
    const cml_u32 third = k == 0u ? 641369u : (k == 1u ? 699997u : (k == 2u ? 1026691u : 344913u));
    const cml_u32 fourth = k == 0u ? 81287u : 889005u;
    return e == 0u ? first : (e == 1u ? second : (e == 2u ? third : fourth));
}

/* Returns a photon's point in its batch, modulo 2^32, with its bits in reverse order. Every 2^32 points of a
 * batch get new shifts. */
CML_FN cml_u32 cml_lattice_reversed(cml_u32 photon_low, cml_u32 photon_high)
{
    cml_u32 x = photon_low / CML_NUM_BATCHES | photon_high << (32 - CML_LOG2_BATCHES);
    x = (x >> 16) | (x << 16);
    x = ((x & 0xff00ff00u) >> 8) | ((x & 0x00ff00ffu) << 8);
    x = ((x & 0xf0f0f0f0u) >> 4) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x & 0xccccccccu) >> 2) | ((x & 0x33333333u) << 2);
    return ((x & 0xaaaaaaaau) >> 1) | ((x & 0x55555555u) << 1);
}

/* Returns the shifts of dimensions 4 e to 4 e + 3, for the batch of a photon. */
CML_FN struct cml_block cml_lattice_shifts(struct cml_stream stream, cml_u32 photon_low, cml_u32 photon_high,
                                           cml_u32 e)
{
    const cml_u32 batch = photon_low % CML_NUM_BATCHES, beyond = photon_high >> CML_LOG2_BATCHES;
    return cml_threefry(stream, batch, beyond, e, (cml_u32)CML_PURPOSE_SHIFT);
}

/* Returns cml_lattice_reversed of a photon's 64-bit index. */
CML_FN cml_u32 cml_lattice_point(cml_u64 photon)
{
    return cml_lattice_reversed((cml_u32)photon, (cml_u32)(photon >> 32));
}

/* Returns a word of the lattice in place of a random one. Its lowest 8 bits stay random: they round absorbed
 * weight (P3), and make every word possible. shifts: those of the block of four that holds the dimension. */
CML_FN cml_u32 cml_lattice_word(cml_u32 reversed, cml_u32 dimension, struct cml_block shifts, cml_u32 random)
{
    const cml_u32 word = reversed * cml_lattice_generator(dimension) + shifts.w[dimension % 4u];
    return (word & ~255u) | (random & 255u);
}

/* Returns cml_lattice_word for one dimension of a photon, and computes the photon's point and shifts for
 * it. */
CML_FN cml_u32 cml_lattice_draw(struct cml_stream stream, cml_u64 photon, cml_u32 dimension, cml_u32 random)
{
    const struct cml_block shifts =
        cml_lattice_shifts(stream, (cml_u32)photon, (cml_u32)(photon >> 32), dimension / 4u);
    return cml_lattice_word(cml_lattice_point(photon), dimension, shifts, random);
}

/* Returns the block of interaction e < CML_LATTICE_EVENTS: the random block with three of its words replaced.
 * shifts: of dimensions 4 e to 4 e + 3. */
CML_FN struct cml_block cml_lattice_block(cml_u32 reversed, cml_u32 e, struct cml_block shifts,
                                          struct cml_block random)
{
    const struct cml_block block = {{cml_lattice_word(reversed, 4u * e, shifts, random.w[0]),
                                     cml_lattice_word(reversed, 4u * e + 1u, shifts, random.w[1]),
                                     cml_lattice_word(reversed, 4u * e + 2u, shifts, random.w[2]),
                                     random.w[3]}};
    return block;
}

/* ---- draws of a packet: from the lattice, as long as the stream has one ---- */

/* Returns the random words of interaction number `event` of packet `photon`: from the lattice for the first
 * ones, as far as sampling is even. */
CML_FN struct cml_block cml_draw_interaction(struct cml_stream stream, cml_u64 photon, cml_u32 event)
{
    const struct cml_block random = cml_draw(stream, photon, CML_PURPOSE_INTERACTION, event);
    if (event >= stream.lattice) return random;
    return cml_lattice_block(cml_lattice_point(photon), event,
                             cml_lattice_shifts(stream, (cml_u32)photon, (cml_u32)(photon >> 32), event),
                             random);
}

/* Returns the dimension that decides the reflection at boundary event `crossing` with unequal indices.
 * crossing < CML_LATTICE_REFLECTIONS. */
CML_FN cml_u32 cml_lattice_reflection(cml_u32 crossing)
{
    return crossing == 0u ? CML_LATTICE_REFLECTION : CML_LATTICE_SECOND_REFLECTION;
}

/* Returns the word that decides the reflection at a photon's boundary event `crossing` with unequal
 * indices. */
CML_FN cml_u32 cml_draw_reflection(struct cml_stream stream, cml_u64 photon, cml_u32 crossing)
{
    const cml_u32 random = cml_draw(stream, photon, CML_PURPOSE_BOUNDARY, crossing).w[0];
    if (crossing >= CML_LATTICE_REFLECTIONS || !stream.lattice) return random;
    return cml_lattice_draw(stream, photon, cml_lattice_reflection(crossing), random);
}

/* Returns the words of a photon's launch: words 0 and 1 place it in its beam, words 2 and 3 draw its
 * direction. Words 0 and 2 come from the lattice. Words 1 and 3 are random, because directions, pixels and
 * facets ask where a pair of words lies, and the lattice puts too many points side by side there. direction:
 * 1 if word 2 is used. */
CML_FN struct cml_block cml_draw_launch(struct cml_stream stream, cml_u64 photon, int direction)
{
    struct cml_block draw = cml_draw(stream, photon, CML_PURPOSE_LAUNCH, 0);
    if (!stream.lattice) return draw;
    draw.w[0] = cml_lattice_draw(stream, photon, CML_LATTICE_LAUNCH_RADIUS, draw.w[0]);
    if (direction) draw.w[2] = cml_lattice_draw(stream, photon, CML_LATTICE_LAUNCH_POLAR, draw.w[2]);
    return draw;
}
