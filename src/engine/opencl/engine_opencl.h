/* The engine `opencl`: single precision, on OpenCL devices. It flies planes, radial heightfields, spheres and
 * cylinders.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/engine.h"

/* The engine. Its open fails with CML_E_DEVICE if there is no device or the program was built without OpenCL.
 * It fails with CML_E_INPUT for scenes that devices cannot fly or score: meshes, maps, volumes, facets, time,
 * directions, detectors, fluence, saved packets, and runs with --aim. */
extern const struct cml_engine cml_engine_opencl;
