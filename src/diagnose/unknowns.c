/* The unknowns of the diagnosis: geometry, causes, noise, and their priors. */
#include "diagnose/unknowns.h"

#include <math.h>
#include <string.h>

/* Prior sigma of a joint's zero, rad: real arms are off by up to 15 mrad. */
#define ZERO_SIGMA 20e-3
/* Of a factor common to all lengths: without it a wrong distance of the sockets would be taken for
 * the arm's size by the priors of single lengths, which know little of their sum. */
#define FACTOR_SIGMA 2e-3
/* Of the ball's place on the tool, m, which nobody measures. */
#define TIP_SIGMA 20e-3
/* Of a frame or tool that is not known at all, m and rad: no information. */
#define FREE_LENGTH 1.0
#define FREE_ANGLE 3.0

static bool take_arrays(mukca_unknowns *u, mukca_pool *pool)
{
    u->theta = MUKCA_TAKE(pool, double, u->n_geometry);
    u->theta_prior = MUKCA_TAKE(pool, double, u->n_geometry);
    u->cause = MUKCA_TAKE(pool, mukca_accepted, MUKCA_MAX_ACCEPTED);
    return !pool->failed;
}

bool mukca_unknowns_create(mukca_unknowns *u, mukca_pool *pool, const mukca_recording *recording)
{
    const mukca_chain *chain = recording->chain;
    const bool poses = recording->groups[0].socket < 0;
    const int last = chain->n_elements - 1;
    *u = (mukca_unknowns){
        .free_base = poses && recording->options.free_base,
        .free_tool = poses && recording->options.free_tool && chain->element[last].joint < 0,
        .slot_width = 6,
        .sigma_length = 2e-3, /* first guesses: choose_scales() follows */
        .sigma_angle = 5e-3,
        .sigma = 1e-4,
        .rotation_weight = 0.3};
    mukca_geometry_set(&u->geometry, chain, NULL);
    if (!mukca_align(&u->nominal, &u->geometry, recording->data,
                     &(mukca_align_options){.tracker = u->free_base, .target = u->free_tool}))
        return false;
    u->tracker = u->nominal.tracker;
    u->target = u->nominal.target;
    /* A first joint's origin moves all sockets alike: only measured poses can see it. */
    for (int j = poses && !u->free_base ? 0 : 1; j < chain->n_joints; j++)
        u->slot_element[u->n_slots++] = chain->joint_element[j];
    if (chain->element[last].joint < 0) {
        u->slot_element[u->n_slots++] = last;
        u->slot_width = recording->dim == 6 ? 6 : 3;
    }
    u->n_geometry = 6 * (u->n_slots - 1) + u->slot_width + 1 + (u->free_base ? 6 : 0);
    return take_arrays(u, pool);
}

bool mukca_unknowns_clone(mukca_unknowns *copy, mukca_pool *pool, const mukca_unknowns *u)
{
    copy->n_geometry = u->n_geometry;
    if (!take_arrays(copy, pool)) return false;
    mukca_unknowns_assign(copy, u);
    return true;
}

void mukca_unknowns_assign(mukca_unknowns *u, const mukca_unknowns *from)
{
    double *theta = u->theta, *prior = u->theta_prior;
    mukca_accepted *cause = u->cause;
    *u = *from;
    u->theta = theta, u->theta_prior = prior, u->cause = cause;
    memcpy(theta, from->theta, sizeof *theta * (size_t)u->n_geometry);
    memcpy(prior, from->theta_prior, sizeof *prior * (size_t)u->n_geometry);
    memcpy(cause, from->cause, sizeof *cause * (size_t)u->n_causes);
}

int mukca_unknowns_capacity(const mukca_unknowns *u)
{
    return u->n_geometry + 3 * MUKCA_MAX_COLUMNS;
}

