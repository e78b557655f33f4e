/* The beam line. SPDX-License-Identifier: MIT */
#include "input/mci_beam.h"

#include "input/mci_options.h"

#include <math.h>

/* The order of the keys in cml_mci_beam. */
enum { BEAM_AT, BEAM_ANGLE, BEAM_AZIMUTH };

/* Angles are degrees in the file, as people write them, and rad from here on. */
static cml_status set_beam_option(const struct cml_mci_line_options *options, struct cml_beam *beam)
{
    const double rad = acos(-1.0) / 180;
    double values[2] = {0, 0};
    switch (options->key) {
    case BEAM_AT:
        if (!cml_mci_parse_list(options->value, 2, values))
            return cml_mci_fail_value(options, "x,y in cm without blanks");
        beam->x = values[0];
        beam->y = values[1];
        return CML_OK;
    case BEAM_ANGLE:
        if (!cml_mci_parse_list(options->value, 1, values) || values[0] < 0 || values[0] >= 90)
            return cml_mci_fail_value(options, "degrees, 0 <= angle < 90");
        beam->angle = values[0] * rad;
        return CML_OK;
    default:
        if (!cml_mci_parse_list(options->value, 1, values) || fabs(values[0]) > 360)
            return cml_mci_fail_value(options, "degrees, -360..360");
        beam->azimuth = values[0] * rad;
        return CML_OK;
    }
}

/* The shape comes first and is no option: without it nobody would know what the radius is of. */
static cml_status read_beam_shape(const struct cml_mci_line_options *options, struct cml_beam *beam)
{
    static const char *const shapes[] = {"pencil", "disk", "gaussian"};
    static const enum cml_beam_kind kinds[] = {CML_BEAM_PENCIL, CML_BEAM_DISK, CML_BEAM_GAUSSIAN};
    static const struct cml_mci_field radius = {"radius", CML_MCI_TINY, CML_MCI_HUGE, false,
                                                "a length of 1e-30..1e30 cm"};
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
