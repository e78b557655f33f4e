/* SPDX-License-Identifier: MIT */
#include "flights/progress.h"

#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

/* Columns of a terminal of unknown width, and limits of the bar's length. */
enum { USUAL_WIDTH = 80, SHORTEST_BAR = 4, LONGEST_BAR = 60 };

/* Writes a time in the unit that gives two or three digits. */
static void write_time(double seconds, char text[16])
{
    if (seconds < 120)
        snprintf(text, 16, "%.0f s", seconds);
    else if (seconds < 7200)
        snprintf(text, 16, "%.0f min", seconds / 60);
    else if (seconds < 172800)
        snprintf(text, 16, "%.1f h", seconds / 3600);
    else
        snprintf(text, 16, "%.3g d", seconds / 86400);
}

static double seconds_left(const struct cml_progress *p)
{
    return p->seconds * (double)(p->total - p->done) / (double)p->done;
}

/* Returns the number of letters in a line of the terminal; a usual number if it is not known. */
static int terminal_width(void)
{
    struct winsize size;
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : USUAL_WIDTH;
}

/* Draws the progress bar over the last one, and clears it at the end, because results follow. One column
 * stays free, since some terminals go to the next line behind the last. If the line is too long, the bar is
 * left out first, then the speed. */
static void draw_bar(const struct cml_progress *p)
{
    char elapsed[16], left[16], text[96], bar[LONGEST_BAR + 4] = "";
    const double share = (double)p->done / (double)p->total;
    const int width = terminal_width() - 1;
    write_time(p->seconds, elapsed);
    write_time(seconds_left(p), left);
    snprintf(text, sizeof text, "%3.0f %%  %.3g photons/s  %s, %s left", 100 * share,
             (double)p->done / p->seconds, elapsed, left);
    if ((int)strlen(text) > width) snprintf(text, sizeof text, "%3.0f %%  %s left", 100 * share, left);
    int length = width - (int)strlen(text) - (int)strlen("[] ");
    if (length > LONGEST_BAR) length = LONGEST_BAR;
    const int full = (int)(share * length);
    for (int i = 0; length >= SHORTEST_BAR && i < length; i++) bar[1 + i] = i < full ? '#' : '.';
    if (length >= SHORTEST_BAR) {
        bar[0] = '[';
        strcpy(bar + 1 + length, "] ");
    }
    fprintf(stderr, "\r%s%.*s\033[K", bar, width > 0 ? width : 0, text);
    if (p->done == p->total) fprintf(stderr, "\r\033[K");
    fflush(stderr);
}

/* Shows the progress: a bar on a terminal, otherwise a line whenever another tenth is flown. There is no line
 * in the first ten seconds, so the log of a short run stays empty. */
void cml_progress_show(void *context, const struct cml_progress *p)
{
    struct cml_display *display = context;
    if (display->quiet || p->done == 0) return;
    if (display->terminal) {
        draw_bar(p);
        display->drawn = p->done < p->total;
        return;
    }
    char elapsed[16], left[16];
    const int tenths = (int)(10 * p->done / p->total);
    if (tenths <= display->tenths || p->seconds < 10) return;
    display->tenths = tenths;
    write_time(p->seconds, elapsed);
    write_time(seconds_left(p), left);
    fprintf(stderr, "%d %%, %s elapsed, %s left\n", 10 * tenths, elapsed, left);
}

void cml_progress_end(struct cml_display *display)
{
    if (display->drawn) fprintf(stderr, "\r\033[K");
    display->drawn = false;
}
