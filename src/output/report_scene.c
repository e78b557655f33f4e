/* Describes a scene in words, for results, before a run and in `check`. SPDX-License-Identifier: MIT */
#include "output/report_parts.h"

#include "scene/body/body_shape.h"
#include "scene/checksum.h"

#include <math.h>
#include <string.h>

/* Returns the name of a file without the scene's folder, which cml_path_beside has put in front of it. */
static const char *name_by_scene(const struct cml_scene *scene, const char *file)
{
    const char *slash = strrchr(scene->file, '/');
    const size_t folder = slash ? (size_t)(slash - scene->file) + 1 : 0;
    return strncmp(file, scene->file, folder) == 0 ? file + folder : file;
}

/* Prints the file at the end of a line, so that a program that compares lines may leave it out: the folder
 * may differ. */
static void print_file(FILE *stream, const struct cml_scene *scene, const char *file,
                       enum cml_report_reader reader)
{
    if (file) fprintf(stream, " from %s", reader == CML_READ_IN_H5 ? name_by_scene(scene, file) : file);
    fputc('\n', stream);
}

/* Prints the checksum of a shape, by which results of other shapes are told from this one. People have no use
 * for it. */
static void print_checksum(FILE *stream, uint32_t sum, enum cml_report_reader reader)
{
    if (reader != CML_READ_BY_PEOPLE) fprintf(stream, ", crc32 %08x", sum);
}

const char *cml_backing_word(enum cml_backing_kind kind)
{
    static const char *const words[] = {"", "mirror", "lambertian", "metal"};
    return words[kind];
}

/* Prints what an opaque surface is made of: "mirror, R = 0.5". */
static void print_opaque(FILE *stream, const struct cml_backing_def *backing)
{
    fprintf(stream, "%s, ", cml_backing_word(backing->kind));
    if (backing->kind == CML_BACKING_METAL)
        fprintf(stream, "index %.15g + %.15g i\n", backing->n, backing->k);
    else
        fprintf(stream, "R = %.15g\n", backing->R);
}

/* Names a medium by its number: 0 is above, then the layers, one below, and then the bodies. */
void cml_medium_name(const struct cml_scene *scene, int medium, char name[CML_MEDIUM_NAME])
{
    const int body = medium - scene->num_layers - 1;
    if (medium == 0 || body == 0)
        strcpy(name, medium == 0 ? "above" : "below");
    else
        snprintf(name, CML_MEDIUM_NAME, "%s %d", body > 0 ? "body" : "layer", body > 0 ? body : medium);
}

/* Prints the phase functions of all media that have one of their own, and the backing. People see the first
 * 20 (`most`) and how many more there are; files name all. */
void cml_report_phases(FILE *stream, const char *prefix, const struct cml_scene *scene,
                       enum cml_report_reader reader)
{
    const int most = 20, last = scene->num_layers + 1 + scene->num_bodies;
    int shown = 0;
    for (int m = 1; m <= last; m++) {
        const struct cml_phase *phase = scene->media[m].phase;
        if (!phase || (++shown > most && reader == CML_READ_BY_PEOPLE)) continue;
        char name[CML_MEDIUM_NAME];
        cml_medium_name(scene, m, name);
        fprintf(stream, "%sphase of %s: ", prefix, name);
        cml_phase_print(stream, phase, reader != CML_READ_BY_PEOPLE);
        print_file(stream, scene, phase->file, reader);
    }
    if (shown > most && reader == CML_READ_BY_PEOPLE)
        fprintf(stream, "%sand phase functions of %d more media\n", prefix, shown - most);
    if (scene->backing.kind != CML_BACKING_NONE) {
        fprintf(stream, "%sbacking: ", prefix);
        print_opaque(stream, &scene->backing);
    }
}

const char *cml_outline_word(bool round, const double size[2])
{
    return !round ? "rectangle" : size[0] == 0 ? "disk" : "ring";
}

/* Prints an outline and its place: "disk of radius 0.01 cm at (0 0". */
static void print_outline(FILE *stream, bool round, const double size[2], double x, double y)
{
    const bool disk = round && size[0] == 0;
    if (!disk) fprintf(stream, round ? "radii %.15g and " : "%.15g x ", size[0]);
    fprintf(stream, "%s%.15g cm at (%.15g %.15g", disk ? "radius " : "", size[1], x, y);
}

