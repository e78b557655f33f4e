/* clustermcml crosscheck: flies the same photon indices with cones, as meshes and on OpenCL, and compares.
 * SPDX-License-Identifier: MIT */
#include "cli/command.h"

#include "base/atomic_file.h"
#include "base/json_name.h"
#include "base/text.h"
#include "base/version.h"
#include "result/quantity.h"
#include "run/cluster/cluster.h"
#include "run/crosscheck/crosscheck.h"
#include "engine/engines.h"

#include <stdio.h>
#include <stdlib.h>

struct dump {
    FILE *stream;
    const struct cml_check_setup *setup;
};

/* Writes a line for a packet that ends differently in two of the compared runs, for --dump. */
static void dump_packet(void *context, uint64_t photon, const struct cml_fate_record *records)
{
    const struct dump *dump = context;
    fprintf(dump->stream, "%llu", (unsigned long long)photon);
    for (int s = 0; s < dump->setup->num_sides; s++)
        fprintf(dump->stream, "  %-11s %8u %8u %.9f", cml_fate_name(records[s].fate), records[s].interactions,
                records[s].boundary_events, records[s].weight * CML_WEIGHT_UNIT);
    fputc('\n', dump->stream);
}

/* Writes the first lines of the dump: the scene, and the columns. */
static void dump_head(const struct dump *dump)
{
    const struct cml_check_setup *setup = dump->setup;
    fprintf(dump->stream,
            "# %s, seed %llu: photons whose fates or steps differ; each can be flown alone: "
            "clustermcml trace %s PHOTON\n# photon, then fate, interactions, boundary events and weight of",
            setup->scene->output, (unsigned long long)setup->options.seed, setup->scene->file);
    for (int s = 0; s < setup->num_sides; s++)
        fprintf(dump->stream, "%s %s", s ? ";" : "", setup->sides[s].name);
    fputc('\n', dump->stream);
}

/* Prints the totals of one of the compared runs. residue: what the energy balance of its packets leaves
 * over. */
static void print_side(const struct cml_check_side *side, const struct cml_result *result)
{
    printf("  %-12s Rsp %.6f  Rd %.6f +- %.6f  A %.6f +- %.6f  Tt %.6f +- %.6f  lost %llu, residue %.17g\n",
           side->name, cml_result_share(result, CML_BALANCE_SPECULAR),
           cml_result_share(result, CML_BALANCE_REFLECTED), cml_result_error(result, CML_TOTAL_REFLECTED),
           cml_result_share(result, CML_BALANCE_ABSORBED), cml_result_error(result, CML_TOTAL_ABSORBED),
           cml_result_share(result, CML_BALANCE_TRANSMITTED), cml_result_error(result, CML_TOTAL_TRANSMITTED),
           (unsigned long long)cml_result_lost(result), cml_result_imbalance(result));
}

/* True if the scene has a total of enum cml_total. */
static bool has_total(const struct cml_check_setup *setup, int total)
{
    const struct cml_scene *scene = setup->scene;
    return cml_has_total(total, scene->backing.kind != CML_BACKING_NONE, scene->num_contacts > 0);
}

/* Prints the comparison of side s with the first side, for people. */
static void print_pair(const struct cml_check_setup *setup, int s, const struct cml_check_pair *pair)
{
    const uint64_t differ = setup->photons - pair->equal;
    printf("%s against %s: %s\n", setup->sides[s].name, setup->sides[0].name,
           pair->agrees ? "agree" : "DISAGREE");
    printf("  equal fates and steps: %.6g %% (%llu of %llu packets differ%s)\n",
           100 * (double)pair->equal / (double)setup->photons, (unsigned long long)differ,
           (unsigned long long)setup->photons,
           setup->sides[s].same_geometry ? ", at most 0.01 % may" : "; another geometry");
    for (int t = 0; t < CML_NUM_TOTALS; t++)
        if (has_total(setup, t))
            printf("  %-3s %+.3e +- %.1e  z = %+.2f\n", cml_quantities[cml_quantity_of_total(t)].name,
                   pair->total[t].mean, pair->total[t].error, pair->total[t].z);
    if (pair->worst_profile)
        printf("  worst bin: %s[%d], z = %+.2f, of %d values\n", pair->worst_profile, pair->worst_bin,
               pair->worst_z, pair->values);
    else
        printf("  worst bin: none, all %d values are equal\n", pair->values);
}

