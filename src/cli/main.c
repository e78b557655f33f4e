/* Finds the command, runs it, prints its error and turns its status into the exit code.
 * SPDX-License-Identifier: MIT */
#include "run/cluster.h"

#include "base/version.h"
#include "cli/command.h"
#include "output/report.h"
#include "run/stop.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>

/* Commands with the number of operands that each takes. The first one is meant where none is named. */
static const struct command {
    const char *name;
    int least, most; /* operands */
    bool parallel;   /* all ranks work; else rank 0 alone */
    const char *operands;
    cml_status (*run)(const struct cml_options *options, struct cml_error *err);
} commands[] = {
    {"run", 1, 1, true, "scene.mci", cml_command_run},
    {"check", 1, 1, false, "scene.mci", cml_command_check},
    {"exact", 1, 1, false, "scene.mci", cml_command_exact},
    {"mesh", 1, 1, false, "scene.mci", cml_command_mesh},
    {"trace", 2, 2, false, "scene.mci N", cml_command_trace},
    {"compare", 2, 2, false, "a.mco b.mco", cml_command_compare},
    {"crosscheck", 1, 1, false, "scene.mci", cml_command_crosscheck},
    {"devices", 0, 0, false, "", cml_command_devices},
    {"plot", 1, 64, false, "a.mco [b.mco ...] or a.map.vti [b.map.vti ...]", cml_command_plot},
};

/* A word that is no command is the operand of `run`: `clustermcml scene.mci` is enough. Commands that are
 * not parallel run on rank 0 while the others wait for its status. */
static cml_status run_command(struct cml_options *options, struct cml_error *err)
{
    const struct command *command = &commands[0];
    for (size_t i = 0; options->num_operands > 0 && i < sizeof commands / sizeof *commands; i++) {
        if (strcmp(options->operands[0], commands[i].name) != 0) continue;
        command = &commands[i];
        options->operands++;
        options->num_operands--;
        break;
    }
    if (options->num_operands < command->least || options->num_operands > command->most)
        return cml_fail(err, CML_E_INPUT, "usage: clustermcml %s %s (try clustermcml --help)", command->name,
                        command->operands);
    return command->parallel || cml_cluster_rank() == 0 ? command->run(options, err) : CML_OK;
}

/* On rank 0 what --help and --version ask for. */
static bool answer_question(const struct cml_options *options)
{
    if (cml_cluster_rank() == 0 && options->help) fputs(cml_options_help(), stdout);
    if (cml_cluster_rank() == 0 && options->version && !options->help)
        printf("clustermcml %s\n", cml_version());
    return options->help || options->version;
}

/* All ranks end with the status and the message of the one that fared worst. */
static cml_status work(int argc, char **argv, struct cml_error *err)
{
    struct cml_options options;
    CML_TRY(cml_cluster_agree(cml_options_parse(argc, argv, &options, err), err));
    cml_cluster_set_timeout(options.timeout);
    cml_announce_meshes(&options);
    cml_status status = CML_OK;
    if (!answer_question(&options)) status = run_command(&options, err);
    if ((fflush(stdout) != 0 || ferror(stdout)) && status == CML_OK)
        status = cml_fail(err, CML_E_IO, "standard output cannot be written");
    return cml_cluster_agree(status, err);
}

/* The only place that prints an error. */
static void complain(cml_status status, const struct cml_error *err)
{
    if (status != CML_OK) fprintf(stderr, "clustermcml: %s\n", err->text);
}

/* A file that is opened while one of the three is closed would get its number, and what is meant for the
 * terminal would be written into it. */
static void open_standard_streams(void)
{
    for (int file = 0; file <= 2; file++)
        if (fcntl(file, F_GETFD) == -1 && errno == EBADF) (void)!open("/dev/null", O_RDWR);
}

/* One message for all ranks; when contact was lost, others than rank 0 speak only if the launcher has not
 * ended them: it may be rank 0 that is lost. */
int main(int argc, char **argv)
{
    struct cml_error err = {CML_OK, ""};
    open_standard_streams();
    cml_stop_ignore();
    cml_status status = cml_cluster_begin(&argc, &argv, &err);
    if (status != CML_OK) {
        complain(status, &err);
        return (int)status;
    }
    status = work(argc, argv, &err);
    if (cml_cluster_rank() == 0) complain(status, &err);
    if (cml_cluster_contact_lost()) {
        cml_cluster_await_launcher();
        if (cml_cluster_rank() != 0) complain(status, &err);
    }
    cml_cluster_end(status);
    return (int)status;
}
