/* SPDX-License-Identifier: MIT */
#include "input/mci_settings.h"

#include "input/mci_beam.h"
#include "input/mci_contact.h"
#include "input/mci_detector.h"
#include "input/mci_medium.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Parses the text of a setting and stores it as the value of the key in its struct, `base`. */
static cml_status set(const struct cml_mci_reader *reader, const struct cml_setting *setting,
                      const struct cml_key *key, void *base)
{
    double value;
    char expected[CML_KEY_TEXT];
    if (!cml_key_parse(key, setting->value, &value))
        return cml_setting_fail(setting, cml_key_expected(key, expected), reader->err);
    cml_key_store(key, base, value);
    return CML_OK;
}

/* Replaces the scale factors of boundary b by settings like boundary0.scale. They are needed before the
 * shape is read, earlier than other settings. */
cml_status cml_mci_set_scaling(const struct cml_mci_reader *reader, int b, double *scale, double *height)
{
    struct cml_boundary factors = {.scale = *scale, .height = *height};
    const struct cml_key *key = cml_keys_of(CML_KEYS_SHAPE);
    for (; reader->options->settings && key->group == CML_KEYS_SHAPE; key++) {
        const struct cml_setting *setting =
            cml_settings_find(reader->options->settings, CML_TEXT("boundary%d.%s", b, key->name));
        if (setting) CML_TRY(set(reader, setting, key, &factors));
    }
    *scale = factors.scale;
    *height = factors.height;
    return CML_OK;
}

/* ---- names ---- */

/* The parts of a setting's name: "beam2.na" has the owner "beam", number 2 and member "na". number -1: no
 * number. */
struct name {
    /* text before the dot, "beam2", which may be the name of a layer; "" if it is too long */
    char whole[CML_LAYER_NAME];
    /* word before the number; "" if the text before the dot is not a word with a number */
    char owner[16];
    int number;
    const char *member;
};

/* Splits a setting's name such as layer2.mua into owner, number and member; false if it has no dot. Numbers
 * have no leading 0. */
static bool split(const char *text, struct name *name)
{
    const char *dot = strchr(text, '.');
    if (!dot) return false;
    const size_t length = (size_t)(dot - text), letters = strcspn(text, "0123456789."),
                 digits = strspn(text + letters, "0123456789");
    *name = (struct name){.number = -1, .member = dot + 1};
    if (length < sizeof name->whole) snprintf(name->whole, sizeof name->whole, "%.*s", (int)length, text);
    if (letters >= sizeof name->owner || letters + digits != length || digits > 9 ||
        (digits > 1 && text[letters] == '0'))
        return true;
    snprintf(name->owner, sizeof name->owner, "%.*s", (int)letters, text);
    if (digits) name->number = (int)strtol(text + letters, NULL, 10);
    return true;
}

/* ---- owners: the words before the dot ---- */

enum owner { ABOVE, BELOW, LAYER, BODY, BOUNDARY, BACKING, BEAM, DETECTOR, FACE, PORT, NUM_OWNERS };
static const char *const owner_words[NUM_OWNERS] = {"above",   "below", "layer",    "body", "boundary",
                                                    "backing", "beam",  "detector", "face", "port"};

/* Returns how many owners of a kind the scene has: layers, bodies, beams and so on. --set names them by
 * number. */
static int count_of(const struct cml_scene *scene, enum owner owner)
{
    const int counts[NUM_OWNERS] = {1,
                                    1,
                                    scene->num_layers,
                                    scene->num_bodies,
                                    scene->num_layers + 1,
                                    1,
                                    scene->num_beams,
                                    cml_num_areas(scene),
                                    cml_mci_contacts_of(scene, false),
                                    cml_mci_contacts_of(scene, true)};
    return counts[owner];
}

/* True if the names of an owner have numbers: there may be several, and for beams and detectors there are. */
static bool is_numbered(const struct cml_scene *scene, enum owner owner)
{
    return owner == LAYER || owner == BODY || owner == BOUNDARY ||
           (owner >= BEAM && count_of(scene, owner) > 1);
}

/* True if "phase." stands before the keys of the group. */
static bool of_phase(enum cml_key_group group)
{
    return group >= CML_KEYS_HG2 && group <= CML_KEYS_GK;
}

/* Lists the groups of keys that --set can change of the i-th owner (from 0): a boundary, layer, body, beam
 * and so on. The group of its phase function comes last. */
