/* SPDX-License-Identifier: MIT */
#include "input/mci_mesh.h"

cml_status cml_mci_mesh_units(const struct cml_mci_line *line, struct cml_mesh_file_options *obj)
{
    static const char *const units[] = {"cm", "mm", "um", "m"};
    static const double cm[] = {1, 0.1, 1e-4, 100};
    const int which = cml_mci_choose(line->value, units, 4);
    if (which < 0) return cml_mci_fail_value(line, line->key->noun);
    obj->unit = cm[which];
    return CML_OK;
}

/* A mesh file's format is that of its ending, too, but only its reader (mesh_file.c) needs to know which. */
cml_status cml_mci_mesh_name(const struct cml_mci_line *line, const char *name, enum cml_mci_mesh_file *kind)
{
    if (!name || *name == '"' || *name == '\0')
        return cml_mci_fail_option(line, "file", name, "a file name in a pair of quotes");
    if (cml_mesh_file_is_known(name))
        *kind = CML_MCI_FILE_MESH;
    else if (cml_file_ends_in(name, ".gsf"))
        *kind = CML_MCI_FILE_GSF;
    else if (cml_file_ends_in(name, ".asc"))
        *kind = CML_MCI_FILE_ASC;
    else
        return cml_mci_fail_option(line, "file", name,
                                   "an " CML_MESH_FILE_ENDINGS
                                   " mesh, a .gsf or .asc heightmap, or the word gaussian");
    return CML_OK;
}
