/* Reads files, lines, words and numbers, and guesses names that were meant. SPDX-License-Identifier: MIT */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* declares vasprintf */
#endif
#include "base/text.h"

#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

static const char blanks[] = " \t\v\f\r";

/* Reports a file that cannot be read: "PATH: cannot be read: REASON (expected EXPECTED)". Returns
 * CML_E_INPUT. */
static cml_status fail_reading(const char *path, const char *reason, const char *expected,
                               struct cml_error *err)
{
    return cml_fail(err, CML_E_INPUT, "%s: cannot be read: %s (expected %s)", path, reason, expected);
}

/* Reports a table larger than `most` bytes. more: "more than ", or "" if its size is exact. Returns
 * CML_E_INPUT. */
static cml_status fail_large(const char *path, const char *more, unsigned long long size, size_t most,
                             struct cml_error *err)
{
    return fail_reading(cml_text_name(path), CML_TEXT("it has %s%llu bytes", more, size),
                        CML_TEXT("a table of at most %zu bytes", most), err);
}

/* Refuses a regular file of more than `most` bytes before it is read. */
static cml_status check_size(FILE *stream, const char *path, size_t most, struct cml_error *err)
{
    struct stat about;
    if (fstat(fileno(stream), &about) != 0 || !S_ISREG(about.st_mode)) return CML_OK;
    if ((unsigned long long)about.st_size <= most) return CML_OK;
    return fail_large(path, "", (unsigned long long)about.st_size, most, err);
}

/* Reads a stream to its end in growing pieces, because the length of standard input is unknown. One byte
 * stays free for the final NUL. */
static cml_status read_stream(FILE *stream, const char *path, size_t most, char **data, size_t *size,
                              struct cml_error *err)
{
    size_t capacity = 1 << 16;
    *data = malloc(capacity);
    *size = 0;
    while (*data) {
        *size += fread(*data + *size, 1, capacity - 1 - *size, stream);
        if (*size > most) {
            free(*data);
            *data = NULL;
            return fail_large(path, "more than ", most, most, err);
        }
        if (*size < capacity - 1) break;
        capacity *= 2;
        char *larger = realloc(*data, capacity);
        if (!larger) free(*data);
        *data = larger;
    }
    if (!*data) return cml_fail_memory(err, (double)capacity, "the input file");
    (*data)[*size] = '\0';
    if (!ferror(stream)) return CML_OK;
    const int reason = errno;
    free(*data);
    *data = NULL;
    return fail_reading(cml_text_name(path), strerror(reason), "a file", err);
}

const char *cml_text_name(const char *path)
{
    return strcmp(path, "-") == 0 ? "standard input" : path;
}

bool cml_file_ends_in(const char *path, const char *extension)
{
    const size_t length = strlen(path), end = strlen(extension);
    return length >= end && strcasecmp(path + length - end, extension) == 0;
}

/* True for devices except terminals. A device such as /dev/zero may never end; a terminal does. */
static bool is_device(int file)
{
    struct stat about;
    return fstat(file, &about) == 0 && (S_ISBLK(about.st_mode) || (S_ISCHR(about.st_mode) && !isatty(file)));
}

/* Reads a whole file into new memory; "-" is standard input. Refuses a device and a file above `most` bytes,
 * so that a wrong name cannot fill the memory. */
cml_status cml_text_read_file(const char *path, size_t most, char **data, size_t *size, struct cml_error *err)
{
    *data = NULL;
    const bool standard = strcmp(path, "-") == 0;
    FILE *stream = standard ? stdin : fopen(path, "rb");
    if (!stream) return fail_reading(path, strerror(errno), "a file", err);
    if (!standard && is_device(fileno(stream))) {
        fclose(stream);
        return fail_reading(path, "it is a device", "a file", err);
    }
    cml_status status = check_size(stream, path, most, err);
    if (status == CML_OK) status = read_stream(stream, path, most, data, size, err);
    if (!standard) fclose(stream);
    return status;
}

/* Reads a file of at most `most` bytes from the source. On failure *text is cleared. */
static cml_status read_bytes(const struct cml_text_source *source, const char *path, size_t most,
                             struct cml_text *text, struct cml_error *err)
{
    *text = (struct cml_text){0};
    CML_TRY(cml_text_copy(cml_text_name(path), &text->path, err));
    const cml_status status = source
                                  ? source->read(source->context, path, most, &text->data, &text->size, err)
                                  : cml_text_read_file(path, most, &text->data, &text->size, err);
    if (status != CML_OK) cml_text_clear(text);
    return status;
}

