/* Levels of the processor: the x86-64 psABI's, as far as our code can use them. Vector loops are compiled
 * once for each (CML_LEVEL, see CMakeLists.txt), so that one binary is fast on all machines. Only
 * instructions differ; results are the same to the last bit. SPDX-License-Identifier: MIT */
#pragma once

/* What this machine runs: 0 baseline, 3 or 4; 0 where the program has no other level. */
int cml_processor_level(void);

/* A name of the level that a file is compiled for. */
#define CML_PASTE(a, b) a##b
#define CML_LEVELED(name, level) CML_PASTE(name, level)
