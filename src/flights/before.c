/* SPDX-License-Identifier: MIT */
#include "flights/before.h"

#include "base/atomic_file.h"
#include "base/text.h"
#include "simulation/scenes.h"
#include "output/files/vtk.h"
#include "output/report.h"
#include "result/head.h"
#include "run/identity.h"
#include "tally/deal.h"
#include "tally/tally_grid.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

cml_status cml_output_path(const struct cml_options *options, const char *name, char **path,
                           struct cml_error *err)
{
    if (!options->directory || name[0] == '/') return cml_text_copy(name, path, err);
    return cml_text_format(path, "a path", err, "%s/%s", options->directory, name);
}

bool cml_has_checkpoint(const char *path)
{
    char older[PATH_MAX];
    snprintf(older, sizeof older, "%s.old", path);
    return access(path, F_OK) == 0 || access(older, F_OK) == 0;
}

/* ---- files on the disk ---- */

cml_status cml_keep(const char *path, struct cml_error *err)
{
    return cml_fail(err, CML_E_INPUT,
                    "--no-clobber: %.400s exists (expected another name or folder, or no --no-clobber)",
                    path);
}

/* Returns the photons of the result in a file; 0: there is none, or it is not a result. */
static uint64_t photons_of(const char *path)
{
    struct cml_head head;
    return !cml_file_is_device(path) && cml_head_read(path, &head) ? head.photons : 0;
}

cml_status cml_before_keep_better(const struct cml_options *options, const char *path, uint64_t photons,
                                  struct cml_error *err)
{
    const uint64_t found = photons_of(path);
    if (!options->resume || options->replace || found <= photons) return CML_OK;
    return cml_fail(err, CML_E_INPUT,
                    "--resume: %.400s of %g photons is of another run, and would be replaced by %g photons "
                    "(expected --photons of as many, or --replace)",
                    path, (double)found, (double)photons);
}

/* State of a search for complete result files. identity: identity of the run, or of the run that it extends.
 * or_identity: a second identity that a file may have, because a stopped extension may have left files of
 * both runs; without an extension it is equal to `identity`. */
struct looking {
    const char *identity, *or_identity;
    bool resumes, extends;
    struct cml_before *before;
};

static const char of_another[] = "is of another run";

/* Returns the fault of a file that should be a result of this run, as text; NULL: none. */
static const char *fault_of_result(const struct looking *looking, const struct cml_report_file *file)
{
    struct cml_head head;
    char sum[CML_IDENTITY_SUM], or_sum[CML_IDENTITY_SUM];
    cml_identity_sum(looking->identity, sum);
    cml_identity_sum(looking->or_identity, or_sum);
    if (file->content > CML_FILE_SAVED && !cml_vtk_has_comment(file->path, sum) &&
        !cml_vtk_has_comment(file->path, or_sum))
        return of_another;
    if (file->content > CML_FILE_SAVED) return cml_vtk_is_whole(file->path) ? NULL : "is no whole result";
    if (!cml_head_read(file->path, &head) || (file->content != CML_FILE_SAVED && head.photons == 0))
        return "is no whole result";
    return strcmp(head.identity, sum) == 0 || strcmp(head.identity, or_sum) == 0 ? NULL : of_another;
}

/* Returns the fault of a file; NULL: none. No run writes a directory, or an empty file such as a full disk
 * leaves. */
static const char *fault_of(const struct looking *looking, const struct cml_report_file *file)
{
    struct stat about;
    if (stat(file->path, &about) != 0) return "is gone";
    if (!S_ISREG(about.st_mode) || about.st_size == 0) return "is empty";
    return looking->resumes || looking->extends ? fault_of_result(looking, file) : NULL;
}

/* Looks, before the flight, at one file that the run may write. Keeps the path of the first file that is
 * there already, and that of the first one that is missing or of another run, with what is wrong. */
static cml_status look(void *context, const struct cml_report_file *file, struct cml_error *err)
{
    const struct looking *looking = context;
    struct cml_before *before = looking->before;
    const bool there = access(file->path, F_OK) == 0;
    const char *fault = fault_of(looking, file);
    if (there && !before->there) CML_TRY(cml_text_copy(file->path, &before->there, err));
    if (!fault || before->gone || (looking->extends && !there)) return CML_OK;
    before->how = fault;
    return cml_text_copy(file->path, &before->gone, err);
}

struct cml_report_asks cml_report_asks_of(const struct cml_run_setup *setup)
{
    return (struct cml_report_asks){setup->options.absorption,
                                    setup->options.derivatives || setup->options.tail};
}

