/* The only symbol that an adapter exports: the table of its functions. SPDX-License-Identifier: MIT */
#include "run/cluster/cluster_calls.h"

#define CALL_ENTRY(type, name, parameters, arguments) .name = cml_cluster_##name,
#define TELL_ENTRY(name, parameters, arguments) .name = cml_cluster_##name,

__attribute__((visibility("default"))) const struct cml_cluster_calls cml_cluster_table = {
    .build = CML_CLUSTER_BUILD, .begin = cml_cluster_begin, CML_CLUSTER_CALLS(CALL_ENTRY, TELL_ENTRY)};
