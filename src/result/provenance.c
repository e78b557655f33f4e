/* SPDX-License-Identifier: MIT */
#include "result/provenance.h"

#include <math.h>
#include <string.h>

#define ROW(name, value, where, before, zero, other) {#name, where, before, zero, other},
const struct cml_option_info cml_options_of_bits[CML_NUM_OPTIONS_OF_BITS] = {CML_OPTIONS_OF_BITS(ROW)};

static const char *form_of(const struct cml_option_info *info, double value)
{
    return value == 0 ? info->zero : info->other;
}

const char *cml_option_word(enum cml_option_of_bits option, double value)
{
    return form_of(&cml_options_of_bits[option], value);
}

static void identify_text(FILE *out, const char *name, const char *text)
{
    fprintf(out, "%s %s\n", text ? name : "no", text ? text : name);
}

void cml_provenance_identify(FILE *out, const struct cml_provenance *provenance)
{
    identify_text(out, "engine", provenance->engine);
    identify_text(out, "aim", provenance->aim);
    identify_text(out, "error_of", provenance->error_of);
    for (int i = 0; i < CML_NUM_OPTIONS_OF_BITS; i++)
        fprintf(out, "%s %.17g\n", cml_options_of_bits[i].name, provenance->value[i]);
}

/* Prints a form: its words, and behind them the value if the form ends in %g or %.0f. */
static void print_form(FILE *out, const char *form, double value)
{
    const size_t words = strcspn(form, "%");
    fprintf(out, "%.*s", (int)words, form);
    if (strcmp(form + words, "%.0f") == 0) fprintf(out, "%.0f", value);
    if (strcmp(form + words, "%g") == 0) fprintf(out, "%g", value);
}

/* Prints the comment line of an .mco that names the engine and the options that were not left at their
 * defaults. */
void cml_provenance_print(FILE *out, const struct cml_provenance *provenance)
{
    fprintf(out, "# engine %s", provenance->engine);
    for (int i = 0; i < CML_NUM_OPTIONS_OF_BITS; i++) {
        const struct cml_option_info *info = &cml_options_of_bits[i];
        const double value = provenance->value[i];
        if (!info->before || isnan(value) || !form_of(info, value)[0]) continue;
        fputs(info->before, out);
        print_form(out, form_of(info, value), value);
    }
    fputc('\n', out);
}
