/* SPDX-License-Identifier: MIT */
#include "options/option_table.h"

#include "base/text.h"
#include "options/option_values.h"

#include <float.h>
#include <stdio.h>
#include <string.h>

/* The commands as bits, and sets of commands that often share an option. */
enum {
    RUN = 1 << CML_COMMAND_RUN,
    PLAN = 1 << CML_COMMAND_PLAN,
    CHECK = 1 << CML_COMMAND_CHECK,
    EXACT = 1 << CML_COMMAND_EXACT,
    MESH = 1 << CML_COMMAND_MESH,
    TRACE = 1 << CML_COMMAND_TRACE,
    CROSSCHECK = 1 << CML_COMMAND_CROSSCHECK,
    FURNACE = 1 << CML_COMMAND_FURNACE,
    MERGE = 1 << CML_COMMAND_MERGE,
    ALL = (1 << CML_NUM_COMMANDS) - 1,
    FLIGHT = CML_OPTION_OF_FLIGHT,
    READING = CML_OPTION_OF_READING,
    TALLYING = RUN | PLAN | TRACE | CROSSCHECK,
    FLYING = TALLYING | FURNACE,
    SURFACES = FLYING | CHECK | MESH
};

#define MEMBER(name)                                                                                         \
    .member = offsetof(struct cml_options, name), .size = sizeof(((struct cml_options *)NULL)->name)
#define SET(name, value) .read = cml_read_flag, MEMBER(name), .least = (value)
#define FLAG(name) SET(name, true)
#define NO_FLAG(name) SET(name, false)
#define TEXT(name) .read = cml_read_text, MEMBER(name)
#define WORD(name, all) .read = cml_read_word, MEMBER(name), .words = (all)
#define COUNT(name, low, high) .read = cml_read_count, MEMBER(name), .least = (low), .most = (high)
#define INT(name, low, high) .read = cml_read_int, MEMBER(name), .least = (low), .most = (high)
#define NUMBER(name, low, high, expected)                                                                    \
    .read = cml_read_number, MEMBER(name), .least = (low), .most = (high), .words = (expected)

/* Numbers next to 0 and 1, for ranges that exclude these. */
#define ABOVE_0 DBL_TRUE_MIN
#define BELOW_1 (1 - DBL_EPSILON / 2)

/* Seconds of an option, above 0: zero would mean "always" for one option and "never" for another. */
#define SECONDS(name) MEMBER(name), .least = ABOVE_0, .most = 1e9, .words = "seconds above 0, up to 1e9"

/* All options. A run has at most 2^48 photons, because its sums could overflow beyond. A seed is at most
 * 2^53, because JSON keeps larger numbers only as rounded doubles. */
