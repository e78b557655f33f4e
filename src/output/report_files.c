/* The files that a run leaves, and their contents. SPDX-License-Identifier: MIT */
#include "output/report_parts.h"

#include "base/array.h"
#include "base/atomic_file.h"
#include "base/text.h"
#include "result/h5.h"
#include "result/mco.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Returns the length of a path without its ending .mco or .h5. Capitals count as small letters, because on a
 * file system that does not distinguish them two runs would write the same file. */
static size_t stem_length(const char *path)
{
    const size_t length = strlen(path);
    if (length > 4 && strcasecmp(path + length - 4, ".mco") == 0) return length - 4;
    if (length > 3 && strcasecmp(path + length - 3, ".h5") == 0) return length - 3;
    return length;
}

/* True if the run has results, or shapes, for which an .mco has no place. */
static bool outgrows_mco(const struct cml_scene *scene, const struct cml_report_asks *asks)
{
    for (int b = 0; b <= scene->num_layers; b++)
        if (scene->boundaries[b].form != CML_FORM_PLANE) return true;
    return asks->scores || scene->map.nx > 0 || scene->facets || scene->time.gates > 0 ||
           scene->directions.nt > 0 || scene->fluence.line || scene->num_detectors > 0 ||
           scene->num_bodies > 0 || scene->backing.kind != CML_BACKING_NONE || scene->num_contacts > 0;
}

/* True if the run leaves an .h5 file. */
static bool wants_fields(const struct cml_scene *scene, const struct cml_report_asks *asks)
{
    return cml_hdf5_available() && (scene->format == 'B' || outgrows_mco(scene, asks));
}

/* Returns the options on which the set of written files depends. */
static struct cml_report_asks asks_of(const struct cml_tally_grid *grid)
{
    return (struct cml_report_asks){grid->absorption, grid->scores > 0 || grid->derivatives};
}

/* Makes the name of a file of a run. All files share one stem, whichever of them the user has named;
 * `suffix` makes the difference. */
cml_status cml_report_path(const char *path, const char *suffix, char **result, struct cml_error *err)
{
    return cml_text_format(result, "a path", err, "%.*s%s", (int)stem_length(path), path, suffix);
}

void cml_report_clear(struct cml_report *report)
{
    for (int i = 0; i < report->num_files; i++) free(report->files[i]);
    free(report->files);
    cml_outcome_clear(&report->outcome);
    report->num_files = 0;
    report->files = NULL;
}

/* ---- names of files ---- */

struct visit {
    const char *path;
    cml_report_file_function *each;
    void *context;
};

/* Calls the visitor for one file of the run. suffix: replaces the ending of the result's name; NULL: the
 * result itself. */
static cml_status visit(const struct visit *v, enum cml_report_content content, int of, const char *suffix,
                        struct cml_error *err)
{
    struct cml_report_file file = {content, of, v->path};
    CML_FREED char *name = NULL;
    if (suffix) CML_TRY(cml_report_path(v->path, suffix, &name, err));
    if (name) file.path = name;
    return v->each(v->context, &file, err);
}

/* Visits the file of saved packets, which lies beside the result under a name of its own. */
static cml_status visit_saved(const struct visit *v, const struct cml_scene *scene, struct cml_error *err)
{
    CML_FREED char *name = NULL;
    CML_TRY(cml_report_saved_path(scene, v->path, &name, err));
    const struct visit here = {name, v->each, v->context};
    return visit(&here, CML_FILE_SAVED, 0, NULL, err);
}

/* Visits the tables. With format B the .h5 replaces the .mco; with format A it stands beside an .mco that has
 * no place for everything. The .mco comes first, because users who need no pictures wait for it. */
static cml_status visit_tables(const struct visit *v, const struct cml_scene *scene,
                               const struct cml_report_asks *asks, struct cml_error *err)
{
    if (scene->format == 'A') CML_TRY(visit(v, CML_FILE_TABLE, 0, NULL, err));
    if (wants_fields(scene, asks)) CML_TRY(visit(v, CML_FILE_FIELDS, 0, ".h5", err));
    return scene->saved.limit ? visit_saved(v, scene, err) : CML_OK;
}

/* Visits a file for each boundary that is not a plane (facets of planes are in the map's image), and one for
 * the bodies. */
