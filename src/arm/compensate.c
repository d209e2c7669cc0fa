/* Compensation by inverse kinematics of the corrected arm. */
#include "arm/compensate.h"

#include <math.h>
#include <string.h>

#include "arm/inverse.h"

#define REACH_TEXT(name, text, sentence) text,
#define REACH_SENTENCE(name, text, sentence) sentence,
const char *const mukca_reach_text[MUKCA_REACH_COUNT] = {MUKCA_REACH_LIST(REACH_TEXT)};
const char *const mukca_reach_sentence[MUKCA_REACH_COUNT] = {MUKCA_REACH_LIST(REACH_SENTENCE)};
#undef REACH_TEXT
#undef REACH_SENTENCE

/* A joint step (rad, m) larger than any correction of a calibrated arm, and than any step between
 * rows of a path.  Of the target, m and rad: tolerance. */
static const double far = 0.5, tolerance = 1e-8;

void mukca_compensator_start(mukca_compensator *c, const mukca_corrected *arm, bool position_only)
{
    memset(c, 0, sizeof *c);
    c->arm = arm;
    c->position_only = position_only || arm->chain.n_joints < 6;
    mukca_geometry_set(&c->nominal, &arm->chain, NULL);
    mukca_row_state_start(&c->rows, arm->chain.n_joints);
}

static void displace(mukca_displacement *displacement, const double *q, void *context)
{
    mukca_compensator *c = context;
    mukca_effects_displacement(displacement, c->arm->effects, c->arm->n_effects, &c->arm->chain,
                               &c->arm->geometry, mukca_row_state_set(&c->rows, q));
}

mukca_compensation mukca_compensate_joints(double *q, mukca_compensator *c,
                                           const mukca_row_reading *reading)
{
    const int n = c->arm->chain.n_joints;
    double meant[MUKCA_MAX_JOINTS], correction[MUKCA_MAX_JOINTS], before[MUKCA_MAX_JOINTS];
    mukca_frame target, uncorrected;
    mukca_displacement displacement = {0};
    mukca_row_reading row = {.time = (double)NAN, .placement = -1, .number = c->rows.number + 1};
    if (reading) row = *reading;
    memcpy(meant, q, (size_t)n * sizeof *q);
    mukca_fk_pose(&target, &c->nominal, meant, NULL);
    row.q = meant;
    row.command = NULL;
    mukca_row_state_next(&c->rows, &row);
    displace(&displacement, meant, c);
    mukca_fk_pose(&uncorrected, &c->arm->geometry, meant, &displacement);

    const mukca_inverse_result found = mukca_inverse_solve(
        q, &c->arm->chain, &c->arm->geometry, &target, !c->position_only,
        &(mukca_inverse_options){
            .tolerance = tolerance, .displace = c->arm->n_effects ? displace : NULL, .context = c});
    mukca_compensation result = {.reach = found.reached   ? MUKCA_REACH_OK
                                          : found.limited ? MUKCA_REACH_LIMIT
                                                          : MUKCA_REACH_UNREACHED,
                                 .position_before = mukca_distance3(uncorrected.p, target.p),
                                 .position_error = found.position_error,
                                 .rotation_error = found.rotation_error};
    for (int j = 0; j < n; j++) {
        correction[j] = q[j] - meant[j];
        before[j] = c->sent[j] - c->target[j];
    }
    if (result.reach == MUKCA_REACH_OK && mukca_largest_difference(q, meant, n) > far)
        result.reach = MUKCA_REACH_FAR;
    const double moved = mukca_largest_difference(meant, c->target, n);
    if (result.reach == MUKCA_REACH_OK && c->on_path && moved < far &&
        mukca_largest_difference(correction, before, n) > 0.02 + 0.5 * moved)
        result.reach = MUKCA_REACH_JUMP;
    memcpy(c->target, meant, (size_t)n * sizeof *q);
    memcpy(c->sent, q, (size_t)n * sizeof *q);
    c->on_path = true;
    mukca_row_state_set(&c->rows, q);
    return result;
}
