/* Inference against dense algebra in long double: whitening, evidence, sets of causes. */
#include <stdbool.h>

#include "base/pool.h"
#include "close.h"
#include "infer/halves.h"
#include "infer/posterior.h"
#include "infer/sets.h"
#include "infer/whitening.h"

typedef long double real;

enum { MOST = 80 };

static double draw(uint64_t *state) /* uniform in [-1, 1] */
{
    *state = *state * 6364136223846793005U + 1442695040888963407U;
    return (double)(*state >> 33) / 1073741824.0 - 1;
}

/* A := its lower Cholesky factor; returns log |A|. */
static real factor(real *A, int n)
{
    real log_det = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) {
            real sum = A[i * n + j];
            for (int k = 0; k < j; k++) sum -= A[i * n + k] * A[j * n + k];
            if (i == j) assert_true(sum > 0);
            A[i * n + j] = i == j ? sqrtl(sum) : sum / A[j * n + j];
            if (i == j) log_det += logl(sum);
        }
    return log_det;
}

/* x' A^-1 y, with the factor of A. */
static real product(const real *L, const double *x, const double *y, int n)
{
    real a[MOST], b[MOST], sum = 0;
    for (int i = 0; i < n; i++) {
        a[i] = x[i], b[i] = y[i];
        for (int k = 0; k < i; k++) a[i] -= L[i * n + k] * a[k], b[i] -= L[i * n + k] * b[k];
        a[i] /= L[i * n + i], b[i] /= L[i * n + i];
        sum += a[i] * b[i];
    }
    return sum;
}

/* ---- whitening ---- */

enum { SAMPLES = 36, DIM = 2, COLUMNS = SAMPLES * DIM, BLOCKS = 3 };

typedef struct {
    mukca_block block[BLOCKS];
    int posture[SAMPLES], next[SAMPLES], readings[SAMPLES];
    mukca_samples samples;
} layout;

/* Rounds: five, four and eight postures a block, read in turn; the last one has no free mean. */
static void lay_out(layout *l)
{
    static const mukca_block blocks[BLOCKS] = {{0, 15, true}, {15, 13, true}, {28, 8, false}};
    static const int postures[BLOCKS] = {5, 4, 8};
    memcpy(l->block, blocks, sizeof blocks);
    for (int b = 0; b < BLOCKS; b++) {
        const int end = blocks[b].start + blocks[b].count;
        for (int i = blocks[b].start; i < end; i++) {
            const int of = (i - blocks[b].start) % postures[b];
            l->posture[i] = 100 * b + of;
            l->next[i] = i + postures[b] < end ? i + postures[b] : -1;
            l->readings[i] = 0;
            for (int k = i; k < end && i - blocks[b].start == of; k += postures[b])
                l->readings[i]++;
        }
    }
    l->samples = (mukca_samples){SAMPLES, BLOCKS, DIM, l->block, l->next, l->readings};
}

/* Covariance of two rows under shapes L of means and M of deviations, of AR(1) of samples or
 * postures. */
static real covariance(const layout *l, mukca_noise_family family, double (*L)[DIM][DIM],
                       double (*M)[DIM][DIM], int row, int column)
{
    const int i = row / DIM, k = column / DIM, c = row % DIM, e = column % DIM;
    const int p = l->posture[i], q = l->posture[k], start = l->block[p / 100].start;
    const bool shares = family.shared > 0;
    const int a = shares ? start + p % 100 : i, b = shares ? start + q % 100 : k; /* the first */
    const real apart = 1 - (real)family.shared;
    real sum = 0, own = 0;
    if (p / 100 != q / 100) return 0;
    for (int t = 0; t < DIM; t++) {
        sum += (real)L[a][c][t] * L[b][e][t];
        own += (real)M[a][c][t] * M[b][e][t];
    }
    if (!shares) return sum * powl(family.rho, abs(i - k));
    sum *= powl(family.rho, abs(p - q)) *
           sqrtl((1 - apart + apart / l->readings[a]) * (1 - apart + apart / l->readings[b]));
    return p == q ? sum + own * apart * ((i == k) - 1.0L / l->readings[a]) : sum;
}

