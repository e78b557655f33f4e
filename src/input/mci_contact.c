/* SPDX-License-Identifier: MIT */
#include "input/mci_contact.h"

#include "base/array.h"
#include "input/mci_options.h"
#include "scene/contact.h"

#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name;
    enum cml_detector_shape shape;
    enum cml_key_group keys;
} shapes[] = {{"disk", CML_DETECTOR_RING, CML_KEYS_CONTACT_DISK},
              {"ring", CML_DETECTOR_RING, CML_KEYS_CONTACT_RING},
              {"rectangle", CML_DETECTOR_RECTANGLE, CML_KEYS_CONTACT_RECTANGLE}};
enum { NUM_SHAPES = sizeof shapes / sizeof *shapes };

/* ---- one line ---- */

/* Reads the shape, if the line has one; *word is the word that follows it, or the first one. */
static cml_status read_shape(const struct cml_mci_line *line, struct cml_contact_def *contact, char **word)
{
    struct cml_mci_reader *reader = line->reader;
    int s = 0;
    *word = cml_text_word(&reader->cursor);
    while (s < NUM_SHAPES && !(*word && strcmp(shapes[s].name, *word) == 0)) s++;
    contact->whole = s == NUM_SHAPES;
    if (contact->whole)
        return contact->port
                   ? cml_mci_fail_option(line, "shape", *word, "disk R, ring R1 R2 or rectangle W H")
                   : CML_OK;
    contact->shape = shapes[s].shape;
    contact->ring = s == 1;
    CML_TRY(cml_mci_leading_numbers(reader, line->owner, CML_KEY_PARTS({shapes[s].keys, contact})));
    if (!contact->port) *word = cml_text_word(&reader->cursor);
    return CML_OK;
}

/* Reads what a face is made of, from `word` on: R and its law, or a metal. */
static cml_status read_face(const struct cml_mci_line *line, const char *word,
                            struct cml_contact_def *contact)
{
    static const char *const laws[] = {"mirror", "lambertian"};
    struct cml_mci_reader *reader = line->reader;
    const struct cml_key *R = cml_keys_of(CML_KEYS_FACE);
    char expected[CML_KEY_TEXT];
    contact->face.kind = CML_BACKING_METAL;
    if (word && strcmp(word, "metal") == 0)
        return cml_mci_leading_numbers(reader, line->owner, CML_KEY_PARTS({CML_KEYS_FACE_METAL, contact}));
    if (!word || !cml_key_parse(R, word, &contact->face.R))
        return cml_mci_fail_option(
            line, cml_key_shown(R), word,
            CML_TEXT("%s, or metal N K%s", cml_key_expected(R, expected),
                     contact->whole ? ", behind disk R, ring R1 R2, rectangle W H or no shape" : ""));
    char *next = reader->cursor + strspn(reader->cursor, " \t\r");
    contact->face.kind = CML_BACKING_MIRROR;
    if (!*next || next[strcspn(next, "= \t\r")] == '=') return CML_OK;
    word = cml_text_word(&reader->cursor);
    const int law = cml_mci_choose(word, laws, 2);
    if (law == 1) contact->face.kind = CML_BACKING_LAMBERTIAN;
    return law >= 0 ? CML_OK
                    : cml_mci_fail_option(line, "law", word, "mirror, lambertian or the end of the line");
}

static cml_status set_name(struct cml_mci_line *line)
{
    struct cml_contact_def *contact = line->context;
    return cml_mci_take_name(line, &contact->name);
}

cml_status cml_mci_contact(struct cml_mci_reader *reader, bool port, struct cml_scene *scene)
{
    const int n = scene->num_contacts;
    const char *owner = port ? "port" : "face";
    char *word;
    if (n == CML_MOST_CONTACTS)
        return cml_mci_fail(reader, "line", cml_mci_raw(reader), "at most 1000 face and port lines");
    CML_TRY(
        cml_array_grow(&scene->contacts, (size_t)n, sizeof *scene->contacts, "faces and ports", reader->err));
    struct cml_contact_def *contact = &scene->contacts[scene->num_contacts++];
    *contact = (struct cml_contact_def){.port = port, .line = reader->text.line};
    struct cml_mci_line line = {.reader = reader, .owner = owner, .own = set_name, .context = contact};
    cml_mci_cut_comment(reader->cursor);
    CML_TRY(read_shape(&line, contact, &word));
    if (!port) CML_TRY(read_face(&line, word, contact));
    if (contact->whole) return cml_mci_end_line(reader, owner);
    line.parts = port ? CML_KEY_PARTS({CML_KEYS_PORT, contact}, {CML_KEYS_CONTACT, contact})
                      : CML_KEY_PARTS({CML_KEYS_CONTACT, contact});
    CML_TRY(cml_mci_options(&line));
    if (port && !cml_mci_saw(&line, "n")) return cml_mci_fail_option(&line, "n", NULL, "n=N, its index");
    return CML_OK;
}

/* ---- settings ---- */

