/* clustermcml trace: prints every event of one photon, on any engine. SPDX-License-Identifier: MIT */
#include "cli/command.h"

#include "base/text.h"
#include "output/report.h"
#include "tally/deal.h"
#include "types.h"

#include <stdio.h>
#include <string.h>

struct listener {
    const struct cml_scene *scene;
    long row;
};

/* Returns the words in front of a face or port. */
static const char *words_of(const char *what)
{
    return strcmp(what, "stop") == 0 ? "stopped by " : strcmp(what, "through") == 0 ? "through " : "";
}

/* Prints an event with nine digits and more, because events of one photon are compared between engines and
 * machines. */
static void print_event(void *context, const struct cml_trace_event *event)
{
    struct listener *listener = context;
    if (strcmp(event->what, "detect") == 0) {
        printf("# seen by %s, %.9g of a packet\n", listener->scene->detectors[event->detector].name,
               event->weight);
        return;
    }
    if (strcmp(event->what, "rough") == 0) {
        printf("# rough: %d step%s\n", event->steps, event->steps == 1 ? "" : "s");
        return;
    }
    if (event->contact > 0) {
        char name[CML_CONTACT_NAME];
        cml_contact_name(listener->scene, event->contact, name);
        printf("# %s%s\n", words_of(event->what), name);
        return;
    }
    printf("%6ld  %-8s %6d  %15.9g %15.9g %15.9g  %12.9f %12.9f %12.9f  %.9g\n", listener->row++, event->what,
           event->medium, event->position[0], event->position[1], event->position[2], event->direction[0],
           event->direction[1], event->direction[2], event->weight);
}

/* Notes a photon that the scene does not have. It is flown anyway, because a run may have had more photons.
 */
static cml_status note_beyond(const struct cml_scene *scene, uint64_t photon, struct cml_error *err)
{
    CML_AT_END(cml_deal_clear) struct cml_deal deal = {0};
    CML_TRY(cml_deal_create(scene->shares, scene->num_beams, &deal, err));
    CML_TRY(cml_deal_round(&deal, 0, scene->photons, err));
    if (cml_deal_has(&deal, photon)) return CML_OK;
    const unsigned long long photons = scene->photons;
    cml_note("photon %llu is not among those of %.300s (%s, unless --photons says more)",
             (unsigned long long)photon, scene->output,
             scene->num_beams == 1 ? CML_TEXT("0 to %llu", photons - 1)
                                   : CML_TEXT("%llu of %d beams, those of beam k from (k - 1) 2^48 on",
                                              photons, scene->num_beams));
    return CML_OK;
}

/* Prints the trace. Lines that are not events begin with #, so that other programs can read the table. */
static cml_status trace(const struct cml_options *options, const struct cml_scene *scene, void *engine,
                        uint64_t photon, struct cml_error *err)
{
    struct cml_fate_record record;
    struct listener listener = {scene, 0};
    printf("# %s, photon %llu, %s engine, seed %llu\n", scene->output, (unsigned long long)photon,
           options->engine->name, (unsigned long long)options->engine_options.seed);
    cml_report_phases(stdout, "# ", scene, CML_READ_BY_PEOPLE);
    cml_report_top(stdout, "# ", scene, CML_READ_BY_PEOPLE);
    const uint64_t beam = scene->num_beams > 1 ? photon >> CML_SOURCE_SHIFT : 0;
    if (beam >= (uint64_t)scene->num_beams)
        return cml_fail(err, CML_E_INPUT,
                        "trace: photon %llu (expected an index of one of %d beams: that of beam k begins at "
                        "(k - 1) 2^48)",
                        (unsigned long long)photon, scene->num_beams);
    CML_TRY(note_beyond(scene, photon, err));
    if (scene->beams[beam].given) cml_report_beam(stdout, "# ", scene, (int)beam, NULL);
    printf("#%5s  %-8s %6s  %15s %15s %15s  %12s %12s %12s  %s\n", "event", "what", "medium", "x cm", "y cm",
           "z cm", "ux", "uy", "uz", "weight");
    CML_TRY(options->engine->trace(engine, photon, print_event, &listener, &record, err));
    printf("# %s", cml_fate_name(record.fate));
    if (record.fate == CML_FATE_LOST) printf(" (%s)", cml_lost_cause_name(record.cause));
    printf(" after %u interactions and %u boundary events", record.interactions, record.boundary_events);
    if (record.boundary_events > 0)
        printf(", last outside contact at x = %.9g, y = %.9g cm", record.exit[0], record.exit[1]);
    putchar('\n');
    return CML_OK;
}

/* Traces a photon in one run. Users count runs from 1. The number is part of each photon's random stream, so
 * it must be that of the file. */
static cml_status trace_scene(const struct cml_options *options, const struct cml_scene *scene,
                              uint64_t photon, struct cml_error *err)
{
    CML_AT_END(cml_surfaces_free) struct cml_surface_set surfaces = {0};
    struct cml_engine_options engine_options = options->engine_options;
    void *engine = NULL;
    engine_options.run = (uint32_t)options->run - 1;
    CML_TRY(cml_choose_surfaces(options, scene, &surfaces, err));
    cml_status status = options->engine->open(scene, &surfaces, &engine_options, &engine, err);
    if (status == CML_OK) status = trace(options, scene, engine, photon, err);
    options->engine->close(engine);
    return status;
}

/* Runs `trace`: flies one photon and prints its events. The photon's number is checked before the scene is
 * read, which may take long. */
cml_status cml_command_trace(const struct cml_options *options, struct cml_error *err)
{
    uint64_t photon = 0;
    if (!cml_parse_count(options->operands[1], &photon))
        return cml_fail(err, CML_E_INPUT, "trace: photon %s (expected an index from 0)",
                        options->operands[1]);
    CML_AT_END(cml_scene_list_clear) struct cml_scene_list list = {0};
    CML_TRY(cml_load_scenes(options, NULL, &list, err));
    if (options->run > (uint64_t)list.count)
        return cml_fail(err, CML_E_INPUT, "--run %llu (expected 1 to %d, the runs of %s)",
                        (unsigned long long)options->run, list.count, options->operands[0]);
    return trace_scene(options, &list.scenes[options->run - 1], photon, err);
}
