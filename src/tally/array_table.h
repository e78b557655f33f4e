/* The table of arrays: one row for every array of sums. A holder is a block of cells that contains a set of
 * the arrays (enum cml_holder). The table gives the size and the place of each array in each kind of holder:
 *
 *     tally of a thread  -->  profiles of a batch, added to  -->  result of a run
 *     rows of a sweep, or scores of derivatives (row_cells.h)
 *
 * A new array needs a row here, its place in the orders of array_table.c, and a line that scores into it.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "tally/tally_grid.h"

/* Axes of arrays. A tally has extra cells beyond the ends of some axes, so that scoring needs no branch there
 * (rule P7): one radius and one depth behind the last, one depth above the first, and one gate for all later
 * times. A result has no extra cells: its outermost bins take their contents, and later times have an array
 * of their own. */
#define CML_CELL_AXES(X)                                                                                     \
    X(r)                                                                                                     \
    X(z)                                                                                                     \
    X(alpha)                                                                                                 \
    X(place)  /* r and z with gates, without extra cells */                                                  \
    X(medium) /* medium above, layers, medium below, bodies */                                               \
    X(gate)                                                                                                  \
    X(theta)                                                                                                 \
    X(phi)                                                                                                   \
    X(total) /* enum cml_total */                                                                            \
    X(term)  /* enum cml_balance_term */                                                                     \
    X(detector)                                                                                              \
    X(moment)         /* enum cml_moment by medium, then the depth; several cells each */                    \
    X(expected)       /* expected values (rule P15) */                                                       \
    X(pixel)          /* pixels of the map, and one for all outside */                                       \
    X(map_alpha)      /* angles of a pixel */                                                                \
    X(voxel)          /* voxels, and one for all outside */                                                  \
    X(inner_voxel)    /* voxels only */                                                                      \
    X(group)          /* groups of packets, CML_NUM_GROUPS */                                                \
    X(facet)          /* facets of all boundaries and bodies */                                              \
    X(facet_score)    /* enum cml_facet_score */                                                             \
    X(detector_pixel) /* pixels of all detectors that are maps */                                            \
    X(row)            /* cells of all rows together */

/* The number of copies of an array. Copies for parts of the packets give its values standard errors. */
enum cml_spread {
    CML_KEPT_WHOLE, /* one copy for all packets */
    /* One copy per group of packets (CML_NUM_GROUPS), or a single one for a large array. */
    CML_KEPT_BY_GROUP,
    /* For arrays to whose cells a packet adds at most once: one copy per group, or sums and squares for a
     * large array. Neighbours with the same axes are stored together, group by group. */
    CML_KEPT_ONCE,
    /* One copy per batch (CML_NUM_BATCHES) in a result; a thread adds the sums of one batch. */
    CML_KEPT_BY_BATCH,
    CML_KEPT_AS_BATCHES /* one copy per batch, in a tally as well */
};

/* Conditions of arrays. An array exists if its condition holds and all its axes have bins. */
enum cml_array_when {
    CML_IF_ANY,
    CML_IF_GATES,
    CML_IF_ABSORPTION,   /* absorption by radius and depth; for rows of a sweep only if they have depths */
    CML_IF_DEPTHS,       /* absorption by depth alone; a tally has it if threads share A_rz */
    CML_IF_TIMES,        /* absorption by time */
    CML_IF_MEDIUM_TIMES, /* absorption by medium and time, if these are few enough cells; not for rows */
    CML_IF_RADII,        /* light that leaves, by radius and time; all threads share one array */
    CML_IF_MEANS,        /* moments of detectors; for rows of a sweep only on request */
    CML_IF_FLUENCE,
    CML_IF_OWNER /* all threads share one array, which the first thread's tally owns */
};

/* clang-format off */
/* Columns: name, axes of cells (slowest first), number of copies, condition of existence, and the term of the
 * balance that all its cells add up to. The row behind an array over gates holds the later times. Further
 * columns, for the quantity in results (result/quantity.h): estimator, units, axes, where it is written, long
 * name. Checkpoints, files and JSON use the names; .h5 and JSON keep the order of these rows. */
