/* Every key of a scene's lines, a row for each. SPDX-License-Identifier: MIT */
#include "input/keys/key.h"

#include "input/mesh/mesh_file.h"
#include "scene/heightmap/random_relief.h"
#include "scene/scene.h"

#define BIG CML_MCI_HUGE
#define TINY CML_MCI_TINY
#define WIDE 1e18 /* cm; squares of radii and distances must have room in single precision */

enum {
    POS = CML_KEY_PLACED,
    OPT = CML_KEY_OPTION,
    SET = CML_KEY_SET,
    JSON = CML_KEY_JSON,
    OR_0 = CML_KEY_OR_0,
    ABOVE = CML_KEY_ABOVE,
    BELOW = CML_KEY_BELOW,
    ALONE = CML_KEY_ALONE
};

const struct cml_key_owner cml_key_owners[CML_NUM_KEY_GROUPS] = {{0},
#define CML_OWNER(group, line, set) {line, set},
                                                                 CML_KEY_GROUPS(CML_OWNER)
#undef CML_OWNER
};

/* Group, name, name in messages, type, use, struct, member, noun, range, unit, default, meaning. */
#define ROW(group, name, shown, type, use, of, member, noun, least, most, unit, fallback, meaning)           \
    {                                                                                                        \
        CML_KEYS_##group, name, shown, CML_KEY_##type, use, offsetof(struct cml_##of, member), noun, least,  \
            most, unit, fallback, meaning                                                                    \
    }
#define COUNT "a whole number"
#define LENGTH "a length"
#define COORD "a coordinate"
#define NA "a numerical aperture"

