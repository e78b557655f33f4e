/* What is worked out once, before packets fly: media as lanes hold them, and what all packets of a pencil
 * beam have in common. Those that start above a boundary that is no plane all meet it at the same place and
 * angle: both are asked for once (at a vertex of a mesh, where all facets around it must be looked at, the
 * search takes long), and so is what becomes of the packets that go through. None of this is hot, so it is
 * compiled once and not, like the bundle's loops, for each level of the processor. SPDX-License-Identifier:
 * MIT */
#pragma once

#include "engine/cpu/bundle_flight.h"

/* Medium m, 0..num_layers + 1, as lanes hold it. */
struct cml_lane_medium cml_lane_medium_of(const struct cml_world *world, int m);

/* From world, to, pencil and start: fills first_hit_known, first_hit, reflectance, enters and inside. */
void cml_find_first_hit(struct cml_flight *f);

/* From world, to, queue_places and start: of packets that the queue places above a plane, through which it
 * takes them, fills enters and inside, whose place and direction are those of one of them. */
void cml_find_entry(struct cml_flight *f);

/* After cml_find_first_hit: fills known, if those that are inside are below a mesh, and then world knows it.
 */
void cml_find_known_path(struct cml_flight *f);

/* After cml_find_first_hit: fills ballistic. */
void cml_find_ballistic(struct cml_flight *f);
