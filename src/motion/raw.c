/* Raw columns of a joint's torque, row by row. */
#include "motion/raw.h"

#include <math.h>
#include <string.h>

/* Velocities at which friction at low speed has decayed, rad/s: greased gears from 0.07 to 0.4, and
 * reversals within the resolution of an encoder. */
#define FIRST_DECAY 0.0707
static const double reversal[2] = {0.025, 0.06};
/* Time by which the reversal of friction is late for a coefficient of 1, s. */
#define REVERSAL_TIME 0.01
/* Half of the step of the logarithms of time constants and velocities, which is that of the root of
 * 2: what is nonlinear within it is 1.5 % of the amplitude. */
#define BETWEEN 0.17
/* Uncertainty of the exponent of Stribeck's curve, 2: between 0.5 and 2 (Armstrong-Helouvry 1991).
 */
#define EXPONENT 0.5
/* Acceleration below which a reversal has no direction, rad/s^2: standstill. */
#define REVERSAL_ACCELERATION 0.1

/* Weights of a piecewise linear function with `n` equidistant knots on [low, high]. */
static void put_hats(double *x, int n, double at, double low, double high, double factor)
{
    const double u = fmin(fmax((at - low) / (high - low), 0), 1) * (n - 1);
    const int k = u < n - 1 ? (int)u : n - 2;
    memset(x, 0, sizeof *x * (size_t)n);
    x[k] = factor * (k + 1 - u);
    x[k + 1] = factor * (u - k);
}

static void put_waves(double *x, double angle)
{
    const double c = cos(angle), s = sin(angle);
    x[0] = c, x[1] = s;
    for (int k = 1; k < MUKCA_ORDERS; k++) {
        x[2 * k] = c * x[2 * k - 2] - s * x[2 * k - 1];
        x[2 * k + 1] = s * x[2 * k - 2] + c * x[2 * k - 1];
    }
}

static void put_velocity(double *x, const mukca_stretch *s, int n, int at, int j)
{
    const double v = s->dq[at + j], sign = tanh(v / MUKCA_SIGN_VELOCITY);
    x[MUKCA_RAW_ONE] = 1;
    x[MUKCA_RAW_SIGN] = sign;
    for (int k = 0; k < MUKCA_SLOWS; k++) {
        const double u = fabs(v) / FIRST_DECAY * exp2(-0.5 * k), decayed = sign * exp(-u * u);
        double *slow = x + MUKCA_RAW_SLOW + k;
        slow[0] = decayed;
        slow[MUKCA_SLOWS] = BETWEEN * 2 * u * u * decayed;
        slow[2 * MUKCA_SLOWS] = -EXPONENT * u * u * log(u + 1e-9) * decayed;
    }
    /* early or late by a time, or by a velocity: a gear winds up, a model of friction is soft */
    x[MUKCA_RAW_REVERSAL] =
        (1 - sign * sign) / MUKCA_SIGN_VELOCITY * s->ddq[at + j] * REVERSAL_TIME;
    for (int k = 0; k < 2; k++) {
        const double near = exp(-v * v / (reversal[k] * reversal[k]));
        x[MUKCA_RAW_REVERSAL + 1 + k] = tanh(s->ddq[at + j] / REVERSAL_ACCELERATION) * near;
        x[MUKCA_RAW_REVERSAL + 3 + k] = sign * near;
    }
    memcpy(x + MUKCA_RAW_PLAY, s->play + (at + j) * MUKCA_PLAYS, sizeof *x * MUKCA_PLAYS);
    x[MUKCA_RAW_VELOCITY] = v;
    x[MUKCA_RAW_SPEED] = fabs(v);
    x[MUKCA_RAW_ACCELERATION] = s->ddq[at + j];
    for (int side = 0; side < 2; side++) {
        const int other = side ? j + 1 : j - 1;
        const bool is = other >= 0 && other < n;
        const double w = is ? s->dq[at + other] : 0;
        double *beside = x + MUKCA_RAW_BESIDE + 4 * side;
        beside[0] = w;
        for (int k = -1; k < 2; k++) /* a motor of a coupled wrist turns with both */
            beside[2 + k] = is ? tanh((w + k * v) / MUKCA_SIGN_VELOCITY) : 0;
        x[MUKCA_RAW_ACCELERATION + 1 + side] = is ? s->ddq[at + other] : 0;
    }
}

