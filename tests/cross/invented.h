/* Invented tables in place of those that --aim computes. They suffice to test that two walks count the same.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "lib/dice.h"

#include "simulation/aim.h"

#include <stdlib.h>

/* Makes a tail at the scene's level, if it has one, with random numbers below it. */
static inline void invent_tail(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                               struct cml_flat_tail *tail)
{
    const struct cml_aim_level level_of = cml_aim_level_of(scene, surfaces);
    const double n = scene->media[level_of.layer].n, other = scene->media[scene->num_layers + 1].n;
    struct dice dice = dice_new(3);
    *tail = (struct cml_flat_tail){.layer = level_of.layer, .z = level_of.z};
    if (level_of.layer == 0) return;
    tail->scores = scene->num_layers - level_of.layer + 1;
    tail->intervals = other < n ? 2 : 1;
    tail->index = calloc(2, sizeof *tail->index);
    tail->index[0] = other;
    tail->index[tail->intervals - 1] = n;
    const size_t numbers = (size_t)tail->intervals * (CML_FLAT_TAIL_CELLS + 1) * (size_t)tail->scores;
    tail->exponent = calloc((size_t)tail->scores, sizeof *tail->exponent);
    tail->response = calloc(numbers, sizeof *tail->response);
    for (size_t i = 0; i < numbers; i++) tail->response[i] = (float)dice_uniform(&dice);
}

/* Makes windows with random weights, which jump from cell to cell and from ring to ring. */
static inline void invent_windows(const struct cml_scene *scene, struct cml_window_table *windows)
{
    static uint32_t target[64 * 4];
    struct dice dice = dice_new(4);
    *windows = (struct cml_window_table){.cells = 64,
                                         .rings = 4,
                                         .share = 1,
                                         .places = 2,
                                         .place = {{0.03, -0.01}, {-0.05, 0}},
                                         .reach = 0.4,
                                         .target = target};
    for (int l = 1; l <= scene->num_layers; l++) windows->depth += scene->media[l].d;
    for (int i = 0; i < windows->cells * windows->rings; i++)
        target[i] = 0x80000000u >> (int)(5 * dice_uniform(&dice));
    for (int k = 0; k < scene->num_detectors; k++)
        if (scene->detectors[k].shape == CML_DETECTOR_RING) windows->detector = k + 1;
    if (windows->detector) windows->share = 0.5; /* the share of circles, in every scene */
}
