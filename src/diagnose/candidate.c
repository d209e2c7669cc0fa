/* A candidate cause: its class, and its forward model on the samples of a recording. */
#include "diagnose/candidate.h"

#include <math.h>

/* Factor from sample to sample of the displacement of a badly seated ball that settles: the largest
 * correlation of successive samples in recordings. */
#define SETTLING 0.75

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

mukca_candidate mukca_candidate_of(const mukca_effect *effect)
{
    return (mukca_candidate){.kind = MUKCA_CANDIDATE_EFFECT,
                             .joint = effect->joint,
                             .placement = effect->placement,
                             .effect = *effect};
}

int mukca_candidate_class(const mukca_candidate *h)
{
    return h->kind == MUKCA_CANDIDATE_EFFECT    ? (int)h->effect.kind
           : h->kind == MUKCA_CANDIDATE_MOTION  ? (int)mukca_effect_at(MUKCA_SITE_SOCKET, 0)
           : h->kind == MUKCA_CANDIDATE_OUTLIER ? (int)MUKCA_CLASS_OUTLIER
                                                : (int)MUKCA_CLASS_UNKNOWN;
}

bool mukca_candidate_is_fault(const mukca_candidate *h)
{
    return h->kind == MUKCA_CANDIDATE_MOTION || h->kind == MUKCA_CANDIDATE_OUTLIER;
}

mukca_effect mukca_candidate_effect(const mukca_candidate *h)
{
    if (h->kind == MUKCA_CANDIDATE_EFFECT) return h->effect;
    return (mukca_effect){.kind = (mukca_effect_kind)mukca_candidate_class(h),
                          .joint = h->joint,
                          .placement = h->placement,
                          .terms = h->terms};
}

int mukca_candidate_site(const mukca_candidate *h)
{
    return h->kind == MUKCA_CANDIDATE_EFFECT     ? (int)mukca_effect_table[h->effect.kind]->site
           : h->kind == MUKCA_CANDIDATE_UNLISTED ? mukca_unlisted_site(h)
                                                 : (int)MUKCA_SITE_SOCKET;
}

bool mukca_candidate_moves_arm(const mukca_candidate *h)
{
    return mukca_candidate_site(h) <= MUKCA_SITE_TIP;
}

int mukca_candidate_own_terms(const mukca_candidate *h)
{
    return h->kind == MUKCA_CANDIDATE_EFFECT ? mukca_effect_terms(&h->effect) : h->terms;
}

bool mukca_candidate_is_flexible(const mukca_candidate *h)
{
    return h->kind == MUKCA_CANDIDATE_UNLISTED
               ? mukca_unlisted_functions[h->unlisted.function].shape == MUKCA_SHAPE_SPRING
               : mukca_effect_has(mukca_candidate_class(h), MUKCA_TRAIT_ELASTIC);
}

bool mukca_candidate_by_mass(const mukca_candidate *h)
{
    return h->terms > mukca_candidate_own_terms(h);
}

bool mukca_candidate_same(const mukca_candidate *a, const mukca_candidate *b)
{
    if (a->kind != b->kind || a->joint != b->joint || a->placement != b->placement) return false;
    if (mukca_candidate_is_fault(a))
        return a->fault.group == b->fault.group && a->fault.first == b->fault.first &&
               a->fault.last == b->fault.last && a->fault.shape == b->fault.shape;
    if (mukca_candidate_site(a) == MUKCA_SITE_SEAT && a->unlisted.argument != b->unlisted.argument)
        return false;
    if (a->kind == MUKCA_CANDIDATE_UNLISTED &&
        (a->unlisted.place != b->unlisted.place || a->unlisted.slot != b->unlisted.slot))
        return false;
    return a->basis == b->basis; /* of one list */
}

double mukca_candidate_fault_share(const mukca_candidate *h, const mukca_recording *recording,
                                   int row)
{
    const int first = h->fault.first, last = h->fault.last;
    if (recording->data->socket[row] != recording->groups[h->fault.group].socket) return 0;
    if (row < first) return 0;
    if (h->fault.shape == MUKCA_FAULT_GROWING)
        return row < last ? (double)(row - first) / (last - first) : 1;
    if (row > last) return 0;
    return h->fault.shape == MUKCA_FAULT_FADING ? pow(SETTLING, row - first) : 1;
}

bool mukca_candidate_changes_pair(const mukca_candidate *h, const mukca_recording *recording,
                                  int pair)
{
    return mukca_candidate_site(h) == MUKCA_SITE_DISTANCE &&
           (h->placement < 0 ||
            recording->groups[recording->pairs[pair].a].placement == h->placement);
}

