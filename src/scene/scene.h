/* The scene: what one run of an .mci file describes. Its reader makes it (input/mci.h); from then on it is
 * immutable, and everyone else has a pointer to a const one.
 * Lengths in cm, coefficients in 1/cm, z down. Media 0..L+1, boundaries 0..L; boundary b lies between medium
 * b (above) and medium b+1 (below) at the nominal depth z_b = d_1 + ... + d_b. Bodies lie inside layers.
 * Knows no files, engines or rays. SPDX-License-Identifier: MIT */
#pragma once

#include "boundary.h"
#include "scene/heightmap/tile.h"
#include "geometry/mesh.h"
#include "scene/phase.h"
#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

/* The smallest mua / (mua + mus) but 0: less is lost in the rounding of integer weights (kernels/walk.h,
 * cml_absorbed_part). */
#define CML_LEAST_ABSORPTION 1e-11

/* Facets below the resolution of a shape (kernels/README.md, P20). kind CML_SMOOTH: no line says anything.
 */
struct cml_rough_def {
    enum cml_rough_kind kind;
    double alpha; /* 0 is smooth, else 1e-4..2 */
    int line;     /* of the .mci */
};

struct cml_medium_def {
    double n;        /* refractive index [-], > 0 */
    double mua, mus; /* absorption, scattering coefficient [1/cm], >= 0; 0 in the media above and below */
    double g;        /* anisotropy [-], -1..1 */
    double d;        /* thickness [cm], >= 0; 0 in the media above and below */
    const struct cml_phase *phase; /* the scene's; NULL: Henyey and Greenstein's, of g */
    struct cml_rough_def rough;    /* of a body: of its surface, as bodies are shared by copies of a scene */
    int line, phase_line;          /* of the .mci: where its numbers stand, and which says how it scatters */
};

/* Attenuation, 1/cm: its inverse is the mean free path. 0: the medium is transparent. */
static inline double cml_medium_mut(const struct cml_medium_def *medium)
{
    return medium->mua + medium->mus;
}

/* Transport attenuation, 1/cm: after its inverse light has forgotten where it came from. */
static inline double cml_medium_mutr(const struct cml_medium_def *medium)
{
    const double mean_cosine = medium->phase ? cml_phase_mean(medium->phase) : medium->g;
    return medium->mua + medium->mus * (1 - mean_cosine);
}

/* n samples (r_i, h_i), r_0 = 0, radii strictly rising; heights count against z: surface z(r) = z_b - h(r),
 * linear between samples, h_{n-1} beyond r_{n-1}. */
struct cml_radial {
    int n;
    double *r, *h; /* [n] cm */
};

enum cml_boundary_form { CML_FORM_PLANE, CML_FORM_RADIAL, CML_FORM_MESH, CML_FORM_TILE };

struct cml_boundary {
    enum cml_boundary_form form; /* as the user gave it; a representation is chosen later (surface.h) */
    double z;                    /* nominal depth, cm */
    struct cml_radial radial;    /* CML_FORM_RADIAL */
    struct cml_mesh mesh;        /* CML_FORM_MESH, prepared, in the boundary's frame */
    struct cml_mesh_notes mesh_notes;
    struct cml_heightmap_notes map_notes; /* of the heightmap that the mesh was made of; zero: of none */
    struct cml_heightmap tile;            /* CML_FORM_TILE: one period; heights count up from z */
    enum cml_normals tile_normals;
    struct cml_tile_notes tile_notes;
    double period[2]; /* of a tile, cm along x and y, also once it has become a plane; 0: it was none */
    double scale,
        height; /* factors that the shape was read with, on all coordinates and on heights besides */
    struct cml_rough_def rough;
    char *file; /* the .obj, .gsf, .asc or height file, NULL when the numbers stand in the .mci */
    int line;   /* line of the .mci, 0 when the boundary is implicit */
    int *users; /* boundaries that share shape and file (base/shared.h) */
};

enum cml_body_form { CML_BODY_MESH, CML_BODY_SPHERE, CML_BODY_CYLINDER };

