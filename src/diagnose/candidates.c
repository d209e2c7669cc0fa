/* The list of candidate causes for a recording. */
#include "diagnose/candidates.h"

#include <math.h>
#include <string.h>

/* Coefficient sizes per unit of displacement for the waves: rms of a sine. */
#define WAVE_UNIT 0.70710678118654752440

int gap_hypothesis_class(const gap_hypothesis *h)
{
    return h->kind == GAP_SPIKE                             ? GAP_CLASS_OUTLIER
           : h->kind == GAP_BUMPS || h->kind == GAP_STRETCH ? GAP_CLASS_UNKNOWN
                                                            : (int)h->effect.kind;
}

bool gap_hypothesis_by_mass(const gap_hypothesis *h)
{
    return h->kind == GAP_EFFECT &&
           h->terms > mukca_effect_terms(h->effect.kind, h->effect.variant);
}

static bool uses_masses(const gap_hypothesis *h)
{
    return h->kind == GAP_EFFECT && (h->effect.kind == MUKCA_EFFECT_JOINT_COMPLIANCE ||
                                     h->effect.kind == MUKCA_EFFECT_LINK_BENDING ||
                                     h->effect.kind == MUKCA_EFFECT_BASE_COMPLIANCE);
}

enum { CROSS_DEGREE = 3, CROSS_TERMS = (CROSS_DEGREE + 1) * (CROSS_DEGREE + 2) / 2 - 1 };

/* Products of Chebyshev polynomials T_a(x) T_b(y), 0 < a + b <= CROSS_DEGREE. */
static void products(float *out, double x, double y)
{
    double T[2][CROSS_DEGREE + 1] = {{1, x}, {1, y}};
    for (int k = 2; k <= CROSS_DEGREE; k++)
        for (int s = 0; s < 2; s++) T[s][k] = 2 * T[s][1] * T[s][k - 1] - T[s][k - 2];
    for (int a = 0, t = 0; a <= CROSS_DEGREE; a++)
        for (int b = 0; a + b <= CROSS_DEGREE; b++)
            if (a + b > 0) out[t++] = (float)(T[0][a] * T[1][b]);
}

/* Gaussian bumps of width `effect.variant` / 1000 rad on a grid over the driver's range; for a
 * driver that is another joint, Chebyshev polynomials of its angle of degree 1 .. 4 or, with
 * CROSS_TERMS terms, products of both joints' angles. */
static void fill_bumps(float *basis, gap_hypothesis *h, const gap_model *m)
{
    const int n_joints = m->chain->n_joints;
    const double lo = h->lo, hi = h->hi;
    const bool timed = h->driver == GAP_TIME, local = timed || h->driver == h->effect.joint;
    double low = HUGE_VAL, high = -HUGE_VAL; /* of the joint's own angle */
    for (int row = 0; !timed && row < m->data->n_rows; row++) {
        low = fmin(low, m->data->q[row * n_joints + h->effect.joint]);
        high = fmax(high, m->data->q[row * n_joints + h->effect.joint]);
    }
    const double width = timed ? (hi - lo) / (h->terms - 1) : 1e-3 * h->effect.variant;
    for (int row = 0; row < m->data->n_rows; row++) {
        const double q = timed ? m->time[row] : m->data->q[row * n_joints + h->driver];
        float *out = basis + row * h->terms;
        if (local) {
            for (int t = 0; t < h->terms; t++) {
                const double x = (q - lo - t * width) / width;
                out[t] = (float)(exp(-0.5 * x * x) / 1.33); /* neighbours add up to 1 or so */
            }
        } else if (h->terms == CROSS_TERMS) {
            const double own = m->data->q[row * n_joints + h->effect.joint];
            products(out, hi > lo ? (2 * q - lo - hi) / (hi - lo) : 0,
                     high > low ? (2 * own - low - high) / (high - low) : 0);
        } else {
            const double x = hi > lo ? (2 * q - lo - hi) / (hi - lo) : 0;
            double before = 1, now = x;
            for (int t = 0; t < h->terms; t++) {
                const double next = 2 * x * now - before;
                out[t] = (float)now;
                before = now, now = next;
            }
        }
    }
}

