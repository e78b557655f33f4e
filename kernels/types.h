/* The data of a walk: the scene as the walk reads it (media, surfaces, sources, the world), and a packet with
 * its fates.
 * Lengths are in cm. x and y count from the scene's origin (P1). The depth z of a packet counts in the frame
 * of its medium, which is the frame of the boundary above the medium (boundary 0 for the medium above all
 * layers). So a thin layer deep down keeps all its digits, and a plane is exactly z = 0.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "balance.h"
#include "boundary.h"
#include "mesh_crossing.h"
#include "port.h"
#include "rng.h"

/* Weights are integers, so the balance of weight holds to the last bit (P10). A whole packet has 2^31
 * units. */
#define CML_WEIGHT_ONE 0x80000000u
/* Boundary events in a row after which shading normals count no more. */
#define CML_SHADED_LIMIT 1000u
/* Least sine of the angle between the facet and a direction computed with a shading normal. If the sine is
 * smaller, the direction is computed again with the facet's own normal. */
#define CML_SHADED_LEAST (8 * CML_EPSILON)
#define CML_TRAPPED_LIMIT 10000u /* boundary events in a row without interaction, in a clear medium */
/* Boundary events in a row without interaction, in any medium: the packet never gets anywhere. */
#define CML_STUCK_LIMIT 10000000u

enum cml_fate {
    CML_FATE_ALIVE,
    CML_FATE_ABSORBED,    /* ended by roulette or with weight 0 */
    CML_FATE_REFLECTED,   /* left upwards for good after having entered the material */
    CML_FATE_TRANSMITTED, /* left downwards for good */
    CML_FATE_SPECULAR,    /* left upwards without having entered the material */
    CML_FATE_TRAPPED,     /* reflected totally for ever in a clear medium */
    CML_FATE_LOST,        /* given up by the walk, see enum cml_lost_cause */
    CML_NUM_FATES
};

enum cml_lost_cause {
    CML_LOST_NOT,
    CML_LOST_NO_SURFACE, /* no surface was hit where a boundary must be */
    CML_LOST_NAN,        /* position or direction is not a number */
    CML_LOST_STUCK,      /* CML_STUCK_LIMIT boundary events without an interaction */
    CML_LOST_LEAKED,     /* found beyond the envelope of a boundary that it never crossed */
    CML_LOST_TOO_FAR,    /* flew over too many periods of a repeated mesh (mesh_crossing.h) */
    CML_LOST_ROUGH,      /* met CML_ROUGH_LIMIT facets of a rough boundary in one event */
    CML_NUM_LOST_CAUSES
};

struct cml_medium {
    real n;   /* refractive index */
    real mut; /* mua + mus, 1/cm; 0 in a clear medium */
    real mfp; /* 1 / mut, cm; infinite in a clear medium */
    /* Share mua / mut of the weight that an interaction absorbs; 0 in a clear medium. A little over 1 in a
     * medium that does not scatter, so that rounding leaves no rest of a weight. */
    real absorb;
    /* Anisotropy of Henyey and Greenstein's function, -1 to 1. A medium with the table k of another phase
     * function has 2 + k here, or -2 - k if the table is mirrored (struct cml_phase_cell). */
    real g;
    real span;  /* z of the frame of the boundary below, in this medium's frame; 0 in the outer media */
    real depth; /* z of this medium's frame in the scene; a body has the frame of its layer */
    real bins;  /* `depth` in bins of dz */
    /* Number of the grid over bodies: in a layer with bodies and in these bodies; else -1. */
    int body_grid;
    /* Range of world.body_nodes: the tree of the bodies that lie directly in the medium. */
    int first_node, end_node;
};

/* A cell of a phase function's table (P4). The table turns a number v in (0, 1) into 1 - c, where c is the
 * cosine of the deflection and v = 0 means straight on. A mirrored table, for functions that scatter mostly
 * backwards, gives 1 + c instead.
 * Cell k of the CML_PHASE_CELLS cells has the numbers v from k / CML_PHASE_CELLS on. Within a cell, at y in
 * (0, 1), 1 - c is start + slope y. A cell in which a straight line is too inaccurate has slope -1, and
 * -start is the index of the first of CML_PHASE_PARTS parts, further on in the same array, that divide y
 * evenly. All other cells have start and slope >= 0. */
