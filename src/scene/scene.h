/* The scene: the description of one run of an .mci file. The reader (input/mci.h) makes it; from then on a
 * scene is immutable, and all others hold a pointer to a const scene. Knows no files, engines or rays.
 * Lengths are in cm, coefficients in 1/cm; z points down. Bodies lie inside layers. Media and boundaries are
 * numbered from above:
 *
 *     medium 0
 *     ------------- boundary 0, z_0 = 0
 *     medium 1 = layer 1
 *     ------------- boundary 1, nominal depth z_1 = d_1
 *        ...
 *     medium L = layer L
 *     ------------- boundary L, nominal depth z_L = d_1 + ... + d_L
 *     medium L + 1
 * SPDX-License-Identifier: MIT */
#pragma once

#include "boundary.h"
#include "scene/heightmap/tile.h"
#include "geometry/mesh.h"
#include "scene/phase.h"
#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

/* The smallest allowed mua / (mua + mus) other than 0. A smaller absorption would be lost in the rounding of
 * integer weights (kernels/walk.h, cml_absorbed_part). */
#define CML_LEAST_ABSORPTION 1e-11

/* Roughness of a surface by facets too small for its shape to resolve (rule P20). kind CML_SMOOTH: no
 * roughness is given. */
struct cml_rough_def {
    enum cml_rough_kind kind;
    double alpha; /* roughness parameter: 0 is smooth, else 1e-4..2 */
    int line;     /* line number in the .mci */
};

/* A medium: a layer, one of the outer media, or a body. */
struct cml_medium_def {
    double n;        /* refractive index [-], > 0 */
    double mua, mus; /* absorption and scattering coefficient [1/cm], >= 0; 0 in the media above and below */
    double g;        /* anisotropy [-], -1..1 */
    double d;        /* thickness [cm], >= 0; 0 in the media above and below */
    /* Phase function, owned by the scene; NULL: Henyey and Greenstein's with g. */
    const struct cml_phase *phase;
    /* Roughness of a body's surface; kept here because copies of a scene share the bodies themselves. */
    struct cml_rough_def rough;
    /* Line numbers in the .mci: of the medium's numbers, and of its phase function. */
    int line, phase_line;
};

/* Returns the attenuation mua + mus, 1/cm, the inverse of the mean free path. 0: the medium is
 * transparent. */
static inline double cml_medium_mut(const struct cml_medium_def *medium)
{
    return medium->mua + medium->mus;
}

/* Returns the transport attenuation, 1/cm. Its inverse is the distance after which light has lost its
 * original direction. */
static inline double cml_medium_mutr(const struct cml_medium_def *medium)
{
    const double mean_cosine = medium->phase ? cml_phase_mean(medium->phase) : medium->g;
    return medium->mua + medium->mus * (1 - mean_cosine);
}

/* A radial heightfield of n samples (r_i, h_i) with r_0 = 0 and strictly rising radii. Heights count upwards,
 * against z: the surface is z(r) = z_b - h(r). h is linear between samples and stays h_{n-1} beyond
 * r_{n-1}. */
struct cml_radial {
    int n;
    double *r, *h; /* [n] radii and heights, cm */
};

/* Forms of a boundary. */
enum cml_boundary_form { CML_FORM_PLANE, CML_FORM_RADIAL, CML_FORM_MESH, CML_FORM_TILE };

/* A boundary between two media. */
struct cml_boundary {
    /* Form in the input; its representation for rays is chosen later (surface.h). */
    enum cml_boundary_form form;
    double z;                 /* nominal depth, cm */
    struct cml_radial radial; /* CML_FORM_RADIAL: samples of the heightfield */
    struct cml_mesh mesh;     /* CML_FORM_MESH: the prepared mesh, in the boundary's frame */
    struct cml_mesh_notes mesh_notes;
    /* The heightmap that the mesh was made from; all zero if there was none. */
    struct cml_heightmap_notes map_notes;
    struct cml_heightmap tile; /* CML_FORM_TILE: one period; heights count up from z */
    enum cml_normals tile_normals;
    struct cml_tile_notes tile_notes;
    /* Period of a tile along x and y, cm, kept even if the tile has become a plane; 0: not a tile. */
    double period[2];
    /* Factors that the input applied: to all coordinates, and to the heights in addition. */
    double scale, height;
    struct cml_rough_def rough;
    char *file; /* the mesh, heightmap or height file; NULL if the numbers stand in the .mci */
    int line;   /* line number in the .mci; 0: the boundary is implicit */
    int *users; /* reference count of boundaries that share shape and file (base/shared.h) */
};

