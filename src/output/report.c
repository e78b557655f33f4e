/* SPDX-License-Identifier: MIT */
#include "output/report.h"

#include "base/version.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>

void cml_report_boundaries(FILE *stream, const char *prefix, const struct cml_scene *scene,
                           const struct cml_surface_set *surfaces)
{
    static const char *const unit_of[] = {"", "rings", "triangles"};
    for (int b = 0; b < surfaces->count; b++) {
        const struct cml_surface_def *def = &surfaces->item[b];
        fprintf(stream, "%sboundary %d: %s at z = %g cm", prefix, b, cml_surface_kind_name(def->kind),
                def->depth);
        if (def->kind != CML_SURFACE_PLANE)
            fprintf(stream, ", %llu %s", (unsigned long long)def->primitives, unit_of[def->kind]);
        fprintf(stream, " (%s)", def->reason);
        if (scene->boundaries[b].file) fprintf(stream, " from %s", scene->boundaries[b].file);
        fputc('\n', stream);
    }
}

static double steps_of(const struct cml_result *result)
{
    return (double)(result->summary.count[CML_COUNT_INTERACTIONS] +
                    result->summary.count[CML_COUNT_BOUNDARY_EVENTS]);
}

static void print_total(FILE *stream, const char *name, const struct cml_result *result, enum cml_total total)
{
    fprintf(stream, "  %-4s %.6f +- %.6f\n", name, cml_result_total(result, total),
            cml_result_error(result, total));
}

/* What happened that should be rare: one line each, only when it did. */
static void print_rarities(FILE *stream, const struct cml_result *result, uint32_t run_index)
{
    static const struct {
        enum cml_count count;
        const char *text;
    } rarities[] = {
        {CML_COUNT_TRAPPED, "packets trapped by total reflection in a clear medium"},
        {CML_COUNT_LOST_NO_SURFACE, "packets lost: no surface found"},
        {CML_COUNT_LOST_NAN, "packets lost: not a number"},
        {CML_COUNT_LOST_STUCK, "packets lost: stuck"},
        {CML_COUNT_LOST_LEAKED, "packets lost: leaked through a boundary"},
        {CML_COUNT_SHADING_OVERRULED, "boundary events where the facet overruled the shading normal"},
    };
    for (size_t i = 0; i < sizeof rarities / sizeof *rarities; i++)
        if (result->summary.count[rarities[i].count] > 0)
            fprintf(stream, "  %.0f %s\n", (double)result->summary.count[rarities[i].count],
                    rarities[i].text);
    for (int i = 0; i < result->summary.lost.count; i++)
        fprintf(stream, "  lost: clustermcml trace ... %llu --run %u\n",
                (unsigned long long)result->summary.lost.index[i], run_index + 1);
    const double overflow = cml_result_share(result, CML_BALANCE_OVERFLOW_R);
    if (overflow > 0)
        fprintf(stream, "  %.4g of the weight was scored beyond r = nr dr, in the last bin\n", overflow);
    const double below = cml_result_share(result, CML_BALANCE_OVERFLOW_Z);
    if (below > 0)
        fprintf(stream, "  %.4g of the weight was absorbed below z = nz dz, in the last bin\n", below);
    const double above = cml_result_share(result, CML_BALANCE_ABOVE);
    if (above > 0)
        fprintf(stream, "  %.4g of the weight was absorbed above z = 0, in the first bin\n", above);
}

void cml_report_summary(FILE *stream, const struct cml_report *report)
{
    const struct cml_result *result = &report->run->result;
    const double seconds = report->run->seconds, steps = steps_of(result);
    print_total(stream, "Rsp", result, CML_TOTAL_SPECULAR);
    print_total(stream, "Rd", result, CML_TOTAL_REFLECTED);
    print_total(stream, "A", result, CML_TOTAL_ABSORBED);
    print_total(stream, "Tt", result, CML_TOTAL_TRANSMITTED);
    fprintf(stream, "  books: residue %.17g, roulette +%.3g -%.3g, lost %llu\n", cml_result_imbalance(result),
            cml_result_share(result, CML_BALANCE_GAINED), cml_result_share(result, CML_BALANCE_ROULETTE),
            (unsigned long long)cml_result_lost(result));
    print_rarities(stream, result, report->run_index);
    fprintf(stream, "  %.3g s, %.3g photons/s, %.3g steps, %.3g ns/step on %d thread%s\n", seconds,
            (double)result->photons / seconds, steps, 1e9 * seconds / steps, report->run->threads,
            report->run->threads == 1 ? "" : "s");
}

void cml_report_ranks(FILE *stream, const struct cml_run_result *run)
{
    fprintf(stream, "  %4s %14s %8s %8s %8s %8s\n", "rank", "photons", "flying %", "idle %", "asking %",
            "sums %");
    for (int i = 0; i < run->ranks; i++) {
        const struct cml_rank_report *rank = &run->rank[i];
        const double percent = 100 / rank->elapsed;
        fprintf(stream, "  %4d %14llu %8.2f %8.2f %8.2f %8.2f\n", i, (unsigned long long)rank->photons,
                percent * rank->flying, percent * rank->waiting, percent * rank->asking,
                percent * rank->meeting);
    }
    fprintf(stream, "  all ranks: idle %.2f %%, communication %.2f %%\n", 100 * cml_run_idle(run),
            100 * cml_run_communication(run));
}

