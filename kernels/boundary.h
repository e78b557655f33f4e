/* The kinds of boundaries, beams, detectors and backings, and a boundary's facets with their scores. The
 * reader of a scene, the walk and the reports of a result all use these names. No type here depends on the
 * precision of `real`, so scenes and tallies can include this file.
 * SPDX-License-Identifier: MIT */
#pragma once

/* Groups of photons, for the errors of arrays with many cells (grids, maps, voxels, facets, directions). 64
 * sums per cell, one for each batch (balance.h), would take too much memory. Photon i is in group i mod 16,
 * so a group is four batches. */
#define CML_NUM_GROUPS 16

enum cml_surface_kind {
    CML_SURFACE_PLANE,
    CML_SURFACE_CONE, /* radial heightfield: rings of capped cones about the z axis */
    CML_SURFACE_MESH,
    CML_SURFACE_AUTO,   /* no surface: asks the host to choose a kind */
    CML_SURFACE_SPHERE, /* of a body; a body may also be a closed CML_SURFACE_MESH */
    CML_SURFACE_CYLINDER,
};

/* Domains over which a curved boundary's depth bounds lie (bounds.h). */
enum cml_bounds_form {
    CML_BOUNDS_SQUARE, /* mesh: a square of the x-y plane, and everything around it */
    CML_BOUNDS_RADII,  /* radial heightfield: the radius */
    CML_BOUNDS_PERIOD, /* repeated mesh: one period, a rectangle that fills the plane */
};

/* Distributions of a beam's starting places across its axis. */
enum cml_beam_shape {
    CML_BEAM_PENCIL,   /* all in a point */
    CML_BEAM_DISK,     /* evenly over a disk */
    CML_BEAM_GAUSSIAN, /* density exp(-2 r^2 / radius^2) */
    CML_BEAM_RING,
    CML_BEAM_RECTANGLE,
    CML_BEAM_IMAGE /* pixels of an image, evenly within each */
};

/* Distributions of the slopes of facets finer than a boundary's shape (P20). */
enum cml_rough_kind { CML_SMOOTH, CML_ROUGH_GGX, CML_ROUGH_BECKMANN };

/* Shapes of detectors; faces and ports are rings or rectangles, too. */
enum cml_detector_shape { CML_DETECTOR_RING, CML_DETECTOR_RECTANGLE, CML_DETECTOR_MAP, CML_DETECTOR_PORT };

/* Kinds of opaque surfaces that send light back (P12): under the last boundary, and on boundary 0. */
enum cml_backing_kind { CML_BACKING_NONE, CML_BACKING_MIRROR, CML_BACKING_LAMBERTIAN, CML_BACKING_METAL };

/* Scores of a facet. Facets of a curved boundary are its triangles or rings, in order, and behind them the
 * outer plane. Facets of a plane are the pixels of the map, and behind them everything outside of it.
 * Above and below are the sides of the boundary. Light that arrives at a facet leaves it again, so
 * irradiances and exitances have exactly the same sum. Scores are weights (power); a density is a score
 * divided by the facet's area. */
enum cml_facet_score {
    CML_FACET_IRRADIANCE_ABOVE, /* weight that arrives from the medium above */
    CML_FACET_IRRADIANCE_BELOW,
    CML_FACET_EXITANCE_ABOVE, /* weight that leaves into the medium above, transmitted or reflected */
    CML_FACET_EXITANCE_BELOW,
    CML_FACET_ESCAPED, /* part of Rd (boundary 0) or Tt (boundary L) that touched this facet last */
    /* Sum of squares of packets' weights, in units of CML_SQUARE_UNIT^2 (tally.h). Not used if each group of
     * photons has facets of its own. */
    CML_FACET_ESCAPED_SQUARES,
    CML_FACET_SCORES
};

/* The range of a boundary's facets among the facets of all boundaries. count 0: none are scored. */
struct cml_facet_range {
    int first, count;
};