struct cml_phase_cell {
    real start, slope;
};
#define CML_PHASE_LOG2_CELLS 10
#define CML_PHASE_LOG2_PARTS 8
#define CML_PHASE_CELLS (1u << CML_PHASE_LOG2_CELLS)
#define CML_PHASE_PARTS (1u << CML_PHASE_LOG2_PARTS)

/* Arrays with one number per ring, stored one behind the other: ring_r, ring_z, ring_slope and both
 * horizons. */
#define CML_RING_ROWS 5
#define CML_DEPTH_LEVELS 11

/* Pyramid of bounds on a curved surface's depth, by cells (bounds.h). */
struct cml_depth_bounds {
    int form;  /* enum cml_bounds_form */
    int size;  /* cells along an axis on level 0, a power of two */
    int first; /* index of level 0 in world.deepest and world.highest */
    int level_offset[CML_DEPTH_LEVELS];
    real corner_x, corner_y, per_cell; /* corner in cm from the scene's axis; cells per cm */
    /* Cells per cm along y. It equals per_cell unless `form` is CML_BOUNDS_PERIOD. */
    real per_cell_y;
    /* Meshes: index of the first horizon in world.horizon_below and above; level of the pyramid whose
     * cells have horizons. A horizon is a slope: packets that leave the mesh more steeply never meet it
     * again. */
    int first_horizon, horizon_level;
};

#ifndef __OPENCL_VERSION__
/* Safe distances (cml_path_is_safe): cubes in and around a mesh that overhangs. Each cube knows a distance
 * from its middle within which there is no surface. */
struct cml_safe_cells {
    int nx, ny, nz; /* numbers of cubes; nx 0: there are none */
    /* Lower corner of the cubes, cm, in the boundary's frame, x and y from the scene's origin. */
    struct cml_vec corner;
    real per_cell, margin; /* cells per cm; loss of a safe distance by rounding, in cells */
    const float *safe;     /* [nz][ny][nx] safe distances, in cells */
};
#endif

/* The grid of maps and of the volume. Its corner lies at x = -nx / 2 * dx, y = -ny / 2 * dy. The volume has
 * depth bins of dz like A_rz, but its first bin begins at the volume's upper face. */
struct cml_map {
    int nx, ny, na; /* na: angle bins of a pixel; nx 0: there is no map */
    real per_dx, per_dy;
    real half_x, half_y; /* nx / 2, ny / 2 */
    real top_bins;       /* depth of the volume's upper face, in bins of dz */
};

/* Gates of time, all of one length (P11). */
struct cml_gates {
    int count;   /* 0: no results by time */
    real per_cm; /* gates per cm of optical path */
};

/* Bins of the directions of light that leaves (P7). */
struct cml_direction_bins {
    int nt, np;          /* numbers of bins; 0: no results by direction */
    real per_dt, per_dp; /* bins per radian */
};

/* An opaque surface that sends light back (P12): the backing under the last layer, or a face on boundary 0.
 */
struct cml_backing {
    int kind;     /* enum cml_backing_kind */
    int boundary; /* number of its boundary; -1: there is no backing */
    /* Mirror, lambertian: share of the weight that stays in the surface. If all of it stays, the share is
     * a little over 1, so that rounding never leaves a rest of weight. */
    real kept;
    real n, k; /* metal: index n + i k relative to the index of the layer that it touches */
};

#ifndef __OPENCL_VERSION__
/* An area in a level plane: a ring or a rectangle. Lengths are in cm, places count from the scene's origin.
 */
struct cml_area {
    int shape;                         /* CML_DETECTOR_RING or CML_DETECTOR_RECTANGLE */
    struct cml_vec middle;             /* z is not used */
    real inner2, outer2;               /* squares of a ring's radii */
    real low_x, high_x, low_y, high_y; /* sides of a rectangle */
};