/* The factor A of V^-1, its transpose and its log determinant; with free means also these, and what
 * they leave: that of dense generalised least squares. */
static void check_family(mukca_noise_family family, bool shaped, const double *weight)
{
    static double unit[COLUMNS][COLUMNS], A[COLUMNS][COLUMNS], F[COLUMNS][COLUMNS],
        T[COLUMNS][COLUMNS], mean[BLOCKS * DIM][COLUMNS], left[COLUMNS][COLUMNS];
    static real V[COLUMNS * COLUMNS], inverse[COLUMNS][COLUMNS];
    double L[SAMPLES][DIM][DIM] = {{{0}}}, M[SAMPLES][DIM][DIM] = {{{0}}};
    layout l;
    mukca_pool pool = {0};
    mukca_whitening w;
    uint64_t seed = 3;
    lay_out(&l);
    for (int i = 0; i < SAMPLES; i++)
        for (int c = 0; c < DIM; c++) {
            for (int e = 0; e < c && shaped; e++)
                L[i][c][e] = draw(&seed), M[i][c][e] = draw(&seed);
            L[i][c][c] = shaped ? 1 + 0.5 * draw(&seed) : 1;
            M[i][c][c] = shaped ? 1 + 0.5 * draw(&seed) : 1;
        }
    const mukca_noise_shape shape = {shaped ? L[0][0] : NULL, shaped ? M[0][0] : NULL};
    for (int i = 0; i < COLUMNS; i++)
        for (int k = 0; k < COLUMNS; k++) {
            unit[i][k] = i == k;
            V[i * COLUMNS + k] = covariance(&l, family, L, M, i, k);
            if (weight) V[i * COLUMNS + k] /= (real)weight[i / DIM] * weight[k / DIM];
        }
    real log_det = factor(V, COLUMNS);
    for (int i = 0; i < COLUMNS; i++)
        for (int k = 0; k <= i; k++)
            inverse[i][k] = inverse[k][i] = product(V, unit[i], unit[k], COLUMNS);

    for (int b = 0; b < BLOCKS; b++) l.block[b].free_mean = false;
    assert_true(mukca_whitening_create(&w, &pool, SAMPLES, BLOCKS, DIM));
    mukca_whitening_set(&w, &l.samples, family, shape, weight);
    mukca_whitening_apply(&(mukca_whitened){COLUMNS, COLUMNS, unit[0], A[0], NULL}, &w, &l.samples);
    mukca_whitening_transpose(T[0], unit[0], COLUMNS, COLUMNS, &w, &l.samples);
    if (!weight) assert_close(w.log_det, (double)(-log_det / 2), 1e-9);
    for (int i = 0; i < COLUMNS; i++)
        for (int k = 0; k < COLUMNS; k++) {
            real sum = 0;
            for (int t = 0; t < COLUMNS; t++) sum += (real)A[t][i] * A[t][k];
            assert_close((double)sum, (double)inverse[i][k], 1e-10 * (double)(1 + fabsl(sum)));
            assert_close(T[i][k], A[k][i], 1e-12 * (1 + fabs(A[k][i])));
        }

    lay_out(&l);
    mukca_whitening_set(&w, &l.samples, family, shape, weight);
    mukca_whitening_apply(&(mukca_whitened){COLUMNS, COLUMNS, unit[0], F[0], mean[0]}, &w,
                          &l.samples);
    mukca_whitening_transpose(T[0], F[0], COLUMNS, COLUMNS, &w, &l.samples);
    memcpy(left, unit, sizeof left);
    for (int b = 0; b < BLOCKS; b++) {
        const int first = l.block[b].start * DIM, end = first + l.block[b].count * DIM;
        real H[DIM * DIM] = {0};
        double X[COLUMNS][DIM] = {{0}}; /* V^-1 times columns of ones */
        if (!l.block[b].free_mean) continue;
        for (int k = 0; k < COLUMNS; k++)
            for (int i = first; i < end; i++) X[k][i % DIM] += (double)inverse[k][i];
        for (int i = first; i < end; i++)
            for (int c = 0; c < DIM; c++) H[i % DIM * DIM + c] += X[i][c];
        log_det += factor(H, DIM);
        for (int k = 0; k < COLUMNS; k++)
            for (int c = 0; c < DIM; c++)
                assert_close(mean[b * DIM + c][k], (double)product(H, unit[c], X[k], DIM), 1e-10);
        for (int i = first; i < end; i++)
            for (int k = 0; k < COLUMNS; k++) left[i][k] -= mean[b * DIM + i % DIM][k];
    }
    assert_int_equal(w.dof, DIM * (SAMPLES - 2));
    if (!weight) assert_close(w.log_det, (double)(-log_det / 2), 1e-9);
    for (int i = 0; i < COLUMNS; i++)
        for (int k = 0; k < COLUMNS; k++) {
            real white = 0, back = 0;
            for (int t = 0; t < COLUMNS; t++) {
                white += (real)A[i][t] * left[t][k];
                back += inverse[i][t] * left[t][k];
            }
            assert_close(F[i][k], (double)white, 1e-10 * (double)(1 + fabsl(white)));
            assert_close(T[i][k], (double)back, 1e-9 * (double)(1 + fabsl(back)));
        }
    mukca_pool_free(&pool);
}

