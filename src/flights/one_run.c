/* SPDX-License-Identifier: MIT */
#include "flights/one_run.h"

#include "base/atomic_file.h"
#include "flights/before.h"
#include "flights/progress.h"
#include "simulation/beam_notes.h"
#include "simulation/check.h"
#include "simulation/simulation.h"
#include "output/report.h"
#include "run/cluster/cluster.h"
#include "run/identity.h"
#include "run/join.h"
#include "run/stop.h"
#include "tally/row_result.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Computes the exact totals if all boundaries are flown as planes, with errors a little below those of the
 * run. Gives up if that takes long. The totals are printed, but no file has them. */
static cml_status solve_flat(struct cml_report *report, struct cml_exact *exact, struct cml_error *err)
{
    const struct cml_surface_set *surfaces = report->surfaces;
    struct cml_exact_options options = {
        .tolerance = 1, .most_work = CML_EXACT_LITTLE_WORK, .walks = CML_EXACT_FEW_WALKS};
    for (int i = 0; i < CML_NUM_GOALS; i++)
        options.tolerance =
            fmin(options.tolerance, fmax(1e-7, 0.1 * cml_result_error(report->sums, cml_goals[i])));
    if (!cml_surfaces_are_planes(surfaces) || !cml_exact_knows(report->scene, surfaces->item->depth))
        return CML_OK;
    CML_FREED double *depth = NULL;
    CML_TRY(cml_zeros(&depth, (size_t)surfaces->count, sizeof *depth, "depths", err));
    for (int b = 0; b < surfaces->count; b++) depth[b] = surfaces->item[b].depth;
    const cml_status status = cml_exact_scene(report->scene, depth, &options, exact, err);
    if (status == CML_OK) report->exact = exact;
    return status == CML_E_NUMERIC ? CML_OK : status;
}

/* Prints the summary of a run for people, and the names of its files. */
static void print_summary(const struct cml_options *options, const struct cml_report *report)
{
    cml_report_summary(stdout, report);
    cml_report_print_derivatives(stdout, report);
    if (options->verbose) cml_report_ranks(stdout, report->timing);
    for (int i = 0; i < report->num_files; i++) printf("  -> %s\n", report->files[i]);
}

/* Notes why derivatives with respect to mua are missing (NaN) for clear media that trap light (P17). */
static void note_trapped(const struct cml_report *report)
{
    const double packets = (double)report->sums->summary.count[CML_COUNT_TRAPPED];
    if (!report->sums->grid.derivatives || !(packets > 0)) return;
    cml_note(
        "%.200s: derivatives by mua of clear media are NaN, as %.0f packet%s given up as trapped in one, "
        "on a path without an end (a small mua there has a derivative)",
        report->scene->output, packets, packets > 1 ? "s were" : " was");
}

static cml_status write_files(const struct cml_options *options, struct cml_report *report,
                              struct cml_error *err)
{
    CML_FREED char *path = NULL;
    CML_TRY(cml_output_path(options, report->scene->output, &path, err));
    return cml_report_write(report, path, err);
}

/* Writes the files of a run and then prints its summary, so that the printed text is true. A run with lost
 * packets or an imbalance is written, too; its status is returned last. */
static cml_status publish(const struct cml_run_call *call, struct cml_report *report,
                          struct cml_record *record, struct cml_error *err)
{
    const struct cml_options *options = call->options;
    struct cml_exact exact = {0};
    cml_status status = options->receiver ? options->receiver->take(options->receiver->context, report, err)
                                          : write_files(options, report, err);
    if (status == CML_OK && call->row == 0 && (options->json || !options->quiet))
        status = solve_flat(report, &exact, err);
    if (status == CML_OK) status = cml_report_record(report, record, err);
    if (status == CML_OK) note_trapped(report);
    if (status == CML_OK && call->row == 0 && !options->quiet && !options->json)
        print_summary(options, report);
    cml_exact_clear(&exact);
    cml_report_clear(report);
    return status == CML_OK ? cml_run_verdict(report->scene, report->sums, err) : status;
}

