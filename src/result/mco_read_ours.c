/* What stands in an .mco behind the sections of original MCML. Nothing here is refused: a section that is not
 * whole is as if it were not there, and `damage` says so to who wants it.
 * SPDX-License-Identifier: MIT */
#include "result/mco_sections.h"

#include "base/text.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

struct reader {
    const char *text, *path;
    struct cml_outcome *o;
};

/* The line behind `line`, NULL when that was the last. */
static const char *line_after(const char *line)
{
    const char *end = strchr(line, '\n');
    return end && end[1] ? end + 1 : NULL;
}

/* ---- comments ---- */

static bool begins(const char *line, const char *word)
{
    return strncmp(line, word, strlen(word)) == 0;
}

/* Lines that begin with either word, without their first `skip` characters. *found is the caller's to free.
 */
static cml_status gather(const char *text, const char *word, const char *or_word, size_t skip, char **found,
                         struct cml_error *err)
{
    char *end = *found = calloc(strlen(text) + 2, 1);
    if (!*found) return cml_fail_memory(err, (double)strlen(text), "a result file");
    for (const char *line = text; line; line = line_after(line)) {
        if (!begins(line, word) && !begins(line, or_word)) continue;
        const size_t length = strcspn(line + skip, "\n");
        memcpy(end, line + skip, length);
        end[length] = '\n';
        end += length + 1;
    }
    char *smaller = realloc(*found, (size_t)(end - *found) + 1);
    if (smaller) *found = smaller;
    return CML_OK;
}

/* What is not the scene is the head, line by line. */
static cml_status read_head(const struct reader *r, struct cml_error *err)
{
    static const char *const scene[] = {
        "# set ", "# beam ", "# phase ", "# backing: ", "# detector ", "# boundary ", "# body ", "# scene "};
    struct cml_outcome *o = r->o;
    char head[256];
    for (const char *line = r->text; line; line = line_after(line)) {
        bool of_scene = line[0] != '#';
        for (size_t i = 0; i < sizeof scene / sizeof *scene; i++) of_scene |= begins(line, scene[i]);
        if (of_scene) continue;
        snprintf(head, sizeof head, "%.*s", (int)strcspn(line, "\r\n"), line);
        if (begins(head, "# clustermcml ") && !o->program)
            CML_TRY(cml_text_copy(head + strlen("# clustermcml "), &o->program, err));
        else
            cml_provenance_read(head, &o->provenance);
        if (begins(head, "# engine ")) sscanf(head, "# engine %31[^,]", o->provenance.engine);
    }
    return CML_OK;
}

static cml_status read_comments(const struct reader *r, struct cml_error *err)
{
    struct cml_outcome *o = r->o;
    CML_TRY(read_head(r, err));
    CML_TRY(gather(r->text, "# set ", "# set ", 6, &o->settings, err));
    CML_TRY(gather(r->text, "# beam ", "# beam ", 2, &o->beam, err));
    CML_TRY(gather(r->text, "# phase ", "# backing: ", 2, &o->phases, err));
    CML_TRY(gather(r->text, "# detector ", "# detector ", 2, &o->detectors, err));
    CML_TRY(gather(r->text, "# boundary ", "# body ", 2, &o->shapes, err));
    CML_TRY(gather(r->text, "# scene ", "# scene ", 8, &o->scene, err));
    return CML_OK;
}

/* ---- sections ---- */

/* The first word of a line as a number; what follows on the line is a comment. An error may be "nan": that of
 * one packet. */
static bool leading_number(const char *line, bool error, double *value)
{
    char word[64];
    const char *start = line + strspn(line, " \t");
    const size_t length = strcspn(start, " \t\r\n");
    if (length >= sizeof word) return false;
    memcpy(word, start, length);
    word[length] = '\0';
    if (!error || strcasecmp(word, "nan") != 0) return cml_parse_double(word, value);
    *value = NAN;
    return true;
}

/* Says what is damaged; the first damage counts. */
__attribute__((format(printf, 2, 3))) static void damaged(const struct reader *r, const char *format, ...)
{
    char text[512];
    va_list arguments;
    if (r->o->damage) return;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    r->o->damage = strdup(text);
}

/* A section that is being read: its key, and the line behind that. */
struct section {
    const struct reader *r;
    char key[64];
    const char *line; /* NULL at the end of the file */
};

/* Numbers, one per line, which end with the first line that does not begin with one: an empty line, or the
 * next key. true: there are `count` of them, and only then out[count] is what they are. */
