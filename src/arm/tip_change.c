/* Displacement of the tip from one offsets table, or the nominal model, to another. */
#include "arm/tip_change.h"

#include <math.h>
#include <string.h>

enum {
    DRAWN = 256,   /* postures; 1 % of the workspace is missed with probability 8 % */
    RECORDED = 512 /* largest number from the data */
};

bool mukca_tip_change_is_frame(const mukca_tip_change_task *task, int element)
{
    return (task->base_frame && element == 0) ||
           (task->tool_frame && element == task->chain->n_elements - 1);
}

void mukca_tip_pose(mukca_frame *tip, const mukca_effect *effects, int n, const mukca_chain *chain,
                    const mukca_geometry *geometry, const mukca_joint_state *state)
{
    mukca_displacement d;
    if (n > 0) mukca_effects_displacement(&d, effects, n, chain, geometry, state);
    mukca_fk_pose(tip, geometry, state->q, n > 0 ? &d : NULL);
}

void mukca_offsets_tip(mukca_frame *tip, const mukca_offsets *table, const mukca_chain *chain,
                       const mukca_geometry *geometry, const double *q)
{
    const mukca_joint_state state = {.q = q, .placement = -1};
    mukca_tip_pose(tip, table ? table->effects : NULL, table ? table->n_effects : 0, chain,
                   geometry, &state);
}

void mukca_chain_remove_first(mukca_chain *chain)
{
    chain->n_elements--;
    memmove(chain->element, chain->element + 1, (size_t)chain->n_elements * sizeof *chain->element);
    for (int m = 0; m < chain->n_masses; m++) chain->mass[m].element--;
    for (int j = 0; j < chain->n_joints; j++) chain->joint_element[j]--;
}

typedef struct {
    const mukca_tip_change_task *task;
    mukca_chain arm;            /* without the frame of the measurement before it */
    mukca_geometry geometry[2]; /* before and after */
    mukca_tip_change found;     /* so far */
    /* of the tips in `count` random postures, before (with the tool of `to`) and after */
    mukca_geometry same_tool;
    double mean[2][3], squares[2];
    int count;
} comparison;

/* Add the tips of a posture to means and squares (Welford). */
static void spread(comparison *c, const double *q)
{
    const mukca_geometry *sides[2] = {&c->same_tool, &c->geometry[1]};
    c->count++;
    for (int side = 0; side < 2; side++) {
        double p[3];
        mukca_fk_position(p, sides[side], q, NULL);
        for (int a = 0; a < 3; a++) {
            const double off = p[a] - c->mean[side][a];
            c->mean[side][a] += off / c->count;
            c->squares[side] += off * (p[a] - c->mean[side][a]);
        }
    }
}

static void compare(comparison *c, const double *q)
{
    mukca_frame tip[2];
    mukca_offsets_tip(&tip[0], c->task->from, &c->arm, &c->geometry[0], q);
    mukca_offsets_tip(&tip[1], c->task->to, &c->arm, &c->geometry[1], q);
    const double change = mukca_distance3(tip[0].p, tip[1].p);
    if (!(change <= c->found.m)) c->found.m = change; /* propagates NaN */
}

/* The arm before and after, with the target of the measurement from `to`. */
static void set_models(comparison *c, const mukca_tip_change_task *task)
{
    double before[MUKCA_MAX_THETA];
    const int skip = task->base_frame ? MUKCA_PARAMETERS : 0;
    const double *after = task->to->theta + skip;
    c->task = task;
    c->arm = *task->chain;
    if (task->base_frame) mukca_chain_remove_first(&c->arm);
    const int last = c->arm.n_elements - 1, tool = MUKCA_PARAMETERS * last;
    const size_t one = MUKCA_PARAMETERS * sizeof *before;
    mukca_chain_theta(before, &c->arm);
    if (task->from) memcpy(before, task->from->theta + skip, (size_t)(last + 1) * one);
    if (task->tool_frame) memcpy(before + tool, after + tool, one);
    mukca_geometry_set(&c->geometry[0], &c->arm, before);
    mukca_geometry_set(&c->geometry[1], &c->arm, after);
    if (c->arm.element[last].joint < 0) memcpy(before + tool, after + tool, one);
    mukca_geometry_set(&c->same_tool, &c->arm, before);
}

mukca_status mukca_tip_change_find(mukca_tip_change *change, const mukca_tip_change_task *task,
                                   mukca_error *error)
{
    mukca_pool pool = {0};
    mukca_random random = mukca_random_seeded(1);
    double q[MUKCA_MAX_JOINTS];
    const mukca_dataset *data = task->data;
    const int step = data ? data->n_rows / RECORDED + 1 : 1;
    comparison *c = MUKCA_TAKE(&pool, comparison, 1);
    if (!c) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    set_models(c, task);
    for (int i = 0; i < DRAWN; i++) {
        mukca_posture_draw(q, task->chain, &random);
        compare(c, q);
        spread(c, q);
    }
    for (int i = 0; data && i < data->n_rows; i += step)
        compare(c, data->q + (size_t)i * (size_t)data->n_joints);
    *change = c->found;
    change->size = sqrt(c->squares[1] / c->squares[0]) - 1;
    mukca_pool_free(&pool);
    return MUKCA_OK;
}

mukca_status mukca_tip_change_judge(mukca_offsets *to, const mukca_tip_change_task *task,
                                    mukca_error *error)
{
    mukca_acceptance *a = &to->acceptance;
    double nominal[MUKCA_MAX_THETA];
    mukca_tip_change change;
    mukca_chain_theta(nominal, task->chain);
    MUKCA_TRY(mukca_tip_change_find(&change, task, error));
    a->tip_change_m = change.m, a->size_change = change.size;
    a->largest_offset_m = a->largest_offset_rad = 0;
    for (int i = 0; i < MUKCA_PARAMETERS * task->chain->n_elements; i++) {
        double *largest = i % MUKCA_PARAMETERS < 3 ? &a->largest_offset_m : &a->largest_offset_rad;
        if (mukca_tip_change_is_frame(task, i / MUKCA_PARAMETERS)) continue;
        *largest = fmax(*largest, fabs(to->theta[i] - nominal[i]));
    }
    return MUKCA_OK;
}
