/* What a walk needs to know of the scene, and what it says of a packet.
 * Lengths in cm. Depth z of a packet is measured from the frame of the medium it is in: the frame of a medium
 * is that of the boundary above it (of boundary 0 for the medium above), so that a thin layer deep down keeps
 * all its digits and a plane is exactly z = 0. x and y are measured from the scene's origin (P1).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "balance.h"
#include "boundary.h"
#include "mesh_crossing.h"
#include "port.h"
#include "rng.h"

/* Weight is an integer, so that the balance holds to the last bit (P10): a whole packet is 2^31 units. */
#define CML_WEIGHT_ONE 0x80000000u
#define CML_SHADED_LIMIT 1000u             /* boundary events in a row that shading normals may bend */
#define CML_SHADED_LEAST (8 * CML_EPSILON) /* sine of the angle at which they may send light from a facet */
#define CML_TRAPPED_LIMIT 10000u  /* boundary events in a row without interaction, in a clear medium */
#define CML_STUCK_LIMIT 10000000u /* the same in any medium: a packet that never gets anywhere */

enum cml_fate {
    CML_FATE_ALIVE,
    CML_FATE_ABSORBED,    /* ended by roulette or with weight 0 */
    CML_FATE_REFLECTED,   /* left upwards for good after having entered */
    CML_FATE_TRANSMITTED, /* left downwards for good */
    CML_FATE_SPECULAR,    /* came back up without having entered */
    CML_FATE_TRAPPED,     /* totally reflected for ever in a clear medium */
    CML_FATE_LOST,        /* see enum cml_lost_cause */
    CML_NUM_FATES
};

enum cml_lost_cause {
    CML_LOST_NOT,
    CML_LOST_NO_SURFACE, /* nothing hit where a boundary must be */
    CML_LOST_NAN,        /* position or direction is not a number */
    CML_LOST_STUCK,      /* CML_STUCK_LIMIT boundary events without an interaction */
    CML_LOST_LEAKED,     /* found beyond the envelope of a boundary it never crossed */
    CML_LOST_TOO_FAR,    /* flew over too many periods of a repeated mesh (mesh_crossing.h) */
    CML_LOST_ROUGH,      /* met CML_ROUGH_LIMIT facets of a rough boundary in one event */
    CML_NUM_LOST_CAUSES
};

struct cml_medium {
    real n;      /* refractive index */
    real mut;    /* mua + mus, 1/cm; 0: clear */
    real mfp;    /* 1 / mut, cm; infinite when clear */
    real absorb; /* mua / mut, 0 when clear; where nothing scatters a little over 1, so that no rounding of a
                  * weight leaves a rest */
    real g; /* anisotropy of Henyey and Greenstein's function; below -1 or above 1, where another one has the
             * table k: 2 + k, or -2 - k where that is mirrored (struct cml_phase_cell) */
    real span;  /* depth of the frame of the boundary below, in this medium's frame; 0 for the outer media */
    real depth; /* of this medium's frame in the scene; a body has the frame of its layer */
    real bins;  /* the same in bins of dz */
    int body_grid;            /* of a layer with bodies and of these, else -1 */
    int first_node, end_node; /* the tree of the bodies that lie in it */
};

/* A cell of a phase function's table, which gives 1 - c, c the cosine of the deflection, or 1 + c where the
 * table is mirrored because more light goes backwards. Of the numbers in (0, 1) that are drawn, 0 straight
 * on, cell k of CML_PHASE_CELLS has those from k / CML_PHASE_CELLS on. In a cell 1 - c is start + slope y, y
 * in (0, 1). Where that is not accurate enough slope is -1, and -start the number of the first of
 * CML_PHASE_PARTS cells, further on in the array, with parts of the same y; else neither is negative. */
