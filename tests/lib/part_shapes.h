/* Closed meshes of several parts for the tests, and an oracle of their inside that shares nothing with the
 * program: solid angles in long double.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "lib/dice.h"

#include "geometry/mesh.h"
#include "geometry/vec3.h"

#include <float.h>
#include <math.h>

enum { SOUP_PARTS = 100, SOUP_VERTICES = 4000, SOUP_TRIANGLES = 8000 };

/* A mesh of several closed parts. Facets of a part turn counter-clockwise seen from outside the part. */
struct soup {
    int parts, num_vertices, num_triangles;
    double vertex[SOUP_VERTICES][3];
    uint32_t triangle[SOUP_TRIANGLES][3];
    int part[SOUP_TRIANGLES];
    int first[SOUP_PARTS + 1]; /* first triangle of each part */
    bool unite; /* inside means inside of any part; otherwise inside of an odd number of parts */
};

static inline void soup_end_part(struct soup *soup)
{
    for (int t = soup->first[soup->parts]; t < soup->num_triangles; t++) soup->part[t] = soup->parts;
    soup->first[++soup->parts] = soup->num_triangles;
}

static inline void soup_add(struct soup *soup, uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t corner[3] = {a, b, c};
    memcpy(soup->triangle[soup->num_triangles++], corner, sizeof corner);
}

/* Adds a stone: rings of vertices about a centre, each moved along its radius. From the centre, the whole
 * surface is visible. */
static inline void soup_stone(struct soup *soup, struct dice *dice, const double centre[3], int rings,
                              double least, double most)
{
    const int m = 2 * rings, base = soup->num_vertices, last = base + 1 + (rings - 1) * m;
    for (int i = 0; i <= rings; i++)
        for (int k = 0; k < (i % rings ? m : 1); k++) {
            const double tilt = 3.141592653589793 * i / rings, turn = 3.141592653589793 * k / rings;
            const double r = dice_between(dice, least, most),
                         u[3] = {sin(tilt) * cos(turn), sin(tilt) * sin(turn), cos(tilt)};
            for (int j = 0; j < 3; j++) soup->vertex[soup->num_vertices][j] = centre[j] + r * u[j];
            soup->num_vertices++;
        }
    for (int k = 0; k < m; k++) {
        const uint32_t a = (uint32_t)(base + 1 + k), b = (uint32_t)(base + 1 + (k + 1) % m);
        const uint32_t down = (uint32_t)((rings - 2) * m);
        soup_add(soup, (uint32_t)base, a, b);
        soup_add(soup, (uint32_t)last, b + down, a + down);
        for (uint32_t j = 0; j < down; j += (uint32_t)m) {
            soup_add(soup, a + j, a + j + (uint32_t)m, b + j + (uint32_t)m);
            soup_add(soup, a + j, b + j + (uint32_t)m, b + j);
        }
    }
    soup_end_part(soup);
}

/* Adds a box with edges along the axes. */
static inline void soup_box(struct soup *soup, const double lower[3], const double upper[3])
{
    static const uint32_t sides[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                         {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    const uint32_t base = (uint32_t)soup->num_vertices;
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++) soup->vertex[(int)base + i][k] = i >> (2 - k) & 1 ? upper[k] : lower[k];
    soup->num_vertices += 8;
    for (int s = 0; s < 6; s++) {
        const uint32_t *v = sides[s];
        soup_add(soup, base + v[0], base + v[1], base + v[2]);
        soup_add(soup, base + v[0], base + v[2], base + v[3]);
    }
    soup_end_part(soup);
}

/* Adds the last part again, scaled by a factor towards a centre. */
static inline void soup_repeat(struct soup *soup, const double centre[3], double factor)
{
    const int first = soup->first[soup->parts - 1], end = soup->num_triangles;
    uint32_t least = UINT32_MAX;
    for (int t = first; t < end; t++)
        for (int k = 0; k < 3; k++) least = soup->triangle[t][k] < least ? soup->triangle[t][k] : least;
    const uint32_t count = (uint32_t)soup->num_vertices - least;
    for (uint32_t i = least; i < least + count; i++)
        for (int k = 0; k < 3; k++)
            soup->vertex[i + count][k] = centre[k] + factor * (soup->vertex[i][k] - centre[k]);
    soup->num_vertices += (int)count;
    for (int t = first; t < end; t++)
        soup_add(soup, soup->triangle[t][0] + count, soup->triangle[t][1] + count,
                 soup->triangle[t][2] + count);
    soup_end_part(soup);
}

/* Returns the number of times that a part encloses p: the solid angles of its facets [van Oosterom and
 * Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125] over 4 pi. */
static inline int soup_winding(const struct soup *soup, int part, const double p[3])
{
    long double sum = 0;
    for (int t = soup->first[part]; t < soup->first[part + 1]; t++) {
        long double d[3][3], size[3], pair[3];
        for (int i = 0; i < 3; i++) {
            for (int k = 0; k < 3; k++)
                d[i][k] = (long double)soup->vertex[soup->triangle[t][i]][k] - (long double)p[k];
            size[i] = sqrtl(d[i][0] * d[i][0] + d[i][1] * d[i][1] + d[i][2] * d[i][2]);
        }
        for (int i = 0; i < 3; i++) {
            const long double *a = d[(i + 1) % 3], *b = d[(i + 2) % 3];
            pair[i] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        }
        const long double volume = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) +
                                   d[0][1] * (d[1][2] * d[2][0] - d[1][0] * d[2][2]) +
                                   d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
        sum += 2 * atan2l(volume, size[0] * size[1] * size[2] + pair[0] * size[0] + pair[1] * size[1] +
                                      pair[2] * size[2]);
    }
    return (int)lrintl(sum / (4 * 3.14159265358979323846L));
}

