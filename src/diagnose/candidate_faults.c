/* Recording faults as candidates: outliers, and motions of the tool. */
#include "diagnose/candidates.h"

enum {
    LONGEST_BURST = 3,   /* successive postures with a badly seated ball */
    LONGEST_SETTLING = 8 /* samples until one has settled to a tenth */
};

/* Last sample of the stay at a posture in which sample i of a group was read. */
static int stay_end(const mukca_recording *r, int g, int i)
{
    const int *next = r->samples.next + r->groups[g].start;
    while (next[i] == r->groups[g].start + i + 1) i++;
    return i;
}

/* List the outliers that begin at sample i of a group. */
static void list_outliers_at(mukca_candidates *all, int g, int i)
{
    const mukca_group *group = &all->recording->groups[g];
    const int *rows = all->recording->order + group->start, last = group->count - 1;
    mukca_candidate h = {.kind = MUKCA_CANDIDATE_OUTLIER,
                         .joint = -1,
                         .placement = group->placement,
                         .fault = {.group = g, .first = rows[i], .last = rows[i]}};
    mukca_candidates_append(all, h);
    /* A badly seated ball, or a bad target, spoils all readings of a posture. */
    h.fault.last = rows[stay_end(all->recording, g, i)];
    if (h.fault.last != h.fault.first) mukca_candidates_append(all, h);
    if (group->socket >= 0 && i < last) {
        h.fault.last = rows[i + LONGEST_SETTLING < last ? i + LONGEST_SETTLING : last];
        h.fault.shape = MUKCA_FAULT_FADING;
        mukca_candidates_append(all, h);
    }
}

/* Was a socket of the same placement recorded completely before this group?  Then a tool that moved
 * in between changes their distance. */
static bool follows_another(const mukca_recording *r, int g)
{
    const mukca_group *group = &r->groups[g];
    for (int p = 0; p < r->n_pairs; p++) {
        const int o = r->pairs[p].a == g ? r->pairs[p].b : r->pairs[p].b == g ? r->pairs[p].a : -1;
        if (o >= 0 &&
            r->order[r->groups[o].start + r->groups[o].count - 1] < r->order[group->start])
            return true;
    }
    return false;
}

/* List the motions of the tool before a stay of a socket, or before all of them.  A motion before
 * the first or last few is indistinguishable from a badly seated ball: an outlier of all of their
 * readings. */
static void list_motions(mukca_candidates *all, int g)
{
    const mukca_group *group = &all->recording->groups[g];
    const int *rows = all->recording->order + group->start, last = group->count - 1;
    mukca_candidate h = {.joint = -1, .placement = group->placement, .fault.group = g};
    int stays = 0, stay = 0;
    for (int i = 0; i < group->count; i = stay_end(all->recording, g, i) + 1) stays++;
    for (int i = 0; i < group->count; i = stay_end(all->recording, g, i) + 1, stay++) {
        h.kind = MUKCA_CANDIDATE_OUTLIER;
        if (stay > 0 && stay < LONGEST_BURST) {
            h.fault.first = rows[0];
            h.fault.last = rows[stay_end(all->recording, g, i)];
            mukca_candidates_append(all, h);
        }
        h.fault.first = rows[i];
        h.fault.last = rows[last];
        if (stay + 1 < stays && stay + LONGEST_BURST >= stays) mukca_candidates_append(all, h);
        h.kind = MUKCA_CANDIDATE_MOTION;
        h.fault.last = all->recording->data->n_rows - 1;
        if (group->socket >= 0 && stay > LONGEST_BURST && stay + LONGEST_BURST < stays)
            mukca_candidates_append(all, h);
    }
    h.fault.first = rows[0];
    h.fault.last = rows[last];
    h.fault.shape = MUKCA_FAULT_GROWING;
    if (group->socket >= 0 && stays >= 2 * LONGEST_BURST) mukca_candidates_append(all, h);
    h.fault.last = all->recording->data->n_rows - 1;
    h.fault.shape = MUKCA_FAULT_STEADY;
    if (follows_another(all->recording, g)) mukca_candidates_append(all, h);
}

void mukca_candidates_append_faults(mukca_candidates *all)
{
    for (int g = 0; g < all->recording->n_groups; g++) {
        const mukca_group *group = &all->recording->groups[g];
        for (int i = 0; i < group->count; i++) list_outliers_at(all, g, i);
        if (group->count) list_motions(all, g);
    }
}
