/* SPDX-License-Identifier: MIT */
#include "cli/options.h"

#include "engine/engines.h"
#include "base/text.h"

#include <getopt.h>
#include <stdio.h>
#include <string.h>

/* Long options only, but for -o and -h; above all characters, as getopt wants it. */
enum option_key {
    KEY_PHOTONS = 256,
    KEY_SEED,
    KEY_RUN,
    KEY_THREADS,
    KEY_CHUNK,
    KEY_ENGINE,
    KEY_DEVICE,
    KEY_GROUP,
    KEY_BUILD_OPTIONS,
    KEY_BOUNDARIES,
    KEY_TOLERANCE,
    KEY_MESH_BUDGET,
    KEY_NORMALS,
    KEY_RINGS,
    KEY_MESH_SEARCH,
    KEY_IGNORE_ABSORPTION,
    KEY_IGNORE_HEIGHTFIELDS,
    KEY_NO_REENTRY,
    KEY_SAMPLING,
    KEY_ROULETTE,
    KEY_CONTROL,
    KEY_TARGET_ERROR,
    KEY_CHECKPOINT,
    KEY_RESUME,
    KEY_PATIENCE,
    KEY_ALPHA,
    KEY_CAPTION,
    KEY_OF,
    KEY_LOG,
    KEY_LINEAR,
    KEY_QUIET,
    KEY_VERBOSE,
    KEY_JSON,
    KEY_OUTPUT,
    KEY_DUMP,
    KEY_HELP,
    KEY_VERSION,
};

/* In the order of the help text. */
static const struct option long_options[] = {
    {"photons", required_argument, NULL, KEY_PHOTONS},
    {"seed", required_argument, NULL, KEY_SEED},
    {"run", required_argument, NULL, KEY_RUN},
    {"threads", required_argument, NULL, KEY_THREADS},
    {"chunk", required_argument, NULL, KEY_CHUNK},
    {"engine", required_argument, NULL, KEY_ENGINE},
    {"device", required_argument, NULL, KEY_DEVICE},
    {"group", required_argument, NULL, KEY_GROUP},
    {"build-options", required_argument, NULL, KEY_BUILD_OPTIONS},
    {"boundaries", required_argument, NULL, KEY_BOUNDARIES},
    {"tolerance", required_argument, NULL, KEY_TOLERANCE},
    {"mesh-budget", required_argument, NULL, KEY_MESH_BUDGET},
    {"normals", required_argument, NULL, KEY_NORMALS},
    {"rings", required_argument, NULL, KEY_RINGS},
    {"mesh-search", required_argument, NULL, KEY_MESH_SEARCH},
    {"ignore-absorption", no_argument, NULL, KEY_IGNORE_ABSORPTION},
    {"ignore-heightfields", no_argument, NULL, KEY_IGNORE_HEIGHTFIELDS},
    {"no-reentry", no_argument, NULL, KEY_NO_REENTRY},
    {"sampling", required_argument, NULL, KEY_SAMPLING},
    {"roulette", required_argument, NULL, KEY_ROULETTE},
    {"control", required_argument, NULL, KEY_CONTROL},
    {"target-error", required_argument, NULL, KEY_TARGET_ERROR},
    {"checkpoint", required_argument, NULL, KEY_CHECKPOINT},
    {"resume", no_argument, NULL, KEY_RESUME},
    {"patience", required_argument, NULL, KEY_PATIENCE},
    {"alpha", required_argument, NULL, KEY_ALPHA},
    {"caption", required_argument, NULL, KEY_CAPTION},
    {"of", required_argument, NULL, KEY_OF},
    {"log", no_argument, NULL, KEY_LOG},
    {"linear", no_argument, NULL, KEY_LINEAR},
    {"quiet", no_argument, NULL, KEY_QUIET},
    {"verbose", no_argument, NULL, KEY_VERBOSE},
    {"json", no_argument, NULL, KEY_JSON},
    {"output-dir", required_argument, NULL, KEY_OUTPUT},
    {"output", required_argument, NULL, KEY_OUTPUT},
    {"dump", required_argument, NULL, KEY_DUMP},
    {"help", no_argument, NULL, KEY_HELP},
    {"version", no_argument, NULL, KEY_VERSION},
    {NULL, 0, NULL, 0},
};

