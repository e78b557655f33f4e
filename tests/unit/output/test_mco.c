/* Writing result files: the bytes, what other programs' readers find in them, and files that are not lost.
 * SPDX-License-Identifier: MIT */
#include "lib/mco_case.h"

#include <math.h>

#include <sys/stat.h>

static const char extra[] = "\n# clustermcml 1.0\n# engine cpu, seed 1, run 1\n"
                            "\nse_RAT # Standard errors of Rsp, Rd, A, Tt [-]\n0\n0.25\n1E-05\n0.5\n"
                            "\nse_Rd_r # [1/cm2]\n  1.0000E-03\n  2.0000E-03\n"
                            "\nbooks # weight per packet\n1 # launched\n0.0001 # gained in roulette\n"
                            "\nresidue # in 2^-31 packets\n0\n";

static void fill(double *values, const double *source, size_t count)
{
    memcpy(values, source, count * sizeof *values);
}

#define FILL(array, ...)                                                                                     \
    do {                                                                                                     \
        const double source[] = {__VA_ARGS__};                                                               \
        fill((array), source, sizeof source / sizeof source[0]);                                             \
    } while (0)

static void make_open(struct cml_mco *mco)
{
    struct cml_error err;
    *mco = (struct cml_mco){.user_time = 7204.4, .photons = 1000000, .dz = 0.01, .dr = 0.0025, .nz = 3};
    mco->nr = 2;
    mco->na = 1;
    mco->num_layers = 2;
    mco->n_above = 1;
    mco->n_below = 1.5;
    assert_int_equal(cml_mco_allocate(mco, &err), CML_OK);
    mco->output = strdup("open.mco");
    FILL(mco->layer[0], 1.37, 1, 100, 0.9, 0.1);
    FILL(mco->layer[1], 1.4, 0, 1. / 3, -0.5, 1e8);
    FILL(&mco->Rsp, 0.02437291);
    FILL(&mco->Rd, 0.2375444);
    FILL(&mco->A, 1e-5);
    FILL(mco->A_l, 0.26118, 1e-5);
    FILL(mco->A_z, 2.799, 2.80994e-12, 0);
    FILL(mco->Rd_r, 30.924, 10.071);
    FILL(mco->Rd_a, 0.034038);
    FILL(mco->Tt_r, 0.58942, 0.60085);
    FILL(mco->Tt_a, 0.013826);
    FILL(mco->A_rz, 3294.8, 3038.6, 2503.3, 1851.4, 1275.8, 8.5363e-99);
    FILL(mco->Rd_ra, 552.68, 364.6);
    FILL(mco->Tt_ra, 170.68, -115.74);
}

static void make_full(struct cml_mco *mco)
{
    struct cml_error err;
    *mco = (struct cml_mco){.photons = (uint64_t)1 << 48, .dz = 1e-5, .dr = 100, .nz = 1, .nr = 5, .na = 2};
    mco->num_layers = 1;
    mco->n_above = mco->n_below = 1;
    assert_int_equal(cml_mco_allocate(mco, &err), CML_OK);
    mco->output = strdup("two words.mco");
    FILL(mco->layer[0], 4. / 3, 0.015, 707.7, 1, 100);
    mco->Rsp = 0.0200593;
    mco->Rd = 0.924403;
    mco->A = 0.055538;
    mco->Tt = 1.234567e-7;
    FILL(mco->A_l, 0.055538);
    FILL(mco->A_z, 0.055538);
    FILL(mco->Rd_r, 1, 2, 3, 4, 5);
    FILL(mco->Rd_a, 6, 7);
    FILL(mco->Tt_r, 1.1, 2.1, 3.1, 4.1, 5.1);
    FILL(mco->Tt_a, 6.1, 7.1);
    FILL(mco->A_rz, .1, .2, .3, .4, .5);
    FILL(mco->Rd_ra, .01, .02, .03, .04, .05, .06, .07, .08, .09, .099);
    FILL(mco->Tt_ra, .001, .002, .003, .004, .005, .006, .007, .008, .009, .0099);
}

static void assert_written(void **state, const struct cml_mco *mco, const char *expected)
{
    char path[256];
    struct cml_error err;
    case_path(state, "out.mco", path);
    assert_int_equal(cml_mco_write(path, mco, &err), CML_OK);
    case_assert_holds(state, "out.mco", expected);
    case_remove(state, "out.mco");
}

static void the_bytes_are_those_of_mcml(void **state)
{
    struct cml_mco mco;
    make_open(&mco);
    assert_written(state, &mco, case_open);
    cml_mco_clear(&mco);
    make_full(&mco);
    assert_written(state, &mco, case_full);
    cml_mco_clear(&mco);
}

