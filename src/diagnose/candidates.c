/* The list of candidate causes for a recording, with their prior odds. */
#include "diagnose/candidates.h"

#include <math.h>
#include <string.h>

#include "diagnose/logs.h"

enum {
    LONGEST_BURST = 3,    /* successive postures with a badly seated ball */
    LONGEST_SETTLING = 8, /* samples until one has settled to a tenth */
    MOST_ORDERS = 36,     /* of the orders of a joint that are added later */
    MOST_SLIPS = 64 /* slips tried per joint: half a step off, a slip in mid-recording loses at
                       most 3 % of its evidence */
};

/* Prior probability that a flexible part, or a servo, deflects by more than an error: each one
 * deflects, and of the some 24 of an arm (joints, links, base) published recordings show one to
 * three. */
#define SHOWS (1.0 / 20)

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
        const int capacity = all->capacity ? 2 * all->capacity : 2048;
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

/* Append the effects of the catalogue at a joint, or (-1) those without a joint. */
static void append_effects(lister *l, int joint)
{
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) {
        mukca_effect e;
        if (mukca_effect_has_joint(kind) != (joint >= 0)) continue;
        for (int i = 0;
             mukca_effect_candidate(&e, (mukca_effect_kind)kind, joint, &l->all->survey, i); i++)
            append(l, mukca_candidate_of(&e));
    }
}

/* List the unknown functions at a joint of any argument but its own angle alone. */
static void list_other_functions(lister *l, int j)
{
    static const double time_constants[] = {300, 1000, 3000}; /* s, as of joint_drift */
    const mukca_recording *recording = l->recording;
    const mukca_unknowns *unknowns = l->unknowns;
    const int element = recording->chain->joint_element[j], rows = recording->data->n_rows;
    const int *socket = recording->data->socket;
    mukca_candidate h = {.joint = j, .placement = -1};
    for (int other = 0; other < recording->chain->n_joints; other++)
        for (int both = 0; both < 2; both++) {
            h.kind = both ? MUKCA_CANDIDATE_ANGLE_PRODUCT : MUKCA_CANDIDATE_OTHER_ANGLE;
            h.of.joint = other;
            if (other != j && l->all->survey.joint[other].range > 0.1) append(l, h);
        }
    h.of.joint = -1;
    h.kind = MUKCA_CANDIDATE_TIME;
    append(l, h);
    /* A slip of the first joint, or in the last socket, is equivalent to a moved socket:
     * tool_motion. */
    h.kind = MUKCA_CANDIDATE_SLIP;
    int end = rows - LONGEST_BURST;
    while (end > 0 && socket[end - 1] >= 0 && socket[end - 1] == socket[rows - 1]) end--;
    for (int row = LONGEST_BURST; row < end && unknowns->slot_element[0] <= element;
         row += rows / MOST_SLIPS + 1) {
        h.of.row = row;
        append(l, h);
    }
    h.of.row = 0;
    h.kind = MUKCA_CANDIDATE_STRETCH;
    for (int k = 0; k < unknowns->n_slots; k++)
        for (int i = 0; i < 3 && unknowns->slot_element[k] == element; i++) {
            h.of.slot = k, h.of.size = time_constants[i];
            append(l, h);
        }
}

/* List the unknown functions of a joint's own angle: two bumps or more, up to MUKCA_MAX_COLUMNS. */
static void list_own_functions(lister *l, int j)
{
    static const double widths[] = {0.03, 0.06, 0.12, 0.25, 0.5, 1}; /* rad */
    const double range = l->all->survey.joint[j].range;
    for (int i = 0; l->all->survey.joint[j].turns && range > 0.1 && i < 6; i++)
        if (widths[i] <= 0.6 * range && (int)ceil(range / widths[i]) + 1 <= MUKCA_MAX_COLUMNS)
            append(l, (mukca_candidate){.kind = MUKCA_CANDIDATE_OWN_ANGLE,
                                        .joint = j,
                                        .placement = -1,
                                        .of = {.joint = j, .size = widths[i]}});
}

/* Last sample of the stay at a posture in which sample i of a group was read. */
static int stay_end(const mukca_recording *r, int g, int i)
{
    const int *next = r->samples.next + r->groups[g].start;
    while (next[i] == r->groups[g].start + i + 1) i++;
    return i;
}

