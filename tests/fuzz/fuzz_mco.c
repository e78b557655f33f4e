/* .mco files: read; written, read and written again with the same bytes. SPDX-License-Identifier: MIT */
#include "fuzz/fuzz.h"

#include "result/mco.h"

/* The bytes of the file that a result is written as; the caller's to free. */
static char *written(const struct cml_outcome *mco, size_t *size)
{
    struct cml_error err = {CML_OK, ""};
    char *bytes = NULL;
    FUZZ_CHECK(cml_mco_write(fuzz_output(), mco, &err) == CML_OK);
    FUZZ_CHECK(cml_text_read_file(fuzz_output(), SIZE_MAX, &bytes, size, &err) == CML_OK);
    return bytes;
}

/* What is read from our own file gives the same bytes. */
static void check_written(struct cml_outcome mco[2])
{
    size_t size[2];
    struct cml_error err = {CML_OK, ""};
    char *bytes = written(&mco[0], &size[0]);
    const cml_status status = cml_mco_read(fuzz_output(), &mco[1], &err);
    if (status != CML_OK) fprintf(stderr, "%s\n", err.text);
    FUZZ_CHECK(status == CML_OK);
    char *again = written(&mco[1], &size[1]);
    FUZZ_CHECK(size[0] == size[1] && memcmp(bytes, again, size[0]) == 0);
    free(bytes);
    free(again);
    remove(fuzz_output());
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct cml_outcome mco[2];
    struct cml_error err = {CML_OK, ""};
    const cml_status status = cml_mco_read(fuzz_file(data, size), &mco[0], &err);
    if (status != CML_OK) {
        fuzz_refused(status, &err);
        return 0;
    }
    check_written(mco);
    cml_outcome_clear(&mco[1]);
    cml_outcome_clear(&mco[0]);
    return 0;
}