struct cml_phase_cell {
    real start, slope;
};
#define CML_PHASE_LOG2_CELLS 10
#define CML_PHASE_LOG2_PARTS 8
#define CML_PHASE_CELLS (1u << CML_PHASE_LOG2_CELLS)
#define CML_PHASE_PARTS (1u << CML_PHASE_LOG2_PARTS)

#define CML_RING_ROWS 5 /* ring_r, ring_z, ring_slope and both horizons, one behind the other */
#define CML_DEPTH_LEVELS 11

/* Bounds of a curved surface's depth by cells, see bounds.h. */
struct cml_depth_bounds {
    int form;  /* enum cml_bounds_form */
    int size;  /* cells along an axis on level 0, a power of two */
    int first; /* of level 0 in world.deepest and world.highest */
    int level_offset[CML_DEPTH_LEVELS];
    real corner_x, corner_y, per_cell; /* cm from the scene's axis, cells per cm */
    real per_cell_y;                   /* the same along y: another one where the form is a period */
    int first_horizon, horizon_level;  /* of meshes: in world.horizon_below and above, and of whose cells */
};

#ifndef __OPENCL_VERSION__
/* Cubes in and around a mesh that overhangs, and how far from the middle of each the surface is at least:
 * see cml_path_is_safe. */
struct cml_safe_cells {
    int nx, ny, nz;        /* nx 0: there are none */
    struct cml_vec corner; /* cm; boundary's frame, x and y from the scene's origin */
    real per_cell, margin; /* cells per cm; what rounding may take of a safe distance, cells */
    const float *safe;     /* [nz][ny][nx] safe distances, cells */
};
#endif

/* The grid of maps and volume: its corner lies at x = -nx / 2 * dx, y = -ny / 2 * dy; the volume has the
 * depth bins of A_rz, from the upper face on. */
struct cml_map {
    int nx, ny, na; /* na: angle bins of a pixel; nx 0: there is no map */
    real per_dx, per_dy;
    real half_x, half_y; /* nx / 2, ny / 2 */
    real top_bins;       /* depth of the volume's upper face in bins of dz */
};

/* Gates of time, all as long (P11). */
struct cml_gates {
    int count;   /* 0: time is not asked for */
    real per_cm; /* gates per cm of optical path */
};

/* Bins of directions (P7). */
struct cml_direction_bins {
    int nt, np;          /* 0: they are not asked for */
    real per_dt, per_dp; /* 1/rad */
};

#ifndef __OPENCL_VERSION__
/* A detector counts packets that have left for good (P13). Lengths are in cm, places from the scene's origin.
 */
struct cml_detector {
    int shape;             /* enum cml_detector_shape */
    int aimed, diffuse;    /* sees a cone about the axis, not all angles; no light that never was inside */
    struct cml_vec axis;   /* unit, along which light goes */
    real most_sine2;       /* square of the sine of the widest angle to it; above 1: the half space */
    struct cml_vec middle; /* z is not used */
    real inner2, outer2;   /* of a ring: squares of the radii */
    real low_x, high_x, low_y, high_y; /* of a rectangle */
    struct cml_map pixels;             /* of a map: its grid, about the middle */
    cml_u64 first_pixel;               /* among those of all detectors; of a map, else not used */
};

/* All detectors on one side at one level, and a grid over them: cell c has those that reach into it,
 * list[start[first + c]] to before list[start[first + c + 1]]. */
struct cml_detector_level {
    int below;
    real z;                                          /* frame of the outer medium */
    int nx, ny, first;                               /* cells; first: in `start` */
    real corner_x, corner_y, per_cell_x, per_cell_y; /* from the scene's origin */
};

/* Of what is split off packets at their launch: no detector sees it, or would; it goes up alike from all
 * packets, from the origin; or each has its own place. */
enum { CML_SPLIT_UNSEEN, CML_SPLIT_ALIKE, CML_SPLIT_APART };

/* A detector in a scene that is the same all about the first beam's axis: of light that leaves on a circle
 * about it, it sees the share that lies in its ring, which is `away` from the axis. */
