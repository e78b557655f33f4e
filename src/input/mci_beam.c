/* The beam line. SPDX-License-Identifier: MIT */
#include "input/mci_beam.h"

#include "input/mci_options.h"
#include "input/mci_settings.h"

#include <math.h>

/* The order of the keys in cml_mci_beam. */
enum { BEAM_AT, BEAM_ANGLE, BEAM_AZIMUTH };

static const char angle_range[] = "degrees, 0 <= angle < 90", azimuth_range[] = "degrees, -360..360";

static bool parse_angle(const char *text, double *degrees)
{
    return cml_mci_parse_list(text, 1, degrees) && *degrees >= 0 && *degrees < 90;
}

static bool parse_azimuth(const char *text, double *degrees)
{
    return cml_mci_parse_list(text, 1, degrees) && fabs(*degrees) <= 360;
}

static double radians(double degrees)
{
    return degrees * (acos(-1.0) / 180);
}

/* Angles are degrees in the file, as people write them, and rad from here on. */
static cml_status set_beam_option(const struct cml_mci_line_options *options, struct cml_beam *beam)
{
    double values[2] = {0, 0};
    switch (options->key) {
    case BEAM_AT:
        if (!cml_mci_parse_list(options->value, 2, values))
            return cml_mci_fail_value(options, "x,y in cm without blanks");
        beam->x = values[0];
        beam->y = values[1];
        return CML_OK;
    case BEAM_ANGLE:
        if (!parse_angle(options->value, values)) return cml_mci_fail_value(options, angle_range);
        beam->angle = radians(values[0]);
        return CML_OK;
    default:
        if (!parse_azimuth(options->value, values)) return cml_mci_fail_value(options, azimuth_range);
        beam->azimuth = radians(values[0]);
        return CML_OK;
    }
}

static const struct cml_mci_field radius = {"radius", CML_MCI_TINY, CML_MCI_HUGE, false,
                                            "a length of 1e-30..1e30 cm"};

/* The shape comes first and is no option: without it nobody would know what the radius is of. */
static cml_status read_beam_shape(const struct cml_mci_line_options *options, struct cml_beam *beam)
{
    static const char *const shapes[] = {"pencil", "disk", "gaussian"};
    static const enum cml_beam_kind kinds[] = {CML_BEAM_PENCIL, CML_BEAM_DISK, CML_BEAM_GAUSSIAN};
    const char *word = cml_text_word(&options->reader->cursor);
    const int which = word ? cml_mci_choose(word, shapes, 3) : -1;
    if (which < 0) return cml_mci_fail_option(options, "shape", word, "pencil, disk R or gaussian R");
    beam->kind = kinds[which];
    if (beam->kind == CML_BEAM_PENCIL) return CML_OK;
    word = cml_text_word(&options->reader->cursor);
    if (word && cml_mci_parse(&radius, word, &beam->radius)) return CML_OK;
    return cml_mci_fail_option(options, radius.name, word, radius.expected);
}

/* A second line would overrule the first unseen: it is refused. */
cml_status cml_mci_beam(struct cml_mci_reader *reader, struct cml_beam *beam)
{
    struct cml_mci_line_options options = {.reader = reader,
                                           .owner = "beam",
                                           .keys = {"at", "angle", "azimuth"},
                                           .list = "at=, angle= or azimuth="};
    if (beam->given) return cml_mci_fail(reader, "line", cml_mci_raw(reader), "one beam line per run");
    beam->given = true;
    cml_mci_cut_comment(reader->cursor);
    CML_TRY(read_beam_shape(&options, beam));
    for (bool more = true; more;) {
        CML_TRY(cml_mci_next_option(&options, &more));
        if (more) CML_TRY(set_beam_option(&options, beam));
    }
    return CML_OK;
}

/* A pencil has no radius that could be set. */
cml_status cml_mci_beam_settings(struct cml_mci_reader *reader, struct cml_beam *beam)
{
    double degrees = 0;
    const struct cml_setting *setting = cml_mci_setting(reader, "beam.angle");
    if (setting && !parse_angle(setting->value, &degrees))
        return cml_setting_fail(setting, angle_range, reader->err);
    if (setting) beam->angle = radians(degrees);
    setting = cml_mci_setting(reader, "beam.azimuth");
    if (setting && !parse_azimuth(setting->value, &degrees))
        return cml_setting_fail(setting, azimuth_range, reader->err);
    if (setting) beam->azimuth = radians(degrees);
    if (beam->kind == CML_BEAM_PENCIL) return CML_OK;
    return cml_mci_set(reader, cml_mci_setting(reader, "beam.radius"), &radius, &beam->radius);
}
