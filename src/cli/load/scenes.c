/* SPDX-License-Identifier: MIT */
#include "cli/load/scenes.h"

#include "engine/engines.h"
#include "engine/plane_trial.h"
#include "run/cluster/cluster.h"
#include "input/mci.h"
#include "input/sweep/sweep_table.h"
#include "run/cluster/launcher.h"
#include "output/report.h"
#include "base/print_line.h"
#include "base/text.h"
#include "scene/body/body_place.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

/* Checks the shapes of all scenes, just as they will be flown. */
static cml_status check_all(const struct cml_scene_list *list, struct cml_error *err)
{
    for (int i = 0; i < list->count; i++) CML_TRY(cml_scene_check_shapes(&list->scenes[i], err));
    return CML_OK;
}

/* least stack of the program in KiB; with 192 all samples and commands ran, and the compiler of PoCL, too
 * (x86-64, gcc 12) */
enum { LEAST_STACK = 256 };

cml_status cml_check_stack(struct cml_error *err)
{
    struct rlimit stack;
    if (getrlimit(RLIMIT_STACK, &stack) != 0 || stack.rlim_cur >= LEAST_STACK * (rlim_t)1024) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "ulimit -s is %llu KiB (expected %d or more)",
                    (unsigned long long)stack.rlim_cur / 1024, LEAST_STACK);
}

/* The receiver of this thread's notes in place of standard error; NULL: none. */
static _Thread_local struct cml_note_receiver receiver;

struct cml_note_receiver cml_notes_go_to(struct cml_note_receiver to)
{
    const struct cml_note_receiver before = receiver;
    receiver = to;
    return before;
}

/* Prints a note on standard error, with the number of the rank unless it is rank 0. */
void cml_show_note(void *context, const char *text)
{
    (void)context;
    if (receiver.to) {
        receiver.to(receiver.context, text);
        return;
    }
    char who[32] = "";
    if (cml_cluster_rank() > 0) snprintf(who, sizeof who, "rank %d: ", cml_cluster_rank());
    fprintf(stderr, "clustermcml: note: %s", who);
    cml_print_line(stderr, text);
}

/* Shows a note of the reader on rank 0 only, because all ranks read the same files. */
static void note_input(void *context, const char *text)
{
    if (cml_cluster_rank() == 0) cml_show_note(context, text);
}

/* True if the options make planes of all boundaries. */
static bool is_flat(const struct cml_options *options)
{
    return options->ignore_heightfields || options->surface.force == CML_SURFACE_PLANE;
}

/* Checks the table of --sweep. The table is an input like others, which all ranks read again later. */
static cml_status read_sweep(const struct cml_options *options, const struct cml_text_source *source,
                             struct cml_error *err)
{
    struct cml_sweep_table table = {.num_rows = 0};
    if (!options->sweep) return CML_OK;
    CML_TRY(cml_sweep_table_read(source, options->sweep, &table, err));
    cml_sweep_table_clear(&table);
    return CML_OK;
}

/* Refuses a setting of photons beside --photons: one of them would be ignored. */
static cml_status check_photons(const struct cml_options *options, const struct cml_settings *settings,
                                struct cml_error *err)
{
    const struct cml_setting *photons = cml_settings_find(settings, "photons");
    if (!photons || options->photons == 0) return CML_OK;
    return cml_setting_fail(photons, "no value beside that of --photons", err);
}

/* Reads the scenes of the input file with the settings of the options, and checks them. On failure *list is
 * empty. */
static cml_status load(const struct cml_options *options, const struct cml_text_source *source,
                       struct cml_scene_list *list, struct cml_error *err)
{
    const struct cml_input_options how = {.source = source,
                                          .tolerance = options->surface.tolerance,
                                          .budget = options->surface.budget,
                                          .settings = &options->settings,
                                          .output =
                                              options->which == CML_COMMAND_RUN ? options->output : NULL,
                                          .on_note = note_input,
                                          .flat = is_flat(options)};
    CML_TRY(check_photons(options, &options->settings, err));
    CML_TRY(cml_mci_read(options->operands[0], &how, list, err));
    cml_status status = check_all(list, err);
    if (status == CML_OK) status = read_sweep(options, source, err);
    if (status != CML_OK) cml_scene_list_clear(list);
    return status;
}

