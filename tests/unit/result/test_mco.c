/* Tests of writing .mco files: their bytes, the numbers that other programs' readers find in them, and
 * that no file is lost. SPDX-License-Identifier: MIT */
#include "lib/mco_case.h"
#include "result/mco.h"

#include <math.h>

#include <sys/stat.h>

/* The sections that this program adds behind those of MCML, for the grid of case_open. */
static const char ours[] =
    "\n# clustermcml 1.0\n# engine cpu, seed 7, run 2, packets are scored at their first exit\n"
    "# sampling lattice, roulette below 0.001 to 0.1\n# set layer1.mua = 2\n"
    "# beam disk of radius 0.1 cm at (0 0) cm, angle 0, azimuth 0 degrees\n"
    "# boundary 0: plane at z = 0 cm (flat)\n"
    "# boundary 1: cone at z = 0.1 cm, 1 rings (exact), crc32 0badcafe (z = 0.09 to 0.12 cm)\n"
    "# boundary 2: plane at z = 1 cm (flat)\n"
    "# body 1: sphere at (0 0 0.02) cm, r = 0.01 cm, in layer 1; n 1.4, mua 1, mus 2 1/cm, g 0.5 (z = 0.01 "
    "to 0.03 "
    "cm, r = 0 to 0.01 cm)\n"
    "\nlattice # 1: the packets of a batch depend on each other, 0: all are independent\n1\n"
    "\nse_RAT # Standard errors of Rsp, Rd, A, Tt [-]\n0\n0.25\n1E-05\n0.5\n"
    "\nse_A_z # [1/cm]\n  1.0000E-01\n  2.0000E-01\n  3.0000E-01\n"
    "\nse_Rd_r # [1/cm2]\n  1.0000E-03\n  2.0000E-03\n"
    "\nse_Rd_a # [sr-1]\n  4.0000E-03\n"
    "\nse_Tt_r # [1/cm2]\n  5.0000E-03\n  6.0000E-03\n"
    "\nse_Tt_a # [sr-1]\n  7.0000E-03\n"
    "\nbooks # weight per launched packet; launched + gained = all others up to lost, exactly\n1 # launched\n"
    "0.0001 # gained in roulette\n0.02 # specular (Rsp)\n0.25 # reflected (Rd)\n0.125 # transmitted (Tt)\n"
    "0.5 # absorbed (A)\n0.25 # lost in roulette\n0 # trapped\n0 # lost\n0.03125 # scored in the last r bin "
    "from "
    "beyond it\n0 # absorbed below the last z bin\n0 # absorbed above z = 0\n"
    "\nresidue # of the books, in 2^-31 packets; 0 unless the program is wrong\n-3\n"
    "\nlost # packets; behind it the smallest of their indices, for `clustermcml trace`\n2\n17\n99\n";

static void fill(double *values, const double *source, size_t count)
{
    memcpy(values, source, count * sizeof *values);
}

#define FILL(array, ...)                                                                                     \
    do {                                                                                                     \
        const double source[] = {__VA_ARGS__};                                                               \
        fill((array), source, sizeof source / sizeof source[0]);                                             \
    } while (0)

static void fill_layer(struct cml_outcome *mco, int layer, double n, double mua, double mus, double g,
                       double d)
{
    const double numbers[CML_LAYER_NUMBERS] = {n, mua, mus, g, d};
    for (int i = 0; i < CML_LAYER_NUMBERS; i++) *cml_outcome_layer(mco, layer, i) = numbers[i];
}

static void make_open(struct cml_outcome *mco)
{
    struct cml_error err;
    *mco = (struct cml_outcome){.user_time = 7204.4, .photons = 1000000, .dz = 0.01, .dr = 0.0025, .nz = 3};
    mco->nr = 2;
    mco->na = 1;
    mco->num_layers = 2;
    mco->n_above = 1;
    mco->n_below = 1.5;
    assert_int_equal(cml_outcome_allocate(mco, &err), CML_OK);
    mco->output = strdup("open.mco");
    fill_layer(mco, 0, 1.37, 1, 100, 0.9, 0.1);
    fill_layer(mco, 1, 1.4, 0, 1. / 3, -0.5, 1e8);
    FILL(&mco->value[CML_QUANTITY_Rsp][0], 0.02437291);
    FILL(&mco->value[CML_QUANTITY_Rd][0], 0.2375444);
    FILL(&mco->value[CML_QUANTITY_A][0], 1e-5);
    FILL(mco->value[CML_QUANTITY_A_l], 0.26118, 1e-5);
    FILL(mco->value[CML_QUANTITY_A_z], 2.799, 2.80994e-12, 0);
    FILL(mco->value[CML_QUANTITY_Rd_r], 30.924, 10.071);
    FILL(mco->value[CML_QUANTITY_Rd_a], 0.034038);
    FILL(mco->value[CML_QUANTITY_Tt_r], 0.58942, 0.60085);
    FILL(mco->value[CML_QUANTITY_Tt_a], 0.013826);
    FILL(mco->value[CML_QUANTITY_A_rz], 3294.8, 3038.6, 2503.3, 1851.4, 1275.8, 8.5363e-99);
    FILL(mco->value[CML_QUANTITY_Rd_ra], 552.68, 364.6);
    FILL(mco->value[CML_QUANTITY_Tt_ra], 170.68, -115.74);
}

