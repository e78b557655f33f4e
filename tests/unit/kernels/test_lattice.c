/* Tests of the lattice of low-discrepancy points: its formula, the draws that use it, how evenly its
 * points lie, and its errors in integrals. SPDX-License-Identifier: MIT */
#include "lib/dice.h"

#include "lattice.h"

enum { DIMENSIONS = CML_LATTICE_DIMENSIONS, BLOCKS = CML_LATTICE_BLOCKS, BATCHES = CML_NUM_BATCHES };

static struct cml_stream stream_of(uint32_t seed)
{
    const struct cml_stream stream = {.key = {seed, 7u, 3u, 0u}, .lattice = CML_LATTICE_EVENTS};
    return stream;
}

/* Dimensions of the lattice in use: all but dimension 7. */
static const int used[] = {0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 11, 12, 13};

/* Draws the words of a packet, by dimension, as the walk does. */
static void draw_all(struct cml_stream stream, uint64_t photon, uint32_t word[DIMENSIONS])
{
    const struct cml_block launch = cml_draw_launch(stream, photon, 1);
    for (uint32_t e = 0; e < CML_LATTICE_EVENTS; e++) {
        const struct cml_block block = cml_draw_interaction(stream, photon, e);
        for (int k = 0; k < 3; k++) word[4 * e + (uint32_t)k] = block.w[k];
    }
    word[CML_LATTICE_REFLECTION] = cml_draw_reflection(stream, photon, 0);
    word[CML_LATTICE_SECOND_REFLECTION] = cml_draw_reflection(stream, photon, 1);
    word[CML_LATTICE_LAUNCH_RADIUS] = launch.w[0];
    word[CML_LATTICE_LAUNCH_POLAR] = launch.w[2];
}

/* Draws random words (Threefry) instead of lattice words, by dimension. */
static void draw_random(struct cml_stream stream, uint64_t photon, uint32_t word[DIMENSIONS])
{
    stream.lattice = 0;
    draw_all(stream, photon, word);
}

/* Returns one of many photon indices: neighbours, distant ones, and those on both sides of each multiple
 * of 2^32 points. */
static uint64_t some_photon(struct dice *dice, int n)
{
    static const uint64_t edges[] = {
        0, 1, 63, 64, 65, 127, 128, ((uint64_t)1 << 38) - 1, (uint64_t)1 << 38, ((uint64_t)1 << 48) - 1};
    if (n < COUNT(edges)) return edges[n];
    const uint64_t high = dice_word(dice), low = dice_word(dice);
    return (high << 32 | low) >> (16 + dice_below(dice, 40));
}

/* ---- what is drawn ---- */

/* Returns the bits of a point's index reversed, one by one. */
static uint64_t reversed_bits(uint64_t point)
{
    uint64_t reversed = 0;
    for (int bit = 0; bit < 32; bit++)
        if (point >> bit & 1) reversed += (uint64_t)1 << (31 - bit);
    return reversed;
}

/* Returns the word of the lattice by its rule: (reverse(p) z_d + shift_d) mod 2^32, with random bits
 * below. */
static uint32_t word_on_paper(struct cml_stream stream, uint64_t photon, uint32_t d, uint32_t random)
{
    const uint64_t point = photon / 64, two_32 = (uint64_t)1 << 32;
    const struct cml_block shifts =
        cml_threefry(stream, (uint32_t)(photon % 64), (uint32_t)(point / two_32), d / 4, CML_PURPOSE_SHIFT);
    const uint64_t word = reversed_bits(point % two_32) * cml_lattice_generator(d) + shifts.w[d % 4];
    return (uint32_t)(word % two_32 / 256 * 256) + random % 256;
}

