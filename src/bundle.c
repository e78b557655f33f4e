/* SPDX-License-Identifier: MIT */
#include "bundle.h"

#include "walk.h"

/* One binary for all machines: gcc compiles each pass for three levels of x86-64 and the loader picks one. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define CML_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define CML_CLONES
#endif

CML_FN real cml_magnitude(real x)
{
    return x < 0 ? -x : x;
}

CML_CLONES cml_u32 cml_bundle_fly(struct cml_bundle *b)
{
    cml_u32 near_lanes = 0;
#pragma omp simd reduction(| : near_lanes)
    for (int i = 0; i < CML_LANES; i++) {
        const real z = b->z[i], mfp = b->mfp[i], depth = b->tau[i] * mfp;
        const real s = mfp < CML_INFINITY ? depth : CML_INFINITY;
        /* the depth reached, widened by its rounding; NaN and infinity compare as near */
        const real step = s * b->uz[i], end = z + step;
        const real slack = 4 * CML_EPSILON * (cml_magnitude(z) + cml_magnitude(step));
        const real least = (z < end ? z : end) - slack, most = (z > end ? z : end) + slack;
        const int clear = (least > b->stop_above[i]) & (most < b->stop_below[i]);
        b->s[i] = s;
        b->task[i] = clear ? CML_LANE_INTERACT : CML_LANE_NEAR;
        near_lanes |= (cml_u32)!clear << i;
    }
    return near_lanes;
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

CML_CLONES int cml_bundle_interact(const struct cml_setup *setup, struct cml_bundle *b)
{
    const struct cml_stream stream = setup->stream;
    const int nz = setup->nz, tally = setup->tally_absorption;
    const real x0 = setup->x0, y0 = setup->y0, per_dr = setup->per_dr, per_dz = setup->per_dz;
    const real bins_r = (real)setup->nr, bins_z = (real)nz, last_r = bins_r - 1, last_z = bins_z - 1;
    int flags = 0;
#pragma omp simd reduction(| : flags)
    for (int i = 0; i < CML_LANES; i++) {
        const int mine = b->task[i] == CML_LANE_INTERACT;
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]}, from = {b->x[i], b->y[i], b->z[i]};
        const struct cml_vec p = cml_along(from, b->s[i], u);
        b->x[i] = p.x;
        b->y[i] = p.y;
        b->z[i] = p.z;
        /* drop: as cml_absorbed_part */
        const cml_u32 w = b->w[i], word = b->draw2[i];
        const real weight = (real)w;
        const real part = weight * b->absorb[i] + ((real)(word & 255u) + (real)0.5) * (real)0.00390625;
        const int partly = (b->absorb[i] < 1) & (part < weight);
        const cml_u32 some = (cml_u32)(partly ? part : (real)0);
        const cml_u32 dw = mine ? (partly ? some : w) : 0u;
        b->dw[i] = dw;
        b->w[i] = w - dw;
        b->deposited[i] += dw;
        /* its bin: as cml_deposit */
        const real x = p.x + x0, y = p.y + y0;
        const real r = CML_SQRT(x * x + y * y) * per_dr, z = (p.z + b->depth[i]) * per_dz;
        const real r_in = r < bins_r ? r : last_r, z_low = z >= 0 ? z : (real)0,
                   z_in = z_low < bins_z ? z_low : last_z;
        b->cell[i] = tally ? (int)r_in * nz + (int)z_in : 0;
        const int edge = tally & !((r < bins_r) & (z >= 0) & (z < bins_z));
        /* spin */
        real ct, st, cp, sp;
        cml_henyey_greenstein(b->g[i], cml_uniform_symmetric(b->draw1[i]), &ct, &st);
        cml_circle_point(word, &cp, &sp);
        const struct cml_vec v = cml_spin(u, ct, st, cp, sp);
        b->ux[i] = mine ? v.x : u.x;
        b->uy[i] = mine ? v.y : u.y;
        b->uz[i] = mine ? v.z : u.z;
        b->bounces[i] = mine ? 0u : b->bounces[i];
        b->on_boundary[i] = mine ? -1 : b->on_boundary[i];
        /* why somebody has to look */
        const int number = cml_dot(v, v) < 2;
        const int flag = mine ? (edge ? CML_FLAG_EDGE : 0) | (number ? 0 : CML_FLAG_NAN) |
                                    (w - dw < CML_ROULETTE_THRESHOLD ? CML_FLAG_ROULETTE : 0)
                              : 0;
        /* draw: the block of the next interaction */
        const cml_u32 event = b->interactions[i] + (cml_u32)mine;
        const struct cml_block draw =
            cml_threefry(stream, b->index_low[i], b->index_high[i], event, CML_PURPOSE_INTERACTION);
        const real tau = -cml_log(cml_uniform(draw.w[0]));
        b->lot[i] = b->draw3[i];
        b->interactions[i] = event;
        b->tau[i] = mine ? tau : b->tau[i];
        b->draw1[i] = draw.w[1];
        b->draw2[i] = draw.w[2];
        b->draw3[i] = draw.w[3];
        b->flag[i] = flag | (mine & (draw.w[0] == 0u) ? CML_FLAG_TAIL : 0);
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
        b->flag[i] = mine & (draw.w[0] == 0u) ? CML_FLAG_TAIL : 0;
        flags |= b->flag[i];
    }
    return flags;
}
