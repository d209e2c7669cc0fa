/* Gravity moments at the joints. */
#include "mukca/gravity.h"

#include <string.h>

#include "model/columns.h"
#include "mukca/rotation.h"

void mukca_chain_masses(mukca_masses *masses, const mukca_chain *chain, const double *mass_scale,
                        double payload_kg)
{
    const int n = chain->n_elements;
    memset(masses, 0, sizeof *masses);
    for (int m = 0; m < chain->n_masses; m++) {
        const mukca_mass *mass = &chain->mass[m];
        if (mass->element < 0 || mass->element >= n) continue; /* fixed to the base */
        const double w = mass_scale ? mass->kg * mass_scale[m] : mass->kg, *com = mass->com;
        double *restrict sum = masses->first[mass->element];
        masses->kg[mass->element] += w;
        sum[0] += w * com[0], sum[1] += w * com[1], sum[2] += w * com[2];
    }
    if (n > 0) masses->kg[n - 1] += payload_kg;
}

void mukca_chain_load(mukca_gravity_load *load, const mukca_chain *chain,
                      const mukca_geometry *geometry, const double *q,
                      const mukca_displacement *displacement, const mukca_masses *masses)
{
    const int n = chain->n_elements;
    joint_angles angles;
    double gravity[MUKCA_MAX_ELEMENTS][3], tilt[MUKCA_MAX_JOINTS][9], base[9];
    double g[3] = {chain->gravity[0], chain->gravity[1], chain->gravity[2]}, turned[3];
    const bool tilts = displacement && displacement->any_rotation;

    mukca_joint_angles_set(&angles, geometry, q, displacement);
    if (tilts) {
        mukca_rotation_exp(base, displacement->base);
        mukca_mat3_tvec(g, base, chain->gravity);
    }
    /* Gravity in each joint frame, from base to tip. */
    for (int k = 0; k < n; k++) {
        const int j = geometry->joint[k];
        const double *w = joint_rotation(displacement, j);
        mukca_mat3_tvec(gravity[k], geometry->origin[k].R, g);
        memcpy(g, gravity[k], sizeof g);
        if (w) {
            mukca_rotation_exp(tilt[j], w);
            mukca_mat3_tvec(gravity[k], tilt[j], g);
            memcpy(g, gravity[k], sizeof g);
        }
        if (mukca_joint_turns(geometry->type[k]))
            turn_vector(g, geometry, k, -angles.s[j], angles.c[j]);
    }

    /* Mass and first moment of all bodies distal of each joint, from tip to base. */
    double total = 0, carried[3] = {0, 0, 0}; /* of element k + 1, in the child frame of k */
    for (int k = n - 1; k >= 0; k--) {
        const double *axis = geometry->axis[k], *p = geometry->origin[k].p;
        const int j = geometry->joint[k];
        const bool slides = geometry->type[k] == MUKCA_PRISMATIC;
        double in_joint[3], in_parent[3];
        total += masses->kg[k];
        for (int i = 0; i < 3; i++) in_joint[i] = masses->first[k][i] + carried[i];
        if (mukca_joint_turns(geometry->type[k]))
            turn_vector(in_joint, geometry, k, angles.s[j], angles.c[j]);
        for (int i = 0; i < 3 && slides; i++) in_joint[i] += total * axis[i] * angles.q[j];
        if (j >= 0) {
            mukca_cross(load->moment[j], gravity[k], in_joint); /* in_joint x (-g) */
            load->torque[j] =
                slides ? -total * mukca_dot3(axis, gravity[k]) : mukca_dot3(axis, load->moment[j]);
        }
        if (joint_rotation(displacement, j)) {
            mukca_mat3_vec(turned, tilt[j], in_joint);
            memcpy(in_joint, turned, sizeof turned);
        }
        mukca_mat3_vec(in_parent, geometry->origin[k].R, in_joint);
        for (int i = 0; i < 3; i++) carried[i] = in_parent[i] + total * p[i];
    }
    if (tilts) {
        mukca_mat3_vec(turned, base, carried);
        memcpy(carried, turned, sizeof turned);
    }
    mukca_cross(load->base, chain->gravity, carried);
}

void mukca_chain_moments(mukca_gravity_load *load, const mukca_chain *chain,
                         const mukca_geometry *geometry, const double *q, const double *mass_scale,
                         double payload_kg)
{
    mukca_masses masses;
    mukca_chain_masses(&masses, chain, mass_scale, payload_kg);
    mukca_chain_load(load, chain, geometry, q, NULL, &masses);
}
