/* Facts that are found once, before packets fly: media as lanes hold them, and the common history of all
 * packets of a pencil beam. Above a curved boundary, all packets of a pencil beam meet it at the same place
 * and angle. The search for this place is done once (at a vertex of a mesh it is slow, because all facets
 * around it must be examined), and so is the fate of packets that go through. None of this is hot, so it is
 * compiled once and not, like the bundle's loops, for each level of the processor.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle_flight.h"

/* Returns medium m as lanes hold it. */
struct cml_lane_medium cml_lane_medium_of(const struct cml_world *world, int m);

/* Fills first_hit_known, first_hit, reflectance, enters and inside, from world, to, pencil and start. */
void cml_find_first_hit(struct cml_flight *f);

/* Fills enters and inside for packets that the queue places above a plane, through which it also takes them.
 * From world, to, queue_places and start. Place and direction of `inside` are those of one of the packets. */
void cml_find_entry(struct cml_flight *f);

/* Fills known if packets start inside below a mesh; world then has it. After cml_find_first_hit. */
void cml_find_known_path(struct cml_flight *f);

/* Fills ballistic. After cml_find_first_hit. */
void cml_find_ballistic(struct cml_flight *f);