static bool read_numbers(struct section *s, size_t count, bool more, double *out)
{
    const bool errors = begins(s->key, "se_") || cml_outcome_may_be_none(s->key);
    size_t found = 0;
    double beyond;
    while (s->line && found < count && leading_number(s->line, errors, &out[found])) {
        found++;
        s->line = line_after(s->line);
    }
    if (found == count && !more && s->line && leading_number(s->line, errors, &beyond))
        damaged(s->r, "%.200s: %s has more numbers (expected %zu)", s->r->path, s->key, count);
    if (found == count) return true;
    const char *word = s->line ? s->line + strspn(s->line, " \t") : "";
    const int length = (int)strcspn(word, " \t\r\n");
    damaged(s->r, "%.200s: %s[%zu] = %.*s (expected one of %zu numbers)", s->r->path, s->key, found,
            length ? length < 40 ? length : 40 : 7, length ? word : "nothing", count);
    return false;
}

/* What stands over gates or directions is written with these. */
static bool over_own_bins(enum cml_quantity quantity)
{
    const enum cml_axis_kind axis = cml_quantities[quantity].axis[0];
    return axis == CML_AXIS_gate || axis == CML_AXIS_theta;
}

/* Numbers of detectors whose section is missing are none. */
static void forget_parts(double *array, size_t size)
{
    for (size_t i = 0; i < size; i++) array[i] = NAN;
}

/* All values, or errors, of a quantity, or those of one detector. Of two sections of one name the first
 * counts, and one without numbers is none. */
static cml_status read_array(struct section *s, enum cml_quantity quantity, int part, bool errors,
                             struct cml_error *err)
{
    struct cml_outcome *o = s->r->o;
    double **array = errors ? &o->error[quantity] : &o->value[quantity];
    const size_t size = cml_outcome_part_size(o, quantity), at = (size_t)part * size;
    if (size == 0 && over_own_bins(quantity))
        damaged(s->r, "%.200s: %s without bins (expected the section %s before it)", s->r->path, s->key,
                cml_quantities[quantity].axis[0] == CML_AXIS_gate ? "time" : "directions");
    if (size == 0 || (*array && !isnan((*array)[at]))) return CML_OK;
    if (!*array) {
        CML_TRY(cml_outcome_add(o, quantity, errors, err));
        forget_parts(*array, cml_outcome_size(o, quantity));
    }
    if (read_numbers(s, size, false, *array + at)) return CML_OK;
    free(*array);
    *array = NULL;
    return CML_OK;
}

/* `count` numbers that are quantities, from `first` on. */
static cml_status read_several(struct section *s, enum cml_quantity first, int count, bool errors,
                               struct cml_error *err)
{
    double numbers[CML_BOOKS];
    double **array = errors ? s->r->o->error + first : s->r->o->value + first;
    if (*array || !read_numbers(s, (size_t)count, first == CML_QUANTITY_lost, numbers)) return CML_OK;
    for (int i = 0; i < count; i++) {
        CML_TRY(cml_outcome_add(s->r->o, (enum cml_quantity)((int)first + i), errors, err));
        array[i][0] = numbers[i];
    }
    return CML_OK;
}

/* The first section counts, and only as a scene may have it. */
static void read_gates(struct section *s)
{
    struct cml_outcome *o = s->r->o;
    double numbers[2];
    if (o->num_gates > 0 || !read_numbers(s, 2, false, numbers)) return;
    if (numbers[0] > 0 && numbers[0] <= 1e12 && numbers[1] >= 1 && numbers[1] <= 1e5 &&
        numbers[1] == floor(numbers[1])) {
        o->time_end = numbers[0];
        o->num_gates = (int)numbers[1];
    } else
        damaged(s->r, "%.200s: time = %g %g (expected T1 and a number of gates)", s->r->path, numbers[0],
                numbers[1]);
}

static void read_directions(struct section *s)
{
    struct cml_outcome *o = s->r->o;
    double n[2];
    if (o->nt > 0 || !read_numbers(s, 2, false, n)) return;
    if (n[0] >= 1 && n[0] <= 3600 && n[0] == floor(n[0]) && n[1] >= 1 && n[1] <= 3600 &&
        n[1] == floor(n[1])) {
        o->nt = (int)n[0];
        o->np = (int)n[1];
    } else
        damaged(s->r, "%.200s: directions = %g %g (expected two numbers of bins)", s->r->path, n[0], n[1]);
}