static json_t *boundaries_json(const struct cml_surface_set *surfaces)
{
    json_t *list = json_array();
    for (int b = 0; b < surfaces->count; b++) {
        const struct cml_surface_def *def = &surfaces->item[b];
        const struct cml_expectation *expect = &def->expectation;
        json_t *bias = isfinite(expect->bias) ? json_real(expect->bias) : json_null();
        json_array_append_new(list, json_pack("{s:s, s:s, s:I, s:f, s:f, s:o, s:f, s:f}", "kind",
                                              cml_surface_kind_name(def->kind), "reason", def->reason,
                                              "primitives", (json_int_t)def->primitives, "build_s",
                                              def->build_seconds, "MiB", def->bytes / 1048576, "bias", bias,
                                              "query_ns", expect->query_ns, "deviation", expect->deviation));
    }
    return list;
}

static json_t *files_json(const struct cml_report *report)
{
    json_t *list = json_array();
    for (int i = 0; i < report->num_files; i++) json_array_append_new(list, json_string(report->files[i]));
    return list;
}

static void set_real(json_t *object, const char *key, double value)
{
    json_object_set_new(object, key, json_real(value));
}

static void set_integer(json_t *object, const char *key, uint64_t value)
{
    json_object_set_new(object, key, json_integer((json_int_t)value));
}

static void set_results(json_t *object, const struct cml_report *report)
{
    const struct cml_result *result = &report->run->result;
    set_real(object, "Rsp", cml_result_total(result, CML_TOTAL_SPECULAR));
    set_real(object, "Rd", cml_result_total(result, CML_TOTAL_REFLECTED));
    set_real(object, "A", cml_result_total(result, CML_TOTAL_ABSORBED));
    set_real(object, "Tt", cml_result_total(result, CML_TOTAL_TRANSMITTED));
    set_real(object, "Rsp_se", cml_result_error(result, CML_TOTAL_SPECULAR));
    set_real(object, "Rd_se", cml_result_error(result, CML_TOTAL_REFLECTED));
    set_real(object, "A_se", cml_result_error(result, CML_TOTAL_ABSORBED));
    set_real(object, "Tt_se", cml_result_error(result, CML_TOTAL_TRANSMITTED));
    set_integer(object, "lost", cml_result_lost(result));
    set_integer(object, "trapped", (uint64_t)result->summary.count[CML_COUNT_TRAPPED]);
    set_integer(object, "shading_overruled", (uint64_t)result->summary.count[CML_COUNT_SHADING_OVERRULED]);
    set_real(object, "residue", cml_result_imbalance(result));
    set_real(object, "overflow_r", cml_result_share(result, CML_BALANCE_OVERFLOW_R));
}

static json_t *ranks_json(const struct cml_run_result *run)
{
    json_t *list = json_array();
    for (int i = 0; i < run->ranks; i++) {
        const struct cml_rank_report *rank = &run->rank[i];
        json_array_append_new(list, json_pack("{s:I, s:I, s:f, s:f, s:f, s:f}", "photons",
                                              (json_int_t)rank->photons, "ranges", (json_int_t)rank->ranges,
                                              "flying", rank->flying, "idle", rank->waiting, "asking",
                                              rank->asking, "sums", rank->meeting));
    }
    return list;
}

static void set_speed(json_t *object, const struct cml_report *report)
{
    const struct cml_run_result *run = report->run;
    const double steps = steps_of(&run->result);
    set_real(object, "seconds", run->seconds);
    set_real(object, "cpu_s", cml_run_processor(run));
    set_real(object, "steps", steps);
    set_real(object, "crossings", (double)run->result.summary.count[CML_COUNT_BOUNDARY_EVENTS]);
    set_real(object, "queries", (double)run->result.summary.count[CML_COUNT_QUERIES]);
    set_real(object, "ns_per_step", steps > 0 ? 1e9 * run->seconds / steps : 0);
    set_real(object, "photons_per_s", (double)run->result.photons / run->seconds);
    set_integer(object, "threads", (uint64_t)run->threads);
    set_integer(object, "ranks", (uint64_t)run->ranks);
    json_object_set_new(object, "rank_s", ranks_json(run));
    set_real(object, "idle", cml_run_idle(run));
    set_real(object, "communication", cml_run_communication(run));
}

cml_status cml_report_json(FILE *stream, const struct cml_report *report, struct cml_error *err)
{
    json_t *object = json_pack("{s:s, s:s, s:s}", "scene", report->scene->file, "output", report->files[0],
                               "engine", report->engine->name);
    if (!object) return cml_fail_memory(err, 1, "the JSON record (or a name that is not UTF-8)");
    set_integer(object, "photons", report->run->result.photons);
    set_integer(object, "seed", report->seed);
    json_object_set_new(object, "boundaries", boundaries_json(report->surfaces));
    json_object_set_new(object, "files", files_json(report));
    set_results(object, report);
    set_speed(object, report);
    json_object_set_new(object, "version", json_string(cml_version()));
    char *text = json_dumps(object, JSON_COMPACT);
    json_decref(object);
    if (!text) return cml_fail_memory(err, 1, "the JSON record");
    fprintf(stream, "%s\n", text);
    fflush(stream);
    free(text);
    return CML_OK;
}
