/* Fuzzes the reader of heads of .mco files. SPDX-License-Identifier: MIT */
#include "fuzz/fuzz.h"

#include "result/head.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct cml_head head;
    if (cml_head_read(fuzz_file(data, size), &head))
        FUZZ_CHECK(head.photons >= 1 && strlen(head.identity) < sizeof head.identity);
    return 0;
}
