/* Tests every number of the table of keys, in scene files and by --set. Values outside the range are
 * refused with a message that names the range; the bounds themselves are accepted. A group of keys without
 * a line in this file fails. SPDX-License-Identifier: MIT */
#include "lib/mci_case.h"

#include "input/keys/key.h"

#include <math.h>

#define NAME "1.0\n1\na.mco A\n"
#define RUN NAME "100\n0.1 0.2\n3 4 5\n"
#define LAYER "1.4 1 2 0.9 1\n"
#define BODY "1\n1\n" LAYER "1\n"
#define LAST RUN "1\n1\n" LAYER

/* A scene with the line of one group of keys. Numbers that belong to a place, not to a word, stand between
 * `before` and `after`; NULL: the group has none. */
static const struct line {
    const char *before, *numbers, *after;
} lines[CML_NUM_KEY_GROUPS] = {
    [CML_KEYS_RUNS] = {"1.0\n", "1", "\na.mco A\n100\n0.1 0.2\n3 4 5\n" BODY},
    [CML_KEYS_PHOTONS] = {NAME, "100", "\n0.1 0.2\n3 4 5\n" BODY},
    [CML_KEYS_STEPS] = {NAME "100\n", "0.1 0.2", "\n3 4 5\n" BODY},
    [CML_KEYS_BINS] = {NAME "100\n0.1 0.2\n", "3 4 5", "\n" BODY},
    [CML_KEYS_LAYERS] = {RUN, "1", "\n1\n" LAYER "1\n"},
    [CML_KEYS_N_ABOVE] = {RUN "1\n", "1", "\n" LAYER "1\n"},
    [CML_KEYS_N_BELOW] = {LAST, "1", "\n"},
    [CML_KEYS_MEDIUM] = {RUN "1\n1\n", "1.4 1 2 0.9", " 1\n1\n"},
    [CML_KEYS_NAMED] = {RUN "1\n1\n1.4 1 2 0.9 1", "", "\n1\n"},
    [CML_KEYS_LAYER] = {RUN "1\n1\n1.4 1 2 0.9 ", "1", "\n1\n"},
    [CML_KEYS_HG2] = {LAST "phase hg2 ", "0.9 0.5 1", "\n1\n"},
    [CML_KEYS_MHG] = {LAST "phase mhg ", "0.9 1", "\n1\n"},
    [CML_KEYS_GK] = {LAST "phase gk ", "0.9 0.5", "\n1\n"},
    [CML_KEYS_BACKING] = {LAST "backing ", "0.5", "\n1\n"},
    [CML_KEYS_METAL] = {LAST "backing metal ", "0.2 3", "\n1\n"},
    [CML_KEYS_CONTACT] = {RUN "1\n1\nport disk 0.1 n=1.5", "", "\n" LAYER "1\n"},
    [CML_KEYS_CONTACT_DISK] = {RUN "1\n1\nport disk ", "0.1", " n=1.5\n" LAYER "1\n"},
    [CML_KEYS_CONTACT_RING] = {RUN "1\n1\nport ring ", "0 0.1", " n=1.5\n" LAYER "1\n"},
    [CML_KEYS_CONTACT_RECTANGLE] = {RUN "1\n1\nport rectangle ", "0.1 0.2", " n=1.5\n" LAYER "1\n"},
    [CML_KEYS_FACE] = {RUN "1\n1\nface disk 0.1 ", "0.5", "\n" LAYER "1\n"},
    [CML_KEYS_FACE_METAL] = {RUN "1\n1\nface disk 0.1 metal ", "0.2 3", "\n" LAYER "1\n"},
    [CML_KEYS_PORT] = {RUN "1\n1\nport disk 0.1", " n=1.5", "\n" LAYER "1\n"},
    [CML_KEYS_ROUGH] = {RUN "1\n1\nrough ggx ", "0.3", "\n" LAYER "1\n"},
    [CML_KEYS_SHAPE] = {RUN "1\n1\nb 2 0.1 0.1 0 1", "", "\n" LAYER "1\n"},
    [CML_KEYS_MESH] = {RUN "1\n1\nm \"none.obj\"", "", "\n" LAYER "1\n"},
    [CML_KEYS_PLACE] = {RUN "1\n1\nm \"none.obj\"", "", "\n" LAYER "1\n"},
    [CML_KEYS_SHEET] = {RUN "1\n1\nm \"none.obj\"", "", "\n" LAYER "1\n"},
    [CML_KEYS_TILE] = {RUN "1\n1\nm \"none.obj\"", "", "\n" LAYER "1\n"},
    [CML_KEYS_SOLID] = {LAST "i \"none.obj\" 1.4 1 2 0.9", "", "\n1\n"},
    [CML_KEYS_RELIEF] = {RUN "1\n1\nm gaussian ", "0.3 0.01", " points=7\n" LAYER "1\n"},
    [CML_KEYS_SPHERE] = {LAST "i sphere ", "0 0 0.5 0.1", " 1.4 1 2 0.9\n1\n"},
    [CML_KEYS_CYLINDER] = {LAST "i cylinder ", "0 0 0.5 1 0 0.5 0.1", " 1.4 1 2 0.9\n1\n"},
    [CML_KEYS_BEAM] = {RUN "beam pencil", "", "\n" BODY},
    [CML_KEYS_START] = {RUN "beam pencil", " z=0.5", "\n" BODY},
    [CML_KEYS_INSIDE] = {RUN "beam pencil z=0.5", "", "\n" BODY},
    [CML_KEYS_ABOVE] = {RUN "beam pencil", "", "\n" BODY},
    [CML_KEYS_AXIS] = {RUN "beam pencil", "", "\n" BODY},
    [CML_KEYS_SHARE] = {RUN "beam pencil\nbeam pencil", "", "\n" BODY},
    [CML_KEYS_LIGHT] = {RUN "beam pencil light=na:0.2", "", "\n" BODY},
    [CML_KEYS_BEAM_DISK] = {RUN "beam disk ", "0.1", "\n" BODY},
    [CML_KEYS_BEAM_RING] = {RUN "beam ring ", "0.1 0.2", "\n" BODY},
    [CML_KEYS_BEAM_RECTANGLE] = {RUN "beam rectangle ", "0.1 0.2", "\n" BODY},
    [CML_KEYS_DETECTOR] = {RUN "detector disk 0.1", "", "\n" BODY},
    [CML_KEYS_AIM] = {RUN "detector disk 0.1", " na=0.2", "\n" BODY},
    [CML_KEYS_SIGHT] = {RUN "detector disk 0.1", "", "\n" BODY},
    [CML_KEYS_DETECTOR_DISK] = {RUN "detector disk ", "0.1", "\n" BODY},
    [CML_KEYS_DETECTOR_RING] = {RUN "detector ring ", "0.1 0.2", "\n" BODY},
    [CML_KEYS_DETECTOR_RECTANGLE] = {RUN "detector rectangle ", "0.1 0.2", "\n" BODY},
    [CML_KEYS_DETECTOR_MAP] = {RUN "detector map ", "3 4 0.1 0.2", "\n" BODY},
    [CML_KEYS_MAP] = {RUN "map ", "3 4 0.1 0.2", "\n" BODY},
    [CML_KEYS_VOLUME] = {RUN "map 3 4 0.1 0.2 volume", "", "\n" BODY},
    [CML_KEYS_FLUENCE] = {RUN "fluence", "", "\n" BODY},
    [CML_KEYS_TIME] = {RUN "time ", "100 10", "\n" BODY},
    [CML_KEYS_DIRECTIONS] = {RUN "directions ", "3 4", "\n" BODY},
    [CML_KEYS_SAVED] = {RUN "photons \"p\"", "", "\n" BODY},
};

