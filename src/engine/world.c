/* Makes the scene as the kernels read it (struct cml_world of kernels/types.h): media, boundaries, rings of
 * heightfields, depth bounds, beams and grids, from a scene and its surfaces.
 * SPDX-License-Identifier: MIT */
#include "engine/world_parts.h"

#include "cone.h"
#include "lattice.h"
#include "surface/bounds/cell_horizon.h"
#include "surface/bounds/ring_horizon_inl.h"
#include "surface/surface_facets.h"
#include "tally/row_cells.h"

#include <math.h>
#include <stdlib.h>

/* Returns a world in which only the numbers of rings and of pyramid cells of all boundaries are set: the
 * boundaries share one array for each. */
static struct cml_owned_world counted(const struct cml_surface_set *surfaces)
{
    struct cml_owned_world all = {0};
    for (int b = 0; b < surfaces->count; b++) {
        all.num_rings += (size_t)surfaces->item[b].num_rings;
        all.depth_cells += surfaces->item[b].depths.cells;
        all.horizon_cells += surfaces->item[b].depths.horizon_cells;
    }
    return all;
}

void cml_owned_world_free(struct cml_owned_world *to)
{
    cml_arrays_free(&to->arrays);
    free(to->detector_cells.start);
    free(to->detector_cells.list);
    free(to->contact_cells.start);
    free(to->contact_cells.list);
    *to = (struct cml_owned_world){0}; /* zeroed, so that a caller that frees the world again does no harm */
}

/* Allocates the arrays of boundaries and media that kernels read. Bodies count as boundaries here, since
 * both have surfaces. Rings belong to boundaries made of cones, depths and horizons to bounds of meshes. */
static cml_status allocate(const struct cml_surface_set *surfaces, struct cml_owned_world *to,
                           struct cml_error *err)
{
    const size_t boundaries = (size_t)surfaces->count + (size_t)surfaces->bodies.count, rings = to->num_rings;
    to->media = cml_arrays_add(&to->arrays, boundaries + 1, sizeof *to->media);
    to->surfaces = cml_arrays_add(&to->arrays, boundaries, sizeof *to->surfaces);
    to->rings = cml_arrays_add(&to->arrays, CML_RING_ROWS * rings, sizeof *to->rings);
    to->ring_starts = cml_arrays_add(&to->arrays, rings, sizeof *to->ring_starts);
    to->meshes = cml_arrays_add(&to->arrays, boundaries, sizeof *to->meshes);
    to->safe_cells = cml_arrays_add(&to->arrays, boundaries, sizeof *to->safe_cells);
    to->depths = cml_arrays_add(&to->arrays, 2 * to->depth_cells, sizeof *to->depths);
    to->horizons = cml_arrays_add(&to->arrays, 2 * to->horizon_cells, sizeof *to->horizons);
    return cml_arrays_check(&to->arrays, "the scene", err);
}

/* Returns an upper bound of the bytes of all phase tables, in double precision and in that of the kernels.
 * The number of cells with parts is known only when a table has been made. In a user's table all cells may
 * have parts; in those of other functions at most 130 cells had, so 150 are assumed. */
static double phase_bytes(const struct cml_scene *scene)
{
    double cells = 0;
    for (const struct cml_phase *phase = scene->phases; phase; phase = phase->next)
        cells +=
            CML_PHASE_CELLS + CML_PHASE_PARTS * (phase->kind == CML_PHASE_TABLE ? CML_PHASE_CELLS : 150.0);
    return fmin(cells, CML_MOST_PHASE_CELLS) *
           (sizeof(struct cml_phase_line) + sizeof(struct cml_phase_cell));
}

