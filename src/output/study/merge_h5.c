/* A merged result as .h5: the fields that a run's .h5 has of what an .mco file holds.
 * SPDX-License-Identifier: MIT */
#include "output/study/merge_parts.h"

#include "base/version.h"
#include "output/files/result_names.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_FIELDS = 48 }; /* of what an .mco file holds */

/* Numbers of a field, and how far they are apart. */
struct source {
    const double *value;
    size_t stride;
};

/* The fields of one result, what they point into, and errors and books from its sections. */
struct list {
    const struct cml_mco *mco;
    struct cml_axis layer, body, r, z, alpha;
    struct cml_field field[MOST_FIELDS];
    struct source source[MOST_FIELDS];
    int count;
    double *room; /* [room_size] numbers of sections, of which `used` are taken */
    size_t used;
};

static void values(const void *context, size_t begin, size_t count, double *out)
{
    const struct source *source = context;
    for (size_t i = 0; i < count; i++) out[i] = source->value[(begin + i) * source->stride];
}

/* values: `stride` apart. */
static struct cml_field *add_named(struct list *l, const struct cml_result_name *name, const double *value,
                                   size_t stride)
{
    struct cml_field *field = &l->field[l->count];
    l->source[l->count] = (struct source){value, stride};
    cml_result_name_field(field, name);
    field->values = values;
    field->context = &l->source[l->count++];
    return field;
}

/* slow and fast may be NULL. */
static struct cml_field *add(struct list *l, const char *name, const double *value,
                             const struct cml_axis *slow, const struct cml_axis *fast)
{
    struct cml_field *field = add_named(l, cml_result_name(name), value, 1);
    if (slow) field->axis[field->num_axes++] = slow;
    if (fast) field->axis[field->num_axes++] = fast;
    return field;
}

/* The numbers of a section; NULL where the result has none. */
static const double *section(struct list *l, const char *key, int count)
{
    double *numbers = l->room + l->used;
    if (cml_mco_extra(l->mco, key, numbers, count) < count) return NULL;
    l->used += (size_t)count;
    return numbers;
}

/* A value and, where they are known, its errors. */
static void add_with_errors(struct list *l, const char *name, const double *value, const double *errors,
                            const struct cml_axis *axis)
{
    struct cml_field *of = add(l, name, value, axis, NULL);
    if (!errors) return;
    l->source[l->count] = (struct source){errors, 1};
    cml_result_name_errors(&l->field[l->count], of);
    l->field[l->count].values = values;
    l->field[l->count].context = &l->source[l->count];
    l->count++;
}

static void add_totals(struct list *l)
{
    const struct cml_mco *m = l->mco;
    const double *errors = section(l, "se_RAT", 4);
    add_with_errors(l, "Rsp", &m->Rsp, errors, NULL);
    add_with_errors(l, "Rd", &m->Rd, errors ? errors + 1 : NULL, NULL);
    add_with_errors(l, "A", &m->A, errors ? errors + 2 : NULL, NULL);
    add_with_errors(l, "Tt", &m->Tt, errors ? errors + 3 : NULL, NULL);
}

static void add_books(struct list *l)
{
    const double *books = section(l, "books", CML_RESULT_BOOKS), *residue = section(l, "residue", 1),
                 *lost = section(l, "lost", 1);
    for (int i = 0; books && i < CML_RESULT_BOOKS; i++) add_named(l, cml_result_book(i), books + i, 1);
    if (residue) add(l, "residue", residue, NULL, NULL);
    if (lost) add(l, "lost", lost, NULL, NULL);
}

static void add_layers(struct list *l)
{
    for (int i = 0; i < CML_RESULT_LAYER; i++) {
        struct cml_field *field = add_named(l, cml_result_layer(i), &l->mco->layer[0][i], CML_RESULT_LAYER);
        field->axis[field->num_axes++] = &l->layer;
    }
    add(l, "A_l", l->mco->A_l, &l->layer, NULL);
}

static void add_bodies(struct list *l)
{
    const double *absorbed = l->body.n > 0 ? section(l, "A_body", (int)l->body.n) : NULL;
    if (absorbed) add(l, "A_body", absorbed, &l->body, NULL);
}

/* Where no errors of A_z are known, absorption was not tallied by place. */
static void add_arrays(struct list *l)
{
    const struct cml_mco *m = l->mco;
    const double *errors = section(l, "se_A_z", m->nz);
    if (errors) {
        add_with_errors(l, "A_z", m->A_z, errors, &l->z);
        add(l, "A_rz", m->A_rz, &l->r, &l->z);
    }
    add_with_errors(l, "Rd_r", m->Rd_r, section(l, "se_Rd_r", m->nr), &l->r);
    add_with_errors(l, "Rd_a", m->Rd_a, section(l, "se_Rd_a", m->na), &l->alpha);
    add_with_errors(l, "Tt_r", m->Tt_r, section(l, "se_Tt_r", m->nr), &l->r);
    add_with_errors(l, "Tt_a", m->Tt_a, section(l, "se_Tt_a", m->na), &l->alpha);
    add(l, "Rd_ra", m->Rd_ra, &l->r, &l->alpha);
    add(l, "Tt_ra", m->Tt_ra, &l->r, &l->alpha);
}

static void set_axes(struct list *l)
{
    const struct cml_mco *m = l->mco;
    const double da = acos(-1.0) / (2.0 * m->na);
    l->layer = cml_result_axis("layer", m->num_layers, 1, 1);
    l->body = cml_result_axis("body", cml_merge_bodies(m->extra), 1, 1);
    l->r = cml_result_axis("r", m->nr, m->dr / 2, m->dr);
    l->z = cml_result_axis("z", m->nz, m->dz / 2, m->dz);
    l->alpha = cml_result_axis("alpha", m->na, da / 2, da);
}

