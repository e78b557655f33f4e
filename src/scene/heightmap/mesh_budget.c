/* SPDX-License-Identifier: MIT */
#include "scene/heightmap/mesh_budget.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

#define MOST_BY_DEFAULT 4e6
#define SHARE_OF_MEMORY 0.25
#define BYTES 350.0  /* bytes per triangle; measurements stand in mesh_budget.h */
#define OF_FILE 50.0 /* bytes of them that are those of the file */
#define SECONDS 3e-6 /* seconds per triangle; measured: 2.1e-6 tessellations, 4.2e-6 .obj files */

double cml_mesh_budget_default(void)
{
    const double memory = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    return fmax(1, floor(fmin(MOST_BY_DEFAULT, SHARE_OF_MEMORY * memory / BYTES)));
}

/* Writes the name of the boundary or body that the mesh belongs to, with file and line. */
static void name(const struct cml_mesh_budget *budget, char *text, size_t size)
{
    const char *what = budget->body > 0 ? "body" : "boundary";
    const int number = budget->body > 0 ? budget->body : budget->boundary;
    if (!budget->file)
        snprintf(text, size, "a boundary");
    else if (budget->line > 0)
        snprintf(text, size, "%.512s:%d: %s %d", budget->file, budget->line, what, number);
    else
        snprintf(text, size, "%.512s: %s %d", budget->file, what, number);
}

cml_status cml_mesh_budget_check(const struct cml_mesh_budget *budget, double triangles, const char *remedy,
                                 struct cml_error *err)
{
    static const struct cml_mesh_budget none;
    if (!budget) budget = &none;
    const double most = budget->most > 0 ? budget->most : CML_MESH_MOST, seconds = SECONDS * triangles;
    const double bytes = BYTES * triangles + fmax(0, budget->read - OF_FILE * triangles);
    char owner[600], text[700];
    name(budget, owner, sizeof owner);
    if (triangles > most)
        return cml_fail(err, CML_E_INPUT, "%s needs %.10g triangles, %.3g GiB (expected at most %.0f, or %s)",
                        owner, triangles, bytes / 1073741824, most, remedy);
    if (seconds <= 1 || !budget->on_large) return CML_OK;
    snprintf(text, sizeof text, "%s: making a mesh of %.3g triangles, some %.0f s", owner, triangles,
             seconds);
    budget->on_large(budget->context, text, seconds);
    return CML_OK;
}
