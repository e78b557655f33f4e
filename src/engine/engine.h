/* Engines: the interface that `cpu`, `reference` and `opencl` implement. An engine opens a scene, flies
 * pieces of work, and is closed.
 *
 *      open ---> run, again and again ---> close
 *                 | next: the next piece            ^
 *                 v                                 | end_batch, add: tallies
 *               photons of one batch ---------------+
 *
 * A piece, photons of one batch, is the only unit of work. Its tally depends on scene, options and piece
 * alone, so threads, ranks, devices and restarts cannot change a result.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/window_table.h"
#include "scene/flat_tail.h"
#include "scene/scene.h"
#include "base/status.h"
#include "surface/surface.h"
#include "tally/piece.h"
#include "tally/tally.h"

/* Options of roulette (P8), in shares of a packet. Both 0: roulette as in original MCML. */
struct cml_roulette_options {
    double below;  /* packets lighter than this play */
    double weight; /* weight of survivors, below <= weight <= 1 */
};

/* Rows of a sweep that come of one flight (P16). Zeroed: no rows. */
struct cml_engine_rows {
    int count;
    const double *more; /* [media][count] absorption above that of the scene, 1/cm; borrowed */
    bool depths;        /* 1: the rows have A(z) and A(r,z), if cml_engine_rows_blind_in returns -1 */
    bool times;         /* 1: the rows have A(t), if there are gates */
    bool means;         /* 1: the rows have means of detectors */
};

/* Returns the share of a packet's weight that a sampled interaction (row_cells.h) adds to A(z) of a row
 * whose medium absorbs `more` (1/cm) than the flown one. The weight is that after the interaction, or, in
 * a medium that does not scatter, that before it. Infinite if packets never interact. */
double cml_engine_row_share(const struct cml_medium_def *flown, double more);

/* Returns the first medium in which too few interactions would make up a row's A(z): packets never
 * interact there, or each interaction would count as more than CML_ROW_MOST_SHARE packets. Returns -1 if
 * there is no such medium. */
#define CML_ROW_MOST_SHARE 1e4
int cml_engine_rows_blind_in(const struct cml_scene *scene, const struct cml_engine_rows *rows);

/* Options of a run, for any engine. Unset members are 0. */
struct cml_engine_options {
    uint64_t seed;
    uint32_t run;   /* number of the run within its file, which makes the runs of one file independent */
    int threads;    /* 0: as many as OpenMP would use; never more than OMP_THREAD_LIMIT */
    uint64_t chunk; /* packets that a thread takes at a time; 0: the engine chooses. Never changes a result */
    bool lattice;   /* 1: the first draws of packets are spread evenly (lattice.h); 0: all are random */
    struct cml_roulette_options roulette;
    bool reentry;    /* 1: packets may come back into the material (P6) */
    bool absorption; /* 1: tally A_rz */
    /* Surfaces by which packets start; NULL: the run's own. Packets start above boundary 0 unless it is a
     * smooth plane in these surfaces. With the surfaces of another geometry, a scene draws the same random
     * numbers as that geometry. Borrowed. */
    const struct cml_surface_set *start_as;
    const struct cml_flat_tail *tail; /* expected values that are wanted (P15); NULL: none. Borrowed */
    /* Weight windows in place of roulette (P19); NULL: none. Borrowed. Only for a scene without maps, facets,
     * directions and saved packets; not for engine opencl, not for traces. */
    const struct cml_window_table *windows;
    /* Only for a scene without fluence, maps, facets and maps of detectors, and a run without absorption; not
     * for engine opencl. */
    struct cml_engine_rows rows;
    /* 1: scores for derivatives in place of rows (P17). Only for a scene without time gates; not for engine
     * opencl. */
    bool derivatives;
    struct cml_saved_taker saved; /* takes the packets that the scene wants saved */
    /* The members below are for engine opencl. */
    /* Devices: "0", "0,2" or "all", by the numbers that `devices` lists; NULL: cml_opencl_default chooses
     * one. */
    const char *device;
    int local_rank; /* number of this process among those of its machine, for the choice of a device */
    const char *build_options; /* options for the device's compiler, after our own; NULL: none */
    int group;                 /* work-items per group; 0: the device chooses */
    bool loose_division; /* 1: division and root as on devices that cannot round them correctly; for tests */
    /* Gets notes for people, one line each; context is NULL. NULL: silent. */
    void (*on_note)(void *context, const char *text);
};

/* The end of one packet. */
struct cml_fate_record {
    int fate, cause; /* enum cml_fate, enum cml_lost_cause of kernels/types.h */
    uint32_t weight; /* weight at the end, units of 2^-31 of a packet */
    uint32_t interactions, boundary_events;
    double specular, absorbed; /* shares of a packet: split off before the launch; absorbed on the way */
    double backing;            /* share of a packet that stayed in the backing */
    double face;               /* share that faces kept, or that was stopped on boundary 0 */
    /* X, y of the scene where the packet last touched a surface from outside, cm. */
    double exit[2];
    /* Direction at the end. With the engine `opencl`, an absorbed packet has the direction before its last
     * interaction. */
    double direction[3];
};