/* Basis of the three elastic effects: all masses together, then each mass alone. */
static void fill_elastic(float *basis, const gap_hypothesis *h, const gap_model *m)
{
    const int n_joints = m->chain->n_joints, j = h->effect.joint;
    const double *axis = j >= 0 ? m->chain->element[m->chain->joint_element[j]].axis : NULL;
    for (int row = 0; row < m->data->n_rows; row++) {
        float *out = basis + (size_t)row * (size_t)(h->terms * h->width);
        for (int t = 0; t < h->terms; t++) {
            mukca_joint_state state = gap_model_state(m, row);
            double term[MUKCA_MAX_TERMS][3];
            if (t > 0) {
                const size_t at = (size_t)row * (size_t)m->n_lumps + (size_t)(t - 1);
                state.torque = m->torque + at * (size_t)n_joints;
                state.moment = (const double(*)[3])(m->moment + 3 * at * (size_t)n_joints);
                state.base_moment = m->base_moment + 3 * at;
            }
            mukca_effect_basis(term, &h->effect, axis, &state);
            for (int i = 0; i < h->width; i++) out[t * h->width + i] = (float)term[0][i];
        }
    }
}

bool gap_hypothesis_prepare(gap_hypothesis *h, mukca_pool *pool, const gap_model *m)
{
    const int n_joints = m->chain->n_joints, rows = m->data->n_rows;
    const mukca_effect_site site =
        h->kind == GAP_BUMPS ? MUKCA_SITE_ANGLE : mukca_effect_table[h->effect.kind].site;
    for (int t = 0; t < GAP_MAX_TERMS; t++) h->unit[t] = 1;
    if (h->kind == GAP_STEP || h->kind == GAP_CREEP || h->kind == GAP_SPIKE) {
        h->terms = h->width = 3;
        return true;
    }
    if (h->kind == GAP_DISTANCE) {
        h->terms = h->width = 1;
        return true;
    }
    if (h->kind == GAP_STRETCH) h->terms = 3;
    h->width = h->kind == GAP_STRETCH || site == MUKCA_SITE_ANGLE ? 1
               : site == MUKCA_SITE_ANGLES                        ? n_joints
                                                                  : 3;
    if (h->kind == GAP_EFFECT) {
        h->effect.terms = mukca_effect_terms(h->effect.kind, h->effect.variant);
        h->terms = h->effect.terms;
        if (uses_masses(h) && m->options.mass_spread > 0 && m->n_lumps > 0)
            h->terms = 1 + m->n_lumps;
    }
    h->basis = MUKCA_TAKE(pool, float, (size_t)rows *(size_t)(h->terms * h->width));
    if (!h->basis) return false;
    if (h->kind == GAP_BUMPS && h->driver == GAP_TIME && h->terms == 1) {
        for (int row = 0; row < rows; row++) h->basis[row] = row >= h->row;
        return true;
    }
    if (h->kind == GAP_BUMPS) {
        fill_bumps(h->basis, h, m);
        return true;
    }
    if (h->kind == GAP_STRETCH) {
        for (int row = 0; row < rows; row++)
            h->basis[3 * row] = (float)(1 - exp(-(m->time[row] - h->lo) / h->effect.variant));
        return true;
    }
    if (uses_masses(h)) {
        fill_elastic(h->basis, h, m);
    } else {
        const int j = h->effect.joint;
        const double *axis = j >= 0 ? m->chain->element[m->chain->joint_element[j]].axis : NULL;
        for (int row = 0; row < rows; row++) {
            const mukca_joint_state state = gap_model_state(m, row);
            float *out = h->basis + (size_t)row * (size_t)(h->terms * h->width);
            double term[MUKCA_MAX_TERMS][3], direction[MUKCA_MAX_JOINTS];
            if (site == MUKCA_SITE_ANGLES) {
                mukca_effect_lag_direction(direction, n_joints, h->effect.variant, &state);
                for (int i = 0; i < n_joints; i++) out[i] = (float)direction[i];
                continue;
            }
            mukca_effect_basis(term, &h->effect, axis, &state);
            for (int t = 0; t < h->terms; t++)
                for (int i = 0; i < h->width; i++) out[t * h->width + i] = (float)term[t][i];
        }
    }
    /* Unit: rms about the mean of what one unit of coefficient turns the joint by. */
    if (site == MUKCA_SITE_TIP) return true;
    const bool wave = h->effect.kind == MUKCA_EFFECT_ENCODER_ECCENTRICITY ||
                      h->effect.kind == MUKCA_EFFECT_GEAR_HARMONIC ||
                      h->effect.kind == MUKCA_EFFECT_AXIS_WOBBLE;
    for (int t = 0; t < h->terms; t++) {
        double square = 0, whole = 0;
        int used = 0;
        for (int i = 0; i < h->width; i++) {
            double sum = 0, sum2 = 0;
            used = 0;
            for (int row = 0; row < rows; row++) {
                if (!m->keep[row]) continue;
                const double x = (double)h->basis[(size_t)row * (size_t)(h->terms * h->width) +
                                                  (size_t)(t * h->width + i)];
                sum += x, sum2 += x * x, used++;
            }
            if (used) square += sum2 / used - (sum / used) * (sum / used), whole += sum2 / used;
        }
        if (site == MUKCA_SITE_ANGLES) square /= n_joints;
        /* what hardly varies is rounding about a constant */
        square = fmax(square, fmax(1e-18, 1e-8 * whole));
        h->unit[t] = wave ? WAVE_UNIT : sqrt(square);
        if (uses_masses(h) && t > 0) h->unit[t] = h->unit[0] / m->options.mass_spread;
    }
    return true;
}

