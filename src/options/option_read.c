/* SPDX-License-Identifier: MIT */
#include "options/option_read.h"

#include "engine/engines.h"
#include "options/option_table.h"
#include "options/option_values.h"

#include <stdio.h>
#include <string.h>

void cml_options_default(struct cml_options *options)
{
    *options = (struct cml_options){.engine = cml_engine_find("cpu")};
    /* one false alarm in a hundred comparisons */
    options->alpha = 0.01;
    /* a fixed seed: whoever has the file can repeat the run */
    options->engine_options.seed = 1;
    options->run = 1;
    options->engine_options.lattice = true;
    options->engine_options.roulette = (struct cml_roulette_options){0.003, 0.01};
    options->engine_options.reentry = true;
    options->engine_options.absorption = true;
    /* s: a kill costs at most a minute of work, and a host is lost only after a minute of silence */
    options->checkpoint_interval = 60;
    options->timeout = 60;
    options->surface.force = CML_SURFACE_AUTO;
    options->surface.tolerance = 1e-3;
    options->surface.tessellation.normals = CML_NORMALS_ANALYTIC;
    options->surface.budget.most = cml_mesh_budget_default();
}

/* Refuses an option that has no effect on this command or engine, because the user expected one. */
static cml_status check_belongs(const struct cml_option *option, const char *typed,
                                const struct cml_options *options, struct cml_error *err)
{
    const struct cml_option *engine = cml_option_find("engine", strlen("engine"));
    const char *command = cml_commands[options->which].name;
    char owners[160] = "";
    if (!cml_option_belongs(option, options->which)) {
        cml_option_commands(option, owners, sizeof owners);
        return cml_fail(err, CML_E_INPUT, "%s: %s does not apply (it belongs to: %s)", command, typed,
                        owners);
    }
    if (!option->engine || !cml_option_belongs(engine, options->which) ||
        strcmp(option->engine, options->engine->name) == 0)
        return CML_OK;
    return cml_fail(err, CML_E_INPUT, "%s: %s does not apply to engine %s (it belongs to: %s)", command,
                    typed, options->engine->name, option->engine);
}

cml_status cml_option_read(const struct cml_option *option, const char *typed, const char *value,
                           bool surplus, struct cml_options *options, struct cml_error *err)
{
    if (!options->help && !options->version) CML_TRY(check_belongs(option, typed, options, err));
    if (option->argument && !value)
        return cml_fail(err, CML_E_INPUT, "%s is missing its value (try clustermcml --help)", typed);
    if (surplus) return cml_fail(err, CML_E_INPUT, "%s takes no value (try clustermcml --help)", typed);
    return option->read(option, value, options, err);
}

/* Reads the options of one pass: the engine decides which options are allowed, and is read first. */
static cml_status read_pass(const char *const *words, bool engine, struct cml_options *options,
                            struct cml_error *err)
{
    for (; *words; words++) {
        const size_t length = strcspn(*words, "=");
        const struct cml_option *option = cml_option_find(*words, length);
        char typed[64];
        if (engine != (option->read == cml_read_engine)) continue;
        snprintf(typed, sizeof typed, "--%.*s", length < 60 ? (int)length : 60, *words);
        const char *value = (*words)[length] ? *words + length + 1 : NULL;
        CML_TRY(cml_option_read(option, typed, value, value && !option->argument, options, err));
    }
    return CML_OK;
}

cml_status cml_options_read(const char *const *words, struct cml_options *options, struct cml_error *err)
{
    CML_TRY(read_pass(words, true, options, err));
    return read_pass(words, false, options, err);
}
