/* Unknowns of the diagnosis: geometry, causes, noise, and their priors. */
#include "diagnose/unknowns.h"

#include <math.h>
#include <string.h>

#include "model/dataset_subset.h"

/* Of an unknown frame or tool, m and rad: uninformative. */
#define FREE_LENGTH 1.0
#define FREE_ANGLE 3.0

static bool take_arrays(mukca_unknowns *u, mukca_pool *pool)
{
    u->theta = MUKCA_TAKE(pool, double, u->n_geometry);
    u->theta_prior = MUKCA_TAKE(pool, double, u->n_geometry);
    u->cause = MUKCA_TAKE(pool, mukca_accepted, MUKCA_MAX_ACCEPTED);
    return !pool->failed;
}

/* C = inverse(A) B */
static void between(mukca_frame *C, const mukca_frame *A, const mukca_frame *B)
{
    double origin[3];
    mukca_mat3_tmul(C->R, A->R, B->R);
    mukca_mat3_tvec(C->p, A->R, B->p);
    mukca_mat3_tvec(origin, A->R, A->p);
    for (int c = 0; c < 3; c++) C->p[c] -= origin[c];
}

/* Align the free frames to the nominal geometry: shared frames by the first log if other frames are
 * per log, else by all.  False: no memory. */
static bool align_logs(mukca_unknowns *u, const mukca_recording *r)
{
    const int last = r->chain->n_elements - 1;
    const bool own_tracker = u->n_trackers > 1, own_target = u->n_targets > 1;
    mukca_align_options options = {.tracker = u->free_base,
                                   .target = u->free_tool,
                                   .group = own_tracker || own_target ? r->log : NULL};
    mukca_alignment first, a;
    if (!mukca_align(&first, &u->arm.geometry, r->data, &options)) return false;
    options.tracker = own_tracker, options.target = own_target;
    mukca_geometry known = u->arm.geometry; /* including the shared frames */
    if (!own_tracker) mukca_frame_multiply(&known.origin[0], &first.tracker, &known.origin[0]);
    if (!own_target) mukca_frame_multiply(&known.origin[last], &known.origin[last], &first.target);
    u->nominal_target = first.target;
    for (int g = 0; g < r->n_logs; g++) {
        options.only = g;
        a = first;
        if (g > 0 && options.group && !mukca_align(&a, &known, r->data, &options)) return false;
        u->nominal.tracker[g] = own_tracker ? a.tracker : first.tracker;
        between(&u->nominal.shift[g], &first.target, own_target ? &a.target : &first.target);
    }
    return true;
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
        .prior = mukca_prior_diagnosed,
        .sigma = 1e-4,
        .rotation_weight = 0.3};
    u->n_trackers = !u->free_base ? 0 : recording->options.base_per_log ? recording->n_logs : 1;
    u->n_targets = !u->free_tool ? 0 : recording->options.tool_per_log ? recording->n_logs : 1;
    mukca_geometry_set(&u->arm.geometry, chain, NULL);
    if (!align_logs(u, recording)) return false;
    u->arm.log = u->nominal;
    u->target = u->nominal_target;
    /* The first joint's origin moves all sockets alike: identifiable from measured poses only. */
    for (int j = poses && !u->free_base ? 0 : 1; j < chain->n_joints; j++)
        u->slot_element[u->n_slots++] = chain->joint_element[j];
    if (chain->element[last].joint < 0) {
        u->slot_element[u->n_slots++] = last;
        u->slot_width = recording->dim == 6 ? 6 : 3;
    }
    u->first_tracker = 6 * (u->n_slots - 1) + u->slot_width + 1;
    u->first_target = u->first_tracker + 6 * u->n_trackers;
    u->first_artefact =
        u->first_target + (u->n_targets > 1 ? u->slot_width * (u->n_targets - 1) : 0);
    u->n_geometry = u->first_artefact + mukca_dataset_artefacts(recording->data);
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
    return u->n_geometry + MUKCA_SET_COLUMNS;
}

