/* The command line: one set of options for all commands.
 * SPDX-License-Identifier: MIT */
#ifndef CML_OPTIONS_H
#define CML_OPTIONS_H

#include "engine/engine.h"
#include "plot/plot_parts.h"
#include "surface/surface.h"

struct cml_options {
    const struct cml_engine *engine;
    struct cml_engine_options engine_options;
    struct cml_surface_options surface;
    uint64_t photons; /* 0: as the .mci says */
    uint64_t run;     /* of the file, from 1, for `trace` */
    bool ignore_heightfields;
    bool control;               /* the flat twin of a run is flown, too, and makes its totals sharper */
    double target_error;        /* 0: none */
    double checkpoint_interval; /* s; 0: no checkpoints */
    bool resume;
    double timeout; /* s of a rank's silence */
    bool quiet, json, verbose;
    double alpha;         /* level of `compare` */
    const char *caption;  /* of `plot`, NULL: none */
    const char *of;       /* array of a map for `plot`, NULL: not given */
    enum cml_scale scale; /* of `plot` */
    const char *output;   /* -o, --output-dir: a directory, or the picture of `plot` and `compare`; NULL: not
                             given */
    const char *dump;     /* crosscheck: a file for the photons that differ; NULL: not wanted */
    int num_operands;
    char **operands; /* borrowed from argv */
    bool help, version;
    char command[4096]; /* the command line as it was typed, words joined by blanks; cut when longer */
};

/* Parses argv[1..]; options and operands may mix. CML_E_INPUT with one line on what is wrong. */
CML_NODISCARD cml_status cml_options_parse(int argc, char **argv, struct cml_options *options,
                                           struct cml_error *err);

/* The grouped help text. */
const char *cml_options_help(void);

#endif
