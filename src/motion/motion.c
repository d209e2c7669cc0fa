/* The analysis of a motion, step by step. */
#include "motion/motion.h"

#include <math.h>
#include <string.h>

#include "base/text.h"
#include "motion/findings.h"

const char *const mukca_motion_verdict_name[MUKCA_MOTION_VERDICTS] = {"none", "named", "tied",
                                                                      "unknown"};

/* Spacing of the torques at neighbouring times, s: half of the filter's, so that what lies between
 * is interpolated; the largest delay that is found is four of them. */
#define SPACING 0.01
#define PART 0.1 /* of a joint's torque, usual, that accelerates */
/* Correlation with the model's torque that no sensor has: its sign is wrong. */
#define OPPOSITE (-0.5)

static bool has_role(const mukca_motion_input *in, mukca_run_role role)
{
    for (int r = 0; r < in->n_runs; r++)
        if (in->run[r].role == role) return true;
    return false;
}

/* Refuse torques of the wrong sign, and motions in one direction only. */
static mukca_status check(const mukca_torques *t, const mukca_motion_input *in, mukca_error *error)
{
    const mukca_signals *s = t->model.signals;
    double product = 0, model = 0, measured = 0;
    int turning = 0;
    for (const mukca_stretch *k = s->stretch; k < s->stretch + s->n; k++)
        for (int i = 0; i < k->n; i += 1 + k->n / 500) {
            double torque[MUKCA_MAX_JOINTS];
            mukca_dynamics_torque(torque, &t->model.dynamics, t->model.inertial, k->q + i * t->n,
                                  k->dq + i * t->n, k->ddq + i * t->n);
            for (int j = 0; j < t->n; j++) {
                const double tau = k->torque[i * t->n + j] / s->range[j];
                torque[j] /= s->range[j];
                product += tau * torque[j];
                model += torque[j] * torque[j];
                measured += tau * tau;
            }
        }
    if (product < OPPOSITE * sqrt(model * measured))
        return mukca_fail(error, MUKCA_INPUT,
                          "the efforts have the opposite sign of the torques that hold the arm "
                          "against gravity (correlation %.2f); reverse their sign",
                          product / sqrt(model * measured));
    for (int j = 0; j < t->n; j++) {
        const char *name = mukca_chain_joint_name(in->chain, j);
        const bool moves = s->forwards[j] || s->backwards[j];
        turning += s->forwards[j] && s->backwards[j];
        if (!moves)
            mukca_note_format(in->notes,
                              "%s does not move: its friction and inertia are not testable", name);
        else if (!(s->forwards[j] && s->backwards[j]))
            mukca_note_format(in->notes,
                              "%s moves in one direction only: Coulomb friction and a torque "
                              "offset are indistinguishable",
                              name);
    }
    if (turning) return MUKCA_OK;
    return mukca_fail(error, MUKCA_UNIDENTIFIABLE,
                      "the joints move in one direction only, so friction and a torque offset are "
                      "indistinguishable; record motions to and fro");
}

/* Mean inertia about each joint, at least that of usual torques: the rotor of a geared wrist has
 * ten times the inertia of what it turns. */
static void find_inertia(mukca_raw_model *m, const mukca_drives *drives)
{
    const mukca_signals *s = m->signals;
    const int n = s->n_joints;
    const double rest[MUKCA_MAX_JOINTS] = {0};
    enum { POSTURES = 16 };
    for (int i = 0; i < POSTURES; i++) {
        const mukca_stretch *k = &s->stretch[0];
        const double *q = k->q + k->n * i / POSTURES * n;
        double gravity[MUKCA_MAX_JOINTS], torque[MUKCA_MAX_JOINTS], unit[MUKCA_MAX_JOINTS] = {0};
        mukca_dynamics_torque(gravity, &m->dynamics, m->inertial, q, rest, rest);
        for (int j = 0; j < n; j++) {
            unit[j] = 1;
            mukca_dynamics_torque(torque, &m->dynamics, m->inertial, q, rest, unit);
            m->inertia[j] += (torque[j] - gravity[j]) / POSTURES;
            unit[j] = 0;
        }
    }
    for (int j = 0; j < n; j++)
        m->inertia[j] = fmax(m->inertia[j] + drives->armature[j],
                             PART * s->range[j] / fmax(s->acceleration[j], 1e-3));
}

