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

CML_CLONES cml_u64 cml_bundle_fly(struct cml_bundle *b)
{
    cml_u32 planes = 0, exceptions = 0;
#pragma omp simd reduction(| : planes, exceptions)
    for (int i = 0; i < CML_LANES; i++) {
        const real z = b->z[i], uz = b->uz[i], tau = b->tau[i], mut = b->mut[i];
        const real plane_above = b->plane_above[i], plane_below = b->plane_below[i];
        const real depth = tau / mut;
        const real free_path = mut > 0 ? depth : CML_INFINITY;
        const real plane = uz < 0 ? plane_above : plane_below;
        const real t = (plane - z) / uz;
        const int hit = (uz != 0) & (t < free_path);
        const real ahead = t > 0 ? t : (real)0;
        const real s = hit ? ahead : free_path;
        /* the depth reached, widened by its rounding; NaN and infinity compare as "may meet anything" */
        const real step = s * uz, end = z + step;
        const real slack = 4 * CML_EPSILON * (cml_magnitude(z) + cml_magnitude(step));
        const real least = (z < end ? z : end) - slack, most = (z > end ? z : end) + slack;
        const int clear = (least > b->field_above[i]) & (most < b->field_below[i]) & (s < CML_INFINITY);
        const int towards = uz < 0 ? CML_LANE_PLANE_ABOVE : CML_LANE_PLANE_BELOW;
        const int task = hit ? towards : CML_LANE_INTERACT;
        b->s[i] = clear ? s : free_path;
        b->task[i] = clear ? task : CML_LANE_EXCEPTION;
        planes |= (cml_u32)(clear & hit) << i;
        exceptions |= (cml_u32)!clear << i;
    }
    return (cml_u64)exceptions << CML_LANES | planes;
}

CML_CLONES void cml_bundle_cross_planes(const struct cml_setup *setup, struct cml_bundle *b, int first)
{
    const struct cml_stream stream = setup->stream;
#pragma omp simd
    for (int i = first; i < first + CML_HALF; i++) {
        const int above = b->task[i] == CML_LANE_PLANE_ABOVE,
                  hit = above | (b->task[i] == CML_LANE_PLANE_BELOW);
        const real n1 = b->n[i], n2 = above ? b->n_above[i] : b->n_below[i];
        const real left = b->tau[i] - b->s[i] * b->mut[i];
        const struct cml_block draw =
            cml_threefry(stream, b->index_low[i], b->index_high[i], b->crossings[i], CML_PURPOSE_BOUNDARY);
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]}, up = {0, 0, -1};
        int refracted;
        const struct cml_vec v = cml_boundary_direction(u, up, above ? (real)1 : (real)-1, n1, n2,
                                                        cml_uniform(draw.w[0]), &refracted);
        const int matched = n1 == n2, turn = hit & !matched;
        const int transmitted = matched | refracted;
        b->x[i] = hit ? b->x[i] + b->s[i] * u.x : b->x[i];
        b->y[i] = hit ? b->y[i] + b->s[i] * u.y : b->y[i];
        b->z[i] = hit ? (above ? (real)0 : b->plane_below[i]) : b->z[i];
        b->tau[i] = hit ? (left > 0 ? left : (real)0) : b->tau[i];
        b->ux[i] = turn ? v.x : u.x;
        b->uy[i] = turn ? v.y : u.y;
        b->uz[i] = turn ? v.z : u.z;
        b->crossings[i] += (cml_u32)turn;
        b->bounces[i] += (cml_u32)hit;
        b->boundary_events[i] += (cml_u32)hit;
        b->straight[i] = hit ? matched : b->straight[i];
        b->task[i] = hit ? (transmitted ? CML_LANE_TRANSMITTED : CML_LANE_REFLECTED) : b->task[i];
    }
}

/* A bin of [0, bins), clamped; the comparison comes first, so that no value out of range is ever converted.
 */
CML_FN int cml_clamped_bin(real bin, int bins, int *over)
{
    *over = !(bin < (real)bins);
    const real inside = *over ? (real)0 : bin;
    return *over ? bins - 1 : (int)inside;
}

