/* Every key of a scene's lines, a row for each. SPDX-License-Identifier: MIT */
#include "input/keys/key.h"

#include "input/mesh/obj.h"
#include "scene/heightmap/random_relief.h"
#include "scene/scene.h"

#define BIG CML_MCI_HUGE
#define TINY CML_MCI_TINY

enum {
    POS = CML_KEY_PLACED,
    OPT = CML_KEY_OPTION,
    SET = CML_KEY_SET,
    JSON = CML_KEY_JSON,
    OR_0 = CML_KEY_OR_0,
    ABOVE = CML_KEY_ABOVE,
    BELOW = CML_KEY_BELOW
};

const struct cml_key_owner cml_key_owners[CML_NUM_KEY_GROUPS] = {{0},
#define CML_OWNER(group, line, set) {line, set},
                                                                 CML_KEY_GROUPS(CML_OWNER)
#undef CML_OWNER
};

/* Group, name, name in messages, type, use, struct, member, noun, range, unit, meaning. */
#define ROW(group, name, shown, type, use, of, member, noun, least, most, unit, meaning)                     \
    {                                                                                                        \
        CML_KEYS_##group, name, shown, CML_KEY_##type, use, offsetof(struct cml_##of, member), noun, least,  \
            most, unit, meaning                                                                              \
    }
#define COUNT "a whole number"
#define LENGTH "a length"
#define COORD "a coordinate"
#define NA "a numerical aperture"