static mukca_status prepare(mukca_torques *t, mukca_signals *signals, mukca_pool *pool,
                            mukca_error *error)
{
    const mukca_motion_input *in = t->input;
    MUKCA_TRY(mukca_signals_make(signals, pool, in, error));
    t->model.signals = signals;
    mukca_dynamics_set(&t->model.dynamics, in->chain);
    mukca_dynamics_inertials(t->model.inertial, in->chain);
    mukca_dynamics_inertials(t->model.load, in->chain);
    t->model.shift = (int)fmax(rint(SPACING / signals->dt), 1);
    for (int j = 0; j < t->n; j++) {
        t->point.torque[j] = MUKCA_TAKE(pool, double, mukca_raw_width(t->n, j));
        if (t->point.torque[j]) mukca_raw_nominal(t->point.torque[j], &t->model, &in->drives, j);
    }
    find_inertia(&t->model, &in->drives);
    return check(t, in, error);
}

static void summarise(mukca_motion *m, const mukca_torques *t)
{
    const mukca_signals *s = t->model.signals;
    m->fitted = m->drives = t->input->drives;
    memcpy(m->inertial, t->model.inertial, sizeof m->inertial);
    memcpy(m->fitted_inertial, t->model.inertial, sizeof m->inertial);
    for (int j = 0; j < t->n && !t->reference; j++) {
        const double *local = t->point.torque[j] + mukca_raw_local(t->n, j, 0);
        memcpy(m->fitted_inertial[j], t->point.torque[j], sizeof *m->inertial);
        m->fitted.coulomb[j] = local[MUKCA_RAW_SIGN];
        m->fitted.viscous[j] = local[MUKCA_RAW_VELOCITY];
        m->fitted.armature[j] = local[MUKCA_RAW_ACCELERATION];
    }
    for (int r = 0; r < t->input->n_runs; r++) {
        const mukca_run_role role = t->input->run[r].role;
        *(role == MUKCA_RUN_NEW         ? &m->n_runs
          : role == MUKCA_RUN_REFERENCE ? &m->n_reference
                                        : &m->n_test) += 1;
    }
    for (int k = 0; k < s->n; k++)
        if (s->stretch[k].role == MUKCA_RUN_NEW) m->seconds += s->stretch[k].n * s->dt;
    for (int j = 0; j < t->n; j++) {
        m->joint[j].moves = s->forwards[j] || s->backwards[j];
        m->joint[j].reverses = s->forwards[j] && s->backwards[j];
        m->shift_s += t->point.delay[j] / t->n;
    }
}

static mukca_status watch(const mukca_motion_input *in, double share, mukca_error *error)
{
    if (!in->progress || in->progress(in->progress_context, share, "comparing sets of effects"))
        return MUKCA_OK;
    return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
}

static mukca_status analyse(mukca_motion *m, mukca_torque_search *search, mukca_signals *signals,
                            mukca_pool *pool, mukca_pool *products, mukca_error *error)
{
    mukca_torques *t = search->t;
    MUKCA_TRY(prepare(t, signals, pool, error));
    for (int pass = 0; pass == 0 || (pass == 1 && search->loads); pass++) {
        if (pass) memcpy(t->model.load, t->point.load, sizeof t->model.load); /* as was found */
        mukca_torque_search_free(search);
        mukca_pool_free(products);
        MUKCA_TRY(watch(t->input, 0.1 + 0.3 * pass, error));
        MUKCA_TRY(mukca_raw_products_make(t->part, products, &t->model, error));
        if (!mukca_items_list(&t->items, &search->columns, t->input, &t->model, &t->point))
            return mukca_fail(error, MUKCA_MEMORY, "out of memory for the effects");
        MUKCA_TRY(mukca_torque_search_run(search, pool, error));
    }
    MUKCA_TRY(watch(t->input, 0.7, error));
    MUKCA_TRY(mukca_torque_findings(m, search, error));
    summarise(m, t);
    return MUKCA_OK;
}

mukca_status mukca_motion_analyse(mukca_motion *m, const mukca_motion_input *in, mukca_error *error)
{
    mukca_pool pool = {0}, products = {0};
    mukca_signals signals;
    mukca_torques *t = MUKCA_TAKE(&pool, mukca_torques, 1);
    mukca_torque_search search = {.t = t};
    *m = (mukca_motion){.n_joints = in->chain->n_joints};
    if (!t) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the analysis");
    t->input = in;
    t->n = in->chain->n_joints;
    t->reference = has_role(in, MUKCA_RUN_REFERENCE);
    t->test = has_role(in, MUKCA_RUN_TEST);
    const mukca_status status = analyse(m, &search, &signals, &pool, &products, error);
    mukca_torque_search_free(&search);
    mukca_pool_free(&products);
    mukca_pool_free(&pool);
    return status;
}