static cml_status visit_facets(const struct visit *v, const struct cml_scene *scene,
                               const struct cml_surface_set *surfaces, struct cml_error *err)
{
    for (int b = 0; b <= scene->num_layers; b++)
        if (!surfaces || surfaces->item[b].kind != CML_SURFACE_PLANE)
            CML_TRY(visit(v, CML_FILE_BOUNDARY, b, CML_TEXT(".boundary%d.vtp", b), err));
    return scene->num_bodies > 0 ? visit(v, CML_FILE_BODIES, 0, ".bodies.vtp", err) : CML_OK;
}

/* Calls `each` for every file that a run writes for this scene: tables, the surface map, the volume, maps of
 * detectors, facets. The one list serves writing, checking for old files, and --json. */
cml_status cml_report_each_file(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                const struct cml_report_asks *asks, const char *path,
                                cml_report_file_function *each, void *context, struct cml_error *err)
{
    const struct visit v = {path, each, context};
    if (cml_file_is_device(path)) /* nothing lies beside the result on a device like /dev/null */
        return visit(&v, CML_FILE_TABLE, 0, NULL, err);
    CML_TRY(visit_tables(&v, scene, asks, err));
    if (scene->map.nx > 0) CML_TRY(visit(&v, CML_FILE_MAP, 0, ".map.vti", err));
    if (scene->map.volume && (asks->absorption || scene->fluence.line))
        CML_TRY(visit(&v, CML_FILE_VOLUME, 0, ".volume.vti", err));
    for (int k = 0; k < scene->num_detectors; k++)
        if (scene->detectors[k].shape == CML_DETECTOR_MAP)
            CML_TRY(
                visit(&v, CML_FILE_DETECTOR, k, CML_TEXT(".detector_%s.vti", scene->detectors[k].name), err));
    return scene->facets ? visit_facets(&v, scene, surfaces, err) : CML_OK;
}

/* ---- contents of files ---- */

enum { PREFIX = 32 };

/* Begins the names of a boundary's fields with its number, because one file holds all boundaries. */
static void name_boundary(int b, char prefix[PREFIX])
{
    snprintf(prefix, PREFIX, "boundary%d_", b);
}

/* Collects all fields that the .h5 of a run contains: maps, voxels, light outside of them, detectors,
 * bodies, and what belongs to each boundary. */
static void fill_list(struct cml_field_list *list)
{
    char prefix[PREFIX];
    cml_add_fields(list, CML_AXIS_y);
    cml_add_fields(list, CML_AXIS_z_volume);
    cml_add_fields(list, CML_AXIS_NONE);
    cml_add_detector_fields(list, -1);
    cml_add_body_fields(list);
    for (int b = 0; b <= list->report->scene->num_layers; b++) {
        name_boundary(b, prefix);
        cml_add_facet_fields(list, b, prefix, 1);
        cml_add_outer_plane_fields(list, b, prefix);
        cml_add_shape_field(list, b, prefix);
    }
}

/* Lists what the .h5 has beside the outcome. The file names other files as the scene does. */
static cml_status begin_h5(struct cml_report *report, struct cml_field_list *list, struct cml_h5_more *more,
                           struct cml_error *err)
{
    CML_TRY(cml_report_words(report, CML_READ_IN_H5, err));
    CML_TRY(cml_field_list_create(report, list, err));
    fill_list(list);
    *more = (struct cml_h5_more){.input = report->scene->text,
                                 .field = list->fields,
                                 .num_fields = list->num_fields,
                                 .call = {report->command, report->scene->file}};
    return CML_OK;
}

/* Writes the .h5. Values are computed while they are written, so only the list of fields is in memory. */
static cml_status write_h5(struct cml_report *report, const char *path, struct cml_error *err)
{
    CML_AT_END(cml_field_list_free) struct cml_field_list list = {0};
    struct cml_h5_more more;
    CML_TRY(begin_h5(report, &list, &more, err));
    return cml_h5_write(path, &report->outcome, &more, err);
}

struct lists {
    struct cml_field_list list;
    struct cml_h5_fields fields;
};

cml_status cml_report_arrays(struct cml_report *report, struct cml_report_arrays *arrays,
                             struct cml_error *err)
{
    struct cml_h5_more more;
    struct lists *lists;
    *arrays = (struct cml_report_arrays){0};
    CML_TRY(cml_zeros(&lists, 1, sizeof *lists, "a list of arrays", err));
    arrays->lists = lists;
    CML_TRY(cml_report_outcome(report, err));
    CML_TRY(begin_h5(report, &lists->list, &more, err));
    CML_TRY(cml_h5_fields_create(&report->outcome, &more, &lists->fields, err));
    arrays->field = lists->fields.field;
    arrays->num_fields = lists->fields.count;
    arrays->num_attributes = cml_h5_attributes(&report->outcome, &more, arrays->attribute);
    return CML_OK;
}