cml_status cml_text_read_bytes(const struct cml_text_source *source, const char *path, struct cml_text *text,
                               struct cml_error *err)
{
    return read_bytes(source, path, SIZE_MAX, text, err);
}

/* Reads a text file of at most `most` bytes: skips a byte order mark and refuses UTF-16, HDF5 and NUL
 * bytes. */
static cml_status read_text(const struct cml_text_source *source, const char *path, size_t most,
                            struct cml_text *text, struct cml_error *err)
{
    CML_TRY(read_bytes(source, path, most, text, err));
    /* Skip the byte order mark that editors on Windows write. In front of a comment it would hide the comment
     * sign. */
    if (strncmp(text->data, "\xEF\xBB\xBF", 3) == 0) {
        text->size -= 3;
        memmove(text->data, text->data + 3, text->size + 1);
    }
    if (strlen(text->data) == text->size) return CML_OK;
    const bool utf16 = memcmp(text->data, "\xFF\xFE", 2) == 0 || memcmp(text->data, "\xFE\xFF", 2) == 0;
    const bool hdf5 = strncmp(text->data, "\x89HDF", 4) == 0;
    const cml_status status = fail_reading(text->path,
                                           utf16  ? "it is UTF-16"
                                           : hdf5 ? "it is HDF5"
                                                  : "it holds a NUL byte",
                                           utf16  ? "a text file in UTF-8"
                                           : hdf5 ? "a text file; results are for plot, compare and merge"
                                                  : "a text file",
                                           err);
    cml_text_clear(text);
    return status;
}

cml_status cml_text_read(const struct cml_text_source *source, const char *path, struct cml_text *text,
                         struct cml_error *err)
{
    return read_text(source, path, SIZE_MAX, text, err);
}

cml_status cml_text_read_table(const struct cml_text_source *source, const char *path, struct cml_text *text,
                               struct cml_error *err)
{
    return read_text(source, path, CML_MOST_TABLE, text, err);
}

void cml_text_clear(struct cml_text *text)
{
    free(text->path);
    free(text->data);
    *text = (struct cml_text){0};
}

/* Returns the next line. Lines are cut in place, so that a file of 1e8 numbers is in memory only once. */
char *cml_text_next(struct cml_text *text)
{
    if (text->cursor >= text->size) return NULL;
    char *line = text->data + text->cursor;
    char *end = strchr(line, '\n');
    if (!end) end = text->data + text->size;
    text->cursor = (size_t)(end - text->data) + 1;
    *end = '\0';
    if (end > line && end[-1] == '\r') end[-1] = '\0';
    text->line++;
    return line;
}

char *cml_text_word(char **cursor)
{
    char *word = *cursor + strspn(*cursor, blanks);
    if (!*word) {
        *cursor = word;
        return NULL;
    }
    const size_t plain = strcspn(word, " \t\v\f\r\"");
    const bool named = plain > 0 && word[plain - 1] == '=' && word[plain] == '"';
    char *close = *word == '"' ? strchr(word + 1, '"') : NULL,
         *last = named ? strchr(word + plain + 1, '"') : NULL;
    char *end = close ? close : last ? last + 1 : word + strcspn(word, blanks);
    *cursor = *end ? end + 1 : end;
    *end = '\0';
    return close ? word + 1 : word;
}

int cml_word_index(const char *words, const char *word)
{
    const size_t length = strlen(word);
    for (int i = 0; *words; i++) {
        const size_t own = strcspn(words, " ");
        if (own == length && memcmp(words, word, own) == 0) return i;
        words += own + strspn(words + own, " ");
    }
    return -1;
}

/* Parses a decimal number; false: it is none. The set of characters excludes hexadecimal numbers, nan and
 * inf, which strtod would accept. */
bool cml_parse_double(const char *word, double *value)
{
    if (word[strspn(word, "+-.0123456789eE")] != '\0') return false;
    char *end = NULL;
    const double number = strtod(word, &end);
    if (end == word || *end || !isfinite(number)) return false;
    *value = number;
    return true;
}