/* A detector: it counts packets that have left for good and cross its shape (P13). */
struct cml_detector {
    int shape; /* enum cml_detector_shape */
    int group; /* number of the detector that sums this one and others, from 1; 0: none */
    int arc;   /* 1: the detector counts shares of circles, by an arc of the detection */
    /* aimed: sees only a cone about the axis, not all angles. diffuse: sees no light that has never been in
     * the material. */
    int aimed, diffuse;
    struct cml_vec axis; /* unit vector along which accepted light goes */
    /* Square of the sine of the widest accepted angle to the axis; above 1: the half space. Light that left
     * through a port has another one, by its own index and `na`. */
    real most_sine2;
    double na;
    struct cml_area area;  /* for a map only its middle */
    int port;              /* CML_DETECTOR_PORT: number of the contact (struct cml_contacts) */
    struct cml_map pixels; /* grid of a map detector, about its middle */
    /* Map detectors: index of the first pixel among the pixels of all detectors. */
    cml_u64 first_pixel;
};

/* All detectors on one side at one level, with a grid over them. Cell c holds the detectors that reach into
 * it: list[start[first + c]] to list[start[first + c + 1] - 1]. */
struct cml_detector_level {
    int below;
    real z;                                          /* level, in the frame of the outer medium */
    int nx, ny, first;                               /* numbers of cells; first: index of cell 0 in `start` */
    real corner_x, corner_y, per_cell_x, per_cell_y; /* cm from the scene's origin; cells per cm */
};

/* Ways in which detectors may see the light that is split off packets at their launch (P1). UNSEEN: no
 * detector sees it. ALIKE: all packets send it up from one place, the origin. APART: each packet has a place
 * of its own. */
enum { CML_SPLIT_UNSEEN, CML_SPLIT_ALIKE, CML_SPLIT_APART };

/* A detector that counts shares of circles (P13). A scene may have some if it looks the same all about the
 * first beam's axis. Light may then leave anywhere on a circle about this axis, and the detector counts
 * the share of the circle that lies in its ring. The ring's middle is `away` from the axis; inner and
 * outer are its radii, cm. */
struct cml_arc {
    int detector, level; /* index of the detector, and of its level */
    real away, inner, outer;
};

/* A face or a port on boundary 0 (P12). */
struct cml_contact {
    struct cml_area area;
    int is_port;
    int stops; /* 1: stops light from the open medium above; all but a port of the same index do */
    double n;  /* port: refractive index of its medium */
    struct cml_backing face; /* face: its surface; a metal's index counts relative to that of layer 1 */
};

/* All that touches boundary 0 from above, numbered from 1 in the order of the scene; a later one lies on top.
 * `grid` lists, by cell and in their order, the numbers of those that have a shape, less 1. */
struct cml_contacts {
    int count;
    int whole; /* number of the last face that covers the whole plane, 0: none; those before it are hidden */
    const struct cml_contact *item;
    struct cml_detector_level grid;
    const int *start, *list;
};

struct cml_detection {
    int num_detectors, num_levels;
    int split;
    int num_arcs;
    const struct cml_arc *arcs;
    const struct cml_detector *detectors;
    const struct cml_detector_level *levels;
    const int *start, *list;
    double per_length; /* units per cm in sums of lengths and depths */
    double top;        /* depth from which largest depths of packets are measured */
};
#endif

/* The marks along packets' paths that score fluence (P14). */
struct cml_marks {
    real spacing, per_spacing; /* distance between marks, cm; its inverse, 1/cm */
    cml_u32 cells;             /* cells of one batch */
    real top, bottom;          /* depths between which marks score, in bins of dz */
};

#ifndef __OPENCL_VERSION__
/* Rows of a sweep that come of one flight (P16): each row is a variant of the scene whose media absorb more
 * than the media that packets fly in. For derivatives (P17) the rows are scores, and `more` and `hits` say
 * how much a path and an interaction add to them. */
struct cml_rows {
    /* Number of rows, rounded up to whole groups (CML_ROW_GROUP); 0: there are none. The rows added by
     * rounding up absorb nothing more than the scene. */
    int count;
    const real *more; /* [media][count] 1/cm */
    const real *hits; /* scores: [media][count] added at each interaction; NULL in a sweep */
    /* Rows: [media][count] share of a packet's weight that a sampled interaction adds to A(r,z); NULL if the
     * rows have no A(r,z). */
    const real *part;
    const real *most; /* [media] the largest `part` of each medium */
};
#endif

