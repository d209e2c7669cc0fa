/* Gravity's moments in each row of a recording, by body, and mass factors from measured efforts. */
#include <math.h>
#include <string.h>

#include "diagnose/recording.h"
#include "math/dense.h"

/* Assumed: noise of one measured effort, N m, friction included; and how far a mass may be off what
 * the model says, relative (the default mass_spread). */
#define EFFORT_SIGMA 0.15
#define MASS_SIGMA 0.1
/* Efforts below this cosine with the modelled torques are no holding torques (currents, other
 * signs): they say nothing about the masses. */
#define LEAST_CORRELATION 0.5

static double *torques(const mukca_recording *recording, int row, int body)
{
    return recording->torque + ((size_t)row * (size_t)recording->n_bodies + (size_t)body) *
                                   (size_t)recording->chain->n_joints;
}

/* Ridge estimate of each body's mass factor from measured efforts. */
static void estimate_masses(mukca_recording *recording)
{
    const int k = recording->n_bodies, n_joints = recording->chain->n_joints;
    double normal[MUKCA_MAX_ELEMENTS][MUKCA_MAX_ELEMENTS] = {{0}}, right[MUKCA_MAX_ELEMENTS] = {0};
    const double weight = 1 / (EFFORT_SIGMA * EFFORT_SIGMA), prior = 1 / (MASS_SIGMA * MASS_SIGMA);
    for (int row = 0; row < recording->data->n_rows; row++)
        for (int j = 0; j < n_joints; j++) {
            const double effort = recording->data->effort[row * n_joints + j];
            if (!isfinite(effort)) continue;
            for (int a = 0; a < k; a++) {
                const double torque = torques(recording, row, a)[j];
                right[a] += weight * torque * effort;
                for (int b = 0; b <= a; b++)
                    normal[a][b] += weight * torque * torques(recording, row, b)[j];
            }
        }
    for (int a = 0; a < k; a++) right[a] += prior, normal[a][a] += prior;
    for (int a = 0; a < k; a++) { /* Cholesky and both substitutions on a small dense system */
        for (int b = 0; b <= a; b++) {
            double sum = normal[a][b];
            for (int c = 0; c < b; c++) sum -= normal[a][c] * normal[b][c];
            if (a == b)
                normal[a][a] = sqrt(fmax(sum, 1e-12));
            else
                normal[a][b] = sum / normal[b][b];
        }
    }
    for (int a = 0; a < k; a++) {
        for (int c = 0; c < a; c++) right[a] -= normal[a][c] * right[c];
        right[a] /= normal[a][a];
    }
    for (int a = k - 1; a >= 0; a--) {
        for (int c = a + 1; c < k; c++) right[a] -= normal[c][a] * right[c];
        right[a] /= normal[a][a];
        recording->mass_factor[a] = fmin(fmax(right[a], 0.3), 3.0);
    }
}

/* Cosine of measured and modelled holding torques; NaN without efforts. */
static double correlate_efforts(const mukca_recording *recording)
{
    const int n_joints = recording->chain->n_joints;
    double agree = 0, efforts = 0, modelled = 0;
    for (int row = 0; row < recording->data->n_rows; row++)
        for (int j = 0; j < n_joints; j++) {
            double torque = 0;
            for (int a = 0; a < recording->n_bodies; a++) torque += torques(recording, row, a)[j];
            const double effort = recording->data->effort[row * n_joints + j];
            if (!isfinite(effort)) continue;
            agree += torque * effort;
            efforts += effort * effort;
            modelled += torque * torque;
        }
    return efforts > 0 && modelled > 0 ? agree / sqrt(efforts * modelled) : (double)NAN;
}

/* Moments of one body in one row, at the nominal geometry. */
static void body_moments(mukca_recording *recording, const mukca_geometry *nominal, int row,
                         int body)
{
    const mukca_chain *chain = recording->chain;
    const mukca_dataset *data = recording->data;
    const size_t n_joints = (size_t)chain->n_joints,
                 at = (size_t)row * (size_t)recording->n_bodies + (size_t)body;
    const int element = recording->body_element[body];
    const bool loaded =
        element == chain->n_elements - 1 && data->payload && isfinite(data->payload[row]);
    double scale[MUKCA_MAX_MASSES];
    for (int i = 0; i < chain->n_masses; i++) scale[i] = chain->mass[i].element == element;
    mukca_gravity_load load;
    mukca_chain_moments(&load, chain, nominal, data->q + (size_t)row * n_joints, scale,
                        loaded ? data->payload[row] : 0);
    memcpy(recording->moment + 3 * at * n_joints, load.moment, n_joints * sizeof *load.moment);
    memcpy(recording->torque + at * n_joints, load.torque, n_joints * sizeof *load.torque);
    memcpy(recording->base_moment + 3 * at, load.base, sizeof load.base);
}

/* Scale n values by a factor and add them to their total. */
static void scale_into(double *total, double *x, size_t n, double factor)
{
    for (size_t i = 0; i < n; i++) {
        x[i] *= factor;
        total[i] += x[i];
    }
}

void mukca_recording_load(mukca_recording *recording)
{
    const mukca_dataset *data = recording->data;
    const size_t n_joints = (size_t)recording->chain->n_joints,
                 bodies = (size_t)recording->n_bodies;
    mukca_geometry nominal;
    mukca_geometry_set(&nominal, recording->chain, NULL);
    recording->efforts_correlation = NAN;
    for (int row = 0; row < data->n_rows; row++)
        for (int a = 0; a < recording->n_bodies; a++) body_moments(recording, &nominal, row, a);
    for (size_t a = 0; a < bodies; a++)
        recording->mass_factor[a] =
            recording->options.mass_factor ? recording->options.mass_factor[a] : 1;
    if (data->effort && bodies && !recording->options.mass_factor) {
        recording->efforts_correlation = correlate_efforts(recording);
        if (recording->efforts_correlation > LEAST_CORRELATION) estimate_masses(recording);
    }
    recording->have_moments = recording->have_torques = bodies > 0;
    for (size_t row = 0; row < (size_t)data->n_rows; row++)
        for (size_t a = 0; a < bodies; a++) {
            const size_t at = row * bodies + a;
            const double factor = recording->mass_factor[a];
            scale_into(recording->total_base + 3 * row, recording->base_moment + 3 * at, 3, factor);
            scale_into(recording->total_torque + row * n_joints, recording->torque + at * n_joints,
                       n_joints, factor);
            scale_into(recording->total_moment + 3 * row * n_joints,
                       recording->moment + 3 * at * n_joints, 3 * n_joints, factor);
        }
    if (!bodies && data->effort) { /* no masses: measured torque serves what acts about the axis */
        recording->have_torques = true;
        for (size_t i = 0; i < (size_t)data->n_rows * n_joints; i++)
            recording->total_torque[i] = isfinite(data->effort[i]) ? data->effort[i] : 0;
    }
}