/* clang-format off */
const struct cml_key cml_key_table[] = {
    {CML_KEYS_RUNS, "number of runs", NULL, CML_KEY_INT, POS, 0, COUNT, 1, 32767, NULL, NULL, "number of runs in the file"},
    ROW(PHOTONS, "photons", NULL, COUNT, POS | SET | JSON, scene, photons, COUNT, 1, 0x1p48, NULL, NULL, "number of launched packets"),
    ROW(STEPS, "dz", NULL, REAL, POS | JSON, scene, dz, LENGTH, TINY, BIG, "cm", NULL, "width of the bins of depth"),
    ROW(STEPS, "dr", NULL, REAL, POS | JSON, scene, dr, LENGTH, TINY, BIG, "cm", NULL, "width of the bins of radius; the last bin also holds what lies beyond the grid"),
    ROW(BINS, "nz", NULL, INT, POS | JSON, scene, nz, COUNT, 1, 1e9, NULL, NULL, "bins of depth; at most 2^31 cells in all arrays of a run"),
    ROW(BINS, "nr", NULL, INT, POS | JSON, scene, nr, COUNT, 1, 1e9, NULL, NULL, "bins of radius"),
    ROW(BINS, "na", NULL, INT, POS | JSON, scene, na, COUNT, 1, 1e9, NULL, NULL, "bins of angle, 0 to 90 degrees"),
    ROW(LAYERS, "number of layers", NULL, INT, POS, scene, num_layers, COUNT, 1, 100000, NULL, NULL, "number of layers"),
    ROW(N_ABOVE, "n", "n above", REAL, POS | SET, medium_def, n, "a refractive index", 0.01, 100, NULL, NULL, "index of refraction of the medium above"),
    ROW(N_BELOW, "n", "n below", REAL, POS | SET, medium_def, n, "a refractive index", 0.01, 100, NULL, NULL, "index of refraction of the medium below"),
    ROW(MEDIUM, "n", NULL, REAL, POS | SET | JSON, medium_def, n, "a refractive index", 0.01, 100, NULL, NULL, "index of refraction"),
    ROW(MEDIUM, "mua", NULL, REAL, POS | SET | JSON, medium_def, mua, "a coefficient", 0, BIG, "1/cm", NULL, "absorption; a mua below 1e-11 of mua + mus is refused, 0 is not"),
    ROW(MEDIUM, "mus", NULL, REAL, POS | SET | JSON, medium_def, mus, "a coefficient", 0, BIG, "1/cm", NULL, "scattering"),
    ROW(MEDIUM, "g", NULL, REAL, POS | SET | JSON, medium_def, g, "an anisotropy", -1, 1, NULL, NULL, "mean cosine of scattering (Henyey-Greenstein, unless a `phase` line follows)"),
    ROW(LAYER, "d", NULL, REAL, POS | SET | JSON, medium_def, d, "a thickness", 0, BIG, "cm", NULL, "thickness; of 0 a layer only reflects and refracts, between planes; a very thick layer (1e8) stands for a half space"),
    {CML_KEYS_NAMED, "name", NULL, CML_KEY_OWN, 0, 0, "1 to 24 letters, digits and underscores, the first of them no digit", 0, 0, NULL, "none", "another name for `--set` and columns of a sweep: `gel.mua` beside `layer1.mua`"},
    ROW(HG2, "g1", NULL, REAL, POS | SET, phase, number[0], "a number", -0.9999, 0.9999, NULL, NULL, "G1: g of the first part"),
    ROW(HG2, "g2", NULL, REAL, POS | SET, phase, number[1], "a number", -0.9999, 0.9999, NULL, NULL, "G2: g of the second part"),
    ROW(HG2, "w", NULL, REAL, POS | SET, phase, number[2], "a share", 0, 1, NULL, NULL, "W: share of the first part"),
    ROW(MHG, "g", NULL, REAL, POS | SET, phase, number[0], "a number", -0.9999, 0.9999, NULL, NULL, "G: g of Henyey and Greenstein's part"),
    ROW(MHG, "w", NULL, REAL, POS | SET, phase, number[1], "a share", 0, 1, NULL, NULL, "W: share of Henyey and Greenstein's part"),
    ROW(GK, "g", NULL, REAL, POS | SET, phase, number[0], "a number", -0.9999, 0.9999, NULL, NULL, "G: how far forward light is scattered"),
    ROW(GK, "a", NULL, REAL, POS | SET | ABOVE, phase, number[1], "a number", -0.5, 100, NULL, NULL, "A: shape of the forward peak; 0.5 is Henyey and Greenstein"),
    ROW(BACKING, "r", "R", REAL, POS | SET, backing_def, R, "a reflectance", 0, 1, NULL, NULL, "share of the light that comes back"),
    ROW(METAL, "n", "N", REAL, POS | SET | JSON, backing_def, n, "the real part of an index", 0, 100, NULL, NULL, "real part of the metal's index"),
    ROW(METAL, "k", "K", REAL, POS | SET | JSON, backing_def, k, "the imaginary part of an index", 0, 100, NULL, NULL, "imaginary part of the metal's index"),
    ROW(CONTACT, "at", NULL, XY, OPT, contact_def, x, NULL, 0, 0, "cm", "0,0", "X,Y of the middle; only behind a shape"),
    ROW(CONTACT, "x", NULL, REAL, SET | JSON, contact_def, x, COORD, -BIG, BIG, "cm", "0", "x of `at`"),
    ROW(CONTACT, "y", NULL, REAL, SET | JSON, contact_def, y, COORD, -BIG, BIG, "cm", "0", "y of `at`"),
    ROW(CONTACT_DISK, "radius", NULL, REAL, POS | SET, contact_def, size[1], LENGTH, TINY, WIDE, "cm", NULL, "radius of the disk"),
    ROW(CONTACT_RING, "r1", NULL, REAL, POS | SET, contact_def, size[0], LENGTH, 0, WIDE, "cm", NULL, "inner radius"),
    ROW(CONTACT_RING, "r2", NULL, REAL, POS | SET, contact_def, size[1], LENGTH, TINY, WIDE, "cm", NULL, "outer radius"),
    ROW(CONTACT_RECTANGLE, "w", NULL, REAL, POS | SET, contact_def, size[0], LENGTH, TINY, BIG, "cm", NULL, "width along x"),
    ROW(CONTACT_RECTANGLE, "h", NULL, REAL, POS | SET, contact_def, size[1], LENGTH, TINY, BIG, "cm", NULL, "width along y"),
    ROW(FACE, "r", "R", REAL, POS | SET, contact_def, face.R, "a reflectance", 0, 1, NULL, NULL, "share of the light that comes back"),
    ROW(FACE_METAL, "n", "N", REAL, POS | SET, contact_def, face.n, "the real part of an index", 0, 100, NULL, NULL, "real part of the metal's index"),
    ROW(FACE_METAL, "k", "K", REAL, POS | SET, contact_def, face.k, "the imaginary part of an index", 0, 100, NULL, NULL, "imaginary part of the metal's index"),
    ROW(PORT, "n", NULL, REAL, OPT | SET, contact_def, n, "a refractive index", 0.01, 100, NULL, NULL, "index of refraction of the medium that fills all above the place"),
    ROW(PORT, "name", NULL, OWN, OPT, contact_def, name, "1 to 24 letters, digits and underscores", 0, 0, NULL, "its number among ports, from 1", "the name of the port for `beam port` and `detector port`"),
    ROW(ROUGH, "alpha", "rough alpha", REAL, POS | SET | OR_0, rough_def, alpha, "a number", 1e-4, 2, NULL, NULL, "roughness: 0 is smooth; `body1.alpha` is that of `rough=` in an `i` line"),
    ROW(SHAPE, "scale", NULL, REAL, SET, boundary, scale, "a number", TINY, BIG, NULL, "1", "factor on all lengths of the shape; replaces `scale=` of an `m` line"),
    ROW(SHAPE, "height", NULL, REAL, SET, boundary, height, "a factor", 0, BIG, NULL, "1", "further factor on heights alone: how rough"),
    ROW(MESH, "up", NULL, WORD, OPT, mesh_file_options, up, "z -z y -y x -x", 0, 0, NULL, "z", "axis of the file that points up; of a heightmap z or -z"),
    ROW(MESH, "rotate", NULL, REAL, OPT, mesh_file_options, rotate, "degrees", -360, 360, "degree", "0", "turn about the vertical, counter-clockwise seen from above; not of a heightmap"),
    ROW(MESH, "units", NULL, OWN, OPT, mesh_file_options, unit, "cm, mm, um or m", 0, 0, NULL, "cm", "unit of the file's numbers: an `.asc` file needs the key, a `.gsf` file has its own unit"),
    ROW(MESH, "scale", NULL, REAL, OPT, mesh_file_options, scale, "a number", TINY, BIG, NULL, "1", "factor on all coordinates of the file"),
    ROW(MESH, "weld", NULL, REAL, OPT, mesh_file_options, weld, "a distance", TINY, BIG, "cm", "none", "corners nearer to each other than this become one, at the place of the first; so do chains of such corners, and equal corners always; not of a heightmap"),
    ROW(PLACE, "shift", NULL, XYZ, OPT, mesh_file_options, shift, NULL, 0, 0, "cm", "0,0,0", "by how much the shape is moved along x, y and up; also of `m gaussian`"),
    ROW(PLACE, "normals", NULL, WORD, OPT, mesh_file_options, normals, "face vertex", 0, 0, NULL, "face", "normals of the facets, or interpolated ones; also of `m gaussian`"),
    ROW(SHEET, "skirt", NULL, REAL, OPT, mesh_file_options, skirt, "a width", TINY, BIG, "cm", "none", "width of the skirt of a border that is not level; not of a heightmap"),
    {CML_KEYS_TILE, "tile", NULL, CML_KEY_OWN, OPT | ALONE, 0, "tile, tile=mirror or tile=as-is", 0, 0, NULL, "not repeated", "repeats the heightmap over the whole plane; `tile=mirror`: with its mirror image, `tile=as-is`: whatever its seam"},
    ROW(SOLID, "union", NULL, FLAG, OPT, mesh_file_options, unite, NULL, 0, 0, NULL, NULL, "the parts of the mesh may cross"),
    ROW(SOLID, "rough", NULL, OWN, OPT, mesh_file_options, unite, "ggx,ALPHA or beckmann,ALPHA", 0, 0, NULL, "smooth", "roughness of the surface of a mesh, a sphere or a cylinder"),
    ROW(RELIEF, "slope", "rms slope", REAL, POS, random_relief, slope, "a number", 1e-4, 10, NULL, NULL, "rms gradient of the facets"),
    ROW(RELIEF, "length", NULL, REAL, POS, random_relief, length, "a correlation length", TINY, BIG, "cm", NULL, "correlation length of the heights"),
    ROW(RELIEF, "tile", NULL, OWN, OPT | ALONE, random_relief, seed, "tile", 0, 0, NULL, NULL, "the relief is repeated"),
    ROW(RELIEF, "seed", NULL, COUNT, OPT, random_relief, seed, COUNT, 0, 0x1p53, NULL, "1", "number of the random surface"),
    ROW(RELIEF, "points", NULL, OWN, OPT, random_relief, points, "a power of two of 16..8192", 0, 0, NULL, "512", "heights along each axis"),
    ROW(RELIEF, "spectrum", NULL, OWN, OPT, random_relief, hurst, "gaussian, exponential, or fractal:H with H of 0.01..1", 0, 0, NULL, "gaussian", "autocorrelation of the heights"),
    ROW(SPHERE, "x", NULL, REAL, POS, scene_body, centre[0], COORD, -BIG, BIG, "cm", NULL, "x of the middle"),
    ROW(SPHERE, "y", NULL, REAL, POS, scene_body, centre[1], COORD, -BIG, BIG, "cm", NULL, "y of the middle"),
    ROW(SPHERE, "z", NULL, REAL, POS, scene_body, centre[2], COORD, -BIG, BIG, "cm", NULL, "z of the middle"),
    ROW(SPHERE, "r", NULL, REAL, POS, scene_body, radius, "a radius", TINY, BIG, "cm", NULL, "radius of the sphere"),
    ROW(CYLINDER, "x1", NULL, REAL, POS, scene_body, centre[0], COORD, -BIG, BIG, "cm", NULL, "x of the middle of the first end"),
    ROW(CYLINDER, "y1", NULL, REAL, POS, scene_body, centre[1], COORD, -BIG, BIG, "cm", NULL, "y of the middle of the first end"),
    ROW(CYLINDER, "z1", NULL, REAL, POS, scene_body, centre[2], COORD, -BIG, BIG, "cm", NULL, "z of the middle of the first end"),
    ROW(CYLINDER, "x2", NULL, REAL, POS, scene_body, end[0], COORD, -BIG, BIG, "cm", NULL, "x of the middle of the other end"),
    ROW(CYLINDER, "y2", NULL, REAL, POS, scene_body, end[1], COORD, -BIG, BIG, "cm", NULL, "y of the middle of the other end"),
    ROW(CYLINDER, "z2", NULL, REAL, POS, scene_body, end[2], COORD, -BIG, BIG, "cm", NULL, "z of the middle of the other end"),
    ROW(CYLINDER, "r", NULL, REAL, POS, scene_body, radius, "a radius", TINY, BIG, "cm", NULL, "radius of the cylinder"),
    ROW(BEAM, "at", NULL, XY, OPT, beam, x, NULL, 0, 0, "cm", "0,0", "X,Y where the axis meets z = 0; with `z` the middle of the shape"),
    ROW(BEAM, "x", NULL, REAL, SET | JSON, beam, x, COORD, -BIG, BIG, "cm", "0", "x of `at`"),
    ROW(BEAM, "y", NULL, REAL, SET | JSON, beam, y, COORD, -BIG, BIG, "cm", "0", "y of `at`"),
    ROW(START, "z", NULL, REAL, OPT | SET | JSON, beam, z, COORD, -BIG, BIG, "cm", "above all surfaces", "depth where packets start"),
    ROW(ABOVE, "angle", NULL, ANGLE, OPT | SET | JSON | BELOW, beam, angle, "degrees", 0, 90, "degree", "0", "angle between the axis and z"),
    ROW(AXIS, "azimuth", NULL, ANGLE, OPT | SET | JSON, beam, azimuth, "degrees", -360, 360, "degree", "0", "azimuth of the axis, from x towards y"),
    ROW(AXIS, "light", NULL, OWN, OPT, beam, light, "parallel, na:N, lambertian, isotropic or a file in quotes", 0, 0, NULL, "parallel", "directions about the axis"),
    ROW(AXIS, "radial", NULL, OWN, OPT, beam, radial, "radial=beam", 0, 0, NULL, "the z axis", "where r in results counts from: with `radial=beam` from `at`"),
    ROW(AXIS, "na", NULL, OWN, 0, beam, light, NULL, 0, 0, NULL, NULL, NULL),
    {CML_KEYS_SHARE, "share", NULL, CML_KEY_REAL, OPT | SET | JSON, 0, "a share", TINY, BIG, NULL, "1", "share of the photons, relative to the shares of the other beams"},
    ROW(INSIDE, "angle", NULL, ANGLE, OPT | SET | JSON, beam, angle, "degrees", 0, 180, "degree", "0", "angle between the axis and z"),
    ROW(LIGHT, "na", NULL, REAL, SET | JSON, light, na, NA, TINY, 100, NULL, NULL, "N, n sin of the widest angle"),
    ROW(BEAM_DISK, "radius", NULL, REAL, POS | SET, beam, size[0], LENGTH, TINY, BIG, "cm", NULL, "radius of the disk, 1/e2 radius of the Gaussian"),
    ROW(BEAM_RING, "r1", NULL, REAL, POS | SET, beam, size[0], LENGTH, 0, BIG, "cm", NULL, "inner radius"),
    ROW(BEAM_RING, "r2", NULL, REAL, POS | SET, beam, size[1], LENGTH, TINY, BIG, "cm", NULL, "outer radius"),
    ROW(BEAM_RECTANGLE, "w", NULL, REAL, POS | SET, beam, size[0], LENGTH, TINY, BIG, "cm", NULL, "width along its own x"),
    ROW(BEAM_RECTANGLE, "h", NULL, REAL, POS | SET, beam, size[1], LENGTH, TINY, BIG, "cm", NULL, "width along its own y"),
    ROW(DETECTOR, "at", NULL, XY, OPT, detector_def, x, NULL, 0, 0, "cm", "0,0", "X,Y of the middle"),
    ROW(DETECTOR, "x", NULL, REAL, SET | JSON, detector_def, x, COORD, -BIG, BIG, "cm", "0", "x of `at`"),
    ROW(DETECTOR, "y", NULL, REAL, SET | JSON, detector_def, y, COORD, -BIG, BIG, "cm", "0", "y of `at`"),
    ROW(DETECTOR, "z", NULL, REAL, OPT | SET | JSON, detector_def, z, COORD, -BIG, BIG, "cm", "the nominal plane of its side", "depth of the detector's plane"),
    ROW(DETECTOR, "side", NULL, OWN, OPT, detector_def, below, "top or bottom", 0, 0, NULL, "top", "the side on which the light leaves"),
    ROW(SIGHT, "diffuse", NULL, FLAG, OPT | JSON, detector_def, diffuse, NULL, 0, 0, NULL, NULL, "leaves out light that never was in the material"),
    ROW(SIGHT, "name", NULL, OWN, OPT, detector_def, name, "1 to 24 letters, digits and underscores", 0, 0, NULL, "its number, from 1", "the name of the detector in results"),
    ROW(SIGHT, "group", NULL, OWN, OPT, detector_def, group, "1 to 24 letters, digits and underscores", 0, 0, NULL, "no group", "the name of a sum of detectors, to which this one belongs"),
    ROW(AIM, "na", NULL, REAL, OPT | SET, detector_def, na, NA, TINY, 100, NULL, "all directions", "limits directions to a cone about an axis: n sin of half its opening"),
    ROW(AIM, "angle", NULL, ANGLE, OPT | SET | JSON, detector_def, angle, "degrees", 0, 90, "degree", "0", "angle between the axis and the outward vertical"),
    ROW(AIM, "azimuth", NULL, ANGLE, OPT | SET | JSON, detector_def, azimuth, "degrees", -360, 360, "degree", "0", "azimuth of the axis, from x towards y"),
    ROW(DETECTOR_DISK, "radius", NULL, REAL, POS | SET, detector_def, size[1], LENGTH, TINY, WIDE, "cm", NULL, "radius of the disk"),
    ROW(DETECTOR_RING, "r1", NULL, REAL, POS | SET, detector_def, size[0], LENGTH, 0, WIDE, "cm", NULL, "inner radius"),
    ROW(DETECTOR_RING, "r2", NULL, REAL, POS | SET, detector_def, size[1], LENGTH, TINY, WIDE, "cm", NULL, "outer radius"),
    ROW(DETECTOR_RECTANGLE, "w", NULL, REAL, POS | SET, detector_def, size[0], LENGTH, TINY, BIG, "cm", NULL, "width along x"),
    ROW(DETECTOR_RECTANGLE, "h", NULL, REAL, POS | SET, detector_def, size[1], LENGTH, TINY, BIG, "cm", NULL, "width along y"),
    ROW(DETECTOR_MAP, "nx", NULL, INT, POS, detector_def, nx, COUNT, 1, 1e9, NULL, NULL, "pixels along x"),
    ROW(DETECTOR_MAP, "ny", NULL, INT, POS, detector_def, ny, COUNT, 1, 1e9, NULL, NULL, "pixels along y"),
    ROW(DETECTOR_MAP, "dx", NULL, REAL, POS | SET, detector_def, size[0], LENGTH, TINY, BIG, "cm", NULL, "width of a pixel"),
    ROW(DETECTOR_MAP, "dy", NULL, REAL, POS | SET, detector_def, size[1], LENGTH, TINY, BIG, "cm", NULL, "height of a pixel"),
    ROW(MAP, "nx", NULL, INT, POS | JSON, map_def, nx, COUNT, 1, 1e9, NULL, NULL, "pixels along x"),
    ROW(MAP, "ny", NULL, INT, POS | JSON, map_def, ny, COUNT, 1, 1e9, NULL, NULL, "pixels along y"),
    ROW(MAP, "dx", NULL, REAL, POS | JSON, map_def, dx, LENGTH, TINY, BIG, "cm", NULL, "width of a pixel"),
    ROW(MAP, "dy", NULL, REAL, POS | JSON, map_def, dy, LENGTH, TINY, BIG, "cm", NULL, "height of a pixel"),
    ROW(MAP, "angles", NULL, FLAG, OPT | JSON, map_def, angles, NULL, 0, 0, NULL, NULL, "also by angle: each pixel has the run's na bins"),
    ROW(MAP, "volume", NULL, FLAG, OPT | JSON, map_def, volume, NULL, 0, 0, NULL, NULL, "also absorption in nx by ny by nz voxels"),
    ROW(VOLUME, "top", NULL, REAL, OPT, map_def, top, "a depth", -BIG, BIG, "cm", "0", "depth of the upper face of the voxels"),
    ROW(FLUENCE, "time", NULL, FLAG, OPT, fluence_def, times, NULL, 0, 0, NULL, NULL, "also by the gates of the `time` line"),
    ROW(TIME, "end", "T1", REAL, POS | JSON, time_def, end, "a time", 1e-6, 1e12, "ps", NULL, "T1, the end of the N gates; one more gate holds all that is later"),
    ROW(TIME, "gates", "number of gates", INT, POS | JSON, time_def, gates, COUNT, 1, 100000, NULL, NULL, "N, gates of equal length from 0 to T1"),
    ROW(TIME, "radii", NULL, FLAG, OPT | JSON, time_def, radii, NULL, 0, 0, NULL, NULL, "also by radius and gate: `Rd_rt` and `Tt_rt`"),
    ROW(DIRECTIONS, "nt", "NT", INT, POS | JSON, directions_def, nt, COUNT, 1, 3600, NULL, NULL, "bins of the angle from the outward vertical"),
    ROW(DIRECTIONS, "np", "NP", INT, POS | JSON, directions_def, np, COUNT, 1, 3600, NULL, NULL, "bins of the azimuth of flight"),
    ROW(SAVED, "detected", NULL, FLAG, OPT, saved_def, detected, NULL, 0, 0, NULL, NULL, "only packets that a `detector` sees"),
    ROW(SAVED, "limit", NULL, COUNT, OPT, saved_def, limit, COUNT, 1, 1e9, NULL, "1e6", "how many packets are kept at most"),
    {.group = CML_KEYS_NONE},
};
/* clang-format on */