/* True if all boundaries have the same shape and depth, so that those found not to cross still do not. */
static bool lies_alike(const struct cml_scene *one, const struct cml_scene *other)
{
    for (int b = 0; b <= one->num_layers; b++)
        if (one->boundaries[b].z != other->boundaries[b].z ||
            !cml_boundary_same_shape(&one->boundaries[b], &other->boundaries[b]))
            return false;
    return true;
}

/* Copies a scene with other settings, for a row of a sweep. Shapes that the settings change are read again
 * from `inputs`, which keeps the bytes of all files. Overlaps are checked only if something has moved. */
cml_status cml_copy_scene(const struct cml_options *options, const struct cml_settings *settings,
                          const char *output, struct cml_inputs *inputs, const struct cml_scene *from,
                          struct cml_scene *scene, struct cml_error *err)
{
    const struct cml_text_source replay = cml_inputs_replayer(inputs);
    const struct cml_input_options how = {.source = &replay,
                                          .tolerance = options->surface.tolerance,
                                          .budget = options->surface.budget,
                                          .settings = settings,
                                          .output = output,
                                          .flat = is_flat(options)};
    CML_TRY(check_photons(options, settings, err));
    CML_TRY(cml_mci_copy(from, &how, scene, err));
    const cml_status status = lies_alike(scene, from) ? CML_OK : cml_scene_check_shapes(scene, err);
    if (status != CML_OK) cml_scene_clear(scene);
    return status;
}

/* Shows that a large mesh is being made: on a terminal at once; in a log only if the wait is as long as that
 * for the first line of progress. Only rank 0 shows it. */
static void show_large_mesh(void *context, const char *text, double seconds)
{
    const struct cml_options *options = context;
    if (options->quiet || options->json || cml_cluster_rank() != 0) return;
    if (isatty(STDERR_FILENO) || seconds >= 10) fprintf(stderr, "%s\n", text);
}

void cml_announce_meshes(struct cml_options *options)
{
    options->surface.budget.on_large = show_large_mesh;
    options->surface.budget.context = options;
}

cml_status cml_load_scenes(const struct cml_options *options, struct cml_scene_list *list,
                           struct cml_error *err)
{
    return load(options, NULL, list, err);
}

/* Reads the scenes and keeps the bytes of all files read, as a run does to resume and to send them to
 * ranks. */
cml_status cml_load_scenes_as_run(const struct cml_options *options, struct cml_scene_list *list,
                                  struct cml_inputs *inputs, struct cml_error *err)
{
    const struct cml_text_source record = cml_inputs_recorder(inputs);
    const cml_status status = load(options, &record, list, err);
    if (status != CML_OK) cml_inputs_clear(inputs);
    return status;
}

/* Sends the bytes of all files that rank 0 has read to the other ranks, which then read the scene from these
 * bytes. */
static cml_status share_inputs(struct cml_inputs *inputs, struct cml_error *err)
{
    char *block = NULL;
    size_t size = 0;
    cml_status status = CML_OK;
    const bool first = cml_cluster_rank() == 0;
    if (first) status = cml_inputs_pack(inputs, &block, &size, err);
    status = cml_cluster_agree(status, err);
    if (status == CML_OK) status = cml_cluster_share_block(&block, &size, err);
    if (status == CML_OK && !first) status = cml_inputs_unpack(block, size, inputs, err);
    free(block);
    return status;
}

/* Reads the scenes on rank 0, and on the other ranks from the same bytes. */
static cml_status load_shared(const struct cml_options *options, struct cml_scene_list *list,
                              struct cml_inputs *inputs, struct cml_error *err)
{
    const bool first = cml_cluster_rank() == 0;
    cml_status status = CML_OK;
    const struct cml_text_source record = cml_inputs_recorder(inputs), replay = cml_inputs_replayer(inputs);
    if (first) status = load(options, &record, list, err);
    CML_TRY(cml_cluster_agree(status, err));
    if (cml_cluster_size() > 1) status = share_inputs(inputs, err);
    if (status == CML_OK && !first) status = load(options, &replay, list, err);
    return cml_cluster_agree(status, err);
}