/* Boundaries and bodies have the same records, so they are counted together. */
double cml_world_bytes(const struct cml_scene *scene, const struct cml_surface_set *surfaces)
{
    const struct cml_owned_world all = counted(surfaces);
    const double bodies = surfaces->bodies.count, boundaries = surfaces->count + bodies,
                 cells = (double)all.depth_cells + (double)all.horizon_cells;
    return (boundaries + 1) * (sizeof(struct cml_medium) + sizeof(struct cml_surface) +
                               sizeof(struct cml_safe_cells) + sizeof(struct cml_mesh_surface *)) +
           (double)all.num_rings * (CML_RING_ROWS * sizeof(real) + sizeof(int)) + 2 * cells * sizeof(real) +
           bodies * sizeof(struct cml_body) +
           surfaces->bodies.tree.count * (double)sizeof(struct cml_body_node) +
           surfaces->bodies.grids.count * (double)sizeof(struct cml_body_grid) +
           (double)surfaces->bodies.grids.num_cells * sizeof(struct cml_body_cell) + phase_bytes(scene) +
           scene->num_contacts * (double)sizeof(struct cml_contact) + cml_source_bytes(scene);
}

/* Fills the media of layers and of the outside as kernels read them: optics, thickness (span), depth, and
 * depth in bins. */
static void copy_media(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                       struct cml_medium *media)
{
    for (int m = 0; m <= scene->num_layers + 1; m++) {
        const bool inside = m > 0 && m <= scene->num_layers;
        const double depth = surfaces->item[m > 0 ? m - 1 : 0].depth;
        cml_copy_optics(&scene->media[m], &media[m]);
        media[m].span = (real)(inside ? surfaces->item[m].depth - depth : 0);
        media[m].depth = (real)depth;
        media[m].bins = (real)(depth / scene->dz);
        media[m].body_grid = -1;
    }
}

/* Copies the rings of one surface into the columns of all rings; `first` is its first. Horizons are those of
 * the rings as rounded to `real`, because packets see this surface. Returns ring_start's parts per cm. */
static real copy_rings(const struct cml_surface_def *from, size_t first, struct cml_owned_world *to)
{
    const int n = from->num_rings;
    const size_t total = to->num_rings;
    int *start = to->ring_starts + first; /* serves as scratch for the horizons before it is filled */
    real *r = to->rings + first, *z = r + total, *slope = z + total, *above = slope + total,
         *below = above + total;
    for (int i = 0; i < n; i++) {
        r[i] = (real)from->r[i];
        z[i] = (real)from->z[i];
        slope[i] = (real)from->slope[i];
    }
    cml_ring_horizons(r, z, n, -1, start, above);
    cml_ring_horizons(r, z, n, 1, start, below);
    return cml_ring_starts(r, n, start);
}

/* Copies a roughness; one of 0 is smooth. */
static void set_roughness(const struct cml_rough_def *from, struct cml_rough *to)
{
    to->kind = cml_is_rough(from) ? (int)from->kind : CML_SMOOTH;
    to->alpha = (real)from->alpha;
}

/* Copies the roughness of all boundaries and bodies. */
static void copy_roughness(const struct cml_scene *scene, const struct cml_surface_set *from,
                           struct cml_owned_world *to)
{
    for (int b = 0; b < from->count; b++) set_roughness(&from->item[b].rough, &to->surfaces[b].rough);
    for (int k = 0; k < scene->num_bodies; k++)
        set_roughness(&scene->media[cml_body_medium(scene, k)].rough, &to->surfaces[from->count + k].rough);
}

/* Copies the boundaries into the form that kernels read, with the rings of those made of cones. `steepest`
 * is raised by more than rounding can turn a direction: a packet that leaves a surface more steeply must be
 * sure never to meet it again. */
static void copy_surfaces(const struct cml_surface_set *from, struct cml_owned_world *to)
{
    const size_t total = to->num_rings;
    size_t ring = 0;
    for (int b = 0; b < from->count; b++) {
        const struct cml_surface_def *def = &from->item[b];
        to->surfaces[b].kind = (int)def->kind;
        to->surfaces[b].above = b;
        to->surfaces[b].first_ring = (int)ring;
        to->surfaces[b].num_rings = def->num_rings;
        to->surfaces[b].lowest = (real)def->lowest;
        to->surfaces[b].highest = (real)def->highest;
        to->surfaces[b].steepest = (real)(1.00001 * def->steepest + 1e-6);
        to->meshes[b] = def->mesh;
        if (def->num_rings) to->surfaces[b].parts_per_cm = copy_rings(def, ring, to);
        ring += (size_t)def->num_rings;
    }
    to->world.ring_r = to->rings;
    to->world.ring_z = to->rings + total;
    to->world.ring_slope = to->rings + 2 * total;
    to->world.ring_horizon_above = to->rings + 3 * total;
    to->world.ring_horizon_below = to->rings + 4 * total;
    to->world.ring_start = to->ring_starts;
}

