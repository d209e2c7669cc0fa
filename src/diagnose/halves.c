/* Posterior over sets of causes in halves of the postures, drawn at random within each socket.
 *
 * A half is searched from nothing, as if it were all that was recorded: a group of causes that only
 * the whole, or the sets that its search met, would find again is not stable (R. Shah and R.
 * Samworth, Variable selection with error control, Journal of the Royal Statistical Society B 75,
 * 2013).  The rows have the whole's whitened columns; free means are estimated anew.  The products
 * of the second half are those of the whole minus the first's. */
#include "diagnose/halves.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "infer/given.h"
#include "infer/halves.h"
#include "math/dense.h"

enum {
    PAIRS = MUKCA_HALVES / 2,
    CHUNK = 256,        /* rows processed together */
    MOST_COLUMNS = 320, /* of the items */
    LEAST_POSTURES = 8, /* of a half, in all: half of them are left for a geometry */
    BUDGET = 8          /* sets expanded in each half without a better one */
};

/* Log odds behind the best set of the whole of the sets whose candidates are tried in the halves:
 * beyond what the noise of a replicate changes. */
#define RELEVANT 20.0

typedef struct {
    uint64_t hash;
    int sample;
} drawn;

/* What is known of the whole, and the scratch memory of a worker. */
typedef struct {
    mukca_search *search;
    mukca_part_layout layout;
    int width;             /* of the columns */
    double *whole, *pairs; /* [width][width] products */
    double *part, *second; /* the same of two halves */
    double *sum;           /* [n_groups][dim][width] products with the whitened ones of a half */
    double *ones[2];       /* [n_groups][dim][dim] products of these, of the whole and of a half */
    double *chunk;         /* [CHUNK][width] */
    const int *item_of;
    unsigned char *in; /* [n_samples] of a half */
    drawn *posture;    /* [n_samples] */
} splitter;

static int by_hash(const void *a, const void *b)
{
    const drawn *x = a, *y = b;
    return x->hash != y->hash ? (x->hash > y->hash) - (x->hash < y->hash) : x->sample - y->sample;
}

/* Draw half of the postures of each group, by their angles, whatever the order of the rows. Returns
 * the number of postures of the smaller half. */
static int draw(unsigned char *in, drawn *posture, const mukca_recording *r, int pair)
{
    const mukca_samples *s = &r->samples;
    const int n = r->chain->n_joints;
    int size[2] = {0, 0};
    for (int b = 0; b < s->n_blocks; b++) {
        const int start = s->block[b].start, end = start + s->block[b].count;
        int count = 0;
        for (int i = start; i < end; i++) {
            uint64_t sum = (uint64_t)pair;
            if (!s->readings[i]) continue;
            for (int k = i; k >= 0; k = s->next[k]) {
                int64_t q[MUKCA_MAX_JOINTS] = {0}; /* microradians: units of files do not matter */
                for (int j = 0; j < n; j++) q[j] = llround(1e6 * r->data->q[r->order[k] * n + j]);
                sum += mukca_hash(MUKCA_HASH_START + (uint64_t)pair, q, sizeof *q * (size_t)n);
            }
            sum = mukca_hash(MUKCA_HASH_START, &sum, sizeof sum);
            posture[count++] = (drawn){mukca_hash(sum ^ sum >> 32, &sum, sizeof sum), i};
        }
        qsort(posture, (size_t)count, sizeof *posture, by_hash);
        const int half = count / 2 + (count % 2 && posture[0].hash % 2); /* of an odd number */
        size[0] += half, size[1] += count - half;
        for (int p = 0; p < count; p++)
            for (int k = posture[p].sample; k >= 0; k = s->next[k]) in[k] = p < half;
    }
    return size[0] < size[1] ? size[0] : size[1];
}

/* Columns of a row, in the layout of the parts. */
static void gather(double *out, const splitter *s, int row)
{
    const mukca_scan *scan = &s->search->scan;
    const mukca_question *q = &s->search->question;
    const mukca_linearisation *linear = &s->search->m->linear;
    const double *x = scan->white + (size_t)row * (size_t)linear->stride,
                 root = sqrt(scan->precision);
    const mukca_part_layout *l = &s->layout;
    for (int t = 0; t < l->n; t++) out[t] = root * scan->prior[t] * x[t];
    out[l->n] = root * x[linear->y];
    out += l->n + 1;
    for (int i = 0; i < l->n_items; i++)
        mukca_question_copy(out + l->item[i].at, 0, q,
                            (mukca_span){q->item[s->item_of[i]].at, l->item[i].terms},
                            (mukca_span){row, 1});
}

