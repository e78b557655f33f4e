/* Reader of the lines `b` and `m` of .mci files, which give a boundary its shape. SPDX-License-Identifier:
 * MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

/* Reads the current `b` or `m` line (cursor behind the keyword) and the file that it may name into *boundary,
 * which has the number `index`. *boundary owns its memory even after a failure. */
CML_NODISCARD cml_status cml_mci_boundary(struct cml_mci_reader *reader, enum cml_mci_kind kind, int index,
                                          struct cml_boundary *boundary);
