/* Hooks through which a bench may look into the CPU engine. Without a bench they compile to nothing. A bench
 * defines the hooks that it needs before it includes engine_cpu_level.c: bench/parts/busy.c counts lanes,
 * bench/parts/curved.c takes times, bench/parts/asked.c counts hits.
 * SPDX-License-Identifier: MIT */
#pragma once

/* Parts of the work at curved boundaries. HITS lies within CURVED, REFLECT within HITS, INTERVALS within
 * CURVED. */
enum cml_hook_part {
    CML_HOOK_CLASSIFY,  /* finds the lanes that can meet a curved boundary at all */
    CML_HOOK_CURVED,    /* all further work for lanes that can meet a curved boundary */
    CML_HOOK_INTERVALS, /* finds the parts of paths on which lanes can meet a curved boundary */
    CML_HOOK_HITS,      /* handles lanes that have met a curved boundary */
    CML_HOOK_REFLECT,   /* roots and normals of rings, reflection and refraction */
    CML_HOOK_PARTS
};

/* Loops whose lanes can be counted. */
enum cml_hook_loop { CML_HOOK_LAUNCH, CML_HOOK_PASS, CML_HOOK_PLANES, CML_HOOK_LOOPS };

/* Called at the beginning and at the end of a part. */
#ifndef CML_HOOK_BEGIN
#define CML_HOOK_BEGIN(part) ((void)(part))
#endif
#ifndef CML_HOOK_END
#define CML_HOOK_END(part) ((void)(part))
#endif

/* Called with the number of lanes that go through a loop. */
#ifndef CML_HOOK_LANES
#define CML_HOOK_LANES(loop, lanes) ((void)(loop))
#endif

/* Called after a search on a curved boundary, which counts in CML_COUNT_QUERIES. met: 1 if it found a
 * crossing. */
#ifndef CML_HOOK_MET
#define CML_HOOK_MET(met) ((void)(met))
#endif
