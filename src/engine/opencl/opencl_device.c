/* The OpenCL devices of this machine: finds, lists and chooses them.
 * SPDX-License-Identifier: MIT */
#include "engine/opencl/opencl_parts.h"

#include "base/text.h"

#include <stdlib.h>
#include <string.h>

/* Most platforms; there is one for each driver, so this is more than a machine is likely to have. */
#define MOST_PLATFORMS 16

/* Returns the name of an error code. The table has the codes that users meet: those of a device that is
 * missing, too small or too old. */
static const char *code_name(cl_int code)
{
#define NAME(code)                                                                                           \
    {                                                                                                        \
        code, #code                                                                                          \
    }
    static const struct {
        cl_int code;
        const char *name;
    } names[] = {
        NAME(CL_DEVICE_NOT_FOUND),       NAME(CL_DEVICE_NOT_AVAILABLE),
        NAME(CL_COMPILER_NOT_AVAILABLE), NAME(CL_MEM_OBJECT_ALLOCATION_FAILURE),
        NAME(CL_OUT_OF_RESOURCES),       NAME(CL_OUT_OF_HOST_MEMORY),
        NAME(CL_BUILD_PROGRAM_FAILURE),  NAME(CL_INVALID_BUFFER_SIZE),
        NAME(CL_INVALID_BUILD_OPTIONS),  NAME(CL_INVALID_BINARY),
        NAME(CL_INVALID_KERNEL_NAME),    NAME(CL_INVALID_KERNEL_ARGS),
        NAME(CL_INVALID_COMMAND_QUEUE),  NAME(CL_INVALID_WORK_GROUP_SIZE),
    };
#undef NAME
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (names[i].code == code) return names[i].name;
    return "OpenCL error";
}

cml_status cml_opencl_fail(const struct cml_opencl_device *device, const char *what, cl_int code,
                           struct cml_error *err)
{
    return cml_fail(err, CML_E_DEVICE, "opencl device %d (%s): %s: %s (%d)", device->number,
                    device->info.name, what, code_name(code), code);
}

/* Asks a device for a value. If the device does not answer, the value is zero or an empty text, and its user
 * checks it. */
static void ask(cl_device_id id, cl_device_info what, size_t size, void *value)
{
    memset(value, 0, size);
    if (clGetDeviceInfo(id, what, size, value, NULL) != CL_SUCCESS) memset(value, 0, size);
}

/* True if the device lists an extension. The size of the list is asked first, because drivers may make it as
 * long as they like. */
static bool has_extension(cl_device_id id, const char *name)
{
    CML_FREED char *all = NULL;
    size_t size = 0;
    if (clGetDeviceInfo(id, CL_DEVICE_EXTENSIONS, 0, NULL, &size) == CL_SUCCESS) all = calloc(1, size + 1);
    return all && clGetDeviceInfo(id, CL_DEVICE_EXTENSIONS, size, all, NULL) == CL_SUCCESS &&
           strstr(all, name);
}

/* Asks a device for its properties: name, memory, units and so on. A driver need not answer every
 * question. */
static void describe(cl_platform_id platform, cl_device_id id, struct cml_opencl_info *info)
{
    cl_device_type type;
    cl_uint units;
    cl_ulong memory, largest, local;
    size_t group;
    cl_device_fp_config floats;
    ask(id, CL_DEVICE_NAME, sizeof info->name, info->name);
    ask(id, CL_DEVICE_VENDOR, sizeof info->vendor, info->vendor);
    ask(id, CL_DEVICE_VERSION, sizeof info->version, info->version);
    ask(id, CL_DRIVER_VERSION, sizeof info->driver, info->driver);
    if (clGetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof info->platform, info->platform, NULL) !=
        CL_SUCCESS)
        info->platform[0] = '\0';
    ask(id, CL_DEVICE_TYPE, sizeof type, &type);
    ask(id, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof units, &units);
    ask(id, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof memory, &memory);
    ask(id, CL_DEVICE_MAX_MEM_ALLOC_SIZE, sizeof largest, &largest);
    ask(id, CL_DEVICE_LOCAL_MEM_SIZE, sizeof local, &local);
    ask(id, CL_DEVICE_MAX_WORK_GROUP_SIZE, sizeof group, &group);
    ask(id, CL_DEVICE_SINGLE_FP_CONFIG, sizeof floats, &floats);
    info->type = type & CL_DEVICE_TYPE_GPU ? "GPU" : (type & CL_DEVICE_TYPE_CPU ? "CPU" : "other");
    info->units = units ? units : 1;
    info->memory = memory;
    info->largest = largest;
    info->local_memory = local;
    info->largest_group = (unsigned)group;
    info->atomics64 = has_extension(id, "cl_khr_int64_base_atomics");
    info->exact_division = (floats & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
}

/* Appends the devices of one platform. A platform without devices, or whose driver fails, counts as empty,
 * because another may serve. */
static cml_status append_platform(cl_platform_id platform, struct cml_opencl_device **list, int *count,
                                  struct cml_error *err)
{
    cl_uint found = 0;
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, NULL, &found) != CL_SUCCESS || found == 0)
        return CML_OK;
    CML_FREED cl_device_id *ids = calloc(found, sizeof *ids);
    struct cml_opencl_device *longer = realloc(*list, ((size_t)*count + found) * sizeof *longer);
    if (longer) *list = longer;
    if (!ids || !longer) return cml_fail_memory(err, (double)(found * sizeof *longer), "the list of devices");
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, found, ids, NULL) != CL_SUCCESS) found = 0;
    for (cl_uint i = 0; i < found; i++, (*count)++) {
        longer[*count] = (struct cml_opencl_device){.number = *count, .id = ids[i]};
        describe(platform, ids[i], &longer[*count].info);
    }
    return CML_OK;
}

