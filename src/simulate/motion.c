/* Runs of a moving arm with chosen effects. */
#include "simulate/motion.h"

#include <math.h>
#include <string.h>

#include "dynamics/inverse_dynamics.h"
#include "simulate/simulate.h"

enum { N = MUKCA_MAX_JOINTS, WAVES = 5, PROBES = 4000 };

/* Time from standstill to the full path, s, and a sliding joint's metre per radian of a turning
 * one: slides of arms are some times slower. */
static const double ramp = 1.5, slide = 0.3;

/* Parts of a joint's travel and of the largest velocity that a path uses. */
static const double travel = 0.9, slowest = 0.7;

static const double band = 1; /* Hz, highest frequency of a path */

/* Path of a run: middle[j] + g(t) sum of WAVES sines. */
typedef struct {
    double seconds, middle[N], frequency[WAVES], sine[N][WAVES], cosine[N][WAVES];
} path;

/* A joint's motion at one time. */
typedef struct {
    double t, q, dq, ddq, load; /* load: torque of the rigid body */
} moment;

/* ---- the catalogue ---- */

enum {
    PAYLOAD,
    LINK_MASS,
    LINK_CENTRE,
    ARMATURE,
    COULOMB,
    VISCOUS,
    STRIBECK,
    LOAD_FRICTION,
    ASYMMETRY,
    OFFSET,
    TORQUE_GAIN,
    DELAY,
    SPRING,
    COGGING,
    THERMAL_FRICTION,
    KINDS
};

/* Of one value, and of one or two values that are torques, with a variant. */
#define ONE(text, where, what, unit)                                   \
    {                                                                  \
        text, MUKCA_SIMULATED_##where, 1, 1, .value = { {what, unit} } \
    }
#define WITH(text, most, a, b, variant, unit, usual)                                               \
    {                                                                                              \
        text, MUKCA_SIMULATED_AT_JOINT, 1, most, false, {{a, "N*m"}, {b, "N*m"}}, {variant, unit}, \
            usual                                                                                  \
    }

const mukca_simulated_kind mukca_simulated_kinds[KINDS + 1] = {
    [PAYLOAD] = {"payload", MUKCA_SIMULATED_AT_TIP, 1, 4, .masses = true,
                 .value = {{"mass", "kg"}, {"x", "m"}, {"y", "m"}, {"z", "m"}}},
    [LINK_MASS] = {"link_mass", MUKCA_SIMULATED_AT_JOINT, 1, 1, .masses = true,
                   .value = {{"mass", "kg"}}},
    [LINK_CENTRE] = {"link_centre", MUKCA_SIMULATED_AT_JOINT, 3, 3, .masses = true,
                     .value = {{"x", "m"}, {"y", "m"}, {"z", "m"}}},
    [ARMATURE] = ONE("armature", AT_JOINT, "inertia", "kg*m^2"),
    [COULOMB] = ONE("coulomb", AT_JOINT, "torque", "N*m"),
    [VISCOUS] = ONE("viscous", AT_JOINT, "damping", "N*m*s/rad"),
    [STRIBECK] = WITH("stribeck", 1, "torque", NULL, "velocity", "rad/s", 0.1),
    [LOAD_FRICTION] = ONE("load_friction", AT_JOINT, "share", "1"),
    [ASYMMETRY] = ONE("asymmetry", AT_JOINT, "damping", "N*m*s/rad"),
    [OFFSET] = ONE("offset", AT_JOINT, "torque", "N*m"),
    [TORQUE_GAIN] = ONE("torque_gain", AT_ALL, "share", "1"),
    [DELAY] = ONE("delay", AT_ALL, "time", "s"),
    [SPRING] = {"spring", MUKCA_SIMULATED_AT_JOINT, 1, 2,
                .value = {{"stiffness", "N*m/rad"}, {"zero", "rad"}}},
    [COGGING] = WITH("cogging", 2, "sine", "cosine", "order", "1", 0),
    [THERMAL_FRICTION] = WITH("thermal_friction", 1, "torque", NULL, "time_constant", "s", 60)};

int mukca_simulated_kind_find(const char *name)
{
    for (int k = 0; k < KINDS; k++)
        if (strcmp(mukca_simulated_kinds[k].name, name) == 0) return k;
    return -1;
}

/* Torque that the drive spends on an effect; 0: of masses, or of the measured torque. */
static double added(const mukca_simulated_torque *e, const moment *at)
{
    const double sign = (at->dq > 0) - (at->dq < 0), v = e->variant;
    const double per_size[KINDS] = {[ARMATURE] = at->ddq,
                                    [COULOMB] = sign,
                                    [VISCOUS] = at->dq,
                                    [STRIBECK] = v > 0 ? sign * exp(-at->dq * at->dq / (v * v)) : 0,
                                    [LOAD_FRICTION] = sign * fabs(at->load),
                                    [ASYMMETRY] = fabs(at->dq),
                                    [OFFSET] = 1,
                                    [SPRING] = at->q - e->value[1],
                                    [COGGING] = sin(v * at->q),
                                    [THERMAL_FRICTION] = v > 0 ? sign * exp(-at->t / v) : 0};
    return e->value[0] * per_size[e->kind] +
           (e->kind == COGGING ? e->value[1] * cos(v * at->q) : 0);
}