/* Roughness of a boundary (P20). By projected area, the share of facets steeper than the slope x is alpha^2 /
 * (alpha^2 + x^2) for ggx and exp(-x^2 / alpha^2) for beckmann. */
struct cml_rough {
    int kind; /* enum cml_rough_kind */
    real alpha;
};

/* A boundary, or the surface of a body. Every place of it has a depth z with lowest <= z <= highest, in the
 * boundary's own frame, or for a body in the frame of its layer. */
struct cml_surface {
    int kind;
    int above;                 /* medium on the upper side; of a body the medium outside */
    int first_ring, num_rings; /* CML_SURFACE_CONE: its slice of the arrays of rings */
    real parts_per_cm;         /* parts of ring_start per cm */
    real lowest, highest;
    real steepest; /* at least the slope of every part; infinite if a part is upright or overhangs */
    struct cml_depth_bounds depths;
    struct cml_facet_range facets;
    struct cml_rough rough;
};

/* The shape of a sphere or cylinder, in the frame of its layer, x and y from the scene's origin. Zero for a
 * body that is a mesh. */
struct cml_body {
    struct cml_vec centre; /* middle of a sphere, or of a cylinder's first end */
    struct cml_vec axis;   /* cylinder: unit vector from the first end to the other; sphere: 0 */
    real radius, length;
};

/* A node of the tree over the bodies that lie in one medium: the box of one body, or of all nodes before
 * `skip`. Nodes stand in preorder. A ray that passes a node's box goes on with the next node; another ray
 * goes on at `skip`. */
struct cml_body_node {
    /* Corners of the box, in the frame of the layer, x and y from the scene's origin. The box is larger than
     * its bodies by more than rounding. */
    struct cml_vec lower, upper;
    int skip, body; /* body: number of the body; -1: an inner node */
};

/* Grid of cubes over all bodies of a layer (cml_may_hit_body). */
struct cml_body_grid {
    /* Numbers of cubes; index of the first in world.body_cells, where x runs fastest. */
    int nx, ny, nz, first;
    struct cml_vec corner; /* lower corner of the grid, cm, in the frame of the layer */
    real cell, per_cell;   /* side of a cube in cm, and cubes per cm */
};

/* The margin by which bounds on bodies are widened, in cells of their grid: more than rounding can move a
 * packet. */
#define CML_CELL_MARGIN 0.01

/* Surfaces of bodies near the middle of a grid cell: a ball about the middle that holds no surface, or the
 * surface of one body, between two planes. Lengths are in cells, widened by CML_CELL_MARGIN. */
struct cml_body_cell {
    real radius; /* radius of the ball; 0: nothing is known */
    /* Medium inside the body whose surface is in the ball; -1: the ball holds no surface. */
    int inside;
    /* Unit normal of the planes, outwards of the body; 0 if the ball holds no surface, and then both planes
     * lie below. */
    struct cml_vec normal;
    real lower, upper; /* heights of the planes above the middle, along the normal */
    /* Sine of an angle. A packet that heads outwards more steeply can enter no facet in the ball; one that
     * heads inwards more steeply can leave through none. Above 1 if there is no such angle. */
    real steepest;
};

/* Rule of roulette (P8): which packets play, and the weight of survivors. Weights are in units. */
struct cml_roulette_rule {
    cml_u32 below; /* packets lighter than this play */
    /* Weight of a survivor in weight units, at least `below`. 0 means that a survivor weighs ten times its
     * old weight, as in original MCML; `below` is then at most 2^31 / 10, so that the new weight fits. */
    cml_u32 weight;
};

#ifndef __OPENCL_VERSION__
/* A row of the table of expected values (P15), for directions whose n sine lies between two neighbouring
 * refractive indices. With c the cosine of the direction in a medium of the upper index, c^2 = ratio uz^2 +
 * rest. The place in the table is per_root sqrt(c). */
struct cml_tail_interval {
    real ratio, rest, per_root;
};

/* Table of the expected results (P15) of light that goes down through the level z of a medium, if
 * everything below this level is flat. */