static const char help[] =
    "usage: clustermcml [run] scene.mci [options]     simulate all runs of the file (- is standard "
    "input)\n"
    "       clustermcml plan scene.mci [options]      photons and time to an error, by engine and sampling; "
    "writes nothing\n"
    "       clustermcml check scene.mci [options]     parse, validate, show boundaries and memory\n"
    "       clustermcml exact scene.mci               totals of the flat scene without photons, by "
    "adding-doubling\n"
    "       clustermcml mesh scene.mci -o DIR         write every boundary as OBJ at the tolerance\n"
    "       clustermcml trace scene.mci N [--run K]   every event of photon N (of run K of the file) as a "
    "table\n"
    "       clustermcml crosscheck scene.mci [options]   cones, mesh, OpenCL on the same photons\n"
    "       clustermcml devices                       OpenCL devices, this machine's cores, Embree\n"
    "       clustermcml compare a.mco b.mco [-o f.svg]    z per bin, Sidak-corrected p-value; exit 1 "
    "if they differ\n"
    "       clustermcml plot a.mco [b.mco ...] [c.csv ...] -o f.svg   r*Rd(r) and r*Tt(r), "
    "heightfields dotted, curves of others dashed (svg or png)\n"
    "       clustermcml plot a.map.vti [b.map.vti ...] -o f.svg       Rd(x,y) in colours\n"
    "\n"
    "simulation\n"
    "  --photons N            instead of the file's number; 1e7 reads as ten million; for plan: of the "
    "longest "
    "pilot\n"
    "  --seed N               default 1; the same seed gives the same bits on any number of threads\n"
    "  --run K                for trace: the file's run that the photon belongs to, from 1 (default)\n"
    "  --target-error E       fly rounds of N, N, 2N, 4N ... until the relative error of Rd, A and Tt "
    "is "
    "below E; of plan, default 1e-3\n"
    "  --sampling KIND        of a packet's first draws: lattice (default, evenly spread) or random\n"
    "  --roulette WR,WS|mcml  packets below WR survive as WS; mcml: below 1e-4 one in ten survives; default "
    "0.003,0.01\n"
    "  --control flat         totals once more with the flat twin as control variate: smaller errors where "
    "boundaries are curved\n"
    "  --ignore-absorption    tally no A_rz\n"
    "  --ignore-heightfields  every surface is its nominal plane\n"
    "  --no-reentry           score packets at their first exit, as the 2019 program did\n"
    "boundaries\n"
    "  --boundaries KIND      auto (default), plane, cone or mesh\n"
    "  --tolerance T          relative bias to keep; heightmaps: height error / peak to valley; default "
    "1e-3;\n"
    "                         when given, a surface becomes a plane where trial packets (a second at most) "
    "show\n"
    "                         that this changes no total or profile by more\n"
    "  --mesh-budget N        triangles that the mesh of a boundary may have; default 4e6, or what fits into "
    "a "
    "quarter of\n"
    "                         the memory at 350 bytes each; a boundary that needs more is refused\n"
    "  --normals KIND         of a tessellated heightfield: analytic (default), vertex or facet\n"
    "  --rings KIND           of a tessellated heightfield: area (area-preserving, default) or "
    "inscribed\n"
    "  --mesh-search KIND     of engine cpu: auto (default; regular grids are walked, Embree elsewhere) or "
    "embree\n"
    "machine\n"
    "  --engine NAME          cpu (default), reference or opencl\n"
    "  --threads N            default: OMP_NUM_THREADS, or all cores\n"
    "  --chunk N              packets a thread or device takes at a time; never changes a result\n"
    "  --device I[,J...]|all  for opencl, see `devices`; default by local MPI rank, GPUs first\n"
    "  --group N              for opencl: work-items per group; never changes a result\n"
    "  --build-options TEXT   for opencl: for the device's compiler, behind ours\n"
    "  --checkpoint S|off     seconds between checkpoints of a run, default 60 (DIR/NAME.checkpoint)\n"
    "  --resume               continue from the checkpoint, on any number of ranks and threads\n"
    "  --patience S           under mpiexec or srun: end when a rank was silent for so long, default "
    "60\n"
    "output\n"
    "  -o, --output-dir DIR   where results go, default the current directory\n"
    "  --json                 one line with one object per run on standard output, nothing else "
    "there\n"
    "  --alpha A              level of `compare`: p below it is a difference, default 0.01\n"
    "  --dump FILE            for crosscheck: the photons that differ, for trace\n"
    "  --verbose              photons, idle and communication share of every rank\n"
    "  --caption TEXT         below the picture of `plot`\n"
    "  --of NAME              map of `plot`: Rd (default), Tt, or any array of the file\n"
    "  --log, --linear        scale of `plot`; default: curves log, maps as their range asks for\n"
    "  --quiet                no banner, progress or summary\n"
    "  --help, --version\n"
    "\n"
    "exit codes: 0 ok, 1 results differ, 2 usage or input, 3 device, 4 numerical (lost packets, "
    "books), 5 files or network,\n"
    "            75 stopped by a signal, --resume continues\n"
    "\n"
    "examples\n"
    "  clustermcml samples/mcml_sample.mci\n"
    "  clustermcml samples/shapes/hihill.mci --photons 1e7 -o results\n"
    "  clustermcml samples/ridges.mci --engine reference --photons 1e4 --json\n";

