/* A mix-up of joint columns that explains data that do not fit the arm. */
#include "fit/mismatch.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pool.h"
#include "fit/align.h"
#include "math/stats.h"
#include "model/dataset_subset.h"

/* Ratio of the errors after and before a mix-up below which it is no coincidence: real errors of
 * origins reach 1 cm at the tip, those of a wrong column 10 cm and more. */
static const double explained = 0.2, origins = 10e-3; /* m per metre of the arm */
/* A less simple mix-up must reduce the error by this factor: reversing a joint with little
 * influence on the ball changes the error by less. */
static const double simpler = 0.5;
/* A zero this close to a quarter turn is that, rad: joints are built to 3 degrees (MUKCA_PRIOR). */
static const double quarter = 0.05;
/* MOST_PATTERNS: up to this number of joints, all patterns of reversed joints are tried; beyond,
 * single joints.  SEARCHED: samples of the
 * search.  BEST: number of mix-ups that further changes are added to.
 * STEPS of the alignment: its closed form is near. */
enum { MOST_PATTERNS = 8, MOST_SAMPLES = 500, SEARCHED = 40, BEST = 6, STEPS = 2 };

typedef struct {
    const mukca_chain *chain;
    mukca_geometry geometry;
    mukca_dataset *data;
    mukca_align_options frames;
    const double *q;   /* as recorded */
    double (*x)[3];    /* [n_rows] predicted, of pose logs minus measured */
    double (*sum)[4];  /* [n_sockets] of those, and their number */
    mukca_mixup *best; /* [BEST] distinct ones, the smallest error first */
    double origins;    /* error of real origins, m */
    bool fixed;        /* the frame of measured poses is the arm's base */
    bool failed;       /* out of memory */
} search;

static mukca_mixup as_recorded(int n)
{
    mukca_mixup m = {.error_m = HUGE_VAL, .square = HUGE_VAL};
    for (int j = 0; j < n; j++) m.from[j] = j;
    return m;
}

/* Set the angles of row r by the mix-up. */
static void change(search *s, const mukca_mixup *m, int r)
{
    const int n = s->data->n_joints;
    const double *from = s->q + (size_t)r * (size_t)n;
    double *q = s->data->q + (size_t)r * (size_t)n;
    for (int j = 0; j < n; j++) {
        q[j] = (m->reversed >> j & 1 ? -1 : 1) * from[m->from[j]] + m->shift[j];
        if (m->coupled[j]) q[j] += (m->coupled[j] < 0 ? -1 : 1) * from[abs(m->coupled[j]) - 1];
    }
}

/* Set the error of the nominal model with the mix-up: mean and mean square of the distances to the
 * measured positions, in the frames that are free, and to the sockets' means. */
static void measure(mukca_mixup *m, search *s)
{
    mukca_dataset *d = s->data;
    const int *used = s->frames.group;
    mukca_alignment a = {.tracker.R = MUKCA_IDENTITY, .target.R = MUKCA_IDENTITY};
    mukca_align_options frames = s->frames;
    int n = 0;
    frames.tracker |= m->base;
    for (int r = 0; r < d->n_rows; r++)
        if (used[r]) change(s, m, r);
    s->failed |= d->position && !mukca_align(&a, &s->geometry, d, &frames);
    memset(s->sum, 0, (size_t)(d->n_sockets + 1) * sizeof *s->sum);
    for (int r = 0; r < d->n_rows; r++) {
        const int socket = d->socket[r];
        mukca_frame T;
        if (!used[r]) continue;
        mukca_fk_pose(&T, &s->geometry, d->q + (size_t)r * (size_t)d->n_joints, NULL);
        mukca_frame_multiply(&T, &T, &a.target);
        mukca_frame_multiply(&T, &a.tracker, &T);
        for (int c = 0; c < 3; c++) {
            s->x[r][c] = socket < 0 && d->position ? T.p[c] - d->position[3 * r + c] : T.p[c];
            if (socket >= 0) s->sum[socket][c] += T.p[c];
        }
        if (socket >= 0) s->sum[socket][3]++;
    }
    m->square = m->error_m = 0;
    for (int r = 0; r < d->n_rows; r++) {
        const double *sum = d->socket[r] < 0 ? NULL : s->sum[d->socket[r]];
        double e[3];
        if (!used[r]) continue;
        for (int c = 0; c < 3; c++) e[c] = s->x[r][c] - (sum ? sum[c] / sum[3] : 0);
        const double square = mukca_dot3(e, e);
        if (isfinite(square)) m->square += square, m->error_m += sqrt(square), n++;
    }
    m->square /= n, m->error_m /= n;
    m->base_frame = a.tracker;
}