const struct cml_option cml_option_table[] = {
    {"photons", 0, "N", RUN | PLAN | CROSSCHECK | FURNACE | FLIGHT, NULL,
     "instead of the file's number; 1e7 reads as ten million; of plan: of the longest pilot",
     COUNT(photons, 1, 0x1p48), .title = "simulation"},
    {"set", 0, "NAME=VALUE", SURFACES | EXACT | READING, NULL,
     "a value in place of the file's, any number of times: layer2.mua=0.3 (n mua mus g d), above.n, below.n, "
     "boundary0.scale, boundary0.height, beam.angle, photons",
     .read = cml_read_set},
    {"sweep", 0, "TABLE.csv", RUN | CHECK, NULL,
     "one run for each row of the table, whose first line has names as --set has, and seed; results are "
     "NAME-0001.mco ..., NAME.sweep.csv and NAME.sweep.h5; check says how many flights that takes",
     TEXT(sweep)},
    {"reweight", 0, NULL, RUN | CHECK | FLIGHT, NULL,
     "with --sweep: rows that differ in nothing but mua, of layers and bodies, come of one flight, each as "
     "exact as a flight of its own; A_rz by every eighth interaction",
     FLAG(reweight)},
    {"derivatives", 0, NULL, RUN | FLIGHT, NULL,
     "of totals, profiles over r and angle, and what layers and bodies absorb, by mua and mus of every "
     "medium",
     FLAG(engine_options.derivatives)},
    {"seed", 0, "N", FLYING | FLIGHT, NULL,
     "default 1; the same seed gives the same bits on any number of threads", .read = cml_read_seed,
     MEMBER(engine_options.seed), .least = 0, .most = 0x1p53},
    {"run", 0, "K", TRACE, NULL, "the file's run, from 1 (default), that the photon belongs to",
     COUNT(run, 1, UINT32_MAX)},
    {"target-error", 0, "E", RUN | PLAN | FLIGHT, NULL,
     "fly rounds of N, N, 2N, 4N ... until the relative error of Rd, A and Tt is below E; of plan: the error "
     "that is planned for, default 1e-3",
     NUMBER(target_error, ABOVE_0, BELOW_1, "a relative error between 0 and 1")},
    {"error-of", 0, "A_l:N|DETECTOR", RUN | PLAN | FLIGHT, NULL,
     "of --target-error: of what layer N absorbs or a detector sees, in place of Rd, A and Tt",
     .read = cml_read_error_of},
    {"sampling", 0, "KIND", RUN | TRACE | CROSSCHECK | FURNACE | FLIGHT, NULL,
     "of a packet's first draws: lattice (default, evenly spread) or random",
     WORD(engine_options.lattice, "random lattice")},
    {"roulette", 0, "WR,WS|mcml", TALLYING | FLIGHT, NULL,
     "packets below WR survive as WS; mcml: below 1e-4 one in ten survives; default 0.003,0.01",
     .read = cml_read_roulette},
    {"aim", 0, "Tt|Tt_r|A_l:N|DETECTOR[,...]", RUN | PLAN | FLIGHT, NULL,
     "more of the light that goes deep, or to a detector: what packets that go down into flat layers below "
     "all shapes are expected to bring, "
     "Tt_expected and A_l_expected; elsewhere, and for Tt_r and a detector, packets that are split on their "
     "way",
     .read = cml_read_aim},
    {"ignore-absorption", 0, NULL, RUN | PLAN | CHECK | CROSSCHECK | FLIGHT, NULL, "tally no A_rz",
     NO_FLAG(engine_options.absorption)},
    {"ignore-heightfields", 0, NULL, SURFACES | READING, NULL, "every surface is its nominal plane",
     FLAG(ignore_heightfields)},
    {"no-reentry", 0, NULL, TALLYING | CHECK | FLIGHT, NULL,
     "score packets at their first exit, as the 2019 program did", NO_FLAG(engine_options.reentry)},

    {"boundaries", 0, "KIND", SURFACES | READING, NULL, "auto (default), plane, cone or mesh",
     WORD(surface.force, "plane cone mesh auto"), .title = "boundaries"},
    {"tolerance", 0, "T", SURFACES | EXACT | READING, NULL,
     "relative bias to keep; heightmaps: height error / peak to valley; default 1e-3. When given, a surface "
     "becomes a plane where trial packets (a second at most) show that this changes no total or profile by "
     "more",
     .read = cml_read_tolerance, MEMBER(surface.tolerance), .least = 1e-12, .most = 0.1,
     .words = "a number from 1e-12 to 0.1"},
    {"mesh-budget", 0, "N", SURFACES | EXACT | READING, NULL,
     "triangles that the mesh of a boundary may have; default 4e6, or what fits into a quarter of the memory "
     "at 350 bytes each; a boundary that needs more is refused",
     .read = cml_read_mesh_budget, .least = 1, .most = CML_MESH_MOST},
    {"normals", 0, "KIND", SURFACES | READING, NULL,
     "of a tessellated heightfield: analytic (default), vertex or facet",
     WORD(surface.tessellation.normals, "facet vertex analytic")},
    {"rings", 0, "KIND", SURFACES | READING, NULL,
     "of a tessellated heightfield: area (area-preserving, default) or inscribed",
     WORD(surface.tessellation.inscribed, "area inscribed")},
    {"mesh-search", 0, "KIND", FLYING | CHECK | READING, "cpu",
     "of engine cpu: auto (default; sheets are walked, others have a tree), tree or embree",
     WORD(surface.search, "auto tree embree")},

    {"engine", 0, "NAME", RUN | CHECK | TRACE | FURNACE | FLIGHT, NULL, "cpu (default), reference or opencl",
     .read = cml_read_engine, .title = "machine"},
    {"threads", 0, "N", RUN | PLAN | CHECK | CROSSCHECK | FURNACE | FLIGHT, NULL,
     "default: OMP_NUM_THREADS, or all cores", INT(engine_options.threads, 1, 4096)},
    {"chunk", 0, "N", RUN | PLAN | CROSSCHECK | FLIGHT, NULL,
     "packets a thread or device takes at a time; never changes a result",
     COUNT(engine_options.chunk, 1, CML_TALLY_MAX_PHOTONS)},
    {"device", 0, "I[,J...]|all", TALLYING | FLIGHT, "opencl",
     "for opencl: numbers that `devices` lists; default by local MPI rank, GPUs first",
     TEXT(engine_options.device)},
    {"group", 0, "N", TALLYING | FLIGHT, "opencl", "for opencl: work-items per group; never changes a result",
     INT(engine_options.group, 1, 65536)},
    {"build-options", 0, "TEXT", TALLYING | FLIGHT, "opencl",
     "for opencl: for the device's compiler, behind ours", TEXT(engine_options.build_options)},
    {"checkpoint", 0, "S|off", RUN, NULL,
     "seconds between checkpoints of a run, default 60 (DIR/NAME.mco.checkpoint)",
     .read = cml_read_checkpoint, SECONDS(checkpoint_interval)},
    {"resume", 0, NULL, RUN, NULL, "continue from the checkpoint, on any number of ranks and threads",
     FLAG(resume)},
    {"replace", 0, NULL, RUN, NULL,
     "with --resume: also replace results of other runs that have more photons", FLAG(replace)},
    {"no-clobber", 0, NULL, RUN | MERGE, NULL,
     "end where a result would be replaced; with --resume finished ones count", FLAG(no_clobber)},
    {"keep", 0, NULL, RUN | MERGE, NULL,
     "leave a checkpoint of the finished run, with all tallies: --more can add photons to it", FLAG(keep)},
    {"more", 0, "N", RUN, NULL,
     "add N photons to a run that was flown with --keep: the same bits as one run of all of them; keeps, too",
     COUNT(more, 1, 0x1p48)},
    {"part", 0, "K/N", RUN, NULL,
     "fly part K of the N parts of each run, into NAME.mco.partKofN: merge makes one run of all parts",
     .read = cml_read_part, .least = 1, .most = 4096},
    {"patience", 0, "S", RUN | PLAN | FURNACE, NULL,
     "under mpiexec or srun: end when a rank was silent for so long, default 60", .read = cml_read_number,
     SECONDS(timeout)},

    {"output-dir", 'o', "DIR", RUN | MESH | MERGE, NULL,
     "where results go, default the current directory; a folder that is not there is made", TEXT(directory),
     .title = "output"},
    {"output", 'o', "FILE", RUN, NULL,
     "the result's name in place of the file's, .mco or .h5 (-o is --output-dir)", TEXT(output)},
    {"classic", 0, NULL, RUN | MERGE, NULL,
     "the .mco ends with the sections of original MCML, for readers that take no other", FLAG(classic)},
    {"json", 0, NULL, RUN | PLAN | CHECK | EXACT | MERGE | CROSSCHECK | FURNACE, NULL,
     "one line with one object per run on standard output, nothing else there", FLAG(json)},
    {"alpha", 0, "A", FURNACE, NULL, "p below it is a difference, default 0.01",
     NUMBER(alpha, ABOVE_0, BELOW_1, "a number above 0 and below 1")},
    {"dump", 0, "FILE", CROSSCHECK, NULL, "the photons that differ, for trace", TEXT(dump)},
    {"verbose", 0, NULL, RUN, NULL, "photons, idle and communication share of every rank", FLAG(verbose)},
    {"quiet", 0, NULL, SURFACES | EXACT | MERGE, NULL, "no banner, progress or summary", FLAG(quiet)},
    {"help", 'h', NULL, ALL, NULL, "of the command, or the list of commands", FLAG(help)},
    {"version", 0, NULL, ALL, NULL, "of the program", FLAG(version)},
};

