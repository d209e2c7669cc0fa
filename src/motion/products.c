/* Products of filtered raw columns, block by block: no column of the whole recording is kept. */
#include <math.h>
#include <string.h>

#include "base/hash.h"
#include "math/dense.h"
#include "motion/raw.h"

/* Rows per period of the cutoff. */
#define ROWS 2.5
/* Standard deviation of a Gaussian filter with half of the power at its cutoff, times the cutoff;
 * its length on either side, in standard deviations. */
#define GAUSSIAN 0.1325
#define REACH 4.0
#define STUCK 0.02 /* part of a row in which a joint may stick, and friction be wrong */
/* Length of a block, s, and the least: halves of the recording alternate between blocks. */
#define BLOCK 2.0
#define SHORTEST_BLOCK 0.6
/* Blocks of a recording, at least, if they can be that long. */
enum { BLOCKS = 32, LEAST_BLOCKS = 8, MOST_TAPS = 64 };

typedef struct {
    const mukca_raw_model *model;
    mukca_raw_products *out;
    int length, step, reach; /* samples of a block, from row to row, of the filter on either side */
    double tap[2 * MOST_TAPS + 1];
    int width;
    double *x, *rows, *pairs, *ends, *Y, *gravity;
} accumulator;

/* Successive blocks alternate, in another order in each eight: no motion has their period. */
static int part_of(mukca_run_role role, int block)
{
    const int eight = block / MUKCA_BLOCKS,
              key = (int)(mukca_hash(MUKCA_HASH_START, &eight, sizeof eight) >> 60);
    return role == MUKCA_RUN_REFERENCE ? MUKCA_PART_REFERENCE
           : role == MUKCA_RUN_TEST    ? MUKCA_PART_TEST
                                       : (block * (2 * (key % 4) + 1) + key) % MUKCA_BLOCKS;
}

/* Can the joint stick in more than a small part of a row's filter? */
static bool may_stick(const accumulator *a, const mukca_stretch *s, int joint, int at)
{
    const int n = a->model->signals->n_joints;
    double part = 0;
    for (int k = 0; k < 2 * a->reach; k++) {
        const double *v = s->dq + (at + k - a->reach) * n + joint;
        const double low = fmax(fmin(v[0], v[n]), -MUKCA_STICKING),
                     high = fmin(fmax(v[0], v[n]), MUKCA_STICKING);
        if (high >= low) part += a->tap[k] * (high > low ? (high - low) / fabs(v[n] - v[0]) : 1);
    }
    return part > STUCK;
}

static void filter(double *row, const double *x, int width, const accumulator *a)
{
    memset(row, 0, sizeof *row * (size_t)width);
    for (int k = 0; k <= 2 * a->reach; k++)
        for (int c = 0; c < width; c++) row[c] += a->tap[k] * x[k * width + c];
}

/* Add the pairs of successive rows of a joint, at every step-th sample whose filter lies within the
 * block. */
static void add_joint(accumulator *a, const mukca_raw_block *block, int j, mukca_raw_products *part)
{
    const int n = a->model->signals->n_joints, width = mukca_raw_width(n, j);
    int pairs = 0, count = 0;
    double *before = NULL, *ends = a->ends;
    for (int at = a->reach; at + a->reach < block->last - block->first; at += a->step) {
        if (may_stick(a, block->stretch, j, block->first + at)) {
            before = NULL;
            continue;
        }
        double *row = a->rows + count * width;
        filter(row, a->x + (at - a->reach) * width, width, a);
        ends[count++] = 0;
        if (before) {
            for (int c = 0; c < width; c++) a->pairs[pairs * width + c] = row[c] - before[c];
            ends[count - 2] += 0.5, ends[count - 1] += 0.5; /* half of either row of a pair */
            pairs++;
        }
        before = row;
    }
    for (int i = 0; i < count; i++)
        for (int c = 0; c < width; c++) a->rows[i * width + c] *= sqrt(ends[i]);
    mukca_dense_syrk(part->difference[j], width, a->pairs, pairs, width);
    mukca_dense_syrk(part->square[j], width, a->rows, count, width);
    part->rows[j] += pairs;
}

static void add_block(accumulator *a, const mukca_stretch *s, int first, mukca_raw_products *part)
{
    const mukca_raw_model *m = a->model;
    const int n = m->signals->n_joints, square = n * n * MUKCA_INERTIAL;
    const double still[MUKCA_MAX_JOINTS] = {0};
    const mukca_raw_block block = {s, first, first + a->length, a->Y, a->gravity};
    for (int i = 0; i < a->length; i++) {
        const int at = (first + i) * n;
        mukca_dynamics_regressor(a->Y + i * square, &m->dynamics, s->q + at, s->dq + at,
                                 s->ddq + at);
        mukca_dynamics_torque(a->gravity + i * n, &m->dynamics, m->load, s->q + at, still, still);
    }
    for (int j = 0; j < n; j++) {
        mukca_raw_fill(a->x, mukca_raw_width(n, j), m, &block, j);
        add_joint(a, &block, j, part);
    }
}

