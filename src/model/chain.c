/* The chain: look-ups, parameter vectors, and gravity moments. */
#include "mukca/chain.h"

#include <math.h>
#include <string.h>

const char *const mukca_joint_type_name[4] = {"fixed", "revolute", "continuous", "prismatic"};

const char *const mukca_parameter_name[MUKCA_PARAMETERS] = {"x", "y", "z", "roll", "pitch", "yaw"};

int mukca_chain_find_element(const mukca_chain *chain, const char *name)
{
    for (int k = 0; k < chain->n_elements; k++)
        if (!strcmp(chain->element[k].name, name)) return k;
    return -1;
}

int mukca_chain_find_joint(const mukca_chain *chain, const char *name)
{
    const int k = mukca_chain_find_element(chain, name);
    return k < 0 ? -1 : chain->element[k].joint;
}

void mukca_chain_theta(double *theta, const mukca_chain *chain)
{
    for (int k = 0; k < chain->n_elements; k++) {
        memcpy(theta + 6 * k, chain->element[k].xyz, 3 * sizeof *theta);
        memcpy(theta + 6 * k + 3, chain->element[k].rpy, 3 * sizeof *theta);
    }
}

void mukca_geometry_set(mukca_geometry *geometry, const mukca_chain *chain, const double *theta)
{
    geometry->n_elements = chain->n_elements;
    geometry->n_joints = chain->n_joints;
    for (int k = 0; k < chain->n_elements; k++) {
        const mukca_element *e = &chain->element[k];
        mukca_rotation_from_rpy(geometry->origin[k].R, theta ? theta + 6 * k + 3 : e->rpy);
        memcpy(geometry->origin[k].p, theta ? theta + 6 * k : e->xyz, 3 * sizeof(double));
        memcpy(geometry->axis[k], e->axis, sizeof e->axis);
        geometry->type[k] = (signed char)e->type;
        geometry->joint[k] = (signed char)e->joint;
        const bool on_z = e->axis[0] == 0 && e->axis[1] == 0;
        geometry->axis_z[k] = (signed char)(!on_z ? 0 : e->axis[2] > 0 ? 1 : -1);
    }
}

void mukca_geometry_theta(double *theta, const mukca_chain *chain, const mukca_geometry *geometry)
{
    for (int k = 0; k < chain->n_elements; k++) {
        memcpy(theta + 6 * k, geometry->origin[k].p, 3 * sizeof *theta);
        mukca_rotation_to_rpy(theta + 6 * k + 3, geometry->origin[k].R, chain->element[k].rpy);
    }
}

/* Rotation of an element's joint, identity where it does not turn. */
static void joint_rotation(double R[9], const mukca_geometry *geometry, int k, const double *q)
{
    if (geometry->type[k] == MUKCA_REVOLUTE || geometry->type[k] == MUKCA_CONTINUOUS) {
        mukca_rotation_about(R, geometry->axis[k], q[geometry->joint[k]]);
    } else {
        static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
        memcpy(R, identity, sizeof identity);
    }
}

void mukca_chain_moments(mukca_gravity_load *load, const mukca_chain *chain,
                         const mukca_geometry *geometry, const double *q, const double *mass_scale,
                         double payload_kg)
{
    const int n = chain->n_elements;
    double turn[MUKCA_MAX_ELEMENTS][9], gravity[MUKCA_MAX_ELEMENTS][3];
    double kg[MUKCA_MAX_ELEMENTS] = {0}, first[MUKCA_MAX_ELEMENTS][3] = {{0}}; /* child frames */
    double g[3] = {chain->gravity[0], chain->gravity[1], chain->gravity[2]};

    /* Gravity in each joint frame, outwards. */
    for (int k = 0; k < n; k++) {
        joint_rotation(turn[k], geometry, k, q);
        mukca_mat3_tvec(gravity[k], geometry->origin[k].R, g);
        mukca_mat3_tvec(g, turn[k], gravity[k]);
    }
    for (int m = 0; m < chain->n_masses; m++) {
        const mukca_mass *mass = &chain->mass[m];
        if (mass->element < 0 || mass->element >= n) continue; /* fixed to the base */
        const double w = mass->kg * (mass_scale ? mass_scale[m] : 1);
        kg[mass->element] += w;
        for (int i = 0; i < 3; i++) first[mass->element][i] += w * mass->com[i];
    }
    if (n > 0) kg[n - 1] += payload_kg;

    /* Mass and first moment of all that hangs on each joint, inwards. */
    double total = 0, carried[3] = {0, 0, 0}; /* of element k + 1, in the child frame of k */
    for (int k = n - 1; k >= 0; k--) {
        const double *axis = geometry->axis[k], *p = geometry->origin[k].p;
        const int j = geometry->joint[k];
        const bool slides = geometry->type[k] == MUKCA_PRISMATIC;
        double in_child[3], in_joint[3], in_parent[3];
        total += kg[k];
        for (int i = 0; i < 3; i++) in_child[i] = first[k][i] + carried[i];
        mukca_mat3_vec(in_joint, turn[k], in_child);
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
