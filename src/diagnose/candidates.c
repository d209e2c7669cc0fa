/* The list of candidate causes for a recording, with their prior odds. */
#include "diagnose/candidates.h"

#include <math.h>
#include <string.h>

enum {
    LONGEST_BURST = 3, /* samples that a badly seated ball may stay so */
    MOST_SLIPS = 200   /* rows at which a joint is tried for a slip */
};

typedef struct {
    mukca_candidates *all;
    mukca_pool *pool;
    const mukca_recording *recording;
    const mukca_unknowns *unknowns;
    const unsigned char *disabled;
    bool ok;
} lister;

static void append(lister *l, mukca_candidate h)
{
    mukca_candidates *all = l->all;
    const int class = mukca_candidate_class(&h);
    if (!l->ok || (class < MUKCA_EFFECT_COUNT && l->disabled && l->disabled[class])) return;
    if (all->count == all->capacity) {
        const int capacity = all->capacity ? 2 * all->capacity : 512;
        mukca_candidate *bigger = MUKCA_TAKE(l->pool, mukca_candidate, capacity);
        if (!bigger) {
            l->ok = false;
            return;
        }
        if (all->count) memcpy(bigger, all->list, sizeof *bigger * (size_t)all->count);
        all->list = bigger;
        all->capacity = capacity;
    }
    l->ok = mukca_candidate_prepare(&h, l->pool, l->recording);
    all->list[all->count++] = h;
}

static void append_effect(lister *l, mukca_effect_kind kind, int joint, int variant, int placement)
{
    append(l, (mukca_candidate){
                  .kind = MUKCA_CANDIDATE_EFFECT,
                  .joint = joint,
                  .placement = placement,
                  .effect = {
                      .kind = kind, .joint = joint, .variant = variant, .placement = placement}});
}

/* Largest minus smallest angle of a joint. */
static double turned(const lister *l, int joint)
{
    double range[2];
    mukca_recording_range(range, l->recording, l->recording->data->q, l->recording->chain->n_joints,
                          joint);
    return range[1] - range[0];
}

/* Effects that need gravity to load the joint differently. */
static void list_elastic(lister *l, int j, bool turns)
{
    static const int torque_scales[] = {300, 1000, 3000};
    const mukca_recording *recording = l->recording;
    const int n_joints = recording->chain->n_joints;
    if (recording->have_torques) {
        double range[2], least = HUGE_VAL;
        mukca_recording_range(range, recording, recording->total_torque, n_joints, j);
        for (int row = 0; row < recording->data->n_rows; row++)
            least = fmin(least, fabs(recording->total_torque[row * n_joints + j]));
        const double most = fmax(fabs(range[0]), fabs(range[1]));
        if (most > 0.05 && range[1] - range[0] > 0.01) {
            append_effect(l, MUKCA_EFFECT_JOINT_COMPLIANCE, j, 0, -1);
            if ((range[0] < 0 && range[1] > 0) || least < 0.3 * most)
                for (int i = 0; i < 3; i++)
                    append_effect(l, MUKCA_EFFECT_BACKLASH, j, torque_scales[i], -1);
        }
    }
    if (recording->have_moments && turns) append_effect(l, MUKCA_EFFECT_LINK_BENDING, j, 0, -1);
}

/* Unknown functions that turn a joint by anything but its own angle. */
static void list_other_functions(lister *l, int j)
{
    static const int time_constants[] = {300, 1000, 3000};
    const mukca_recording *recording = l->recording;
    const mukca_unknowns *unknowns = l->unknowns;
    const int element = recording->chain->joint_element[j], rows = recording->data->n_rows;
    const int *socket = recording->data->socket;
    mukca_candidate h = {.joint = j, .placement = -1};
    for (h.other = 0; h.other < recording->chain->n_joints; h.other++)
        for (int both = 0; both < 2; both++) {
            h.kind = both ? MUKCA_CANDIDATE_ANGLE_PRODUCT : MUKCA_CANDIDATE_OTHER_ANGLE;
            if (h.other != j && turned(l, h.other) > 0.1) append(l, h);
        }
    h.kind = MUKCA_CANDIDATE_TIME;
    append(l, h);
    /* A slip of the first joint, or in the last socket, moves one socket and nothing else that is
     * seen: that is a moved tool. */
    h.kind = MUKCA_CANDIDATE_SLIP;
    int end = rows - LONGEST_BURST;
    while (end > 0 && socket[end - 1] >= 0 && socket[end - 1] == socket[rows - 1]) end--;
    for (h.row = LONGEST_BURST; h.row < end && unknowns->slot_element[0] <= element;
         h.row += rows / MOST_SLIPS + 1)
        append(l, h);
    h.kind = MUKCA_CANDIDATE_STRETCH;
    for (int k = 0; k < unknowns->n_slots; k++)
        for (int i = 0; i < 3 && unknowns->slot_element[k] == element; i++) {
            h.stretch.slot = k, h.stretch.time_constant = time_constants[i];
            append(l, h);
        }
}

