/* What a run says of itself: the .mco file, the summary for people, the JSON line for programs.
 * SPDX-License-Identifier: MIT */
#ifndef CML_REPORT_H
#define CML_REPORT_H

#include "mco.h"
#include "run.h"

struct cml_report {
    const struct cml_scene *scene;
    const struct cml_surface_set *surfaces;
    const struct cml_run_result *run;
    const struct cml_engine *engine;
    uint64_t seed;
    uint32_t run_index; /* from 0 */
    bool reentry;
    const char *output; /* path of the file written */
};

/* Scales the tallies as original MCML does and adds our own sections behind Tt_ra: boundaries, seed, engine,
 * standard errors, books. Nothing in it depends on time, threads or chunks but `user_time`. *mco is the
 * caller's to clear. */
CML_NODISCARD cml_status cml_report_mco(const struct cml_report *report, struct cml_mco *mco,
                                        struct cml_error *err);

/* One line per boundary, each behind the prefix: number, kind, primitives, reason. */
void cml_report_boundaries(FILE *stream, const char *prefix, const struct cml_scene *scene,
                           const struct cml_surface_set *surfaces);

/* Rsp, Rd, A, Tt with standard errors, books, speed. */
void cml_report_summary(FILE *stream, const struct cml_report *report);

/* One line per rank: packets, and where its time went; and the shares of all together. */
void cml_report_ranks(FILE *stream, const struct cml_run_result *run);

/* One object on one line, keys as documented in README. */
CML_NODISCARD cml_status cml_report_json(FILE *stream, const struct cml_report *report,
                                         struct cml_error *err);

const char *cml_version(void); /* "0.1.0 (git hash)" */

#endif
