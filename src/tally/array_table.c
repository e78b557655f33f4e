/* SPDX-License-Identifier: MIT */
#include "tally/array_table.h"

enum { CML_BALANCE_none = CML_NO_TERM };

const struct cml_array_info cml_arrays[CML_NUM_ARRAYS] = {
#define ROW(name, first, second, spread, when, term, ...)                                                    \
    {#name, {CML_CELLS_##first, CML_CELLS_##second}, CML_KEPT_##spread, CML_IF_##when, CML_BALANCE_##term},
    CML_ARRAYS(ROW)};

/* ---- the order of arrays ----
 * The order of a result's arrays is the format of checkpoints. OpenCL devices have the first nine arrays of a
 * tally, and A_rz (kernels/device_layout.h). Maps come last in a tally, in the same order as in a result. */

/* clang-format off */
#define _(name) CML_ARRAY_##name
#define MAPS                                                                                                 \
    _(Rd_xya), _(Tt_xya), _(A_xyz), _(phi_xyz), _(facets), _(detector_map), _(Rd_dir), _(Tt_dir), _(Rsp_dir)

static const enum cml_array
    of_tally[] = {_(A_l), _(Rd_t), _(Tt_t), _(A_t), _(A_lt), _(detector), _(detector_t), _(moments),
                  _(expected), _(Rd_ra), _(Tt_ra), _(rows), _(A_rz), _(A_z), _(phi_rz), _(phi_rzt), _(Rd_rt), _(Tt_rt), MAPS},
    of_result[] = {_(Rd_ra), _(Tt_ra), _(A_rz), _(rows), MAPS, _(totals), _(Rd_r), _(Tt_r), _(Rd_a), _(Tt_a),
                   _(A_l), _(A_z), _(Rd_t), _(Rd_t_later), _(Tt_t), _(Tt_t_later), _(A_t), _(A_t_later), _(A_lt), _(A_lt_later),
                   _(detector), _(detector_t), _(detector_t_later), _(detector_path),
                   _(detector_interactions), _(detector_momentum), _(detector_deepest), _(expected), _(phi_rz), _(phi_z), _(phi_rzt), _(phi_rzt_later), _(Rd_rt), _(Rd_rt_later), _(Tt_rt), _(Tt_rt_later)},
    of_profiles[] = {_(totals), _(Rd_r), _(Tt_r), _(Rd_a), _(Tt_a), _(A_z), _(A_l), _(Rd_t), _(Tt_t), _(A_t), _(A_lt),
                     _(detector), _(detector_t), _(moments), _(expected)},
    of_row_bins[] = {_(terms), _(Rd_r), _(Tt_r), _(Rd_a), _(Tt_a), _(A_l), _(Rd_t), _(Tt_t), _(detector),
                     _(detector_t), _(moments), _(A_t), _(A_z)},
    of_row_grids[] = {_(Rd_ra), _(Tt_ra), _(A_rz), _(Rd_dir), _(Tt_dir), _(Rd_rt), _(Tt_rt)};

struct cml_array_order cml_order_of(enum cml_holder holder)
{
#define ORDER(list) {sizeof list / sizeof *list, list}
    static const struct cml_array_order orders[] = {[CML_OF_TALLY] = ORDER(of_tally),
                                                    [CML_OF_RESULT] = ORDER(of_result),
                                                    [CML_OF_PROFILES] = ORDER(of_profiles),
                                                    [CML_OF_ROW_BINS] = ORDER(of_row_bins),
                                                    [CML_OF_ROW_GRIDS] = ORDER(of_row_grids)};
    return orders[holder];
}

/* ---- sizes ---- */

static struct cml_extent bins(size_t n)
{
    return (struct cml_extent){n, 0, 0};
}

static size_t pixels_of(const struct cml_tally_grid *grid)
{
    return (size_t)grid->nx * (size_t)grid->ny;
}

struct cml_extent cml_extent_of(const struct cml_tally_grid *grid, enum cml_cell_axis axis,
                                enum cml_holder holder)
{
    const size_t beyond = holder != CML_OF_RESULT,
                 parts = holder == CML_OF_ROW_BINS ? CML_ROW_MOMENT_CELLS : CML_MOMENT_CELLS;
    switch (axis) {
    case CML_CELLS_none: return bins(1);
    case CML_CELLS_r: return (struct cml_extent){(size_t)grid->nr, 0, beyond};
    case CML_CELLS_z: return (struct cml_extent){(size_t)grid->nz, beyond, beyond};
    case CML_CELLS_alpha: return bins((size_t)grid->na);
    case CML_CELLS_place: return bins(grid->phi_times ? (size_t)grid->nr * (size_t)grid->nz : 0);
    case CML_CELLS_medium: return bins(cml_tally_media(grid));
    case CML_CELLS_gate: return (struct cml_extent){(size_t)grid->gates, 0, grid->gates ? beyond : 0};
    case CML_CELLS_theta: return bins((size_t)grid->nt);
    case CML_CELLS_phi: return bins((size_t)grid->np);
    case CML_CELLS_total: return bins(CML_NUM_TOTALS);
    case CML_CELLS_term: return bins(CML_NUM_BALANCE_TERMS);
    case CML_CELLS_detector: return bins((size_t)grid->detectors);
    case CML_CELLS_moment: return bins(parts * cml_tally_moments(grid));
    case CML_CELLS_expected: return bins((size_t)grid->scores);
    case CML_CELLS_pixel: return bins(grid->nx > 0 ? pixels_of(grid) + 1 : 0);
    case CML_CELLS_map_alpha: return bins((size_t)grid->map_na);
    case CML_CELLS_voxel: return bins(grid->volume ? pixels_of(grid) * (size_t)grid->nz + 1 : 0);
    case CML_CELLS_inner_voxel: return bins(grid->phi_volume ? pixels_of(grid) * (size_t)grid->nz : 0);
    case CML_CELLS_group: return bins(CML_NUM_GROUPS);
    case CML_CELLS_facet: return bins(grid->facets);
    case CML_CELLS_facet_score: return bins(CML_FACET_SCORES);
    case CML_CELLS_detector_pixel: return bins(grid->detector_pixels);
    case CML_CELLS_row: return bins(grid->row_cells);
    }
    return bins(0);
}

/* True if a holder has the arrays that exist under the condition `when`. A holder is a thread's tally, a
 * result, the profiles of batches, or a row of a sweep; rows have fewer arrays. */
static bool exists(const struct cml_tally_grid *grid, enum cml_array_when when, enum cml_holder holder)
{
    const bool rows = holder == CML_OF_ROW_BINS || holder == CML_OF_ROW_GRIDS,
               profiles = holder == CML_OF_PROFILES,
               timed = grid->absorption || (grid->row_times && !grid->rows);
    switch (when) {
    case CML_IF_ABSORPTION: return rows ? grid->row_depths : grid->absorption;
    case CML_IF_DEPTHS: return rows                    ? grid->row_depths
                               : holder == CML_OF_TALLY ? grid->depths
                                                        : grid->absorption || (profiles && grid->depths);
    case CML_IF_GATES: return grid->gates > 0;
    case CML_IF_TIMES: return rows ? grid->row_times : grid->gates > 0 && (timed || grid->depths);
    case CML_IF_MEDIUM_TIMES: return cml_has_medium_times(grid) && !rows;
    case CML_IF_RADII: return grid->radii && (holder != CML_OF_TALLY || !grid->of_thread);
    case CML_IF_MEANS: return !rows || grid->row_means;
    case CML_IF_FLUENCE: return grid->marks > 0;
    case CML_IF_OWNER: return holder != CML_OF_TALLY || !grid->of_thread;
    case CML_IF_ANY: return true;
    }
    return false;
}

/* Returns the number of cells of one array in one part; 0 if the array does not exist. Among the grids of
 * scores of derivatives only those of absorption exist. */
static size_t size_of(const struct cml_tally_grid *grid, const struct cml_array_info *info,
                      enum cml_holder holder)
{
    const bool scores = holder == CML_OF_ROW_GRIDS && grid->derivatives;
    if (!exists(grid, info->when, holder) || (scores && info->when != CML_IF_ABSORPTION)) return 0;
    return cml_extent_cells(cml_extent_of(grid, info->axis[0], holder)) *
           cml_extent_cells(cml_extent_of(grid, info->axis[1], holder));
}

/* True if each group of packets has an array of its own (groups.h). */
static bool is_by_group(const struct cml_tally_grid *grid, const struct cml_array_info *info)
{
    switch (info->axis[0]) {
    case CML_CELLS_place: return true;
    case CML_CELLS_voxel: return grid->voxel_step > 0;
    case CML_CELLS_facet: return grid->facet_step > 0;
    case CML_CELLS_pixel: return grid->map_once.step > 0;
    case CML_CELLS_detector_pixel: return grid->pixel_once.step > 0;
    case CML_CELLS_theta: return grid->direction_once.step > 0;
    default: return info->when == CML_IF_RADII ? grid->gate_errors : grid->cell_errors;
    }
}

/* Returns how many copies of an array a holder keeps, from whose spread standard errors come: one for each
 * group or batch of photons, or 1. An array whose cells a packet reaches at most once (KEPT_ONCE) may
 * instead have 2 parts: sums and sums of squares. */
static size_t parts_of(const struct cml_tally_grid *grid, const struct cml_array_info *info,
                       enum cml_holder holder)
{
    const bool whole = holder == CML_OF_TALLY || holder == CML_OF_RESULT;
    switch (info->spread) {
    case CML_KEPT_ONCE: return is_by_group(grid, info) ? CML_NUM_GROUPS : 2; /* 2: sums and squares */
    case CML_KEPT_BY_GROUP: return whole && is_by_group(grid, info) ? CML_NUM_GROUPS : 1;
    case CML_KEPT_BY_BATCH: return holder == CML_OF_RESULT ? CML_NUM_BATCHES : 1;
    case CML_KEPT_AS_BATCHES: return CML_NUM_BATCHES;
    case CML_KEPT_WHOLE: return 1;
    }
    return 1;
}

/* clang-format on */

/* Returns the number of arrays, from this one on, that are stored together: one part of each array in
 * turn. */
static int num_together(const struct cml_array_order *order, int first)
{
    const struct cml_array_info *info = &cml_arrays[order->array[first]];
    int n = 1;
    while (info->spread == CML_KEPT_ONCE && first + n < order->count &&
           cml_arrays[order->array[first + n]].axis[0] == info->axis[0])
        n++;
    return n;
}

/* Arrays that are stored together (num_together) alternate: one part of each, then the next part of each. */
struct cml_layout cml_layout_of(const struct cml_tally_grid *grid, enum cml_holder holder)
{
    const struct cml_array_order order = cml_order_of(holder);
    struct cml_layout layout = {.cells = 0};
    for (int i = 0; i < order.count;) {
        const struct cml_array_info *info = &cml_arrays[order.array[i]];
        const int together = num_together(&order, i);
        const size_t size = size_of(grid, info, holder), parts = parts_of(grid, info, holder);
        const size_t step = (size_t)together * size;
        const bool squares = info->spread == CML_KEPT_ONCE && parts == 2;
        for (int k = 0; k < together; k++) {
            const enum cml_array array = order.array[i + k];
            layout.at[array] = layout.cells + (size_t)k * size;
            layout.size[array] = size;
            layout.parts[array] = parts;
            layout.once[array] = (struct cml_once){squares || parts == 1 ? 0 : step, step};
        }
        layout.cells += step * parts;
        i += together;
    }
    return layout;
}