static bool is_number(const struct cml_key *key)
{
    return key->type == CML_KEY_REAL || key->type == CML_KEY_ANGLE || key->type == CML_KEY_INT ||
           key->type == CML_KEY_COUNT;
}

/* Writes a scene whose line sets the key to `value`, at the number's place or as an option. */
static void write_scene(char text[600], const struct cml_key *key, const char *value)
{
    const struct line *line = &lines[key->group];
    const char *number = line->numbers;
    char *end = text + sprintf(text, "%s", line->before);
    if (key->use & CML_KEY_OPTION) {
        const bool again = strstr(line->numbers, key->name) != NULL;
        sprintf(end, "%s %s=%s%s", again ? "" : line->numbers, key->name, value, line->after);
        return;
    }
    for (const struct cml_key *other = cml_keys_of(key->group); other->group == key->group; other++) {
        if (!(other->use & CML_KEY_PLACED)) continue;
        const size_t length = strcspn(number, " ");
        end += sprintf(end, "%.*s ", other == key ? (int)strlen(value) : (int)length,
                       other == key ? value : number);
        number += length + (number[length] == ' ');
    }
    sprintf(end, "%s", line->after);
}

/* Returns a value just above or below the key's range. */
static double beyond(const struct cml_key *key, bool above)
{
    const bool whole = key->type == CML_KEY_INT || key->type == CML_KEY_COUNT;
    const double bound = above ? key->most : key->least;
    const bool open = key->use & (above ? CML_KEY_BELOW : CML_KEY_ABOVE);
    const double next = nextafter(bound, above ? HUGE_VAL : -HUGE_VAL);
    return open ? bound : !whole ? next : above ? fmax(next, floor(bound + 1)) : bound - 1;
}

