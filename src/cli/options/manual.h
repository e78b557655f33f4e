/* The pages of samples/manual that are built into the program, and the search for a word in them.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <stdio.h>

/* A page in Markdown, as the source has it. name: its path below samples/manual without ".md"
 * ("input/beams"). */
struct cml_manual_page {
    const char *name, *text;
};

/* Sorted by name; the last page has no name (help_texts.cmake writes the list). */
extern const struct cml_manual_page cml_manual[];

/* name: that of a page, its last part ("beams"), or a folder ("input", which means its index). NULL: no such
 * page. */
const struct cml_manual_page *cml_manual_find(const char *name);

/* Prints the sections whose heading has the word in grave accents, the rows of tables whose first cell has it
 * so, and the section to which the glossary sends it. Returns how many of these there were. */
int cml_manual_print_word(FILE *stream, const char *word);
