/* The list of candidates: survey of the recording, effects of the catalogue. */
#include <math.h>
#include <string.h>

#include "diagnose/candidates.h"

/* Properties of the recording that determine the testable effects. */
static void survey_recording(mukca_effect_survey *s, const mukca_recording *recording)
{
    const mukca_dataset *data = recording->data;
    const int n = recording->chain->n_joints, rows = data->n_rows;
    *s = (mukca_effect_survey){.n_joints = n,
                               .n_placements = data->n_placements,
                               .moments = recording->have_moments,
                               .torques = recording->have_torques,
                               .by_command = data->by_command,
                               .pairs = recording->n_pairs > 1};
    for (int j = 0; j < n; j++) {
        const double *torque = recording->total_torque;
        double range[2];
        mukca_recording_range(range, recording, data->q, n, j);
        s->joint[j].range = range[1] - range[0];
        s->joint[j].turns =
            recording->chain->element[recording->chain->joint_element[j]].type != MUKCA_PRISMATIC;
        mukca_recording_range(range, recording, recording->move, n, j);
        s->moved |= range[1] - range[0] > 1e-6;
        mukca_recording_range(range, recording, torque, n, j);
        s->joint[j].torque_low = range[0], s->joint[j].torque_high = range[1];
        s->joint[j].torque_most = fmax(fabs(range[0]), fabs(range[1]));
        s->joint[j].torque_least = HUGE_VAL;
        for (int row = 0; row < rows; row++)
            s->joint[j].torque_least = fmin(s->joint[j].torque_least, fabs(torque[row * n + j]));
    }
    for (int row = 0; row < rows; row++) s->dwelled |= recording->repeat[row] > 0;
    for (int i = 0; recording->command && i < rows * n; i++)
        s->commanded |= fabs(recording->command[i] - data->q[i]) > 1e-7;
    for (int g = 0; g < recording->n_groups; g++) s->sockets |= recording->groups[g].socket >= 0;
}

void mukca_candidates_append(mukca_candidates *all, mukca_candidate h)
{
    const int class = mukca_candidate_class(&h);
    if (class < MUKCA_EFFECT_COUNT && all->disabled && all->disabled[class]) return;
    if (all->count == all->capacity) {
        const int capacity = all->capacity ? 2 * all->capacity : 2048;
        mukca_candidate *bigger = MUKCA_TAKE(all->pool, mukca_candidate, capacity);
        if (!bigger) return;
        if (all->count) memcpy(bigger, all->list, sizeof *bigger * (size_t)all->count);
        all->list = bigger;
        all->capacity = capacity;
    }
    if (mukca_candidate_take(&h, all->pool, all->recording, all->list, all->count))
        all->list[all->count++] = h;
}

void mukca_candidates_start(mukca_candidates *all, mukca_pool *pool,
                            const mukca_recording *recording, const unsigned char *disabled)
{
    *all = (mukca_candidates){.pool = pool, .recording = recording, .disabled = disabled};
    survey_recording(&all->survey, recording);
    for (int joint = -1; joint < recording->chain->n_joints; joint++)
        for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) {
            mukca_effect e;
            if (mukca_effect_has_joint(kind) != (joint >= 0)) continue;
            for (int i = 0;
                 mukca_effect_candidate(&e, (mukca_effect_kind)kind, joint, &all->survey, i); i++)
                mukca_candidates_append(all, mukca_candidate_of(&e));
        }
}

typedef struct {
    const mukca_candidates *all;
    const unsigned char *taken;
} filling;

static void fill(void *context, int block, int worker)
{
    const filling *job = context;
    const mukca_candidate *h = &job->all->list[block];
    (void)worker;
    if (!job->taken)
        mukca_candidate_compute(h, job->all->recording);
    else if (job->taken[block])
        mukca_candidate_fill(h, job->all->recording);
}

void mukca_candidates_fill(const mukca_candidates *all, unsigned char *taken)
{
    const mukca_candidate *list = all->list;
    const int n = all->pool->failed ? 0 : all->count;
    for (int i = 0; i < n && taken; i++)
        for (int o = 0; o < i && taken[i] && list[i].shares_basis; o++)
            if (list[o].basis == list[i].basis) taken[o] = 1;
    mukca_workers_run(all->recording->workers, n, fill, &(filling){all, taken});
}