void mukca_unknowns_set_geometry(mukca_unknowns *u, const mukca_chain *chain)
{
    mukca_geometry_set(&u->geometry, chain, NULL);
    const double factor = 1 + u->theta[6 * (u->n_slots - 1) + u->slot_width];
    for (int k = 0; k < chain->n_elements; k++)
        for (int c = 0; c < 3; c++) u->geometry.origin[k].p[c] *= factor;
    for (int k = 0; k < u->n_slots; k++) {
        const double *t = u->theta + 6 * k;
        mukca_frame local = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {t[0], t[1], t[2]}};
        if (k + 1 < u->n_slots || u->slot_width == 6) mukca_rotation_exp(local.R, t + 3);
        mukca_frame *origin = &u->geometry.origin[u->slot_element[k]];
        if (u->free_tool && k + 1 == u->n_slots) mukca_frame_multiply(origin, origin, &u->target);
        mukca_frame_multiply(origin, origin, &local);
    }
}

/* frame := frame * local(t), t zeroed; `turns`: t holds a rotation vector, too. */
static void fold(mukca_frame *frame, double *t, bool turns)
{
    mukca_frame local = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {t[0], t[1], t[2]}};
    if (turns) mukca_rotation_exp(local.R, t + 3);
    mukca_frame_multiply(frame, frame, &local);
    memset(t, 0, (turns ? 6 : 3) * sizeof *t);
}

void mukca_unknowns_fold_frames(mukca_unknowns *u)
{
    if (u->free_base) fold(&u->tracker, u->theta + u->n_geometry - 6, true);
    if (u->free_tool) fold(&u->target, u->theta + 6 * (u->n_slots - 1), u->slot_width == 6);
}

mukca_arm_state mukca_unknowns_nominal_arm(const mukca_unknowns *u, const mukca_chain *chain)
{
    mukca_arm_state arm = {.tracker = u->nominal.tracker};
    mukca_geometry_set(&arm.geometry, chain, NULL);
    mukca_frame *last = &arm.geometry.origin[chain->n_elements - 1];
    mukca_frame_multiply(last, last, &u->nominal.target);
    return arm;
}

mukca_arm_state mukca_unknowns_arm(const mukca_unknowns *u)
{
    return (mukca_arm_state){.geometry = u->geometry, .tracker = u->tracker};
}

void mukca_unknowns_set_arm(mukca_unknowns *u, const mukca_arm_state *arm)
{
    u->geometry = arm->geometry;
    u->tracker = arm->tracker;
}

void mukca_unknowns_set_geometry_prior(mukca_unknowns *u, const mukca_recording *recording)
{
    for (int k = 0; k < u->n_slots; k++) {
        const mukca_element *element = &recording->chain->element[u->slot_element[k]];
        double *sigma = u->theta_prior + 6 * k;
        const int width = k + 1 < u->n_slots ? 6 : u->slot_width;
        const bool tip = element->joint < 0;
        for (int a = 0; a < 3; a++) {
            sigma[a] = tip ? (u->free_tool ? FREE_LENGTH : TIP_SIGMA) : u->sigma_length;
            if (width < 6) continue;
            const double along = element->axis[a] * element->axis[a];
            sigma[3 + a] = tip ? (u->free_tool ? FREE_ANGLE : u->sigma_angle)
                               : sqrt(u->sigma_angle * u->sigma_angle * (1 - along) +
                                      ZERO_SIGMA * ZERO_SIGMA * along);
        }
    }
    u->theta_prior[6 * (u->n_slots - 1) + u->slot_width] = FACTOR_SIGMA;
    for (int a = 0; u->free_base && a < 6; a++)
        u->theta_prior[u->n_geometry - 6 + a] = a < 3 ? FREE_LENGTH : FREE_ANGLE;
}

int mukca_unknowns_column(const mukca_unknowns *u, int cause)
{
    int column = u->n_geometry;
    for (int c = 0; c < cause; c++) column += u->cause[c].candidate.terms;
    return column;
}