enum {
    LONGEST_BURST = 3, /* rows that a badly seated ball may stay so */
    TIME_BUMPS = 10,   /* over the whole recording */
    MOST_SLIPS = 200   /* rows at which a joint is tried for a slip */
};

typedef struct {
    gap_hypotheses *all;
    mukca_pool *pool;
    const gap_model *m;
    const unsigned char *disabled;
    bool ok;
} lister;

static gap_hypothesis *append(lister *l, gap_hypothesis h)
{
    gap_hypotheses *all = l->all;
    const int class = gap_hypothesis_class(&h);
    if (!l->ok || (class < MUKCA_EFFECT_COUNT && l->disabled && l->disabled[class])) return NULL;
    if (all->count == all->capacity) {
        const int capacity = all->capacity ? 2 * all->capacity : 512;
        gap_hypothesis *bigger = MUKCA_TAKE(l->pool, gap_hypothesis, capacity);
        if (!bigger) {
            l->ok = false;
            return NULL;
        }
        if (all->count) memcpy(bigger, all->list, sizeof *bigger * (size_t)all->count);
        all->list = bigger;
        all->capacity = capacity;
    }
    l->ok = gap_hypothesis_prepare(&h, l->pool, l->m);
    all->list[all->count] = h;
    return &all->list[all->count++];
}

static void append_effect(lister *l, mukca_effect_kind kind, int joint, int variant, int placement)
{
    append(l, (gap_hypothesis){
                  .kind = GAP_EFFECT,
                  .effect = {
                      .kind = kind, .joint = joint, .variant = variant, .placement = placement}});
}

static void append_bumps(lister *l, int joint, int driver, int width, const double (*span)[2])
{
    const double *of = span[driver == GAP_TIME ? l->m->chain->n_joints : driver];
    const double lo = of[0], hi = of[1], range = hi - lo;
    int terms = 4;
    if (driver == GAP_TIME) {
        terms = TIME_BUMPS;
    } else if (joint == driver) {
        if (1e-3 * width > 0.6 * range) return;
        terms = (int)ceil(range / (1e-3 * width)) + 1;
        if (terms > GAP_MAX_TERMS) return;
    } else if (width) {
        terms = CROSS_TERMS;
    }
    append(l, (gap_hypothesis){.kind = GAP_BUMPS,
                               .effect = {.joint = joint, .variant = width, .placement = -1},
                               .driver = driver,
                               .lo = lo,
                               .hi = hi,
                               .terms = terms});
}