struct cml_arc {
    int detector, level; /* detector: from 1; 0: there is none */
    real away, inner, outer;
};

struct cml_detection {
    int num_detectors, num_levels;
    int split;
    struct cml_arc arc;
    const struct cml_detector *detectors;
    const struct cml_detector_level *levels;
    const int *start, *list;
    double per_length; /* units per cm of what is summed of lengths and depths */
    double top;        /* where depths count from */
};
#endif

/* How fluence is scored (P14): by marks along the paths of packets. */
struct cml_marks {
    real spacing, per_spacing; /* of marks along paths, cm, 1/cm */
    cml_u32 cells;             /* of a batch */
    real top, bottom;          /* depths between which they score, in bins of dz */
};

#ifndef __OPENCL_VERSION__
/* Rows of a sweep that come of one flight (P16): by how much their media absorb more than those that are
 * flown. Or scores, for derivatives (P17): by how much they grow. */
struct cml_rows {
    int count;        /* rounded up to whole groups; those too many absorb nothing more; 0: there are none */
    const real *more; /* [media][count] 1/cm */
    const real *hits; /* scores: [media][count], for each interaction; NULL: rows of a sweep */
    const real *part; /* rows: [media][count] of a packet's weight that a sampled interaction is worth in
                       * A(r,z), or NULL: they have none */
    const real *most; /* [media] the largest of these */
};
#endif

/* P20. Slopes t of the facets, by projected area: P(t > x) = alpha^2 / (alpha^2 + x^2) of ggx, exp(-x^2 /
 * alpha^2) of beckmann. */
struct cml_rough {
    int kind; /* enum cml_rough_kind */
    real alpha;
};

/* A boundary, or the surface of a body. lowest and highest bound its depth in its own frame, that of a body
 * in the frame of its layer: lowest <= z <= highest everywhere. */
struct cml_surface {
    int kind;
    int above;                 /* the medium on its upper side: of a body the one outside */
    int first_ring, num_rings; /* CML_SURFACE_CONE: slices of the arrays of rings */
    real parts_per_cm;         /* of ring_start */
    real lowest, highest;
    real steepest; /* at least the slope of every part of it; infinite where it is upright or overhangs */
    struct cml_depth_bounds depths;
    struct cml_facet_range facets;
    struct cml_rough rough;
};

/* The shape of a body, in the frame of its layer, x and y from the scene's origin. Empty for a mesh. */
struct cml_body {
    struct cml_vec centre; /* of a sphere; of a cylinder the middle of its first end */
    struct cml_vec axis;   /* of a cylinder, unit, from that end to the other; of a sphere 0 */
    real radius, length;
};

/* A node of the tree over the bodies that lie in one medium: the box of one body or of all nodes up to
 * `skip`. Nodes stand in preorder, so whoever passes a box goes on with the next node, and who does not, at
 * `skip`. */
struct cml_body_node {
    struct cml_vec lower,
        upper;      /* frame of the layer, x and y from the scene's origin; larger than rounding */
    int skip, body; /* body: number of it, -1: an inner node */
};

/* Cubes over all bodies of a layer: see cml_may_hit_body. */
struct cml_body_grid {
    int nx, ny, nz, first; /* first: of its cells in world.body_cells, x fastest */
    struct cml_vec corner; /* cm */
    real cell, per_cell;   /* cm, and cells per cm */
};

/* In cells of a grid of bodies: what their bounds have to spare, more than rounding can move a packet. */
#define CML_CELL_MARGIN 0.01

/* What surfaces of bodies there are in a ball about the middle of a cell: none, or that of one body, between
 * two planes. Lengths in cells, all with CML_CELL_MARGIN to spare. */
