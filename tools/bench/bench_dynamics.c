/* Torques of a moving arm, directly and by the regressor, for tools/interop/dynamics.py; and the
 * run time of both.
 *
 * usage: bench_dynamics URDF TIP <MOTIONS     MOTIONS: lines of q dq ddq, one number per joint each
 *
 * Prints the torques and Y p of each line, then "# NANOSECONDS NANOSECONDS" per row: direct,
 * regressor.
 */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "dynamics/inverse_dynamics.h"
#include "io/urdf.h"

enum { N = MUKCA_MAX_JOINTS, ROWS = 1000, REPEATS = 20 };

static double motions[ROWS][3 * N], Y[N * N * MUKCA_INERTIAL], p[N * MUKCA_INERTIAL];

static double processor_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e9 * (double)now.tv_sec + (double)now.tv_nsec;
}

static void print_row(const mukca_dynamics *dynamics, const double *row)
{
    const int n = dynamics->n_joints;
    double torque[N];
    mukca_dynamics_torque(torque, dynamics, p, row, row + n, row + 2 * n);
    mukca_dynamics_regressor(Y, dynamics, row, row + n, row + 2 * n);
    for (int i = 0; i < n; i++) printf("%.17g ", torque[i]);
    for (int i = 0; i < n; i++) {
        double sum = 0;
        for (int c = 0; c < n * MUKCA_INERTIAL; c++) sum += Y[i * n * MUKCA_INERTIAL + c] * p[c];
        printf("%.17g%c", sum, i < n - 1 ? ' ' : '\n');
    }
}

int main(int argc, char **argv)
{
    static mukca_chain chain;
    static mukca_dynamics dynamics;
    mukca_error error;
    int rows = 0, read = 0;
    const mukca_urdf_options options = {.tip = argc == 3 ? argv[2] : NULL};
    if (argc != 3 || mukca_urdf_load(&chain, argv[1], &options, &error)) {
        fprintf(stderr, "bench_dynamics: %s\n", argc != 3 ? "needs URDF TIP" : error.text);
        return 2;
    }
    const int n = chain.n_joints;
    mukca_dynamics_set(&dynamics, &chain);
    mukca_dynamics_inertials(p, &chain);
    while (rows < ROWS && scanf("%lf", &motions[rows][read]) == 1)
        if (++read == 3 * n) rows++, read = 0;
    if (rows == 0) return 2;
    for (int r = 0; r < rows; r++) print_row(&dynamics, motions[r]);
    double ns[2], torque[N];
    for (int regressor = 0; regressor < 2; regressor++) {
        const double start = processor_ns();
        for (int i = 0; i < REPEATS * rows; i++) {
            const double *row = motions[i % rows];
            if (regressor)
                mukca_dynamics_regressor(Y, &dynamics, row, row + n, row + 2 * n);
            else
                mukca_dynamics_torque(torque, &dynamics, p, row, row + n, row + 2 * n);
        }
        ns[regressor] = (processor_ns() - start) / (REPEATS * rows);
    }
    printf("# %.0f %.0f\n", ns[0], ns[1]);
    return 0;
}
