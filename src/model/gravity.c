/* Gravity moments at the joints. */
#include "mukca/gravity.h"

#include <math.h>
#include <string.h>

#include "model/turn.h"

void mukca_chain_moments(mukca_gravity_load *load, const mukca_chain *chain,
                         const mukca_geometry *geometry, const double *q, const double *mass_scale,
                         double payload_kg)
{
    const int n = chain->n_elements;
    double s[MUKCA_MAX_ELEMENTS], c[MUKCA_MAX_ELEMENTS]; /* of each joint's angle */
    double gravity[MUKCA_MAX_ELEMENTS][3];
    double kg[MUKCA_MAX_ELEMENTS] = {0}, first[MUKCA_MAX_ELEMENTS][3] = {{0}}; /* child frames */
    double g[3] = {chain->gravity[0], chain->gravity[1], chain->gravity[2]};

    /* Gravity in each joint frame, outwards. */
    for (int k = 0; k < n; k++) {
        const bool turns = mukca_joint_turns(geometry->type[k]);
        s[k] = turns ? sin(q[geometry->joint[k]]) : 0;
        c[k] = turns ? cos(q[geometry->joint[k]]) : 1;
        mukca_mat3_tvec(gravity[k], geometry->origin[k].R, g);
        memcpy(g, gravity[k], sizeof g);
        turn_vector(g, geometry, k, -s[k], c[k]);
    }
    for (int m = 0; m < chain->n_masses; m++) {
        const mukca_mass *mass = &chain->mass[m];
        if (mass->element < 0 || mass->element >= n) continue; /* fixed to the base */
        const double w = mass->kg * (mass_scale ? mass_scale[m] : 1);
        kg[mass->element] += w;
        for (int i = 0; i < 3; i++) first[mass->element][i] += w * mass->com[i];
    }
    if (n > 0) kg[n - 1] += payload_kg;

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
        for (int i = 0; i < 3 && slides; i++) in_joint[i] += total * axis[i] * q[j];
        if (j >= 0) {
            mukca_cross(load->moment[j], gravity[k], in_joint); /* in_joint x (-g) */
            load->torque[j] =
                slides ? -total * mukca_dot3(axis, gravity[k]) : mukca_dot3(axis, load->moment[j]);
        }
        mukca_mat3_vec(in_parent, geometry->origin[k].R, in_joint);
        for (int i = 0; i < 3; i++) carried[i] = in_parent[i] + total * p[i];
    }
    mukca_cross(load->base, chain->gravity, carried);
}
