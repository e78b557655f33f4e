/* What an engine is: open a scene, fly pieces of work, close.
 * A piece, photons of one batch, is the only unit of work, and its tally depends on nothing but scene,
 * options and piece: so threads, ranks, devices and restarts cannot show. SPDX-License-Identifier: MIT */
#pragma once

#include "scene/window_table.h"
#include "scene/flat_tail.h"
#include "scene/scene.h"
#include "base/status.h"
#include "surface/surface.h"
#include "tally/piece.h"
#include "tally/tally.h"

/* Roulette (P8), in shares of a packet; both 0: that of original MCML. */
struct cml_roulette_options {
    double below;  /* lighter packets play */
    double weight; /* of survivors, below <= weight <= 1 */
};

/* Rows of a sweep that come of the same flight (P16). Zeroed: none. */
struct cml_engine_rows {
    int count;
    const double *more; /* [media][count] by how much they absorb more than the scene, 1/cm; borrowed */
    bool depths;        /* with A(z) and A(r,z), if cml_engine_rows_blind_in gives -1 */
    bool times;         /* with A(t), where there are gates */
    bool means;         /* with means of detectors */
};

/* What a sampled interaction (row_cells.h) is worth in A(z) of a row that absorbs so much more than the
 * medium that is flown, 1/cm: as a share of the weight that the packet leaves with, or where nothing scatters
 * of that which it came with. Infinite where packets never interact. */
double cml_engine_row_share(const struct cml_medium_def *flown, double more);

/* The first medium in which A(z) of one of the rows would come of too few interactions, or none: each worth
 * more than CML_ROW_MOST_SHARE packets; -1: there is none. */
#define CML_ROW_MOST_SHARE 1e4
int cml_engine_rows_blind_in(const struct cml_scene *scene, const struct cml_engine_rows *rows);

/* What a run asks of any engine. Unset members are 0. */
struct cml_engine_options {
    uint64_t seed;
    uint32_t run;   /* number of the run within its file, so that runs of one file are independent */
    int threads;    /* 0: as many as OpenMP would use, and never more than OMP_THREAD_LIMIT */
    uint64_t chunk; /* packets a thread takes at a time; 0: chosen by the engine. Never changes a result */
    bool lattice;   /* the first draws of packets are evenly spread (lattice.h); false: all are random */
    struct cml_roulette_options roulette;
    bool reentry;    /* P6 */
    bool absorption; /* tally A_rz */
    /* Packets start as they do with these surfaces: above boundary 0 where that is curved here, so that in
     * another geometry they draw the same. NULL: with the run's own. Borrowed. */
    const struct cml_surface_set *start_as;
    const struct cml_flat_tail *tail; /* P15: its expected values are wanted; NULL: none. Borrowed */
    const struct cml_window_table
        *windows;                 /* P19, in place of roulette; NULL: none. Borrowed. With a scene without
                                   * maps, facets, directions, saved packets; not of engine opencl, not traced */
    struct cml_engine_rows rows;  /* with a scene without fluence, maps, facets and maps of detectors, and
                                   * without absorption; not of engine opencl */
    bool derivatives;             /* P17: scores in place of rows; with a scene without time and detectors,
                                   * not of engine opencl */
    struct cml_saved_taker saved; /* of packets that the scene wants saved */
    /* opencl */
    const char *device; /* "0", "0,2" or "all", numbers as listed by `devices`; NULL: cml_opencl_default */
    int local_rank;     /* for that: this process's number among those of its machine */
    const char *build_options; /* for the device's compiler, behind ours; NULL: none */
    int group;                 /* work-items per group; 0: chosen by the device */
    bool loose_division; /* division and root as on devices that cannot round them correctly; for tests */
    void (*on_note)(void *context, const char *text); /* one line for people; context NULL. NULL: silent */
};

/* How one packet ended. */
struct cml_fate_record {
    int fate, cause; /* enum cml_fate, enum cml_lost_cause of kernels/types.h */
    uint32_t weight; /* left at the end, 2^-31 of a packet */
    uint32_t interactions, boundary_events;
    double specular, absorbed; /* shares of a packet: split off before the launch, left on the way */
    double backing;            /* the same, left in the backing */
    double exit[2];            /* x, y of the scene, cm, where it touched the surface last, from outside */
    double direction[3];       /* opencl: of an absorbed packet that before its last interaction */
};

