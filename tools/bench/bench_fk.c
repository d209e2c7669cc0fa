/* Run times of forward kinematics per configuration, absolute and relative to a yardstick: the C
 * library's sincos of each joint, timed in the same repeat.  Lines "NAME NANOSECONDS RATIO LOWER
 * UPPER": medians, and quartiles of the ratio; for kinematics.py.
 *
 * usage: bench_fk URDF ANGLES OFFSETS [CASADI.so]
 *
 * ANGLES: raw doubles, one row of joint angles after the other; each repeat uses the next 1000
 * rows.  With repeated rows the branch predictor would learn sincos, and bias short kernels most.
 * OFFSETS: a table with effects.  CASADI.so: functions that CasADi generated (casadi_fk.py), on the
 * same rows; their results are compared with ours.
 */
#define _GNU_SOURCE /* sincos */
#include <dlfcn.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fit/fit.h"
#include "io/urdf.h"
#include "mukca/corrected.h"

enum { ROWS = 1000, MAX_REPEATS = 1000, MAX_WORK = 4096, MAX_PASSES = 16 };
enum { WIDTH = MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS };

typedef int casadi_function(const double **arguments, double **results, long long *integers,
                            double *work, int memory);
typedef int casadi_sizes(long long *arguments, long long *results, long long *integers,
                         long long *work);

typedef struct bench bench;

typedef struct {
    const char *name;
    void (*run)(bench *);
    casadi_function *function;
    double seconds[MAX_REPEATS], ratio[MAX_REPEATS];
} pass;

struct bench {
    mukca_chain chain;
    mukca_geometry geometry;
    mukca_corrected arm;
    double theta[WIDTH], q[ROWS * MUKCA_MAX_JOINTS], positions[3 * ROWS];
    double J[3 * WIDTH], other[3 * WIDTH], work[MAX_WORK];
    long long integers[MAX_WORK];
    int n_passes;
    pass passes[MAX_PASSES], *now;
};

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void add(bench *b, const char *name, void (*run)(bench *), casadi_function *function)
{
    b->passes[b->n_passes++] = (pass){.name = name, .run = run, .function = function};
}