struct cml_tail {
    int medium;
    real z;            /* depth of the level, in the frame of the medium */
    int cells, scores; /* cells of an interval; scores of a cell: Tt, then A of each layer below the medium */
    const struct cml_tail_interval *interval; /* by rising refractive index; the last has ratio 1, rest 0 */
    const float *response;                    /* [intervals][cells + 1][scores], each 0..1 */
};
/* Weight windows (P19): the weight that a packet shall have, by its depth in the scene and its distance
 * from the nearest place. Cells of depth are equal and begin at depth 0; ring k lies between k^2 and (k +
 * 1)^2 over per_root^2 from the place. The first and last cell of depth and the last ring have no outer
 * border. An entry of the table is the lower end of the window for the least target weight W in its cell. */
struct cml_weight_windows {
    int cells, rings;   /* cells of depth, 0: there are no windows; rings: 1 if only depth counts */
    int places;         /* 0 if only depth counts */
    real per_bin;       /* cells in a bin of dz */
    real per_root;      /* rings per square root of a cm */
    const real *x, *y;  /* [places] from the scene's origin, cm */
    const cml_u32 *low; /* [rings][cells] lower end of the window, W / 3, in units of weight */
};
#define CML_TAIL_UNIT ((real)0.015625) /* score units in one unit of weight: 2^-6, so that sums have room */
#endif

/* Distributions of a source's directions about its axis. */
enum cml_source_light {
    CML_LIGHT_PARALLEL,
    /* Evenly per solid angle, up to 1 - cosine = `spread`, or, if `spread` is 0, up to the sine aperture /
     * n. */
    CML_LIGHT_EVEN,
    CML_LIGHT_COSINE, /* cosine law over the hemisphere */
    CML_LIGHT_TABLE
};

/* A source of packets: one beam of the scene (P1). Lengths are in cm. */
struct cml_source {
    /* 1: packets start at their place in the shape; 0: above all surfaces, on the line through this place. */
    int inside;
    /* Medium in which packets start: 0 above all surfaces; 1 below planes, 2 below a glass plate; for a
     * source inside, the medium at its middle. */
    int medium;
    int is_pencil; /* a source inside whose packets all start in `medium` */
    int is_common; /* light from above, parallel, from a point, a disk or a Gaussian */
    int port;      /* number of the port in which all packets start, on boundary 0; 0: none */
    /* A source inside, far outside of the scene; `middle` is then where the axis meets the level `start`. */
    int is_far;
    real ahead; /* far source: distance along the axis from the source to `middle` */
    /* Rsp of one packet in weight units, which the launch splits off. 0 where the walk finds Rsp itself: if
     * packets start in medium 0, above boundary 0, or inside the scene. */
    cml_u32 specular;
    /* Light that goes up between the faces of a clear first layer, summed over all passages, in weight units;
     * 0 without such a layer. */
    cml_u32 between;
    /* Middle of the shape: x and y from the scene's origin, z in the frame of boundary 0, or for a source
     * inside in the frame of its medium. */
    struct cml_vec middle;
    /* Z at which packets start, in the frame of `medium`. A source inside that is not far (`is_far`) does not
     * use it. */
    real start;
    struct cml_vec axis, e1, e2; /* direction of the beam, and two unit vectors across it */
    int shape, light;            /* enum cml_beam_shape, cml_source_light */
    /* Disk: a is the radius. Gaussian: a is the 1/e^2 radius. Ring: a is the square of the inner radius, b
     * the difference of both squares. Rectangle: half its lengths along e1 and e2. Image: lengths of a pixel
     * along e1 and e2. */
    real a, b;
    real aperture, spread; /* numerical aperture; largest 1 - cosine (enum cml_source_light) */
    /* image: numbers of columns and rows, and its first word in world.image_words. */
    int nx, ny, first_word;
    int first_cell, num_cells; /* table: its range of world.light_cells */
};

/* A part of a table of directions. 1 - cosine begins at v and has the width `width`; begin and end are the
 * densities at both ends. */
struct cml_light_cell {
    cml_u32 first; /* lowest random word that leads to this part */
    real v, width, begin, end;
};