struct cml_body_cell {
    real radius;           /* of the ball; 0: nothing is known */
    int inside;            /* the body's medium; -1: no surface is in the ball */
    struct cml_vec normal; /* of the planes, unit, outwards of the body; 0 where there is no surface, with
                            * both planes below */
    real lower, upper;     /* heights of the planes over the middle */
    real steepest; /* sine: who heads outwards more steeply than this can enter no facet in the ball, nor
                    * leave through one who heads inwards so; above 1 where this is never so */
};

/* P8: which packets play roulette, and what survivors weigh. Units of weight. */
struct cml_roulette_rule {
    cml_u32 below; /* lighter ones play */
    cml_u32
        weight; /* at least `below`; 0: ten times what they had, below at most 2^31 / 10 (original MCML) */
};

#ifndef __OPENCL_VERSION__
/* P15. Directions whose n sine lies between two indices: with c their cosine in a medium of the upper index,
 * c^2 = ratio uz^2 + rest, places in the table rise as the root of c. */
struct cml_tail_interval {
    real ratio, rest, per_root;
};

/* What is expected of light that goes down through the level z of a medium, below which all is flat. */
struct cml_tail {
    int medium;
    real z;            /* in the frame of the medium */
    int cells, scores; /* cells of an interval; scores: Tt, and A of each layer below the medium */
    const struct cml_tail_interval *interval; /* rising indices; the last has ratio 1, rest 0 */
    const float *response;                    /* [intervals][cells + 1][scores], each 0..1 */
};
/* P19: what packets shall weigh by depth in the scene, and by their distance from a place: the least of that
 * in equal cells of depth from 0 on and rings whose borders go with the square of their number. The first and
 * the last of both go on. */
struct cml_weight_windows {
    int cells, rings;    /* of depth, 0: there are none; rings: 1 where only depth counts */
    real per_bin;        /* cells in a bin of dz */
    real x, y, per_root; /* the place, from the scene's origin, and rings in the root of a cm */
    const cml_u32 *low;  /* [rings][cells] units of weight */
};
#define CML_TAIL_UNIT ((real)0.015625) /* of a score in one of weight: 2^-6, so that sums have room */
#endif

/* Directions of a source's packets about its axis. */
enum cml_source_light {
    CML_LIGHT_PARALLEL,
    CML_LIGHT_EVEN,   /* evenly per solid angle, as far as 1 - cosine is `spread`, or, where that is 0, the
                       * sine aperture / n */
    CML_LIGHT_COSINE, /* cosine law over the hemisphere */
    CML_LIGHT_TABLE
};

/* A beam (P1). Lengths in cm. */
struct cml_source {
    int inside;    /* starts at the place itself, else above all surfaces on the line through it */
    int medium;    /* of packets: 0: above all surfaces; below planes 1, or 2: glass; inside: at the middle */
    int is_pencil; /* inside: all packets start in that medium */
    int is_common; /* above, parallel, and a point, a disk or a Gaussian */
    int is_far;    /* inside: far outside of the scene; `middle` is where the axis meets the level `start` */
    real ahead;    /* of a far source: the distance along the axis to there */
    cml_u32 specular;      /* deterministic Rsp of one packet in weight units, 0 when medium is 0 or inside */
    cml_u32 between;       /* weight that goes up to boundary 0 again in a clear first layer, 0 without one */
    struct cml_vec middle; /* of the shape, x and y from the scene's origin, z in the frame of boundary 0;
                            * inside: of the medium */
    real start;            /* z where packets start in the frame of the medium, unless inside and near */
    struct cml_vec axis, e1, e2; /* direction, and two unit vectors across it */
    int shape, light;            /* enum cml_beam_shape, cml_source_light */
    real a, b; /* disk: the radius; Gaussian: the 1/e^2 radius; ring: the square of the inner radius, and the
                * difference of both squares; rectangle: half its lengths along e1 and e2; image: lengths of a
                * pixel along them */
    real aperture, spread;     /* of the light */
    int nx, ny, first_word;    /* of an image */
    int first_cell, num_cells; /* of a table */
};

