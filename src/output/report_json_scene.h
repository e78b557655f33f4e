/* What JSON of check and of a run have in common: the scene. Private to report_json*.c.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/json_name.h"
#include "output/report.h"

#include <stdio.h>

/* What lists are about; sums NULL: nothing has been flown. */
struct cml_json_subject {
    const struct cml_scene *scene;
    const struct cml_surface_set *surfaces;
    const struct cml_result *sums;
    uint64_t *dealt;                    /* [num_beams] photons of each beam; made by cml_json_print_lists */
    const int *starts;                  /* [num_beams] the medium that each starts in; NULL: not known */
    const struct cml_mean_shapes *mean; /* NULL: not asked for */
};

/* A list that may be long: its elements are made while they are written, one at a time. In the object `key`
 * holds its place. */
struct cml_json_list {
    const char *key;
    int count;
    json_t *(*element)(const struct cml_json_subject *subject, int i);
};

json_t *cml_json_boundary(const struct cml_json_subject *subject, int b);
json_t *cml_json_beam(const struct cml_json_subject *subject, int k);
json_t *cml_json_body(const struct cml_json_subject *subject, int k);

/* The scene's backing; null where it has none. */
json_t *cml_json_backing(const struct cml_backing_def *backing);

/* Prints the object with its lists on one line, and frees it; beams share the photons. CML_E_INPUT when
 * memory runs out. lists: [num_lists] */
CML_NODISCARD cml_status cml_json_print_lists(FILE *stream, json_t *object, const struct cml_json_list *lists,
                                              size_t num_lists, struct cml_json_subject *subject,
                                              uint64_t photons, struct cml_error *err);

/* Keys keep the order in which they are set (jansson 2.8 and later). */
static inline void cml_json_set_real(json_t *object, const char *key, double value)
{
    json_object_set_new(object, key, cml_json_real(value));
}

static inline void cml_json_set_integer(json_t *object, const char *key, uint64_t value)
{
    json_object_set_new(object, key, json_integer((json_int_t)value));
}

/* The totals that a scene has: with a backing one more. */
static inline int cml_json_totals(const struct cml_scene *scene)
{
    return cml_num_totals(scene->backing.kind != CML_BACKING_NONE);
}
