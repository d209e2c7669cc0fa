/* What a recording cannot test at all, and why. */
#include "diagnose/untested.h"

#include <math.h>

static void add(mukca_diagnosis *d, int kind, int joint, const char *why)
{
    if (d->n_tested == MUKCA_MAX_TESTED) return;
    d->tested[d->n_tested++] = (mukca_tested){.effect = (mukca_effect_kind)kind,
                                              .joint = joint,
                                              .log_bayes_factor = NAN,
                                              .log_odds = NAN,
                                              .limit = NAN,
                                              .testable = false,
                                              .why = why};
}

/* Largest minus smallest of column j of x[rows][n]. */
static double span(const double *x, int rows, int n, int j)
{
    double lo = HUGE_VAL, hi = -HUGE_VAL;
    for (int row = 0; row < rows; row++) {
        lo = fmin(lo, x[row * n + j]);
        hi = fmax(hi, x[row * n + j]);
    }
    return rows ? hi - lo : 0;
}

static const char *reason(int kind, const mukca_recording *recording, int joint)
{
    const int n = recording->chain->n_joints, rows = recording->data->n_rows;
    double most = 0;
    for (int row = 0; row < rows; row++)
        most = fmax(most, fabs(recording->total_torque[row * n + joint]));
    switch (kind) {
        case MUKCA_EFFECT_JOINT_COMPLIANCE:
        case MUKCA_EFFECT_BACKLASH:
            if (most < 0.05) return "gravity does not load it in these poses";
            return kind == MUKCA_EFFECT_BACKLASH
                       ? "gravity holds it on one side in all rows: record poses on both sides"
                       : "gravity loads it alike in all rows: record poses with other lever arms";
        case MUKCA_EFFECT_JOINT_COUPLING:
            return "no neighbour of it moved: record poses that turn them";
        default:
            return span(recording->data->q, rows, n, joint) < 1e-3
                       ? "it did not move: record poses that turn it"
                       : "these rows hold nothing that tells of it";
    }
}

const char *mukca_untested_faint(int kind, int joint)
{
    if (kind == MUKCA_EFFECT_ZERO_JUMP && joint == 0)
        return "turns the whole placement, sockets and all: only a tracker can see it";
    if (joint < 0) return "too faint for these rows: record more";
    return "hardly moves the ball in these poses: turn it further, or mount the ball off its axis";
}

void mukca_untested_add(mukca_diagnosis *d, const mukca_recording *recording,
                        const mukca_candidates *all)
{
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) {
        const mukca_effect_site site = mukca_effect_table[kind].site;
        if (all->missing[kind]) {
            add(d, kind, -1, all->missing[kind]);
            continue;
        }
        if (site != MUKCA_SITE_ANGLE && site != MUKCA_SITE_ROTATION) continue;
        if (kind == MUKCA_EFFECT_GEAR_HARMONIC && !all->harmonics) {
            add(d, kind, -1, "left out on request");
            continue;
        }
        for (int j = 0; j < recording->chain->n_joints; j++) {
            const bool slides =
                recording->chain->element[recording->chain->joint_element[j]].type ==
                MUKCA_PRISMATIC;
            bool listed = slides && (site == MUKCA_SITE_ROTATION ||
                                     kind == MUKCA_EFFECT_ENCODER_ECCENTRICITY ||
                                     kind == MUKCA_EFFECT_GEAR_HARMONIC);
            for (int t = 0; t < d->n_tested && !listed; t++)
                listed = (int)d->tested[t].effect == kind && d->tested[t].joint == j;
            if (!listed) add(d, kind, j, reason(kind, recording, j));
        }
    }
}

int mukca_untested_distinct(const mukca_recording *recording)
{
    const int n = recording->chain->n_joints;
    int distinct = 0;
    for (int g = 0; g < recording->n_groups; g++)
        for (int i = 0; i < recording->groups[g].count; i++) {
            const int *row = recording->order + recording->groups[g].start + i;
            double most = i ? 0 : HUGE_VAL;
            for (int j = 0; i && j < n; j++)
                most = fmax(most, fabs(recording->data->q[row[0] * n + j] -
                                       recording->data->q[row[-1] * n + j]));
            distinct += most > 1e-5;
        }
    return distinct;
}

void mukca_untested_all(mukca_diagnosis *d, const char *why)
{
    d->verdict = MUKCA_VERDICT_UNTESTABLE;
    d->why = why;
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) add(d, kind, -1, why);
}