/* Change the parameters p of all links by an effect of masses. */
static void change_masses(double *p, const mukca_simulated_torque *e,
                          const mukca_simulated_motion *motion)
{
    const mukca_chain *chain = motion->chain;
    double *link = p + MUKCA_INERTIAL * (e->joint < 0 ? chain->n_joints - 1 : e->joint), at[3];
    if (e->kind == PAYLOAD) { /* from the tip to the last link's frame */
        memcpy(at, e->value + 1, sizeof at);
        for (int k = chain->n_elements - 1; k > chain->joint_element[chain->n_joints - 1]; k--) {
            double R[9], turned[3];
            mukca_rotation_from_rpy(R, chain->element[k].rpy);
            mukca_mat3_vec(turned, R, at);
            for (int i = 0; i < 3; i++) at[i] = turned[i] + chain->element[k].xyz[i];
        }
        mukca_inertial_add(link, e->value[0], at, NULL);
    } else if (e->kind == LINK_MASS && link[0] > 0) { /* more of the same body */
        const double factor = 1 + e->value[0] / link[0];
        for (int i = 0; i < MUKCA_INERTIAL; i++) link[i] *= factor;
    } else if (e->kind == LINK_CENTRE && link[0] > 0) {
        const double kg = link[0];
        for (int i = 0; i < 3; i++) at[i] = link[1 + i] / kg;
        mukca_inertial_add(link, -kg, at, NULL);
        for (int i = 0; i < 3; i++) at[i] += e->value[i];
        mukca_inertial_add(link, kg, at, NULL);
    }
}

/* ---- path ---- */

/* Motion of joint j at a time of the run; before and after it the arm stands still. */
static moment path_at(const path *way, int j, double t)
{
    const double side = t < 0.5 * way->seconds ? 1 : -1;
    const double over = fmin(ramp, 0.5 * way->seconds);
    const double u = fmin(fmax((side > 0 ? t : way->seconds - t) / over, 0), 1), left = 1 - u;
    const double g = u * u * u * (10 - 15 * u + 6 * u * u); /* smooth to the second derivative */
    const double dg = side * 30 * u * u * left * left / over;
    const double ddg = 60 * u * left * (1 - 2 * u) / (over * over);
    double x = 0, dx = 0, ddx = 0;
    for (int k = 0; k < WAVES; k++) {
        const double w = 2 * M_PI * way->frequency[k], s = sin(w * t), c = cos(w * t);
        const double a = way->sine[j][k], b = way->cosine[j][k];
        x += a * s + b * c;
        dx += w * (a * c - b * s);
        ddx -= w * w * (a * s + b * c);
    }
    return (moment){.t = t,
                    .q = way->middle[j] + g * x,
                    .dq = g * dx + dg * x,
                    .ddq = g * ddx + 2 * dg * dx + ddg * x};
}

/* Draw a path within the limits of the joints and of the velocity. */
static void draw_path(path *way, const mukca_simulated_motion *motion, mukca_random *random)
{
    const mukca_chain *chain = motion->chain;
    *way = (path){.seconds = motion->seconds};
    for (int k = 0; k < WAVES; k++)
        way->frequency[k] = band * (k + mukca_random_uniform(random)) / WAVES;
    for (int j = 0; j < chain->n_joints; j++) {
        const mukca_element *e = &chain->element[chain->joint_element[j]];
        const bool slides = e->type == MUKCA_PRISMATIC;
        const double free = slides ? 0.5 : M_PI; /* of a joint without limits */
        const double lower = isinf(e->lower) ? -free : e->lower;
        const double upper = isinf(e->upper) ? free : e->upper;
        double farthest = 0, fastest = 0;
        for (int k = 0; k < WAVES; k++) {
            way->sine[j][k] = mukca_random_normal(random);
            way->cosine[j][k] = mukca_random_normal(random);
        }
        for (int i = 0; i < PROBES; i++) {
            const moment at = path_at(way, j, way->seconds * i / PROBES);
            farthest = fmax(farthest, fabs(at.q));
            fastest = fmax(fastest, fabs(at.dq));
        }
        const double fraction = slowest + (1 - slowest) * mukca_random_uniform(random);
        const double size = fmin(fraction * motion->speed * (slides ? slide : 1) / fastest,
                                 0.5 * travel * (upper - lower) / farthest);
        for (int k = 0; k < WAVES; k++) way->sine[j][k] *= size, way->cosine[j][k] *= size;
        const double margin = 0.5 * (upper - lower) - size * farthest;
        way->middle[j] =
            0.5 * (lower + upper) + travel * margin * (2 * mukca_random_uniform(random) - 1);
    }
}