/* ---- positions in groups ---- */

enum {
    N = 4,
    GROUPS = 6,
    ROW = N + 1,
    SHARED = 3 * GROUPS + N, /* the error of the distances */
    ALL = SHARED + 1
};

/* Add a row v[ALL] of that precision. */
static void add_row(real *A, const double *v, double precision)
{
    for (int i = 0; i < ALL; i++)
        for (int k = 0; k < ALL; k++) A[i * ALL + k] += precision * (real)v[i] * v[k];
}

/* Twice two groups a known distance apart, with the same error, two without one, and positions that
 * are removed and added again: the variances are those of one regression with all unknowns, of
 * which the coefficients have priors. */
TEST(groups)
{
    static real A[ALL * ALL];
    double x[4 * GROUPS][3 * ROW], v[ALL], row[N];
    const double noise = 0.1, sigma = 0.02;
    uint64_t seed = 5;
    mukca_pool pool = {0};
    mukca_grouped g;
    assert_true(mukca_grouped_create(&g, &pool, N, GROUPS, 2));
    g.noise = noise;
    g.pair[0] = (mukca_group_pair){0, 1, 0, sigma};
    g.pair[1] = (mukca_group_pair){2, 3, 0, sigma};
    for (int i = 0; i < ALL; i++) {
        const int c = i - 3 * GROUPS; /* the means have no prior */
        memset(v, 0, sizeof v), v[i] = 1;
        if (c >= 0 && c < N) g.posterior.prior[c] = 0.5 + c;
        add_row(A, v, c < 0 ? 1e-12 : pow(c == N ? sigma : g.posterior.prior[c], -2));
    }
    for (int r = 0; r < 4 * GROUPS; r++) {
        const int group = r % GROUPS;
        for (int i = 0; i < 3 * ROW; i++) x[r][i] = draw(&seed);
        for (int k = 0; k < (r == 3 ? 1 : 3); k++)
            mukca_grouped_add(&g, x[r], group, k % 2 ? -1 : 1);
        for (int a = 0; a < 3; a++) {
            memset(v, 0, sizeof v), v[3 * group + a] = 1;
            memcpy(v + 3 * GROUPS, x[r] + a * ROW, N * sizeof *v);
            add_row(A, v, 1 / (noise * noise));
        }
    }
    for (int pair = 0; pair < 2; pair++) {
        double *of = v + 6 * pair, far = 0;
        memset(v, 0, sizeof v), v[SHARED] = -1;
        for (int a = 0; a < 3; a++) { /* along the distance at coefficients 0 */
            for (int r = 0; r < 4 * GROUPS; r++)
                if (r % GROUPS / 2 == pair) of[a] += (r % 2 ? -1 : 1) * x[r][a * ROW + N] / 4;
            far = hypot(far, of[a]);
        }
        for (int a = 0; a < 3; a++) of[a] /= far, of[3 + a] = -of[a];
        add_row(A, v, 1e9); /* of the means themselves: exact to 1e-8 */
    }
    factor(A, ALL);
    mukca_grouped_solve(&g);
    for (int i = 0; i < N; i++) {
        memset(v, 0, sizeof v), v[3 * GROUPS + i] = 1;
        memset(row, 0, sizeof row), row[i] = 1;
        assert_close(mukca_posterior_variance(row, &g.posterior), (double)product(A, v, v, ALL),
                     1e-7);
    }
    mukca_pool_free(&pool);
}

