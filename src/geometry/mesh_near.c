/* Finds vertices near a place, through cells of equal width. SPDX-License-Identifier: MIT */
#include "geometry/mesh_parts.h"
#include "geometry/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define EMPTY UINT32_MAX

/* Multiplications and shifts mix all bits, because coordinates on a grid differ in few bits. */
size_t cml_mesh_hash(const double p[3])
{
    uint64_t bits[3];
    memcpy(bits, p, sizeof bits);
    uint64_t h = bits[0] * 0x9e3779b97f4a7c15u;
    h = ((h ^ h >> 32) + bits[1]) * 0xbf58476d1ce4e5b9u;
    h = ((h ^ h >> 29) + bits[2]) * 0x94d049bb133111ebu;
    return (size_t)(h ^ h >> 31);
}

cml_status cml_mesh_near_begin(struct cml_mesh_near *near, const struct cml_mesh *mesh, double width,
                               struct cml_error *err)
{
    size_t slots = 16;
    while (slots < 2 * mesh->num_vertices) slots *= 2;
    *near = (struct cml_mesh_near){.mesh = mesh, .width = width, .mask = slots - 1};
    near->first = malloc(slots * sizeof *near->first);
    near->next = malloc((mesh->num_vertices + 1) * sizeof *near->next);
    if (!near->first || !near->next)
        return cml_fail_memory(err, 4.0 * (double)slots, "the vertices of a mesh");
    memset(near->first, 0xff, slots * sizeof *near->first);
    return CML_OK;
}

void cml_mesh_near_end(struct cml_mesh_near *near)
{
    free(near->first);
    free(near->next);
}

/* Returns the slot of the cell that holds a place, or of the cell `step` cells away. 0.0 makes a plus zero of
 * a minus zero. */
static size_t slot_of(const struct cml_mesh_near *near, const double place[3], const int step[3])
{
    double cell[3];
    for (int k = 0; k < 3; k++) cell[k] = floor(place[k] / near->width) + step[k] + 0.0;
    return cml_mesh_hash(cell) & near->mask;
}

void cml_mesh_near_add(struct cml_mesh_near *near, uint32_t vertex)
{
    const size_t slot = slot_of(near, near->mesh->vertex[vertex], (const int[3]){0, 0, 0});
    near->next[vertex] = near->first[slot];
    near->first[slot] = vertex;
}

/* Cells of one slot are told apart by the distance of their vertices. */
void cml_mesh_near_visit(const struct cml_mesh_near *near, uint32_t vertex, cml_mesh_near_call *call,
                         void *context)
{
    const double *place = near->mesh->vertex[vertex];
    for (int cell = 0; cell < 27; cell++) {
        const int step[3] = {cell % 3 - 1, cell / 3 % 3 - 1, cell / 9 - 1};
        for (uint32_t i = near->first[slot_of(near, place, step)]; i != EMPTY; i = near->next[i]) {
            double way[3];
            cml_vec3_subtract(near->mesh->vertex[i], place, way);
            const double distance = cml_vec3_length(way);
            if (i != vertex && distance < near->width) call(context, vertex, i, distance);
        }
    }
}