/* Numbers the facets of all boundaries and bodies in one sequence, in which each has a range. outer_facets
 * (top, bottom) stays empty for a plane, because the map of Rd or Tt already holds what escapes through its
 * pixels. */
static void set_facets(const struct cml_surface_set *from, const struct cml_map_def *map,
                       struct cml_owned_world *to)
{
    const int last = from->count - 1;
    int first = 0;
    for (int b = 0; b < from->count; b++) {
        struct cml_facet_range *range = &to->surfaces[b].facets;
        range->first = first;
        range->count = (int)cml_surface_facets(&from->item[b], map);
        first += range->count;
    }
    for (int k = 0; k < from->bodies.count; k++) {
        struct cml_facet_range *range = &to->surfaces[from->count + k].facets;
        range->first = first;
        range->count = (int)from->bodies.item[k].primitives;
        first += range->count;
    }
    if (from->item[0].kind != CML_SURFACE_PLANE) to->world.setup.outer_facets[0] = to->surfaces[0].facets;
    if (from->item[last].kind != CML_SURFACE_PLANE)
        to->world.setup.outer_facets[1] = to->surfaces[last].facets;
}

/* Copies the bounds of depth of all curved boundaries, one behind the other: pyramids of cells, each level
 * half as fine as the one before (kernels/bounds.h). */
static void copy_depths(const struct cml_surface_set *from, struct cml_owned_world *to)
{
    const size_t total = to->depth_cells;
    size_t first = 0;
    for (int b = 0; b < from->count; b++) {
        const struct cml_depth_map *map = &from->item[b].depths;
        struct cml_depth_bounds *depths = &to->surfaces[b].depths;
        int offset = 0;
        depths->form = (int)map->form;
        depths->size = map->size;
        depths->first = (int)first;
        depths->corner_x = (real)map->corner[0];
        depths->corner_y = (real)map->corner[1];
        depths->per_cell = (real)(map->cell[0] > 0 ? 1 / map->cell[0] : 0);
        depths->per_cell_y = (real)(map->cell[1] > 0 ? 1 / map->cell[1] : 0);
        for (int l = 0; l < map->levels; l++) {
            depths->level_offset[l] = offset;
            offset += (int)cml_depth_map_level_cells(map, l);
        }
        for (size_t i = 0; i < map->cells; i++) {
            to->depths[first + i] = map->deepest[i];
            to->depths[total + first + i] = map->highest[i];
        }
        first += map->cells;
    }
    to->world.deepest = to->depths;
    to->world.highest = to->depths + total;
}

/* Copies the horizons of all meshes into the arrays that kernels read. A horizon is a slope beyond which a
 * packet in a cell clears the rest of the mesh; seen from below first, from above behind. */
static void copy_horizons(const struct cml_surface_set *from, struct cml_owned_world *to)
{
    size_t first = 0;
    for (int b = 0; b < from->count; b++) {
        const struct cml_depth_map *map = &from->item[b].depths;
        to->surfaces[b].depths.first_horizon = (int)first;
        to->surfaces[b].depths.horizon_level = CML_HORIZON_LEVEL;
        for (size_t i = 0; i < map->horizon_cells; i++) {
            to->horizons[first + i] = map->horizon[0][i];
            to->horizons[to->horizon_cells + first + i] = map->horizon[1][i];
        }
        first += map->horizon_cells;
    }
    to->world.horizon_below = to->horizons;
    to->world.horizon_above = to->horizons + to->horizon_cells;
}

/* Copies for meshes that overhang how far each cell of space is from the mesh. The margin covers rounding,
 * also for packets that are outside the grid of cells by up to a safe distance;
 * samples/manual/physics/free-paths.md derives both of its terms. */
