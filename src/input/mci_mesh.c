/* SPDX-License-Identifier: MIT */
#include "input/mci_mesh.h"

#include <math.h>
#include <string.h>
#include <strings.h>

const char *const cml_mci_up_names[6] = {"z", "-z", "y", "-y", "x", "-x"};

/* Reads an option of a mesh: one case for each key. */
cml_status cml_mci_mesh_option(const struct cml_mci_line_options *options, struct cml_obj_options *obj)
{
    static const char *const units[] = {"cm", "mm", "um", "m"};
    static const double cm[] = {1, 0.1, 1e-4, 100};
    static const char *const normals[] = {"face", "vertex"};
    const char *value = options->value;
    int which = -1;
    switch (options->key) {
    case CML_MCI_MESH_UNITS:
        which = cml_mci_choose(value, units, 4);
        if (which < 0) return cml_mci_fail_value(options, "cm, mm, um or m");
        obj->unit = cm[which];
        return CML_OK;
    case CML_MCI_MESH_SCALE:
        if (cml_mci_parse_list(value, 1, &obj->scale) && obj->scale >= CML_MCI_TINY) return CML_OK;
        return cml_mci_fail_value(options, "a number of 1e-30..1e30");
    case CML_MCI_MESH_SHIFT:
        if (cml_mci_parse_list(value, 3, obj->shift)) return CML_OK;
        return cml_mci_fail_value(options, "x,y,z in cm without blanks");
    case CML_MCI_MESH_UP:
        which = cml_mci_choose(value, cml_mci_up_names, 6);
        if (which < 0) return cml_mci_fail_value(options, "x, -x, y, -y, z or -z");
        obj->up = (enum cml_up_axis)which;
        return CML_OK;
    case CML_MCI_MESH_ROTATE:
        if (cml_mci_parse_list(value, 1, &obj->rotate) && fabs(obj->rotate) <= 360) return CML_OK;
        return cml_mci_fail_value(options, "degrees of -360..360");
    case CML_MCI_MESH_SKIRT:
        if (cml_mci_parse_list(value, 1, &obj->skirt) && obj->skirt >= CML_MCI_TINY) return CML_OK;
        return cml_mci_fail_value(options, "a width of 1e-30..1e30 cm");
    case CML_MCI_BODY_UNION:
        obj->unite = true;
        return options->alone ? CML_OK : cml_mci_fail_value(options, "the word union alone");
    default:
        which = cml_mci_choose(value, normals, 2);
        if (which < 0) return cml_mci_fail_value(options, "face or vertex");
        obj->normals = which == 0 ? CML_NORMALS_FACET : CML_NORMALS_VERTEX;
        return CML_OK;
    }
}

/* The ending decides how a file is read. Meshes for printers have no reader here. */
cml_status cml_mci_mesh_name(const struct cml_mci_line_options *options, const char *name,
                             enum cml_mci_mesh_file *kind)
{
    static const char *const endings[] = {".obj", ".gsf", ".asc"};
    if (!name || *name == '"' || *name == '\0')
        return cml_mci_fail_option(options, "file", name, "a file name in a pair of quotes");
    const char *dot = strrchr(name, '.');
    for (int i = 0; dot && i < 3; i++) {
        *kind = (enum cml_mci_mesh_file)i;
        if (strcasecmp(dot, endings[i]) == 0) return CML_OK;
    }
    const bool other = dot && (strcasecmp(dot, ".stl") == 0 || strcasecmp(dot, ".ply") == 0);
    return cml_mci_fail_option(options, "file", name,
                               other ? "an .obj file: convert it, with MeshLab for instance"
                                     : "an .obj file, a .gsf or .asc heightmap, or the word gaussian");
}
