/* SPDX-License-Identifier: MIT */
#include "plot/section.h"

#include "plot/plot_parts.h"

#include <math.h>
#include <string.h>

/* Points of the SVG; letters are 13 high. */
enum { HEIGHT = 560, LEFT = 104, RIGHT = 710, TOP = 44, BOTTOM = 78, LINE = 18 };

/* Shares of the frame's height: the room for beam and map above the highest surface, and that below the
 * lowest; where in the upper room the map's bar, its text and the beam's tail are, and how far above it the
 * beam's text. */
static const double room_above = 0.30, room_below = 0.10;
static const double map_bar = 0.965, map_text = 0.925, beam_tail = 0.835, beam_text_above = 0.03;

static const char *const colours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00"};
enum { COLOURS = sizeof colours / sizeof *colours };

/* Points of the picture that a text takes. */
struct box {
    double left, right, low, high;
};
enum { MOST_BOXES = 256 };

struct frame {
    const struct cml_section *section;
    struct cml_page page;
    int low;                    /* points: the frame's lower edge */
    int num_texts;              /* written */
    struct box box[MOST_BOXES]; /* of the first of them, and of beams that start inside */
    int num_boxes;
    double z0, z1; /* depths at the frame's upper and lower edge */
};

/* The depth at this share of the frame's height, from below. */
static double depth_at(const struct frame *f, double share)
{
    return f->z1 + share * (f->z0 - f->z1);
}

static double frame_points(const struct frame *f)
{
    return f->page.height - TOP - f->low;
}

static double page_x(const struct frame *f, double x)
{
    return LEFT + (x - f->section->x_low) / (f->section->x_high - f->section->x_low) * (RIGHT - LEFT);
}

static double page_y(const struct frame *f, double z)
{
    return f->low + (f->z1 - z) / (f->z1 - f->z0) * frame_points(f);
}

/* How many times longer a length in z is drawn than the same in x. */
static double stretch_of(const struct frame *f)
{
    const struct cml_section *s = f->section;
    return frame_points(f) / (f->z1 - f->z0) * (s->x_high - s->x_low) / (RIGHT - LEFT);
}

/* Letters are 0.6 of their size wide at most, in the mean. */
static struct box box_of(double x, double y, enum cml_align align, int size, const char *text)
{
    const double width = 0.6 * size * (double)strlen(text), left = align == CML_ALIGN_LEFT    ? x
                                                                   : align == CML_ALIGN_RIGHT ? x - width
                                                                                              : x - width / 2;
    return (struct box){left, left + width, y - 0.6 * size, y + 0.6 * size};
}

static void take_room(struct frame *f, struct box box)
{
    if (f->num_boxes < MOST_BOXES) f->box[f->num_boxes++] = box;
}

/* Where not all boxes are known nothing is. */
static bool is_free(const struct frame *f, const struct box *box)
{
    for (int i = 0; i < f->num_boxes; i++) {
        const struct box *other = &f->box[i];
        if (box->left < other->right && other->left < box->right && box->low < other->high &&
            other->low < box->high)
            return false;
    }
    return f->num_boxes < MOST_BOXES;
}

/* Labels have numbers in gnuplot: ours from 1 on, those of the caption above all of them. */
static void write_text(struct frame *f, double x, double y, enum cml_align align, int size, const char *text)
{
    take_room(f, box_of(x, y, align, size, text));
    cml_page_write(&f->page, ++f->num_texts, x, y, align, size, text);
}

static void write_frame(struct frame *f)
{
    const struct cml_section *s = f->section;
    const double top = f->page.height - TOP;
    cml_page_begin(&f->page);
    cml_page_panel(&f->page, LEFT, RIGHT, f->low, top);
    fprintf(f->page.out,
            "unset key\nset xrange [%.9g:%.9g]\nset yrange [%.9g:%.9g]\nset xtics %.9g\nset ytics %.9g\n",
            s->x_low, s->x_high, f->z1, f->z0, cml_plot_round_step((s->x_high - s->x_low) / 6),
            cml_plot_round_step((f->z1 - f->z0) / 7));
    write_text(f, (LEFT + RIGHT) / 2.0, top + 24, CML_ALIGN_CENTER, CML_PAGE_LARGE, s->title);
    write_text(f, (LEFT + RIGHT) / 2.0, f->low - 46, CML_ALIGN_CENTER, CML_PAGE_NORMAL, "x [cm]");
    write_text(f, 22, (f->low + top) / 2, CML_ALIGN_UPRIGHT, CML_PAGE_NORMAL, "depth z [cm]");
}

