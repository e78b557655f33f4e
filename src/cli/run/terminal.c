/* SPDX-License-Identifier: MIT */
#include "cli/run/terminal.h"

#include "base/print_line.h"
#include "run/cluster/cluster.h"

#include <stdio.h>

/* Prints a note on standard error, with the number of the rank unless it is rank 0. */
void cml_print_note(void *context, const char *text)
{
    char who[32] = "";
    (void)context;
    if (cml_cluster_rank() > 0) snprintf(who, sizeof who, "rank %d: ", cml_cluster_rank());
    fprintf(stderr, "clustermcml: note: %s", who);
    cml_print_line(stderr, text);
}

/* Prints the largest memory that a run will need, with the shares of sums and of writing files. */
void cml_print_memory(const struct cml_options *options, const struct cml_scene *scene,
                      const struct cml_surface_set *surfaces)
{
    const struct cml_memory memory = cml_memory_of(options, scene, surfaces);
    const double mib = 1048576;
    printf("  memory: at most %.0f MiB (tallies %.3g MiB, writing %.3g MiB)\n", memory.most / mib,
           memory.tallies / mib, memory.output / mib);
}

/* Prints what the reader changed on the mesh of boundary b, so that the user can correct the file. Nothing
 * if nothing was changed. */
void cml_print_mesh_repairs(const struct cml_scene *scene, int b)
{
    const struct cml_boundary *boundary = &scene->boundaries[b];
    const struct cml_mesh_notes *notes = &boundary->mesh_notes;
    if (boundary->form != CML_FORM_MESH) return;
    if (notes->bent > 0)
        printf("    boundary %d: %zu faces lie in no plane and were cut into triangles, corners up to %.3g "
               "cm off the face's mean plane\n",
               b, notes->bent, notes->bend);
    if (notes->joined > 0)
        printf("    boundary %d: %zu corners were joined with others, up to %.3g cm away (weld=%g)\n", b,
               notes->joined, notes->join_distance, boundary->mesh.weld);
    if (notes->levelled > 0)
        printf("    boundary %d: the mesh's border was levelled, its heights differed by %.3g cm\n", b,
               notes->levelled);
    if (notes->skirt > 0)
        printf("    boundary %d: skirt of %g cm around the mesh to its border's mean height %g cm: %zu "
               "triangles, up to %.3g cm\n",
               b, boundary->mesh.skirt, 0.0 - boundary->mesh.z_border, notes->skirt, notes->skirt_rise);
}
