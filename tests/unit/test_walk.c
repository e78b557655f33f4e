/* The events of kernels/walk.h that keep a mean: roulette and the rounding of absorbed weight.
 * SPDX-License-Identifier: MIT */
#include "walk.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static const struct cml_stream stream = {{7, 0, 0, 0}};

/* N = 1e6; mean weight after roulette against the weight before: z below 4.9. */
static void roulette_keeps_the_mean_weight(void **state)
{
    (void)state;
    const cml_u32 w = CML_ROULETTE_THRESHOLD - 1;
    const double n = 1e6, p = 0.1;
    double sum = 0;
    for (cml_u64 i = 0; i < (cml_u64)n; i++) {
        struct cml_packet packet = {.w = w, .draw = cml_draw(stream, i, CML_PURPOSE_INTERACTION, 0)};
        cml_roulette(&packet);
        assert_int_equal(packet.w, packet.fate == CML_FATE_ALIVE ? 10 * w : 0);
        assert_int_equal(w + packet.gained, packet.w + packet.roulette);
        sum += packet.w;
    }
    assert_true(fabs(sum / n / w - 1) < 4.9 * sqrt((1 - p) / p / n));
}

static void heavy_packets_play_no_roulette(void **state)
{
    (void)state;
    struct cml_packet packet = {.w = CML_ROULETTE_THRESHOLD, .draw.w[3] = 0xffffffffu};
    cml_roulette(&packet);
    assert_int_equal(packet.w, CML_ROULETTE_THRESHOLD);
    assert_int_equal(packet.fate, CML_FATE_ALIVE);
}

/* Far less than one unit per interaction is still absorbed in the mean: exactly over the 256 values of the
 * random bits, to 1/512 unit. */
static void absorbed_weight_is_rounded_without_bias(void **state)
{
    (void)state;
    static const real absorb[] = {(real)1e-7, (real)3e-6, (real)0.01, (real)0.37};
    for (int k = 0; k < 4; k++) {
        const cml_u32 w = 214748;
        double sum = 0;
        for (cml_u32 word = 0; word < 256; word++) sum += cml_absorbed_part(w, absorb[k], word);
        assert_true(fabs(sum / 256 - (double)w * absorb[k]) < 1.0 / 512 + 1e-7 * (double)w * absorb[k]);
    }
    assert_int_equal(cml_absorbed_part(12345, 1, 0), 12345);
    assert_int_equal(cml_absorbed_part(12345, 0, 255), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(roulette_keeps_the_mean_weight),
        cmocka_unit_test(heavy_packets_play_no_roulette),
        cmocka_unit_test(absorbed_weight_is_rounded_without_bias),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
