/* Escapes control characters, invisible characters and invalid UTF-8 in messages and on standard output.
 * SPDX-License-Identifier: MIT */
#define _GNU_SOURCE /* declares fopencookie */
#include "base/print_line.h"

#include <errno.h>
#include <stdint.h>
#include <string.h>
#include <unistd.h>

/* Returns the number of bytes of the UTF-8 character that begins with the byte `first`; 1 if no character
 * begins so. */
static int length_of(unsigned char first)
{
    return first < 0xc0 || first >= 0xf8 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
}

/* True for characters that a message must not contain: control characters of terminals (C1), of lines and of
 * writing direction; invisible characters (Default_Ignorable_Code_Point of Unicode 15,
 * DerivedCoreProperties.txt); code points that are no characters. */
static bool is_control(uint32_t code)
{
    static const uint32_t range[][2] = {
        {0, 0x1f},        {0x7f, 0x9f},     {0xad, 0xad},       {0x34f, 0x34f},     {0x61c, 0x61c},
        {0x115f, 0x1160}, {0x17b4, 0x17b5}, {0x180b, 0x180f},   {0x200b, 0x200f},   {0x2028, 0x202e},
        {0x2060, 0x206f}, {0x3164, 0x3164}, {0xfdd0, 0xfdef},   {0xfe00, 0xfe0f},   {0xfeff, 0xfeff},
        {0xffa0, 0xffa0}, {0xfff0, 0xfffb}, {0x1bca0, 0x1bca3}, {0x1d173, 0x1d17a}, {0xe0000, 0xe0fff},
    };
    if ((code & 0xfffe) == 0xfffe) return true;
    for (size_t i = 0; i < sizeof range / sizeof *range; i++)
        if (code >= range[i][0] && code <= range[i][1]) return true;
    return false;
}

/* Decodes the UTF-8 character at `text` into *code. Returns its number of bytes; 0 if no valid character
 * begins there. */
static int decode(const char *text, uint32_t *code)
{
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    const unsigned char first = (unsigned char)*text;
    const int bytes = length_of(first);
    *code = bytes == 1 ? first : first & (0x7fu >> bytes);
    for (int i = 1; i < bytes; i++) {
        if ((text[i] & 0xc0) != 0x80) return 0;
        *code = *code << 6 | ((unsigned char)text[i] & 0x3fu);
    }
    const bool none = (bytes == 1 && first >= 0x80) || *code < least[bytes] || *code > 0x10ffff ||
                      (*code >= 0xd800 && *code < 0xe000);
    return none ? 0 : bytes;
}

/* Prints a text with dangerous characters escaped: as \uNNNN with `json`, else as \xNN. as_they_are: control
 * characters that stay. */
static void print(FILE *stream, const char *text, const char *as_they_are, bool json)
{
    while (*text) {
        uint32_t code;
        const int bytes = decode(text, &code);
        const bool plain =
            bytes > 0 && (!is_control(code) || (code < 0x80 && strchr(as_they_are, (int)code)));
        if (plain)
            fwrite(text, 1, (size_t)bytes, stream);
        else if (json && bytes == 4)
            fprintf(stream, "\\u%04x\\u%04x", 0xd7c0 + (code >> 10), 0xdc00 + (code & 0x3ff));
        else if (json && bytes > 0)
            fprintf(stream, "\\u%04x", code);
        else
            fprintf(stream, "\\x%02x", (unsigned char)*text);
        text += plain || (json && bytes > 0) ? bytes : 1;
    }
}

void cml_print_line(FILE *stream, const char *text)
{
    print(stream, text, "", false);
    fputc('\n', stream);
}

/* The stream in place of standard output: bytes of a character that is not complete yet, since a character
 * may come in several writes. */
static struct {
    FILE *to;
    bool json;
    char held[5];
    int count;
    bool unread;
} escaped;

/* Prints the bytes held so far and forgets them. */
static void print_held(void)
{
    escaped.held[escaped.count] = '\0';
    print(escaped.to, escaped.held, "\n\t", escaped.json);
    escaped.count = 0;
}

/* Writes the bytes of a stream to standard output, character by character (fopencookie). Returns 0 if
 * standard output failed. */
static ssize_t write_escaped(void *context, const char *data, size_t size)
{
    (void)context;
    for (size_t i = 0; i < size; i++) {
        /* A byte that begins a character shows that the character held so far is incomplete. */
        if ((data[i] & 0xc0) != 0x80) print_held();
        escaped.held[escaped.count++] = data[i];
        if (escaped.count == length_of((unsigned char)escaped.held[0])) print_held();
    }
    if (fflush(escaped.to) == 0 && !ferror(escaped.to)) return (ssize_t)size;
    escaped.unread |= errno == EPIPE;
    return 0;
}

bool cml_output_unread(void)
{
    return escaped.unread;
}

/* Replaces stdout by a stream that escapes control characters, so that names from files cannot steer a
 * terminal. With `json`, escapes are written as in JSON. Terminals get each line at once, files get
 * blocks. */
cml_status cml_escape_output(bool json, struct cml_error *err)
{
    const cookie_io_functions_t calls = {.write = write_escaped};
    FILE *stream = fopencookie(NULL, "w", calls);
    if (!stream) return cml_fail_memory(err, 0, "standard output");
    setvbuf(stream, NULL, isatty(STDOUT_FILENO) ? _IOLBF : _IOFBF, BUFSIZ);
    escaped.to = stdout;
    escaped.json = json;
    stdout = stream;
    return CML_OK;
}
