/* SPDX-License-Identifier: MIT */
#include "bundle.h"

#include "walk.h"

/* One binary for all machines: gcc compiles each pass for three levels of x86-64 and the loader picks one.
 * Tests define CML_ONE_LEVEL to have a level that the loader would not pick here. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) &&     \
    !defined(CML_ONE_LEVEL)
#define CML_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define CML_CLONES
#endif

CML_FN real cml_magnitude(real x)
{
    return x < 0 ? -x : x;
}

CML_CLONES cml_u64 cml_bundle_fly(struct cml_bundle *b)
{
    cml_u32 near_above = 0, near_below = 0;
#pragma omp simd reduction(| : near_above, near_below)
    for (int i = 0; i < CML_LANES; i++) {
        const real z = b->z[i], mfp = b->mfp[i], depth = b->tau[i] * mfp;
        const real s = mfp < CML_INFINITY ? depth : CML_INFINITY;
        /* the depth reached, widened by its rounding; NaN and infinity compare as near */
        const real step = s * b->uz[i], end = z + step;
        const real slack = 4 * CML_EPSILON * (cml_magnitude(z) + cml_magnitude(step));
        const real least = (z < end ? z : end) - slack, most = (z > end ? z : end) + slack;
        const int above = !(least > b->stop_above[i]), below = !(most < b->stop_below[i]);
        b->s[i] = s;
        b->task[i] = (above | below) ? CML_LANE_NEAR : CML_LANE_INTERACT;
        near_above |= (cml_u32)above << i;
        near_below |= (cml_u32)below << i;
    }
    return (cml_u64)near_below << CML_LANES | near_above;
}

CML_CLONES void cml_bundle_cross_planes(const struct cml_setup *setup, struct cml_bundle *b, int first)
{
    const struct cml_stream stream = setup->stream;
#pragma omp simd
    for (int i = first; i < first + CML_HALF; i++) {
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]}, up = {0, 0, -1};
        const real z = b->z[i], s = b->s[i], tau = b->tau[i];
        const real plane_above = b->plane_above[i], plane_below = b->plane_below[i];
        const real n1 = b->n[i], n_above = b->n_above[i], n_below = b->n_below[i];
        const int task = b->task[i], straight = b->straight[i], above = u.z < 0;
        const real plane = above ? plane_above : plane_below, n2 = above ? n_above : n_below;
        const real t = (plane - z) / u.z, ahead = t > 0 ? t : (real)0;
        const int mine = task == CML_LANE_NEAR, hit = mine & (u.z != 0) & (t < s);
        const real left = tau - ahead * b->mut[i], tau_left = left > 0 ? left : (real)0;
        const struct cml_block draw =
            cml_threefry(stream, b->index_low[i], b->index_high[i], b->crossings[i], CML_PURPOSE_BOUNDARY);
        const real side = above ? (real)1 : (real)-1;
        int refracted;
        const struct cml_vec v =
            cml_boundary_direction(u, up, side, n1, n2, cml_uniform(draw.w[0]), &refracted);
        const int matched = n1 == n2, turn = hit & !matched, through = matched | refracted;
        const int crossed = through ? CML_LANE_TRANSMITTED : CML_LANE_REFLECTED;
        const int missed = s < CML_INFINITY ? CML_LANE_INTERACT : CML_LANE_NOWHERE;
        const int event = hit ? crossed : missed;
        const real t_hit = hit ? ahead : (real)0, z_hit = above ? (real)0 : plane_below;
        b->x[i] += t_hit * u.x;
        b->y[i] += t_hit * u.y;
        b->z[i] = hit ? z_hit : z;
        b->s[i] = hit ? (real)0 : s;
        b->tau[i] = hit ? tau_left : tau;
        b->ux[i] = turn ? v.x : u.x;
        b->uy[i] = turn ? v.y : u.y;
        b->uz[i] = turn ? v.z : u.z;
        b->crossings[i] += (cml_u32)turn;
        b->bounces[i] += (cml_u32)hit;
        b->boundary_events[i] += (cml_u32)hit;
        b->straight[i] = hit ? matched : straight;
        b->task[i] = mine ? event : task;
    }
}

/* What the interaction of one lane deposits: as cml_absorbed_part. */
CML_FN cml_u32 cml_lane_deposit(cml_u32 w, real absorb, cml_u32 word)
{
    const real weight = (real)w;
    const real part = weight * absorb + ((real)(word & 255u) + (real)0.5) * (real)0.00390625;
    const int partly = (absorb < 1) & (part < weight);
    const cml_u32 some = (cml_u32)(partly ? part : (real)0);
    return partly ? some : w;
}