static void list_joint(lister *l, int j, bool moved)
{
    static const int time_constants[] = {0, 300, 1000, 3000};
    static const int wobbles[] = {1, 2, 11, 12, 98, 99, 102, 103};
    static const int widths_mrad[] = {120, 250, 500, 1000};
    const mukca_recording *recording = l->recording;
    const int n_joints = recording->chain->n_joints, placements = recording->data->n_placements;
    const bool turns =
        recording->chain->element[recording->chain->joint_element[j]].type != MUKCA_PRISMATIC;
    list_elastic(l, j, turns);
    for (int i = 0; i < 4; i++)
        append_effect(l, MUKCA_EFFECT_JOINT_DRIFT, j, time_constants[i], -1);
    for (int p = 0; placements > 1 && p < placements; p++)
        append_effect(l, MUKCA_EFFECT_ZERO_JUMP, j, 0, p);
    for (int side = -1; side <= 1; side += 2)
        if (j + side >= 0 && j + side < n_joints && turned(l, j + side) > 1e-3)
            append_effect(l, MUKCA_EFFECT_JOINT_COUPLING, j, side, -1);
    list_other_functions(l, j);
    const double range = turned(l, j);
    if (range < 1e-3) return;
    if (moved) append_effect(l, MUKCA_EFFECT_APPROACH_HYSTERESIS, j, 0, -1);
    append_effect(l, MUKCA_EFFECT_JOINT_SCALE, j, 0, -1);
    if (!turns) return;
    for (int i = 0; i < 4 && range > 0.1; i++) {
        const double width =
            1e-3 * widths_mrad[i]; /* two bumps or more, as many as there is room */
        if (width <= 0.6 * range && (int)ceil(range / width) + 1 <= MUKCA_MAX_COLUMNS)
            append(l, (mukca_candidate){.kind = MUKCA_CANDIDATE_OWN_ANGLE,
                                        .joint = j,
                                        .placement = -1,
                                        .width = width});
    }
    append_effect(l, MUKCA_EFFECT_ENCODER_ECCENTRICITY, j, 0, -1);
    for (size_t i = 0; i < sizeof wobbles / sizeof *wobbles; i++)
        append_effect(l, MUKCA_EFFECT_AXIS_WOBBLE, j, wobbles[i], -1);
}

/* Faults that begin at sample i of a group. */
static void list_faults_at(lister *l, int g, int i)
{
    const mukca_group *group = &l->recording->groups[g];
    const int *rows = l->recording->order + group->start, last = group->count - 1;
    mukca_candidate h = {.kind = MUKCA_CANDIDATE_OUTLIER,
                         .joint = -1,
                         .placement = group->placement,
                         .fault = {.group = g, .first = rows[i], .last = rows[i]}};
    append(l, h);
    /* A few samples at either end: a move there and a badly seated ball are indistinguishable. */
    for (int n = 1; n < LONGEST_BURST && i + n <= last; n++)
        if (i == 0 || i + n == last) {
            h.fault.last = rows[i + n];
            append(l, h);
        }
    if (group->socket < 0 || i < LONGEST_BURST || i > last - LONGEST_BURST) return;
    h.kind = MUKCA_CANDIDATE_STEP;
    append(l, h);
}

static void list_faults(lister *l)
{
    for (int g = 0; g < l->recording->n_groups; g++) {
        const mukca_group *group = &l->recording->groups[g];
        for (int i = 0; i < group->count; i++) list_faults_at(l, g, i);
        if (group->socket < 0 || group->count < 2 * LONGEST_BURST) continue;
        append(l, (mukca_candidate){
                      .kind = MUKCA_CANDIDATE_CREEP,
                      .joint = -1,
                      .placement = group->placement,
                      .fault = {.group = g, .first = l->recording->order[group->start]}});
    }
}

/* Prior odds: equal per class, then per joint, then per variant; a quarter of tool motions creep,
 * half of the outliers are bursts, half of the unknown functions have another argument than the
 * joint's own angle alone. */