static bool is_elastic(const mukca_candidate *h)
{
    return h->kind == MUKCA_CANDIDATE_EFFECT &&
           mukca_effect_has((int)h->effect.kind, MUKCA_TRAIT_ELASTIC);
}

mukca_mixture mukca_candidate_mixture(const mukca_candidate *h)
{
    /* Rms of an unknown function of a joint, rad: arms often show 0.1 mrad, hardly ever 10. */
    static const double unknown[] = {0.1e-3, 0.3e-3, 1e-3, 3e-3, 10e-3};
    static const double frequency[] = {1, 0.5, 0.2, 0.1, 0.03};
    mukca_mixture prior = {.nonnegative = h->kind == MUKCA_CANDIDATE_EFFECT &&
                                          mukca_effect_table[h->effect.kind]->nonnegative};
    const int class = mukca_candidate_class(h);
    double total = 0;
    int n = 0;
    const bool spring = class == MUKCA_CLASS_UNKNOWN && mukca_candidate_is_flexible(h);
    if (class == MUKCA_CLASS_UNKNOWN && !spring) {
        for (; n < COUNT(unknown); n++) {
            prior.size[n] = unknown[n];
            total += prior.log_weight[n] = frequency[n];
        }
    } else {
        const mukca_effect_sizes *sizes = spring ? &mukca_sizes_spring
                                          : class < MUKCA_EFFECT_COUNT
                                              ? mukca_effect_catalogue[class]->sizes
                                              : &mukca_sizes_socket;
        if (!sizes) sizes = &mukca_sizes_angle;
        const double unit =
            mukca_candidate_site(h) == MUKCA_SITE_ANGLES ? 1 : h->unit[0]; /* see sizes */
        for (int i = 0; i < MUKCA_MAX_SIZES && sizes->sigma[i] > 0; i++) {
            const bool rare = i >= sizes->usual;
            if (rare && sizes->most > 0 && sizes->sigma[i] * unit > sizes->most) break;
            prior.size[n] = sizes->sigma[i] * unit;
            total += prior.log_weight[n++] = rare ? MUKCA_RARE_SIZE : 1;
        }
    }
    for (int i = 0; i < n; i++) prior.log_weight[i] = log(prior.log_weight[i] / total);
    prior.n_sizes = n;
    return prior;
}

/* Basis of an effect; additional terms of an elastic effect: under the load of each single body. */
static void fill_effect(const mukca_candidate *h, const mukca_recording *recording)
{
    const int n_joints = recording->chain->n_joints, width = h->width_of_term;
    const bool elastic = is_elastic(h);
    const double *axis =
        h->joint >= 0 ? recording->chain->element[recording->chain->joint_element[h->joint]].axis
                      : NULL;
    for (int row = 0; row < recording->data->n_rows; row++) {
        mukca_joint_state state = mukca_recording_state(recording, row);
        float *out = h->basis + (size_t)row * (size_t)(h->terms * width);
        double term[MUKCA_MAX_TERMS][3], direction[MUKCA_MAX_JOINTS];
        if (mukca_effect_table[h->effect.kind]->site == MUKCA_SITE_ANGLES) {
            mukca_effect_direction(direction, n_joints, &h->effect, &state);
            for (int i = 0; i < n_joints; i++) out[i] = (float)direction[i];
            continue;
        }
        mukca_effect_basis(term, &h->effect, axis, &state);
        for (int t = 0; t < h->terms; t++) {
            if (elastic && t > 0) {
                const size_t at = (size_t)row * (size_t)recording->n_bodies + (size_t)(t - 1);
                state.torque = recording->torque + at * (size_t)n_joints;
                state.moment = (const double(*)[3])(recording->moment + 3 * at * (size_t)n_joints);
                state.base_moment = recording->base_moment + 3 * at;
                mukca_effect_basis(term, &h->effect, axis, &state);
            }
            for (int i = 0; i < width; i++) out[t * width + i] = (float)term[elastic ? 0 : t][i];
        }
    }
}

