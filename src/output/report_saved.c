/* Writes the file of saved packets (P18): one array for each of their properties. SPDX-License-Identifier:
 * MIT */
#include "output/report_parts.h"

#include "base/text.h"
#include "result/h5.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* The type of a property in memory. */
enum type { TYPE_FLOAT, TYPE_COUNT };

/* A property of packets, an array of the file. at: offset in a row; for a property of media, the number of
 * its block behind the row. */
static const struct property {
    const char *name, *long_name, *units;
    enum type type;
    size_t at;
    double unit;
    bool of_medium, whole; /* one value per medium; written in double precision */
} properties[] = {
#define ROW(member) offsetof(struct cml_saved_row, member)
    {"weight", "weight with which it left", "1", TYPE_COUNT, ROW(weight), CML_WEIGHT_UNIT, false, true},
    {"x", "where it touched a surface last", "cm", TYPE_FLOAT, ROW(place[0]), 1, false, false},
    {"y", "where it touched a surface last", "cm", TYPE_FLOAT, ROW(place[1]), 1, false, false},
    {"z", "where it touched a surface last", "cm", TYPE_FLOAT, ROW(place[2]), 1, false, false},
    {"ux", "direction", "1", TYPE_FLOAT, ROW(direction[0]), 1, false, false},
    {"uy", "direction", "1", TYPE_FLOAT, ROW(direction[1]), 1, false, false},
    {"uz", "direction", "1", TYPE_FLOAT, ROW(direction[2]), 1, false, false},
    {"path", "length of its way in every medium", "cm", TYPE_FLOAT, 0, 1, true, false},
    {"interactions", "interactions in every medium", "1", TYPE_COUNT, 1, 1, true, false},
    {"momentum", "sum of 1 - cosine of scatterings in every medium", "1", TYPE_FLOAT, 2, 1, true, false},
    {"touches", "boundaries and bodies met", "1", TYPE_COUNT, ROW(touches), 1, false, false},
    {"deepest", "largest depth", "cm", TYPE_FLOAT, ROW(deepest), 1, false, false},
    {"time", "time of flight", "ps", TYPE_FLOAT, ROW(optical), 1 / CML_LIGHT_CM_PER_PS, false, false},
    {"side", "0: top, 1: bottom, 2: top, and it never was in the material", "1", TYPE_COUNT, ROW(side), 1,
     false, false},
    {"detector", "number of the first that saw it, 0: none", "1", TYPE_COUNT, ROW(detector), 1, false, false},
};
enum { NUM_PROPERTIES = sizeof properties / sizeof *properties };

/* A property and the packets that it is read from. */
struct column {
    const struct cml_saved *saved;
    const struct property *property;
};

/* Copies `count` numbers out of rows: `each` numbers side by side in a row, beginning with number m of the
 * row at `at`. Inlined, so that there is a loop for each type. */
static inline __attribute__((always_inline)) void gather(const char *at, size_t stride, size_t m, size_t each,
                                                         size_t count, enum type type, double unit,
                                                         double *out)
{
    for (size_t i = 0; i < count; i++) {
        out[i] = unit * (type == TYPE_FLOAT ? (double)((const float *)at)[m] : ((const uint32_t *)at)[m]);
        if (++m < each) continue;
        m = 0;
        at += stride;
    }
}

/* Gives one property of all saved packets as a column. It is one of the functions cml_field_values that
 * writers call block by block. */
static void column_values(const void *context, size_t begin, size_t count, double *out)
{
    const struct column *c = context;
    const struct property *p = c->property;
    const size_t media = cml_saved_media(c->saved), each = p->of_medium ? media : 1, m = begin % each;
    const size_t first = p->of_medium ? sizeof(struct cml_saved_row) + p->at * media * sizeof(float) : p->at;
    const char *const at = (const char *)cml_saved_row(c->saved, begin / each) + first;
    const size_t stride = cml_saved_row_bytes(media);
    if (p->type == TYPE_FLOAT) gather(at, stride, m, each, count, TYPE_FLOAT, p->unit, out);
    if (p->type == TYPE_COUNT) gather(at, stride, m, each, count, TYPE_COUNT, p->unit, out);
}

