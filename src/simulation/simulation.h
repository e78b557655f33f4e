/* A run: prepared, flown, reported. The program and the C library (api/clustermcml.h) fly this object and no
 * other. SPDX-License-Identifier: MIT */
#pragma once

#include "options/options.h"
#include "simulation/aim.h"
#include "output/report.h"
#include "run/run.h"

struct cml_simulation {
    const struct cml_options *options;
    /* The members point to others of this structure, which must not move once it is prepared. */
    struct cml_run_setup setup;
    struct cml_surface_set surfaces;
    struct cml_aim aim;
    struct cml_provenance provenance;
    char *identity;
    struct cml_run_result flown; /* what has flown; zeros: nothing */
};

/* Refuses options of a flight that contradict each other. */
CML_NODISCARD cml_status cml_check_flight_options(const struct cml_options *options, struct cml_error *err);

/* Refuses --derivatives of a scene with a time line. */
CML_NODISCARD cml_status cml_check_differentiated(const struct cml_options *options,
                                                  const struct cml_scene *scene, struct cml_error *err);

/* Refuses before any flight what a run of the scene would refuse: memory, starts of beams, --error-of, --aim.
 * shared: as in cml_surface_options. */
CML_NODISCARD cml_status cml_simulation_check(const struct cml_options *options,
                                              const struct cml_scene *scene,
                                              const struct cml_surface_set *shared, struct cml_error *err);

/* Sets all that options and scene alone decide. All arguments are borrowed. */
void cml_simulation_begin(const struct cml_options *options, const struct cml_scene *scene, uint64_t seed,
                          uint32_t run, struct cml_simulation *sim);

/* Returns the options for a run of all photons: with --more also those flown before. */
struct cml_options cml_all_photons(const struct cml_simulation *sim);

/* Makes surfaces and aim, and checks memory and --error-of. shared: as in cml_surface_options. */
CML_NODISCARD cml_status cml_simulation_prepare(struct cml_simulation *sim,
                                                const struct cml_surface_set *shared, struct cml_error *err);

/* Sets provenance and identity once the photons are known. inputs: the lines of cml_identity_inputs. */
CML_NODISCARD cml_status cml_simulation_identify(struct cml_simulation *sim, const char *inputs,
                                                 struct cml_error *err);

/* Flies `photons` behind those that have flown; 0, only at first: as many as the setup says. The sum of
 * several flights has the bits of one. Fails as cml_run does, and then adds nothing. Collective. */
CML_NODISCARD cml_status cml_simulation_fly(struct cml_simulation *sim, uint64_t photons,
                                            struct cml_error *err);

/* Returns the report of what has flown. It borrows all that it names. */
struct cml_report cml_simulation_report(const struct cml_simulation *sim);

void cml_simulation_clear(struct cml_simulation *sim);
