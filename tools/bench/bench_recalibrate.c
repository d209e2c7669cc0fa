/* Rows per second of the re-calibration without text input.
 *
 * usage: bench_recalibrate URDF ROWS      prints "rows passes seconds rank", seconds of the
 * processor bench_recalibrate URDF ROWS -    prints a pose log of as many rows instead
 */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "io/urdf.h"
#include "math/random.h"
#include "recalibrate/recalibrate.h"

/* Random postures and the poses of an arm with errors of some mm and mrad in origins and zeros, 0.1
 * mm of noise. */
static void fill(mukca_dataset *log, const mukca_chain *chain)
{
    double theta[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
    mukca_geometry geometry;
    mukca_random random;
    const int n = chain->n_joints;
    mukca_chain_theta(theta, chain);
    random = mukca_random_seeded(1);
    for (int i = 0; i < 6 * chain->n_elements; i++)
        if (i % 6 < 3) theta[i] += 3e-3 * mukca_random_normal(&random);
    mukca_geometry_set(&geometry, chain, theta);
    for (int i = 0; i < log->n_rows; i++) {
        mukca_frame tip;
        double q[MUKCA_MAX_JOINTS];
        log->time[i] = i;
        for (int j = 0; j < n; j++) {
            log->q[i * n + j] = 4 * mukca_random_uniform(&random) - 2;
            q[j] = log->q[i * n + j] + 2e-3 * (j % 3 - 1);
        }
        mukca_fk_pose(&tip, &geometry, q, NULL);
        for (int a = 0; a < 3; a++)
            log->position[3 * i + a] = tip.p[a] + 1e-4 * mukca_random_normal(&random);
        mukca_rotation_to_quaternion(log->quaternion + 4 * i, tip.R);
    }
}

static void print_log(const mukca_dataset *log, const mukca_chain *chain)
{
    for (int j = 0; j < chain->n_joints; j++)
        printf("%s\t", chain->element[chain->joint_element[j]].name);
    puts("x_m\ty_m\tz_m\tqw\tqx\tqy\tqz");
    for (int i = 0; i < log->n_rows; i++) {
        for (int j = 0; j < chain->n_joints; j++) printf("%.9f\t", log->q[i * chain->n_joints + j]);
        for (int a = 0; a < 3; a++) printf("%.9f\t", log->position[3 * i + a]);
        for (int a = 0; a < 4; a++)
            printf("%.9f%c", log->quaternion[4 * i + a], a < 3 ? '\t' : '\n');
    }
}

static mukca_status run(mukca_dataset *log, const mukca_chain *chain, mukca_error *error)
{
    const mukca_fit_options options = {.free_base = false};
    mukca_recalibration *result = calloc(1, sizeof *result);
    if (!result) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    const clock_t start = clock(); /* processor time, independent of other load */
    mukca_status status = mukca_pose_log_prepare(log, error);
    if (status == MUKCA_OK) status = mukca_recalibrate(result, chain, log, &options, false, error);
    if (status == MUKCA_OK)
        printf("%d %d %.6f %d\n", log->n_rows, result->all.outcome.evaluations,
               (double)(clock() - start) / CLOCKS_PER_SEC, result->lengths.identification.rank);
    free(result);
    return status;
}

int main(int argc, char **argv)
{
    mukca_error error;
    mukca_dataset log = {0};
    static mukca_chain chain;
    if (argc < 3) return 2;
    mukca_status status = mukca_urdf_load(&chain, argv[1], NULL, &error);
    const int n = atoi(argv[2]);
    if (status == MUKCA_OK) status = mukca_dataset_create(&log, n, chain.n_joints, 0, 0, &error);
    if (status == MUKCA_OK) {
        log.time = calloc((size_t)n, sizeof *log.time);
        log.position = calloc((size_t)n, 3 * sizeof *log.position);
        log.quaternion = calloc((size_t)n, 4 * sizeof *log.quaternion);
        if (!log.time || !log.position || !log.quaternion) return 1;
        fill(&log, &chain);
        if (argc > 3)
            print_log(&log, &chain);
        else
            status = run(&log, &chain, &error);
    }
    if (status != MUKCA_OK) fprintf(stderr, "bench_recalibrate: %s\n", error.text);
    mukca_dataset_free(&log);
    return status != MUKCA_OK;
}
