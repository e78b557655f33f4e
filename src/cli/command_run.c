/* clustermcml run: every run of a file, one result each.
 * SPDX-License-Identifier: MIT */
#include "cli/command.h"

#include "base/atomic_file.h"
#include "cli/outputs.h"
#include "cli/progress.h"
#include "run/checkpoint.h"
#include "run/cluster.h"
#include "run/launcher.h"
#include "run/identity.h"
#include "output/hdf5_file.h"
#include "output/report.h"
#include "run/stop.h"
#include "base/text.h"
#include "base/version.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Planes and nothing else. */
static bool all_planes(const struct cml_surface_set *surfaces)
{
    if (surfaces->bodies.count > 0) return false;
    for (int b = 0; b < surfaces->count; b++)
        if (surfaces->item[b].kind != CML_SURFACE_PLANE) return false;
    return true;
}

/* Where all boundaries are flown as planes, what would come out without noise: a little finer than the run's
 * own errors, and none where that takes longer than it is worth. It is in no file. */
static cml_status solve_flat(struct cml_report *report, struct cml_exact *exact, struct cml_error *err)
{
    const struct cml_surface_set *surfaces = report->surfaces;
    const struct cml_result *result = &report->run->result;
    struct cml_exact_options options = {.tolerance = 1, .most_work = CML_EXACT_LITTLE_WORK};
    static const enum cml_total totals[] = {CML_TOTAL_REFLECTED, CML_TOTAL_ABSORBED, CML_TOTAL_TRANSMITTED};
    for (size_t i = 0; i < sizeof totals / sizeof *totals; i++)
        options.tolerance = fmin(options.tolerance, fmax(1e-7, 0.1 * cml_result_error(result, totals[i])));
    if (!all_planes(surfaces)) return CML_OK;
    double *depth = malloc((size_t)surfaces->count * sizeof *depth);
    if (!depth) return cml_fail_memory(err, surfaces->count * (double)sizeof *depth, "depths");
    for (int b = 0; b < surfaces->count; b++) depth[b] = surfaces->item[b].depth;
    const cml_status status = cml_exact_scene(report->scene, depth, &options, exact, err);
    free(depth);
    if (status == CML_OK) report->exact = exact;
    return status == CML_E_NUMERIC ? CML_OK : status;
}

/* Files first: what is printed is then true. A run with lost packets or an imbalance is written all the
 * same, and its status comes last. */
static cml_status publish(const struct cml_options *options, struct cml_report *report, struct cml_error *err)
{
    struct cml_exact exact = {0};
    char *path = NULL;
    CML_TRY(cml_output_path(options, report->scene->output, &path, err));
    cml_status status = cml_report_write(report, path, err);
    free(path);
    if (status == CML_OK && (options->json || !options->quiet)) status = solve_flat(report, &exact, err);
    if (status == CML_OK && options->json) status = cml_report_json(stdout, report, err);
    if (status == CML_OK && !options->quiet && !options->json) {
        cml_report_summary(stdout, report);
        if (options->verbose) cml_report_ranks(stdout, report->run);
        for (int i = 0; i < report->num_files; i++) printf("  -> %s\n", report->files[i]);
    }
    cml_exact_clear(&exact);
    cml_report_clear(report);
    return status == CML_OK ? cml_run_verdict(report->scene, &report->run->result, err) : status;
}

/* Before the run, so that a wrong input shows in its first second and not after hours. */
static void announce(const struct cml_options *options, const struct cml_run_setup *setup)
{
    if (options->quiet || options->json || cml_cluster_rank() != 0) return;
    const struct cml_scene *scene = setup->scene;
    printf("%s: %g photons, %d layer%s, %s engine, seed %llu\n", scene->output, (double)setup->photons,
           scene->num_layers, scene->num_layers == 1 ? "" : "s", setup->engine->name,
           (unsigned long long)setup->options.seed);
    cml_report_boundaries(stdout, "  ", scene, setup->surfaces, CML_NAMED_BY_PATH);
    for (int b = 0; b <= scene->num_layers; b++) cml_print_mesh_repairs(scene, b);
    if (cml_report_wants_fields(scene) && !cml_hdf5_available())
        printf("  no .h5 file: this program was built without HDF5\n");
    cml_print_memory(options, scene, setup->surfaces);
    fflush(stdout);
}

/* What all runs of one call share. */
struct session {
    const struct cml_options *options;
    struct cml_scene_list list;
    char *inputs;               /* lines of their identity */
    struct cml_outputs outputs; /* rank 0's */
};

/* Options that differ between ranks would mix two runs in one result. */
static cml_status check_same(const char *identity, struct cml_error *err)
{
    char *first = (char *)identity;
    size_t size = strlen(identity) + 1;
    CML_TRY(cml_cluster_share_block(&first, &size, err));
    cml_status status = CML_OK;
    if (strcmp(first, identity) != 0)
        status = cml_fail(err, CML_E_INPUT,
                          "rank %d has another program or other options than rank 0 (expected the same)",
                          cml_cluster_rank());
    if (first != identity) free(first);
    return cml_cluster_agree(status, err);
}