#define CML_QUANTITY_ARRAYS(A) \
    A(A_l, medium, none, BY_BATCH, ANY, ABSORBED, LAYERS, "1", OVER1(layer), H5 | JSON, "absorption by layer") \
    A(A_z, z, none, BY_BATCH, DEPTHS, none, ARRAY, "1/cm", OVER1(z), H5, \
      "absorption by depth; what lies outside is in the outermost bins") \
    A(Rd_r, r, none, BY_BATCH, ANY, none, ARRAY, "1/cm2", OVER1(r), H5, \
      "diffuse reflectance by radius; the last bin holds what lies beyond") \
    A(Rd_a, alpha, none, BY_BATCH, ANY, none, ARRAY, "sr-1", OVER1(alpha), H5, "diffuse reflectance by angle") \
    A(Tt_r, r, none, BY_BATCH, ANY, none, ARRAY, "1/cm2", OVER1(r), H5, \
      "transmittance by radius; the last bin holds what lies beyond") \
    A(Tt_a, alpha, none, BY_BATCH, ANY, none, ARRAY, "sr-1", OVER1(alpha), H5, "transmittance by angle") \
    A(A_rz, r, z, BY_GROUP, ABSORPTION, ABSORBED, ARRAY, "1/cm3", OVER2(r, z), H5, \
      "absorption by radius and depth") \
    A(Rd_ra, r, alpha, BY_GROUP, ANY, REFLECTED, ARRAY, "1/(cm2 sr)", OVER2(r, alpha), H5, \
      "diffuse reflectance by radius and angle") \
    A(Tt_ra, r, alpha, BY_GROUP, ANY, TRANSMITTED, ARRAY, "1/(cm2 sr)", OVER2(r, alpha), H5, \
      "transmittance by radius and angle") \
    A(Rd_t, gate, none, BY_BATCH, ANY, REFLECTED, ARRAY, "1/ps", OVER1(gate), H5, "diffuse reflectance by time") \
    A(Rd_t_later, none, none, BY_BATCH, GATES, none, ARRAY, "1", NUMBER, H5 | JSON, \
      "diffuse reflectance later than all gates") \
    A(Tt_t, gate, none, BY_BATCH, ANY, TRANSMITTED, ARRAY, "1/ps", OVER1(gate), H5, "transmittance by time") \
    A(Tt_t_later, none, none, BY_BATCH, GATES, none, ARRAY, "1", NUMBER, H5 | JSON, \
      "transmittance later than all gates") \
    A(A_t, gate, none, BY_BATCH, TIMES, ABSORBED, ARRAY, "1/ps", OVER1(gate), H5, "absorption by time") \
    A(A_t_later, none, none, BY_BATCH, TIMES, none, ARRAY, "1", NUMBER, H5 | JSON, \
      "absorption later than all gates") \
    A(A_lt, medium, gate, BY_BATCH, MEDIUM_TIMES, ABSORBED, LAYERS, "1/ps", OVER2(layer, gate), H5, \
      "absorption by layer and time") \
    A(A_lt_later, medium, none, BY_BATCH, MEDIUM_TIMES, none, LAYERS, "1", OVER1(layer), H5, \
      "absorption by layer later than all gates") \
    A(Rd_rt, r, gate, BY_GROUP, RADII, REFLECTED, ARRAY, "1/(cm2 ps)", OVER2(r, gate), H5, \
      "diffuse reflectance by radius and time") \
    A(Rd_rt_later, r, none, BY_GROUP, RADII, none, ARRAY, "1/cm2", OVER1(r), H5, \
      "diffuse reflectance by radius, later than all gates") \
    A(Tt_rt, r, gate, BY_GROUP, RADII, TRANSMITTED, ARRAY, "1/(cm2 ps)", OVER2(r, gate), H5, \
      "transmittance by radius and time") \
    A(Tt_rt_later, r, none, BY_GROUP, RADII, none, ARRAY, "1/cm2", OVER1(r), H5, \
      "transmittance by radius, later than all gates") \
    A(phi_z, z, none, BY_BATCH, FLUENCE, none, ARRAY, "1", OVER1(z), H5, "fluence by depth, over all radii") \
    A(phi_rz, r, z, AS_BATCHES, FLUENCE, none, ARRAY, "1/cm2", OVER2(r, z), H5, "fluence by radius and depth") \
    A(phi_rzt, place, gate, BY_GROUP, OWNER, none, ARRAY, "1/(cm2 ps)", OVER3(r, z, gate), H5, \
      "fluence rate by radius, depth and time") \
    A(phi_rzt_later, place, none, BY_GROUP, OWNER, none, ARRAY, "1/cm2", OVER2(r, z), H5, \
      "fluence by radius and depth later than all gates") \
    A(Rd_dir, theta, phi, ONCE, OWNER, REFLECTED, ARRAY, "1/sr", OVER2(theta, phi), H5, \
      "diffuse reflectance by direction") \
    A(Tt_dir, theta, phi, ONCE, OWNER, TRANSMITTED, ARRAY, "1/sr", OVER2(theta, phi), H5, \
      "transmittance by direction") \
    A(Rsp_dir, theta, phi, ONCE, OWNER, SPECULAR, ARRAY, "1/sr", OVER2(theta, phi), H5, \
      "specular reflectance by direction") \
    A(detector, detector, none, BY_BATCH, ANY, none, ARRAY, "1", OVER1(detector), H5 | JSON, "detected") \
    A(detector_t, detector, gate, BY_BATCH, ANY, none, ARRAY, "1/ps", OVER2(detector, gate), H5, \
      "detected by time") \
    A(detector_t_later, detector, none, BY_BATCH, GATES, none, ARRAY, "1", OVER1(detector), H5 | JSON, \
      "detected later than all gates") \
    A(detector_path, detector, medium, BY_BATCH, ANY, none, MEANS, "cm", OVER2(detector, medium), H5, \
      "mean path of detected light by medium") \
    A(detector_interactions, detector, medium, BY_BATCH, ANY, none, MEANS, "1", OVER2(detector, medium), H5, \
      "mean interactions of detected light by medium") \
    A(detector_momentum, detector, medium, BY_BATCH, ANY, none, MEANS, "1", OVER2(detector, medium), H5, \
      "mean momentum transfer of detected light by medium") \
    A(detector_deepest, detector, none, BY_BATCH, ANY, none, MEANS, "cm", OVER1(detector), H5 | JSON, \
      "mean largest depth of detected light") \
    A(detector_map, detector_pixel, none, ONCE, OWNER, none, FIELD, "1/cm2", OVER1(detector), 0, \
      "detected by pixel") \
    A(Rd_xya, pixel, map_alpha, ONCE, OWNER, REFLECTED, FIELD, "1/(cm2 sr)", OVER3(y, x, alpha), 0, \
      "diffuse reflectance by angle") \
    A(Tt_xya, pixel, map_alpha, ONCE, OWNER, TRANSMITTED, FIELD, "1/(cm2 sr)", OVER3(y, x, alpha), 0, \
      "transmittance by angle") \
    A(A_xyz, voxel, none, BY_GROUP, OWNER, ABSORBED, FIELD, "1/cm3", OVER3(z_volume, y, x), 0, "absorption") \
    A(phi_xyz, inner_voxel, group, WHOLE, OWNER, none, FIELD, "1/cm2", OVER3(z_volume, y, x), 0, "fluence")

