/* JSON of a scene, which the records of check and of a run share. Private to report_json*.c.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/json_name.h"
#include "output/report.h"

#include <stdio.h>

/* The run whose lists are printed; sums NULL: nothing has been flown. */
struct cml_json_subject {
    const struct cml_scene *scene;
    const struct cml_surface_set *surfaces;
    const struct cml_result *sums;
    uint64_t *dealt;   /* [num_beams] photons of each beam; made by cml_json_print_lists */
    const int *starts; /* [num_beams] the medium in which each beam starts; NULL: not known */
    const struct cml_mean_shapes *mean; /* NULL: not asked for */
};

/* A list that may be long, so its elements are made one at a time while they are written. The object has
 * `key` where the list will stand. */
struct cml_json_list {
    const char *key;
    int count;
    json_t *(*element)(const struct cml_json_subject *subject, int i);
};

json_t *cml_json_boundary(const struct cml_json_subject *subject, int b);
json_t *cml_json_beam(const struct cml_json_subject *subject, int k);
json_t *cml_json_body(const struct cml_json_subject *subject, int k);

/* Returns the scene's backing; null if it has none. */
json_t *cml_json_backing(const struct cml_backing_def *backing);

/* Prints the object with its lists on one line, and frees it. photons: shared by the beams. CML_E_INPUT if
 * memory runs out. lists: [num_lists] */
CML_NODISCARD cml_status cml_json_print_lists(FILE *stream, json_t *object, const struct cml_json_list *lists,
                                              size_t num_lists, struct cml_json_subject *subject,
                                              uint64_t photons, struct cml_error *err);

/* Sets a number. Keys keep the order in which they are set (jansson 2.8 and later). */
static inline void cml_json_set_real(json_t *object, const char *key, double value)
{
    json_object_set_new(object, key, cml_json_real(value));
}

static inline void cml_json_set_integer(json_t *object, const char *key, uint64_t value)
{
    json_object_set_new(object, key, json_integer((json_int_t)value));
}

/* True if adding-doubling knows a total of a scene: it treats no faces and ports. */
static inline bool cml_json_has_exact(const struct cml_scene *scene, int total)
{
    return cml_has_total(total, scene->backing.kind != CML_BACKING_NONE, false);
}
