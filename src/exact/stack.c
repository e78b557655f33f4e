/* Adds up layers and boundaries from below [van de Hulst, Multiple Light Scattering, 1980, chapter 4; Prahl,
 * van Gemert, Welch 1993]. A matrix and some rows describe all that lies below a level. The matrix takes the
 * power that comes down in each direction to the power that comes back up. The rows take it to the shares
 * transmitted, and absorbed in each layer. Layers and boundaries are put on top one by one.
 * SPDX-License-Identifier: MIT */
#include "exact/stack.h"

#include "exact/dense.h"
#include "exact/layer_response.h"

#include <stdlib.h>
#include <string.h>

/* Largest number of layers whose shares form one block. With more layers there are several blocks, so that
 * time and memory grow with the number of layers, not with its square. */
#define BLOCK_LAYERS 64

/* A block: some layers with the boundaries below them; the uppermost block also contains boundary 0. share:
 * [passed + layers][n], per power that comes down into the block in each of n directions. The first `passed`
 * rows are the power that leaves the block downwards in each direction (for the lowest block: one row, all
 * that is transmitted). The other rows are the shares that the layers absorb. */
struct block {
    int first, layers; /* number of the uppermost layer; number of layers */
    int passed, n;
    double *share;
};

/* All that lies below a level, seen from above. `below`: [n + rows][n], n rows of the light that comes back,
 * then the shares of the uppermost block. */
struct stack {
    /* n: number of directions at the level; rows: number of shares; most: largest number of directions of any
     * medium */
    int n, rows, most;
    double *below;
    double *other, *matrix; /* [most + rows][most] scratch */
    double *mirror;         /* [most] reflectances of a boundary by direction */
    double *light;          /* [2 most] light that comes down, for two blocks in turn */
    int num_blocks;
    struct block *block; /* [num_blocks] the lowest block first */
    double *share;       /* [num_blocks][most + BLOCK_LAYERS][most] shares of all blocks */
};

double cml_stack_fresnel(double n1, double c1, double n2, double c2)
{
    if (!(c1 > 0 && c2 > 0)) return 1;
    const double s = (n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2), p = (n1 * c2 - n2 * c1) / (n1 * c2 + n2 * c1);
    return (s * s + p * p) / 2;
}

/* Allocates the matrices and blocks of a stack of layers. A block keeps the shares of up to BLOCK_LAYERS
 * layers; with one block for all, memory would grow with the square of the number of layers. */
static cml_status allocate(struct cml_arrays *arrays, struct stack *stack,
                           const struct cml_directions *directions, struct cml_error *err)
{
    const size_t most = (size_t)directions->count, shares = most * (most + BLOCK_LAYERS),
                 size = most * most + shares, blocks = (size_t)(directions->num_media - 2) / BLOCK_LAYERS + 1;
    stack->most = directions->count;
    stack->below = cml_arrays_add(arrays, size, sizeof(double));
    stack->other = cml_arrays_add(arrays, size, sizeof(double));
    stack->matrix = cml_arrays_add(arrays, size, sizeof(double));
    stack->mirror = cml_arrays_add(arrays, most, sizeof(double));
    stack->light = cml_arrays_add(arrays, 2 * most, sizeof(double));
    stack->block = cml_arrays_add(arrays, blocks, sizeof *stack->block);
    stack->share = cml_arrays_add(arrays, blocks * shares, sizeof(double));
    return cml_arrays_check(arrays, "layers", err);
}

/* Puts a smooth boundary on top of the stack, below a medium with n directions. Directions that exist on one
 * side only are reflected totally. Light that passes back and forth between boundary and stack adds up to (1
 * - r below)^-1. */
