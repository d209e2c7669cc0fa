/* Cartesian impedance control with the corrected arm: from joint states to torques, over LCM.
 *
 *     build/examples/example_impedance offsets.tsv --torque 110,110,70,70,30,30,15
 *
 * The law of Franzese et al. (arXiv 2503.12584):
 *     tau = J'(K (x_goal - Phi(q)) - D J dq/dt + I) + N (K_q (q_goal - q) - D_q dq/dt)
 * with Phi of the table (geometry and effects), J of its geometry (the effects change J by less
 * than 1e-3), I the integral of K (x_goal - Phi(q)) while the goal asks for it, and N the projector
 * onto the null space of J. The arm's driver adds the torques of gravity and Coriolis forces.
 *
 * Goals are impedance.goal messages on IMPEDANCE_GOAL (tools/closed_loop/types).  Before the first
 * goal it commands no torque.  On stale joint states, a goal out of limits or the table of another
 * arm it goes limp: it sends a last command of zero torque, prints the reason, and exits with code
 * 1.
 *
 * Links libmukca_core.a, LCM and libm.
 */
#include <lcm/lcm.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "mukca/corrected.h"
#include "mukca/row_state.h"

enum { N_MAX = MUKCA_MAX_JOINTS, BINS = 1000 };

/* Fingerprints as lcm-gen computes them. */
#define STATUS_FINGERPRINT 0xf16fb804284abca3u  /* drake.lcmt_iiwa_status */
#define COMMAND_FINGERPRINT 0xddc7c7738c815334u /* drake.lcmt_iiwa_command */
#define GOAL_FINGERPRINT 0xdbb3300ea2118a77u    /* impedance.goal */

/* The paper's stiffness: N/m in x, y, z, N m/rad about them; damping 2 sqrt(K). */
static const double stiffness[6] = {15000, 15000, 2000, 40, 40, 40};
#define NULL_STIFFNESS 10.0 /* N m/rad; damping 2 sqrt of it, N m s/rad */
#define INTEGRAL_TIME 1.0   /* s, time constant of the integral term: a fifth of its 5 s */
#define MAX_INTEGRAL 40.0   /* N: friction of some N m, lever arms of some 0.1 m */
#define MAX_FORCE 100.0     /* N, of the spring */
#define MAX_TORQUE_RATE 1.0 /* N m per cycle: 1000 N m/s at 1 kHz, as arms of this size allow */
#define MAX_SPEED 0.25      /* m/s, of a goal: ISO 10218-1, reduced speed */
#define MAX_STEP 0.5        /* m, from the previous goal */
#define LIMIT_MARGIN \
    0.1 /* rad beyond the model's joint limits: calibrated zeros, not another arm */
#define ANGULAR_LENGTH 0.1 /* m/rad: duration of rotations */

typedef struct {
    double taught[N_MAX], posture[N_MAX], offset[3], speed;
    bool compensate;
} goal_message;

typedef struct {
    mukca_corrected arm;
    mukca_row_state recent;
    int n;
    double torque_limit[N_MAX], stale;
    bool lock_step;
    /* Goal: motion of the tip from `from` to `to`. */
    bool has_goal, compensate;
    mukca_frame from, to, at;
    double turn[3], share, share_rate;
    double posture[N_MAX];
    /* State. */
    bool heard;
    int64_t utime;
    double integral[6], torque[N_MAX];
    /* Run time of the control law, 0.1 us per bin. */
    long cycles, bins[BINS];
    double longest;
    lcm_t *lcm;
    char limp[200]; /* reason; empty: in control */
} controller;

static volatile sig_atomic_t interrupted;

static void on_signal(int number)
{
    (void)number;
    interrupted = 1;
}

static void __attribute__((format(printf, 2, 3))) go_limp(controller *c, const char *format, ...)
{
    if (c->limp[0]) return;
    va_list list;
    va_start(list, format);
    vsnprintf(c->limp, sizeof c->limp, format, list);
    va_end(list);
}

/* ---- encoding: big-endian, fields in order ---- */