/* Prints the scene before the flight, so that wrong input shows in the first second and not after hours. */
static void announce(const struct cml_simulation *sim)
{
    const struct cml_options *options = sim->options;
    const struct cml_run_setup *setup = &sim->setup;
    if (options->quiet || options->json || cml_cluster_rank() != 0) return;
    const struct cml_scene *scene = setup->scene;
    printf("%s: %s%g photons, %d layer%s, %s engine, seed %llu\n", scene->output,
           setup->target_error > 0 ? "at least " : "", (double)setup->photons, scene->num_layers,
           scene->num_layers == 1 ? "" : "s", setup->engine->name, (unsigned long long)setup->options.seed);
    cml_report_phases(stdout, "  ", scene, CML_READ_BY_PEOPLE);
    cml_report_top(stdout, "  ", scene, CML_READ_BY_PEOPLE);
    cml_report_shapes(stdout, "  ", scene, setup->surfaces, CML_READ_BY_PEOPLE);
    cml_print_repairs(stdout, scene);
    if (setup->part.count > 0)
        printf("  part %" PRIu64 " of %" PRIu64 "\n", setup->part.number, setup->part.count);
    const struct cml_options all = cml_all_photons(sim);
    cml_print_memory(stdout, &all, scene, setup->surfaces);
    fflush(stdout);
}

/* Makes the record of a run that was finished before. */
static cml_status take_record(const struct cml_run_call *call, const struct cml_record *before,
                              struct cml_record *record, struct cml_error *err)
{
    CML_FREED char *path = NULL;
    CML_TRY(cml_output_path(call->options, call->scene->output, &path, err));
    return cml_report_record_again(call->scene, path, before, record, err);
}

/* Prints the name of one output file. */
static cml_status print_path(void *context, const struct cml_report_file *file, struct cml_error *err)
{
    (void)context;
    (void)err;
    printf("  -> %s\n", file->path);
    return CML_OK;
}

/* Prints the paths of the results of a run that was finished before. */
static cml_status say_finished(const struct cml_run_call *call, const struct cml_run_setup *setup,
                               struct cml_error *err)
{
    CML_FREED char *path = NULL;
    CML_TRY(cml_output_path(call->options, call->scene->output, &path, err));
    printf("  finished before: nothing was written, its results stand\n");
    const struct cml_report_asks asks = cml_report_asks_of(setup);
    return cml_report_each_file(setup->scene, setup->surfaces, &asks, path, print_path, NULL, err);
}

/* True if the run could have an aim, but has none. */
static bool may_aim(const struct cml_run_setup *setup)
{
    return !setup->options.tail && !setup->options.windows && strcmp(setup->engine->name, "opencl") != 0;
}

/* Publishes a run on rank 0. Its checkpoint then says that the run is finished, so that --resume skips it;
 * with --keep the checkpoint also has the tallies, and must be written. */
static cml_status publish_run(const struct cml_run_call *call, struct cml_simulation *sim,
                              struct cml_record *record, struct cml_error *err)
{
    const struct cml_options *options = call->options;
    const struct cml_run_setup *setup = &sim->setup;
    struct cml_run_result *run = &sim->flown;
    if (cml_cluster_rank() != 0) return CML_OK;
    if (run->intent == CML_RUN_NOTHING_LEFT) {
        if (!setup->result_stands) CML_TRY(take_record(call, &run->record, record, err));
        /* left by a process that was killed before it removed the file */
        cml_checkpoint_remove_older(setup->checkpoint);
        const bool says = !options->quiet && !options->json && call->row == 0;
        return says ? say_finished(call, setup, err) : CML_OK;
    }
    struct cml_report report = cml_simulation_report(sim);
    report.row = call->row;
    if (may_aim(setup)) report.flat_below = cml_aim_proposal(setup->scene, setup->surfaces, &run->result);
    if (call->row == 0 && !options->quiet && !options->json && may_aim(setup) && !setup->options.derivatives)
        report.unseen = cml_aim_unseen(setup->scene, setup->surfaces, &run->result);
    /* CML_RUN_REPUBLISH: the tallies of the checkpoint stay */
    const bool tallies = options->keep || run->intent == CML_RUN_REPUBLISH;
    CML_TRY(publish(call, &report, record, err));
    if (!setup->checkpoint || !call->stays) return CML_OK;
    if (call->pending && !tallies)
        return cml_pending_add(call->pending, setup->checkpoint, setup->identity, &run->state, record, err);
    const cml_status status = cml_checkpoint_finish(setup->checkpoint, setup->identity, &run->state, record,
                                                    tallies ? &run->result : NULL, err);
    if (status == CML_OK || options->keep) return status;
    cml_show_note(NULL, err->text);
    cml_checkpoint_remove(setup->checkpoint); /* the result is written, so the run must not look stopped */
    return CML_OK;
}