/* What lies under the last boundary and sends light back; the medium below is opaque then. */
struct cml_backing_def {
    enum cml_backing_kind kind;
    double R;    /* share that comes back, 0..1; mirror, lambertian */
    double n, k; /* index n + i k relative to vacuum; metal */
    int line;    /* of the .mci */
};

/* A body: a medium of its own inside a layer or inside another body of that layer. In scene coordinates, cm,
 * z down. */
struct cml_scene_body {
    enum cml_body_form form;
    int layer; /* 1..L: the one it lies in, at whatever depth of nesting */
    int host;  /* the medium it lies in: that layer, or the medium of a body (cml_scene_place_bodies) */
    double centre[3]; /* of a sphere; of a cylinder the middle of its first end */
    double end[3];    /* of a cylinder: the middle of the other end */
    double radius;
    struct cml_mesh mesh; /* CML_BODY_MESH, prepared and closed */
    struct cml_mesh_notes mesh_notes;
    char *file; /* the .obj file, or NULL */
    int line;   /* line of the .mci */
};

/* Directions of a beam's light about its axis. */
enum cml_light_kind {
    CML_LIGHT_OF_PARALLEL,
    CML_LIGHT_OF_NA,         /* evenly per solid angle within a numerical aperture */
    CML_LIGHT_OF_LAMBERTIAN, /* cosine law over the hemisphere */
    CML_LIGHT_OF_ISOTROPIC,  /* evenly over the sphere */
    CML_LIGHT_OF_TABLE
};

struct cml_light {
    enum cml_light_kind kind;
    double na; /* CML_LIGHT_OF_NA: n sin of the widest angle */
    int rows;  /* CML_LIGHT_OF_TABLE, 2 or more */
    double *t,
        *intensity; /* [rows] rad, rising from 0; per solid angle, >= 0, not all 0; linear between rows */
};

struct cml_beam {
    enum cml_beam_shape shape; /* lies across the axis, centred on it */
    double size[2]; /* cm; radius of a disk, 1/e^2 radius of a gaussian; both radii of a ring; widths of a
                     * rectangle or an image along the own x and y */
    double x, y, z; /* cm; where the axis meets z = 0, or the middle of the shape */
    bool inside;    /* packets start at the middle and around it, else above all surfaces */
    double angle,
        azimuth; /* rad; angle between the axis and +z, 0 <= angle < pi/2, inside up to pi; azimuth
                  * from +x to +y. Own x: (cos a cos p, cos a sin p, -sin a), own y: (-sin p, cos p, 0) */
    struct cml_light light;
    int columns, rows; /* of an image */
    double *pixel;     /* [rows][columns] >= 0, not all 0; the first row at the largest own y */
    int *users;        /* beams that share pixels and the table of their light */
    bool of_tile;      /* a rectangle whose size is one period of the tiles, as seen from above */
    bool radial;       /* results count r from x, y instead of from the z axis */
    bool given;        /* a `beam` line stands in the file */
    int line;          /* of the .mci */
};

/* What is recorded over x and y, centred on 0, 0. */
struct cml_map_def {
    int nx, ny;    /* pixels; 0: no map line */
    double dx, dy; /* cm */
    bool angles;   /* every pixel has the run's na angle bins */
    bool volume;   /* A(x, y, z) too, nz bins of dz below `top` */
    double top;    /* depth of the volume's upper face, cm */
    int line;      /* of the .mci */
};

/* Gates of time from 0 to `end`, all as long, and one for what is later. */
struct cml_time_def {
    int gates;  /* 0: no time line */
    double end; /* ps */
    bool radii; /* what leaves is wanted by radius and gate, too */
    int line;   /* of the .mci */
};

/* Directions of what leaves: even bins of the angle from the outward vertical and of the azimuth. */
struct cml_directions_def {
    int nt, np; /* 0: no directions line */
    int line;   /* of the .mci */
};

/* Whether the scene asks for fluence, in the bins of A_rz. */
struct cml_fluence_def {
    int line;   /* of the .mci; 0: no fluence line */
    bool times; /* by gates, too */
};

/* Packets that have left, one by one, in a file of their own. */
struct cml_saved_def {
    char *name;     /* NAME.photons.h5 */
    uint64_t limit; /* of rows; 0: no photons line */
    bool detected;  /* only what a detector sees */
    int line;       /* of the .mci */
};