/* clang-format off */
const struct cml_key cml_key_table[] = {
    {CML_KEYS_RUNS, "number of runs", NULL, CML_KEY_INT, POS, 0, COUNT, 1, 32767, NULL, "runs in the file"},
    ROW(PHOTONS, "photons", NULL, COUNT, POS | SET | JSON, scene, photons, COUNT, 1, 0x1p48, NULL, "launched packets"),
    ROW(STEPS, "dz", NULL, REAL, POS | JSON, scene, dz, LENGTH, TINY, BIG, "cm", "width of the bins of depth"),
    ROW(STEPS, "dr", NULL, REAL, POS | JSON, scene, dr, LENGTH, TINY, BIG, "cm", "width of the bins of radius; the last bin also holds what lies beyond the grid"),
    ROW(BINS, "nz", NULL, INT, POS | JSON, scene, nz, COUNT, 1, 1e9, NULL, "bins of depth; at most 2^31 cells in all arrays of a run"),
    ROW(BINS, "nr", NULL, INT, POS | JSON, scene, nr, COUNT, 1, 1e9, NULL, "bins of radius"),
    ROW(BINS, "na", NULL, INT, POS | JSON, scene, na, COUNT, 1, 1e9, NULL, "bins of angle, 0 to 90 degrees"),
    ROW(LAYERS, "number of layers", NULL, INT, POS, scene, num_layers, COUNT, 1, 100000, NULL, "number of layers"),
    ROW(N_ABOVE, "n", "n above", REAL, POS | SET, medium_def, n, "a refractive index", 0.01, 100, NULL, "index of refraction of the medium above"),
    ROW(N_BELOW, "n", "n below", REAL, POS | SET, medium_def, n, "a refractive index", 0.01, 100, NULL, "index of refraction of the medium below"),
    ROW(MEDIUM, "n", NULL, REAL, POS | SET | JSON, medium_def, n, "a refractive index", 0.01, 100, NULL, "index of refraction"),
    ROW(MEDIUM, "mua", NULL, REAL, POS | SET | JSON, medium_def, mua, "a coefficient", 0, BIG, "1/cm", "absorption; a mua below 1e-11 of mua + mus is refused, 0 is not"),
    ROW(MEDIUM, "mus", NULL, REAL, POS | SET | JSON, medium_def, mus, "a coefficient", 0, BIG, "1/cm", "scattering"),
    ROW(MEDIUM, "g", NULL, REAL, POS | SET | JSON, medium_def, g, "an anisotropy", -1, 1, NULL, "mean cosine of scattering (Henyey-Greenstein, unless a `phase` line follows)"),
    ROW(LAYER, "d", NULL, REAL, POS | SET | JSON, medium_def, d, "a thickness", 0, BIG, "cm", "thickness; of 0 a layer only reflects and refracts, between planes; a very thick layer (1e8) stands for a half space"),
    ROW(HG2, "g1", NULL, REAL, POS | SET, phase, number[0], "a number", -0.9999, 0.9999, NULL, "G1, g of the first part"),
    ROW(HG2, "g2", NULL, REAL, POS | SET, phase, number[1], "a number", -0.9999, 0.9999, NULL, "G2, g of the second part"),
    ROW(HG2, "w", NULL, REAL, POS | SET, phase, number[2], "a share", 0, 1, NULL, "W, share of the first part"),
    ROW(MHG, "g", NULL, REAL, POS | SET, phase, number[0], "a number", -0.9999, 0.9999, NULL, "G"),
    ROW(MHG, "w", NULL, REAL, POS | SET, phase, number[1], "a share", 0, 1, NULL, "W, share of Henyey and Greenstein's part"),
    ROW(GK, "g", NULL, REAL, POS | SET, phase, number[0], "a number", -0.9999, 0.9999, NULL, "G"),
    ROW(GK, "a", NULL, REAL, POS | SET | ABOVE, phase, number[1], "a number", -0.5, 100, NULL, "A"),
    ROW(BACKING, "r", "R", REAL, POS | SET, backing_def, R, "a reflectance", 0, 1, NULL, "share that comes back"),
    ROW(METAL, "n", "N", REAL, POS | SET | JSON, backing_def, n, "the real part of an index", 0, 100, NULL, "real part of the metal's index"),
    ROW(METAL, "k", "K", REAL, POS | SET | JSON, backing_def, k, "the imaginary part of an index", 0, 100, NULL, "imaginary part of the metal's index"),
    ROW(ROUGH, "alpha", "rough alpha", REAL, POS | SET | OR_0, rough_def, alpha, "a number", 1e-4, 2, NULL, "roughness, also of `rough=` of an `i` line (`body1.alpha`); 0 is smooth"),
    ROW(SHAPE, "scale", NULL, REAL, SET, boundary, scale, "a number", TINY, BIG, NULL, "factor on all coordinates of a shape: in place of `scale=` of an `m` line; heights and spacings of a `b` line"),
    ROW(SHAPE, "height", NULL, REAL, SET, boundary, height, "a factor", 0, BIG, NULL, "a further factor on heights alone: how rough"),
    ROW(MESH, "up", NULL, WORD, OPT, obj_options, up, "z -z y -y x -x", 0, 0, NULL, "axis of the file that points up"),
    ROW(MESH, "rotate", NULL, REAL, OPT, obj_options, rotate, "degrees", -360, 360, "degree", "turn about the vertical, counter-clockwise seen from above"),
    ROW(MESH, "units", NULL, OWN, OPT, obj_options, unit, NULL, 0, 0, NULL, "unit of the file's numbers: cm, mm, um or m"),
    ROW(MESH, "scale", NULL, REAL, OPT, obj_options, scale, "a number", TINY, BIG, NULL, "factor on all coordinates"),
    ROW(PLACE, "shift", NULL, XYZ, OPT, obj_options, shift, NULL, 0, 0, "cm", "x, y and up; also of `m gaussian`"),
    ROW(PLACE, "normals", NULL, WORD, OPT, obj_options, normals, "face vertex", 0, 0, NULL, "normals of facets, or interpolated ones; also of `m gaussian`"),
    ROW(SHEET, "skirt", NULL, REAL, OPT, obj_options, skirt, "a width", TINY, BIG, "cm", "a border that is not level gets a skirt of this width"),
    {CML_KEYS_TILE, "tile", NULL, CML_KEY_OWN, OPT, 0, "tile, tile=mirror or tile=as-is", 0, 0, NULL, "the heightmap is repeated, as it is or with its mirror image"},
    ROW(SOLID, "union", NULL, FLAG, OPT, obj_options, unite, NULL, 0, 0, NULL, "the parts of a body's mesh may cross"),
    ROW(SOLID, "rough", NULL, OWN, OPT, obj_options, unite, NULL, 0, 0, NULL, "roughness of its surface, KIND,ALPHA, also behind spheres and cylinders"),
    ROW(RELIEF, "slope", "rms slope", REAL, POS, random_relief, slope, "a number", 1e-4, 10, NULL, "rms gradient of the facets"),
    ROW(RELIEF, "length", NULL, REAL, POS, random_relief, length, "a correlation length", TINY, BIG, "cm", "correlation length"),
    ROW(RELIEF, "tile", NULL, OWN, OPT, random_relief, seed, "tile", 0, 0, NULL, "the relief is repeated"),
    ROW(RELIEF, "seed", NULL, COUNT, OPT, random_relief, seed, COUNT, 0, 0x1p53, NULL, "another seed is another surface"),
    ROW(RELIEF, "points", NULL, OWN, OPT, random_relief, points, NULL, 0, 0, NULL, "heights along each axis, a power of two of 16..8192"),
    ROW(RELIEF, "spectrum", NULL, OWN, OPT, random_relief, hurst, NULL, 0, 0, NULL, "autocorrelation: gaussian, exponential or fractal:H"),
    ROW(SPHERE, "x", NULL, REAL, POS, scene_body, centre[0], COORD, -BIG, BIG, "cm", "middle"),
    ROW(SPHERE, "y", NULL, REAL, POS, scene_body, centre[1], COORD, -BIG, BIG, "cm", "middle"),
    ROW(SPHERE, "z", NULL, REAL, POS, scene_body, centre[2], COORD, -BIG, BIG, "cm", "middle"),
    ROW(SPHERE, "r", NULL, REAL, POS, scene_body, radius, "a radius", TINY, BIG, "cm", "radius"),
    ROW(CYLINDER, "x1", NULL, REAL, POS, scene_body, centre[0], COORD, -BIG, BIG, "cm", "middle of the first end"),
    ROW(CYLINDER, "y1", NULL, REAL, POS, scene_body, centre[1], COORD, -BIG, BIG, "cm", "middle of the first end"),
    ROW(CYLINDER, "z1", NULL, REAL, POS, scene_body, centre[2], COORD, -BIG, BIG, "cm", "middle of the first end"),
    ROW(CYLINDER, "x2", NULL, REAL, POS, scene_body, end[0], COORD, -BIG, BIG, "cm", "middle of the other end"),
    ROW(CYLINDER, "y2", NULL, REAL, POS, scene_body, end[1], COORD, -BIG, BIG, "cm", "middle of the other end"),
    ROW(CYLINDER, "z2", NULL, REAL, POS, scene_body, end[2], COORD, -BIG, BIG, "cm", "middle of the other end"),
    ROW(CYLINDER, "r", NULL, REAL, POS, scene_body, radius, "a radius", TINY, BIG, "cm", "radius"),
    ROW(BEAM, "at", NULL, XY, OPT, beam, x, NULL, 0, 0, "cm", "x,y where the axis meets z = 0, or with `z` the middle of the shape"),
    ROW(BEAM, "x", NULL, REAL, SET | JSON, beam, x, COORD, -BIG, BIG, "cm", "x of `at`"),
    ROW(BEAM, "y", NULL, REAL, SET | JSON, beam, y, COORD, -BIG, BIG, "cm", "y of `at`"),
    ROW(START, "z", NULL, REAL, OPT | SET | JSON, beam, z, COORD, -BIG, BIG, "cm", "depth where packets start; without it they start above all surfaces"),
    ROW(INSIDE, "angle", NULL, ANGLE, OPT | SET | JSON, beam, angle, "degrees", 0, 180, "degree", "between the axis and z"),
    ROW(ABOVE, "angle", NULL, ANGLE, OPT | SET | JSON | BELOW, beam, angle, "degrees", 0, 90, "degree", "between the axis and z"),
    ROW(AXIS, "azimuth", NULL, ANGLE, OPT | SET | JSON, beam, azimuth, "degrees", -360, 360, "degree", "where the axis goes to, from x towards y"),
    ROW(AXIS, "light", NULL, OWN, OPT, beam, light, NULL, 0, 0, NULL, "directions about the axis: parallel, na:N, lambertian, isotropic or a file in quotes"),
    ROW(AXIS, "radial", NULL, OWN, OPT, beam, radial, NULL, 0, 0, NULL, "`radial=beam`: r in results counts from `at`"),
    ROW(AXIS, "na", NULL, OWN, 0, beam, light, NULL, 0, 0, NULL, NULL),
    {CML_KEYS_SHARE, "share", NULL, CML_KEY_REAL, OPT | SET | JSON, 0, "a share", TINY, BIG, NULL, "share of the light of several beams"},
    ROW(LIGHT, "na", NULL, REAL, SET | JSON, light, na, NA, TINY, 100, NULL, "n sin of the widest angle"),
    ROW(BEAM_DISK, "radius", NULL, REAL, POS | SET, beam, size[0], LENGTH, TINY, BIG, "cm", "radius; of a Gaussian the 1/e2 radius"),
    ROW(BEAM_RING, "r1", NULL, REAL, POS | SET, beam, size[0], LENGTH, 0, BIG, "cm", "inner radius"),
    ROW(BEAM_RING, "r2", NULL, REAL, POS | SET, beam, size[1], LENGTH, TINY, BIG, "cm", "outer radius"),
    ROW(BEAM_RECTANGLE, "w", NULL, REAL, POS | SET, beam, size[0], LENGTH, TINY, BIG, "cm", "width along its own x"),
    ROW(BEAM_RECTANGLE, "h", NULL, REAL, POS | SET, beam, size[1], LENGTH, TINY, BIG, "cm", "width along its own y"),
    ROW(DETECTOR, "at", NULL, XY, OPT, detector_def, x, NULL, 0, 0, "cm", "x,y of the middle"),
    ROW(DETECTOR, "x", NULL, REAL, SET | JSON, detector_def, x, COORD, -BIG, BIG, "cm", "x of `at`"),
    ROW(DETECTOR, "y", NULL, REAL, SET | JSON, detector_def, y, COORD, -BIG, BIG, "cm", "y of `at`"),
    ROW(DETECTOR, "z", NULL, REAL, OPT | SET | JSON, detector_def, z, COORD, -BIG, BIG, "cm", "depth of its plane; without it the nominal plane of its side"),
    ROW(DETECTOR, "side", NULL, OWN, OPT, detector_def, below, NULL, 0, 0, NULL, "the side that light leaves on: top or bottom"),
    ROW(AIM, "na", NULL, REAL, OPT | SET, detector_def, na, NA, TINY, 100, NULL, "limits directions to a cone about an axis"),
    ROW(AIM, "angle", NULL, ANGLE, OPT | SET | JSON, detector_def, angle, "degrees", 0, 90, "degree", "of the axis to the outward vertical"),
    ROW(AIM, "azimuth", NULL, ANGLE, OPT | SET | JSON, detector_def, azimuth, "degrees", -360, 360, "degree", "of the axis, from x towards y"),
    ROW(SIGHT, "diffuse", NULL, FLAG, OPT | JSON, detector_def, diffuse, NULL, 0, 0, NULL, "no light that never was in the material"),
    ROW(SIGHT, "name", NULL, OWN, OPT, detector_def, name, NULL, 0, 0, NULL, "its name, of 1 to 24 letters, digits and underscores; else it has its number, from 1"),
    ROW(DETECTOR_DISK, "radius", NULL, REAL, POS | SET, detector_def, size[1], LENGTH, TINY, BIG, "cm", "radius"),
    ROW(DETECTOR_RING, "r1", NULL, REAL, POS | SET, detector_def, size[0], LENGTH, 0, BIG, "cm", "inner radius"),
    ROW(DETECTOR_RING, "r2", NULL, REAL, POS | SET, detector_def, size[1], LENGTH, TINY, BIG, "cm", "outer radius"),
    ROW(DETECTOR_RECTANGLE, "w", NULL, REAL, POS | SET, detector_def, size[0], LENGTH, TINY, BIG, "cm", "width along x"),
    ROW(DETECTOR_RECTANGLE, "h", NULL, REAL, POS | SET, detector_def, size[1], LENGTH, TINY, BIG, "cm", "width along y"),
    ROW(DETECTOR_MAP, "nx", NULL, INT, POS, detector_def, nx, COUNT, 1, 1e9, NULL, "pixels along x"),
    ROW(DETECTOR_MAP, "ny", NULL, INT, POS, detector_def, ny, COUNT, 1, 1e9, NULL, "pixels along y"),
    ROW(DETECTOR_MAP, "dx", NULL, REAL, POS | SET, detector_def, size[0], LENGTH, TINY, BIG, "cm", "width of a pixel"),
    ROW(DETECTOR_MAP, "dy", NULL, REAL, POS | SET, detector_def, size[1], LENGTH, TINY, BIG, "cm", "height of a pixel"),
    ROW(MAP, "nx", NULL, INT, POS | JSON, map_def, nx, COUNT, 1, 1e9, NULL, "pixels along x"),
    ROW(MAP, "ny", NULL, INT, POS | JSON, map_def, ny, COUNT, 1, 1e9, NULL, "pixels along y"),
    ROW(MAP, "dx", NULL, REAL, POS | JSON, map_def, dx, LENGTH, TINY, BIG, "cm", "width of a pixel"),
    ROW(MAP, "dy", NULL, REAL, POS | JSON, map_def, dy, LENGTH, TINY, BIG, "cm", "height of a pixel"),
    ROW(MAP, "angles", NULL, FLAG, OPT | JSON, map_def, angles, NULL, 0, 0, NULL, "each pixel has the run's na angle bins"),
    ROW(MAP, "volume", NULL, FLAG, OPT | JSON, map_def, volume, NULL, 0, 0, NULL, "absorption in nx by ny by nz voxels, too"),
    ROW(VOLUME, "top", NULL, REAL, OPT, map_def, top, "a depth", -BIG, BIG, "cm", "depth of the upper face of the voxels"),
    ROW(FLUENCE, "time", NULL, FLAG, OPT, fluence_def, times, NULL, 0, 0, NULL, "by the gates of `time`, too"),
    ROW(TIME, "end", "T1", REAL, POS | JSON, time_def, end, "a time", 1e-6, 1e12, "ps", "end of the last gate but the one for all that is later"),
    ROW(TIME, "gates", "number of gates", INT, POS | JSON, time_def, gates, COUNT, 1, 100000, NULL, "gates from 0 to the end, all as long"),
    ROW(TIME, "radii", NULL, FLAG, OPT | JSON, time_def, radii, NULL, 0, 0, NULL, "what leaves also by radius and gate"),
    ROW(DIRECTIONS, "nt", "NT", INT, POS | JSON, directions_def, nt, COUNT, 1, 3600, NULL, "bins of the angle from the outward vertical"),
    ROW(DIRECTIONS, "np", "NP", INT, POS | JSON, directions_def, np, COUNT, 1, 3600, NULL, "bins of the azimuth of flight"),
    ROW(SAVED, "detected", NULL, FLAG, OPT, saved_def, detected, NULL, 0, 0, NULL, "only packets that some `detector` sees"),
    ROW(SAVED, "limit", NULL, COUNT, OPT, saved_def, limit, COUNT, 1, 1e9, NULL, "how many packets are kept, 1e6 without it"),
    {.group = CML_KEYS_NONE},
};
/* clang-format on */
