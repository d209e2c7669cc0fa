/* Signals of the runs: gaps cut, uniform grids, zero-phase filters, derivatives. */
#include "motion/signals.h"

#include <math.h>
#include <string.h>

#include "base/text.h"
#include "dynamics/signals.h"
#include "math/stats.h"

/* A gap: longer than ten steps, in which the angles may do anything. */
#define GAP 10.0
/* The grid has this many samples per period of the cutoff, or less than one more. */
#define OVERSAMPLED 6.0
/* Shortest stretch, s: one block and the transients of the filters. */
#define SHORTEST 1.0
/* Widths of the play operator, rad: from the windup of a gear to the sag of a cable. */
static const double plays[MUKCA_PLAYS] = {0.05, 0.2, 0.6};

typedef struct {
    mukca_signals *out;
    mukca_pool *pool;
    int n_joints, step; /* step: raw samples per sample of the grid */
    double raw;         /* s: raw step */
    mukca_lowpass angle, torque;
} maker;

static double median_step(const mukca_motion_input *in, mukca_pool *pool)
{
    int all = 0, n = 0;
    for (int r = 0; r < in->n_runs; r++) all += in->run[r].n;
    double *step = MUKCA_TAKE(pool, double, all + 1);
    for (int r = 0; r < in->n_runs && step; r++)
        for (int i = 1; i < in->run[r].n; i++)
            step[n++] = in->run[r].time[i] - in->run[r].time[i - 1];
    return step ? mukca_stats_median(step, n) : 0;
}

/* Linear interpolation of x[rows][n] of a run, from sample `first` on, to `count` equal steps. */
static void resample(double *out, const double *x, const mukca_run *run, int first, int count,
                     const maker *m)
{
    const int n = m->n_joints;
    int at = first;
    for (int i = 0; i < count; i++) {
        const double t = run->time[first] + i * m->raw;
        while (at + 2 < run->n && run->time[at + 1] <= t) at++;
        const double part =
            fmin(fmax((t - run->time[at]) / (run->time[at + 1] - run->time[at]), 0), 1);
        for (int j = 0; j < n; j++)
            out[i * n + j] = (1 - part) * x[at * n + j] + part * x[(at + 1) * n + j];
    }
}

/* First and last sample with motion. */
static bool find_motion(int ends[2], const double *dq, int rows, int n)
{
    ends[0] = -1;
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < n; j++)
            if (fabs(dq[i * n + j]) > MUKCA_LEAST_MOTION) {
                if (ends[0] < 0) ends[0] = i;
                ends[1] = i;
            }
    return ends[0] >= 0;
}

static void fill_play(mukca_stretch *s, int n)
{
    for (int i = 1; i < s->n; i++)
        for (int j = 0; j < n; j++)
            for (int k = 0; k < MUKCA_PLAYS; k++) {
                const int at = (i * n + j) * MUKCA_PLAYS + k;
                const double moved = (s->q[i * n + j] - s->q[(i - 1) * n + j]) / plays[k];
                s->play[at] = fmin(fmax(s->play[at - n * MUKCA_PLAYS] + moved, -1), 1);
            }
}

/* Add the samples first .. last of a run, which have no gap, if they move; `start`: time of its
 * first sample since the first run began. */
static void add_stretch(maker *m, const mukca_run *run, int first, int last, double start)
{
    const int n = m->n_joints;
    const int count = (int)floor((run->time[last] - run->time[first]) / m->raw) + 1;
    const mukca_lowpass *longer = m->angle.pad > m->torque.pad ? &m->angle : &m->torque;
    mukca_pool pool = {0};
    int ends[2] = {0, 0};
    double *q = MUKCA_TAKE(&pool, double, count *n + 1),
           *dq = MUKCA_TAKE(&pool, double, count *n + 1),
           *ddq = MUKCA_TAKE(&pool, double, count *n + 1),
           *torque = MUKCA_TAKE(&pool, double, count *n + 1),
           *scratch = MUKCA_TAKE(&pool, double, mukca_lowpass_scratch(longer, count));
    m->pool->failed |= pool.failed;
    if (count * m->raw < SHORTEST || pool.failed) goto out;
    resample(q, run->q, run, first, count, m);
    resample(torque, run->effort, run, first, count, m);
    mukca_lowpass_apply(q, count, n, n, &m->angle, scratch);
    mukca_differences(dq, q, count, n, m->raw);
    mukca_differences(ddq, dq, count, n, m->raw);
    if (m->step > 1) mukca_lowpass_apply(torque, count, n, n, &m->torque, scratch);
    mukca_stretch s = {.role = run->role};
    double *all[] = {q, dq, ddq, torque}, **kept[] = {&s.q, &s.dq, &s.ddq, &s.torque};
    for (int k = 0; k < 4; k++) s.n = mukca_decimate(all[k], count, n, m->step);
    /* the ends of the filtered angles are extrapolated */
    const int cut = (int)ceil(0.6 / (MUKCA_MOTION_CUTOFF * m->out->dt)) + 1;
    if (!find_motion(ends, dq, s.n, n)) goto out;
    ends[0] = ends[0] > cut ? ends[0] : cut;
    ends[1] = ends[1] < s.n - cut ? ends[1] : s.n - cut;
    s.n = ends[1] - ends[0];
    if (s.n * m->out->dt < SHORTEST) goto out;
    s.start = start + run->time[first] - run->time[0] + ends[0] * m->out->dt;
    for (int k = 0; k < 4; k++) {
        *kept[k] = MUKCA_TAKE(m->pool, double, s.n *n);
        if (*kept[k]) memcpy(*kept[k], all[k] + ends[0] * n, sizeof(double) * (size_t)(s.n * n));
    }
    s.play = MUKCA_TAKE(m->pool, double, s.n *n *MUKCA_PLAYS);
    if (!m->pool->failed) fill_play(&s, n);
    m->out->stretch[m->out->n++] = s;
    m->out->end = fmax(m->out->end, s.start + s.n * m->out->dt);
out:
    mukca_pool_free(&pool);
}

