/* Runs one method on a scene for the atlas of stability: atlas SCENE.mci METHOD AIM[,AIM...] CROSSINGS
 * [SECONDS [FLIGHTS]].
 *
 * Simulates the scene's first run with packets aimed as asked (face, edge, vertex, drop, along, or an angle
 * in rad). Each aim ends when CROSSINGS boundaries are crossed, when FLIGHTS (20) are flown for each of
 * them, or after SECONDS (0: no limit). Prints for each aim:
 * crossings,lost,wrong,missed,spurious,nan,trapped,flights,cause. Exit code 2 with a message if the program
 * refuses the scene or the method cannot represent it.
 * SPDX-License-Identifier: MIT */
#include "atlas.h"
#include "engine/cpu/engine_cpu.h"
#include "input/mci.h"
#include "scene/body/body_place.h"

struct method {
    const char *name;
    enum cml_surface_kind force;
    bool in_double;
};

static const struct method methods[] = {
    {"reference", CML_SURFACE_AUTO, true},      {"cpu", CML_SURFACE_AUTO, false},
    {"reference-cone", CML_SURFACE_CONE, true}, {"cpu-cone", CML_SURFACE_CONE, false},
    {"reference-mesh", CML_SURFACE_MESH, true}, {"cpu-mesh", CML_SURFACE_MESH, false},
    {"cpu-plane", CML_SURFACE_PLANE, false},
};

static const char *const aims[NUM_AIMS] = {"face", "edge", "vertex", "drop", "along", "graze"};

static const struct method *find_method(const char *name)
{
    for (int i = 0; i < COUNT(methods); i++)
        if (strcmp(methods[i].name, name) == 0) return &methods[i];
    return NULL;
}

static bool find_aim(const char *name, struct atlas_flight *flight)
{
    for (int i = 0; i < AIM_GRAZE; i++)
        if (strcmp(aims[i], name) == 0) {
            flight->aim = (enum aim_kind)i;
            return true;
        }
    flight->aim = AIM_GRAZE;
    flight->angle = atof(name);
    return flight->angle > 0;
}

/* Returns the walk of the fastest level of the processor that this machine can run. */
static atlas_fly *find_walk(bool in_double)
{
#ifdef ATLAS_X86_LEVELS
    struct cml_cpu_level levels[CML_CPU_LEVELS];
    const int count = cml_cpu_levels(levels);
    for (int i = 0; i < count; i++)
        if (strcmp(levels[i].name, "x86-64-v3") == 0)
            return in_double ? atlas_fly_double_v3 : atlas_fly_float_v3;
#endif
    return in_double ? atlas_fly_double_base : atlas_fly_float_base;
}

static void print_count(const struct atlas_count *count)
{
    printf("%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%s\n", (unsigned long long)count->crossings,
           (unsigned long long)count->lost, (unsigned long long)count->wrong,
           (unsigned long long)count->missed, (unsigned long long)count->spurious,
           (unsigned long long)count->nan, (unsigned long long)count->trapped,
           (unsigned long long)count->steps, count->lost ? cml_lost_cause_name(count->lost_cause) : "");
}

/* Prints one line of counts for each aim in the comma-separated names. */
static cml_status fly_aims(const struct method *method, char *names, struct atlas_flight *flight,
                           struct cml_error *err)
{
    struct atlas_count count;
    for (char *name = strtok(names, ","); name; name = strtok(NULL, ",")) {
        if (!find_aim(name, flight))
            return cml_fail(err, CML_E_INPUT,
                            "%s is no aim (expected face, edge, vertex, drop, along or an angle in rad)",
                            name);
        CML_TRY(find_walk(method->in_double)(flight, &count, err));
        print_count(&count);
    }
    return CML_OK;
}

static cml_status fly(const struct method *method, char *aims_flown, struct atlas_flight *flight,
                      struct cml_error *err)
{
    const struct cml_surface_options options = {
        .force = method->force, .tessellation = {.tolerance = 1e-3, .normals = CML_NORMALS_ANALYTIC}};
    struct cml_surface_set surfaces;
    CML_TRY(cml_surfaces_create(flight->scene, &options, &surfaces, err));
    struct oracle *oracle = calloc((size_t)surfaces.count, sizeof *oracle);
    if (!oracle) return cml_fail_memory(err, (double)sizeof *oracle, "the oracle");
    for (int b = 0; b < surfaces.count; b++) oracle_create(&surfaces.item[b], &oracle[b]);
    struct oracle_bodies bodies;
    oracle_bodies_create(flight->scene, &surfaces.bodies, &bodies);
    flight->surfaces = &surfaces;
    flight->oracle = oracle;
    flight->bodies = &bodies;
    const cml_status status = fly_aims(method, aims_flown, flight, err);
    oracle_bodies_free(&bodies);
    for (int b = 0; b < surfaces.count; b++) oracle_free(&oracle[b]);
    free(oracle);
    cml_surfaces_free(&surfaces);
    return status;
}

static cml_status fly_file(const char *path, const struct method *method, char *aims_flown,
                           struct atlas_flight *flight, struct cml_error *err)
{
    struct cml_scene_list list;
    const struct cml_input_options options = {.flat = method->force == CML_SURFACE_PLANE};
    CML_TRY(cml_mci_read(path, &options, &list, err));
    flight->scene = &list.scenes[0];
    cml_status status = cml_scene_check_shapes(&list.scenes[0], err);
    if (status == CML_OK) status = fly(method, aims_flown, flight, err);
    cml_scene_list_clear(&list);
    return status;
}

int main(int argc, char **argv)
{
    struct atlas_flight flight = {.seed = 20261121};
    struct cml_error err = {CML_OK, ""};
    const struct method *method = argc >= 5 ? find_method(argv[2]) : NULL;
    if (!method) {
        fprintf(stderr, "usage: atlas SCENE.mci METHOD AIM[,AIM...] CROSSINGS [SECONDS [FLIGHTS]]\n"
                        "AIM: face, edge, vertex, drop, along or an angle in rad\n");
        return 2;
    }
    flight.crossings = (uint64_t)atof(argv[4]);
    flight.max_steps = (uint64_t)(argc > 6 ? atof(argv[6]) : 20) * flight.crossings;
    flight.max_seconds = argc > 5 ? atof(argv[5]) : 0;
    if (fly_file(argv[1], method, argv[3], &flight, &err) != CML_OK) {
        fprintf(stderr, "%s\n", err.text);
        return 2;
    }
    return 0;
}
