/* Code, included once by each engine on the host, in its precision and for its level of the processor, as
 * terminated_packets_inl.h is: weights of the rows of a sweep that come of one flight (P16), and scores for
 * derivatives (P17).
 *
 *      weight of a row = weight of the packet * factor of the row
 *
 *      w   *---.                       packet: falls at interactions (o), rises or ends at roulette
 *          |    o-----o----.           row:    falls all along the path as well
 *          |. . _     |    o----o
 *          |      . . . _  |    |
 *          +-----------------. .+-->
 *
 * Rows are booked where the packet changes the medium, plays roulette, loses weight to a surface, or ends:
 * one vector loop over all rows. Scores are summed as rows are, but their factors add up along the path, and
 * may be negative.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/detected_light_inl.h"
#include "tally/row_cells.h"
#include "walk.h"

#define CML_ROWS_INLINE __attribute__((always_inline)) static inline

/* Sums over the rows of a flight: their layout and their arrays. */
struct cml_row_sums {
    int count;             /* number of rows; 0: there are none */
    int scores;            /* 1: the rows are scores */
    int timed;             /* 1: the rows have A_t */
    int means;             /* 1: the rows have means of detectors */
    struct cml_layout at;  /* layout of a batch, in bins */
    size_t batch;          /* number of cells of a batch */
    uint64_t *cells, *ra;  /* sums of the first batch; Rd_ra */
    size_t transmitted_ra; /* distance from Rd_ra to Tt_ra */
    uint64_t *rz;          /* A_rz, if rows have one */
    uint64_t *radii;       /* Rd_rt of the rows; NULL: they have none */
    size_t transmitted_rt; /* distance from Rd_rt to Tt_rt */
    uint64_t *dir;        /* sums over directions of all rows of a sweep: Rd_dir, behind it Tt_dir; or NULL */
    struct cml_once once; /* layout of directions, in bins of all rows */
};

/* Returns where the sums of the rows of a sweep lie in a tally. Binned arrays by batch come first, then
 * grids over r and angle, r and z, directions, and r and time, as far as they exist. */
static inline struct cml_row_sums cml_row_sums_of(const struct cml_world *world,
                                                  const struct cml_tally *tally)
{
    const struct cml_tally_grid *grid = &tally->grid;
    struct cml_row_sums sums = {.count = world->rows.count};
    if (sums.count == 0) return sums;
    sums.scores = world->rows.hits != NULL;
    sums.timed = grid->row_times;
    sums.means = grid->row_means;
    const struct cml_layout grids = cml_layout_of(grid, CML_OF_ROW_GRIDS);
    const size_t stride = cml_row_stride(grid);
    sums.at = cml_layout_of(grid, CML_OF_ROW_BINS);
    sums.batch = cml_row_batch(grid, 1);
    sums.cells = tally->rows;
    sums.ra = tally->rows + cml_row_batch(grid, CML_NUM_BATCHES);
    sums.transmitted_ra = (grids.Tt_ra - grids.Rd_ra) * stride;
    sums.rz = sums.ra + grids.A_rz * stride;
    if (grids.size[CML_ARRAY_Rd_dir]) sums.dir = sums.ra + grids.Rd_dir * stride;
    sums.once = grids.once[CML_ARRAY_Rd_dir];
    if (grids.size[CML_ARRAY_Rd_rt]) sums.radii = sums.ra + grids.Rd_rt * stride;
    sums.transmitted_rt = (grids.Tt_rt - grids.Rd_rt) * stride;
    return sums;
}

