/* The wording of a diagnosis: the recording, its faults, and effects that the data cannot test. */
#include <math.h>
#include <string.h>

#include "base/file.h"
#include "math/stats.h"
#include "report/wording.h"

#define put mukca_wording_put /* short for this file */

/* The other stream of angles is recommended if its residual is below this fraction: effects of the
 * arm account for less than a fifth. */
static const double worth_changing = 0.8;

/* A joint whose effects must be larger than this to be detected (rad rms, 1.7 degrees) counts as
 * not testable: no cause of a calibrated arm is that large. */
static const double useless_limit = 30e-3;

const char *mukca_wording_fault(char text[MUKCA_WORDING], const mukca_data_fault *f,
                                const mukca_diagnosed *r)
{
    const mukca_dataset *data = r->data;
    const double mm = 1e3 * f->size_m;
    bool creep = false;
    for (int i = 0; i < r->diagnosis->n_causes; i++) {
        const mukca_cause *c = &r->diagnosis->causes[i];
        creep |= c->creep && c->socket == f->socket && c->row == f->row;
    }
    if (f->placement >= 0) put(text, "%s, ", data->placements[f->placement].name);
    if (f->socket >= 0) put(text, "socket %s, ", data->sockets[f->socket].label);
    put(text, "row %d of %s: ", f->row,
        data->files ? mukca_file_name(data->files[f->file]) : "the recording");
    if (f->kind == MUKCA_FAULT_TOOL_MOTION && creep)
        return put(text, "the tool crept by %.2f mm from here on; record this socket again", mm);
    if (f->kind == MUKCA_FAULT_TOOL_MOTION)
        return put(text,
                   "the tool moved by %.2f mm before it, or a joint slipped; record this socket "
                   "again",
                   mm);
    if (f->kind == MUKCA_FAULT_WRONG_SOCKET)
        return put(text, "the ball was in another socket (%.1f mm away); correct its label", mm);
    if (f->kind == MUKCA_FAULT_OUTLIER)
        return put(text, "outlier of %.2f mm, not used; record it again", mm);
    return put(text, "repeats the row before; record another posture");
}

/* ---- what the data can show ---- */

/* Median of the detection limits of a joint's effects, rad; NaN: none. */
static double joint_limit(const mukca_diagnosis *d, int joint)
{
    double limit[MUKCA_EFFECT_COUNT] = {0};
    int n = 0;
    for (int i = 0; i < d->n_tested && n < MUKCA_EFFECT_COUNT; i++)
        if (d->tested[i].joint == joint && isfinite(d->tested[i].limit))
            limit[n++] = d->tested[i].limit;
    return n ? mukca_stats_median(limit, n) : (double)NAN;
}

const char *mukca_wording_limits(char text[MUKCA_WORDING], const mukca_diagnosed *r)
{
    for (int j = 0; j < r->chain->n_joints; j++) {
        const double limit = joint_limit(r->diagnosis, j);
        if (limit < useless_limit)
            put(text, "%s %s %.*f%s",
                *text ? "," : "Detection limits, mrad rms (median over effects):",
                mukca_chain_joint_name(r->chain, j), limit < 1e-5 ? 4 : 2, 1e3 * limit,
                mukca_wording_slides(r->chain, j) ? " mm" : "");
    }
    return text;
}

/* Whether two tested effects have one reason; at joints, or of the whole arm. */
static bool same_reason(const mukca_tested *a, const mukca_tested *b)
{
    return !a->testable && !b->testable && (a->joint < 0) == (b->joint < 0) &&
           strcmp(a->why, b->why) == 0;
}