/* One line of a trace: the packet after the event. */
struct cml_trace_event {
    const char *what;   /* "launch", "interact", "reflect", "transmit", "end"; "rough", before "reflect" or
                           "transmit" at a rough boundary; "detect", after all others */
    int detector;       /* number of that which saw it, from 0; of "detect", which has a weight and no more */
    int steps;          /* facets met in the longest walk of the event; of "rough", which has no more */
    int medium;         /* 0..L+1, L+2 and up: bodies */
    double position[3]; /* of the scene, cm */
    double direction[3];
    double weight; /* share of a packet */
};
typedef void cml_trace_function(void *context, const struct cml_trace_event *event);

/* Where an engine gets packets, and where it hands in what they scored. Threads of the engine call all three
 * at any time and side by side: so each goes its own way from piece to piece, and none waits for another. */
struct cml_work {
    void *context;
    /* The next piece, of at most `most` packets; where `takers` threads ask, less and less of them towards
     * the end. false: there are no more for this call of run; *piece is empty then. */
    bool (*next)(void *context, uint64_t most, int takers, struct cml_piece *piece);
    /* All that has come to the tally since the last call, or since it was zero, is of this batch, but for
     * what its late packets have brought (tally.h). Packets may still be under way: what they bring comes
     * with a later call. The cells stay. */
    void (*end_batch)(void *context, int batch, struct cml_tally *tally);
    /* Takes all cells of a tally that gets no more in this call of run, whose last batch has ended; it is
     * zero afterwards. */
    void (*add)(void *context, struct cml_tally *tally);
    /* The system refused to start all threads of the engine: so many fly. NULL: not told. */
    void (*fewer)(void *context, int threads);
    /* Whether the run is to stop: next has no more pieces then. NULL: never. */
    bool (*stops)(void *context);
};

/* How long a thread that flies packets waits for their ends: its own time when it first saw that the run is
 * to stop, s; 0 before. */
struct cml_patience {
    double since;
};

/* Whether a thread has flown for 0.3 seconds of its own time since the run was to stop. Packets live for
 * moments, but one may make 10^7 boundary events in a row between interactions: it is given up, and with it
 * all that this call of run has flown. To be asked every few hundred events. */
bool cml_engine_gives_up(const struct cml_work *work, struct cml_patience *patience);

/* What `run` of an engine returns when packets were given up: CML_E_STOPPED. */
CML_NODISCARD cml_status cml_engine_given_up(struct cml_error *err);

struct cml_engine {
    const char *name;
    bool reweights; /* flies rows (struct cml_engine_rows), and scores */
    /* The scene and its surfaces must outlive the engine. */
    cml_status (*open)(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                       const struct cml_engine_options *options, void **self, struct cml_error *err);
    /* Flies pieces of the work until there are no more, and hands in their tallies; together at most
     * CML_TALLY_MAX_PHOTONS. On failure some are flown, and not all of that is handed in: the engine is only
     * to be closed then. CML_E_STOPPED when packets were given up. */
    cml_status (*run)(void *self, const struct cml_work *work, struct cml_error *err);
    /* Flies packet `index` alone. on_event may be NULL. */
    cml_status (*trace)(void *self, uint64_t index, cml_trace_function *on_event, void *context,
                        struct cml_fate_record *record, struct cml_error *err);
    /* How packets [first, first + count) end, without a tally: records[count]. */
    cml_status (*fates)(void *self, uint64_t first, uint64_t count, struct cml_fate_record *records,
                        struct cml_error *err);
    int (*threads)(const void *self); /* NULL: as many as it takes unless told */
    double (*bytes)(const struct cml_scene *scene,
                    const struct cml_surface_set *surfaces); /* that `open` takes, without tallies */
    void (*close)(void *self);
};

/* Adds packets [first, first + count) to the tally, which has the grid of the engine's scene and options;
 * count <= CML_TALLY_MAX_PHOTONS. */
CML_NODISCARD cml_status cml_engine_run_range(const struct cml_engine *engine, void *self, uint64_t first,
                                              uint64_t count, struct cml_tally *tally, struct cml_error *err);

/* For cml_work.next: how many of `left` packets one of `takers` threads gets that asks for `most`. */
uint64_t cml_piece_size(uint64_t most, int takers, uint64_t left);

/* The grid of a run's tallies: whatever scene and options ask for. surfaces NULL: without facets. */
struct cml_tally_grid cml_engine_grid(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                      const struct cml_engine_options *options);

const char *cml_fate_name(int fate);
const char *cml_lost_cause_name(int cause);