void cml_contact_name(const struct cml_scene *scene, int number, char name[CML_CONTACT_NAME])
{
    const struct cml_contact_def *contact = &scene->contacts[number - 1];
    int faces = 0;
    for (int k = 0; k < number; k++) faces += !scene->contacts[k].port;
    if (contact->port)
        snprintf(name, CML_CONTACT_NAME, "port %s", contact->name);
    else
        snprintf(name, CML_CONTACT_NAME, "face %d", faces);
}

static void report_contact(FILE *stream, const char *prefix, const struct cml_scene *scene, int k)
{
    const struct cml_contact_def *contact = &scene->contacts[k];
    const bool round = contact->shape == CML_DETECTOR_RING;
    char name[CML_CONTACT_NAME];
    cml_contact_name(scene, k + 1, name);
    fprintf(stream, "%s%s: ", prefix, name);
    if (contact->whole) {
        fputs("the whole plane, ", stream);
    } else {
        fprintf(stream, "%s of ", cml_outline_word(round, contact->size));
        print_outline(stream, round, contact->size, contact->x, contact->y);
        fputs(") cm, ", stream);
    }
    if (contact->port)
        fprintf(stream, "n = %.15g\n", contact->n);
    else
        print_opaque(stream, &contact->face);
}

void cml_report_top(FILE *stream, const char *prefix, const struct cml_scene *scene,
                    enum cml_report_reader reader)
{
    const int n = scene->num_contacts, most = 20, shown = reader == CML_READ_BY_PEOPLE && n > most ? most : n;
    for (int k = 0; k < shown; k++) report_contact(stream, prefix, scene, k);
    if (shown < n) fprintf(stream, "%sand %d more faces and ports\n", prefix, n - shown);
}

/* Prints the depths that a boundary spans: bins there are shared by two media. */
static void print_depths(FILE *stream, const struct cml_surface_def *def, enum cml_report_reader reader)
{
    if (reader != CML_READ_BY_PEOPLE)
        fprintf(stream, " (z = %.9g to %.9g cm)", def->depth + def->lowest, def->depth + def->highest);
}

/* Along each axis the closest point is 0 if the box contains 0. */
void cml_report_reach(const struct cml_body_surface *body, double *least, double *most)
{
    double closest[2], farthest[2];
    for (int i = 0; i < 2; i++) {
        closest[i] = fmax(0, fmax(body->lower[i], 0.0 - body->upper[i]));
        farthest[i] = fmax(0.0 - body->lower[i], body->upper[i]);
    }
    /* not hypot, whose last bits changed with glibc 2.35 */
    *least = sqrt(closest[0] * closest[0] + closest[1] * closest[1]);
    *most = sqrt(farthest[0] * farthest[0] + farthest[1] * farthest[1]);
}

/* Prints the depths and the distances from the z axis that the box around a body spans. */
static void print_extent(FILE *stream, const struct cml_body_surface *body, enum cml_report_reader reader)
{
    double least, most;
    if (reader == CML_READ_BY_PEOPLE) return;
    cml_report_reach(body, &least, &most);
    fprintf(stream, " (z = %.9g to %.9g cm, r = %.9g to %.9g cm)", body->depth + body->lower[2],
            body->depth + body->upper[2], least, most);
}

/* Prints the roughness of a surface, if it has any. */
static void print_roughness(FILE *stream, const struct cml_rough_def *rough)
{
    if (cml_is_rough(rough)) fprintf(stream, ", rough %s %.9g", cml_rough_word(rough->kind), rough->alpha);
}

/* Prints the medium around a body: "layer 2" or "body 3". */
static void print_host(FILE *stream, const struct cml_scene *scene, int host)
{
    const bool body = host > scene->num_layers;
    fprintf(stream, ", in %s %d", body ? "body" : "layer", body ? host - scene->num_layers - 1 : host);
}

/* Prints the form of a body with its place and size, or the parts of its mesh. */
static void print_shape(FILE *stream, const struct cml_scene_body *body, enum cml_report_reader reader)
{
    const double *c = body->centre, *e = body->end;
    fputs(cml_body_form_name(body->form), stream);
    if (body->form == CML_BODY_MESH) {
        fprintf(stream, " of %zu triangles", body->mesh.num_triangles);
        if (body->mesh.unite)
            fprintf(stream, ", the union of %zu parts", body->mesh.num_parts);
        else if (body->mesh.num_parts > 1)
            fprintf(stream, " in %zu parts, %zu of them cavities", body->mesh.num_parts,
                    body->mesh_notes.cavities);
        print_checksum(stream, cml_mesh_checksum(&body->mesh), reader);
    } else if (body->form == CML_BODY_SPHERE)
        fprintf(stream, " at (%g %g %g) cm, r = %g cm", c[0], c[1], c[2], body->radius);
    else
        fprintf(stream, " between (%g %g %g) and (%g %g %g) cm, r = %g cm", c[0], c[1], c[2], e[0], e[1],
                e[2], body->radius);
}

