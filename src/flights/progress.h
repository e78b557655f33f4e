/* Progress of a run on standard error: a bar that redraws itself on a terminal, else a line for every tenth.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "run/run.h"

/* State of the display of one run's progress. */
struct cml_display {
    bool quiet, terminal;
    int tenths; /* tenths printed so far */
    bool drawn; /* a bar is drawn, and the cursor stands behind it */
};

/* A cml_progress_function: shows the progress. context: the struct cml_display. */
void cml_progress_show(void *context, const struct cml_progress *progress);

/* Clears the bar of a run that has stopped, because messages follow. */
void cml_progress_end(struct cml_display *display);