/* Prints each run's totals, then how each run compares with the first. */
static void print_all(const struct cml_check_setup *setup, const struct cml_check_result *result,
                      double tolerance)
{
    printf("%s: %g photons, seed %llu, mesh at tolerance %g\n", setup->scene->output, (double)setup->photons,
           (unsigned long long)setup->options.seed, tolerance);
    for (int s = 0; s < setup->num_sides; s++) print_side(&setup->sides[s], &result->runs[s].result);
    for (int s = 1; s < setup->num_sides; s++) print_pair(setup, s, &result->pairs[s]);
}

/* ---- JSON ---- */

/* Returns the JSON object of a side: its totals, and their differences to the first side. */
static json_t *side_json(const struct cml_check_setup *setup, int s, const struct cml_check_result *result)
{
    const struct cml_result *sums = &result->runs[s].result;
    const struct cml_check_pair *pair = &result->pairs[s];
    json_t *side = json_pack("{s:s, s:I, s:f}", "name", setup->sides[s].name, "lost",
                             (json_int_t)cml_result_lost(sums), "residue", cml_result_imbalance(sums));
    json_t *differences = json_object();
    for (int t = 0; t < CML_NUM_TOTALS; t++) {
        if (!has_total(setup, t)) continue;
        const char *name = cml_quantities[cml_quantity_of_total(t)].name;
        const struct cml_check_total *total = &pair->total[t];
        json_object_set_new(side, name, cml_json_real(cml_result_total(sums, (enum cml_total)t)));
        json_object_set_new(side, CML_TEXT("%s_se", name),
                            cml_json_real(cml_result_error(sums, (enum cml_total)t)));
        json_object_set_new(differences, name,
                            json_pack("{s:o, s:o, s:o}", "mean", cml_json_real(total->mean), "error",
                                      cml_json_real(total->error), "z", cml_json_real(total->z)));
    }
    if (s == 0) {
        json_decref(differences);
        return side;
    }
    json_t *worst = !pair->worst_profile
                        ? json_null()
                        : json_pack("{s:s, s:i, s:o}", "quantity", pair->worst_profile, "bin",
                                    pair->worst_bin, "z", cml_json_real(pair->worst_z));
    json_t *more =
        json_pack("{s:b, s:I, s:i, s:o, s:o}", "agree", pair->agrees, "equal", (json_int_t)pair->equal,
                  "values", pair->values, "differences", differences, "worst", worst);
    json_object_update(side, more);
    json_decref(more);
    return side;
}

/* Prints the result of a cross-check as one JSON object with one element for each way of flying the
 * photons. */
static cml_status print_json(const struct cml_check_setup *setup, const struct cml_check_result *result,
                             double tolerance, struct cml_error *err)
{
    bool agree = true;
    json_t *ways = json_array();
    for (int s = 0; s < setup->num_sides; s++) {
        agree = agree && (s == 0 || result->pairs[s].agrees);
        json_array_append_new(ways, side_json(setup, s, result));
    }
    json_t *object =
        json_pack("{s:o, s:o, s:I, s:I, s:f, s:b, s:o, s:s}", "scene", cml_json_name(setup->scene->file),
                  "output", cml_json_name(setup->scene->output), "photons", (json_int_t)setup->photons,
                  "seed", (json_int_t)setup->options.seed, "tolerance", tolerance, "agree", agree, "ways",
                  ways, "version", cml_version());
    return cml_json_print(stdout, object, err);
}

/* Fails with CML_E_DIFFER if a side disagrees with the first. */
static cml_status verdict(const struct cml_check_setup *setup, const struct cml_check_result *result,
                          struct cml_error *err)
{
    int disagree = 0;
    for (int s = 1; s < setup->num_sides; s++) disagree += !result->pairs[s].agrees;
    if (!disagree) return CML_OK;
    return cml_fail(err, CML_E_DIFFER, "%s: %d of %d comparisons disagree", setup->scene->output, disagree,
                    setup->num_sides - 1);
}

