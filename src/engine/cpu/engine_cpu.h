/* The engine `cpu`: single precision, threads, bundles of packets in vector loops. It is compiled for several
 * levels of the processor, which differ only in speed. The best level that this machine can run is chosen
 * when the program starts.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/engine.h"

/* Returns the engine for the best level of the processor that this machine has. */
const struct cml_engine *cml_engine_cpu(void);

#define CML_CPU_LEVELS 3
struct cml_cpu_level {
    const char *name; /* "x86-64-v4", "x86-64-v3", "baseline" */
    const struct cml_engine *engine;
};

/* Fills in the levels that this machine can run, the best one first, and returns their number. */
int cml_cpu_levels(struct cml_cpu_level levels[CML_CPU_LEVELS]);
