/* Gravity moments at the joints. */
#include "mukca/gravity.h"

#include <math.h>
#include <string.h>

#include "model/turn.h"

/* The arm in a posture under its load; what may be NULL is so in mukca_chain_moments. */
typedef struct {
    const mukca_chain *chain;
    const mukca_geometry *geometry;
    const double *q;
    const mukca_displacement *displacement;
    const double *mass_scale;
    double payload_kg;
} posture;

static double angle_of(const posture *p, int joint)
{
    return p->q[joint] + (p->displacement ? p->displacement->q[joint] : 0);
}

/* Rotation of the origin of element k, displaced; in R[9] where it is not that of the geometry. */
static const double *turn_origin(double R[9], const posture *p, int k)
{
    const int j = p->geometry->joint[k];
    double turn[9];
    if (j < 0 || !p->displacement || !p->displacement->any_rotation)
        return p->geometry->origin[k].R;
    mukca_rotation_exp(turn, p->displacement->rotation[j]);
    mukca_mat3_mul(R, p->geometry->origin[k].R, turn);
    return R;
}

static void find_moments(mukca_gravity_load *load, const posture *at)
{
    const mukca_chain *chain = at->chain;
    const mukca_geometry *geometry = at->geometry;
    const bool tilted = at->displacement && at->displacement->any_rotation;
    const int n = chain->n_elements;
    double R[9], tilt[9];                                /* of the base */
    double s[MUKCA_MAX_ELEMENTS], c[MUKCA_MAX_ELEMENTS]; /* of each joint's angle */
    double gravity[MUKCA_MAX_ELEMENTS][3];
    double kg[MUKCA_MAX_ELEMENTS] = {0}, first[MUKCA_MAX_ELEMENTS][3] = {{0}}; /* child frames */
    double g[3] = {chain->gravity[0], chain->gravity[1], chain->gravity[2]};

    if (tilted) {
        mukca_rotation_exp(tilt, at->displacement->base);
        mukca_mat3_tvec(g, tilt, chain->gravity);
    }
    /* Gravity in each joint frame, outwards. */
    for (int k = 0; k < n; k++) {
        const bool turns = mukca_joint_turns(geometry->type[k]);
        const double angle = turns ? angle_of(at, geometry->joint[k]) : 0;
        s[k] = turns ? sin(angle) : 0;
        c[k] = turns ? cos(angle) : 1;
        mukca_mat3_tvec(gravity[k], turn_origin(R, at, k), g);
        memcpy(g, gravity[k], sizeof g);
        turn_vector(g, geometry, k, -s[k], c[k]);
    }
    for (int m = 0; m < chain->n_masses; m++) {
        const mukca_mass *mass = &chain->mass[m];
        if (mass->element < 0 || mass->element >= n) continue; /* fixed to the base */
        const double w = mass->kg * (at->mass_scale ? at->mass_scale[m] : 1);
        kg[mass->element] += w;
        for (int i = 0; i < 3; i++) first[mass->element][i] += w * mass->com[i];
    }
    if (n > 0) kg[n - 1] += at->payload_kg;

    /* Mass and first moment of all that each joint carries, inwards. */
    double total = 0, carried[3] = {0, 0, 0}; /* of element k + 1, in the child frame of k */
    for (int k = n - 1; k >= 0; k--) {
        const double *axis = geometry->axis[k], *p = geometry->origin[k].p;
        const int j = geometry->joint[k];
        const bool slides = geometry->type[k] == MUKCA_PRISMATIC;
        double in_joint[3], in_parent[3];
        total += kg[k];
        for (int i = 0; i < 3; i++) in_joint[i] = first[k][i] + carried[i];
        turn_vector(in_joint, geometry, k, s[k], c[k]);
        for (int i = 0; i < 3 && slides; i++) in_joint[i] += total * axis[i] * angle_of(at, j);
        if (j >= 0) {
            mukca_cross(load->moment[j], gravity[k], in_joint); /* in_joint x (-g) */
            load->torque[j] =
                slides ? -total * mukca_dot3(axis, gravity[k]) : mukca_dot3(axis, load->moment[j]);
        }
        mukca_mat3_vec(in_parent, turn_origin(R, at, k), in_joint);
        for (int i = 0; i < 3; i++) carried[i] = in_parent[i] + total * p[i];
    }
    if (tilted) {
        const double level[3] = {carried[0], carried[1], carried[2]};
        mukca_mat3_vec(carried, tilt, level);
    }
    mukca_cross(load->base, chain->gravity, carried);
}

void mukca_chain_moments(mukca_gravity_load *load, const mukca_chain *chain,
                         const mukca_geometry *geometry, const double *q, const double *mass_scale,
                         double payload_kg)
{
    const posture at = {.chain = chain,
                        .geometry = geometry,
                        .q = q,
                        .mass_scale = mass_scale,
                        .payload_kg = payload_kg};
    find_moments(load, &at);
}

void mukca_chain_moments_displaced(mukca_gravity_load *load, const mukca_chain *chain,
                                   const mukca_geometry *geometry, const double *q,
                                   const mukca_displacement *displacement, double payload_kg)
{
    const posture at = {.chain = chain,
                        .geometry = geometry,
                        .q = q,
                        .displacement = displacement,
                        .payload_kg = payload_kg};
    find_moments(load, &at);
}
