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
    if (n > 0) mukca_effects_displacement(&d, effects, n, chain, geometry, state->q, state);
    mukca_fk_pose(tip, geometry, state->q, n > 0 ? &d : NULL);
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
    mukca_chain arm; /* without the frame of the measurement before it: `skip` parameters */
    int skip;
    double theta[2][MUKCA_MAX_THETA];
    mukca_geometry geometry[2];
    mukca_tip_change found; /* so far */
    /* of the tips in `count` random postures, before (with the tool of `to`) and after */
    mukca_geometry same_tool;
    double mean[2][3], squares[2];
    int count;
} comparison;

/* theta of the arm before and after, with the target of the measurement from `to`. */
static void set_theta(comparison *c)
{
    const int n = MUKCA_PARAMETERS * c->arm.n_elements, target = n - MUKCA_PARAMETERS;
    mukca_chain_theta(c->theta[0], &c->arm);
    for (int i = 0; i < n; i++) {
        c->theta[1][i] = c->task->to->theta[i + c->skip];
        if (c->task->from) c->theta[0][i] = c->task->from->theta[i + c->skip];
        if (c->task->tool_frame && i >= target) c->theta[0][i] = c->theta[1][i];
    }
}

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
    const mukca_joint_state state = {.q = q, .placement = -1};
    for (int side = 0; side < 2; side++) {
        const mukca_offsets *o = side ? c->task->to : c->task->from;
        const int n_effects = side || o ? o->n_effects : 0;
        mukca_tip_pose(&tip[side], n_effects ? o->effects : NULL, n_effects, &c->arm,
                       &c->geometry[side], &state);
    }
    const double change = mukca_distance3(tip[0].p, tip[1].p);
    if (!(change <= c->found.m)) c->found.m = change; /* propagates NaN */
}

static void set_models(comparison *c, const mukca_tip_change_task *task)
{
    double theta[MUKCA_MAX_THETA];
    c->task = task;
    c->arm = *task->chain;
    c->skip = task->base_frame ? MUKCA_PARAMETERS : 0;
    if (task->base_frame) mukca_chain_remove_first(&c->arm);
    set_theta(c);
    for (int side = 0; side < 2; side++)
        mukca_geometry_set(&c->geometry[side], &c->arm, c->theta[side]);
    const int last = c->arm.n_elements - 1, tool = MUKCA_PARAMETERS * last;
    memcpy(theta, c->theta[0], sizeof theta);
    if (c->arm.element[last].joint < 0)
        memcpy(theta + tool, c->theta[1] + tool, sizeof *theta * MUKCA_PARAMETERS);
    mukca_geometry_set(&c->same_tool, &c->arm, theta);
}

mukca_status mukca_tip_change_find(mukca_tip_change *change, const mukca_tip_change_task *task,
                                   mukca_error *error)
{
    mukca_pool pool = {0};
    mukca_random random;
    double q[MUKCA_MAX_JOINTS];
    const mukca_dataset *data = task->data;
    const int step = data ? data->n_rows / RECORDED + 1 : 1;
    comparison *c = MUKCA_TAKE(&pool, comparison, 1);
    if (!c) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    set_models(c, task);
    mukca_random_seed(&random, 1);
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
    const mukca_status status = mukca_tip_change_find(&change, task, error);
    if (status != MUKCA_OK) return status;
    a->tip_change_m = change.m, a->size_change = change.size;
    a->largest_offset_m = a->largest_offset_rad = 0;
    for (int i = 0; i < MUKCA_PARAMETERS * task->chain->n_elements; i++) {
        double *largest = i % MUKCA_PARAMETERS < 3 ? &a->largest_offset_m : &a->largest_offset_rad;
        if (mukca_tip_change_is_frame(task, i / MUKCA_PARAMETERS)) continue;
        *largest = fmax(*largest, fabs(to->theta[i] - nominal[i]));
    }
    return MUKCA_OK;
}