/* All arrays: those above, and others that are only parts of quantities. */
#define CML_ARRAYS(A) \
    CML_QUANTITY_ARRAYS(A) \
    A(totals, total, none, BY_BATCH, ANY, none, "of the launched weight") \
    A(terms, term, none, BY_BATCH, ANY, none, "of the balance, of rows") \
    A(moments, detector, moment, BY_BATCH, MEANS, none, "of which a result makes detector_path and the like") \
    A(expected, expected, none, BY_BATCH, ANY, none, "values, in a result in units of CML_EXPECTED_UNIT") \
    A(facets, facet, facet_score, BY_GROUP, OWNER, none, "scores; what escapes is kept once") \
    A(rows, row, none, WHOLE, ANY, none, "of a sweep, or scores (row_cells.h)")
/* clang-format on */

enum cml_cell_axis {
    CML_CELLS_none,
#define CML_CELL_AXIS(name) CML_CELLS_##name,
    CML_CELL_AXES(CML_CELL_AXIS)
#undef CML_CELL_AXIS
};

enum cml_array {
#define CML_ENUMERATOR(name, ...) CML_ARRAY_##name,
    CML_ARRAYS(CML_ENUMERATOR)
#undef CML_ENUMERATOR
        CML_NUM_ARRAYS
};