/* Rows of a sweep in which fewer than LEAST_PACKETS effective packets make up one quantity: a total, or the
 * sum of A_z. The standard error of the quantity is itself uncertain there. */
struct poor_rows {
    int count, row; /* the row with the fewest packets, from 0 */
    double packets; /* effective packets of this row */
};
#define LEAST_PACKETS 100
enum { POOR_A_Z = CML_NUM_GOALS, NUM_POOR };

/* Counts the rows that too few effective packets reached, and keeps the worst of them. */
static void add_poor(double packets, int row, struct poor_rows *poor)
{
    if (packets >= LEAST_PACKETS || (poor->count++ > 0 && packets >= poor->packets)) return;
    poor->row = row;
    poor->packets = packets;
}

/* Notes for each total if too few effective packets carry the result of row `row`; `poor` keeps count and
 * the worst row. */
static void find_poor(const struct cml_result *flight, const struct cml_result *result, int row,
                      struct poor_rows poor[NUM_POOR])
{
    for (int i = 0; i < CML_NUM_GOALS; i++)
        if (cml_result_total(flight, cml_goals[i]) > 0)
            add_poor(cml_effective_packets(result, cml_goals[i]), row, &poor[i]);
    if (result->A_z && cml_result_total(result, CML_TOTAL_ABSORBED) > 0)
        add_poor(cml_effective_packets_by_depth(result), row, &poor[POOR_A_Z]);
}

/* Shows a note for each quantity whose value rests on too few packets in some rows of a sweep. Rows that
 * share a flight weigh its packets differently, and few packets may carry nearly all weight. */
static void note_poor(const struct cml_run_rows *rows, const struct poor_rows poor[NUM_POOR])
{
    for (int i = 0; i < NUM_POOR; i++) {
        const enum cml_quantity quantity =
            i == POOR_A_Z ? CML_QUANTITY_A_z : cml_quantity_of_total((int)cml_goals[i]);
        const char *name = cml_quantities[quantity].name;
        if (poor[i].count == 0) continue;
        cml_note("%s of %d of %d rows comes of fewer than %d effective packets, that of row %d of %.0f "
                 "packets: there its standard error is rough",
                 name, poor[i].count, rows->count, LEAST_PACKETS, poor[i].row + 1, poor[i].packets);
    }
}

/* Writes the files of row i of a flight that several rows share, and notes where its packets are too few. */
static cml_status publish_row(const struct cml_run_call *call, const struct cml_simulation *sim, int i,
                              struct poor_rows *poor, struct cml_error *err)
{
    const struct cml_run_rows *rows = call->rows;
    const struct cml_run_result *run = &sim->flown;
    struct cml_result result;
    CML_TRY(cml_row_result(&run->result, i, &result, err));
    struct cml_report report = {.scene = rows->scene[i],
                                .surfaces = &sim->surfaces,
                                .sums = &result,
                                .timing = &run->timing,
                                .provenance = &sim->provenance,
                                .row = rows->number[i] + 1,
                                .command = call->options->command};
    const cml_status status = publish(call, &report, &rows->record[i], err);
    if (status == CML_OK || status == CML_E_NUMERIC) find_poor(&run->result, &result, rows->number[i], poor);
    cml_result_free(&result);
    return status;
}