/* A text attribute of lines of `extra`: of those that begin with either word, without `skip` characters. */
struct words {
    const char *name, *begin, *or_begin;
    size_t skip;
    char *text;
};

static bool begins(const char *line, const char *word)
{
    return word && strncmp(line, word, strlen(word)) == 0;
}

/* words->text is the caller's to free; NULL when memory runs out. */
static void gather(const char *extra, struct words *words)
{
    char *end = words->text = calloc(strlen(extra) + 1, 1);
    for (const char *line = extra; end && *line;) {
        const size_t size = strcspn(line, "\n") + (strchr(line, '\n') != NULL);
        if (begins(line, words->begin) || begins(line, words->or_begin)) {
            memcpy(end, line + words->skip, size - words->skip);
            end += size - words->skip;
        }
        line += size;
    }
}

enum { NUMBERS = 6, WORDS = 5 };

static cml_status write_fields(const char *path, const struct cml_mco *merged,
                               const struct words words[WORDS], const struct cml_field *fields, int count,
                               const struct cml_hdf5_call *call, struct cml_error *err)
{
    double lattice = 0;
    (void)cml_mco_extra(merged, "lattice", &lattice, 1);
    struct cml_attribute attributes[NUMBERS + WORDS] = {
        {"title", merged->output, 0},
        {"source", "clustermcml: Monte Carlo light transport in layered turbid media", 0},
        {"version", cml_version(), 0},
        {"sampling", lattice > 0 ? "lattice" : "random", 0},
        {"reentry", NULL, !cml_merge_first_exit(merged->extra)},
        {"photons", NULL, (double)merged->photons},
    };
    for (int i = 0; i < WORDS; i++)
        attributes[NUMBERS + i] = (struct cml_attribute){words[i].name, words[i].text, 0};
    return cml_hdf5_write(path, attributes, NUMBERS + WORDS, call, fields, count, err);
}

static cml_status write_with_words(const char *path, const struct cml_mco *merged,
                                   const struct cml_field *fields, int count,
                                   const struct cml_hdf5_call *call, struct cml_error *err)
{
    struct words words[WORDS] = {{"merged", "# merged ", NULL, 2, NULL},
                                 {"boundaries", "# boundary ", "# body ", 2, NULL},
                                 {"beam", "# beam ", NULL, 2, NULL},
                                 {"settings", "# set ", NULL, 6, NULL},
                                 {"scene", "# scene ", NULL, 8, NULL}};
    cml_status status = CML_OK;
    for (int i = 0; i < WORDS; i++) {
        gather(merged->extra, &words[i]);
        if (!words[i].text) status = cml_fail_memory(err, 1, "a merged result");
    }
    if (status == CML_OK) status = write_fields(path, merged, words, fields, count, call, err);
    for (int i = 0; i < WORDS; i++) free(words[i].text);
    return status;
}

static bool has_field(const struct list *l, const char *name)
{
    for (int i = 0; i < l->count; i++)
        if (strcmp(l->field[i].name, name) == 0) return true;
    return false;
}

/* The fields of the list, then the arrays that it has not. */
static cml_status write_all(const char *path, const struct list *l, const struct cml_merge_arrays *arrays,
                            const struct cml_hdf5_call *call, struct cml_error *err)
{
    struct cml_field *fields = calloc((size_t)(l->count + arrays->count), sizeof *fields);
    int count = l->count;
    if (!fields) return cml_fail_memory(err, 1, "a merged result");
    memcpy(fields, l->field, (size_t)count * sizeof *fields);
    for (int i = 0; i < arrays->count; i++)
        if (!has_field(l, arrays->field[i].name)) fields[count++] = arrays->field[i];
    cml_status status = write_with_words(path, l->mco, fields, count, call, err);
    if (arrays->broken) {
        *err = arrays->err;
        status = err->status;
    }
    free(fields);
    return status;
}

static cml_status fill_and_write(const char *path, struct list *l, const struct cml_merge_arrays *arrays,
                                 const struct cml_hdf5_call *call, struct cml_error *err)
{
    const struct cml_mco *mco = l->mco;
    const int bodies = cml_merge_bodies(mco->extra);
    const size_t size = (size_t)(mco->nz + 2 * (mco->nr + mco->na) + bodies) + 4 + CML_RESULT_BOOKS + 2;
    l->room = calloc(size, sizeof *l->room);
    if (!l->room) return cml_fail_memory(err, 8.0 * (double)size, "a merged result");
    set_axes(l);
    add_totals(l);
    add_books(l);
    add_layers(l);
    add_bodies(l);
    add_arrays(l);
    const cml_status status = write_all(path, l, arrays, call, err);
    free(l->room);
    return status;
}

cml_status cml_merge_write_h5(const char *path, const struct cml_mco *merged,
                              const struct cml_merge_input *inputs, int count,
                              const struct cml_hdf5_call *call, struct cml_error *err)
{
    struct cml_merge_arrays arrays;
    CML_TRY(cml_merge_arrays_open(inputs, count, merged, &arrays, err));
    struct list *l = calloc(1, sizeof *l);
    cml_status status = l ? CML_OK : cml_fail_memory(err, sizeof *l, "a merged result");
    if (l) {
        l->mco = merged;
        status = fill_and_write(path, l, &arrays, call, err);
    }
    free(l);
    cml_merge_arrays_close(&arrays);
    return status;
}
