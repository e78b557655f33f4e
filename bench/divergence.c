/* What lanes of a GPU that go on together wait for each other, counted without a GPU:
 * bench_divergence COSTS.csv SCENE.mci ... flies packets of the first run of each scene one by one, as the
 * kernel would, and lets 32 lanes do their steps in several orders of work. COSTS.csv: instructions of each
 * stage (gpu_static.sh leaves it). Prints CSV: instructions of a warp per event of a lane times 32, how often
 * an event needs a stage and the share of lanes that are active whenever a warp does it, and how often lanes
 * add to one bin. SPDX-License-Identifier: MIT */
#include "divergence.h"

enum { WARPS = 16, ROUNDS = 4000, FIRST_ROUNDS = 1000 };

/* Which lanes do what before which others. */
struct order {
    const char *name;
    int in_pass;  /* boundaries and ends as soon as a lane comes to one */
    int split;    /* packets that draw from the lattice fly apart from the others */
    int passes;   /* interactions that a lane may have before boundaries and ends are looked at */
    int boundary; /* lanes that must wait for a boundary before the warp does them */
    int end;      /* the same for ends */
    int roulette; /* 1: roulette waits for the end of the passes, too */
};

static const struct order orders[] = {
    {"each pass, lattice apart", 1, 1, 1, 1, 1, 0},
    {"each pass", 1, 0, 1, 1, 1, 0},
    {"2 passes", 0, 0, 2, 1, 1, 1},
    {"4 passes", 0, 0, 4, 1, 1, 1},
    {"8 passes", 0, 0, 8, 1, 1, 1},
    {"12 passes", 0, 0, 12, 1, 1, 1},
    {"16 passes", 0, 0, 16, 1, 1, 1},
    {"8 lanes wait", 0, 0, 1, 8, 8, 1},
    {"16 lanes wait", 0, 0, 1, 16, 16, 1},
};
enum { NUM_ORDERS = sizeof orders / sizeof *orders };

enum state { READY, FLOWN, AT_BOUNDARY, CLEARED, LOW, ENDED };

struct lane {
    struct packet_ahead ahead;
    enum state state;
};

struct warp {
    struct lane lane[LANES];
    uint64_t next; /* index of the next packet */
};

/* How often warps do a stage, and how many lanes are active in it; events of lanes. */
struct use {
    double done[NUM_STAGES], active[NUM_STAGES], events;
    double layer, sums; /* additions to A_l; to balance, counts and exits */
};

static int count(const struct warp *warp, enum state state)
{
    int n = 0;
    for (int i = 0; i < LANES; i++) n += warp->lane[i].state == state;
    return n;
}

static void note(struct use *use, enum stage stage, int active)
{
    use->done[stage] += active > 0;
    use->active[stage] += active;
}

static void step_is_done(const struct bench_scene *scene, struct lane *lane, struct use *use)
{
    use->events++;
    use->layer += lane->ahead.step.layer;
    use->sums += lane->ahead.step.sums;
    lane->state = lane->ahead.step.ends ? ENDED : READY;
    if (!lane->ahead.step.ends) packet_look_ahead(scene, &lane->ahead);
}

static void refill(const struct bench_scene *scene, struct warp *warp, struct use *use)
{
    note(use, REPLACE, count(warp, ENDED));
    for (int i = 0; i < LANES; i++) {
        struct lane *lane = &warp->lane[i];
        if (lane->state != ENDED) continue;
        packet_launch(scene, warp->next++, &lane->ahead);
        lane->state = READY;
    }
}

/* Lanes that meet none are to interact: now or in the next pass. */
static void do_boundaries(const struct bench_scene *scene, struct warp *warp, enum state cleared,
                          struct use *use)
{
    note(use, BOUNDARY, count(warp, AT_BOUNDARY));
    for (int i = 0; i < LANES; i++) {
        struct lane *lane = &warp->lane[i];
        if (lane->state != AT_BOUNDARY) continue;
        lane->state = cleared;
        if (!lane->ahead.step.interacts) step_is_done(scene, lane, use);
    }
}

static void do_roulette(const struct bench_scene *scene, struct warp *warp, struct use *use)
{
    note(use, ROULETTE, count(warp, LOW));
    for (int i = 0; i < LANES; i++)
        if (warp->lane[i].state == LOW) step_is_done(scene, &warp->lane[i], use);
}

/* Lanes that fly, and which of them are at a boundary then. */
static void fly(struct warp *warp, const struct order *order, struct use *use)
{
    int even = 0, all = 0;
    for (int i = 0; i < LANES; i++) {
        struct lane *lane = &warp->lane[i];
        if (lane->state != READY && lane->state != CLEARED) continue;
        all++;
        even += lane->ahead.step.even;
        lane->state = lane->state == READY && lane->ahead.step.near ? AT_BOUNDARY : FLOWN;
    }
    note(use, FLY, order->split ? all - even : all);
    note(use, LATTICE, even);
    if (order->split) note(use, FLY_AGAIN, even);
}

