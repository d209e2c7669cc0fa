/* The corrected arm: parsed from an offsets table alone; kinematics with effects. */
#include "mukca/corrected.h"

#include <string.h>

#include "arm/offsets.h"
#include "effect/catalogue.h"

mukca_status mukca_corrected_parse_named(mukca_corrected *model, const char *text, size_t size,
                                         const char *name, int accept, mukca_error *error)
{
    double theta[MUKCA_MAX_THETA];
    unsigned char listed[MUKCA_MAX_THETA] = {0};
    mukca_acceptance acceptance;
    mukca_offsets_origin origin = {.name = name, .accept = accept, .embedded = &model->chain};
    const mukca_offsets_target into = {.theta = theta,
                                       .listed = listed,
                                       .n_effects = &model->n_effects,
                                       .effects = model->effects,
                                       .acceptance = &acceptance};
    memset(model, 0, sizeof *model);
    const mukca_status status = mukca_offsets_parse_into(&into, &origin, NULL, text, size, error);
    model->judged = acceptance.given;
    model->accepted = acceptance.accepted;
    model->intact = acceptance.intact;
    if (status == MUKCA_OK) mukca_geometry_set(&model->geometry, &model->chain, theta);
    return status;
}

mukca_status mukca_corrected_parse(mukca_corrected *model, const char *text, size_t size,
                                   mukca_error *error)
{
    return mukca_corrected_parse_named(model, text, size, "offsets table", 0, error);
}

/* Displacement at the encoder angles q. */
static void find_displacement(mukca_displacement *displacement, mukca_effect_slopes *slopes,
                              const mukca_corrected *model, const double *q,
                              const mukca_joint_state *state)
{
    static const mukca_joint_state none = {.placement = -1};
    mukca_effect_task task = {.effects = model->effects,
                              .n_effects = model->n_effects,
                              .chain = &model->chain,
                              .geometry = &model->geometry,
                              .state = state ? *state : none};
    task.state.q = q;
    mukca_effects_apply(displacement, slopes, &task);
}

void mukca_corrected_position(double position[3], const mukca_corrected *model, const double *q,
                              const mukca_joint_state *state)
{
    mukca_frame tip;
    mukca_corrected_pose(&tip, model, q, state);
    memcpy(position, tip.p, sizeof tip.p);
}

void mukca_corrected_pose(mukca_frame *T_base_tip, const mukca_corrected *model, const double *q,
                          const mukca_joint_state *state)
{
    mukca_displacement displacement;
    if (model->n_effects > 0) find_displacement(&displacement, NULL, model, q, state);
    mukca_fk_pose(T_base_tip, &model->geometry, q, model->n_effects > 0 ? &displacement : NULL);
}

/* J[6][n_joints] by displaced angles := J by encoder angles, column by column. */
static void apply_angle_slopes(double *J, const mukca_effect_slopes *slopes, int n)
{
    for (int i = 0; i < 6; i++) {
        double *row = J + i * n, before = 0; /* of the joint before, on this joint */
        for (int j = 0; j < n; j++) {
            const double turn = row[j], *by = slopes->angle[j];
            row[j] = before + by[1] * turn;
            if (j > 0) row[j - 1] += by[0] * turn;
            before = by[2] * turn;
        }
    }
}

/* Add the motion of the tip by rotations of frames that depend on the joint's angle. */
static __attribute__((noinline)) void add_rotation_slopes(double *J, const double tip[3],
                                                          const mukca_effect_slopes *slopes,
                                                          const mukca_corrected *model,
                                                          const double *q,
                                                          const mukca_displacement *displacement)
{
    const int n = model->chain.n_joints;
    mukca_frame before[MUKCA_MAX_ELEMENTS];
    mukca_fk_frames(before, NULL, &model->geometry, q, displacement);
    for (int j = 0; j < n; j++) {
        const mukca_frame *frame = &before[model->chain.joint_element[j]];
        const double *rate = slopes->rotation[j];
        double rotation[3], angular[3], lever[3], linear[3];
        /* rate of exp([w]x) by that of w, to the second order */
        mukca_cross(rotation, displacement->rotation[j], rate);
        for (int i = 0; i < 3; i++) rotation[i] = rate[i] + 0.5 * rotation[i];
        mukca_mat3_vec(angular, frame->R, rotation);
        for (int i = 0; i < 3; i++) lever[i] = tip[i] - frame->p[i];
        mukca_cross(linear, angular, lever);
        for (int i = 0; i < 3; i++) {
            J[i * n + j] += linear[i];
            J[(3 + i) * n + j] += angular[i];
        }
    }
}

void mukca_corrected_jacobian(double *J, mukca_frame *T_base_tip, const mukca_corrected *model,
                              const double *q, const mukca_joint_state *state)
{
    mukca_displacement displacement;
    mukca_effect_slopes slopes;
    mukca_frame tip;
    if (model->n_effects == 0) {
        mukca_fk_jacobian(J, T_base_tip, &model->geometry, q, NULL);
        return;
    }
    find_displacement(&displacement, &slopes, model, q, state);
    mukca_fk_jacobian(J, &tip, &model->geometry, q, &displacement);
    apply_angle_slopes(J, &slopes, model->chain.n_joints);
    if (slopes.rotates) add_rotation_slopes(J, tip.p, &slopes, model, q, &displacement);
    if (T_base_tip) *T_base_tip = tip;
}
