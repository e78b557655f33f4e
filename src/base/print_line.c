/* SPDX-License-Identifier: MIT */
#include "base/print_line.h"

#include <stdbool.h>
#include <stdint.h>

/* Bytes of the character that begins here and is printable UTF-8, 0: there is none. Controls of terminals
 * (C1) and of the direction of writing are not. */
static int printable(const unsigned char *text)
{
    static const uint32_t least[] = {0x20, 0xa0, 0x800, 0x10000};
    const int more = *text < 0x80 ? 0 : *text < 0xe0 ? 1 : *text < 0xf0 ? 2 : 3;
    uint32_t code = more ? *text & (0x3fu >> more) : *text;
    if ((*text >= 0x80 && *text < 0xc0) || *text >= 0xf8) return 0;
    for (int i = 1; i <= more; i++) {
        if ((text[i] & 0xc0) != 0x80) return 0;
        code = code << 6 | (text[i] & 0x3fu);
    }
    const bool control =
                   code == 0x7f || (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069),
               surrogate = code >= 0xd800 && code < 0xe000;
    return code < least[more] || code > 0x10ffff || control || surrogate ? 0 : more + 1;
}

void cml_print_line(FILE *stream, const char *text)
{
    for (const unsigned char *c = (const unsigned char *)text; *c;) {
        const int bytes = printable(c);
        if (bytes > 0)
            fwrite(c, 1, (size_t)bytes, stream);
        else
            fprintf(stream, "\\x%02x", *c);
        c += bytes > 0 ? bytes : 1;
    }
    fputc('\n', stream);
}