/* Reads the scenes on all ranks: only rank 0 opens files, the others get their bytes. */
cml_status cml_load_shared_scenes(const struct cml_options *options, struct cml_scene_list *list,
                                  struct cml_inputs *inputs, struct cml_error *err)
{
    *list = (struct cml_scene_list){0};
    *inputs = (struct cml_inputs){0};
    const cml_status status = load_shared(options, list, inputs, err);
    if (status == CML_OK) return CML_OK;
    cml_scene_list_clear(list);
    cml_inputs_clear(inputs);
    return status;
}

/* Reads the scenes and calls `fly` for each, with the number of threads chosen for this rank. */
cml_status cml_fly_scenes(const struct cml_options *options, cml_fly_scene *fly, struct cml_error *err)
{
    struct cml_options mine = *options;
    CML_AT_END(cml_scene_list_clear) struct cml_scene_list list = {0};
    struct cml_inputs inputs;
    mine.engine_options.threads = cml_choose_threads(options);
    mine.engine_options.local_rank = cml_cluster_local_rank();
    CML_TRY(cml_load_shared_scenes(options, &list, &inputs, err));
    cml_inputs_clear(&inputs);
    for (int i = 0; i < list.count; i++) CML_TRY(fly(&mine, &list.scenes[i], i, err));
    return CML_OK;
}

/* Makes the surfaces that a scene is flown with. With --tolerance, shapes too slight to matter become
 * planes. */
cml_status cml_choose_surfaces(const struct cml_options *options, const struct cml_scene *scene,
                               struct cml_surface_set *surfaces, struct cml_error *err)
{
    CML_TRY(cml_surfaces_create(scene, &options->surface, surfaces, err));
    const cml_status status = cml_make_harmless_planes(scene, &options->surface, cml_engine_find("cpu"),
                                                       &options->engine_options, surfaces, err);
    if (status != CML_OK) cml_surfaces_free(surfaces);
    return status;
}

/* Makes the path of an output: `name` in the folder of -o, unless the name is absolute. */
cml_status cml_output_path(const struct cml_options *options, const char *name, char **path,
                           struct cml_error *err)
{
    if (!options->directory || name[0] == '/') return cml_text_copy(name, path, err);
    return cml_text_format(path, "a path", err, "%s/%s", options->directory, name);
}

struct memory {
    /* Bytes on this machine: the most at any time, the tallies in flight, writing the results. */
    double most, tallies, output;
};

/* Sets the bytes that this process holds now, and the most it has held. getrusage would also count what the
 * process held that started this one. */
static void find_held(double *now, double *most)
{
    FILE *file = fopen("/proc/self/status", "r"); /* proc(5): sizes in kB */
    char line[256];
    double kibibytes;
    *now = *most = 0;
    while (file && fgets(line, sizeof line, file)) {
        if (sscanf(line, "VmHWM: %lf", &kibibytes) == 1) *most = 1024 * kibibytes;
        if (sscanf(line, "VmRSS: %lf", &kibibytes) == 1) *now = 1024 * kibibytes;
    }
    if (file) fclose(file);
}

/* Returns the most photons of a run. Photons flown before --more are not known here. */
static uint64_t most_photons(const struct cml_options *options, const struct cml_scene *scene)
{
    if (options->target_error > 0) return UINT64_MAX;
    return (options->photons ? options->photons : scene->photons) + options->more;
}

/* Estimates the largest memory that a run needs at one time. Reading, the flight and the writing of results
 * follow each other, and each frees its memory before the next begins. */
static struct memory memory_of(const struct cml_options *options, const struct cml_scene *scene,
                               const struct cml_surface_set *surfaces)
{
    struct cml_tally_grid grid = cml_engine_grid(scene, surfaces, &options->engine_options);
    grid.saved.limit = cml_most_saved(scene, most_photons(options, scene));
    const int asked = options->engine_options.threads;
    const int threads = asked > 0 ? asked : options->engine->threads(NULL);
    const double ranks = cml_cluster_local_size(),
                 world = surfaces ? options->engine->bytes(scene, surfaces) : 0;
    const double mib = 1048576;
    double now, so_far;
    find_held(&now, &so_far);
    struct memory memory = {.tallies = cml_run_bytes(&grid, threads) * ranks,
                            .output = cml_report_bytes(scene, &grid)};
    const double flight =
        ranks * (world + mib * (4 + threads)); /* threads' stacks and bundles of packets, libraries */
    /* the kernel does not count the last pages of each thread yet, so they are added to what it reports */
    const double counted = mib * (1 + threads);
    memory.most =
        fmax((so_far + counted) * ranks, now * ranks + memory.tallies + fmax(flight, memory.output));
    return memory;
}

