/* SPDX-License-Identifier: MIT */
#include "engine.h"

#include "types.h"

#include <stddef.h>
#include <string.h>

static const struct cml_engine *const engines[] = {&cml_engine_cpu, &cml_engine_reference, NULL};

const struct cml_engine *cml_engine_find(const char *name)
{
    for (int i = 0; engines[i]; i++)
        if (strcmp(engines[i]->name, name) == 0) return engines[i];
    return NULL;
}

const char *cml_fate_name(int fate)
{
    static const char *const names[CML_NUM_FATES] = {"alive",    "absorbed", "reflected", "transmitted",
                                                     "specular", "trapped",  "lost"};
    return names[fate];
}

const char *cml_lost_cause_name(int cause)
{
    static const char *const names[CML_NUM_LOST_CAUSES] = {"not lost", "no surface found", "not a number",
                                                           "stuck", "leaked through a boundary"};
    return names[cause];
}