enum { CML_ARRAY_AXES = 2, CML_NO_TERM = -1 };

/* A row of the table of arrays. */
struct cml_array_info {
    const char *name;
    enum cml_cell_axis axis[CML_ARRAY_AXES]; /* slowest first */
    enum cml_spread spread;
    enum cml_array_when when;
    int term; /* enum cml_balance_term; CML_NO_TERM: none */
};
extern const struct cml_array_info cml_arrays[CML_NUM_ARRAYS];

/* The holders: blocks of cells that contain a set of arrays. */
enum cml_holder {
    CML_OF_TALLY,
    CML_OF_RESULT,
    CML_OF_PROFILES, /* sums of one batch that a thread adds to the result */
    CML_OF_ROW_BINS, /* bins of a row of a sweep, or of a score, for one batch */
    CML_OF_ROW_GRIDS /* grids of a row of a sweep, behind the bins of all batches */
};

/* True for a grid of radius, or of radius and depth, and another axis, which is kept by group of packets:
 * A_rz, Rd_ra, Rd_rt, phi_rzt and the like. */
static inline bool cml_is_grid_of_groups(enum cml_array array)
{
    const struct cml_array_info *info = &cml_arrays[array];
    return (info->axis[0] == CML_CELLS_r || info->axis[0] == CML_CELLS_place) &&
           info->axis[1] != CML_CELLS_none && info->spread == CML_KEPT_BY_GROUP;
}

/* The place of each array in a holder's block of cells. */
struct cml_layout {
    union {
        size_t at[CML_NUM_ARRAYS];
        struct {
#define CML_PLACE(name, ...) size_t name;
            CML_ARRAYS(CML_PLACE)
#undef CML_PLACE
        };
    };
    size_t size[CML_NUM_ARRAYS];          /* cells of one array in one part; 0: the array does not exist */
    size_t parts[CML_NUM_ARRAYS];         /* number of parts: groups, batches, or 2 for sums and squares */
    struct cml_once once[CML_NUM_ARRAYS]; /* distances between the parts of an array, in cells (balance.h) */
    size_t cells;                         /* number of cells of all arrays */
};
/* Returns the places of all arrays of a holder. */
struct cml_layout cml_layout_of(const struct cml_tally_grid *grid, enum cml_holder holder);

/* Returns the number of cells of an array in all its parts: groups, batches, or sums and squares. */
static inline size_t cml_layout_cells(const struct cml_layout *layout, enum cml_array array)
{
    return layout->size[array] * layout->parts[array];
}

/* The arrays of a holder in the order of its cells. */
struct cml_array_order {
    int count;
    const enum cml_array *array;
};
/* Returns the arrays of a holder in the order of their cells. */
struct cml_array_order cml_order_of(enum cml_holder holder);

/* The number of bins along an axis, and of extra cells before the first and behind the last bin. */
struct cml_extent {
    size_t bins, before, behind;
};
/* Returns the number of bins and extra cells along an axis, for a holder. */
struct cml_extent cml_extent_of(const struct cml_tally_grid *grid, enum cml_cell_axis axis,
                                enum cml_holder holder);

/* Returns the number of cells along an axis. */
static inline size_t cml_extent_cells(struct cml_extent extent)
{
    return extent.before + extent.bins + extent.behind;
}