typedef struct {
    const unsigned char *at, *end;
    bool good;
} reader;

static uint64_t take(reader *r, int bytes)
{
    uint64_t value = 0;
    if (r->end - r->at < bytes) r->good = false;
    for (int i = 0; r->good && i < bytes; i++) value = value << 8 | *r->at++;
    return value;
}

static void take_doubles(double *to, reader *r, int n)
{
    for (int i = 0; i < n; i++) {
        const uint64_t bits = take(r, 8);
        if (to) memcpy(&to[i], &bits, sizeof bits);
        if (to && !isfinite(to[i])) r->good = false;
    }
}

static unsigned char *put(unsigned char *at, uint64_t value, int bytes)
{
    for (int i = bytes - 1; i >= 0; i--) *at++ = (unsigned char)(value >> (8 * i));
    return at;
}

static void send_command(controller *c)
{
    unsigned char message[8 + 8 + 4 + 4 + 8 * N_MAX], *at = message;
    at = put(at, COMMAND_FINGERPRINT, 8);
    at = put(at, (uint64_t)c->utime, 8);
    at = put(at, 0, 4); /* no positions: torque mode */
    at = put(at, (uint64_t)c->n, 4);
    for (int j = 0; j < c->n; j++) {
        uint64_t bits;
        memcpy(&bits, &c->torque[j], sizeof bits);
        at = put(at, bits, 8);
    }
    if (lcm_publish(c->lcm, "IIWA_COMMAND", message, (unsigned)(at - message)) != 0)
        go_limp(c, "cannot send a command");
}

/* ---- the control law: no allocation ---- */

/* x = A^-1 b for a symmetric positive definite A[6][6], which is overwritten (Cholesky). */
static void solve6(double x[6], double A[6][6], const double b[6])
{
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = A[i][j];
            for (int k = 0; k < j; k++) sum -= A[i][k] * A[j][k];
            A[i][j] = i == j ? sqrt(sum) : sum / A[j][j];
        }
        x[i] = b[i];
        for (int k = 0; k < i; k++) x[i] -= A[i][k] * x[k];
        x[i] /= A[i][i];
    }
    for (int i = 5; i >= 0; i--) {
        for (int k = i + 1; k < 6; k++) x[i] -= A[k][i] * x[k];
        x[i] /= A[i][i];
    }
}

/* tau += N tau0, N = 1 - J'(J J')^-1 J: no force at the tip. */
static void add_null_space(double *tau, const double *J, const double *tau0, int n)
{
    double A[6][6], b[6], x[6];
    for (int i = 0; i < 6; i++) {
        b[i] = 0;
        for (int k = 0; k < n; k++) b[i] += J[i * n + k] * tau0[k];
        for (int j = 0; j < 6; j++) {
            A[i][j] = i == j ? 1e-6 : 0; /* m^2: regularisation where J loses rank */
            for (int k = 0; k < n; k++) A[i][j] += J[i * n + k] * J[j * n + k];
        }
    }
    solve6(x, A, b);
    for (int k = 0; k < n; k++) {
        tau[k] += tau0[k];
        for (int i = 0; i < 6; i++) tau[k] -= J[i * n + k] * x[i];
    }
}

/* Advance the goal along its path; dt in s. */
static void advance(controller *c, double dt)
{
    double R[9];
    c->share = fmin(1, c->share + c->share_rate * dt);
    for (int i = 0; i < 3; i++) c->at.p[i] = c->from.p[i] + c->share * (c->to.p[i] - c->from.p[i]);
    const double w[3] = {c->share * c->turn[0], c->share * c->turn[1], c->share * c->turn[2]};
    mukca_rotation_exp(R, w);
    mukca_mat3_mul(c->at.R, R, c->from.R);
}

