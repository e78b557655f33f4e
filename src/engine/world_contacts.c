/* Faces and ports on boundary 0 as the kernels read them (struct cml_contacts), and the light that they stop.
 * SPDX-License-Identifier: MIT */
#include "engine/world_parts.h"

#include "source.h"

#include <stdlib.h>

/* Makes the grid over the contacts that have a shape and are not hidden by a face that covers all. */
static cml_status make_contact_grid(const struct cml_scene *scene, const double origin[2],
                                    struct cml_owned_world *to, struct cml_error *err)
{
    const int first = to->world.contacts.whole, count = scene->num_contacts - first;
    if (count == 0) return CML_OK;
    struct cml_outline *outline = malloc((size_t)count * sizeof *outline);
    int *number = malloc((size_t)count * sizeof *number);
    cml_status status =
        outline && number ? CML_OK : cml_fail_memory(err, count * (double)sizeof *outline, "faces and ports");
    for (int k = 0; status == CML_OK && k < count; k++) {
        number[k] = first + k;
        outline[k] = cml_contact_outline(&scene->contacts[first + k]);
    }
    if (status == CML_OK)
        status =
            cml_add_level(outline, number, count, origin, &to->contact_cells, &to->world.contacts.grid, err);
    free(outline);
    free(number);
    to->world.contacts.start = to->contact_cells.start;
    to->world.contacts.list = to->contact_cells.list;
    return status;
}

cml_status cml_set_contacts(const struct cml_scene *scene, const double origin[2], struct cml_owned_world *to,
                            struct cml_error *err)
{
    const int count = scene->num_contacts;
    if (count == 0) return CML_OK;
    to->contacts = cml_arrays_add(&to->arrays, (size_t)count, sizeof *to->contacts);
    CML_TRY(cml_arrays_check(&to->arrays, "faces and ports", err));
    for (int k = 0; k < count; k++) {
        const struct cml_contact_def *def = &scene->contacts[k];
        const struct cml_outline outline = cml_contact_outline(def);
        to->contacts[k] = (struct cml_contact){.area = cml_area_of(&outline, origin),
                                               .is_port = def->port,
                                               .stops = !(def->port && def->n == scene->media[0].n),
                                               .n = def->n,
                                               .face = cml_backing_of(&def->face, 0, scene->media[1].n)};
    }
    to->world.contacts.count = count;
    to->world.contacts.whole = cml_contact_whole(scene);
    to->world.contacts.item = to->contacts;
    return make_contact_grid(scene, origin, to, err);
}

/* Light that starts in layer 1 or deeper, in a port or upwards meets nothing that could stop it. */
double cml_stopped_share(const struct cml_world *world, int k, int *passes)
{
    const int places = 4096;
    const cml_u64 first = world->setup.num_sources > 1 ? (cml_u64)k << CML_SOURCE_SHIFT : 0;
    int stopped = 0, upwards = 0;
    *passes = 1;
    if (world->sources[k].port) return 0;
    for (int i = 0; i < places; i++) {
        struct cml_packet packet;
        cml_place(world, first + (cml_u64)i, &packet);
        upwards += packet.medium == 0 && !(packet.u.z > 0);
        if (packet.medium > 0 || !(packet.u.z > 0)) continue;
        const struct cml_vec at = cml_along(packet.p, -packet.p.z / packet.u.z, packet.u);
        const struct cml_contact *contact = cml_contact_of(world, cml_contact_at(world, at.x, at.y));
        stopped += contact && contact->stops;
    }
    *passes = stopped == 0 || stopped + upwards < places;
    return (double)stopped / places;
}