/* Largest and smallest value, and largest magnitude below which gravity's side changes. */
static void range_of(double *lo, double *hi, double *least, const double *x, int n, int stride)
{
    *lo = HUGE_VAL, *hi = -HUGE_VAL, *least = HUGE_VAL;
    for (int i = 0; i < n; i++) {
        *lo = fmin(*lo, x[i * stride]), *hi = fmax(*hi, x[i * stride]);
        *least = fmin(*least, fabs(x[i * stride]));
    }
}

static void list_joint(lister *l, int j, const double (*span)[2], bool moved)
{
    static const int time_constants[] = {0, 300, 1000, 3000};
    static const int torque_scales[] = {300, 1000, 3000};
    static const int wobbles[] = {1, 2, 11, 12, 98, 99, 102, 103};
    static const int widths[] = {120, 250, 500, 1000};
    const gap_model *m = l->m;
    const int n_joints = m->chain->n_joints, rows = m->data->n_rows;
    const bool turns = m->chain->element[m->chain->joint_element[j]].type != MUKCA_PRISMATIC;
    double lo, hi, least;
    if (m->have_torques) {
        range_of(&lo, &hi, &least, m->total_torque + j, rows, n_joints);
        const double most = fmax(fabs(lo), fabs(hi));
        if (most > 0.05 && hi - lo > 0.01) {
            append_effect(l, MUKCA_EFFECT_JOINT_COMPLIANCE, j, 0, -1);
            if ((lo < 0 && hi > 0) || least < 0.3 * most)
                for (int i = 0; i < 3; i++)
                    append_effect(l, MUKCA_EFFECT_BACKLASH, j, torque_scales[i], -1);
        }
    }
    if (m->have_moments && turns) append_effect(l, MUKCA_EFFECT_LINK_BENDING, j, 0, -1);
    for (int i = 0; i < 4; i++)
        append_effect(l, MUKCA_EFFECT_JOINT_DRIFT, j, time_constants[i], -1);
    for (int p = 0; m->data->n_placements > 1 && p < m->data->n_placements; p++)
        append_effect(l, MUKCA_EFFECT_ZERO_JUMP, j, 0, p);
    for (int side = -1; side <= 1; side += 2)
        if (j + side >= 0 && j + side < n_joints && span[j + side][1] - span[j + side][0] > 1e-3)
            append_effect(l, MUKCA_EFFECT_JOINT_COUPLING, j, side, -1);
    for (int i = 0; i < n_joints; i++)
        for (int both = 0; both < 2; both++)
            if (i != j && span[i][1] - span[i][0] > 0.1) append_bumps(l, j, i, both, span);
    append_bumps(l, j, GAP_TIME, 0, span);
    /* The joint slips once, at a row.  A slip of the first joint, or in the last socket, moves one
     * socket and nothing else that is seen: that is a moved tool. */
    const int stride = rows / MOST_SLIPS + 1;
    int end = rows - LONGEST_BURST;
    while (end > 0 && m->data->socket[end - 1] >= 0 &&
           m->data->socket[end - 1] == m->data->socket[rows - 1])
        end--;
    for (int i = LONGEST_BURST; i < end && m->slot_element[0] <= m->chain->joint_element[j];
         i += stride)
        append(l, (gap_hypothesis){.kind = GAP_BUMPS,
                                   .effect = {.joint = j, .placement = -1},
                                   .driver = GAP_TIME,
                                   .row = i,
                                   .terms = 1});
    for (int k = 0; k < m->n_slots; k++)
        for (int i = 1; i < 4 && m->slot_element[k] == m->chain->joint_element[j]; i++)
            append(l, (gap_hypothesis){
                          .kind = GAP_STRETCH,
                          .effect = {.joint = j, .variant = time_constants[i], .placement = -1},
                          .driver = GAP_TIME,
                          .lo = span[n_joints][0],
                          .group = k});
    const double range = span[j][1] - span[j][0];
    if (range < 1e-3) return;
    if (moved) append_effect(l, MUKCA_EFFECT_APPROACH_HYSTERESIS, j, 0, -1);
    append_effect(l, MUKCA_EFFECT_JOINT_SCALE, j, 0, -1);
    for (int i = 0; turns && i < 4 && range > 0.1; i++) append_bumps(l, j, j, widths[i], span);
    if (!turns) return;
    append_effect(l, MUKCA_EFFECT_ENCODER_ECCENTRICITY, j, 0, -1);
    for (size_t i = 0; i < sizeof wobbles / sizeof *wobbles; i++)
        append_effect(l, MUKCA_EFFECT_AXIS_WOBBLE, j, wobbles[i], -1);
}

