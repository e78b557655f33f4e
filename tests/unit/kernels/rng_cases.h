/* Cases of kernels/rng.h (random numbers of packets), compiled once in float and once in double.
 * SPDX-License-Identifier: MIT */
#include "lib/dice.h"

#include <Random123/threefry.h>

static const struct cml_stream stream = {.key = {42u, 7u, 3u, 0u}};

static struct cml_block from_random123(int rounds, const uint32_t key[4], const uint32_t counter[4])
{
    const threefry4x32_key_t k = {{key[0], key[1], key[2], key[3]}};
    const threefry4x32_ctr_t c = {{counter[0], counter[1], counter[2], counter[3]}};
    const threefry4x32_ctr_t r = threefry4x32_R((unsigned)rounds, c, k);
    const struct cml_block block = {{r.v[0], r.v[1], r.v[2], r.v[3]}};
    return block;
}

static void the_oracle_gives_its_published_vectors(void **state)
{
    (void)state;
    static const struct {
        int rounds;
        uint32_t counter[4], key[4], out[4];
    } kat[] = {
        {13, {0}, {0}, {0x531c7e4fu, 0x39491ee5u, 0x2c855a92u, 0x3d6abf9au}},
        {20, {0}, {0}, {0x9c6ca96au, 0xe17eae66u, 0xfc10ecd4u, 0x5256a7d8u}},
        {13,
         {0x243f6a88u, 0x85a308d3u, 0x13198a2eu, 0x03707344u},
         {0xa4093822u, 0x299f31d0u, 0x082efa98u, 0xec4e6c89u},
         {0x4aa71d8fu, 0x734738c2u, 0x431fc6a8u, 0xae6debf1u}},
        {20,
         {0x243f6a88u, 0x85a308d3u, 0x13198a2eu, 0x03707344u},
         {0xa4093822u, 0x299f31d0u, 0x082efa98u, 0xec4e6c89u},
         {0x59cd1dbbu, 0xb8879579u, 0x86b5d00cu, 0xac8b6d84u}},
    };
    for (int i = 0; i < COUNT(kat); i++) {
        const struct cml_block block = from_random123(kat[i].rounds, kat[i].key, kat[i].counter);
        for (int k = 0; k < 4; k++) assert_int_equal(block.w[k], kat[i].out[k]);
    }
}

static void threefry_is_random123s_with_12_rounds(void **state)
{
    (void)state;
    struct dice dice = dice_new(1);
    for (int n = 0; n < 20000; n++) {
        struct cml_stream s;
        uint32_t c[4];
        for (int k = 0; k < 4; k++) s.key[k] = n % 7 ? dice_word(&dice) : 0xffffffffu * (unsigned)(n & 1);
        for (int k = 0; k < 4; k++) c[k] = n % 5 ? dice_word(&dice) : 0xffffffffu * (unsigned)(n & 1);
        const struct cml_block a = cml_threefry(s, c[0], c[1], c[2], c[3]), b = from_random123(12, s.key, c);
        assert_memory_equal(&a, &b, sizeof a);
    }
}

static int compare_blocks(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(struct cml_block));
}

/* No two draws share a block of random numbers. The photon indices tested include some with equal lower 32
 * bits, and the runs include neighbours. */
static void no_block_serves_two_purposes(void **state)
{
    (void)state;
    static struct cml_block block[2 * 5 * 40 * 200];
    size_t n = 0;
    for (uint32_t run = 0; run < 2; run++) {
        const struct cml_stream s = {.key = {1u, 0u, run, 0u}};
        for (int purpose = CML_PURPOSE_INTERACTION; purpose <= CML_PURPOSE_SHIFT; purpose++)
            for (uint64_t photon = 0; photon < 40; photon++)
                for (uint32_t event = 0; event < 200; event++)
                    block[n++] =
                        cml_draw(s, photon % 20 + (photon / 20 << 32), (enum cml_purpose)purpose, event);
    }
    assert_int_equal(n, COUNT(block));
    qsort(block, n, sizeof *block, compare_blocks);
    for (size_t i = 1; i < n; i++) assert_true(compare_blocks(&block[i - 1], &block[i]) != 0);
}

static void a_uniform_lies_in_the_half_open_unit_interval(void **state)
{
    (void)state;
    struct dice dice = dice_new(2);
    static const uint32_t edges[] = {0, 1, 2, 0xffffffu, 0x1000001u, 0x7fffffffu, 0xfffffeffu, 0xffffffffu};
    for (int n = 0; n < 1000000; n++) {
        const uint32_t word = n < COUNT(edges) ? edges[n] : dice_word(&dice);
        const double u = (double)cml_uniform(word), exact = ((double)word + 0.5) * 0x1p-32;
        assert_true(u > 0 && u <= 1);
        assert_true(fabs(u - exact) <= (double)CML_EPSILON * exact);
    }
}

static void a_symmetric_uniform_is_exact_and_odd(void **state)
{
    (void)state;
    struct dice dice = dice_new(3);
    static const uint32_t edges[] = {0, 255, 256, 0x7fffffffu, 0x80000000u, 0xffffff00u, 0xffffffffu};
    for (int n = 0; n < 1000000; n++) {
        const uint32_t word = n < COUNT(edges) ? edges[n] : dice_word(&dice);
        const double s = (double)cml_uniform_symmetric(word);
        assert_true(s == (2.0 * ((int32_t)word >> 8) + 1) * 0x1p-24);
        assert_true(s > -1 && s < 1);
        assert_true((double)cml_uniform_symmetric(~word) == -s);
    }
}

/* Chi-square tests of every word of the blocks, over the events of one photon or over photons at one
 * event. They test the upper byte through cml_uniform, the lower byte (which rounds weights), and pairs of
 * successive upper four bits. */
static void check_flatness(bool over_photons, int word)
{
    enum { blocks = 200000 };
    long upper[256] = {0}, lower[256] = {0}, pair[256] = {0};
    uint32_t before = 0;
    for (uint32_t i = 0; i < blocks; i++) {
        const struct cml_block block = over_photons ? cml_draw(stream, i, CML_PURPOSE_INTERACTION, 5)
                                                    : cml_draw(stream, 5, CML_PURPOSE_INTERACTION, i);
        const uint32_t w = block.w[word];
        const int bin = (int)((double)cml_uniform(w) * 256);
        upper[bin < 256 ? bin : 255]++;
        lower[w & 255]++;
        if (i & 1) pair[(before >> 28 << 4) | w >> 28]++;
        before = w;
    }
    assert_flat("upper byte", upper, 256);
    assert_flat("lower byte", lower, 256);
    assert_flat("pairs", pair, 256);
}

static void uniforms_over_events_are_flat(void **state)
{
    (void)state;
    for (int word = 0; word < 4; word++) check_flatness(false, word);
}

static void uniforms_over_photons_are_flat(void **state)
{
    (void)state;
    for (int word = 0; word < 4; word++) check_flatness(true, word);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_oracle_gives_its_published_vectors),
        cmocka_unit_test(threefry_is_random123s_with_12_rounds),
        cmocka_unit_test(no_block_serves_two_purposes),
        cmocka_unit_test(a_uniform_lies_in_the_half_open_unit_interval),
        cmocka_unit_test(a_symmetric_uniform_is_exact_and_odd),
        cmocka_unit_test(uniforms_over_events_are_flat),
        cmocka_unit_test(uniforms_over_photons_are_flat),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
