/* SPDX-License-Identifier: MIT */
#include "plot/shown.h"

#include "plot/files/media.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CURVE(name_, quantity_, as_, title_, axis_)                                                          \
    {                                                                                                        \
        .name = name_, .num_panels = 1, .panel = { {CML_QUANTITY_##quantity_, as_, title_, axis_, NULL} }    \
    }
#define MAP(name_, quantity_, as_, colours_, polar_)                                                         \
    {                                                                                                        \
        .name = name_, .panel = {{CML_QUANTITY_##quantity_, as_, NULL, NULL, NULL}}, .map = colours_,        \
        .polar = polar_                                                                                      \
    }

/* The first is what is shown without being asked. */
static const struct cml_shown all[] = {
    {.name = "profiles",
     .num_panels = 2,
     .panel = {{CML_QUANTITY_Rd_r, CML_SHOWN_TIMES_R, "Reflectance", "r·Rd(r)  [1/cm]", NULL},
               {CML_QUANTITY_Tt_r, CML_SHOWN_TIMES_R, "Transmittance", "r·Tt(r)  [1/cm]", NULL}}},
    CURVE("Rd_r", Rd_r, CML_SHOWN_PLAIN, "Reflectance by radius", "Rd(r)  [1/cm²]"),
    CURVE("Tt_r", Tt_r, CML_SHOWN_PLAIN, "Transmittance by radius", "Tt(r)  [1/cm²]"),
    CURVE("Rd_a", Rd_a, CML_SHOWN_PLAIN, "Reflectance by angle", "Rd(α)  [1/sr]"),
    CURVE("Tt_a", Tt_a, CML_SHOWN_PLAIN, "Transmittance by angle", "Tt(α)  [1/sr]"),
    CURVE("A_z", A_z, CML_SHOWN_PLAIN, "Absorption by depth", "A(z)  [1/cm]"),
    CURVE("Rd_t", Rd_t, CML_SHOWN_PLAIN, "Reflectance by time", "Rd(t)  [1/ps]"),
    CURVE("Tt_t", Tt_t, CML_SHOWN_PLAIN, "Transmittance by time", "Tt(t)  [1/ps]"),
    CURVE("A_t", A_t, CML_SHOWN_PLAIN, "Absorption by time", "A(t)  [1/ps]"),
    CURVE("detector_NAME_t", detector_t, CML_SHOWN_PLAIN, "Detected by time", "1/ps"),
    CURVE("phi_z", phi_z, CML_SHOWN_PLAIN, "Fluence by depth", "φ(z)  [-]"),
    CURVE("fluence", A_z, CML_SHOWN_OVER_MUA, "Fluence by depth", "φ(z) = A(z)/μa  [-]"),
    MAP("A_rz", A_rz, CML_SHOWN_PLAIN, "A(r,z)  [1/cm³]", false),
    MAP("A_rz_se", A_rz, CML_SHOWN_ERROR, "standard error of A(r,z)  [1/cm³]", false),
    MAP("phi_rz", phi_rz, CML_SHOWN_PLAIN, "φ(r,z)  [1/cm²]", false),
    MAP("phi_rz_se", phi_rz, CML_SHOWN_ERROR, "standard error of φ(r,z)  [1/cm²]", false),
    MAP("fluence_rz", A_rz, CML_SHOWN_OVER_MUA, "φ(r,z) = A(r,z)/μa  [1/cm²]", false),
    MAP("Rd_dir", Rd_dir, CML_SHOWN_PLAIN, "Rd(θ,φ)  [1/sr]", true),
    MAP("Tt_dir", Tt_dir, CML_SHOWN_PLAIN, "Tt(θ,φ)  [1/sr]", true),
    MAP("Rsp_dir", Rsp_dir, CML_SHOWN_PLAIN, "Rsp(θ,φ)  [1/sr]", true),
};
enum { NUM_SHOWN = sizeof all / sizeof *all };

static bool is_called(const struct cml_shown *shown, const char *name)
{
    const size_t size = strlen(name);
    if (shown->panel[0].quantity != CML_QUANTITY_detector_t) return strcmp(shown->name, name) == 0;
    return size > 11 && strncmp(name, "detector_", 9) == 0 && strcmp(name + size - 2, "_t") == 0;
}

void cml_shown_names(char names[CML_SHOWN_NAMES])
{
    size_t used = 0;
    for (int i = 1; i < NUM_SHOWN; i++)
        used +=
            (size_t)snprintf(names + used, CML_SHOWN_NAMES - used, "%s%s", i > 1 ? ", " : "", all[i].name);
}

cml_status cml_shown_find(const char *name, const struct cml_shown **shown, struct cml_error *err)
{
    char names[CML_SHOWN_NAMES];
    *shown = &all[0];
    if (!name) return CML_OK;
    for (int i = 1; i < NUM_SHOWN; i++) {
        *shown = &all[i];
        if (is_called(&all[i], name)) return CML_OK;
    }
    cml_shown_names(names);
    return cml_fail(err, CML_E_INPUT, "--of %s (expected one of %s; or an array of a map)", name, names);
}

static bool is_angle(const struct cml_shown_panel *panel)
{
    return panel->quantity == CML_QUANTITY_Rd_a || panel->quantity == CML_QUANTITY_Tt_a;
}

static bool is_time(const struct cml_shown_panel *panel)
{
    return panel->detector || cml_quantities[panel->quantity].axis[0] == CML_AXIS_gate;
}

static bool is_depth(const struct cml_shown_panel *panel)
{
    return cml_quantities[panel->quantity].axis[0] == CML_AXIS_z;
}

const char *cml_shown_axis(const struct cml_shown_panel *panel)
{
    if (is_depth(panel)) return "depth z [cm]";
    if (is_time(panel)) return "time t [ps]";
    return is_angle(panel) ? "angle α from the vertical [rad]" : "radius r [cm]";
}

struct cml_curve_columns cml_shown_columns(const struct cml_shown_panel *panel)
{
    const char *place = is_depth(panel)   ? "z_mid_cm"
                        : is_angle(panel) ? "alpha_mid_rad"
                        : is_time(panel)  ? "t_mid_ps"
                                          : "r_mid_cm";
    const bool fluence = panel->as == CML_SHOWN_OVER_MUA;
    return (struct cml_curve_columns){fluence           ? "fluence"
                                      : panel->detector ? panel->detector
                                                        : cml_quantities[panel->quantity].name,
                                      place};
}

/* A fluence without absorption is nothing that was tallied. */
static cml_status check_absorption(const struct cml_outcome *o, const char *path, struct cml_error *err)
{
    for (int l = 0; l < o->num_layers; l++)
        if (o->value[CML_QUANTITY_layer_mua][l] > 0) return CML_OK;
    return cml_fail(err, CML_E_INPUT,
                    "%s: mua = 0 in all layers (expected a layer that absorbs, for a fluence)", path);
}

/* What a value is divided by: mua of its bin. *mua is the caller's to free; NULL for what is no fluence. */
static cml_status find_absorption(const struct cml_outcome *o, const char *path, enum cml_shown_as as,
                                  bool by_radius, double **mua, struct cml_error *err)
{
    *mua = NULL;
    if (as != CML_SHOWN_OVER_MUA) return CML_OK;
    CML_TRY(check_absorption(o, path, err));
    return cml_media_mua(o, path, by_radius, mua, err);
}

/* A gap where nothing absorbs, and where two media share the bin. */
static double over(const double *mua, size_t bin)
{
    if (!mua) return 1;
    return mua[bin] > 0 ? 1 / mua[bin] : NAN;
}

/* The last lit bin and the next: what lies beyond is an empty frame. Angles and gates, whose last bins hold
 * nothing from beyond, are shown whole. */
static double end_of(const struct cml_curve *curve, double width, bool whole)
{
    int last = whole ? curve->n - 1 : 0;
    for (int i = last; i < curve->n; i++)
        if (curve->y[i] > 0) last = i;
    return fmin(last + 2, curve->n + !whole) * width;
}

/* What only some scenes ask for may not be there. */
static cml_status check_there(const struct cml_outcome *o, const char *path, enum cml_quantity quantity,
                              struct cml_error *err)
{
    const char *line = cml_quantity_is_fluence(quantity)                    ? "fluence"
                       : cml_quantities[quantity].axis[0] == CML_AXIS_theta ? "directions"
                                                                            : "time";
    if (o->value[quantity]) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "%s: no %s (expected the result of a scene with a %s line)", path,
                    cml_quantities[quantity].name, line);
}

/* Which of the parts of a quantity is shown. */
static cml_status find_part(const struct cml_outcome *o, const char *path,
                            const struct cml_shown_panel *panel, int *part, struct cml_error *err)
{
    enum cml_quantity quantity = panel->quantity;
    *part = 0;
    if (!panel->detector) return check_there(o, path, quantity, err);
    if (cml_outcome_find(o, panel->detector, &quantity, part) && o->value[quantity]) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "%s: no %.60s (expected gates of one of its detectors)", path,
                    panel->detector);
}

cml_status cml_shown_curve(const struct cml_outcome *o, const char *path, const struct cml_shown_panel *panel,
                           struct cml_curve *curve, struct cml_error *err)
{
    const double width = cml_outcome_width(o, panel->detector ? CML_QUANTITY_Rd_t : panel->quantity);
    const bool whole = is_angle(panel) || is_time(panel);
    const int bins = (int)cml_outcome_part_size(o, panel->quantity);
    int part;
    double *mua;
    *curve = (struct cml_curve){0};
    CML_TRY(find_part(o, path, panel, &part, err));
    CML_TRY(find_absorption(o, path, panel->as, false, &mua, err));
    const cml_status status = cml_curve_create(bins, true, curve, err);
    if (status != CML_OK) {
        free(mua);
        return status;
    }
    const size_t first = (size_t)part * (size_t)bins;
    const double *values = o->value[panel->quantity] + first,
                 *errors = cml_outcome_errors(o, panel->quantity);
    curve->n = whole ? bins : bins - 1;
    for (int i = 0; i < curve->n; i++) {
        const double x = (i + 0.5) * width;
        const double factor = panel->as == CML_SHOWN_TIMES_R ? x : over(mua, (size_t)i);
        curve->shared |= mua && isnan(mua[i]);
        curve->x[i] = x;
        curve->y[i] = values[i] * factor;
        curve->error[i] = errors ? errors[first + (size_t)i] * factor : 0;
    }
    curve->end = end_of(curve, width, whole);
    free(mua);
    return CML_OK;
}

cml_status cml_shown_curve_of_others(const struct cml_curve *from, const struct cml_shown_panel *panel,
                                     struct cml_curve *curve, struct cml_error *err)
{
    CML_TRY(cml_curve_create(from->n, from->error != NULL, curve, err));
    curve->end = from->end;
    for (int i = 0; i < from->n; i++) {
        const double factor = panel->as == CML_SHOWN_TIMES_R ? from->x[i] : 1;
        curve->x[i] = from->x[i];
        curve->y[i] = from->y[i] * factor;
        if (from->error) curve->error[i] = from->error[i] * factor;
    }
    return CML_OK;
}

/* The bin of a direction, whose distance from the middle is its angle; -1: beyond 90 degrees. */
static int direction_at(const struct cml_outcome *o, double x, double y)
{
    const double full = 360, quarter = 90, theta = hypot(x, y);
    const double phi = atan2(y, x) * (full / 2 / acos(-1.0));
    if (!(theta < quarter)) return -1;
    const int it = (int)(theta / quarter * o->nt), ip = (int)((phi < 0 ? phi + full : phi) / full * o->np);
    return it * o->np + (ip < o->np ? ip : o->np - 1);
}

static cml_status polar_map(const struct cml_outcome *o, const char *path, enum cml_quantity quantity,
                            struct cml_pixels *map, struct cml_error *err)
{
    const size_t n = 720;
    const double most = 1e30, quarter = 90, spacing = 2 * quarter / (double)n;
    CML_TRY(check_there(o, path, quantity, err));
    *map = (struct cml_pixels){.n = {n, n}, .origin = {-quarter, -quarter}, .spacing = {spacing, spacing}};
    map->value = malloc(n * n * sizeof *map->value);
    if (!map->value) return cml_fail_memory(err, (double)(n * n * sizeof *map->value), "a map");
    for (size_t i = 0; i < n * n; i++) {
        const double x = ((double)(i % n) + 0.5) * spacing - quarter,
                     y = ((double)(i / n) + 0.5) * spacing - quarter;
        const int bin = direction_at(o, x, y);
        map->value[i] = bin < 0 ? -1 : (float)fmin(o->value[quantity][bin], most);
    }
    return CML_OK;
}

/* What a map over (r, z) shows before it is divided. */
static cml_status find_values(const struct cml_outcome *o, const char *path,
                              const struct cml_shown_panel *panel, const double **values,
                              struct cml_error *err)
{
    CML_TRY(check_there(o, path, panel->quantity, err));
    *values =
        panel->as == CML_SHOWN_ERROR ? cml_outcome_errors(o, panel->quantity) : o->value[panel->quantity];
    if (*values) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "%s: no %s_se (expected a result with standard errors of it)", path,
                    cml_quantities[panel->quantity].name);
}

cml_status cml_shown_map(const struct cml_outcome *o, const char *path, const struct cml_shown *shown,
                         struct cml_pixels *map, struct cml_error *err)
{
    const double most = 1e30; /* only a damaged file has more */
    const double *values;
    double *mua;
    *map = (struct cml_pixels){0};
    if (shown->polar) return polar_map(o, path, shown->panel[0].quantity, map, err);
    if (o->nr < 2 || o->nz < 2)
        return cml_fail(err, CML_E_INPUT, "%s: nz, nr = %d %d (expected 2 or more of each for a map)", path,
                        o->nz, o->nr);
    CML_TRY(find_values(o, path, &shown->panel[0], &values, err));
    CML_TRY(find_absorption(o, path, shown->panel[0].as, true, &mua, err));
    const size_t nr = (size_t)o->nr - 1, nz = (size_t)o->nz - 1;
    *map = (struct cml_pixels){.n = {nr, nz}, .spacing = {o->dr, o->dz}};
    map->value = malloc(nr * nz * sizeof *map->value);
    for (size_t iz = 0; map->value && iz < nz; iz++)
        for (size_t ir = 0; ir < nr; ir++)
            map->value[iz * nr + ir] =
                (float)(over(mua, iz * (nr + 1) + ir) * fmin(values[ir * (size_t)o->nz + iz], most));
    free(mua);
    return map->value ? CML_OK : cml_fail_memory(err, (double)(nr * nz * sizeof *map->value), "a map");
}
