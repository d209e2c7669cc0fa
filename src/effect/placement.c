/* Changes between placements: of a joint's zero, or of the ball's position on the arm. */
#include "effect/catalogue.h"

/* Each coefficient is a coordinate, in one placement; that of a zero is the first. */
static void placement_basis(double basis[][3], const mukca_basis_input *in)
{
    const int placement = in->effect->placement;
    for (int i = 0; i < 3; i++) basis[i][i] = placement >= 0 && in->state->placement == placement;
}

static bool of_placement(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    effect->placement = i;
    return survey->n_placements > 1 && i < survey->n_placements;
}

/* rad: from a nudge of the encoder to a homing that is wrong by a sixth of a motor's turn (a pole
 * pair of its Hall sensors) through a gear of 100, 10 mrad. */
static const mukca_effect_sizes zero_sizes = {.usual = 5,
                                              .sigma = {0.1e-3, 0.3e-3, 1e-3, 3e-3, 10e-3}};

const mukca_effect_ops mukca_zero_jump_effect = {
    .sizes = &zero_sizes,
    .info = {.name = "zero_jump",
             .title = "zero jump",
             .site = MUKCA_SITE_ANGLE,
             .varies_with = MUKCA_VARIES_PLACEMENT,
             .terms = 1,
             .unit = "rad",
             .needs = MUKCA_NEEDS_PLACEMENTS,
             .traits = MUKCA_TRAIT_PER_PLACEMENT,
             .sentence = "the joint's zero differs in one placement from the others (slipped or "
                         "re-homed)",
             .remedy = "check homing and brake of the joint, then record this placement again"},
    .basis = placement_basis,
    .candidate = of_placement,
    .faint_at_first =
        "indistinguishable from a rotation of the placement; only a tracker can detect it",
};

/* m: a ball in its holder. */
static const mukca_effect_sizes ball_sizes = {.usual = 3, .sigma = {0.05e-3, 0.2e-3, 1e-3}};

const mukca_effect_ops mukca_ball_shift_effect = {
    .sizes = &ball_sizes,
    .info = {.name = "ball_shift",
             .title = "ball shift",
             .site = MUKCA_SITE_TIP,
             .varies_with = MUKCA_VARIES_PLACEMENT,
             .terms = 3,
             .unit = "m",
             .needs = MUKCA_NEEDS_PLACEMENTS,
             .traits = MUKCA_TRAIT_PER_PLACEMENT,
             .sentence = "the ball's position on the arm differs in one placement (loose or "
                         "re-mounted)",
             .remedy = "fasten the ball and record this placement again"},
    .basis = placement_basis,
    .term_name = {"x", "y", "z"},
    .candidate = of_placement,
};

/* ---- recording faults: effects on sockets instead of the arm ---- */

/* No candidates: the diagnosis lists one per sample of each socket. */
const mukca_effect_ops mukca_tool_motion_effect = {
    .sizes = &mukca_sizes_socket,
    .info = {.name = "tool_motion",
             .title = "tool motion",
             .site = MUKCA_SITE_SOCKET,
             .varies_with = MUKCA_VARIES_PLACEMENT,
             .terms = 3,
             .unit = "m",
             .needs = MUKCA_NEEDS_SOCKETS,
             .traits = MUKCA_TRAIT_RECORDING_FAULT,
             .sentence =
                 "the tool was pushed or crept while it was being recorded, or a joint slipped",
             .remedy = "fasten the tool and record this placement again"},
    .missing = "too few samples in each socket: record 20 or more",
};

/* The error of all distances, then that of each placement. */
static bool distance_candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    effect->placement = i - 1;
    return survey->pairs && i <= survey->n_placements;
}

const mukca_effect_ops mukca_socket_distance_effect = {
    .sizes = &mukca_sizes_socket,
    .info = {.name = "socket_distance",
             .title = "socket distance",
             .site = MUKCA_SITE_DISTANCE,
             .varies_with = MUKCA_VARIES_PLACEMENT,
             .terms = 1,
             .unit = "m",
             .needs = MUKCA_NEEDS_SOCKETS,
             .traits = MUKCA_TRAIT_PER_PLACEMENT | MUKCA_TRAIT_RECORDING_FAULT,
             .sentence = "the sockets are not as far apart as --distance says",
             .remedy = "measure the distance between the sockets and give it as --distance"},
    .candidate = distance_candidate,
    .missing = "needs two pairs of sockets a known distance apart: record another placement",
};