/* True if the input gives the boundary a shape: only such a boundary has a line. */
static inline bool cml_boundary_has_shape(const struct cml_boundary *boundary)
{
    return boundary->line > 0;
}

enum cml_body_form { CML_BODY_MESH, CML_BODY_SPHERE, CML_BODY_CYLINDER };

/* An opaque surface that sends light back: the backing under the last boundary, or a face on boundary 0. */
struct cml_backing_def {
    enum cml_backing_kind kind;
    double R;    /* mirror, lambertian: share of the light that comes back, 0..1 */
    double n, k; /* metal: refractive index n + i k relative to vacuum */
    int line;    /* line number in the .mci */
};

/* The largest number of faces and ports. */
#define CML_MOST_CONTACTS 1000

/* A face or a port: what touches boundary 0 from above. A face is opaque; a port is a medium that fills all
 * above its place. A later one lies on top. */
struct cml_contact_def {
    bool port;
    bool whole;                    /* a face that covers the whole plane and has no shape */
    enum cml_detector_shape shape; /* CML_DETECTOR_RING or CML_DETECTOR_RECTANGLE */
    bool ring;                     /* the line has two radii, of which the first may be 0 */
    double size[2];                /* both radii of a ring (a disk: the first is 0), or both sides; cm */
    double x, y;                   /* middle, cm */
    double n;                      /* port: refractive index of its medium */
    struct cml_backing_def face;   /* face: its surface */
    char *name;                    /* port: its name; NULL: face */
    int line;                      /* line number in the .mci */
};

/* A body: a medium of its own inside a layer, or inside another body of that layer. Scene coordinates, cm, z
 * down. */
struct cml_scene_body {
    enum cml_body_form form;
    int layer; /* layer that contains the body, 1..L, even if the body lies inside another body */
    /* Medium directly around the body: its layer, or the medium of another body (cml_scene_place_bodies). */
    int host;
    double centre[3]; /* centre of a sphere; middle of the first end of a cylinder */
    double end[3];    /* middle of the other end of a cylinder */
    double radius;
    struct cml_mesh mesh; /* CML_BODY_MESH: the mesh, prepared and closed */
    struct cml_mesh_notes mesh_notes;
    char *file; /* the file of a mesh, or NULL */
    int line;   /* line number in the .mci */
};

/* Angular distributions of a beam's light about its axis. */
enum cml_light_kind {
    CML_LIGHT_OF_PARALLEL,
    CML_LIGHT_OF_NA,         /* evenly per solid angle within a numerical aperture */
    CML_LIGHT_OF_LAMBERTIAN, /* cosine law over the hemisphere */
    CML_LIGHT_OF_ISOTROPIC,  /* evenly over the sphere */
    CML_LIGHT_OF_TABLE
};

/* The angular distribution of a beam's light. */
struct cml_light {
    enum cml_light_kind kind;
    double na; /* CML_LIGHT_OF_NA: n times the sine of the widest angle */
    int rows;  /* CML_LIGHT_OF_TABLE: number of rows, 2 or more */
    /* [rows] angle in rad, rising from 0; intensity per solid angle, >= 0, not all 0; linear between
     * rows */
    double *t, *intensity;
};

/* A beam: a source of light with a shape, an axis and an angular distribution. */
struct cml_beam {
    enum cml_beam_shape shape; /* shape of the beam's cross section, centred on its axis */
    /* Size of the shape, cm: the radius of a disk; the 1/e^2 radius of a gaussian; both radii of a ring; the
     * widths of a rectangle or an image along the beam's own x and y. */
    double size[2];
    double x, y, z; /* place where the axis meets z = 0, or with `inside` the middle of the shape; cm */
    bool inside;    /* packets start at and around the middle; else above all surfaces */
    /* Direction of the axis, rad. angle: between the axis and +z, 0 <= angle < pi/2; with `inside` up to
     * pi. azimuth: from +x to +y. The beam's own x is (cos a cos p, cos a sin p, -sin a), its own y (-sin
     * p, cos p, 0). */
    double angle, azimuth;
    struct cml_light light;
    int columns, rows; /* size of an image in pixels */
    double *pixel;     /* [rows][columns] brightness >= 0, not all 0; the first row has the largest own y */
    char *port;        /* name of the port that the light comes from; NULL: none */
    int contact;       /* number of this port among the faces and ports, from 1; 0: none */
    int *users;        /* reference count of beams that share pixels, the table of their light and `port` */
    bool of_tile;      /* rectangle of the size of one period of the tiles, as seen from above */
    bool radial;       /* results count the radius r from the beam's x, y; else from the z axis */
    bool given;        /* a `beam` line stands in the file */
    int line;          /* line number in the .mci */
};

