/* SPDX-License-Identifier: MIT */
#include "cli/hand_over.h"

#include <errno.h>
#include <limits.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define CURE                                                                                                 \
    "apt-get install python3-h5py python3-matplotlib python3-xarray python3-scipy, or pip install h5py "     \
    "matplotlib xarray scipy"

/* The program that Python runs, in syntax of any version. Modules are imported only when needed, so any
 * import may fail later. The current folder is taken off the path: its modules must not replace libraries. */
static const char start[] =
    "import sys\n"
    "if sys.path[0] == '': del sys.path[0]\n"
    "def lacks(what):\n"
    "    sys.stderr.write('clustermcml: %s: %s %s (expected Python 3.10 or later with packages: " CURE
    ")\\n'\n"
    "                     % (sys.argv[1], sys.executable, what))\n"
    "    sys.exit(5)\n"
    "if sys.version_info < (3, 10): lacks('is older than Python 3.10')\n"
    "try:\n"
    "    from clustermcml.__main__ import main\n"
    "    code = main()\n"
    "except ImportError as error:\n"
    "    lacks('has no module %s' % (error.name or error))\n"
    "sys.exit(code)\n";

/* Finds the package, relative to the folder of the program: in a build tree, an install tree or a wheel. */
static bool find_package(const char *folder, char path[PATH_MAX])
{
    static const char *const places[] = {"../src/python", "../share/clustermcml/python", "../.."};
    char main[PATH_MAX + 40];
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        if (snprintf(path, PATH_MAX, "%s/%s", folder, places[i]) >= PATH_MAX) continue;
        snprintf(main, sizeof main, "%s/clustermcml/__main__.py", path);
        if (access(main, R_OK) == 0) return true;
    }
    return false;
}

/* Tells the package which program to call (this one), and Python to look for modules beside it first. */
static cml_status set_environment(struct cml_error *err)
{
    char program[PATH_MAX], package[PATH_MAX], all[3 * PATH_MAX];
    const char *others = getenv("PYTHONPATH");
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    if (length < 0) return CML_OK; /* the search path of modules will do */
    program[length] = '\0';
    int failed = setenv("CLUSTERMCML", program, 1);
    *strrchr(program, '/') = '\0';
    if (find_package(program, package)) {
        snprintf(all, sizeof all, "%s%s%s", package, others && *others ? ":" : "", others ? others : "");
        failed |= setenv("PYTHONPATH", all, 1);
    }
    return failed ? cml_fail_memory(err, sizeof all, "the environment") : CML_OK;
}

cml_status cml_hand_over(int argc, char **argv, struct cml_error *err)
{
    const char *named = getenv("CLUSTERMCML_PYTHON"), *python = named && *named ? named : "python3";
    char **words = calloc((size_t)argc + 3, sizeof *words);
    if (!words) return cml_fail_memory(err, 8.0 * argc, "the words of a command");
    words[0] = (char *)(uintptr_t)python;
    words[1] = (char *)(uintptr_t) "-c";
    words[2] = (char *)(uintptr_t)start;
    for (int i = 1; i < argc; i++) words[2 + i] = argv[i];
    cml_status status = set_environment(err);
    if (status == CML_OK) {
        execvp(python, words);
        status =
            cml_fail(err, CML_E_IO,
                     "%s: %s cannot be started (%s; expected Python 3.10 or later with packages: " CURE ")",
                     argv[1], python, strerror(errno));
    }
    free(words);
    return status;
}