static void list_faults(lister *l)
{
    const gap_model *m = l->m;
    for (int g = 0; g < m->n_groups; g++) {
        const gap_group *group = &m->groups[g];
        for (int i = 0; i < group->count; i++) {
            const int row = m->order[group->start + i];
            gap_hypothesis h = {.group = g, .row = row, .effect = {.joint = -1, .placement = -1}};
            h.effect.kind = MUKCA_EFFECT_TOOL_MOTION;
            h.effect.placement = group->placement;
            h.kind = GAP_SPIKE;
            h.last = row;
            append(l, h);
            /* A few rows at either end: a move there cannot be told from a badly seated ball. */
            for (int n = 1; n < LONGEST_BURST && i + n < group->count; n++) {
                if (i != 0 && i + n != group->count - 1) continue;
                h.last = m->order[group->start + i + n];
                append(l, h);
            }
            if (group->socket < 0 || i < LONGEST_BURST || i > group->count - LONGEST_BURST - 1)
                continue;
            h.kind = GAP_STEP;
            append(l, h);
        }
        if (group->socket >= 0 && group->count >= 6) {
            gap_hypothesis h = {
                .kind = GAP_CREEP,
                .group = g,
                .row = m->order[group->start],
                .effect = {
                    .kind = MUKCA_EFFECT_TOOL_MOTION, .joint = -1, .placement = group->placement}};
            append(l, h);
        }
    }
}

/* Prior odds: equal per class, then per joint, then per variant; a quarter of tool motions creep,
 * half of the outliers are bursts, half of the unknown functions have another argument than the
 * joint's own angle alone. */
static void set_priors(gap_hypotheses *all)
{
    int variants[GAP_CLASSES][MUKCA_MAX_JOINTS + 1] = {{0}}, crossed[MUKCA_MAX_JOINTS + 1] = {0};
    int joints[GAP_CLASSES] = {0}, kinds[GAP_STRETCH + 1] = {0}, single = 0;
    for (int i = 0; i < all->count; i++) {
        const gap_hypothesis *h = &all->list[i];
        const int class = gap_hypothesis_class(h), slot = h->effect.joint + 1;
        const bool cross = class == GAP_CLASS_UNKNOWN && h->driver != h->effect.joint;
        single += h->kind == GAP_SPIKE && h->last == h->row;
        all->enabled[class] = true;
        kinds[h->kind]++;
        if (!variants[class][slot] && !(class == GAP_CLASS_UNKNOWN && crossed[slot]))
            joints[class]++;
        if (cross)
            crossed[slot]++;
        else
            variants[class][slot]++;
    }
    all->classes = all->harmonics;
    for (int c = 0; c < GAP_CLASSES; c++) all->classes += all->enabled[c];
    for (int i = 0; i < all->count; i++) {
        gap_hypothesis *h = &all->list[i];
        const int class = gap_hypothesis_class(h), slot = h->effect.joint + 1;
        double share = 1.0 / joints[class]; /* of the class */
        if (h->kind == GAP_STEP || h->kind == GAP_CREEP || h->kind == GAP_SPIKE) {
            share = 1.0 / kinds[h->kind];
            if (h->kind == GAP_SPIKE)
                share = 0.5 / (h->last == h->row ? single : kinds[GAP_SPIKE] - single);
            else if (kinds[GAP_CREEP])
                share *= h->kind == GAP_CREEP ? 0.25 : 0.75;
        } else if (class == GAP_CLASS_UNKNOWN && crossed[slot] && variants[class][slot]) {
            share *= 0.5 / (h->driver == h->effect.joint ? variants[class][slot] : crossed[slot]);
        } else {
            share /= variants[class][slot] + (class == GAP_CLASS_UNKNOWN ? crossed[slot] : 0);
        }
        h->log_prior = log(share / all->classes);
    }
}