/* The map: a grid of pixels over x and y, centred on 0, 0, that records light leaving the scene. */
struct cml_map_def {
    int nx, ny;    /* number of pixels; 0: the scene has no map line */
    double dx, dy; /* size of a pixel, cm */
    bool angles;   /* every pixel is divided into the run's na angle bins */
    bool volume;   /* absorption A(x, y, z) is recorded, too, in nz bins of dz below `top` */
    double top;    /* depth of the volume's upper face, cm */
    int line;      /* line number in the .mci */
};

/* Time gates: equal gates from 0 to `end`, and one more for all later light. */
struct cml_time_def {
    int gates;  /* number of gates; 0: the scene has no time line */
    double end; /* end of the last equal gate, ps */
    bool radii; /* light that leaves is also recorded by radius and gate (Rd_rt, Tt_rt) */
    int line;   /* line number in the .mci */
};

/* The grid of exit directions: equal bins of the angle to the outward vertical and of the azimuth. */
struct cml_directions_def {
    int nt, np; /* number of bins of angle and azimuth; 0: the scene has no directions line */
    int line;   /* line number in the .mci */
};

/* The request for fluence, which is recorded in the bins of A_rz. */
struct cml_fluence_def {
    int line;   /* line number in the .mci; 0: the scene has no fluence line */
    bool times; /* fluence is recorded by time gate, too */
};

/* The request to save packets that have left, one by one, in a file of their own. */
struct cml_saved_def {
    char *name;     /* file name, NAME.photons.h5 */
    uint64_t limit; /* largest number of rows; 0: the scene has no photons line */
    bool detected;  /* only packets that a detector sees are saved */
    int line;       /* line number in the .mci */
};

/* Size of a detector's name in bytes, with its final NUL. */
enum { CML_DETECTOR_NAME = 25 };

/* A detector: an area in a level plane above or below the scene. It sees light that leaves on its side if the
 * straight line of the last flight crosses the area, at any angle or within a cone. A group is a detector
 * without an area: it sees what its members see, all on one side. */
struct cml_detector_def {
    char *name;
    char group[CML_DETECTOR_NAME]; /* name of the group of which the detector is a member, or "" */
    int in_group;                  /* number of this group among the detectors, from 1; 0: none */
    enum cml_detector_shape shape;
    bool ring;  /* the line has two radii, of which the first may be 0 */
    bool round; /* CML_DETECTOR_PORT: the port is a ring or a disk */
    /* Both radii of a ring (a disk: the first is 0), or both side lengths of a rectangle or pixel; cm. */
    double size[2];
    int nx, ny;     /* number of pixels of a map; 1 for other shapes */
    double x, y, z; /* centre of the area in scene coordinates, cm */
    /* below: the detector is on the bottom side. at_z: the input gives z; else z is the nominal plane of the
     * side. */
    bool below, at_z;
    bool aimed; /* the detector sees only a cone about its axis; else all angles */
    double na;  /* numerical aperture, n sin(widest angle); n or more: the half space about the axis */
    /* Angle between the axis, which points along the light, and the outward vertical, 0 to pi/2 rad. */
    double angle;
    double azimuth; /* azimuth of the axis, rad */
    bool diffuse;   /* light that never entered the material is ignored */
    int line;       /* line number in the .mci */
    char *port;     /* CML_DETECTOR_PORT: name of the port */
    int contact;    /* CML_DETECTOR_PORT: its number among the faces and ports, from 1 */
    char *table;    /* table file whose line `row` describes the detector; NULL: the .mci does */
    int row;
};

/* True if a detector's area is a ring or a disk. */
static inline bool cml_detector_is_round(const struct cml_detector_def *detector)
{
    return detector->shape == CML_DETECTOR_RING || (detector->shape == CML_DETECTOR_PORT && detector->round);
}

