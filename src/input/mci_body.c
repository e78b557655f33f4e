/* SPDX-License-Identifier: MIT */
#include "input/mci_body.h"

#include "base/shared.h"
#include "input/mci_medium.h"
#include "input/mci_mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_BODIES 1000000

/* Room for one more body and its medium; arrays are enlarged when their number is a power of two. */
static cml_status grow(struct cml_mci_reader *reader, struct cml_scene *scene)
{
    const size_t count = (size_t)scene->num_bodies, media = (size_t)scene->num_layers + 2;
    if (count >= MAX_BODIES) return cml_mci_fail(reader, "line", "i", "at most 1000000 bodies");
    if (count > 0 && (count & (count - 1)) != 0) return CML_OK;
    const size_t capacity = count ? 2 * count : 1;
    struct cml_scene_body *bodies = realloc(scene->bodies, capacity * sizeof *bodies);
    if (bodies) scene->bodies = bodies;
    struct cml_medium_def *larger = realloc(scene->media, (media + capacity) * sizeof *larger);
    if (larger) scene->media = larger;
    if (bodies && larger) return CML_OK;
    return cml_fail_memory(reader->err, (double)(capacity * sizeof *bodies), "bodies");
}

/* Behind the last number a number too many was meant for something (mci_lines.h). */
static cml_status read_shape(struct cml_mci_reader *reader, const char *owner, struct cml_scene_body *body,
                             struct cml_medium_def *medium)
{
    static const char coordinate[] = "a coordinate of -1e30..1e30 cm",
                      radius[] = "a radius of 1e-30..1e30 cm";
    static const struct cml_mci_field sphere[] = {
        {"x", -CML_MCI_HUGE, CML_MCI_HUGE, false, coordinate},
        {"y", -CML_MCI_HUGE, CML_MCI_HUGE, false, coordinate},
        {"z", -CML_MCI_HUGE, CML_MCI_HUGE, false, coordinate},
        {"r", CML_MCI_TINY, CML_MCI_HUGE, false, radius},
    };
    static const struct cml_mci_field cylinder[] = {
        {"x1", -CML_MCI_HUGE, CML_MCI_HUGE, false, coordinate},
        {"y1", -CML_MCI_HUGE, CML_MCI_HUGE, false, coordinate},
        {"z1", -CML_MCI_HUGE, CML_MCI_HUGE, false, coordinate},
        {"x2", -CML_MCI_HUGE, CML_MCI_HUGE, false, coordinate},
        {"y2", -CML_MCI_HUGE, CML_MCI_HUGE, false, coordinate},
        {"z2", -CML_MCI_HUGE, CML_MCI_HUGE, false, coordinate},
        {"r", CML_MCI_TINY, CML_MCI_HUGE, false, radius},
    };
    const bool round = body->form == CML_BODY_SPHERE;
    const int count = round ? 4 : 7;
    struct cml_mci_field fields[12];
    double values[12] = {0};
    memcpy(fields, round ? sphere : cylinder, (size_t)count * sizeof *fields);
    memcpy(fields + count, cml_mci_medium_fields, 4 * sizeof *fields);
    CML_TRY(cml_mci_numbers(reader, owner, fields, count + 4, values));
    memcpy(body->centre, values, sizeof body->centre);
    if (!round) memcpy(body->end, values + 3, sizeof body->end);
    body->radius = values[count - 1];
    *medium = cml_mci_medium(reader, values + count);
    return CML_OK;
}

/* Takes the word rough=KIND,ALPHA out of the line, wherever it stands behind the shape. Beside a sphere or a
 * cylinder no other word is an option: words are ignored there, but one with = or rough was meant for
 * something. */
static cml_status take_roughness(struct cml_mci_reader *reader, const char *owner,
                                 struct cml_rough_def *rough)
{
    static const char blank[] = " \t\r", key[] = "rough=";
    char value[64], field[48], *words = reader->cursor + strspn(reader->cursor, blank);
    const char *name_end = *words == '"' ? strchr(words + 1, '"') : NULL;
    const bool has_file = name_end != NULL;
    if (has_file) words += name_end - words;
    for (char *word = words; *(word += strspn(word, blank)) != '\0';) {
        const size_t length = strcspn(word, blank);
        const bool is_rough = strncmp(word, key, sizeof key - 1) == 0;
        const char *begin = is_rough ? word + sizeof key - 1 : word;
        snprintf(value, sizeof value, "%.*s", (int)(length - (size_t)(begin - word)), begin);
        snprintf(field, sizeof field, "%s: %s", owner, is_rough ? "rough" : "option");
        if (is_rough && rough->line) return cml_mci_fail(reader, field, value, "this option only once");
        if (is_rough && !cml_mci_parse_rough(value, rough))
            return cml_mci_fail(reader, field, value, cml_mci_rough_option);
        if (!is_rough && !has_file && (strchr(value, '=') || strcmp(value, "rough") == 0))
            return cml_mci_fail(reader, field, value, "rough=KIND,ALPHA, or none");
        if (is_rough) rough->line = reader->text.line;
        if (is_rough) memset(word, ' ', length);
        word += length;
    }
    return CML_OK;
}

