/* The picture of a section through a scene: boundaries, layers with their names, the beam, the width of the
 * map. It is told lines and texts, and knows no scene. SPDX-License-Identifier: MIT */
#pragma once

#include "plot/gnuplot.h"

#include <stdbool.h>
#include <stddef.h>

/* One boundary: straight pieces, x, z of one end, x, z of the other. */
struct cml_section_line {
    size_t count;
    const double (*piece)[4]; /* [count] cm, z down */
};

/* What is written at the right, with a line to the middle of the part of z_top..z_bottom that is in the
 * picture; nothing where no part is. */
struct cml_section_label {
    double z_top, z_bottom; /* cm; may be infinite */
    char text[64];
};

/* A body's part of the section, and what is written into or beside it where no other text is. */
struct cml_section_body {
    double x_low, x_high, z_top, z_bottom; /* cm */
    char text[48];
};

/* A beam of no width has one line, others have one at either side, too; light that spreads has rays at
 * its sides. One that starts inside has an arrow from its middle, or arrows to all sides. */
struct cml_section_beam {
    double x;          /* cm: where its axis meets z = 0, or its middle */
    double slope;      /* dx / dz */
    double half_width; /* cm, along x; 0: none */
    double spread;     /* rad: between the axis and the rays at its sides */
    bool inside;
    double z; /* cm: of the middle, of one inside */
    double axis[2],
        side[2]; /* of one inside: x and z of its direction, and from the middle to its edge, cm */
    char text[160];
};

struct cml_section {
    double x_low, x_high;      /* cm: the width of the picture */
    double z_top, z_bottom;    /* cm: depths that must be in it, z_top < z_bottom; there is more room above */
    int num_lines, num_labels; /* from above */
    const struct cml_section_line *lines;
    const struct cml_section_label *labels;
    int num_bodies; /* with texts */
    const struct cml_section_body *body;
    int num_beams;
    const struct cml_section_beam *beam; /* [num_beams] */
    double map_low, map_high;            /* cm: its ends along x; equal: no map */
    char map_text[128];
    const char *title, *caption; /* caption NULL: none */
    enum cml_picture picture;
};

/* How many labels have room; more are never drawn, but every second, third, ... one. */
#define CML_SECTION_LABELS 20

/* How many bodies may have texts. */
#define CML_SECTION_BODIES 100

/* For cml_gnuplot_draw: writes the script that draws the const struct cml_section `what`. */
CML_NODISCARD cml_status cml_section_script(FILE *out, const void *what, struct cml_error *err);
