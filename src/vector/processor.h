/* Levels of the processor: those of the x86-64 psABI that our code uses. Vector loops are compiled once for
 * each level (CML_LEVEL, see CMakeLists.txt), so that one binary is fast on all machines. The levels differ
 * only in instructions; results are the same to the last bit.
 * SPDX-License-Identifier: MIT */
#pragma once

/* Returns the highest level that this machine runs: 0 baseline, 3 or 4. Returns 0 if the program was built
 * without other levels. */
int cml_processor_level(void);

/* The name of a function for the level that a file is compiled for. */
#define CML_PASTE(a, b) a##b
#define CML_LEVELED(name, level) CML_PASTE(name, level)
