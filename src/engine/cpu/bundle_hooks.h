/* Where a bench may look into the CPU engine. Without a bench the hooks compile to nothing. A bench defines
 * those it needs before it includes engine_cpu_level.c: bench/parts/busy.c counts lanes, bench/parts/curved.c
 * takes times, bench/parts/asked.c counts hits. SPDX-License-Identifier: MIT */
#pragma once

/* Parts of the work at curved boundaries; HITS lies within CURVED, REFLECT within HITS, INTERVALS within
 * CURVED. */
enum cml_hook_part {
    CML_HOOK_CLASSIFY,  /* which lanes can meet a curved boundary at all */
    CML_HOOK_CURVED,    /* all that is done for those that can */
    CML_HOOK_INTERVALS, /* on which part of their paths */
    CML_HOOK_HITS,      /* what becomes of lanes that have met one */
    CML_HOOK_REFLECT,   /* roots and normals of rings, reflection and refraction */
    CML_HOOK_PARTS
};

/* Loops whose lanes can be counted. */
enum cml_hook_loop { CML_HOOK_LAUNCH, CML_HOOK_PASS, CML_HOOK_PLANES, CML_HOOK_LOOPS };

/* A part begins, or ends. */
#ifndef CML_HOOK_BEGIN
#define CML_HOOK_BEGIN(part) ((void)(part))
#endif
#ifndef CML_HOOK_END
#define CML_HOOK_END(part) ((void)(part))
#endif

/* So many lanes go through a loop. */
#ifndef CML_HOOK_LANES
#define CML_HOOK_LANES(loop, lanes) ((void)(loop))
#endif

/* A query of a curved boundary, which counts in CML_COUNT_QUERIES, has met it, if `met`. */
#ifndef CML_HOOK_MET
#define CML_HOOK_MET(met) ((void)(met))
#endif