/* frame := frame * local(t); `turns`: t includes a rotation vector. */
static void move(mukca_frame *frame, const double *t, bool turns)
{
    mukca_frame local = {MUKCA_IDENTITY, {t[0], t[1], t[2]}};
    if (turns) mukca_rotation_exp(local.R, t + 3);
    mukca_frame_multiply(frame, frame, &local);
}

void mukca_unknowns_set_geometry(mukca_unknowns *u, const mukca_chain *chain)
{
    mukca_geometry_set(&u->arm.geometry, chain, NULL);
    const double factor = 1 + u->theta[u->first_tracker - 1];
    for (int k = 0; k < chain->n_elements; k++)
        for (int c = 0; c < 3; c++) u->arm.geometry.origin[k].p[c] *= factor;
    for (int k = 0; k < u->n_slots; k++) {
        mukca_frame *origin = &u->arm.geometry.origin[u->slot_element[k]];
        if (u->free_tool && k + 1 == u->n_slots) mukca_frame_multiply(origin, origin, &u->target);
        move(origin, u->theta + 6 * k, k + 1 < u->n_slots || u->slot_width == 6);
    }
}

/* The same, and t := 0. */
static void fold(mukca_frame *frame, double *t, bool turns)
{
    move(frame, t, turns);
    memset(t, 0, (turns ? 6 : 3) * sizeof *t);
}

void mukca_unknowns_fold_frames(mukca_unknowns *u)
{
    const bool turns = u->slot_width == 6;
    for (int g = 0; g < u->n_trackers; g++)
        fold(&u->arm.log.tracker[g], u->theta + u->first_tracker + 6 * g, true);
    for (int g = 1; g < MUKCA_MAX_LOGS && u->n_trackers == 1; g++)
        u->arm.log.tracker[g] = u->arm.log.tracker[0];
    if (u->free_tool) fold(&u->target, u->theta + 6 * (u->n_slots - 1), turns);
    for (int g = 1; g < u->n_targets; g++)
        fold(&u->arm.log.shift[g], u->theta + u->first_target + u->slot_width * (g - 1), turns);
}

mukca_arm_state mukca_unknowns_nominal_arm(const mukca_unknowns *u, const mukca_chain *chain)
{
    mukca_arm_state arm = {.log = u->nominal};
    mukca_geometry_set(&arm.geometry, chain, NULL);
    mukca_frame *last = &arm.geometry.origin[chain->n_elements - 1];
    mukca_frame_multiply(last, last, &u->nominal_target);
    return arm;
}

void mukca_unknowns_set_geometry_prior(mukca_unknowns *u, const mukca_recording *recording)
{
    const mukca_geometry_prior *prior = &u->prior;
    for (int k = 0; k < u->n_slots; k++) {
        const mukca_element *element = &recording->chain->element[u->slot_element[k]];
        double *sigma = u->theta_prior + 6 * k;
        const int width = k + 1 < u->n_slots ? 6 : u->slot_width;
        const bool tip = element->joint < 0;
        for (int a = 0; a < 3; a++) {
            sigma[a] = tip ? (u->free_tool ? FREE_LENGTH : prior->tool) : prior->length;
            if (width < 6) continue;
            const double along = element->axis[a] * element->axis[a],
                         zero = prior->zero > 0 ? prior->zero : prior->angle;
            sigma[3 + a] =
                tip ? (u->free_tool ? FREE_ANGLE : prior->angle)
                    : sqrt(prior->angle * prior->angle * (1 - along) + zero * zero * along);
        }
    }
    u->theta_prior[u->first_tracker - 1] = prior->common;
    for (int i = u->first_tracker; i < u->first_target; i++)
        u->theta_prior[i] = (i - u->first_tracker) % 6 < 3 ? FREE_LENGTH : FREE_ANGLE;
    for (int i = u->first_target; i < u->first_artefact; i++)
        u->theta_prior[i] = (i - u->first_target) % u->slot_width < 3 ? FREE_LENGTH : FREE_ANGLE;
    for (int p = 0; p < recording->data->n_distances; p++)
        u->theta_prior[u->first_artefact + recording->data->distances[p].artefact] =
            mukca_distance_sigma(&recording->data->distances[p]);
}

