/* SPDX-License-Identifier: MIT */
#include "flights/outputs.h"

#include "base/array.h"
#include "base/atomic_file.h"
#include "base/text.h"
#include "simulation/scenes.h"
#include "flights/before.h"
#include "flights/one_run.h"
#include "output/files/hdf5_file.h"
#include "output/files/hdf5_head.h"
#include "output/files/vtk.h"
#include "output/report.h"
#include "result/mco.h"
#include "run/checkpoint.h"

#include <limits.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- names of files ---- */

/* Returns the path of a file with its directory free of links and dots. A directory that does not exist is
 * left as it is; the failure to write there is found later. */
static cml_status resolve_folder(const char *path, char **name, struct cml_error *err)
{
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
    char folder[PATH_MAX];
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path + 1) : 1, slash ? path : ".");
    CML_FREED char *real = realpath(folder, NULL);
    if (!real) return cml_text_copy(path, name, err);
    return cml_text_format(name, "a path", err, "%s/%s", strcmp(real, "/") == 0 ? "" : real, base);
}

/* Returns the path of a file without links and dots; of a file that does not exist, as resolve_folder does.
 */
static cml_status resolve(const char *path, char **name, struct cml_error *err)
{
    *name = realpath(path, NULL);
    return *name ? CML_OK : resolve_folder(path, name, err);
}

/* ---- files of a run ---- */

/* Adds a file to the list of files that the program will write, under its path without links and dots. run:
 * number of the run in the file. */
static cml_status add(struct cml_outputs *outputs, const char *path, int run, enum cml_output_kind kind,
                      struct cml_error *err)
{
    CML_TRY(cml_file_check_link(path, err));
    CML_TRY(
        cml_array_grow(&outputs->file, outputs->count, sizeof *outputs->file, "the names of outputs", err));
    struct cml_output_file *file = &outputs->file[outputs->count];
    *file = (struct cml_output_file){.run = run, .kind = kind};
    CML_TRY(resolve(path, &file->name, err));
    outputs->count++;
    return CML_OK;
}

struct adding {
    struct cml_outputs *outputs;
    int run;
    enum cml_output_kind kind; /* kind of the next file */
};

/* Adds a file that a run will write to the list of outputs. The first file of a run is the main result.
 * Called for each file by cml_report_each_file. */
static cml_status add_file(void *context, const struct cml_report_file *file, struct cml_error *err)
{
    struct adding *adding = context;
    const enum cml_output_kind kind = adding->kind;
    adding->kind = CML_OUTPUT_BESIDE;
    return add(adding->outputs, file->path, adding->run, kind, err);
}

/* Adds all files that one run may write. */
static cml_status add_run(struct cml_outputs *outputs, const struct cml_options *options,
                          const struct cml_scene *scene, const char *path, int run, struct cml_error *err)
{
    const struct cml_report_asks asks = {true, options->engine_options.derivatives || options->aim};
    struct adding adding = {outputs, run, CML_OUTPUT_MAIN};
    return cml_report_each_file(scene, NULL, &asks, path, add_file, &adding, err);
}

/* Adds the checkpoint of run number `run` to the files that the program writes. */
static cml_status add_checkpoint(const struct cml_options *options, struct cml_outputs *outputs,
                                 const char *path, int run, struct cml_error *err)
{
    CML_FREED char *checkpoint = NULL;
    CML_TRY(cml_checkpoint_of(options, path, &checkpoint, err));
    return add(outputs, checkpoint, run, CML_OUTPUT_CHECKPOINT, err);
}

/* Refuses names with endings of scenes, or with those that the program gives to its own files. */
static cml_status check_name(const struct cml_scene *scene, struct cml_error *err)
{
    static const char *const taken[] = {".checkpoint", ".checkpoint.old", ".lock", ".tmp", ".mci"};
    for (size_t i = 0; i < sizeof taken / sizeof *taken; i++)
        if (cml_file_ends_in(scene->output, taken[i]))
            return cml_fail_field(err, scene->file, scene->line, "output name", scene->output,
                                  "no ending .mci, .checkpoint, .checkpoint.old, .lock or .tmp");
    return CML_OK;
}

/* ---- can the files be written? ---- */

/* Checks that a file can be written by creating its temporary file. This takes no time, and finds missing
 * folders, missing rights and read-only disks. */
