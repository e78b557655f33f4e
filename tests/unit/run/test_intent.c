/* Tests of the decision to start, continue, extend or refuse a run, for every combination of files and
 * options that it may find. SPDX-License-Identifier: MIT */
#include "run/intent.h"

#include "lib/require.h"

enum { NO, YES, ANY, ANY_KIND = CML_CHECKPOINT_FINISHED + 1 };

/* Rules in order; the first row that fits decides. */
static const struct {
    int extends, resumes, kind, tallies, result_gone, result_stands, kept;
    enum cml_run_intent intent;
} rows[] = {
    {YES, ANY, ANY_KIND, ANY, ANY, ANY, ANY, CML_RUN_EXTEND},
    {NO, YES, CML_CHECKPOINT_NONE, ANY, ANY, YES, ANY, CML_RUN_NOTHING_LEFT},
    {NO, YES, CML_CHECKPOINT_FINISHED, ANY, NO, ANY, ANY, CML_RUN_NOTHING_LEFT},
    {NO, ANY, ANY_KIND, ANY, ANY, ANY, YES, CML_RUN_REFUSED},
    {NO, NO, ANY_KIND, ANY, ANY, ANY, NO, CML_RUN_FRESH},
    {NO, YES, CML_CHECKPOINT_NONE, ANY, ANY, NO, NO, CML_RUN_FRESH},
    {NO, YES, CML_CHECKPOINT_PARTIAL, ANY, ANY, ANY, NO, CML_RUN_RESUME},
    {NO, YES, CML_CHECKPOINT_FINISHED, YES, YES, ANY, NO, CML_RUN_REPUBLISH},
    {NO, YES, CML_CHECKPOINT_FINISHED, NO, YES, ANY, NO, CML_RUN_FRESH},
};

static bool fits(int wanted, int value, int any)
{
    return wanted == any || wanted == value;
}

static void every_combination_has_its_intent(void **state)
{
    (void)state;
    for (int bits = 0; bits < 64; bits++)
        for (int kind = CML_CHECKPOINT_NONE; kind <= CML_CHECKPOINT_FINISHED; kind++) {
            const struct cml_run_findings found = {.extends = bits & 1,
                                                   .resumes = bits & 2,
                                                   .kind = (enum cml_checkpoint_kind)kind,
                                                   .tallies = bits & 4,
                                                   .result_gone = bits & 8,
                                                   .result_stands = bits & 16,
                                                   .kept = bits & 32};
            size_t row = 0;
            while (!(fits(rows[row].extends, found.extends, ANY) &&
                     fits(rows[row].resumes, found.resumes, ANY) && fits(rows[row].kind, kind, ANY_KIND) &&
                     fits(rows[row].tallies, found.tallies, ANY) &&
                     fits(rows[row].result_gone, found.result_gone, ANY) &&
                     fits(rows[row].result_stands, found.result_stands, ANY) &&
                     fits(rows[row].kept, found.kept, ANY)))
                row++;
            assert_int_equal(cml_run_intent_of(&found), rows[row].intent);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_combination_has_its_intent)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