/* Returns the most memory that a run will hold, in bytes. */
double cml_most_memory(const struct cml_options *options, const struct cml_scene *scene,
                       const struct cml_surface_set *surfaces)
{
    return memory_of(options, scene, surfaces).most;
}

/* Refuses a run that needs more memory than the machine has, before the run begins. */
cml_status cml_check_memory(const struct cml_options *options, const struct cml_scene *scene,
                            const struct cml_surface_set *surfaces, struct cml_error *err)
{
    const double bytes = cml_most_memory(options, scene, surfaces), gib = 1073741824.0;
    const double most = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    if (bytes < most) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "%s: %s takes %.3g GiB (expected at most this machine's %.3g GiB)",
                    scene->file, scene->output, bytes / gib, most / gib);
}

/* Prints the largest memory that a run will need, with the shares of sums and of writing files. */
void cml_print_memory(const struct cml_options *options, const struct cml_scene *scene,
                      const struct cml_surface_set *surfaces)
{
    const struct memory memory = memory_of(options, scene, surfaces);
    const double mib = 1048576;
    printf("  memory: at most %.0f MiB (tallies %.3g MiB, writing %.3g MiB)\n", memory.most / mib,
           memory.tallies / mib, memory.output / mib);
}

/* Prints what the reader changed on a mesh, so that the user can correct the file. Nothing if nothing was
 * changed. */
void cml_print_mesh_repairs(const char *owner, int number, const struct cml_mesh *mesh,
                            const struct cml_mesh_notes *notes)
{
    char name[32];
    snprintf(name, sizeof name, "%s %d", owner, number);
    if (notes->bent > 0)
        printf("    %s: %zu faces lie in no plane and were cut into triangles, corners up to %.3g "
               "cm off the face's mean plane\n",
               name, notes->bent, notes->bend);
    if (notes->joined > 0)
        printf("    %s: %zu corners were joined with others, up to %.3g cm away (weld=%g)\n", name,
               notes->joined, notes->join_distance, mesh->weld);
    if (notes->levelled > 0)
        printf("    %s: the mesh's border was levelled, its heights differed by %.3g cm\n", name,
               notes->levelled);
    if (notes->skirt > 0)
        printf("    %s: skirt of %g cm around the mesh to its border's mean height %g cm: %zu "
               "triangles, up to %.3g cm\n",
               name, mesh->skirt, 0.0 - mesh->z_border, notes->skirt, notes->skirt_rise);
}

void cml_print_repairs(const struct cml_scene *scene)
{
    for (int b = 0; b <= scene->num_layers; b++)
        cml_print_mesh_repairs("boundary", b, &scene->boundaries[b].mesh, &scene->boundaries[b].mesh_notes);
    for (int k = 0; k < scene->num_bodies; k++)
        cml_print_mesh_repairs("body", k + 1, &scene->bodies[k].mesh, &scene->bodies[k].mesh_notes);
}

/* Notes on rank 0 that there are more threads than cores, which slows a run: a usual mistake under mpiexec,
 * which binds processes to one core. */
static void warn_of_binding(int threads)
{
    struct cml_cores cores;
    char text[160];
    cml_cores_mine(&cores);
    const int count = cml_cores_count(&cores);
    if (threads <= count || cml_cluster_rank() != 0) return;
    snprintf(text, sizeof text,
             "%d threads on %d core%s (affinity of this process; under mpiexec try --bind-to none)", threads,
             count, count == 1 ? "" : "s");
    cml_show_note(NULL, text);
}

/* Returns the number of threads of this rank: that of --threads, else OMP_NUM_THREADS, else this rank's
 * share of the machine's cores. 0 leaves an odd value to OpenMP. */
int cml_choose_threads(const struct cml_options *options)
{
    const char *environment = getenv("OMP_NUM_THREADS");
    int threads = options->engine_options.threads;
    if (threads == 0 && environment && !cml_parse_int(environment, &threads)) return 0;
    warn_of_binding(threads);
    return threads > 0 ? threads : cml_cluster_fair_cores();
}
