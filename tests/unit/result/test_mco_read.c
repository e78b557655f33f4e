/* Reading result files: the dialects of other programs, cut and mangled files, and messages word by word.
 * SPDX-License-Identifier: MIT */
#include "lib/mco_case.h"

/* The results of gpumcml, CUDAMCML and the 2019 clustermcml: other widths, and a last line that need not end.
 */
#define GPU_RESULTS                                                                                          \
    "\nRAT #Reflectance, absorption transmission\n0.0438845 \t\t #Specular reflectance [-]\n"                \
    "0.563252 \t\t #Diffuse reflectance [-]\n0.389672 \t\t #Absorbed fraction [-]\n"                         \
    "0 \t\t #Transmittance [-]\n"                                                                            \
    "\nA_l #Absorption as a function of layer. [-]\n0.00252556\n5.8704E-05\n"                                \
    "\nA_z #A[0], [1],..A[nz-1]. [1/cm]\n1.262778E+00\n7.352041E-01\n"                                       \
    "\nRd_r #Rd[0], [1],..Rd[nr-1]. [1/cm2]\n2.433934E+02\n"                                                 \
    "\nRd_a #Rd[0], [1],..Rd[na-1]. [sr-1]\n2.156913E-01\n1.935162E-01\n"                                    \
    "\nTt_r #Tt[0], [1],..Tt[nr-1]. [1/cm2]\n2.120768E-03\n"                                                 \
    "\nTt_a #Tt[0], [1],..Tt[na-1]. [sr-1]\n4.135529E-04\n1.009415E-03\n"                                    \
    "\n" CASE_A_RZ " 1.180773E+03  7.081055E+02 \n\n" CASE_RD_RA                                             \
    " 1.000000E+00  2.500000E+00 \n\n" CASE_TT_RA " 0.000000E+00  1.240000E-03 "

#define GPU_HEAD CASE_HEAD "# User time: 85.98 sec\n\n"

/* What all samples of this file mean, written as we write it. */
static const char meaning[] =
    CASE_HEAD "# User time:       86 sec =     0.02 hr.   Simulation time of this run.\n\n"
              "InParm \t\t\t# Input parameters. cm is used.\n"
              "skin.mco \tA\t\t# output file name, ASCII.\n"
              "100000 \t\t\t# No. of photons\n"
              "0.002\t0.01\t\t# dz, dr [cm]\n"
              "2\t1\t2\t# No. of dz, dr, da.\n\n"
              "2\t\t\t\t\t# Number of layers\n"
              "#n\tmua\tmus\tg\td\t# One line for each layer\n"
              "1\t\t\t\t\t# n for medium above\n"
              "1.53\t0.2\t1000\t0.9\t0.002\t# layer 1\n"
              "1.34\t0.15\t400\t0.85\t0.008\t# layer 2\n"
              "1\t\t\t\t\t# n for medium below\n\n"
              "RAT #Reflectance, absorption, transmission. \n"
              "0.0438845      \t#Specular reflectance [-]\n"
              "0.563252       \t#Diffuse reflectance [-]\n"
              "0.389672       \t#Absorbed fraction [-]\n"
              "0              \t#Transmittance [-]\n\n"
              "A_l #Absorption as a function of layer. [-]\n"
              "    0.002526\n    5.87E-05\n\n"
              "A_z #A[0], [1],..A[nz-1]. [1/cm]\n  1.2628E+00\n  7.3520E-01\n\n"
              "Rd_r #Rd[0], [1],..Rd[nr-1]. [1/cm2]\n  2.4339E+02\n\n"
              "Rd_a #Rd[0], [1],..Rd[na-1]. [sr-1]\n  2.1569E-01\n  1.9352E-01\n\n"
              "Tt_r #Tt[0], [1],..Tt[nr-1]. [1/cm2]\n  2.1208E-03\n\n"
              "Tt_a #Tt[0], [1],..Tt[na-1]. [sr-1]\n  4.1355E-04\n  1.0094E-03\n\n" CASE_A_RZ
              "  1.1808E+03   7.0811E+02 \n" CASE_RD_RA "  1.0000E+00   2.5000E+00 \n" CASE_TT_RA
              "  0.0000E+00   1.2400E-03 \n";