TEST(whitening)
{
    static const mukca_noise_family families[] = {{0, 0},    {0.25, 0},  {0.75, 0},   {0, 0.5},
                                                  {0, 0.75}, {0, 0.999}, {0.5, 0.75}, {0.75, 0.3}};
    double weight[SAMPLES];
    uint64_t seed = 9;
    for (size_t f = 0; f < sizeof families / sizeof *families; f++)
        for (int shaped = 0; shaped < 2; shaped++) check_family(families[f], shaped, NULL);
    for (int i = 0; i < SAMPLES; i++) weight[i] = 0.6 + 0.4 * draw(&seed);
    check_family(families[0], false, weight); /* robust weights imply independent samples */
}

/* ---- evidence and sets ---- */

enum { ROWS = 40, MODEL = 3, WIDTH = 24, ITEMS = 9, PROJECTED = ROWS + MODEL };

/* A model X that is projected out, items, and y. */
typedef struct {
    double X[MODEL][ROWS], E[WIDTH][ROWS], y[ROWS];
    mukca_item item[ITEMS];
    double columns[WIDTH / 8][PROJECTED][8], g[WIDTH];
    mukca_question question;
} problem;

/* V + size^2 x x' */
static void add_column(real *V, const double *x, double size)
{
    for (int i = 0; i < ROWS; i++)
        for (int k = 0; k < ROWS; k++) V[i * ROWS + k] += (real)size * size * x[i] * x[k];
}

static void model_covariance(real *V, const problem *p)
{
    for (int i = 0; i < ROWS * ROWS; i++) V[i] = i % (ROWS + 1) == 0;
    for (int t = 0; t < MODEL; t++) add_column(V, p->X[t], 1);
}

static void add_item(real *V, const problem *p, int item, int size)
{
    const mukca_item *h = &p->item[item];
    for (int t = 0; t < h->terms; t++) add_column(V, p->E[h->at + t], h->prior.size[size]);
}

/* Log evidence of y with the covariance sigma^2 V, at the best sigma; V := its factor. */
static real dense_evidence(real *V, const double *y, real *squares)
{
    const real log_det = factor(V, ROWS);
    *squares = product(V, y, y, ROWS);
    return -log_det / 2 - ROWS / 2.0L * logl(*squares);
}

/* Log evidence of the model and items, each with its size, less that of the model. */
static real dense_value(const problem *p, const int *item, const int *size, int n)
{
    real V[ROWS * ROWS], without, squares;
    model_covariance(V, p);
    without = dense_evidence(V, p->y, &squares);
    model_covariance(V, p);
    for (int i = 0; i < n; i++) add_item(V, p, item[i], size[i]);
    return dense_evidence(V, p->y, &squares) - without;
}

