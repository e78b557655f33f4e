/* A preloaded library that imitates a failing OpenCL device. CML_FAULT="FUNCTION N CODE" makes the N-th call
 * of FUNCTION, and all later ones, return CODE without being made. CML_DEVICE_BYTES is the memory that the
 * device reports.
 * SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Returns the code that this call of the named function must return, or CL_SUCCESS. */
static cl_int fault(const char *name)
{
    static int calls;
    char function[64];
    int first, code;
    const char *text = getenv("CML_FAULT");
    if (!text || sscanf(text, "%63s %d %d", function, &first, &code) != 3) return CL_SUCCESS;
    if (strcmp(function, name) != 0) return CL_SUCCESS;
    return ++calls >= first ? code : CL_SUCCESS;
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

cl_int clGetPlatformIDs(cl_uint entries, cl_platform_id *platforms, cl_uint *count)
{
    const cl_int code = fault("clGetPlatformIDs");
    return code ? code : REAL(clGetPlatformIDs)(entries, platforms, count);
}

cl_int clGetDeviceInfo(cl_device_id device, cl_device_info what, size_t size, void *value, size_t *needed)
{
    const cl_int code = REAL(clGetDeviceInfo)(device, what, size, value, needed);
    const char *bytes = getenv("CML_DEVICE_BYTES");
    const int memory = what == CL_DEVICE_GLOBAL_MEM_SIZE || what == CL_DEVICE_MAX_MEM_ALLOC_SIZE;
    if (bytes && memory && value) *(cl_ulong *)value = strtoull(bytes, NULL, 10);
    return code;
}

cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t size, void *host, cl_int *code)
{
    *code = fault("clCreateBuffer");
    return *code ? NULL : REAL(clCreateBuffer)(context, flags, size, host, code);
}

cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions,
                              const size_t *offset, const size_t *global, const size_t *local, cl_uint waits,
                              const cl_event *wait, cl_event *event)
{
    const cl_int code = fault("clEnqueueNDRangeKernel");
    return code ? code
                : REAL(clEnqueueNDRangeKernel)(queue, kernel, dimensions, offset, global, local, waits, wait,
                                               event);
}

cl_int clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset,
                           size_t size, void *to, cl_uint waits, const cl_event *wait, cl_event *event)
{
    const cl_int code = fault("clEnqueueReadBuffer");
    return code ? code
                : REAL(clEnqueueReadBuffer)(queue, buffer, blocking, offset, size, to, waits, wait, event);
}
