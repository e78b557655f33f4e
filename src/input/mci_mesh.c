/* SPDX-License-Identifier: MIT */
#include "input/mci_mesh.h"

#include <string.h>
#include <strings.h>

/* Reads the unit of length of a mesh file and stores the unit in cm. */
cml_status cml_mci_mesh_units(const struct cml_mci_line *line, struct cml_obj_options *obj)
{
    static const char *const units[] = {"cm", "mm", "um", "m"};
    static const double cm[] = {1, 0.1, 1e-4, 100};
    const int which = cml_mci_choose(line->value, units, 4);
    if (which < 0) return cml_mci_fail_value(line, line->key->noun);
    obj->unit = cm[which];
    return CML_OK;
}

/* Finds the format of a mesh by the ending of its file name. Formats of 3D printers (.stl, .ply) cannot be
 * read, so the message advises to convert them. */
cml_status cml_mci_mesh_name(const struct cml_mci_line *line, const char *name, enum cml_mci_mesh_file *kind)
{
    static const char *const endings[] = {".obj", ".gsf", ".asc"};
    if (!name || *name == '"' || *name == '\0')
        return cml_mci_fail_option(line, "file", name, "a file name in a pair of quotes");
    const char *dot = strrchr(name, '.');
    for (int i = 0; dot && i < 3; i++) {
        *kind = (enum cml_mci_mesh_file)i;
        if (strcasecmp(dot, endings[i]) == 0) return CML_OK;
    }
    const bool other = dot && (strcasecmp(dot, ".stl") == 0 || strcasecmp(dot, ".ply") == 0);
    return cml_mci_fail_option(line, "file", name,
                               other ? "an .obj file: convert it, with MeshLab for instance"
                                     : "an .obj file, a .gsf or .asc heightmap, or the word gaussian");
}
