/* The photons of a run are dealt out in turn to 64 batches: photon i is point i / 64 of batch i mod 64. How
 * many photons there are does not matter, so a longer run has all packets of a shorter one, in the same
 * batches. Standard errors come from the spread of the batches. SPDX-License-Identifier: MIT */
#ifndef CML_BATCHES_H
#define CML_BATCHES_H

#define CML_LOG2_BATCHES 6
#define CML_NUM_BATCHES (1 << CML_LOG2_BATCHES)

#endif
