/* Code, included by the readers of binary files: numbers, read byte by byte: a file's order of bytes is fixed
 * while the machine's is not, and addresses need not be aligned. SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/* Returns `size` bytes, at most 8, as a whole number. big: the first byte is the highest. */
static inline uint64_t cml_binary_word(const char *data, int size, bool big)
{
    uint64_t word = 0;
    for (int i = 0; i < size; i++) word = word << 8 | (unsigned char)data[big ? i : size - 1 - i];
    return word;
}

/* Returns a float (size 4) or a double (size 8) of IEEE 754. */
static inline double cml_binary_real(const char *data, int size, bool big)
{
    const uint64_t word = cml_binary_word(data, size, big);
    const uint32_t half = (uint32_t)word;
    float single;
    double real;
    memcpy(&single, &half, sizeof single);
    memcpy(&real, &word, sizeof real);
    return size == 4 ? (double)single : real;
}
