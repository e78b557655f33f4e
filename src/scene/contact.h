/* Faces and ports: what touches the material from above, on boundary 0 (rule P12). Lines of an .mci; a later
 * one lies on top of those before.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"

/* An area in a level plane. size: both radii of a ring (a disk: the first is 0), or both sides of a
 * rectangle; cm. */
struct cml_outline {
    enum cml_detector_shape shape;
    double x, y, size[2];
};

/* Returns the outline of a contact that has a shape. */
static inline struct cml_outline cml_contact_outline(const struct cml_contact_def *contact)
{
    return (struct cml_outline){contact->shape, contact->x, contact->y, {contact->size[0], contact->size[1]}};
}

/* Returns the number, from 1, of the last face that covers the whole plane; 0: none. It hides all before. */
int cml_contact_whole(const struct cml_scene *scene);

/* Returns the number, from 1, of the first contact behind contact `number` that overlaps it; 0: none.
 * Contacts that touch do not overlap. */
int cml_contact_above(const struct cml_scene *scene, int number);

/* True if one contact behind contact `number`, from 1, which has a shape, covers it. */
bool cml_contact_is_hidden(const struct cml_scene *scene, int number);

/* True if an opaque surface sends all light back. A metal whose index has no real part does. */
static inline bool cml_reflects_all(const struct cml_backing_def *surface)
{
    return surface->kind == CML_BACKING_METAL ? surface->n == 0 : surface->R >= 1;
}

/* Returns the index of the medium in which a beam that starts above all surfaces starts. */
double cml_beam_index(const struct cml_scene *scene, const struct cml_beam *beam);
