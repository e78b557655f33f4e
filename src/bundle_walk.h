/* Flies photons through a bundle until there are no more.
 * SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_WALK_H
#define CML_BUNDLE_WALK_H

#include "bundle.h"
#include "tally.h"

/* Hands out the next range [*first, *first + *count) of photon indices; false when there is none. */
struct cml_range_source {
    int (*next)(void *context, uint64_t *first, uint64_t *count);
    void *context;
};

/* Everything goes into `tally`. The bundle is the thread's scratch memory. */
void cml_bundle_walk(const struct cml_world *world, struct cml_bundle *bundle,
                     const struct cml_range_source *source, struct cml_tally *tally);

#endif
