/* What lines of boundaries and of bodies have in common that name a mesh: the file, and options behind it.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_options.h"
#include "input/mesh/obj.h"

enum cml_mci_mesh_file { CML_MCI_FILE_OBJ, CML_MCI_FILE_GSF, CML_MCI_FILE_ASC };

/* Whether name is one, and of which kind by its ending; NULL: there is no word. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_mesh_name(const struct cml_mci_line *line, const char *name,
                                           enum cml_mci_mesh_file *kind);

/* Takes the value of `units`. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_mesh_units(const struct cml_mci_line *line, struct cml_obj_options *obj);
