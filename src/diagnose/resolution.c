/* Resolution of the recorded angles of a joint. */
#include "diagnose/resolution.h"

#include <math.h>
#include <stdlib.h>

enum {
    LEAST_VALUES = 20, /* distinct values that make a step evident */
    MOST_PARTS = 4     /* largest number of steps in the smallest difference */
};
/* Largest deviation of a difference from whole steps: rounding in the file's last digits.  By
 * chance one difference in five is within it, and not twenty in a row. */
#define WHOLE 0.1

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double mukca_resolution_step(double *scratch, const mukca_recording *r, int joint)
{
    const int n = r->data->n_rows, joints = r->chain->n_joints;
    double smallest = HUGE_VAL;
    int values = 0;
    for (int row = 0; row < n; row++) scratch[row] = r->data->q[row * joints + joint];
    qsort(scratch, (size_t)n, sizeof *scratch, ascending);
    for (int i = 1; i < n; i++) { /* differences between neighbours, in place */
        const double difference = scratch[i] - scratch[i - 1];
        if (difference > 1e-9) smallest = fmin(smallest, scratch[values++] = difference);
    }
    for (int parts = 1; values >= LEAST_VALUES && parts <= MOST_PARTS; parts++) {
        const double step = smallest / parts;
        int i = 0;
        while (i < values && fabs(scratch[i] / step - round(scratch[i] / step)) < WHOLE) i++;
        if (i == values) return step;
    }
    return 0;
}
