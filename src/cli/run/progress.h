/* How far a run is, on standard error: a bar that redraws itself on a terminal, a line every tenth elsewhere.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "run/run.h"

/* How the progress of one run is shown. */
struct cml_display {
    bool quiet, terminal;
    int tenths; /* lines printed so far */
    bool drawn; /* the cursor is behind a bar */
};

/* A cml_progress_function; context: the display. */
void cml_progress_show(void *context, const struct cml_progress *progress);

/* Clears the bar of a run that stopped on its way: what is said of that follows. */
void cml_progress_end(struct cml_display *display);
