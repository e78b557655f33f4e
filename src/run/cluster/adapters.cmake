# Adapters (cluster_calls.h), each compiled with the mpi.h of one ABI and linked with no MPI library. They lie beside
# the program, which exports the functions that they call.
# SPDX-License-Identifier: MIT
set(CML_FOR_ADAPTERS cml_fail cml_fail_memory cml_result_cells cml_summary_merge
    cml_launcher_check cml_launcher_found cml_cores_count cml_cores_mine)
list(TRANSFORM CML_FOR_ADAPTERS PREPEND LINKER:--export-dynamic-symbol=)
set(CML_CLUSTER_FOLDER ${CMAKE_CURRENT_LIST_DIR})

# name: openmpi, mpich or abi, the names that cluster_load.c knows. folders: where mpi.h lies.
function(cml_add_adapter name folders)
    set(adapter cluster_${name})
    add_library(${adapter} MODULE ${CML_CLUSTER_FOLDER}/cluster.c ${CML_CLUSTER_FOLDER}/cluster_service.c
                                  ${CML_CLUSTER_FOLDER}/cluster_table.c)
    set_target_properties(${adapter} PROPERTIES PREFIX "" C_VISIBILITY_PRESET hidden)
    target_include_directories(${adapter} SYSTEM PRIVATE ${folders})
    target_compile_definitions(${adapter} PRIVATE ${CML_BUILD})
    target_link_libraries(${adapter} PRIVATE cml_options Threads::Threads)
endfunction()