/* ---- torques ---- */

typedef struct {
    const mukca_simulated_motion *motion;
    mukca_dynamics dynamics;
    double p[N * MUKCA_INERTIAL], range[N];
    mukca_random paths, noise;
    path way;
} state;

/* Torques of the true arm at a time of the run, which began at `start`. */
static void true_torques(double *torque, const state *s, double t, double start)
{
    const int n = s->dynamics.n_joints;
    double q[N], dq[N], ddq[N], rigid[N];
    for (int j = 0; j < n; j++) {
        const moment at = path_at(&s->way, j, t);
        q[j] = at.q, dq[j] = at.dq, ddq[j] = at.ddq;
    }
    mukca_dynamics_torque(rigid, &s->dynamics, s->p, q, dq, ddq);
    memcpy(torque, rigid, (size_t)n * sizeof *torque);
    for (int e = 0; e < s->motion->n_effects; e++) {
        const mukca_simulated_torque *effect = &s->motion->effects[e];
        const int j = effect->joint;
        if (j < 0) continue;
        torque[j] += added(effect, &(moment){start + t, q[j], dq[j], ddq[j], rigid[j]});
    }
}

/* Torques as measured, without noise: late, and with the gain of the sensors. */
static void measured_torques(double *torque, const state *s, double t, double start)
{
    double delay[N] = {0}, all[N], now = 0;
    const int n = s->dynamics.n_joints;
    for (int e = 0; e < s->motion->n_effects; e++) {
        const mukca_simulated_torque *effect = &s->motion->effects[e];
        for (int j = 0; j < n && effect->kind == DELAY; j++)
            if (effect->joint < 0 || effect->joint == j) delay[j] += effect->value[0];
    }
    true_torques(all, s, t, start);
    for (int j = 0; j < n; j++) {
        if (delay[j] != now) true_torques(all, s, t - delay[j], start);
        now = delay[j];
        torque[j] = all[j];
    }
    for (int e = 0; e < s->motion->n_effects; e++) {
        const mukca_simulated_torque *effect = &s->motion->effects[e];
        for (int j = 0; j < n && effect->kind == TORQUE_GAIN; j++)
            if (effect->joint < 0 || effect->joint == j) torque[j] *= 1 + effect->value[0];
    }
}

/* Half of the range of each joint's torque on the path. */
static void find_ranges(state *s)
{
    const int n = s->dynamics.n_joints;
    double least[N], most[N], torque[N];
    for (int i = 0; i < PROBES; i++) {
        measured_torques(torque, s, s->way.seconds * i / PROBES, 0);
        for (int j = 0; j < n; j++) {
            least[j] = i ? fmin(least[j], torque[j]) : torque[j];
            most[j] = i ? fmax(most[j], torque[j]) : torque[j];
            s->range[j] = 0.5 * (most[j] - least[j]);
        }
    }
}

/* Write the rows of a run that begins at `start`. */
static mukca_status write_run(state *s, double start, mukca_motion_writer *write, void *context)
{
    const mukca_simulated_motion *m = s->motion;
    const long rows = (long)(m->seconds * m->rate) + 1;
    for (long r = 0; r < rows; r++) {
        const double t = (double)r / m->rate;
        double q[N], effort[N];
        if (m->interrupted && m->interrupted()) return MUKCA_INTERRUPTED;
        measured_torques(effort, s, t, start);
        for (int j = 0; j < m->chain->n_joints; j++) {
            q[j] = path_at(&s->way, j, t).q;
            effort[j] += m->noise * s->range[j] * mukca_random_normal(&s->noise);
        }
        write(context, start + t, q, effort);
    }
    return MUKCA_OK;
}

mukca_status mukca_simulate_motion(const mukca_simulated_motion *motion, mukca_motion_writer *write,
                                   void *context)
{
    state s = {.motion = motion};
    mukca_dynamics_set(&s.dynamics, motion->chain);
    mukca_dynamics_inertials(s.p, motion->chain);
    for (int e = 0; e < motion->n_effects; e++) change_masses(s.p, &motion->effects[e], motion);
    mukca_simulate_seed(&s.paths, motion->seed, MUKCA_DRAW_POSTURES);
    mukca_simulate_seed(&s.noise, motion->seed, MUKCA_DRAW_NOISE);
    for (int run = 0; run < motion->runs; run++) {
        draw_path(&s.way, motion, &s.paths);
        if (run == 0) find_ranges(&s);
        MUKCA_TRY(write_run(&s, run * (motion->seconds + MUKCA_RUN_PAUSE), write, context));
    }
    return MUKCA_OK;
}