/* Wrench of spring, damper and integral term at the tip. */
static void wrench(double F[6], controller *c, const mukca_frame *tip, const double velocity[6],
                   double dt)
{
    double error[6];
    for (int i = 0; i < 3; i++) error[i] = c->at.p[i] - tip->p[i];
    mukca_rotation_difference(error + 3, c->at.R, tip->R);
    for (int i = 0; i < 6; i++) {
        const double spring = fmin(fmax(stiffness[i] * error[i], -MAX_FORCE), MAX_FORCE);
        if (c->compensate)
            c->integral[i] = fmin(fmax(c->integral[i] + spring * dt / INTEGRAL_TIME, -MAX_INTEGRAL),
                                  MAX_INTEGRAL);
        F[i] = spring + c->integral[i] - 2 * sqrt(stiffness[i]) * velocity[i];
    }
}

/* Limit torques and their rates; a torque beyond its limit scales all torques, which preserves the
 * direction. */
static void limit(controller *c, const double *wanted)
{
    double scale = 1;
    for (int j = 0; j < c->n; j++) {
        if (!isfinite(wanted[j])) {
            go_limp(c, "the control law gave no number");
            return;
        }
        scale = fmin(scale, c->torque_limit[j] / fmax(fabs(wanted[j]), 1e-9));
    }
    for (int j = 0; j < c->n; j++) {
        const double change = scale * wanted[j] - c->torque[j];
        c->torque[j] += fmin(fmax(change, -MAX_TORQUE_RATE), MAX_TORQUE_RATE);
    }
}

/* Compute torques for q[n], v[n], dt s after the previous state. */
static void control(controller *c, const double *q, const double *v, double dt)
{
    double J[6 * N_MAX], velocity[6] = {0}, F[6], tau[N_MAX] = {0}, posture[N_MAX];
    mukca_frame tip;
    const mukca_row_reading reading = {
        .q = q, .time = 1e-6 * (double)c->utime, .payload_kg = 0, .placement = -1};
    const mukca_joint_state *state = mukca_row_state_next(&c->recent, &reading);
    if (!c->has_goal) return;
    mukca_corrected_pose(&tip, &c->arm, q, state);
    mukca_fk_jacobian(J, NULL, &c->arm.geometry, q, NULL);
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < c->n; j++) velocity[i] += J[i * c->n + j] * v[j];
    advance(c, dt);
    wrench(F, c, &tip, velocity, dt);
    for (int j = 0; j < c->n; j++) {
        for (int i = 0; i < 6; i++) tau[j] += J[i * c->n + j] * F[i];
        posture[j] = NULL_STIFFNESS * (c->posture[j] - q[j]) - 2 * sqrt(NULL_STIFFNESS) * v[j];
    }
    add_null_space(tau, J, posture, c->n);
    limit(c, tau);
}

/* ---- messages ---- */

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void on_status(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    (void)channel;
    controller *c = user;
    const unsigned char *data = buffer->data;
    reader r = {data, data + buffer->data_size, true};
    double q[N_MAX], v[N_MAX];
    if (c->limp[0] || take(&r, 8) != STATUS_FINGERPRINT) return;
    const int64_t utime = (int64_t)take(&r, 8);
    const uint64_t n = take(&r, 4);
    if (n != (uint64_t)c->n) {
        go_limp(c, "the joint states have %d joints, the table has %d: the table of another arm",
                (int)n, c->n);
        return;
    }
    take_doubles(q, &r, c->n);
    take_doubles(v, &r, c->n);
    if (!r.good) {
        go_limp(c, "a joint state is cut short or not finite");
        return;
    }
    if (c->heard && utime == c->utime) { /* lock-step: repeated request */
        send_command(c);
        return;
    }
    const double dt = c->heard ? 1e-6 * (double)(utime - c->utime) : 0;
    if (!(dt >= 0 && dt <= c->stale)) {
        go_limp(c, "%.0f ms without joint states, at most %.0f allowed", 1e3 * dt, 1e3 * c->stale);
        return;
    }
    for (int j = 0; j < c->n; j++) {
        const mukca_element *e = &c->arm.chain.element[c->arm.chain.joint_element[j]];
        if (q[j] >= e->lower - LIMIT_MARGIN && q[j] <= e->upper + LIMIT_MARGIN) continue;
        go_limp(c, "%s is at %.3f rad, outside the table's limits: the table of another arm",
                e->name, q[j]);
        return;
    }
    c->heard = true;
    c->utime = utime;
    const double start = now();
    control(c, q, v, dt);
    const double us = 1e6 * (now() - start);
    c->cycles++;
    c->bins[us < 0.1 * BINS ? (int)(10 * us) : BINS - 1]++;
    c->longest = fmax(c->longest, us);
    if (!c->limp[0]) send_command(c);
}