/* The speed of light in vacuum, cm/ps. */
#define CML_LIGHT_CM_PER_PS 0.0299792458

/* Size of a layer's name in bytes, with its final NUL. */
enum { CML_LAYER_NAME = 25 };

/* A scene: all that one run of an .mci file describes. */
struct cml_scene {
    char *file;       /* path of the .mci, for messages and for names relative to it */
    int line;         /* line number where the run begins */
    char *output;     /* output name as the .mci gives it */
    char format;      /* format letter as the .mci gives it, 'A' or 'B' */
    uint64_t photons; /* number of photons, 1..2^48 */
    double dz, dr;    /* grid spacing, cm, > 0 */
    int nz, nr, na;   /* number of grid bins, >= 1 */
    int num_layers;   /* number of layers L, >= 1 */
    int num_bodies;
    /* [L+1] names by layer, "" if a layer has none; NULL: no layer has a name */
    char (*layer_names)[CML_LAYER_NAME];
    /* [L+2+num_bodies] medium above, layers, medium below, bodies: body k has medium L+2+k */
    struct cml_medium_def *media;
    /* List of the different phase functions, the last one first; at most CML_MOST_PHASES. */
    struct cml_phase *phases;
    struct cml_boundary *boundaries; /* [L+1] boundaries 0..L */
    struct cml_scene_body *bodies;   /* [num_bodies] sorted by layer */
    int *body_users;                 /* reference count of scenes that share the bodies */
    struct cml_backing_def backing;
    int num_contacts;
    struct cml_contact_def *contacts; /* [num_contacts] faces and ports, in the order of the lines */
    int num_beams;                    /* number of beams, >= 1 */
    struct cml_beam *beams;           /* [num_beams] beams */
    double *shares;                   /* [num_beams] share of the light of each beam, > 0 */
    struct cml_map_def map;
    struct cml_time_def time;
    struct cml_directions_def directions;
    int num_detectors;
    int num_groups;                     /* number of groups, which are the last of the detectors */
    struct cml_detector_def *detectors; /* [num_detectors] detectors */
    struct cml_fluence_def fluence;
    struct cml_saved_def saved;
    /* Line number of the `facets` line, which asks for irradiance and exitance of all facets; 0: none. */
    int facets;
    char *text;     /* data lines of the run as written, joined with line feeds: the result's provenance */
    char *settings; /* settings from outside the file (--set), a line "NAME = VALUE" each; NULL: none */
};

/* True if the surface has rough facets, that is if its alpha is above 0. */
static inline bool cml_is_rough(const struct cml_rough_def *rough)
{
    return rough->kind != CML_SMOOTH && rough->alpha > 0;
}

/* Returns the word of a kind of roughness in the .mci, "" for smooth. */
static inline const char *cml_rough_word(enum cml_rough_kind kind)
{
    static const char *const words[] = {"", "ggx", "beckmann"};
    return words[kind];
}

/* The scenes of all runs of an .mci file. */
struct cml_scene_list {
    int count;
    struct cml_scene *scenes; /* [count] scenes */
};

/* Copies a scene, so that the copy may be changed. Both share shapes, bodies and tables. On failure *to is
 * empty. */
CML_NODISCARD cml_status cml_scene_copy(const struct cml_scene *from, struct cml_scene *to,
                                        struct cml_error *err);

void cml_scene_clear(struct cml_scene *scene);
void cml_scene_list_clear(struct cml_scene_list *list);

/* Returns the number of detectors that have an area: all but the groups. */
static inline int cml_num_areas(const struct cml_scene *scene)
{
    return scene->num_detectors - scene->num_groups;
}

/* Returns the name of layer l, 1..L, or "" if the layer has none. */
static inline const char *cml_layer_name(const struct cml_scene *scene, int l)
{
    return scene->layer_names ? scene->layer_names[l] : "";
}

/* Returns the number of the medium of body k. */
static inline int cml_body_medium(const struct cml_scene *scene, int k)
{
    return scene->num_layers + 2 + k;
}

/* Returns the largest angle between a beam's rays and its axis, rad. medium_n: index of the medium where the
 * light starts. */
double cml_light_widest(const struct cml_light *light, double medium_n);

/* Returns the angle from the axis, rad, of the rays that a picture draws at a beam's sides. This is the
 * widest angle; for a table, the largest angle with half of the maximum intensity, because tables end where
 * hardly any light is left. */