static char *joined(const char *head, const char *tail)
{
    char *text = malloc(strlen(head) + strlen(tail) + 1);
    assert_non_null(text);
    strcpy(text, head);
    return strcat(text, tail);
}

static void extra_text_stands_behind_the_grids(void **state)
{
    struct cml_mco mco;
    char *expected = joined(case_full, extra);
    make_full(&mco);
    mco.extra = strdup(extra);
    assert_written(state, &mco, expected);
    cml_mco_clear(&mco);
    free(expected);
}

/* 17.6 s is 0.00489 h, which would print as 0.00, but the file's 18 s is 0.005 h. */
static void the_hours_are_those_of_the_printed_seconds(void **state)
{
    struct cml_mco mco;
    char *expected = case_replace(case_open, "    7204 sec =     2.00 hr.", "      18 sec =     0.01 hr.");
    make_open(&mco);
    mco.user_time = 17.6;
    assert_written(state, &mco, expected);
    cml_mco_clear(&mco);
    case_assert_rewritten(state, expected, expected);
    free(expected);
}

static void what_is_read_is_written_again(void **state)
{
    static const char *const texts[] = {case_open, case_full};
    static const char *const tails[] = {"", extra, "\n", "\n\n\n", "# no empty line\n", "tail \t\n\r\n\n"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++)
        for (size_t k = 0; k < sizeof tails / sizeof tails[0]; k++) {
            char *text = joined(texts[i], tails[k]);
            case_assert_rewritten(state, text, text);
            free(text);
        }
}

static void make_all_exponents(struct cml_mco *mco)
{
    static const double mantissas[8] = {1, 1.00005, 1.23455, 2.5, 4.99995, 7.77777, 9.99994, 9.99999};
    struct cml_error err;
    *mco = (struct cml_mco){.photons = 1, .dz = 1. / 3, .dr = 2e-11 / 3, .nz = 1, .nr = 615, .na = 8};
    mco->num_layers = 8;
    mco->n_above = mco->n_below = 4. / 3;
    assert_int_equal(cml_mco_allocate(mco, &err), CML_OK);
    mco->output = strdup("a.mco");
    for (int ir = 0; ir < mco->nr; ir++)
        for (int ia = 0; ia < mco->na; ia++) {
            char value[64];
            snprintf(value, sizeof value, "%.17ge%d", mantissas[ia], ir - 307);
            mco->Rd_ra[ir * mco->na + ia] = strtod(value, NULL);
        }
    for (int l = 0; l < mco->num_layers; l++) {
        const double x = mantissas[l];
        FILL(mco->layer[l], x, x * 1e5, x * 1e6, x / 10, x * 1e-5);
        mco->A_l[l] = x * 1e-4;
    }
}

/* Any number as MCML prints it, over the whole range of exponents. */
static void printed_numbers_survive(void **state)
{
    static char text[1 << 18];
    char path[256];
    struct cml_mco mco;
    struct cml_error err;
    make_all_exponents(&mco);
    case_path(state, "a.mco", path);
    assert_int_equal(cml_mco_write(path, &mco, &err), CML_OK);
    cml_mco_clear(&mco);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    assert_int_equal(fclose(file), 0);
    case_remove(state, "a.mco");
    assert_non_null(strstr(text, "Tt_ra\n"));
    case_assert_rewritten(state, text, text);
}

/* Line `number` of the text, from 1. */
static const char *line_of(const char *text, int number)
{
    for (int line = 1; line < number; line++) text = strchr(text, '\n') + 1;
    return text;
}

/* What getmcml.m has to find on a line that it knows by its number alone: these numbers at its start. */
struct counted {
    int line, count;
    double values[5];
};

static void a_reader_that_counts_lines(void **state)
{
    (void)state;
    static const struct counted table[] = {
        {15, 2, {0.01, 0.0025}}, /* dz dr */
        {16, 3, {3, 2, 1}},      /* nz nr na */
        {18, 1, {2}},            /* layers */
        {20, 1, {1}},            /* n above */
        {21, 5, {1.37, 1, 100, 0.9, 0.1}},
        {22, 5, {1.4, 0, 0.333333, -0.5, 1e8}},
        {23, 1, {1.5}}, /* n below */
        {26, 1, {0.0243729}},
        {29, 1, {0}},
        {32, 1, {0.2612}},       /* A_l */
        {36, 1, {2.799}},        /* A_z */
        {41, 1, {30.924}},       /* Rd_r */
        {45, 1, {0.034038}},     /* Rd_a */
        {48, 1, {0.58942}},      /* Tt_r */
        {52, 1, {0.013826}},     /* Tt_a */
        {61, 1, {8.5363e-99}},   /* A_rz */
        {68, 2, {552.68, 364.6}} /* Rd_ra */
    };
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        const char *line = line_of(case_open, table[i].line);
        for (int k = 0; k < table[i].count; k++) {
            char *end = NULL;
            assert_true(strtod(line, &end) == table[i].values[k]);
            line = end;
        }
        line += strspn(line, " \t");
        assert_true(*line == '\n' || *line == '#');
    }
}