static bool within(const controller *c, const double *q)
{
    for (int j = 0; j < c->n; j++) {
        const mukca_element *e = &c->arm.chain.element[c->arm.chain.joint_element[j]];
        if (!(q[j] >= e->lower - LIMIT_MARGIN && q[j] <= e->upper + LIMIT_MARGIN)) return false;
    }
    return true;
}

/* Start the motion to a goal; false: out of limits. */
static bool set_goal(controller *c, const goal_message *goal)
{
    if (!within(c, goal->taught) || !within(c, goal->posture) ||
        !(goal->speed > 0 && goal->speed <= MAX_SPEED))
        return false;
    mukca_frame to;
    mukca_corrected_pose(&to, &c->arm, goal->taught, NULL);
    for (int i = 0; i < 3; i++) to.p[i] += goal->offset[i];
    if (!c->has_goal) mukca_corrected_pose(&c->at, &c->arm, c->recent.q, &c->recent.state);
    const double distance = mukca_distance3(to.p, c->at.p);
    if (!(distance <= MAX_STEP)) return false;
    c->from = c->at;
    c->to = to;
    mukca_rotation_difference(c->turn, to.R, c->from.R);
    c->share = 0;
    c->share_rate = goal->speed / fmax(1e-6, fmax(distance, ANGULAR_LENGTH * mukca_norm3(c->turn)));
    memcpy(c->posture, goal->posture, sizeof c->posture);
    c->compensate = goal->compensate;
    c->has_goal = true;
    return true;
}

static void on_goal(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    (void)channel;
    controller *c = user;
    const unsigned char *data = buffer->data;
    reader r = {data, data + buffer->data_size, true};
    goal_message goal;
    if (c->limp[0] || take(&r, 8) != GOAL_FINGERPRINT) return;
    take(&r, 8);
    if (take(&r, 4) != (uint64_t)c->n) r.good = false;
    take_doubles(goal.taught, &r, r.good ? c->n : 0);
    take_doubles(goal.posture, &r, r.good ? c->n : 0);
    take_doubles(goal.offset, &r, 3);
    take_doubles(&goal.speed, &r, 1);
    goal.compensate = take(&r, 1) != 0;
    if (!c->heard) return; /* not before the first joint state */
    if (!r.good || !set_goal(c, &goal))
        go_limp(c,
                "a goal is out of limits: %d joints within theirs, at most %g m away, "
                "at most %g m/s",
                c->n, MAX_STEP, MAX_SPEED);
}

/* ---- the program ---- */

/* Run until interrupted or limp. */
static void serve(controller *c)
{
    while (!interrupted && !c->limp[0]) {
        const bool wait = c->lock_step || !c->heard;
        const int got = lcm_handle_timeout(c->lcm, wait ? 200 : (int)(1e3 * c->stale));
        if (got < 0 && !interrupted) go_limp(c, "LCM ended");
        if (got == 0 && !wait) go_limp(c, "no joint state for %.0f ms", 1e3 * c->stale);
    }
    memset(c->torque, 0, sizeof c->torque);
    send_command(c);
}

/* Quantile `share` of the cycles' run time, us. */
static double within_time(const controller *c, double share)
{
    long seen = 0;
    int bin = 0;
    while (bin < BINS - 1 && (double)(seen += c->bins[bin]) < share * (double)c->cycles) bin++;
    return 0.1 * (bin + 1);
}

static void report(const controller *c)
{
    fprintf(stderr, "%ld cycles; control law: median %.1f us, 99.9 %% %.1f us, longest %.1f us\n",
            c->cycles, within_time(c, 0.5), within_time(c, 0.999), c->longest);
    if (c->limp[0]) fprintf(stderr, "limp: %s\n", c->limp);
}

