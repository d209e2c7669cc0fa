/* What was tested, how small an effect would have shown, and what cannot be tested at all. */
#include "diagnose/untested.h"

#include <math.h>

/* Log evidence grows as amplitude^2 information / 2 and must beat the prior odds, Occam's factor
 * and the threshold: some 12 in all. */
#define LEAST_EVIDENCE 12.0
/* Limits beyond these are no test: errors so large show without a diagnosis.  rad, m. */
#define MOST_ANGLE 10e-3
#define MOST_LENGTH 20e-3

static bool listed(const mukca_tested_list *tested, int kind, int joint)
{
    for (int t = 0; t < tested->count; t++)
        if ((int)tested->list[t].effect == kind && tested->list[t].joint == joint) return true;
    return false;
}

static void add(mukca_tested_list *tested, int kind, int joint, const char *why)
{
    if (tested->count == MUKCA_MAX_TESTED) return;
    tested->list[tested->count++] = (mukca_tested){.effect = (mukca_effect_kind)kind,
                                                   .joint = joint,
                                                   .log_bayes_factor = NAN,
                                                   .log_odds = NAN,
                                                   .limit = NAN,
                                                   .testable = false,
                                                   .why = why};
}

static const char *reason(int kind, const mukca_recording *recording, int joint)
{
    const int n = recording->chain->n_joints;
    double range[2], torque[2];
    mukca_recording_range(range, recording, recording->data->q, n, joint);
    mukca_recording_range(torque, recording, recording->total_torque, n, joint);
    switch (kind) {
        case MUKCA_EFFECT_JOINT_COMPLIANCE:
        case MUKCA_EFFECT_BACKLASH:
            if (fmax(fabs(torque[0]), fabs(torque[1])) < 0.05)
                return "gravity does not load it in these poses";
            return kind == MUKCA_EFFECT_BACKLASH
                       ? "gravity holds it on one side in all rows: record poses on both sides"
                       : "gravity loads it alike in all rows: record poses with other lever arms";
        case MUKCA_EFFECT_JOINT_COUPLING:
            return "no neighbour of it moved: record poses that turn them";
        default:
            return !(range[1] - range[0] >= 1e-3) ? "it did not move: record poses that turn it"
                                                  : "these rows hold nothing that tells of it";
    }
}

static const char *faint(int kind, int joint)
{
    if (kind == MUKCA_EFFECT_ZERO_JUMP && joint == 0)
        return "turns the whole placement, sockets and all: only a tracker can see it";
    if (joint < 0) return "too faint for these rows: record more";
    return "hardly moves the ball in these poses: turn it further, or mount the ball off its axis";
}

/* Add the effects that have no candidate, as a whole or at a joint. */
static void add_missing(mukca_tested_list *tested, const mukca_recording *recording,
                        const mukca_candidates *all)
{
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) {
        const mukca_effect_site site = mukca_effect_table[kind].site;
        if (all->missing[kind]) {
            add(tested, kind, -1, all->missing[kind]);
            continue;
        }
        if (site != MUKCA_SITE_ANGLE && site != MUKCA_SITE_ROTATION) continue;
        if (kind == MUKCA_EFFECT_GEAR_HARMONIC && !all->harmonics) {
            add(tested, kind, -1, "left out on request");
            continue;
        }
        for (int j = 0; j < recording->chain->n_joints; j++) {
            const bool slides =
                recording->chain->element[recording->chain->joint_element[j]].type ==
                MUKCA_PRISMATIC;
            const bool never = slides && (site == MUKCA_SITE_ROTATION ||
                                          kind == MUKCA_EFFECT_ENCODER_ECCENTRICITY ||
                                          kind == MUKCA_EFFECT_GEAR_HARMONIC);
            if (!never && !listed(tested, kind, j))
                add(tested, kind, j, reason(kind, recording, j));
        }
    }
}

void mukca_untested_list(mukca_tested_list *tested, const mukca_competition *contest)
{
    tested->count = 0;
    for (int i = 0; i < contest->n_first && tested->count < MUKCA_MAX_TESTED; i++) {
        const mukca_contender *c = &contest->first[i];
        if (c->class >= MUKCA_EFFECT_COUNT || listed(tested, c->class, c->joint)) continue;
        const mukca_score *score = &contest->first_score[c->best];
        const double limit = sqrt(2 * LEAST_EVIDENCE / fmax(score->information, 1e-12));
        const mukca_effect_site site = mukca_effect_table[c->class].site;
        const bool length = site == MUKCA_SITE_TIP || site == MUKCA_SITE_SOCKET;
        const bool testable = limit < (length ? MOST_LENGTH : MOST_ANGLE);
        tested->list[tested->count++] =
            (mukca_tested){.effect = (mukca_effect_kind)c->class,
                           .joint = c->joint,
                           .log_bayes_factor = score->log_bayes,
                           .log_odds = c->log_odds,
                           .limit = limit,
                           .testable = testable,
                           .why = testable ? NULL : faint(c->class, c->joint)};
    }
    add_missing(tested, &contest->m->recording, contest->all);
}

void mukca_untested_all(mukca_tested_list *tested, const char *why)
{
    tested->count = 0;
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) add(tested, kind, -1, why);
}
