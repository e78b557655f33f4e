/* SPDX-License-Identifier: MIT */
#include "exact/importance.h"

#include "base/array.h"
#include "exact/stack.h"

#include <math.h>

enum { ORDER = 16, TERMS = 2 * ORDER, PIECES = 96, MOST_DIRECTIONS = 320 };

/* Least absorption, mua times the total depth: fluence is read from absorption, so a clear layer gets this
 * much. */
#define LEAST_ABSORPTION 1e-3

/* The layers upside down and cut into pieces. The absorption of each piece tells the fluence in its
 * middle. */
struct pieces {
    int count;                    /* number of pieces between the outer media */
    struct cml_medium_def *media; /* [count + 2] media of the pieces and the outer media */
    double *middle;               /* [count] depths of the pieces' middles, falling, cm */
    double *absorbed;             /* [count] share of the light that each piece absorbs */
};

/* Returns into how many pieces a layer of thickness d is cut: by its share of the whole depth, and two
 * more. */
static int pieces_of(double d, double depth)
{
    return 2 + (int)(PIECES * d / depth);
}

/* Cuts all layers into thin pieces, from below, in whose middles the importance of light is computed. The
 * importance is read from absorption, so clear layers get a trace of it. */
static void cut(const struct cml_medium_def *media, int layers, double depth, struct pieces *to)
{
    double bottom = depth;
    to->media[0] = media[layers + 1];
    for (int l = layers; l > 0; bottom -= media[l--].d) {
        const int n = pieces_of(media[l].d, depth);
        for (int i = 0; i < n; i++) {
            struct cml_medium_def *piece = &to->media[++to->count];
            *piece = media[l];
            piece->d = media[l].d / n;
            piece->mua = fmax(piece->mua, LEAST_ABSORPTION / depth);
            to->middle[to->count - 1] = bottom - (i + 0.5) * piece->d;
        }
    }
    to->media[to->count + 1] = media[0];
}

/* Computes the absorption of each piece of the layers, for diffuse light that comes from outside. */
static cml_status solve(struct pieces *pieces, struct cml_error *err)
{
    const struct cml_exact_light light = {.diffuse = 1};
    CML_AT_END(cml_directions_clear) struct cml_directions directions = {0};
    double reflected, transmitted;
    CML_TRY(cml_directions_create(pieces->media, pieces->count, NULL, &light, ORDER, &directions, err));
    if (directions.count > MOST_DIRECTIONS)
        return cml_fail(err, CML_E_NUMERIC, "adding-doubling takes more than %d directions", MOST_DIRECTIONS);
    return cml_stack_shares(pieces->media, NULL, NULL, &directions, TERMS, &reflected, &transmitted,
                            pieces->absorbed, err);
}

/* Returns the importance in the middle of piece i, counted from below. The incident flux of 1 has the
 * radiance 1 / pi, which grows with the square of the index. */
static double worth(const struct pieces *pieces, int i)
{
    const struct cml_medium_def *piece = &pieces->media[i + 1];
    const double widened = piece->n / pieces->media[0].n;
    return pieces->absorbed[i] / (piece->mua * piece->d) / (4 * widened * widened);
}

/* Interpolates importance linearly in its logarithm between the middles of pieces; beyond the first and last
 * middle it is constant. */
static void interpolate(const struct pieces *pieces, double depth, int cells, double *value)
{
    for (int c = cells - 1, i = 0; c >= 0; c--) {
        const double z = (c + 0.5) / cells * depth;
        while (i < pieces->count - 1 && pieces->middle[i] > z) i++;
        if (i == 0 || pieces->middle[i] > z) {
            value[c] = worth(pieces, i);
            continue;
        }
        const double part = (pieces->middle[i - 1] - z) / (pieces->middle[i - 1] - pieces->middle[i]);
        value[c] = exp((1 - part) * log(worth(pieces, i - 1)) + part * log(worth(pieces, i)));
    }
}

/* By reciprocity the importance is the fluence that light from below would cause there. */
cml_status cml_importance_of_depth(const struct cml_medium_def *media, int layers, int cells, double *value,
                                   struct cml_error *err)
{
    double depth = 0;
    size_t count = 0;
    for (int l = 1; l <= layers; l++) depth += media[l].d;
    for (int l = 1; l <= layers; l++) count += (size_t)pieces_of(media[l].d, depth);
    CML_AT_END(cml_arrays_free) struct cml_arrays arrays = {0};
    struct pieces pieces = {.media = cml_arrays_add(&arrays, count + 2, sizeof *pieces.media),
                            .middle = cml_arrays_add(&arrays, count, sizeof *pieces.middle),
                            .absorbed = cml_arrays_add(&arrays, count, sizeof *pieces.absorbed)};
    CML_TRY(cml_arrays_check(&arrays, "pieces of layers", err));
    cut(media, layers, depth, &pieces);
    CML_TRY(solve(&pieces, err));
    interpolate(&pieces, depth, cells, value);
    return CML_OK;
}
