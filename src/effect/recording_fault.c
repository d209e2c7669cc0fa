/* Recording faults: effects on sockets instead of the arm. */
#include "effect/catalogue.h"

/* No candidates: the diagnosis lists one per sample of each socket. */
const mukca_effect_ops mukca_tool_motion_effect = {
    .sizes = &mukca_sizes_socket,
    .info = {.name = "tool_motion",
             .title = "tool motion",
             .site = MUKCA_SITE_SOCKET,
             .terms = 3,
             MUKCA_IN_MM,
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
             .terms = 1,
             MUKCA_IN_MM,
             .needs = MUKCA_NEEDS_SOCKETS,
             .traits = MUKCA_TRAIT_PER_PLACEMENT | MUKCA_TRAIT_RECORDING_FAULT,
             .sentence = "the sockets are not as far apart as --distance says",
             .remedy = "measure the distance between the sockets and give it as --distance"},
    .candidate = distance_candidate,
    .missing = "needs two pairs of sockets a known distance apart: record another placement",
};
