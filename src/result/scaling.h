/* Scaling of tallies to the values that MCML writes: weight per packet divided by the measure of a bin. Rd_r
 * and Tt_r are per area, Rd_a and Tt_a per solid angle, Rd_ra and Tt_ra per area and projected solid angle,
 * A_z per depth, A_rz per volume. All are as in MCML 1.2.2 (ScaleRdTt, ScaleA), because readers expect its
 * values, although those over angles are not exact (see each function). The manual (Wang and Jacques, 1992)
 * has them as eqs 4.9 to 4.18 and 4.23 to 4.26. Its solid angle, eq 4.12, is exact, but the program divides
 * Rd_a and Tt_a by that of cml_solid_angle. All functions take the width of a bin and its number from 0, so
 * that they need no scene. SPDX-License-Identifier: MIT */
#pragma once

/* Returns the width of one of na angle bins between the outward vertical and the horizontal, rad. */
double cml_angle_width(int na);

/* Returns the area of radial bin ir, cm2: 2 pi r dr at the middle of the bin, which is exact. */
double cml_ring_area(double dr, int ir);

/* Returns the solid angle of angular bin ia, sr: 2 pi sin(a) da at the middle of the bin. The exact value is
 * smaller by sin(da/2) / (da/2): by 0.01 % for 30 bins, by 10 % for one. */
double cml_solid_angle(double da, int ia);

/* Returns the solid angle of angular bin ia times the cosine to the vertical, sr: 2 pi sin(da/2) sin(2a) at
 * the middle of the bin. The exact value is smaller by cos(da/2): by 0.03 % for 30 bins, by 29 % for one. */
double cml_projected_solid_angle(double da, int ia);

/* Returns the solid angle of a bin of directions, sr. There are nt equal bins of the angle from the vertical,
 * of which this is number it, and np bins of the azimuth. */
double cml_direction_solid_angle(int nt, int np, int it);