/* Behind the number of lost packets stand the smallest of their indices. */
static cml_status read_lost(struct section *s, struct cml_error *err)
{
    struct cml_lost_list *lost = &s->r->o->lost;
    double index;
    if (s->r->o->value[CML_QUANTITY_lost]) return CML_OK;
    CML_TRY(read_several(s, CML_QUANTITY_lost, 1, false, err));
    for (; lost->count < CML_LOST_LISTED && s->line; s->line = line_after(s->line)) {
        if (!leading_number(s->line, false, &index) || !(index >= 0 && index <= 0x1p53)) break;
        lost->index[lost->count++] = (uint64_t)index;
    }
    return CML_OK;
}

static cml_status read_section(struct section *s, struct cml_error *err)
{
    static const struct {
        const char *key;
        enum cml_quantity first;
        int count;
        bool errors;
    } several[] = {{"se_RAT", CML_QUANTITY_Rsp, CML_TOTALS, true},
                   {"books", CML_QUANTITY_book_launched, CML_BOOKS, false},
                   {"residue", CML_QUANTITY_residue, 1, false}};
    double *lattice = &s->r->o->provenance.value[CML_DECIDES_sampling];
    for (size_t i = 0; i < sizeof several / sizeof *several; i++)
        if (strcmp(s->key, several[i].key) == 0)
            return read_several(s, several[i].first, several[i].count, several[i].errors, err);
    if (strcmp(s->key, "lattice") == 0 && s->line) (void)leading_number(s->line, false, lattice);
    if (strcmp(s->key, "directions") == 0) read_directions(s);
    if (strcmp(s->key, "time") == 0) read_gates(s);
    if (strcmp(s->key, "lost") == 0) return read_lost(s, err);
    const bool errors = begins(s->key, "se_");
    enum cml_quantity quantity;
    int part;
    if (!cml_outcome_find(s->r->o, s->key + (errors ? 3 : 0), &quantity, &part) || (int)quantity < CML_TOTALS)
        return CML_OK;
    return read_array(s, quantity, part, errors, err);
}

static void check_whole(const struct reader *r)
{
    for (int i = 0; i < CML_NUM_QUANTITIES; i++) {
        const enum cml_quantity quantity = (enum cml_quantity)i;
        if (!over_own_bins(quantity) || cml_outcome_size(r->o, quantity) == 0) continue;
        if (quantity == CML_QUANTITY_A_t && !r->o->error[CML_QUANTITY_A_z] && !r->o->value[i])
            continue; /* of a run with --ignore-absorption */
        if (!r->o->value[i] || !r->o->error[i])
            damaged(r, "%.200s: %s%s is missing (expected it with its bins)", r->path,
                    r->o->value[i] ? "se_" : "", cml_quantities[i].name);
    }
}

/* What is wrong with the last line, which has a line end; NULL: nothing. Blanks may stand behind it. */
static const char *fault_of_end(const char *text)
{
    const char *line = text, *behind = NULL;
    for (; line && !behind; line = line_after(line))
        if (begins(line, CML_MCO_END) && strspn(line + strlen(CML_MCO_END), "\r\n") > 0)
            behind = line + strlen(CML_MCO_END);
    if (!behind) return "last line is missing (expected " CML_MCO_END "; the file is cut off)";
    return behind[strspn(behind, " \t\r\n")] ? "text behind " CML_MCO_END " (expected one result)" : NULL;
}

cml_status cml_mco_read_ours(const char *text, const char *path, bool ends, struct cml_outcome *o,
                             struct cml_error *err)
{
    const struct reader r = {text, path, o};
    const char *fault = ends ? fault_of_end(text) : NULL;
    if (fault) damaged(&r, "%.200s: %s", path, fault);
    CML_TRY(read_comments(&r, err));
    for (const char *line = text; line; line = line_after(line)) {
        struct section section = {&r, "", line_after(line)};
        const size_t length = strcspn(line, " \t\n");
        if (length == 0 || length >= sizeof section.key || line[length] == '\n' || !line[length]) continue;
        snprintf(section.key, sizeof section.key, "%.*s", (int)length, line);
        CML_TRY(read_section(&section, err));
    }
    check_whole(&r);
    o->provenance.value[CML_DECIDES_absorption] = o->error[CML_QUANTITY_A_z] != NULL;
    return CML_OK;
}
