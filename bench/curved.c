/* Where the time below a curved boundary goes: bench_curved SCENE.mci cone|mesh. For the first run of the
 * scene, on one thread, in ns per photon: what it takes in all, and of that around  which lanes may be near
 * one, asked in every pass that has any at a boundary, ahead   whether their paths keep clear of it, seek
 * which ring or facet they meet, and where, lane by lane, turn    roots and normals of rings, reflection and
 * refraction, cross   their packets into the next medium, or out of the scene for good or until they come
 * back. The whole is flown without clocks, and the parts once more with them, less what the clocks take.
 * Prints CSV. SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 199309L
#include "engine/cpu/bundle_curved_reach_inl.h"
#include "engine/cpu/bundle_loops_inl.h"

#include <string.h>
#include <time.h>

enum part { AROUND, AHEAD, TURN, HITS, CURVES, PARTS };

static int timed; /* whether the parts are */
static struct {
    double begin, ns;
    long times;
} spent[PARTS];

static double ticks(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static void begin(enum part part)
{
    if (timed) spent[part].begin = ticks();
}

static void end(enum part part)
{
    if (!timed) return;
    spent[part].ns += ticks() - spent[part].begin;
    spent[part].times++;
}

static int answer;
#define TIMED(part, call) (begin(part), (call), end(part))
#define TIMED_ANSWER(part, call) (begin(part), answer = (call), end(part), answer)

#define cml_hits_refine_rings(world, side, h) TIMED(TURN, cml_hits_refine_rings(world, side, h))
#define cml_hits_reflect_or_refract(setup, side, n1, n2, h) TIMED_ANSWER(TURN, cml_hits_reflect_or_refract(setup, side, n1, n2, h))
#define cml_gather_intervals(f, medium, lanes) TIMED(AHEAD, cml_gather_intervals(f, medium, lanes))
#define cml_bundle_classify_near(b, steepest) TIMED_ANSWER(AROUND, cml_bundle_classify_near(b, steepest))
#include "engine/cpu/bundle_curved_cross_inl.h"
#define cml_process_hits(f, medium, side, h) TIMED(HITS, cml_process_hits(f, medium, side, h))
#include "engine/cpu/bundle_curved_search_inl.h"
#define cml_process_curved(f) TIMED(CURVES, cml_process_curved(f))

#define CML_LEVEL curved
#include "engine/cpu/engine_cpu_level.c"

#include "fly_scene.h"

static double flight_begin;

static void reset(void)
{
    memset(spent, 0, sizeof spent);
    flight_begin = ticks();
}

/* What a clock adds to a part, and to the part around it, in ns. */
struct clocks {
    double within, around;
};

static struct clocks time_clocks(void)
{
    enum { COUNT = 1000000 };
    reset();
    timed = 1;
    const double start = ticks();
    for (int i = 0; i < COUNT; i++) TIMED(HITS, (void)0);
    const double within = spent[HITS].ns / COUNT, both = (ticks() - start) / COUNT;
    timed = 0;
    return (struct clocks){within, both};
}

/* What a part takes, with all parts within it. */
static double whole(enum part part, struct clocks clocks)
{
    return spent[part].ns - (double)spent[part].times * clocks.within;
}

/* What a part that was timed has added to the one around it. */
static double added(enum part part, struct clocks clocks)
{
    return whole(part, clocks) + (double)spent[part].times * clocks.around;
}

/* ns: of a photon, without clocks. flown: what the flight with clocks took, in ns; the machine may have been
 * slower or faster meanwhile. */
static void report(const char *path, const struct bench_flight *flight, double ns, double flown,
                   struct clocks clocks)
{
    for (int part = 0; part < PARTS; part++) flown -= (double)spent[part].times * clocks.around;
    const double n = flown / ns;
    const double turn = whole(TURN, clocks), cross = whole(HITS, clocks) - added(TURN, clocks);
    const double seek = whole(CURVES, clocks) - added(AHEAD, clocks) - added(HITS, clocks);
    printf("scene,queries,ns,around,ahead,seek,turn,cross\n%s,%.3f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f\n", path,
           (double)flight->tally.count[CML_COUNT_QUERIES] / (double)flight->photons, ns,
           whole(AROUND, clocks) / n, whole(AHEAD, clocks) / n, seek / n, turn / n, cross / n);
}

static cml_status measure(const char *path, enum cml_surface_kind force, struct cml_error *err)
{
    struct bench_flight flight;
    const struct clocks clocks = time_clocks();
    CML_TRY(bench_open(path, force, &flight, err));
    CML_TRY(bench_fly(&flight, reset, err));
    const double ns = 1e9 * flight.seconds / (double)flight.photons;
    timed = 1;
    CML_TRY(bench_fly(&flight, reset, err));
    report(path, &flight, ns, ticks() - flight_begin, clocks);
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
    if (measure(argv[1], strcmp(argv[2], "mesh") == 0 ? CML_SURFACE_MESH : CML_SURFACE_CONE, &err) == CML_OK) return 0;
    fprintf(stderr, "bench_curved: %s\n", err.text);
    return 2;
}