static void add_boundary(struct stack *stack, const struct cml_directions *directions, double above,
                         double below, int n)
{
    /* inner: number of directions below the boundary. shared: number of directions that exist on both sides.
     */
    const int inner = stack->n, shared = n < inner ? n : inner;
    const struct cml_dense_kind kind = cml_directions_kind(directions, inner);
    double *r = stack->mirror, *to = stack->other;
    for (int i = 0; i < inner; i++)
        r[i] = i < shared ? cml_stack_fresnel(above, cml_directions_cosine(directions, i, above), below,
                                              cml_directions_cosine(directions, i, below))
                          : 1;
    for (int i = 0; i < inner; i++)
        for (int j = 0; j < inner; j++)
            stack->matrix[i * inner + j] = (i == j) - r[i] * stack->below[i * inner + j];
    cml_dense_divide(&kind, stack->rows, stack->matrix, stack->below);
    memset(to, 0, (size_t)(n + stack->rows) * (size_t)n * sizeof *to);
    for (int j = 0; j < shared; j++) {
        for (int i = 0; i < shared; i++)
            to[i * n + j] = (1 - r[i]) * stack->below[i * inner + j] * (1 - r[j]);
        for (int k = 0; k < stack->rows; k++)
            to[(n + k) * n + j] = stack->below[(inner + k) * inner + j] * (1 - r[j]);
    }
    for (int i = 0; i < n; i++) to[i * n + i] += i < shared ? r[i] : 1;
    stack->other = stack->below;
    stack->below = to;
    stack->n = n;
}

/* Puts a rough boundary on top of the stack, below a medium with n directions. The stack gets the light T (1
 * - R_below below)^-1 from above, with all passes back and forth. */
static void add_rough(struct stack *stack, const struct cml_directions *directions,
                      const struct cml_rough_matrices *rough, int n)
{
    const int inner = stack->n, all = inner + stack->rows;
    const struct cml_dense_kind kind = cml_directions_kind(directions, inner);
    double *matrix = stack->matrix, *to = stack->other;
    memset(matrix, 0, (size_t)inner * (size_t)inner * sizeof *matrix);
    cml_dense_add_product(&kind, 0, rough->R_below, stack->below, matrix);
    for (int i = 0; i < inner; i++)
        for (int j = 0; j < inner; j++) matrix[i * inner + j] = (i == j) - matrix[i * inner + j];
    cml_dense_divide(&kind, stack->rows, matrix, stack->below);
    memset(matrix, 0, (size_t)all * (size_t)n * sizeof *matrix);
    cml_dense_add_general(all, inner, n, stack->below, rough->T, matrix);
    memcpy(to, rough->R, (size_t)n * (size_t)n * sizeof *to);
    cml_dense_add_general(n, inner, n, rough->T_below, matrix, to);
    memcpy(to + n * n, matrix + inner * n, (size_t)stack->rows * (size_t)n * sizeof *to);
    stack->other = stack->below;
    stack->below = to;
    stack->n = n;
}

/* Puts a layer on top of the stack, whose absorbed share becomes row `number`. The stack below gets the
 * share (1 - R below)^-1 T of the incident light, and Z comes back from there. */
static void add_layer(struct stack *stack, const struct cml_directions *directions,
                      const struct cml_layer_response *layer, int number)
{
    const int n = stack->n;
    const struct cml_dense_kind kind = cml_directions_kind(directions, n);
    double *Z = stack->other, *old = stack->below, *matrix = stack->matrix;
    memset(matrix, 0, (size_t)n * (size_t)n * sizeof *matrix);
    cml_dense_add_product(&kind, 0, layer->R, old, matrix);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) matrix[i * n + j] = (i == j) - matrix[i * n + j];
    cml_dense_divide(&kind, stack->rows, matrix, old);
    for (int i = 0; i < (n + stack->rows) * n; i++) Z[i] = layer->through * old[i];
    cml_dense_add_product(&kind, stack->rows, old, layer->U, Z);
    double *absorbed = Z + (size_t)(n + number) * (size_t)n;
    memcpy(absorbed, layer->a, (size_t)n * sizeof *absorbed);
    cml_dense_add_row_product(&kind, layer->a, Z, absorbed);
    memcpy(old + n * n, Z + n * n, (size_t)stack->rows * (size_t)n * sizeof *old);
    for (int i = 0; i < n * n; i++) old[i] = layer->through * Z[i];
    cml_dense_add_product(&kind, 0, layer->U, Z, old);
    for (int i = 0; i < n * n; i++) old[i] += layer->R[i];
}