static double within(const struct cml_key *key, bool above)
{
    const double bound = above ? key->most : key->least;
    const bool open = key->use & (above ? CML_KEY_BELOW : CML_KEY_ABOVE);
    return open ? nextafter(bound, above ? -HUGE_VAL : HUGE_VAL) : bound;
}

/* True if the scene is refused for a value outside the key's range. The value stands in the text, or in
 * `setting` unless that is NULL. */
static bool is_refused(void **state, const struct cml_key *key, const char *text, const char *setting)
{
    char expected[CML_KEY_TEXT], message[CML_KEY_TEXT + 20];
    struct cml_settings settings = {0};
    struct cml_scene_list list;
    struct cml_error err = {0};
    const struct cml_input_options options = {.settings = setting ? &settings : NULL};
    if (setting) assert_int_equal(cml_settings_add(&settings, setting, &err), CML_OK);
    const cml_status status = case_read_with(state, text, &options, &list, &err);
    if (status == CML_OK) cml_scene_list_clear(&list);
    snprintf(message, sizeof message, "(expected %s", cml_key_expected(key, expected));
    return status == CML_E_INPUT && strstr(err.text, message) && strstr(err.text, " = ");
}

static void check(void **state, const struct cml_key *key, double value, bool refused)
{
    char number[40], name[CML_SETTING_NAME], setting[2 * CML_SETTING_NAME], text[600], sound[600];
    snprintf(number, sizeof number, "%.17g", value);
    write_scene(text, key, number);
    if (key->use & (CML_KEY_PLACED | CML_KEY_OPTION) && is_refused(state, key, text, NULL) != refused)
        fail_msg("%s is %s:\n%s", number, refused ? "taken" : "refused", text);
    if (!(key->use & CML_KEY_SET)) return;
    const char *owner = cml_key_owners[key->group].set;
    snprintf(name, sizeof name, "%s%s%s", owner, *owner ? "." : "", key->name);
    snprintf(setting, sizeof setting, "%s=%s", name, number);
    const struct line *line = &lines[key->group];
    snprintf(sound, sizeof sound, "%s%s%s", line->before, line->numbers, line->after);
    if (is_refused(state, key, sound, setting) != refused)
        fail_msg("--set %s is %s:\n%s", setting, refused ? "taken" : "refused", sound);
}

static void numbers_are_held_to_their_ranges(void **state)
{
    int count = 0;
    for (const struct cml_key *key = cml_key_table; key->group != CML_KEYS_NONE; key++) {
        if (!lines[key->group].before) fail_msg("no line with %s", key->name);
        if (!is_number(key)) continue;
        for (int above = 0; above < 2; above++) {
            check(state, key, beyond(key, above), true);
            check(state, key, within(key, above), false);
        }
        if (key->use & CML_KEY_OR_0) check(state, key, 0, false);
        count++;
    }
    assert_true(count > 60);
}

/* ---- defaults ---- */