/* Writes the .h5 of saved packets: attributes of the run, and one array for each property of packets.
 * indices: the packets' numbers, which are the axis of the arrays; kept: how many were found and kept. */
static cml_status write(const struct cml_report *report, const char *path, const struct cml_saved_sums *kept,
                        double *indices, struct cml_error *err)
{
    const struct cml_result *sums = report->sums;
    const struct cml_saved_def *saved = &report->scene->saved;
    const struct cml_h5_more more = {.input = report->scene->text};
    const struct cml_hdf5_call call = {report->command, report->scene->file};
    const struct cml_axis index = {.name = "index",
                                   .long_name = "number of the packet, for trace",
                                   .units = "1",
                                   .n = kept->kept,
                                   .values = indices},
                          medium = {.name = "medium",
                                    .long_name = "medium: above, layers, below, bodies",
                                    .units = "1",
                                    .n = cml_saved_media(sums->saved),
                                    .step = 1};
    struct cml_attribute attributes[CML_H5_MOST_ATTRIBUTES + 4];
    struct cml_field fields[NUM_PROPERTIES];
    struct column columns[NUM_PROPERTIES];
    int n = cml_h5_attributes(&report->outcome, &more, attributes);
    attributes[n++] = (struct cml_attribute){"covers", NULL, (double)report->covers};
    attributes[n++] = (struct cml_attribute){"found", NULL, (double)kept->found};
    attributes[n++] = (struct cml_attribute){"limit", NULL, (double)saved->limit};
    attributes[n++] = (struct cml_attribute){"detected", NULL, saved->detected};
    /* without detectors the last property is left out */
    const int num_fields = NUM_PROPERTIES - (report->scene->num_detectors == 0);
    for (int i = 0; i < num_fields; i++) {
        const struct property *p = &properties[i];
        columns[i] = (struct column){sums->saved, p};
        fields[i] = (struct cml_field){.long_name = p->long_name,
                                       .units = p->units,
                                       .num_axes = p->of_medium ? 2 : 1,
                                       .axis = {&index, &medium},
                                       .single = !p->whole,
                                       .plain = true,
                                       .values = column_values,
                                       .context = &columns[i]};
        strcpy(fields[i].name, p->name);
    }
    return cml_hdf5_write(path, attributes, n, &call, fields, num_fields, err);
}

/* Writes one row per packet, in rising order of index. */
cml_status cml_report_write_saved(struct cml_report *report, const char *path, struct cml_error *err)
{
    struct cml_saved *saved = report->sums->saved;
    const struct cml_saved_sums kept = cml_saved_sort(saved);
    CML_TRY(cml_report_words(report, CML_READ_IN_H5, err));
    CML_FREED double *indices = NULL;
    CML_TRY(cml_zeros(&indices, kept.kept, sizeof *indices, "saved photons", err));
    for (size_t i = 0; i < kept.kept; i++) indices[i] = (double)cml_saved_row(saved, i)->index;
    return write(report, path, &kept, indices, err);
}

cml_status cml_report_saved_path(const struct cml_scene *scene, const char *path, char **result,
                                 struct cml_error *err)
{
    const char *slash = strrchr(path, '/');
    const int folder = slash ? (int)(slash + 1 - path) : 0;
    return cml_text_format(result, "a path", err, "%.*s%s.photons.h5", folder, path, scene->saved.name);
}

/* Returns the bytes that a file of saved packets takes at most. Each packet has an index (8 bytes) and its
 * properties: 8 bytes for whole numbers, 4 for others, once or once for each medium. */
double cml_saved_file_bytes(const struct cml_saved_kind *kind)
{
    double row = sizeof(double);
    for (int i = 0; i < NUM_PROPERTIES; i++)
        row += (properties[i].whole ? 8.0 : 4.0) * (properties[i].of_medium ? (double)kind->media : 1);
    return (double)kind->limit * row;
}