const char *cml_options_help(void)
{
    return help;
}

/* Every message names the option, what was given, and what was expected. */
static cml_status fail(struct cml_error *err, const char *option, const char *value, const char *expected)
{
    return cml_fail(err, CML_E_INPUT, "--%s %s (expected %s)", option, value, expected);
}

/* One of the words, whose position is *choice. */
static cml_status choose(const char *option, const char *value, const char *const *words, int *choice,
                         struct cml_error *err)
{
    char expected[128] = "one of";
    for (int i = 0; words[i]; i++) {
        if (strcmp(value, words[i]) == 0) {
            *choice = i;
            return CML_OK;
        }
        const size_t used = strlen(expected);
        snprintf(expected + used, sizeof expected - used, " %s", words[i]);
    }
    return fail(err, option, value, expected);
}

/* Counts may be written like 1e7; limits are part of the message. */
static cml_status count(const char *option, const char *value, uint64_t least, uint64_t most,
                        uint64_t *number, struct cml_error *err)
{
    char expected[96];
    snprintf(expected, sizeof expected, "a whole number from %llu to %llu", (unsigned long long)least,
             (unsigned long long)most);
    uint64_t read = 0;
    if (!cml_parse_count(value, &read) || read < least || read > most)
        return fail(err, option, value, expected);
    *number = read;
    return CML_OK;
}

/* What is flown, where and how. Upper limits: 2^48 photons is what a result holds, 2^53 what a seed may be
 * to survive as a number in JSON and HDF5. */
static cml_status parse_machine(int key, const char *value, struct cml_options *options,
                                struct cml_error *err)
{
    uint64_t number = 0;
    switch (key) {
    case KEY_PHOTONS:
        return count("photons", value, 1, (uint64_t)1 << 48, &options->photons, err);
    case KEY_SEED:
        return count("seed", value, 0, (uint64_t)1 << 53, &options->engine_options.seed, err);
    case KEY_RUN:
        return count("run", value, 1, UINT32_MAX, &options->run, err);
    case KEY_CHUNK:
        return count("chunk", value, 1, CML_TALLY_MAX_PHOTONS, &options->engine_options.chunk, err);
    case KEY_THREADS:
        CML_TRY(count("threads", value, 1, 4096, &number, err));
        options->engine_options.threads = (int)number;
        return CML_OK;
    case KEY_GROUP:
        CML_TRY(count("group", value, 1, 65536, &number, err));
        options->engine_options.group = (int)number;
        return CML_OK;
    case KEY_DEVICE:
        options->engine_options.device = value;
        return CML_OK;
    case KEY_BUILD_OPTIONS:
        options->engine_options.build_options = value;
        return CML_OK;
    default:
        options->engine = cml_engine_find(value);
        return options->engine ? CML_OK : fail(err, "engine", value, "cpu, reference or opencl");
    }
}

/* "A,B". */
static bool parse_pair(const char *value, double *a, double *b)
{
    char first[32];
    const char *comma = strchr(value, ',');
    const size_t length = comma ? (size_t)(comma - value) : sizeof first;
    if (length >= sizeof first) return false;
    memcpy(first, value, length);
    first[length] = '\0';
    return cml_parse_double(first, a) && cml_parse_double(comma + 1, b);
}

/* How packets draw and end: what changes the error of a result, and no expected value. */
static cml_status parse_sampling(int key, const char *value, struct cml_options *options,
                                 struct cml_error *err)
{
    static const char *const kinds[] = {"random", "lattice", NULL};
    struct cml_roulette_options *roulette = &options->engine_options.roulette;
    if (key == KEY_SAMPLING) {
        int choice = 0;
        CML_TRY(choose("sampling", value, kinds, &choice, err));
        options->engine_options.lattice = choice == 1;
        return CML_OK;
    }
    if (key == KEY_CONTROL) {
        options->control = strcmp(value, "flat") == 0;
        return options->control ? CML_OK : fail(err, "control", value, "flat");
    }
    *roulette = (struct cml_roulette_options){0, 0};
    if (strcmp(value, "mcml") == 0) return CML_OK;
    const bool sound = parse_pair(value, &roulette->below, &roulette->weight) && roulette->below >= 1e-6 &&
                       roulette->below <= roulette->weight && roulette->weight <= 1;
    return sound ? CML_OK : fail(err, "roulette", value, "mcml, or WR,WS with 1e-6 <= WR <= WS <= 1");
}

