/* How much of the random cases of a test a build with sanitizers flies. They look at addresses and undefined
 * operations, which every case of a kind shares, and take ten times as long: every kind of case, shape and
 * mesh is there, with fewer of each. How rare a wrong result is, builds without them tell.
 * SPDX-License-Identifier: MIT */
#ifndef SANITIZED_H
#define SANITIZED_H

#ifndef __has_feature
#define __has_feature(name) 0
#endif
#if defined __SANITIZE_ADDRESS__ || __has_feature(address_sanitizer)
enum { SANITIZED = 1 };
#else
enum { SANITIZED = 0 };
#endif

/* One in so many is flown. */
enum { SANITIZED_STEP = SANITIZED ? 8 : 1 };

/* The number of cases, of which there are `all` without sanitizers. */
static inline int repeats(int all)
{
    return all / SANITIZED_STEP;
}

#endif
