/* .vti files: read and drawn. SPDX-License-Identifier: MIT */
#include "fuzz/fuzz.h"

#include "plot/plot_map.h"

#include <zlib.h>

/* A picture has 90000 numbers or more, so that only some inputs are drawn: which, and how, their bytes say.
 */
static void draw(const struct cml_pixels *map, const uint8_t *data, size_t size)
{
    static const char *const names[1] = {"a.map.vti"};
    struct cml_error err = {CML_OK, ""};
    const unsigned long sum = crc32_z(0, data, size) % 64;
    const struct cml_map_plot plot = {.count = 1,
                                      .maps = map,
                                      .names = names,
                                      .quantity = "Rd",
                                      .grey = "no light",
                                      .axes = &cml_map_xy,
                                      .style = {.caption = "a b",
                                                .scale = (enum cml_scale)(sum % 3),
                                                .x = cml_axis_range_any,
                                                .y = cml_axis_range_any,
                                                .colour = cml_axis_range_any,
                                                .percentile = 100}};
    if (sum >= 3) return;
    const cml_status status = cml_map_script(fuzz_nowhere(), &plot, &err);
    if (status != CML_OK) fuzz_refused(status, &err);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct cml_pixels map;
    struct cml_error err = {CML_OK, ""};
    const cml_status status = cml_vti_read(fuzz_file(data, size), "Rd_xy", &map, &err);
    if (status != CML_OK) {
        fuzz_refused(status, &err);
        return 0;
    }
    FUZZ_CHECK(map.n[0] > 0 && map.n[1] > 0 && map.n[0] * map.n[1] * sizeof(float) <= size);
    draw(&map, data, size);
    cml_pixels_clear(&map);
    return 0;
}
