/* SPDX-License-Identifier: MIT */
#include "input/mci_body.h"

#include "base/shared.h"
#include "input/mci_medium.h"
#include "input/mci_mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_BODIES 1000000

/* Makes room for one more body and its medium; the arrays double when the number of bodies is a power of two.
 */
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

/* Reads the value of a body's option rough=KIND,ALPHA: the distribution of facet slopes and its width. */
static cml_status set_rough(const struct cml_mci_reader *reader, const char *owner, const char *value,
                            struct cml_rough_def *rough)
{
    char alpha[CML_KEY_TEXT];
    const char *field = CML_TEXT("%s: rough", owner);
    if (rough->line) return cml_mci_fail(reader, field, value, "this option only once");
    rough->line = reader->text.line;
    if (cml_mci_parse_rough(value, rough)) return CML_OK;
    return cml_mci_fail(reader, field, value,
                        CML_TEXT("ggx,ALPHA or beckmann,ALPHA, with ALPHA %s",
                                 cml_key_expected(cml_keys_of(CML_KEYS_ROUGH), alpha)));
}

/* Takes the word rough=KIND,ALPHA out of the line of a sphere or a cylinder. Other words behind the numbers
 * are ignored, as in data lines, but a word with = or the word rough is refused: it was meant as an option.
 */
static cml_status take_roughness(struct cml_mci_reader *reader, const char *owner,
                                 struct cml_rough_def *rough)
{
    static const char blank[] = " \t\r", key[] = "rough=";
    char value[64];
    for (char *word = reader->cursor; *(word += strspn(word, blank)) != '\0';) {
        const size_t length = strcspn(word, blank),
                     skip = strncmp(word, key, sizeof key - 1) == 0 ? sizeof key - 1 : 0;
        snprintf(value, sizeof value, "%.*s", (int)(length - skip), word + skip);
        if (skip) CML_TRY(set_rough(reader, owner, value, rough));
        if (!skip && (strchr(value, '=') || strcmp(value, "rough") == 0))
            return cml_mci_fail(reader, CML_TEXT("%s: option", owner), value, "rough=KIND,ALPHA, or none");
        if (skip) memset(word, ' ', length);
        word += length;
    }
    return CML_OK;
}

/* Checks that the axis of a cylinder is longer than rounding errors. */
static cml_status check_axis(const struct cml_mci_reader *reader, const char *owner,
                             const struct cml_scene_body *body)
{
    double length = 0, size = 0;
    for (int k = 0; k < 3; k++) {
        length = hypot(length, body->end[k] - body->centre[k]);
        size += fabs(body->end[k]) + fabs(body->centre[k]);
    }
    if (body->form != CML_BODY_CYLINDER || length > 1e-12 * size) return CML_OK;
    return cml_mci_fail(reader, CML_TEXT("%s: x2 y2 z2", owner), "those of the first end",
                        "another point: the axis has no length");
}

/* Options of the line of a body's mesh. */
struct mesh_line {
    struct cml_mesh_file_options obj;
    struct cml_rough_def *rough;
};

/* Stores an option of a body's mesh that needs its own code: roughness or unit of length. */
static cml_status set_mesh_option(struct cml_mci_line *line)
{
    struct mesh_line *mesh = line->context;
    if (strcmp(line->key->name, "rough") == 0)
        return set_rough(line->reader, line->owner, line->value, mesh->rough);
    return cml_mci_mesh_units(line, &mesh->obj);
}

/* Reads a body that is a closed mesh: the file name, the medium and the options. Then reads the file. */
static cml_status read_mesh(struct cml_mci_reader *reader, const char *owner, int number,
                            struct cml_scene_body *body, struct cml_medium_def *medium)
{
    struct mesh_line mesh = {.obj = {.unit = 1, .scale = 1, .height = 1, .closed = true},
                             .rough = &medium->rough};
    struct cml_mesh_file_options *obj = &mesh.obj;
    struct cml_mci_line line = {
        .reader = reader,
        .owner = owner,
        .parts = CML_KEY_PARTS({CML_KEYS_MESH, obj}, {CML_KEYS_PLACE, obj}, {CML_KEYS_SOLID, obj}),
        .own = set_mesh_option,
        .context = &mesh};
    enum cml_mci_mesh_file kind = CML_MCI_FILE_MESH;
    const char *name = cml_text_word(&reader->cursor);
    CML_TRY(cml_mci_mesh_name(&line, name, &kind));
    if (kind != CML_MCI_FILE_MESH)
        return cml_mci_fail_option(&line, "file", name, "an " CML_MESH_FILE_ENDINGS " file: a closed mesh");
    CML_TRY(cml_path_beside(reader->text.path, name, &body->file, reader->err));
    CML_TRY(cml_mci_leading_numbers(reader, owner, CML_KEY_PARTS({CML_KEYS_MEDIUM, medium})));
    CML_TRY(cml_mci_options(&line));
    obj->budget = reader->options->budget;
    obj->budget.file = reader->text.path;
    obj->budget.line = reader->text.line;
    obj->budget.body = number;
    return cml_mci_name_line(reader, owner, body->file,
                             cml_mesh_file_read(reader->options->source, body->file, obj, &body->mesh,
                                                &body->mesh_notes, reader->err));
}

/* Reads the line of a body: a mesh in quotes, or a sphere or cylinder with its medium. */
static cml_status read_body(struct cml_mci_reader *reader, int number, struct cml_scene_body *body,
                            struct cml_medium_def *medium)
{
    const char *owner = CML_TEXT("body %d", number);
    medium->line = reader->text.line;
    cml_mci_cut_comment(reader->cursor);
    reader->cursor += strspn(reader->cursor, " \t");
    if (*reader->cursor == '"') {
        body->form = CML_BODY_MESH;
        return read_mesh(reader, owner, number, body, medium);
    }
    CML_TRY(take_roughness(reader, owner, &medium->rough));
    const char *word = cml_text_word(&reader->cursor);
    if (!word || (strcmp(word, "sphere") != 0 && strcmp(word, "cylinder") != 0))
        return cml_mci_fail(reader, CML_TEXT("%s: form", owner), word,
                            "sphere, cylinder, or an " CML_MESH_FILE_ENDINGS " file in a pair of quotes");
    const bool round = word[0] == 's';
    body->form = round ? CML_BODY_SPHERE : CML_BODY_CYLINDER;
    CML_TRY(cml_mci_numbers(
        reader, owner,
        CML_KEY_PARTS({round ? CML_KEYS_SPHERE : CML_KEYS_CYLINDER, body}, {CML_KEYS_MEDIUM, medium})));
    return check_axis(reader, owner, body);
}

cml_status cml_mci_body(struct cml_mci_reader *reader, int layer, struct cml_scene *scene)
{
    CML_TRY(grow(reader, scene));
    const int k = scene->num_bodies++;
    struct cml_scene_body *body = &scene->bodies[k];
    *body = (struct cml_scene_body){.layer = layer, .host = layer, .line = reader->text.line};
    struct cml_medium_def *medium = &scene->media[cml_body_medium(scene, k)];
    *medium = (struct cml_medium_def){0};
    CML_TRY(cml_share_begin(&scene->body_users, reader->err));
    return read_body(reader, k + 1, body, medium);
}
