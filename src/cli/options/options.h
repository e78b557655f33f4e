/* What the command line said, in one structure for all commands. SPDX-License-Identifier: MIT */
#pragma once

#include "base/settings.h"
#include "cli/options/command_table.h"
#include "engine/engine.h"
#include "surface/surface.h"

struct cml_options {
    enum cml_command which; /* run where none is named */
    const struct cml_engine *engine;
    struct cml_engine_options engine_options;
    struct cml_surface_options surface;
    uint64_t photons; /* 0: as the .mci says */
    uint64_t run;     /* of the file, from 1, for `trace` */
    bool ignore_heightfields;
    const char *aim;            /* NAME[,NAME ...] of what shall be known better (P15, P19); NULL: none */
    double target_error;        /* 0: none */
    const char *error_of;       /* of what that is; NULL: of Rd, A and Tt */
    double checkpoint_interval; /* s; 0: no checkpoints */
    bool seed_given;            /* by --seed */
    bool resume;
    bool replace;                  /* --resume may replace results with more photons */
    bool no_clobber;               /* a result that is there is not replaced */
    bool classic;                  /* the .mco ends with the sections of original MCML */
    bool keep;                     /* checkpoints of finished runs stay, with all tallies */
    uint64_t more;                 /* photons to be added to finished runs; 0: none */
    uint64_t part, parts;          /* `part`, from 1, of `parts` is flown of each run; 0: all */
    struct cml_part_files *joined; /* of `merge`: parts whose sums take the place of flights; NULL: none */
    double timeout;                /* s of a rank's silence */
    bool quiet, json, verbose;
    double alpha;                 /* level of `furnace` */
    const char *sweep;            /* a table, one run a row; NULL: not given */
    bool reweight;                /* rows that differ in absorption come of one flight */
    const char *directory;        /* of the results; NULL: not given */
    const char *output;           /* the name of a result; NULL: not given */
    struct cml_settings settings; /* values in place of what the scene's file says */
    const char *dump;             /* crosscheck: a file for the photons that differ; NULL: not wanted */
    int num_operands;             /* without the command's name */
    char **operands;              /* borrowed from argv */
    bool help, version;
    bool named;         /* the command was */
    char command[4096]; /* the command line as it was typed, words joined by blanks; cut when longer */
    char
        call[4096]; /* that without --part and --resume, each word ended by a line feed; "": it is too long */
};
