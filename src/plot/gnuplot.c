/* SPDX-License-Identifier: MIT */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* memfd_create */
#endif
#include "plot/gnuplot.h"

#include "base/atomic_file.h"

#include <errno.h>
#include <spawn.h>
#include <string.h>
#include <strings.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

/* ---- the script ---- */

/* How gnuplot makes each format. Cairo's letters are measured in points of 1/72 inch, SVG's in its units: a
 * PNG of two pixels per point has 96 pixels per inch, and a page of 900 points is 7 inches wide. */
static const struct terminal {
    const char *ending, *name, *unit, *options;
    double length, letters; /* of a point of the page */
} terminals[] = {
    [CML_PICTURE_SVG] = {".svg", "svg", "", "", 1, 1},
    [CML_PICTURE_PNG] = {".png", "pngcairo", "", " fontscale 2 linewidth 2 pointscale 2", 2, 11.0 / 15},
    [CML_PICTURE_PDF] = {".pdf", "pdfcairo", "in", " fontscale 1 linewidth 0.56 pointscale 0.56", 7.0 / 900,
                         0.56},
    [CML_PICTURE_EPS] = {".eps", "epscairo", "in", " fontscale 1 linewidth 0.56 pointscale 0.56", 7.0 / 900,
                         0.56},
};
enum { NUM_TERMINALS = sizeof terminals / sizeof *terminals };

/* Judged before anything is read or computed. The dot must be in the name itself, not in a folder. */
cml_status cml_picture_of(const char *path, enum cml_picture *picture, struct cml_error *err)
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
    for (int i = 0; dot && i < NUM_TERMINALS; i++)
        if (strcasecmp(dot, terminals[i].ending) == 0) {
            *picture = (enum cml_picture)i;
            return CML_OK;
        }
    return cml_fail(err, CML_E_INPUT, "--output %s (expected a name that ends in .svg, .png, .pdf or .eps)",
                    path);
}

/* `noenhanced`, because names of files have underscores, which gnuplot would take for subscripts. */
void cml_page_begin(const struct cml_page *page)
{
    const struct terminal *t = &terminals[page->picture];
    fprintf(page->out,
            "set encoding utf8\nset terminal %s noenhanced size %g%s,%g%s font 'Helvetica,%g' background "
            "'#FFFFFF'%s\n",
            t->name, t->length * page->width, t->unit, t->length * page->height, t->unit,
            t->letters * CML_PAGE_NORMAL, t->options);
    fputs("set border 15 lw 0.8 lc rgb '#404040'\nset tics textcolor rgb '#202020'\n"
          "set grid xtics ytics lc rgb '#E4E4E4' lt 1 lw 0.6\n",
          page->out);
}

void cml_page_panel(const struct cml_page *page, double left, double right, double bottom, double top)
{
    fprintf(page->out, "set lmargin at screen %.6f\nset rmargin at screen %.6f\n", left / page->width,
            right / page->width);
    fprintf(page->out, "set bmargin at screen %.6f\nset tmargin at screen %.6f\n", bottom / page->height,
            top / page->height);
}

/* Writes a text at a place of the page; small letters are grey. */
void cml_page_write(const struct cml_page *page, int number, double x, double y, enum cml_align align,
                    int size, const char *text)
{
    static const char *const aligns[] = {"left", "center", "right", "center rotate"};
    fprintf(page->out, "set label %d ", number);
    cml_gnuplot_quote(page->out, text);
    fprintf(page->out, " at screen %.6f,%.6f %s font ',%g'%s\n", x / page->width, y / page->height,
            aligns[align], terminals[page->picture].letters * size,
            size == CML_PAGE_SMALL ? " textcolor rgb '#404040'" : "");
}

/* The code of a UTF-8 sequence of that length. */
static unsigned long code_of(const unsigned char *p, int length)
{
    unsigned long code = length == 1 ? p[0] : p[0] & (0x7Fu >> length);
    for (int i = 1; i < length; i++) code = code << 6 | (p[i] & 0x3F);
    return code;
}

/* Bytes of a UTF-8 sequence that begins at p; 0 when it is none, or of a character that XML does not have: a
 * control character, half a surrogate, one beyond the last. Too long a sequence is none. */
static int utf8_length(const unsigned char *p)
{
    const int length = p[0] < 0x80                   ? 1
                       : p[0] >= 0xC2 && p[0] < 0xE0 ? 2
                       : p[0] >= 0xE0 && p[0] < 0xF0 ? 3
                       : p[0] >= 0xF0 && p[0] < 0xF5 ? 4
                                                     : 0;
    for (int i = 1; i < length; i++)
        if ((p[i] & 0xC0) != 0x80) return 0;
    static const unsigned long least[] = {0, 0x20, 0x80, 0x800, 0x10000};
    const unsigned long code = length ? code_of(p, length) : 0;
    if (code < least[length] || code == 0x7F || (code >= 0xD800 && code < 0xE000)) return 0;
    return code == 0xFFFE || code == 0xFFFF || code > 0x10FFFF ? 0 : length;
}

