/* SPDX-License-Identifier: MIT */
#include "result/mco.h"

#include "base/atomic_file.h"
#include "base/text.h"
#include "result/mco_sections.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

/* ---- MCML's part ---- */

enum { PER_LINE = 5 }; /* numbers on a full line of a grid */

/* The comment lines before a grid, as MCML 1.2.2 prints them. */
#define GRID_COMMENT(q, what, last)                                                                          \
    "# " q what "\n# " q "[0][0], [0][1],..[0][" last "-1]\n# " q "[1][0], [1][1],..[1][" last               \
    "-1]\n# ...\n# " q "[nr-1][0], [nr-1][1],..[nr-1][" last "-1]\n"

/* Blanks, and missing blanks, are MCML's: the file must be equal byte by byte. */
const struct cml_mco_section cml_mco_sections[CML_MCO_SECTIONS] = {
    {CML_QUANTITY_A_l, "", " #Absorption as a function of layer. [-]"},
    {CML_QUANTITY_A_z, "", " #A[0], [1],..A[nz-1]. [1/cm]"},
    {CML_QUANTITY_Rd_r, "", " #Rd[0], [1],..Rd[nr-1]. [1/cm2]"},
    {CML_QUANTITY_Rd_a, "", " #Rd[0], [1],..Rd[na-1]. [sr-1]"},
    {CML_QUANTITY_Tt_r, "", " #Tt[0], [1],..Tt[nr-1]. [1/cm2]"},
    {CML_QUANTITY_Tt_a, "", " #Tt[0], [1],..Tt[na-1]. [sr-1]"},
    {CML_QUANTITY_A_rz, GRID_COMMENT("A", "[r][z]. [1/cm3]", "nz"), ""},
    {CML_QUANTITY_Rd_ra, GRID_COMMENT("Rd", "[r][angle]. [1/(cm2sr)].", "na"), ""},
    {CML_QUANTITY_Tt_ra, GRID_COMMENT("Tt", "[r][angle]. [1/(cm2sr)].", "na"), ""},
};

/* Writes the first lines, up to the time of the run. The hours are computed from the seconds as printed,
 * so that a reader of the file gets the same. */
static void write_head(FILE *out, const struct cml_outcome *o)
{
    const double seconds = rint(o->user_time);
    fputs(CML_MCO_FIRST_LINE, out);
    fputs("\n"
          "####\n"
          "# Data categories include: \n"
          "# InParm, RAT, \n"
          "# A_l, A_z, Rd_r, Rd_a, Tt_r, Tt_a, \n"
          "# A_rz, Rd_ra, Tt_ra \n"
          "####\n"
          "\n",
          out);
    fprintf(out, "# User time: %8.0f sec = %8.2f hr.   Simulation time of this run.", seconds,
            seconds / 3600);
    if (o->program) fputs("  " CML_MCO_HAS_END, out);
    if (o->identity[0]) fprintf(out, "  " CML_MCO_IDENTITY "%s", o->identity);
    fputs("\n\n", out);
}

/* Writes the input as MCML repeats it, with %G and tabs. The format letter is A even if the input says B,
 * because the file is text. */
static void write_parameters(FILE *out, const struct cml_outcome *o)
{
    fprintf(out, "InParm \t\t\t# Input parameters. cm is used.\n");
    fprintf(out, "%s \tA\t\t# output file name, ASCII.\n", o->output);
    fprintf(out, "%" PRIu64 " \t\t\t# No. of photons\n", o->photons);
    fprintf(out, "%G\t%G\t\t# dz, dr [cm]\n", o->dz, o->dr);
    fprintf(out, "%d\t%d\t%d\t# No. of dz, dr, da.\n\n", o->nz, o->nr, o->na);
    fprintf(out, "%d\t\t\t\t\t# Number of layers\n", o->num_layers);
    fprintf(out, "#n\tmua\tmus\tg\td\t# One line for each layer\n");
    fprintf(out, "%G\t\t\t\t\t# n for medium above\n", o->n_above);
    for (int l = 0; l < o->num_layers; l++) {
        for (int i = 0; i < CML_LAYER_NUMBERS; i++) fprintf(out, "%G\t", *cml_outcome_layer(o, l, i));
        fprintf(out, "# layer %d\n", l + 1);
    }
    fprintf(out, "%G\t\t\t\t\t# n for medium below\n\n", o->n_below);
}

/* Writes the totals with six digits, in a field of fourteen characters as MCML pads it. */
static void write_totals(FILE *out, const struct cml_outcome *o)
{
    static const char *const names[CML_TOTALS] = {"Specular reflectance", "Diffuse reflectance",
                                                  "Absorbed fraction", "Transmittance"};
    fprintf(out, "RAT #Reflectance, absorption, transmission. \n");
    for (int i = 0; i < CML_TOTALS; i++) fprintf(out, "%-14.6G \t#%s [-]\n", o->value[i][0], names[i]);
    fputc('\n', out);
}

/* Writes a number as "%12.4E" does. Most cells of a grid are dark, and zeros are written a thousand times
 * faster this way. */
static void write_number(FILE *out, double value)
{
    if (value == 0 && !signbit(value))
        fputs("  0.0000E+00", out);
    else
        fprintf(out, "%12.4E", value);
}

/* Returns the number of columns of a grid; 0 for a profile. */
static int columns_of(const struct cml_outcome *o, const struct cml_mco_section *section)
{
    return cml_outcome_bins(o, cml_quantities[section->quantity].axis[1]);
}

