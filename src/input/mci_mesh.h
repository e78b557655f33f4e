/* What lines of boundaries and of bodies have in common that name a mesh: the file, and options behind it.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_options.h"
#include "input/mesh/obj.h"

/* The order of the keys of an m line; an i line has union in place of a tile. */
enum cml_mci_mesh_key {
    CML_MCI_MESH_UP,
    CML_MCI_MESH_ROTATE,
    CML_MCI_MESH_UNITS,
    CML_MCI_MESH_SCALE,
    CML_MCI_MESH_SHIFT,
    CML_MCI_MESH_NORMALS,
    CML_MCI_MESH_SKIRT,
    CML_MCI_MESH_TILE,
    CML_MCI_BODY_UNION = CML_MCI_MESH_TILE
};

enum cml_mci_mesh_file { CML_MCI_FILE_OBJ, CML_MCI_FILE_GSF, CML_MCI_FILE_ASC };

/* In the order of enum cml_up_axis. */
extern const char *const cml_mci_up_names[6];

/* Whether name is one, and of which kind by its ending; NULL: there is no word. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_mesh_name(const struct cml_mci_line_options *options, const char *name,
                                           enum cml_mci_mesh_file *kind);

/* Takes the option read last, which is none of a tile. CML_E_INPUT when its value is wrong. */
CML_NODISCARD cml_status cml_mci_mesh_option(const struct cml_mci_line_options *options,
                                             struct cml_obj_options *obj);
