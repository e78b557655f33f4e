/* SPDX-License-Identifier: MIT */
#include "run/crosscheck/crosscheck.h"

#include "base/significance.h"
#include "tally/deal.h"
#include "types.h"

#include <math.h>
#include <stdlib.h>

/* packets compared at a time: some MiB of records, and enough work for a device */
#define PACKETS_AT_ONCE 16384

/* Sums of a difference d and of d^2. */
struct moments {
    double sum, squares;
};

/* State of the first half of a cross-check, which compares fates packet by packet. Index: the side. */
struct fates {
    const struct cml_check_setup *setup;
    void *engines[CML_CHECK_MOST_SIDES];
    struct cml_fate_record *records[CML_CHECK_MOST_SIDES]; /* [PACKETS_AT_ONCE] of each side */
    struct moments moments[CML_CHECK_MOST_SIDES][CML_NUM_TOTALS];
    uint64_t equal[CML_CHECK_MOST_SIDES];
};

/* True if two packets ended alike after the same number of steps. Positions and weights may differ in their
 * last bits, because the sides compute the same geometry in another order or precision. */
static bool same_fate(const struct cml_fate_record *a, const struct cml_fate_record *b)
{
    return a->fate == b->fate && a->interactions == b->interactions &&
           a->boundary_events == b->boundary_events;
}

/* Returns how much a packet adds to a total, as a share of a packet. */
static double share_of(const struct cml_fate_record *record, int total)
{
    static const int fate_of[CML_NUM_TOTALS] = {[CML_TOTAL_SPECULAR] = CML_FATE_SPECULAR,
                                                [CML_TOTAL_REFLECTED] = CML_FATE_REFLECTED,
                                                [CML_TOTAL_TRANSMITTED] = CML_FATE_TRANSMITTED};
    if (total == CML_TOTAL_ABSORBED) return record->absorbed;
    if (total == CML_TOTAL_BACKING) return record->backing;
    if (total == CML_TOTAL_FACE) return record->face;
    const double split_off = total == CML_TOTAL_SPECULAR ? record->specular : 0;
    return split_off + (record->fate == fate_of[total] ? record->weight * CML_WEIGHT_UNIT : 0);
}

/* Compares one packet of all sides with the first. Differences of totals are summed for every packet, because
 * weights may differ even where fates are equal. */
static void compare_packet(struct fates *fates, uint64_t photon, size_t place)
{
    struct cml_fate_record records[CML_CHECK_MOST_SIDES];
    bool differs = false;
    records[0] = fates->records[0][place];
    for (int s = 1; s < fates->setup->num_sides; s++) {
        records[s] = fates->records[s][place];
        const bool equal = same_fate(&records[0], &records[s]);
        fates->equal[s] += equal;
        differs |= !equal;
        for (int t = 0; t < CML_NUM_TOTALS; t++) {
            const double d = share_of(&records[s], t) - share_of(&records[0], t);
            fates->moments[s][t].sum += d;
            fates->moments[s][t].squares += d * d;
        }
    }
    if (differs && fates->setup->on_difference)
        fates->setup->on_difference(fates->setup->context, photon, records);
}

/* Lets all sides fly a range before it is compared, so that memory does not grow with the number of photons.
 */
static cml_status compare_range(struct fates *fates, uint64_t first, uint64_t count, struct cml_error *err)
{
    const struct cml_check_setup *setup = fates->setup;
    for (int s = 0; s < setup->num_sides; s++)
        CML_TRY(setup->sides[s].engine->fates(fates->engines[s], first, count, fates->records[s], err));
    for (uint64_t i = 0; i < count; i++) compare_packet(fates, first + i, (size_t)i);
    return CML_OK;
}

/* Opens all sides. After a failure close_sides closes those that were opened; the others are null pointers.
 */
