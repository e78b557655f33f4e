/* SPDX-License-Identifier: MIT */
#include "result/head.h"

#include "base/text.h"
#include "output/files/hdf5_head.h"
#include "result/mco_sections.h"

#include <ctype.h>
#include <math.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

/* ---- .mco ---- */

/* An .mco whose lines are read one after the other. */
struct reader {
    struct cml_text text;
    struct cml_head *head;
    /* Numbers in MCML's sections: `expected` by the sizes in the head, and `numbers` that were found. */
    double expected, numbers;
    int keys;     /* number of section names until now */
    bool classic; /* the file is from --classic: it ends behind MCML's sections, without a mark */
};

/* Returns the next line of an .mco that holds more than a comment; NULL at the end. On the way, notes the
 * run's identity, which stands in the comment with the user time. */
static char *next_line(struct reader *r)
{
    char *line;
    while ((line = cml_text_next(&r->text)) != NULL) {
        const char *sum = strstr(line, CML_MCO_IDENTITY);
        if (sum && strncmp(line, "# User time:", 12) == 0) {
            snprintf(r->head->identity, CML_IDENTITY_SUM, "%s", sum + strlen(CML_MCO_IDENTITY));
            r->classic = !strstr(line, CML_MCO_HAS_END);
        }
        const char first = line[strspn(line, " \t\r")];
        if (first && first != '#') break;
    }
    return line;
}

/* Reads the next word of a line as a whole number above 0; false if there is none. */
static bool next_count(char **line, uint64_t *count)
{
    const char *word = *line ? cml_text_word(line) : NULL;
    return word && cml_parse_count(word, count) && *count > 0;
}

/* True if a section name is the next one expected: RAT, then those of cml_mco_sections, then any. */
static bool is_next_key(struct reader *r, const char *word)
{
    const int i = r->keys++;
    if (i > CML_MCO_SECTIONS) return true;
    return strcmp(word, i == 0 ? "RAT" : cml_quantities[cml_mco_sections[i - 1].quantity].name) == 0;
}

/* Cuts off a comment, which begins at the start of a word. Returns false if the comment begins like a number:
 * this program writes no such comment, so the file is damaged. */
static bool cut_comment(char *line)
{
    char *mark = strchr(line, '#');
    while (mark && mark > line && !strchr(" \t", mark[-1])) mark = strchr(mark + 1, '#');
    const bool good = !mark || !strchr(".0123456789", mark[1]); /* strchr finds '\0', too */
    if (mark) *mark = '\0';
    return good;
}

/* True if a line of an .mco holds only numbers and a comment, which shows that it is undamaged, or the name
 * of the next section. Counts the numbers of the sections that must be complete. */
static bool is_sound(struct reader *r, char *line, bool may_be_key)
{
    double number;
    if (!line || !cut_comment(line)) return false;
    char *word = cml_text_word(&line);
    if (word && may_be_key && isalpha((unsigned char)*word) && strcasecmp(word, "nan") != 0)
        return is_next_key(r, word) && !cml_text_word(&line);
    for (; word; word = cml_text_word(&line)) {
        if (!cml_parse_double(word, &number) && strcasecmp(word, "nan") != 0) return false;
        if (r->keys > 0 && r->keys <= 1 + CML_MCO_SECTIONS) r->numbers++;
    }
    return true;
}

/* Reads the head of an .mco up to the number of layers; false if it is none. The line behind the file name
 * holds the number of photons. */
static bool read_head(struct reader *r)
{
    uint64_t nz, nr, na, layers;
    char *line = next_line(r), *word = line ? cml_text_word(&line) : NULL;
    if (!word || (strcmp(word, "A1") != 0 && strcmp(word, "B1") != 0)) return false;
    line = next_line(r);
    word = line ? cml_text_word(&line) : NULL;
    if (!word || (strcmp(word, "InParm") != 0 && strcmp(word, "InParam") != 0) || !next_line(r)) return false;
    line = next_line(r);
    if (!next_count(&line, &r->head->photons) || !is_sound(r, next_line(r), false)) return false;
    line = next_line(r);
    if (!next_count(&line, &nz) || !next_count(&line, &nr) || !next_count(&line, &na)) return false;
    line = next_line(r);
    if (!next_count(&line, &layers)) return false;
    const double z = (double)nz, ring = (double)nr, angle = (double)na;
    r->expected = CML_TOTALS + (double)layers + z + 2 * ring + 2 * angle + ring * z + 2 * ring * angle;
    return true;
}

/* True if the rest of an .mco is complete: every line sound, all sections and numbers there, and the mark of
 * the end as the last line. Files of --classic have no such mark. */
static bool is_whole(struct reader *r)
{
    bool may_be_key = false;
    char *line;
    while ((line = cml_text_next(&r->text)) != NULL && strcmp(line, CML_MCO_END) != 0) {
        const bool separates = *line == '\0' || *line == '#';
        if (!is_sound(r, line, may_be_key)) return false;
        may_be_key = separates;
    }
    if (r->keys <= CML_MCO_SECTIONS || r->numbers != r->expected) return false;
    if (r->text.cursor > r->text.size) return false; /* the last line ends with a line feed, too */
    if (r->classic) return !line;
    if (!line) return false;
    const char *behind = r->text.data + r->text.cursor;
    return behind[strspn(behind, " \t\r\n")] == '\0';
}

/* True if a file has no control characters besides tabs and ends of lines; a binary file would have some. */
static bool is_text(const struct cml_text *text)
{
    for (size_t i = 0; i < text->size; i++)
        if (iscntrl((unsigned char)text->data[i]) && !strchr("\t\r\n", text->data[i])) return false;
    return true;
}

/* Reads the head of an .mco; false if it is none. A file without an identity is not checked beyond its
 * head. */
static bool read_mco(const char *path, struct cml_head *head)
{
    struct reader r = {.head = head};
    struct cml_error ignored;
    if (cml_text_read(NULL, path, &r.text, &ignored) != CML_OK) return false;
    const bool good = is_text(&r.text) && read_head(&r) && (!head->identity[0] || is_whole(&r));
    cml_text_clear(&r.text);
    return good;
}

/* ---- .h5 ---- */

/* Reads the number of photons and the identity of an .h5 result. Refuses a photon number that is no whole
 * number below 2^53, above which a double cannot hold every whole number. */
static bool read_h5(const char *path, struct cml_head *head)
{
    struct cml_hdf5_head found;
    const char *names[CML_NUM_QUANTITIES];
    for (int i = 0; i < CML_NUM_QUANTITIES; i++) names[i] = cml_quantities[i].name;
    if (!cml_hdf5_read_head(path, names, CML_NUM_QUANTITIES, &found)) return false;
    if (!(found.photons >= 1 && found.photons <= 0x1p53 && found.photons == floor(found.photons)))
        return false;
    if (found.has_totals) head->photons = (uint64_t)found.photons;
    snprintf(head->identity, sizeof head->identity, "%s", found.identity);
    return true;
}

bool cml_head_read(const char *path, struct cml_head *head)
{
    struct stat about;
    *head = (struct cml_head){0};
    if (stat(path, &about) != 0 || !S_ISREG(about.st_mode)) return false;
    return cml_file_ends_in(path, ".h5") ? read_h5(path, head) : read_mco(path, head);
}