static const char gpumcml[] =
    GPU_HEAD "InParm \t\t\t# Input parameters. cm is used.\nskin.mco \tA\t\t# output file name, ASCII.\n"
             "100000 \t\t\t# No. of photons\n0.002\t0.01\t\t# dz, dr [cm]\n2\t1\t2\t# No. of dz, dr, da.\n\n"
             "2\t\t\t\t\t# Number of layers\n#n\tmua\tmus\tg\td\t# One line for each layer\n"
             "1\t\t\t\t\t# n for medium above\n1.53\t0.2\t1000\t0.9\t0.002\t# layer 1\n"
             "1.34\t0.15\t400\t0.85\t0.008\t# layer 2\n1\t\t\t\t\t# n for medium below\n" GPU_RESULTS;

/* A verbatim copy of the .mci file. */
#define COPIED_INPUT                                                                                         \
    "skin.mco\tA\t\t\t# output filename, ASCII/Binary\n100000\t\t\t\t\t\t# No. of photons\n"                 \
    "0.002\t0.01\t\t\t\t\t# dz, dr\n2\t1\t2\t\t\t\t# No. of dz, dr & da.\n\n"                                \
    "2\t\t\t\t\t\t# No. of layers\n# n\tmua\tmus\tg\td\t\t# One line for each layer\n"                       \
    "1.0\t\t\t\t\t\t# n for medium above.\n1.53\t0.2\t1000\t0.9\t0.002\t\t# layer 1: stratum corneum\n"      \
    "1.34\t0.15\t400\t0.85\t0.008\t\t# layer 2\n1.0\t\t\t\t\t\t# n for medium below.\n"

static const char cudamcml[] = GPU_HEAD "InParam\t\t# Input parameters:\n" COPIED_INPUT GPU_RESULTS;

/* The lines of boundaries and their comments, before a layer and before n below. */
static const char clustermcml[] = GPU_HEAD
    "InParam\t\t# Input parameters:\n"
    "  # my \xc2\xb5m run\n\nskin.mco A\n1e5 photons\n# grid\n0.002 0.01\n2 1 2\n2#layers\n\n1.0 # above\n"
    "b 3 0.01 0.02 0.005 0.02 0 0 # crater\n# 9 9 9 9 9\n"
    "1.53 0.2 1000 0.9 0.002\n#@ b 1 0 1\n\n  b 2 0.1 0.2 0 0\n1.34 .15 4e2 +0.85 0.008 dermis\n"
    "m \"skin.obj\" units=mm\nbeam disk 0.1\n1.0\n" GPU_RESULTS;

/* Programs on Windows begin their copy somewhere in the comments before the run. */
static const char misplaced_copy[] =
    GPU_HEAD "InParam\t\t# Input parameters:\n\t\t\t\t# number of runs\n\nlow.\ndata for run 1\n" COPIED_INPUT
        GPU_RESULTS;

static void dialects_mean_the_same(void **state)
{
    case_assert_rewritten(state, meaning, meaning);
    case_assert_rewritten(state, gpumcml, meaning);
    case_assert_rewritten(state, cudamcml, meaning);
    case_assert_rewritten(state, clustermcml, meaning);
    case_assert_rewritten(state, misplaced_copy, meaning);
}

/* Edits that leave a file's meaning as it is. */
static void harmless_differences(void **state)
{
    static const struct {
        const char *from, *to;
    } table[] = {
        {"E+0", "E+00"},                      /* MSVC's exponents */
        {"E-0", "E-00"},                      /**/
        {"\n", "\r\n"},                       /* its line ends */
        {"    7204 sec", " 7203.96 sec"},     /* MCML before 1.2.2 */
        {"A1 \t#", "B1 \t#"},                 /* format B, which is ASCII too */
        {"InParm \t\t\t#", "InParam # copy"}, /* both keys */
        {"\n\n", "\n"},                       /* no empty lines */
        {"\n\n", "\n \t\n# more\n\n"},        /* other ones */
        {"1000000 \t", "1e6 \t"},             /* a count as in our .mci files */
        {"2\t\t\t\t\t# Number", "2 #"},       /* other comments */
        {"\t# layer 1", " tissue"},           /* comments without # */
        {" \tA\t\t# output file name, ASCII.", " A"},
        {"open.mco \tA\t\t# output", "\"open.mco\" A"},
        {"   2.5033E+03", "\n2.5033E+03"}, /* other line ends in a grid */
    };
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char *text = case_replace(case_open, table[i].from, table[i].to);
        case_assert_rewritten(state, text, case_open);
        free(text);
    }
}

