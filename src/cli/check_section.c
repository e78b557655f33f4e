/* The picture of `check`: a section through a scene along x, made of the scene's own numbers.
 * SPDX-License-Identifier: MIT */
#include "cli/command.h"

#include "output/report.h"
#include "plot/section.h"
#include "scene/body/body_shape.h"
#include "scene/section.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void take_in(double range[2], double low, double high)
{
    range[0] = fmin(range[0], low);
    range[1] = fmax(range[1], high);
}

/* Half the width of the shape along its own x. */
static double half_size(const struct cml_beam *beam)
{
    const double half[] = {
        0, beam->size[0], beam->size[0], beam->size[1], beam->size[0] / 2, beam->size[0] / 2};
    return half[beam->shape];
}

/* Across the beam, R; along x, more where the beam is slanted. */
static double half_width(const struct cml_beam *beam)
{
    const double ux = sin(beam->angle) * cos(beam->azimuth);
    return half_size(beam) / sqrt(1 - ux * ux);
}

/* All that is not a plane, of a tile one period, map and beam; the grid where there is nothing else. */
static void find_width(const struct cml_scene *scene, double x[2])
{
    const double map = scene->map.nx * scene->map.dx / 2;
    x[0] = INFINITY;
    x[1] = -INFINITY;
    for (int b = 0; b <= scene->num_layers; b++) {
        const struct cml_boundary *boundary = &scene->boundaries[b];
        const struct cml_radial *radial = &boundary->radial;
        if (boundary->form == CML_FORM_MESH) take_in(x, boundary->mesh.lower[0], boundary->mesh.upper[0]);
        if (boundary->form == CML_FORM_TILE)
            take_in(x, boundary->tile.x0, boundary->tile.x0 + cml_tile_period(&boundary->tile, 0));
        if (boundary->form == CML_FORM_RADIAL && radial->n > 1)
            take_in(x, -radial->r[radial->n - 1], radial->r[radial->n - 1]);
    }
    for (int k = 0; k < scene->num_bodies; k++) {
        double lower[3], upper[3];
        cml_body_box(&scene->bodies[k], lower, upper);
        take_in(x, lower[0], upper[0]);
    }
    if (map > 0) take_in(x, -map, map);
    if (!(x[1] > x[0])) take_in(x, -scene->nr * scene->dr, scene->nr * scene->dr);
    for (int k = 0; k < scene->num_beams; k++) {
        const struct cml_beam *beam = &scene->beams[k];
        const double wide = beam->inside ? half_size(beam) : half_width(beam);
        take_in(x, beam->x - wide, beam->x + wide);
    }
    const double margin = 0.06 * (x[1] - x[0]);
    take_in(x, x[0] - margin, x[1] + margin);
}

static void find_depths(const struct cml_boundary *boundary, double z[2])
{
    z[0] = z[1] = cml_outer_depth(boundary);
    if (boundary->form == CML_FORM_MESH)
        take_in(z, boundary->z + boundary->mesh.lower[2], boundary->z + boundary->mesh.upper[2]);
    if (boundary->form == CML_FORM_TILE)
        take_in(z, boundary->z - boundary->tile_notes.relief.highest,
                boundary->z - boundary->tile_notes.relief.lowest);
    for (int i = 0; boundary->form == CML_FORM_RADIAL && i < boundary->radial.n; i++)
        take_in(z, boundary->z - boundary->radial.h[i], boundary->z - boundary->radial.h[i]);
}

/* The depths of the picture: those of all bodies, and down to the last boundary, or to the last that lies no
 * deeper than twice the picture's width or the bodies: layers are often given as thick as the sea. */
static void find_depth(const struct cml_scene *scene, const double x[2], double z[2])
{
    const double width = x[1] - x[0];
    bool all = true;
    find_depths(&scene->boundaries[0], z);
    for (int k = 0; k < scene->num_bodies; k++) {
        double lower[3], upper[3];
        cml_body_box(&scene->bodies[k], lower, upper);
        take_in(z, lower[2], upper[2]);
    }
    const double reach = z[0] + 2 * fmax(width, z[1] - z[0]);
    for (int b = 1; b <= scene->num_layers; b++) {
        double depths[2];
        find_depths(&scene->boundaries[b], depths);
        if (depths[1] <= reach)
            take_in(z, depths[0], depths[1]);
        else
            all = false;
    }
    for (int k = 0; k < scene->num_beams; k++)
        if (scene->beams[k].inside) take_in(z, scene->beams[k].z, scene->beams[k].z);
    if (!all || !(z[1] > z[0])) z[1] += width / 2;
}