/* Cut a run at its gaps.  Returns their number. */
static int add_run(maker *m, const mukca_run *run, double start)
{
    int first = 0, gaps = 0;
    for (int i = 1; i <= run->n && m->out; i++) {
        const bool end = i == run->n;
        if (!end && run->time[i] - run->time[i - 1] <= GAP * m->raw) continue;
        if (i - first > 3) add_stretch(m, run, first, i - 1, start);
        gaps += !end;
        first = i;
    }
    return gaps;
}

/* Ranges of all signals; those of the torque are of the runs that are fitted. */
static void survey(mukca_signals *s)
{
    const int n = s->n_joints;
    double mean[MUKCA_MAX_JOINTS] = {0};
    long rows = 0;
    for (int j = 0; j < n; j++) s->low[j] = HUGE_VAL, s->high[j] = -HUGE_VAL;
    for (const mukca_stretch *k = s->stretch; k < s->stretch + s->n; k++)
        for (int i = 0; i < k->n; i++, rows++)
            for (int j = 0; j < n; j++) {
                const int at = i * n + j;
                s->low[j] = fmin(s->low[j], k->q[at]);
                s->high[j] = fmax(s->high[j], k->q[at]);
                s->fastest[j] = fmax(s->fastest[j], fabs(k->dq[at]));
                s->acceleration[j] += k->ddq[at] * k->ddq[at];
                s->forwards[j] |= k->dq[at] > MUKCA_LEAST_MOTION;
                s->backwards[j] |= k->dq[at] < -MUKCA_LEAST_MOTION;
                mean[j] += k->torque[at];
            }
    for (int j = 0; j < n; j++) s->acceleration[j] = sqrt(s->acceleration[j] / (double)rows);
    for (const mukca_stretch *k = s->stretch; k < s->stretch + s->n; k++)
        for (int i = 0; i < k->n; i++)
            for (int j = 0; j < n; j++)
                s->range[j] =
                    fmax(s->range[j], fabs(k->torque[i * n + j] - mean[j] / (double)rows));
    for (int j = 0; j < n; j++) s->range[j] = fmax(s->range[j], 1e-6);
}

mukca_status mukca_signals_make(mukca_signals *out, mukca_pool *pool, const mukca_motion_input *in,
                                mukca_error *error)
{
    const double cutoff = MUKCA_MOTION_CUTOFF;
    int most = 0;
    double clock = 0, end = -HUGE_VAL;
    maker m = {.out = out, .pool = pool, .n_joints = in->chain->n_joints};
    *out = (mukca_signals){.n_joints = in->chain->n_joints};
    m.raw = median_step(in, pool);
    if (!(m.raw > 0) || 1 / m.raw < 2.5 * cutoff)
        return mukca_fail(
            error, MUKCA_UNIDENTIFIABLE,
            "the runs have %.3g samples per second; friction and inertia need %.0f or "
            "more, record the joint states faster",
            m.raw > 0 ? 1 / m.raw : 0, 2.5 * cutoff);
    m.step = (int)fmax(floor(1 / (m.raw * OVERSAMPLED * cutoff)), 1);
    out->dt = m.step * m.raw;
    mukca_lowpass_set(&m.angle, 3, MUKCA_ANGLE_CUTOFF * cutoff, 1 / m.raw);
    mukca_lowpass_set(&m.torque, 3, 0.4 / out->dt, 1 / m.raw);
    for (int r = 0; r < in->n_runs; r++)
        for (int i = 1; i < in->run[r].n; i++)
            most += in->run[r].time[i] - in->run[r].time[i - 1] > GAP * m.raw;
    out->stretch = MUKCA_TAKE(pool, mukca_stretch, most + in->n_runs + 1);
    for (int r = 0; r < in->n_runs && !pool->failed; r++) {
        const mukca_run *run = &in->run[r];
        if (run->n < 2) continue;
        /* clocks that go on are those of the drift; others start anew behind the last run */
        const double start = run->time[0] > end && r ? clock + run->time[0] - end : clock;
        const int gaps = add_run(&m, run, r ? start : 0);
        if (gaps)
            mukca_note_format(in->notes, "%s: cut at %d gap%s in time_s", run->name, gaps,
                              gaps > 1 ? "s" : "");
        end = run->time[run->n - 1];
        clock = (r ? start : 0) + end - run->time[0];
    }
    if (pool->failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the signals");
    if (!out->n)
        return mukca_fail(error, MUKCA_UNIDENTIFIABLE,
                          "no joint moves faster than %.2g rad/s for %.0f s in the runs; record "
                          "motions of all joints, for example with mukca simulate --motion as a "
                          "pattern",
                          MUKCA_LEAST_MOTION, SHORTEST);
    survey(out);
    return MUKCA_OK;
}