static void the_fields_are_where_they_belong(void **state)
{
    struct cml_outcome mco;
    struct cml_error err;
    assert_int_equal(case_read(state, case_full, strlen(case_full), &mco, &err), CML_OK);
    assert_string_equal(mco.output, "two words.mco");
    assert_true(mco.photons == (uint64_t)1 << 48);
    assert_true(mco.dz == 1e-5 && mco.dr == 100);
    assert_true(mco.nz == 1 && mco.nr == 5 && mco.na == 2 && mco.num_layers == 1);
    assert_true(*cml_outcome_layer(&mco, 0, 2) == 707.7 && *cml_outcome_layer(&mco, 0, 4) == 100);
    assert_true(mco.value[CML_QUANTITY_Rsp][0] == 0.0200593 && mco.value[CML_QUANTITY_Rd][0] == 0.924403 &&
                mco.value[CML_QUANTITY_A][0] == 0.055538 && mco.value[CML_QUANTITY_Tt][0] == 1.23457e-7);
    assert_true(mco.value[CML_QUANTITY_Rd_r][4] == 5 && mco.value[CML_QUANTITY_Rd_a][1] == 7 &&
                mco.value[CML_QUANTITY_Tt_r][0] == 1.1 && mco.value[CML_QUANTITY_Tt_a][1] == 7.1);
    assert_true(mco.value[CML_QUANTITY_A_rz][3] == 0.4 && mco.value[CML_QUANTITY_Rd_ra][2 * 2 + 1] == 0.06 &&
                mco.value[CML_QUANTITY_Tt_ra][4 * 2] == 0.009);
    cml_outcome_clear(&mco);
}

/* A cut file is either refused or gives the numbers of the whole one. */
static void assert_cuts_are_safe(void **state, const char *text, const char *whole)
{
    const size_t size = strlen(text);
    size_t read = 0;
    for (size_t length = 0; length < size; length++) {
        struct cml_outcome mco;
        struct cml_error err;
        const cml_status status = case_read(state, text, length, &mco, &err);
        if (status == CML_OK) {
            char *cut = strndup(text, length);
            case_assert_rewritten(state, cut, whole);
            free(cut);
            cml_outcome_clear(&mco);
            read++;
        } else {
            assert_int_equal(status, CML_E_INPUT);
            assert_memory_equal(err.text, "x.mco:", 6);
            assert_null(mco.value[CML_QUANTITY_A_rz]);
            assert_null(mco.output);
        }
    }
    assert_true(read <= 2); /* without the final blank, line feeds or both */
}

static void cut_files_are_refused_or_whole(void **state)
{
    assert_cuts_are_safe(state, case_open, case_open);
    assert_cuts_are_safe(state, case_full, case_full);
    assert_cuts_are_safe(state, gpumcml, meaning);
    assert_cuts_are_safe(state, clustermcml, meaning);
}

/* Any byte replaced by any of these: read or refused, and nothing else. */
static void mangled_files_do_no_harm(void **state)
{
    static const char bytes[] = "\n #9-.eAb\t\"\x80";
    static const char *const texts[] = {case_open, clustermcml};
    for (size_t t = 0; t < 2; t++) {
        const size_t size = strlen(texts[t]);
        char *text = strdup(texts[t]);
        for (size_t at = 0; at < size; at++) {
            for (size_t k = 0; k < sizeof bytes - 1; k++) {
                struct cml_outcome mco;
                struct cml_error err;
                text[at] = bytes[k];
                if (case_read(state, text, size, &mco, &err) == CML_OK)
                    cml_outcome_clear(&mco);
                else
                    assert_int_equal(err.status, CML_E_INPUT);
            }
            text[at] = texts[t][at];
        }
        free(text);
    }
}

struct mistake {
    const char *text, *from, *to, *message;
};

