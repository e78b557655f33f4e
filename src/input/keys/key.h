/* The keys of a scene's lines: numbers, words and flags, each with its unit, range, default, struct member
 * and meaning. The reader of scenes, --set, the JSON of check and help use one table of them (key_table.c).
 * SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* The largest and the smallest number of a scene. Beyond them a float overflows in the transport. */
#define CML_MCI_HUGE 1e30
#define CML_MCI_TINY 1e-30

/* Groups of keys: the keys that one kind of line has, whose values are members of one struct. The arguments
 * of X: the group; the name of the line in the manual; the word before the dot in --set, or NULL if --set
 * takes no key of the group. */
/* clang-format off */
#define CML_KEY_GROUPS(X) \
    X(RUNS, "runs", NULL) \
    X(PHOTONS, "photons", "") \
    X(STEPS, "dz dr", NULL) \
    X(BINS, "nz nr na", NULL) \
    X(LAYERS, "layers", NULL) \
    X(N_ABOVE, "n above", "above") \
    X(N_BELOW, "n below", "below") \
    X(MEDIUM, "a layer, `i`", "layer1") \
    X(LAYER, "a layer", "layer1") \
    X(NAMED, "a layer", NULL) \
    X(HG2, "`phase hg2`", "layer1.phase") \
    X(MHG, "`phase mhg`", "layer1.phase") \
    X(GK, "`phase gk`", "layer1.phase") \
    X(BACKING, "`backing`", "backing") \
    X(METAL, "`backing metal`", "backing") \
    X(CONTACT, "`face`, `port`", "port") \
    X(CONTACT_DISK, "`face disk`, `port disk`", "port") \
    X(CONTACT_RING, "`face ring`, `port ring`", "port") \
    X(CONTACT_RECTANGLE, "`face rectangle`, `port rectangle`", "port") \
    X(FACE, "`face`", "face") \
    X(FACE_METAL, "`face metal`", "face") \
    X(PORT, "`port`", "port") \
    X(ROUGH, "`rough`", "boundary0") \
    X(SHAPE, "`b`, `m`", "boundary0") \
    X(MESH, "`m`, `i`", NULL) \
    X(SHEET, "`m`", NULL) \
    X(TILE, "`m`", NULL) \
    X(SOLID, "`i`", NULL) \
    X(RELIEF, "`m gaussian`", NULL) \
    X(PLACE, "`m`, `i`", NULL) \
    X(SPHERE, "`i sphere`", NULL) \
    X(CYLINDER, "`i cylinder`", NULL) \
    X(BEAM, "`beam`", "beam") \
    X(START, "`beam`", "beam") \
    X(INSIDE, "`beam` with `z`", "beam") \
    X(ABOVE, "`beam`", "beam") \
    X(AXIS, "`beam`", "beam") \
    X(SHARE, "`beam`", "beam1") \
    X(LIGHT, "`beam` with `light=na:N`", "beam") \
    X(BEAM_DISK, "`beam disk`, `gaussian`", "beam") \
    X(BEAM_RING, "`beam ring`", "beam") \
    X(BEAM_RECTANGLE, "`beam rectangle`", "beam") \
    X(DETECTOR, "`detector`", "detector") \
    X(AIM, "`detector` with `na`", "detector") \
    X(SIGHT, "`detector`", "detector") \
    X(DETECTOR_DISK, "`detector disk`", "detector") \
    X(DETECTOR_RING, "`detector ring`", "detector") \
    X(DETECTOR_RECTANGLE, "`detector rectangle`", "detector") \
    X(DETECTOR_MAP, "`detector map`", "detector") \
    X(MAP, "`map`", NULL) \
    X(VOLUME, "`map` with `volume`", NULL) \
    X(FLUENCE, "`fluence`", NULL) \
    X(TIME, "`time`", NULL) \
    X(DIRECTIONS, "`directions`", NULL) \
    X(SAVED, "`photons`", NULL)
/* clang-format on */

enum cml_key_group {
    CML_KEYS_NONE, /* ends a list of parts */
#define CML_GROUP(group, line, set) CML_KEYS_##group,
    CML_KEY_GROUPS(CML_GROUP)
#undef CML_GROUP
        CML_NUM_KEY_GROUPS
};