static cml_status check_writable(const char *path, const char *suffix, struct cml_error *err)
{
    CML_FREED char *name = NULL;
    struct cml_file file;
    CML_TRY(suffix ? cml_report_path(path, suffix, &name, err) : cml_text_copy(path, &name, err));
    CML_TRY(cml_file_create(name, &file, err));
    cml_file_abort(&file);
    return CML_OK;
}

/* Refuses, in a program without HDF5, every line and option whose results only an .h5 file can hold.
 * `asked`: lines of the scene, 0 if absent. */
static cml_status check_format(const struct cml_options *options, const struct cml_scene *scene,
                               struct cml_error *err)
{
    const struct {
        const char *field;
        int line;
    } asked[] = {{"map", scene->map.nx > 0 ? scene->map.line : 0},
                 {"facets", scene->facets},
                 {"time", scene->time.line},
                 {"directions", scene->directions.line},
                 {"fluence", scene->fluence.line},
                 {"detector", scene->num_detectors > 0 ? scene->detectors[0].line : 0},
                 {"photons", scene->saved.line},
                 {"backing", scene->backing.line},
                 {"face or port", scene->num_contacts > 0 ? scene->contacts->line : 0},
                 {"i", scene->num_bodies > 0 ? scene->bodies[0].line : 0}};
    static const char none[] = "no such line: this program was built without HDF5",
                      no_option[] = "run: --%s (expected none: this program was built without HDF5)";
    if (cml_hdf5_available()) return CML_OK;
    if (scene->format == 'B')
        return cml_fail_field(err, scene->file, scene->line, "format", "B",
                              "A: this program was built without HDF5");
    for (size_t i = 0; i < sizeof asked / sizeof *asked; i++)
        if (asked[i].line > 0)
            return cml_fail_field(err, scene->file, asked[i].line, "line", asked[i].field, none);
    if (options->engine_options.derivatives) return cml_fail(err, CML_E_INPUT, no_option, "derivatives");
    return options->aim ? cml_fail(err, CML_E_INPUT, no_option, "aim") : CML_OK;
}

/* Checks the main file, and the file with the longest name among those from number `first` on. A process
 * killed here leaves only temporary files of outputs, which remove_leftovers finds. */
static cml_status check_files(const struct cml_scene *scene, const char *path,
                              const struct cml_outputs *outputs, size_t first, struct cml_error *err)
{
    const char *longest = "";
    for (size_t i = first; i < outputs->count; i++)
        if (strlen(outputs->file[i].name) > strlen(longest)) longest = outputs->file[i].name;
    CML_TRY(check_writable(path, scene->format == 'B' ? ".h5" : NULL, err));
    return outputs->count > first + 1 ? check_writable(longest, NULL, err) : CML_OK;
}

/* True if the lock is taken already: two runs of one call may share a stem. */
static bool has_lock(const struct cml_outputs *outputs, const char *path)
{
    for (size_t i = 0; i < outputs->num_locks; i++)
        if (strcmp(outputs->lock[i].path, path) == 0) return true;
    return false;
}

/* Locks the file `path`, unless this process has locked it already for another run. */
static cml_status add_lock(struct cml_outputs *outputs, const char *path, struct cml_error *err)
{
    if (has_lock(outputs, path)) return CML_OK;
    CML_TRY(cml_array_grow(&outputs->lock, outputs->num_locks, sizeof *outputs->lock, "the locks of outputs",
                           err));
    CML_TRY(cml_file_lock_take(path, &outputs->lock[outputs->num_locks], err));
    outputs->num_locks++;
    return CML_OK;
}

/* Locks the file of a part, not the whole run: parts are flown at the same time. */
static cml_status lock_part(const struct cml_options *options, const char *path, struct cml_outputs *outputs,
                            struct cml_error *err)
{
    CML_FREED char *part = NULL, *beside = NULL, *name = NULL;
    CML_TRY(cml_checkpoint_of(options, path, &part, err));
    CML_TRY(cml_text_format(&beside, "a path", err, "%s.lock", part));
    CML_TRY(resolve_folder(beside, &name, err));
    return add_lock(outputs, name, err);
}

/* Locks all files of a result at once, by the lock file STEM.lock beside them. */
static cml_status lock_stem(const char *path, struct cml_outputs *outputs, struct cml_error *err)
{
    CML_FREED char *beside = NULL, *name = NULL;
    if (cml_file_is_device(path)) return CML_OK;
    CML_TRY(cml_report_path(path, ".lock", &beside, err));
    CML_TRY(resolve_folder(beside, &name, err)); /* not resolve: a lock must not be a link */
    return add_lock(outputs, name, err);
}

