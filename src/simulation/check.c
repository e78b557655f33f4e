/* SPDX-License-Identifier: MIT */
#include "simulation/check.h"

#include "scene/body/body_shape.h"
#include "simulation/beam_notes.h"

#include <math.h>
#include <stdlib.h>

enum { MOST_BODIES = 20 }; /* bodies printed at most */

void cml_print_memory(FILE *stream, const struct cml_options *options, const struct cml_scene *scene,
                      const struct cml_surface_set *surfaces)
{
    const struct cml_memory memory = cml_memory_of(options, scene, surfaces);
    const double mib = 1048576;
    fprintf(stream, "  memory: at most %.0f MiB (tallies %.3g MiB, writing %.3g MiB)\n", memory.most / mib,
            memory.tallies / mib, memory.output / mib);
}

/* Prints how a mesh was changed. Nothing if nothing was changed, as for a boundary or body that is no mesh.
 * owner: "boundary" or "body". */
static void print_mesh_repairs(FILE *stream, const char *owner, int number, const struct cml_mesh *mesh,
                               const struct cml_mesh_notes *notes)
{
    char name[32];
    snprintf(name, sizeof name, "%s %d", owner, number);
    if (notes->bent > 0)
        fprintf(stream,
                "    %s: %zu faces lie in no plane and were cut into triangles, corners up to %.3g "
                "cm off the face's mean plane\n",
                name, notes->bent, notes->bend);
    if (notes->joined > 0)
        fprintf(stream, "    %s: %zu corners were joined with others, up to %.3g cm away (weld=%g)\n", name,
                notes->joined, notes->join_distance, mesh->weld);
    if (notes->levelled > 0)
        fprintf(stream, "    %s: the mesh's border was levelled, its heights differed by %.3g cm\n", name,
                notes->levelled);
    if (notes->skirt > 0)
        fprintf(stream,
                "    %s: skirt of %g cm around the mesh to its border's mean height %g cm: %zu "
                "triangles, up to %.3g cm\n",
                name, mesh->skirt, 0.0 - mesh->z_border, notes->skirt, notes->skirt_rise);
}

void cml_print_repairs(FILE *stream, const struct cml_scene *scene)
{
    for (int b = 0; b <= scene->num_layers; b++)
        print_mesh_repairs(stream, "boundary", b, &scene->boundaries[b].mesh,
                           &scene->boundaries[b].mesh_notes);
    for (int k = 0; k < scene->num_bodies; k++)
        print_mesh_repairs(stream, "body", k + 1, &scene->bodies[k].mesh, &scene->bodies[k].mesh_notes);
}

/* Prints the media as the program understood them. The mean free path, 1 / (mua + mus), is the length to
 * compare grid and boundaries with. */
static void print_media(FILE *stream, const struct cml_scene *scene)
{
    fprintf(stream, "  %-8s %10s %10s %10s %10s %10s %12s\n", "medium", "n", "mua 1/cm", "mus 1/cm", "g",
            "d cm", "mfp cm");
    for (int m = 0; m <= scene->num_layers + 1; m++) {
        const struct cml_medium_def *medium = &scene->media[m];
        if (m == 0 || m > scene->num_layers) {
            fprintf(stream, "  %-8s %10g\n", m == 0 ? "above" : "below", medium->n);
            continue;
        }
        fprintf(stream, "  %-8d %10g %10g %10g %10g %10g %12g", m, medium->n, medium->mua, medium->mus,
                medium->g, medium->d, 1 / cml_medium_mut(medium));
        fprintf(stream, "%s%s\n", *cml_layer_name(scene, m) ? "  " : "", cml_layer_name(scene, m));
    }
    for (int k = 0; k < scene->num_bodies && k < MOST_BODIES; k++) {
        const struct cml_medium_def *medium = &scene->media[cml_body_medium(scene, k)];
        char name[24];
        snprintf(name, sizeof name, "body %d", k + 1);
        fprintf(stream, "  %-8s %10g %10g %10g %10g %10s %12g\n", name, medium->n, medium->mua, medium->mus,
                medium->g, "", 1 / cml_medium_mut(medium));
    }
}

/* Prints the heightmap that a mesh was made from, and how it was simplified. A skirt steeper than the scan
 * itself comes from a scan that is not level. */