static cml_status open_sides(struct fates *fates, struct cml_error *err)
{
    const struct cml_check_setup *setup = fates->setup;
    for (int s = 0; s < setup->num_sides; s++) {
        const struct cml_check_side *side = &setup->sides[s];
        CML_TRY(cml_zeros(&fates->records[s], PACKETS_AT_ONCE, sizeof *fates->records[s], "fates", err));
        CML_TRY(side->engine->open(setup->scene, side->surfaces, &setup->options, &fates->engines[s], err));
    }
    return CML_OK;
}

/* Closes the engines that were compared, and frees their records. */
static void close_sides(struct fates *fates)
{
    for (int s = 0; s < fates->setup->num_sides; s++) {
        fates->setup->sides[s].engine->close(fates->engines[s]);
        free(fates->records[s]);
    }
}

/* Returns mean, standard error and z of paired differences. Most packets of two sides are identical, so the
 * standard error of the mean difference is far below that of either total, and small errors of a geometry
 * show. */
static struct cml_check_total total_of(const struct moments *moments, double n)
{
    struct cml_check_total total = {.mean = moments->sum / n};
    const double variance = n > 1 ? (moments->squares - moments->sum * total.mean) / (n - 1) / n : 0;
    total.error = variance > 0 ? sqrt(variance) : 0;
    total.z = total.error > 0 ? total.mean / total.error : 0;
    return total;
}

/* Compares `count` packets of one beam from index `first` on. */
static cml_status compare_beam(struct fates *fates, uint64_t first, uint64_t count, struct cml_error *err)
{
    for (uint64_t done = 0; done < count; done += PACKETS_AT_ONCE)
        CML_TRY(compare_range(fates, first + done,
                              count - done < PACKETS_AT_ONCE ? count - done : PACKETS_AT_ONCE, err));
    return CML_OK;
}

/* Compares the packets of all beams, each with its share of the photons. */
static cml_status compare_beams(struct fates *fates, struct cml_error *err)
{
    const struct cml_scene *scene = fates->setup->scene;
    CML_FREED uint64_t *number = NULL;
    CML_TRY(cml_zeros(&number, (size_t)scene->num_beams, sizeof *number, "the beams", err));
    CML_TRY(cml_deal_numbers(scene->shares, scene->num_beams, fates->setup->photons, number, err));
    for (int k = 0; k < scene->num_beams; k++)
        CML_TRY(compare_beam(fates, (uint64_t)k << CML_SOURCE_SHIFT, number[k], err));
    return CML_OK;
}

/* Compares the packets of all sides: equal fates and differences of totals, into pairs[1..]. */
static cml_status compare_fates(const struct cml_check_setup *setup, struct cml_check_pair *pairs,
                                struct cml_error *err)
{
    const int totals =
        CML_TOTALS + (setup->scene->backing.kind != CML_BACKING_NONE) + (setup->scene->num_contacts > 0);
    struct fates fates = {.setup = setup};
    cml_status status = open_sides(&fates, err);
    if (status == CML_OK) status = compare_beams(&fates, err);
    for (int s = 1; s < setup->num_sides; s++) {
        pairs[s] = (struct cml_check_pair){.equal = fates.equal[s], .values = totals};
        for (int t = 0; t < CML_NUM_TOTALS; t++)
            pairs[s].total[t] = total_of(&fates.moments[s][t], (double)setup->photons);
    }
    close_sides(&fates);
    return status;
}

/* Returns a - b of two unsigned sums as a number with a sign. */
static double difference(cml_u128 a, cml_u128 b)
{
    return a >= b ? (double)(a - b) : -(double)(b - a);
}

/* Returns z of bin i of profile[64][n], result a against result b. The mean of the 64 batches' differences
 * over its standard error is a Student deviate of 63 degrees of freedom (Student 1908, Biometrika 6, 1),
 * which is turned into the normal deviate of the same tail. 0 when all batches agree. */
static double bin_z(const cml_u128 *a, const cml_u128 *b, int n, int i)
{
    struct moments moments = {0, 0};
    for (int batch = 0; batch < CML_NUM_BATCHES; batch++) {
        const size_t at = (size_t)batch * (size_t)n + (size_t)i;
        const double d = difference(a[at], b[at]);
        moments.sum += d;
        moments.squares += d * d;
    }
    return cml_normal_of_student(total_of(&moments, CML_NUM_BATCHES).z, CML_NUM_BATCHES - 1);
}