/* Locks the files of one run for this process: its result, its file of saved packets, or the file of its
 * part. */
static cml_status lock_run(const struct cml_options *options, const struct cml_scene *scene,
                           struct cml_outputs *outputs, struct cml_error *err)
{
    CML_FREED char *path = NULL;
    CML_TRY(cml_output_path(options, scene->output, &path, err));
    if (options->parts > 0) return cml_file_is_device(path) ? CML_OK : lock_part(options, path, outputs, err);
    CML_FREED char *saved = NULL;
    CML_TRY(lock_stem(path, outputs, err));
    if (scene->saved.limit && !cml_file_is_device(path)) {
        CML_TRY(cml_report_saved_path(scene, path, &saved, err));
        CML_TRY(lock_stem(saved, outputs, err));
    }
    return CML_OK;
}

/* Refuses a directory or device in the place of a file beside the result, from number `first` on; the flight
 * would find it too late. */
static cml_status check_places(const struct cml_outputs *outputs, size_t first, struct cml_error *err)
{
    struct stat about;
    for (size_t i = first; i < outputs->count; i++) {
        const char *name = outputs->file[i].name;
        if (outputs->file[i].kind == CML_OUTPUT_MAIN || cml_file_is_device(name)) continue;
        if (stat(name, &about) != 0 || S_ISREG(about.st_mode)) continue;
        return cml_fail(err, CML_E_INPUT, "%.400s: cannot be written (%s; expected a file, or none)", name,
                        S_ISDIR(about.st_mode) ? "a directory" : "no regular file");
    }
    return CML_OK;
}

/* ---- would files be destroyed? ---- */

/* True if a file was written by another program: its first bytes differ from those of every kind of file
 * that this program writes. An empty, cut or damaged file may be ours. A table (.csv) has no such mark. */
static bool is_strange(const struct cml_output_file *file)
{
    static const char *const ours[] = {CML_CHECKPOINT_MAGIC, CML_MCO_FIRST_LINE, "\211HDF\r\n\032\n",
                                       CML_VTK_FIRST_LINE CML_VTK_RUN};
    char found[64];
    FILE *in = cml_file_ends_in(file->name, ".csv") ? NULL : fopen(file->name, "rb");
    if (!in) return false;
    const size_t size = fread(found, 1, sizeof found, in);
    bool strange = size > 0;
    fclose(in);
    const size_t first = file->kind != CML_OUTPUT_CHECKPOINT, end = first ? sizeof ours / sizeof *ours : 1;
    for (size_t i = first; i < end; i++)
        strange &= memcmp(found, ours[i], strlen(ours[i]) < size ? strlen(ours[i]) : size) != 0;
    return strange || (size > 0 && first > 0 && cml_hdf5_is_foreign(file->name));
}

/* Refuses to replace a file that another program wrote, where --part and --resume would take it for an
 * earlier state of the run. */
static cml_status check_strange(const struct cml_options *options, const struct cml_outputs *outputs,
                                struct cml_error *err)
{
    for (size_t i = 0; (options->resume || outputs->of_part) && i < outputs->count; i++) {
        const struct cml_output_file *file = &outputs->file[i];
        if ((outputs->of_part && file->kind != CML_OUTPUT_CHECKPOINT) || !is_strange(file)) continue;
        return cml_fail(err, CML_E_INPUT, "%.400s: is no file of this program (expected %s, or no file)",
                        file->name,
                        outputs->of_part                      ? "a part"
                        : file->kind == CML_OUTPUT_CHECKPOINT ? "a checkpoint"
                                                              : "a result");
    }
    return CML_OK;
}

/* Orders files by name and then by run, so that files of one name become neighbours. */
static int compare_files(const void *a, const void *b)
{
    const struct cml_output_file *one = a, *other = b;
    const int names = strcmp(one->name, other->name);
    return names != 0 ? names : (one->run > other->run) - (one->run < other->run);
}

/* Refuses two runs that would write the same file. Files are sorted by name, so equal names are
 * neighbours. */
static cml_status check_distinct(const struct cml_outputs *outputs, const struct cml_scene_list *list,
                                 struct cml_error *err)
{
    for (size_t i = 1; i < outputs->count; i++) {
        const struct cml_output_file *one = &outputs->file[i - 1], *other = &outputs->file[i];
        if (strcmp(one->name, other->name) != 0) continue;
        const struct cml_scene *first = &list->scenes[one->run], *second = &list->scenes[other->run];
        return cml_fail(err, CML_E_INPUT,
                        "%s:%d: output name = %s (expected another one: run %d, %s, writes %s, too)",
                        second->file, second->line, second->output, one->run + 1, first->output,
                        strrchr(one->name, '/') + 1);
    }
    return CML_OK;
}

