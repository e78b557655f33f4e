/* Parts that all cross tests share: simulates packets one by one and compares their ends.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "lib/require.h"

#include "engine/engines.h"
#include "input/mci.h"
#include "scene/body/body_place.h"
#include "types.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct flight {
    struct cml_scene_list list;
    struct cml_surface_set surfaces;
    const struct cml_engine *engine;
    void *self;
};

/* Reads the text of an .mci file as scenes. The file lies beside the repository's samples, so that paths of
 * meshes resolve. */
static inline void read_scenes(const char *text, struct cml_scene_list *list)
{
    struct cml_error err;
    char path[] = "/tmp/cml_cross_XXXXXX";
    const int file = mkstemp(path);
    assert_true(file >= 0);
    assert_int_equal(write(file, text, strlen(text)), (ssize_t)strlen(text));
    close(file);
    const cml_status status = cml_mci_read(path, NULL, list, &err);
    remove(path);
    require_ok(status, &err);
    for (int i = 0; i < list->count; i++) require_ok(cml_scene_check_shapes(&list->scenes[i], &err), &err);
}

struct flight_options {
    const char *engine;
    enum cml_surface_kind kind;
    double tolerance;
    bool inscribed;
    enum cml_normals normals;
    bool no_reentry, absorption;
};

static inline void flight_open(const char *text, const struct flight_options *with, struct flight *flight)
{
    struct cml_error err;
    const struct cml_engine_options options = {.seed = 20261121,
                                               .threads = 1,
                                               .lattice = true,
                                               .roulette = {0.01, 0.03},
                                               .reentry = !with->no_reentry,
                                               .absorption = with->absorption};
    struct cml_surface_options surface = {.force = with->kind};
    surface.tessellation.tolerance = with->tolerance > 0 ? with->tolerance : 1e-3;
    surface.tessellation.inscribed = with->inscribed;
    surface.tessellation.normals = with->normals;
    read_scenes(text, &flight->list);
    require_ok(cml_surfaces_create(&flight->list.scenes[0], &surface, &flight->surfaces, &err), &err);
    flight->engine = cml_engine_find(with->engine);
    require_ok(
        flight->engine->open(&flight->list.scenes[0], &flight->surfaces, &options, &flight->self, &err),
        &err);
}

static inline void flight_close(struct flight *flight)
{
    flight->engine->close(flight->self);
    cml_surfaces_free(&flight->surfaces);
    cml_scene_list_clear(&flight->list);
}

static inline struct cml_fate_record fly(const struct flight *flight, uint64_t photon)
{
    struct cml_error err;
    struct cml_fate_record record;
    require_ok(flight->engine->trace(flight->self, photon, NULL, NULL, &record, &err), &err);
    return record;
}

/* Returns how many of `photons` packets end differently (fate or number of interactions) in two flights. */
static inline uint64_t count_different(const struct flight *a, const struct flight *b, uint64_t photons)
{
    uint64_t different = 0;
    for (uint64_t i = 0; i < photons; i++) {
        const struct cml_fate_record ra = fly(a, i), rb = fly(b, i);
        assert_int_not_equal(ra.fate, CML_FATE_LOST);
        assert_int_not_equal(rb.fate, CML_FATE_LOST);
        different += ra.fate != rb.fate || ra.interactions != rb.interactions;
    }
    return different;
}