static void print_heightmap(FILE *stream, const struct cml_heightmap_notes *notes)
{
    const struct cml_relief *relief = &notes->relief;
    fprintf(stream,
            "    heightmap of %d x %d heights, %g x %g cm apart: rms height %g cm, rms slope %g, peak to "
            "valley %g cm, mean %g cm\n",
            notes->nx, notes->ny, notes->dx, notes->dy, relief->rms, relief->slope_rms,
            relief->highest - relief->lowest, relief->mean);
    fprintf(stream,
            "    simplified to %zu of %zu triangles, height error <= %.3g cm (tolerance %.3g cm), rms slope "
            "error %.3g\n",
            notes->triangles, 2 * notes->cells, notes->height_error, notes->tolerance, notes->slope_error);
    fprintf(stream, "    skirt of %g x %g cm around it to the rim's mean height %g cm: up to %.3g cm\n",
            notes->skirt[0], notes->skirt[1], notes->rim_mean, notes->rim_step);
}

/* Prints a mesh. One that is much wider or thinner than the layers was probably given in other units. */
static void print_mesh(FILE *stream, const struct cml_scene *scene, int b)
{
    const struct cml_boundary *boundary = &scene->boundaries[b];
    const struct cml_mesh *mesh = &boundary->mesh;
    struct cml_mesh_summary s;
    cml_mesh_summarise(mesh, &s);
    fprintf(stream, "  mesh of boundary %d: x %g..%g, y %g..%g, z %g..%g cm\n", b, mesh->lower[0],
            mesh->upper[0], mesh->lower[1], mesh->upper[1], boundary->z + mesh->lower[2],
            boundary->z + mesh->upper[2]);
    fprintf(stream,
            "    box %g x %g x %g cm, rms height %g cm, peak to valley %g cm, rms slope %g, steepest %g\n",
            mesh->upper[0] - mesh->lower[0], mesh->upper[1] - mesh->lower[1], mesh->upper[2] - mesh->lower[2],
            s.z_rms, s.peak_to_valley, s.slope_rms, s.slope_max);
    fprintf(stream, "    %zu triangles, edges %g cm (median), %g cm (shortest)\n", mesh->num_triangles,
            s.edge_median, s.edge_min);
    if (boundary->map_notes.cells > 0) print_heightmap(stream, &boundary->map_notes);
    const struct cml_mesh_notes *notes = &boundary->mesh_notes;
    if (notes->welded + notes->degenerate + notes->unused + notes->flipped > 0)
        fprintf(
            stream,
            "    welded %zu bit-equal vertices, dropped %zu degenerate triangles and %zu unused vertices, "
            "turned %zu triangles\n",
            notes->welded, notes->degenerate, notes->unused, notes->flipped);
    print_mesh_repairs(stream, "boundary", b, mesh, notes);
    const double thickness = scene->boundaries[scene->num_layers].z;
    const double width = fmax(mesh->upper[0] - mesh->lower[0], mesh->upper[1] - mesh->lower[1]);
    if (width > 100 * thickness || s.peak_to_valley > thickness)
        fprintf(stream,
                "    warning: the mesh is %g cm wide and %g cm high over layers of %g cm: is units= right?\n",
                width, s.peak_to_valley, thickness);
    const double ulp = 1.2e-7 * width;
    if (ulp > 1e-4 * s.edge_min)
        fprintf(stream,
                "    warning: single precision resolves %g cm here, more than 1e-4 of the shortest edge\n",
                ulp);
}

/* Prints the tile of boundary b: its size, its heights and slopes, and the steps across its seams. */
static void print_tile(FILE *stream, const struct cml_scene *scene, int b)
{
    const struct cml_boundary *boundary = &scene->boundaries[b];
    const struct cml_heightmap *tile = &boundary->tile;
    const struct cml_tile_notes *notes = &boundary->tile_notes;
    const struct cml_relief *relief = &notes->relief;
    fprintf(stream,
            "  tile of boundary %d: %d x %d heights, %g x %g cm apart, %severy %g x %g cm over the whole "
            "plane\n",
            b, notes->nx, notes->ny, tile->dx, tile->dy,
            notes->mirrored ? "mirrored and repeated " : "repeated ", cml_tile_period(tile, 0),
            cml_tile_period(tile, 1));
    fprintf(stream, "    z %g..%g cm, rms height %g cm, rms slope %g, mean %g cm\n",
            boundary->z - relief->highest, boundary->z - relief->lowest, relief->rms, relief->slope_rms,
            relief->mean);
    if (notes->drawn.rms > 0)
        fprintf(stream,
                "    drawn: rms height %g cm, rms slope %g, correlation length %g cm, over a period\n",
                notes->drawn.rms, notes->drawn.slope, notes->drawn.length);
    fprintf(stream,
            "    largest step across the seam %.3g cm along x, %.3g cm along y; inside %.3g and %.3g cm\n",
            notes->seam[0], notes->seam[1], notes->inside[0], notes->inside[1]);
    fprintf(stream, "    the beam does not repeat\n");
}