/* Remember a mix-up if it is among the best. */
static void keep(search *s, const mukca_mixup *m)
{
    int k = BEST;
    for (int i = 0; i < BEST; i++)
        if (fabs(m->square - s->best[i].square) <= 1e-6 * m->square) return; /* the same */
    while (k > 0 && m->square < s->best[k - 1].square) k--;
    if (k == BEST) return;
    memmove(s->best + k + 1, s->best + k, (size_t)(BEST - 1 - k) * sizeof *m);
    s->best[k] = *m;
}

/* A mix-up as a function of the zero of one joint. */
typedef struct {
    search *s;
    mukca_mixup tried, *best;
    int joint;
} zero;

static double try_zero(void *context, double shift)
{
    zero *z = context;
    z->tried.shift[z->joint] = shift;
    measure(&z->tried, z->s);
    if (z->tried.square < z->best->square) *z->best = z->tried;
    return z->tried.square;
}

/* Where the error is least by the zero of joint j alone, nearly.  Positions depend on the sine and
 * the cosine of a joint's angle, so that squares of distances have two harmonics, which five values
 * determine; in frames that are free, nearly. */
static void shift_zero(mukca_mixup *m, search *s, int j)
{
    enum { VALUES = 5, GRID = 720 };
    const double start = m->shift[j];
    double wave[VALUES] = {0}, least = HUGE_VAL, best = 0;
    zero z = {s, *m, m, j};
    for (int k = 0; k < VALUES; k++) {
        const double t = 2 * M_PI * k / VALUES,
                     square = try_zero(&z, remainder(start + t, 2 * M_PI));
        for (int h = 0; h < VALUES; h++) { /* 1, cos t, sin t, cos 2 t, sin 2 t */
            const int n = (h + 1) / 2;
            wave[h] += 0.4 * square * (h % 2 || !h ? cos(n * t) : sin(n * t));
        }
    }
    for (int g = 0; g < GRID; g++) {
        const double t = 2 * M_PI * g / GRID, f = wave[1] * cos(t) + wave[2] * sin(t) +
                                                  wave[3] * cos(2 * t) + wave[4] * sin(2 * t);
        if (f < least) least = f, best = t;
    }
    try_zero(&z, remainder(start + best, 2 * M_PI));
}

/* The least error near the zero of joint j, to a tenth of a milliradian. */
static void refine_zero(mukca_mixup *m, search *s, int j)
{
    const double near = 0.1, at = m->shift[j];
    zero z = {s, *m, m, j};
    mukca_stats_minimize(NULL, try_zero, &z, at - near, at + near, 1e-4);
}

/* Shift the zero of the joint that reduces the error most, at most `rounds` times. */
static void shift_zeros(search *s, mukca_mixup m, int rounds)
{
    for (bool better = true; better && rounds-- > 0;) {
        const mukca_mixup start = m;
        int best = 0;
        for (int j = 0; j < s->data->n_joints; j++) {
            mukca_mixup tried = start;
            if (s->chain->element[s->chain->joint_element[j]].type == MUKCA_PRISMATIC) continue;
            shift_zero(&tried, s, j);
            if (tried.square < m.square) m = tried, best = j;
        }
        if (m.shift[best] != 0) refine_zero(&m, s, best);
        better = m.square < simpler * start.square;
    }
    keep(s, &m);
}