const char *mukca_wording_untestable(char text[MUKCA_WORDING], int tested, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    const mukca_tested *effect = &d->tested[tested];
    const int needs = mukca_effect_table[effect->effect]->needs;
    bool joint[MUKCA_MAX_JOINTS] = {false}, kind[MUKCA_EFFECT_COUNT] = {false};
    int kinds = 0, joints = 0, n = 0, first = 0;
    while (first < tested && !same_reason(&d->tested[first], effect)) first++;
    /* with readings, errors of commands are not mentioned */
    if (effect->testable || first < tested ||
        (r->data->n_sockets == 0 && mukca_effect_of_sockets(effect->effect)) ||
        (needs & MUKCA_NEEDS_COMMANDS && !r->data->by_command))
        return text;
    for (const mukca_tested *t = effect; t < d->tested + d->n_tested; t++) {
        if (!same_reason(t, effect)) continue;
        kinds += !kind[t->effect];
        kind[t->effect] = true;
        if (t->joint >= 0) joints += !joint[t->joint], joint[t->joint] = true;
    }
    const bool many = kinds > 3 && joints > 0;
    if (many) put(text, "%d effects", kinds);
    for (int k = 0; k < MUKCA_EFFECT_COUNT; k++)
        if (kind[k] && !many) put(text, "%s%s", n++ ? ", " : "", mukca_effect_table[k]->title);
    for (int j = 0, at = 0; j < r->chain->n_joints; j++)
        if (joint[j]) put(text, "%s%s", at++ ? ", " : " at ", mukca_chain_joint_name(r->chain, j));
    return put(text, " (%s)", effect->why);
}

/* ---- the recording ---- */

const char *mukca_wording_logs(char text[MUKCA_WORDING], const mukca_diagnosed *r)
{
    const mukca_logs *logs = &r->diagnosis->logs;
    const double *evidence = logs->log_evidence;
    const int chosen = logs->base_per_log + 2 * logs->tool_per_log;
    static const char *const bias[] = {"", "a tracker's frame", "a target's offset",
                                       "a tracker's frame and a target's offset"};
    if (logs->n > 1 && r->data->n_targets > 1)
        return put(text, "each of the %d targets has its own position on the tool", logs->n);
    if (logs->n < 2 || !(isfinite(evidence[1]) || isfinite(evidence[2]))) return text;
    if (!chosen) return put(text, "the %d pose logs share the free frames", logs->n);
    return put(text, "each of the %d pose logs has %s of its own (log Bayes factor %.3g)", logs->n,
               bias[chosen], evidence[chosen] - evidence[0]);
}

const char *mukca_wording_angles(char text[MUKCA_WORDING], const mukca_diagnosed *r)
{
    const mukca_streams *s = &r->diagnosis->streams;
    const bool command = r->data->by_command;
    int largest = 0, n = 0;
    for (int j = 1; j < s->n_joints; j++)
        if (s->joint[j].rms > s->joint[largest].rms) largest = j;
    if (s->n_joints == 0 || !(s->joint[largest].rms > 0)) return text;
    put(text, "%s fitted; reading minus command: at most %.3f mrad rms (%s)",
        command ? "commands" : "readings", 1e3 * s->joint[largest].rms,
        mukca_chain_joint_name(r->chain, largest));
    for (const mukca_stream_difference *difference = s->joint; difference < s->joint + s->n_joints;
         difference++)
        if (difference->log_bayes_factor > MUKCA_SAG_EVIDENT && difference->sag > 0)
            put(text, "%s %s %.3g urad/(N·m) [%.3g, %.3g]", n++ ? "," : "; servo sag",
                mukca_chain_joint_name(r->chain, (int)(difference - s->joint)),
                1e6 * difference->sag, 1e6 * difference->low, 1e6 * difference->high);
    if (isfinite(s->sigma_command_m))
        put(text, "; residual of the geometry: %.3f mm with readings, %.3f mm with commands",
            1e3 * s->sigma_reading_m, 1e3 * s->sigma_command_m);
    const double ratio = s->sigma_command_m / s->sigma_reading_m;
    if (command ? ratio > 1 / worth_changing : ratio < worth_changing)
        put(text, ": fit the %s (--angles %s)", command ? "readings" : "commands",
            command ? "reading" : "command");
    return text;
}

const char *mukca_wording_efforts(char text[MUKCA_WORDING], const mukca_diagnosed *r)
{
    const double correlation = r->diagnosis->efforts_correlation;
    if (r->diagnosis->turned_efforts)
        return put(
            text,
            "the sign of the measured efforts was reversed: as recorded, the joints would "
            "deflect against their load; record the torque that the joint exerts on the arm");
    if (!(correlation < 0.5)) return text;
    return put(text,
               "measured efforts %s the torques that hold the arm (correlation %.2f) and were not "
               "used; %s",
               correlation < -0.5 ? "oppose" : "differ from", correlation,
               correlation < -0.5 ? "write them as the torque that the joint exerts on the arm"
                                  : "check their unit (N·m), their joints and the masses");
}
