/* Fuzzes heightmaps, .gsf and .asc: a map that one reader accepts becomes a mesh. SPDX-License-Identifier:
 * MIT */
#include "fuzz/fuzz.h"

#include "input/mesh/esri.h"
#include "input/mesh/gsf.h"

#include <math.h>

enum { MOST_SAMPLES = 1024 }; /* limit for maps that are made into meshes */

static void check_map(struct cml_heightmap *map)
{
    struct cml_mesh mesh;
    struct cml_heightmap_notes notes;
    struct cml_error err = {CML_OK, ""};
    FUZZ_CHECK(map->nx >= 2 && map->ny >= 2 && map->dx > 0 && map->dy > 0);
    for (int i = 0; i < map->nx * map->ny; i++) FUZZ_CHECK(isfinite(map->h[i]));
    if (map->nx * map->ny <= MOST_SAMPLES) {
        const cml_status status = cml_heightmap_mesh(map, 1e-3, CML_NORMALS_FACET, NULL, &mesh, &notes, &err);
        if (status == CML_OK)
            cml_mesh_clear(&mesh);
        else
            fuzz_refused(status, &err);
    }
    cml_heightmap_clear(map);
}

/* unit 0: the file must name its own unit, if its format can. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    for (int unit = 0; unit < 2; unit++)
        for (int esri = 0; esri < 2; esri++) {
            struct fuzz_files files = {data, size};
            const struct cml_text_source source = fuzz_source(&files);
            struct cml_heightmap map;
            struct cml_error err = {CML_OK, ""};
            const cml_status status = (esri ? cml_esri_read : cml_gsf_read)(&source, "map", unit, &map, &err);
            if (status == CML_OK)
                check_map(&map);
            else
                fuzz_refused(status, &err);
        }
    return 0;
}