/* What sees light that leaves on one side, where the line of its last flight crosses a level plane, at any
 * angle or about an axis. */
struct cml_detector_def {
    char *name;
    enum cml_detector_shape shape;
    bool ring;        /* the line has two radii, of which the first may be 0 */
    double size[2];   /* cm; both radii of a ring, a disk's first one 0; lengths of a rectangle or pixel */
    int nx, ny;       /* pixels of a map; else 1 */
    double x, y, z;   /* cm, of the middle; the scene's */
    bool below, at_z; /* on the bottom side; z was given, else it is the side's nominal plane */
    bool aimed;       /* sees a cone about the axis, else all angles */
    double na;        /* n sin of its widest angle; n or more: the half space about the axis */
    double angle;     /* rad, 0 to pi/2; of the axis, along which light goes, to the outward vertical */
    double azimuth;   /* rad */
    bool diffuse;     /* no light that never was in the material */
    int line;         /* of the .mci */
    char *table;      /* the file whose line `row` says all this; NULL: the .mci */
    int row;
};

/* The speed of light in vacuum, cm/ps. */
#define CML_LIGHT_CM_PER_PS 0.0299792458

/* Bytes of a layer's name with its final NUL. */
enum { CML_LAYER_NAME = 25 };

struct cml_scene {
    char *file;       /* the .mci, for messages and names beside it */
    int line;         /* where the run begins */
    char *output;     /* output name as written */
    char format;      /* 'A' or 'B' */
    uint64_t photons; /* 1..2^48 */
    double dz, dr;    /* cm, > 0 */
    int nz, nr, na;   /* >= 1 */
    int num_layers;   /* L >= 1 */
    int num_bodies;
    char (*layer_names)[CML_LAYER_NAME]; /* [L+1] "": layer l has none; NULL: no layer has one */
    struct cml_medium_def *media;    /* [L+2+num_bodies], layers, outer media and bodies: body k is L+2+k */
    struct cml_phase *phases;        /* all that differ, the last one first; at most CML_MOST_PHASES */
    struct cml_boundary *boundaries; /* [L+1] */
    struct cml_scene_body *bodies;   /* [num_bodies], layer after layer */
    int *body_users;                 /* scenes that share them */
    struct cml_backing_def backing;
    int num_beams;          /* >= 1 */
    struct cml_beam *beams; /* [num_beams] */
    double *shares;         /* [num_beams] > 0, of the light */
    struct cml_map_def map;
    struct cml_time_def time;
    struct cml_directions_def directions;
    int num_detectors;
    struct cml_detector_def *detectors; /* [num_detectors] */
    struct cml_fluence_def fluence;
    struct cml_saved_def saved;
    int facets;     /* line of the .mci by which irradiance and exitance of all facets are wanted; 0: none */
    char *text;     /* the data lines of the run as written, joined with line feeds: provenance */
    char *settings; /* what was set from outside the file, a "NAME = VALUE" a line; NULL: nothing */
};

/* Whether light meets facets there: 0 is smooth. */
static inline bool cml_is_rough(const struct cml_rough_def *rough)
{
    return rough->kind != CML_SMOOTH && rough->alpha > 0;
}

/* The word of the .mci; "": smooth. */
static inline const char *cml_rough_word(enum cml_rough_kind kind)
{
    static const char *const words[] = {"", "ggx", "beckmann"};
    return words[kind];
}

struct cml_scene_list {
    int count;
    struct cml_scene *scenes; /* [count] */
};

/* A scene that may be changed; shapes, bodies and tables are shared. On failure *to is empty. */
CML_NODISCARD cml_status cml_scene_copy(const struct cml_scene *from, struct cml_scene *to,
                                        struct cml_error *err);

void cml_scene_clear(struct cml_scene *scene);
void cml_scene_list_clear(struct cml_scene_list *list);

/* The name of layer l, 1..L; "": it has none. */
static inline const char *cml_layer_name(const struct cml_scene *scene, int l)
{
    return scene->layer_names ? scene->layer_names[l] : "";
}

/* Medium of body k. */
static inline int cml_body_medium(const struct cml_scene *scene, int k)
{
    return scene->num_layers + 2 + k;
}

