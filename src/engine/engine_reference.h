/* The engine `reference`: double, one packet at a time, one thread. The oracle for the others.
 * SPDX-License-Identifier: MIT */
#ifndef CML_ENGINE_REFERENCE_H
#define CML_ENGINE_REFERENCE_H

#include "engine/engine.h"

extern const struct cml_engine cml_engine_reference;

#endif