static void copy_safe_cells(const struct cml_surface_set *from, struct cml_owned_world *to)
{
    const double origin[3] = {from->origin.at[0], from->origin.at[1], 0};
    for (int b = 0; b < from->count; b++) {
        const struct cml_mesh_surface *mesh = from->item[b].mesh;
        const struct cml_safe_map *map = mesh ? cml_mesh_surface_map(mesh) : NULL;
        struct cml_safe_cells *cells = &to->safe_cells[b];
        if (!map) continue;
        double middle[3], corner[3], across = 0, farthest = (double)to->media[b].span;
        cml_mesh_surface_mesh(mesh, middle);
        for (int k = 0; k < 3; k++) {
            corner[k] = map->corner[k] + middle[k] - origin[k];
            across += map->n[k];
            farthest += fabs(corner[k]) + 2 * map->n[k] * map->cell;
        }
        cells->nx = map->n[0];
        cells->ny = map->n[1];
        cells->nz = map->n[2];
        cells->corner = cml_vec_of(corner[0], corner[1], corner[2]);
        cells->per_cell = (real)(1 / map->cell);
        cells->margin = (real)((double)CML_EPSILON * (32 * across + 160 * farthest / map->cell));
        cells->safe = map->safe;
    }
    to->world.safe_cells = to->safe_cells;
}

/* Returns a cell of a phase table in the precision of the kernels, for y between from and to. A cell that
 * rounding takes out of 0..2, so that the cosine would leave -1..1, gets its middle as a constant. */
static struct cml_phase_cell phase_cell_of(struct cml_phase_line line, double from, double to)
{
    const struct cml_phase_cell cell = {(real)line.start, (real)line.slope},
                                middle = {(real)(line.start + line.slope * (from + to) / 2), 0};
    const bool outside =
        CML_FMA(cell.slope, (real)from, cell.start) < 0 || CML_FMA(cell.slope, (real)to, cell.start) > 2;
    return outside && cell.slope >= 0 ? middle : cell;
}

/* Makes the tables of all tabulated and other non-standard phase functions, from which packets draw the
 * deflection. only_tables: no medium scatters by Henyey-Greenstein's function. */
static cml_status copy_phases(const struct cml_scene *scene, struct cml_owned_world *to,
                              struct cml_error *err)
{
    struct cml_phase_tables tables;
    if (!scene->phases) return CML_OK;
    CML_TRY(cml_phase_tables_create(scene->file, scene->phases, &tables, err));
    to->phase_cells = cml_arrays_add(&to->arrays, tables.count, sizeof *to->phase_cells);
    to->num_phase_cells = tables.count;
    for (size_t i = 0; to->phase_cells && i < tables.count; i++) {
        const bool whole = i < (size_t)(scene->phases->index + 1) * CML_PHASE_CELLS;
        const double from = whole ? 0 : (double)(i % CML_PHASE_PARTS) / CML_PHASE_PARTS;
        to->phase_cells[i] = phase_cell_of(tables.item[i], from, from + (whole ? 1 : 1.0 / CML_PHASE_PARTS));
    }
    free(tables.item);
    to->world.phase_cells = to->phase_cells;
    to->world.only_tables = 1;
    for (int m = 0; m < scene->num_layers + 2 + scene->num_bodies; m++)
        if (scene->media[m].mus > 0 && !scene->media[m].phase) to->world.only_tables = 0;
    return cml_arrays_check(&to->arrays, "phase functions", err);
}

/* Sets the grid of the surface map and the voxels for kernels; nx stays 0 if the scene asks for none. */
static void set_map(const struct cml_scene *scene, struct cml_map *map)
{
    const struct cml_map_def *def = &scene->map;
    if (def->nx == 0) return;
    map->nx = def->nx;
    map->ny = def->ny;
    map->na = def->angles ? scene->na : 1;
    map->per_dx = (real)(1 / def->dx);
    map->per_dy = (real)(1 / def->dy);
    map->half_x = (real)(0.5 * def->nx);
    map->half_y = (real)(0.5 * def->ny);
    map->top_bins = (real)(def->top / scene->dz);
}