/* Prints a line with the shape, the surface, the place and the medium of body k. */
static void report_body(FILE *stream, const char *prefix, const struct cml_scene *scene,
                        const struct cml_body_surface *surface, int k, enum cml_report_reader reader)
{
    const struct cml_scene_body *body = &scene->bodies[k];
    const struct cml_medium_def *medium = &scene->media[cml_body_medium(scene, k)];
    fprintf(stream, "%sbody %d: ", prefix, k + 1);
    print_shape(stream, body, reader);
    if (body->form != CML_BODY_MESH && surface->kind == CML_SURFACE_MESH)
        fprintf(stream, ", as %llu triangles", (unsigned long long)surface->primitives);
    print_roughness(stream, &medium->rough);
    print_host(stream, scene, body->host);
    fprintf(stream, "; n %g, mua %g, mus %g 1/cm, g %g", medium->n, medium->mua, medium->mus, medium->g);
    print_extent(stream, surface, reader);
    print_file(stream, scene, body->file, reader);
}

/* Prints all bodies; for people only the first ones, because thousands of grains would hide the rest. */
static void report_bodies(FILE *stream, const char *prefix, const struct cml_scene *scene,
                          const struct cml_body_surfaces *surfaces, enum cml_report_reader reader)
{
    const int most = 20,
              shown = reader == CML_READ_BY_PEOPLE && scene->num_bodies > most ? most : scene->num_bodies;
    for (int k = 0; k < shown; k++) report_body(stream, prefix, scene, &surfaces->item[k], k, reader);
    if (shown < scene->num_bodies)
        fprintf(stream, "%sand %d more bodies\n", prefix, scene->num_bodies - shown);
}

/* Prints all boundaries and bodies as they are flown. The text is part of the .mco file, whose bytes must not
 * depend on the machine, so it has no measured times. */
void cml_report_shapes(FILE *stream, const char *prefix, const struct cml_scene *scene,
                       const struct cml_surface_set *surfaces, enum cml_report_reader reader)
{
    static const char *const unit_of[] = {"", "rings", "triangles"};
    for (int b = 0; b < surfaces->count; b++) {
        const struct cml_surface_def *def = &surfaces->item[b];
        const struct cml_boundary *boundary = &scene->boundaries[b];
        fprintf(stream, "%sboundary %d: %s at z = %g cm", prefix, b, cml_surface_kind_name(def->kind),
                def->depth);
        if (def->kind != CML_SURFACE_PLANE)
            fprintf(stream, ", %llu %s", (unsigned long long)def->primitives, unit_of[def->kind]);
        print_roughness(stream, &def->rough);
        fprintf(stream, " (%s)", def->reason);
        if (boundary->form != CML_FORM_PLANE) print_checksum(stream, cml_boundary_checksum(boundary), reader);
        if (def->kind != CML_SURFACE_PLANE) print_depths(stream, def, reader);
        print_file(stream, scene, boundary->file, reader);
    }
    report_bodies(stream, prefix, scene, &surfaces->bodies, reader);
}

const char *cml_light_word(enum cml_light_kind kind)
{
    static const char *const words[] = {"parallel", "na", "lambertian", "isotropic", "table"};
    return words[kind];
}

/* Prints the angular distribution of a beam's light. Nothing for parallel light, the usual case. */
static void report_light(FILE *stream, const struct cml_light *light)
{
    if (light->kind == CML_LIGHT_OF_PARALLEL) return;
    fprintf(stream, ", light %s%s", light->kind == CML_LIGHT_OF_TABLE ? "of a " : "",
            cml_light_word(light->kind));
    if (light->kind == CML_LIGHT_OF_NA) fprintf(stream, ":%g", light->na);
}

const char *cml_beam_word(enum cml_beam_shape kind)
{
    static const char *const words[] = {"pencil", "disk", "gaussian", "ring", "rectangle", "image"};
    return words[kind];
}