/* Defaults that are no value of their key. */
static const char *const words[] = {"none",
                                    "above all surfaces",
                                    "smooth",
                                    "not repeated",
                                    "all directions",
                                    "its number, from 1",
                                    "no group",
                                    "no",
                                    "the nominal plane of its side",
                                    "the z axis",
                                    "its number among ports, from 1"};

static bool is_word(const char *text)
{
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strcmp(text, words[i]) == 0) return true;
    return false;
}

/* The scene of a group, in which the key's line ends with `option`. A relief has so few points that it is
 * read quickly, unless `points` is the key. */
static void write_with(char text[600], const struct cml_key *key, const char *option)
{
    struct line line = lines[key->group];
    const bool alone = strstr(line.numbers, key->name) && !(key->use & CML_KEY_PLACED);
    if (key->group == CML_KEYS_RELIEF) line.numbers = "0.3 0.01 tile";
    if (key->group == CML_KEYS_RELIEF) line.after = "\n" LAYER "1\n";
    sprintf(text, "%s%s%s%s%s", line.before, alone ? "" : line.numbers, *option ? " " : "", option,
            line.after);
}

static void print_keys(FILE *out, enum cml_key_group group, const void *base)
{
    for (const struct cml_key *key = cml_keys_of(group); key->group == group; key++) {
        if (is_number(key)) fprintf(out, "%s %.17g\n", key->name, cml_key_load(key, base));
        if (key->type == CML_KEY_FLAG)
            fprintf(out, "%s %d\n", key->name, *((const bool *)base + key->member));
    }
}

static void print_shape(FILE *out, const struct cml_boundary *boundary)
{
    const struct cml_heightmap *tile = &boundary->tile;
    double heights = 0, corners = 0;
    for (int i = 0; i < tile->nx * tile->ny; i++) heights += (1 + i % 97) * tile->h[i];
    for (size_t i = 0; i < 3 * boundary->mesh.num_vertices; i++)
        corners += (1.0 + (double)i) * ((const double *)boundary->mesh.vertex)[i];
    fprintf(out, "%d %d %d %.17g %.17g\n", boundary->form, tile->nx, tile->ny, tile->dx, heights);
    fprintf(out, "%d %d %.17g\n", boundary->mesh.normals, boundary->tile_normals, corners);
}

/* Everything that a key with a default decides, as text. */
static char *describe(const struct cml_scene *scene)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    print_keys(out, CML_KEYS_SHARE, scene->shares);
    for (int g = CML_KEYS_BEAM; g <= CML_KEYS_AXIS; g++) print_keys(out, (enum cml_key_group)g, scene->beams);
    fprintf(out, "%d %d %d\n", scene->beams->light.kind, scene->beams->radial, scene->beams->inside);
    for (int k = 0; k < scene->num_detectors; k++) {
        const struct cml_detector_def *detector = &scene->detectors[k];
        for (int g = CML_KEYS_DETECTOR; g <= CML_KEYS_SIGHT; g++)
            print_keys(out, (enum cml_key_group)g, detector);
        fprintf(out, "%s %d %d %d\n", detector->name, detector->below, detector->at_z, detector->aimed);
    }
    print_keys(out, CML_KEYS_MAP, &scene->map);
    print_keys(out, CML_KEYS_VOLUME, &scene->map);
    print_keys(out, CML_KEYS_TIME, &scene->time);
    print_keys(out, CML_KEYS_FLUENCE, &scene->fluence);
    print_keys(out, CML_KEYS_SAVED, &scene->saved);
    print_shape(out, scene->boundaries);
    fclose(out);
    return text;
}

/* The description of the scene, to be freed; NULL: it is refused. */
static char *read_as_text(void **state, const char *scene, const char *setting)
{
    struct cml_settings settings = {0};
    struct cml_scene_list list;
    struct cml_error err = {0};
    const struct cml_input_options options = {.settings = setting ? &settings : NULL};
    if (setting) assert_int_equal(cml_settings_add(&settings, setting, &err), CML_OK);
    if (case_read_with(state, scene, &options, &list, &err) != CML_OK) return NULL;
    char *text = describe(list.scenes);
    cml_scene_list_clear(&list);
    return text;
}