/* Compares two profiles[64][n] and keeps the bin with the largest |z| so far. A profile that one result lacks
 * is left out. */
static void compare_profile(const char *name, const cml_u128 *a, const cml_u128 *b, int n,
                            struct cml_check_pair *pair)
{
    if (!a || !b) return;
    pair->values += n;
    for (int i = 0; i < n; i++) {
        const double z = bin_z(a, b, n, i);
        if (fabs(z) <= fabs(pair->worst_z)) continue;
        pair->worst_z = z;
        pair->worst_profile = name;
        pair->worst_bin = i;
    }
}

/* Compares all profiles of two runs bin by bin, and keeps the bin that differs most. Grids over two
 * variables have no batches and are left out. */
static void compare_bins(const struct cml_result *first, const struct cml_result *other,
                         struct cml_check_pair *pair)
{
    const struct cml_tally_grid *grid = &first->grid;
    compare_profile("Rd_r", other->Rd_r, first->Rd_r, grid->nr, pair);
    compare_profile("Rd_a", other->Rd_a, first->Rd_a, grid->na, pair);
    compare_profile("Tt_r", other->Tt_r, first->Tt_r, grid->nr, pair);
    compare_profile("Tt_a", other->Tt_a, first->Tt_a, grid->na, pair);
    compare_profile("A_z", other->A_z, first->A_z, grid->nz, pair);
}

/* Decides whether a pair agrees. The largest of many |z| is large by chance, so its probability is corrected
 * for their number (Sidak 1967, J. Am. Stat. Assoc. 62, 626; conservative for correlated bins). */
static void judge(const struct cml_check_setup *setup, int s, struct cml_check_pair *pair)
{
    double worst = fabs(pair->worst_z);
    for (int t = 0; t < CML_NUM_TOTALS; t++) worst = fmax(worst, fabs(pair->total[t].z));
    const double share = (double)pair->equal / (double)setup->photons;
    pair->agrees = cml_sidak(cml_two_sided(worst), pair->values) >= CML_CHECK_LEVEL &&
                   (!setup->sides[s].same_geometry || share >= CML_CHECK_SHARE);
}

/* Flies the photons once more as a whole run of one side. Bins and batches come from this run, and it also
 * tests the engine's usual path, which the fates do not use. */
static cml_status run_side(const struct cml_check_setup *setup, int s, struct cml_run_result *run,
                           struct cml_error *err)
{
    const struct cml_run_setup flight = {.scene = setup->scene,
                                         .surfaces = setup->sides[s].surfaces,
                                         .engine = setup->sides[s].engine,
                                         .options = setup->options,
                                         .photons = setup->photons};
    CML_TRY(cml_run(&flight, run, err));
    return cml_run_verdict(setup->scene, &run->result, err);
}

/* Compares packets first, because there a fault can be pinned to a photon number; then whole runs, for the
 * bins. */
cml_status cml_crosscheck(const struct cml_check_setup *setup, struct cml_check_result *result,
                          struct cml_error *err)
{
    *result = (struct cml_check_result){0};
    cml_status status = compare_fates(setup, result->pairs, err);
    for (int s = 0; status == CML_OK && s < setup->num_sides; s++)
        status = run_side(setup, s, &result->runs[s], err);
    if (status != CML_OK) {
        cml_check_clear(result);
        return status;
    }
    for (int s = 1; s < setup->num_sides; s++) {
        compare_bins(&result->runs[0].result, &result->runs[s].result, &result->pairs[s]);
        judge(setup, s, &result->pairs[s]);
    }
    return CML_OK;
}

/* Frees the results of a cross-check. A run that was not made is zero, and freeing it does nothing. */
void cml_check_clear(struct cml_check_result *result)
{
    for (int s = 0; s < CML_CHECK_MOST_SIDES; s++) cml_run_result_free(&result->runs[s]);
    *result = (struct cml_check_result){0};
}