/* Begins a stack of n directions with the medium below all layers. No light comes back from that medium, and
 * share 0 is the transmitted light. */
static void begin(struct stack *stack, int n)
{
    stack->n = n;
    for (int j = 0; j < n; j++) stack->below[n * n + j] = 1;
}

/* Begins with a backing below a medium of index m with n directions; share 0 is the light that the backing
 * keeps. Diffuse reflection sends light into each direction in proportion to its etendue, and all directions
 * exist there. */
static void begin_backed(struct stack *stack, const struct cml_backing_def *backing,
                         const struct cml_directions *directions, double m, int n)
{
    const bool diffuse = backing->kind == CML_BACKING_LAMBERTIAN;
    stack->n = n;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            stack->below[i * n + j] = diffuse  ? backing->R * 2 * directions->etendue[i] / (m * m)
                                      : i == j ? backing->R
                                               : 0;
    for (int j = 0; j < n; j++) stack->below[n * n + j] = 1 - backing->R;
}

/* Begins a stack with a rough backing. Light comes back as its matrix R says, and share 0 is the rest, the
 * light that the backing's facets keep. */
static void begin_rough(struct stack *stack, const struct cml_rough_matrices *rough, int n)
{
    stack->n = n;
    memcpy(stack->below, rough->R, (size_t)n * (size_t)n * sizeof *stack->below);
    for (int j = 0; j < n; j++) {
        double kept = 1;
        for (int i = 0; i < n; i++) kept -= rough->R[i * n + j];
        stack->below[n * n + j] = kept;
    }
}

/* Begins another block, of layers up to `last`. Light that comes down into the blocks below leaves this
 * block. */
static void begin_block(struct stack *stack, int last)
{
    struct block *block = &stack->block[stack->num_blocks];
    double *shares = stack->below + (size_t)stack->n * (size_t)stack->n;
    const size_t size = (size_t)stack->most * ((size_t)stack->most + BLOCK_LAYERS);
    *block = (struct block){.layers = last < BLOCK_LAYERS ? last : BLOCK_LAYERS,
                            .passed = stack->num_blocks > 0 ? stack->n : 1,
                            .share = stack->share + (size_t)stack->num_blocks * size};
    block->first = last - block->layers + 1;
    stack->rows = block->passed + block->layers;
    if (stack->num_blocks++ == 0) return;
    memset(shares, 0, (size_t)stack->rows * (size_t)stack->n * sizeof *shares);
    for (int i = 0; i < stack->n; i++) shares[i * stack->n + i] = 1;
}

/* Stores the shares of the layers of a completed block, so that the stack can begin the next block. */
static void end_block(struct stack *stack)
{
    struct block *block = &stack->block[stack->num_blocks - 1];
    block->n = stack->n;
    memcpy(block->share, stack->below + (size_t)stack->n * (size_t)stack->n,
           (size_t)stack->rows * (size_t)stack->n * sizeof *block->share);
}

/* Builds the stack of all layers from below, a boundary and a layer in turn, up to boundary 0, and cuts it
 * into blocks. */
