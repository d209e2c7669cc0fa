/* Joint state of a row from the preceding rows: move, time, command. */
#include "mukca/row_state.h"

#include <math.h>
#include <string.h>

void mukca_row_state_start(mukca_row_state *rows, int n_joints)
{
    memset(rows, 0, sizeof *rows);
    rows->n_joints = n_joints;
    rows->start = (double)NAN;
    rows->state = (mukca_joint_state){.q = rows->q, .move = rows->move, .placement = -1};
}

void mukca_row_state_stream(mukca_row_state *rows, int n_joints)
{
    mukca_row_state_start(rows, n_joints);
    rows->window = 0.1; /* five scales of approach hysteresis, whose tanh is then 1 */
}

const mukca_joint_state *mukca_row_state_set(mukca_row_state *rows, const double *q)
{
    for (int j = 0; j < rows->n_joints; j++) {
        rows->q[j] = q[j];
        rows->move[j] = rows->rows > 1 ? q[j] - rows->before[j] : 0;
        if (rows->window > 0)
            rows->move[j] = fmin(fmax(rows->move[j], -rows->window), rows->window);
    }
    return &rows->state;
}

/* Time since the start of the recording, s. */
static double elapsed(mukca_row_state *rows, const mukca_row_reading *reading)
{
    const int skipped = rows->rows > 0 ? reading->number - rows->number : 0;
    const double estimate = rows->state.time + MUKCA_SECONDS_PER_ROW * skipped;
    if (isnan(reading->time)) return estimate;
    if (isnan(rows->start)) rows->start = reading->time - estimate;
    return reading->time - rows->start;
}

const mukca_joint_state *mukca_row_state_next(mukca_row_state *rows,
                                              const mukca_row_reading *reading)
{
    mukca_joint_state *state = &rows->state;
    for (int j = 0; j < rows->n_joints; j++)
        rows->before[j] = rows->rows == 0    ? reading->q[j]
                          : rows->window > 0 ? rows->q[j] - rows->move[j]
                                             : rows->q[j];
    state->time = elapsed(rows, reading);
    state->payload_kg = isnan(reading->payload_kg) ? 0 : reading->payload_kg;
    state->placement = reading->placement;
    state->command = reading->command ? rows->command : NULL;
    for (int j = 0; j < rows->n_joints && reading->command; j++)
        rows->command[j] = isnan(reading->command[j]) ? reading->q[j] : reading->command[j];
    rows->number = reading->number;
    rows->rows++;
    return mukca_row_state_set(rows, reading->q);
}
