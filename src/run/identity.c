/* SPDX-License-Identifier: MIT */
#include "run/identity.h"

#include "base/text.h"
#include "base/version.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

/* Returns the options that decide the bits of a result. Threads, ranks, chunks and devices do not, so a run
 * may be resumed with others. */
struct cml_provenance cml_run_provenance(const struct cml_run_setup *setup,
                                         const struct cml_surface_options *surface, bool flat)
{
    const struct cml_engine_options *options = &setup->options;
    struct cml_provenance provenance = {.engine = ""};
#define TAKE(name, from, ...) provenance.value[CML_DECIDES_##name] = (double)(from);
    CML_OPTIONS_OF_BITS(TAKE)
    snprintf(provenance.engine, sizeof provenance.engine, "%s", setup->engine->name);
    return provenance;
}

/* Writes name, size and checksum of a file. The name is without directories, so that the folder may be moved.
 */
static void write_input(FILE *out, const struct cml_input *input)
{
    const char *path = cml_text_name(input->path), *slash = strrchr(path, '/');
    const uLong sum = crc32_z(crc32(0, NULL, 0), (const Bytef *)input->data, input->size);
    fprintf(out, "input %s of %zu bytes, crc32 %08lx\n", slash ? slash + 1 : path, input->size, sum);
}

/* Writes a line for each input file, in the order in which the files were read. The line has a checksum, so a
 * run with a changed mesh is another run. */
cml_status cml_identity_inputs(const struct cml_inputs *inputs, char **text, struct cml_error *err)
{
    size_t size = 0;
    FILE *out = open_memstream(text, &size);
    for (size_t i = 0; out && i < inputs->count; i++) write_input(out, &inputs->item[i]);
    return cml_text_end(out, text, &size, "the run's identity", err);
}

/* Writes the lines of options first: messages show the first line that differs, and an option says more than
 * a checksum. */
cml_status cml_identity_of(const struct cml_provenance *provenance, const char *settings, const char *inputs,
                           char **identity, struct cml_error *err)
{
    size_t size = 0;
    FILE *out = open_memstream(identity, &size);
    if (!out) return cml_fail_memory(err, 1, "the run's identity");
    fprintf(out, "program %s\n", cml_version());
    cml_provenance_identify(out, provenance);
    cml_text_print(out, "set ", settings);
    fputs(inputs, out);
    return cml_text_end(out, identity, &size, "the run's identity", err);
}

void cml_identity_sum(const char *identity, char sum[CML_IDENTITY_SUM])
{
    const Bytef *const bytes = (const Bytef *)identity;
    const size_t size = strlen(identity);
    snprintf(sum, CML_IDENTITY_SUM, "%08lx%08lx", crc32_z(crc32(0, NULL, 0), bytes, size),
             adler32_z(adler32(0, NULL, 0), bytes, size));
}