/* Processor time, s: on a busy machine a pass of some ms is often interrupted. */
static double processor_time(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static bool next_rows(bench *b, FILE *angles)
{
    return fread(b->q, (size_t)b->chain.n_joints * sizeof *b->q, ROWS, angles) == ROWS;
}

/* Run all passes in turn over the same rows, for equal disturbance by other load; the first is the
 * yardstick. */
static void measure(bench *b, FILE *angles)
{
    size_t n = 0;
    for (; n < MAX_REPEATS && next_rows(b, angles); n++)
        for (pass *p = b->passes; p < b->passes + b->n_passes; p++) {
            const double start = processor_time();
            b->now = p;
            p->run(b);
            p->seconds[n] = (processor_time() - start) / ROWS;
            p->ratio[n] = p->seconds[n] / b->passes->seconds[n];
        }
    for (pass *p = b->passes; p < b->passes + b->n_passes; p++) {
        qsort(p->seconds, n, sizeof *p->seconds, ascending);
        qsort(p->ratio, n, sizeof *p->ratio, ascending);
        printf("%s %.6g %.4g %.4g %.4g\n", p->name, 1e9 * p->seconds[n / 2], p->ratio[n / 2],
               p->ratio[n / 4], p->ratio[3 * n / 4]);
    }
}

static void yardstick(bench *b)
{
    for (int i = 0; i < ROWS * b->chain.n_joints; i++) sincos(b->q[i], &b->work[0], &b->work[1]);
}

static void at_once(bench *b)
{
    mukca_fk_positions(b->positions, &b->geometry, b->q, ROWS);
}

static void poses(bench *b)
{
    mukca_frame tip;
    for (int r = 0; r < ROWS; r++) {
        mukca_fk_pose(&tip, &b->geometry, b->q + r * b->chain.n_joints, NULL);
        memcpy(b->positions + 3 * r, tip.p, sizeof tip.p);
    }
}

static void geometric(bench *b)
{
    mukca_frame tip;
    for (int r = 0; r < ROWS; r++)
        mukca_fk_jacobian(b->other, &tip, &b->geometry, b->q + r * b->chain.n_joints, NULL);
}

static void corrected(bench *b)
{
    mukca_frame tip;
    for (int r = 0; r < ROWS; r++)
        mukca_corrected_pose(&tip, &b->arm, b->q + r * b->chain.n_joints, NULL);
}

static void corrected_jacobian(bench *b)
{
    mukca_frame tip;
    for (int r = 0; r < ROWS; r++)
        mukca_corrected_jacobian(b->other, &tip, &b->arm, b->q + r * b->chain.n_joints, NULL);
}

static void one_by_one(bench *b)
{
    for (int r = 0; r < ROWS; r++)
        mukca_fk_position(b->positions + 3 * r, &b->geometry, b->q + r * b->chain.n_joints, NULL);
}

static void jacobians(bench *b)
{
    for (int r = 0; r < ROWS; r++)
        mukca_fk_parameter_jacobian(b->J, b->positions + 3 * r, &b->geometry, b->theta,
                                    b->q + r * b->chain.n_joints);
}

/* Arguments q and theta (ignored by functions without it), results position and Jacobian. */
static void generated(bench *b)
{
    for (int r = 0; r < ROWS; r++) {
        const double *arguments[8] = {b->q + r * b->chain.n_joints, b->theta};
        double *results[8] = {b->positions + 3 * r, b->other};
        b->now->function(arguments, results, b->integers, b->work, 0);
    }
}

static double distance(const double *a, const double *b, int n)
{
    double most = 0;
    for (int i = 0; i < n; i++) most = fmax(most, fabs(a[i] - b[i]));
    return most;
}

/* Compare a generated function with ours on all rows, and time it. */
static int add_casadi(bench *b, void *library, const char *name, const char *shown)
{
    static double ours[3 * ROWS];
    char symbol[64];
    long long sizes[4];
    casadi_sizes *work;
    casadi_function *function;
    snprintf(symbol, sizeof symbol, "%s_work", name);
    *(void **)&work = dlsym(library, symbol);
    *(void **)&function = dlsym(library, name);
    if (!work || !function || work(sizes, sizes + 1, sizes + 2, sizes + 3) != 0 || sizes[0] > 8 ||
        sizes[1] > 8 || sizes[2] > MAX_WORK || sizes[3] > MAX_WORK) {
        fprintf(stderr, "bench_fk: %s is not as expected\n", name);
        return 1;
    }
    pass check = {.function = function};
    jacobians(b);
    memcpy(ours, b->positions, sizeof ours);
    memset(b->positions, 0, sizeof b->positions);
    b->now = &check;
    generated(b);
    double off = distance(b->positions, ours, 3 * ROWS);
    if (strcmp(name, "position") != 0)
        off = fmax(off, distance(b->J, b->other, 3 * MUKCA_PARAMETERS * b->chain.n_elements));
    if (!(off <= 1e-9)) {
        fprintf(stderr, "bench_fk: %s of CasADi differs by %g\n", name, off);
        return 1;
    }
    add(b, shown, generated, function);
    return 0;
}

int main(int argc, char **argv)
{
    static bench b;
    mukca_error error;
    FILE *angles = argc > 3 ? fopen(argv[2], "rb") : NULL;
    if (!angles) {
        fputs("usage: bench_fk URDF ANGLES OFFSETS [CASADI.so]\n", stderr);
        return 2;
    }
    if (mukca_urdf_load(&b.chain, argv[1], NULL, &error) != MUKCA_OK ||
        mukca_corrected_load(&b.arm, argv[3], &error) != MUKCA_OK) {
        fprintf(stderr, "bench_fk: %s\n", error.text);
        return 3;
    }
    if (!next_rows(&b, angles)) {
        fprintf(stderr, "bench_fk: %s has fewer than %d rows\n", argv[2], ROWS);
        return 1;
    }
    rewind(angles);
    mukca_chain_theta(b.theta, &b.chain);
    mukca_geometry_set(&b.geometry, &b.chain, NULL);
    add(&b, "yardstick", yardstick, NULL);
    add(&b, "positions", at_once, NULL);
    add(&b, "position", one_by_one, NULL);
    add(&b, "pose", poses, NULL);
    add(&b, "geometric_jacobian", geometric, NULL);
    add(&b, "jacobian", jacobians, NULL);
    add(&b, "corrected_pose", corrected, NULL);
    add(&b, "corrected_jacobian", corrected_jacobian, NULL);
    if (argc > 4) {
        void *library = dlopen(argv[4], RTLD_NOW);
        if (!library) {
            fprintf(stderr, "bench_fk: %s\n", dlerror());
            return 1;
        }
        if (add_casadi(&b, library, "position", "casadi_position") ||
            add_casadi(&b, library, "jacobian", "casadi_jacobian") ||
            add_casadi(&b, library, "jacobian_constant", "casadi_jacobian_constant"))
            return 1;
    }
    measure(&b, angles);
    fclose(angles);
    one_by_one(&b);
    double sum[3] = {0, 0, 0};
    for (int i = 0; i < 3 * ROWS; i++) sum[i % 3] += b.positions[i];
    printf("check %.12g %.12g %.12g\n", sum[0], sum[1], sum[2]);
    return 0;
}