/* Finds all devices with their handles; the caller frees *list, also after a failure. Devices are numbered
 * across platforms, in the order in which drivers name them: these are the numbers of --device. Without a
 * driver the loader reports an error, which counts as an empty list. */
static cml_status find_devices(struct cml_opencl_device **list, int *count, struct cml_error *err)
{
    cl_platform_id platforms[MOST_PLATFORMS];
    cl_uint found = 0;
    *list = NULL;
    *count = 0;
    if (clGetPlatformIDs(MOST_PLATFORMS, platforms, &found) != CL_SUCCESS) return CML_OK;
    for (cl_uint i = 0; i < found && i < MOST_PLATFORMS; i++)
        CML_TRY(append_platform(platforms[i], list, count, err));
    return CML_OK;
}

cml_status cml_opencl_list(struct cml_opencl_info **list, int *count, struct cml_error *err)
{
    CML_FREED struct cml_opencl_device *devices = NULL;
    *list = NULL;
    CML_TRY(find_devices(&devices, count, err));
    *list = calloc((size_t)*count + 1, sizeof **list);
    for (int i = 0; *list && i < *count; i++) (*list)[i] = devices[i].info;
    return *list ? CML_OK : cml_fail_memory(err, *count * (double)sizeof **list, "the list of devices");
}

const char *cml_opencl_build(void)
{
    return "OpenCL 1.2";
}

/* A CPU that is also a device is left to ranks of machines without a GPU. */
int cml_opencl_default(const struct cml_opencl_info *list, int count, int local_rank)
{
    int gpus = 0;
    for (int i = 0; i < count; i++) gpus += strcmp(list[i].type, "GPU") == 0;
    int wanted = local_rank % (gpus ? gpus : count);
    for (int i = 0; i < count; i++)
        if ((!gpus || strcmp(list[i].type, "GPU") == 0) && wanted-- == 0) return i;
    return 0;
}

/* Reads the next number of a list like "0,2,5" and moves *cursor behind the number and the comma. Returns
 * false for anything else, also for a comma at the end of the list. */
static bool next_number(const char **cursor, int *number)
{
    char word[16];
    const size_t length = strcspn(*cursor, ",");
    if (length == 0 || length >= sizeof word || !((*cursor)[0] >= '0' && (*cursor)[0] <= '9')) return false;
    memcpy(word, *cursor, length);
    word[length] = '\0';
    *cursor += length;
    if (**cursor == ',' && *++*cursor == '\0') return false; /* a comma, and nothing behind it */
    return cml_parse_int(word, number);
}

/* Reads the value of --device, like "0,2", into numbers[most]; *count becomes how many. Refuses numbers of
 * devices that do not exist (`devices`: how many there are). */
static cml_status parse_selection(const char *wanted, int devices, int *numbers, int most, int *count,
                                  struct cml_error *err)
{
    const char *cursor = wanted;
    *count = 0;
    do {
        int number = 0;
        if (*count == most || !next_number(&cursor, &number))
            return cml_fail(err, CML_E_INPUT, "--device %s (expected a number, several like 0,1, or all)",
                            wanted);
        if (number >= devices)
            return cml_fail(err, CML_E_DEVICE, "no OpenCL device %d: there %s %d (see clustermcml devices)",
                            number, devices == 1 ? "is" : "are", devices);
        numbers[(*count)++] = number;
    } while (*cursor);
    return CML_OK;
}

/* Returns the number of the device for a run without --device, as cml_opencl_default does; the first one if
 * memory is short. local_rank: number of this rank among those of the machine. */
static int choose_default(const struct cml_opencl_device *all, int count, int local_rank)
{
    CML_FREED struct cml_opencl_info *infos = calloc((size_t)count, sizeof *infos);
    for (int i = 0; infos && i < count; i++) infos[i] = all[i].info;
    return infos ? cml_opencl_default(infos, count, local_rank) : 0;
}

/* At most 64 devices are selected, the size of the engine's list of started devices. */
cml_status cml_opencl_select(const char *wanted, int local_rank, struct cml_opencl_device **list, int *count,
                             struct cml_error *err)
{
    enum { most = 64 };
    CML_FREED struct cml_opencl_device *all = NULL;
    int numbers[most], devices;
    *list = NULL;
    CML_TRY(find_devices(&all, &devices, err));
    if (devices < 1)
        return cml_fail(err, CML_E_DEVICE, "there is no OpenCL device (see clustermcml devices)");
    *count = 1;
    if (!wanted) {
        numbers[0] = choose_default(all, devices, local_rank);
    } else if (strcmp(wanted, "all") == 0) {
        *count = devices < most ? devices : most;
        for (int i = 0; i < *count; i++) numbers[i] = i;
    } else {
        CML_TRY(parse_selection(wanted, devices, numbers, most, count, err));
    }
    *list = calloc((size_t)*count, sizeof **list);
    if (!*list) return cml_fail_memory(err, 1, "the list of devices");
    for (int i = 0; i < *count; i++) (*list)[i] = all[numbers[i]];
    return CML_OK;
}
