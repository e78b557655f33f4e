/* Counts of references: of what is read or built once, never changed afterwards, and held by several. The
 * count stands in memory of its own; NULL is that of one holder who shares with none. For one thread.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stdlib.h>

/* Makes *users the count of one holder, unless it counts already. */
CML_NODISCARD static inline cml_status cml_share_begin(int **users, struct cml_error *err)
{
    if (*users) return CML_OK;
    *users = malloc(sizeof **users);
    if (!*users) return cml_fail_memory(err, sizeof **users, "a count of references");
    **users = 1;
    return CML_OK;
}

/* Counts one holder more of what is shared. */
static inline void cml_share(int *users)
{
    if (users) ++*users;
}

/* One holder less; true when it was the last one, who frees what was shared. */
static inline bool cml_share_end(int *users)
{
    if (users && --*users > 0) return false;
    free(users);
    return true;
}
