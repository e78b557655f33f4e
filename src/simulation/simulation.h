/* A run made ready to fly: its surfaces, its aim, the options that decide its bits, its identity. The program
 * and the C library (api/clustermcml.h) fly what is prepared here. SPDX-License-Identifier: MIT */
#pragma once

#include "options/options.h"
#include "simulation/aim.h"
#include "output/report.h"
#include "run/run.h"

struct cml_prepared {
    /* The members point to others of this structure, which must not move once it is prepared. */
    struct cml_run_setup setup;
    struct cml_surface_set surfaces;
    struct cml_aim aim;
    struct cml_provenance provenance;
    char *identity;
};

/* Refuses options of a flight that contradict each other. */
CML_NODISCARD cml_status cml_check_flight_options(const struct cml_options *options, struct cml_error *err);

/* Refuses --derivatives of a scene with a time line. */
CML_NODISCARD cml_status cml_check_differentiated(const struct cml_options *options,
                                                  const struct cml_scene *scene, struct cml_error *err);

/* Returns the setup of a run as far as the options know it. */
struct cml_run_setup cml_setup_of(const struct cml_options *options, const struct cml_scene *scene,
                                  uint64_t seed, uint32_t run);

/* Returns the options for a run of all photons: with --more also those flown before. */
struct cml_options cml_all_photons(const struct cml_options *options, const struct cml_run_setup *setup);

/* Makes the surfaces and the aim of run->setup, and checks memory and --error-of. shared: as in
 * cml_surface_options. The caller clears *run, also on failure. */
CML_NODISCARD cml_status cml_prepare(const struct cml_options *options, const struct cml_surface_set *shared,
                                     struct cml_prepared *run, struct cml_error *err);

/* Sets provenance and identity once the photons are known. inputs: the lines of cml_identity_inputs. */
CML_NODISCARD cml_status cml_prepared_identify(const struct cml_options *options, const char *inputs,
                                               struct cml_prepared *run, struct cml_error *err);

/* Returns the report of a run that was flown. It borrows all that it names. */
struct cml_report cml_prepared_report(const struct cml_prepared *run, const struct cml_run_result *flown,
                                      const char *command);

void cml_prepared_clear(struct cml_prepared *run);
