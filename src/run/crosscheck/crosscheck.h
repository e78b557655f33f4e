/* The same photon indices flown in several ways, compared packet by packet and bin by bin with the first way.
 * A packet's random numbers belong to its index, so the ways differ by geometry and rounding only, and
 * differences are judged by their own spread ("paired"): over packets for the totals, over the 64 batches for
 * the bins. SPDX-License-Identifier: MIT */
#pragma once

#include "run/run.h"

#define CML_CHECK_MOST_SIDES 3
#define CML_CHECK_SHARE                                                                                      \
    0.9999                   /* of packets that must have equal fates and steps where the geometry is equal */
#define CML_CHECK_LEVEL 1e-4 /* chance that two ways of the same physics are found to disagree */

/* One way of flying. */
struct cml_check_side {
    const char *name;
    const struct cml_engine *engine;
    const struct cml_surface_set *surfaces;
    bool same_geometry; /* as the first side: CML_CHECK_SHARE is demanded */
};

/* Mean difference to the first side per packet, as a share of a packet; z = mean / error, 0 when both are. */
struct cml_check_total {
    double mean, error, z;
};

struct cml_check_pair {
    uint64_t equal; /* packets of the same fate, interactions and boundary events */
    struct cml_check_total total[CML_NUM_TOTALS];
    const char *worst_profile; /* "Rd_r", ...; NULL when no bin differs */
    int worst_bin;
    double worst_z;
    int values;  /* totals and bins that were compared */
    bool agrees; /* share of equal packets where demanded, and the largest z for so many values */
};

/* A packet whose ways differ: records[num_sides]. */
typedef void cml_check_function(void *context, uint64_t photon, const struct cml_fate_record *records);

struct cml_check_setup {
    const struct cml_scene *scene;
    struct cml_engine_options options;
    uint64_t photons;
    int num_sides; /* 2..CML_CHECK_MOST_SIDES */
    struct cml_check_side sides[CML_CHECK_MOST_SIDES];
    cml_check_function *on_difference; /* NULL: not told */
    void *context;
};

struct cml_check_result {
    struct cml_run_result runs[CML_CHECK_MOST_SIDES];
    struct cml_check_pair pairs[CML_CHECK_MOST_SIDES]; /* [0] unused */
};

/* On failure *result is cleared. It is the caller's to clear (cml_check_clear). */
CML_NODISCARD cml_status cml_crosscheck(const struct cml_check_setup *setup, struct cml_check_result *result,
                                        struct cml_error *err);
void cml_check_clear(struct cml_check_result *result);