void mukca_unknowns_prior(double *prior, const mukca_unknowns *u)
{
    memcpy(prior, u->theta_prior, sizeof *prior * (size_t)u->n_geometry);
    prior += u->n_geometry;
    for (int c = 0; c < u->n_causes; c++)
        for (int t = 0; t < u->cause[c].candidate.terms; t++)
            *prior++ = u->cause[c].scale / u->cause[c].candidate.unit[t];
}

void mukca_unknowns_set(mukca_unknowns *u, const double *mean)
{
    memcpy(u->theta, mean, sizeof *mean * (size_t)u->n_geometry);
    mean += u->n_geometry;
    for (int c = 0; c < u->n_causes; c++)
        for (int t = 0; t < u->cause[c].candidate.terms; t++) u->cause[c].coefficient[t] = *mean++;
}

bool mukca_unknowns_add(mukca_unknowns *u, const mukca_candidate *candidate)
{
    const int used = mukca_unknowns_column(u, u->n_causes) + candidate->terms;
    if (u->n_causes == MUKCA_MAX_ACCEPTED || used > mukca_unknowns_capacity(u)) return false;
    double scales[MUKCA_MAX_SIZES], weight[MUKCA_MAX_SIZES];
    const int n = mukca_candidate_scales(scales, weight, candidate);
    u->cause[u->n_causes++] = (mukca_accepted){.candidate = *candidate, .scale = scales[n / 2]};
    return true;
}

void mukca_unknowns_drop(mukca_unknowns *u, int cause)
{
    for (int c = cause; c + 1 < u->n_causes; c++) u->cause[c] = u->cause[c + 1];
    u->n_causes--;
}

void mukca_unknowns_displacement(mukca_displacement *d, const mukca_unknowns *u, int n_joints,
                                 int row)
{
    memset(d, 0, sizeof *d);
    for (int c = 0; c < u->n_causes; c++) {
        const mukca_candidate *h = &u->cause[c].candidate;
        if (!mukca_candidate_moves_arm(h)) continue;
        const int width = h->width_of_term;
        const float *basis = h->basis + (size_t)row * (size_t)(h->terms * width);
        const mukca_effect_site site = mukca_candidate_site(h);
        double *into = site == MUKCA_SITE_ANGLE      ? &d->q[h->joint]
                       : site == MUKCA_SITE_ROTATION ? d->rotation[h->joint]
                       : site == MUKCA_SITE_BASE     ? d->base
                       : site == MUKCA_SITE_TIP      ? d->tip
                                                     : d->q;
        if (site == MUKCA_SITE_ANGLES && width != n_joints) continue;
        d->any_rotation |= site == MUKCA_SITE_ROTATION || site == MUKCA_SITE_BASE;
        for (int t = 0; t < h->terms; t++)
            for (int i = 0; i < width; i++)
                into[i] += u->cause[c].coefficient[t] * (double)basis[t * width + i];
    }
}

void mukca_unknowns_predict(double position[3], const mukca_unknowns *u,
                            const mukca_recording *recording, int row)
{
    const int n_joints = recording->chain->n_joints;
    mukca_displacement d;
    mukca_unknowns_displacement(&d, u, n_joints, row);
    mukca_fk_position(position, &u->geometry, recording->data->q + (size_t)row * (size_t)n_joints,
                      u->n_causes ? &d : NULL);
}

void mukca_unknowns_predict_measured(double position[3], const mukca_unknowns *u,
                                     const mukca_recording *recording, int row)
{
    double p[3];
    mukca_unknowns_predict(p, u, recording, row);
    memcpy(position, p, sizeof p);
    if (recording->data->socket[row] >= 0) return;
    mukca_mat3_vec(position, u->tracker.R, p);
    for (int c = 0; c < 3; c++) position[c] += u->tracker.p[c];
}

void mukca_unknowns_to_base(double position[3], const mukca_unknowns *u, const double measured[3])
{
    double difference[3];
    for (int c = 0; c < 3; c++) difference[c] = measured[c] - u->tracker.p[c];
    mukca_mat3_tvec(position, u->tracker.R, difference);
}
