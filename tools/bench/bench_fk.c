/* Times of forward kinematics as lines "NAME NANOSECONDS" per configuration, medians: for
 * kinematics.py.
 *
 * usage: bench_fk URDF REPEATS ANGLES [CASADI.so]
 *
 * ANGLES: raw doubles, a row of joint angles after the other.  CASADI.so: functions that CasADi
 * generated (casadi_fk.py); they are timed on the same rows, and their results compared with ours.
 */
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fit/fit.h"
#include "io/urdf.h"

enum { MAX_ROWS = 4096, MAX_REPEATS = 1000, MAX_WORK = 4096 };
enum { WIDTH = MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS };

typedef int casadi_function(const double **arguments, double **results, long long *integers,
                            double *work, int memory);
typedef int casadi_sizes(long long *arguments, long long *results, long long *integers,
                         long long *work);

typedef struct {
    mukca_chain chain;
    mukca_geometry geometry;
    double theta[WIDTH], q[MAX_ROWS * MUKCA_MAX_JOINTS], positions[3 * MAX_ROWS];
    double J[3 * WIDTH], other[3 * WIDTH], times[MAX_REPEATS], work[MAX_WORK];
    long long integers[MAX_WORK];
    int rows, repeats;
    const char *symbol;
    casadi_function *function;
} bench;

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Time a pass over all rows. */
static void measure(bench *b, const char *name, void (*pass)(bench *))
{
    for (int i = 0; i < b->repeats; i++) {
        const double start = mukca_solver_clock();
        pass(b);
        b->times[i] = (mukca_solver_clock() - start) / b->rows;
    }
    qsort(b->times, (size_t)b->repeats, sizeof *b->times, ascending);
    printf("%s %.6g\n", name, 1e9 * b->times[b->repeats / 2]);
}

static void one_by_one(bench *b)
{
    for (int r = 0; r < b->rows; r++)
        mukca_fk_position(b->positions + 3 * r, &b->geometry, b->q + r * b->chain.n_joints, NULL);
}

static void jacobians(bench *b)
{
    for (int r = 0; r < b->rows; r++)
        mukca_fk_parameter_jacobian(b->J, b->positions + 3 * r, &b->geometry, b->theta,
                                    b->q + r * b->chain.n_joints);
}

/* Arguments q and theta (those that do not take it do not look), results position and Jacobian. */
static void generated(bench *b)
{
    for (int r = 0; r < b->rows; r++) {
        const double *arguments[8] = {b->q + r * b->chain.n_joints, b->theta};
        double *results[8] = {b->positions + 3 * r, b->other};
        b->function(arguments, results, b->integers, b->work, 0);
    }
}

static double distance(const double *a, const double *b, int n)
{
    double most = 0;
    for (int i = 0; i < n; i++) most = fmax(most, fabs(a[i] - b[i]));
    return most;
}

static int time_casadi(bench *b, const char *path)
{
    static const char *const names[] = {"position", "jacobian", "jacobian_constant"};
    static double ours[3 * MAX_ROWS];
    void *library = dlopen(path, RTLD_NOW);
    if (!library) {
        fprintf(stderr, "bench_fk: %s\n", dlerror());
        return 1;
    }
    memcpy(ours, b->positions, sizeof ours);
    for (int i = 0; i < 3; i++) {
        char symbol[64];
        long long sizes[4];
        casadi_sizes *work;
        snprintf(symbol, sizeof symbol, "%s_work", names[i]);
        *(void **)&work = dlsym(library, symbol);
        *(void **)&b->function = dlsym(library, names[i]);
        if (!work || !b->function || work(sizes, sizes + 1, sizes + 2, sizes + 3) != 0 ||
            sizes[0] > 8 || sizes[1] > 8 || sizes[2] > MAX_WORK || sizes[3] > MAX_WORK) {
            fprintf(stderr, "bench_fk: %s of %s is not as expected\n", names[i], path);
            return 1;
        }
        snprintf(symbol, sizeof symbol, "casadi_%s", names[i]);
        memset(b->positions, 0, sizeof b->positions);
        measure(b, symbol, generated);
        double off = distance(b->positions, ours, 3 * b->rows);
        if (i > 0)
            off = fmax(off, distance(b->J, b->other, 3 * MUKCA_PARAMETERS * b->chain.n_elements));
        if (!(off <= 1e-9)) {
            fprintf(stderr, "bench_fk: %s of CasADi differs by %g\n", names[i], off);
            return 1;
        }
    }
    return 0;
}

int main(int argc, char **argv)
{
    static bench b;
    mukca_error error;
    FILE *angles = argc > 3 ? fopen(argv[3], "rb") : NULL;
    if (!angles) {
        fputs("usage: bench_fk URDF REPEATS ANGLES [CASADI.so]\n", stderr);
        return 2;
    }
    b.repeats = atoi(argv[2]);
    if (b.repeats < 1 || b.repeats > MAX_REPEATS) b.repeats = 101;
    if (mukca_urdf_load(&b.chain, argv[1], NULL, NULL, NULL, &error) != MUKCA_OK) {
        fprintf(stderr, "bench_fk: %s\n", error.text);
        return 3;
    }
    const size_t width = (size_t)b.chain.n_joints * sizeof *b.q;
    b.rows = (int)fread(b.q, width, MAX_ROWS, angles);
    fclose(angles);
    mukca_chain_theta(b.theta, &b.chain);
    mukca_geometry_set(&b.geometry, &b.chain, NULL);
    measure(&b, "position_one", one_by_one);
    measure(&b, "jacobian", jacobians);
    double sum[3] = {0, 0, 0};
    for (int i = 0; i < 3 * b.rows; i++) sum[i % 3] += b.positions[i];
    printf("check %.12g %.12g %.12g\n", sum[0], sum[1], sum[2]);
    return argc > 4 ? time_casadi(&b, argv[4]) : 0;
}