static void parts_of(struct cml_scene *scene, enum owner owner, int i, struct cml_key_part *part)
{
    if (owner == BEAM) cml_mci_beam_parts(scene, i, false, part);
    if (owner == DETECTOR) cml_mci_detector_parts(&scene->detectors[i], part);
    if (owner == FACE || owner == PORT) cml_mci_contact_parts(scene, owner == PORT, i, part);
    if (owner >= BEAM) return;
    struct cml_medium_def *media = scene->media,
                          *medium = &media[owner == BODY ? cml_body_medium(scene, i) : i + 1];
    struct cml_boundary *boundary = &scene->boundaries[owner == BOUNDARY ? i : 0];
    const enum cml_backing_kind backing = scene->backing.kind;
    if (owner == ABOVE) *part++ = (struct cml_key_part){CML_KEYS_N_ABOVE, media};
    if (owner == BELOW) *part++ = (struct cml_key_part){CML_KEYS_N_BELOW, media + scene->num_layers + 1};
    if (owner == BACKING && backing != CML_BACKING_NONE)
        *part++ = (struct cml_key_part){backing == CML_BACKING_METAL ? CML_KEYS_METAL : CML_KEYS_BACKING,
                                        &scene->backing};
    if (owner == BOUNDARY && boundary->line > 0) *part++ = (struct cml_key_part){CML_KEYS_SHAPE, boundary};
    if (owner == BOUNDARY && boundary->rough.line > 0)
        *part++ = (struct cml_key_part){CML_KEYS_ROUGH, &boundary->rough};
    if (owner == LAYER || owner == BODY) *part++ = (struct cml_key_part){CML_KEYS_MEDIUM, medium};
    if (owner == LAYER) *part++ = (struct cml_key_part){CML_KEYS_LAYER, medium};
    if (owner == BODY && medium->rough.line > 0)
        *part++ = (struct cml_key_part){CML_KEYS_ROUGH, &medium->rough};
    if ((owner == LAYER || owner == BODY) && cml_mci_phase_keys(medium->phase) != CML_KEYS_NONE)
        *part++ = (struct cml_key_part){cml_mci_phase_keys(medium->phase), NULL};
    *part = (struct cml_key_part){CML_KEYS_NONE, NULL};
}

/* Finds what a setting's name belongs to, such as a layer or a beam, and its index *i; false if the scene
 * has no such owner. */
static bool find_owner(const struct cml_scene *scene, const struct name *name, enum owner *owner, int *i)
{
    for (*owner = ABOVE; *owner < NUM_OWNERS; ++*owner) {
        if (strcmp(name->owner, owner_words[*owner]) != 0) continue;
        const bool numbered = is_numbered(scene, *owner);
        *i = numbered ? name->number - (*owner != BOUNDARY) : 0;
        return numbered == (name->number >= 0) && *i >= 0 && *i < count_of(scene, *owner);
    }
    *owner = LAYER;
    for (*i = 0; *name->whole && scene->layer_names && *i < scene->num_layers; ++*i)
        if (strcmp(scene->layer_names[*i + 1], name->whole) == 0) return true;
    return false;
}

/* Returns the key of a group that --set knows by this name; NULL: none. */
static const struct cml_key *find_key(enum cml_key_group group, const char *name)
{
    const struct cml_key *key = cml_keys_of(group);
    if (of_phase(group)) name += strncmp(name, "phase.", 6) == 0 ? 6 : strlen(name);
    for (; key->group == group && group != CML_KEYS_NONE; key++)
        if (key->use & CML_KEY_SET && strcmp(key->name, name) == 0) return key;
    return NULL;
}

/* Finds the number that a setting's name means: its key, and the struct *base that contains it. *key is NULL
 * if there is none. A medium whose phase function is meant gets its own copy of the function, since others
 * may share it. */
static cml_status find_number(struct cml_mci_reader *reader, struct cml_scene *scene, const struct name *name,
                              const struct cml_key **key, void **base)
{
    struct cml_key_part parts[CML_MOST_KEY_PARTS], *part = parts;
    struct cml_phase *own = NULL;
    enum owner owner;
    int i;
    *key = NULL;
    if (!find_owner(scene, name, &owner, &i)) return CML_OK;
    for (parts_of(scene, owner, i, parts); !*key && part->group != CML_KEYS_NONE; part++) {
        *key = find_key(part->group, name->member);
        *base = part->base;
    }
    if (*key && of_phase((*key)->group)) {
        CML_TRY(cml_mci_own_phase(reader, scene, owner == LAYER ? i + 1 : cml_body_medium(scene, i), &own));
        *base = own;
    }
    if (*key && owner == DETECTOR && strcmp((*key)->name, "z") == 0) scene->detectors[i].at_z = true;
    return CML_OK;
}

/* ---- messages about unknown names ---- */

/* Writes all names of a group that may be set, " .n .mua". Returns how many there are. out NULL: only counts.
 */
static int write_members(FILE *out, const char *before, enum cml_key_group group)
{
    const struct cml_key *key = cml_keys_of(group);
    int count = 0;
    for (; key->group == group && group != CML_KEYS_NONE; key++) {
        if (!(key->use & CML_KEY_SET)) continue;
        if (out) fprintf(out, "%s%s.%s", before, of_phase(group) ? ".phase" : "", key->name);
        count++;
    }
    return count;
}

