/* What a run says of itself: the .mco file, the summary for people, the JSON line for programs.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "exact/exact.h"
#include "result/outcome.h"
#include "result/timing.h"
#include "scene/flat_tail.h"
#include "surface/mean_depth.h"

struct cml_report {
    const struct cml_scene *scene;
    const struct cml_surface_set *surfaces;
    const struct cml_result *sums;
    const struct cml_timing *timing;
    const struct cml_provenance *provenance;
    char identity[CML_IDENTITY_SUM];  /* of the run */
    const char *command;              /* line, for provenance */
    int row;                          /* of a sweep, from 1; 0: of none */
    const struct cml_flat_tail *tail; /* of --aim; NULL: none */
    double flat_below;                /* a depth where --aim would save photons, cm; NaN: nowhere */
    int unseen; /* detector, from 1, that has seen nothing, and that --aim would send packets to; 0: none */
    const struct cml_exact *exact; /* totals by adding-doubling for summary and JSON; NULL: none */
    struct cml_outcome outcome;    /* of cml_report_write: what files, record and summary are made of */
    uint64_t covers; /* of cml_report_write: photons, the first or of several beams a sample, of which no
                      * saved packet is missing (cml_saved_covers), so that sums of rows over that number are
                      * estimates */
    bool classic;    /* the .mco ends with the sections of original MCML */
    int num_files;
    char **files; /* [num_files] paths written, the main result first */
};

/* What a file of a run holds, and of which detector or boundary, from 0. */
enum cml_report_content {
    CML_FILE_TABLE,    /* `path` (.mco) */
    CML_FILE_FIELDS,   /* STEM.h5 */
    CML_FILE_SAVED,    /* NAME.photons.h5 */
    CML_FILE_MAP,      /* STEM.map.vti */
    CML_FILE_VOLUME,   /* STEM.volume.vti */
    CML_FILE_DETECTOR, /* STEM.detector_<name>.vti */
    CML_FILE_BOUNDARY, /* STEM.boundary<b>.vtp */
    CML_FILE_BODIES,   /* STEM.bodies.vtp */
};
struct cml_report_file {
    enum cml_report_content content;
    int of;
    const char *path;
};
typedef cml_status cml_report_file_function(void *context, const struct cml_report_file *file,
                                            struct cml_error *err);

/* What the options of a run ask for, as far as its files depend on them. */
struct cml_report_asks {
    bool absorption; /* by place */
    bool scores;     /* derivatives or expected values, for which an .mco has no place */
};

/* Calls `each` for the files that a run leaves beside `path`, the main result first, until one fails.
 * surfaces: those that are planes have no file; NULL: not known, and all boundaries count. A program without
 * HDF5 leaves none of that kind. */
CML_NODISCARD cml_status cml_report_each_file(const struct cml_scene *scene,
                                              const struct cml_surface_set *surfaces,
                                              const struct cml_report_asks *asks, const char *path,
                                              cml_report_file_function *each, void *context,
                                              struct cml_error *err);

/* Writes all of them. Each file is the old or the complete new one at any moment. report->files lists them.
 * CML_E_IO when one could not be written; those before it are then there. */
CML_NODISCARD cml_status cml_report_write(struct cml_report *report, const char *path, struct cml_error *err);

/* Forgets the outcome and the list of files. */
void cml_report_clear(struct cml_report *report);

/* What a run leaves behind, once it is written; and the same of one that was finished before, as of a result
 * in `path`. *record is the caller's to clear. */
CML_NODISCARD cml_status cml_report_record(const struct cml_report *report, struct cml_record *record,
                                           struct cml_error *err);
CML_NODISCARD cml_status cml_report_record_again(const struct cml_scene *scene, const char *path,
                                                 const struct cml_record *before, struct cml_record *record,
                                                 struct cml_error *err);

/* Bytes that cml_report_write holds at its peak besides the results: most of them are the .h5 file. */
double cml_report_bytes(const struct cml_scene *scene, const struct cml_tally_grid *grid);

/* Names of the files beside the .mco: `path` without a final ".mco" or ".h5", then `suffix`. *result is the
 * caller's to free; CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_report_path(const char *path, const char *suffix, char **result,
                                         struct cml_error *err);

/* The file of saved packets beside the result `path`, and at most how many bytes of numbers it holds; *result
 * is the caller's to free. */
CML_NODISCARD cml_status cml_report_saved_path(const struct cml_scene *scene, const char *path, char **result,
                                               struct cml_error *err);
double cml_saved_file_bytes(const struct cml_saved_kind *kind);