/* Prints the shape of a beam and its size in cm. */
static void report_beam_shape(FILE *stream, const struct cml_beam *beam)
{
    fprintf(stream, "beam %s", cml_beam_word(beam->shape));
    if (beam->shape == CML_BEAM_DISK || beam->shape == CML_BEAM_GAUSSIAN)
        fprintf(stream, " of radius %g cm", beam->size[0]);
    else if (beam->shape == CML_BEAM_RING)
        fprintf(stream, " of radii %g and %g cm", beam->size[0], beam->size[1]);
    else if (beam->shape != CML_BEAM_PENCIL)
        fprintf(stream, " of %g x %g cm", beam->size[0], beam->size[1]);
}

/* The checksum stands for an image or table that is too long to print. */
void cml_report_beam(FILE *stream, const char *prefix, const struct cml_scene *scene, int k,
                     const int *starts)
{
    const struct cml_beam *beam = &scene->beams[k];
    const double degrees = 180 / acos(-1.0);
    const bool files = beam->shape == CML_BEAM_IMAGE || beam->light.kind == CML_LIGHT_OF_TABLE;
    fputs(prefix, stream);
    report_beam_shape(stream, beam);
    fprintf(stream, " at (%g %g", beam->x, beam->y);
    if (beam->inside) fprintf(stream, " %g", beam->z);
    fprintf(stream, ") cm, angle %g, azimuth %g degrees", beam->angle * degrees, beam->azimuth * degrees);
    if (beam->port) fprintf(stream, ", from port %s", beam->port);
    report_light(stream, &beam->light);
    if (files) fprintf(stream, ", crc32 %08x", cml_beam_checksum(beam));
    if (scene->num_beams > 1) fprintf(stream, ", share %g", scene->shares[k]);
    fputs(beam->radial ? ", r about its place" : "", stream);
    if (starts && beam->inside) {
        char name[CML_MEDIUM_NAME];
        cml_medium_name(scene, starts[k], name);
        fprintf(stream, ", medium: %s", name);
    }
    fputc('\n', stream);
}

void cml_report_beams(FILE *stream, const char *prefix, const struct cml_scene *scene, const int *starts)
{
    for (int k = 0; k < scene->num_beams; k++)
        if (scene->beams[k].given) cml_report_beam(stream, prefix, scene, k, starts);
}

const char *cml_detector_word(const struct cml_detector_def *detector)
{
    if (detector->shape == CML_DETECTOR_MAP) return "map";
    if (detector->shape == CML_DETECTOR_GROUP) return "group";
    return cml_outline_word(cml_detector_is_round(detector), detector->size);
}

/* Prints a line with the number of members of a group. */
static void report_group(FILE *stream, const char *prefix, const struct cml_scene *scene, int k)
{
    int members = 0;
    for (int i = 0; i < cml_num_areas(scene); i++) members += scene->detectors[i].in_group == k + 1;
    fprintf(stream, "%sdetector %s: sum of %d detector%s, %s\n", prefix, scene->detectors[k].name, members,
            members == 1 ? "" : "s", scene->detectors[k].below ? "bottom" : "top");
}

/* Prints a line with the shape, the place and the acceptance of a detector. */
static void report_detector(FILE *stream, const char *prefix, const struct cml_detector_def *detector)
{
    const double degrees = 180 / acos(-1.0);
    fprintf(stream, "%sdetector %s: %s of ", prefix, detector->name, cml_detector_word(detector));
    if (detector->shape == CML_DETECTOR_MAP)
        fprintf(stream, "%d x %d pixels of ", detector->nx, detector->ny);
    print_outline(stream, cml_detector_is_round(detector), detector->size, detector->x, detector->y);
    fprintf(stream, " %.15g) cm, %s", detector->z, detector->below ? "bottom" : "top");
    if (detector->port) fprintf(stream, ", through port %s", detector->port);
    if (detector->aimed)
        fprintf(stream, ", na %.15g, angle %.15g, azimuth %.15g degrees", detector->na,
                detector->angle * degrees, detector->azimuth * degrees);
    fputs(detector->diffuse ? ", diffuse light" : "", stream);
    if (*detector->group) fprintf(stream, ", group %s", detector->group);
    fputc('\n', stream);
}

void cml_report_detectors(FILE *stream, const char *prefix, const struct cml_scene *scene,
                          enum cml_report_reader reader)
{
    const int n = scene->num_detectors, most = 20,
              shown = reader == CML_READ_BY_PEOPLE && n > most ? most : n;
    for (int k = 0; k < shown; k++)
        if (k < cml_num_areas(scene))
            report_detector(stream, prefix, &scene->detectors[k]);
        else
            report_group(stream, prefix, scene, k);
    if (shown < n) fprintf(stream, "%sand %d more detectors\n", prefix, n - shown);
}