/* A backing stands in the place of the medium below, in as many letters as there is room for. */
static void label_backing(const struct cml_backing_def *backing, struct cml_section_label *label)
{
    char what[48];
    if (backing->kind == CML_BACKING_NONE) return;
    if (backing->kind == CML_BACKING_METAL)
        snprintf(what, sizeof what, "%.3g+%.3gi", backing->n, backing->k);
    else
        snprintf(what, sizeof what, "R = %.3g", backing->R);
    snprintf(label->text, sizeof label->text, "%s, %s", cml_backing_word(backing->kind), what);
}

static void label_media(const struct cml_scene *scene, struct cml_section_label *labels)
{
    const int last = scene->num_layers + 1;
    for (int m = 0; m <= last; m++) {
        struct cml_section_label *label = &labels[m];
        label->z_top = m > 0 ? cml_outer_depth(&scene->boundaries[m - 1]) : -INFINITY;
        label->z_bottom = m < last ? cml_outer_depth(&scene->boundaries[m]) : INFINITY;
        char name[CML_MEDIUM_NAME];
        cml_medium_name(scene, m, name);
        snprintf(label->text, sizeof label->text, "%s, n = %g", name, scene->media[m].n);
    }
    label_backing(&scene->backing, &labels[last]);
}

/* What beam k is, in words, without what the picture's axes say. */
static void describe_in_words(const struct cml_scene *scene, int k, char *text, size_t size)
{
    static const char *const kinds[] = {"pencil", "disk", "Gaussian", "ring", "rectangle", "image"};
    static const char *const lights[] = {"", ", na:", ", lambertian", ", isotropic",
                                         ", light of a table (rays: half its maximum)"};
    const struct cml_beam *beam = &scene->beams[k];
    const double degrees = 180 / acos(-1.0);
    FILE *out = fmemopen(text, size, "w");
    if (!out) return;
    if (scene->num_beams > 1) fprintf(out, "%d: ", k + 1);
    fputs(kinds[beam->shape], out);
    if (beam->shape == CML_BEAM_DISK || beam->shape == CML_BEAM_GAUSSIAN)
        fprintf(out, ", R = %g cm", beam->size[0]);
    else if (beam->shape == CML_BEAM_RING)
        fprintf(out, ", R = %g to %g cm", beam->size[0], beam->size[1]);
    else if (beam->shape != CML_BEAM_PENCIL)
        fprintf(out, ", %g x %g cm", beam->size[0], beam->size[1]);
    if (beam->angle > 0)
        fprintf(out, ", angle %g, azimuth %g", beam->angle * degrees, beam->azimuth * degrees);
    fputs(lights[beam->light.kind], out);
    if (beam->light.kind == CML_LIGHT_OF_NA) fprintf(out, "%g", beam->light.na);
    if (beam->y != 0) fprintf(out, ", at y = %g cm", beam->y);
    fclose(out);
}

/* Half of the largest intensity: tables end where hardly anything is left. */
static double half_angle(const struct cml_light *light)
{
    const double *t = light->t, *intensity = light->intensity;
    double half = 0;
    int last = light->rows - 1;
    for (int i = 0; i < light->rows; i++) half = fmax(half, intensity[i] / 2);
    while (intensity[last] < half) last--;
    if (last == light->rows - 1) return t[last];
    return t[last] +
           (t[last + 1] - t[last]) * (intensity[last] - half) / (intensity[last] - intensity[last + 1]);
}

