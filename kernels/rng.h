/* Random numbers. Each photon owns a stream: every block of four 32-bit words is a pure function of (seed,
 * run, photon index, purpose, event). So no number depends on the order of events, on threads or on devices.
 *
 *      key      seed low, seed high, run, 0    --+
 *                                                +--> Threefry4x32, 12 rounds --> words 0, 1, 2, 3
 *      counter  photon low, photon high,       --+
 *               event, purpose
 *
 * 12 rounds are the fewest that pass BigCrush with a margin [Salmon, Moraes, Dror, Shaw: Parallel random
 * numbers: as easy as 1, 2, 3; SC11, table 2]. The words are bit-equal to Random123's threefry4x32_R(12,
 * ...), which a test checks. The function uses only additions, rotations and exclusive-ors, so every compiler
 * makes vector code of it.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "port.h"

/* The purpose of a block of random words. The purpose is a part of the generator's counter, so that draws
 * for one purpose do not change those for another: additional boundary events leave the scattering draws
 * unchanged. "[k]" is word k of a block. */
enum cml_purpose {
    /* Event e: [0] optical depth to interaction e, [1] [2] its angles, [3] its roulette. */
    CML_PURPOSE_INTERACTION,
    CML_PURPOSE_BOUNDARY, /* event c: [0] reflection at the c-th boundary event with unequal indices */
    CML_PURPOSE_TAIL,     /* event e: further optical depths if word [0] of interaction e is 0 (P2) */
    CML_PURPOSE_LAUNCH,   /* event 0: [0] [1] place in the beam, [2] [3] direction */
    CML_PURPOSE_SHIFT,    /* of a batch, not of a photon: shifts of the lattice (lattice.h) */
    /* Event c, counted as for CML_PURPOSE_BOUNDARY: [0] [3] rounding of the weight that a backing or face
     * keeps, [1] [2] direction. */
    CML_PURPOSE_BACKING,
    /* Event 0: [0] place of the first mark (marks.h); event 1 + e: [0] marks of a long flight that count,
     * after e events. */
    CML_PURPOSE_MARK,
    /* Event 64 j + k: [0] [1] index of part k of a packet split after j interactions; event 0: [0] rounding
     * of a share of a circle (P13) */
    CML_PURPOSE_BRANCH,
    /* Event b, counted over the packet's life: [0] flight to the next facet of a rough boundary, [1] [2] its
     * normal, [3] reflection there. */
    CML_PURPOSE_ROUGH,
};

struct cml_block {
    cml_u32 w[4];
};

struct cml_stream {
    cml_u32 key[4]; /* seed low, seed high, run, 0 */
    /* Interactions of a packet that draw from the lattice (lattice.h): CML_LATTICE_EVENTS or 0. */
    cml_u32 lattice;
};

CML_FN cml_u32 cml_rotate_left(cml_u32 x, int n)
{
    return (x << n) | (x >> (32 - n));
}

#define CML_MIX(a, b, n)                                                                                     \
    do {                                                                                                     \
        (a) += (b);                                                                                          \
        (b) = cml_rotate_left(b, n) ^ (a);                                                                   \
    } while (0)

/* Four rounds of Threefry: column rounds alternate with diagonal rounds. The rotations come in two sets of
 * four. */
#define CML_FOUR_ROUNDS(r0, r1, r2, r3, r4, r5, r6, r7)                                                      \
    do {                                                                                                     \
        CML_MIX(x0, x1, r0);                                                                                 \
        CML_MIX(x2, x3, r1);                                                                                 \
        CML_MIX(x0, x3, r2);                                                                                 \
        CML_MIX(x2, x1, r3);                                                                                 \
        CML_MIX(x0, x1, r4);                                                                                 \
        CML_MIX(x2, x3, r5);                                                                                 \
        CML_MIX(x0, x3, r6);                                                                                 \
        CML_MIX(x2, x1, r7);                                                                                 \
    } while (0)

#define CML_INJECT(a, b, c, d, s)                                                                            \
    do {                                                                                                     \
        x0 += (a);                                                                                           \
        x1 += (b);                                                                                           \
        x2 += (c);                                                                                           \
        x3 += (d) + (s);                                                                                     \
    } while (0)

/* Returns Threefry4x32-12 of the counter (c0, c1, c2, c3) under the stream's key. */
CML_FN struct cml_block cml_threefry(struct cml_stream stream, cml_u32 c0, cml_u32 c1, cml_u32 c2, cml_u32 c3)
{
    const cml_u32 k0 = stream.key[0], k1 = stream.key[1], k2 = stream.key[2], k3 = stream.key[3];
    const cml_u32 k4 = 0x1BD11BDAu ^ k0 ^ k1 ^ k2 ^ k3;
    cml_u32 x0 = c0, x1 = c1, x2 = c2, x3 = c3;
    CML_INJECT(k0, k1, k2, k3, 0u);
    CML_FOUR_ROUNDS(10, 26, 11, 21, 13, 27, 23, 5);
    CML_INJECT(k1, k2, k3, k4, 1u);
    CML_FOUR_ROUNDS(6, 20, 17, 11, 25, 10, 18, 20);
    CML_INJECT(k2, k3, k4, k0, 2u);
    CML_FOUR_ROUNDS(10, 26, 11, 21, 13, 27, 23, 5);
    CML_INJECT(k3, k4, k0, k1, 3u);
    const struct cml_block block = {{x0, x1, x2, x3}};
    return block;
}

/* Returns the block of random words of a photon for an event and purpose. */
CML_FN struct cml_block cml_draw(struct cml_stream stream, cml_u64 photon, enum cml_purpose purpose,
                                 cml_u32 event)
{
    return cml_threefry(stream, (cml_u32)photon, (cml_u32)(photon >> 32), event, (cml_u32)purpose);
}

/* Returns (k + 1/2) / 2^32 for a word k, rounded to real: uniform in (0, 1], never 0. */
CML_FN real cml_uniform(cml_u32 word)
{
    return CML_FMA((real)word, (real)2.3283064365386963e-10, (real)1.1641532182693481e-10);
}

/* Returns a number uniform in (-1, 1), symmetric, never +-1, exact in float: an odd multiple of 2^-24, from
 * the word's upper 24 bits. */
CML_FN real cml_uniform_symmetric(cml_u32 word)
{
    return CML_FMA((real)((int)word >> 8), (real)1.1920928955078125e-7, (real)5.9604644775390625e-8);
}
