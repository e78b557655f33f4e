/* clustermcml plot: reads results and lets gnuplot draw them. Script on its standard input, picture from its
 * standard output, so that no name of a file is ever part of a command.
 * SPDX-License-Identifier: MIT */
#include "command.h"

#include "plot.h"
#include "text.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

struct script {
    char *text;
    size_t size;
};

static cml_status picture_format(const char *path, enum cml_plot_format *format, struct cml_error *err)
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
    *format = dot && strcasecmp(dot, ".png") == 0 ? CML_PLOT_PNG : CML_PLOT_SVG;
    if (dot && (*format == CML_PLOT_PNG || strcasecmp(dot, ".svg") == 0)) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "plot: --output %s (expected a name that ends in .svg or .png)", path);
}

static cml_status make_script(const struct cml_plot *plot, struct script *script, struct cml_error *err)
{
    FILE *out = open_memstream(&script->text, &script->size);
    if (!out) return cml_fail_memory(err, 1, "the plot");
    cml_status status = cml_plot_script(out, plot, err);
    const int failed = ferror(out);
    if ((fclose(out) != 0 || failed) && status == CML_OK)
        status = cml_fail_memory(err, (double)script->size, "the plot");
    return status;
}

/* ---- the process ---- */

static bool open_pipe(int ends[2])
{
    if (pipe(ends) != 0) return false;
    return fcntl(ends[0], F_SETFD, FD_CLOEXEC) == 0 && fcntl(ends[1], F_SETFD, FD_CLOEXEC) == 0;
}

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

static cml_status wait_for(pid_t child, const char *said, struct cml_error *err)
{
    int state = 0;
    while (waitpid(child, &state, 0) < 0)
        if (errno != EINTR) return cml_fail(err, CML_E_IO, "plot: gnuplot was lost (%s)", strerror(errno));
    if (WIFEXITED(state) && WEXITSTATUS(state) == 0) return CML_OK;
    const char *line = strrchr(said, '\n');
    return cml_fail(err, CML_E_IO, "plot: gnuplot failed (%s)", line ? line + 1 : said);
}

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
        return cml_fail(err, CML_E_IO, "plot: gnuplot cannot be started (%s); is it installed?",
                        strerror(failed));
    }
    feed(in[1], script);
    listen(messages[0], said, sizeof said);
    close(messages[0]);
    return wait_for(child, said, err);
}

static cml_status run_gnuplot(const struct script *script, FILE *picture, struct cml_error *err)
{
    int in[2], messages[2];
    if (!open_pipe(in)) return cml_fail(err, CML_E_IO, "plot: no pipe to gnuplot (%s)", strerror(errno));
    if (!open_pipe(messages)) {
        close(in[0]);
        close(in[1]);
        return cml_fail(err, CML_E_IO, "plot: no pipe to gnuplot (%s)", strerror(errno));
    }
    return converse(script, fileno(picture), in, messages, err);
}

/* ---- the command ---- */

static cml_status draw(const struct cml_plot *plot, const char *path, struct cml_error *err)
{
    struct script script = {NULL, 0};
    struct cml_file file;
    cml_status status = make_script(plot, &script, err);
    if (status == CML_OK) status = cml_file_create(path, &file, err);
    if (status == CML_OK) {
        status = run_gnuplot(&script, file.stream, err);
        if (status == CML_OK)
            status = cml_file_commit(&file, err);
        else
            cml_file_abort(&file);
    }
    free(script.text);
    return status;
}

static cml_status read_results(const struct cml_options *options, struct cml_mco *results, int *count,
                               struct cml_error *err)
{
    for (*count = 0; *count < options->num_operands; (*count)++) {
        struct cml_mco *mco = &results[*count];
        CML_TRY(cml_mco_read(options->operands[*count], mco, err));
        if (mco->nr >= 3) continue;
        const int nr = mco->nr;
        cml_mco_clear(mco);
        return cml_fail(err, CML_E_INPUT, "%s: nr = %d (expected 3 or more bins for a curve over r)",
                        options->operands[*count], nr);
    }
    return CML_OK;
}

cml_status cml_command_plot(const struct cml_options *options, struct cml_error *err)
{
    const char *path = options->output ? options->output : "plot.svg";
    struct cml_plot plot = {.names = (const char *const *)options->operands};
    CML_TRY(picture_format(path, &plot.format, err));
    struct cml_mco *results = calloc((size_t)options->num_operands, sizeof *results);
    if (!results) return cml_fail_memory(err, (double)sizeof *results * options->num_operands, "the results");
    cml_status status = read_results(options, results, &plot.count, err);
    plot.results = results;
    if (status == CML_OK) status = draw(&plot, path, err);
    if (status == CML_OK && !options->quiet) printf("%s\n", path);
    for (int i = 0; i < plot.count; i++) cml_mco_clear(&results[i]);
    free(results);
    return status;
}