static void check_default(void **state, const struct cml_key *key)
{
    char option[120] = "", setting[120], with[600], without[600];
    const char *fallback = cml_key_fallback(key);
    const bool is_option = key->use & CML_KEY_OPTION;
    if (is_option) snprintf(option, sizeof option, "%s=%s", key->name, fallback);
    snprintf(setting, sizeof setting, "%s.%s=%s", cml_key_owners[key->group].set, key->name, fallback);
    write_with(with, key, option);
    write_with(without, key, "");
    char *expected = read_as_text(state, without, NULL),
         *text = read_as_text(state, with, is_option ? NULL : setting);
    if (!expected) fail_msg("%s cannot be left out:\n%s", key->name, without);
    if (is_word(fallback) ? text != NULL : !text)
        fail_msg("the default %s of %s is %s", fallback, key->name, text ? "a value" : "no value");
    if (text) assert_string_equal(text, expected);
    snprintf(option, sizeof option, "\n%s 0\n", key->name);
    if (key->type == CML_KEY_FLAG && !strstr(expected, option))
        fail_msg("%s is set without its word", key->name);
    free(text);
    free(expected);
}

/* A line has few enough numbers to be refused when one of them is left out. */
static void check_required(void **state, const struct cml_key *key)
{
    char text[600];
    if (key->use & CML_KEY_PLACED)
        write_scene(text, key, "");
    else
        sprintf(text, RUN "1\n1\nm gaussian 0.3 0.01\n" LAYER "1\n");
    char *taken = read_as_text(state, text, NULL);
    if (taken) fail_msg("%s is not required:\n%s", key->name, text);
}

/* The reader takes the default of the table where a key is absent. A word stands for what is no value. */
static void defaults_are_those_of_the_reader(void **state)
{
    int values = 0, required = 0;
    case_write(state, "none.obj",
               "v -1 -2 0\nv 1 -2 0\nv 1 2 0\nv -1 2 0\nv 0.1 0 0.5\n"
               "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n");
    for (const struct cml_key *key = cml_key_table; key->group != CML_KEYS_NONE; key++) {
        const bool is_required = strcmp(cml_key_fallback(key), "required") == 0;
        if (!key->meaning || key->group == CML_KEYS_LIGHT) continue; /* light=na:N has its number */
        if (is_required)
            check_required(state, key);
        else if (key->group != CML_KEYS_SOLID && key->group != CML_KEYS_NAMED)
            check_default(state, key);
        required += is_required;
        values += !is_required && !is_word(cml_key_fallback(key));
    }
    case_remove(state, "none.obj");
    assert_true(required > 50 && values > 25);
}

/* A value set by --set reaches the number that its name means, in the unit of the table. */
static void settings_have_the_units_of_the_table(void **state)
{
    (void)state;
    for (const struct cml_key *key = cml_key_table; key->group != CML_KEYS_NONE; key++) {
        char name[CML_SETTING_NAME];
        if (!(key->use & CML_KEY_SET)) continue;
        assert_non_null(cml_key_owners[key->group].set);
        snprintf(name, sizeof name, "%s.%s", cml_key_owners[key->group].set, key->name);
        assert_string_equal(cml_key_unit(name), key->unit ? key->unit : "1");
    }
}

static void groups_stand_together(void **state)
{
    (void)state;
    for (const struct cml_key *key = cml_key_table + 1; key->group != CML_KEYS_NONE; key++)
        assert_true(key->group == key[-1].group || cml_keys_of(key->group) == key);
    assert_string_equal(cml_key_unit("layer1.phase.w"), "1");
}

static void what_is_stored_is_loaded(void **state)
{
    (void)state;
    for (const struct cml_key *key = cml_key_table; key->group != CML_KEYS_NONE; key++) {
        const double value = key->type == CML_KEY_ANGLE ? 30.1 : 3;
        _Alignas(double) char base[4096] = {0};
        if (!is_number(key)) continue;
        cml_key_store(key, base, value);
        assert_true(cml_key_load(key, base) == value);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(numbers_are_held_to_their_ranges, case_setup, case_teardown),
        cmocka_unit_test_setup_teardown(defaults_are_those_of_the_reader, case_setup, case_teardown),
        cmocka_unit_test(settings_have_the_units_of_the_table),
        cmocka_unit_test(groups_stand_together),
        cmocka_unit_test(what_is_stored_is_loaded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
