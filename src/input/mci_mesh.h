/* Words that lines of boundaries and of bodies share if they name a mesh: the file and its units.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_options.h"
#include "input/mesh/mesh_file.h"

enum cml_mci_mesh_file { CML_MCI_FILE_MESH, CML_MCI_FILE_GSF, CML_MCI_FILE_ASC };

/* Checks the name of a mesh or heightmap, and sets its kind by the ending. name NULL: the word is missing.
 * CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_mesh_name(const struct cml_mci_line *line, const char *name,
                                           enum cml_mci_mesh_file *kind);

/* Reads the value of the option `units` into obj->unit. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_mesh_units(const struct cml_mci_line *line,
                                            struct cml_mesh_file_options *obj);
