/* clustermcml devices: lists the processors and OpenCL devices on which this machine can fly photons.
 * SPDX-License-Identifier: MIT */
#include "cli/command.h"

#include "run/cluster/cluster.h"
#include "engine/opencl/opencl.h"
#include "surface/mesh/mesh_surface.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

/* Returns the vector instructions of the processor, by which the cpu engine chooses its level. */
static const char *vector_level(void)
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl")) return "AVX-512";
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return "AVX2";
    return "SSE2";
#else
    return "the compiler's default";
#endif
}

/* Prints a device: its memory for tallies, and whether its sums and roundings are those of the cpu. */
static void print_device(int number, const struct cml_opencl_info *info, int chosen)
{
    const double mib = 1048576;
    printf("%d%s %s: %s, %s\n", number, number == chosen ? "*" : " ", info->type, info->name, info->platform);
    printf("     driver %s, %s\n", info->driver, info->version);
    printf("     %u compute units, %.0f MiB, %.0f MiB in one piece, %.0f KiB local, groups up to %u\n",
           info->units, (double)info->memory / mib, (double)info->largest / mib,
           (double)info->local_memory / 1024, info->largest_group);
    printf("     64-bit atomics %s, division and root %s\n", info->atomics64 ? "yes" : "no (two words)",
           info->exact_division ? "as on the cpu" : "not correctly rounded");
}

/* Lists the processor and all OpenCL devices. A star marks the device that a run on this rank would take. */
cml_status cml_command_devices(const struct cml_options *options, struct cml_error *err)
{
    struct cml_opencl_info *list;
    int count;
    (void)options;
    CML_TRY(cml_opencl_list(&list, &count, err));
    printf("cpu: %ld cores, %s; rays: %s; built with %s\n", sysconf(_SC_NPROCESSORS_ONLN), vector_level(),
           cml_mesh_library(), cml_opencl_build());
    const int chosen = count > 0 ? cml_opencl_default(list, count, cml_cluster_local_rank()) : -1;
    for (int i = 0; i < count; i++) print_device(i, &list[i], chosen);
    if (count == 0)
        printf("no OpenCL device\n");
    else
        printf("* is taken without --device\n");
    free(list);
    return CML_OK;
}