mukca_status gap_hypotheses_list(gap_hypotheses *all, mukca_pool *pool, const gap_model *m,
                                 const unsigned char *disabled, mukca_error *error)
{
    lister l = {all, pool, m, disabled, true};
    const int n_joints = m->chain->n_joints, rows = m->data->n_rows;
    double span[MUKCA_MAX_JOINTS + 1][2] = {{0}}, lo, hi, least;
    bool moved = false, commanded = false;
    memset(all, 0, sizeof *all);
    for (int j = 0; j < n_joints; j++) {
        if (rows) range_of(&span[j][0], &span[j][1], &least, m->data->q + j, rows, n_joints);
        range_of(&lo, &hi, &least, m->move + j, rows, n_joints);
        moved |= hi - lo > 1e-6;
    }
    if (rows) range_of(&span[n_joints][0], &span[n_joints][1], &least, m->time, rows, 1);
    for (int i = 0; m->data->command && i < rows * n_joints; i++)
        commanded |= fabs(m->data->command[i] - m->data->q[i]) > 1e-7;
    for (int j = 0; j < n_joints; j++) list_joint(&l, j, (const double(*)[2])span, moved);
    if (m->have_moments) append_effect(&l, MUKCA_EFFECT_BASE_COMPLIANCE, -1, 0, -1);
    if (moved) append_effect(&l, MUKCA_EFFECT_READBACK_LAG, -1, 0, -1);
    if (commanded) append_effect(&l, MUKCA_EFFECT_READBACK_LAG, -1, 1, -1);
    for (int p = 0; m->data->n_placements > 1 && p < m->data->n_placements; p++)
        append_effect(&l, MUKCA_EFFECT_BALL_SHIFT, -1, 0, p);
    for (int p = -1; m->n_pairs > 1 && p < m->data->n_placements; p++) /* in all, or in one */
        append(&l,
               (gap_hypothesis){
                   .kind = GAP_DISTANCE,
                   .effect = {.kind = MUKCA_EFFECT_SOCKET_DISTANCE, .joint = -1, .placement = p}});
    list_faults(&l);
    if (!l.ok)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for the candidates of %d rows", rows);
    all->harmonics = !(disabled && disabled[MUKCA_EFFECT_GEAR_HARMONIC]);
    set_priors(all);
    int sockets = 0;
    for (int g = 0; g < m->n_groups; g++) sockets += m->groups[g].socket >= 0;
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) {
        const int needs = mukca_effect_table[kind].needs;
        if (all->enabled[kind] || kind == MUKCA_EFFECT_GEAR_HARMONIC) continue;
        all->missing[kind] =
            disabled && disabled[kind]     ? "left out on request"
            : (needs & MUKCA_NEEDS_MASSES) ? "no masses: give --inertials FILE"
            : (needs & MUKCA_NEEDS_PLACEMENTS)
                ? (sockets ? "one placement only: record a second one"
                           : "a log of poses has no placements")
            : !(needs & MUKCA_NEEDS_SOCKETS)
                ? (needs & MUKCA_NEEDS_ORDER ? "no moves between rows" : "no joint moved enough")
            : !sockets ? "a log of poses has no sockets"
            : kind == MUKCA_EFFECT_TOOL_MOTION
                ? "too few rows in each socket: record 20 or more"
                : "needs two pairs of sockets a known distance apart: record another placement";
    }
    return MUKCA_OK;
}
