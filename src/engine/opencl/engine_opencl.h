/* The engine `opencl`: float, planes and heightfields on OpenCL devices.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/engine.h"

/* Without a device, or built without OpenCL, open fails with CML_E_DEVICE; with a mesh boundary, a map,
 * volume or facets with CML_E_INPUT. */
extern const struct cml_engine cml_engine_opencl;