/* As CONV does: the keys one after the other by the start of a line, then so many numbers over any lines. */
static const char *conv_section(const char *text, const char *key, int count, double *values)
{
    while (strncmp(text, key, strlen(key)) != 0) text = strchr(text, '\n') + 1;
    text = strchr(text, '\n') + 1;
    for (int i = 0; i < count; i++) {
        char *end = NULL;
        values[i] = strtod(text, &end);
        assert_true(end > text);
        text = end;
    }
    return text;
}

static void a_reader_that_searches_keys(void **state)
{
    (void)state;
    static const struct {
        const char *key;
        int count;
        double first, last;
    } table[] = {
        {"InParm", 0, 0, 0},           {"RAT", 4, 0.0243729, 0},        {"A_l", 2, 0.2612, 1e-5},
        {"A_z", 3, 2.799, 0},          {"Rd_r", 2, 30.924, 10.071},     {"Rd_a", 1, 0.034038, 0.034038},
        {"Tt_r", 2, 0.58942, 0.60085}, {"Tt_a", 1, 0.013826, 0.013826}, {"A_rz", 6, 3294.8, 8.5363e-99},
        {"Rd_ra", 2, 552.68, 364.6},   {"Tt_ra", 2, 170.68, -115.74}};
    char *text = joined(case_open, extra);
    const char *at = text;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        double values[6] = {0};
        const int rat = strcmp(table[i].key, "RAT") == 0; /* one number per line, the rest is a comment */
        at = conv_section(at, table[i].key, rat ? 1 : table[i].count, values);
        assert_true(values[0] == table[i].first);
        if (table[i].count > 0 && !rat) assert_true(values[table[i].count - 1] == table[i].last);
    }
    free(text);
}

static void extra_sections_are_found_by_their_whole_key(void **state)
{
    (void)state;
    struct cml_mco mco = {.extra = strdup(extra)};
    double values[4] = {9, 9, 9, 9};
    assert_int_equal(cml_mco_extra(&mco, "se_RAT", values, 4), 4);
    assert_true(values[0] == 0 && values[1] == 0.25 && values[2] == 1e-5 && values[3] == 0.5);
    assert_int_equal(cml_mco_extra(&mco, "se_Rd_r", values, 4), 2);
    assert_true(values[0] == 1e-3 && values[1] == 2e-3 && values[2] == 1e-5);
    assert_int_equal(cml_mco_extra(&mco, "books", values, 4), 2);
    assert_true(values[1] == 0.0001);
    assert_int_equal(cml_mco_extra(&mco, "residue", values, 4), 1);
    assert_int_equal(cml_mco_extra(&mco, "se_RAT", values, 3), 3);
    assert_int_equal(cml_mco_extra(&mco, "se_RAT", values, 0), 0);
    static const char *const absent[] = {"se_Rd", "Rd_r", "e_RAT", "se_RAT ", "0.25", "launched", "se_Tt_r"};
    for (size_t i = 0; i < sizeof absent / sizeof absent[0]; i++)
        assert_int_equal(cml_mco_extra(&mco, absent[i], values, 4), 0);
    cml_mco_clear(&mco);
}

static void extra_sections_that_hold_nothing(void **state)
{
    (void)state;
    static const char *const texts[] = {"key ",           "key # nothing\n", "key #\n\n1\n",   "key #\ninf\n",
                                        "key #\nnan 1\n", "key #\n0x10\n",   "key #\nkey 1\n", " key #\n1\n",
                                        "key\n1\n",       "#key #\n1\n",     "key #\n# 1\n",   ""};
    double value = 0;
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        struct cml_mco mco = {.extra = strdup(texts[i])};
        assert_int_equal(cml_mco_extra(&mco, "key", &value, 1), 0);
        cml_mco_clear(&mco);
    }
    struct cml_mco none = {0};
    assert_int_equal(cml_mco_extra(&none, "key", &value, 1), 0);
}

