/* SPDX-License-Identifier: MIT */
#include "run/join.h"

#include "base/text.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* ---- files ---- */

/* True for a lock, an older checkpoint or an unfinished file: a shell's NAME.part* also matches these. */
static bool is_beside_part(const char *path)
{
    return cml_file_ends_in(path, ".lock") || cml_file_ends_in(path, ".old") ||
           cml_file_ends_in(path, ".tmp");
}

cml_status cml_part_files_read(char *const *path, int count, struct cml_part_files *files,
                               struct cml_error *err)
{
    *files = (struct cml_part_files){0};
    CML_TRY(cml_zeros(&files->file, (size_t)count + 1, sizeof *files->file, "the parts", err));
    for (int i = 0; i < count; i++) {
        struct cml_part_file *file = &files->file[files->count];
        if (is_beside_part(path[i])) continue;
        file->path = path[i];
        CML_TRY(cml_part_look(file->path, &file->about, &file->identity, &file->call, err));
        files->count++;
    }
    if (files->count > 0) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "merge: no parts (expected those of a run, NAME.partKofN)");
}

void cml_part_files_clear(struct cml_part_files *files)
{
    for (int i = 0; files->file && i < files->count; i++) {
        free(files->file[i].identity);
        free(files->file[i].call);
    }
    free(files->file);
    *files = (struct cml_part_files){0};
}

cml_status cml_part_files_looked(struct cml_part_files *files, cml_status status, struct cml_error *err)
{
    files->looking = false;
    for (int i = 0; status == CML_OK && i < files->count; i++)
        if (!files->file[i].joined)
            return cml_fail(err, CML_E_INPUT,
                            "%s: is a part of another run than %s (expected parts of one scene file with the "
                            "same options)",
                            files->file[i].path, files->file[0].path);
    return status;
}

/* ---- which parts there are ---- */

/* Returns the turns of the part in a file. */
static struct cml_range turns_of(const struct cml_part_file *file)
{
    return cml_part_turns(file->about.part, file->about.begin, file->about.end);
}

/* True if the file holds a part of this run. */
static bool is_part_of(const struct cml_part_file *file, const struct cml_run_setup *setup)
{
    return strcmp(file->identity, setup->identity) == 0 && file->about.begin == setup->base;
}

/* Refuses a file that is a part of another run: the identity differs, or the round of photons. */
static cml_status fail_other(const struct cml_run_setup *setup, const struct cml_part_file *file,
                             struct cml_error *err)
{
    if (strcmp(file->identity, setup->identity) != 0)
        return cml_fail_other_run(file->path, file->identity, setup->identity, "parts of one run", err);
    return cml_fail(err, CML_E_INPUT,
                    "%s: begins with photon %" PRIu64 " (expected photons from %" PRIu64 " on)", file->path,
                    file->about.begin, setup->base);
}

/* Writes the numbers of missing parts into `list`, as "2, 4 and 5", cut off after 20 numbers. Returns how
 * many of the `count` parts are missing. */
static int list_missing(const struct cml_run_setup *setup, const struct cml_part_files *files, uint64_t count,
                        char list[200])
{
    char *end = list, *last = NULL;
    int missing = 0;
    for (uint64_t number = 1; number <= count; number++) {
        int i = 0;
        while (i < files->count &&
               !(is_part_of(&files->file[i], setup) && files->file[i].about.part.number == number))
            i++;
        if (i < files->count || ++missing > 20) continue;
        last = end;
        end += sprintf(end, "%s%" PRIu64, missing > 1 ? ", " : "", number);
    }
    if (missing > 20) strcpy(end, " ...");
    if (missing < 2 || missing > 20) return missing;
    char text[20];
    snprintf(text, sizeof text, "%s", last + 2);
    sprintf(last, " and %s", text);
    return missing;
}

/* Refuses to join a run of which parts are missing, and names them. turn: the first one that no part has. */
static cml_status fail_missing(const struct cml_run_setup *setup, const struct cml_part_files *files,
                               uint64_t turn, struct cml_error *err)
{
    const char *name = setup->scene->output;
    int first = 0;
    while (first < files->count && !is_part_of(&files->file[first], setup)) first++;
    struct cml_part part = {1, 0};
    if (first < files->count) part.count = files->file[first].about.part.count;
    while (
        part.number < part.count &&
        turn >=
            cml_part_turns((struct cml_part){part.number + 1, part.count}, setup->base, setup->photons).first)
        part.number++;
    if (part.count == 0)
        return cml_fail(err, CML_E_INPUT, "%s: no part of it (expected all its parts)", name);
    char list[200];
    if (list_missing(setup, files, part.count, list) < 2)
        snprintf(list, sizeof list, "%" PRIu64, part.number);
    return cml_fail(err, CML_E_INPUT,
                    "%s: part%s %s of %" PRIu64 " %s missing (expected all parts of the run)", name,
                    strpbrk(list, " ") ? "s" : "", list, part.count, strpbrk(list, " ") ? "are" : "is");
}

/* Returns the file with the part of this run whose photons begin with number `turn`; NULL if no file has
 * it. */