/* Log of twice the probability that the first coefficient of item[0] is positive, by Simpson's rule
 * over it; the noise has the sigma of maximal evidence of all items. */
static real dense_sign(const problem *p, const int *item, const int *size, int n)
{
    enum { STEPS = 4000 };
    real V[ROWS * ROWS], squares, sum[2] = {0};
    const mukca_item *first = &p->item[item[0]];
    const double s = first->prior.size[size[0]];
    double rest[ROWS];
    model_covariance(V, p);
    for (int i = 0; i < n; i++) add_item(V, p, item[i], size[i]);
    dense_evidence(V, p->y, &squares);
    const real variance = squares / ROWS;
    model_covariance(V, p);
    for (int i = 1; i < n; i++) add_item(V, p, item[i], size[i]);
    for (int t = 1; t < first->terms; t++) add_column(V, p->E[first->at + t], s);
    factor(V, ROWS);
    const double most = fmin(8 * s * sqrt((double)variance), 10); /* beyond: no density */
    for (int k = -STEPS; k <= STEPS; k++) {
        const double b = most * k / STEPS;
        for (int i = 0; i < ROWS; i++) rest[i] = p->y[i] - b * p->E[first->at][i];
        real density = product(V, rest, rest, ROWS) + (real)b * b / (s * s);
        density = expl((squares - density) / variance / 2) * (abs(k) == STEPS || k == 0 ? 1
                                                              : k % 2                   ? 4
                                                                                        : 2);
        if (k >= 0) sum[1] += density;
        if (k <= 0) sum[0] += density;
    }
    return logl(2 * sum[1] / (sum[0] + sum[1]));
}

/* Normal equations of the items with the model projected out, by definition. */
static void project(problem *p)
{
    real A[MODEL * MODEL], V[ROWS * ROWS], squares;
    for (int i = 0; i < MODEL * MODEL; i++) {
        A[i] = i % (MODEL + 1) == 0;
        for (int r = 0; r < ROWS; r++) A[i] += (real)p->X[i / MODEL][r] * p->X[i % MODEL][r];
    }
    factor(A, MODEL);
    for (int c = 0; c <= WIDTH; c++) { /* the last one is y */
        const double *x = c < WIDTH ? p->E[c] : p->y;
        real T[MODEL] = {0};
        static real z[MODEL];
        for (int t = 0; t < MODEL; t++) {
            for (int r = 0; r < ROWS; r++) T[t] += (real)p->X[t][r] * x[r];
            for (int k = 0; k < t; k++) T[t] -= A[t * MODEL + k] * T[k];
            T[t] /= A[t * MODEL + t];
            if (c < WIDTH) p->columns[c / 8][ROWS + t][c % 8] = (double)T[t];
        }
        for (int r = 0; r < ROWS && c < WIDTH; r++) p->columns[c / 8][r][c % 8] = x[r];
        memcpy(z, T, sizeof z);
        for (int k = 0; k < WIDTH && c == WIDTH; k++) {
            real sum = 0;
            for (int r = 0; r < ROWS; r++) sum += (real)p->E[k][r] * p->y[r];
            for (int t = 0; t < MODEL; t++) sum -= z[t] * p->columns[k / 8][ROWS + t][k % 8];
            p->g[k] = (double)sum;
        }
    }
    model_covariance(V, p);
    dense_evidence(V, p->y, &squares);
    p->question = (mukca_question){.n_items = ITEMS,
                                   .n_columns = WIDTH,
                                   .stride = WIDTH,
                                   .n_rows = PROJECTED,
                                   .n_projected = MODEL,
                                   .dof = ROWS,
                                   .item = p->item,
                                   .E = p->columns[0][0],
                                   .g = p->g,
                                   .residual = (double)squares};
}