/* Of one packet there is none. */
static void an_error_may_be_no_number(void **state)
{
    (void)state;
    struct cml_mco mco = {.extra = "\nse_RAT #\nNAN\nnan\n1\n\nbooks #\nnan\n"};
    double values[3] = {0};
    assert_int_equal(cml_mco_extra(&mco, "se_RAT", values, 3), 3);
    assert_true(isnan(values[0]) && isnan(values[1]) && values[2] == 1);
    assert_int_equal(cml_mco_extra(&mco, "books", values, 3), 0);
}

static void a_word_of_any_length_ends_an_extra_section(void **state)
{
    (void)state;
    double values[2] = {0};
    struct cml_mco mco = {.extra = calloc(1, 300)};
    assert_non_null(mco.extra);
    strcpy(mco.extra, "key #\n7\n");
    memset(mco.extra + strlen(mco.extra), '1', 200);
    assert_int_equal(cml_mco_extra(&mco, "key", values, 2), 1);
    assert_true(values[0] == 7);
    cml_mco_clear(&mco);
}

static void assert_unwritable(void **state, const char *name, const char *message)
{
    char path[256];
    struct cml_mco mco;
    struct cml_error err = {0};
    make_open(&mco);
    case_path(state, name, path);
    assert_int_equal(cml_mco_write(path, &mco, &err), CML_E_IO);
    cml_mco_clear(&mco);
    case_normalise(state, err.text);
    assert_string_equal(err.text, message);
}

static void what_cannot_be_written_is_named(void **state)
{
    char taken[256];
    case_path(state, "taken.mco", taken);
    assert_int_equal(mkdir(taken, 0700), 0);
    assert_unwritable(state, "taken.mco", "taken.mco: cannot be written (a directory)");
    case_remove(state, "taken.mco");
    assert_unwritable(state, "none/x.mco", "none/x.mco: cannot be written (No such file or directory)");
}

static void a_read_only_directory_is_reported(void **state)
{
    if (geteuid() == 0) skip(); /* nothing is read-only for root */
    case_write_bytes(state, "old.mco", "old", 3);
    assert_int_equal(chmod(*state, 0500), 0);
    assert_unwritable(state, "old.mco", "old.mco: cannot be written (Permission denied)");
    assert_int_equal(chmod(*state, 0700), 0);
    case_assert_holds(state, "old.mco", "old");
    case_remove(state, "old.mco");
}

static void arrays_are_zero_or_refused(void **state)
{
    (void)state;
    struct cml_error err = {0};
    struct cml_mco mco = {.nz = 2, .nr = 3, .na = 4, .num_layers = 5, .extra = NULL};
    assert_int_equal(cml_mco_allocate(&mco, &err), CML_OK);
    for (int i = 0; i < 5; i++) assert_true(mco.layer[i][4] == 0 && mco.A_l[i] == 0);
    for (int i = 0; i < 12; i++) assert_true(mco.Rd_ra[i] == 0 && mco.Tt_ra[i] == 0);
    for (int i = 0; i < 6; i++) assert_true(mco.A_rz[i] == 0);
    cml_mco_clear(&mco);
    assert_true(!mco.layer && !mco.A_rz && mco.nr == 0);
    mco = (struct cml_mco){.nz = INT32_MAX, .nr = INT32_MAX, .na = 1, .num_layers = 1};
    assert_int_equal(cml_mco_allocate(&mco, &err), CML_E_INPUT);
    assert_true(!mco.layer && !mco.A_l && !mco.A_rz);
    assert_memory_equal(err.text, "out of memory: ", 15);
    cml_mco_clear(&mco);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_bytes_are_those_of_mcml),
        cmocka_unit_test(extra_text_stands_behind_the_grids),
        cmocka_unit_test(the_hours_are_those_of_the_printed_seconds),
        cmocka_unit_test(what_is_read_is_written_again),
        cmocka_unit_test(printed_numbers_survive),
        cmocka_unit_test(a_reader_that_counts_lines),
        cmocka_unit_test(a_reader_that_searches_keys),
        cmocka_unit_test(extra_sections_are_found_by_their_whole_key),
        cmocka_unit_test(extra_sections_that_hold_nothing),
        cmocka_unit_test(an_error_may_be_no_number),
        cmocka_unit_test(a_word_of_any_length_ends_an_extra_section),
        cmocka_unit_test(what_cannot_be_written_is_named),
        cmocka_unit_test(a_read_only_directory_is_reported),
        cmocka_unit_test(arrays_are_zero_or_refused),
    };
    return cmocka_run_group_tests_name("mco", tests, case_setup, case_teardown);
}