static void usage(const char *program)
{
    fprintf(stderr,
            "usage: %s OFFSETS --torque N_M,... [--nominal] [--robot NAME] [--urdf-sha256 HEX]\n"
            "       [--stale S] [--lock-step] [--url URL]\n"
            "--torque        limits of the joints, N m\n"
            "--nominal       the table's nominal geometry, without effects\n"
            "--robot, --urdf-sha256   refuse the table of another arm\n"
            "--stale         longest time without joint states (default: 0.01)\n"
            "--lock-step     wait for joint states; only their own time counts\n",
            program);
    exit(MUKCA_USAGE);
}

/* Load the table and check its arm. */
static mukca_status load(controller *c, const char *path, const char *robot, const char *sha256,
                         bool nominal, mukca_error *error)
{
    mukca_status status = mukca_corrected_load(&c->arm, path, error);
    if (status != MUKCA_OK) return status;
    const mukca_chain *chain = &c->arm.chain;
    if ((robot && strcmp(robot, chain->robot) != 0) ||
        (sha256 && strcmp(sha256, chain->urdf_sha256) != 0)) {
        error->status = MUKCA_INPUT;
        snprintf(error->text, sizeof error->text, "%s: the table of another arm: %s, URDF %.12s...",
                 path, chain->robot, chain->urdf_sha256);
        return MUKCA_INPUT;
    }
    if (nominal) {
        mukca_geometry_set(&c->arm.geometry, chain, NULL);
        c->arm.n_effects = 0;
    }
    c->n = chain->n_joints;
    mukca_row_state_stream(&c->recent, c->n);
    return MUKCA_OK;
}

int main(int argc, char **argv)
{
    static controller c; /* some 50 kB */
    const char *path = NULL, *robot = NULL, *sha256 = NULL, *url = NULL, *torque = NULL;
    bool nominal = false;
    mukca_error error = {0};
    c.stale = 0.01;
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (strcmp(argv[i], "--nominal") == 0)
            nominal = true;
        else if (strcmp(argv[i], "--lock-step") == 0)
            c.lock_step = true;
        else if (argv[i][0] != '-')
            path = argv[i];
        else if (!value)
            usage(argv[0]);
        else if (strcmp(argv[i], "--torque") == 0)
            torque = argv[++i];
        else if (strcmp(argv[i], "--robot") == 0)
            robot = argv[++i];
        else if (strcmp(argv[i], "--urdf-sha256") == 0)
            sha256 = argv[++i];
        else if (strcmp(argv[i], "--url") == 0)
            url = argv[++i];
        else if (strcmp(argv[i], "--stale") == 0)
            c.stale = strtod(argv[++i], NULL);
        else
            usage(argv[0]);
    }
    if (!path || !torque || !(c.stale > 0)) usage(argv[0]);
    if (load(&c, path, robot, sha256, nominal, &error) != MUKCA_OK) {
        fprintf(stderr, "limp: %s\n", error.text);
        return (int)error.status;
    }
    for (int j = 0; j < c.n; j++) {
        char *end;
        c.torque_limit[j] = strtod(torque, &end);
        if (end == torque || !(c.torque_limit[j] > 0)) usage(argv[0]);
        torque = *end == ',' ? end + 1 : end;
    }
    c.lcm = lcm_create(url);
    if (!c.lcm) {
        fprintf(stderr, "limp: no LCM network; check the multicast route or --url\n");
        return MUKCA_TRANSPORT;
    }
    signal(SIGINT, on_signal);
    signal(SIGTERM, on_signal);
    lcm_subscription_set_queue_capacity(lcm_subscribe(c.lcm, "IIWA_STATUS", on_status, &c), 0);
    lcm_subscribe(c.lcm, "IMPEDANCE_GOAL", on_goal, &c);
    serve(&c);
    report(&c);
    lcm_destroy(c.lcm);
    return c.limp[0] ? MUKCA_NEGATIVE : MUKCA_OK;
}