static const struct mistake mistakes[] = {
    {case_open, "A1 ", "mcmloA2.0 ", "x.mco:1: format = mcmloA2.0 (expected A1, the results of MCML 1)"},
    {case_open, "7204 sec", "long", "x.mco:10: user time = long (expected seconds)"},
    {case_open, "7204 sec", "-1 sec", "x.mco:10: user time = -1 (expected seconds)"},
    {case_open, "InParm \t", "InParms \t", "x.mco:12: section = InParms (expected InParm)"},
    {case_open, "open.mco \tA\t\t", "open.mco",
     "x.mco:13: output name = open.mco# (expected a file name and the letter A or B)"},
    {case_open, "1000000 ", "many ", "x.mco:14: photons = many (expected a whole number above 0)"},
    {case_open, "1000000 ", "0 ", "x.mco:14: photons = 0 (expected a whole number above 0)"},
    {case_open, "1000000 ", "1e400 ", "x.mco:14: photons = 1e400 (expected a whole number above 0)"},
    {case_open, "0.01\t0.0025", "0.01", "x.mco:15: dr is missing (expected a number above 0)"},
    {case_open, "0.01\t0.0025", "0\t0.0025", "x.mco:15: dz = 0 (expected a number above 0)"},
    {case_open, "0.01\t0.0025", "0.01\tnan", "x.mco:15: dr = nan (expected a number above 0)"},
    {case_open, "0.01\t0.0025", "0.01 0,0025",
     "x.mco:15: dr = 0,0025 (expected a number above 0, with a decimal point)"},
    {case_open, "3\t2\t1\t", "3\t2\t-1\t", "x.mco:16: na = -1 (expected a whole number above 0)"},
    {case_open, "3\t2\t1\t", "3\t2.5\t1\t", "x.mco:16: nr = 2.5 (expected a whole number above 0)"},
    {case_open, "3\t2\t1\t", "3\t2\t1\t4 ", "x.mco:16: number too many = 4 (expected the end of the line)"},
    {case_open, "3\t2\t1\t", "99999999999 2 1\t",
     "x.mco:16: nz = 99999999999 (expected a whole number above 0)"},
    {case_open, "2\t\t\t\t\t# Number", "0 # Number",
     "x.mco:18: number of layers = 0 (expected a whole number above 0)"},
    {case_open, "2\t\t\t\t\t# Number", "3 # Number",
     "x.mco:23: mua is missing (expected a number of 0 or more)"},
    {case_open, "2\t\t\t\t\t# Number", "1 # Number",
     "x.mco:22: number too many = 0 (expected the end of the line)"},
    {case_open, "1\t\t\t\t\t# n for medium above", "-1",
     "x.mco:20: n above = -1 (expected a number above 0)"},
    {case_open, "1.37\t", "1.37 x ", "x.mco:21: mua = x (expected a number of 0 or more)"},
    {case_open, "1E+08\t", "1.#INF\t", "x.mco:22: d = 1.#INF (expected a number of 0 or more)"},
    {case_open, "-0.5\t", "-1.5\t", "x.mco:22: g = -1.5 (expected a number from -1 to 1)"},
    {case_open, "1E+08\t", "-1E+08\t", "x.mco:22: d = -1E+08 (expected a number of 0 or more)"},
    {case_open, "1.5\t\t\t\t\t# n for medium below\n", "",
     "x.mco:24: n below = RAT (expected a number above 0)"},
    {case_open, "RAT #", "RATE #", "x.mco:25: section = RATE (expected RAT)"},
    {case_open, "0.237544 ", "0.2.3 ", "x.mco:27: RAT[1] = 0.2.3 (expected a number)"},
    {case_open, "1E-05          \t#Absorbed fraction [-]\n", "",
     "x.mco:30: RAT[3] = A_l (expected a number)"},
    {case_open, "  2.8099E-12\n", "", "x.mco:39: A_z[2] = Rd_r (expected a number)"},
    {case_open, "  2.8099E-12\n", "  2.8099E-12\n  2.8099E-12\n",
     "x.mco:39: section = 0.0000E+00 (expected Rd_r)"},
    {case_open, "  2.8099E-12\n", " -1.#IND\n", "x.mco:37: A_z[1] = -1.#IND (expected a number)"},
    {case_open, "  3.4038E-02", "  0x10", "x.mco:45: Rd_a[0] = 0x10 (expected a number)"},
    {case_open, "  3.4038E-02", "  1E999", "x.mco:45: Rd_a[0] = 1E999 (expected a number)"},
    {case_open, "Tt_a #", "tt_a #", "x.mco:51: section = tt_a (expected Tt_a)"},
    {case_open, "   2.5033E+03", "  inf", "x.mco:60: A_rz[0][2] = inf (expected a number)"},
    {case_open, "\n  8.5363E-99", "", "x.mco:66: A_rz[1][2] = Rd_ra (expected a number)"},
    {case_open, "  8.5363E-99", "  8.5363E-99 7",
     "x.mco:61: A_rz[2][0] = 7 (expected the end of the section)"},
    {case_open, "  1.7068E+02  -1.1574E+02 \n", "", "x.mco:74: Tt_ra[0][0] is missing (expected a number)"},
    {case_open, "  -1.1574E+02 \n", "   1.15",
     "x.mco:75: Tt_ra[1][0] = 1.15 (expected a line end after it, the file is cut off)"},
    {clustermcml, "skin.mco A\n1e5 photons\n", "",
     "x.mco:32: output name is missing (expected a file name and the letter A or B)"},
    {clustermcml, "1e5 photons\n", "", "x.mco:17: photons = 0.002 (expected a whole number above 0)"},
    {clustermcml, "beam disk 0.1\n1.0\n", "", "x.mco:32: n below is missing (expected a number above 0)"},
};

