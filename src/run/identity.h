/* The identity of a run: all that the bits of its result depend on, as lines of text (program, options,
 * photons, the bytes of all input files). Two runs with the same identity give the same tallies for any
 * number of threads and ranks. Where two identities differ, their first differing line says why.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/input_files.h"
#include "result/provenance.h"
#include "run/run.h"

/* Returns the lines for the input files in *text: name without directories, size, checksum. The caller frees
 * *text. */
CML_NODISCARD cml_status cml_identity_inputs(const struct cml_inputs *inputs, char **text,
                                             struct cml_error *err);

/* Returns the provenance of a run: the values of all options that change the bits of results. flat: shapes
 * are ignored. Only this function knows where these options are kept. */
struct cml_provenance cml_run_provenance(const struct cml_run_setup *setup,
                                         const struct cml_surface_options *surface, bool flat);

/* Returns the identity in *identity, which the caller frees. settings: those of --set in this scene; NULL:
 * none. inputs: the lines of cml_identity_inputs. */
CML_NODISCARD cml_status cml_identity_of(const struct cml_provenance *provenance, const char *settings,
                                         const char *inputs, char **identity, struct cml_error *err);

/* Writes two checksums of an identity as 16 hexadecimal digits, by which a result names its run. */
void cml_identity_sum(const char *identity, char sum[CML_IDENTITY_SUM]);
