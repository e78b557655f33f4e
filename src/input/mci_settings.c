/* SPDX-License-Identifier: MIT */
#include "input/mci_settings.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

const struct cml_setting *cml_mci_setting(struct cml_mci_reader *reader, const char *format, ...)
{
    const struct cml_settings *settings = reader->options->settings;
    char name[CML_SETTING_NAME];
    if (!settings) return NULL;
    va_list values;
    va_start(values, format);
    vsnprintf(name, sizeof name, format, values);
    va_end(values);
    const struct cml_setting *setting = cml_settings_find(settings, name);
    if (setting) reader->taken[setting - settings->item] = true;
    return setting;
}

cml_status cml_mci_set(const struct cml_mci_reader *reader, const struct cml_setting *setting,
                       const struct cml_mci_field *field, double *value)
{
    if (!setting || cml_mci_parse(field, setting->value, value)) return CML_OK;
    return cml_setting_fail(setting, field->expected, reader->err);
}

/* "layer1", or "layer1..3". */
static void write_owners(FILE *out, const char *owner, int first, int last)
{
    fprintf(out, ", %s%d", owner, first);
    if (last > first) fprintf(out, "..%d", last);
}

static void write_media(FILE *out, const char *kind, int count, const char *fields)
{
    if (count == 0) return;
    write_owners(out, kind, 1, count);
    fprintf(out, " with %s", fields);
}

static void write_phase(FILE *out, const char *kind, int number, const struct cml_phase *phase)
{
    if (!phase || !*cml_phase_numbers(phase->kind)) return;
    fprintf(out, ", %s%d.phase with", kind, number);
    for (const char *const *name = cml_phase_numbers(phase->kind); *name; name++) fprintf(out, " .%s", *name);
}

/* Of planes nothing can be set, so they are left out. */
static void write_shapes(FILE *out, const struct cml_scene *scene)
{
    for (int b = 0; b <= scene->num_layers; b++)
        if (scene->boundaries[b].line > 0) fprintf(out, ", boundary%d.scale and .height", b);
}

/* A pencil has no numbers, other shapes have those that their names say. */
static void write_beams(FILE *out, const struct cml_scene *scene)
{
    static const char *const of_shape[] = {"", " .radius", " .radius", " .r1 .r2", " .w .h", ""};
    for (int k = 0; k < scene->num_beams && k < 9; k++) {
        const struct cml_beam *beam = &scene->beams[k];
        fputs(", beam", out);
        if (scene->num_beams > 1) fprintf(out, "%d", k + 1);
        fprintf(out, " with .x .y%s .angle .azimuth%s%s%s", beam->inside ? " .z" : "", of_shape[beam->kind],
                beam->light.kind == CML_LIGHT_OF_NA ? " .na" : "", scene->num_beams > 1 ? " .share" : "");
    }
}

static void write_detectors(FILE *out, const struct cml_scene *scene)
{
    const int n = scene->num_detectors;
    if (n == 1) fputs(", detector", out);
    if (n > 1) write_owners(out, "detector", 1, n);
    if (n > 0) fputs(" with .x .y .z, what its shape has, and with na= .na .angle .azimuth", out);
}

static void write_names(FILE *out, const struct cml_scene *scene)
{
    fputs("photons, above.n, below.n", out);
    write_media(out, "layer", scene->num_layers, ".n .mua .mus .g .d");
    write_media(out, "body", scene->num_bodies, ".n .mua .mus .g");
    for (int l = 1; l <= scene->num_layers; l++) write_phase(out, "layer", l, scene->media[l].phase);
    for (int k = 0; k < scene->num_bodies; k++)
        write_phase(out, "body", k + 1, scene->media[cml_body_medium(scene, k)].phase);
    if (scene->backing.kind == CML_BACKED_BY_METAL)
        fputs(", backing.n, backing.k", out);
    else if (scene->backing.kind != CML_NO_BACKING)
        fputs(", backing.r", out);
    write_shapes(out, scene);
    write_beams(out, scene);
    write_detectors(out, scene);
}

static cml_status fail_unknown(const struct cml_mci_reader *reader, const struct cml_setting *setting,
                               const struct cml_scene *scene)
{
    char names[600] = "", expected[700];
    FILE *out = fmemopen(names, sizeof names, "w");
    if (out) {
        write_names(out, scene);
        fclose(out);
    }
    snprintf(expected, sizeof expected, "a name that the run in line %d knows: %s", scene->line, names);
    return cml_setting_fail(setting, expected, reader->err);
}

cml_status cml_mci_check_settings(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    const struct cml_settings *settings = reader->options->settings;
    for (int i = 0; settings && i < settings->count; i++)
        if (!reader->taken[i]) return fail_unknown(reader, &settings->item[i], scene);
    return CML_OK;
}