/* How boundaries are represented. A tolerance that the user gives also allows a boundary to be taken for a
 * plane where that is within it. */
static cml_status parse_surface(int key, const char *value, struct cml_options *options,
                                struct cml_error *err)
{
    static const char *const kinds[] = {"plane", "cone", "mesh", "auto", NULL};
    static const char *const normals[] = {"facet", "vertex", "analytic", NULL};
    static const char *const rings[] = {"area", "inscribed", NULL};
    static const char *const searches[] = {"auto", "embree", NULL};
    struct cml_tessellation *tessellation = &options->surface.tessellation;
    int choice = 0;
    if (key == KEY_MESH_BUDGET) {
        uint64_t most = 0;
        CML_TRY(count("mesh-budget", value, 1, (uint64_t)CML_MESH_MOST, &most, err));
        options->surface.budget.most = (double)most;
        return CML_OK;
    }
    if (key == KEY_TOLERANCE) {
        const bool number = cml_parse_double(value, &options->surface.tolerance);
        const bool sound = number && options->surface.tolerance >= 1e-12 && options->surface.tolerance <= 0.1;
        options->surface.may_flatten = true;
        return sound ? CML_OK : fail(err, "tolerance", value, "a number from 1e-12 to 0.1");
    }
    if (key == KEY_BOUNDARIES) {
        CML_TRY(choose("boundaries", value, kinds, &choice, err));
        options->surface.force = (enum cml_surface_kind)choice;
    } else if (key == KEY_NORMALS) {
        CML_TRY(choose("normals", value, normals, &choice, err));
        tessellation->normals = (enum cml_normals)choice;
    } else if (key == KEY_MESH_SEARCH) {
        CML_TRY(choose("mesh-search", value, searches, &choice, err));
        options->surface.search = (enum cml_mesh_search)choice;
    } else {
        CML_TRY(choose("rings", value, rings, &choice, err));
        tessellation->inscribed = choice == 1;
    }
    return CML_OK;
}

/* Zero would mean for ever in one place and never in another, so it is refused; `off` says it in words. */
static cml_status seconds(const char *option, const char *value, double *number, struct cml_error *err)
{
    if (cml_parse_double(value, number) && *number > 0 && *number <= 1e9) return CML_OK;
    return fail(err, option, value, "seconds above 0, up to 1e9");
}

/* When a run ends or is saved. --patience is the timeout after which a silent rank counts as lost. */
static cml_status parse_stopping(int key, const char *value, struct cml_options *options,
                                 struct cml_error *err)
{
    if (key == KEY_PATIENCE) return seconds("patience", value, &options->timeout, err);
    if (key == KEY_CHECKPOINT) {
        options->checkpoint_interval = 0;
        return strcmp(value, "off") == 0 ? CML_OK
                                         : seconds("checkpoint", value, &options->checkpoint_interval, err);
    }
    double *error = &options->target_error;
    if (cml_parse_double(value, error) && *error > 0 && *error < 1) return CML_OK;
    return fail(err, "target-error", value, "a relative error between 0 and 1");
}

/* 0 would never differ, 1 always. */
static cml_status parse_alpha(const char *value, struct cml_options *options, struct cml_error *err)
{
    const bool number = cml_parse_double(value, &options->alpha);
    return number && options->alpha > 0 && options->alpha < 1
               ? CML_OK
               : fail(err, "alpha", value, "a number above 0 and below 1");
}

/* Options without a value, which cannot be wrong. */
static void set_flag(int key, struct cml_options *options)
{
    if (key == KEY_IGNORE_ABSORPTION) options->engine_options.absorption = false;
    if (key == KEY_IGNORE_HEIGHTFIELDS) options->ignore_heightfields = true;
    if (key == KEY_NO_REENTRY) options->engine_options.reentry = false;
    if (key == KEY_LOG) options->scale = CML_SCALE_LOG;
    if (key == KEY_LINEAR) options->scale = CML_SCALE_LINEAR;
    if (key == KEY_RESUME) options->resume = true;
    if (key == KEY_VERBOSE) options->verbose = true;
    if (key == KEY_QUIET) options->quiet = true;
    if (key == KEY_JSON) options->json = true;
    if (key == KEY_HELP) options->help = true;
    if (key == KEY_VERSION) options->version = true;
}

