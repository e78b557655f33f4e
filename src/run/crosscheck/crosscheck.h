/* A cross-check: flies the same photon indices in several ways ("sides"), and compares each side with the
 * first, packet by packet and bin by bin. The random numbers of a packet belong to its index, so sides differ
 * only by geometry and rounding. Differences are judged by their own spread ("paired"): over packets for the
 * totals, over the 64 batches for the bins. SPDX-License-Identifier: MIT */
#pragma once

#include "run/run.h"

#define CML_CHECK_MOST_SIDES 3
#define CML_CHECK_SHARE                                                                                      \
    0.9999 /* least share of packets with equal fates and steps, where the geometry is equal */
#define CML_CHECK_LEVEL 1e-4 /* probability that two ways of the same physics are found to disagree */

/* One way to fly the photons. */
struct cml_check_side {
    const char *name;
    const struct cml_engine *engine;
    const struct cml_surface_set *surfaces;
    bool same_geometry; /* the side has the geometry of the first side, so CML_CHECK_SHARE is demanded */
};

/* The difference of a total to the first side: mean per packet, as a share of a packet, its standard error,
 * and z = mean / error (0 where the error is 0). */
struct cml_check_total {
    double mean, error, z;
};

struct cml_check_pair {
    uint64_t equal; /* packets with the same fate, interactions and boundary events on both sides */
    struct cml_check_total total[CML_NUM_TOTALS];
    /* profile of the bin with the largest |z|, "Rd_r" ...; NULL when no bin differs */
    const char *worst_profile;
    int worst_bin;
    double worst_z;
    int values; /* number of totals and bins compared */
    /* the share of equal packets suffices where demanded, and the largest z is likely for so many values */
    bool agrees;
};

/* Called for a packet whose fates differ between sides: records[num_sides]. */
typedef void cml_check_function(void *context, uint64_t photon, const struct cml_fate_record *records);

struct cml_check_setup {
    const struct cml_scene *scene;
    struct cml_engine_options options;
    uint64_t photons;
    int num_sides; /* 2..CML_CHECK_MOST_SIDES */
    struct cml_check_side sides[CML_CHECK_MOST_SIDES];
    cml_check_function *on_difference; /* called for each packet that differs; NULL: none */
    void *context;
};

struct cml_check_result {
    struct cml_run_result runs[CML_CHECK_MOST_SIDES];
    struct cml_check_pair pairs[CML_CHECK_MOST_SIDES]; /* differences to the first side; [0] is unused */
};

/* Runs the cross-check. The caller clears *result (cml_check_clear); after a failure it is cleared already.
 */
CML_NODISCARD cml_status cml_crosscheck(const struct cml_check_setup *setup, struct cml_check_result *result,
                                        struct cml_error *err);
void cml_check_clear(struct cml_check_result *result);
