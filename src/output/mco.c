/* SPDX-License-Identifier: MIT */
#include "output/mco.h"

#include "base/atomic_file.h"
#include "output/mco_sections.h"
#include "base/text.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* The writer, and what it shares with the reader: where each section of the file stands in struct cml_mco. */

#define OFFSET(member) offsetof(struct cml_mco, member)

/* The comment lines before a grid, as MCML 1.2.2 prints them. */
#define GRID_COMMENT(q, what, last)                                                                          \
    "# " q what "\n# " q "[0][0], [0][1],..[0][" last "-1]\n# " q "[1][0], [1][1],..[1][" last               \
    "-1]\n# ...\n# " q "[nr-1][0], [nr-1][1],..[nr-1][" last "-1]\n"

/* Blanks and the missing ones are MCML's: the file is to be the same byte by byte. */
const struct cml_mco_section cml_mco_sections[CML_MCO_SECTIONS] = {
    {"", "A_l", " #Absorption as a function of layer. [-]", OFFSET(A_l), OFFSET(num_layers), 0, true},
    {"", "A_z", " #A[0], [1],..A[nz-1]. [1/cm]", OFFSET(A_z), OFFSET(nz), 0, false},
    {"", "Rd_r", " #Rd[0], [1],..Rd[nr-1]. [1/cm2]", OFFSET(Rd_r), OFFSET(nr), 0, false},
    {"", "Rd_a", " #Rd[0], [1],..Rd[na-1]. [sr-1]", OFFSET(Rd_a), OFFSET(na), 0, false},
    {"", "Tt_r", " #Tt[0], [1],..Tt[nr-1]. [1/cm2]", OFFSET(Tt_r), OFFSET(nr), 0, false},
    {"", "Tt_a", " #Tt[0], [1],..Tt[na-1]. [sr-1]", OFFSET(Tt_a), OFFSET(na), 0, false},
    {GRID_COMMENT("A", "[r][z]. [1/cm3]", "nz"), "A_rz", "", OFFSET(A_rz), OFFSET(nr), OFFSET(nz), false},
    {GRID_COMMENT("Rd", "[r][angle]. [1/(cm2sr)].", "na"), "Rd_ra", "", OFFSET(Rd_ra), OFFSET(nr), OFFSET(na),
     false},
    {GRID_COMMENT("Tt", "[r][angle]. [1/(cm2sr)].", "na"), "Tt_ra", "", OFFSET(Tt_ra), OFFSET(nr), OFFSET(na),
     false},
};

/* Members are reached by offset and memcpy, which no compiler may take for an access of another type. */
static int int_at(const struct cml_mco *mco, size_t offset)
{
    int value = 0;
    memcpy(&value, (const char *)mco + offset, sizeof value);
    return value;
}

int cml_mco_columns(const struct cml_mco *mco, const struct cml_mco_section *section)
{
    return section->columns ? int_at(mco, section->columns) : 0;
}

size_t cml_mco_cells(const struct cml_mco *mco, const struct cml_mco_section *section)
{
    const size_t rows = (size_t)int_at(mco, section->rows);
    return section->columns ? rows * (size_t)cml_mco_columns(mco, section) : rows;
}

double *cml_mco_values(const struct cml_mco *mco, const struct cml_mco_section *section)
{
    double *values = NULL;
    memcpy(&values, (const char *)mco + section->values, sizeof values);
    return values;
}

static void set_values(struct cml_mco *mco, const struct cml_mco_section *section, double *values)
{
    memcpy((char *)mco + section->values, &values, sizeof values);
}

static void free_arrays(struct cml_mco *mco)
{
    for (int i = 0; i < CML_MCO_SECTIONS; i++) {
        free(cml_mco_values(mco, &cml_mco_sections[i]));
        set_values(mco, &cml_mco_sections[i], NULL);
    }
    free(mco->layer);
    mco->layer = NULL;
}

/* As a double: sizes of a file that was not written by us may overflow any integer. */
static double bytes_of(const struct cml_mco *mco)
{
    double bytes = (double)mco->num_layers * (double)sizeof *mco->layer;
    for (int i = 0; i < CML_MCO_SECTIONS; i++)
        bytes += (double)cml_mco_cells(mco, &cml_mco_sections[i]) * (double)sizeof(double);
    return bytes;
}

/* All or none: after the first failure the rest become NULL, so that free_arrays may run over all. */
static bool allocate_arrays(struct cml_mco *mco)
{
    mco->layer = calloc((size_t)mco->num_layers, sizeof *mco->layer);
    bool good = mco->layer != NULL;
    for (int i = 0; i < CML_MCO_SECTIONS; i++) {
        double *values = good ? calloc(cml_mco_cells(mco, &cml_mco_sections[i]), sizeof *values) : NULL;
        set_values(mco, &cml_mco_sections[i], values);
        good = values != NULL;
    }
    if (!good) free_arrays(mco);
    return good;
}

cml_status cml_mco_allocate(struct cml_mco *mco, struct cml_error *err)
{
    const double bytes = bytes_of(mco);
    mco->extra = NULL;
    if (bytes < (double)PTRDIFF_MAX && allocate_arrays(mco)) return CML_OK;
    return cml_fail_memory(err, bytes, "the results");
}

/* Also of one that was never filled, as long as it is zero. */
void cml_mco_clear(struct cml_mco *mco)
{
    free_arrays(mco);
    free(mco->output);
    free(mco->extra);
    *mco = (struct cml_mco){0};
}

/* The hours are those of the seconds as printed: computed from the unrounded time they could not be found
 * again from the file. */