/* Try a mix-up, with `rounds` of shifted zeros. */
static void try(search *s, mukca_mixup m, int rounds)
{
    measure(&m, s);
    keep(s, &m);
    if (rounds) shift_zeros(s, m, rounds);
}

static void exchange(mukca_mixup *m, int a, int b)
{
    const int from = m->from[a];
    m->from[a] = m->from[b], m->from[b] = from;
}

/* Try all single changes of a mix-up. */
static void try_changes(search *s, const mukca_mixup *m, int rounds)
{
    const int n = s->data->n_joints;
    mukca_mixup tried = *m;
    tried.base = s->fixed;
    if (s->fixed && !m->base) try(s, tried, rounds);
    for (int a = 0; a < n; a++) {
        tried = *m, tried.reversed ^= 1u << a;
        try(s, tried, rounds);
        for (int b = 0; b < n; b++) {
            tried = *m, exchange(&tried, a, b);
            if (b > a) try(s, tried, rounds);
            for (int sign = -1; sign <= 1 && a != b; sign += 2) {
                tried = *m, tried.coupled[a] = sign * (b + 1);
                try(s, tried, rounds);
            }
        }
    }
}

static void try_patterns(search *s, int rounds)
{
    mukca_mixup m = as_recorded(s->data->n_joints);
    if (s->data->n_joints <= MOST_PATTERNS)
        for (; m.reversed < 1u << s->data->n_joints; m.reversed++) try(s, m, rounds);
}

/* Undo what the mix-up does not need for an error below `limit`.  The base's frame is named before
 * the zero of a joint about the same axis, quarters of a turn before other angles. */
static void simplify(mukca_mixup *m, search *s, double limit)
{
    enum { BASE, SHIFT, SIGN, COUPLED, COLUMN, FIXED, QUARTER, KINDS };
    const int n = s->data->n_joints;
    for (int step = 0; step < KINDS * n; step++) {
        const int j = step % n, kind = step / n;
        const double turns = nearbyint(m->shift[j] / (M_PI / 2)) * (M_PI / 2);
        mukca_mixup tried = *m;
        if (kind == BASE && s->fixed && j == 0 && m->shift[0] != 0) tried.base = true;
        if ((kind == BASE && tried.base) || kind == SHIFT) tried.shift[j] = 0;
        if (kind == SIGN) tried.reversed &= ~(1u << j);
        if (kind == COUPLED) tried.coupled[j] = 0;
        if (kind == FIXED) tried.base = false;
        if (kind == QUARTER && fabs(m->shift[j] - turns) < quarter) tried.shift[j] = turns;
        for (int a = 0; a < n && kind == COLUMN; a++)
            if (tried.from[a] == j && a != j) exchange(&tried, a, j);
        measure(&tried, s);
        if (tried.error_m < limit) *m = tried;
    }
    if (!m->base) return;
    mukca_mixup tried = *m;
    tried.base = false;
    measure(&tried, s);
    shift_zero(&tried, s, 0);
    if (tried.error_m < limit) m->equivalent_shift = tried.shift[0];
}

static int count(const mukca_mixup *m, int n)
{
    int changes = m->base;
    for (int j = 0; j < n; j++)
        changes += (int)(m->reversed >> j & 1) + (m->shift[j] != 0) + (m->coupled[j] != 0) +
                   (m->from[j] > j);
    return changes;
}