/* The text is refused with a message that begins so, and nothing of it is left. */
static void assert_refused(void **state, const char *text, const char *start, struct cml_error *err)
{
    struct cml_outcome mco;
    assert_int_equal(case_read(state, text, strlen(text), &mco, err), CML_E_INPUT);
    assert_memory_equal(err->text, start, strlen(start));
    assert_null(mco.output);
    assert_null(mco.value[CML_QUANTITY_layer_n]);
}

static void mistakes_are_named(void **state)
{
    for (size_t i = 0; i < sizeof mistakes / sizeof mistakes[0]; i++) {
        struct cml_error err;
        char *text = case_replace(mistakes[i].text, mistakes[i].from, mistakes[i].to);
        assert_refused(state, text, mistakes[i].message, &err);
        assert_string_equal(err.text, mistakes[i].message);
        free(text);
    }
}

/* Sizes beyond the file are refused with the number that it could hold; nothing is allocated for them. */
static void absurd_sizes_are_refused(void **state)
{
    static const struct {
        const char *from, *to, *start;
    } table[] = {
        {"3\t2\t1\t", "2147483647 2147483647 2147483647\t",
         "x.mco:16: nz nr na = 2147483647 2147483647 2147483647 (expected sizes that ask for no more than "
         "the "},
        {"3\t2\t1\t", "3 2 1000\t",
         "x.mco:16: nz nr na = 3 2 1000 (expected sizes that ask for no more than "},
        {"2\t\t\t\t\t# Number", "2147483647 #",
         "x.mco:18: number of layers = 2147483647 (expected sizes that ask for no more than the "},
    };
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        struct cml_error err;
        char number[64], *text = case_replace(case_open, table[i].from, table[i].to);
        assert_refused(state, text, table[i].start, &err);
        snprintf(number, sizeof number, " %zu numbers the file can hold)", strlen(text) / 2);
        assert_non_null(strstr(err.text, number));
        free(text);
    }
}

static void files_that_are_none(void **state)
{
    static const struct {
        const char *text, *message;
    } table[] = {
        {"", "x.mco: format is missing (expected A1, the results of MCML 1)"},
        {"\n\n# A1\n", "x.mco:3: format is missing"},
        {"1.0 # file version\n", "x.mco:1: format = 1.0"},
        {"A1\n", "x.mco:1: section is missing (expected InParm)"},
        {"A1\nRAT\n", "x.mco:2: section = RAT (expected InParm)"},
    };
    struct cml_outcome mco;
    struct cml_error err;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++)
        assert_refused(state, table[i].text, table[i].message, &err);
    char path[256];
    case_path(state, "none.mco", path);
    assert_int_equal(cml_mco_read(path, &mco, &err), CML_E_INPUT);
    case_normalise(state, err.text);
    assert_string_equal(err.text, "none.mco: cannot be read: No such file or directory (expected a file)");
    assert_int_equal(case_read(state, "A1\0", 3, &mco, &err), CML_E_INPUT);
    assert_null(mco.output);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dialects_mean_the_same),           cmocka_unit_test(harmless_differences),
        cmocka_unit_test(the_fields_are_where_they_belong), cmocka_unit_test(cut_files_are_refused_or_whole),
        cmocka_unit_test(mangled_files_do_no_harm),         cmocka_unit_test(mistakes_are_named),
        cmocka_unit_test(absurd_sizes_are_refused),         cmocka_unit_test(files_that_are_none),
    };
    return cmocka_run_group_tests_name("mco_read", tests, case_setup, case_teardown);
}
