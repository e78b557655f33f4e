/* The engine `reference`: double precision, one packet at a time, one thread. The other engines are tested
 * against it.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/engine.h"

extern const struct cml_engine cml_engine_reference;