/* Sets the time gates for kernels: their number, and gates per cm of optical path. */
static void set_gates(const struct cml_time_def *time, struct cml_gates *gates)
{
    if (time->gates == 0) return;
    gates->count = time->gates;
    gates->per_cm = (real)(time->gates / (time->end * CML_LIGHT_CM_PER_PS));
}

/* Sets the bins of directions for kernels: their numbers, and bins per radian. */
static void set_directions(const struct cml_directions_def *def, struct cml_direction_bins *bins)
{
    bins->nt = def->nt;
    bins->np = def->np;
    bins->per_dt = (real)(def->nt / 1.5707963267948966);
    bins->per_dp = (real)(def->np / 6.283185307179586);
}

/* Sets how fluence is scored: the spacing of marks along paths. The grid of r and z begins at depth 0, the
 * grid of voxels at its own top. */
static void set_marks(const struct cml_tally_grid *grid, const struct cml_map *map, struct cml_marks *marks)
{
    const real top = grid->phi_volume ? map->top_bins : 0;
    marks->top = top < 0 ? top : 0;
    marks->bottom = (real)grid->nz + (top > 0 ? top : 0);
    marks->spacing = (real)grid->marks;
    marks->per_spacing = grid->marks > 0 ? (real)(1 / grid->marks) : 0;
    marks->cells = ((cml_u32)grid->nr + 1) * ((cml_u32)grid->nz + 2);
}

/* Fills the tail of expected values (P15). The table of responses still belongs to the caller's options. */
static cml_status set_tail(const struct cml_scene *scene, const struct cml_flat_tail *from,
                           struct cml_owned_world *to, struct cml_error *err)
{
    if (!from) return CML_OK;
    const double n = scene->media[from->layer].n;
    to->tail_intervals = cml_arrays_add(&to->arrays, (size_t)from->intervals, sizeof *to->tail_intervals);
    CML_TRY(cml_arrays_check(&to->arrays, "layers", err));
    for (int k = 0; k < from->intervals; k++) {
        const double share = n / from->index[k], rest = (1 - share) * (1 + share);
        to->tail_intervals[k] = (struct cml_tail_interval){
            (real)(share * share), (real)rest, (real)(CML_FLAT_TAIL_CELLS / cml_flat_tail_widest(from, k))};
    }
    to->world.tail = (struct cml_tail){from->layer,  (real)from->z,      CML_FLAT_TAIL_CELLS,
                                       from->scores, to->tail_intervals, from->response};
    return CML_OK;
}

/* Fills the weight windows (P19): for each cell, the least weight of a packet, a third of the weight that
 * packets should have there. */
static cml_status set_windows(const struct cml_scene *scene, const double origin[2],
                              const struct cml_window_table *from, struct cml_owned_world *to,
                              struct cml_error *err)
{
    if (!from) return CML_OK;
    const size_t count = (size_t)from->cells * (size_t)from->rings, places = (size_t)from->places;
    to->lowest = cml_arrays_add(&to->arrays, count, sizeof *to->lowest);
    real *x = cml_arrays_add(&to->arrays, 2 * places, sizeof *x);
    CML_TRY(cml_arrays_check(&to->arrays, "weight windows", err));
    for (size_t i = 0; i < count; i++) to->lowest[i] = from->target[i] / 3;
    for (size_t k = 0; k < places; k++) {
        x[k] = (real)(from->place[k][0] - origin[0]);
        x[places + k] = (real)(from->place[k][1] - origin[1]);
    }
    to->world.windows = (struct cml_weight_windows){.cells = from->cells,
                                                    .rings = from->rings,
                                                    .places = from->places,
                                                    .per_bin = (real)(from->cells / from->depth * scene->dz),
                                                    .per_root = (real)(from->rings / sqrt(from->reach)),
                                                    .x = x,
                                                    .y = x + places,
                                                    .low = to->lowest};
    return CML_OK;
}

/* Returns the rule of roulette: the given one, or that of original MCML. */
static struct cml_roulette_rule roulette_of(const struct cml_roulette_options *options)
{
    const struct cml_roulette_rule given = {(cml_u32)(options->below * CML_WEIGHT_ONE),
                                            (cml_u32)(options->weight * CML_WEIGHT_ONE)},
                                   mcml = {(cml_u32)(1e-4 * CML_WEIGHT_ONE), 0};
    return options->below > 0 ? given : mcml;
}