void mukca_raw_fill(double *x, int ld, const mukca_raw_model *m, const mukca_raw_block *block,
                    int j)
{
    const mukca_stretch *s = block->stretch;
    const double *Y = block->Y;
    const mukca_signals *signals = m->signals;
    const int n = signals->n_joints, rigid = MUKCA_INERTIAL * (n - j);
    const double fastest = fmax(signals->fastest[j], 1e-9), end = fmax(signals->end, 1e-9);
    for (int i = block->first; i < block->last; i++, x += ld, Y += n * n * MUKCA_INERTIAL) {
        const int at = i * n;
        const double t = s->start + i * signals->dt, *own = Y + (j * n + j) * MUKCA_INERTIAL;
        double torque = 0, load = 0, *local = x + rigid;
        memcpy(x, own, sizeof *x * (size_t)rigid);
        for (int p = 0; p < rigid; p++) {
            torque += own[p] * m->inertial[j * MUKCA_INERTIAL + p];
            load += own[p] * m->load[j * MUKCA_INERTIAL + p];
        }
        put_velocity(local, s, n, at, j);
        const double sign = local[MUKCA_RAW_SIGN], v = s->dq[at + j];
        local[MUKCA_RAW_DRAG] = v * fabs(v) / fastest;
        local[MUKCA_RAW_DRAG + 1] = v * v * v / (fastest * fastest);
        const double still = fabs(block->gravity[(i - block->first) * n + j]);
        local[MUKCA_RAW_LOAD] = 0.5 * sign * (fabs(load) + still);
        local[MUKCA_RAW_LOAD + 1] = 0.5 * sign * (fabs(load) - still);
        local[MUKCA_RAW_LOAD + 2] = sign * load * load / signals->range[j];
        local[MUKCA_RAW_LOAD + 3] = v * fabs(load) / fastest;
        local[MUKCA_RAW_MODEL] = torque;
        local[MUKCA_RAW_MODEL + 1] = torque * fabs(torque) / signals->range[j];
        local[MUKCA_RAW_ANGLE] = s->q[at + j] - 0.5 * (signals->low[j] + signals->high[j]);
        put_waves(local + MUKCA_RAW_WAVE, s->q[at + j]);
        put_hats(local + MUKCA_RAW_CURVE, MUKCA_HATS, v, -fastest, fastest, 1);
        put_hats(local + MUKCA_RAW_TIME, MUKCA_HATS, t, 0, end, 1);
        put_hats(local + MUKCA_RAW_BURST, MUKCA_BURSTS, t, 0, end, 1);
        put_hats(local + MUKCA_RAW_DRIFT, MUKCA_HATS, t, 0, end, sign);
        /* 2 to 1/8 of the recording, and the derivative by the logarithm */
        for (int k = 0; k < MUKCA_WARMINGS; k++) {
            const double u = t / (2 * end) * exp2(0.5 * k);
            local[MUKCA_RAW_WARMING + k] = sign * exp(-u);
            local[MUKCA_RAW_WARMING + MUKCA_WARMINGS + k] = BETWEEN * sign * u * exp(-u);
        }
        for (int k = 0; k < MUKCA_SHIFTS; k++) {
            int from = i + (k - MUKCA_SHIFTS / 2) * m->shift;
            from = from < 0 ? 0 : from >= s->n ? s->n - 1 : from;
            local[MUKCA_RAW_TORQUE + k] = s->torque[from * n + j];
        }
    }
}

void mukca_raw_interpolate(double value[MUKCA_SHIFTS], double slope[MUKCA_SHIFTS], double x)
{
    for (int k = 0; k < MUKCA_SHIFTS; k++) {
        value[k] = 1, slope[k] = 0;
        for (int i = 0; i < MUKCA_SHIFTS; i++) {
            if (i == k) continue;
            const int shift = i - MUKCA_SHIFTS / 2;
            const double u = (x - shift) / (k - i);
            slope[k] = slope[k] * u + value[k] / (k - i);
            value[k] *= u;
        }
    }
}

const double *mukca_drives_of(const mukca_drives *d, int effect)
{
    if (effect == MUKCA_MOTION_COULOMB) return d->coulomb;
    if (effect == MUKCA_MOTION_VISCOUS) return d->viscous;
    return effect == MUKCA_MOTION_ARMATURE ? d->armature : NULL;
}

void mukca_raw_nominal(double *torque, const mukca_raw_model *m, const mukca_drives *d, int j)
{
    const int n = m->signals->n_joints;
    memset(torque, 0, sizeof *torque * (size_t)mukca_raw_width(n, j));
    for (int p = 0; p < MUKCA_INERTIAL * (n - j); p++)
        torque[p] = m->inertial[j * MUKCA_INERTIAL + p];
    torque[mukca_raw_local(n, j, MUKCA_RAW_SIGN)] = d->coulomb[j];
    torque[mukca_raw_local(n, j, MUKCA_RAW_VELOCITY)] = d->viscous[j];
    torque[mukca_raw_local(n, j, MUKCA_RAW_ACCELERATION)] = d->armature[j];
}