/* By groups, because one function for all of them would be too long to read. */
static cml_status parse_one(int key, const char *value, struct cml_options *options, struct cml_error *err)
{
    switch (key) {
    case KEY_PHOTONS:
    case KEY_SEED:
    case KEY_RUN:
    case KEY_THREADS:
    case KEY_CHUNK:
    case KEY_ENGINE:
    case KEY_DEVICE:
    case KEY_GROUP:
    case KEY_BUILD_OPTIONS:
        return parse_machine(key, value, options, err);
    case KEY_BOUNDARIES:
    case KEY_TOLERANCE:
    case KEY_MESH_BUDGET:
    case KEY_NORMALS:
    case KEY_RINGS:
    case KEY_MESH_SEARCH:
        return parse_surface(key, value, options, err);
    case KEY_SAMPLING:
    case KEY_ROULETTE:
    case KEY_CONTROL:
        return parse_sampling(key, value, options, err);
    case KEY_TARGET_ERROR:
    case KEY_CHECKPOINT:
    case KEY_PATIENCE:
        return parse_stopping(key, value, options, err);
    case KEY_ALPHA:
        return parse_alpha(value, options, err);
    case KEY_CAPTION:
        options->caption = value;
        return CML_OK;
    case KEY_OF:
        options->of = value;
        return CML_OK;
    case KEY_OUTPUT:
    case 'o':
        options->output = value;
        return CML_OK;
    case KEY_DUMP:
        options->dump = value;
        return CML_OK;
    case 'h':
        options->help = true;
        return CML_OK;
    default:
        set_flag(key, options);
        return CML_OK;
    }
}

/* Whatever is not zero. */
static void set_defaults(struct cml_options *options)
{
    *options = (struct cml_options){.engine = cml_engine_find("cpu")};
    /* a level of one false alarm in a hundred comparisons */
    options->alpha = 0.01;
    /* a fixed seed, so that a run can be repeated by whoever has its file */
    options->engine_options.seed = 1;
    options->run = 1;
    options->engine_options.lattice = true;
    options->engine_options.roulette = (struct cml_roulette_options){0.003, 0.01};
    options->engine_options.reentry = true;
    options->engine_options.absorption = true;
    /* s: a minute of work may be lost, and a host that is busy must not be taken for a lost one */
    options->checkpoint_interval = 60;
    options->timeout = 60;
    options->surface.force = CML_SURFACE_AUTO;
    options->surface.tolerance = 1e-3;
    options->surface.tessellation.normals = CML_NORMALS_ANALYTIC;
    options->surface.budget.most = cml_mesh_budget_default();
}

/* Before getopt moves the operands behind the options. */
static void keep_command(int argc, char **argv, struct cml_options *options)
{
    size_t used = 0;
    for (int i = 0; i < argc && used < sizeof options->command; i++)
        used += (size_t)snprintf(options->command + used, sizeof options->command - used, "%s%s",
                                 i > 0 ? " " : "", argv[i]);
}

/* What getopt stumbled on. It may be a letter in a group like -xh, of which optind says nothing: optopt is
 * then that letter. A long option is the word before optind; optopt is then 0 or its key. */
static cml_status refuse(int key, const char *word, struct cml_error *err)
{
    const char letter[] = {'-', (char)optopt, '\0'};
    const char *option = optopt != 0 && optopt < KEY_PHOTONS ? letter : word;
    if (key == ':')
        return cml_fail(err, CML_E_INPUT, "%s is missing its value (try clustermcml --help)", option);
    return cml_fail(err, CML_E_INPUT, "unknown option %s (try clustermcml --help)", option);
}

/* getopt prints nothing (opterr) and sorts operands behind the options, so that both may mix. The colon in
 * front of the short options tells a missing value from an unknown option. */
cml_status cml_options_parse(int argc, char **argv, struct cml_options *options, struct cml_error *err)
{
    set_defaults(options);
    keep_command(argc, argv, options);
    opterr = 0;
    for (;;) {
        const int key = getopt_long(argc, argv, ":o:h", long_options, NULL);
        if (key == -1) break;
        if (key == '?' || key == ':') return refuse(key, argv[optind - 1], err);
        CML_TRY(parse_one(key, optarg, options, err));
    }
    options->operands = argv + optind;
    options->num_operands = argc - optind;
    return CML_OK;
}