/* Runs the cross-check, writes the dump of --dump, and prints the result. */
static cml_status check_and_dump(const struct cml_options *options, struct cml_check_setup *setup,
                                 struct cml_error *err)
{
    struct cml_file file = {0};
    struct dump dump = {NULL, setup};
    CML_AT_END(cml_check_clear) struct cml_check_result result = {0};
    if (options->dump) {
        CML_TRY(cml_file_create_alone(options->dump, &file, err));
        dump.stream = file.stream;
        dump_head(&dump);
        setup->on_difference = dump_packet;
        setup->context = &dump;
    }
    cml_status status = cml_crosscheck(setup, &result, err);
    if (status != CML_OK) {
        if (options->dump) cml_file_abort(&file);
        return status;
    }
    if (options->dump) status = cml_file_commit(&file, err);
    if (options->json && status == CML_OK)
        status = print_json(setup, &result, options->surface.tolerance, err);
    else if (!options->quiet && !options->json)
        print_all(setup, &result, options->surface.tolerance);
    return status == CML_OK ? verdict(setup, &result, err) : status;
}

/* True if any boundary or body is represented by this kind of surface. */
static bool has_kind(const struct cml_surface_set *surfaces, enum cml_surface_kind kind)
{
    for (int b = 0; b < surfaces->count; b++)
        if (surfaces->item[b].kind == kind) return true;
    for (int k = 0; k < surfaces->bodies.count; k++)
        if (surfaces->bodies.item[k].kind == kind) return true;
    return false;
}

/* Cross-checks a scene with its surfaces as chosen, as meshes, and on OpenCL. Meshes are left out if
 * they would be planes. If meshes are compared, all sides start their packets above boundary 0: a plane would
 * split the specular part off every packet, while a mesh reflects a few packets as a whole, and that
 * difference alone would look like an error. */
static cml_status check_surfaces(const struct cml_options *options, const struct cml_scene *scene, int index,
                                 const struct cml_surface_set *chosen, const struct cml_surface_set *meshes,
                                 struct cml_error *err)
{
    const struct cml_engine *cpu = cml_engine_find("cpu"), *opencl = cml_engine_find("opencl");
    struct cml_check_setup setup = {.scene = scene,
                                    .options = options->engine_options,
                                    .photons = options->photons ? options->photons : scene->photons,
                                    .num_sides = 1,
                                    .sides = {{"cpu (cones)", cpu, chosen, true}}};
    setup.options.run = (uint32_t)index;
    if (!has_kind(chosen, CML_SURFACE_CONE))
        setup.sides[0].name = chosen->bodies.count > 0 ? "cpu (bodies)" : "cpu (planes)";
    if (has_kind(meshes, CML_SURFACE_MESH)) {
        setup.sides[setup.num_sides++] = (struct cml_check_side){"cpu (mesh)", cpu, meshes, false};
        setup.options.start_as = meshes;
    }
    setup.sides[setup.num_sides++] = (struct cml_check_side){"opencl", opencl, chosen, true};
    return check_and_dump(options, &setup, err);
}

/* Checks a scene without map, volume, facets and times: they are not compared, and the opencl engine would
 * refuse them. */
static cml_status check_scene(const struct cml_options *options, const struct cml_scene *whole, int index,
                              struct cml_error *err)
{
    struct cml_scene bare = *whole;
    cml_scene_ask_nothing(&bare);
    const struct cml_scene *scene = &bare;
    CML_AT_END(cml_surfaces_free) struct cml_surface_set chosen = {0}, meshes = {0};
    struct cml_surface_options as_mesh = options->surface;
    as_mesh.force = CML_SURFACE_MESH;
    CML_TRY(cml_choose_surfaces(options, scene, &chosen, err));
    CML_TRY(cml_surfaces_create(scene, &as_mesh, &meshes, err));
    return check_surfaces(options, scene, index, &chosen, &meshes, err);
}

/* Runs `crosscheck`: flies the same photons in several ways (engines, meshes instead of exact shapes) and
 * compares packet by packet. The comparison keeps all packets in one process. */
cml_status cml_command_crosscheck(const struct cml_options *options, struct cml_error *err)
{
    CML_AT_END(cml_scene_list_clear) struct cml_scene_list list = {0};
    if (cml_cluster_size() > 1)
        return cml_fail(err, CML_E_INPUT, "crosscheck: %d ranks (expected one process)", cml_cluster_size());
    CML_TRY(cml_load_scenes(options, NULL, &list, err));
    if (options->dump && list.count > 1)
        return cml_fail(err, CML_E_INPUT, "crosscheck: %s has %d runs (expected one with --dump)",
                        options->operands[0], list.count);
    for (int i = 0; i < list.count; i++) CML_TRY(check_scene(options, &list.scenes[i], i, err));
    return CML_OK;
}
