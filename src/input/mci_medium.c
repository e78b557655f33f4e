/* SPDX-License-Identifier: MIT */
#include "input/mci_medium.h"

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

cml_status cml_mci_medium(const struct cml_mci_reader *reader, const char *owner,
                          const double values[CML_MCI_MEDIUM_FIELDS], const struct cml_setting *mua,
                          struct cml_medium_def *medium)
{
    static const char expected[] = "0, or at least 1e-11 of mua + mus";
    char field[48], value[32];
    *medium = (struct cml_medium_def){.n = values[0], .mua = values[1], .mus = values[2], .g = values[3]};
    if (!(values[1] > 0 && values[1] < CML_LEAST_ABSORPTION * (values[1] + values[2]))) return CML_OK;
    snprintf(field, sizeof field, "%s: mua", owner);
    snprintf(value, sizeof value, "%g", values[1]);
    if (mua) return cml_setting_fail(mua, expected, reader->err);
    return cml_mci_fail(reader, field, value, expected);
}