/* Returns a hash of a word (fmix32 of MurmurHash3), which looks random. */
static inline cml_u32 cml_row_hash(cml_u32 h)
{
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

/* The rows of one packet, for one booking. */
struct cml_row_packet {
    const struct cml_row_sums *sums;
    uint64_t *cells; /* sums of the packet's batch */
    /* [cml_row_factors] weight of each row divided by the packet's weight; for scores, the score. */
    real *factor;
    real rounding; /* added to weights before they are cut to integers, 0 to below 1 */
};

/* Numbers behind the factors of all rows, which describe the packet at its last booking: its number of
 * interactions modulo 2^24, because a float holds integers below 2^24 exactly; its optical path in the
 * material, and that outside of it, cm (P11). */
enum { CML_ROW_INTERACTIONS, CML_ROW_INSIDE, CML_ROW_OUTSIDE, CML_ROW_MEMORY };

/* Returns how many numbers the factors of a packet take, with the numbers behind them (CML_ROW_MEMORY). */
static inline size_t cml_row_factors(size_t rows)
{
    return rows + CML_ROW_MEMORY;
}

/* Returns the time of the last booking, as an optical path, cm. */
static inline real cml_row_booked_at(const real *factor, size_t rows)
{
    return factor[rows + CML_ROW_INSIDE] + factor[rows + CML_ROW_OUTSIDE];
}

/* Returns a hash of a packet, from both words of its index and the whole key of the run, so that seeds are
 * independent. It is fmix32 of A. Appleby's MurmurHash3. A hash is enough, because nothing else depends on
 * it. */
static inline cml_u32 cml_row_hash_of(const struct cml_setup *setup, cml_u32 low, cml_u32 high)
{
    const cml_u32 *key = setup->stream.key;
    const cml_u32 run = cml_row_hash(cml_row_hash(cml_row_hash(key[2]) + key[1]) + key[0]);
    return cml_row_hash(cml_row_hash(low + run) + high);
}

/* Returns what it takes to add packet `index` to the sums of all rows. Weights are rounded at random, so that
 * means of tiny weights are kept. A packet has one random number for all its roundings, so a later weight of
 * the packet is never rounded above an earlier one. */
static inline struct cml_row_packet
cml_row_packet_of(const struct cml_setup *setup, const struct cml_row_sums *sums, cml_u64 index, real *factor)
{
    const cml_u32 hash = cml_row_hash_of(setup, (cml_u32)index, (cml_u32)(index >> 32));
    const struct cml_row_packet rows = {.sums = sums,
                                        .cells = sums->cells + index % CML_NUM_BATCHES * sums->batch,
                                        .factor = factor,
                                        .rounding = (real)(hash >> 8) * (real)0x1p-24};
    return rows;
}

/* True if interaction n of a packet, from 1, is one of those that make up A(r,z) of rows: each
 * CML_ROW_SAMPLING-th. The first of them is random, by bits of the packet's hash that rounding does not
 * use. */
static inline int cml_row_samples(cml_u32 hash, cml_u32 n)
{
    return (hash + n) % CML_ROW_SAMPLING == 0;
}

/* Returns the sums of all rows in a bin. */
static inline uint64_t *cml_row_bin(const struct cml_row_packet *rows, size_t bin)
{
    return rows->cells + bin * (size_t)rows->sums->count;
}

/* Returns a packet's weight in the unit by which factors are multiplied, 2^-30 of a packet. */
static inline real cml_row_unit(cml_u32 w)
{
    return (real)w * (real)0.5;
}

/* Returns a row's weight in units of 2^-30 of a packet, which fits into `int`. It never rises if neither the
 * packet's weight nor the factor does. */
static inline cml_u32 cml_row_weight(real unit, real factor, real rounding)
{
    return (cml_u32)(int)CML_FMA(unit, factor, rounding);
}

/* Returns a row's contribution to a sum, in whole units. A weight is rounded at random, by `rounding`. A
 * score times the weight is in units of 2^-20 of a packet, so that the contributions of 2^43 interactions fit
 * into a tally; it is rounded in the same way, but towards minus infinity, because it may be negative. */
CML_ROWS_INLINE uint64_t cml_row_part(int scores, real unit, real factor, real rounding)
{
    return scores ? (uint64_t)(int64_t)CML_FLOOR(CML_FMA(unit * (real)0x1p-10, factor, rounding))
                  : (uint64_t)cml_row_weight(unit, factor, rounding);
}

/* Launches a packet of weight w with all its rows (times = 1), or takes a launch back (times = -1) for a
 * packet that was never inside. path: as in cml_packet. The rounded weight of the rows is summed in the place
 * of the first row. Scores begin with 0. */
static inline void cml_rows_launch(const struct cml_row_packet *rows, cml_u32 w, int times, real path)
{
    real *memory = rows->factor + rows->sums->count;
    const int scores = rows->sums->scores;
    const uint64_t launched = scores ? 0 : cml_row_weight(cml_row_unit(w), 1, rows->rounding);
    *cml_row_bin(rows, CML_BALANCE_LAUNCHED) += times < 0 ? 0 - launched : launched;
    for (int i = 0; i < rows->sums->count; i++) rows->factor[i] = scores ? 0 : 1;
    memory[CML_ROW_INTERACTIONS] = memory[CML_ROW_OUTSIDE] = 0;
    memory[CML_ROW_INSIDE] = path > 0 ? path : (real)0;
}

/* Adds to each derivative's score the effect of a flight of length t (cm): `more` per cm, and `hits` for
 * each scattering since the last call. Absorption on the way is added to the medium, weighted by the score.
 * It is cml_rows_fly for derivatives. */
static inline void cml_scores_fly(const struct cml_world *world, const struct cml_row_packet *rows,
                                  int medium, real t, cml_u32 interactions, cml_u32 before, cml_u32 left)
{
    const int count = rows->sums->count;
    const real rounding = rows->rounding;
    const real in = cml_row_unit(before), out = cml_row_unit(left);
    const real *restrict more = world->rows.more + (size_t)medium * (size_t)count;
    const real *restrict hits = world->rows.hits + (size_t)medium * (size_t)count;
    real *restrict score = rows->factor;
    uint64_t *restrict absorbed = cml_row_bin(rows, rows->sums->at.A_l + (size_t)medium);
    const cml_u32 seen = interactions & 0xffffffu;
    real *last = &score[count + CML_ROW_INTERACTIONS];
    const real times = (real)((seen - (cml_u32)*last) & 0xffffffu);
    *last = (real)seen;
#pragma omp simd
    for (int i = 0; i < count; i++) {
        const real s = score[i], after = CML_FMA(hits[i], times, CML_FMA(more[i], t, s));
        absorbed[i] += cml_row_part(1, in, s, rounding) - cml_row_part(1, out, after, rounding);
        score[i] = after;
    }
}

/* Absorbs a flight of length t (cm) in all rows of a sweep, each with its own mua. The packet's weight fell
 * from `before` to `left`; a row's weight is the packet's times the row's factor. timed: also adds to the
 * time gate by_t. Factors below 1e-20 become 0, because arithmetic with the smallest numbers is slow. */
CML_ROWS_INLINE void cml_rows_absorb_as(int timed, const struct cml_world *world,
                                        const struct cml_row_packet *rows, int medium, real t, cml_u32 before,
                                        cml_u32 left, uint64_t *restrict by_t)
{
    const int count = rows->sums->count;
    const real rounding = rows->rounding;
    const real in = cml_row_unit(before), out = cml_row_unit(left);
    const real *restrict more = world->rows.more + (size_t)medium * (size_t)count;
    real *restrict factor = rows->factor;
    uint64_t *restrict absorbed = cml_row_bin(rows, rows->sums->at.A_l + (size_t)medium);
#pragma omp simd
    for (int i = 0; i < count; i++) {
        const real f = factor[i], after = f * cml_exp_minus(more[i] * t);
        const real kept = after > (real)1e-20 ? after : (real)0;
        const uint64_t part = cml_row_weight(in, f, rounding) - cml_row_weight(out, kept, rounding);
        absorbed[i] += part;
        if (timed) by_t[i] += part;
        factor[i] = kept;
    }
}

/* Absorbs a flight in all rows, as cml_rows_absorb_as does, and divides the loss among the time gates that
 * the flight crosses. path: optical path, cm. The packet's own loss goes to the first gate, because a packet
 * is handled at its first interaction in each later gate; rows lose weight all along the path. */
static inline void cml_rows_absorb_by_time(const struct cml_world *world, const struct cml_row_packet *rows,
                                           int medium, real path, cml_u32 before, cml_u32 left)
{
    const struct cml_gates gates = world->setup.gates;
    const size_t count = (size_t)rows->sums->count;
    const real n = world->media[medium].n;
    real at = cml_row_booked_at(rows->factor, count), rest = path;
    int gate = cml_gate(gates, at);
    for (const int last = cml_gate(gates, at + path); gate < last; gate++) {
        const real end = (real)(gate + 1) / gates.per_cm, way = end > at ? end - at : (real)0,
                   part = way < rest ? way : rest;
        cml_rows_absorb_as(1, world, rows, medium, part / n, before, left,
                           cml_row_bin(rows, rows->sums->at.A_t + (size_t)gate));
        before = left;
        rest -= part;
        at = end;
    }
    cml_rows_absorb_as(1, world, rows, medium, rest / n, before, left,
                       cml_row_bin(rows, rows->sums->at.A_t + (size_t)gate));
    rows->factor[count + CML_ROW_INSIDE] += path;
}

/* Books a flight in all rows: a packet of weight `before` has flown `path` (as in cml_packet) in a medium,
 * and `left` of it remains. interactions: of the packet so far. */
static inline void cml_rows_fly(const struct cml_world *world, const struct cml_row_packet *rows, int medium,
                                real path, cml_u32 interactions, cml_u32 before, cml_u32 left)
{
    const real flown = path > 0 && !cml_is_outer(world, medium) ? path : (real)0,
               t = flown / world->media[medium].n;
    if (rows->sums->scores)
        cml_scores_fly(world, rows, medium, t, interactions, before, left);
    else if (rows->sums->timed)
        cml_rows_absorb_by_time(world, rows, medium, flown, before, left);
    else
        cml_rows_absorb_as(0, world, rows, medium, t, before, left, NULL);
}

/* Returns the optical path of all visits to the outer media, cm, of a packet that is now in the material. */
static inline real cml_rows_outside(const struct cml_world *world, const struct cml_trail *trail)
{
    const int below = world->setup.num_layers + 1;
    return (real)(world->media[0].n * trail->stay[0].length +
                  world->media[below].n * trail->stay[below].length);
}

/* True if a packet in the material has been outside since its last booking. Rows with A_t are then booked
 * before they fly on, because their losses so far belong to the time before. */
static inline int cml_rows_have_returned(const struct cml_world *world, const struct cml_row_packet *rows,
                                         const struct cml_trail *trail)
{
    return rows->sums->timed &&
           rows->factor[rows->sums->count + CML_ROW_OUTSIDE] != cml_rows_outside(world, trail);
}

/* Records the optical path outside the material as booked. Call it after cml_rows_fly. */
static inline void cml_rows_pass_time(const struct cml_world *world, const struct cml_row_packet *rows,
                                      const struct cml_trail *trail)
{
    if (rows->sums->timed) rows->factor[rows->sums->count + CML_ROW_OUTSIDE] = cml_rows_outside(world, trail);
}

/* Adds a sampled interaction to a bin of depth and a bin of radius and depth, for each row of a sweep: its
 * weight `unit`, times the absorbed share of the row, times the row's factor, in whole units. rounding:
 * random number of the packet between 0 and 1. wide: 1 if a contribution may exceed 31 bits, for which
 * vectors of 32 bits are too narrow. */
CML_ROWS_INLINE void cml_rows_sample_as(int wide, const struct cml_row_packet *rows, real unit,
                                        const real *restrict share, uint64_t *restrict by_z,
                                        uint64_t *restrict by_rz)
{
    const int count = rows->sums->count;
    const real rounding = rows->rounding;
    const real *restrict factor = rows->factor;
#pragma omp simd
    for (int i = 0; i < count; i++) {
        const real part = CML_FMA(unit * share[i], factor[i], rounding);
        const uint64_t whole = wide ? (uint64_t)(int64_t)part : (uint64_t)(cml_u32)(int)part;
        by_z[i] += whole;
        by_rz[i] += whole;
    }
}

/* Bins of an interaction, [rows] each. */
struct cml_row_place {
    uint64_t *by_z, *by_rz;
};

/* Returns where an interaction at p counts in the rows' A(z) and A(r, z). */
static inline struct cml_row_place cml_rows_sampled_at(const struct cml_world *world,
                                                       const struct cml_row_packet *rows, int medium,
                                                       struct cml_vec p)
{
    const struct cml_setup *setup = &world->setup;
    const struct cml_row_sums *sums = rows->sums;
    const size_t iz = (size_t)cml_depth_bin(setup, p.z, world->media[medium].bins),
                 ir = (size_t)cml_radial_bin(setup, p.x, p.y);
    return (struct cml_row_place){
        cml_row_bin(rows, sums->at.A_z + iz),
        sums->rz + (ir * ((size_t)setup->nz + 2) + iz) * (size_t)sums->count,
    };
}

/* Fetches the bins that will be needed soon into the cache, because grids of all rows are larger than
 * caches. */
static inline void cml_rows_expect(const struct cml_row_packet *rows, struct cml_row_place at)
{
    for (int i = 0; i < rows->sums->count; i += 8) { /* one step for each cache line of 64 bytes */
        __builtin_prefetch(at.by_z + i, 1);
        __builtin_prefetch(at.by_rz + i, 1);
    }
}

/* Adds a sampled interaction in a medium, after the booking there. left: the packet's weight after the
 * interaction; before: its weight at the booking before, used in a medium that leaves nothing of any
 * packet. */
static inline void cml_rows_sample(const struct cml_world *world, const struct cml_row_packet *rows,
                                   int medium, struct cml_row_place at, cml_u32 before, cml_u32 left)
{
    const int black = world->media[medium].absorb >= 1;
    const real unit = cml_row_unit(black ? before : left);
    const real *share = world->rows.part + (size_t)medium * (size_t)rows->sums->count;
    if (unit * world->rows.most[medium] < (real)0x1p30)
        cml_rows_sample_as(0, rows, unit, share, at.by_z, at.by_rz);
    else
        cml_rows_sample_as(1, rows, unit, share, at.by_z, at.by_rz);
}

/* Adds the difference of two weights of the packet, as each row weighs it, to a bin. high, low: cml_row_unit
 * of both weights. */
CML_ROWS_INLINE void cml_rows_change_as(int scores, const struct cml_row_packet *rows, real high, real low,
                                        uint64_t *restrict to)
{
    const int count = rows->sums->count;
    const real rounding = rows->rounding;
    const real *restrict factor = rows->factor;
#pragma omp simd
    for (int i = 0; i < count; i++)
        to[i] +=
            cml_row_part(scores, high, factor[i], rounding) - cml_row_part(scores, low, factor[i], rounding);
}

/* Books a change of the packet's weight by other means than absorption: the difference goes into the bin of
 * `more` if the weight rises, of `less` if it falls. */
static inline void cml_rows_change(const struct cml_row_packet *rows, cml_u32 before, cml_u32 after,
                                   enum cml_balance_term more, enum cml_balance_term less)
{
    const real high = cml_row_unit(after > before ? after : before),
               low = cml_row_unit(after > before ? before : after);
    uint64_t *to = cml_row_bin(rows, (size_t)(after > before ? more : less));
    if (after == before) return;
    if (rows->sums->scores)
        cml_rows_change_as(1, rows, high, low, to);
    else
        cml_rows_change_as(0, rows, high, low, to);
}

/* Books the effect of roulette on the packet's weight in all rows (P8). */
static inline void cml_rows_roulette(const struct cml_row_packet *rows, cml_u32 before, cml_u32 after)
{
    cml_rows_change(rows, before, after, CML_BALANCE_GAINED, CML_BALANCE_ROULETTE);
}

/* Books the weight that the backing, or a face, keeps in all rows (P12). */
static inline void cml_rows_keep(const struct cml_row_packet *rows, cml_u32 before, cml_u32 after, int face)
{
    const enum cml_balance_term term = face ? CML_BALANCE_FACE : CML_BALANCE_BACKING;
    cml_rows_change(rows, before, after, term, term);
}

/* Adds a packet that leaves the scene to the totals and profiles of all rows, with each row's weight.
 * scores: 1 if the rows are scores for derivatives, which have no sums over both radius and angle; timed: 1
 * if there are time gates. */
CML_ROWS_INLINE void cml_rows_leave_as(int scores, int timed, const struct cml_setup *setup,
                                       const struct cml_row_packet *rows, const struct cml_exit *exit,
                                       real unit)
{
    const struct cml_row_sums *sums = rows->sums;
    const int count = sums->count, up = exit->up;
    const size_t ir = (size_t)exit->r, ia = (size_t)exit->alpha;
    const real rounding = rows->rounding;
    const real *restrict factor = rows->factor;
    uint64_t *restrict by_r = cml_row_bin(rows, (up ? sums->at.Rd_r : sums->at.Tt_r) + ir);
    uint64_t *restrict by_a = cml_row_bin(rows, (up ? sums->at.Rd_a : sums->at.Tt_a) + ia);
    uint64_t *restrict by_t = cml_row_bin(rows, (up ? sums->at.Rd_t : sums->at.Tt_t) + (size_t)exit->gate);
    uint64_t *restrict by_ra =
        sums->ra + (up ? 0 : sums->transmitted_ra) + (ir * (size_t)setup->na + ia) * (size_t)count;
    uint64_t *restrict total = cml_row_bin(rows, up ? CML_BALANCE_REFLECTED : CML_BALANCE_TRANSMITTED);
#pragma omp simd
    for (int i = 0; i < count; i++) {
        const uint64_t part = cml_row_part(scores, unit, factor[i], rounding);
        by_r[i] += part;
        by_a[i] += part;
        if (timed) by_t[i] += part;
        if (!scores) by_ra[i] += part;
        total[i] += part;
    }
}

/* Adds a packet of weight w that leaves the scene to the profiles of all rows of a sweep, each with its own
 * weight. */
static inline void cml_rows_leave(const struct cml_setup *setup, const struct cml_row_packet *rows,
                                  const struct cml_exit *exit, cml_u32 w)
{
    const real unit = cml_row_unit(w);
    if (rows->sums->scores)
        cml_rows_leave_as(1, 0, setup, rows, exit, unit);
    else if (setup->gates.count)
        cml_rows_leave_as(0, 1, setup, rows, exit, unit);
    else
        cml_rows_leave_as(0, 0, setup, rows, exit, unit);
}

/* ---- detectors (P13) and directions (P7) ----
 * Light that was never inside, and light that is split off at a launch, weighs as much in all rows. */

/* Light that has left, with the rows that weigh it. */
struct cml_row_light {
    const struct cml_row_packet *rows;
    const struct cml_light_out *light;
    int fresh; /* 1: the light weighs as much in all rows, and has no score */
};

/* Adds light to one bin of all rows of a sweep, each with its own weight. to: the bin of the first row; the
 * others follow. */
static inline void cml_rows_add_to(const struct cml_row_light *of, uint64_t *to)
{
    const struct cml_row_packet *rows = of->rows;
    const int count = rows->sums->count, scores = rows->sums->scores;
    const real unit = cml_row_unit(of->light->w), rounding = rows->rounding;
    const uint64_t whole = scores ? 0 : cml_row_weight(unit, 1, rounding);
    if (of->fresh)
        for (int i = 0; i < count; i++) to[i] += whole;
    else
        for (int i = 0; i < count; i++) to[i] += cml_row_part(scores, unit, rows->factor[i], rounding);
}

/* Adds the light, as each row weighs it, to a bin of the packet's batch. */
static inline void cml_rows_add(const struct cml_row_light *of, size_t bin)
{
    cml_rows_add_to(of, cml_row_bin(of->rows, bin));
}

/* Returns where a packet that leaves counts in the rows' Rd or Tt over radius and time. */
static inline uint64_t *cml_row_radius_and_gate(const struct cml_setup *setup,
                                                const struct cml_row_packet *rows,
                                                const struct cml_exit *exit)
{
    const struct cml_row_sums *sums = rows->sums;
    const size_t cell = (size_t)exit->r * ((size_t)setup->gates.count + 1) + (size_t)exit->gate;
    return sums->radii + (exit->up ? 0 : sums->transmitted_rt) + cell * (size_t)sums->count;
}

/* Adds weight times `number` to a moment (such as the mean depth) of each row. number: in units of 2^-16. A
 * moment needs more than 64 bits, so its sum has a lower and an upper part, which lie `count` cells apart. */
static inline void cml_rows_add_moment(const struct cml_row_light *of, size_t bin, uint64_t number)
{
    const struct cml_row_packet *rows = of->rows;
    const int count = rows->sums->count;
    const real unit = cml_row_unit(of->light->w), rounding = rows->rounding;
    const uint32_t high = (uint32_t)(number >> CML_ROW_MOMENT_SHIFT),
                   low = (uint32_t)number & ((1u << CML_ROW_MOMENT_SHIFT) - 1);
    uint64_t *restrict to = cml_row_bin(rows, bin), *restrict upper = to + count;
#pragma omp simd
    for (int i = 0; i < count; i++) {
        const uint64_t w = cml_row_weight(unit, of->fresh ? (real)1 : rows->factor[i], rounding);
        const uint64_t part = (w * low + (1u << (CML_ROW_MOMENT_SHIFT - 1))) >> CML_ROW_MOMENT_SHIFT,
                       moment = w * high + part;
        to[i] += moment & ((1u << CML_ROW_MOMENT_BITS) - 1);
        upper[i] += moment >> CML_ROW_MOMENT_BITS;
    }
}

/* Adds the light to all moments of detector k, as cml_add_moments does for the packet. */
static inline void cml_rows_add_moments(const struct cml_world *world, const struct cml_row_light *of,
                                        size_t k)
{
    const struct cml_trail *trail = of->light->trail;
    const size_t media = cml_num_media(world), numbers = CML_MEDIUM_MOMENTS * media,
                 first = of->rows->sums->at.moments + 2 * k * (numbers + 1);
    const uint64_t deepest = cml_deepest_in_units(world, trail);
    for (size_t i = 0; trail && i < numbers; i++) {
        const int moment = (int)(i / media),
                  shift = moment == CML_MOMENT_INTERACTIONS ? CML_ROW_MOMENT_SHIFT : 0;
        const uint64_t number = cml_number_of_moment(world, &trail->stay[i % media], moment);
        if (number) cml_rows_add_moment(of, first + 2 * i, number << shift);
    }
    if (deepest) cml_rows_add_moment(of, first + 2 * numbers, deepest);
}

/* Adds the light to all detectors that see it, and to their groups, as each row weighs it. */
static inline void cml_rows_detect(const struct cml_world *world, const struct cml_row_light *of)
{
    const struct cml_layout *at = &of->rows->sums->at;
    const size_t gates = (size_t)world->setup.gates.count;
    struct cml_seeing seeing = cml_seeing_of(world, &of->light->ray);
    for (int seen; (seen = cml_next_seeing(&seeing)) >= 0;)
        for (int k = seen; k >= 0; k = cml_group_of(world, k)) {
            cml_rows_add(of, at->detector + (size_t)k);
            if (of->rows->sums->means) cml_rows_add_moments(world, of, (size_t)k);
            if (gates) cml_rows_add(of, at->detector_t + (size_t)k * (gates + 1) + (size_t)of->light->gate);
        }
}

/* Adds a packet that leaves the scene to the bin of its direction, once for each row of a sweep with the
 * row's own weight. Groups have bins of their own, once.step apart, or share bins (step 0), and squares
 * stand once.squares bins behind. Rows count in 2^-30 packets and squares in 2^-31, hence 2 * part. */
static inline void cml_rows_direct(const struct cml_setup *setup, const struct cml_row_light *of)
{
    const struct cml_row_packet *rows = of->rows;
    const size_t count = (size_t)rows->sums->count,
                 cells = (size_t)setup->directions.nt * (size_t)setup->directions.np;
    const struct cml_once once = rows->sums->once;
    const struct cml_vec u = of->light->ray.u;
    const size_t bin = cml_direction_bin(&setup->directions, u.x, u.y, u.z) +
                       (of->light->ray.below ? cells : 0) + of->light->index % CML_NUM_GROUPS * once.step;
    uint64_t *const to = rows->sums->dir + bin * count;
    const real unit = cml_row_unit(of->light->w);
    for (size_t i = 0; i < count; i++) {
        const uint64_t part = cml_row_weight(unit, rows->factor[i], rows->rounding);
        to[i] += part;
        if (!once.step) to[once.squares * count + i] += cml_square_of(2 * part);
    }
}

/* Books the end of a packet in all rows, and its light if it has left. Light that was never inside is in the
 * flight's own specular part. */
static inline void cml_rows_end(const struct cml_world *world, const struct cml_row_packet *rows, int fate,
                                const struct cml_exit *exit, const struct cml_light_out *light)
{
    const struct cml_row_light of = {rows, light, exit->fresh};
    if (exit->up | exit->down) {
        cml_rows_leave(&world->setup, rows, exit, light->w);
        if (rows->sums->radii) cml_rows_add_to(&of, cml_row_radius_and_gate(&world->setup, rows, exit));
        if (rows->sums->dir) cml_rows_direct(&world->setup, &of);
    }
    if (cml_has_left(exit) && world->detection.num_detectors) cml_rows_detect(world, &of);
    if (exit->fresh) cml_rows_launch(rows, light->w, -1, 0);
    if (fate == CML_FATE_TRAPPED)
        cml_rows_change(rows, light->w, 0, CML_BALANCE_TRAPPED, CML_BALANCE_TRAPPED);
    if (fate == CML_FATE_LOST) cml_rows_change(rows, light->w, 0, CML_BALANCE_LOST, CML_BALANCE_LOST);
}

/* Adds the light that was split off packet `index` at its launch to the detectors of all rows. */
static inline void cml_rows_place_split_off(const struct cml_world *world, const struct cml_row_packet *rows,
                                            cml_u64 index)
{
    const struct cml_light_out light = cml_light_split_off(world, index);
    const struct cml_row_light of = {rows, &light, 1};
    if (light.w) cml_rows_detect(world, &of);
}