/* List the outliers that begin at sample i of a group. */
static void list_outliers_at(lister *l, int g, int i)
{
    const mukca_group *group = &l->recording->groups[g];
    const int *rows = l->recording->order + group->start, last = group->count - 1;
    mukca_candidate h = {.kind = MUKCA_CANDIDATE_OUTLIER,
                         .joint = -1,
                         .placement = group->placement,
                         .fault = {.group = g, .first = rows[i], .last = rows[i]}};
    append(l, h);
    /* A badly seated ball, or a bad target, spoils all readings of a posture. */
    h.fault.last = rows[stay_end(l->recording, g, i)];
    if (h.fault.last != h.fault.first) append(l, h);
    if (group->socket >= 0 && i < last) {
        h.fault.last = rows[i + LONGEST_SETTLING < last ? i + LONGEST_SETTLING : last];
        h.fault.shape = MUKCA_FAULT_FADING;
        append(l, h);
    }
}

/* List the motions of the tool before a stay of a socket.  A motion before the first or last few is
 * indistinguishable from a badly seated ball: an outlier of all of their readings. */
static void list_motions(lister *l, int g)
{
    const mukca_group *group = &l->recording->groups[g];
    const int *rows = l->recording->order + group->start, last = group->count - 1;
    mukca_candidate h = {.joint = -1, .placement = group->placement, .fault.group = g};
    int stays = 0, stay = 0;
    for (int i = 0; i < group->count; i = stay_end(l->recording, g, i) + 1) stays++;
    for (int i = 0; i < group->count; i = stay_end(l->recording, g, i) + 1, stay++) {
        h.kind = MUKCA_CANDIDATE_OUTLIER;
        if (stay > 0 && stay < LONGEST_BURST) {
            h.fault.first = rows[0];
            h.fault.last = rows[stay_end(l->recording, g, i)];
            append(l, h);
        }
        h.fault.first = rows[i];
        h.fault.last = rows[last];
        if (stay + 1 < stays && stay + LONGEST_BURST >= stays) append(l, h);
        h.kind = MUKCA_CANDIDATE_MOTION;
        h.fault.last = l->recording->data->n_rows - 1;
        if (group->socket >= 0 && stay > LONGEST_BURST && stay + LONGEST_BURST < stays)
            append(l, h);
    }
    h.fault.first = rows[0];
    h.fault.last = rows[last];
    h.fault.shape = MUKCA_FAULT_GROWING;
    if (group->socket >= 0 && stays >= 2 * LONGEST_BURST) append(l, h);
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

static void list_faults(lister *l)
{
    for (int g = 0; g < l->recording->n_groups; g++) {
        const mukca_group *group = &l->recording->groups[g];
        for (int i = 0; i < group->count; i++) list_outliers_at(l, g, i);
        if (group->count) list_motions(l, g);
        if (group->count && follows_another(l->recording, g))
            append(l, (mukca_candidate){.kind = MUKCA_CANDIDATE_MOTION,
                                        .joint = -1,
                                        .placement = group->placement,
                                        .fault = {.group = g,
                                                  .first = l->recording->order[group->start],
                                                  .last = l->recording->data->n_rows - 1}});
    }
}

/* Is an argument of joint k at joint j worth a candidate? */
static bool is_worth_listing(const lister *l, mukca_argument a, int j, int k)
{
    const bool load = (a >= MUKCA_ARGUMENT_LOAD && a <= MUKCA_ARGUMENT_SOFTENING) ||
                      a == MUKCA_ARGUMENT_RUBBING || a == MUKCA_ARGUMENT_CREEP,
               friction = a >= MUKCA_ARGUMENT_LAG && a <= MUKCA_ARGUMENT_WEARING;
    if (l->all->survey.joint[k].range < 0.1 || (load && !l->recording->have_torques)) return false;
    /* the masses' spread covers the loads of other joints; friction acts on its own joint */
    return k == j || (!load && !friction);
}

/* List the unlisted causes: every argument at every joint and frame. */
static void list_unlisted(lister *l)
{
    const mukca_recording *r = l->recording;
    const mukca_unknowns *u = l->unknowns;
    const int n = r->chain->n_joints;
    const bool placements = r->data->n_placements > 1;
    for (int j = 0; j < n; j++)
        for (int a = 0; a <= MUKCA_ARGUMENT_TIME; a++)
            for (int k = 0; k < (a == MUKCA_ARGUMENT_TIME ? 1 : n); k++) {
                if (!is_worth_listing(l, (mukca_argument)a, j, k)) continue;
                append(l, (mukca_candidate){.kind = MUKCA_CANDIDATE_UNLISTED_ANGLE,
                                            .joint = j,
                                            .placement = -1,
                                            .of = {(mukca_argument)a, .joint = k}});
            }
    for (int j = 0; j < n && r->have_torques && r->n_bodies; j++)
        for (int p = -1; p < (placements ? r->data->n_placements : 0); p++)
            append(l, (mukca_candidate){.kind = MUKCA_CANDIDATE_UNLISTED_ANGLE,
                                        .joint = j,
                                        .placement = p,
                                        .of = {MUKCA_ARGUMENT_PAYLOAD, .joint = j}});
    for (int axis = 0; axis < 3; axis++)
        for (int in_tool = 0; in_tool < 2; in_tool++)
            append(l, (mukca_candidate){.kind = MUKCA_CANDIDATE_UNLISTED_TILT,
                                        .joint = n - 1,
                                        .placement = -1,
                                        .of = {.joint = axis, .turns = in_tool}});
    static const mukca_argument of_base[] = {MUKCA_ARGUMENT_TIME, MUKCA_ARGUMENT_SEASON,
                                             MUKCA_ARGUMENT_MOMENT, MUKCA_ARGUMENT_TIPPING};
    for (int i = 0; i < (r->have_moments ? 4 : 2); i++)
        append(l, (mukca_candidate){.kind = MUKCA_CANDIDATE_UNLISTED_BASE,
                                    .joint = -1,
                                    .placement = -1,
                                    .of = {of_base[i]}});
    for (int p = 0; p < r->n_pairs; p++)
        append(l, (mukca_candidate){.kind = MUKCA_CANDIDATE_UNLISTED_PAIR,
                                    .joint = -1,
                                    .placement = r->groups[r->pairs[p].a].placement});
    for (int slot = 0; slot < u->n_slots; slot++) {
        const int joint = r->chain->element[u->slot_element[slot]].joint;
        mukca_candidate h = {.kind = MUKCA_CANDIDATE_UNLISTED_FRAME,
                             .joint = joint < 0 ? n - 1 : joint,
                             .of = {.slot = slot}};
        h.of.joint = h.joint;
        for (int turns = 0; turns < 2; turns++) {
            if (turns && slot + 1 == u->n_slots && u->slot_width < 6) continue;
            h.of.turns = turns;
            h.placement = -1;
            h.of.argument = MUKCA_ARGUMENT_WAVE;
            append(l, h);
            h.of.argument = MUKCA_ARGUMENT_TIME;
            append(l, h);
            h.of.argument = MUKCA_ARGUMENT_MOMENT;
            if (r->have_moments) append(l, h);
            h.of.argument = MUKCA_ARGUMENT_TIPPING;
            if (r->have_moments && turns) append(l, h);
            h.of.argument = MUKCA_ARGUMENT_PLACEMENT;
            for (h.placement = 0; placements && h.placement < r->data->n_placements; h.placement++)
                append(l, h);
        }
    }
}

static double order_prior(const mukca_candidates *all, const mukca_effect *e)
{
    return log(mukca_effect_catalogue[e->kind]->order_prior(e->variant.order)) -
           log(all->survey.n_joints) - log(all->classes);
}

/* Parts of the outliers and of the tool's motions, each with a share of its class. */
typedef enum { SINGLE, BURST, CREEP, BETWEEN, STEP, PARTS } fault_part;

static fault_part part_of(const mukca_candidate *h, const mukca_recording *r)
{
    if (h->kind == MUKCA_CANDIDATE_OUTLIER) return h->fault.last == h->fault.first ? SINGLE : BURST;
    if (h->fault.shape == MUKCA_FAULT_GROWING) return CREEP;
    return h->fault.first == r->order[r->groups[h->fault.group].start] ? BETWEEN : STEP;
}

/* Prior odds: those of flexible parts; else equal per class, then per joint, then per variant; half
 * of the outliers are bursts, a quarter of tool motions creep, another quarter happens between two
 * sockets, half of the unknown functions have another argument than the joint's own angle alone.
 * Unlisted causes are a class of their own, equal per kind. */
static void set_priors(mukca_candidates *all, const mukca_recording *r)
{
    int variants[MUKCA_CLASSES][MUKCA_MAX_JOINTS + 1] = {{0}}, crossed[MUKCA_MAX_JOINTS + 1] = {0};
    int joints[MUKCA_CLASSES] = {0}, kinds[MUKCA_CANDIDATE_KINDS] = {0}, parts[PARTS] = {0};
    for (int i = 0; i < all->first_unlisted; i++) {
        const mukca_candidate *h = &all->list[i];
        const int class = mukca_candidate_class(h), slot = h->joint + 1;
        const bool cross = class == MUKCA_CLASS_UNKNOWN && h->kind != MUKCA_CANDIDATE_OWN_ANGLE;
        if (mukca_effect_has(class, MUKCA_TRAIT_ORDERS))
            continue; /* they have priors of their own */
        if (mukca_candidate_is_fault(h)) parts[part_of(h, r)]++;
        all->enabled[class] = true;
        kinds[h->kind]++;
        if (!variants[class][slot] && !(class == MUKCA_CLASS_UNKNOWN && crossed[slot]))
            joints[class]++;
        ++*(cross ? &crossed[slot] : &variants[class][slot]);
    }
    double of_part[PARTS] = {0.5, 0.5, parts[CREEP] ? 0.25 : 0, parts[BETWEEN] ? 0.25 : 0, 1};
    of_part[STEP] -= of_part[CREEP] + of_part[BETWEEN];
    all->classes = 0;
    for (int c = 0; c < MUKCA_CLASSES; c++) all->classes += all->enabled[c];
    for (int i = 0; i < all->first_unlisted; i++) {
        mukca_candidate *h = &all->list[i];
        const int class = mukca_candidate_class(h), slot = h->joint + 1;
        if (mukca_effect_has(class, MUKCA_TRAIT_ORDERS)) {
            h->log_prior = order_prior(all, &h->effect);
            continue;
        }
        double share = 1.0 / joints[class]; /* of the class */
        if (mukca_candidate_is_fault(h)) {
            const fault_part part = part_of(h, r);
            share = of_part[part] / parts[part];
        } else if (class == MUKCA_CLASS_UNKNOWN && crossed[slot] && variants[class][slot]) {
            share *= 0.5 /
                     (h->kind == MUKCA_CANDIDATE_OWN_ANGLE ? variants[class][slot] : crossed[slot]);
        } else {
            share /= variants[class][slot] + (class == MUKCA_CLASS_UNKNOWN ? crossed[slot] : 0);
        }
        h->log_prior =
            mukca_effect_has(class, MUKCA_TRAIT_ELASTIC) ? log(SHOWS) : log(share / all->classes);
    }
    int listed = 0;
    for (int i = all->first_unlisted; i < all->count; i++) listed += !kinds[all->list[i].kind]++;
    for (int i = all->first_unlisted; i < all->count; i++)
        all->list[i].log_prior = -log((double)all->classes * listed * kinds[all->list[i].kind]);
}

/* If commands are fitted and readings are recorded, too, their difference measures a sag directly:
 * independent data, with evidence that is added to the prior odds. */
static void add_sag_evidence(mukca_candidates *all, const mukca_recording *recording)
{
    const double most =
        20; /* log odds: certain, but not enough for a sag without effect on the ball */
    mukca_streams streams;
    if (!recording->data->by_command || !recording->data->reading) return;
    mukca_streams_compare(&streams, recording);
    for (int i = 0; i < all->count; i++) {
        mukca_candidate *h = &all->list[i];
        if (h->kind != MUKCA_CANDIDATE_EFFECT ||
            !(mukca_effect_table[h->effect.kind]->needs & MUKCA_NEEDS_COMMANDS))
            continue;
        const double evidence = streams.joint[h->joint].log_bayes_factor;
        if (isfinite(evidence)) h->log_prior += fmin(evidence, most);
    }
}

/* Properties of the recording that determine the testable effects. */
static void survey_recording(mukca_effect_survey *s, const mukca_recording *recording)
{
    const mukca_dataset *data = recording->data;
    const int n = recording->chain->n_joints, rows = data->n_rows;
    *s = (mukca_effect_survey){.n_joints = n,
                               .n_placements = data->n_placements,
                               .moments = recording->have_moments,
                               .torques = recording->have_torques,
                               .by_command = data->by_command,
                               .pairs = recording->n_pairs > 1};
    for (int j = 0; j < n; j++) {
        const double *torque = recording->total_torque;
        double range[2];
        mukca_recording_range(range, recording, data->q, n, j);
        s->joint[j].range = range[1] - range[0];
        s->joint[j].turns =
            recording->chain->element[recording->chain->joint_element[j]].type != MUKCA_PRISMATIC;
        mukca_recording_range(range, recording, recording->move, n, j);
        s->moved |= range[1] - range[0] > 1e-6;
        mukca_recording_range(range, recording, torque, n, j);
        s->joint[j].torque_low = range[0], s->joint[j].torque_high = range[1];
        s->joint[j].torque_most = fmax(fabs(range[0]), fabs(range[1]));
        s->joint[j].torque_least = HUGE_VAL;
        for (int row = 0; row < rows; row++)
            s->joint[j].torque_least = fmin(s->joint[j].torque_least, fabs(torque[row * n + j]));
    }
    for (int row = 0; row < rows; row++) s->dwelled |= recording->repeat[row] > 0;
    for (int i = 0; recording->command && i < rows * n; i++)
        s->commanded |= fabs(recording->command[i] - data->q[i]) > 1e-7;
    for (int g = 0; g < recording->n_groups; g++) s->sockets |= recording->groups[g].socket >= 0;
}

static mukca_status no_memory(const mukca_recording *recording, mukca_error *error)
{
    return mukca_fail(error, MUKCA_MEMORY, "out of memory for the candidates of %d rows",
                      recording->data->n_rows);
}

mukca_status mukca_candidates_list_effects(mukca_candidates *all, mukca_pool *pool,
                                           const mukca_recording *recording,
                                           const unsigned char *disabled, mukca_error *error)
{
    lister l = {.all = all,
                .pool = pool,
                .recording = recording,
                .disabled = disabled,
                .ok = true};
    memset(all, 0, sizeof *all);
    survey_recording(&all->survey, recording);
    for (int j = -1; j < recording->chain->n_joints; j++) append_effects(&l, j);
    return l.ok ? MUKCA_OK : no_memory(recording, error);
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
    memset(all, 0, sizeof *all);
    survey_recording(&all->survey, recording);
    for (int j = 0; j < recording->chain->n_joints; j++) {
        append_effects(&l, j);
        list_other_functions(&l, j);
        list_own_functions(&l, j);
    }
    append_effects(&l, -1);
    list_faults(&l);
    all->first_unlisted = all->count;
    list_unlisted(&l);
    if (!l.ok) return no_memory(recording, error);
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) /* whether or not a long wave is listed */
        all->enabled[kind] =
            mukca_effect_has(kind, MUKCA_TRAIT_ORDERS) && !(disabled && disabled[kind]);
    set_priors(all, recording);
    const int most = all->count + MOST_ORDERS * recording->chain->n_joints;
    mukca_candidate *list = MUKCA_TAKE(pool, mukca_candidate, most);
    if (!list) return no_memory(recording, error);
    memcpy(list, all->list, sizeof *list * (size_t)all->count);
    all->list = list;
    all->capacity = most;
    add_sag_evidence(all, recording);
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++)
        if (!all->enabled[kind])
            all->missing[kind] = disabled && disabled[kind]
                                     ? "excluded on request"
                                     : mukca_effect_missing((mukca_effect_kind)kind, &all->survey);
    return MUKCA_OK;
}

mukca_status mukca_candidates_add_order(mukca_candidates *all, mukca_pool *pool,
                                        const mukca_recording *recording,
                                        const mukca_effect *effect, mukca_error *error)
{
    mukca_candidate h = mukca_candidate_of(effect);
    h.log_prior = order_prior(all, effect);
    if (all->count == all->capacity) return MUKCA_OK;
    if (!mukca_candidate_prepare(&h, pool, recording)) return no_memory(recording, error);
    all->list[all->count++] = h;
    return MUKCA_OK;
}