/* An event in a trace, with the packet after it. */
struct cml_trace_event {
    /* "launch", "interact", "reflect", "transmit" or "end". "rough" comes before "reflect" or "transmit" at a
     * rough boundary, and so do "face" (kept by a face) and "through" (of a port); "stop" comes before the
     * end of a packet that a face or port stops; "detect" comes after all others. */
    const char *what;
    /* "detect": number of the detector that saw the packet, from 0; of the other members only weight is
     * set. */
    int detector;
    int contact;        /* "face", "through", "stop": number of the face or port, from 1; only this is set */
    int steps;          /* "rough": facets met in the longest walk of the event; no other member is set */
    int medium;         /* 0..L+1: outer media and layers; L+2 and up: bodies */
    double position[3]; /* coordinates of the scene, cm */
    double direction[3];
    double weight; /* weight as a share of a packet */
};
typedef void cml_trace_function(void *context, const struct cml_trace_event *event);

/* The source of an engine's packets, and the receiver of their scores. The engine's threads call the
 * functions at any time and side by side, so each goes its own way from piece to piece, and none waits for
 * another. */
struct cml_work {
    void *context;
    /* Finds the next piece, of at most `most` packets. If `takers` threads ask, pieces become smaller towards
     * the end. Returns false, and an empty *piece, if there are no more for this call of run. */
    bool (*next)(void *context, uint64_t most, int takers, struct cml_piece *piece);
    /* Says that all scores in the tally since the last call, or since it was zero, belong to this batch,
     * except those of its late packets (tally.h). Packets may still be under way: their scores come with a
     * later call. The cells stay. */
    void (*end_batch)(void *context, int batch, struct cml_tally *tally);
    /* Takes all cells of a tally that gets no more in this call of run, and sets them to zero. The tally's
     * last batch has ended. */
    void (*add)(void *context, struct cml_tally *tally);
    /* Called if the system refuses to start all threads: `threads` of them fly. NULL: not told. */
    void (*fewer)(void *context, int threads);
    /* True if the run is to stop; then `next` has no more pieces. NULL: never. */
    bool (*stops)(void *context);
};

/* The patience of a thread that flies packets of a run which is to stop: the thread's own time when it first
 * saw this, s; 0 before. */
struct cml_patience {
    double since;
};

/* True if a thread has flown for 0.3 seconds of its own time since the run was to stop. Most packets end in
 * moments, but one may have 10^7 boundary events in a row between interactions. Such a packet is given up,
 * and with it all that this call of run has flown. To be asked every few hundred events. */
bool cml_engine_gives_up(const struct cml_work *work, struct cml_patience *patience);

/* Fails with CML_E_STOPPED and a message. An engine's `run` returns this status if it gave packets up
 * (cml_engine_gives_up). */
CML_NODISCARD cml_status cml_engine_given_up(struct cml_error *err);

struct cml_engine {
    const char *name;
    bool reweights; /* true: the engine flies rows (struct cml_engine_rows) and scores */
    /* Opens a scene. The scene and its surfaces must outlive the engine. */
    cml_status (*open)(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                       const struct cml_engine_options *options, void **self, struct cml_error *err);
    /* Flies pieces of the work until there are no more, at most CML_TALLY_MAX_PHOTONS packets in all, and
     * passes their tallies to work->add. After a failure some scores of the pieces that were flown may be
     * missing, so the engine may only be closed. CML_E_STOPPED: packets that do not end were given up
     * (cml_engine_gives_up). */
    cml_status (*run)(void *self, const struct cml_work *work, struct cml_error *err);
    /* Flies packet `index` alone. on_event may be NULL. */
    cml_status (*trace)(void *self, uint64_t index, cml_trace_function *on_event, void *context,
                        struct cml_fate_record *record, struct cml_error *err);
    /* Finds the ends of packets [first, first + count) without a tally: records[count]. */
    cml_status (*fates)(void *self, uint64_t first, uint64_t count, struct cml_fate_record *records,
                        struct cml_error *err);
    int (*threads)(const void *self); /* number of threads; NULL: as many as it takes unless told */
    double (*bytes)(const struct cml_scene *scene,
                    const struct cml_surface_set *surfaces); /* bytes that `open` takes, without tallies */
    void (*close)(void *self);
};

/* Adds packets [first, first + count) to a tally, which has the grid of the engine's scene and options. count
 * <= CML_TALLY_MAX_PHOTONS. */
CML_NODISCARD cml_status cml_engine_run_range(const struct cml_engine *engine, void *self, uint64_t first,
                                              uint64_t count, struct cml_tally *tally, struct cml_error *err);

/* Returns the size of a piece for cml_work.next: the number of packets, of the `left` ones, that one of
 * `takers` threads gets if it asks for `most`. */
uint64_t cml_piece_size(uint64_t most, int takers, uint64_t left);

/* Returns the grid of a run's tallies: all that scene and options ask for. surfaces NULL: without facets. */
struct cml_tally_grid cml_engine_grid(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                      const struct cml_engine_options *options);

const char *cml_fate_name(int fate);
const char *cml_lost_cause_name(int cause);
