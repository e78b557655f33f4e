/* A relief that is drawn by lot: Gaussian heights of a stated slope and correlation length, one period of a
 * tile. Ground glass, matt paint and paper, of which nobody measured the heights, as geometry.
 *
 *     white noise --FFT--> noise of each wave number k --times sqrt(power(k))--> inverse FFT --> heights
 *
 *     power(k)  gaussian    exp(-(k L)^2 / 4)             autocorrelation exp(-(r / L)^2)
 *               fractal:H   (1 + (k L)^2)^-(1 + H)        self-affine below L with Hurst exponent H
 *               exponential fractal:0.5                   autocorrelation exp(-r / L)
 *
 * The heights are then moved and scaled: the mean height of the facets is 0, and their rms gradient is the
 * slope asked for. Sources: Garcia, Stoll, Phys. Rev. Lett. 52, 1798 (1984) for the filter; Palasantzas,
 * Phys. Rev. B 48, 14472 (1993) for the fractal spectrum.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/heightmap/tile.h"

#define CML_RELIEF_STEPS 10 /* samples in a correlation length */

struct cml_random_relief {
    double slope;  /* rms gradient of the facets [-], ISO 25178's Sdq */
    double length; /* correlation length L, cm */
    double hurst;  /* H of a fractal relief, 0 < H <= 1; 0: the gaussian spectrum */
    int points;    /* samples along each axis; a power of two */
    uint64_t seed; /* the same seed and points: the same relief, but for the rounding of the C library */
};

/* Heights up in cm, points x points of them, L / CML_RELIEF_STEPS apart, the middle at x = y = 0. Free the
 * map with cml_heightmap_clear. CML_E_INPUT for memory; then the map is cleared. */
CML_NODISCARD cml_status cml_random_relief_make(const struct cml_random_relief *relief,
                                                struct cml_heightmap *map, struct cml_error *err);

/* Measures one period of a tile. */
void cml_random_relief_measure(const struct cml_heightmap *tile, struct cml_drawn_relief *drawn);
