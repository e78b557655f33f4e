/* Random reliefs: Gaussian heights of a given slope and correlation length, one period of a tile. They stand
 * for ground glass, matt paint and paper whose heights nobody measured.
 *
 *     white noise --FFT--> noise of each wave number k --times sqrt(power(k))--> inverse FFT --> heights
 *
 *     power(k)  gaussian    exp(-(k L)^2 / 4)             autocorrelation exp(-(r / L)^2)
 *               fractal:H   (1 + (k L)^2)^-(1 + H)        self-affine below L with Hurst exponent H
 *               exponential fractal:0.5                   autocorrelation exp(-r / L)
 *
 * The heights are then scaled until the rms gradient of the facets is the requested slope, and moved until
 * their mean over the facets is 0. Sources: Garcia, Stoll, Phys. Rev. Lett. 52, 1798 (1984) for the filter;
 * Palasantzas, Phys. Rev. B 48, 14472 (1993) for the fractal spectrum. SPDX-License-Identifier: MIT */
#pragma once

#include "scene/heightmap/tile.h"

#define CML_RELIEF_STEPS 10 /* samples per correlation length */

/* The parameters of a random relief. */
struct cml_random_relief {
    double slope;  /* rms gradient of the facets [-], called Sdq in ISO 25178 */
    double length; /* correlation length L, cm */
    double hurst;  /* Hurst exponent of a fractal relief, 0 < H <= 1; 0: the gaussian spectrum */
    int points;    /* number of samples along each axis; a power of two */
    /* Seed of the noise; equal seeds and points give equal reliefs, but for the C library's rounding. */
    uint64_t seed;
};

/* Makes a relief of points x points heights, cm, upwards, spaced L / CML_RELIEF_STEPS, with its middle at x =
 * y = 0. Free the map with cml_heightmap_clear. CML_E_INPUT if memory runs out; the map is then cleared. */
CML_NODISCARD cml_status cml_random_relief_make(const struct cml_random_relief *relief,
                                                struct cml_heightmap *map, struct cml_error *err);

/* Measures the height, slope and correlation length of one period of a tile. */
void cml_random_relief_measure(const struct cml_heightmap *tile, struct cml_drawn_relief *drawn);