/* Refuses a run whose result would overwrite one of the files that it reads. */
static cml_status fail_input(const struct cml_options *options, const struct cml_scene *scene,
                             const char *input, struct cml_error *err)
{
    if (options->output)
        return cml_fail(err, CML_E_INPUT,
                        "run: --output %.200s would overwrite its input %s (expected another name)",
                        options->output, input);
    return cml_fail(err, CML_E_INPUT,
                    "%s:%d: output name = %s (expected another one: it would overwrite the input %s)",
                    scene->file, scene->line, scene->output, input);
}

/* Refuses a result that would overwrite one of the files that were read. "-" is standard input, which nobody
 * can overwrite. */
static cml_status check_inputs(const struct cml_options *options, const struct cml_outputs *outputs,
                               const struct cml_scene_list *list, const struct cml_inputs *inputs,
                               struct cml_error *err)
{
    for (size_t i = 0; i < inputs->count; i++) {
        CML_FREED char *name = NULL;
        if (strcmp(inputs->item[i].path, "-") == 0) continue;
        CML_TRY(resolve(inputs->item[i].path, &name, err));
        for (size_t k = 0; k < outputs->count; k++)
            if (strcmp(outputs->file[k].name, name) == 0)
                return fail_input(options, &list->scenes[outputs->file[k].run], inputs->item[i].path, err);
    }
    return CML_OK;
}

/* True for the table of a sweep. */
static bool is_table(const struct cml_scene *scene)
{
    return cml_file_ends_in(scene->output, ".sweep.csv") || cml_file_ends_in(scene->output, ".sweep.h5");
}

/* True if an existing result may stay. With --resume it stays if its checkpoint says that the run is
 * finished. Without a checkpoint it may stay, too: once the run's identity is known, cml_before_look decides
 * whether the result belongs to the run. */
static bool result_stays(const struct cml_options *options, const struct cml_scene *scene)
{
    struct cml_error ignored;
    CML_FREED char *path = NULL;
    if (!options->resume || cml_run_checkpoint(options, scene, &path, &ignored) != CML_OK) return false;
    const enum cml_checkpoint_kind kind = cml_checkpoint_look(path).kind;
    return kind == CML_CHECKPOINT_FINISHED || (kind == CML_CHECKPOINT_NONE && !options->sweep);
}

/* True if the results of all rows of a sweep stay. The tables of the sweep are then written again with the
 * same content. */
static bool all_stay(const struct cml_options *options, const struct cml_scene_list *list)
{
    int run = 0;
    while (run < list->count && (is_table(&list->scenes[run]) || result_stays(options, &list->scenes[run])))
        run++;
    return run == list->count;
}

/* True if an existing result of run number `run` may stay as it is. The table of a sweep stays only if all
 * rows do. */
static bool may_stay(const struct cml_options *options, const struct cml_scene_list *list, int run)
{
    const struct cml_scene *scene = &list->scenes[run];
    if (options->more > 0) return true;
    return options->sweep && is_table(scene) ? all_stay(options, list) : result_stays(options, scene);
}

/* Refuses, with --no-clobber, to replace a file that exists, unless the file may stay as it is. */
static cml_status check_clobber(const struct cml_options *options, const struct cml_scene_list *list,
                                const struct cml_outputs *outputs, struct cml_error *err)
{
    for (size_t i = 0; options->no_clobber && options->parts == 0 && i < outputs->count; i++) {
        const struct cml_output_file *file = &outputs->file[i];
        if (file->kind != CML_OUTPUT_CHECKPOINT && access(file->name, F_OK) == 0 &&
            !may_stay(options, list, file->run))
            return cml_keep(file->name, err);
    }
    return CML_OK;
}

/* Notes results that do not lie below the folder of -o, because their names have a path. */
static void note_elsewhere(const struct cml_options *options, const struct cml_outputs *outputs)
{
    CML_FREED char *folder = options->directory ? realpath(options->directory, NULL) : NULL;
    for (size_t i = 0; folder && i < outputs->count; i++) {
        const char *name = outputs->file[i].name;
        const size_t length = strlen(folder);
        if (outputs->file[i].kind == CML_OUTPUT_MAIN &&
            (strncmp(name, folder, length) != 0 || name[length] != '/'))
            cml_note("%.300s is not below -o %.100s", name, options->directory);
    }
}