CML_CLONES int cml_bundle_interact(const struct cml_setup *setup, struct cml_bundle *b)
{
    const int nr = setup->nr, nz = setup->nz, tally = setup->tally_absorption;
    const real x0 = setup->x0, y0 = setup->y0, per_dr = setup->per_dr, per_dz = setup->per_dz;
    int flags = 0;
#pragma omp simd reduction(| : flags)
    for (int i = 0; i < CML_LANES; i++) {
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]}, from = {b->x[i], b->y[i], b->z[i]};
        const struct cml_vec p = cml_along(from, b->s[i], u);
        const int mine = b->task[i] == CML_LANE_INTERACT;
        const int leaked = mine & ((p.z < b->leak_above[i]) | (p.z > b->leak_below[i]));
        const int act = mine & !leaked;
        const cml_u32 w = b->w[i], word = b->draw[2][i];
        const real part = (real)w * b->absorb[i] + ((real)(word & 255u) + (real)0.5) * (real)0.00390625;
        const cml_u32 some = (cml_u32)(part < (real)w ? part : (real)0);
        const cml_u32 dw = act ? (b->absorb[i] >= 1 || !(part < (real)w) ? w : some) : 0u;
        const real x = p.x + x0, y = p.y + y0, depth = (p.z + b->depth[i]) * per_dz;
        int over_r, over_z;
        const int above = !(depth >= 0);
        const int ir = cml_clamped_bin(CML_SQRT(x * x + y * y) * per_dr, nr, &over_r);
        const int iz = cml_clamped_bin(above ? (real)0 : depth, nz, &over_z);
        real ct, st, cp, sp;
        cml_henyey_greenstein(b->g[i], cml_uniform_symmetric(b->draw[1][i]), &ct, &st);
        cml_circle_point(word, &cp, &sp);
        const struct cml_vec v = cml_spin(u, ct, st, cp, sp);
        const int number = cml_dot(v, v) < 2;
        b->x[i] = mine ? p.x : from.x;
        b->y[i] = mine ? p.y : from.y;
        b->z[i] = mine ? p.z : from.z;
        b->ux[i] = act ? v.x : u.x;
        b->uy[i] = act ? v.y : u.y;
        b->uz[i] = act ? v.z : u.z;
        b->dw[i] = dw;
        b->w[i] = w - dw;
        b->deposited[i] += dw;
        b->cell[i] = tally ? ir * nz + iz : 0;
        b->bounces[i] = mine ? 0u : b->bounces[i];
        b->on_boundary[i] = mine ? -1 : b->on_boundary[i];
        b->interactions[i] += (cml_u32)act;
        const int bins = tally ? (over_r ? CML_FLAG_OVERFLOW_R : 0) | (over_z ? CML_FLAG_OVERFLOW_Z : 0) |
                                     (above ? CML_FLAG_ABOVE : 0)
                               : 0;
        const int roulette = w - dw < CML_ROULETTE_THRESHOLD ? CML_FLAG_ROULETTE : 0;
        const int flag =
            (act ? bins | roulette | (number ? 0 : CML_FLAG_NAN) : 0) | (leaked ? CML_FLAG_LEAKED : 0);
        b->flag[i] = flag;
        flags |= flag;
    }
    return flags;
}

CML_CLONES cml_u32 cml_bundle_draw(const struct cml_setup *setup, struct cml_bundle *b)
{
    const struct cml_stream stream = setup->stream;
    int zero = 0;
#pragma omp simd reduction(| : zero)
    for (int i = 0; i < CML_LANES; i++) {
        const int mine = (b->task[i] == CML_LANE_INTERACT) | (b->task[i] == CML_LANE_LAUNCHED);
        const struct cml_block draw = cml_threefry(stream, b->index_low[i], b->index_high[i],
                                                   b->interactions[i], CML_PURPOSE_INTERACTION);
        const real tau = -cml_log(cml_uniform(draw.w[0]));
        b->tau[i] = mine ? (real)0 + tau : b->tau[i];
        b->draw[0][i] = mine ? draw.w[0] : b->draw[0][i];
        b->draw[1][i] = mine ? draw.w[1] : b->draw[1][i];
        b->draw[2][i] = mine ? draw.w[2] : b->draw[2][i];
        b->draw[3][i] = mine ? draw.w[3] : b->draw[3][i];
        zero |= mine & (draw.w[0] == 0u);
    }
    if (!zero) return 0;
    cml_u32 mask = 0;
    for (int i = 0; i < CML_LANES; i++) {
        const int mine = (b->task[i] == CML_LANE_INTERACT) | (b->task[i] == CML_LANE_LAUNCHED);
        if (mine && b->draw[0][i] == 0u) mask |= (cml_u32)1 << i;
    }
    return mask;
}