int mukca_unknowns_column(const mukca_unknowns *u, int cause)
{
    int column = u->n_geometry;
    for (int c = 0; c < cause; c++) column += u->cause[c].candidate.terms;
    return column;
}

void mukca_unknowns_prior(double *prior, const mukca_unknowns *u, int model)
{
    const uint64_t in = model < 0 ? ~UINT64_C(0) : u->model[model];
    memcpy(prior, u->theta_prior, sizeof *prior * (size_t)u->n_geometry);
    prior += u->n_geometry;
    for (int c = 0; c < u->n_causes; c++)
        for (int t = 0; t < u->cause[c].candidate.terms; t++)
            *prior++ = in >> c & 1 ? u->cause[c].scale / u->cause[c].candidate.unit[t] : 0;
}

void mukca_unknowns_set(mukca_unknowns *u, const double *mean)
{
    memcpy(u->theta, mean, sizeof *mean * (size_t)u->n_geometry);
    mean += u->n_geometry;
    for (int c = 0; c < u->n_causes; c++)
        for (int t = 0; t < u->cause[c].candidate.terms; t++)
            u->cause[c].coefficient[t] = *mean++ + u->cause[c].centre;
}

bool mukca_unknowns_add(mukca_unknowns *u, const mukca_candidate *candidate)
{
    const int used = mukca_unknowns_column(u, u->n_causes) + candidate->terms;
    if (u->n_causes == MUKCA_MAX_ACCEPTED || used > mukca_unknowns_capacity(u)) return false;
    const mukca_mixture prior = mukca_candidate_mixture(candidate);
    for (int k = 0; k < u->n_models; k++) u->model[k] |= UINT64_C(1) << u->n_causes;
    u->cause[u->n_causes++] =
        (mukca_accepted){.candidate = *candidate, .scale = prior.size[prior.n_sizes / 2]};
    return true;
}

void mukca_unknowns_drop(mukca_unknowns *u, int cause)
{
    const uint64_t before = (UINT64_C(1) << cause) - 1;
    for (int c = cause; c + 1 < u->n_causes; c++) u->cause[c] = u->cause[c + 1];
    for (int k = 0; k < u->n_models; k++)
        u->model[k] = (u->model[k] & before) | (u->model[k] >> 1 & ~before);
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
        const int site = mukca_candidate_site(h);
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
    const int n_joints = recording->chain->n_joints, log = recording->log[row];
    const double *q = recording->data->q + (size_t)row * (size_t)n_joints;
    const mukca_frame *tracker = &u->arm.log.tracker[log];
    mukca_displacement d;
    mukca_frame tip;
    mukca_unknowns_displacement(&d, u, n_joints, row);
    if (log == 0 || u->n_targets < 2) {
        mukca_fk_position(tip.p, &u->arm.geometry, q, u->n_causes ? &d : NULL);
    } else {
        mukca_fk_pose(&tip, &u->arm.geometry, q, u->n_causes ? &d : NULL);
        mukca_frame_multiply(&tip, &tip, &u->arm.log.shift[log]);
    }
    memcpy(position, tip.p, sizeof tip.p);
    if (recording->data->socket[row] >= 0) return;
    mukca_mat3_vec(position, tracker->R, tip.p);
    for (int c = 0; c < 3; c++) position[c] += tracker->p[c];
}

void mukca_unknowns_to_base(double position[3], const mukca_unknowns *u, int log,
                            const double measured[3])
{
    const mukca_frame *tracker = &u->arm.log.tracker[log];
    double difference[3];
    for (int c = 0; c < 3; c++) difference[c] = measured[c] - tracker->p[c];
    mukca_mat3_tvec(position, tracker->R, difference);
}
