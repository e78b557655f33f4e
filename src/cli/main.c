/* Finds the command, runs it, prints its error, and turns its status into the exit code.
 * SPDX-License-Identifier: MIT */
#include "run/cluster/cluster.h"

#include "api/clustermcml.h"
#include "base/print_line.h"
#include "base/version.h"
#include "cli/command.h"
#include "cli/hand_over.h"
#include "cli/options/help.h"
#include "cli/options/options_parse.h"
#include "run/cluster/launcher.h"
#include "run/stop.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

cml_status cml_command_help(const struct cml_options *options, struct cml_error *err)
{
    return cml_help_print(stdout, options->num_operands > 0 ? options->operands[0] : NULL, err);
}

/* Rows of the table of commands; run NULL: a command of the Python package. */
#define ROW(NAME, name, parallel) {parallel, cml_command_##name},
#define PYTHON_ROW(NAME, name) {false, NULL},
static const struct {
    bool parallel;
    cml_status (*run)(const struct cml_options *options, struct cml_error *err);
} commands[CML_NUM_COMMANDS] = {CML_COMMANDS(ROW, PYTHON_ROW)};

/* True if all ranks do what the command line asks for. Rank 0 alone does all else, and needs no MPI. */
static bool is_parallel(const struct cml_options *options)
{
    return commands[options->which].parallel && !options->help && !options->version;
}

/* Runs the command of the command line, or prints help or version. */
static cml_status answer(const struct cml_options *options, struct cml_error *err)
{
    const char *name = cml_commands[options->which].name, *topic = options->named ? name : NULL;
    if (!options->help && !options->version && !commands[options->which].run)
        return cml_fail(err, CML_E_INPUT, "%s stands behind other words (expected clustermcml %s ...)", name,
                        name);
    if (options->help) return cml_help_print(stdout, topic, err);
    if (!options->version) return commands[options->which].run(options, err);
    printf("clustermcml %s\n%s\n", clm_version(), cml_version_parts());
    return CML_OK;
}

/* Shows that a large mesh is being made: on a terminal at once; in a log only if the wait is as long as that
 * for the first line of progress. Only rank 0 shows it. */
static void show_large_mesh(void *context, const char *text, double seconds)
{
    const struct cml_options *options = context;
    if (options->quiet || options->json || cml_cluster_rank() != 0) return;
    if (isatty(STDERR_FILENO) || seconds >= 10) fprintf(stderr, "%s\n", text);
}

/* Prints a note on standard error, with the number of the rank unless it is rank 0. */
static void print_note(void *context, const char *text)
{
    char who[32] = "";
    (void)context;
    if (cml_cluster_rank() > 0) snprintf(who, sizeof who, "rank %d: ", cml_cluster_rank());
    fprintf(stderr, "clustermcml: note: %s", who);
    cml_print_line(stderr, text);
}

/* Does the command on all ranks that have read their options. All return the worst status of all, and its
 * message. */
static cml_status work(cml_status status, struct cml_options *options, struct cml_error *err)
{
    CML_TRY(cml_cluster_agree(status, err));
    CML_TRY(cml_escape_output(options->json, err));
    cml_cluster_set_timeout(options->timeout);
    options->surface.budget.on_large = show_large_mesh;
    options->surface.budget.context = options;
    options->engine_options.on_note = print_note;
    clm_on_note(print_note, NULL);
    status = answer(options, err);
    if ((fflush(stdout) != 0 || ferror(stdout)) && status == CML_OK && !cml_output_unread())
        status = cml_fail(err, CML_E_IO, "standard output cannot be written");
    return cml_cluster_agree(status, err);
}

/* Prints the error, if there is one, the only function that does. Returns the exit code. */
static int complain(cml_status status, const struct cml_error *err)
{
    if (status == CML_OK) return 0;
    fputs("clustermcml: ", stderr);
    cml_print_line(stderr, err->text);
    return (int)status;
}

/* least stack of the program in KiB; with 192 all samples and commands ran, and the compiler of PoCL, too
 * (x86-64, gcc 12) */
enum { LEAST_STACK = 256 };

/* Refuses less stack than the main thread, which flies photons, too, may need. Called before MPI begins,
 * which also needs some. Other threads have stacks of their own size. */
static cml_status check_stack(struct cml_error *err)
{
    struct rlimit stack;
    if (getrlimit(RLIMIT_STACK, &stack) != 0 || stack.rlim_cur >= LEAST_STACK * (rlim_t)1024) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "ulimit -s is %llu KiB (expected %d or more)",
                    (unsigned long long)stack.rlim_cur / 1024, LEAST_STACK);
}

/* Opens the standard streams that are closed: a file opened later would get their number, and receive text
 * for the terminal. Standard output becomes a directory, which refuses to be written. */
static void open_standard_streams(void)
{
    for (int file = 0; file <= 2; file++)
        if (fcntl(file, F_GETFD) == -1 && errno == EBADF)
            (void)!(file == STDOUT_FILENO ? open("/", O_RDONLY) : open("/dev/null", O_RDWR));
}

/* True if the first word is a command of the Python package; --version belongs to this program. */
static bool is_handed_over(int argc, char *const *argv)
{
    const enum cml_command command = argc > 1 ? cml_command_find(argv[1]) : CML_NUM_COMMANDS;
    if (command == CML_NUM_COMMANDS || commands[command].run) return false;
    for (int i = 2; i < argc; i++)
        if (strcmp(argv[i], "--version") == 0) return false;
    return true;
}

/* Runs the program and returns its exit status. One message is printed for all ranks. After contact was lost
 * the other ranks print theirs, too, if the launcher has not ended them: rank 0 may be the lost one. */
int main(int argc, char **argv)
{
    struct cml_error err = {CML_OK, ""};
    if (is_handed_over(argc, argv)) return complain(cml_hand_over(argc, argv, &err), &err);
    open_standard_streams();
    cml_stop_ignore();
    cml_stop_with_parent();
    cml_status status = check_stack(&err);
    if (status != CML_OK) return complain(status, &err);
    static struct cml_options options; /* 31 KiB, which a small stack would not have before the check */
    const cml_status understood = cml_options_parse(argc, argv, &options, &err);
    if (!is_parallel(&options) && cml_launcher_rank() > 0) return 0;
    if (is_parallel(&options)) status = cml_cluster_begin(&argc, &argv, &err);
    if (status != CML_OK) return complain(status, &err);
    status = work(understood, &options, &err);
    /* from here on signals are only remembered: if a job fails, a launcher ends all its ranks by a signal,
     * which must not change the exit code */
    cml_stop_watch();
    if (cml_cluster_rank() == 0) complain(status, &err);
    if (cml_cluster_contact_lost()) {
        cml_cluster_await_launcher();
        if (cml_cluster_rank() != 0) complain(status, &err);
    }
    cml_cluster_end(status);
    if (status == CML_OK && cml_output_unread()) cml_stop_without_reader();
    return (int)status;
}
