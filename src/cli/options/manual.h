/* The pages of samples/manual, which are built into the program, and the search for a word in them.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <stdio.h>

/* A page in Markdown. */
struct cml_manual_page {
    const char *name; /* path below samples/manual without ".md": "input/beams" */
    const char *word; /* last part of the name: "beams"; of an index its folder: "input" */
    const char *text; /* the whole source */
};

/* All pages sorted by name; the last has no name. help_texts.cmake writes this list. */
extern const struct cml_manual_page cml_manual[];

/* Returns the first page with this name or word; NULL: no such page. */
const struct cml_manual_page *cml_manual_find(const char *name);

/* Prints the sections whose heading has the word in backquotes, and the rows of tables whose first cell has
 * it so; if there are none, the section that the glossary names. Returns how many there were. */
int cml_manual_print_word(FILE *stream, const char *word);