/* Add the rows of a sample to the sums of its group. */
static void add_means(splitter *s, double *ones, const double *rows, int sample, int group)
{
    const int d = s->search->m->recording.dim;
    const double *one = s->search->scan.normal->whitening.one + sample * d * d;
    for (int a = 0; a < d; a++)
        for (int c = 0; c < d; c++) {
            double *sum = s->sum + (size_t)(group * d + c) * (size_t)s->width;
            const double by = one[a * d + c];
            for (int k = 0; k < s->width && by != 0; k++) sum[k] += by * rows[a * s->width + k];
            for (int b = 0; b < d; b++) ones[(group * d + c) * d + b] += by * one[a * d + b];
        }
}

/* Products of the marked samples (NULL: all), and of their means. */
static void multiply(splitter *s, double *gram, double *ones, const unsigned char *in)
{
    /* NOLINTNEXTLINE(clang-analyzer-core.NullDereference): every worker has the search */
    const mukca_samples *samples = &s->search->m->recording.samples;
    const int d = samples->dim, groups = samples->n_blocks;
    const size_t width = (size_t)s->width;
    int rows = 0;
    memset(gram, 0, sizeof *gram * width * width);
    memset(s->sum, 0, sizeof *s->sum * (size_t)(groups * d) * width);
    memset(ones, 0, sizeof *ones * (size_t)(groups * d * d));
    for (int b = 0; b < groups; b++) {
        const mukca_block *block = &samples->block[b];
        for (int i = block->start; i < block->start + block->count; i++) {
            if (in && !in[i]) continue;
            for (int c = 0; c < d; c++) gather(s->chunk + (size_t)(rows + c) * width, s, i * d + c);
            if (block->free_mean) add_means(s, ones, s->chunk + (size_t)rows * width, i, b);
            rows += d;
            if (rows + d <= CHUNK) continue;
            mukca_dense_syrk(gram, s->width, s->chunk, rows, s->width);
            rows = 0;
        }
    }
    mukca_dense_syrk(gram, s->width, s->chunk, rows, s->width);
}

/* Remove the free means from the products of a half, or (other) of its complement: the whole has
 * none, so that their sums differ in sign only. */
static void remove_means(const splitter *s, double *gram, bool other)
{
    const mukca_samples *samples = &s->search->m->recording.samples;
    const int d = samples->dim;
    for (int b = 0; b < samples->n_blocks; b++) {
        double L[36] = {0}, *x = s->chunk;
        if (!samples->block[b].free_mean) continue;
        for (int i = 0; i < d * d; i++)
            L[i] = (other ? s->ones[0][b * d * d + i] : 0) +
                   (other ? -1.0 : 1.0) * s->ones[1][b * d * d + i];
        memcpy(x, s->sum + (size_t)(b * d) * (size_t)s->width, sizeof *x * (size_t)(d * s->width));
        if (!(L[0] > 1e-9) || !mukca_dense_cholesky(L, d)) continue;
        mukca_dense_forward(x, s->width, L, d);
        for (int c = 0; c < d; c++, x += s->width)
            for (int i = 0; i < s->width; i++)
                for (int k = 0; k < s->width; k++) gram[i * s->width + k] -= x[i] * x[k];
    }
}

/* Degrees of freedom of the marked samples, or (other) of those not marked. */
static int freedom(const mukca_recording *r, const unsigned char *in, bool other)
{
    int rows = 0;
    for (int b = 0; b < r->samples.n_blocks; b++) {
        const mukca_block *block = &r->samples.block[b];
        int count = 0;
        for (int i = block->start; i < block->start + block->count; i++)
            count += (in[i] != 0) != other;
        rows += r->dim * (count - (block->free_mean && count));
    }
    return rows;
}

/* The items of the best sets that the whole has met. */
static bool choose_items(mukca_halves *h, mukca_pool *pool, const mukca_search *search)
{
    const mukca_sets *sets = &search->sets;
    double *value = MUKCA_TAKE(pool, double, search->n_kept + 1);
    bool *chosen = MUKCA_TAKE(pool, bool, search->n_kept + 1);
    h->item_of = MUKCA_TAKE(pool, int, search->n_kept + 1);
    h->item = MUKCA_TAKE(pool, mukca_item, search->n_kept + 1);
    if (pool->failed) return false;
    for (int i = 0; i < search->n_kept; i++) value[i] = -HUGE_VAL;
    for (int s = 0; s < sets->n_sets; s++)
        for (int m = 0; m < sets->set[s].n; m++) {
            double *best = &value[sets->set[s].item[m]];
            *best = fmax(*best, sets->set[s].value);
        }
    const double least = sets->set[sets->best].value - RELEVANT;
    for (int columns = 0;;) {
        const int best = mukca_set_largest(value, search->n_kept);
        columns += search->question.item[best].terms;
        if (!search->n_kept || !(value[best] > least) || columns > MOST_COLUMNS) break;
        value[best] = -HUGE_VAL;
        chosen[best] = true;
    }
    for (int i = 0, columns = 0; i < search->n_kept; i++) {
        if (!chosen[i]) continue;
        h->item[h->n_items] = search->question.item[i];
        h->item[h->n_items].at = columns;
        columns += search->question.item[i].terms;
        h->item_of[h->n_items++] = i;
    }
    return true;
}

