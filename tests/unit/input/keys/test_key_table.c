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
    [CML_KEYS_LAYER] = {RUN "1\n1\n1.4 1 2 0.9 ", "1", "\n1\n"},
    [CML_KEYS_HG2] = {LAST "phase hg2 ", "0.9 0.5 1", "\n1\n"},
    [CML_KEYS_MHG] = {LAST "phase mhg ", "0.9 1", "\n1\n"},
    [CML_KEYS_GK] = {LAST "phase gk ", "0.9 0.5", "\n1\n"},
    [CML_KEYS_BACKING] = {LAST "backing ", "0.5", "\n1\n"},
    [CML_KEYS_METAL] = {LAST "backing metal ", "0.2 3", "\n1\n"},
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
        cmocka_unit_test(settings_have_the_units_of_the_table),
        cmocka_unit_test(groups_stand_together),
        cmocka_unit_test(what_is_stored_is_loaded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