/* Items of one to four columns, with so many sizes each; 1 and 4 are in y. */
static void pose(problem *p, int sizes)
{
    static const int terms[ITEMS] = {1, 2, 3, 1, 4, 2, 1, 3, 2};
    uint64_t seed = 3;
    int at = 0;
    memset(p, 0, sizeof *p);
    for (int i = 0; i < ITEMS; at += terms[i++]) {
        p->item[i] = (mukca_item){.at = at, .terms = terms[i], .log_prior = -4 - 0.1 * i, .key = i};
        p->item[i].prior.n_sizes = sizes;
        for (int s = 0; s < sizes; s++) {
            p->item[i].prior.size[s] = (sizes == 1 ? 2 : 0.3) * pow(2.5, s);
            p->item[i].prior.log_weight[s] = log((1.0 + s) / (sizes * (sizes + 1) / 2.0));
        }
    }
    for (int r = 0; r < ROWS; r++) {
        for (int t = 0; t < MODEL; t++) p->X[t][r] = draw(&seed);
        for (int c = 0; c < at; c++) p->E[c][r] = draw(&seed) + 0.4 * p->X[c % MODEL][r];
        p->y[r] = 1.2 * p->X[0][r] + 1.5 * p->E[1][r] + 1.1 * p->E[8][r] - 0.9 * p->E[9][r];
        for (int k = 0; k < 4; k++) p->y[r] += 0.4 * draw(&seed);
    }
    project(p);
}

static problem p, other; /* of the test */

/* Average over the sizes of one block, and its sign. */
TEST(mixtures)
{
    for (int sizes = 1; sizes <= MUKCA_MOST_SIZES; sizes += 2) {
        pose(&p, sizes);
        for (int i = 0; i < ITEMS; i++)
            for (int positive = 0; positive < 2; positive++) {
                mukca_item *h = &p.item[i];
                const int k = h->terms;
                static mukca_mixture_scratch scratch;
                double G[MODEL + ROWS], by_size[MUKCA_MOST_SIZES];
                real sum = 0;
                for (int a = 0; a < k * k; a++) {
                    const int b = h->at + a / k, c = h->at + a % k;
                    G[a] = 0;
                    for (int r = 0; r < PROJECTED; r++)
                        G[a] += (r < ROWS ? 1 : -1) * p.columns[b / 8][r][b % 8] *
                                p.columns[c / 8][r][c % 8];
                }
                h->prior.nonnegative = positive;
                const double value = mukca_mixture_evidence(
                    by_size, &(mukca_equations){G, p.g + h->at, k, ROWS, p.question.residual},
                    &h->prior, &scratch);
                for (int s = 0; s < sizes; s++) {
                    real expected = dense_value(&p, &i, &s, 1) + h->prior.log_weight[s];
                    if (positive) expected += dense_sign(&p, &i, &s, 1);
                    assert_close(by_size[s], (double)expected, 1e-6); /* of Simpson's rule */
                    sum += expl(expected);
                }
                assert_close(value, (double)logl(sum), 1e-6);
            }
    }
}

static double insert(mukca_sets *sets, const int *item, int n)
{
    const int at = mukca_sets_insert(sets, item, NULL, n);
    assert_true(at >= 0 && sets->set[at].exact && sets->set[at].n == n);
    return sets->set[at].value;
}