/* A part of the directions of a table: 1 - cosine from v on, `width` wide; density at both ends. */
struct cml_light_cell {
    cml_u32 first; /* the lowest word that leads here */
    real v, width, begin, end;
};

/* What lies under the last boundary and sends light back (P12). */
struct cml_backing {
    int kind;     /* enum cml_backing_kind */
    int boundary; /* the last one; -1 without a backing */
    real kept; /* mirror, lambertian: share of the weight that does not come back; a little over 1 where none
                * does */
    real n, k; /* metal: index n + i k, relative to that of the last layer */
};

struct cml_setup {
    struct cml_stream stream;
    struct cml_roulette_rule roulette;
    int num_layers, num_bodies;
    int reentry;          /* follow packets outside (P6) */
    int tally_absorption; /* A_rz is wanted */
    int nr, nz, na;       /* bins; a tally's A_rz is [nr + 1][nz + 2], its Rd_ra and Tt_ra are [nr + 1][na] */
    real per_dr, per_dz;  /* 1/dr, 1/dz */
    real per_da;          /* na / (pi/2) */
    real x0, y0;          /* scene position of the origin of x and y */
    real r0_x, r0_y;      /* the same from where results count r */
    struct cml_map map;
    struct cml_gates gates;
    int keeps_paths; /* gates, detectors, saved packets or rows want them */
    struct cml_direction_bins directions;
    struct cml_marks marks;
    struct cml_facet_range outer_facets[2]; /* of boundaries 0 and num_layers, count 0 for planes */
    struct cml_backing backing;
    /* launch */
    int num_sources;
    cml_u32 specular; /* what is split off every packet before its launch; 0 where sources differ in that */
};

#ifndef __OPENCL_VERSION__
/* A packet's way, for detectors and saved packets (P13, P18): all visits of media but the one under way. */
struct cml_trail {
    struct cml_stay *stay; /* [media]; NULL: nobody wants it */
    real deepest;          /* depth in the scene, cm */
};
#endif

struct cml_packet {
    cml_u64 index;
    struct cml_vec p, u;
    real tau; /* optical depth left to the next interaction */
    cml_u32 w;
    struct cml_block draw; /* the block of the next interaction */
    cml_u32 interactions;  /* so far: the event number of the next one */
    cml_u32 crossings;     /* boundary events with unequal indices so far: the event number of the next one */
    cml_u32 rough_draws;   /* blocks of random words drawn at rough boundaries (P20) */
    cml_u32 bounces;       /* boundary events since the last interaction */
    cml_u32 boundary_events; /* all of them */
    int medium;
    int on_boundary, on_primitive; /* what the packet stands on, -1: nothing, or CML_NEAR_FACETS */
    struct cml_vec off; /* where that is a sphere or a cylinder: place from its centre or its axis, cm */
    int near_boundary;  /* 1 + the boundary that the path last looked along ends at, within rounding; 0: none
                         */
    int undeflected;    /* it came there without a turn: equal indices */
    int entered;        /* has been in the material */
    int fate, cause;
    real exit_x, exit_y; /* where the packet touched the surface last, seen from outside */
    real path;           /* n times length, cm, up to where it is (P11); below 0: its clock has not started */
    real mark;           /* cm to the next mark ahead (P14); of neither does a device keep account */
    /* terms of this packet in the weight balance, in weight units */
    cml_u64 gained, roulette, absorbed, backing;
    cml_u32 queries;           /* curved surfaces asked for a crossing; depends on the engine's short cuts */
    cml_u32 shading_overruled; /* events that the facet decided against the shading normal */
#ifndef __OPENCL_VERSION__     /* a device has what stands above (device_layout.h) */
    /* P13, of the visit of its medium that is under way: length, cm; largest depth, frame of the medium; sum
     * of 1 - cosine of scatterings; interactions before it */
    real here, low, momentum;
    cml_u32 before;
    struct cml_trail trail;
    cml_u32 spent; /* P19: of CML_MOST_OF_FAMILY: the others may be branches that come of the packet */
#endif
};