/* Writes a section: its key, then its numbers. A profile has one number per line. A grid has PER_LINE numbers
 * per line, counted over the whole grid and not by row. As in MCML, an empty line follows a grid only if its
 * last line is full. */
static void write_section(FILE *out, const struct cml_outcome *o, const struct cml_mco_section *section)
{
    const double *values = o->value[section->quantity];
    const size_t cells = cml_outcome_size(o, section->quantity);
    const bool grid = columns_of(o, section) > 0;
    fprintf(out, "%s%s%s\n", section->before, cml_quantities[section->quantity].name, section->after);
    for (size_t i = 0; i < cells; i++) {
        if (section->quantity == CML_QUANTITY_A_l)
            fprintf(out, "%12.4G", values[i]);
        else
            write_number(out, values[i]);
        fputs(!grid ? "\n" : (i + 1) % PER_LINE == 0 ? " \n" : " ", out);
    }
    fputc('\n', out);
}

/* ---- this program's part ---- */

/* Writes comments on the program and the scene, and the section `lattice`, which says how packets were
 * sampled. */
static void write_comments(FILE *out, const struct cml_outcome *o)
{
    fprintf(out, "\n# clustermcml %s\n", o->program);
    cml_provenance_print(out, &o->provenance);
    cml_text_print(out, "# set ", o->settings);
    cml_text_print(out, "# ", o->beam);
    cml_text_print(out, "# ", o->phases);
    cml_text_print(out, "# ", o->top);
    cml_text_print(out, "# ", o->detectors);
    cml_text_print(out, "# ", o->shapes);
    if (o->beside) fputs(CML_MCO_BESIDE "\n", out);
    const double sampling = o->provenance.value[CML_DECIDES_sampling];
    /* NaN: the file that was read does not say how its packets were sampled, so `lattice` is left out. */
    if (isnan(sampling)) return;
    fprintf(out, "\nlattice # 1: the packets of a batch depend on each other, 0: all are independent\n%d\n",
            sampling > 0);
}

/* Writes a section "se_KEY # [unit]", then one standard error per line. */
static void write_errors_of(FILE *out, const struct cml_outcome *o, enum cml_quantity quantity)
{
    const double *errors = o->error[quantity];
    const size_t size = cml_outcome_size(o, quantity);
    if (!errors) return;
    fprintf(out, "\nse_%s # [%s]\n", cml_quantities[quantity].name, cml_quantities[quantity].units);
    for (size_t i = 0; i < size; i++) {
        write_number(out, errors[i]);
        fputc('\n', out);
    }
}

/* Writes A_face, which the totals of original MCML lack, and its standard error. */
static void write_face(FILE *out, const struct cml_outcome *o)
{
    const struct cml_quantity_info *face = &cml_quantities[CML_QUANTITY_A_face];
    if (!o->value[CML_QUANTITY_A_face]) return;
    fprintf(out, "\n%s # %s [-]\n%.6G\n", face->name, face->long_name, o->value[CML_QUANTITY_A_face][0]);
    write_errors_of(out, o, CML_QUANTITY_A_face);
}

/* Writes the sections of standard errors. */
static void write_errors(FILE *out, const struct cml_outcome *o)
{
    if (o->error[CML_QUANTITY_Rsp]) fputs("\nse_RAT # Standard errors of Rsp, Rd, A, Tt [-]\n", out);
    for (int i = 0; i < CML_TOTALS; i++)
        if (o->error[i]) fprintf(out, "%.6G\n", o->error[i][0]);
    for (int i = 0; i < CML_MCO_SECTIONS; i++) write_errors_of(out, o, cml_mco_sections[i].quantity);
}

/* Writes the sections `books` (the terms of the weight balance, rule P10), `residue` (its imbalance) and
 * `lost`. The names are part of the file format and older than the words of the code. */
static void write_balance(FILE *out, const struct cml_outcome *o)
{
    double *const *books = o->value + CML_QUANTITY_book_launched;
    if (books[0])
        fputs("\nbooks # weight per launched packet; launched + gained = all others up to lost, exactly\n",
              out);
    for (int i = 0; i < CML_BOOKS && books[i]; i++)
        fprintf(out, "%.17g # %s\n", books[i][0], cml_quantities[CML_QUANTITY_book_launched + i].long_name);
    if (o->value[CML_QUANTITY_residue])
        fprintf(out, "\nresidue # of the books, in 2^-31 packets; 0 unless the program is wrong\n%.17g\n",
                o->value[CML_QUANTITY_residue][0]);
    if (o->value[CML_QUANTITY_lost])
        fprintf(out,
                "\nlost # packets; behind it the smallest of their indices, for `clustermcml trace`\n%.17g\n",
                o->value[CML_QUANTITY_lost][0]);
    for (int i = 0; i < o->lost.count; i++) fprintf(out, "%" PRIu64 "\n", o->lost.index[i]);
}

/* Writes the file section by section. Errors of single prints stay with the stream, where cml_file_commit
 * finds them. */
cml_status cml_mco_write(const char *path, const struct cml_outcome *o, struct cml_error *err)
{
    struct cml_file file;
    CML_TRY(cml_file_create(path, &file, err));
    write_head(file.stream, o);
    write_parameters(file.stream, o);
    write_totals(file.stream, o);
    for (int i = 0; i < CML_MCO_SECTIONS; i++) write_section(file.stream, o, &cml_mco_sections[i]);
    if (o->program) {
        write_comments(file.stream, o);
        write_face(file.stream, o);
        write_errors(file.stream, o);
        write_balance(file.stream, o);
        fputs("\n" CML_MCO_END "\n", file.stream);
    }
    return cml_file_commit(&file, err);
}