typedef struct {
    mukca_halves *halves;
    splitter worker[MUKCA_MOST_WORKERS];
    enum { DONE = 1, TOO_FEW, FAILED } outcome[PAIRS];
} splitting;

/* Draw a pair of halves, and search both. */
static void search_pair(void *context, int pair, int worker)
{
    splitting *job = context;
    splitter *s = &job->worker[worker];
    const mukca_recording *r = &s->search->m->recording;
    mukca_pool *pool = &job->halves->pool[worker];
    const int square = s->width * s->width;
    job->outcome[pair] = TOO_FEW;
    if (draw(s->in, s->posture, r, pair) < LEAST_POSTURES) return;
    multiply(s, s->part, s->ones[1], s->in);
    for (int i = 0; i < square; i++) s->second[i] = s->whole[i] - s->part[i];
    job->outcome[pair] = DONE;
    for (int other = 0; other < 2; other++) {
        mukca_half *half = &job->halves->half[2 * pair + other];
        double *gram = other ? s->second : s->part;
        remove_means(s, gram, other);
        for (int i = 0; i < square; i++) gram[i] += s->pairs[i];
        const int all = freedom(r, s->in, other != 0),
                  dof = (int)(s->search->m->evidence.counted * all) + r->n_pairs;
        if (mukca_part_question(&half->question, pool, gram, dof, &s->layout) &&
            mukca_sets_create(&half->sets, pool, &half->question))
            mukca_sets_explore(&half->sets, BUDGET, false);
        else
            job->outcome[pair] = TOO_FEW; /* or: singular */
        if (pool->failed) job->outcome[pair] = FAILED;
    }
}

/* Scratch memory of a worker; false: none. */
static bool take_scratch(splitter *s, mukca_pool *pool)
{
    const mukca_recording *r = &s->search->m->recording;
    const int d = r->dim, groups = r->samples.n_blocks + 1;
    s->in = MUKCA_TAKE(pool, unsigned char, r->n_samples + 1);
    s->posture = MUKCA_TAKE(pool, drawn, r->n_samples + 1);
    s->part = MUKCA_TAKE(pool, double, s->width * s->width);
    s->second = MUKCA_TAKE(pool, double, s->width * s->width);
    s->sum = MUKCA_TAKE(pool, double, groups *d * s->width);
    s->ones[1] = MUKCA_TAKE(pool, double, groups *d *d);
    s->chunk = MUKCA_TAKE(pool, double, (CHUNK + d) * s->width);
    return !pool->failed;
}

mukca_status mukca_halves_search(mukca_halves *h, mukca_pool *pool, mukca_search *search,
                                 mukca_error *error)
{
    const mukca_recording *r = &search->m->recording;
    const int d = r->dim, workers = mukca_workers_count(search->m->recording.workers);
    splitting job = {.halves = h};
    bool ok =
        choose_items(h, pool, search) && mukca_scan_aim(&search->scan, search->m->unknowns.family);
    splitter s = {.search = search, .item_of = h->item_of};
    s.layout = (mukca_part_layout){.n = search->scan.n, .n_items = h->n_items, .item = h->item};
    for (int i = 0; i < h->n_items; i++) s.layout.n_columns += h->item[i].terms;
    s.width = s.layout.n + 1 + s.layout.n_columns;
    s.whole = MUKCA_TAKE(pool, double, s.width *s.width);
    s.pairs = MUKCA_TAKE(pool, double, s.width *s.width);
    s.ones[0] = MUKCA_TAKE(pool, double, (r->samples.n_blocks + 1) * d * d);
    ok = ok && !pool->failed;
    for (int k = 0; k < workers && ok; k++) {
        job.worker[k] = s;
        ok = take_scratch(&job.worker[k], pool);
    }
    if (!ok) return mukca_fail(error, MUKCA_MEMORY, "out of memory for halves of the data");
    splitter *own = &job.worker[0];
    multiply(own, s.whole, s.ones[0], NULL);
    for (int p = 0; p < r->n_pairs; p++) {
        gather(own->chunk, own, r->n_samples * d + p);
        mukca_dense_syrk(s.pairs, s.width, own->chunk, 1, s.width);
    }
    mukca_workers_run(search->m->recording.workers, PAIRS, search_pair, &job);
    for (int pair = 0; pair < PAIRS; pair++) {
        if (job.outcome[pair] == FAILED)
            return mukca_fail(error, MUKCA_MEMORY, "out of memory for halves of the data");
        if (job.outcome[pair] == DONE) h->n = MUKCA_HALVES;
    }
    return MUKCA_OK;
}

void mukca_halves_free(mukca_halves *h)
{
    for (int k = 0; k < MUKCA_MOST_WORKERS; k++) mukca_pool_free(&h->pool[k]);
}