/* Publishes all rows of a flight on rank 0, even if weights of a row do not balance. After a signal it stops
 * if the checkpoint of the flight holds all rows. */
static cml_status publish_rows(const struct cml_run_call *call, const struct cml_simulation *sim,
                               struct cml_error *err)
{
    const struct cml_run_setup *setup = &sim->setup;
    struct poor_rows poor[NUM_POOR] = {{0}};
    cml_status worst = CML_OK;
    for (int i = 0; cml_cluster_rank() == 0 && i < call->rows->count; i++) {
        struct cml_error why;
        if (setup->checkpoint && cml_stop_requested())
            return cml_fail(err, CML_E_STOPPED, "%s: stopped with %d of %d rows to write; --resume continues",
                            setup->scene->output, call->rows->count - i, call->rows->count);
        const cml_status status = publish_row(call, sim, i, poor, &why);
        if (status != CML_OK) *err = why;
        if (status == CML_E_NUMERIC) worst = status;
        if (status != CML_OK && status != CML_E_NUMERIC) return status;
    }
    if (setup->checkpoint && cml_cluster_rank() == 0) cml_checkpoint_remove_older(setup->checkpoint);
    note_poor(call->rows, poor);
    return worst;
}

/* A run of the program, with its checkpoint and files. */
struct own {
    struct cml_simulation sim;
    char *checkpoint, *base_identity;
    struct cml_before before; /* files that were there before the run, on rank 0 only */
};

/* Ends a complete part on rank 0: removes the older checkpoint, and prints the time and the part's file. */
static void say_part(const struct cml_run_call *call, const struct cml_simulation *sim)
{
    const char *path = sim->setup.checkpoint;
    const struct cml_run_result *run = &sim->flown;
    if (cml_cluster_rank() != 0) return;
    cml_checkpoint_remove_older(path);
    if (call->options->quiet || call->row > 0) return;
    if (run->intent == CML_RUN_NOTHING_LEFT)
        printf("  finished before\n");
    else
        printf("  %.3g s, %.0f photons\n", run->timing.seconds,
               (double)run->result.summary.count[CML_COUNT_PHOTONS]);
    printf("  -> %s\n", path);
}

/* Takes the sums of the run's parts in place of a flight. If the call has only one run, all files must be
 * parts of it. */
static cml_status join(const struct cml_run_call *call, struct cml_simulation *sim, struct cml_error *err)
{
    return cml_run_join(&sim->setup, call->options->joined, call->only, &sim->flown, err);
}

/* Flies or joins the run and publishes it, on all ranks. `merge` first only looks at all parts. Signals are
 * remembered only if a checkpoint can be written. */
static cml_status fly(const struct cml_run_call *call, struct own *run, struct cml_record *record,
                      struct cml_error *err)
{
    struct cml_simulation *sim = &run->sim;
    const struct cml_run_setup *setup = &sim->setup;
    if (cml_part_files_looking(call->options->joined)) return join(call, sim, err);
    if ((setup->base == 0 || setup->part.count > 0) && cml_cluster_rank() == 0)
        cml_before_note(call->options, setup, call->row, &run->before);
    if (call->options->checkpoint_interval > 0) cml_stop_watch();
    if (call->row == 0) announce(sim);
    CML_TRY(call->options->joined ? join(call, sim, err) : cml_simulation_fly(sim, 0, err));
    if (setup->part.count > 0) {
        say_part(call, sim);
        return CML_OK;
    }
    const cml_status status = call->rows ? publish_rows(call, sim, err) : publish_run(call, sim, record, err);
    return cml_cluster_agree(status, err);
}

/* True if the run has checkpoints. Output to a device has none, because it cannot be continued. */
static bool uses_checkpoints(const struct cml_options *options, const struct cml_scene *scene)
{
    return (options->checkpoint_interval > 0 || options->resume || options->keep || options->parts > 0) &&
           !cml_file_is_device(scene->output);
}