int cml_mci_contacts_of(const struct cml_scene *scene, bool ports)
{
    int count = 0;
    for (int k = 0; k < scene->num_contacts; k++) count += scene->contacts[k].port == ports;
    return count;
}

void cml_mci_contact_parts(struct cml_scene *scene, bool port, int i, struct cml_key_part *part)
{
    struct cml_contact_def *contact = scene->contacts;
    while (contact->port != port || i-- > 0) contact++;
    const bool metal = contact->face.kind == CML_BACKING_METAL;
    *part++ = (struct cml_key_part){port    ? CML_KEYS_PORT
                                    : metal ? CML_KEYS_FACE_METAL
                                            : CML_KEYS_FACE,
                                    contact};
    if (!contact->whole) {
        const int round = contact->ring ? 1 : 0;
        *part++ = (struct cml_key_part){CML_KEYS_CONTACT, contact};
        *part++ =
            (struct cml_key_part){shapes[contact->shape == CML_DETECTOR_RING ? round : 2].keys, contact};
    }
    *part = (struct cml_key_part){CML_KEYS_NONE, NULL};
}

/* ---- checks of several lines ---- */

/* Returns the number of the port of this name, from 1; 0: none. */
static int port_of(const struct cml_scene *scene, const char *name)
{
    for (int k = 0; k < scene->num_contacts; k++)
        if (scene->contacts[k].name && strcmp(scene->contacts[k].name, name) == 0) return k + 1;
    return 0;
}

cml_status cml_mci_find_port(const struct cml_mci_reader *reader, const struct cml_scene *scene,
                             const char *name, const char *owner, const char *file, int line, int *contact)
{
    *contact = name ? port_of(scene, name) : 0;
    if (!name || *contact) return CML_OK;
    return cml_fail_field(reader->err, file, line, CML_TEXT("%s: port", owner), name,
                          "the name or number of a port line, which stands before layer 1");
}

/* Gives a port without a name its number among ports, and refuses a name that is taken. */
static cml_status name_port(const struct cml_mci_reader *reader, struct cml_scene *scene, int k, int number)
{
    struct cml_contact_def *port = &scene->contacts[k];
    if (!port->name) CML_TRY(cml_text_copy(CML_TEXT("%d", number), &port->name, reader->err));
    const int first = port_of(scene, port->name) - 1;
    if (first == k) return CML_OK;
    return cml_fail_field(
        reader->err, scene->file, port->line, "port: name", port->name,
        CML_TEXT("another name than that of the port in line %d", scene->contacts[first].line));
}

/* Refuses a boundary 0 that is no smooth plane: only a plane touches a probe everywhere. */
static cml_status check_plane(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    const struct cml_boundary *top = &scene->boundaries[0];
    const int line = top->line ? top->line : top->rough.line;
    if (!line) return CML_OK;
    return cml_fail_field(
        reader->err, scene->file, line, "boundary 0",
        top->line ? "a shape beside face or port lines" : "rough beside face or port lines",
        "a smooth plane. A probe on a rough surface touches a film of gel or sweat: write the "
        "film as layer 1, clear (n 1.33) and thicker than the relief, and the surface as "
        "boundary 1");
}

/* True if no medium of the material absorbs. */
static bool absorbs_nowhere(const struct cml_scene *scene)
{
    for (int m = 1; m < scene->num_layers + 2 + scene->num_bodies; m++)
        if (scene->media[m].mua > 0) return false;
    return true;
}

/* Refuses walls of which all light comes back forever. */
static cml_status check_walls(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    const int whole = cml_contact_whole(scene);
    bool open = whole == 0;
    for (int k = whole ? whole - 1 : 0; k < scene->num_contacts; k++) {
        const struct cml_contact_def *contact = &scene->contacts[k];
        const bool lets_out = contact->port || !cml_reflects_all(&contact->face);
        open |= lets_out && (contact->whole || !cml_contact_is_hidden(scene, k + 1));
    }
    const struct cml_backing_def *backing = &scene->backing;
    if (open || backing->kind == CML_BACKING_NONE || !cml_reflects_all(backing) || !absorbs_nowhere(scene))
        return CML_OK;
    return cml_fail_field(
        reader->err, scene->file, scene->contacts[whole - 1].line, "face: R", "1",
        "less than 1, a port that no line covers, or a medium that absorbs: over a backing of R = 1 "
        "light would never end");
}

cml_status cml_mci_end_contacts(const struct cml_mci_reader *reader, struct cml_scene *scene)
{
    int ports = 0;
    if (scene->num_contacts == 0) return CML_OK;
    CML_TRY(check_plane(reader, scene));
    for (int k = 0; k < scene->num_contacts; k++) {
        const struct cml_contact_def *contact = &scene->contacts[k];
        if (contact->ring && contact->size[0] >= contact->size[1])
            return cml_fail_field(reader->err, scene->file, contact->line,
                                  contact->port ? "port: r1 r2" : "face: r1 r2",
                                  CML_TEXT("%g %g", contact->size[0], contact->size[1]), "r1 < r2");
        if (contact->port) CML_TRY(name_port(reader, scene, k, ++ports));
    }
    return check_walls(reader, scene);
}