/* Cell of A_rz at a position from the scene's axis: as cml_deposit. *edge: it lies beyond the grid and was
 * clamped. */
CML_FN int cml_lane_cell(const struct cml_setup *setup, real x, real y, real depth, int *edge)
{
    const real bins_r = (real)setup->nr, bins_z = (real)setup->nz;
    const real r = CML_SQRT(x * x + y * y) * setup->per_dr, z = depth * setup->per_dz;
    const real r_in = r < bins_r ? r : bins_r - 1, z_low = z >= 0 ? z : (real)0,
               z_in = z_low < bins_z ? z_low : bins_z - 1;
    *edge = !((r < bins_r) & (z >= 0) & (z < bins_z));
    return (int)r_in * setup->nz + (int)z_in;
}

CML_CLONES int cml_bundle_interact(const struct cml_setup *shared, struct cml_bundle *b, int first)
{
    const struct cml_setup setup = *shared; /* a copy that stores into the bundle cannot change */
    int flags = 0;
#pragma omp simd reduction(| : flags)
    for (int i = first; i < first + CML_HALF; i++) {
        const int mine = b->task[i] == CML_LANE_INTERACT;
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]}, from = {b->x[i], b->y[i], b->z[i]};
        const struct cml_vec p = cml_along(from, b->s[i], u);
        b->x[i] = p.x;
        b->y[i] = p.y;
        b->z[i] = p.z;
        const cml_u32 w = b->w[i], word = b->draw2[i], part = cml_lane_deposit(w, b->absorb[i], word);
        const cml_u32 dw = mine ? part : 0u;
        int edge;
        const int cell = cml_lane_cell(&setup, p.x + setup.x0, p.y + setup.y0, p.z + b->depth[i], &edge);
        b->dw[i] = dw;
        b->w[i] = w - dw;
        b->deposited[i] += dw;
        b->cell[i] = setup.tally_absorption ? cell : 0;
        real ct, st, cp, sp;
        cml_henyey_greenstein(b->g[i], cml_uniform_symmetric(b->draw1[i]), &ct, &st);
        cml_circle_point(word, &cp, &sp);
        const struct cml_vec v = cml_spin(u, ct, st, cp, sp);
        b->ux[i] = mine ? v.x : u.x;
        b->uy[i] = mine ? v.y : u.y;
        b->uz[i] = mine ? v.z : u.z;
        b->bounces[i] = mine ? 0u : b->bounces[i];
        b->on_boundary[i] = mine ? -1 : b->on_boundary[i];
        b->lot[i] = b->draw3[i];
        b->interactions[i] += (cml_u32)mine;
        const struct cml_block draw = cml_threefry(setup.stream, b->index_low[i], b->index_high[i],
                                                   b->interactions[i], CML_PURPOSE_INTERACTION);
        const real tau = -cml_log(cml_uniform(draw.w[0]));
        b->tau[i] = mine ? tau : b->tau[i];
        b->draw1[i] = draw.w[1]; /* a lane that did not interact gets the same block again */
        b->draw2[i] = draw.w[2];
        b->draw3[i] = draw.w[3];
        const int look =
            ((edge & setup.tally_absorption) ? CML_FLAG_EDGE : 0) | (cml_dot(v, v) < 2 ? 0 : CML_FLAG_NAN) |
            (w - dw < CML_ROULETTE_THRESHOLD ? CML_FLAG_ROULETTE : 0) | (draw.w[0] == 0u ? CML_FLAG_TAIL : 0);
        b->flag[i] = mine ? look : 0;
        flags |= b->flag[i];
    }
    return flags;
}

CML_CLONES int cml_bundle_draw(const struct cml_setup *setup, struct cml_bundle *b)
{
    const struct cml_stream stream = setup->stream;
    int flags = 0;
#pragma omp simd reduction(| : flags)
    for (int i = 0; i < CML_LANES; i++) {
        const int mine = b->task[i] == CML_LANE_LAUNCHED;
        const struct cml_block draw = cml_threefry(stream, b->index_low[i], b->index_high[i],
                                                   b->interactions[i], CML_PURPOSE_INTERACTION);
        const real tau = -cml_log(cml_uniform(draw.w[0]));
        b->tau[i] = mine ? tau : b->tau[i];
        b->draw1[i] = draw.w[1];
        b->draw2[i] = draw.w[2];
        b->draw3[i] = draw.w[3];
        b->flag[i] = (mine & (draw.w[0] == 0u)) ? CML_FLAG_TAIL : 0;
        flags |= b->flag[i];
    }
    return flags;
}