/* Unit of each term: rms, about the mean, of the joint's rotation per unit of coefficient. */
static void set_units(double *unit, const mukca_candidate *h, const mukca_recording *recording)
{
    const int width = h->width_of_term, site = mukca_candidate_site(h);
    const size_t step = (size_t)h->terms * (size_t)width;
    const bool wave = mukca_effect_has(mukca_candidate_class(h), MUKCA_TRAIT_PERIODIC);
    for (int t = 0; t < h->terms && site != MUKCA_SITE_TIP; t++) {
        double square = 0, whole = 0;
        for (int i = 0; i < width; i++) {
            double sum = 0, sum2 = 0;
            int used = 0;
            for (int row = 0; row < recording->data->n_rows; row++) {
                if (!recording->keep[row]) continue;
                const double x = (double)h->basis[(size_t)row * step + (size_t)(t * width + i)];
                sum += x, sum2 += x * x, used++;
            }
            if (used) square += sum2 / used - (sum / used) * (sum / used), whole += sum2 / used;
        }
        if (site == MUKCA_SITE_ANGLES) square /= width;
        /* a smaller variation is rounding about a constant */
        square = fmax(square, fmax(1e-18, 1e-8 * whole));
        unit[t] = wave ? MUKCA_WAVE_UNIT : sqrt(square);
        if (is_elastic(h) && t > 0)
            unit[t] = unit[0] / mukca_recording_mass_spread(recording, t - 1);
    }
    /* components of one argument have one size: one that hardly varies is noise */
    for (int t = 0; t < h->terms && h->kind == MUKCA_CANDIDATE_UNLISTED; t++)
        unit[0] = fmax(unit[0], unit[t]);
    for (int t = 1; t < h->terms && h->kind == MUKCA_CANDIDATE_UNLISTED; t++) unit[t] = unit[0];
}

/* Number of terms of a candidate, and components of a term. */
static void set_shape(mukca_candidate *h, const mukca_recording *recording)
{
    const int site = mukca_candidate_site(h);
    h->terms = h->width_of_term = 3; /* of faults */
    if (h->kind == MUKCA_CANDIDATE_UNLISTED) mukca_unlisted_set_shape(h, recording);
    if (h->kind != MUKCA_CANDIDATE_EFFECT) return;
    h->width_of_term = site == MUKCA_SITE_ANGLE || site == MUKCA_SITE_DISTANCE ? 1
                       : site == MUKCA_SITE_ANGLES ? recording->chain->n_joints
                                                   : 3;
    h->terms = h->effect.terms = mukca_effect_terms(&h->effect);
    if (is_elastic(h) && !h->as_one && recording->options.mass_spread > 0)
        h->terms = 1 + recording->n_bodies;
}

/* The last cause of a list with the same function of the same argument, at another frame. */
static const mukca_candidate *find_same(const mukca_candidate *h, const mukca_candidate *list,
                                        int n)
{
    if (mukca_candidate_site(h) != MUKCA_SITE_FRAME) return NULL;
    const bool own = mukca_unlisted_functions[h->unlisted.function].shape == MUKCA_SHAPE_PRODUCTS;
    while (n-- > 0) {
        const mukca_candidate *o = &list[n];
        if (o->kind != h->kind || o->unlisted.function != h->unlisted.function) break;
        if (mukca_candidate_site(o) == MUKCA_SITE_FRAME && o->terms == h->terms &&
            o->unlisted.argument == h->unlisted.argument &&
            o->unlisted.measure == h->unlisted.measure && o->placement == h->placement &&
            (o->joint == h->joint || !own))
            return o;
    }
    return NULL;
}

bool mukca_candidate_take(mukca_candidate *h, mukca_pool *pool, const mukca_recording *recording,
                          const mukca_candidate *list, int n)
{
    set_shape(h, recording);
    const bool moves = mukca_candidate_moves_arm(h) || mukca_candidate_site(h) == MUKCA_SITE_FRAME;
    const size_t rows = (size_t)recording->data->n_rows;
    const mukca_candidate *same = moves ? find_same(h, list, n) : NULL;
    h->shares_basis = same != NULL;
    h->unit = same ? same->unit : MUKCA_TAKE(pool, double, h->terms);
    h->basis = same ? same->basis : NULL;
    for (int t = 0; t < h->terms && h->unit && !same; t++) h->unit[t] = 1;
    if (moves && !same) /* three spare entries: it is read four at a time */
        h->basis = MUKCA_TAKE(pool, float, rows *(size_t)(h->terms * h->width_of_term) + 3);
    return h->unit && (h->basis || !moves);
}

void mukca_candidate_fill(const mukca_candidate *h, const mukca_recording *recording)
{
    if (!h->basis || h->shares_basis) return;
    if (h->kind == MUKCA_CANDIDATE_EFFECT)
        fill_effect(h, recording);
    else
        mukca_unlisted_fill(h, recording);
}

void mukca_candidate_compute(const mukca_candidate *h, const mukca_recording *recording)
{
    mukca_candidate_fill(h, recording);
    if (h->basis && !h->shares_basis &&
        (h->kind == MUKCA_CANDIDATE_EFFECT || !mukca_unlisted_is_normalised(h)))
        set_units(h->unit, h, recording);
}

bool mukca_candidate_prepare(mukca_candidate *h, mukca_pool *pool, const mukca_recording *recording)
{
    if (!mukca_candidate_take(h, pool, recording, NULL, 0)) return false;
    mukca_candidate_compute(h, recording);
    return true;
}