/* Describes beam k for the picture; medium: the one that its middle starts in. */
static void describe_beam(const struct cml_scene *scene, int k, int medium, struct cml_section_beam *drawn)
{
    const struct cml_beam *beam = &scene->beams[k];
    const double a = beam->angle, c = cos(beam->azimuth), half = half_size(beam);
    const bool table = beam->light.kind == CML_LIGHT_OF_TABLE;
    *drawn = (struct cml_section_beam){
        .x = beam->x,
        .slope = tan(a) * c,
        .half_width = beam->inside ? half : half_width(beam),
        .spread = table ? half_angle(&beam->light) : cml_light_widest(&beam->light, scene->media[medium].n),
        .inside = beam->inside,
        .z = beam->z,
        .axis = {sin(a) * c, cos(a)},
        .side = {half * cos(a) * c, -half * sin(a)}};
    describe_in_words(scene, k, drawn->text, sizeof drawn->text);
}

/* Pieces from `first` on are those of body k. */
static void describe_body(const struct cml_scene *scene, int k, const struct cml_cut *cut, size_t first,
                          struct cml_section_body *drawn)
{
    double x[2] = {INFINITY, -INFINITY}, z[2] = {INFINITY, -INFINITY};
    for (size_t i = first; i < cut->count; i++) {
        const double *piece = cut->piece[i];
        take_in(x, fmin(piece[0], piece[2]), fmax(piece[0], piece[2]));
        take_in(z, fmin(piece[1], piece[3]), fmax(piece[1], piece[3]));
    }
    *drawn = (struct cml_section_body){x[0], x[1], z[0], z[1], ""};
    snprintf(drawn->text, sizeof drawn->text, "body %d, n = %g", k + 1,
             scene->media[cml_body_medium(scene, k)].n);
}

/* Arrays of one element for each boundary and medium; behind the boundaries all bodies are one line. */
struct drawing {
    struct cml_cut *cuts;
    struct cml_section_line *lines;
    struct cml_section_label *labels;
    struct cml_section_beam *beams;
    const int *starts; /* media of the beams' middles */
    struct cml_section_body bodies[CML_SECTION_BODIES];
    int num_bodies;
};

/* Spheres and cylinders as meshes that look round. */
static cml_status cut_bodies(const struct cml_scene *scene, struct cml_cut *cut, struct drawing *drawing,
                             struct cml_error *err)
{
    const int sides = scene->num_bodies < 100 ? 64 : 16;
    for (int k = 0; k < scene->num_bodies; k++) {
        const struct cml_scene_body *body = &scene->bodies[k];
        const size_t first = cut->count;
        struct cml_mesh mesh;
        double lower[3], upper[3];
        cml_body_box(body, lower, upper);
        if (lower[1] > 0 || upper[1] < 0) continue;
        CML_TRY(cml_body_mesh(body, body->form == CML_BODY_SPHERE ? sides / 4 : sides, false, &mesh, err));
        const cml_status status = cml_section_add_body(&mesh, cut, err);
        cml_mesh_clear(&mesh);
        CML_TRY(status);
        if (cut->count > first && drawing->num_bodies < CML_SECTION_BODIES)
            describe_body(scene, k, cut, first, &drawing->bodies[drawing->num_bodies++]);
    }
    return CML_OK;
}

/* The shapes and where they come from, as many as a line or two hold. */
static void describe_boundaries(const struct cml_scene *scene, char *text, size_t size)
{
    size_t used = (size_t)snprintf(text, size, "Plane y = 0.");
    for (int b = 0, named = 0; b <= scene->num_layers && named <= 6; b++) {
        const struct cml_boundary *boundary = &scene->boundaries[b];
        const char *slash = boundary->file ? strrchr(boundary->file, '/') : NULL;
        const char *name = slash ? slash + 1 : boundary->file ? boundary->file : "heightfield";
        if (boundary->form == CML_FORM_PLANE) continue;
        if (named++ < 6)
            used += (size_t)snprintf(text + used, size - used, " Boundary %d: %.40s.", b, name);
        else
            used += (size_t)snprintf(text + used, size - used, " And others.");
    }
}