static void make_full(struct cml_outcome *mco)
{
    struct cml_error err;
    *mco =
        (struct cml_outcome){.photons = (uint64_t)1 << 48, .dz = 1e-5, .dr = 100, .nz = 1, .nr = 5, .na = 2};
    mco->num_layers = 1;
    mco->n_above = mco->n_below = 1;
    assert_int_equal(cml_outcome_allocate(mco, &err), CML_OK);
    mco->output = strdup("two words.mco");
    fill_layer(mco, 0, 4. / 3, 0.015, 707.7, 1, 100);
    mco->value[CML_QUANTITY_Rsp][0] = 0.0200593;
    mco->value[CML_QUANTITY_Rd][0] = 0.924403;
    mco->value[CML_QUANTITY_A][0] = 0.055538;
    mco->value[CML_QUANTITY_Tt][0] = 1.234567e-7;
    FILL(mco->value[CML_QUANTITY_A_l], 0.055538);
    FILL(mco->value[CML_QUANTITY_A_z], 0.055538);
    FILL(mco->value[CML_QUANTITY_Rd_r], 1, 2, 3, 4, 5);
    FILL(mco->value[CML_QUANTITY_Rd_a], 6, 7);
    FILL(mco->value[CML_QUANTITY_Tt_r], 1.1, 2.1, 3.1, 4.1, 5.1);
    FILL(mco->value[CML_QUANTITY_Tt_a], 6.1, 7.1);
    FILL(mco->value[CML_QUANTITY_A_rz], .1, .2, .3, .4, .5);
    FILL(mco->value[CML_QUANTITY_Rd_ra], .01, .02, .03, .04, .05, .06, .07, .08, .09, .099);
    FILL(mco->value[CML_QUANTITY_Tt_ra], .001, .002, .003, .004, .005, .006, .007, .008, .009, .0099);
}

static void assert_written(void **state, const struct cml_outcome *mco, const char *expected)
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
    struct cml_outcome mco;
    make_open(&mco);
    assert_written(state, &mco, case_open);
    cml_outcome_clear(&mco);
    make_full(&mco);
    assert_written(state, &mco, case_full);
    cml_outcome_clear(&mco);
}

static char *joined(const char *head, const char *tail)
{
    char *text = malloc(strlen(head) + strlen(tail) + 1);
    assert_non_null(text);
    strcpy(text, head);
    return strcat(text, tail);
}

/* Hours are computed from the printed seconds: 17.6 s are 0.00489 h, which would print as 0.00, but the
 * file says 18 s, which are 0.005 h. */
static void the_hours_are_those_of_the_printed_seconds(void **state)
{
    struct cml_outcome mco;
    char *expected = case_replace(case_open, "    7204 sec =     2.00 hr.", "      18 sec =     0.01 hr.");
    make_open(&mco);
    mco.user_time = 17.6;
    assert_written(state, &mco, expected);
    cml_outcome_clear(&mco);
    free(expected);
}

/* Returns line `number` of the text, from 1. */
static const char *line_of(const char *text, int number)
{
    for (int line = 1; line < number; line++) text = strchr(text, '\n') + 1;
    return text;
}

/* Lines that getmcml.m knows by their number alone, and the numbers that must begin them. */
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

/* Reads a section as CONV does: it finds the key at the start of a line, after the previous key, then
 * `count` numbers over any lines. Returns the text behind them. */
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
    char *text = joined(case_open, ours);
    const char *at = text;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        double values[6] = {0};
        const int rat = strcmp(table[i].key, "RAT") == 0; /* RAT has one number per line, then a comment */
        at = conv_section(at, table[i].key, rat ? 1 : table[i].count, values);
        assert_true(values[0] == table[i].first);
        if (table[i].count > 0 && !rat) assert_true(values[table[i].count - 1] == table[i].last);
    }
    free(text);
}

static void assert_unwritable(void **state, const char *name, const char *message)
{
    char path[256];
    struct cml_outcome mco;
    struct cml_error err = {0};
    make_open(&mco);
    case_path(state, name, path);
    assert_int_equal(cml_mco_write(path, &mco, &err), CML_E_IO);
    cml_outcome_clear(&mco);
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
    if (geteuid() == 0) skip(); /* root may write read-only files */
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
    struct cml_outcome mco = {.nz = 2, .nr = 3, .na = 4, .num_layers = 5};
    assert_int_equal(cml_outcome_allocate(&mco, &err), CML_OK);
    for (int i = 0; i < 5; i++)
        assert_true(*cml_outcome_layer(&mco, i, 4) == 0 && mco.value[CML_QUANTITY_A_l][i] == 0);
    for (int i = 0; i < 12; i++)
        assert_true(mco.value[CML_QUANTITY_Rd_ra][i] == 0 && mco.value[CML_QUANTITY_Tt_ra][i] == 0);
    for (int i = 0; i < 6; i++) assert_true(mco.value[CML_QUANTITY_A_rz][i] == 0);
    cml_outcome_clear(&mco);
    assert_true(!mco.value[CML_QUANTITY_layer_n] && !mco.value[CML_QUANTITY_A_rz] && mco.nr == 0);
    mco = (struct cml_outcome){.nz = INT32_MAX, .nr = INT32_MAX, .na = 1, .num_layers = 1};
    assert_int_equal(cml_outcome_allocate(&mco, &err), CML_E_INPUT);
    assert_true(!mco.value[CML_QUANTITY_layer_n] && !mco.value[CML_QUANTITY_A_rz]);
    assert_memory_equal(err.text, "out of memory: ", 15);
    cml_outcome_clear(&mco);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_bytes_are_those_of_mcml),
        cmocka_unit_test(the_hours_are_those_of_the_printed_seconds),
        cmocka_unit_test(a_reader_that_counts_lines),
        cmocka_unit_test(a_reader_that_searches_keys),
        cmocka_unit_test(what_cannot_be_written_is_named),
        cmocka_unit_test(a_read_only_directory_is_reported),
        cmocka_unit_test(arrays_are_zero_or_refused),
    };
    return cmocka_run_group_tests_name("mco", tests, case_setup, case_teardown);
}
