/* SPDX-License-Identifier: MIT */
#include "input/mci_medium.h"

#include "input/mci_settings.h"

#include <stdio.h>

#define MIN_INDEX 0.01
#define MAX_INDEX 100

const char cml_mci_index_range[] = "a refractive index of 0.01..100";

static const char coefficient[] = "a coefficient of 0..1e30 1/cm";

const struct cml_mci_field cml_mci_medium_fields[CML_MCI_MEDIUM_FIELDS] = {
    {"n", MIN_INDEX, MAX_INDEX, false, cml_mci_index_range},
    {"mua", 0, CML_MCI_HUGE, false, coefficient},
    {"mus", 0, CML_MCI_HUGE, false, coefficient},
    {"g", -1, 1, false, "an anisotropy of -1..1"},
};

static cml_status check_absorption(struct cml_mci_reader *reader, const char *kind, int number,
                                   const struct cml_medium_def *medium)
{
    static const char expected[] = "0, or at least 1e-11 of mua + mus";
    char field[48], value[32];
    const double mut = medium->mua + medium->mus;
    if (!(medium->mua > 0 && medium->mua < CML_LEAST_ABSORPTION * mut)) return CML_OK;
    const struct cml_setting *mua = cml_mci_setting(reader, "%s%d.mua", kind, number);
    snprintf(field, sizeof field, "%s %d: mua", kind, number);
    snprintf(value, sizeof value, "%g", medium->mua);
    if (mua) return cml_setting_fail(mua, expected, reader->err);
    return cml_mci_fail(reader, field, value, expected);
}

cml_status cml_mci_medium(struct cml_mci_reader *reader, const char *kind, int number,
                          const double line[CML_MCI_MEDIUM_FIELDS], struct cml_medium_def *medium)
{
    double values[CML_MCI_MEDIUM_FIELDS];
    for (int i = 0; i < CML_MCI_MEDIUM_FIELDS; i++) {
        const struct cml_mci_field *field = &cml_mci_medium_fields[i];
        values[i] = line[i];
        CML_TRY(cml_mci_set(reader, cml_mci_setting(reader, "%s%d.%s", kind, number, field->name), field,
                            &values[i]));
    }
    *medium = (struct cml_medium_def){.n = values[0], .mua = values[1], .mus = values[2], .g = values[3]};
    return check_absorption(reader, kind, number, medium);
}
