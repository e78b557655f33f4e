/* SPDX-License-Identifier: MIT */
#include "plot/files/media.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct media {
    const struct cml_outcome *outcome;
    size_t nr, nz;
    double (*depth)[2]; /* [L + 1] of every boundary: its highest and its lowest point */
    int *bodies;        /* [nz + 1][nr + 1] how many more touch a bin than those before it, along z and r */
};

/* In bins: nearer than this a surface lies between two of them. */
static const double err_edge = 1e-6;

static cml_status fail_unknown(const char *path, const char *what, struct cml_error *err)
{
    return cml_fail(
        err, CML_E_INPUT,
        "%s: does not say where %s lies (expected a result that names its depths, for a fluence: fly "
        "the scene again)",
        path, what);
}

static void place_layers(struct media *media)
{
    double z = 0;
    for (int b = 0; b <= media->outcome->num_layers; b++) {
        media->depth[b][0] = media->depth[b][1] = z;
        if (b < media->outcome->num_layers) z += *cml_outcome_layer(media->outcome, b, 4);
    }
}

/* The depth of a plane has six digits in the file, as thicknesses have: where both agree, it is the latter.
 */
static cml_status place_boundary(struct media *media, const struct cml_extent *extent, const char *path,
                                 struct cml_error *err)
{
    const int b = extent->boundary;
    char what[32];
    if (b < 0 || b > media->outcome->num_layers) return fail_unknown(path, "a boundary", err);
    snprintf(what, sizeof what, "boundary %d", b);
    if (!extent->known) return fail_unknown(path, what, err);
    const double *z = extent->z, agree = extent->plane ? 1e-5 * fabs(z[0]) : -1;
    if (fabs(z[0] - media->depth[b][0]) > agree) memcpy(media->depth[b], z, sizeof media->depth[b]);
    return CML_OK;
}

/* Bins from *first to *end that touch low..high; none outside the grid. */
static void touch(double low, double high, double width, size_t n, size_t *first, size_t *end)
{
    const double from = floor(low / width + err_edge), to = ceil(high / width - err_edge);
    *first = (size_t)fmin(fmax(from, 0), (double)n);
    *end = (size_t)fmin(fmax(to, (double)*first), (double)n);
}

/* What changes at the corners of its box: the sums along both axes are then one inside it. */
static cml_status place_body(struct media *media, const struct cml_extent *extent, const char *path,
                             struct cml_error *err)
{
    size_t z[2], r[2] = {0, 1};
    if (!extent->known) return fail_unknown(path, "a body", err);
    touch(extent->z[0], extent->z[1], media->outcome->dz, media->nz, &z[0], &z[1]);
    if (media->nr > 1) touch(extent->r[0], extent->r[1], media->outcome->dr, media->nr, &r[0], &r[1]);
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++) media->bodies[z[i] * (media->nr + 1) + r[k]] += i == k ? 1 : -1;
    return CML_OK;
}

static cml_status place_shapes(struct media *media, const char *path, struct cml_error *err)
{
    if (media->outcome->curved) return fail_unknown(path, "a curved boundary", err);
    for (int i = 0; i < media->outcome->num_extents; i++) {
        const struct cml_extent *extent = &media->outcome->extent[i];
        CML_TRY(extent->body ? place_body(media, extent, path, err)
                             : place_boundary(media, extent, path, err));
    }
    return CML_OK;
}

/* The absorption of medium m, 1/cm; 0 is above, L + 1 below the layers. */
static double mua_of(const struct cml_outcome *outcome, int m)
{
    return m >= 1 && m <= outcome->num_layers ? outcome->value[CML_QUANTITY_layer_mua][m - 1] : 0;
}

/* The absorption at each depth, the same for all radii. What is absorbed above z = 0 counts in the first bin,
 * which is then larger than the others. */
static void fill_layers(const struct media *media, double *mua)
{
    const struct cml_outcome *outcome = media->outcome;
    const double err_depth = err_edge * outcome->dz;
    int above = 0, below = 0; /* first and last medium of the bin */
    for (size_t iz = 0; iz < media->nz; iz++) {
        const double top = (double)iz * outcome->dz, bottom = top + outcome->dz;
        while (above <= outcome->num_layers && media->depth[above][1] <= top + err_depth) above++;
        while (below <= outcome->num_layers && media->depth[below][0] < bottom - err_depth) below++;
        double value = mua_of(outcome, above);
        for (int m = above + 1; m <= below; m++)
            if (mua_of(outcome, m) != mua_of(outcome, above)) value = NAN;
        if (iz == 0 && media->depth[0][0] < -err_depth) value = NAN;
        for (size_t ir = 0; ir < media->nr; ir++) mua[iz * media->nr + ir] = value;
    }
}

static void leave_out_bodies(const struct media *media, double *mua)
{
    const size_t row = media->nr + 1;
    int *bodies = media->bodies;
    for (size_t i = row; i < row * (media->nz + 1); i++) bodies[i] += bodies[i - row];
    for (size_t i = 0; i < media->nz; i++) {
        int touching = 0;
        for (size_t k = 0; k < media->nr; k++) {
            touching += bodies[i * row + k];
            if (touching > 0) mua[i * media->nr + k] = NAN;
        }
    }
}

cml_status cml_media_mua(const struct cml_outcome *outcome, const char *path, bool by_radius, double **mua,
                         struct cml_error *err)
{
    struct media media = {
        .outcome = outcome, .nr = by_radius ? (size_t)outcome->nr : 1, .nz = (size_t)outcome->nz};
    const size_t bins = (media.nr + 1) * (media.nz + 1);
    media.depth = calloc((size_t)outcome->num_layers + 1, sizeof *media.depth);
    media.bodies = calloc(bins, sizeof *media.bodies);
    *mua = malloc(bins * sizeof **mua);
    cml_status status =
        media.depth && media.bodies && *mua ? CML_OK : cml_fail_memory(err, 12.0 * (double)bins, "media");
    if (status == CML_OK) {
        place_layers(&media);
        status = place_shapes(&media, path, err);
    }
    if (status == CML_OK) {
        fill_layers(&media, *mua);
        leave_out_bodies(&media, *mua);
    } else {
        free(*mua);
        *mua = NULL;
    }
    free(media.depth);
    free(media.bodies);
    return status;
}
