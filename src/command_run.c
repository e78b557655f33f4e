/* clustermcml run: every run of a file, one result each.
 * SPDX-License-Identifier: MIT */
#include "command.h"

#include "report.h"
#include "text.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Progress goes to standard error: a bar that redraws itself on a terminal, a line every tenth elsewhere. */
struct display {
    bool quiet, terminal;
    int tenths; /* lines printed so far */
};

static void draw_bar(const struct cml_progress *p)
{
    char bar[31];
    const double share = (double)p->done / (double)p->total, speed = (double)p->done / p->seconds;
    const int full = (int)(share * (sizeof bar - 1));
    for (int i = 0; i < (int)sizeof bar - 1; i++) bar[i] = i < full ? '#' : '.';
    bar[sizeof bar - 1] = '\0';
    fprintf(stderr, "\r[%s] %3.0f %%  %.3g photons/s  %.0f s left   ", bar, 100 * share, speed,
            (double)(p->total - p->done) / speed);
    if (p->done == p->total) fprintf(stderr, "\r\033[K");
    fflush(stderr);
}

static void show_progress(void *context, const struct cml_progress *p)
{
    struct display *display = context;
    if (display->quiet) return;
    if (display->terminal) {
        draw_bar(p);
        return;
    }
    const int tenths = (int)(10 * p->done / p->total);
    if (tenths <= display->tenths || p->seconds < 10) return;
    display->tenths = tenths;
    fprintf(stderr, "%d %%, %.0f s\n", 10 * tenths, p->seconds);
}

static cml_status write_result(const struct cml_report *report, struct cml_error *err)
{
    struct cml_mco mco;
    CML_TRY(cml_report_mco(report, &mco, err));
    const cml_status status = cml_mco_write(report->output, &mco, err);
    cml_mco_clear(&mco);
    return status;
}

static cml_status publish(const struct cml_options *options, struct cml_report *report, struct cml_error *err)
{
    char *path = NULL;
    CML_TRY(cml_output_path(options, report->scene->output, &path, err));
    report->output = path;
    cml_status status = write_result(report, err);
    if (status == CML_OK && options->json) status = cml_report_json(stdout, report, err);
    if (status == CML_OK && !options->quiet && !options->json) {
        cml_report_summary(stdout, report);
        printf("  -> %s\n", path);
    }
    free(path);
    return status == CML_OK ? cml_run_verdict(report->scene, &report->run->result, err) : status;
}

static void announce(const struct cml_options *options, const struct cml_run_setup *setup)
{
    if (options->quiet || options->json) return;
    const struct cml_scene *scene = setup->scene;
    printf("%s: %g photons, %d layer%s, %s engine, seed %llu%s\n", scene->output, (double)setup->photons,
           scene->num_layers, scene->num_layers == 1 ? "" : "s", setup->engine->name,
           (unsigned long long)setup->options.seed,
           scene->format == 'B' ? " (format B is written as ASCII)" : "");
    cml_report_boundaries(stdout, "  ", scene, setup->surfaces);
    fflush(stdout);
}

static cml_status fly(const struct cml_options *options, const struct cml_scene *scene, int index,
                      const struct cml_surface_set *surfaces, struct cml_error *err)
{
    struct display display = {.quiet = options->quiet || options->json, .terminal = isatty(STDERR_FILENO)};
    struct cml_run_setup setup = {.scene = scene,
                                  .surfaces = surfaces,
                                  .engine = options->engine,
                                  .options = options->engine_options,
                                  .photons = options->photons ? options->photons : scene->photons,
                                  .on_progress = show_progress,
                                  .context = &display};
    struct cml_run_result run;
    setup.options.run = (uint32_t)index;
    announce(options, &setup);
    CML_TRY(cml_run(&setup, &run, err));
    struct cml_report report = {.scene = scene,
                                .surfaces = surfaces,
                                .run = &run,
                                .engine = options->engine,
                                .seed = options->engine_options.seed,
                                .run_index = (uint32_t)index,
                                .reentry = options->engine_options.reentry};
    const cml_status status = publish(options, &report, err);
    cml_run_result_free(&run);
    return status;
}

static cml_status run_scene(const struct cml_options *options, const struct cml_scene *scene, int index,
                            struct cml_error *err)
{
    struct cml_surface_set surfaces;
    CML_TRY(cml_surfaces_create(scene, &options->surface, &surfaces, err));
    const cml_status status = fly(options, scene, index, &surfaces, err);
    cml_surfaces_free(&surfaces);
    return status;
}

static cml_status check_memory(const struct cml_options *options, const struct cml_scene *scene,
                               struct cml_error *err)
{
    const struct cml_grid grid = cml_run_grid(scene, options->engine_options.absorption);
    const int threads = options->engine_options.threads > 0 ? options->engine_options.threads : 1;
    const double bytes = cml_run_bytes(&grid, threads), gib = 1073741824.0;
    const double memory = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    if (bytes < memory) return CML_OK;
    return cml_fail(err, CML_E_INPUT,
                    "%s: the tallies take %.3g GiB (expected at most this machine's %.3g GiB)", scene->file,
                    bytes / gib, memory / gib);
}

/* Found before the photons fly, not after: an output that cannot be written, a grid that does not fit. */
static cml_status check_outputs(const struct cml_options *options, const struct cml_scene_list *list,
                                struct cml_error *err)
{
    for (int i = 0; i < list->count; i++) {
        CML_TRY(check_memory(options, &list->scenes[i], err));
        char *path = NULL;
        struct cml_file file;
        CML_TRY(cml_output_path(options, list->scenes[i].output, &path, err));
        const cml_status status = cml_file_create(path, &file, err);
        free(path);
        CML_TRY(status);
        cml_file_abort(&file);
    }
    return CML_OK;
}

cml_status cml_command_run(const struct cml_options *options, struct cml_error *err)
{
    struct cml_scene_list list;
    CML_TRY(cml_load_scenes(options, &list, err));
    cml_status status = check_outputs(options, &list, err);
    if (status == CML_OK && !options->quiet && !options->json) printf("clustermcml %s\n", cml_version());
    for (int i = 0; status == CML_OK && i < list.count; i++)
        status = run_scene(options, &list.scenes[i], i, err);
    cml_scene_list_clear(&list);
    return status;
}
