/* Fuzzes .mci files and all files that they name: reads them and checks the boundaries.
 * SPDX-License-Identifier: MIT */
#include "fuzz/fuzz.h"

#include "input/mci.h"
#include "scene/body/body_place.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_files files = {data, size};
    const struct cml_text_source source = fuzz_source(&files);
    const struct cml_input_options options = {.source = &source, .tolerance = 1e-3};
    struct cml_scene_list list;
    struct cml_error err = {CML_OK, ""};
    cml_status status = cml_mci_read("scene.mci", &options, &list, &err);
    if (status != CML_OK) {
        fuzz_refused(status, &err);
        FUZZ_CHECK(list.count == 0 && list.scenes == NULL);
        return 0;
    }
    FUZZ_CHECK(list.count >= 1 && list.count <= 32767);
    for (int i = 0; i < list.count; i++) {
        status = cml_scene_check_shapes(&list.scenes[i], &err);
        if (status != CML_OK) fuzz_refused(status, &err);
    }
    cml_scene_list_clear(&list);
    return 0;
}