/* Evidence of sets, with the columns of their items really added. */
TEST(values)
{
    static const int members[][3] = {{4}, {7}, {1, 4}, {0, 8}, {1, 4, 6}, {2, 5, 7}};
    static const int numbers[] = {1, 1, 2, 2, 3, 3}, one[3] = {0};
    pose(&p, 1);
    for (int i = 0; i < ITEMS; i++) p.item[i].kin = i % 3, p.item[i].kinship = 0.7;
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        for (int positive = 0; positive < 2; positive++) {
            const int n = numbers[i], *member = members[i];
            mukca_pool pool = {0};
            mukca_sets sets;
            double prior = 0, rest = 0;
            p.item[member[0]].prior.nonnegative = positive;
            assert_true(mukca_sets_create(&sets, &pool, &p.question));
            real expected = dense_value(&p, member, one, n);
            if (positive) expected += dense_sign(&p, member, one, n);
            bool kin[3] = {false};
            double further = 0; /* of the last member */
            for (int k = 0; k < n; k++) {
                const mukca_item *h = &p.item[member[k]];
                further = h->kin && kin[h->kin] ? h->kinship : 0;
                kin[h->kin] = true;
                prior += h->log_prior + further;
            }
            const double value = insert(&sets, member, n);
            assert_close(value, (double)expected + prior, 1e-6); /* of Simpson's rule */
            p.item[member[0]].prior.nonnegative = false;
            if (!positive) { /* one item more */
                const int last = member[n - 1];
                rest = insert(&sets, member, n - 1);
                const mukca_set set = sets.set[mukca_sets_insert(&sets, member, NULL, n - 1)];
                assert_true(mukca_sets_weigh(&sets, &set));
                assert_close(mukca_sets_gain(&sets, &set, last) + p.item[last].log_prior + further,
                             value - rest, 1e-9);
            }
            mukca_pool_free(&pool);
        }
}

/* Sizes of several items: each is averaged with the others at their maximum. */
TEST(averages)
{
    static const int pair[2] = {1, 4};
    mukca_pool pool = {0};
    mukca_sets sets;
    real sum = 0;
    pose(&p, 5);
    assert_true(mukca_sets_create(&sets, &pool, &p.question));
    for (int a = 0; a < 5; a++)
        for (int b = 0; b < 5; b++) {
            const int size[2] = {a, b};
            sum += expl(dense_value(&p, pair, size, 2) + p.item[1].prior.log_weight[a] +
                        p.item[4].prior.log_weight[b]);
        }
    assert_close(insert(&sets, pair, 2),
                 (double)logl(sum) + p.item[1].log_prior + p.item[4].log_prior,
                 0.05); /* of the product of two averages: 5 % of a probability */
    mukca_pool_free(&pool);
}

/* The question of a part from products of its columns: the same as from all of the columns. */
TEST(parts)
{
    enum { EACH = MODEL + 1 + WIDTH };
    static const int members[] = {1, 4, 6};
    static double gram[EACH][EACH];
    mukca_pool pool = {0};
    mukca_question part;
    mukca_sets sets[2];
    double product[2][9], mean[WIDTH + 8];
    pose(&p, 5);
    for (int a = 0; a < EACH; a++)
        for (int b = 0; b < EACH; b++) {
            const double *x = a < MODEL    ? p.X[a]
                              : a == MODEL ? p.y
                                           : p.E[a - MODEL - 1],
                         *y = b < MODEL    ? p.X[b]
                              : b == MODEL ? p.y
                                           : p.E[b - MODEL - 1];
            gram[a][b] = 0;
            for (int r = 0; r < ROWS; r++) gram[a][b] += x[r] * y[r];
        }
    const mukca_part_layout of = {MODEL, ITEMS, WIDTH, p.item};
    assert_true(mukca_part_question(&part, &pool, gram[0], ROWS, &of));
    assert_close(part.residual, p.question.residual, 1e-10 * ROWS);
    for (int k = 0; k < WIDTH; k++) assert_close(part.g[k], p.g[k], 1e-10 * ROWS);
    for (int k = 0; k < 2; k++) {
        assert_true(mukca_sets_create(&sets[k], &pool, k ? &part : &p.question));
        const int at = mukca_sets_insert(&sets[k], members, NULL, 3);
        mukca_sets_products(product[k], mean, &sets[k], &sets[k].set[at]);
    }
    assert_close(insert(&sets[1], members, 3), insert(&sets[0], members, 3), 1e-9 * ROWS);
    for (int i = 0; i < 9; i++) assert_close(product[1][i], product[0][i], 1e-9 * ROWS);
    mukca_pool_free(&pool);
}