/* From few changes to many, until the error is that of real origins. */
static void find(mukca_mismatch *mismatch, search *s)
{
    const int n = s->data->n_joints;
    mukca_mixup start = as_recorded(n), better[BEST];
    for (int i = 0; i < BEST; i++) s->best[i] = start;
    measure(&start, s);
    mismatch->mixup = start;
    if (!(start.error_m > s->origins)) return;
    for (int step = 0; step < 5 && !(s->best[0].error_m < s->origins); step++) {
        memcpy(better, s->best, sizeof better);
        if (step == 0) try_changes(s, &start, 0), shift_zeros(s, start, 3), try_patterns(s, 0);
        if (step == 1) try_patterns(s, 1);
        if (step == 2) try_changes(s, &start, 1);
        for (int i = 0; i < BEST && step > 2; i++) {
            if (step == 3) shift_zeros(s, better[i], n);
            if (step == 4) try_changes(s, &better[i], 0);
        }
    }
    mukca_mixup *m = &mismatch->mixup;
    *m = s->best[0];
    s->frames.steps = 0;
    measure(m, s);
    for (int k = 0; k < 3 * n; k++)
        if (m->shift[k % n] != 0) refine_zero(m, s, k % n);
    simplify(m, s, fmax(m->error_m / simpler, fmin(s->origins, explained * start.error_m)));
    mismatch->found = count(m, n) > 0 && m->error_m < explained * start.error_m &&
                      (count(m, n) == 1 || m->error_m < s->origins);
}

/* Use some `most` samples of the first target, evenly spread by the golden section: no pattern of
 * the recording is met. */
static void use(int *used, const mukca_dataset *data, int most)
{
    int n = 0;
    for (int r = 0; r < data->n_rows; r++) {
        used[r] = data->n_targets < 2 || data->target[r] == data->target[0];
        n += used[r];
    }
    for (int r = 0; r < data->n_rows; r++)
        used[r] = used[r] && fmod(0.6180339887 * r, 1) * n <= most;
}

mukca_status mukca_mismatch_find(mukca_mismatch *mismatch, const mukca_chain *chain,
                                 const mukca_dataset *data, bool free_base, bool free_tool,
                                 mukca_error *error)
{
    mukca_dataset part = {0};
    mukca_pool pool = {0};
    *mismatch = (mukca_mismatch){.before_m = NAN};
    MUKCA_TRY(mukca_part_take(&part, data, MOST_SAMPLES, error));
    const size_t rows = (size_t)part.n_rows;
    search s = {.chain = chain,
                .data = &part,
                .fixed = part.position && !free_base,
                .frames = {.tracker = free_base,
                           .target = free_tool || part.n_targets > 1,
                           .only = 1,
                           .steps = STEPS},
                .x = MUKCA_TAKE(&pool, double[3], rows + 1),
                .sum = MUKCA_TAKE(&pool, double[4], part.n_sockets + 1),
                .best = MUKCA_TAKE(&pool, mukca_mixup, BEST)};
    double *q = MUKCA_TAKE(&pool, double, rows *(size_t)part.n_joints + 1);
    int *used = MUKCA_TAKE(&pool, int, rows + 1);
    s.failed = pool.failed;
    free(part.quaternion); /* with wrong angles, orientations determine no frame */
    part.quaternion = NULL;
    if (!s.failed && part.q) {
        s.q = memcpy(q, part.q, rows * (size_t)part.n_joints * sizeof *q);
        s.frames.group = used;
        mukca_geometry_set(&s.geometry, chain, NULL);
        for (int k = 0; k < chain->n_elements; k++)
            s.origins += origins * mukca_norm3(chain->element[k].xyz);
        use(used, &part, SEARCHED);
        find(mismatch, &s);
        use(used, &part, part.n_rows);
        mukca_mixup recorded = as_recorded(part.n_joints);
        measure(&recorded, &s);
        measure(&mismatch->mixup, &s);
        mismatch->before_m = recorded.error_m;
    }
    mukca_pool_free(&pool);
    mukca_dataset_free(&part);
    return s.failed ? mukca_fail(error, MUKCA_MEMORY, "out of memory") : MUKCA_OK;
}