static void words_are_those_of_the_formula(void **state)
{
    (void)state;
    struct dice dice = dice_new(1);
    for (int n = 0; n < 20000; n++) {
        const struct cml_stream stream = stream_of(dice_word(&dice));
        const uint64_t photon = some_photon(&dice, n);
        uint32_t word[DIMENSIONS], random[DIMENSIONS];
        draw_all(stream, photon, word);
        draw_random(stream, photon, random);
        for (int i = 0; i < COUNT(used); i++) {
            const uint32_t d = (uint32_t)used[i];
            assert_int_equal(word[d], word_on_paper(stream, photon, d, random[d]));
        }
    }
}

/* Draws without a lattice dimension come from Threefry: roulette of the first interactions, all later
 * events, all but the first two reflections, and the azimuths of the launch. */
static void everything_else_is_threefrys(void **state)
{
    (void)state;
    struct dice dice = dice_new(2);
    for (int n = 0; n < 20000; n++) {
        const struct cml_stream stream = stream_of(dice_word(&dice));
        const uint64_t photon = some_photon(&dice, n);
        for (uint32_t e = 0; e < CML_LATTICE_EVENTS + 4; e++) {
            const struct cml_block block = cml_draw_interaction(stream, photon, e),
                                   random = cml_draw(stream, photon, CML_PURPOSE_INTERACTION, e);
            assert_int_equal(block.w[3], random.w[3]);
            if (e >= CML_LATTICE_EVENTS) assert_memory_equal(&block, &random, sizeof block);
        }
        for (uint32_t c = 2; c < 6; c++)
            assert_int_equal(cml_draw_reflection(stream, photon, c),
                             cml_draw(stream, photon, CML_PURPOSE_BOUNDARY, c).w[0]);
        const struct cml_block launch = cml_draw_launch(stream, photon, 0),
                               random = cml_draw(stream, photon, CML_PURPOSE_LAUNCH, 0);
        assert_memory_equal(&launch.w[1], &random.w[1], 3 * sizeof launch.w[1]);
        const struct cml_block spread = cml_draw_launch(stream, photon, 1);
        assert_int_equal(spread.w[0], launch.w[0]);
        assert_int_equal(spread.w[1], random.w[1]);
        assert_int_equal(spread.w[3], random.w[3]);
    }
}

static void without_a_lattice_all_is_threefrys(void **state)
{
    (void)state;
    struct dice dice = dice_new(3);
    for (int n = 0; n < 20000; n++) {
        struct cml_stream stream = stream_of(dice_word(&dice));
        stream.lattice = 0;
        const uint64_t photon = some_photon(&dice, n);
        const uint32_t event = dice_word(&dice) % 5;
        const struct cml_block interaction = cml_draw_interaction(stream, photon, event),
                               launch = cml_draw_launch(stream, photon, 1),
                               random_launch = cml_draw(stream, photon, CML_PURPOSE_LAUNCH, 0),
                               random = cml_draw(stream, photon, CML_PURPOSE_INTERACTION, event);
        assert_memory_equal(&interaction, &random, sizeof random);
        assert_memory_equal(&launch, &random_launch, sizeof launch);
        assert_int_equal(cml_draw_reflection(stream, photon, event),
                         cml_draw(stream, photon, CML_PURPOSE_BOUNDARY, event).w[0]);
    }
}