/* A crossing ahead. Of a body above and up are outside and outwards. */
struct cml_hit {
    real t; /* distance, cm */
    int boundary, primitive;
    struct cml_vec point;  /* in the boundary's frame, x and y from the scene's origin */
    struct cml_vec normal; /* unit, up: what Fresnel and Snell see */
    struct cml_vec facet;  /* unit, up: decides on which side a direction goes */
    struct cml_vec off;    /* of a sphere or a cylinder: place from its centre or its axis */
};

#ifndef __OPENCL_VERSION__
/* What paths from p along u meet of the first boundary, a mesh, on whose primitive they begin, below it:
 * nothing where they are longer than `least` and shorter than `most`, `hit` where they are longer than
 * `from`, cm. Others are to be asked. */
struct cml_known_path {
    struct cml_vec p, u;
    int on_primitive;
    double least, most, from;
    struct cml_hit hit;
};
#endif

/* Body k is medium num_layers + 2 + k, and its surface boundary num_layers + 1 + k: as for layers, the medium
 * below boundary b is b + 1. */

/* Everything a walk reads. Rings: r rising from 0, z = depth at r in the boundary's frame, slope dz/dr to the
 * next ring (0 behind the last: the outer plane). Its radius cut into as many equal parts as there are rings
 * before the last, start[k] is the last ring that begins in a part before k, or 0. Horizons, seen
 * from above and from below: a packet that stands on a ring, and from there rises or falls so steeply, meets
 * the field never again (src/surface/bounds/ring_horizon_inl.h). */
struct cml_world {
    struct cml_setup setup;
    CML_GLOBAL const struct cml_medium *media;     /* [num_layers + 2 + num_bodies] */
    CML_GLOBAL const struct cml_surface *surfaces; /* [num_layers + 1 + num_bodies] */
    CML_GLOBAL const real *ring_r, *ring_z, *ring_slope, *ring_horizon_above, *ring_horizon_below;
    CML_GLOBAL const int *ring_start;
    CML_GLOBAL const real *deepest,
        *highest; /* pyramids of all surfaces: greatest and least z of each cell */
    CML_GLOBAL const real *horizon_below, *horizon_above; /* of the cells of all meshes */
    CML_GLOBAL const struct cml_body *bodies;             /* [num_bodies] */
    CML_GLOBAL const struct cml_body_node *body_nodes;
    CML_GLOBAL const struct cml_body_grid *body_grids;
    CML_GLOBAL const struct cml_body_cell *body_cells; /* of all grids */
    /* Tables, one behind the other, then parts of their cells; NULL where no medium has one. */
    CML_GLOBAL const struct cml_phase_cell *phase_cells;
    CML_GLOBAL const struct cml_source *sources; /* [setup.num_sources] */
    CML_GLOBAL const struct cml_light_cell *light_cells;
    /* Images, each: how many rows are in use, the lowest word that leads to each of them [ny], and then the
     * same of the columns of every row, [ny][1 + nx]. */
    CML_GLOBAL const cml_u32 *image_words;
#ifndef __OPENCL_VERSION__
    struct cml_detection detection;
    struct cml_rows rows;
    int only_tables;                              /* every medium that scatters has one */
    cml_mesh_intersect *intersect_mesh;           /* NULL where no surface is a mesh */
    const struct cml_mesh_surface *const *meshes; /* of surfaces, NULL where one is no mesh */
    const struct cml_safe_cells *safe_cells;      /* [num_layers + 1] of boundaries */
    const struct cml_known_path *known_path;      /* NULL where none is */
    struct cml_tail tail;                         /* read where its scores are wanted */
    struct cml_weight_windows windows;
    void (*on_event)(void *context, const char *what, const struct cml_packet *packet); /* NULL: not traced */
    void *on_event_context;
#endif
};
