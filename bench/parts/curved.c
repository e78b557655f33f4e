/* Where the time below a curved boundary goes: bench_curved SCENE.mci cone|mesh. For the first run of the
 * scene, on one thread, in ns per photon: what it takes in all (ns), and of that
 *
 * classify   which lanes may be near one: asked in every pass that has any at a boundary
 * intervals  on which part of its path each may meet it
 * search     which ring or facet each meets, and where
 * reflect    roots and normals of rings, reflection and refraction
 * cross      what takes their packets into the next medium, or out of the scene for good or until they return
 *
 * The whole is flown without clocks, and the parts once more with them (engine/cpu/bundle_hooks.h), less what
 * the clocks take. Prints CSV. SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 199309L
#define CML_HOOK_BEGIN(part) begin(part)
#define CML_HOOK_END(part) end(part)
#include "base/clock.h"
#include "engine/cpu/bundle_hooks.h"

#include <string.h>

static int parts_timed; /* whether the parts are */
static struct {
    double begin, ns;
    long times;
} taken[CML_HOOK_PARTS];

static double nanoseconds(void)
{
    return 1e9 * cml_now();
}

static void begin(enum cml_hook_part part)
{
    if (parts_timed) taken[part].begin = nanoseconds();
}

static void end(enum cml_hook_part part)
{
    if (!parts_timed) return;
    taken[part].ns += nanoseconds() - taken[part].begin;
    taken[part].times++;
}

#define CML_LEVEL curved
#include "engine/cpu/engine_cpu_level.c"

#include "fly_scene.h"

static double flight_begin;

static void reset(void)
{
    memset(taken, 0, sizeof taken);
    flight_begin = nanoseconds();
}

/* What a clock adds to a part, and to the part around it, in ns. */
struct clocks {
    double within, around;
};

static struct clocks time_clocks(void)
{
    enum { COUNT = 1000000 };
    reset();
    parts_timed = 1;
    const double start = nanoseconds();
    for (int i = 0; i < COUNT; i++) begin(CML_HOOK_HITS), end(CML_HOOK_HITS);
    const double within = taken[CML_HOOK_HITS].ns / COUNT, both = (nanoseconds() - start) / COUNT;
    parts_timed = 0;
    return (struct clocks){within, both};
}

/* What a part takes, with all parts within it. */
static double whole(enum cml_hook_part part, struct clocks clocks)
{
    return taken[part].ns - (double)taken[part].times * clocks.within;
}

/* What a part that was timed has added to the one around it. */
static double added(enum cml_hook_part part, struct clocks clocks)
{
    return whole(part, clocks) + (double)taken[part].times * clocks.around;
}

/* ns: of a photon, without clocks. flown: what the flight with clocks took, in ns; the machine may have been
 * slower or faster meanwhile. */
static void report(const char *path, const struct bench_flight *flight, double ns, double flown,
                   struct clocks clocks)
{
    for (int part = 0; part < CML_HOOK_PARTS; part++) flown -= (double)taken[part].times * clocks.around;
    const double n = flown / ns;
    const double reflect = whole(CML_HOOK_REFLECT, clocks);
    const double cross = whole(CML_HOOK_HITS, clocks) - added(CML_HOOK_REFLECT, clocks);
    const double intervals = whole(CML_HOOK_INTERVALS, clocks);
    const double search =
        whole(CML_HOOK_CURVED, clocks) - added(CML_HOOK_INTERVALS, clocks) - added(CML_HOOK_HITS, clocks);
    printf(
        "scene,queries,ns,classify,intervals,search,reflect,cross\n%s,%.3f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f\n",
        path, (double)flight->tally.count[CML_COUNT_QUERIES] / (double)flight->photons, ns,
        whole(CML_HOOK_CLASSIFY, clocks) / n, intervals / n, search / n, reflect / n, cross / n);
}

static cml_status measure(const char *path, enum cml_surface_kind force, struct cml_error *err)
{
    struct bench_flight flight;
    const struct clocks clocks = time_clocks();
    CML_TRY(bench_open(path, force, &flight, err));
    CML_TRY(bench_fly(&flight, reset, err));
    const double ns = 1e9 * flight.seconds / (double)flight.photons;
    parts_timed = 1;
    CML_TRY(bench_fly(&flight, reset, err));
    report(path, &flight, ns, nanoseconds() - flight_begin, clocks);
    bench_close(&flight);
    return CML_OK;
}

int main(int argc, char **argv)
{
    struct cml_error err;
    if (argc != 3) {
        fprintf(stderr, "usage: bench_curved SCENE.mci cone|mesh\n");
        return 2;
    }
    if (measure(argv[1], strcmp(argv[2], "mesh") == 0 ? CML_SURFACE_MESH : CML_SURFACE_CONE, &err) == CML_OK)
        return 0;
    fprintf(stderr, "bench_curved: %s\n", err.text);
    return 2;
}
