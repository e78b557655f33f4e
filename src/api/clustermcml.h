/* libclustermcml: Monte Carlo light transport in layered turbid media, for programs in C and for bindings.
 *
 *     struct clm_scene *scene = NULL;
 *     struct clm_run *run = NULL;
 *     struct clm_array array;
 *     if (clm_scene_open("fig5.mci", NULL, &scene) || clm_scene_set(scene, 0, "layer1.mua", "0.2") ||
 *         clm_run_open(scene, 0, NULL, &run) || clm_run_fly(run, 0) || clm_run_array(run, "Rd_r", &array))
 *         fprintf(stderr, "%s\n", clm_error());
 *     else
 *         printf("%g\n", array.value[0]);
 *     clm_run_free(run);
 *     clm_scene_free(scene);
 *
 * Functions of type int return 0 or one of enum clm_status; clm_error() then has one line of text. Nothing
 * here prints, exits, or sets a signal handler. Two threads may use two scenes or two runs at once. A scene
 * or a run is used by one thread at a time. Results do not depend on threads, nor on other runs.
 *
 * Options are those of `clustermcml run`, without dashes, in an array that NULL ends:
 * {"photons=1e6", "seed=7", "threads=2", "ignore-absorption", NULL}. NULL: none. Options about files,
 * checkpoints and ranks belong to the program alone.
 *
 * Strings are UTF-8. Lengths are cm, coefficients 1/cm, times ps, as in scene files.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Raised when a function or a structure changes so that callers must be compiled again. */
#define CLM_API 1

/* The numbers are the exit codes of the command line. */
enum clm_status {
    CLM_OK = 0,
    CLM_E_INPUT = 2,    /* the scene, a file, an option or a name is wrong, or memory does not suffice */
    CLM_E_DEVICE = 3,   /* no such device, or the device refused */
    CLM_E_NUMERIC = 4,  /* the run ended and its result can be read, but cannot be trusted */
    CLM_E_IO = 5,       /* a file could not be written */
    CLM_E_STOPPED = 75, /* the progress function has cancelled the flight */
};

/* ---- the library ---- */

int clm_api(void);             /* CLM_API of the library that was loaded */
const char *clm_version(void); /* such as "0.3.0 (d71ca371)" */
const char *clm_error(void);   /* last error of this thread; "" when there was none */

/* Called with one line about input that is valid, but perhaps not meant. */
typedef void clm_note(void *context, const char *text);
/* Sets the function that gets the notes of all calls of this thread; NULL: none. */
void clm_on_note(clm_note *note, void *context);

/* ---- scenes ---- */

/* The runs of a scene file. */
struct clm_scene;

/* Read a scene from a file, or from a text. The paths in a text are relative to the folder `beside`, NULL:
 * the working folder. The scene is checked whole. On failure *scene is NULL. */
int clm_scene_open(const char *path, const char *const *options, struct clm_scene **scene);
int clm_scene_parse(const char *text, const char *beside, const char *const *options,
                    struct clm_scene **scene);
void clm_scene_free(struct clm_scene *scene); /* NULL: nothing is done */

int clm_scene_runs(const struct clm_scene *scene); /* number of runs in the file */

/* Set one number of a run (from 0) by the name that --set takes, such as "layer1.mua", "photons". The run is
 * checked; after a failure it is what it was before. */
int clm_scene_set(struct clm_scene *scene, int run, const char *name, const char *value);
int clm_scene_set_number(struct clm_scene *scene, int run, const char *name, double value);
/* Sets `count` numbers, and checks the scene after the last one: numbers that only fit together can be set.
 */
int clm_scene_set_numbers(struct clm_scene *scene, int run, int count, const char *const *name,
                          const double *value);

/* The text that the program prints on a run without flying it, or with json as one line. clm_scene_check: the
 * text of `check`. clm_scene_exact: totals by adding-doubling, with planes in place of all shapes. The text
 * ends with a line feed and is valid until the next such call, or until the scene is freed. */
int clm_scene_check(struct clm_scene *scene, int run, int json, const char **text);
int clm_scene_exact(struct clm_scene *scene, int run, int json, const char **text);

/* ---- runs ---- */

/* A run of a scene, and what has flown of it. It does not need the scene any more. */
struct clm_run;

/* Makes the surfaces of a run, and checks its memory. Its options replace those of the scene; those that
 * decide how shapes are read and represented (set, tolerance, mesh-budget, mesh-search, boundaries, normals,
 * rings, ignore-heightfields) belong to the scene. Runs of a scene share their surfaces while these are the
 * same. On failure *run is NULL. */
int clm_run_open(struct clm_scene *scene, int run, const char *const *options, struct clm_run **out);
void clm_run_free(struct clm_run *run); /* NULL: nothing is done */

/* Called some twice a second during a flight, by any thread, never by two at once. Returns 0 to go on; else
 * the flight is cancelled within a second. */
typedef int clm_progress(void *context, uint64_t done, uint64_t total, double seconds);
void clm_run_on_progress(struct clm_run *run, clm_progress *progress, void *context); /* NULL: none */

/* Flies. photons: number of photons to add to those flown before; the sum of slices has the bits of one
 * flight. 0, only before all others: as many as the scene or the options say. A cancelled flight adds
 * nothing, and does not count. */
int clm_run_fly(struct clm_run *run, uint64_t photons);

/* ---- results: what has flown ---- */

enum { CLM_MOST_AXES = 4 };

/* An array, with the name, units and values of the .h5 file of the same run: row-major. An axis is an array,
 * too, whose only axis is itself. All pointers are valid until the run flies again or is freed. */
struct clm_array {
    const char *name, *units, *meaning;
    int num_axes;                    /* 0: a single number */
    const char *axis[CLM_MOST_AXES]; /* names, slowest axis first */
    size_t size[CLM_MOST_AXES];
    size_t count;        /* number of values */
    int single;          /* 1: files have the values as 32-bit floats, and so they are rounded here */
    const double *value; /* [count] values */
    const double *error; /* [count] standard errors; NULL: not known */
};

/* Array i, from 0; CLM_E_INPUT behind the last. An array by its name. */
int clm_run_item(struct clm_run *run, int i, struct clm_array *array);
int clm_run_array(struct clm_run *run, const char *name, struct clm_array *array);

/* Attribute i of the .h5 file, from 0: a text, or a number where *text is NULL. CLM_E_INPUT behind the last.
 */
int clm_run_attribute(struct clm_run *run, int i, const char **name, const char **text, double *number);

/* The line that `run --json` prints: totals, time, threads; "" before the first flight. Valid as arrays are.
 */
const char *clm_run_json(const struct clm_run *run);

/* Writes the files that `run --output path` writes. */
int clm_run_write(struct clm_run *run, const char *path);

/* ---- sweeps ---- */

/* Called with each row of a sweep, from 0, when it has flown: a run whose results can be read during the
 * call. Returns 0 to go on; else the sweep is cancelled. */
typedef int clm_row(void *context, int row, struct clm_run *run);

/* Flies a scene with one run once for each row of a table, whose text is that of a file of `--sweep`:
 * "layer1.mua,seed\n0.1,1\n0.2,2\n". All rows are checked before the first one flies. With the option
 * "reweight" rows that differ in mua alone share a flight. progress hears of each flight, NULL: none; it and
 * `row` get the same context. */
int clm_scene_sweep(struct clm_scene *scene, const char *const *options, const char *table,
                    clm_progress *progress, clm_row *row, void *context);

#ifdef __cplusplus
}
#endif
