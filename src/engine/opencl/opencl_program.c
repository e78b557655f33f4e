/* Compiles the kernels for a device, or takes them from the cache.
 * SPDX-License-Identifier: MIT */
#include "engine/opencl/opencl_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Hands every line of the build log to on_note, and writes the first line that names an error into the
 * message. */
static cml_status fail_build(const struct cml_opencl_device *device, cl_program program, cl_int code,
                             cml_opencl_note *on_note, struct cml_error *err)
{
    size_t size = 0;
    CML_FREED char *log = NULL;
    if (clGetProgramBuildInfo(program, device->id, CL_PROGRAM_BUILD_LOG, 0, NULL, &size) == CL_SUCCESS)
        log = calloc(1, size + 1);
    if (!log ||
        clGetProgramBuildInfo(program, device->id, CL_PROGRAM_BUILD_LOG, size, log, NULL) != CL_SUCCESS ||
        log[0] == '\0')
        return cml_opencl_fail(device, "building the kernel", code, err);
    const char *first = NULL;
    char *rest = log;
    for (char *line = strtok_r(log, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
        if (on_note) on_note(NULL, line);
        if (!first && strstr(line, "error")) first = line;
    }
    return cml_fail(err, CML_E_DEVICE, "opencl device %d (%s): the kernel does not compile: %s",
                    device->number, device->info.name, first ? first : log);
}

/* Returns the key of a binary: everything that it depends on. The caller frees it. */
static char *key_of(const struct cml_opencl_device *device, const char *options)
{
    const struct cml_opencl_info *info = &device->info;
    const size_t size = cml_opencl_text_size + strlen(options) + sizeof *info;
    char *key = malloc(size);
    if (key)
        snprintf(key, size, "%s\n%s\n%s\n%s\n%s\n%s\n%s", info->platform, info->name, info->vendor,
                 info->version, info->driver, options, cml_opencl_text);
    return key;
}

/* Builds the program from a cached binary. Returns false if there is none, or the driver refuses it, for
 * instance after an update that left its version unchanged. */
static bool build_from_cache(const struct cml_opencl_device *device, cl_context context, const char *key,
                             const char *options, cml_opencl_note *on_note, cl_program *program)
{
    size_t size = 0;
    CML_FREED unsigned char *binary = cml_opencl_cache_load(key, on_note, &size);
    const unsigned char *binaries[] = {binary};
    cl_int sound = CL_SUCCESS, code = CL_SUCCESS;
    if (!binary) return false;
    *program = clCreateProgramWithBinary(context, 1, &device->id, &size, binaries, &sound, &code);
    if (code != CL_SUCCESS) return false;
    if (sound == CL_SUCCESS && clBuildProgram(*program, 1, &device->id, options, NULL, NULL) == CL_SUCCESS)
        return true;
    clReleaseProgram(*program);
    return false;
}

/* Stores the compiled program in the cache on the disk. A driver that gives no binary is no failure. */
static void keep(const char *key, cl_program program)
{
    size_t size = 0;
    if (clGetProgramInfo(program, CL_PROGRAM_BINARY_SIZES, sizeof size, &size, NULL) != CL_SUCCESS || !size)
        return;
    CML_FREED unsigned char *binary = malloc(size);
    if (binary && clGetProgramInfo(program, CL_PROGRAM_BINARIES, sizeof binary, &binary, NULL) == CL_SUCCESS)
        cml_opencl_cache_store(key, binary, size);
}

/* Compiles the kernel from its source text, which is a part of this program (opencl_text.cmake put it
 * together). */
static cml_status build_from_text(const struct cml_opencl_device *device, cl_context context,
                                  const char *options, cml_opencl_note *on_note, cl_program *program,
                                  struct cml_error *err)
{
    const char *text = cml_opencl_text;
    cl_int code = CL_SUCCESS;
    *program = clCreateProgramWithSource(context, 1, &text, &cml_opencl_text_size, &code);
    CML_CL(device, "the kernel's text", code, err);
    code = clBuildProgram(*program, 1, &device->id, options, NULL, NULL);
    if (code == CL_SUCCESS) return CML_OK;
    const cml_status status = fail_build(device, *program, code, on_note, err);
    clReleaseProgram(*program);
    *program = NULL;
    return status;
}

/* Without memory for the cache's key, the kernel is compiled and not stored. */
cml_status cml_opencl_program(const struct cml_opencl_device *device, cl_context context, const char *options,
                              cml_opencl_note *on_note, cl_program *program, struct cml_error *err)
{
    CML_FREED char *key = key_of(device, options);
    if (key && build_from_cache(device, context, key, options, on_note, program)) return CML_OK;
    CML_TRY(build_from_text(device, context, options, on_note, program, err));
    if (key) keep(key, *program);
    return CML_OK;
}