void cml_report_arrays_clear(struct cml_report_arrays *arrays)
{
    struct lists *lists = arrays->lists;
    if (!lists) return;
    cml_h5_fields_free(&lists->fields);
    cml_field_list_free(&lists->list);
    free(lists);
    *arrays = (struct cml_report_arrays){0};
}

/* Fills the list with the fields of the map, and of the boundaries that are planes: facets of a plane are the
 * pixels of the map. */
static void fill_map(struct cml_field_list *list)
{
    const struct cml_surface_set *surfaces = list->report->surfaces;
    char prefix[PREFIX];
    cml_add_fields(list, CML_AXIS_y);
    for (int b = 0; b < surfaces->count; b++) {
        if (surfaces->item[b].kind != CML_SURFACE_PLANE) continue;
        name_boundary(b, prefix);
        cml_add_facet_fields(list, b, prefix, 1);
    }
}

/* Returns position and size of an image in the frame of the scene (z down). The image of a detector lies at
 * the depth that the detector is focused on. */
static struct cml_image image_of(const struct cml_scene *scene, const struct cml_report_file *file)
{
    const struct cml_map_def *map = &scene->map;
    const bool volume = file->content == CML_FILE_VOLUME;
    if (file->content != CML_FILE_DETECTOR)
        return (struct cml_image){
            .n = {(size_t)map->nx, (size_t)map->ny, volume ? (size_t)scene->nz : 0},
            .origin = {-0.5 * map->nx * map->dx, -0.5 * map->ny * map->dy, volume ? map->top : 0},
            .spacing = {map->dx, map->dy, scene->dz}};
    const struct cml_detector_def *d = &scene->detectors[file->of];
    return (struct cml_image){
        .n = {(size_t)d->nx, (size_t)d->ny, 0},
        .origin = {d->x - 0.5 * d->nx * d->size[0], d->y - 0.5 * d->ny * d->size[1], d->z},
        .spacing = {d->size[0], d->size[1], 1}};
}

/* Writes a .vti image of the surface map, the volume or one detector, whichever the file contains. */
static cml_status write_image(const struct cml_report *report, const struct cml_report_file *file,
                              const char *path, struct cml_error *err)
{
    const struct cml_image image = image_of(report->scene, file);
    CML_AT_END(cml_field_list_free) struct cml_field_list list = {0};
    CML_TRY(cml_field_list_create(report, &list, err));
    if (file->content == CML_FILE_MAP) fill_map(&list);
    if (file->content == CML_FILE_VOLUME) cml_add_fields(&list, CML_AXIS_z_volume);
    if (file->content == CML_FILE_DETECTOR) cml_add_detector_fields(&list, file->of);
    return cml_vti_write(path, report->identity, &image, list.fields, list.num_fields, err);
}

/* Writes the faces of a boundary that is not a plane, or of all bodies, and the light that they received. */
static cml_status write_faces(const struct cml_report *report, const struct cml_report_file *file,
                              const char *path, struct cml_error *err)
{
    const bool bodies = file->content == CML_FILE_BODIES;
    CML_AT_END(cml_field_list_free) struct cml_field_list list = {0};
    CML_AT_END(cml_drawn_faces_free) struct cml_body_faces drawn = {.face = NULL};
    size_t per_facet = 1;
    CML_TRY(bodies ? cml_drawn_faces_of_bodies(report, &drawn, err)
                   : cml_drawn_faces_of_boundary(&report->surfaces->item[file->of], &drawn.faces, &per_facet,
                                                 err));
    CML_TRY(cml_field_list_create(report, &list, err));
    if (bodies)
        cml_add_body_face_fields(&list, &drawn);
    else
        cml_add_facet_fields(&list, file->of, "", per_facet);
    return cml_vtp_write(path, report->identity, &drawn.faces, list.fields, list.num_fields, err);
}

/* Writes the .mco. Without the name of the program, cml_mco_write leaves out all sections that original MCML
 * does not have. */
static cml_status write_mco(const struct cml_report *report, const char *path, struct cml_error *err)
{
    const struct cml_report_asks asks = asks_of(&report->sums->grid);
    struct cml_outcome outcome = report->outcome;
    outcome.beside = outgrows_mco(report->scene, &asks);
    if (report->classic) outcome.program = NULL;
    return cml_mco_write(path, &outcome, err);
}

/* Writes one file of a run: which function does it depends on the file's content, such as .mco, .h5 or a
 * picture. */
