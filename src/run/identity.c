/* SPDX-License-Identifier: MIT */
#include "run/identity.h"

#include "base/settings.h"
#include "base/version.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

/* Only what changes bits: threads, ranks, chunks and devices do not, and a run may be resumed with others.
 * Numbers with 17 digits, which tell any two doubles apart. */
static void write_options(FILE *out, const struct cml_run_setup *setup,
                          const struct cml_surface_options *surface, bool flat)
{
    const struct cml_engine_options *options = &setup->options;
    const struct cml_tessellation *tessellation = &surface->tessellation;
    fprintf(out, "program %s\nengine %s\nseed %" PRIu64 "\nrun %" PRIu32 "\nphotons %" PRIu64 "\n",
            cml_version(), setup->engine->name, options->seed, options->run + 1, setup->photons);
    fprintf(out, "lattice %d, roulette below %.17g to %.17g\n", options->lattice, options->roulette.below,
            options->roulette.weight);
    fprintf(out, "target error %.17g\nre-entry %d\nabsorption %d\nflat %d\n", setup->target_error,
            options->reentry, options->absorption, flat);
    if (setup->controlled) fprintf(out, "control flat\n");
    cml_settings_print(out, "set ", setup->scene->settings);
    fprintf(out, "boundaries %d, tolerance %.17g, may flatten %d, normals %d, inscribed %d, search %d\n",
            surface->force, surface->tolerance, surface->may_flatten, tessellation->normals,
            tessellation->inscribed, surface->search);
}

/* By name without directories, so that a folder may be moved. */
static void write_input(FILE *out, const struct cml_input *input)
{
    const char *path = cml_text_name(input->path), *slash = strrchr(path, '/');
    const uLong sum = crc32_z(crc32(0, NULL, 0), (const Bytef *)input->data, input->size);
    fprintf(out, "input %s of %zu bytes, crc32 %08lx\n", slash ? slash + 1 : path, input->size, sum);
}

/* A stream in memory fails only where memory runs out. */
static cml_status close_text(FILE *out, const size_t *size, struct cml_error *err)
{
    const int failed = ferror(out);
    if (fclose(out) == 0 && !failed) return CML_OK;
    return cml_fail_memory(err, (double)*size, "the run's identity");
}

/* Of all files that were read, in the order in which they were: a mesh that was changed makes another run. */
cml_status cml_identity_inputs(const struct cml_inputs *inputs, char **text, struct cml_error *err)
{
    size_t size = 0;
    FILE *out = open_memstream(text, &size);
    if (!out) return cml_fail_memory(err, 1, "the run's identity");
    for (size_t i = 0; i < inputs->count; i++) write_input(out, &inputs->item[i]);
    return close_text(out, &size, err);
}

/* The lines for options come first, because the first line that differs is shown, and an option says more
 * than a checksum. */
cml_status cml_identity_of(const struct cml_run_setup *setup, const struct cml_surface_options *surface,
                           bool flat, const char *inputs, char **identity, struct cml_error *err)
{
    size_t size = 0;
    FILE *out = open_memstream(identity, &size);
    if (!out) return cml_fail_memory(err, 1, "the run's identity");
    write_options(out, setup, surface, flat);
    fputs(inputs, out);
    return close_text(out, &size, err);
}
