/* The table of quantities: one row for each result of a run. Every reader and writer of results uses these
 * rows. Names, units and long names are those of .h5 files, and of sections of .mco files that MCML does not
 * have. SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/field.h"
#include "tally/array_table.h"

/* Estimators: the ways in which quantities are computed from the sums of a run (tally/result.h). scaling.h
 * gives the measures of bins that values are divided by. */
enum cml_estimator {
    CML_FROM_TOTAL,   /* share of the launched weight, with an error; sums: enum cml_total */
    CML_FROM_BALANCE, /* share of the launched weight; sums: enum cml_balance_term */
    CML_FROM_COUNT,   /* sum over packets; sums: enum cml_count */
    CML_FROM_RESIDUE, /* imbalance of the weight */
    CML_FROM_LOST,    /* number of lost packets */
    /* Absorption by layer, as a share of the launched weight, with errors; sums: an array by medium. */
    CML_FROM_LAYERS,
    CML_FROM_BODIES, /* absorption by body, with errors; sums: an array by medium */
    /* Cells of an array; with errors if the array is kept by batch or group, or with squares. */
    CML_FROM_ARRAY,
    /* Mean over the light that a detector has seen, from an array of moments, with errors; NaN if it has seen
     * none. */
    CML_FROM_MEANS,
    CML_FROM_EXPECTED, /* expected value of flat layers below all shapes, with an error */
    /* Derivative by mua of each medium inside, from scores (rule P17), with errors; NaN if not known. sums:
     * the enum cml_quantity that is derived. */
    CML_FROM_MUA,
    CML_FROM_MUS,    /* derivative by mus of each medium inside, from scores, with errors */
    CML_FROM_INPUT,  /* a number of the scene */
    CML_FROM_FACETS, /* sums over facets, filled in by code that knows the surfaces */
    CML_FROM_FACET,  /* a score of facets, computed piece by piece; sums: enum cml_facet_score */
    CML_FROM_FIELD,  /* cells of an array, computed piece by piece and never held as a whole */
};

/* Places where a quantity is written: as a data set of an .h5, as a key of JSON. The .mco has MCML's arrays
 * besides (mco.h). */
enum { CML_IN_H5 = 2, CML_IN_JSON = 4 };

/* Axes of quantities: name, long name, units. */
#define CML_AXES(X)                                                                                          \
    X(layer, "layer, from 1", "1")                                                                           \
    X(boundary, "boundary, from 0 above the first layer", "1")                                               \
    X(body, "body, from 1, in the order of the file", "1")                                                   \
    X(r, "distance from the z axis, middle of the bin", "cm")                                                \
    X(z, "depth, middle of the bin", "cm")                                                                   \
    X(alpha, "angle from the outward vertical, middle of the bin", "rad")                                    \
    X(detector, "detector, in the order of the file: each has numbers of its own", "1")                      \
    X(medium, "medium: 0 above, layers from 1, below, then bodies", "1")                                     \
    X(inside, "medium inside: layers from 1, then bodies", "1")                                              \
    X(gate, "time, middle of the gate", "ps")                                                                \
    X(theta, "angle of flight from the outward vertical, middle of the bin", "rad")                          \
    X(phi, "azimuth of flight, from x towards y, middle of the bin", "rad")                                  \
    X(x, "x, middle of the pixel", "cm")                                                                     \
    X(y, "y, middle of the pixel", "cm")                                                                     \
    X(z_volume, "depth, middle of the voxel", "cm")                                                          \
    X(body_facet, "facet of any body, from 0", "1")                                                          \
    X(facet, "triangle, or ring, from 0", "1")                                                               \
    X(radius, "distance from the axis of the shape", "cm")                                                   \
    X(face, "face", "1")                                                                                     \
    X(side, "arrives outside, inside, leaves outside, inside", "1")