/* Centred at x, or beside the edge that it would pass. */
static void write_text_over(struct frame *f, const char *text, double x, double share)
{
    const struct cml_section *s = f->section;
    const double place = (x - s->x_low) / (s->x_high - s->x_low), width = RIGHT - LEFT;
    const double at = place < 0.25 ? LEFT + 8 : place > 0.75 ? RIGHT - 8 : LEFT + place * width;
    write_text(f, at, f->low + share * frame_points(f),
               place < 0.25   ? CML_ALIGN_LEFT
               : place > 0.75 ? CML_ALIGN_RIGHT
                              : CML_ALIGN_CENTER,
               CML_PAGE_SMALL, text);
}

static void write_map(struct frame *f)
{
    const struct cml_section *s = f->section;
    if (!(s->map_high > s->map_low)) return;
    fprintf(f->page.out,
            "set arrow from first %.9g,graph %.6f to first %.9g,graph %.6f heads size graph 0.012,90 lw 1.6 "
            "lc rgb '#404040'\n",
            s->map_low, map_bar, s->map_high, map_bar);
    write_text_over(f, s->map_text, 0.5 * (s->map_low + s->map_high), map_text);
}

static void write_arrow(struct frame *f, double x0, double z0, double x1, double z1, bool head)
{
    fprintf(f->page.out,
            "set arrow from first %.9g,first %.9g to first %.9g,first %.9g %s lc rgb '#C00000'\n", x0, z0, x1,
            z1, head ? "head filled size screen 0.012,18 lw 2" : "nohead lw 1 dt 2");
}

/* From its tail down to z = 0, or a little below the frame's upper edge where that lies above. A slanted one
 * begins lower, so that it stays in the picture. row: of its text, from
 * below. */
static void write_beam_above(struct frame *f, const struct cml_section_beam *beam, int row)
{
    const struct cml_section *s = f->section;
    const double end = fmax(0, depth_at(f, beam_tail - 0.06));
    double tail = depth_at(f, beam_tail);
    const double width = s->x_high - s->x_low;
    const double room = beam->slope > 0 ? beam->x - s->x_low : s->x_high - beam->x;
    const double most = fmax(0.02 * width, fmin(0.3 * width, room - beam->half_width));
    if (fabs(beam->slope) * (end - tail) > most) tail = end - most / fabs(beam->slope);
    for (int side = -1; side <= 1; side++) {
        const double x = beam->x + side * beam->half_width, turned = atan(beam->slope) + side * beam->spread;
        if (side == 0 || beam->half_width > 0)
            write_arrow(f, x + beam->slope * tail, tail, x + beam->slope * end, end, side == 0);
        if (side == 0 || beam->spread == 0) continue;
        const double rise = fmin(end - tail, 0.2 * width / fmax(fabs(tan(turned)), 1e-9));
        const double rim =
            beam->x - side * beam->half_width + beam->slope * end; /* the outermost ray to it */
        write_arrow(f, rim - rise * tan(turned), end - rise, rim, end, false);
    }
    write_text_over(f, beam->text, beam->x + beam->slope * tail,
                    (f->z1 - tail) / (f->z1 - f->z0) + beam_text_above + 0.035 * row);
}

/* Lengths of arrows are those of the picture, not of the scene. */
static void write_ray(struct frame *f, const struct cml_section_beam *beam, double angle, double share,
                      bool head)
{
    const double x = sin(angle) / (f->section->x_high - f->section->x_low), z = cos(angle) / (f->z1 - f->z0),
                 length = share / hypot(x, z);
    write_arrow(f, beam->x, beam->z, beam->x + length * sin(angle), beam->z + length * cos(angle), head);
}

