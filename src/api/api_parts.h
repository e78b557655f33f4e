/* Structures and functions that the files of the C library share, and what the program uses of them.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "api/clustermcml.h"
#include "base/input_files.h"
#include "output/report.h"
#include "simulation/scenes.h"

#include <locale.h>

/* The words that options borrow: the path of the scene, then NAME or NAME=VALUE. */
struct cml_api_words {
    int count;
    char **word; /* [count] words, and a NULL behind them */
};

struct clm_scene {
    struct cml_api_words words;
    struct cml_options options;
    struct cml_scene_list list;
    struct cml_inputs inputs;         /* bytes of all files */
    struct cml_settings **settings;   /* [list.count] settings of each run; NULL: those of the options */
    struct cml_surface_set *surfaces; /* [list.count] surfaces of each run that was opened, to be shared */
    /* Engine options of the flight that takes most memory, and the size of a sweep: the program sets both. */
    struct cml_engine_options flown;
    struct cml_sweep_size sweep;
    char *text; /* last answer of clm_scene_check or clm_scene_exact */
};

/* The last error of this thread. */
extern _Thread_local struct cml_error cml_api_error;

/* A call of the library reads and writes numbers in the "C" locale. cml_api_enter returns the locale of the
 * thread, and cml_api_leave gives it back. */
locale_t cml_api_enter(void);
void cml_api_leave(locale_t *before);

/* Declares that the calling function is a call of the library. */
#define CML_API_CALL() CML_AT_END(cml_api_leave) locale_t cml_before_ = cml_api_enter()

/* Marks a function of clustermcml.h. */
#define CML_API __attribute__((visibility("default")))

/* Makes the words of `before` (NULL: none) and of the options, and reads them. reads: options about the
 * reading of files are allowed. CML_E_INPUT; the caller clears *words. */
CML_NODISCARD cml_status cml_api_parse(const char *path, const struct cml_api_words *before,
                                       const char *const *options, bool reads, struct cml_api_words *words,
                                       struct cml_options *parsed, struct cml_error *err);
void cml_api_words_clear(struct cml_api_words *words);

/* For the program: opens the scenes of a command line that is read already. options: borrowed words. */
CML_NODISCARD cml_status cml_api_open(const struct cml_options *options, struct clm_scene **scene,
                                      struct cml_error *err);

/* For the program: frees *scene at the end of its scope, and takes over the error of a call. */
void cml_api_close(struct clm_scene **scene);
CML_NODISCARD cml_status cml_api_take(int status, struct cml_error *err);

/* Returns the settings with which a run is read. */
const struct cml_settings *cml_api_settings(const struct clm_scene *scene, int run);

/* Fails with CML_E_INPUT if the scene has no such run. */
CML_NODISCARD cml_status cml_api_check_run(const struct clm_scene *scene, int run, struct cml_error *err);
