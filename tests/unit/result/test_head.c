/* Tests of reading the heads of result files: whole files, cut files, changed files, and files of other
 * programs. SPDX-License-Identifier: MIT */
#include "lib/mco_case.h"

#include "output/files/hdf5_file.h"
#include "result/head.h"

#include <sys/stat.h>

#define SUM "0123456789abcdef"

/* Returns the text of a whole .mco of this program; the caller frees it. */
static char *whole_mco(void)
{
    static const char ours[] =
        "\n# clustermcml 1.0\n# scene a\n\nse_RAT # Standard errors\n0\nnan\n1E-05\n0.5\n"
        "\nbooks # weight\n1 # launched\n0 # gained\n\nA_body # in each body\n0.3\n\n# end\n";
    char *head = case_replace(case_open, "this run.", "this run.   Last line: # end   Identity: " SUM);
    strcat(head, ours); /* case_replace leaves room behind the text */
    return head;
}

static bool reads(void **state, const char *name, const char *bytes, size_t size, struct cml_head *head)
{
    char path[256];
    case_path(state, name, path);
    case_write_bytes(state, name, bytes, size);
    const bool good = cml_head_read(path, head);
    case_remove(state, name);
    return good;
}

static void a_whole_mco(void **state)
{
    struct cml_head head;
    char *text = whole_mco();
    assert_true(reads(state, "x.mco", text, strlen(text), &head));
    assert_true(head.photons == 1000000);
    assert_string_equal(head.identity, SUM);
    strcat(text, " \t\r\n\n");
    assert_true(reads(state, "x.mco", text, strlen(text), &head));
    free(text);
}

static void a_cut_mco_is_refused(void **state)
{
    struct cml_head head;
    char *text = whole_mco();
    const size_t size = strlen(text);
    for (size_t length = 0; length < size; length++) assert_false(reads(state, "x.mco", text, length, &head));
    free(text);
}

/* A damaged .mco is refused. A changed digit is not noticed, as the comment of head.h says. */
static void a_changed_mco_is_refused(void **state)
{
    static const struct {
        const char *from, *to;
        bool noticed;
    } table[] = {
        {"A1 \t", "A2 \t", true},           {"InParm \t", "InParn \t", true},
        {"1000000 \t", "many \t", true},    {"3\t2\t1\t", "3\t2\t3\t", true},
        {"0.0025\t", "0.00q5\t", true},     {"2\t\t\t\t\t# Number", "0\t# Number", true},
        {"RAT #", "RBT #", true},           {"Rd_r #", "Sd_r #", true},
        {"  2.8099E-12\n", "", true},       {"2.8099E-12", "2. 99E-12", true},
        {"3.0924E+01", "#.0924E+01", true}, {"2.8099E-12\n", "2.8099E-12\v", true},
        {"2.5033E+03", "2.50s3E+03", true}, {"1E-05\n0.5\n", "1E-05\n0/5\n", true},
        {"\nA_body #", "A_body #", true},   {"A_body #", "A_body 1 #", true},
        {"\n0.3\n", "\n#.3\n", true},       {"\n# end\n", "\n# End\n", true},
        {"# end\n", "# end\nA1 \n", true},  {"2.5033E+03", "2.5133E+03", false},
    };
    struct cml_head head;
    char *text = whole_mco();
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char *changed = case_replace(text, table[i].from, table[i].to);
        if (reads(state, "x.mco", changed, strlen(changed), &head) == table[i].noticed)
            fail_msg("'%s' in place of '%s'", table[i].to, table[i].from);
        free(changed);
    }
    text[strlen(text) / 2] = '\0';
    assert_false(reads(state, "x.mco", text, strlen(text) + 100, &head));
    free(text);
}