/* True if two owners have the same groups of keys. */
static bool same_parts(const struct cml_key_part *one, const struct cml_key_part *other)
{
    for (; one->group == other->group; one++, other++)
        if (one->group == CML_KEYS_NONE) return true;
    return false;
}

/* Writes the owners of a kind with their names, ", above.n" or ", layer1..3 with .n .mua". Neighbours with
 * the same keys are written together. */
static void write_owners(FILE *out, struct cml_scene *scene, enum owner owner)
{
    struct cml_key_part parts[CML_MOST_KEY_PARTS], next[CML_MOST_KEY_PARTS];
    const int count = count_of(scene, owner), from = owner != BOUNDARY;
    for (int first = 0, last; first < count; first = last + 1) {
        int members = 0;
        parts_of(scene, owner, first, parts);
        for (last = first; last + 1 < count; last++) {
            parts_of(scene, owner, last + 1, next);
            if (!same_parts(parts, next)) break;
        }
        for (int p = 0; parts[p].group != CML_KEYS_NONE; p++)
            members += write_members(NULL, "", parts[p].group);
        if (members == 0) continue;
        fprintf(out, ", %s", owner_words[owner]);
        if (is_numbered(scene, owner)) fprintf(out, "%d", first + from);
        if (last > first) fprintf(out, "..%d", last + from);
        if (members > 1) fputs(" with", out);
        for (int p = 0; parts[p].group != CML_KEYS_NONE; p++)
            write_members(out, members > 1 ? " " : "", parts[p].group);
    }
}

/* Writes all names that may be set: "photons, above with .n ... , also named gel vessel". */
static void write_names(FILE *out, struct cml_scene *scene)
{
    fputs("photons", out);
    for (enum owner owner = ABOVE; owner < NUM_OWNERS; owner++) {
        write_owners(out, scene, owner);
        for (int l = 1, named = 0; owner == LAYER && l <= scene->num_layers; l++)
            if (*cml_layer_name(scene, l))
                fprintf(out, "%s %s", named++ ? "" : ", also named", cml_layer_name(scene, l));
    }
}

/* Refuses a setting whose name the scene does not have, and lists the names that it has. */
static cml_status fail_unknown(const struct cml_mci_reader *reader, const struct cml_setting *setting,
                               struct cml_scene *scene)
{
    char names[600] = "", expected[750];
    FILE *out = fmemopen(names, sizeof names, "w");
    if (out) {
        write_names(out, scene);
        fclose(out);
    }
    snprintf(expected, sizeof expected, "a name that the run in line %d knows: %s%s", scene->line, names,
             setting->column > 0 ? "; a label stands in quotation marks" : "");
    return cml_setting_fail(setting, expected, reader->err);
}

/* Refuses a second value for one number: a layer may be named in two ways, layer1.mua and gel.mua. place: the
 * members set by the settings before. */
static cml_status check_once(const struct cml_mci_reader *reader, const struct cml_settings *settings, int i,
                             const void *const *place)
{
    int k = 0;
    while (k < i && place[k] != place[i]) k++;
    if (k == i) return CML_OK;
    const struct cml_setting *first = &settings->item[k];
    return cml_setting_fail(&settings->item[i],
                            CML_TEXT("one value, but %.63s of %.80s has set it to %.30s", first->name,
                                     first->source, first->value),
                            reader->err);
}

/* Finds the member *key of the struct *base that a setting means; *key NULL: the scene has no such number. */
static cml_status find(struct cml_mci_reader *reader, struct cml_scene *scene, const char *text,
                       const struct cml_key **key, void **base)
{
    struct name name;
    *base = scene;
    *key = find_key(CML_KEYS_PHOTONS, text);
    return *key || !split(text, &name) ? CML_OK : find_number(reader, scene, &name, key, base);
}

/* Puts the values of all settings into the scene. place[] holds which number each setting changes, so that
 * none is set twice under two names. */
cml_status cml_mci_apply_settings(struct cml_mci_reader *reader, struct cml_scene *scene)
{
    const struct cml_settings *settings = reader->options->settings;
    const void *place[CML_MOST_SETTINGS] = {NULL};
    for (int i = 0; settings && i < settings->count; i++) {
        const struct cml_setting *setting = &settings->item[i];
        const struct cml_key *key;
        void *base;
        CML_TRY(find(reader, scene, setting->name, &key, &base));
        if (!key) return fail_unknown(reader, setting, scene);
        place[i] = (const char *)base + key->member;
        CML_TRY(check_once(reader, settings, i, place));
        /* the reader of a shape has already applied these (cml_mci_set_scaling) */
        if (key->group != CML_KEYS_SHAPE) CML_TRY(set(reader, setting, key, base));
    }
    return CML_OK;
}

