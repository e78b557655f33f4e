/* Fuzzes command lines; the input has one word per line. SPDX-License-Identifier: MIT */
#include "fuzz/fuzz.h"

#include "cli/options/options_parse.h"

enum { MOST_WORDS = 64 };

/* Copies each word into memory of its own, so that the sanitizer sees a read beyond a word. */
static int split(const uint8_t *data, size_t size, char *argv[MOST_WORDS + 1])
{
    int count = 0;
    argv[count++] = strdup("clustermcml");
    for (size_t at = 0; at < size && count < MOST_WORDS;) {
        const uint8_t *end = memchr(data + at, '\n', size - at);
        const size_t length = end ? (size_t)(end - data) - at : size - at;
        argv[count++] = strndup((const char *)data + at, length);
        at += length + 1;
    }
    argv[count] = NULL;
    return count;
}

static void check(const struct cml_options *options, int argc)
{
    FUZZ_CHECK(options->engine != NULL);
    FUZZ_CHECK(options->photons <= (uint64_t)1 << 48 && options->run >= 1 && options->run <= UINT32_MAX);
    FUZZ_CHECK(options->engine_options.threads >= 0 && options->engine_options.threads <= 4096);
    FUZZ_CHECK(options->surface.tolerance >= 1e-12 && options->surface.tolerance <= 0.1);
    FUZZ_CHECK(options->surface.budget.most >= 1 && options->surface.budget.most <= CML_MESH_MOST);
    FUZZ_CHECK(options->target_error >= 0 && options->target_error < 1);
    FUZZ_CHECK(options->timeout > 0 && options->checkpoint_interval >= 0);
    FUZZ_CHECK(options->alpha > 0 && options->alpha < 1);
    FUZZ_CHECK(options->num_operands >= 0 && options->num_operands < argc);
    for (int i = 0; i < options->num_operands; i++) FUZZ_CHECK(options->operands[i] != NULL);
    FUZZ_CHECK(strlen(options->command) < sizeof options->command);
}

/* True if the name belongs to the word: the word without text behind '=' or beyond 62 bytes, or one of its
 * letters (-x of -xh). Control characters of the word have become '?'. */
static bool is_of(const char *name, size_t length, const char *word)
{
    const size_t whole = strcspn(word, "=");
    bool letter = false, same = length == (whole < 62 ? whole : 62);
    for (size_t i = 0; same && i < length; i++) same = name[i] == word[i] || name[i] == '?';
    if (word[0] != '-' || word[1] == '-' || length != 2) return same;
    for (const char *c = word + 1; *c; c++) letter = letter || name[1] == *c || name[1] == '?';
    return same || letter;
}

/* Checks that a message about an unknown option, or one without a value, names an option that was given. A
 * message that was too long is cut and lacks this end. */
static void check_name(const char *message, int argc, char *const *words)
{
    static const char head[] = "unknown option ";
    const bool unknown = strncmp(message, head, sizeof head - 1) == 0;
    const char *name = unknown ? message + sizeof head - 1 : message;
    const char *tail =
        unknown ? " (try clustermcml --help)" : " is missing its value (try clustermcml --help)";
    if (strlen(name) < strlen(tail) || strcmp(name + strlen(name) - strlen(tail), tail) != 0) return;
    bool given = false;
    for (int i = 1; i < argc; i++) given = given || is_of(name, strlen(name) - strlen(tail), words[i]);
    FUZZ_CHECK(given);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *argv[MOST_WORDS + 1], *words[MOST_WORDS + 1];
    const int argc = split(data, size, argv);
    struct cml_options options;
    struct cml_error err = {CML_OK, ""};
    memcpy(words, argv, sizeof words); /* parsing moves operands to the front of argv */
    const cml_status status = cml_options_parse(argc, argv, &options, &err);
    if (status == CML_OK) {
        check(&options, argc);
    } else {
        fuzz_refused(status, &err);
        check_name(err.text, argc, words);
    }
    for (int i = 0; i < argc; i++) free(words[i]);
    return 0;
}
