/* The cluster (cluster.h) of a program that was built without MPI: it loads the MPI library of the machine
 * when a launcher started it, and the adapter for the ABI of that library. Adapters lie beside the program.
 * They are linked with no MPI library, so one file serves all libraries of one ABI.
 * SPDX-License-Identifier: MIT */
#include "run/cluster/cluster_calls.h"
#include "run/cluster/launcher.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const struct cml_cluster_calls *calls = &cml_cluster_single;

/* The ABIs of MPI: the adapter, and the names that libraries of this ABI have. */
static const struct abi {
    const char *adapter, *libraries[3];
} abis[] = {
    {"cluster_openmpi.so", {"libmpi.so.40"}},
    {"cluster_mpich.so", {"libmpi.so.12", "libmpich.so.12"}},   /* Intel MPI and Cray MPICH, too */
    {"cluster_abi.so", {"libmpi_abi.so.1", "libmpi_abi.so.0"}}, /* the standard ABI of MPI 5 */
};
enum { OPENMPI, MPICH, STANDARD, ABIS };

/* Opens an MPI library with global symbols: adapters name no library, and plugins of Open MPI search for
 * them. */
static void *open_library(const char *name)
{
    return dlopen(name, RTLD_NOW | RTLD_GLOBAL);
}

/* Opens the library that CLUSTERMCML_MPI_LIBRARY names. A symbol tells Open MPI. MPICH 5 has the symbols of
 * the standard ABI in its libmpi.so.12, too, so the name tells these two apart. */
static cml_status open_named(const char *name, const struct abi **abi, struct cml_error *err)
{
    void *library = open_library(name);
    if (!library) return cml_fail(err, CML_E_DEVICE, "CLUSTERMCML_MPI_LIBRARY: %s", dlerror());
    const bool is_standard = strstr(name, "libmpi_abi");
    *abi = &abis[dlsym(library, "ompi_mpi_comm_world") ? OPENMPI : is_standard ? STANDARD : MPICH];
    return CML_OK;
}

/* Opens the first MPI library that the system finds. Open MPI's launcher is told by its variable, and its
 * library is tried first there. Under other launchers it is tried last. NULL: there is no library, and `why`
 * has the reason for each name. */
static const struct abi *open_first(char *why, size_t size)
{
    const int first = getenv("OMPI_COMM_WORLD_SIZE") ? OPENMPI : MPICH;
    size_t used = 0;
    for (int i = 0; i < ABIS; i++) {
        const struct abi *abi = &abis[(first + i) % ABIS];
        for (int k = 0; k < 3 && abi->libraries[k]; k++) {
            if (open_library(abi->libraries[k])) return abi;
            if (used < size)
                used += (size_t)snprintf(why + used, size - used, "%s%s", used ? "; " : "", dlerror());
        }
    }
    return NULL;
}

/* Makes the adapter in the program's own folder the table of all calls. A program without adapters stays a
 * single rank, which refuses to be one of several copies. */
static cml_status load_adapter(const char *name, struct cml_error *err)
{
    char path[4096] = "", why[4200];
    const ssize_t length = readlink("/proc/self/exe", path, sizeof path - 64);
    char *slash = length > 0 ? strrchr(path, '/') : NULL;
    if (!slash) return cml_fail(err, CML_E_DEVICE, "/proc/self/exe: the program's folder is unknown");
    strcpy(slash + 1, name);
    snprintf(why, sizeof why, "%s is missing (an adapter: clustermcml help adapter)", path);
    if (access(path, F_OK) != 0) return cml_launcher_check(1, why, err);
    void *adapter = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    const struct cml_cluster_calls *table = adapter ? dlsym(adapter, "cml_cluster_table") : NULL;
    if (!table) return cml_fail(err, CML_E_DEVICE, "MPI cannot start: %s", dlerror());
    if (strcmp(table->build, calls->build) != 0)
        return cml_fail(err, CML_E_DEVICE, "%s: is of build %s (expected build %s: install both together)",
                        path, table->build, calls->build);
    calls = table;
    return CML_OK;
}

/* Loads MPI. Without a library the process stays a single rank, which refuses to be one of several copies. */
static cml_status load(struct cml_error *err)
{
    const char *named = getenv("CLUSTERMCML_MPI_LIBRARY");
    const struct abi *abi = NULL;
    char reasons[600] = "", why[800];
    if (named)
        CML_TRY(open_named(named, &abi, err));
    else
        abi = open_first(reasons, sizeof reasons);
    snprintf(
        why, sizeof why,
        "no MPI library was found (%s; expected one on the search path, or CLUSTERMCML_MPI_LIBRARY=FILE)",
        reasons);
    return abi ? load_adapter(abi->adapter, err) : cml_launcher_check(1, why, err);
}

cml_status cml_cluster_begin(int *argc, char ***argv, struct cml_error *err)
{
    if (cml_launcher_found() || cml_launcher_size() > 1) CML_TRY(load(err));
    return calls->begin(argc, argv, err);
}

/* All other functions of cluster.h call through the table. */
#define CALL_THROUGH(type, name, parameters, arguments)                                                      \
    type cml_cluster_##name parameters                                                                       \
    {                                                                                                        \
        return calls->name arguments;                                                                        \
    }
#define TELL_THROUGH(name, parameters, arguments)                                                            \
    void cml_cluster_##name parameters                                                                       \
    {                                                                                                        \
        calls->name arguments;                                                                               \
    }
CML_CLUSTER_CALLS(CALL_THROUGH, TELL_THROUGH)
