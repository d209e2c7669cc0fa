/* Gravity moments of each row of a recording, by body, and mass factors from measured efforts. */
#include <math.h>
#include <string.h>

#include "diagnose/recording.h"
#include "math/dense.h"
#include "mukca/gravity.h"

/* Assumptions: standard deviation of a measured effort, N m, friction included; relative standard
 * deviation of a model's mass (the default mass_spread). */
#define EFFORT_SIGMA 0.15
#define MASS_SIGMA 0.1
/* Efforts below this cosine with the modelled torques are not holding torques (currents, other
 * signs), and contain no information on the masses. */
#define LEAST_CORRELATION 0.5

/* A weighed payload: 1 %, as a centre of mass one centimetre from the tip at a lever arm of 1 m. */
#define PAYLOAD_SPREAD 0.01

double mukca_recording_mass_spread(const mukca_recording *r, int body)
{
    return body == r->payload_body ? fmin(PAYLOAD_SPREAD, r->options.mass_spread)
                                   : r->options.mass_spread;
}

static double *torques(const mukca_recording *r, int row, int body)
{
    return r->torque +
           ((size_t)row * (size_t)r->n_bodies + (size_t)body) * (size_t)r->chain->n_joints;
}

/* Ridge estimate of each body's mass factor from measured efforts. */
static void estimate_masses(mukca_recording *r)
{
    const int k = r->n_bodies, n_joints = r->chain->n_joints;
    double *normal = r->normal, right[MUKCA_MAX_ELEMENTS + 1] = {0};
    const double weight = 1 / (EFFORT_SIGMA * EFFORT_SIGMA);
    memset(normal, 0, sizeof *normal * (size_t)(k * k));
    for (int row = 0; row < r->data->n_rows; row++)
        for (int j = 0; j < n_joints; j++) {
            const double effort = r->data->effort[row * n_joints + j];
            if (!isfinite(effort)) continue;
            for (int a = 0; a < k; a++) {
                const double torque = torques(r, row, a)[j];
                right[a] += weight * torque * effort;
                for (int b = 0; b <= a; b++)
                    normal[a * k + b] += weight * torque * torques(r, row, b)[j];
            }
        }
    for (int a = 0; a < k; a++) {
        const double spread = a == r->payload_body ? PAYLOAD_SPREAD : MASS_SIGMA;
        right[a] += 1 / (spread * spread), normal[a * k + a] += 1 / (spread * spread);
    }
    if (!mukca_dense_solve(right, 1, normal, k)) return;
    for (int a = 0; a < k; a++) r->mass_factor[a] = fmin(fmax(right[a], 0.3), 3.0);
}

/* Cosine of measured and modelled holding torques; NaN without efforts. */
static double correlate_efforts(const mukca_recording *r)
{
    const int n_joints = r->chain->n_joints;
    double agree = 0, efforts = 0, modelled = 0;
    for (int row = 0; row < r->data->n_rows; row++)
        for (int j = 0; j < n_joints; j++) {
            double torque = 0;
            for (int a = 0; a < r->n_bodies; a++) torque += torques(r, row, a)[j];
            const double effort = r->data->effort[row * n_joints + j];
            if (!isfinite(effort)) continue;
            agree += torque * effort;
            efforts += effort * effort;
            modelled += torque * torque;
        }
    return efforts > 0 && modelled > 0 ? agree / sqrt(efforts * modelled) : (double)NAN;
}

/* Moments of one body in one row, with the nominal geometry. */
static void body_moments(mukca_recording *r, const mukca_geometry *nominal, int row, int body)
{
    const mukca_chain *chain = r->chain;
    const mukca_dataset *data = r->data;
    const size_t n_joints = (size_t)chain->n_joints,
                 at = (size_t)row * (size_t)r->n_bodies + (size_t)body;
    const int element = r->body_element[body];
    const bool payload = body == r->payload_body;
    double scale[MUKCA_MAX_MASSES];
    for (int i = 0; i < chain->n_masses; i++)
        scale[i] = !payload && chain->mass[i].element == element;
    mukca_gravity_load load;
    mukca_chain_moments(&load, chain, nominal, data->q + (size_t)row * n_joints, scale,
                        payload && isfinite(data->payload[row]) ? data->payload[row] : 0);
    memcpy(r->moment + 3 * at * n_joints, load.moment, n_joints * sizeof *load.moment);
    memcpy(r->torque + at * n_joints, load.torque, n_joints * sizeof *load.torque);
    memcpy(r->base_moment + 3 * at, load.base, sizeof load.base);
}