/* Parses a whole number up to 2^53, below which doubles hold every whole number. long double is used because
 * a double would round 2^53 + 1 to 2^53. */
bool cml_parse_count(const char *word, uint64_t *value)
{
    double rounded = 0;
    if (!cml_parse_double(word, &rounded)) return false;
    const long double number = strtold(word, NULL);
    if (number < 0 || number > 9007199254740992.0L || number != floorl(number)) return false;
    *value = (uint64_t)number;
    return true;
}

bool cml_parse_int(const char *word, int *value)
{
    if (word[strspn(word, "+-0123456789")] != '\0') return false;
    char *end = NULL;
    errno = 0;
    const long number = strtol(word, &end, 10);
    if (end == word || *end || errno || number < INT_MIN || number > INT_MAX) return false;
    *value = (int)number;
    return true;
}

cml_status cml_text_copy(const char *text, char **copy, struct cml_error *err)
{
    *copy = strdup(text);
    return *copy ? CML_OK : cml_fail_memory(err, (double)strlen(text), "a name");
}

cml_status cml_text_format(char **text, const char *what, struct cml_error *err, const char *format, ...)
{
    va_list values;
    va_start(values, format);
    const bool good = vasprintf(text, format, values) >= 0;
    va_end(values);
    if (good) return CML_OK;
    *text = NULL;
    return cml_fail_memory(err, 0, what);
}

const char *cml_text_short(char text[CML_TEXT_SIZE], const char *format, ...)
{
    va_list values;
    va_start(values, format);
    vsnprintf(text, CML_TEXT_SIZE, format, values);
    va_end(values);
    return text;
}

cml_status cml_text_end(FILE *out, char **text, const size_t *size, const char *what, struct cml_error *err)
{
    const bool failed = out && ferror(out);
    if (out && fclose(out) == 0 && !failed) return CML_OK;
    if (out) free(*text);
    *text = NULL;
    return cml_fail_memory(err, (double)*size, what);
}

void cml_text_print(FILE *out, const char *prefix, const char *text)
{
    while (text && *text) {
        const size_t length = strcspn(text, "\n");
        fprintf(out, "%s%.*s\n", prefix, (int)length, text);
        text += length + (text[length] == '\n');
    }
}

cml_status cml_path_beside(const char *beside, const char *name, char **path, struct cml_error *err)
{
    const char *slash = strrchr(beside, '/');
    if (!slash || name[0] == '/') return cml_text_copy(name, path, err);
    return cml_text_format(path, "a path", err, "%.*s%s", (int)(slash - beside) + 1, beside, name);
}

/* ---- guessing the name that was meant ---- */

enum { LONGEST = 63 };

/* Returns the smaller of two numbers. */
static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* True if two letters are equal, ignoring case. */
static bool is_same(char a, char b)
{
    return tolower((unsigned char)a) == tolower((unsigned char)b);
}

/* Returns Levenshtein's distance of two words, ignoring case. One row of its table is kept at a time. */
static size_t distance(const char *a, size_t a_length, const char *b, size_t b_length)
{
    size_t row[LONGEST + 1];
    for (size_t j = 0; j <= b_length; j++) row[j] = j;
    for (size_t i = 1; i <= a_length; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b_length; j++) {
            const size_t above = row[j];
            row[j] = least(least(above, row[j - 1]) + 1, diagonal + !is_same(a[i - 1], b[j - 1]));
            diagonal = above;
        }
    }
    return row[b_length];
}

void cml_guess_offer(struct cml_guess *guess, const char *name)
{
    const size_t length = strlen(name);
    if (length > LONGEST || guess->length > LONGEST || guess->length == 0) return;
    if (strncmp(name, guess->word, guess->length) == 0) {
        guess->complete = name;
        guess->completions++;
    }
    const size_t d = distance(guess->word, guess->length, name, length);
    if (guess->nearest && d >= guess->distance) return;
    guess->nearest = name;
    guess->distance = d;
}

const char *cml_guess_best(const struct cml_guess *guess)
{
    if (guess->completions == 1) return guess->complete;
    if (!guess->nearest || guess->length < 3) return NULL;
    const size_t most = guess->length == 3 ? 1 : 2;
    return guess->distance <= most && 2 * guess->distance <= strlen(guess->nearest) ? guess->nearest : NULL;
}