static void set_priors(mukca_candidates *all)
{
    int variants[MUKCA_CLASSES][MUKCA_MAX_JOINTS + 1] = {{0}}, crossed[MUKCA_MAX_JOINTS + 1] = {0};
    int joints[MUKCA_CLASSES] = {0}, kinds[MUKCA_CANDIDATE_KINDS] = {0}, single = 0;
    for (int i = 0; i < all->count; i++) {
        const mukca_candidate *h = &all->list[i];
        const int class = mukca_candidate_class(h), slot = h->joint + 1;
        const bool cross = class == MUKCA_CLASS_UNKNOWN && h->kind != MUKCA_CANDIDATE_OWN_ANGLE;
        single += h->kind == MUKCA_CANDIDATE_OUTLIER && h->fault.last == h->fault.first;
        all->enabled[class] = true;
        kinds[h->kind]++;
        if (!variants[class][slot] && !(class == MUKCA_CLASS_UNKNOWN && crossed[slot]))
            joints[class]++;
        ++*(cross ? &crossed[slot] : &variants[class][slot]);
    }
    all->classes = all->harmonics;
    for (int c = 0; c < MUKCA_CLASSES; c++) all->classes += all->enabled[c];
    for (int i = 0; i < all->count; i++) {
        mukca_candidate *h = &all->list[i];
        const int class = mukca_candidate_class(h), slot = h->joint + 1;
        double share = 1.0 / joints[class]; /* of the class */
        if (h->kind == MUKCA_CANDIDATE_OUTLIER) {
            const bool burst = h->fault.last != h->fault.first;
            share = 0.5 / (burst ? kinds[h->kind] - single : single);
        } else if (mukca_candidate_is_fault(h)) {
            share = 1.0 / kinds[h->kind];
            if (kinds[MUKCA_CANDIDATE_CREEP])
                share *= h->kind == MUKCA_CANDIDATE_CREEP ? 0.25 : 0.75;
        } else if (class == MUKCA_CLASS_UNKNOWN && crossed[slot] && variants[class][slot]) {
            share *= 0.5 /
                     (h->kind == MUKCA_CANDIDATE_OWN_ANGLE ? variants[class][slot] : crossed[slot]);
        } else {
            share /= variants[class][slot] + (class == MUKCA_CLASS_UNKNOWN ? crossed[slot] : 0);
        }
        h->log_prior = log(share / all->classes);
    }
}

static const char *reason_missing(mukca_effect_kind kind, bool sockets)
{
    const int needs = mukca_effect_table[kind].needs;
    if (needs & MUKCA_NEEDS_MASSES) return "no masses: give --inertials FILE";
    if (needs & MUKCA_NEEDS_PLACEMENTS)
        return sockets ? "one placement only: record a second one"
                       : "a log of poses has no placements";
    if (!(needs & MUKCA_NEEDS_SOCKETS))
        return needs & MUKCA_NEEDS_ORDER ? "no moves between rows" : "no joint moved enough";
    if (!sockets) return "a log of poses has no sockets";
    return kind == MUKCA_EFFECT_TOOL_MOTION
               ? "too few rows in each socket: record 20 or more"
               : "needs two pairs of sockets a known distance apart: record another placement";
}

mukca_status mukca_candidates_list(mukca_candidates *all, mukca_pool *pool,
                                   const mukca_recording *recording, const mukca_unknowns *unknowns,
                                   const unsigned char *disabled, mukca_error *error)
{
    lister l = {.all = all,
                .pool = pool,
                .recording = recording,
                .unknowns = unknowns,
                .disabled = disabled,
                .ok = true};
    const mukca_dataset *data = recording->data;
    const int n_joints = recording->chain->n_joints, rows = data->n_rows;
    bool moved = false, commanded = false, sockets = false;
    memset(all, 0, sizeof *all);
    for (int j = 0; j < n_joints; j++) {
        double range[2];
        mukca_recording_range(range, recording, recording->move, n_joints, j);
        moved |= range[1] - range[0] > 1e-6;
    }
    for (int i = 0; recording->command && i < rows * n_joints; i++)
        commanded |= fabs(recording->command[i] - data->q[i]) > 1e-7;
    for (int j = 0; j < n_joints; j++) list_joint(&l, j, moved);
    if (recording->have_moments) append_effect(&l, MUKCA_EFFECT_BASE_COMPLIANCE, -1, 0, -1);
    if (moved) append_effect(&l, MUKCA_EFFECT_READBACK_LAG, -1, 0, -1);
    if (commanded) append_effect(&l, MUKCA_EFFECT_READBACK_LAG, -1, 1, -1);
    for (int p = 0; data->n_placements > 1 && p < data->n_placements; p++)
        append_effect(&l, MUKCA_EFFECT_BALL_SHIFT, -1, 0, p);
    /* a wrong distance in all placements, or in one */
    for (int p = -1; recording->n_pairs > 1 && p < data->n_placements; p++)
        append(&l,
               (mukca_candidate){.kind = MUKCA_CANDIDATE_DISTANCE, .joint = -1, .placement = p});
    list_faults(&l);
    if (!l.ok)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for the candidates of %d rows", rows);
    all->harmonics = !(disabled && disabled[MUKCA_EFFECT_GEAR_HARMONIC]);
    set_priors(all);
    for (int g = 0; g < recording->n_groups; g++) sockets |= recording->groups[g].socket >= 0;
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++)
        if (!all->enabled[kind] && kind != MUKCA_EFFECT_GEAR_HARMONIC)
            all->missing[kind] = disabled && disabled[kind]
                                     ? "left out on request"
                                     : reason_missing((mukca_effect_kind)kind, sockets);
    return MUKCA_OK;
}