/* Looks at every file that the run will write, and notes in *before which exist and of which run they are. */
static cml_status find_files(const struct cml_options *options, const struct cml_run_setup *setup,
                             bool extends, struct cml_before *before, struct cml_error *err)
{
    const char *identity = setup->base > 0 ? setup->base_identity : setup->identity;
    struct looking looking = {identity, extends ? setup->base_identity : identity, options->resume, extends,
                              before};
    CML_FREED char *path = NULL;
    CML_TRY(cml_output_path(options, setup->scene->output, &path, err));
    if (cml_file_is_device(path)) return CML_OK;
    const struct cml_report_asks asks = cml_report_asks_of(setup);
    return cml_report_each_file(setup->scene, setup->surfaces, &asks, path, look, &looking, err);
}

/* True if a result of this run exists and no flight is needed. False if there is a checkpoint, which knows
 * more, and if JSON or the table of a sweep needs more digits than a result has. */
static bool result_stands(const struct cml_options *options, const struct cml_run_setup *setup,
                          const struct cml_before *before)
{
    return options->resume && !options->json && !options->keep && before->there && !before->gone &&
           !cml_has_checkpoint(setup->checkpoint);
}

/* Refuses with --no-clobber and --resume to replace files that are not of this run; cml_outputs_claim could
 * not tell yet. */
static cml_status check_kept(const struct cml_run_setup *setup, const struct cml_before *before,
                             struct cml_error *err)
{
    const struct cml_checkpoint_about about = cml_checkpoint_look(setup->checkpoint);
    const struct cml_run_findings found = {.resumes = true,
                                           .kind = about.kind,
                                           .tallies = about.tallies,
                                           .result_gone = before->gone,
                                           .result_stands = before->stands,
                                           .kept = before->there};
    if (cml_run_intent_of(&found) != CML_RUN_REFUSED) return CML_OK;
    if (about.kind != CML_CHECKPOINT_FINISHED) return cml_keep(before->there, err);
    return cml_fail(
        err, CML_E_INPUT,
        "--no-clobber: %.300s exists, but %.300s %s (expected all files of the run, or none of them)",
        before->there, before->gone, before->how);
}

/* Refuses with --no-clobber alone to overwrite a checkpoint, which may hold hours of flight. */
static cml_status keep_checkpoint(const char *path, struct cml_error *err)
{
    const struct cml_checkpoint_about about = cml_checkpoint_look(path);
    const bool stopped = about.kind == CML_CHECKPOINT_PARTIAL;
    if (!stopped && !about.tallies) return CML_OK;
    return cml_fail(
        err, CML_E_INPUT, "--no-clobber: %.400s is that of a %s", path,
        stopped
            ? "stopped run (expected --resume, which continues it, or no such file)"
            : "finished run with its tallies (expected --more, which extends it, --resume, or no such file)");
}

/* Refuses to replace a result with more photons, if there is no checkpoint. */
static cml_status keep_better(const struct cml_options *options, const struct cml_run_setup *setup,
                              struct cml_error *err)
{
    CML_FREED char *path = NULL;
    if (setup->checkpoint && cml_has_checkpoint(setup->checkpoint)) return CML_OK;
    CML_TRY(cml_output_path(options, setup->scene->output, &path, err));
    return cml_before_keep_better(options, path, setup->photons, err);
}

cml_status cml_before_look(const struct cml_options *options, const struct cml_run_setup *setup, int row,
                           struct cml_before *before, struct cml_error *err)
{
    if (setup->part.count > 0) /* a part replaces no result */
        return options->no_clobber && !options->resume && access(setup->checkpoint, F_OK) == 0
                   ? cml_keep(setup->checkpoint, err)
                   : CML_OK;
    if (row > 0 && !options->resume) return CML_OK;
    if (setup->checkpoint && options->no_clobber && !options->resume && options->more == 0)
        CML_TRY(keep_checkpoint(setup->checkpoint, err));
    const bool extends =
        options->more > 0 &&
        (setup->base > 0 || cml_checkpoint_look(setup->checkpoint).kind == CML_CHECKPOINT_PARTIAL);
    CML_TRY(find_files(options, setup, extends, before, err));
    if (extends && options->no_clobber && before->gone)
        return cml_fail(err, CML_E_INPUT,
                        "--no-clobber: %.400s %s (expected that of the run that --more extends)",
                        before->gone, before->how);
    if (before->how == of_another) CML_TRY(keep_better(options, setup, err));
    before->stands = row == 0 && setup->checkpoint && result_stands(options, setup, before);
    const bool keeps = options->no_clobber && options->resume && !extends && setup->checkpoint;
    return keeps ? check_kept(setup, before, err) : CML_OK;
}