/* Files of original MCML, and of programs that repeat the .mci with its comments. */
static void files_of_other_programs(void **state)
{
    static const char copied[] =
        "A1 \t# Version\n\n# User time: 85.98 sec\n\nInParam\t\t# Input parameters:\n  # my run\n\n"
        "skin.mco A\n1e5 photons\n# grid\n0.002 0.01\n2 1 2\n2 layers\n\n1.0 # above\n";
    struct cml_head head;
    assert_true(reads(state, "x.mco", case_full, strlen(case_full), &head));
    assert_true(head.photons == (uint64_t)1 << 48 && head.identity[0] == '\0');
    assert_true(reads(state, "x.mco", copied, strlen(copied), &head));
    assert_true(head.photons == 100000 && head.identity[0] == '\0');
}

static void what_is_no_file(void **state)
{
    struct cml_head head;
    char path[256];
    case_path(state, "none.mco", path);
    assert_false(cml_head_read(path, &head));
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_false(cml_head_read(path, &head));
    case_remove(state, "none.mco");
    assert_false(cml_head_read(*state, &head));
    assert_false(reads(state, "x.mco", "", 0, &head));
    assert_false(reads(state, "x.h5", "", 0, &head));
    assert_false(reads(state, "x.h5", case_full, strlen(case_full), &head));
}

static void steps(const void *context, size_t begin, size_t count, double *out)
{
    (void)context;
    for (size_t i = 0; i < count; i++) out[i] = (double)(begin + i) * 0.37;
}

/* Returns the bytes of an .h5 file with one array. A file of a run has an array Rd; another name makes it
 * a file of another kind. */
static char *h5_bytes(void **state, const char *array, double photons, size_t *size)
{
    static const struct cml_axis axis = {"r", "radius", "cm", 300, 0.05, 0.1, NULL};
    const struct cml_attribute attributes[] = {{"photons", NULL, photons}, {"identity", SUM, 0}};
    const struct cml_hdf5_call call = {"run", "s.mci"};
    struct cml_field field = {
        .long_name = "l", .units = "u", .num_axes = 1, .axis = {&axis}, .values = steps};
    struct cml_error err = {0};
    char path[256], *bytes = malloc(1 << 20);
    strcpy(field.name, array);
    case_path(state, "made.h5", path);
    assert_int_equal(cml_hdf5_write(path, attributes, 2, &call, &field, 1, &err), CML_OK);
    FILE *file = fopen(path, "rb");
    assert_true(bytes && file);
    *size = fread(bytes, 1, 1 << 20, file);
    fclose(file);
    case_remove(state, "made.h5");
    return bytes;
}

static void h5_files(void **state)
{
    struct cml_head head;
    size_t size, refused = 0;
    if (!cml_hdf5_available()) skip();
    char *bytes = h5_bytes(state, "path", 1e6, &size);
    assert_true(reads(state, "x.h5", bytes, size, &head)); /* a file of saved packets */
    assert_true(head.photons == 0);
    free(bytes);
    bytes = h5_bytes(state, "Rd", 0.5, &size);
    assert_false(reads(state, "x.h5", bytes, size, &head));
    free(bytes);
    bytes = h5_bytes(state, "Rd", 1e6, &size);
    assert_true(reads(state, "x.h5", bytes, size, &head));
    assert_true(head.photons == 1000000);
    assert_string_equal(head.identity, SUM);
    for (size_t length = 0; length < size; length += 1 + size / 500)
        assert_false(reads(state, "x.h5", bytes, length, &head));
    for (size_t at = 0; at + 16 < size; at += 16) { /* blanks out 16 bytes wherever some are not 0 */
        char kept[16];
        memcpy(kept, bytes + at, 16);
        memset(bytes + at, 0, 16);
        refused += !reads(state, "x.h5", bytes, size, &head);
        memcpy(bytes + at, kept, 16);
    }
    assert_true(refused > 1300 / 16); /* least size of 300 numbers, deflated */
    free(bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_whole_mco),
        cmocka_unit_test(a_cut_mco_is_refused),
        cmocka_unit_test(a_changed_mco_is_refused),
        cmocka_unit_test(files_of_other_programs),
        cmocka_unit_test(what_is_no_file),
        cmocka_unit_test(h5_files),
    };
    return cmocka_run_group_tests_name("head", tests, case_setup, case_teardown);
}