/* Loads with gravity along two axes across that of the model: those of an arm on a wall. */
static void load_across(mukca_recording *r, const mukca_geometry *nominal)
{
    const mukca_dataset *data = r->data;
    const size_t n_joints = (size_t)r->chain->n_joints;
    mukca_gravity_load load;
    double g[3], axis[2][3];
    memcpy(g, r->chain->gravity, sizeof g);
    const int least = fabs(g[0]) <= fabs(g[1]) ? 0 : 1;
    *r->turned = *r->chain;
    const double e[3] = {least == 0, least == 1, 0};
    mukca_cross(axis[0], g, e);
    mukca_cross(axis[1], g, axis[0]);
    for (int k = 0; k < 2; k++) {
        for (int c = 0; c < 3; c++)
            r->turned->gravity[c] = axis[k][c] * mukca_norm3(g) / fmax(mukca_norm3(axis[k]), 1e-9);
        for (size_t row = 0; row < (size_t)data->n_rows && r->n_bodies; row++) {
            const double payload = r->payload_body >= 0 ? data->payload[row] : 0;
            mukca_chain_moments(&load, r->turned, nominal, data->q + row * n_joints, NULL,
                                isfinite(payload) ? payload : 0);
            for (size_t j = 0; j < n_joints; j++)
                r->across[2 * (row * n_joints + j) + (size_t)k] = load.torque[j];
            memcpy(r->across_base[row][k], load.base, sizeof load.base);
        }
    }
}

/* Scale n values by a factor and add them to their total. */
static void scale_into(double *total, double *x, size_t n, double factor)
{
    for (size_t i = 0; i < n; i++) {
        x[i] *= factor;
        total[i] += x[i];
    }
}

void mukca_recording_load(mukca_recording *r)
{
    const mukca_dataset *data = r->data;
    const size_t n_joints = (size_t)r->chain->n_joints, bodies = (size_t)r->n_bodies;
    mukca_geometry nominal;
    mukca_geometry_set(&nominal, r->chain, NULL);
    r->efforts_correlation = NAN;
    for (int row = 0; row < data->n_rows; row++)
        for (int a = 0; a < r->n_bodies; a++) body_moments(r, &nominal, row, a);
    load_across(r, &nominal);
    const double *given = r->options.mass_factor;
    for (size_t a = 0; a < sizeof r->mass_factor / sizeof *r->mass_factor; a++)
        r->mass_factor[a] = given ? given[a] : 1; /* test data may have a new payload */
    if (data->effort && bodies && !given) {
        r->efforts_correlation = correlate_efforts(r);
        if (r->efforts_correlation > LEAST_CORRELATION) estimate_masses(r);
    }
    r->have_moments = r->have_torques = bodies > 0;
    const size_t values = (size_t)data->n_rows * n_joints;
    memset(r->total_base, 0, sizeof *r->total_base * 3 * (size_t)data->n_rows);
    memset(r->total_torque, 0, sizeof *r->total_torque * values);
    memset(r->total_moment, 0, sizeof *r->total_moment * 3 * values);
    for (size_t row = 0; row < (size_t)data->n_rows; row++)
        for (size_t a = 0; a < bodies; a++) {
            const size_t at = row * bodies + a;
            const double factor = r->mass_factor[a];
            scale_into(r->total_base + 3 * row, r->base_moment + 3 * at, 3, factor);
            scale_into(r->total_torque + row * n_joints, r->torque + at * n_joints, n_joints,
                       factor);
            scale_into(r->total_moment + 3 * row * n_joints, r->moment + 3 * at * n_joints,
                       3 * n_joints, factor);
        }
    if (!bodies && data->effort) { /* no masses: measured torques serve effects about the axis */
        const double sign = r->options.turned_efforts ? -1 : 1;
        r->have_torques = true;
        for (size_t i = 0; i < values; i++)
            r->total_torque[i] = isfinite(data->effort[i]) ? sign * data->effort[i] : 0;
    }
}
