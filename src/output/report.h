/* Reports of a run: its result files (.mco, .h5, .vti, .vtp), the summary for people, the JSON line for
 * programs. SPDX-License-Identifier: MIT */
#pragma once

#include "exact/exact.h"
#include "result/h5.h"
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
    char identity[CML_IDENTITY_SUM];  /* identity of the run, as digits (run/identity.h) */
    const char *command;              /* command line */
    int row;                          /* row of a sweep, from 1; 0: no sweep */
    const struct cml_flat_tail *tail; /* the tail of --aim; NULL: none */
    double flat_below;                /* depth below which --aim would save photons, cm; NaN: none */
    /* Number, from 1, of a detector that has seen nothing, and to which --aim would send packets; 0: none. */
    int unseen;
    const struct cml_exact *exact; /* totals by adding-doubling, for summary and JSON; NULL: none */
    struct cml_outcome outcome;    /* set by cml_report_write: the contents of files, record and summary */
    /* Set by cml_report_write: the number of photons (the first ones, or a sample if there are several beams)
     * of which no saved packet is missing (cml_saved_covers). Sums of rows over this number are estimates. */
    uint64_t covers;
    bool classic; /* the .mco ends with the sections of original MCML */
    int num_files;
    char **files; /* [num_files] paths of the files written, the main result first */
};

/* The content of a file of a run. */
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

/* Options of a run that its files depend on. */
struct cml_report_asks {
    bool absorption; /* absorption by place is tallied */
    bool scores;     /* derivatives or expected values are tallied, for which an .mco has no place */
};

/* Calls `each` for every file that a run leaves beside `path`, the main result first, until a call fails.
 * surfaces: a boundary that is a plane has no file; NULL: unknown, all boundaries count. Without HDF5 there
 * are no .h5 files. */
CML_NODISCARD cml_status cml_report_each_file(const struct cml_scene *scene,
                                              const struct cml_surface_set *surfaces,
                                              const struct cml_report_asks *asks, const char *path,
                                              cml_report_file_function *each, void *context,
                                              struct cml_error *err);

/* Writes all files of a run. Each file is the old or the complete new one at any moment. report->files lists
 * the files. CML_E_IO when a file could not be written; those before it are complete. */
CML_NODISCARD cml_status cml_report_write(struct cml_report *report, const char *path, struct cml_error *err);

/* The arrays and attributes of a run as its .h5 has them, without a file. */
struct cml_report_arrays {
    const struct cml_field *field; /* [num_fields] arrays; values are computed when they are asked for */
    int num_fields, num_attributes;
    struct cml_attribute attribute[CML_H5_MOST_ATTRIBUTES];
    void *lists; /* owner of all that the members above point to */
};

/* Makes report->outcome, and lists the arrays. The report must outlive the list; the caller clears both, also
 * on failure. */
CML_NODISCARD cml_status cml_report_arrays(struct cml_report *report, struct cml_report_arrays *arrays,
                                           struct cml_error *err);
void cml_report_arrays_clear(struct cml_report_arrays *arrays);

/* Frees the outcome and the list of files. */
void cml_report_clear(struct cml_report *report);

/* Make the record of a run. cml_report_record: the run has just been written. cml_report_record_again: the
 * run was finished earlier with the record `before`, and its result now lies in `path`. The caller clears
 * *record. */
CML_NODISCARD cml_status cml_report_record(const struct cml_report *report, struct cml_record *record,
                                           struct cml_error *err);
CML_NODISCARD cml_status cml_report_record_again(const struct cml_scene *scene, const char *path,
                                                 const struct cml_record *before, struct cml_record *record,
                                                 struct cml_error *err);

/* Returns the bytes that cml_report_write holds at its peak besides the result; most are the .h5 file. */
double cml_report_bytes(const struct cml_scene *scene, const struct cml_tally_grid *grid);

/* Returns the name of a file beside the result in *result: `path` without a final ".mco" or ".h5", then
 * `suffix`. The caller frees *result. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_report_path(const char *path, const char *suffix, char **result,
                                         struct cml_error *err);

/* cml_report_saved_path returns the file of saved packets beside the result `path`; the caller frees *result.
 * cml_saved_file_bytes returns the most bytes of numbers that the file holds. */
CML_NODISCARD cml_status cml_report_saved_path(const struct cml_scene *scene, const char *path, char **result,
                                               struct cml_error *err);
double cml_saved_file_bytes(const struct cml_saved_kind *kind);

/* The reader for whom a scene is described. People see files by the path by which they were opened, and at
 * most 20 bodies. Results have all bodies, and checksums of all shapes. An .h5 names files as the scene does,
 * so that it does not depend on the folder from which the program was called. */
enum cml_report_reader { CML_READ_BY_PEOPLE, CML_READ_IN_MCO, CML_READ_IN_H5 };

/* Prints a line per boundary behind the prefix (number, kind, primitives, reason, file), then a line per body
 * (number, shape, host, medium, file). */