/* Whom a description of the scene is for. People see files by their path as they were opened, and at most 20
 * bodies. Results hold all bodies, and checksums of all shapes; an .h5 names files as the scene does, so that
 * it does not depend on the folder from which the program was called. */
enum cml_report_reader { CML_READ_BY_PEOPLE, CML_READ_IN_MCO, CML_READ_IN_H5 };

/* One line per boundary, each behind the prefix: number, kind, primitives, reason, file; then one per body:
 * number, shape, host, medium, file. */
void cml_report_shapes(FILE *stream, const char *prefix, const struct cml_scene *scene,
                       const struct cml_surface_set *surfaces, enum cml_report_reader reader);

/* "disk", "ring", "rectangle" or "map"; a ring from 0 on is a disk. */
const char *cml_detector_word(const struct cml_detector_def *detector);

/* "above", "layer 1", "below" or "body 1". */
enum { CML_MEDIUM_NAME = 24 };
void cml_medium_name(const struct cml_scene *scene, int medium, char name[CML_MEDIUM_NAME]);

/* A line for every beam that stands in the file, behind the prefix; nothing for MCML's pencil beam. starts:
 * the medium that each starts in, said of those with z=; NULL: not known, not said. */
void cml_report_beams(FILE *stream, const char *prefix, const struct cml_scene *scene, const int *starts);

/* Prints beam k: its shape, where it starts, its light. */
void cml_report_beam(FILE *stream, const char *prefix, const struct cml_scene *scene, int k,
                     const int *starts);

/* A line per medium that does not scatter by Henyey and Greenstein's function, behind the prefix: "phase of
 * layer 1: gk 0.9 0.5". */
void cml_report_phases(FILE *stream, const char *prefix, const struct cml_scene *scene,
                       enum cml_report_reader reader);

/* "mirror", "lambertian", "metal". */
const char *cml_backing_word(enum cml_backing_kind kind);

/* A line per detector, behind the prefix: "detector NAME: ring of ...". People see the first of many. */
void cml_report_detectors(FILE *stream, const char *prefix, const struct cml_scene *scene,
                          enum cml_report_reader reader);

/* " 0.318400 +- 0.000300", " 1.234e-07 +- 1.1e-08" of what is small. */
void cml_report_estimate(FILE *stream, double value, double error);

/* Rsp, Rd, A, Tt with standard errors and, where there are any, exact values; weight balance, speed. */
void cml_report_summary(FILE *stream, const struct cml_report *report);

/* A line for each medium inside, up to 16 of them: derivatives of Rd and Tt. Nothing where the run has none.
 */
void cml_report_print_derivatives(FILE *stream, const struct cml_report *report);

/* One line per rank: packets, and where its time went; and the shares of all together. */
void cml_report_ranks(FILE *stream, const struct cml_timing *timing);

/* One object on one line, keys as in samples/manual/output/json.md. */
CML_NODISCARD cml_status cml_report_json(FILE *stream, const struct cml_report *report,
                                         struct cml_error *err);

/* The object of a run that was finished before, with scene and files as they are called now: the folder may
 * have been moved, or the program called from elsewhere. path: of the main result, the output's name
 * included. */
CML_NODISCARD cml_status cml_report_json_again(FILE *stream, const char *json, const struct cml_scene *scene,
                                               const char *path, struct cml_error *err);

/* Totals by adding-doubling alone: a table, and one object on one line. */
void cml_report_exact(FILE *stream, const struct cml_scene *scene, const struct cml_exact *exact);
CML_NODISCARD cml_status cml_report_exact_json(FILE *stream, const struct cml_scene *scene,
                                               const struct cml_exact *exact, struct cml_error *err);

/* Totals by adding-doubling in one line, of what the scene would be with planes in place of all shapes. */
void cml_report_flat_twin(FILE *stream, const struct cml_scene *scene, const struct cml_exact *exact);

/* Zeroed: no sweep. */
struct cml_sweep_size {
    int rows, flights;
};

/* What check says of a scene, as one object on one line, keys as documented in samples/manual/output/json.md. bytes: the
 * most memory that its run will hold; starts: in which medium each beam starts; mean: of the scene; flat: the
 * totals of its flat twin, NULL: not known. */
CML_NODISCARD cml_status cml_report_check_json(FILE *stream, const struct cml_scene *scene,
                                               const struct cml_surface_set *surfaces,
                                               const struct cml_sweep_size *sweep, double bytes,
                                               const int *starts, const struct cml_mean_shapes *mean,
                                               const struct cml_exact *flat, struct cml_error *err);