static struct cml_part_file *find_at(const struct cml_run_setup *setup, const struct cml_part_files *files,
                                     uint64_t turn)
{
    for (int i = 0; i < files->count; i++) {
        struct cml_part_file *file = &files->file[i];
        const struct cml_range turns = turns_of(file);
        if (is_part_of(file, setup) && turns.first == turn && turns.count > 0) return file;
    }
    return NULL;
}

/* Refuses a part whose photons another part has, too, and marks all parts of the run as joined. */
static cml_status check_twice(const struct cml_run_setup *setup, struct cml_part_files *files,
                              struct cml_error *err)
{
    for (int i = 0; i < files->count; i++) {
        struct cml_part_file *file = &files->file[i];
        const struct cml_range turns = turns_of(file);
        if (!is_part_of(file, setup) || file->joined) continue;
        file->joined = true;
        for (int k = 0; turns.count > 0 && k < files->count; k++) {
            const struct cml_range other = turns_of(&files->file[k]);
            if (k == i || !is_part_of(&files->file[k], setup) || other.first >= turns.first + turns.count ||
                turns.first >= other.first + other.count)
                continue;
            return cml_fail(err, CML_E_INPUT, "%s: has photons that %s has, too (expected each part once)",
                            file->path, files->file[k].path);
        }
    }
    return CML_OK;
}

/* ---- sums ---- */

/* Adds the saved packets of a part. */
static void add_saved(struct cml_saved *to, struct cml_saved *from)
{
    const struct cml_saved_sums sums = cml_saved_sort(from);
    cml_saved_add(to, sums.kept ? cml_saved_row(from, 0) : NULL, sums.kept);
    cml_saved_add_found(to, sums.found - sums.kept);
}

void cml_run_add(struct cml_result *to, struct cml_result *from)
{
    size_t cells = 0;
    const cml_u128 *more = cml_result_cells(from, &cells);
    cml_u128 *cell = cml_result_cells(to, &cells);
    for (size_t i = 0; i < cells; i++) cell[i] += more[i];
    cml_summary_merge(&to->summary, &from->summary);
    if (to->saved) add_saved(to->saved, from->saved);
}

/* Refuses a part that has not flown all its photons. `open`: photons of the run that nobody has flown. */
static cml_status check_finished(const struct cml_part_file *file, struct cml_ranges *open,
                                 struct cml_error *err)
{
    CML_AT_END(cml_ranges_clear) struct cml_ranges others = {0};
    CML_TRY(cml_ranges_keep(open, turns_of(file), &others, err));
    if (open->total == 0) return CML_OK;
    return cml_fail(
        err, CML_E_INPUT,
        "%s: %" PRIu64
        " photons of the part have not flown yet (expected a finished part; --resume continues it)",
        file->path, open->total);
}

/* Reads the file of a part and adds its tallies to *out. one: an empty result of the run's grid, as room for
 * the part. */
static cml_status add_part(const struct cml_run_setup *setup, const struct cml_part_file *file,
                           struct cml_result *one, struct cml_run_result *out, struct cml_error *err)
{
    struct cml_run_state state = {.begin = 0};
    CML_AT_END(cml_record_clear) struct cml_record record = {0};
    enum cml_checkpoint_kind kind;
    struct cml_error note;
    cml_status status =
        cml_checkpoint_read(file->path, setup->identity, &kind, &state, one, true, &record, &note, err);
    if (status == CML_OK) status = check_finished(file, &state.open, err);
    if (status == CML_OK) cml_run_add(&out->result, one);
    out->state.seconds += state.seconds;
    cml_ranges_clear(&state.open);
    return status;
}

/* Adds up the results of all parts of a run in the order of their photons, and the run that they extend. */
static cml_status add_parts(const struct cml_run_setup *setup, struct cml_part_files *files,
                            struct cml_run_result *out, struct cml_error *err)
{
    const struct cml_tally_grid grid = cml_run_grid(setup);
    CML_AT_END(cml_result_free) struct cml_result one = {.photons = 0};
    CML_TRY(cml_result_create(&grid, setup->photons, &one, err));
    CML_TRY(cml_result_create(&grid, setup->photons, &out->result, err));
    if (setup->base > 0) CML_TRY(cml_run_read_base(setup, &out->state, &out->result, err));
    out->state.begin = setup->base;
    out->state.end = setup->photons;
    for (uint64_t turn = setup->base; turn < setup->photons;) {
        struct cml_part_file *file = find_at(setup, files, turn);
        if (!file) return fail_missing(setup, files, turn, err);
        CML_TRY(add_part(setup, file, &one, out, err));
        file->joined = true;
        turn += turns_of(file).count;
    }
    return check_twice(setup, files, err);
}

/* Adds up the parts of a run. The time of the result is the sum of the times of all parts. */
cml_status cml_run_join(const struct cml_run_setup *setup, struct cml_part_files *files, bool alone,
                        struct cml_run_result *out, struct cml_error *err)
{
    *out = (struct cml_run_result){.intent = setup->base > 0 ? CML_RUN_EXTEND : CML_RUN_FRESH};
    for (int i = 0; alone && i < files->count; i++)
        if (!is_part_of(&files->file[i], setup)) CML_TRY(fail_other(setup, &files->file[i], err));
    const cml_status status = add_parts(setup, files, out, err);
    out->result.photons = setup->photons;
    out->timing.seconds = out->state.seconds;
    if (status != CML_OK) cml_run_result_free(out);
    return status;
}
