/* Run times of the fit on given data, as lines "name value", for run.py.
 *
 * usage: bench_fit URDF REPEATS FOLDER...
 *   rows                         of the data
 *   solve SOLVER GRADIENT J seconds   median: workspace set up, angles' sines, minimisation
 *   kernel NAME ROWS seconds     median per call, on the data repeated to ROWS rows
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fit/fit.h"
#include "fit/solver.h"
#include "io/dataset.h"
#include "io/urdf.h"

enum { MAX_REPEATS = 1000 };

/* Processor time, which other programs of the machine do not lengthen. */
static double processor_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *times, int n)
{
    qsort(times, (size_t)n, sizeof *times, ascending);
    return times[n / 2];
}

typedef struct {
    mukca_chain chain;
    mukca_parameters parameters;
    mukca_dataset data;
    double times[MAX_REPEATS];
    int repeats;
} bench;

static void time_solvers(bench *b)
{
    mukca_cost cost;
    double x[MUKCA_MAX_FREE];
    for (int s = 0; mukca_solver_table[s]; s++)
        for (int kind = 0; kind < 2; kind++) {
            const mukca_cost_options options = {.gradient = kind ? MUKCA_GRADIENT_ANALYTIC
                                                                 : MUKCA_GRADIENT_FD};
            double J = 0;
            for (int i = 0; i < b->repeats; i++) {
                mukca_solver_outcome outcome;
                const double start = processor_seconds();
                mukca_pool pool = {0};
                if (!mukca_cost_setup(&cost, &pool, &b->chain, &b->parameters, &b->data, &options))
                    abort();
                memcpy(x, cost.nominal, (size_t)cost.n * sizeof *x);
                mukca_solver_table[s]->run(x, &outcome, &cost, mukca_solver_table[s],
                                           &(mukca_solver_options){0}, NULL);
                b->times[i] = processor_seconds() - start;
                J = mukca_cost_evaluate(NULL, NULL, &cost, x);
                mukca_pool_free(&pool);
            }
            printf("solve %s %s %.17g %.6g\n", mukca_solver_name[s], kind ? "analytic" : "fd", J,
                   median(b->times, b->repeats));
        }
}

/* The data, repeated `times` times. */
static mukca_status repeat(mukca_dataset *out, const mukca_dataset *data, int times)
{
    const int n = data->n_rows, joints = data->n_joints;
    mukca_status status =
        mukca_dataset_create(out, n * times, joints, data->n_sockets, data->n_placements, NULL);
    if (status != MUKCA_OK) return status;
    for (int t = 0; t < times; t++) {
        memcpy(out->q + t * n * joints, data->q, (size_t)(n * joints) * sizeof *data->q);
        memcpy(out->socket + t * n, data->socket, (size_t)n * sizeof *data->socket);
    }
    memcpy(out->sockets, data->sockets, (size_t)data->n_sockets * sizeof *data->sockets);
    out->distances = malloc((size_t)(data->n_distances + 1) * sizeof *data->distances);
    if (!out->distances) return MUKCA_MEMORY;
    memcpy(out->distances, data->distances, (size_t)data->n_distances * sizeof *data->distances);
    out->n_distances = data->n_distances;
    return MUKCA_OK;
}

static void time_kernels(bench *b, int times)
{
    enum { CALLS = 20 };
    static const char *const names[] = {"cost", "gradient", "jacobian"};
    mukca_dataset data;
    mukca_cost cost;
    double x[MUKCA_MAX_FREE], g[MUKCA_MAX_FREE];
    if (repeat(&data, &b->data, times) != MUKCA_OK) return;
    mukca_pool pool = {0};
    if (!mukca_cost_setup(&cost, &pool, &b->chain, &b->parameters, &data, &(mukca_cost_options){0}))
        abort();
    memcpy(x, cost.nominal, (size_t)cost.n * sizeof *x);
    for (int kernel = 0; kernel < 3; kernel++) {
        for (int i = 0; i < b->repeats; i++) {
            const double start = processor_seconds();
            for (int call = 0; call < CALLS; call++) {
                if (kernel < 2)
                    mukca_cost_evaluate(NULL, kernel ? g : NULL, &cost, x);
                else
                    mukca_cost_normal(cost.matrix[0], &cost, x, false);
            }
            b->times[i] = (processor_seconds() - start) / CALLS;
        }
        printf("kernel %s %d %.6g\n", names[kernel], data.n_rows, median(b->times, b->repeats));
    }
    mukca_pool_free(&pool);
    mukca_dataset_free(&data);
}

int main(int argc, char **argv)
{
    static bench b;
    mukca_error error;
    if (argc < 4) {
        fputs("usage: bench_fit URDF REPEATS FOLDER...\n", stderr);
        return 2;
    }
    b.repeats = atoi(argv[2]);
    if (b.repeats < 1 || b.repeats > MAX_REPEATS) b.repeats = 21;
    if (mukca_urdf_load(&b.chain, argv[1], NULL, &error) != MUKCA_OK ||
        mukca_dataset_load(&b.data, &b.chain, (const char *const *)(argv + 3), argc - 3, NULL,
                           &error) != MUKCA_OK ||
        mukca_parameters_select(&b.parameters, &b.chain, &(mukca_selection){0}, &error) !=
            MUKCA_OK) {
        fprintf(stderr, "bench_fit: %s\n", error.text);
        return 3;
    }
    printf("rows %d\n", b.data.n_rows);
    time_solvers(&b);
    time_kernels(&b, 1);
    time_kernels(&b, 10);
    mukca_dataset_free(&b.data);
    return 0;
}
