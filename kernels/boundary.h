/* What kinds of boundaries, beams, detectors and backings there are, as the reader of a scene, the walk and
 * the reports of a result name them; a boundary's facets with what is scored on them. Knows no precision, so
 * that scenes and tallies can stand on it. SPDX-License-Identifier: MIT */
#pragma once

/* Cells of grids, maps, voxels, facets and directions are too many for 64 sums of each, those of the batches
 * (balance.h): their errors come from 16 groups of four batches, photon i in group i mod 16. */
#define CML_NUM_GROUPS 16

enum cml_surface_kind {
    CML_SURFACE_PLANE,
    CML_SURFACE_CONE, /* rings of capped cones about the z axis */
    CML_SURFACE_MESH,
    CML_SURFACE_AUTO,   /* the kind of no surface: asks the host to choose one */
    CML_SURFACE_SPHERE, /* of a body; a body may also be a closed CML_SURFACE_MESH */
    CML_SURFACE_CYLINDER,
};

/* What the bounds of a curved boundary's depth lie over, see bounds.h. */
enum cml_bounds_form {
    CML_BOUNDS_SQUARE, /* a square of the x-y plane and what is around it: a mesh */
    CML_BOUNDS_RADII,  /* the radius: rings */
    CML_BOUNDS_PERIOD, /* a rectangle that is repeated over the whole plane: a mesh that is */
};

/* How the starts of a beam's packets lie across its axis. */
enum cml_beam_shape {
    CML_BEAM_PENCIL,   /* in a point */
    CML_BEAM_DISK,     /* evenly */
    CML_BEAM_GAUSSIAN, /* its density falls as exp(-2 r^2 / radius^2) */
    CML_BEAM_RING,
    CML_BEAM_RECTANGLE,
    CML_BEAM_IMAGE /* pixels, each evenly */
};

/* Distributions of the facets that are finer than a boundary's shape (P20). */
enum cml_rough_kind { CML_SMOOTH, CML_ROUGH_GGX, CML_ROUGH_BECKMANN };

enum cml_detector_shape { CML_DETECTOR_RING, CML_DETECTOR_RECTANGLE, CML_DETECTOR_MAP };

/* What lies under the last boundary and sends light back (P12). */
enum cml_backing_kind { CML_BACKING_NONE, CML_BACKING_MIRROR, CML_BACKING_LAMBERTIAN, CML_BACKING_METAL };

/* Facets are the triangles of a mesh or the rings of cones, in order, and behind them the outer plane; the
 * pixels of the map on a plane, and behind them what lies outside. Above and below are the sides of the
 * boundary. What arrives at a facet leaves it again, so irradiances and exitances have the same sum, exactly.
 * Weights, i.e. power: to be divided by the facet's area. */
enum cml_facet_score {
    CML_FACET_IRRADIANCE_ABOVE, /* arrives from the medium above */
    CML_FACET_IRRADIANCE_BELOW,
    CML_FACET_EXITANCE_ABOVE, /* leaves into the medium above, transmitted or reflected */
    CML_FACET_EXITANCE_BELOW,
    CML_FACET_ESCAPED,         /* part of Rd (boundary 0) or Tt (boundary L) that touched this facet last */
    CML_FACET_ESCAPED_SQUARES, /* of the packets' weights, in units of CML_SQUARE_UNIT^2 (tally.h); none where
                                * groups have facets of their own */
    CML_FACET_SCORES
};

/* Where the facets of a boundary stand among those of all. count 0: none are scored. */
struct cml_facet_range {
    int first, count;
};
