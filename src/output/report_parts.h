/* Functions that the files report*.c share, private to them: they turn tallies into fields, and scenes into
 * words. SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/hdf5_file.h"
#include "output/files/vtk.h"
#include "output/report.h"

/* Returns the facets of a surface that is not a plane, except the last one, as faces in the scene's
 * coordinates (z down). A facet has *per_facet successive faces, because a ring is drawn as quadrangles. The
 * caller frees the arrays of *faces, also when memory runs out (CML_E_INPUT). */
CML_NODISCARD cml_status cml_drawn_faces_of_boundary(const struct cml_surface_def *def,
                                                     struct cml_faces *faces, size_t *per_facet,
                                                     struct cml_error *err);

/* The facet that a face of a drawing of bodies stands for. Bodies are drawn as triangles in the scene's
 * coordinates (z down). */
struct cml_body_face {
    int body;
    size_t facet; /* number of the facet, counted over all bodies */
    double area;  /* area of this facet, cm2 */
};
struct cml_body_faces {
    struct cml_faces faces;
    struct cml_body_face *face; /* [faces.num_faces] facet of each face */
};

/* Draws all bodies. The caller frees *drawn, also when memory runs out (CML_E_INPUT). */
CML_NODISCARD cml_status cml_drawn_faces_of_bodies(const struct cml_report *report,
                                                   struct cml_body_faces *drawn, struct cml_error *err);
void cml_drawn_faces_free(struct cml_body_faces *drawn);

/* Adds the fluxes of each body to the outcome: light that arrives at its surface from outside and from
 * inside, and leaves to either side. Adds nothing if facets are not tallied. */
CML_NODISCARD cml_status cml_report_body_fluxes(const struct cml_report *report, struct cml_outcome *outcome,
                                                struct cml_error *err);

/* Returns the least and the largest distance from the z axis of the box around a body, cm. */
void cml_report_reach(const struct cml_body_surface *body, double *least, double *most);

/* Return the word of a shape ("pencil", "disk" ...) and of a light ("parallel", "na" ...). */
const char *cml_beam_word(enum cml_beam_shape kind);
const char *cml_light_word(enum cml_light_kind kind);

/* An axis that owns its name. */
struct cml_named_axis {
    struct cml_axis axis;
    char name[64];
};

/* A list of fields, their sources and their axes; they point to each other, so nothing in it moves. */
struct cml_field_list {
    const struct cml_report *report;
    int num_fields;
    struct cml_field *fields;
    struct cml_field_source *sources; /* source of the field with the same number (report_fields.c) */
    struct cml_axis axis[CML_NUM_AXES];
    struct cml_named_axis *facet, *radius; /* [L + 1] axes of each boundary */
    struct cml_named_axis *pixel;          /* [num_detectors][2] x and y axes of detectors that are maps */
};

CML_NODISCARD cml_status cml_field_list_create(const struct cml_report *report, struct cml_field_list *list,
                                               struct cml_error *err);
void cml_field_list_free(struct cml_field_list *list);

/* Adds the tallied fields whose first axis is `first`, with standard errors where these are known. y: Rd_xy,
 * Tt_xy and, with angles, Rd_xya, Tt_xya. z_volume: A_xyz and phi_xyz. CML_AXIS_NONE: the light outside map
 * and volume. */
void cml_add_fields(struct cml_field_list *list, enum cml_axis_kind first);

/* Adds detector_NAME_map, with standard errors, for all detectors that are maps; only >= 0: for this detector
 * alone. */
void cml_add_detector_fields(struct cml_field_list *list, int only);

/* Adds the fields of bodies and, with `facets`, of all their facets. Adds nothing without bodies. */
void cml_add_body_fields(struct cml_field_list *list);

/* Adds the fields of every face in a drawing of bodies: the number of the body, and the light that the facet
 * received and sent. */
void cml_add_body_face_fields(struct cml_field_list *list, const struct cml_body_faces *drawn);

/* Adds irradiance and exitance of the facets of boundary b except the last one, each value `per_facet` times
 * in a row, under names that begin with `prefix`. A plane has fields along y and x, or none without a map. */
void cml_add_facet_fields(struct cml_field_list *list, int b, const char *prefix, size_t per_facet);

/* Adds the heights of a radial shape by radius, as the scene gives them. Shapes of more than 10,000 points
 * are left out: they would outgrow the results, and the .mci has them. */
void cml_add_shape_field(struct cml_field_list *list, int b, const char *prefix);

/* Adds irradiance and exitance of the last facet, the plane around boundary b, as shares of the launched
 * weight; and the areas of facets that are not pixels. */
void cml_add_outer_plane_fields(struct cml_field_list *list, int b, const char *prefix);

/* Makes report->outcome: the contents of the run's .mco and .h5, except for the fields. On failure it is
 * cleared. */
CML_NODISCARD cml_status cml_report_outcome(struct cml_report *report, struct cml_error *err);

/* Writes the scene into the outcome in words, for `reader`. */
CML_NODISCARD cml_status cml_report_words(struct cml_report *report, enum cml_report_reader reader,
                                          struct cml_error *err);

/* Writes the saved packets to the file `path`. */
CML_NODISCARD cml_status cml_report_write_saved(struct cml_report *report, const char *path,
                                                struct cml_error *err);
