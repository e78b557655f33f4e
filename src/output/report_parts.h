/* How tallies become fields: what the reports share. Private to report*.c.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/hdf5_file.h"
#include "output/files/vtk.h"
#include "output/report.h"

/* The facets but the last one, of a surface that is no plane, as faces in the scene's coordinates (z down);
 * for each facet `per_facet` of them one behind the other, because a ring is drawn as quadrangles. The caller
 * frees what they point to. */
CML_NODISCARD cml_status cml_report_faces(const struct cml_surface_def *def, struct cml_faces *faces,
                                          size_t *per_facet, struct cml_error *err);

/* Bodies drawn as triangles in the scene's coordinates (z down), and what each of these stands for. */
struct cml_body_face {
    int body;
    size_t facet; /* among those of all bodies */
    double area;  /* of that facet, cm2 */
};
struct cml_body_faces {
    struct cml_faces faces;
    struct cml_body_face *face; /* [faces.num_faces] */
};

/* CML_E_INPUT when memory runs out; then nothing is left to free. */
CML_NODISCARD cml_status cml_report_body_faces(const struct cml_report *report, struct cml_body_faces *drawn,
                                               struct cml_error *err);
void cml_report_body_faces_free(struct cml_body_faces *drawn);

/* What came to each body's surface from outside and from inside, and left it to either side; nothing without
 * facets. */
CML_NODISCARD cml_status cml_report_body_fluxes(const struct cml_report *report, struct cml_outcome *outcome,
                                                struct cml_error *err);

/* Distances from the z axis between which the box around a body lies, cm. */
void cml_report_reach(const struct cml_body_surface *body, double *least, double *most);

/* "pencil", "parallel" ... */
const char *cml_beam_word(enum cml_beam_shape kind);
const char *cml_light_word(enum cml_light_kind kind);

/* An axis with a name of its own. */
struct cml_named_axis {
    struct cml_axis axis;
    char name[64];
};

/* A list of fields, their sources and their axes. Nothing in it moves. */
struct cml_field_list {
    const struct cml_report *report;
    int num_fields;
    struct cml_field *fields;
    struct cml_field_source *sources; /* of the field of the same number (report_fields.c) */
    struct cml_axis axis[CML_NUM_AXES];
    struct cml_named_axis *facet, *radius; /* [L + 1] of every boundary */
    struct cml_named_axis *pixel;          /* [num_detectors][2] of maps: x and y */
};

CML_NODISCARD cml_status cml_field_list_create(const struct cml_report *report, struct cml_field_list *list,
                                               struct cml_error *err);
void cml_field_list_free(struct cml_field_list *list);

/* The fields whose first axis is this one: of y Rd_xy, Tt_xy and, with angles, Rd_xya, Tt_xya; of z_volume
 * A_xyz and phi_xyz; of none what lies outside map and volume. With standard errors where these are known;
 * nothing that is not tallied. */
void cml_add_fields(struct cml_field_list *list, enum cml_axis_kind first);

/* detector_NAME_map of all detectors that are maps, or of number `only` if that is not below 0, with standard
 * errors. */
void cml_add_detector_fields(struct cml_field_list *list, int only);

/* Fields of what bodies receive and send, with `facets` also of all their facets; nothing without bodies. */
void cml_add_body_fields(struct cml_field_list *list);

/* Fields of every face of a drawing of bodies: whose it is, and what its facet has received and sent. */
void cml_add_body_face_fields(struct cml_field_list *list, const struct cml_body_faces *drawn);

/* Irradiance and exitance of the facets of boundary b but the last one, each `per_facet` times in a row,
 * under names that begin with `prefix`; of a plane along y and x, and nothing without a map. */
void cml_add_facet_fields(struct cml_field_list *list, int b, const char *prefix, size_t per_facet);

/* What the scene says of a radial shape: its heights by radius. Long ones are left out: they would outgrow
 * the results, and the .mci has them. */
void cml_add_shape_field(struct cml_field_list *list, int b, const char *prefix);

/* Irradiance and exitance of the last facet, the outer plane, as shares of the launched weight; and the areas
 * of facets that are no pixels. */
void cml_add_outer_plane_fields(struct cml_field_list *list, int b, const char *prefix);

/* Makes report->outcome: what an .mco or .h5 file holds of a run but its fields. On failure it is cleared. */
CML_NODISCARD cml_status cml_report_outcome(struct cml_report *report, struct cml_error *err);

/* Gives the outcome the words of the scene as `reader` wants them. */
CML_NODISCARD cml_status cml_report_words(struct cml_report *report, enum cml_report_reader reader,
                                          struct cml_error *err);

/* The packets that were saved, to `path`. */
CML_NODISCARD cml_status cml_report_write_saved(struct cml_report *report, const char *path,
                                                struct cml_error *err);
