/* Run time of each call in a control loop: bench_realtime OFFSETS [CALLS]; one line per function
 * with the mean, quantiles and maximum of all calls. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "math/random.h"
#include "mukca/corrected.h"

static double now_us(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e6 * (double)t.tv_sec + 1e-3 * (double)t.tv_nsec;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void call(int which, const mukca_corrected *arm, const double *q)
{
    static double J[6 * MUKCA_MAX_JOINTS];
    static mukca_frame tip;
    if (which == 0) mukca_corrected_position(tip.p, arm, q, NULL);
    if (which == 1) mukca_corrected_pose(&tip, arm, q, NULL);
    if (which == 2) mukca_corrected_jacobian(J, &tip, arm, q, NULL);
}

int main(int argc, char **argv)
{
    static const char *const name[] = {"position", "pose", "jacobian"};
    static mukca_corrected arm;
    mukca_error error;
    mukca_random random;
    const int calls = argc > 2 ? atoi(argv[2]) : 1000000;
    double *us = argc > 1 && calls > 0 ? malloc((size_t)calls * sizeof *us) : NULL;
    if (!us) {
        fputs("usage: bench_realtime OFFSETS [CALLS]\n", stderr);
        return 2;
    }
    if (mukca_corrected_load(&arm, argv[1], &error)) {
        fprintf(stderr, "%s\n", error.text);
        return 3;
    }
    printf("%d calls, %d joints, %d effects; microseconds\n", calls, arm.chain.n_joints,
           arm.n_effects);
    puts("function      mean  median  99.99 %     max");
    random = mukca_random_seeded(1);
    for (int which = 0; which < 3; which++) {
        double sum = 0;
        for (int i = 0; i < calls; i++) {
            double q[MUKCA_MAX_JOINTS];
            for (int j = 0; j < arm.chain.n_joints; j++)
                q[j] = 6 * mukca_random_uniform(&random) - 3;
            const double before = now_us();
            call(which, &arm, q);
            us[i] = now_us() - before;
            sum += us[i];
        }
        qsort(us, (size_t)calls, sizeof *us, by_size);
        printf("%-10s %7.2f %7.2f %8.2f %7.1f\n", name[which], sum / calls, us[calls / 2],
               us[(int)(0.9999 * (calls - 1))], us[calls - 1]);
    }
    free(us);
    return 0;
}