static void write_beam_inside(struct frame *f, const struct cml_section_beam *beam)
{
    const double angle = atan2(beam->axis[0], beam->axis[1]), turn = acos(-1.0) / 4;
    const bool all = beam->spread > 3;
    const double x = page_x(f, beam->x), y = page_y(f, beam->z), arrow = 0.06 * frame_points(f);
    take_room(f, (struct box){x - arrow, x + arrow, y - arrow, y + arrow});
    write_arrow(f, beam->x - beam->side[0], beam->z - beam->side[1], beam->x + beam->side[0],
                beam->z + beam->side[1], false);
    for (int k = 0; k < (all ? 8 : 1); k++) {
        const double across = sin(k * turn) * (f->section->x_high - f->section->x_low),
                     down = cos(k * turn) * (f->z1 - f->z0);
        write_ray(f, beam, all ? atan2(across, down) : angle, all ? 0.06 : 0.1, true);
    }
    for (int side = -1; side <= 1 && !all && beam->spread > 0; side += 2)
        write_ray(f, beam, angle + side * beam->spread, 0.1, false);
    const double above = !all && beam->axis[1] < 0 ? 0.13 : 0.08; /* of an arrow that points up, its tip */
    write_text_over(f, beam->text, beam->x, (f->z1 - beam->z) / (f->z1 - f->z0) + above);
}

static void write_beams(struct frame *f)
{
    const struct cml_section *s = f->section;
    for (int k = 0, above = 0; k < s->num_beams; k++) {
        if (s->beam[k].inside)
            write_beam_inside(f, &s->beam[k]);
        else
            write_beam_above(f, &s->beam[k], above++);
    }
}

/* ---- the labels at the right ---- */

/* Points from the picture's upper edge to the middle of what is seen of it; negative where nothing is. */
static double middle_of(const struct frame *f, const struct cml_section_label *label)
{
    const double top = fmax(label->z_top, f->z0), bottom = fmin(label->z_bottom, f->z1);
    if (!(bottom >= top)) return -1;
    return TOP + ((top + bottom) / 2 - f->z0) / (f->z1 - f->z0) * frame_points(f);
}

/* Puts labels at least a line apart, as near to their wanted places as that allows, within the frame: pushed
 * down from above, and what then is too low pushed up again. */
static void spread(const struct frame *f, double *place, int count)
{
    for (int i = 1; i < count; i++) place[i] = fmax(place[i], place[i - 1] + LINE);
    double most = f->page.height - f->low - LINE / 2;
    for (int i = count - 1; i >= 0; i--, most -= LINE) place[i] = fmin(place[i], most);
}

static void write_labels(struct frame *f)
{
    const struct cml_section *s = f->section;
    const int step = (s->num_labels + CML_SECTION_LABELS - 1) / CML_SECTION_LABELS;
    double middle[CML_SECTION_LABELS], place[CML_SECTION_LABELS];
    int which[CML_SECTION_LABELS], count = 0;
    for (int i = 0; i < s->num_labels; i += step) {
        const double wanted = middle_of(f, &s->labels[i]);
        if (wanted < 0) continue;
        which[count] = i;
        middle[count] = place[count] = wanted;
        count++;
    }
    spread(f, place, count);
    for (int i = 0; i < count; i++) {
        const double y = f->page.height - place[i];
        fprintf(f->page.out,
                "set arrow from screen %.6f,%.6f to screen %.6f,%.6f nohead lw 0.8 lc rgb '#A0A0A0'\n",
                (RIGHT + 2.0) / CML_PAGE_WIDTH, 1 - middle[i] / f->page.height,
                (RIGHT + 16.0) / CML_PAGE_WIDTH, y / f->page.height);
        write_text(f, RIGHT + 20, y, CML_ALIGN_LEFT, CML_PAGE_SMALL, s->labels[which[i]].text);
    }
}