const size_t cml_option_count = sizeof cml_option_table / sizeof *cml_option_table;

const struct cml_option *cml_option_find(const char *name, size_t length)
{
    for (size_t i = 0; i < cml_option_count; i++) {
        const char *known = cml_option_table[i].name;
        if (strlen(known) == length && memcmp(known, name, length) == 0) return &cml_option_table[i];
    }
    return NULL;
}

const struct cml_option *cml_option_of_letter(char letter, enum cml_command command)
{
    const struct cml_option *first = NULL;
    for (const struct cml_option *o = cml_option_table; o < cml_option_table + cml_option_count; o++) {
        if (o->letter != letter || letter == '\0') continue;
        if (cml_option_belongs(o, command)) return o;
        if (!first) first = o;
    }
    return first;
}

void cml_option_commands(const struct cml_option *option, char *text, size_t size)
{
    size_t used = 0;
    for (int i = 0; i < CML_NUM_COMMANDS && used < size; i++)
        if (cml_option_belongs(option, (enum cml_command)i))
            used +=
                (size_t)snprintf(text + used, size - used, "%s%s", used ? ", " : "", cml_commands[i].name);
}

const char *cml_option_guess(const char *name, size_t length)
{
    struct cml_guess guess = {.word = name, .length = length};
    for (size_t i = 0; i < cml_option_count; i++) cml_guess_offer(&guess, cml_option_table[i].name);
    return cml_guess_best(&guess);
}
