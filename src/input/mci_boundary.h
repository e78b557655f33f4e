/* The lines of .mci files that give a boundary its shape, b and m, and the files that they name.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

/* Reads the current b or m line (cursor behind the keyword) and the file that it may name into *boundary,
 * which is number `index`. What was allocated before a failure belongs to *boundary. */
CML_NODISCARD cml_status cml_mci_boundary(struct cml_mci_reader *reader, enum cml_mci_kind kind, int index,
                                          struct cml_boundary *boundary);