void cml_before_clear(struct cml_before *before)
{
    free(before->there);
    free(before->gone);
    *before = (struct cml_before){0};
}

/* ---- notes ---- */

/* Notes that --resume finds no checkpoint: no run was stopped here, or its names differ. Not for rows of a
 * sweep, most of which may not have begun. */
static void note_no_checkpoint(const char *path, const struct cml_before *before)
{
    const char *why = !before->there ? "none of its files is there"
                      : before->gone ? CML_TEXT("%.360s %s", before->gone, before->how)
                                     : "its files hold less than --json or --keep ask for";
    if (cml_has_checkpoint(path)) return;
    cml_note("--resume finds no %.400s: the run begins anew, as %s%s", path, why,
             before->there ? "; what is there of its files is replaced" : "");
}

/* Notes a checkpoint that will be overwritten, which the user may not want. */
static void note_old_checkpoint(const char *path, enum cml_checkpoint_kind kind, bool tallies)
{
    if (kind == CML_CHECKPOINT_FINISHED)
        cml_note("%.400s is of a finished run; without --more or --resume it begins anew%s", path,
                 tallies ? ", and its tallies go" : "");
    if (kind == CML_CHECKPOINT_PARTIAL)
        cml_note("%.400s is of a run that was stopped; without --resume it begins anew", path);
}

/* Notes beams that get none of the photons because their share is too small. */
static void note_dark_beams(const struct cml_scene *scene, uint64_t photons)
{
    struct cml_error ignored;
    CML_FREED uint64_t *number = calloc((size_t)scene->num_beams, sizeof *number);
    if (!number || cml_deal_numbers(scene->shares, scene->num_beams, photons, number, &ignored) != CML_OK)
        return;
    for (int k = 0; k < scene->num_beams; k++)
        if (number[k] == 0)
            cml_note("beam %d has none of the %g photons: its share is too small", k + 1, (double)photons);
}

/* Notes that absorption by medium and time is left out, because gates of every layer and body would take too
 * much memory. */
static void note_no_medium_times(const struct cml_scene *scene)
{
    const int media = scene->num_layers + 2 + scene->num_bodies;
    if (scene->time.gates == 0 || (double)media * (scene->time.gates + 1.0) <= CML_MEDIUM_TIMES) return;
    cml_note("no A_lt and A_body_t: %d media, the outer two included, times %d gates (at most %d)", media,
             scene->time.gates + 1, CML_MEDIUM_TIMES);
}

bool cml_describe_replaced(const char *path, char text[CML_REPLACED])
{
    if (access(path, F_OK) != 0 || cml_file_is_device(path)) return false;
    const double photons = (double)photons_of(path);
    snprintf(text, CML_REPLACED, photons > 0 ? "replaces %.400s of %g photons" : "replaces %.400s", path,
             photons);
    return true;
}

/* Tells the user which files of an earlier run will be replaced. The file of saved packets has a name of its
 * own, and may belong to another run. */
static void note_replaced(const struct cml_scene *scene, const char *there)
{
    struct cml_error ignored;
    CML_FREED char *saved = NULL;
    char text[CML_REPLACED];
    if (there && cml_describe_replaced(there, text)) cml_show_note(NULL, text);
    if (there && scene->saved.limit && cml_report_saved_path(scene, there, &saved, &ignored) == CML_OK &&
        strcmp(saved, there) != 0 && cml_describe_replaced(saved, text))
        cml_show_note(NULL, text);
}

void cml_before_note(const struct cml_options *options, const struct cml_run_setup *setup, int row,
                     const struct cml_before *before)
{
    const char *path = setup->checkpoint;
    const bool resume = options->resume;
    const struct cml_checkpoint_about about =
        path ? cml_checkpoint_look(path) : (struct cml_checkpoint_about){.kind = CML_CHECKPOINT_NONE};
    const enum cml_checkpoint_kind kind = about.kind;
    if (setup->part.count > 0) {
        if (!resume && access(path, F_OK) == 0)
            cml_note("%.400s is there; without --resume this part begins anew", path);
        return;
    }
    if (path && !resume) note_old_checkpoint(path, kind, about.tallies);
    if (row > 0 || (resume && kind != CML_CHECKPOINT_NONE) || before->stands) return;
    if (path && resume) note_no_checkpoint(path, before);
    note_dark_beams(setup->scene, setup->photons);
    note_no_medium_times(setup->scene);
    if (!options->quiet) note_replaced(setup->scene, before->there);
}
