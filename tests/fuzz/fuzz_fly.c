/* Fuzzes .mci files like fuzz_mci, and flies 64 packets of each run with two engines: no packet is lost,
 * no weight is missing. Scenes that would take long are skipped. SPDX-License-Identifier: MIT */
#include "fuzz/fuzz.h"

#include "engine/engines.h"
#include "input/mci.h"
#include "scene/body/body_place.h"
#include "tally/result.h"

#include <math.h>

enum { PHOTONS = 64, MOST_RUNS = 2, MOST_LAYERS = 6, MOST_CELLS = 4096, MOST_PARTS = 256, MOST_BODIES = 32 };

/* True if a layer is quick to fly. Packets interact often if the albedo is near 1 and the layer is thick,
 * and meet boundaries often if it is thin. A float resolves 1e-7 of lengths. */
static bool is_quick_layer(const struct cml_medium_def *layer, double reach)
{
    const double mut = layer->mua + layer->mus;
    if (layer->d > 1e3 && layer->mua < 0.009 * mut) return false;
    if (mut == 0) return layer->d == 0 || layer->d > 1e-4 * reach;
    return layer->d > 1e-4 * reach && mut * layer->d > 1e-2 && mut * reach < 1e4 &&
           (mut * reach < 25 || layer->mua > 0.009 * mut);
}

static bool is_quick_boundary(const struct cml_boundary *boundary)
{
    return boundary->mesh.num_triangles <= MOST_PARTS && boundary->radial.n <= MOST_PARTS;
}

/* True if a body is no larger than its layer; a body without absorption must be thin. */
static bool is_quick_body(const struct cml_scene *scene, int body, double reach)
{
    const struct cml_medium_def *medium = &scene->media[scene->num_layers + 2 + body];
    const double mut = medium->mua + medium->mus;
    return scene->bodies[body].mesh.num_triangles <= MOST_PARTS && mut * reach < 1e4 &&
           (mut * reach < 25 || medium->mua > 0.009 * mut);
}

/* Returns the largest distance (cm) across a layer: all layers and all shapes. */
static double reach_of(const struct cml_scene *scene)
{
    double reach = 0;
    for (int l = 1; l <= scene->num_layers; l++)
        if (scene->media[l].d <= 1e3) reach += scene->media[l].d;
    for (int b = 0; b <= scene->num_layers; b++) {
        const struct cml_boundary *boundary = &scene->boundaries[b];
        for (int axis = 0; axis < 3 && boundary->mesh.num_triangles > 0; axis++)
            reach = fmax(reach, fmax(-boundary->mesh.lower[axis], boundary->mesh.upper[axis]));
        for (int i = 0; i < boundary->radial.n; i++)
            reach = fmax(reach, fmax(fabs(boundary->radial.h[i]), boundary->radial.r[i]));
    }
    return fmax(reach, fmax(fabs(scene->beams[0].x), fabs(scene->beams[0].y)) + scene->beams[0].size[0]);
}

static bool is_quick(const struct cml_scene *scene)
{
    const struct cml_map_def *map = &scene->map;
    const double pixels = (double)map->nx * map->ny, nz = scene->nz, nr = scene->nr, na = scene->na;
    if (nz * nr > MOST_CELLS || nr * na > MOST_CELLS || nz > 256 || nr > 256 || na > 256 ||
        pixels * (map->angles ? na : 1) > MOST_CELLS || pixels * (map->volume ? nz : 1) > MOST_CELLS)
        return false;
    const double reach = reach_of(scene);
    if (scene->num_layers > MOST_LAYERS || scene->num_bodies > MOST_BODIES || !(reach > 1e-6 && reach < 1e6))
        return false;
    for (int l = 1; l <= scene->num_layers; l++)
        if (!is_quick_layer(&scene->media[l], reach)) return false;
    for (int b = 0; b <= scene->num_layers; b++)
        if (!is_quick_boundary(&scene->boundaries[b])) return false;
    for (int k = 0; k < scene->num_bodies; k++)
        if (!is_quick_body(scene, k, reach)) return false;
    return true;
}

/* Checks the tally's weight. The whole tally is one batch of the result, whichever batches it was noted
 * for before. */
static void check_tally(struct cml_tally *tally)
{
    struct cml_result result;
    struct cml_error err = {CML_OK, ""};
    FUZZ_CHECK(cml_result_create(&tally->grid, PHOTONS, &result, &err) == CML_OK);
    memset(tally->last_sums, 0, cml_tally_profile_bins(&tally->grid) * sizeof *tally->last_sums);
    tally->late.count = 0;
    cml_tally_sum_batch(tally, 0);
    cml_result_add_batch(&result, 0, tally);
    cml_result_add(&result, tally);
    FUZZ_CHECK(result.summary.count[CML_COUNT_PHOTONS] == PHOTONS);
    FUZZ_CHECK(cml_result_imbalance(&result) == 0);
    FUZZ_CHECK(cml_result_lost(&result) == 0);
    cml_result_free(&result);
}

static void fly(const char *name, const struct cml_scene *scene, const struct cml_surface_set *surfaces)
{
    const struct cml_engine *engine = cml_engine_find(name);
    const struct cml_engine_options options = {.seed = 1,
                                               .run = 1,
                                               .threads = 1,
                                               .lattice = true,
                                               .roulette = {0.01, 0.03},
                                               .reentry = true,
                                               .absorption = true};
    const struct cml_tally_grid grid = cml_engine_grid(scene, surfaces, &options);
    struct cml_tally tally;
    struct cml_error err = {CML_OK, ""};
    void *self = NULL;
    if (grid.facets > MOST_CELLS) return;
    const cml_status status = engine->open(scene, surfaces, &options, &self, &err);
    if (status != CML_OK) {
        fuzz_refused(status, &err);
        return;
    }
    FUZZ_CHECK(cml_tally_create(&grid, &tally, &err) == CML_OK);
    FUZZ_CHECK(cml_engine_run_range(engine, self, 0, PHOTONS, &tally, &err) == CML_OK);
    engine->close(self);
    check_tally(&tally);
    cml_tally_free(&tally);
}

static void fly_both(const struct cml_scene *scene)
{
    const struct cml_surface_options options = {
        .force = CML_SURFACE_AUTO, .tolerance = 1e-3, .tessellation.normals = CML_NORMALS_ANALYTIC};
    struct cml_surface_set surfaces;
    struct cml_error err = {CML_OK, ""};
    if (!is_quick(scene) || cml_scene_check_shapes(scene, &err) != CML_OK) return;
    const cml_status status = cml_surfaces_create(scene, &options, &surfaces, &err);
    if (status != CML_OK) {
        fuzz_refused(status, &err);
        return;
    }
    fly("cpu", scene, &surfaces);
    fly("reference", scene, &surfaces);
    cml_surfaces_free(&surfaces);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_files files = {data, size};
    const struct cml_text_source source = fuzz_source(&files);
    const struct cml_input_options options = {.source = &source, .tolerance = 1e-2};
    struct cml_scene_list list;
    struct cml_error err = {CML_OK, ""};
    if (cml_mci_read("scene.mci", &options, &list, &err) != CML_OK) return 0;
    for (int i = 0; i < list.count && i < MOST_RUNS; i++) fly_both(&list.scenes[i]);
    cml_scene_list_clear(&list);
    return 0;
}
