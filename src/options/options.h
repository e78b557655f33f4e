/* The command line as one structure for all commands. SPDX-License-Identifier: MIT */
#pragma once

#include "base/settings.h"
#include "options/command_table.h"
#include "engine/engine.h"
#include "surface/surface.h"

struct cml_options {
    enum cml_command which; /* CML_COMMAND_RUN if the command line names none */
    const struct cml_engine *engine;
    struct cml_engine_options engine_options;
    struct cml_surface_options surface;
    uint64_t photons; /* photons of --photons; 0: the number in the .mci file */
    uint64_t run;     /* run of the file, from 1, for `trace` */
    bool ignore_heightfields;
    const char *aim;            /* NAME[,NAME ...] of --aim (P15, P19); NULL: none */
    double target_error;        /* relative error of --target-error; 0: not given */
    const char *error_of;       /* quantity of target_error; NULL: Rd, A and Tt */
    double checkpoint_interval; /* seconds between checkpoints; 0: none are written */
    bool seed_given;            /* --seed was given */
    bool resume;
    bool replace;    /* --resume may replace results with more photons */
    bool no_clobber; /* existing results are not replaced */
    bool classic;    /* the .mco ends with the sections of original MCML */
    bool keep;       /* checkpoints of finished runs stay, with all tallies */
    uint64_t more;   /* photons to add to finished runs; 0: none */
    /* Part `part`, from 1, of `parts` is flown in each run; 0: the whole run. */
    uint64_t part, parts;
    /* For `merge`: parts whose sums replace flights; NULL: none. */
    struct cml_part_files *joined;
    /* Takes results in place of files (flights/one_run.h); NULL: none. */
    const struct cml_receiver *receiver;
    double timeout; /* s of silence after which a rank counts as lost */
    bool quiet, json, verbose;
    double alpha;                 /* least p-value at which `furnace` accepts a scene */
    const char *sweep;            /* table with one run per row; NULL: not given */
    bool reweight;                /* rows that differ only in absorption share one flight */
    const char *directory;        /* folder of the results; NULL: not given */
    const char *output;           /* name of the result; NULL: not given */
    struct cml_settings settings; /* values that replace those of the scene's file */
    const char *dump;             /* file for the photons that differ in `crosscheck`; NULL: none */
    int num_operands;             /* number of operands, without the name of the command */
    char **operands;              /* the operands, borrowed from argv */
    bool help, version;
    bool named; /* the command line names the command */
    /* The command line as typed, words separated by blanks; cut off if longer. */
    char command[4096];
    /* The command line without --part and --resume, each word ended by a line feed; "": too long. */
    char call[4096];
};
