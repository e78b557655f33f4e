/* How tallies become densities and fields: what the reports share. Private to report*.c.
 * SPDX-License-Identifier: MIT */
#ifndef CML_REPORT_PARTS_H
#define CML_REPORT_PARTS_H

#include "output/files/hdf5_file.h"
#include "output/files/result_names.h"
#include "output/files/vtk.h"
#include "output/report.h"

/* A profile that is kept batch by batch. */
struct cml_profile {
    const char *name, *units;
    const cml_u128 *batches; /* [64][n], or NULL when it is not tallied */
    int n;
    double width;                           /* of its bins, cm or rad */
    double (*measure)(double width, int i); /* of bin i, by which its weight is divided (scaling.h) */
};

#define CML_PROFILES 5
void cml_report_profiles(const struct cml_report *report, struct cml_profile profiles[CML_PROFILES]);

/* Standard error of bin i in the profile's units. */
double cml_profile_error(const struct cml_report *report, const struct cml_profile *profile, int i);

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

/* Where a field gets its values; which members count is the affair of its function. */
struct cml_field_source {
    const struct cml_report *report;
    const double *array;
    size_t stride; /* from one number of the array to the next */
    double number;
    struct cml_profile profile;
    const cml_u128 *cells, *squares;
    size_t na;    /* cells of a pixel */
    double scale; /* from share of the launched weight to what is written */
    const struct cml_surface_def *surface;
    size_t per_facet; /* successive values that belong to one facet */
    const struct cml_body_face *face;
};

/* A list of fields, their sources and their axes. Nothing in it moves. */
struct cml_field_list {
    const struct cml_report *report;
    int num_fields, capacity;
    struct cml_field *fields;         /* [capacity] */
    struct cml_field_source *sources; /* [capacity], of the field of the same number */
    struct cml_axis layer, body, body_facet, r, z, alpha, x, y, z_volume;
    struct cml_axis *facet;  /* [L + 1] */
    char (*facet_names)[32]; /* [L + 1] */
};

CML_NODISCARD cml_status cml_field_list_create(const struct cml_report *report, struct cml_field_list *list,
                                               struct cml_error *err);
void cml_field_list_free(struct cml_field_list *list);

/* Adds a field and returns its source to be filled in. No array grows, so that a field may point to its
 * source. */
struct cml_field_source *cml_add_field(struct cml_field_list *list, const char *name, const char *long_name,
                                       const char *units, cml_field_values *values);

/* The same of a name in the list of result_names.h. */
struct cml_field_source *cml_add_result_field(struct cml_field_list *list, const char *name,
                                              cml_field_values *values);

/* A field without axes, of unit 1. */
void cml_add_number_field(struct cml_field_list *list, const char *name, const char *long_name,
                          double number);

/* The standard errors of the field added last, NAME_se. */
struct cml_field_source *cml_add_error_field(struct cml_field_list *list, cml_field_values *values);

/* Axes of the field added last, slowest first; b and d may be NULL. */
void cml_field_along(struct cml_field_list *list, const struct cml_axis *a, const struct cml_axis *b,
                     const struct cml_axis *d);

/* n places, the first at `first`, `step` apart. */
struct cml_axis cml_field_bins(const char *name, const char *what, const char *units, int n, double first,
                               double step);

/* Values that are numbers already: of `array`, `stride` apart. */
void cml_field_array_values(const void *context, size_t begin, size_t count, double *out);

/* From units of weight to a share of one packet. */
double cml_field_per_photon(const struct cml_field_source *source);

/* Everything an .mco file holds, with standard errors. *mco must outlive the list. */
void cml_add_result_fields(struct cml_field_list *list, const struct cml_mco *mco);

/* Rd_xy, Tt_xy, with angles Rd_xya, Tt_xya, and standard errors; nothing without a map. */
void cml_add_map_fields(struct cml_field_list *list);

/* A_xyz; nothing when it is not tallied. */
void cml_add_volume_fields(struct cml_field_list *list);

/* What lies outside map and volume. */
void cml_add_outside_fields(struct cml_field_list *list);

/* A_body, media of bodies, with `facets` irradiance and exitance of all their facets; nothing without bodies.
 */
void cml_add_body_fields(struct cml_field_list *list);

/* Of every face of a drawing: whose it is, and what its facet has received and sent. */
void cml_add_body_face_fields(struct cml_field_list *list, const struct cml_body_faces *drawn);

/* Irradiance and exitance of the facets of boundary b but the last one, each `per_facet` times in a row,
 * under names that begin with `prefix`; of a plane along y and x, and nothing without a map. */
void cml_add_facet_fields(struct cml_field_list *list, int b, const char *prefix, size_t per_facet);

/* The same of the last one: shares of the launched weight; and the areas of facets that are no pixels. */
void cml_add_outer_plane_fields(struct cml_field_list *list, int b, const char *prefix);

#endif
