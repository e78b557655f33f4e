/* Input files, remembered as they are read. Rank 0 sends them to the other ranks, which read from memory the
 * bytes that rank 0 read from disk. Checkpoints are compared with them, too. SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"

struct cml_input {
    char *path; /* as the scene named the file */
    char *data; /* [size] bytes and a final NUL */
    size_t size;
};

struct cml_inputs {
    size_t count;
    struct cml_input *item; /* [count] files in the order of reading */
};

/* Returns a source that reads from the file system and adds every file to `inputs`, which must outlive the
 * source. */
struct cml_text_source cml_inputs_recorder(struct cml_inputs *inputs);

/* Returns a source that finds files in `inputs` only, and returns CML_E_INPUT for any other path. */
struct cml_text_source cml_inputs_replayer(struct cml_inputs *inputs);

/* Adds a copy of data[size] as the file `path`. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_inputs_add(struct cml_inputs *inputs, const char *path, const char *data,
                                        size_t size, struct cml_error *err);

/* Packs all files into one block, which the caller frees. Returns CML_E_INPUT if memory runs out. */
CML_NODISCARD cml_status cml_inputs_pack(const struct cml_inputs *inputs, char **block, size_t *size,
                                         struct cml_error *err);

/* Fills *inputs with the files of a block from cml_inputs_pack, without checking the block. Returns
 * CML_E_INPUT if memory runs out. */
CML_NODISCARD cml_status cml_inputs_unpack(const char *block, size_t size, struct cml_inputs *inputs,
                                           struct cml_error *err);

/* Frees all files. Does nothing for a zeroed structure. */
void cml_inputs_clear(struct cml_inputs *inputs);