/* The largest angle to its axis at which a light shines, rad. medium_n: of the medium it starts in. */
double cml_light_widest(const struct cml_light *light, double medium_n);

/* The angle from the axis, rad, of the rays at a beam's sides in a picture: the widest; of a table the last
 * that has half of its largest intensity, as tables end where hardly anything is left. */
double cml_light_spread(const struct cml_light *light, double medium_n);

/* Depth of the plane in which the boundary goes on outside its shape; mean depth of a tile; cm. */
double cml_outer_depth(const struct cml_boundary *boundary);

/* Whether any beam starts at its place (z=) instead of above all surfaces. */
bool cml_scene_starts_inside(const struct cml_scene *scene);

/* Sine and cosine of the angle between the axis of a beam and +z; 0 where they are. */
double cml_beam_sine(const struct cml_beam *beam);
double cml_beam_descent(const struct cml_beam *beam);

/* How far above and below its middle the packets of a slanted shape start, cm; few of a Gaussian start beyond
 * five of its radii. */
double cml_beam_height(const struct cml_beam *beam);

/* The axes of the scene, 0 for x and 1 for y, along which the own x and y of a beam run seen from above.
 * False when the azimuth is no multiple of 90 degrees. */
bool cml_beam_axes(const struct cml_beam *beam, int axis[2]);

/* The bodies of layer l, at whatever depth of nesting: those from number `first` to before `end`. */
struct cml_body_range {
    int first, end;
};
struct cml_body_range cml_layer_bodies(const struct cml_scene *scene, int l);

/* Whether any body lies in layer l; the media above and below, 0 and L + 1, have none. */
bool cml_layer_has_bodies(const struct cml_scene *scene, int l);

/* How many packets a run of so many photons saves at most: each photon is one packet. */
static inline uint64_t cml_most_saved(const struct cml_scene *scene, uint64_t photons)
{
    return scene->saved.limit < photons ? scene->saved.limit : photons;
}

/* Leaves out what only some scenes ask for: map, volume, facets, time, directions, fluence, detectors,
 * photons. Of a copy, which is not to be cleared. */
void cml_scene_ask_nothing(struct cml_scene *scene);

/* For readers, of a scene that is not complete yet: frees the boundary's shape, which it shares with none,
 * and leaves its nominal plane, and where it stands in the file. */
void cml_boundary_flatten(struct cml_boundary *boundary);

/* Leaves the shape and its file to others who share them, or frees them; of *boundary only z is left. */
void cml_boundary_clear(struct cml_boundary *boundary);

/* Whether two that a reader made share their shape, or have none. */
static inline bool cml_boundary_same_shape(const struct cml_boundary *one, const struct cml_boundary *other)
{
    return one->users == other->users;
}

/* Height h(r) of a radial heightfield, cm; r >= 0. */
double cml_radial_height(const struct cml_radial *radial, double r);

/* Boundaries must not cross or touch each other, nor themselves; boundary b lies above b+1 everywhere. Planes
 * (flat fields and meshes too) may touch: layers of no thickness. What holds for neighbours holds for all, so
 * only those are compared, and the next ones beyond planes. Exact for the coordinates as given (overlap.c).
 * CML_E_INPUT: "FILE: boundaries 0 and 1 cross at (x y z) cm: boundary 0 reaches D cm below boundary 1",
 * "FILE: boundaries 0 and 1 touch at (x y z) cm", "FILE:LINE: boundary 0 crosses itself at (x y z) cm:
 * triangles i and j". A tile is compared with planes and with tiles of the same cells; where its depths
 * overlap those of anything else it is refused. */
CML_NODISCARD cml_status cml_scene_check_overlap(const struct cml_scene *scene, struct cml_error *err);

/* The steepest slope of radial heightfields and heightmaps, and the most that a mesh may be higher than it is
 * wide; why: steepness.c. CML_E_INPUT: "FILE:LINE: boundary 0: slope 6000 at x = 0.1, y = 0 cm (expected at
 * most 5000: ...)". */
#define CML_STEEPEST 5000.0
CML_NODISCARD cml_status cml_scene_check_steepness(const struct cml_scene *scene, struct cml_error *err);