/* It will be overwritten, which may not be what the user wants. */
static void note_old_checkpoint(const struct cml_options *options, const char *path)
{
    if (options->resume || access(path, F_OK) != 0) return;
    char text[512];
    snprintf(text, sizeof text, "%.400s is of a run that was stopped; without --resume it begins anew", path);
    cml_show_note(NULL, text);
}

/* On rank 0. The checkpoint of a finished run says that it is finished, so that --resume of a file with
 * several runs goes on with the next; that of the last run is not needed, as all are removed then. */
static cml_status publish_run(const struct session *session, int index, const struct cml_run_setup *setup,
                              const struct cml_run_result *run, const struct cml_run_result *twin,
                              const struct cml_controlled *control, struct cml_error *err)
{
    const struct cml_options *options = session->options;
    if (cml_cluster_rank() != 0) return CML_OK;
    if (run->finished) {
        if (!options->quiet && !options->json) printf("  finished before\n");
        return CML_OK;
    }
    struct cml_report report = {.scene = setup->scene,
                                .surfaces = setup->surfaces,
                                .run = run,
                                .engine = setup->engine,
                                .options = &setup->options,
                                .control = control,
                                .control_processor = twin ? cml_run_processor(twin) : 0,
                                .command = options->command};
    CML_TRY(publish(options, &report, err));
    if (!setup->checkpoint || index + 1 == session->list.count) return CML_OK;
    const struct cml_run_state nothing = {.begin = 0};
    return cml_checkpoint_write(setup->checkpoint, setup->identity, &nothing, NULL, err);
}

/* The flat twin's flight lies between the run's and its publication. That the twin's books balance is looked
 * at last, as the run's own results are good without it. */
static cml_status control_run(const struct session *session, int index, const struct cml_run_setup *setup,
                              const struct cml_run_result *run, const struct cml_twin *twin,
                              struct cml_error *err)
{
    struct cml_run_result flight;
    struct cml_controlled control[CML_NUM_TOTALS];
    CML_TRY(cml_twin_fly(twin, setup, &run->result, &flight, control, err));
    cml_status status = publish_run(session, index, setup, run, &flight, control, err);
    if (status == CML_OK && cml_cluster_rank() == 0)
        status = cml_run_verdict(&twin->scene, &flight.result, err);
    cml_run_result_free(&flight);
    return status;
}

/* One run on all ranks. */
static cml_status fly(const struct session *session, int index, const struct cml_run_setup *setup,
                      const struct cml_twin *twin, struct cml_error *err)
{
    struct cml_run_result run;
    if (setup->checkpoint && cml_cluster_rank() == 0)
        note_old_checkpoint(session->options, setup->checkpoint);
    announce(session->options, setup);
    CML_TRY(check_same(setup->identity, err));
    CML_TRY(cml_run(setup, &run, err));
    cml_status status = setup->keep && !run.finished
                            ? control_run(session, index, setup, &run, twin, err)
                            : publish_run(session, index, setup, &run, NULL, NULL, err);
    if (status == CML_OK && twin->checkpoint && cml_cluster_rank() == 0)
        cml_checkpoint_remove(twin->checkpoint);
    cml_run_result_free(&run);
    return cml_cluster_agree(status, err);
}

/* Of what is written to a device there is nothing to continue. */
static bool uses_checkpoints(const struct cml_options *options, const struct cml_scene *scene)
{
    return (options->checkpoint_interval > 0 || options->resume) && !cml_file_is_device(scene->output);
}

/* Beside the output, under its name. */
static cml_status checkpoint_path(const struct cml_options *options, const struct cml_scene *scene,
                                  char **path, struct cml_error *err)
{
    char *output = NULL;
    CML_TRY(cml_output_path(options, scene->output, &output, err));
    const cml_status status = cml_checkpoint_path(output, path, err);
    free(output);
    return status;
}

/* Everything that may fail on one rank alone happens before the ranks agree. */
static cml_status prepare(const struct session *session, int index, struct cml_surface_set *surfaces,
                          char **checkpoint, char **identity, struct cml_twin *twin,
                          struct cml_run_setup *setup, struct cml_error *err)
{
    const struct cml_options *options = session->options;
    CML_TRY(cml_choose_surfaces(options, setup->scene, surfaces, err));
    CML_TRY(cml_check_memory(options, setup->scene, surfaces, err));
    setup->surfaces = surfaces;
    setup->options.run = (uint32_t)index;
    setup->keep = options->control && !all_planes(surfaces);
    CML_TRY(cml_identity_of(setup, &options->surface, options->ignore_heightfields, session->inputs, identity,
                            err));
    setup->identity = *identity;
    if (uses_checkpoints(options, setup->scene))
        CML_TRY(checkpoint_path(options, setup->scene, checkpoint, err));
    setup->checkpoint = *checkpoint;
    return setup->keep ? cml_twin_create(options, setup, twin, err) : CML_OK;
}