/* A cylinder's axis must have a length that is more than rounding. */
static cml_status check_axis(const struct cml_mci_reader *reader, const char *owner,
                             const struct cml_scene_body *body)
{
    double length = 0, size = 0;
    char field[64];
    for (int k = 0; k < 3; k++) {
        length = hypot(length, body->end[k] - body->centre[k]);
        size += fabs(body->end[k]) + fabs(body->centre[k]);
    }
    if (body->form != CML_BODY_CYLINDER || length > 1e-12 * size) return CML_OK;
    snprintf(field, sizeof field, "%s: x2 y2 z2", owner);
    return cml_mci_fail(reader, field, "those of the first end", "another point: the axis has no length");
}

/* Name, medium, options: what comes before the file is read. */
static cml_status read_body_line(struct cml_mci_line_options *options, struct cml_scene_body *body,
                                 struct cml_medium_def *medium, struct cml_obj_options *obj)
{
    struct cml_mci_reader *reader = options->reader;
    double values[CML_MCI_MEDIUM_FIELDS];
    enum cml_mci_mesh_file kind = CML_MCI_FILE_OBJ;
    const char *name = cml_text_word(&reader->cursor);
    CML_TRY(cml_mci_mesh_name(options, name, &kind));
    if (kind != CML_MCI_FILE_OBJ)
        return cml_mci_fail_option(options, "file", name, "an .obj file: a closed mesh");
    CML_TRY(cml_path_beside(reader->text.path, name, &body->file, reader->err));
    CML_TRY(cml_mci_leading_numbers(reader, options->owner, cml_mci_medium_fields, CML_MCI_MEDIUM_FIELDS,
                                    values));
    *medium = cml_mci_medium(reader, values);
    for (bool more = true; more;) {
        CML_TRY(cml_mci_next_option(options, &more));
        if (more) CML_TRY(cml_mci_mesh_option(options, obj));
    }
    return CML_OK;
}

static cml_status read_mesh(struct cml_mci_reader *reader, int number, struct cml_scene_body *body,
                            struct cml_medium_def *medium)
{
    char owner[32];
    snprintf(owner, sizeof owner, "body %d", number);
    struct cml_mci_line_options options = {
        .reader = reader,
        .owner = owner,
        .keys = {"up", "rotate", "units", "scale", "shift", "normals",
                 "\n" /* no skirt: no word holds a line's end */, "union"},
        .flag = "union",
        .list = "up=, rotate=, units=, scale=, shift=, normals=, union or rough="};
    struct cml_obj_options obj = {.unit = 1, .scale = 1, .height = 1, .closed = true};
    CML_TRY(read_body_line(&options, body, medium, &obj));
    obj.budget = reader->options->budget;
    obj.budget.file = reader->text.path;
    obj.budget.line = reader->text.line;
    obj.budget.body = number;
    return cml_mci_name_line(
        reader, owner, body->file,
        cml_obj_read(reader->options->source, body->file, &obj, &body->mesh, &body->mesh_notes, reader->err));
}

static cml_status read_smooth_body(struct cml_mci_reader *reader, const char *owner, int number,
                                   struct cml_scene_body *body, struct cml_medium_def *medium)
{
    reader->cursor += strspn(reader->cursor, " \t");
    if (*reader->cursor == '"') {
        body->form = CML_BODY_MESH;
        return read_mesh(reader, number, body, medium);
    }
    const char *word = cml_text_word(&reader->cursor);
    char field[48];
    snprintf(field, sizeof field, "%s: form", owner);
    if (!word || (strcmp(word, "sphere") != 0 && strcmp(word, "cylinder") != 0))
        return cml_mci_fail(reader, field, word, "sphere, cylinder, or an .obj file in a pair of quotes");
    body->form = word[0] == 's' ? CML_BODY_SPHERE : CML_BODY_CYLINDER;
    CML_TRY(read_shape(reader, owner, body, medium));
    return check_axis(reader, owner, body);
}

static cml_status read_body(struct cml_mci_reader *reader, int number, struct cml_scene_body *body,
                            struct cml_medium_def *medium)
{
    char owner[32];
    struct cml_rough_def rough = {0};
    snprintf(owner, sizeof owner, "body %d", number);
    cml_mci_cut_comment(reader->cursor);
    CML_TRY(take_roughness(reader, owner, &rough));
    CML_TRY(read_smooth_body(reader, owner, number, body, medium));
    medium->rough = rough;
    return CML_OK;
}

cml_status cml_mci_body(struct cml_mci_reader *reader, int layer, struct cml_scene *scene)
{
    CML_TRY(grow(reader, scene));
    const int k = scene->num_bodies++;
    struct cml_scene_body *body = &scene->bodies[k];
    *body = (struct cml_scene_body){.layer = layer, .host = layer, .line = reader->text.line};
    CML_TRY(cml_share_begin(&scene->body_users, reader->err));
    return read_body(reader, k + 1, body, &scene->media[cml_body_medium(scene, k)]);
}
