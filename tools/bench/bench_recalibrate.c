/* Rows per second of the re-calibration without text input: a few thousand rows, repeated to the
 * length of the log.
 *
 * usage: bench_recalibrate URDF ROWS      prints "rows passes seconds rank", seconds of the
 * processor bench_recalibrate URDF ROWS -    prints a pose log of as many rows instead
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "io/urdf.h"
#include "math/random.h"
#include "recalibrate/recalibrate.h"

enum { PERIOD = 4096 };

typedef struct {
    mukca_pose_row row[PERIOD];
    long n;
} endless;

/* Random postures and the poses of an arm with errors of some mm and mrad in origins and zeros, 0.1
 * mm of noise. */
static void fill(endless *log, const mukca_chain *chain)
{
    double theta[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
    mukca_geometry geometry;
    mukca_random random;
    mukca_random_seed(&random, 1);
    mukca_chain_theta(theta, chain);
    for (int i = 0; i < 6 * chain->n_elements; i++)
        if (i % 6 < 3) theta[i] += 3e-3 * mukca_random_normal(&random);
    mukca_geometry_set(&geometry, chain, theta);
    for (int i = 0; i < PERIOD; i++) {
        mukca_pose_row *row = &log->row[i];
        mukca_frame tip;
        double q[MUKCA_MAX_JOINTS];
        *row = (mukca_pose_row){.time = (double)i, .file = 1};
        for (int j = 0; j < chain->n_joints; j++) {
            row->q[j] = 4 * mukca_random_uniform(&random) - 2;
            q[j] = row->q[j] + 2e-3 * (j % 3 - 1);
        }
        mukca_fk_pose(&tip, &geometry, q, NULL);
        for (int a = 0; a < 3; a++)
            row->position[a] = tip.p[a] + 1e-4 * mukca_random_normal(&random);
        mukca_rotation_to_quaternion(row->quaternion, tip.R);
    }
}

static void print_log(const endless *log, const mukca_chain *chain)
{
    for (int j = 0; j < chain->n_joints; j++)
        printf("%s\t", chain->element[chain->joint_element[j]].name);
    puts("x_m\ty_m\tz_m\tqw\tqx\tqy\tqz");
    for (long i = 0; i < log->n; i++) {
        const mukca_pose_row *row = &log->row[i % PERIOD];
        for (int j = 0; j < chain->n_joints; j++) printf("%.9f\t", row->q[j]);
        for (int a = 0; a < 3; a++) printf("%.9f\t", row->position[a]);
        for (int a = 0; a < 4; a++) printf("%.9f%c", row->quaternion[a], a < 3 ? '\t' : '\n');
    }
}

int main(int argc, char **argv)
{
    mukca_error error;
    endless *log = calloc(1, sizeof *log);
    mukca_chain *chain = calloc(1, sizeof *chain);
    mukca_recalibration *result = calloc(1, sizeof *result);
    const mukca_recalibrate_options options = {.iterate = false};
    if (argc < 3 || !log || !chain || !result) return 2;
    if (mukca_urdf_load(chain, argv[1], NULL, NULL, NULL, &error)) {
        fprintf(stderr, "bench_recalibrate: %s\n", error.text);
        return 1;
    }
    log->n = atol(argv[2]);
    fill(log, chain);
    if (argc > 3) {
        print_log(log, chain);
    } else {
        mukca_pose_log as_log = {.n_joints = chain->n_joints};
        const mukca_recalibrate_task task = {chain, &as_log, &options};
        for (long i = 0; i < log->n; i++)
            if (mukca_pose_log_add(&as_log, &log->row[i % PERIOD], &error)) return 1;
        const clock_t start = clock(); /* processor time, independent of other load */
        if (mukca_recalibrate(result, &task, &error)) {
            fprintf(stderr, "bench_recalibrate: %s\n", error.text);
            return 1;
        }
        printf("%ld %d %.6f %d\n", as_log.n, result->passes,
               (double)(clock() - start) / CLOCKS_PER_SEC, result->found.rank);
        mukca_pose_log_close(&as_log);
    }
    free(result);
    free(chain);
    free(log);
    return 0;
}