/* The run flies all the same, for other runs of the file may have shapes. */
static void note_nothing_to_control(const struct cml_scene *scene)
{
    char text[512];
    snprintf(text, sizeof text, "%.400s: --control flat has nothing to do where all boundaries are planes",
             scene->output);
    if (cml_cluster_rank() == 0) cml_show_note(NULL, text);
}

/* What prepare made is freed whether it was complete or not; nothing here may return before all ranks
 * agree. */
static cml_status run_scene(const struct session *session, int index, struct cml_error *err)
{
    const struct cml_options *options = session->options;
    const struct cml_scene *scene = &session->list.scenes[index];
    struct cml_display display = {.quiet = options->quiet || options->json,
                                  .terminal = isatty(STDERR_FILENO)};
    struct cml_run_setup setup = {.scene = scene,
                                  .engine = options->engine,
                                  .options = options->engine_options,
                                  .photons = options->photons ? options->photons : scene->photons,
                                  .target_error = options->target_error,
                                  .interval = options->checkpoint_interval,
                                  .resume = options->resume,
                                  .on_progress = cml_progress_show,
                                  .on_note = cml_show_note,
                                  .context = &display};
    struct cml_surface_set surfaces = {0};
    char *checkpoint = NULL, *identity = NULL;
    struct cml_twin twin = {.checkpoint = NULL};
    cml_status status = prepare(session, index, &surfaces, &checkpoint, &identity, &twin, &setup, err);
    status = cml_cluster_agree(status, err);
    if (status == CML_OK && options->control && !setup.keep) note_nothing_to_control(scene);
    if (status == CML_OK) status = fly(session, index, &setup, &twin, err);
    cml_twin_clear(&twin);
    cml_surfaces_free(&surfaces);
    free(checkpoint);
    free(identity);
    return status;
}

/* Found before the photons fly, not after: a grid that does not fit, an output that cannot be written. */
static cml_status check_runs(struct session *session, const struct cml_inputs *inputs, struct cml_error *err)
{
    const struct cml_scene_list *list = &session->list;
    cml_status status = CML_OK;
    for (int i = 0; status == CML_OK && i < list->count; i++)
        status = cml_check_memory(session->options, &list->scenes[i], NULL, err);
    if (status == CML_OK && cml_cluster_rank() == 0)
        status = cml_outputs_claim(session->options, list, inputs, cml_show_note, &session->outputs, err);
    return cml_cluster_agree(status, err);
}

/* More threads than cores take turns and are slow; under mpiexec it is the usual mistake,
 * and rank 0 speaks for all. */
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

int cml_choose_threads(const struct cml_options *options)
{
    const char *environment = getenv("OMP_NUM_THREADS");
    int threads = options->engine_options.threads;
    if (threads == 0 && environment && !cml_parse_int(environment, &threads)) return 0;
    warn_of_binding(threads);
    return threads > 0 ? threads : cml_cluster_fair_cores();
}

/* A finished run needs no checkpoint. */
static void remove_checkpoints(const struct session *session)
{
    struct cml_error ignored;
    for (int i = 0; cml_cluster_rank() == 0 && i < session->list.count; i++) {
        char *path = NULL;
        if (checkpoint_path(session->options, &session->list.scenes[i], &path, &ignored) == CML_OK)
            cml_checkpoint_remove(path);
        free(path);
    }
}

/* Signals are watched only where a checkpoint can follow them; else they end the program as usual. */
static cml_status run_all(const struct session *session, struct cml_error *err)
{
    const struct cml_options *options = session->options;
    if (options->checkpoint_interval > 0) cml_stop_watch();
    if (cml_cluster_rank() == 0 && !options->quiet && !options->json)
        printf("clustermcml %s, %d rank%s\n", cml_version(), cml_cluster_size(),
               cml_cluster_size() == 1 ? "" : "s");
    for (int i = 0; i < session->list.count; i++) CML_TRY(run_scene(session, i, err));
    if (options->checkpoint_interval > 0 || options->resume) remove_checkpoints(session);
    return CML_OK;
}

/* The bytes of the input are needed for the identity only, and freed before the run. */
cml_status cml_command_run(const struct cml_options *options, struct cml_error *err)
{
    struct cml_options mine = *options;
    struct session session = {.options = &mine};
    struct cml_inputs inputs;
    if (options->control && options->ignore_heightfields)
        return cml_fail(err, CML_E_INPUT, "--control flat (expected no --ignore-heightfields beside it)");
    mine.engine_options.threads = cml_choose_threads(options);
    mine.engine_options.local_rank = cml_cluster_local_rank();
    CML_TRY(cml_load_shared_scenes(options, &session.list, &inputs, err));
    cml_status status = cml_cluster_agree(cml_identity_inputs(&inputs, &session.inputs, err), err);
    if (status == CML_OK) status = check_runs(&session, &inputs, err);
    cml_inputs_clear(&inputs);
    if (status == CML_OK) status = run_all(&session, err);
    cml_outputs_release(&session.outputs);
    free(session.inputs);
    cml_scene_list_clear(&session.list);
    return status;
}