/* Fills the setup: what does not depend on the packet, such as seed, options, grid and map. Bin widths
 * become their reciprocals, so that a bin is found by a multiplication. */
static void set_up(const struct cml_scene *scene, const double origin[2],
                   const struct cml_engine_options *options, struct cml_setup *setup)
{
    const struct cml_beam *beam = &scene->beams[0];
    *setup = (struct cml_setup){0};
    setup->stream.key[0] = (cml_u32)options->seed;
    setup->stream.key[1] = (cml_u32)(options->seed >> 32);
    setup->stream.key[2] = options->run;
    setup->roulette = roulette_of(&options->roulette);
    setup->stream.lattice = options->lattice ? CML_LATTICE_EVENTS : 0;
    setup->num_layers = scene->num_layers;
    setup->num_bodies = scene->num_bodies;
    setup->reentry = options->reentry;
    setup->tally_absorption = options->absorption;
    setup->nr = scene->nr;
    setup->nz = scene->nz;
    setup->na = scene->na;
    setup->per_dr = (real)(1 / scene->dr);
    setup->per_dz = (real)(1 / scene->dz);
    setup->per_da = (real)(scene->na / 1.5707963267948966);
    setup->backing = cml_backing_of(&scene->backing, scene->num_layers, scene->media[scene->num_layers].n);
    set_map(scene, &setup->map);
    set_gates(&scene->time, &setup->gates);
    set_directions(&scene->directions, &setup->directions);
    const struct cml_tally_grid grid = cml_engine_grid(scene, NULL, options);
    setup->keeps_paths =
        scene->time.gates > 0 || scene->num_detectors > 0 || grid.saved.limit > 0 || grid.rows > 0;
    set_marks(&grid, &setup->map, &setup->marks);
    setup->x0 = (real)origin[0];
    setup->y0 = (real)origin[1];
    setup->r0_x = beam->radial ? (real)(origin[0] - beam->x) : setup->x0;
    setup->r0_y = beam->radial ? (real)(origin[1] - beam->y) : setup->y0;
}

/* Makes the data of rows of a sweep that share a flight (P16): for each medium and row, by how much the
 * row's mua exceeds the flown one, and the share that a sampled interaction adds to A(z). */
static cml_status copy_rows(const struct cml_scene *scene, const struct cml_tally_grid *grid,
                            const struct cml_engine_rows *rows, struct cml_owned_world *to,
                            struct cml_error *err)
{
    const size_t media = cml_tally_media(grid), own = (size_t)rows->count, all = cml_row_stride(grid);
    if (own == 0) return CML_OK;
    to->row_more = cml_arrays_add(&to->arrays, media * all, sizeof *to->row_more);
    to->row_part = cml_arrays_add(&to->arrays, media * all, sizeof *to->row_part);
    to->row_most = cml_arrays_add(&to->arrays, media, sizeof *to->row_most);
    CML_TRY(cml_arrays_check(&to->arrays, "the rows", err));
    for (size_t m = 0; m < media; m++)
        for (size_t i = 0; i < own; i++) {
            const double more = rows->more[m * own + i];
            to->row_more[m * all + i] = (real)more;
            const real part = rows->depths ? (real)cml_engine_row_share(&scene->media[m], more) : 0;
            to->row_part[m * all + i] = part;
            if (part > to->row_most[m]) to->row_most[m] = part;
        }
    to->world.rows = (struct cml_rows){.count = (int)all, .more = to->row_more};
    to->world.rows.most = to->row_most;
    if (rows->depths) to->world.rows.part = to->row_part;
    return CML_OK;
}

/* Makes the scores for derivatives (P17). Each medium has two rows: one for mua, one for mus, in this order.
 * row_more: change per cm of path; row_hits: change per scattering. */