static void write_head(FILE *out, const struct cml_mco *mco)
{
    const double seconds = rint(mco->user_time);
    fputs("A1 \t# Version number of the file format.\n"
          "\n"
          "####\n"
          "# Data categories include: \n"
          "# InParm, RAT, \n"
          "# A_l, A_z, Rd_r, Rd_a, Tt_r, Tt_a, \n"
          "# A_rz, Rd_ra, Tt_ra \n"
          "####\n"
          "\n",
          out);
    fprintf(out, "# User time: %8.0f sec = %8.2f hr.   Simulation time of this run.\n\n", seconds,
            seconds / 3600);
}

/* The input as MCML repeats it, %G and tabs included. The letter A also where the format was B: the file
 * is text. */
static void write_parameters(FILE *out, const struct cml_mco *mco)
{
    fprintf(out, "InParm \t\t\t# Input parameters. cm is used.\n");
    fprintf(out, "%s \tA\t\t# output file name, ASCII.\n", mco->output);
    fprintf(out, "%" PRIu64 " \t\t\t# No. of photons\n", mco->photons);
    fprintf(out, "%G\t%G\t\t# dz, dr [cm]\n", mco->dz, mco->dr);
    fprintf(out, "%d\t%d\t%d\t# No. of dz, dr, da.\n\n", mco->nz, mco->nr, mco->na);
    fprintf(out, "%d\t\t\t\t\t# Number of layers\n", mco->num_layers);
    fprintf(out, "#n\tmua\tmus\tg\td\t# One line for each layer\n");
    fprintf(out, "%G\t\t\t\t\t# n for medium above\n", mco->n_above);
    for (int l = 0; l < mco->num_layers; l++) {
        const double *p = mco->layer[l];
        fprintf(out, "%G\t%G\t%G\t%G\t%G\t# layer %d\n", p[0], p[1], p[2], p[3], p[4], l + 1);
    }
    fprintf(out, "%G\t\t\t\t\t# n for medium below\n\n", mco->n_below);
}

/* Six digits, in a field of fourteen characters as MCML pads it. */
static void write_totals(FILE *out, const struct cml_mco *mco)
{
    fprintf(out, "RAT #Reflectance, absorption, transmission. \n");
    fprintf(out, "%-14.6G \t#Specular reflectance [-]\n", mco->Rsp);
    fprintf(out, "%-14.6G \t#Diffuse reflectance [-]\n", mco->Rd);
    fprintf(out, "%-14.6G \t#Absorbed fraction [-]\n", mco->A);
    fprintf(out, "%-14.6G \t#Transmittance [-]\n\n", mco->Tt);
}

/* The line ends of a grid are counted over the whole block: a count that fills its last line leaves an empty
 * line behind the block, any other does not. */
static void write_section(FILE *out, const struct cml_mco *mco, const struct cml_mco_section *section)
{
    const double *values = cml_mco_values(mco, section);
    const size_t cells = cml_mco_cells(mco, section);
    fprintf(out, "%s%s%s\n", section->before, section->key, section->after);
    for (size_t i = 0; i < cells; i++) {
        if (!section->columns)
            fprintf(out, section->general ? "%12.4G\n" : "%12.4E\n", values[i]);
        else
            fprintf(out, (i + 1) % CML_MCO_PER_LINE == 0 ? "%12.4E \n" : "%12.4E ", values[i]);
    }
    fputc('\n', out);
}

/* Errors of single prints stay with the stream, and the commit looks at it. */
cml_status cml_mco_write(const char *path, const struct cml_mco *mco, struct cml_error *err)
{
    struct cml_file file;
    CML_TRY(cml_file_create(path, &file, err));
    write_head(file.stream, mco);
    write_parameters(file.stream, mco);
    write_totals(file.stream, mco);
    for (int i = 0; i < CML_MCO_SECTIONS; i++) write_section(file.stream, mco, &cml_mco_sections[i]);
    if (mco->extra) fputs(mco->extra, file.stream);
    return cml_file_commit(&file, err);
}

/* The line behind `line`, NULL when that was the last. */
static const char *line_after(const char *line)
{
    const char *end = strchr(line, '\n');
    return end && end[1] ? end + 1 : NULL;
}

/* The first line behind the one that begins with `key` and a blank. */
static const char *find_values(const char *text, const char *key)
{
    const size_t length = strlen(key);
    for (const char *line = text; line; line = line_after(line))
        if (strncmp(line, key, length) == 0 && (line[length] == ' ' || line[length] == '\t'))
            return line_after(line);
    return NULL;
}

/* Its first word as a number; what follows on the line is a comment. An error may be "nan": that of one
 * packet. */
static bool leading_number(const char *line, bool error, double *value)
{
    char word[64];
    const char *start = line + strspn(line, " \t");
    const size_t length = strcspn(start, " \t\r\n");
    if (length >= sizeof word) return false;
    memcpy(word, start, length);
    word[length] = '\0';
    if (!error || strcasecmp(word, "nan") != 0) return cml_parse_double(word, value);
    *value = NAN;
    return true;
}

/* The values end with the first line that does not begin with a number: an empty line, or the next key. */
int cml_mco_extra(const struct cml_mco *mco, const char *key, double *values, int capacity)
{
    int count = 0;
    const bool errors = strncmp(key, "se_", 3) == 0;
    const char *line = mco->extra ? find_values(mco->extra, key) : NULL;
    while (line && count < capacity && leading_number(line, errors, &values[count])) {
        count++;
        line = line_after(line);
    }
    return count;
}
