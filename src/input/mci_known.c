/* Shapes that were read before: rows of a sweep borrow them. SPDX-License-Identifier: MIT */
#include "input/mci_boundary.h"

#include "input/mci_settings.h"

#include <stdio.h>
#include <string.h>

static bool same_value(const struct cml_setting *one, const struct cml_setting *other)
{
    return one && other ? strcmp(one->value, other->value) == 0 : one == other;
}

const struct cml_boundary *cml_mci_known_shape(struct cml_mci_reader *reader, int index)
{
    static const char *const of[] = {"scale", "height"};
    static const struct cml_settings none;
    const struct cml_input_options *options = reader->options;
    char name[CML_SETTING_NAME];
    if (!options->known) return NULL;
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        snprintf(name, sizeof name, "boundary%d.%s", index, of[i]);
        const struct cml_setting *then =
            cml_settings_find(options->known_settings ? options->known_settings : &none, name);
        if (!same_value(cml_mci_setting(reader, "%s", name), then)) return NULL;
    }
    return &options->known->scenes[reader->run].boundaries[index];
}

void cml_mci_borrow_shape(const struct cml_boundary *from, struct cml_boundary *boundary)
{
    const double z = boundary->z;
    *boundary = *from;
    boundary->z = z;
    boundary->borrowed = true;
}