/* Probability of each item, as the share of the sets with it. */
static void search(double *probability, const mukca_question *question)
{
    mukca_pool pool = {0};
    mukca_sets sets;
    double total = 0;
    assert_true(mukca_sets_create(&sets, &pool, question));
    mukca_sets_explore(&sets, 10, false);
    mukca_sets_explore(&sets, 30, true);
    assert_false(pool.failed);
    for (int i = 0; i < sets.n_sets; i++) mukca_sets_evaluate(&sets, i);
    memset(probability, 0, sizeof *probability * ITEMS);
    for (int i = 0; i < sets.n_sets; i++) {
        const double weight = exp(sets.set[i].value - sets.set[sets.best].value);
        total += weight;
        for (int k = 0; k < sets.set[i].n; k++) probability[sets.set[i].item[k]] += weight;
    }
    for (int i = 0; i < ITEMS; i++) probability[i] /= total;
    mukca_pool_free(&pool);
}

/* The same items in another order. */
static void permute(const int *order)
{
    other = p;
    for (int i = 0, at = 0; i < ITEMS; at += other.item[i++].terms) {
        const mukca_item *h = &p.item[order[i]];
        memcpy(other.E[at], p.E[h->at], sizeof *other.E * (size_t)h->terms);
        other.item[i] = *h;
        other.item[i].at = at;
    }
    project(&other);
}

TEST(searches)
{
    static const int order[ITEMS] = {6, 4, 8, 0, 2, 7, 1, 5, 3};
    double probability[ITEMS], again[ITEMS];
    for (int sizes = 1; sizes <= 5; sizes += 4) {
        pose(&p, sizes);
        search(probability, &p.question);
        for (int i = 0; i < ITEMS; i++)
            if (i == 1 || i == 4)
                assert_true(probability[i] > 0.99);
            else
                assert_true(probability[i] < 0.1);
        permute(order);
        search(again, &other.question);
        for (int i = 0; i < ITEMS; i++)
            assert_close(again[i], probability[order[i]], 1e-9); /* rounding */
    }
}

/* Columns that are there twice: both explain the data as well. */
TEST(duplicates)
{
    double probability[ITEMS];
    pose(&p, 5);
    memcpy(p.E[p.item[8].at], p.E[p.item[1].at], sizeof *p.E * 2);
    p.item[8].log_prior = p.item[1].log_prior;
    project(&p);
    search(probability, &p.question);
    assert_close(probability[1], probability[8], 1e-9); /* rounding */
    assert_true(probability[1] > 0.49 && probability[1] < 0.55);
    assert_true(probability[4] > 0.99);
    p.item[8].key = p.item[1].key; /* variants of one cause: never together */
    search(probability, &p.question);
    assert_close(probability[1], 0.5, 1e-3); /* of the sets without it */
    assert_close(probability[8], 0.5, 1e-3);
}

/* A model that knows no friction lacks three effects at each of seven joints and more: all are in
 * one set. */
TEST(many_members)
{
    enum { MANY = 32 };
    static mukca_item item[MANY];
    static double gram[MANY][MANY], g[MANY];
    const double square = 50, dof = 1000;
    mukca_pool pool = {0};
    mukca_sets sets;
    for (int i = 0; i < MANY; i++) {
        item[i] = (mukca_item){
            .at = i, .terms = 1, .prior = {.n_sizes = 1, .size = {1}}, .log_prior = -3, .key = i};
        gram[i][i] = g[i] = square;
    }
    const mukca_question question = {.n_items = MANY,
                                     .n_columns = MANY,
                                     .stride = MANY,
                                     .dof = (int)dof,
                                     .item = item,
                                     .gram = gram[0],
                                     .g = g,
                                     .residual = dof + MANY * square};
    assert_true(mukca_sets_create(&sets, &pool, &question));
    mukca_sets_explore(&sets, 2 * MANY, false);
    assert_int_equal(sets.set[sets.best].n, MANY);
    mukca_pool_free(&pool);
}

TEST_MAIN(NULL, NULL)