struct cml_setup {
    struct cml_stream stream;
    struct cml_roulette_rule roulette;
    int num_layers, num_bodies;
    int reentry;          /* 1: packets outside are followed, because they may come back in (P6) */
    int tally_absorption; /* 1: A_rz is wanted */
    /* Numbers of bins. In a tally A_rz is [nr + 1][nz + 2]; Rd_ra and Tt_ra are [nr + 1][na]. */
    int nr, nz, na;
    real per_dr, per_dz; /* 1/dr, 1/dz */
    real per_da;         /* na / (pi/2) */
    real x0, y0;         /* the origin of packets' x and y, in the scene's coordinates */
    real r0_x, r0_y;     /* the same origin, from the axis from which results count r */
    struct cml_map map;
    struct cml_gates gates;
    int keeps_paths; /* 1: gates, detectors, saved packets or rows need the lengths of paths */
    struct cml_direction_bins directions;
    struct cml_marks marks;
    /* Facets of boundaries 0 and num_layers; count 0 for a boundary that is a plane. */
    struct cml_facet_range outer_facets[2];
    struct cml_backing backing;
    int num_sources;
    cml_u32 specular; /* weight units that are split off every packet at its launch; 0 if they differ */
    int apart;        /* 1: launches differ in what they split off, or in the medium where they start */
};

#ifndef __OPENCL_VERSION__
/* The history of a packet for detectors and saved packets (P13, P18): all finished visits of media. The visit
 * under way is in the packet itself. */
struct cml_trail {
    struct cml_stay *stay; /* [media]; NULL if no result needs it */
    real deepest;          /* largest depth in the scene, cm */
};
#endif

struct cml_packet {
    cml_u64 index;
    struct cml_vec p, u;
    real tau; /* optical depth left to the next interaction */
    cml_u32 w;
    struct cml_block draw; /* random words of the next interaction */
    cml_u32 interactions;  /* interactions so far: the event number of the next one */
    cml_u32 crossings;     /* boundary events with unequal indices so far: the event number of the next one */
    cml_u32 rough_draws;   /* blocks of random words drawn at rough boundaries (P20) */
    cml_u32 bounces;       /* boundary events since the last interaction */
    cml_u32 boundary_events; /* boundary events in its whole life */
    int medium;
    /* Boundary and primitive that the packet stands on; -1 if it stands on nothing. After an interaction
     * within rounding of a mesh, on_primitive is CML_NEAR_FACETS (mesh_crossing.h). */
    int on_boundary, on_primitive;
    /* Place on a sphere or cylinder that the packet stands on, from its centre or axis, cm. */
    struct cml_vec off;
    /* 1 + the boundary at which the last searched path ends, within rounding; 0: none. */
    int near_boundary;
    /* 1: the packet came through `on_boundary` without a turn, because indices are equal. */
    int undeflected;
    int entered; /* 1: has been in the material */
    int fate, cause;
    real exit_x, exit_y; /* x and y of the last touch of a surface from an outer medium */
    /* Optical path so far, n times length, cm (P11); below 0: the clock has not started. */
    real path;
    /* Distance to the next mark ahead, cm (P14); a device uses neither this nor `path`. */
    real mark;
    /* Terms of this packet in the weight balance, in weight units. */
    cml_u64 gained, roulette, absorbed, backing;
    /* Searches for a crossing on curved surfaces; depends on the engine's short cuts. */
    cml_u32 queries;
    cml_u32 shading_overruled; /* boundary events that the facet decided against the shading normal */
#ifndef __OPENCL_VERSION__     /* a packet on a device has only the members above (device_layout.h) */
    /* The visit under way of the packet's medium (P13): length in cm, largest depth in the frame of the
     * medium, and the sum of 1 - cosine of its scatterings. before: interactions of the packet before the
     * visit. */
    real here, low, momentum;
    cml_u32 before;
    struct cml_trail trail;
    cml_u64 face; /* term in the weight balance: kept by faces, or stopped on boundary 0 */
    /* The part of the budget of CML_MOST_OF_FAMILY branches (P19) that the packet may no longer use: branches
     * that it has split off, and the shares of the budget that it has given to them. */
    cml_u32 spent;
#endif
};