static cml_status make_scores(const struct cml_scene *scene, const struct cml_tally_grid *grid,
                              struct cml_owned_world *to, struct cml_error *err)
{
    const size_t media = cml_tally_media(grid), all = cml_row_stride(grid);
    to->row_more = cml_arrays_add(&to->arrays, media * all, sizeof *to->row_more);
    to->row_hits = cml_arrays_add(&to->arrays, media * all, sizeof *to->row_hits);
    CML_TRY(cml_arrays_check(&to->arrays, "the scores", err));
    for (int k = 0; k < scene->num_layers + scene->num_bodies; k++) {
        const int medium = cml_medium_inside(scene->num_layers, k);
        const size_t by_mua = (size_t)medium * all + 2 * (size_t)k, by_mus = by_mua + 1;
        to->row_more[by_mua] = (real)cml_score_unit(cml_medium_mut(&scene->media[medium]));
        to->row_more[by_mus] = -(real)scene->media[medium].mus;
        to->row_hits[by_mus] = 1;
    }
    to->world.rows = (struct cml_rows){.count = (int)all, .more = to->row_more, .hits = to->row_hits};
    return CML_OK;
}

/* Makes all parts of the world. Beams come after all surfaces, because the walk's own functions find the
 * medium in which a beam starts. */
static cml_status fill(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                       const struct cml_engine_options *options, struct cml_owned_world *to,
                       struct cml_error *err)
{
    const struct cml_tally_grid grid = cml_engine_grid(scene, surfaces, options);
    CML_TRY(allocate(surfaces, to, err));
    copy_media(scene, surfaces, to->media);
    CML_TRY(cml_copy_bodies(scene, surfaces, to, err));
    CML_TRY(copy_phases(scene, to, err));
    CML_TRY(set_tail(scene, options->tail, to, err));
    CML_TRY(set_windows(scene, surfaces->origin.at, options->windows, to, err));
    copy_surfaces(surfaces, to);
    copy_roughness(scene, surfaces, to);
    copy_depths(surfaces, to);
    copy_horizons(surfaces, to);
    copy_safe_cells(surfaces, to);
    to->world.media = to->media;
    to->world.surfaces = to->surfaces;
    to->world.meshes = to->meshes;
    to->world.intersect_mesh = cml_mesh_surface_hit;
    set_up(scene, surfaces->origin.at, options, &to->world.setup);
    if (scene->facets) set_facets(surfaces, &scene->map, to);
    CML_TRY(cml_set_contacts(scene, surfaces->origin.at, to, err));
    CML_TRY(cml_set_sources(scene, surfaces, options->start_as ? options->start_as : surfaces, to, err));
    CML_TRY(cml_set_detectors(scene, surfaces, options->windows, to, err));
    return grid.derivatives ? make_scores(scene, &grid, to, err)
                            : copy_rows(scene, &grid, &options->rows, to, err);
}

cml_status cml_owned_world_create(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                  const struct cml_engine_options *options, struct cml_owned_world *to,
                                  struct cml_error *err)
{
    *to = counted(surfaces);
    const cml_status status = fill(scene, surfaces, options, to, err);
    if (status != CML_OK) cml_owned_world_free(to);
    return status;
}

/* Makes a world only if a beam starts inside, or may be stopped, because all other beams start in medium 0.
 */
cml_status cml_source_media(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                            int **medium, double *stopped, struct cml_error *err)
{
    const struct cml_engine_options plain = {.lattice = true};
    CML_AT_END(cml_owned_world_free) struct cml_owned_world owned = {0};
    const bool asks = cml_scene_starts_inside(scene) || scene->num_contacts > 0;
    int passes;
    *medium = NULL;
    if (asks) CML_TRY(cml_owned_world_create(scene, surfaces, &plain, &owned, err));
    *medium = calloc((size_t)scene->num_beams, sizeof **medium);
    if (!*medium) return cml_fail_memory(err, scene->num_beams * 4.0, "the beams");
    for (int k = 0; asks && k < scene->num_beams; k++) {
        (*medium)[k] = cml_source_medium(&owned.world, &scene->beams[k]);
        if (stopped) stopped[k] = cml_stopped_share(&owned.world, k, &passes);
    }
    return CML_OK;
}