double cml_light_spread(const struct cml_light *light, double medium_n);

/* Returns the height above its nominal depth of the plane that continues a boundary outside its shape, for a
 * tile its mean height; cm. */
double cml_outer_height(const struct cml_boundary *boundary);

/* Returns the depth of this plane, cm. */
static inline double cml_outer_depth(const struct cml_boundary *boundary)
{
    return boundary->z - cml_outer_height(boundary);
}

/* True if any beam starts inside the scene, at its own z, instead of above all surfaces. */
bool cml_scene_starts_inside(const struct cml_scene *scene);

/* Return the sine and the cosine of the angle between a beam's axis and +z, exactly 0 at pi and at pi/2. */
double cml_beam_sine(const struct cml_beam *beam);
double cml_beam_descent(const struct cml_beam *beam);

/* Returns the height above and below its middle at which packets of a slanted beam shape start, cm. For a
 * Gaussian this is taken at five radii, beyond which few packets start. */
double cml_beam_height(const struct cml_beam *beam);

/* Sets axis[0] and axis[1] to the scene's axes (0: x, 1: y) along which the beam's own x and y run, seen from
 * above. Returns false if the azimuth is not a multiple of 90 degrees. */
bool cml_beam_axes(const struct cml_beam *beam, int axis[2]);

/* The bodies of layer l, nested ones included: numbers `first` to `end` - 1. */
struct cml_body_range {
    int first, end;
};
struct cml_body_range cml_layer_bodies(const struct cml_scene *scene, int l);

/* True if any body lies in layer l; false for the media above and below, 0 and L + 1. */
bool cml_layer_has_bodies(const struct cml_scene *scene, int l);

/* Returns the largest number of packets that a run saves. Each photon is one packet. */
static inline uint64_t cml_most_saved(const struct cml_scene *scene, uint64_t photons)
{
    return scene->saved.limit < photons ? scene->saved.limit : photons;
}

/* Removes all optional requests from a copy of a scene: map, volume, facets, time, directions, fluence,
 * detectors, photons. The copy must not be cleared afterwards, because the removed members belong to the
 * original. */
void cml_scene_ask_nothing(struct cml_scene *scene);

/* Frees a boundary's shape, which no other boundary may share, and turns it into its nominal plane. Keeps its
 * line number. For readers, while a scene is incomplete. */
void cml_boundary_flatten(struct cml_boundary *boundary);

/* Releases a boundary's shape and file, or frees them if nobody else shares them. Only z and the roughness
 * stay. */
void cml_boundary_clear(struct cml_boundary *boundary);

/* True if two boundaries made by a reader share one shape, or both have none. */
static inline bool cml_boundary_same_shape(const struct cml_boundary *one, const struct cml_boundary *other)
{
    return one->users == other->users;
}

/* Returns the height h(r) of a radial heightfield, cm, for r >= 0. */
double cml_radial_height(const struct cml_radial *radial, double r);

/* Checks that no boundary crosses or touches itself or another one, and that boundary b lies above b+1
 * everywhere. Planes (also flat heightfields and meshes) may touch: layers of no thickness. Only neighbours
 * are compared, and the next boundaries beyond planes, because order among neighbours implies order among
 * all. Exact for the coordinates as given (overlap.c). A tile is compared with planes and with tiles of the
 * same cells; a tile whose depths overlap those of any other surface is refused. CML_E_INPUT: "FILE:LINE:
 * boundaries 0 and 1 cross at (x y z) cm: boundary 0 reaches D cm below boundary 1", "FILE:LINE: boundaries 0
 * and 1 touch at (x y z) cm", "FILE:LINE: boundary 0 crosses itself at (x y z) cm: triangles i and j". */
CML_NODISCARD cml_status cml_scene_check_overlap(const struct cml_scene *scene, struct cml_error *err);

/* The largest allowed slope of radial heightfields and heightmaps, and the largest ratio of height to width
 * of a mesh; steepness.c gives the reason. CML_E_INPUT: "FILE:LINE: boundary 0: slope 6000 at x = 0.1, y = 0
 * cm (expected at most 5000: ...)". */
#define CML_STEEPEST 5000.0
CML_NODISCARD cml_status cml_scene_check_steepness(const struct cml_scene *scene, struct cml_error *err);
