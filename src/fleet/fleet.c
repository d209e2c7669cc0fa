/* Collection of the summaries of arms of one model. */
#include "fleet/fleet.h"

#include <math.h>
#include <stddef.h>
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
    f->capacity = f->capacity ? 2 * f->capacity : 64;
    mukca_summary **bigger = MUKCA_TAKE(&f->pool, mukca_summary *, f->capacity);
    for (int i = 0; bigger && i < f->n_sessions; i++) bigger[i] = f->session[i];
    f->session = bigger;
    return bigger != NULL;
}

mukca_status mukca_fleet_take(mukca_fleet *f, const mukca_summary *s, mukca_error *error)
{
    if (f->n_sessions == 0) {
        f->model = s->model;
        f->n_terms = mukca_fleet_terms(s->model.n_joints);
    }
    const size_t size =
        offsetof(mukca_summary, ripple) + (size_t)f->model.n_joints * sizeof *s->ripple;
    const char *differs = mukca_fleet_model_differs(&f->model, &s->model);
    if (differs)
        return mukca_fail(error, MUKCA_INPUT,
                          "%s: of another model than %s: %s; pool arms of one model only", s->path,
                          f->session[0]->path, differs);
    if (!is_possible(s, f->n_terms))
        return mukca_fail(
            error, MUKCA_INPUT,
            "%s: the information is not positive semidefinite; write the summary again", s->path);
    mukca_summary *copy = mukca_pool_take(&f->pool, 1, size);
    if (!copy || !grow(f)) return mukca_fail(error, MUKCA_MEMORY, "out of memory for %s", s->path);
    memcpy(copy, s, size);
    f->session[f->n_sessions++] = copy;
    return MUKCA_OK;
}

static int by_data(const void *a, const void *b)
{
    const mukca_summary *x = *(mukca_summary *const *)a, *y = *(mukca_summary *const *)b;
    return (x->data > y->data) - (x->data < y->data);
}

static int by_arm(const void *a, const void *b)
{
    const mukca_summary *x = *(mukca_summary *const *)a, *y = *(mukca_summary *const *)b;
    const int order = strcmp(x->arm, y->arm);
    return order ? order : by_data(a, b);
}

/* Sum the sessions from `first` on that have its name. */
static bool sum(mukca_fleet_arm *arm, mukca_fleet *f, int first)
{
    const int packed = mukca_fleet_packed(f->n_terms);
    *arm = (mukca_fleet_arm){.name = f->session[first]->arm,
                             .first = first,
                             .end = first,
                             .information = MUKCA_TAKE(&f->pool, double, packed),
                             .vector = MUKCA_TAKE(&f->pool, double, f->n_terms)};
    if (f->pool.failed) return false;
    for (; arm->end < f->n_sessions; arm->end++) {
        const mukca_summary *s = f->session[arm->end];
        if (strcmp(s->arm, arm->name) != 0) break;
        for (int i = 0; i < packed; i++) arm->information[i] += s->information[i];
        for (int i = 0; i < f->n_terms; i++) arm->vector[i] += s->vector[i];
        arm->samples += s->samples;
    }
    return true;
}

mukca_status mukca_fleet_gather(mukca_fleet *f, mukca_error *error)
{
    const size_t n = (size_t)f->n_sessions;
    qsort(f->session, n, sizeof(void *), by_data);
    for (int i = 1; i < f->n_sessions; i++) {
        const mukca_summary *s = f->session[i], *before = f->session[i - 1];
        if (s->data == before->data)
            return mukca_fail(error, MUKCA_INPUT,
                              "%s: the same recording as %s (arms '%s' and '%s'); give it once",
                              s->path, before->path, s->arm, before->arm);
    }
    qsort(f->session, n, sizeof(void *), by_arm);
    f->n_arms = 0;
    f->arm = MUKCA_TAKE(&f->pool, mukca_fleet_arm, n + 1);
    for (int s = 0; s < f->n_sessions && f->arm; s = f->arm[f->n_arms++].end)
        if (!sum(&f->arm[f->n_arms], f, s)) break;
    if (f->pool.failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d arms", f->n_arms);
    return MUKCA_OK;
}

double mukca_fleet_ripple(const mukca_fleet *f, int arm, int joint, int order)
{
    int quanta = 0;
    for (int s = f->arm[arm].first; s < f->arm[arm].end; s++)
        quanta += f->session[s]->ripple[joint][order - 2];
    return quanta * MUKCA_FLEET_QUANTUM;
}

void mukca_fleet_free(mukca_fleet *f)
{
    mukca_pool_free(&f->pool);
    memset(f, 0, sizeof *f);
}