/* A crossing ahead of a packet. On the surface of a body "above" and "up" mean outside and outwards. */
struct cml_hit {
    real t; /* distance, cm */
    int boundary, primitive;
    struct cml_vec point;  /* in the boundary's frame, x and y from the scene's origin */
    struct cml_vec normal; /* unit, up: the normal for Fresnel's and Snell's laws */
    /* Unit, up: the facet's own normal, which decides on which side a direction goes. */
    struct cml_vec facet;
    struct cml_vec off; /* sphere or cylinder: place from its centre or axis */
};

#ifndef __OPENCL_VERSION__
/* The known answer to a search that many packets repeat: paths from p along u to boundary 0, a mesh, that
 * begin below it on primitive on_primitive. A path longer than `least` and shorter than `most` (cm) meets
 * nothing. A path longer than `from` meets `hit`. All other paths must be searched. */
struct cml_known_path {
    struct cml_vec p, u;
    int on_primitive;
    double least, most, from;
    struct cml_hit hit;
};
#endif

/* Numbering of bodies: body k is medium num_layers + 2 + k, and its surface is boundary num_layers + 1 + k.
 * So, as for layers, the medium below boundary b is b + 1. */

/* The world: everything that a walk reads.
 * Rings of a radial heightfield: ring_r rises from 0, ring_z is the depth there in the boundary's frame, and
 * ring_slope is dz/dr up to the next ring (0 behind the last, in the outer plane). ring_start speeds up the
 * search for a ring: the radius up to the last ring is cut into equal parts, one fewer than rings.
 * ring_start[k] is the last ring that begins in a part before k, or 0.
 * Horizons of rings, for packets above and below: a packet that leaves a ring more steeply than its horizon
 * never meets the field again (src/surface/bounds/ring_horizon_inl.h). */
struct cml_world {
    struct cml_setup setup;
    CML_GLOBAL const struct cml_medium *media;     /* [num_layers + 2 + num_bodies] */
    CML_GLOBAL const struct cml_surface *surfaces; /* [num_layers + 1 + num_bodies] */
    CML_GLOBAL const real *ring_r, *ring_z, *ring_slope, *ring_horizon_above, *ring_horizon_below;
    CML_GLOBAL const int *ring_start;
    /* Pyramids of all surfaces: greatest and least z of each cell. */
    CML_GLOBAL const real *deepest, *highest;
    CML_GLOBAL const real *horizon_below, *horizon_above; /* horizons of the cells of all meshes */
    CML_GLOBAL const struct cml_body *bodies;             /* [num_bodies] */
    CML_GLOBAL const struct cml_body_node *body_nodes;
    CML_GLOBAL const struct cml_body_grid *body_grids;
    CML_GLOBAL const struct cml_body_cell *body_cells; /* cells of all grids over bodies */
    /* Tables one behind the other, then the parts of their cells; NULL if no medium has a table. */
    CML_GLOBAL const struct cml_phase_cell *phase_cells;
    CML_GLOBAL const struct cml_source *sources; /* [setup.num_sources] */
    CML_GLOBAL const struct cml_light_cell *light_cells;
    /* Images one behind the other. Each has the number of rows in use, then for each of ny rows the lowest
     * word that leads to the row. For each row follow its number of columns in use and their lowest words,
     * [ny][1 + nx]. */
    CML_GLOBAL const cml_u32 *image_words;
#ifndef __OPENCL_VERSION__
    struct cml_contacts contacts;
    struct cml_detection detection;
    struct cml_rows rows;
    int only_tables;                              /* 1: every medium that scatters has a phase table */
    cml_mesh_intersect *intersect_mesh;           /* NULL if no surface is a mesh */
    const struct cml_mesh_surface *const *meshes; /* by surface; NULL for a surface that is no mesh */
    const struct cml_safe_cells *safe_cells;      /* [num_layers + 1] by boundary */
    const struct cml_known_path *known_path;      /* answer that is known without a search; NULL: none */
    /* Expected values below a level (P15); read only if they are wanted. */
    struct cml_tail tail;
    struct cml_weight_windows windows;
    /* Called at each event of a packet that is traced; NULL: no packet is traced. */
    void (*on_event)(void *context, const char *what, const struct cml_packet *packet);
    void *on_event_context;
#endif
};