/* Prints the box around a body, which shows wrong units or a wrong shift, and how its mesh was changed. */
static void print_body_box(FILE *stream, const struct cml_scene_body *body, int k)
{
    double lower[3], upper[3];
    cml_body_box(body, lower, upper);
    fprintf(stream, "  mesh of body %d: x %g..%g, y %g..%g, z %g..%g cm\n", k + 1, lower[0], upper[0],
            lower[1], upper[1], lower[2], upper[2]);
    print_mesh_repairs(stream, "body", k + 1, &body->mesh, &body->mesh_notes);
}

/* Prints a line about each boundary or body that is a mesh or a tile; of bodies only the first
 * MOST_BODIES. */
static void print_meshes(FILE *stream, const struct cml_scene *scene)
{
    for (int b = 0; b <= scene->num_layers; b++) {
        if (scene->boundaries[b].form == CML_FORM_TILE) print_tile(stream, scene, b);
        if (scene->boundaries[b].form == CML_FORM_MESH) print_mesh(stream, scene, b);
    }
    for (int k = 0; k < scene->num_bodies && k < MOST_BODIES; k++)
        if (scene->bodies[k].form == CML_BODY_MESH) print_body_box(stream, &scene->bodies[k], k);
}

/* a note is printed if shapes change a thickness by more than 1 part in this many */
enum { WORTH_A_NOTE = 100 };

/* Prints mean heights and thicknesses. A boundary whose mean is not at its nominal depth makes layers thicker
 * or thinner, which may matter more than its roughness. */
static void print_means(FILE *stream, const struct cml_scene *scene, const struct cml_mean_shapes *mean)
{
    for (int b = 0; b <= scene->num_layers; b++) {
        const enum cml_boundary_form form = scene->boundaries[b].form;
        if (form == CML_FORM_PLANE) continue;
        fprintf(stream, "  boundary %d: mean height %.6g cm", b, mean->height[b]);
        if (form == CML_FORM_TILE && mean->area[b] > 0)
            fprintf(stream, " over a period\n");
        else
            fprintf(stream, mean->area[b] > 0 ? " over its %.4g cm2\n" : "\n", mean->area[b]);
    }
    for (int l = 0; l < scene->num_layers; l++) {
        const double d = scene->media[l + 1].d, change = mean->thickness[l] / d - 1;
        if (!(fabs(change) > 1.0 / WORTH_A_NOTE)) continue;
        fprintf(
            stream,
            "  note: layer %d is %.6g cm thick in the mean, %.3g %% %s than its d; the flat scene of that "
            "volume: --ignore-heightfields --set layer%d.d=%.6g\n",
            l + 1, mean->thickness[l], 100 * fabs(change), change > 0 ? "more" : "less", l + 1,
            mean->thickness[l]);
    }
}

/* Prints which optional results the scene asks for, with their sizes: map, facets, fluence, directions,
 * saved packets, time gates. */
static void print_map(FILE *stream, const struct cml_scene *scene)
{
    const struct cml_map_def *map = &scene->map;
    if (map->nx > 0)
        fprintf(stream, "  map: nx %d x %g cm, ny %d x %g cm%s%s\n", map->nx, map->dx, map->ny, map->dy,
                map->angles ? ", na angle bins in each pixel" : "",
                map->volume ? ", and nz layers of voxels" : "");
    if (scene->facets) fprintf(stream, "  facets: irradiance and exitance of every boundary\n");
    if (scene->fluence.line)
        fprintf(stream, "  fluence: nr x nz bins of r and z%s%s\n", scene->fluence.times ? ", and gates" : "",
                map->volume ? ", and voxels" : "");
    if (scene->directions.nt > 0)
        fprintf(stream, "  directions: %d angles, %d azimuths\n", scene->directions.nt, scene->directions.np);
    if (scene->saved.limit) {
        const struct cml_saved_kind kind = {.limit = cml_most_saved(scene, scene->photons),
                                            .media =
                                                (size_t)scene->num_layers + 2 + (size_t)scene->num_bodies};
        fprintf(stream, "  photons: %s.photons.h5, at most %.0f row%s%s, %.3g MiB\n", scene->saved.name,
                (double)kind.limit, kind.limit == 1 ? "" : "s",
                scene->saved.detected ? " of what detectors see" : "", cml_saved_file_bytes(&kind) / 1048576);
    }
    if (scene->time.gates > 0)
        fprintf(stream, "  time: %d gates of %g ps%s\n", scene->time.gates,
                scene->time.end / scene->time.gates, scene->time.radii ? ", by radius, too" : "");
}