static cml_status write_file(struct cml_report *report, const struct cml_report_file *file, const char *path,
                             struct cml_error *err)
{
    switch (file->content) {
    case CML_FILE_TABLE:
        return write_mco(report, path, err);
    case CML_FILE_FIELDS:
        return write_h5(report, path, err);
    case CML_FILE_SAVED:
        return cml_report_write_saved(report, path, err);
    case CML_FILE_MAP:
    case CML_FILE_VOLUME:
    case CML_FILE_DETECTOR:
        return write_image(report, file, path, err);
    case CML_FILE_BOUNDARY:
    case CML_FILE_BODIES:
        return write_faces(report, file, path, err);
    }
    return CML_OK;
}

/* Writes the next file, which is complete before another is begun. Counts the file even if writing fails: the
 * run then fails anyway. */
static cml_status write_next(void *context, const struct cml_report_file *file, struct cml_error *err)
{
    struct cml_report *report = context;
    CML_TRY(cml_array_grow(&report->files, (size_t)report->num_files, sizeof *report->files,
                           "a list of files", err));
    char **const name = &report->files[report->num_files];
    CML_TRY(cml_text_copy(file->path, name, err));
    report->num_files++;
    return write_file(report, file, *name, err);
}

cml_status cml_report_write(struct cml_report *report, const char *path, struct cml_error *err)
{
    const struct cml_report_asks asks = asks_of(&report->sums->grid);
    CML_TRY(cml_report_outcome(report, err));
    return cml_report_each_file(report->scene, report->surfaces, &asks, path, write_next, report, err);
}

/* Returns the bytes of the .h5 file, which is made in memory: at most the arrays before they are deflated.
 * Profiles have errors; so have the sum and each angle of a pixel, in single precision. A facet has five
 * scores with errors, an area and numbers; a body its medium and a line of text. Memory may be copied as it
 * grows while it is small. */
static double image_bytes(const struct cml_tally_grid *grid, double numbers)
{
    const double pixels = (double)grid->nx * grid->ny, mib = 1048576.0;
    const double voxels =
        pixels * grid->nz * (grid->volume * (grid->voxel_step ? 2 : 1) + 2 * grid->phi_volume);
    const double bytes = 2 * numbers * sizeof(double) +
                         4 * pixels * (1.0 + (grid->map_na > 1 ? grid->map_na : 0)) * sizeof(float) +
                         2 * (double)grid->detector_pixels * sizeof(float) + voxels * sizeof(float) +
                         80.0 * (double)grid->facets + 320.0 * grid->num_bodies;
    return 1.01 * bytes + fmin(bytes, 32 * mib);
}

/* Returns how many numbers all quantities that are held as whole arrays have together. Absorption by depth
 * always counts, because an .mco contains it even if it is not tallied. */
static double numbers_of(const struct cml_tally_grid *grid)
{
    const struct cml_layout layout = cml_layout_of(grid, CML_OF_RESULT);
    double numbers = grid->absorption ? 0 : ((double)grid->nr + 1) * grid->nz;
    for (int i = 0; i < CML_NUM_QUANTITIES; i++)
        if (cml_quantities[i].estimator >= CML_FROM_LAYERS && cml_quantities[i].estimator <= CML_FROM_MEANS)
            numbers += (double)layout.size[cml_quantities[i].sums];
    return numbers;
}

/* Sums the memory of the quantities in double precision with their errors, of the text of the .mco, and of
 * the buffers of the writers. A boundary or a body has a line in the .mco and one in the JSON record, and the
 * longer of the two counts. A growing stream in memory holds three times its text, which is doubled and
 * copied [glibc, libio/strops.c]. The text is held only once, so media and fluxes of bodies fit in as
 * well. */
double cml_report_bytes(const struct cml_scene *scene, const struct cml_tally_grid *grid)
{
    const double line_of_boundary = 250, line_of_body = 250;
    const double numbers = numbers_of(grid);
    const double line_of_detector = 250;
    const double text = 3 * (line_of_boundary * grid->num_layers + line_of_body * grid->num_bodies +
                             line_of_detector * grid->detectors);
    const struct cml_report_asks asks = asks_of(grid);
    const bool image = wants_fields(scene, &asks);
    const double rows = 1.01 * cml_saved_file_bytes(&grid->saved) + 8.0 * (double)grid->saved.limit;
    return 2 * numbers * sizeof(double) + text + 8.0 * 1048576 +
           fmax(image ? image_bytes(grid, numbers) : 0, rows);
}
