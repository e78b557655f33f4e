/* Recognises a mesh whose vertices lie on a regular lattice, as sampled heights do: which facets cover each
 * cell, and between which depths. Facets may be merged ones (heightmap.h): their sides run along lattice
 * lines or the cells' diagonals, so that no cell has more than two. Parts outside the lattice's rectangle,
 * such as a skirt, may have any shape. Knows no rays. SPDX-License-Identifier: MIT */
#ifndef CML_LATTICE_H
#define CML_LATTICE_H

#include "mesh_query.h"

#define CML_LATTICE_NO_FACET 0x7fffffffu
#define CML_LATTICE_FALLING                                                                                  \
    0x80000000u /* the cell's diagonal runs from (1, 0) to (0, 1), not (0, 0) to (1, 1) */

struct cml_lattice_cell {
    float least, most; /* depths of the cell's facets, widened by rounding and margin */
    uint32_t south,
        north; /* facets at the lower and upper side in y, often the same; both with
                * CML_LATTICE_FALLING or both without; CML_LATTICE_NO_FACET where the mesh has none */
};

struct cml_lattice {
    double corner[2], per_cell[2]; /* cm relative to the body's centre, cells per cm */
    double margin; /* in cells: so far may a facet's edge lie from where the lattice says, and some more */
    int n[2];
    bool is_whole;                 /* the mesh has no other facets */
    struct cml_lattice_cell *cell; /* [n[1]][n[0]] */
};

/* *lattice owns its cells; none (cell NULL) when the mesh is no regular grid. CML_E_INPUT for memory. */
CML_NODISCARD cml_status cml_lattice_find(const struct cml_mesh_body *body, struct cml_lattice *lattice,
                                          struct cml_error *err);
void cml_lattice_clear(struct cml_lattice *lattice);

#endif