static bool take_products(mukca_raw_products products[MUKCA_PARTS], mukca_pool *pool,
                          const mukca_signals *s)
{
    memset(products, 0, sizeof *products * MUKCA_PARTS);
    for (int g = 0; g < MUKCA_PARTS; g++) {
        bool has = g <= MUKCA_PART_NEW;
        for (int k = 0; k < s->n; k++) has |= part_of(s->stretch[k].role, 0) == g;
        for (int j = 0; j < s->n_joints && has; j++) {
            const int width = mukca_raw_width(s->n_joints, j);
            products[g].square[j] = MUKCA_TAKE(pool, double, width *width);
            products[g].difference[j] = MUKCA_TAKE(pool, double, width *width);
        }
    }
    return !pool->failed;
}

static void set_filter(accumulator *a, const mukca_signals *s)
{
    const double sigma = GAUSSIAN / (MUKCA_MOTION_CUTOFF * s->dt);
    double sum = 0, total = 0;
    a->step = (int)fmax(floor(1 / (ROWS * MUKCA_MOTION_CUTOFF * s->dt)), 1);
    a->reach = (int)fmin(ceil(REACH * sigma), MOST_TAPS);
    for (int k = -a->reach; k <= a->reach; k++)
        sum += a->tap[k + a->reach] = exp(-0.5 * k * k / (sigma * sigma));
    for (int k = 0; k <= 2 * a->reach; k++) a->tap[k] /= sum;
    for (int k = 0; k < s->n; k++)
        if (s->stretch[k].role == MUKCA_RUN_NEW) total += s->stretch[k].n * s->dt;
    a->length = (int)fmax(fmin(BLOCK, fmax(total / BLOCKS, SHORTEST_BLOCK)) / s->dt, 1);
}

mukca_status mukca_raw_products_make(mukca_raw_products products[MUKCA_PARTS], mukca_pool *pool,
                                     const mukca_raw_model *model, mukca_error *error)
{
    const mukca_signals *s = model->signals;
    const int n = s->n_joints;
    mukca_pool scratch = {0};
    accumulator a = {.model = model, .width = mukca_raw_width(n, 0)};
    int blocks = 0, counted = 0;
    set_filter(&a, s);
    a.x = MUKCA_TAKE(&scratch, double, a.length *a.width);
    a.rows = MUKCA_TAKE(&scratch, double, a.length *a.width);
    a.pairs = MUKCA_TAKE(&scratch, double, a.length *a.width);
    a.ends = MUKCA_TAKE(&scratch, double, a.length);
    a.gravity = MUKCA_TAKE(&scratch, double, a.length *n);
    a.Y = MUKCA_TAKE(&scratch, double, a.length *n *n *MUKCA_INERTIAL);
    if (take_products(products, pool, s) && !scratch.failed)
        for (const mukca_stretch *k = s->stretch; k < s->stretch + s->n; k++)
            for (int at = 0; at + a.length <= k->n; at += a.length) {
                add_block(&a, k, at, &products[part_of(k->role, blocks)]);
                blocks += k->role == MUKCA_RUN_NEW;
            }
    const bool failed = pool->failed || scratch.failed;
    mukca_pool_free(&scratch);
    if (failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the columns");
    for (int g = 0; g < MUKCA_BLOCKS; g++) {
        bool some = false;
        for (int j = 0; j < n; j++) {
            const int width = mukca_raw_width(n, j);
            some |= products[g].rows[j] > 0;
            products[MUKCA_PART_NEW].rows[j] += products[g].rows[j];
            for (int i = 0; i < width * width && products[g].square[j]; i++) {
                products[MUKCA_PART_NEW].square[j][i] += products[g].square[j][i];
                products[MUKCA_PART_NEW].difference[j][i] += products[g].difference[j][i];
            }
        }
        counted += some;
    }
    if (counted == LEAST_BLOCKS) return MUKCA_OK;
    return mukca_fail(error, MUKCA_UNIDENTIFIABLE,
                      "the runs move for %.1f s; record %.0f s or more", blocks * a.length * s->dt,
                      2 * LEAST_BLOCKS * SHORTEST_BLOCK);
}

void mukca_raw_products_add(double *out, const mukca_raw_products *part, int joint, int width,
                            double rho, double factor)
{
    const double *S = part->square[joint], *D = part->difference[joint];
    const double s = factor * (1 - rho) * (1 - rho), d = factor * rho;
    for (int i = 0; i < width * width && S; i++) out[i] += s * S[i] + d * D[i];
}
