/* Input files, remembered as they are read: what rank 0 sends to the others, who read
 * from memory what it read from disk, and what a checkpoint is compared with. SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"

struct cml_input {
    char *path; /* as it was asked for */
    char *data; /* [size], and a final NUL */
    size_t size;
};

struct cml_inputs {
    size_t count;
    struct cml_input *item; /* [count], in the order of reading */
};

/* A source that reads the file system and adds every file that it read to `inputs`, which must outlive it. */
struct cml_text_source cml_inputs_recorder(struct cml_inputs *inputs);

/* A source that finds files in `inputs` and nowhere else. CML_E_INPUT for any other path. */
struct cml_text_source cml_inputs_replayer(struct cml_inputs *inputs);

/* All files as one block, the caller's to free, and back. cml_inputs_unpack trusts its block. */
CML_NODISCARD cml_status cml_inputs_pack(const struct cml_inputs *inputs, char **block, size_t *size,
                                         struct cml_error *err);
CML_NODISCARD cml_status cml_inputs_unpack(const char *block, size_t size, struct cml_inputs *inputs,
                                           struct cml_error *err);

void cml_inputs_clear(struct cml_inputs *inputs);
