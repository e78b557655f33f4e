/* Two .mco files merged; where there is one, with itself under another seed. What comes out is a result
 * again. SPDX-License-Identifier: MIT */
#include "fuzz/fuzz.h"

#include <math.h>

#include "output/study/merge.h"
#include "result/h5.h"
#include "result/mco.h"

/* The second file, or the first with another digit in its seed; the caller's to free. */
static uint8_t *second(const uint8_t *data, size_t size, size_t *first_size, size_t *second_size)
{
    const size_t cut = sizeof FUZZ_CUT - 1;
    const uint8_t *mark = memmem(data, size, FUZZ_CUT, cut);
    *first_size = mark ? (size_t)(mark - data) : size;
    *second_size = mark ? size - *first_size - cut : size;
    uint8_t *copy = malloc(*second_size + 1);
    FUZZ_CHECK(copy != NULL);
    memcpy(copy, mark ? mark + cut : data, *second_size);
    uint8_t *seed = mark ? NULL : memmem(copy, *second_size, "seed ", 5);
    if (seed && seed + 5 < copy + *second_size) seed[5] = seed[5] == '9' ? '8' : '9';
    return copy;
}

/* Refused was what is no number; errors of single packets have been estimated. */
static void check(const struct cml_outcome *merged)
{
    FUZZ_CHECK(isfinite(merged->value[CML_QUANTITY_Rsp][0]) && isfinite(merged->value[CML_QUANTITY_Rd][0]) &&
               isfinite(merged->value[CML_QUANTITY_A][0]) && isfinite(merged->value[CML_QUANTITY_Tt][0]));
    FUZZ_CHECK(merged->value[CML_QUANTITY_Rsp][0] >= 0 && merged->value[CML_QUANTITY_Rd][0] >= 0 &&
               merged->value[CML_QUANTITY_A][0] >= 0 && merged->value[CML_QUANTITY_Tt][0] >= 0);
    for (int i = 0; i < CML_TOTALS; i++) FUZZ_CHECK(merged->error[i][0] >= 0);
}

static void write_all(const struct cml_outcome *merged, const struct cml_merge_input inputs[2], bool h5)
{
    struct cml_outcome again;
    struct cml_error err = {CML_OK, ""};
    const struct cml_hdf5_call call = {"merge", "a.mco"};
    FUZZ_CHECK(cml_merge_json(fuzz_nowhere(), "m.mco", inputs, 2, merged, &err) == CML_OK);
    if (merged->n_above > 0) {
        FUZZ_CHECK(cml_mco_write(fuzz_output(), merged, &err) == CML_OK);
        FUZZ_CHECK(cml_mco_read(fuzz_output(), &again, &err) == CML_OK);
        cml_outcome_clear(&again);
    }
    if (h5) FUZZ_CHECK(cml_merge_write_h5(fuzz_output(), merged, inputs, 2, &call, &err) == CML_OK);
    remove(fuzz_output());
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    size_t sizes[2];
    struct cml_outcome mco[2] = {0}, merged;
    struct cml_error err = {CML_OK, ""};
    uint8_t *other = second(data, size, &sizes[0], &sizes[1]);
    const struct cml_merge_input inputs[2] = {{"a.mco", &mco[0]}, {"b.mco", &mco[1]}};
    cml_status status = cml_result_read(fuzz_file(data, sizes[0]), &mco[0], &err);
    if (status == CML_OK) status = cml_result_read(fuzz_file(other, sizes[1]), &mco[1], &err);
    if (status == CML_OK) status = cml_merge(inputs, 2, "m.mco", &merged, &err);
    if (status == CML_OK) {
        check(&merged);
        write_all(&merged, inputs, size % 64 == 0);
        cml_outcome_clear(&merged);
    } else {
        fuzz_refused(status, &err);
    }
    cml_outcome_clear(&mco[0]);
    cml_outcome_clear(&mco[1]);
    free(other);
    return 0;
}