/* ---- files left by killed processes ---- */

static int compare_names(const void *a, const void *b)
{
    return strcmp(((const struct cml_output_file *)a)->name, ((const struct cml_output_file *)b)->name);
}

/* True for a leftover of our outputs; no process owns it, because we hold the locks. For a part only
 * leftovers of its own file count. */
static bool is_ours(const void *context, const char *name, const char *left)
{
    const struct cml_outputs *outputs = context;
    const struct cml_output_file key = {.name = (char *)name};
    (void)left;
    const struct cml_output_file *file =
        bsearch(&key, outputs->file, outputs->count, sizeof key, compare_names);
    return file && (!outputs->of_part || file->kind == CML_OUTPUT_CHECKPOINT);
}

/* Removes leftovers, directory by directory. The outputs are sorted, so files of one directory mostly follow
 * each other. */
static void remove_leftovers(const struct cml_outputs *outputs)
{
    size_t before = SIZE_MAX;
    for (size_t i = 0; i < outputs->count; i++) {
        const char *name = outputs->file[i].name, *slash = strrchr(name, '/');
        const size_t length = slash ? (size_t)(slash - name) : 0;
        const bool same =
            i > 0 && length == before && strncmp(name, outputs->file[i - 1].name, length + 1) == 0;
        if (slash && !same) cml_file_remove_leftovers(name, length + 1, is_ours, outputs);
        before = length;
    }
}

/* Adds the files of one run to the claimed files, after checks of their names and folders. A device like
 * /dev/null is not added. */
static cml_status claim_run(const struct cml_options *options, const struct cml_scene *scene, int run,
                            struct cml_outputs *outputs, struct cml_error *err)
{
    CML_FREED char *path = NULL;
    const size_t before = outputs->count;
    CML_TRY(check_name(scene, err));
    CML_TRY(check_format(options, scene, err));
    CML_TRY(cml_output_path(options, scene->output, &path, err));
    const bool device = cml_file_is_device(path);
    CML_TRY(device ? CML_OK : add_run(outputs, options, scene, path, run, err));
    CML_TRY(check_places(outputs, before, err));
    CML_TRY(check_files(scene, path, outputs, before, err));
    return device ? CML_OK : add_checkpoint(options, outputs, path, run, err);
}

/* Checks and locks the files of all runs: distinct names, no input overwritten, no foreign file or kept
 * result in the way. Only the first num_locks runs are locked. */
static cml_status claim_all(const struct cml_options *options, const struct cml_scene_list *list,
                            int num_locks, const struct cml_inputs *inputs, struct cml_outputs *outputs,
                            struct cml_error *err)
{
    for (int i = 0; i < list->count; i++) CML_TRY(claim_run(options, &list->scenes[i], i, outputs, err));
    qsort(outputs->file, outputs->count, sizeof *outputs->file, compare_files);
    CML_TRY(check_distinct(outputs, list, err));
    CML_TRY(check_inputs(options, outputs, list, inputs, err));
    CML_TRY(check_strange(options, outputs, err));
    CML_TRY(check_clobber(options, list, outputs, err));
    for (int i = 0; i < num_locks; i++) CML_TRY(lock_run(options, &list->scenes[i], outputs, err));
    remove_leftovers(outputs);
    return CML_OK;
}

cml_status cml_outputs_claim(const struct cml_options *options, const struct cml_scene_list *list,
                             int num_locks, const struct cml_inputs *inputs, struct cml_outputs *outputs,
                             struct cml_error *err)
{
    const bool made = options->directory && access(options->directory, F_OK) != 0;
    *outputs = (struct cml_outputs){.of_part = options->parts > 0};
    if (made) CML_TRY(cml_folder_make(options->directory, err));
    if (made) outputs->made = options->directory;
    const cml_status status = claim_all(options, list, num_locks, inputs, outputs, err);
    if (status == CML_OK)
        note_elsewhere(options, outputs);
    else
        cml_outputs_release(outputs);
    return status;
}

void cml_outputs_release(struct cml_outputs *outputs)
{
    for (size_t i = 0; i < outputs->num_locks; i++) cml_file_lock_release(&outputs->lock[i]);
    for (size_t i = 0; i < outputs->count; i++) free(outputs->file[i].name);
    free(outputs->lock);
    free(outputs->file);
    if (outputs->made) (void)rmdir(outputs->made);
    *outputs = (struct cml_outputs){0};
}