bool cml_run_leaves_checkpoints(const struct cml_options *options)
{
    return options->resume || options->keep || options->parts > 0;
}

cml_status cml_run_checkpoint(const struct cml_options *options, const struct cml_scene *scene, char **path,
                              struct cml_error *err)
{
    CML_FREED char *output = NULL;
    CML_TRY(cml_output_path(options, scene->output, &output, err));
    return cml_checkpoint_of(options, output, path, err);
}

cml_status cml_checkpoint_of(const struct cml_options *options, const char *output, char **path,
                             struct cml_error *err)
{
    const struct cml_part part = {options->part, options->parts};
    return part.count > 0 ? cml_part_path(output, part, path, err) : cml_checkpoint_path(output, path, err);
}

/* ---- --more ---- */

static cml_status fail_more(const char *path, const char *what, struct cml_error *err)
{
    return cml_fail(err, CML_E_INPUT, "--more: %s %s", path, what);
}

/* Finds on rank 0 how many photons the run of --more has, from the checkpoint that it extends. With
 * --resume, an extension by the same number of photons is the same run, and goes on. */
static cml_status plan_more(const struct cml_options *options, struct cml_run_setup *setup, const char *path,
                            struct cml_error *err)
{
    const struct cml_checkpoint_about about = cml_checkpoint_look(path);
    const bool part = options->parts > 0,
               same = !part && options->resume && about.begin > 0 && about.end - about.begin == options->more;
    setup->photons = about.end;
    if (about.kind == CML_CHECKPOINT_NONE && access(path, F_OK) == 0)
        return fail_more(path, "is damaged (expected the checkpoint of a run that was flown with --keep)",
                         err);
    if (about.kind == CML_CHECKPOINT_NONE)
        return fail_more(path, "is not there (expected the checkpoint of a run that was flown with --keep)",
                         err);
    if (about.kind == CML_CHECKPOINT_PARTIAL && !same)
        return fail_more(path, "is of a run that was stopped: --resume continues it", err);
    if (same) return CML_OK;
    if (!about.tallies)
        return fail_more(path, "has no tallies (expected the checkpoint of a run that was flown with --keep)",
                         err);
    setup->base = about.end;
    setup->photons = about.end + options->more;
    setup->resume = part && options->resume;
    if (setup->photons > (uint64_t)1 << 48)
        return cml_fail(err, CML_E_INPUT,
                        "--more %" PRIu64 " (expected at most 2^48 photons together with the %" PRIu64
                        " of %s)",
                        options->more, about.end, path);
    return CML_OK;
}

/* Plans --more for the scene. A part has its own file beside the checkpoint of the run that is extended. */
static cml_status plan_more_of(const struct cml_run_call *call, struct cml_run_setup *setup,
                               struct cml_error *err)
{
    CML_FREED char *output = NULL, *path = NULL;
    CML_TRY(cml_output_path(call->options, call->scene->output, &output, err));
    CML_TRY(cml_checkpoint_path(output, &path, err));
    return plan_more(call->options, setup, path, err);
}

/* Decides on all ranks which photons the run flies, before any step that may fail on one rank alone.
 * Checkpoint, --part and --more have a say. */
static cml_status plan_photons(const struct cml_run_call *call, struct own *run, struct cml_error *err)
{
    const struct cml_options *options = call->options;
    struct cml_run_setup *setup = &run->sim.setup;
    cml_status status = CML_OK;
    if (uses_checkpoints(options, call->scene))
        status = cml_run_checkpoint(options, call->scene, &run->checkpoint, err);
    CML_TRY(cml_cluster_agree(status, err));
    setup->checkpoint = run->checkpoint;
    if (setup->part.count > 0 && !run->checkpoint)
        status = cml_fail(err, CML_E_INPUT, "--part: %s is no file (expected a result in a file)",
                          call->scene->output);
    CML_TRY(cml_cluster_agree(status, err));
    if (options->more == 0) return CML_OK;
    if (!run->checkpoint) status = fail_more(call->scene->output, "is no file that could be extended", err);
    CML_TRY(cml_cluster_agree(status, err));
    if (cml_cluster_rank() == 0) status = plan_more_of(call, setup, err);
    CML_TRY(cml_cluster_agree(status, err));
    uint64_t words[] = {setup->photons, setup->base, setup->resume};
    CML_TRY(cml_cluster_share(words, sizeof words, err));
    setup->photons = words[0];
    setup->base = words[1];
    setup->resume = words[2] != 0;
    return CML_OK;
}