int cml_mci_layer_of(const struct cml_scene *scene, const char *text)
{
    struct name name;
    enum owner owner;
    int i;
    return split(text, &name) && find_owner(scene, &name, &owner, &i) && owner == LAYER ? i + 1 : 0;
}

/* Asks a copy of the scene, because a medium gets its own phase function when one of its numbers is looked
 * up. */
cml_status cml_mci_is_setting(const struct cml_scene *scene, const char *text, bool *known,
                              struct cml_error *err)
{
    struct cml_mci_reader reader = {.err = err};
    const struct cml_key *key = NULL;
    CML_AT_END(cml_scene_clear) struct cml_scene copy = {0};
    void *base;
    *known = false;
    CML_TRY(cml_scene_copy(scene, &copy, err));
    CML_TRY(find(&reader, &copy, text, &key, &base));
    *known = key != NULL;
    return CML_OK;
}

bool cml_mci_resembles_setting(const char *text)
{
    struct cml_guess guess = {.word = text, .length = strlen(text)};
    if (strchr(text, '.')) return true;
    for (int i = 0; i < NUM_OWNERS; i++)
        if (strncasecmp(text, owner_words[i], strlen(owner_words[i])) == 0) return true;
    for (const struct cml_key *key = cml_key_table; key->group != CML_KEYS_NONE; key++) {
        if (!(key->use & CML_KEY_SET) || strchr(cml_key_owners[key->group].set, '.')) continue;
        if (strcasecmp(text, key->name) == 0) return true;
        if (strlen(key->name) > 2) cml_guess_offer(&guess, key->name);
    }
    cml_guess_offer(&guess, "seed");
    return cml_guess_best(&guess) != NULL;
}

/* ---- the name of a layer ---- */

/* Refuses roughness in the line of a layer: it belongs to a boundary, and has a line of its own. Original
 * MCML ignores any word behind the five numbers, so only words that can mean nothing else are refused. */
static cml_status refuse_rough(struct cml_mci_reader *reader, const char *owner)
{
    static const char *const keys[] = {"rough=", "rough ggx", "rough beckmann"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        const char *word = cml_mci_find_word(reader->cursor, keys[i]);
        if (word)
            return cml_mci_fail(reader, owner, word,
                                "a line `rough KIND ALPHA` before the layer whose top it is");
    }
    return CML_OK;
}

/* True if --set and sweeps use the name for something else: photons, above, layer2 ... */
static bool is_taken(const char *name)
{
    for (enum owner owner = ABOVE; owner < NUM_OWNERS; owner++) {
        const size_t length = strlen(owner_words[owner]);
        const char *rest = name + length;
        if (strncmp(name, owner_words[owner], length) != 0) continue;
        if (owner == ABOVE || owner == BELOW || owner == BACKING ? !*rest : !rest[strspn(rest, "0123456789")])
            return true;
    }
    return strcmp(name, "photons") == 0 || strcmp(name, "seed") == 0;
}

/* Returns the rule that a name of a layer breaks, as text for "expected ..."; NULL: the name is good. */
static const char *why_no_layer_name(const struct cml_scene *scene, int layer, const char *name)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789";
    const size_t length = strlen(name);
    if (length == 0 || length >= CML_LAYER_NAME || name[strspn(name, letters)] != '\0' ||
        strchr("0123456789", *name))
        return cml_keys_of(CML_KEYS_NAMED)->noun;
    if (is_taken(name)) return "a name that no other part of a scene has";
    for (int l = 1; l < layer; l++)
        if (strcmp(cml_layer_name(scene, l), name) == 0) return "a name that no layer before has";
    return NULL;
}

cml_status cml_mci_layer_name(struct cml_mci_reader *reader, const char *owner, int layer,
                              struct cml_scene *scene)
{
    cml_mci_cut_comment(reader->cursor);
    CML_TRY(refuse_rough(reader, owner));
    char *word = cml_mci_find_word(reader->cursor, "name=");
    if (!word) return CML_OK;
    *word = '\0'; /* the numbers before name= end here */
    const char *name = word += strlen("name=");
    word += strcspn(word, " \t\v\f\r");
    const bool again = *word && cml_mci_find_word(word + 1, "name=");
    *word = '\0';
    const char *expected = again ? "one name" : why_no_layer_name(scene, layer, name);
    if (expected) return cml_mci_fail(reader, CML_TEXT("%s: name", owner), name, expected);
    if (!scene->layer_names)
        CML_TRY(cml_zeros(&scene->layer_names, (size_t)scene->num_layers + 1, sizeof *scene->layer_names,
                          "the layers", reader->err));
    strcpy(scene->layer_names[layer], name);
    return CML_OK;
}