/* Double quotes: in single ones gnuplot 5.4 misreads an apostrophe that comes first or twice. */
void cml_gnuplot_quote(FILE *out, const char *text)
{
    fputc('"', out);
    for (const unsigned char *p = (const unsigned char *)text; *p;) {
        const int length = utf8_length(p);
        if (*p == '"' || *p == '\\') fputc('\\', out);
        if (length == 0 || strncmp((const char *)p, "]]>", 3) == 0)
            fputc('?', out);
        else if (*p == '`')
            fputs("\\140", out);
        else
            fwrite(p, 1, (size_t)length, out);
        p += length == 0 ? 1 : length;
    }
    fputc('"', out);
}

/* ---- the process ---- */

/* What gnuplot reads and writes are files in memory, numbered as in the process: it starts only when the
 * script is complete, and of a disk that is full it would say nothing. */
enum { SCRIPT, PICTURE, MESSAGES, FILES };

/* Starts gnuplot without a shell, so nothing in a name can be an order. No settings of the user's, so that a
 * picture is the same everywhere. Returns an error number, 0 when it runs. */
static int spawn(const int files[FILES], pid_t *child)
{
    char *arguments[] = {"gnuplot", "--default-settings", "-", NULL};
    posix_spawn_file_actions_t actions;
    int failed = posix_spawn_file_actions_init(&actions);
    if (failed) return failed;
    for (int i = 0; !failed && i < FILES; i++)
        failed = posix_spawn_file_actions_adddup2(&actions, files[i], i);
    if (!failed) failed = posix_spawnp(child, "gnuplot", &actions, NULL, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    return failed;
}

/* Only the last line of what it said: the lines before repeat the script. */
static cml_status fail(int messages, struct cml_error *err)
{
    char said[4096];
    const off_t end = lseek(messages, 0, SEEK_END), begin = end - (off_t)sizeof said + 1;
    ssize_t size = pread(messages, said, sizeof said - 1, begin > 0 ? begin : 0);
    while (size > 0 && (said[size - 1] == '\n' || said[size - 1] == ' ')) size--;
    said[size > 0 ? size : 0] = '\0';
    const char *line = strrchr(said, '\n');
    return cml_fail(err, CML_E_IO, "gnuplot failed (%s)", line ? line + 1 : said);
}

static cml_status run_gnuplot(const int files[FILES], struct cml_error *err)
{
    pid_t child = 0;
    int state = 0;
    const int failed = spawn(files, &child);
    if (failed)
        return cml_fail(err, CML_E_IO, "gnuplot cannot be started (%s); is it installed?", strerror(failed));
    while (waitpid(child, &state, 0) < 0)
        if (errno != EINTR) return cml_fail(err, CML_E_IO, "gnuplot was lost (%s)", strerror(errno));
    return WIFEXITED(state) && WEXITSTATUS(state) == 0 ? CML_OK : fail(files[MESSAGES], err);
}

/* A failure of `write` counts before that of memory. */
static cml_status write_script(cml_status (*write)(FILE *, const void *, struct cml_error *),
                               const void *what, int script, struct cml_error *err)
{
    const int own = dup(script);
    FILE *out = own < 0 ? NULL : fdopen(own, "w");
    if (!out) return cml_fail_memory(err, 1, "the plot");
    cml_status status = write(out, what, err);
    const int failed = ferror(out);
    if ((fclose(out) != 0 || failed) && status == CML_OK)
        status = cml_fail_memory(err, (double)lseek(script, 0, SEEK_END), "the plot");
    lseek(script, 0, SEEK_SET);
    return status;
}

/* Gives a picture that gnuplot has drawn its name. */
static cml_status publish(int picture, const char *path, struct cml_error *err)
{
    char part[16384];
    struct cml_file file;
    CML_TRY(cml_file_create_alone(path, &file, err));
    for (off_t done = 0;;) {
        const ssize_t got = pread(picture, part, sizeof part, done);
        if (got <= 0) break;
        done += (off_t)fwrite(part, 1, (size_t)got, file.stream);
    }
    return cml_file_commit(&file, err);
}

cml_status cml_gnuplot_draw(cml_status (*write)(FILE *, const void *, struct cml_error *), const void *what,
                            const char *path, struct cml_error *err)
{
    int files[FILES];
    cml_status status = CML_OK;
    for (int i = 0; i < FILES; i++) {
        files[i] = memfd_create("plot", MFD_CLOEXEC);
        if (files[i] < 0) status = cml_fail(err, CML_E_IO, "no memory for a picture (%s)", strerror(errno));
    }
    if (status == CML_OK) status = write_script(write, what, files[SCRIPT], err);
    if (status == CML_OK) status = run_gnuplot(files, err);
    if (status == CML_OK) status = publish(files[PICTURE], path, err);
    for (int i = 0; i < FILES; i++)
        if (files[i] >= 0) close(files[i]);
    return status;
}