static cml_status build(const struct cml_medium_def *media, const struct cml_backing_def *backing,
                        const struct cml_stack_rough *rough, const struct cml_directions *directions,
                        int terms, struct stack *stack, struct cml_error *err)
{
    const int num_layers = directions->num_media - 2;
    if (backing && rough && rough->boundary[num_layers].R)
        begin_rough(stack, &rough->boundary[num_layers], directions->live[num_layers]);
    else if (backing)
        begin_backed(stack, backing, directions, media[num_layers].n, directions->live[num_layers]);
    else
        begin(stack, directions->live[num_layers + 1]);
    begin_block(stack, num_layers);
    for (int b = num_layers; b >= 0; b--) {
        const struct block *block = &stack->block[stack->num_blocks - 1];
        CML_AT_END(cml_layer_response_clear) struct cml_layer_response own = {.count = 0};
        struct cml_layer_response *layer = rough ? &rough->layer[b] : &own;
        if (b > 0 && b < block->first) {
            end_block(stack);
            begin_block(stack, b);
            block++;
        }
        if (rough && rough->boundary[b].R && (b < num_layers || !backing))
            add_rough(stack, directions, &rough->boundary[b], directions->live[b]);
        else if (b < num_layers || !backing)
            add_boundary(stack, directions, media[b].n, media[b + 1].n, directions->live[b]);
        if (b == 0) break;
        if (!layer->R) CML_TRY(cml_layer_response_create(&media[b], directions, stack->n, terms, layer, err));
        add_layer(stack, directions, layer, block->passed + b - block->first);
    }
    end_block(stack);
    return CML_OK;
}

/* Returns the share of the light in n directions that one row of a matrix [][n] takes. */
static double share(const double *matrix, int n, int row, const double *light)
{
    double sum = 0;
    for (int j = 0; j < n; j++) sum += matrix[row * n + j] * light[j];
    return sum;
}

/* Follows `light` from block to block downwards. Computes the shares transmitted, and absorbed by layer l:
 * absorbed[(l - 1) step]. */
static void share_out(const struct stack *stack, const double *light, int step, double *transmitted,
                      double *absorbed)
{
    for (int k = stack->num_blocks - 1; k >= 0; k--) {
        const struct block *block = &stack->block[k];
        double *next = stack->light + (k % 2) * stack->most;
        for (int i = 0; i < block->layers; i++)
            absorbed[(block->first - 1 + i) * step] = share(block->share, block->n, block->passed + i, light);
        for (int i = 0; i < block->passed; i++) next[i] = share(block->share, block->n, i, light);
        light = next;
    }
    *transmitted = light[0];
}

cml_status cml_stack_shares(const struct cml_medium_def *media, const struct cml_backing_def *backing,
                            const struct cml_stack_rough *rough, const struct cml_directions *directions,
                            int terms, double *reflected, double *transmitted, double *absorbed,
                            struct cml_error *err)
{
    CML_AT_END(cml_arrays_free) struct cml_arrays arrays = {0};
    struct stack stack = {.n = 0};
    CML_TRY(allocate(&arrays, &stack, directions, err));
    CML_TRY(build(media, backing, rough, directions, terms, &stack, err));
    *reflected = 0;
    for (int i = 0; i < stack.n; i++) *reflected += share(stack.below, stack.n, i, directions->light);
    share_out(&stack, directions->light, 1, transmitted, absorbed);
    return CML_OK;
}

cml_status cml_stack_responses(const struct cml_medium_def *media, const struct cml_directions *directions,
                               int terms, int count, double *response, struct cml_error *err)
{
    CML_AT_END(cml_arrays_free) struct cml_arrays arrays = {0};
    struct stack stack = {.n = 0};
    double *light = cml_arrays_add(&arrays, (size_t)directions->count, sizeof *light);
    CML_TRY(allocate(&arrays, &stack, directions, err));
    CML_TRY(build(media, NULL, NULL, directions, terms, &stack, err));
    for (int j = 0, at = 0; j < stack.n; j++) {
        if (directions->etendue[j] != 0) continue;
        light[j] = 1;
        share_out(&stack, light, count, response + at, response + count + at);
        at++;
        light[j] = 0;
    }
    return CML_OK;
}
