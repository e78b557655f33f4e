/* SPDX-License-Identifier: MIT */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* memfd_create */
#endif
#include "plot/gnuplot.h"

#include "base/atomic_file.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
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

/* A script in memory: gnuplot starts only when it is complete, and data of any size go through the pipe. */
struct script {
    char *text;
    size_t size;
};

/* Closed on exec: gnuplot would otherwise hold the writing end of its own input, and never see it end. */
static bool open_pipe(int ends[2])
{
    if (pipe(ends) != 0) return false;
    return fcntl(ends[0], F_SETFD, FD_CLOEXEC) == 0 && fcntl(ends[1], F_SETFD, FD_CLOEXEC) == 0;
}

/* Starts gnuplot without a shell, so nothing in a name can be an order. No settings of the user's, so that a
 * picture is the same everywhere. Returns an error number, 0 when it runs. */
static int spawn(int in, int out, int messages, pid_t *child)
{
    char *arguments[] = {"gnuplot", "--default-settings", "-", NULL};
    posix_spawn_file_actions_t actions;
    int failed = posix_spawn_file_actions_init(&actions);
    if (failed) return failed;
    failed = posix_spawn_file_actions_adddup2(&actions, in, STDIN_FILENO);
    if (!failed) failed = posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
    if (!failed) failed = posix_spawn_file_actions_adddup2(&actions, messages, STDERR_FILENO);
    if (!failed) failed = posix_spawnp(child, "gnuplot", &actions, NULL, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    return failed;
}

/* gnuplot stops at its first error and then reads no further; the message says more than the broken pipe. */
static void feed(int in, const struct script *script)
{
    void (*handler)(int) = signal(SIGPIPE, SIG_IGN);
    for (size_t done = 0; done < script->size;) {
        const ssize_t wrote = write(in, script->text + done, script->size - done);
        if (wrote < 0 && errno == EINTR) continue;
        if (wrote <= 0) break;
        done += (size_t)wrote;
    }
    close(in);
    signal(SIGPIPE, handler);
}

/* Keeps the end of what gnuplot says: its last line is the error. */
static void listen(int messages, char *said, size_t size)
{
    char part[256];
    size_t used = 0;
    for (ssize_t got = 0; (got = read(messages, part, sizeof part)) != 0;) {
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) break;
        for (ssize_t i = 0; i < got; i++) {
            if (used + 1 >= size) used = 0;
            said[used++] = part[i];
        }
    }
    while (used > 0 && (said[used - 1] == '\n' || said[used - 1] == ' ')) used--;
    said[used] = '\0';
}

/* Only the last line of what it said: the lines before repeat the script. */
static cml_status wait_for(pid_t child, const char *said, struct cml_error *err)
{
    int state = 0;
    while (waitpid(child, &state, 0) < 0)
        if (errno != EINTR) return cml_fail(err, CML_E_IO, "gnuplot was lost (%s)", strerror(errno));
    if (WIFEXITED(state) && WEXITSTATUS(state) == 0) return CML_OK;
    const char *line = strrchr(said, '\n');
    return cml_fail(err, CML_E_IO, "gnuplot failed (%s)", line ? line + 1 : said);
}

/* The whole script first, then the messages: gnuplot says little before its first error, after which it
 * reads no further. The ends that belong to the child are closed here, or reading would never end. */
static cml_status converse(const struct script *script, int picture, int in[2], int messages[2],
                           struct cml_error *err)
{
    char said[4096];
    pid_t child = 0;
    const int failed = spawn(in[0], picture, messages[1], &child);
    close(in[0]);
    close(messages[1]);
    if (failed) {
        close(in[1]);
        close(messages[0]);
        return cml_fail(err, CML_E_IO, "gnuplot cannot be started (%s); is it installed?", strerror(failed));
    }
    feed(in[1], script);
    listen(messages[0], said, sizeof said);
    close(messages[0]);
    return wait_for(child, said, err);
}

/* The script and the messages pass through pipes, the picture into a file. */
static cml_status run_gnuplot(const struct script *script, int picture, struct cml_error *err)
{
    int in[2], messages[2];
    if (!open_pipe(in)) return cml_fail(err, CML_E_IO, "no pipe to gnuplot (%s)", strerror(errno));
    if (!open_pipe(messages)) {
        close(in[0]);
        close(in[1]);
        return cml_fail(err, CML_E_IO, "no pipe to gnuplot (%s)", strerror(errno));
    }
    return converse(script, picture, in, messages, err);
}

/* A failure of `write` counts before that of memory. */
static cml_status make_script(cml_status (*write)(FILE *, const void *, struct cml_error *), const void *what,
                              struct script *script, struct cml_error *err)
{
    FILE *out = open_memstream(&script->text, &script->size);
    if (!out) return cml_fail_memory(err, 1, "the plot");
    return cml_text_end(out, &script->size, write(out, what, err), "the plot", err);
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

/* gnuplot draws into memory: of a disk that is full it would say nothing. */
cml_status cml_gnuplot_draw(cml_status (*write)(FILE *, const void *, struct cml_error *), const void *what,
                            const char *path, struct cml_error *err)
{
    struct script script = {NULL, 0};
    const int picture = memfd_create("picture", MFD_CLOEXEC);
    if (picture < 0) return cml_fail(err, CML_E_IO, "no memory for a picture (%s)", strerror(errno));
    cml_status status = make_script(write, what, &script, err);
    if (status == CML_OK) status = run_gnuplot(&script, picture, err);
    if (status == CML_OK) status = publish(picture, path, err);
    close(picture);
    free(script.text);
    return status;
}
