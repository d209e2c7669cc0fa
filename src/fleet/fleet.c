/* The summaries of arms of one model, collected to a fleet. */
#include "fleet/fleet.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/list.h"
#include "math/dense.h"
#include "model/chain_hash.h"

void mukca_fleet_model_of(mukca_fleet_model *model, const mukca_chain *chain)
{
    *model = (mukca_fleet_model){.n_joints = chain->n_joints, .masses = MUKCA_HASH_START};
    memcpy(model->robot, chain->robot, sizeof model->robot);
    memcpy(model->base, chain->base, sizeof model->base);
    memcpy(model->tip, chain->tip, sizeof model->tip);
    for (int j = 0; j < chain->n_joints; j++)
        memcpy(model->joint[j], mukca_chain_joint_name(chain, j), sizeof *model->joint);
    const int last = chain->joint_element[chain->n_joints - 1];
    for (int i = 0; i < chain->n_masses; i++) {
        if (chain->mass[i].element >= last) continue; /* the last link carries the tool */
        const double element = chain->mass[i].element;
        model->masses = mukca_hash_numbers(model->masses, &element, 1, 1);
        model->masses = mukca_hash_numbers(model->masses, &chain->mass[i].kg, 1, 1e-3);
        model->masses = mukca_hash_numbers(model->masses, chain->mass[i].com, 3, 1e-6);
    }
    model->masses = mukca_hash_numbers(model->masses, chain->gravity, 3, 1e-3);
    /* factory files differ between arms of one model */
    model->geometry = chain->urdf_geometry ? chain->urdf_geometry : mukca_chain_hash(chain);
}

const char *mukca_fleet_model_differs(const mukca_fleet_model *a, const mukca_fleet_model *b)
{
    if (a->n_joints != b->n_joints) return "the number of joints differs";
    if (strcmp(a->base, b->base) != 0) return "the base of the chain differs";
    for (int j = 0; j < a->n_joints; j++)
        if (strcmp(a->joint[j], b->joint[j]) != 0) return "the names of the joints differ";
    if (a->geometry != b->geometry) return "the nominal geometry differs";
    return a->masses != b->masses ? "the link masses differ (--inertials)" : NULL;
}

int mukca_fleet_terms(int n_joints)
{
    return 2 * n_joints;
}

mukca_effect mukca_fleet_term(int i, int n_joints)
{
    const bool base = i == 2 * n_joints - 1;
    const mukca_effect_site site = i < n_joints ? MUKCA_SITE_ANGLE
                                   : base       ? MUKCA_SITE_BASE
                                                : MUKCA_SITE_ROTATION;
    return (mukca_effect){.kind = mukca_effect_at(site, MUKCA_TRAIT_FLEXIBLE),
                          .joint = i < n_joints ? i
                                   : base       ? -1
                                                : i - n_joints + 1,
                          .placement = -1,
                          .terms = 1};
}

mukca_effect mukca_fleet_wave(int joint)
{
    return (mukca_effect){.kind = mukca_effect_at(MUKCA_SITE_ANGLE, MUKCA_TRAIT_ORDERS),
                          .joint = joint,
                          .placement = -1,
                          .terms = 2};
}

uint64_t mukca_summary_hash(const mukca_dataset *data)
{
    const size_t rows = (size_t)data->n_rows;
    uint64_t hash =
        mukca_hash(MUKCA_HASH_START, data->q, rows * (size_t)data->n_joints * sizeof(double));
    hash = mukca_hash(hash, data->socket, rows * sizeof *data->socket);
    if (data->position) hash = mukca_hash(hash, data->position, 3 * rows * sizeof(double));
    return hash;
}

/* ---- collection of the summaries of arms of one model ---- */

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
    return mukca_dense_cholesky(A, terms);
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
    mukca_summary *copy = mukca_pool_take(&f->pool, 1, size),
                  **added =
                      copy ? mukca_list_append(&f->session, &f->n_sessions, sizeof(void *)) : NULL;
    if (!added) return mukca_fail(error, MUKCA_MEMORY, "out of memory for %s", s->path);
    *added = memcpy(copy, s, size);
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
static bool sum_sessions(mukca_fleet_arm *arm, mukca_fleet *f, int first)
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
        if (!sum_sessions(&f->arm[f->n_arms], f, s)) break;
    if (f->pool.failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d arms", f->n_arms);
    return MUKCA_OK;
}

void mukca_fleet_free(mukca_fleet *f)
{
    mukca_pool_free(&f->pool);
    free(f->session);
    memset(f, 0, sizeof *f);
}
