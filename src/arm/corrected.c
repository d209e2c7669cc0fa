/* The corrected arm: parsed from an offsets table alone; kinematics with effects. */
#include "mukca/corrected.h"

#include <string.h>

#include "arm/offsets.h"
#include "effect/equilibrium.h"

mukca_status mukca_corrected_parse_named(mukca_corrected *model, mukca_bytes table,
                                         const char *name, int accept, mukca_error *error)
{
    double theta[MUKCA_MAX_THETA];
    unsigned char listed[MUKCA_MAX_THETA] = {0};
    mukca_acceptance acceptance;
    mukca_offsets_origin origin = {.name = name, .accept = accept, .own = &model->chain};
    const mukca_offsets_target into = {.theta = theta,
                                       .listed = listed,
                                       .n_effects = &model->n_effects,
                                       .effects = model->effects,
                                       .acceptance = &acceptance};
    memset(model, 0, sizeof *model);
    const mukca_status status = mukca_offsets_parse_into(&into, &origin, NULL, table, error);
    model->judged = acceptance.given;
    model->accepted = acceptance.accepted;
    model->intact = acceptance.intact;
    if (status == MUKCA_OK) mukca_geometry_set(&model->geometry, &model->chain, theta);
    return status;
}

mukca_status mukca_corrected_parse(mukca_corrected *model, const char *text, size_t size,
                                   mukca_error *error)
{
    const mukca_bytes table = {text, size};
    return mukca_corrected_parse_named(model, table, "offsets table", 0, error);
}

/* Static equilibrium at the encoder angles q. */
static void find_equilibrium(mukca_equilibrium *at, mukca_effect_slopes *slopes,
                             const mukca_corrected *model, const double *q,
                             const mukca_joint_state *state)
{
    static const mukca_joint_state none = {.placement = -1};
    mukca_effect_task task;
    task.effects = model->effects;
    task.n_effects = model->n_effects;
    task.chain = &model->chain;
    task.geometry = &model->geometry;
    task.state = state ? *state : none;
    task.state.q = q;
    mukca_equilibrium_find(at, slopes, &task);
}

void mukca_corrected_position(double position[3], const mukca_corrected *model, const double *q,
                              const mukca_joint_state *state)
{
    mukca_frame tip;
    mukca_corrected_pose(&tip, model, q, state);
    memcpy(position, tip.p, sizeof tip.p);
}

/* With effects; a separate function, as an arm without effects needs none of its stack. */
static __attribute__((noinline)) void find_pose(mukca_frame *tip, const mukca_corrected *model,
                                                const double *q, const mukca_joint_state *state)
{
    mukca_equilibrium at;
    find_equilibrium(&at, NULL, model, q, state);
    columns_frame(tip, &at.tip);
}

void mukca_corrected_pose(mukca_frame *T_base_tip, const mukca_corrected *model, const double *q,
                          const mukca_joint_state *state)
{
    if (model->n_effects > 0)
        find_pose(T_base_tip, model, q, state);
    else
        mukca_fk_pose(T_base_tip, &model->geometry, q, NULL);
}

static __attribute__((noinline)) void find_jacobian(double *J, mukca_frame *tip,
                                                    const mukca_corrected *model, const double *q,
                                                    const mukca_joint_state *state)
{
    mukca_equilibrium at;
    mukca_effect_slopes slopes;
    find_equilibrium(&at, &slopes, model, q, state);
    mukca_equilibrium_differentiate(J, &at, &slopes);
    if (tip) columns_frame(tip, &at.tip);
}

void mukca_corrected_jacobian(double *J, mukca_frame *T_base_tip, const mukca_corrected *model,
                              const double *q, const mukca_joint_state *state)
{
    if (model->n_effects > 0)
        find_jacobian(J, T_base_tip, model, q, state);
    else
        mukca_fk_jacobian(J, T_base_tip, &model->geometry, q, NULL);
}
