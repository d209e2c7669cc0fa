/* Inverse dynamics of a chain: links, their inertial parameters, regressor and torques.
 *
 * Source: Siciliano et al., "Robotics: Modelling, Planning and Control" (2009), section 7.5 (Newton
 * and Euler) and 7.2.2 (linearity in the parameters).  Velocities and accelerations are propagated
 * from base to tip in link coordinates; gravity is an acceleration of the base.
 */
#include "dynamics/inverse_dynamics.h"

#include <math.h>
#include <string.h>

#include "mukca/rotation.h"

/* Motion of a link in its own coordinates. */
typedef struct {
    double w[3], dw[3]; /* angular velocity and acceleration */
    double a[3];        /* acceleration of the origin minus gravity */
} motion;

static const mukca_frame identity = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};

/* Place in the 6-vector of a symmetric tensor: xx yy zz xy xz yz. */
static const int place[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};

/* T := T times the origin of an element. */
static void append_origin(mukca_frame *T, const mukca_element *e)
{
    mukca_frame origin = {.p = {e->xyz[0], e->xyz[1], e->xyz[2]}};
    mukca_rotation_from_rpy(origin.R, e->rpy);
    mukca_frame_multiply(T, T, &origin);
}

void mukca_dynamics_set(mukca_dynamics *dynamics, const mukca_chain *chain)
{
    mukca_frame T = identity;
    dynamics->n_joints = chain->n_joints;
    memcpy(dynamics->gravity, chain->gravity, sizeof dynamics->gravity);
    for (int k = 0; k < chain->n_elements; k++) {
        const mukca_element *e = &chain->element[k];
        append_origin(&T, e);
        if (e->joint < 0) continue;
        dynamics->origin[e->joint] = T;
        memcpy(dynamics->axis[e->joint], e->axis, sizeof e->axis);
        dynamics->slides[e->joint] = e->type == MUKCA_PRISMATIC;
        T = identity;
    }
}

void mukca_inertial_add(double *p, double kg, const double com[3], const double inertia[6])
{
    p[0] += kg;
    for (int a = 0; a < 3; a++) {
        p[1 + a] += kg * com[a];
        for (int b = a; b < 3; b++) {
            const double square = a == b ? mukca_dot3(com, com) : 0;
            p[4 + place[a][b]] += kg * (square - com[a] * com[b]);
        }
    }
    for (int i = 0; i < 6 && inertia; i++) p[4 + i] += inertia[i];
}

/* Add a mass of an element whose frame in the link's is T. */
static void add_mass(double *p, const mukca_mass *mass, const mukca_frame *T)
{
    double com[3], inertia[6] = {0};
    mukca_mat3_vec(com, T->R, mass->com);
    for (int a = 0; a < 3; a++) {
        com[a] += T->p[a];
        for (int b = a; b < 3; b++)
            for (int i = 0; i < 3; i++)
                for (int j = 0; j < 3; j++)
                    inertia[place[a][b]] +=
                        T->R[3 * a + i] * mass->inertia[place[i][j]] * T->R[3 * b + j];
    }
    mukca_inertial_add(p, mass->kg, com, inertia);
}

void mukca_dynamics_inertials(double *p, const mukca_chain *chain)
{
    mukca_frame T = identity;
    int link = -1; /* masses before the first joint do not move */
    memset(p, 0, sizeof *p * MUKCA_INERTIAL * (size_t)chain->n_joints);
    for (int k = 0; k < chain->n_elements; k++) {
        append_origin(&T, &chain->element[k]);
        if (chain->element[k].joint >= 0) {
            link = chain->element[k].joint;
            T = identity;
        }
        for (int m = 0; m < chain->n_masses && link >= 0; m++)
            if (chain->mass[m].element == k)
                add_mass(p + MUKCA_INERTIAL * link, &chain->mass[m], &T);
    }
}

/* Frame of link j in that of link j - 1. */
static void link_frame(mukca_frame *T, const mukca_dynamics *dynamics, int j, double q)
{
    const mukca_frame *origin = &dynamics->origin[j];
    const double *u = dynamics->axis[j];
    if (dynamics->slides[j]) {
        *T = *origin;
        for (int i = 0; i < 3; i++) T->p[i] += q * mukca_dot3(origin->R + 3 * i, u);
        return;
    }
    double turn[9];
    mukca_rotation_about(turn, u, q);
    mukca_mat3_mul(T->R, origin->R, turn);
    memcpy(T->p, origin->p, sizeof T->p);
}