static cml_status cut_all(const struct cml_scene *scene, struct drawing *drawing, const double x[2],
                          struct cml_error *err)
{
    for (int b = 0; b <= scene->num_layers; b++) {
        CML_TRY(cml_section_cut(&scene->boundaries[b], x[0], x[1], &drawing->cuts[b], err));
        drawing->lines[b].count = drawing->cuts[b].count;
        drawing->lines[b].piece = (const double(*)[4])drawing->cuts[b].piece;
    }
    const int bodies = scene->num_layers + 1;
    CML_TRY(cut_bodies(scene, &drawing->cuts[bodies], drawing, err));
    drawing->lines[bodies].count = drawing->cuts[bodies].count;
    drawing->lines[bodies].piece = (const double(*)[4])drawing->cuts[bodies].piece;
    return CML_OK;
}

static cml_status draw_with(const struct cml_scene *scene, enum cml_picture picture, const char *path,
                            struct drawing *drawing, struct cml_error *err)
{
    const struct cml_map_def *map = &scene->map;
    double x[2], z[2];
    char caption[512], title[160];
    find_width(scene, x);
    find_depth(scene, x, z);
    CML_TRY(cut_all(scene, drawing, x, err));
    label_media(scene, drawing->labels);
    describe_boundaries(scene, caption, sizeof caption);
    snprintf(title, sizeof title, "%.120s, seen along y", scene->output);
    struct cml_section section = {.x_low = x[0],
                                  .x_high = x[1],
                                  .z_top = z[0],
                                  .z_bottom = z[1],
                                  .num_lines = scene->num_layers + (scene->num_bodies > 0 ? 2 : 1),
                                  .num_labels = scene->num_layers + 2,
                                  .lines = drawing->lines,
                                  .labels = drawing->labels,
                                  .map_low = -map->nx * map->dx / 2,
                                  .map_high = map->nx * map->dx / 2,
                                  .title = title,
                                  .caption = caption,
                                  .picture = picture};
    section.num_bodies = drawing->num_bodies;
    section.body = drawing->bodies;
    section.num_beams = scene->num_beams;
    section.beam = drawing->beams;
    for (int k = 0; k < scene->num_beams; k++)
        describe_beam(scene, k, drawing->starts[k], &drawing->beams[k]);
    snprintf(section.map_text, sizeof section.map_text, "map, %d x %d pixels of %g x %g cm", map->nx, map->ny,
             map->dx, map->dy);
    return cml_gnuplot_draw(cml_section_script, &section, path, err);
}

static cml_status draw_scene(const struct cml_scene *scene, const int *starts, enum cml_picture picture,
                             const char *path, struct cml_error *err)
{
    const size_t boundaries = (size_t)scene->num_layers + 1;
    struct drawing drawing = {.cuts = calloc(boundaries + 1, sizeof *drawing.cuts),
                              .lines = calloc(boundaries + 1, sizeof *drawing.lines),
                              .labels = calloc(boundaries + 1, sizeof *drawing.labels),
                              .beams = calloc((size_t)scene->num_beams, sizeof *drawing.beams),
                              .starts = starts};
    cml_status status = CML_OK;
    if (drawing.cuts && drawing.lines && drawing.labels && drawing.beams)
        status = draw_with(scene, picture, path, &drawing, err);
    else
        status = cml_fail_memory(err, 100.0 * (double)boundaries, "a section");
    for (size_t b = 0; b <= boundaries && drawing.cuts; b++) cml_cut_clear(&drawing.cuts[b]);
    free(drawing.cuts);
    free(drawing.lines);
    free(drawing.labels);
    free(drawing.beams);
    return status;
}

cml_status cml_draw_section(const struct cml_options *options, const struct cml_scene_list *list,
                            const int *starts, enum cml_picture picture, struct cml_error *err)
{
    if (!options->output) return CML_OK;
    if (options->run > (uint64_t)list->count)
        return cml_fail(err, CML_E_INPUT, "--run %llu (expected 1 to %d, the runs of %s)",
                        (unsigned long long)options->run, list->count, options->operands[0]);
    CML_TRY(draw_scene(&list->scenes[options->run - 1], starts, picture, options->output, err));
    if (!options->quiet && !options->json) printf("  -> %s\n", options->output);
    return CML_OK;
}