/* clang-format off */
/* The derivatives of quantities by mua or mus. */
#define CML_DERIVATIVES(Q, x, by) \
    Q(dRd_d##x, "cm", by, CML_QUANTITY_Rd, OVER1(inside), H5 | JSON, "derivative of Rd by " #x) \
    Q(dA_d##x, "cm", by, CML_QUANTITY_A, OVER1(inside), H5 | JSON, "derivative of A by " #x) \
    Q(dTt_d##x, "cm", by, CML_QUANTITY_Tt, OVER1(inside), H5 | JSON, "derivative of Tt by " #x) \
    Q(dA_backing_d##x, "cm", by, CML_QUANTITY_A_backing, OVER1(inside), H5 | JSON, \
      "derivative of A_backing by " #x) \
    Q(dA_face_d##x, "cm", by, CML_QUANTITY_A_face, OVER1(inside), H5 | JSON, "derivative of A_face by " #x) \
    Q(dA_l_d##x, "cm", by, CML_QUANTITY_A_l, OVER2(layer, inside), H5, "derivative of A_l by " #x) \
    Q(dA_body_d##x, "cm", by, CML_QUANTITY_A_body, OVER2(body, inside), H5, "derivative of A_body by " #x) \
    Q(dRd_r_d##x, "1/cm", by, CML_QUANTITY_Rd_r, OVER2(r, inside), H5, "derivative of Rd_r by " #x) \
    Q(dRd_a_d##x, "cm/sr", by, CML_QUANTITY_Rd_a, OVER2(alpha, inside), H5, "derivative of Rd_a by " #x) \
    Q(dTt_r_d##x, "1/cm", by, CML_QUANTITY_Tt_r, OVER2(r, inside), H5, "derivative of Tt_r by " #x) \
    Q(dTt_a_d##x, "cm/sr", by, CML_QUANTITY_Tt_a, OVER2(alpha, inside), H5, "derivative of Tt_a by " #x) \
    Q(detector_d##x, "cm", by, CML_QUANTITY_detector, OVER2(detector, inside), H5, \
      "derivative of detected by " #x)

/* All quantities. Columns of Q: name, units, estimator, the sums that the estimator uses, axes (slowest
 * first), where it is written, long name. OF_ARRAY gets the rows of array_table.h, which have these columns,
 * too. */
#define CML_QUANTITIES(Q, OF_ARRAY) \
    Q(Rsp, "1", TOTAL, CML_TOTAL_SPECULAR, NUMBER, H5 | JSON, "specular reflectance") \
    Q(Rd, "1", TOTAL, CML_TOTAL_REFLECTED, NUMBER, H5 | JSON, "diffuse reflectance") \
    Q(A, "1", TOTAL, CML_TOTAL_ABSORBED, NUMBER, H5 | JSON, "absorbed fraction") \
    Q(Tt, "1", TOTAL, CML_TOTAL_TRANSMITTED, NUMBER, H5 | JSON, "transmittance") \
    Q(book_launched, "1", BALANCE, CML_BALANCE_LAUNCHED, NUMBER, H5, "launched") \
    Q(book_gained, "1", BALANCE, CML_BALANCE_GAINED, NUMBER, H5, "gained in roulette") \
    Q(book_specular, "1", BALANCE, CML_BALANCE_SPECULAR, NUMBER, H5, "specular (Rsp)") \
    Q(book_reflected, "1", BALANCE, CML_BALANCE_REFLECTED, NUMBER, H5, "reflected (Rd)") \
    Q(book_transmitted, "1", BALANCE, CML_BALANCE_TRANSMITTED, NUMBER, H5, "transmitted (Tt)") \
    Q(book_absorbed, "1", BALANCE, CML_BALANCE_ABSORBED, NUMBER, H5, "absorbed (A)") \
    Q(book_roulette, "1", BALANCE, CML_BALANCE_ROULETTE, NUMBER, H5, "lost in roulette") \
    Q(book_trapped, "1", BALANCE, CML_BALANCE_TRAPPED, NUMBER, H5, "trapped") \
    Q(book_lost, "1", BALANCE, CML_BALANCE_LOST, NUMBER, H5, "lost") \
    Q(book_overflow_r, "1", BALANCE, CML_BALANCE_OVERFLOW_R, NUMBER, H5, \
      "scored in the last r bin from beyond it") \
    Q(book_overflow_z, "1", BALANCE, CML_BALANCE_OVERFLOW_Z, NUMBER, H5, "absorbed below the last z bin") \
    Q(book_above, "1", BALANCE, CML_BALANCE_ABOVE, NUMBER, H5, "absorbed above z = 0") \
    Q(residue, "1", RESIDUE, 0, NUMBER, H5, "launched + gained - all fates, in 2^-31 packets") \
    Q(lost, "1", LOST, 0, NUMBER, H5, "packets lost to numerical failure") \
    Q(Rd_xy, "1/cm2", FIELD, CML_ARRAY_Rd_xya, OVER2(y, x), 0, "diffuse reflectance") \
    Q(Tt_xy, "1/cm2", FIELD, CML_ARRAY_Tt_xya, OVER2(y, x), 0, "transmittance") \
    Q(layer_n, "1", INPUT, 0, OVER1(layer), H5, "refractive index") \
    Q(layer_mua, "1/cm", INPUT, 0, OVER1(layer), H5, "absorption coefficient") \
    Q(layer_mus, "1/cm", INPUT, 0, OVER1(layer), H5, "scattering coefficient") \
    Q(layer_g, "1", INPUT, 0, OVER1(layer), H5, "anisotropy of scattering") \
    Q(layer_d, "cm", INPUT, 0, OVER1(layer), H5, "thickness") \
    CML_QUANTITY_ARRAYS(OF_ARRAY) \
    Q(body_n, "1", INPUT, 0, OVER1(body), H5, "refractive index") \
    Q(body_mua, "1/cm", INPUT, 0, OVER1(body), H5, "absorption coefficient") \
    Q(body_mus, "1/cm", INPUT, 0, OVER1(body), H5, "scattering coefficient") \
    Q(body_g, "1", INPUT, 0, OVER1(body), H5, "anisotropy of scattering") \
    Q(boundary_z_min, "cm", INPUT, 0, OVER1(boundary), H5, "depth of the highest point") \
    Q(boundary_z_max, "cm", INPUT, 0, OVER1(boundary), H5, "depth of the lowest point") \
    Q(body_z_min, "cm", INPUT, 0, OVER1(body), H5, "depth of the highest point of the box around the body") \
    Q(body_z_max, "cm", INPUT, 0, OVER1(body), H5, "depth of the lowest point of the box around the body") \
    Q(body_r_min, "cm", INPUT, 0, OVER1(body), H5, "least distance of the box around the body from the z axis") \
    Q(body_r_max, "cm", INPUT, 0, OVER1(body), H5, "largest distance of the box around the body from the z axis") \
    Q(height, "cm", FIELD, 0, OVER1(radius), 0, "height of the shape, up from the depth of its boundary; linear in between") \
    Q(A_body, "1", BODIES, CML_ARRAY_A_l, OVER1(body), H5, "absorption by body") \
    Q(A_body_t, "1/ps", BODIES, CML_ARRAY_A_lt, OVER2(body, gate), H5, "absorption by body and time") \
    Q(A_body_t_later, "1", BODIES, CML_ARRAY_A_lt_later, OVER1(body), H5, "absorption by body later than all gates") \
    Q(A_backing, "1", TOTAL, CML_TOTAL_BACKING, NUMBER, H5 | JSON, "kept by the backing") \
    Q(A_face, "1", TOTAL, CML_TOTAL_FACE, NUMBER, H5 | JSON, "kept by faces, or stopped on boundary 0") \
    Q(Tt_expected, "1", EXPECTED, 0, NUMBER, H5 | JSON, "transmittance, by what flat layers let through") \
    Q(A_l_expected, "1", EXPECTED, 0, OVER1(layer), H5 | JSON, \
      "absorption by layer, by what flat layers absorb; above them as counted") \
    CML_DERIVATIVES(Q, mua, MUA) \
    CML_DERIVATIVES(Q, mus, MUS) \
    Q(flux_body, "1", FACETS, 0, OVER2(body, side), H5 | JSON, \
      "weight at each body's surface: arrives outside, inside, leaves outside, inside") \
    Q(Rd_outside, "1", FIELD, CML_ARRAY_Rd_xya, NUMBER, 0, "diffuse reflectance outside the map") \
    Q(Tt_outside, "1", FIELD, CML_ARRAY_Tt_xya, NUMBER, 0, "transmittance outside the map") \
    Q(A_outside, "1", FIELD, CML_ARRAY_A_xyz, NUMBER, 0, "absorbed fraction outside the volume") \
    Q(body_of_facet, "1", INPUT, 0, OVER1(body_facet), 0, "body, from 1") \
    Q(body_area, "cm2", INPUT, 0, OVER1(body_facet), 0, "area of the facet") \
    Q(body_irradiance_outside, "1/cm2", FACET, CML_FACET_IRRADIANCE_ABOVE, OVER1(body_facet), 0, "irradiance from outside the body") \
    Q(body_irradiance_inside, "1/cm2", FACET, CML_FACET_IRRADIANCE_BELOW, OVER1(body_facet), 0, "irradiance from inside the body") \
    Q(body_exitance_outside, "1/cm2", FACET, CML_FACET_EXITANCE_ABOVE, OVER1(body_facet), 0, "radiant exitance out of the body") \
    Q(body_exitance_inside, "1/cm2", FACET, CML_FACET_EXITANCE_BELOW, OVER1(body_facet), 0, "radiant exitance into the body") \
    Q(irradiance_above, "1/cm2", FACET, CML_FACET_IRRADIANCE_ABOVE, OVER1(facet), 0, "irradiance from the medium above") \
    Q(irradiance_below, "1/cm2", FACET, CML_FACET_IRRADIANCE_BELOW, OVER1(facet), 0, "irradiance from the medium below") \
    Q(exitance_above, "1/cm2", FACET, CML_FACET_EXITANCE_ABOVE, OVER1(facet), 0, "radiant exitance into the medium above") \
    Q(exitance_below, "1/cm2", FACET, CML_FACET_EXITANCE_BELOW, OVER1(facet), 0, "radiant exitance into the medium below") \
    Q(Rd_facet, "1/cm2", FACET, CML_FACET_ESCAPED, OVER1(facet), 0, "diffuse reflectance by what it touched last") \
    Q(Tt_facet, "1/cm2", FACET, CML_FACET_ESCAPED, OVER1(facet), 0, "transmittance by what it touched last") \
    Q(area, "cm2", INPUT, 0, OVER1(facet), 0, "area of the facet")
/* clang-format on */

#define CML_ENUMERATOR(name, ...) CML_AXIS_##name,
enum cml_axis_kind { CML_AXIS_NONE, CML_AXES(CML_ENUMERATOR) CML_NUM_AXES };
#undef CML_ENUMERATOR
#define CML_ENUMERATOR(name, ...) CML_QUANTITY_##name,
enum cml_quantity { CML_QUANTITIES(CML_ENUMERATOR, CML_ENUMERATOR) CML_NUM_QUANTITIES };
#undef CML_ENUMERATOR

/* Numbers of quantities. The totals of every run come first, in the order of enum cml_total. The terms of the
 * balance are neighbours, and so are the numbers of a layer, in the order of an .mci line. */
enum { CML_TOTALS = 4, CML_BOOKS = 12, CML_LAYER_NUMBERS = 5, CML_QUANTITY_AXES = 3 };

/* A row of the table of quantities. */
struct cml_quantity_info {
    const char *name, *units, *long_name;
    enum cml_estimator estimator;
    size_t sums;                                /* the sums that the estimator uses */
    enum cml_axis_kind axis[CML_QUANTITY_AXES]; /* slowest first, CML_AXIS_NONE behind the last */
    unsigned where;                             /* CML_IN_H5, CML_IN_JSON, or both */
};
extern const struct cml_quantity_info cml_quantities[CML_NUM_QUANTITIES];

/* Makes a named axis of n bins, the first at `first`, `step` apart. */
struct cml_axis cml_quantity_axis(enum cml_axis_kind kind, size_t n, double first, double step);

/* True for fluence, whose sums are weight times length. */
static inline bool cml_quantity_is_fluence(enum cml_quantity quantity)
{
    return quantity >= CML_QUANTITY_phi_z && quantity <= CML_QUANTITY_phi_rzt_later;
}

/* True if each detector has a quantity of this kind under its own name (cml_outcome_key). */
static inline bool cml_quantity_is_of_detector(enum cml_quantity quantity)
{
    return cml_quantities[quantity].axis[0] == CML_AXIS_detector;
}

/* Returns the ending that results of a detector add to its name, as "_t" in detector_NAME_t; NULL: the name
 * has none. */
const char *cml_quantity_ending(const char *name);

/* Returns the quantity of a total of enum cml_total. */
enum cml_quantity cml_quantity_of_total(int total);

/* True if a scene has a total of enum cml_total. backed: the scene has a backing; faced: it has faces or
 * ports. */
static inline bool cml_has_total(int total, bool backed, bool faced)
{
    return total < CML_TOTALS || (total == (int)CML_TOTAL_BACKING ? backed : faced);
}

/* Sets the name, long name and units of a field. */
void cml_quantity_name(struct cml_field *field, enum cml_quantity quantity);

/* Makes `errors` the field of the standard errors of `of`: NAME_se along the same axes. `of` must stay in
 * place, because it refers to the name in `errors`. */
void cml_quantity_name_errors(struct cml_field *errors, struct cml_field *of);
