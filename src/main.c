/* Finds the command, runs it, prints its error and turns its status into the exit code.
 * SPDX-License-Identifier: MIT */
#include "command.h"
#include "report.h"

#include <stdio.h>
#include <string.h>

static const struct command {
    const char *name;
    int least, most; /* operands */
    const char *operands;
    cml_status (*run)(const struct cml_options *options, struct cml_error *err);
} commands[] = {
    {"run", 1, 1, "scene.mci", cml_command_run},
    {"check", 1, 1, "scene.mci", cml_command_check},
    {"mesh", 1, 1, "scene.mci", cml_command_mesh},
    {"trace", 2, 2, "scene.mci N", cml_command_trace},
    {"plot", 1, 64, "a.mco [b.mco ...]", cml_command_plot},
};

static cml_status dispatch(struct cml_options *options, struct cml_error *err)
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
    return command->run(options, err);
}

int main(int argc, char **argv)
{
    struct cml_error err = {CML_OK, ""};
    struct cml_options options;
    cml_status status = cml_options_parse(argc, argv, &options, &err);
    if (status == CML_OK && options.help) {
        fputs(cml_options_help(), stdout);
        return 0;
    }
    if (status == CML_OK && options.version) {
        printf("clustermcml %s\n", cml_version());
        return 0;
    }
    if (status == CML_OK) status = dispatch(&options, &err);
    if (fflush(stdout) != 0 && status == CML_OK)
        status = cml_fail(&err, CML_E_IO, "standard output cannot be written");
    if (status != CML_OK) fprintf(stderr, "clustermcml: %s\n", err.text);
    return (int)status;
}