static inline bool soup_holds(const struct soup *soup, const double p[3])
{
    int parts = 0;
    for (int k = 0; k < soup->parts; k++) parts += soup_winding(soup, k, p) != 0;
    return soup->unite ? parts > 0 : parts % 2 == 1;
}

static inline double soup_segment_distance(const double a[3], const double b[3], const double p[3])
{
    double ab[3], ap[3];
    cml_vec3_subtract(b, a, ab);
    cml_vec3_subtract(p, a, ap);
    const double s = cml_vec3_dot(ab, ap) / cml_vec3_dot(ab, ab);
    cml_vec3_add_scaled(ap, -fmax(0, fmin(1, s)), ab, ap);
    return cml_vec3_length(ap);
}

/* Returns the distance from p to the nearest facet of all parts. */
static inline double soup_distance(const struct soup *soup, const double p[3])
{
    double least = INFINITY;
    for (int t = 0; t < soup->num_triangles; t++) {
        const double *v[3];
        double normal[3], from[3], edge[3], across[3];
        bool over = true;
        for (int k = 0; k < 3; k++) v[k] = soup->vertex[soup->triangle[t][k]];
        cml_vec3_area(v[0], v[1], v[2], normal);
        cml_vec3_normalise(normal);
        for (int k = 0; k < 3; k++) {
            cml_vec3_subtract(v[(k + 1) % 3], v[k], edge);
            cml_vec3_subtract(p, v[k], from);
            cml_vec3_cross(edge, from, across);
            over = over && cml_vec3_dot(across, normal) >= 0;
            least = fmin(least, soup_segment_distance(v[k], v[(k + 1) % 3], p));
        }
        if (over) least = fmin(least, fabs(cml_vec3_dot(from, normal)));
    }
    return least;
}

/* Returns a prepared mesh of the soup, owned by the caller. About half of its triangles, chosen at random,
 * are turned before preparation. */
static inline struct cml_mesh soup_mesh(const struct soup *soup, struct dice *dice,
                                        struct cml_mesh_notes *notes)
{
    struct cml_mesh mesh = {.num_vertices = (size_t)soup->num_vertices,
                            .num_triangles = (size_t)soup->num_triangles,
                            .closed = true,
                            .unite = soup->unite};
    struct cml_error err = {CML_OK, ""};
    mesh.vertex = malloc(mesh.num_vertices * sizeof *mesh.vertex);
    mesh.triangle = malloc(mesh.num_triangles * sizeof *mesh.triangle);
    assert_true(mesh.vertex && mesh.triangle);
    memcpy(mesh.vertex, soup->vertex, mesh.num_vertices * sizeof *mesh.vertex);
    memcpy(mesh.triangle, soup->triangle, mesh.num_triangles * sizeof *mesh.triangle);
    for (size_t t = 0; t < mesh.num_triangles; t++) {
        if (dice_below(dice, 2)) continue;
        const uint32_t second = mesh.triangle[t][1];
        mesh.triangle[t][1] = mesh.triangle[t][2];
        mesh.triangle[t][2] = second;
    }
    const cml_status status = cml_mesh_prepare(&mesh, NULL, notes, &err);
    assert_string_equal(err.text, "");
    assert_int_equal(status, CML_OK);
    return mesh;
}
