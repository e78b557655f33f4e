/* Calls that must succeed, in a test of cmocka's.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* Fails the test with the error's text. */
static inline void require_ok(cml_status status, const struct cml_error *err)
{
    if (status != CML_OK) fail_msg("%s", err->text);
}