/* v + w x p in the coordinates of the next link: velocity of its origin. */
static void shift(double out[3], const double v[3], const double w[3], const mukca_frame *T)
{
    double moved[3];
    mukca_cross(moved, w, T->p);
    for (int i = 0; i < 3; i++) moved[i] += v[i];
    mukca_mat3_tvec(out, T->R, moved);
}

/* The motion of link j from that of link j - 1, in place; T: its frame there. */
static void propagate(motion *at, const mukca_frame *T, const mukca_dynamics *dynamics, int j,
                      double dq, double ddq)
{
    const double *u = dynamics->axis[j];
    const motion before = *at;
    double spin[3], coriolis[3], a[3];
    mukca_cross(spin, before.w, T->p);
    mukca_cross(a, before.w, spin);
    for (int i = 0; i < 3; i++) a[i] += before.a[i];
    shift(at->a, a, before.dw, T);
    mukca_mat3_tvec(at->w, T->R, before.w);
    mukca_mat3_tvec(at->dw, T->R, before.dw);
    mukca_cross(coriolis, at->w, u);
    for (int i = 0; i < 3; i++) {
        if (dynamics->slides[j]) {
            at->a[i] += ddq * u[i] + 2 * dq * coriolis[i];
        } else {
            at->dw[i] += ddq * u[i] + dq * coriolis[i];
            at->w[i] += dq * u[i];
        }
    }
}

/* Power, by unit parameters of a link that moves like `at`, upon a joint that moves the link's
 * origin with v and turns the link with w: force  = m a + (dw~ + w~ w~) mc,   moment = mc x a + I
 * dw + w x I w */
static void row_of(double row[MUKCA_INERTIAL], const motion *at, const double v[3],
                   const double w[3])
{
    double turned[3], lever[3], spin[3], twice[3], u[3];
    row[0] = mukca_dot3(v, at->a);
    mukca_cross(turned, v, at->dw);
    mukca_cross(spin, v, at->w);
    mukca_cross(twice, spin, at->w);
    mukca_cross(lever, at->a, w);
    for (int i = 0; i < 3; i++) row[1 + i] = turned[i] + twice[i] + lever[i];
    mukca_cross(u, w, at->w);
    for (int a = 0; a < 3; a++) {
        row[4 + a] = w[a] * at->dw[a] + u[a] * at->w[a];
        for (int b = a + 1; b < 3; b++)
            row[4 + place[a][b]] =
                w[a] * at->dw[b] + w[b] * at->dw[a] + u[a] * at->w[b] + u[b] * at->w[a];
    }
}

/* Torques of unit parameters into Y, or (Y NULL) those of parameters p added to `torque`. */
static void find_torques(double *Y, double *torque, const mukca_dynamics *dynamics, const double *p,
                         const double *const state[3])
{
    const int n = dynamics->n_joints;
    const double *g = dynamics->gravity, rest[3] = {0, 0, 0};
    double v[MUKCA_MAX_JOINTS][3], w[MUKCA_MAX_JOINTS][3]; /* of link k by a unit of dq[i] */
    motion at = {.a = {-g[0], -g[1], -g[2]}};
    for (int k = 0; k < n; k++) {
        mukca_frame T;
        link_frame(&T, dynamics, k, state[0][k]);
        propagate(&at, &T, dynamics, k, state[1][k], state[2][k]);
        for (int i = 0; i < k; i++) {
            double before[3];
            memcpy(before, w[i], sizeof before);
            shift(v[i], v[i], before, &T);
            mukca_mat3_tvec(w[i], T.R, before);
        }
        memcpy(v[k], dynamics->slides[k] ? dynamics->axis[k] : rest, sizeof v[k]);
        memcpy(w[k], dynamics->slides[k] ? rest : dynamics->axis[k], sizeof w[k]);
        for (int i = 0; i < n; i++) {
            double row[MUKCA_INERTIAL] = {0};
            if (i <= k) row_of(row, &at, v[i], w[i]);
            if (Y) memcpy(Y + MUKCA_INERTIAL * (i * n + k), row, sizeof row);
            for (int c = 0; c < MUKCA_INERTIAL && torque && p; c++)
                torque[i] += row[c] * p[k * MUKCA_INERTIAL + c];
        }
    }
}

void mukca_dynamics_regressor(double *Y, const mukca_dynamics *dynamics, const double *q,
                              const double *dq, const double *ddq)
{
    find_torques(Y, NULL, dynamics, NULL, (const double *const[]){q, dq, ddq});
}

void mukca_dynamics_torque(double *torque, const mukca_dynamics *dynamics, const double *p,
                           const double *q, const double *dq, const double *ddq)
{
    memset(torque, 0, sizeof *torque * (size_t)dynamics->n_joints);
    find_torques(NULL, torque, dynamics, p, (const double *const[]){q, dq, ddq});
}
