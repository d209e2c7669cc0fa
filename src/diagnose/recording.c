/* The recording under diagnosis: motion of its rows and grouping of its samples. */
#include "diagnose/recording.h"

#include <math.h>
#include <string.h>

mukca_joint_state mukca_recording_state(const mukca_recording *recording, int row)
{
    const size_t r = (size_t)row, n = (size_t)recording->chain->n_joints;
    mukca_joint_state state = {.q = recording->data->q + r * n,
                               .move = recording->move + r * n,
                               .time = recording->time[row],
                               .placement = recording->placement[row]};
    if (recording->have_torques) state.torque = recording->total_torque + r * n;
    if (recording->have_moments) {
        state.moment = (const double(*)[3])(recording->total_moment + 3 * r * n);
        state.base_moment = recording->total_base + 3 * r;
    }
    if (recording->command) state.command = recording->command + r * n;
    return state;
}

void mukca_recording_range(double range[2], const mukca_recording *recording, const double *x,
                           int columns, int column)
{
    range[0] = HUGE_VAL, range[1] = -HUGE_VAL;
    for (int row = 0; row < recording->data->n_rows; row++) {
        range[0] = fmin(range[0], x[row * columns + column]);
        range[1] = fmax(range[1], x[row * columns + column]);
    }
}

void mukca_recording_regroup(mukca_recording *recording)
{
    const mukca_dataset *data = recording->data;
    recording->n_samples = recording->n_groups = recording->n_pairs = 0;
    for (int s = -1; s < data->n_sockets; s++) {
        mukca_group *group = &recording->groups[recording->n_groups];
        *group = (mukca_group){.start = recording->n_samples, .socket = s, .placement = -1};
        for (int row = 0; row < data->n_rows; row++)
            if (recording->keep[row] && data->socket[row] == s) {
                recording->order[recording->n_samples++] = row;
                group->placement = recording->placement[row];
            }
        group->count = recording->n_samples - group->start;
        /* Groups keep their index (faults refer to it), so empty sockets stay in the table. */
        if (s >= 0 || group->count) recording->n_groups++;
    }
    const int shift = recording->groups[0].socket < 0; /* a pose log is the first group */
    for (int p = 0; p < data->n_distances; p++) {
        const mukca_distance *known = &data->distances[p];
        const mukca_socket_pair pair = {known->a + shift, known->b + shift, known->distance};
        if (recording->groups[pair.a].count && recording->groups[pair.b].count)
            recording->pairs[recording->n_pairs++] = pair;
    }
}

/* Move, command, time and placement of each row. */
static void fill_motion(mukca_recording *recording)
{
    const size_t n = (size_t)recording->chain->n_joints, size = n * sizeof(double);
    mukca_row_state rows;
    for (int row = 0; row < recording->data->n_rows; row++) {
        const mukca_joint_state *state = mukca_dataset_state(&rows, recording->data, row);
        const size_t at = (size_t)row * n;
        memcpy(recording->move + at, state->move, size);
        if (recording->command) memcpy(recording->command + at, state->command, size);
        recording->time[row] = state->time;
        recording->placement[row] = state->placement;
    }
}

/* Six numbers per sample where all rows are poses with orientations, three otherwise. */
static int observed(const mukca_dataset *data)
{
    bool turned = data->n_rows > 0;
    for (int row = 0; row < data->n_rows && turned; row++)
        turned = data->socket[row] < 0 && data->quaternion &&
                 isfinite(data->quaternion[4 * (size_t)row]);
    return turned ? 6 : 3;
}

static void list_bodies(mukca_recording *recording)
{
    const mukca_chain *chain = recording->chain;
    for (int element = 0; element < chain->n_elements; element++) {
        double kg = 0;
        for (int i = 0; i < chain->n_masses; i++)
            if (chain->mass[i].element == element) kg += chain->mass[i].kg;
        const bool payload =
            recording->data->payload && element == chain->n_elements - 1 && chain->n_masses > 0;
        if (kg > 0 || payload) recording->body_element[recording->n_bodies++] = element;
    }
}

bool mukca_recording_create(mukca_recording *recording, mukca_pool *pool, const mukca_chain *chain,
                            const mukca_dataset *data, const mukca_recording_options *options)
{
    const int rows = data->n_rows, n_joints = chain->n_joints;
    *recording =
        (mukca_recording){.chain = chain, .data = data, .options = *options, .dim = observed(data)};
    list_bodies(recording);
    const int bodies = recording->n_bodies ? recording->n_bodies : 1;
    recording->moment = MUKCA_TAKE(pool, double, 3 * rows * bodies * n_joints);
    recording->torque = MUKCA_TAKE(pool, double, rows *bodies *n_joints);
    recording->base_moment = MUKCA_TAKE(pool, double, 3 * rows * bodies);
    recording->total_moment = MUKCA_TAKE(pool, double, 3 * rows * n_joints);
    recording->total_torque = MUKCA_TAKE(pool, double, rows *n_joints);
    recording->total_base = MUKCA_TAKE(pool, double, 3 * rows);
    recording->move = MUKCA_TAKE(pool, double, rows *n_joints);
    recording->command = data->command ? MUKCA_TAKE(pool, double, rows *n_joints) : NULL;
    recording->time = MUKCA_TAKE(pool, double, rows);
    recording->placement = MUKCA_TAKE(pool, int, rows);
    recording->keep = MUKCA_TAKE(pool, unsigned char, rows);
    recording->order = MUKCA_TAKE(pool, int, rows);
    recording->groups = MUKCA_TAKE(pool, mukca_group, data->n_sockets + 2);
    recording->pairs = MUKCA_TAKE(pool, mukca_socket_pair, data->n_distances + 1);
    if (pool->failed) return false;
    memset(recording->keep, 1, (size_t)rows);
    fill_motion(recording);
    mukca_recording_load(recording);
    mukca_recording_regroup(recording);
    return true;
}

int mukca_recording_distinct(const mukca_recording *recording)
{
    const int n = recording->chain->n_joints;
    int distinct = 0;
    for (int g = 0; g < recording->n_groups; g++)
        for (int i = 0; i < recording->groups[g].count; i++) {
            const int *row = recording->order + recording->groups[g].start + i;
            const double *q = recording->data->q + row[0] * n;
            double most = i ? 0 : HUGE_VAL;
            for (int j = 0; i && j < n; j++)
                most = fmax(most, fabs(q[j] - recording->data->q[row[-1] * n + j]));
            distinct += most > 1e-5; /* rad: the resolution of any encoder */
        }
    return distinct;
}
