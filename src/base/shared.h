/* Reference counts for objects that several holders share and nobody changes. Each count has memory of its
 * own. A NULL count belongs to an object with one holder. Several threads may share and end at once; only one
 * may begin.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stdlib.h>

/* Makes *users a reference count of one holder, unless *users is a count already. Returns CML_E_INPUT if
 * memory runs out. */
CML_NODISCARD static inline cml_status cml_share_begin(int **users, struct cml_error *err)
{
    if (*users) return CML_OK;
    *users = malloc(sizeof **users);
    if (!*users) return cml_fail_memory(err, sizeof **users, "a count of references");
    **users = 1;
    return CML_OK;
}

/* Adds one holder to the reference count of a shared object. */
static inline void cml_share(int *users)
{
    if (users) __atomic_add_fetch(users, 1, __ATOMIC_RELAXED);
}

/* Removes one holder from the reference count of a shared object. Returns true for the last holder, who must
 * free the object. */
static inline bool cml_share_end(int *users)
{
    if (users && __atomic_sub_fetch(users, 1, __ATOMIC_ACQ_REL) > 0) return false;
    free(users);
    return true;
}