static void interact(const struct bench_scene *scene, struct warp *warp, struct use *use,
                     struct conflicts *conflicts)
{
    uint32_t cell[LANES];
    int all = 0;
    for (int i = 0; i < LANES; i++) {
        struct lane *lane = &warp->lane[i];
        if (lane->state != FLOWN) continue;
        cell[all++] = lane->ahead.step.cell;
        if (lane->ahead.step.low)
            lane->state = LOW;
        else
            step_is_done(scene, lane, use);
    }
    note(use, INTERACT, all);
    note(use, DEPOSIT, all);
    if (conflicts) conflicts_note(conflicts, cell, all);
}

static int can_fly(const struct warp *warp)
{
    return count(warp, READY) + count(warp, CLEARED);
}

static void round_of(const struct bench_scene *scene, const struct order *order, struct warp *warp,
                     struct use *use, struct conflicts *conflicts)
{
    for (int pass = 0; pass < order->passes && can_fly(warp); pass++) {
        fly(warp, order, use);
        if (order->in_pass) do_boundaries(scene, warp, FLOWN, use);
        interact(scene, warp, use, conflicts);
        if (!order->roulette) do_roulette(scene, warp, use);
    }
    if (!order->in_pass && (count(warp, AT_BOUNDARY) >= order->boundary || !can_fly(warp)))
        do_boundaries(scene, warp, CLEARED, use);
    do_roulette(scene, warp, use);
    if (count(warp, ENDED) >= order->end || !can_fly(warp)) refill(scene, warp, use);
}

/* Rounds of a steady state: the first ones, in which packets begin together, do not count. */
static struct use use_of(const struct bench_scene *scene, const struct order *order,
                         struct conflicts *conflicts)
{
    struct use use = {0};
    for (uint64_t w = 0; w < WARPS; w++) {
        struct use ignored = {0};
        struct warp warp = {.next = w << 20};
        for (int i = 0; i < LANES; i++) warp.lane[i].state = ENDED;
        refill(scene, &warp, &ignored);
        for (int n = 0; n < FIRST_ROUNDS; n++) round_of(scene, order, &warp, &ignored, NULL);
        for (int n = 0; n < ROUNDS; n++) round_of(scene, order, &warp, &use, conflicts);
    }
    return use;
}

/* Instructions of a warp per event of a lane times 32; as few as that if no lane ever waited: *least. */
static double price(const struct use *use, const double *cost, double *least)
{
    double all = 0;
    *least = 0;
    for (int i = 0; i < NUM_STAGES; i++) {
        all += cost[i] * use->done[i];
        *least += cost[i] * use->active[i] / LANES;
    }
    *least *= LANES / use->events;
    return all * LANES / use->events;
}

static void report(const struct bench_scene *scene, const struct order *order, const double *cost)
{
    struct conflicts c;
    double least;
    conflicts_begin(scene, &c);
    const struct use use = use_of(scene, order, &c);
    const double paid = price(&use, cost, &least);
    printf("\"%s: %s\",%d,%.0f,%.0f", scene->name, order->name, scene->only_planes, paid, least);
    for (int i = 0; i < NUM_STAGES; i++)
        printf(",%.4f,%.3f", use.active[i] / use.events,
               use.done[i] > 0 ? use.active[i] / use.done[i] / LANES : 0);
    printf(",%u,%u,%.4f,%.4f,%.4f,%.2f,%.4f,%.2f,%.5f\n", c.near, c.cells, 1 - c.far / c.all,
           use.layer / use.events, use.sums / use.events, c.all / c.done, c.same / c.all, c.busiest / c.done,
           conflicts_collision(&c));
    conflicts_end(&c);
}

/* Instructions of the stages, for planes or for curved boundaries. */
static int read_costs(const char *path, const char *kind, double *cost)
{
    FILE *file = fopen(path, "r");
    char line[256], of[64], name[64];
    double instructions;
    int found = 0;
    if (!file) return 0;
    while (fgets(line, sizeof line, file))
        for (int i = 0; i < NUM_STAGES; i++)
            if (sscanf(line, "%63[^,],%63[^,],%lf", of, name, &instructions) == 3 && strcmp(of, kind) == 0 &&
                strcmp(name, stage_names[i]) == 0) {
                cost[i] = instructions;
                found++;
            }
    fclose(file);
    cost[FLY_AGAIN] = cost[FLY];
    return found == NUM_STAGES - 1;
}

static int fail(const char *path, const char *text)
{
    fprintf(stderr, "bench_divergence: %s: %s\n", path, text);
    return 2;
}

int main(int argc, char **argv)
{
    printf("scene and order,only planes,instructions,least");
    for (int i = 0; i < NUM_STAGES; i++) printf(",%s,%s share", stage_names[i], stage_names[i]);
    printf(",near,cells,in local memory,layer,sums,lanes,one bin,busiest,collision\n");
    for (int k = 2; k < argc; k++) {
        struct bench_scene scene;
        struct cml_error err;
        double cost[NUM_STAGES];
        if (bench_scene_open(argv[k], &scene, &err) != CML_OK) return fail(argv[k], err.text);
        if (!read_costs(argv[1], scene.only_planes ? "planes" : "cones", cost))
            return fail(argv[1], "not the instructions of all stages");
        for (int i = 0; i < NUM_ORDERS; i++) report(&scene, &orders[i], cost);
        bench_scene_close(&scene);
    }
    return 0;
}