/* ---- bodies ---- */

/* Where there is room and neither text nor body: in the middle, below or above it, where another body may lie
 * inside, beside the body, below or above it. */
static void write_body(struct frame *f, const struct cml_section_body *body)
{
    const double left = page_x(f, body->x_low), right = page_x(f, body->x_high), top = page_y(f, body->z_top),
                 bottom = page_y(f, body->z_bottom), width = right - left, height = top - bottom,
                 x = (left + right) / 2, y = (top + bottom) / 2;
    const struct {
        bool inside;
        enum cml_align align;
        double x, y;
    } places[] = {{true, CML_ALIGN_CENTER, x, y},
                  {true, CML_ALIGN_CENTER, x, bottom + 0.2 * height},
                  {true, CML_ALIGN_CENTER, x, top - 0.2 * height},
                  {false, CML_ALIGN_LEFT, right + 6, y},
                  {false, CML_ALIGN_RIGHT, left - 6, y},
                  {false, CML_ALIGN_CENTER, x, bottom - CML_PAGE_SMALL},
                  {false, CML_ALIGN_CENTER, x, top + CML_PAGE_SMALL}};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        const struct box box = box_of(places[i].x, places[i].y, places[i].align, CML_PAGE_SMALL, body->text);
        const bool fits = places[i].inside
                              ? box.right - box.left < 0.95 * width && height > 2 * CML_PAGE_SMALL
                              : box.left > LEFT && box.right < RIGHT;
        if (!fits || !is_free(f, &box)) continue;
        write_text(f, places[i].x, places[i].y, places[i].align, CML_PAGE_SMALL, body->text);
        break;
    }
    take_room(
        f, (struct box){left + 0.1 * width, right - 0.1 * width, bottom + 0.1 * height, top - 0.1 * height});
}

/* ---- the boundaries ---- */

/* A name for each colour, as gnuplot looks for a name among all, and the data of all lines that have it; an
 * empty line behind every piece parts it from the next. */
static void write_lines(const struct frame *f)
{
    const struct cml_section *s = f->section;
    FILE *out = f->page.out;
    for (int c = 0; c < COLOURS && c < s->num_lines; c++) {
        fprintf(out, "$b%d << EOD\n", c);
        for (int b = c; b < s->num_lines; b += COLOURS)
            for (size_t i = 0; i < s->lines[b].count; i++) {
                const double *piece = s->lines[b].piece[i];
                fprintf(out, "%.9g %.9g\n%.9g %.9g\n\n", piece[0], piece[1], piece[2], piece[3]);
            }
        fputs("EOD\n", out);
    }
    for (int c = 0; c < COLOURS && c < s->num_lines; c++)
        fprintf(out, "%s$b%d with lines lw 2 lc rgb '%s'", c == 0 ? "plot " : ", ", c, colours[c]);
    fputc('\n', out);
}

cml_status cml_section_script(FILE *out, const void *what, struct cml_error *err)
{
    (void)err;
    const struct cml_section *s = what;
    struct frame f = {.section = s, .page = {out, s->picture, CML_PAGE_WIDTH, HEIGHT}};
    char caption[1024];
    const double span = (s->z_bottom - s->z_top) / (1 - room_above - room_below);
    f.z0 = s->z_top - room_above * span;
    f.z1 = s->z_bottom + room_below * span;
    f.low = BOTTOM;
    snprintf(caption, sizeof caption, "%s Depths are drawn %.3g times as long as widths.",
             s->caption ? s->caption : "", stretch_of(&f));
    const int lines = cml_plot_caption(NULL, caption, 0);
    f.page.height += lines;
    f.low += lines;
    write_frame(&f);
    cml_plot_caption(&f.page, caption, lines);
    write_map(&f);
    write_beams(&f);
    write_labels(&f);
    /* the last first: a body in another stands behind it in most files */
    for (int k = s->num_bodies - 1; k >= 0; k--) write_body(&f, &s->body[k]);
    write_lines(&f);
    return CML_OK;
}