/* Prints what `check` has understood of a scene: media, grid, requests, shapes with accuracy and cost, and
 * memory. starts: the medium in which each beam starts; mean: mean heights and thicknesses. */
static void print_scene(FILE *stream, const struct cml_options *options, const struct cml_scene *scene,
                        const struct cml_surface_set *surfaces, const int *starts,
                        const struct cml_mean_shapes *mean)
{
    fprintf(stream, "%s (%s:%d): %.0f photons\n", scene->output, scene->file, scene->line,
            (double)scene->photons);
    print_media(stream, scene);
    fprintf(stream, "  grid: nz %d x %g cm, nr %d x %g cm, na %d\n", scene->nz, scene->dz, scene->nr,
            scene->dr, scene->na);
    print_map(stream, scene);
    cml_report_phases(stream, "  ", scene, CML_READ_BY_PEOPLE);
    cml_report_top(stream, "  ", scene, CML_READ_BY_PEOPLE);
    cml_report_detectors(stream, "  ", scene, CML_READ_BY_PEOPLE);
    cml_report_beams(stream, "  ", scene, starts);
    cml_report_shapes(stream, "  ", scene, surfaces, CML_READ_BY_PEOPLE);
    for (int b = 0; b <= scene->num_layers; b++) {
        const struct cml_surface_def *def = &surfaces->item[b];
        if (def->kind != CML_SURFACE_PLANE || def->expectation.bias > 0)
            fprintf(stream,
                    "  boundary %d: expected bias %.2g, about %.0f ns per query, built in %.3g s, %.3g MiB "
                    "with its bounds\n",
                    b, def->expectation.bias, def->expectation.query_ns, def->build_seconds,
                    def->bytes / 1048576);
    }
    print_meshes(stream, scene);
    print_means(stream, scene, mean);
    cml_print_memory(stream, options, scene, surfaces);
}

/* Computes the totals of the scene with planes in place of all shapes, to compare a run with before it is
 * flown. *known false: there are none, and *err says why. */
static cml_status solve_flat_twin(const struct cml_scene *scene, struct cml_exact *exact, bool *known,
                                  struct cml_error *err)
{
    const struct cml_exact_options little = {
        .tolerance = 1e-6, .most_work = CML_EXACT_LITTLE_WORK, .walks = CML_EXACT_FEW_WALKS};
    const cml_status status = cml_exact_scene(scene, NULL, &little, exact, err);
    *known = status == CML_OK;
    return status == CML_E_NUMERIC || scene->num_bodies > 0 || !cml_exact_knows(scene, 0) ? CML_OK : status;
}

/* Prints what `check` found out about a scene, for people or as JSON, with the exact totals of its flat twin
 * (planes in place of shapes) if adding-doubling can compute them. Memory is measured first, before those
 * totals take some. */
static cml_status show(FILE *stream, const struct cml_options *options, const struct cml_scene *scene,
                       const struct cml_surface_set *surfaces, const int *starts,
                       const struct cml_mean_shapes *mean, const struct cml_sweep_size *sweep,
                       struct cml_error *err)
{
    const double bytes = cml_memory_of(options, scene, surfaces).most;
    CML_AT_END(cml_exact_clear) struct cml_exact exact = {0};
    bool known = false;
    if (!options->json) print_scene(stream, options, scene, surfaces, starts, mean);
    cml_status status = solve_flat_twin(scene, &exact, &known, err);
    if (status == CML_OK && options->json)
        status = cml_report_check_json(stream, scene, surfaces, sweep, bytes, starts, mean,
                                       known ? &exact : NULL, err);
    else if (status == CML_OK && known)
        cml_report_flat_twin(stream, scene, &exact);
    else if (status == CML_OK)
        fprintf(stream, "  no totals of the flat scene: %s\n", err->text);
    return status;
}

cml_status cml_check_scene(FILE *stream, const struct cml_options *options, const struct cml_options *flown,
                           const struct cml_scene *scene, const struct cml_sweep_size *sweep,
                           struct cml_error *err)
{
    CML_AT_END(cml_surfaces_free) struct cml_surface_set surfaces = {0};
    CML_AT_END(cml_mean_shapes_clear) struct cml_mean_shapes mean = {0};
    CML_FREED int *starts = NULL; /* the medium that each beam starts in */
    CML_TRY(cml_choose_surfaces(options, scene, &surfaces, err));
    CML_TRY(cml_note_beam(scene, &surfaces, &starts, err));
    CML_TRY(cml_mean_shapes(scene, &surfaces, &options->surface, &mean, err));
    return show(stream, flown, scene, &surfaces, starts, &mean, sweep, err);
}
