/* Collection of the summaries of arms of one model. */
#include "fleet/fleet.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "math/dense.h"

/* Is the information positive definite, up to a prior of the softest gears? */
static bool is_possible(const mukca_summary *s, int terms)
{
    const double softest = 1e-3; /* rad/(N m) */
    double A[MUKCA_FLEET_TERMS * MUKCA_FLEET_TERMS];
    for (int i = 0; i < terms; i++) {
        for (int j = 0; j <= i; j++)
            A[i * terms + j] = s->information[mukca_fleet_packed(i) + j] * softest * softest;
        if (!(A[i * terms + i] >= 0) || !isfinite(s->vector[i])) return false;
        A[i * terms + i] = A[i * terms + i] * (1 + 1e-9) + 1; /* rounding in the file */
    }
    return mukca_dense_cholesky(A, terms) == 0;
}

static bool grow(mukca_fleet *f)
{
    if (f->n_sessions < f->capacity) return true;
    const int capacity = f->capacity ? 2 * f->capacity : 64;
    mukca_fleet_session *bigger = MUKCA_TAKE(&f->pool, mukca_fleet_session, capacity);
    if (!bigger) return false;
    if (f->n_sessions) memcpy(bigger, f->session, sizeof *bigger * (size_t)f->n_sessions);
    f->session = bigger;
    f->capacity = capacity;
    return true;
}

mukca_status mukca_fleet_take(mukca_fleet *f, const mukca_summary *s, const char *path,
                              mukca_error *error)
{
    if (f->n_sessions == 0) {
        f->model = s->model;
        f->n_terms = mukca_fleet_terms(s->model.n_joints);
    }
    const int terms = f->n_terms, packed = mukca_fleet_packed(terms);
    const size_t orders = (size_t)f->model.n_joints * MUKCA_FLEET_ORDERS, length = strlen(s->arm);
    const char *differs = mukca_fleet_model_differs(&f->model, &s->model);
    if (differs)
        return mukca_fail(error, MUKCA_INPUT,
                          "%s: of another model than %s: %s; pool arms of one model only", path,
                          f->session[0].path, differs);
    if (!is_possible(s, terms))
        return mukca_fail(
            error, MUKCA_INPUT,
            "%s: the information is not positive semidefinite; write the summary again", path);
    /* one block per session: numbers, ripple, name */
    double *numbers = mukca_pool_take(
        &f->pool, 1,
        sizeof(double) * (size_t)(packed + terms) + orders * sizeof(int16_t) + length + 1);
    if (!numbers || !grow(f)) return mukca_fail(error, MUKCA_MEMORY, "out of memory for %s", path);
    void *behind = numbers + packed + terms;
    int16_t *ripple = behind;
    char *arm = (char *)(ripple + orders);
    memcpy(numbers, s->information, sizeof *numbers * (size_t)packed);
    memcpy(numbers + packed, s->vector, sizeof *numbers * (size_t)terms);
    memcpy(ripple, s->ripple, orders * sizeof *ripple);
    memcpy(arm, s->arm, length + 1);
    f->session[f->n_sessions++] = (mukca_fleet_session){.data = s->data,
                                                        .arm = arm,
                                                        .path = path,
                                                        .samples = s->samples,
                                                        .sigma_m = s->sigma_m,
                                                        .information = numbers,
                                                        .vector = numbers + packed,
                                                        .ripple = ripple};
    return MUKCA_OK;
}

void mukca_fleet_give(mukca_summary *s, const mukca_fleet *f, int session)
{
    const mukca_fleet_session *from = &f->session[session];
    memset(s, 0, sizeof *s);
    s->model = f->model;
    memcpy(s->arm, from->arm, strlen(from->arm));
    s->data = from->data, s->samples = from->samples, s->sigma_m = from->sigma_m;
    memcpy(s->information, from->information,
           sizeof *s->information * (size_t)mukca_fleet_packed(f->n_terms));
    memcpy(s->vector, from->vector, sizeof *s->vector * (size_t)f->n_terms);
    memcpy(s->ripple, from->ripple, sizeof *s->ripple * (size_t)f->model.n_joints);
}

static int by_data(const void *a, const void *b)
{
    const mukca_fleet_session *x = a, *y = b;
    return (x->data > y->data) - (x->data < y->data);
}

static int by_arm(const void *a, const void *b)
{
    const mukca_fleet_session *x = a, *y = b;
    const int order = strcmp(x->arm, y->arm);
    return order ? order : by_data(a, b);
}

/* Sum the sessions [first, end). */
static bool sum(mukca_fleet_arm *arm, mukca_fleet *f, int first, int end)
{
    const mukca_fleet_session *s = f->session;
    const int packed = mukca_fleet_packed(f->n_terms), size = packed + f->n_terms;
    double *numbers = s[first].information;
    *arm = (mukca_fleet_arm){.name = s[first].arm, .first = first, .end = end};
    if (end > first + 1) {
        numbers = MUKCA_TAKE(&f->pool, double, size);
        if (!numbers) return false;
        for (int k = first; k < end; k++)
            for (int i = 0; i < size; i++) numbers[i] += s[k].information[i];
    }
    for (int k = first; k < end; k++) arm->samples += s[k].samples;
    arm->information = numbers, arm->vector = numbers + packed;
    return true;
}

double mukca_fleet_ripple(const mukca_fleet *f, int arm, int joint, int order)
{
    int quanta = 0;
    for (int s = f->arm[arm].first; s < f->arm[arm].end; s++)
        quanta += f->session[s].ripple[joint * MUKCA_FLEET_ORDERS + order - 2];
    return quanta * MUKCA_FLEET_QUANTUM;
}

mukca_status mukca_fleet_gather(mukca_fleet *f, mukca_error *error)
{
    const size_t n = (size_t)f->n_sessions;
    qsort(f->session, n, sizeof *f->session, by_data);
    for (int s = 1; s < f->n_sessions; s++)
        if (f->session[s].data == f->session[s - 1].data)
            return mukca_fail(error, MUKCA_INPUT,
                              "%s: the same recording as %s (arms '%s' and '%s'); give it once",
                              f->session[s].path, f->session[s - 1].path, f->session[s].arm,
                              f->session[s - 1].arm);
    qsort(f->session, n, sizeof *f->session, by_arm);
    f->n_arms = 0;
    f->arm = MUKCA_TAKE(&f->pool, mukca_fleet_arm, n + 1);
    for (int s = 0, end; s < f->n_sessions && f->arm; s = end) {
        for (end = s + 1; end < f->n_sessions; end++)
            if (strcmp(f->session[end].arm, f->session[s].arm) != 0) break;
        if (!sum(&f->arm[f->n_arms++], f, s, end)) break;
    }
    if (f->pool.failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d arms", f->n_arms);
    return MUKCA_OK;
}

void mukca_fleet_free(mukca_fleet *f)
{
    mukca_pool_free(&f->pool);
    memset(f, 0, sizeof *f);
}