struct cml_key_owner {
    const char *line, *set;
};
extern const struct cml_key_owner cml_key_owners[CML_NUM_KEY_GROUPS];

enum cml_key_type {
    CML_KEY_REAL,  /* double */
    CML_KEY_ANGLE, /* double, rad; degrees in the file */
    CML_KEY_INT,   /* int, written like 1e7, too */
    CML_KEY_COUNT, /* uint64_t, written like 1e7, too */
    CML_KEY_XY,    /* double[2], cm, with a comma between them */
    CML_KEY_XYZ,   /* double[3] */
    CML_KEY_WORD,  /* int or enum: which of the words in `noun`, with blanks between them */
    CML_KEY_FLAG,  /* bool: the key alone */
    CML_KEY_OWN    /* its line has a function that reads it: `own` of struct cml_mci_line */
};

/* Bits of `use` in struct cml_key. */
enum {
    CML_KEY_PLACED = 1, /* a number at a fixed place behind the line's word */
    CML_KEY_OPTION = 2, /* key=value, or a flag, behind the numbers */
    CML_KEY_SET = 4,    /* --set and columns of a sweep take the key */
    CML_KEY_JSON = 8,   /* check --json prints the key */
    CML_KEY_OR_0 = 16,  /* 0 is in the range, too */
    CML_KEY_ABOVE = 32, /* `least` itself is not in the range */
    CML_KEY_BELOW = 64, /* `most` itself is not in the range */
    CML_KEY_ALONE = 128 /* the word of an OWN key may stand without a value */
};

struct cml_key {
    enum cml_key_group group;
    const char *name;  /* in the line, in --set and in JSON */
    const char *shown; /* name in messages; NULL: `name` */
    enum cml_key_type type;
    int use;
    size_t member;        /* offset in the group's struct */
    const char *noun;     /* "a length"; the words of CML_KEY_WORD; the values of CML_KEY_OWN, or NULL */
    double least, most;   /* as in the file */
    const char *unit;     /* of the file; NULL: none */
    const char *fallback; /* for the manual: the value without the key; NULL: cml_key_fallback says which */
    const char *meaning;  /* for the manual */
};

/* All keys, group after group; the last row has the group CML_KEYS_NONE. */
extern const struct cml_key cml_key_table[];

/* A group of keys, and the struct in which their members lie. */
struct cml_key_part {
    enum cml_key_group group;
    void *base;
};

/* Makes a list of parts for one call: CML_KEY_PARTS({group, base}, {group, base}). */
#define CML_KEY_PARTS(...) ((const struct cml_key_part[]){__VA_ARGS__, {CML_KEYS_NONE, NULL}})
#define CML_MOST_KEY_PARTS 10

/* Returns the first row of a group; the other rows of the group follow it. */
const struct cml_key *cml_keys_of(enum cml_key_group group);

/* Returns the key's name in messages. */
static inline const char *cml_key_shown(const struct cml_key *key)
{
    return key->shown ? key->shown : key->name;
}

/* Returns true if the entire word is a number in the key's range; *value is then the number as in the file.
 */
bool cml_key_parse(const struct cml_key *key, const char *word, double *value);

/* Returns an angle of rad in degrees, rounded to 14 digits, because further digits are rounding errors. */
double cml_key_degrees(double angle);

/* Stores a number as in the file into the member of a REAL, ANGLE, INT or COUNT. base: the group's struct. */
void cml_key_store(const struct cml_key *key, void *base, double value);
/* Returns the member of a REAL, ANGLE, INT or COUNT in the unit of the file. */
double cml_key_load(const struct cml_key *key, const void *base);

/* Returns the range in words: "a length of 1e-30..1e30 cm". */
#define CML_KEY_TEXT 120
const char *cml_key_expected(const struct cml_key *key, char text[CML_KEY_TEXT]);

/* Returns the range without noun and unit: "0 to 1e30"; the words or the form of a key that is no number. */
const char *cml_key_range(const struct cml_key *key, char text[CML_KEY_TEXT]);

/* Returns the value that the reader takes if the key is absent: "0", "no" of a flag, or "required". */
const char *cml_key_fallback(const struct cml_key *key);

/* Returns the unit of a name that --set takes, by the last word of the name: "1/cm", "cm", "degree" or "1".
 */
const char *cml_key_unit(const char *name);
