/* The replacement of the opencl engine in a program that is built without OpenCL.
 * SPDX-License-Identifier: MIT */
#include "engine/opencl/engine_opencl.h"

#include "engine/opencl/opencl.h"

#include <stdlib.h>

/* Fails: a program without OpenCL has no such engine. Of the engine's other functions only threads and close
 * are ever called. */
static cml_status none_open(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                            const struct cml_engine_options *options, void **self, struct cml_error *err)
{
    (void)scene, (void)surfaces, (void)options;
    *self = NULL;
    return cml_fail(err, CML_E_DEVICE, "this clustermcml was built without OpenCL");
}

/* Stands for the number of threads of OpenCL in a program without OpenCL. */
static int none_threads(const void *self)
{
    (void)self;
    return 0;
}

/* Stands for the memory of OpenCL in a program without OpenCL. */
static double none_bytes(const struct cml_scene *scene, const struct cml_surface_set *surfaces)
{
    (void)scene, (void)surfaces;
    return 0;
}

static void none_close(void *self)
{
    (void)self;
}

const struct cml_engine cml_engine_opencl = {
    .name = "opencl",
    .open = none_open,
    .threads = none_threads,
    .bytes = none_bytes,
    .close = none_close,
};

cml_status cml_opencl_list(struct cml_opencl_info **list, int *count, struct cml_error *err)
{
    *count = 0;
    *list = calloc(1, sizeof **list);
    return *list ? CML_OK : cml_fail_memory(err, 1, "the list of devices");
}

const char *cml_opencl_build(void)
{
    return "none";
}

int cml_opencl_default(const struct cml_opencl_info *list, int count, int local_rank)
{
    (void)list, (void)count, (void)local_rank;
    return 0;
}
