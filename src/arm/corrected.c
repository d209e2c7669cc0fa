/* The corrected arm: parsed from an offsets table alone; kinematics with effects. */
#include "mukca/corrected.h"

#include <string.h>

#include "arm/corrected_jacobian.h"
#include "arm/offsets.h"
#include "base/print.h"

mukca_status mukca_corrected_parse_from(mukca_corrected *model, mukca_bytes table,
                                        const mukca_offsets_origin *from, mukca_error *error)
{
    double theta[MUKCA_MAX_THETA];
    unsigned char listed[MUKCA_MAX_THETA] = {0};
    mukca_acceptance acceptance;
    mukca_offsets_origin origin = *from;
    const mukca_offsets_target into = {.theta = theta,
                                       .listed = listed,
                                       .n_effects = &model->n_effects,
                                       .effects = model->effects,
                                       .acceptance = &acceptance};
    memset(model, 0, sizeof *model);
    mukca_status status = mukca_chain_parse(&model->chain, table, origin.name, error);
    if (status != MUKCA_OK) return status;
    mukca_chain_theta(theta, &model->chain);
    mukca_acceptance_init(&acceptance);
    status = mukca_offsets_parse_into(&into, &origin, &model->chain, table, error);
    model->judged = acceptance.given;
    model->accepted = acceptance.accepted;
    if (status != MUKCA_OK) return status;
    if (origin.ignored > 0) {
        if (error) {
            error->status = MUKCA_INPUT;
            mukca_print(error->text, sizeof error->text,
                        "%s: has rows of joints that its chain lacks", origin.name);
        }
        return MUKCA_INPUT;
    }
    mukca_geometry_set(&model->geometry, &model->chain, theta);
    return MUKCA_OK;
}

mukca_status mukca_corrected_parse_any(mukca_corrected *model, const char *text, size_t size,
                                       bool accept_failed, mukca_error *error)
{
    const mukca_offsets_origin memory = {.name = "offsets table", .accept_failed = accept_failed};
    return mukca_corrected_parse_from(model, (mukca_bytes){text, size}, &memory, error);
}

mukca_status mukca_corrected_parse(mukca_corrected *model, const char *text, size_t size,
                                   mukca_error *error)
{
    return mukca_corrected_parse_any(model, text, size, false, error);
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
    mukca_corrected_differentiate(J, &at, &slopes);
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