/* ---- the whole run ---- */

/* Computes the identity of the run, by which checkpoints and results know it, and with --more that of the
 * run that it extends. */
static cml_status identify(const struct cml_run_call *call, struct own *run, struct cml_error *err)
{
    const struct cml_options *options = call->options;
    struct cml_run_setup *setup = &run->sim.setup;
    CML_TRY(cml_simulation_identify(&run->sim, call->inputs, err));
    if (options->more == 0) return CML_OK;
    struct cml_provenance before = run->sim.provenance;
    before.value[CML_DECIDES_photons] = (double)(setup->photons - options->more);
    CML_TRY(cml_identity_of(&before, setup->scene->settings, call->inputs, &run->base_identity, err));
    setup->base_identity = run->base_identity;
    return CML_OK;
}

/* Prepares a run: surfaces, memory, aim, identity, and a look at files that exist. All this may fail on one
 * rank alone, hence it comes before the ranks agree to fly. */
static cml_status prepare(const struct cml_run_call *call, struct own *run, struct cml_error *err)
{
    const struct cml_options *options = call->options;
    struct cml_run_setup *setup = &run->sim.setup;
    CML_TRY(cml_simulation_prepare(&run->sim, call->shared, err));
    CML_TRY(identify(call, run, err));
    if (!call->rows && !options->receiver && cml_cluster_rank() == 0)
        CML_TRY(cml_before_look(options, setup, call->row, &run->before, err));
    setup->gone = options->resume ? run->before.gone : NULL;
    setup->how_gone = run->before.how;
    setup->result_stands = run->before.stands;
    if (call->row == 0 && cml_cluster_rank() == 0 && !cml_part_files_looking(options->joined))
        CML_TRY(cml_note_beam(setup->scene, setup->surfaces, NULL, err));
    return CML_OK;
}

/* Begins a run, as far as options and scene decide it. */
static void begin(const struct cml_run_call *call, struct cml_display *display, struct cml_simulation *sim)
{
    const struct cml_options *options = call->options;
    struct cml_run_setup *setup = &sim->setup;
    cml_simulation_begin(options, call->scene, call->seed, call->run, sim);
    setup->part = (struct cml_part){options->part, options->parts};
    setup->call = options->parts > 0 ? options->call : NULL;
    setup->interval = options->checkpoint_interval;
    setup->resume = options->resume;
    setup->on_progress = cml_progress_show;
    setup->context = display;
    if (!options->receiver) return;
    setup->on_progress = options->receiver->on_progress;
    setup->cancelled = options->receiver->cancelled;
    setup->on_note = options->receiver->on_note;
    setup->context = options->receiver->context;
}

/* No rank may return before all agree. */
cml_status cml_run_one(const struct cml_run_call *call, struct cml_record *record, struct cml_error *err)
{
    const struct cml_options *options = call->options;
    /* the Python package, which sets CLUSTERMCML_PARENT, reads the bar from a pipe */
    const bool terminal = isatty(STDERR_FILENO) || getenv("CLUSTERMCML_PARENT");
    struct cml_display display = {.quiet = options->quiet, .terminal = terminal};
    struct own run = {0};
    begin(call, &display, &run.sim);
    *record = (struct cml_record){0};
    cml_status status = plan_photons(call, &run, err);
    if (status == CML_OK) status = cml_cluster_agree(prepare(call, &run, err), err);
    if (status == CML_OK) status = fly(call, &run, record, err);
    cml_progress_end(&display);
    cml_simulation_clear(&run.sim);
    free(run.checkpoint);
    free(run.base_identity);
    cml_before_clear(&run.before);
    return status;
}