void cml_report_shapes(FILE *stream, const char *prefix, const struct cml_scene *scene,
                       const struct cml_surface_set *surfaces, enum cml_report_reader reader);

/* Returns "disk", "ring", "rectangle" or "map"; a ring without a hole is a disk. */
const char *cml_detector_word(const struct cml_detector_def *detector);

/* Writes the name of a medium: "above", "layer 1", "below" or "body 1". */
enum { CML_MEDIUM_NAME = 24 };
void cml_medium_name(const struct cml_scene *scene, int medium, char name[CML_MEDIUM_NAME]);

/* Prints a line behind the prefix for every beam of the file; none for MCML's pencil beam. starts: the medium
 * that each beam starts in, printed for beams with z=; NULL: not known. */
void cml_report_beams(FILE *stream, const char *prefix, const struct cml_scene *scene, const int *starts);

/* Prints beam k behind the prefix: its shape, its start, its light. starts: as for cml_report_beams. */
void cml_report_beam(FILE *stream, const char *prefix, const struct cml_scene *scene, int k,
                     const int *starts);

/* Prints a line behind the prefix for every medium whose phase function is not that of Henyey and Greenstein,
 * "phase of layer 1: gk 0.9 0.5", and one for the backing. */
void cml_report_phases(FILE *stream, const char *prefix, const struct cml_scene *scene,
                       enum cml_report_reader reader);

/* Prints a line behind the prefix for every face and port, "port out: disk of ..."; people see the first 20.
 */
void cml_report_top(FILE *stream, const char *prefix, const struct cml_scene *scene,
                    enum cml_report_reader reader);

/* Writes the name of a face or port, numbered from 1: "face 2", "port out". */
enum { CML_CONTACT_NAME = 40 };
void cml_contact_name(const struct cml_scene *scene, int number, char name[CML_CONTACT_NAME]);

/* Returns the word of an outline in the .mci: disk, ring or rectangle. */
const char *cml_outline_word(bool round, const double size[2]);

/* Returns "mirror", "lambertian" or "metal". */
const char *cml_backing_word(enum cml_backing_kind kind);

/* Prints a line behind the prefix for every detector, "detector NAME: ring of ..."; people see the first 20.
 */
void cml_report_detectors(FILE *stream, const char *prefix, const struct cml_scene *scene,
                          enum cml_report_reader reader);

/* Prints a value with its error: " 0.318400 +- 0.000300", or " 1.234e-07 +- 1.1e-08" for a small value. */
void cml_report_estimate(FILE *stream, double value, double error);

/* Prints the summary of a run: Rsp, Rd, A, Tt with standard errors and, where known, exact values; weight
 * balance; speed. */
void cml_report_summary(FILE *stream, const struct cml_report *report);

/* Prints the derivatives of Rd and Tt, a line for each medium inside, up to 16. Nothing if the run has none.
 */
void cml_report_print_derivatives(FILE *stream, const struct cml_report *report);

/* Prints a line per rank (its packets, and the shares of its time), and the shares of all ranks together. */
void cml_report_ranks(FILE *stream, const struct cml_timing *timing);

/* Prints a run as one JSON object on one line, with the keys of samples/manual/output/json.md. */
CML_NODISCARD cml_status cml_report_json(FILE *stream, const struct cml_report *report,
                                         struct cml_error *err);

/* Prints the JSON object of a run that was finished before, with the present names of scene and files: the
 * folder may have been moved, or the program called from elsewhere. path: of the main result, with the
 * output's name. */
CML_NODISCARD cml_status cml_report_json_again(FILE *stream, const char *json, const struct cml_scene *scene,
                                               const char *path, struct cml_error *err);

/* Print totals by adding-doubling alone: as a table, and as one JSON object on one line. */
void cml_report_exact(FILE *stream, const struct cml_scene *scene, const struct cml_exact *exact);
CML_NODISCARD cml_status cml_report_exact_json(FILE *stream, const struct cml_scene *scene,
                                               const struct cml_exact *exact, struct cml_error *err);

/* Prints in one line the totals by adding-doubling of the scene with planes in place of all shapes
 * (its flat twin). */
void cml_report_flat_twin(FILE *stream, const struct cml_scene *scene, const struct cml_exact *exact);

/* The size of a sweep. Zeros mean that there is no sweep. */
struct cml_sweep_size {
    int rows, flights;
};

/* Prints the findings of `check` as one JSON object on one line, with the keys of
 * samples/manual/output/json.md. bytes: the most memory that the run will hold. starts: the medium that each
 * beam starts in. mean: the mean shapes of the scene. flat: the totals with planes in place of all shapes;
 * NULL: not known. */
CML_NODISCARD cml_status cml_report_check_json(FILE *stream, const struct cml_scene *scene,
                                               const struct cml_surface_set *surfaces,
                                               const struct cml_sweep_size *sweep, double bytes,
                                               const int *starts, const struct cml_mean_shapes *mean,
                                               const struct cml_exact *flat, struct cml_error *err);
