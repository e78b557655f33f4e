/* Structures and functions that the files of the C library share. SPDX-License-Identifier: MIT */
#pragma once

#include "api/clustermcml.h"
#include "base/input_files.h"
#include "simulation/scenes.h"

#include <locale.h>

/* Words of a command line, which options borrow. */
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
};

/* The last error of this thread, and the receiver of its notes. */
extern _Thread_local struct cml_error cml_api_error;
extern _Thread_local struct cml_note_receiver cml_api_notes;

/* The state that a call changes in its thread, and gives back at its end: numbers are read and written in the
 * "C" locale, and notes go to their receiver. */
struct cml_api_call {
    locale_t locale;
    struct cml_note_receiver notes;
};
struct cml_api_call cml_api_enter(void);
void cml_api_leave(struct cml_api_call *call);

/* Declares that the calling function is a call of the library. */
#define CML_API_CALL() CML_AT_END(cml_api_leave) struct cml_api_call cml_call_ = cml_api_enter()

/* Marks a function of clustermcml.h. */
#define CML_API __attribute__((visibility("default")))

/* Makes the words of a call of `run`: those of `before` without the scene (NULL: none), then the options, and
 * parses them. reads: options about the reading of files are allowed. CML_E_INPUT; the caller clears *words.
 */
CML_NODISCARD cml_status cml_api_parse(const char *path, const struct cml_api_words *before,
                                       const char *const *options, bool reads, struct cml_api_words *words,
                                       struct cml_options *parsed, struct cml_error *err);
void cml_api_words_clear(struct cml_api_words *words);

/* Returns the settings with which a run is read. */
const struct cml_settings *cml_api_settings(const struct clm_scene *scene, int run);

/* Fails with CML_E_INPUT if the scene has no such run. */
CML_NODISCARD cml_status cml_api_check_run(const struct clm_scene *scene, int run, struct cml_error *err);