static int compare_words(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static struct cml_block shifts_of(struct cml_stream stream, uint64_t photon, uint32_t e)
{
    return cml_lattice_shifts(stream, (uint32_t)photon, (uint32_t)(photon >> 32), e);
}

/* Shifts differ for neighbouring seeds, runs, batches and dimensions, and for points beyond 2^32. Two of
 * 7680 random words would agree with a chance of 0.7 %; these do not. */
static void every_shift_is_another(void **state)
{
    (void)state;
    static uint32_t shift[2 * 2 * 2 * 2 * 30 * BLOCKS * 4];
    int n = 0;
    for (uint32_t which = 0; which < 16; which++)
        for (uint64_t batch = 0; batch < 30; batch++) {
            const struct cml_stream stream = {.key = {which & 1, which >> 1 & 1, which >> 2 & 1, 0}};
            const uint64_t photon = batch + ((uint64_t)(which >> 3) << 38);
            for (uint32_t e = 0; e < BLOCKS; e++) {
                const struct cml_block shifts = shifts_of(stream, photon, e);
                for (int k = 0; k < 4; k++) shift[n++] = shifts.w[k];
            }
        }
    assert_int_equal(n, COUNT(shift));
    qsort(shift, COUNT(shift), sizeof *shift, compare_words);
    for (int i = 1; i < COUNT(shift); i++) assert_true(shift[i - 1] != shift[i]);
}

static void a_batch_keeps_its_shifts_for_all_its_points(void **state)
{
    (void)state;
    const struct cml_stream stream = stream_of(5);
    for (uint64_t point = 1; point < (uint64_t)1 << 32; point = 3 * point + 1)
        for (uint32_t e = 0; e < BLOCKS; e++) {
            const struct cml_block first = shifts_of(stream, 17, e),
                                   later = shifts_of(stream, point * BATCHES + 17, e);
            assert_memory_equal(&first, &later, sizeof first);
        }
}

/* ---- how evenly points lie ---- */

/* Chi-square test of the bytes of one point's words, over seeds and batches. */
static void check_flatness(uint64_t point)
{
    static long upper[DIMENSIONS][256], next[DIMENSIONS][256], lower[DIMENSIONS][256];
    memset(upper, 0, sizeof upper), memset(next, 0, sizeof next), memset(lower, 0, sizeof lower);
    for (uint32_t seed = 0; seed < 1000; seed++)
        for (uint64_t batch = 0; batch < BATCHES; batch++) {
            uint32_t word[DIMENSIONS];
            draw_all(stream_of(seed), point * BATCHES + batch, word);
            for (int i = 0; i < COUNT(used); i++) {
                const int d = used[i];
                upper[d][word[d] >> 24]++;
                next[d][word[d] >> 16 & 255]++;
                lower[d][word[d] & 255]++;
            }
        }
    for (int i = 0; i < COUNT(used); i++) {
        const int d = used[i];
        assert_flat("upper byte", upper[d], 256);
        assert_flat("next byte", next[d], 256);
        assert_flat("lower byte", lower[d], 256);
    }
}

static void every_word_is_flat_over_shifts(void **state)
{
    (void)state;
    check_flatness(0);
    check_flatness(12345);
    check_flatness(((uint64_t)1 << 32) + 1);
}

/* Checks that the points p 2^m to (p + 1) 2^m of a batch lie in different ones of 2^m equal cells, in each
 * dimension. */
static void check_cells(int m, uint64_t p)
{
    static bool taken[DIMENSIONS][1 << 16];
    memset(taken, 0, sizeof taken);
    for (uint64_t point = p << m; point < (p + 1) << m; point++) {
        uint32_t word[DIMENSIONS];
        draw_all(stream_of(9), point * BATCHES + 33, word);
        for (int i = 0; i < COUNT(used); i++) {
            const int d = used[i];
            bool *cell = &taken[d][(uint64_t)word[d] >> (32 - m)];
            if (*cell)
                fail_msg("dimension %d: two of points %llu 2^%d on in one cell", d, (unsigned long long)p, m);
            *cell = true;
        }
    }
}

static void a_power_of_two_of_points_fills_every_cell(void **state)
{
    (void)state;
    for (int m = 0; m <= 16; m++) {
        check_cells(m, 0);
        check_cells(m, 1);
        check_cells(m, 12345);
    }
}

/* ---- errors of integrals ---- */

/* Smooth functions of all dimensions in use, with mean 1. Later events count less. */
static double product_of_lines(const double u[DIMENSIONS])
{
    double product = 1;
    for (int i = 0; i < COUNT(used); i++) product *= 1 + 2.0 / (1 + used[i]) * (u[used[i]] - 0.5);
    return product;
}

static double product_of_waves(const double u[DIMENSIONS])
{
    double product = 1;
    for (int i = 0; i < COUNT(used); i++)
        product *= 1 + 1.0 / (1 + used[i]) * sin(6.283185307179586 * u[used[i]]);
    return product;
}

static double exponential(const double u[DIMENSIONS])
{
    double exponent = 0, mean = 1;
    for (int i = 0; i < COUNT(used); i++) {
        const int d = used[i];
        const double rate = 2.0 / (1 + d / 4);
        exponent -= rate * u[d];
        mean *= (1 - exp(-rate)) / rate;
    }
    return exp(exponent) / mean;
}

typedef double function(const double u[DIMENSIONS]);
static function *const functions[] = {product_of_lines, product_of_waves, exponential};

typedef void draw_words(struct cml_stream stream, uint64_t photon, uint32_t word[DIMENSIONS]);

/* Returns the error of the mean of f over the first points of a batch. */
static double error_of_mean(function *f, draw_words *draw, uint32_t seed, uint64_t batch, int points)
{
    double sum = 0, u[DIMENSIONS];
    for (int point = 0; point < points; point++) {
        uint32_t word[DIMENSIONS];
        draw(stream_of(seed), (uint64_t)point * BATCHES + batch, word);
        for (int i = 0; i < COUNT(used); i++) u[used[i]] = (word[used[i]] + 0.5) * 0x1p-32;
        sum += f(u);
    }
    return sum / points - 1;
}

static double mean_square_error(function *f, draw_words *draw, int points)
{
    double sum = 0;
    for (uint64_t batch = 0; batch < BATCHES; batch++) {
        const double error = error_of_mean(f, draw, 21, batch, points);
        sum += error * error;
    }
    return sum / BATCHES;
}

/* Errors of smooth functions are far below those of random points, also for 1562 points, which 1e5 photons
 * give a batch and which are no power of two. The bounds on the gain are half of what the lattice vector
 * in use reaches. */
static void smooth_functions_have_far_smaller_errors_than_at_random(void **state)
{
    (void)state;
    static const struct {
        int points;
        double gain[COUNT(functions)];
    } runs[] = {{64, {7, 40, 1.5}}, {1562, {35, 130, 2.7}}, {4096, {110, 900, 3}}};
    for (int r = 0; r < COUNT(runs); r++)
        for (int f = 0; f < COUNT(functions); f++) {
            const double even = mean_square_error(functions[f], draw_all, runs[r].points),
                         random = mean_square_error(functions[f], draw_random, runs[r].points);
            if (!(random > runs[r].gain[f] * even))
                fail_msg("function %d, %d points: variance only %g times less", f, runs[r].points,
                         random / even);
        }
}

/* The mean over shifts has no bias, also for few points, because each point alone is uniform. The tested
 * points include first ones of batches and others. */
static void means_over_shifts_have_no_bias(void **state)
{
    (void)state;
    enum { SHIFTS = 1000 };
    static const int points[] = {1, 7, 64};
    for (int p = 0; p < COUNT(points); p++)
        for (int f = 0; f < COUNT(functions); f++) {
            double sum = 0, squares = 0;
            for (uint32_t seed = 0; seed < SHIFTS; seed++) {
                const double error = error_of_mean(functions[f], draw_all, seed, seed % BATCHES, points[p]);
                sum += error;
                squares += error * error;
            }
            assert_near("mean over its error", sum / sqrt(squares), 0, 4);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(words_are_those_of_the_formula),
        cmocka_unit_test(everything_else_is_threefrys),
        cmocka_unit_test(without_a_lattice_all_is_threefrys),
        cmocka_unit_test(every_shift_is_another),
        cmocka_unit_test(a_batch_keeps_its_shifts_for_all_its_points),
        cmocka_unit_test(every_word_is_flat_over_shifts),
        cmocka_unit_test(a_power_of_two_of_points_fills_every_cell),
        cmocka_unit_test(smooth_functions_have_far_smaller_errors_than_at_random),
        cmocka_unit_test(means_over_shifts_have_no_bias),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
