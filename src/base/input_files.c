/* Remembers input files, replays them from memory, and packs them for other ranks. SPDX-License-Identifier:
 * MIT */
#include "base/input_files.h"

#include "base/array.h"

#include <stdlib.h>
#include <string.h>

/* Returns a copy of data[size] with a final NUL; NULL if memory runs out. */
static char *copy_data(const char *data, size_t size)
{
    char *copy = malloc(size + 1);
    if (!copy) return NULL;
    memcpy(copy, data, size);
    copy[size] = '\0';
    return copy;
}

/* The entry is counted even if one of its copies failed, so that
 * cml_inputs_clear frees the other copy. */
cml_status cml_inputs_add(struct cml_inputs *inputs, const char *path, const char *data, size_t size,
                          struct cml_error *err)
{
    CML_TRY(
        cml_array_grow(&inputs->item, inputs->count, sizeof *inputs->item, "a copy of an input file", err));
    const struct cml_input input = {strdup(path), copy_data(data, size), size};
    inputs->item[inputs->count++] = input;
    if (input.path && input.data) return CML_OK;
    return cml_fail_memory(err, (double)size, "a copy of an input file");
}

/* Returns the file read under `path`, or NULL. Paths are compared as text: all ranks read the same .mci, so
 * all ask with the same text. */
static const struct cml_input *find(const struct cml_inputs *inputs, const char *path)
{
    for (size_t i = 0; i < inputs->count; i++)
        if (strcmp(inputs->item[i].path, path) == 0) return &inputs->item[i];
    return NULL;
}

/* Gives the caller a copy of a remembered file, which the caller frees. */
static cml_status give_copy(const struct cml_input *input, char **data, size_t *size, struct cml_error *err)
{
    *size = input->size;
    *data = copy_data(input->data, *size);
    return *data ? CML_OK : cml_fail_memory(err, (double)*size, "an input file");
}

/* Reads a file and remembers it (a struct cml_text_source). A file that several bodies name is read and kept
 * once. */
static cml_status record(void *context, const char *path, size_t most, char **data, size_t *size,
                         struct cml_error *err)
{
    const struct cml_input *known = find(context, path);
    if (known) return give_copy(known, data, size, err);
    CML_TRY(cml_text_read_file(path, most, data, size, err));
    return cml_inputs_add(context, path, *data, *size, err);
}

/* Finds a file that rank 0 has sent (a struct cml_text_source). Returns CML_E_INPUT for any other path. */
static cml_status replay(void *context, const char *path, size_t most, char **data, size_t *size,
                         struct cml_error *err)
{
    (void)most; /* rank 0 has checked the size while recording */
    const struct cml_input *known = find(context, path);
    if (known) return give_copy(known, data, size, err);
    return cml_fail(err, CML_E_INPUT, "%s: rank 0 did not read this file", cml_text_name(path));
}

struct cml_text_source cml_inputs_recorder(struct cml_inputs *inputs)
{
    return (struct cml_text_source){record, inputs};
}

struct cml_text_source cml_inputs_replayer(struct cml_inputs *inputs)
{
    return (struct cml_text_source){replay, inputs};
}

/* Packs the files into one block: path, size, bytes of each file in turn. Sizes are in native byte order, as
 * all ranks run the same program on the same kind of machine. */
cml_status cml_inputs_pack(const struct cml_inputs *inputs, char **block, size_t *size, struct cml_error *err)
{
    FILE *out = open_memstream(block, size);
    for (size_t i = 0; out && i < inputs->count; i++) {
        const struct cml_input *input = &inputs->item[i];
        fwrite(input->path, 1, strlen(input->path) + 1, out);
        fwrite(&input->size, sizeof input->size, 1, out);
        fwrite(input->data, 1, input->size, out);
    }
    return cml_text_end(out, block, size, "the input files", err);
}

/* Rebuilds the list of input files from one block of bytes, as another rank has sent it. Each file is its
 * path with a NUL, the number of bytes as a size_t, and the bytes. */
cml_status cml_inputs_unpack(const char *block, size_t size, struct cml_inputs *inputs, struct cml_error *err)
{
    *inputs = (struct cml_inputs){0};
    const char *end = block + size;
    while (block < end) {
        const char *path = block;
        size_t length = 0;
        block += strlen(path) + 1;
        memcpy(&length, block, sizeof length);
        block += sizeof length;
        CML_TRY(cml_inputs_add(inputs, path, block, length, err));
        block += length;
    }
    return CML_OK;
}

void cml_inputs_clear(struct cml_inputs *inputs)
{
    for (size_t i = 0; i < inputs->count; i++) {
        free(inputs->item[i].path);
        free(inputs->item[i].data);
    }
    free(inputs->item);
    *inputs = (struct cml_inputs){0};
}
