/* The diagnosis for people: one screen of 80 columns, causes first. */
#include <math.h>
#include <string.h>

#include "base/text.h"
#include "cli/diagnose.h"
#include "math/stats.h"

/* causes with a line of their own, faults and reasons likewise: the screen holds some 30 lines */
enum { MOST_CAUSES = 8, MOST_LINES = 6, TEXT = 1024 };

/* A joint whose effects must be larger than this to be detected (rad rms, 1.7 degrees) counts as
 * not testable: no cause of a calibrated arm is that large. */
static const double useless_limit = 30e-3;

/* Below this the measured poses are the nominal model's own, m: trackers measure 0.05 mm at best.
 */
static const double echo_limit = 5e-5;

/* Held-out errors this much above what is expected are worth a sentence (2 %: the standard
 * deviation of the rms of some thousand coordinates). */
static const double worth_telling = 1.02;

/* The other stream of angles is recommended where it leaves that much less: a fifth is more than an
 * effect of the arm would pass for. */
static const double worth_changing = 0.8;

/* Print the text, if there is any: after a key, or (NULL) as lines; and empty it. */
static void flush(FILE *stream, const char *key, mukca_text *text)
{
    if (text->used && key) cli_print_keyed(stream, key, text->at);
    if (text->used && !key) cli_print_wrapped(stream, 0, text->at);
    text->at[text->used = 0] = '\0';
}

static void print_more(FILE *stream, int n)
{
    char line[80];
    snprintf(line, sizeof line, "and %d more; --json lists them all", n);
    cli_print_keyed(stream, "", line);
}

/* ---- causes ---- */

static void put_amplitude(mukca_text *text, const mukca_cause *c, const mukca_chain *chain)
{
    char amplitude[MUKCA_WORDING], probability[MUKCA_WORDING];
    mukca_wording_amplitude(amplitude, c, chain);
    mukca_wording_probability(probability, c->probability);
    mukca_text_put(text, "%s, %s", amplitude, probability);
}

/* " (indistinguishable in these data; 10 more postures would decide: mukca plan --settle)" */
static void put_tie(mukca_text *text, const mukca_diagnosed *r, const mukca_cause *c)
{
    const mukca_next_poses *next = r->next;
    if (!c->n_ties && !c->or_unknown) return;
    mukca_text_put(text, " (indistinguishable in these data");
    if (mukca_next_poses_need_readings(c)) mukca_text_put(text, "; readings would decide");
    if (next && next->cause >= 0 && c == &r->diagnosis->causes[next->cause]) {
        const mukca_plan *plan = &next->plan;
        if (plan->n_rows > 0 && plan->evidence_after >= MUKCA_PLAN_NAME)
            mukca_text_put(text, "; %d more postures would decide: mukca plan --settle",
                           plan->n_rows);
        else if (plan->n_rows > 0 && plan->rows_to_name > 0)
            mukca_text_put(text,
                           "; some %d more postures would decide: mukca plan --settle --rows %d",
                           plan->rows_to_name, plan->rows_to_name);
        else if (r->data->n_sockets > 0)
            mukca_text_put(text,
                           "; a placement far from these may decide: mukca plan --settle "
                           "--suggest 1");
    }
    mukca_text_put(text, ")");
}

static void print_first(FILE *stream, const mukca_diagnosed *r, const mukca_cause *c)
{
    char line[TEXT] = "", words[MUKCA_WORDING];
    mukca_text text = MUKCA_TEXT(line);
    if (c->n_ties || c->or_unknown) {
        mukca_wording_rivals(words, c, r);
        mukca_text_put(&text, "%s", words);
        put_tie(&text, r, c);
    } else {
        mukca_wording_cause(words, c, r);
        mukca_text_put(&text, "%s: %s", words, mukca_wording_mechanism(c, r));
    }
    flush(stream, "Cause", &text);
    put_amplitude(&text, c, r->chain);
    flush(stream, "", &text);
}

static void print_further(FILE *stream, const mukca_diagnosed *r, const mukca_cause *c,
                          const char *key)
{
    char line[TEXT] = "", words[MUKCA_WORDING];
    mukca_text text = MUKCA_TEXT(line);
    mukca_wording_rivals(words, c, r);
    mukca_text_put(&text, "%s, ", words);
    put_amplitude(&text, c, r->chain);
    put_tie(&text, r, c);
    flush(stream, key, &text);
}

static void print_rest(FILE *stream, const mukca_diagnosis *d)
{
    char line[TEXT] = "";
    mukca_text text = MUKCA_TEXT(line);
    const bool unknown = d->verdict == MUKCA_VERDICT_UNKNOWN;
    const bool unexplained = d->unexplained && !unknown;
    if (!unknown)
        mukca_text_put(&text, unexplained ? "unexplained structure" : "nothing above the noise");
    if ((unexplained || unknown) && d->surprise > worth_telling && isfinite(d->surprise))
        mukca_text_put(&text,
                       "%sheld-out errors are %.2f times those expected from noise and the "
                       "uncertainty of the geometry",
                       unexplained ? ": " : "", d->surprise);
    flush(stream, "Rest", &text);
}

static void print_causes(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    char words[MUKCA_WORDING];
    int printed = d->verdict == MUKCA_VERDICT_UNKNOWN;
    if (printed) {
        mukca_wording_unexplained(words, r);
        cli_print_keyed(stream, "Cause", words);
    }
    for (int i = 0; i < d->n_causes; i++) {
        if (!mukca_wording_on_arm(&d->causes[i])) continue;
        if (printed == 0)
            print_first(stream, r, &d->causes[i]);
        else if (printed <= MOST_CAUSES)
            print_further(stream, r, &d->causes[i], printed == 1 ? "Also" : "");
        printed++;
    }
    if (printed > MOST_CAUSES + 1) print_more(stream, printed - MOST_CAUSES - 1);
    if (printed) {
        print_rest(stream, d);
        return;
    }
    mukca_wording_verdict(words, r);
    cli_print_keyed(stream, "Cause", words);
}

/* ---- held-out errors ---- */

static void print_step(FILE *stream, const char *name, double metres, const char *remark)
{
    if (isfinite(metres))
        fprintf(stream, "  %-28s %8.3f%s%s\n", name, 1e3 * metres, *remark ? "   " : "", remark);
}

static void describe_gain(char remark[120], const mukca_shrink *s)
{
    mukca_text text = {.at = remark, .size = 120};
    remark[0] = '\0';
    if (!isfinite(s->shrink_percent)) return;
    mukca_text_put(&text, "%.0f %% %s", fabs(s->shrink_percent),
                   s->shrink_percent < 0 ? "more" : "less");
    if (isfinite(s->low_percent) && isfinite(s->high_percent))
        mukca_text_put(&text, " [%.0f, %.0f]%s", s->low_percent, s->high_percent,
                       s->low_percent > 0 ? "" : ", not significant");
    mukca_text_put(&text, ", in %d of %d folds", s->folds_better, s->folds);
}

static void print_errors(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    char remark[120], line[TEXT] = "";
    mukca_text text = MUKCA_TEXT(line);
    int causes = 0;
    if (!isfinite(d->nominal_m)) return;
    for (int i = 0; i < d->n_causes; i++) causes += mukca_wording_on_arm(&d->causes[i]);
    fprintf(stream, "\n%s%s error, mm%s", cli_bold(stream), d->folds > 1 ? "Held-out" : "Mean",
            cli_plain(stream));
    if (d->folds > 1)
        fprintf(stream, " (each %s predicted from the others)",
                r->data->n_placements >= 2 ? "placement"
                : r->data->n_sockets > 0   ? "socket"
                                           : "fold of the log");
    fputc('\n', stream);
    print_step(stream, "nominal model", d->nominal_m, "");
    print_step(stream, "calibrated geometry", d->geometry_m, "");
    if (d->n_faults) print_step(stream, "faulty samples excluded", d->faults_excused_m, "");
    describe_gain(remark, &d->held_out);
    if (d->n_causes)
        print_step(stream,
                   causes == 0   ? "geometry and tool motion"
                   : causes == 1 ? "geometry and the cause"
                   : causes == 2 ? "geometry and both causes"
                                 : "geometry and all causes",
                   d->explained_m, remark);
    if (d->structure_m < d->explained_m) /* where it predicts something */
        print_step(stream, "and unexplained structure", d->structure_m, "");
    print_step(stream, "noise floor", d->noise_floor_m, "");
    if (r->test && isfinite(d->test_geometry_m))
        fprintf(stream, "Test data, mm: nominal %.3f, geometry %.3f, with causes %.3f\n",
                1e3 * d->test_nominal_m, 1e3 * d->test_geometry_m, 1e3 * d->test_explained_m);
    if (r->data->n_sockets == 0 || r->data->n_placements >= 4 || !d->n_causes) return;
    mukca_text_put(&text, "Fewer than four placements: the reduction by the causes is uncertain");
    if (isfinite(d->noise_shrink_percent))
        mukca_text_put(&text,
                       " (on pure noise the best effect of the catalogue reduces the error by "
                       "%.0f %%)",
                       d->noise_shrink_percent);
    flush(stream, NULL, &text);
}

/* ---- the recording ---- */

static void put_fault(mukca_text *text, const mukca_diagnosed *r, const mukca_data_fault *f)
{
    const mukca_dataset *data = r->data;
    const double mm = 1e3 * f->size_m;
    bool creep = false;
    const char *path = data->files ? data->files[f->file] : "the recording";
    const char *file = strrchr(path, '/');
    for (int i = 0; i < r->diagnosis->n_causes; i++) {
        const mukca_cause *c = &r->diagnosis->causes[i];
        creep |= c->creep && c->socket == f->socket && c->row == f->row;
    }
    if (f->placement >= 0) mukca_text_put(text, "%s, ", data->placements[f->placement].name);
    if (f->socket >= 0) mukca_text_put(text, "socket %s, ", data->sockets[f->socket].label);
    mukca_text_put(text, "row %d of %s: ", f->row, file ? file + 1 : path);
    if (f->kind == MUKCA_FAULT_TOOL_MOTION)
        mukca_text_put(text, "the tool %s by %.2f mm %s; record this socket again",
                       creep ? "crept" : "moved", mm, creep ? "from here on" : "before it");
    else if (f->kind == MUKCA_FAULT_WRONG_SOCKET)
        mukca_text_put(text, "the ball was in another socket (%.1f mm away); correct its label",
                       mm);
    else if (f->kind == MUKCA_FAULT_OUTLIER)
        mukca_text_put(text, "outlier of %.2f mm, not used; record it again", mm);
    else
        mukca_text_put(text, "repeats the row before; record another posture");
}

static void print_recording(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    char line[TEXT] = "";
    mukca_text text = MUKCA_TEXT(line);
    for (int i = 0; i < d->n_faults && i < MOST_LINES; i++) {
        put_fault(&text, r, &d->faults[i]);
        flush(stream, i ? "" : "Faults", &text);
    }
    if (d->n_faults > MOST_LINES) print_more(stream, d->n_faults - MOST_LINES);
    if (r->data->n_sockets == 0 && d->nominal_m < echo_limit)
        cli_print_keyed(stream, "Poses",
                        "the measured poses repeat the nominal model: they seem to come from the "
                        "controller, not from a tracker, and contain no error of the arm");
    if (!(d->efforts_correlation < 0.5)) return;
    const bool opposed = d->efforts_correlation < -0.5;
    mukca_text_put(&text,
                   "measured efforts %s the torques that hold the arm (correlation %.2f) and were "
                   "not used; %s",
                   opposed ? "oppose" : "differ from", d->efforts_correlation,
                   opposed ? "write them as the torque that the joint exerts on the arm"
                           : "check their unit (N·m), their joints and the masses");
    flush(stream, "Efforts", &text);
}

/* ---- detection limits ---- */

/* "Not testable: joint_drift, joint_scale (REASON)", with the joints where the reason is theirs. */
static void print_reason(FILE *stream, const mukca_diagnosed *r, const mukca_tested *of)
{
    const mukca_diagnosis *d = r->diagnosis;
    char line[TEXT] = "";
    mukca_text text = MUKCA_TEXT(line);
    bool joint[MUKCA_MAX_JOINTS] = {false}, kind[MUKCA_EFFECT_COUNT] = {false};
    int kinds = 0, joints = 0, n = 0;
    for (int i = 0; i < d->n_tested; i++) {
        const mukca_tested *t = &d->tested[i];
        if (t->testable || (t->joint < 0) != (of->joint < 0) || strcmp(t->why, of->why) != 0)
            continue;
        kinds += !kind[t->effect];
        kind[t->effect] = true;
        if (t->joint >= 0) joints += !joint[t->joint], joint[t->joint] = true;
    }
    mukca_text_put(&text, "Not testable: ");
    if (kinds > 3 && joints > 0)
        mukca_text_put(&text, "%d effects", kinds);
    else
        for (int k = 0; k < MUKCA_EFFECT_COUNT; k++)
            if (kind[k])
                mukca_text_put(&text, "%s%s", n++ ? ", " : "", mukca_effect_table[k]->name);
    for (int j = 0, at = 0; j < r->chain->n_joints; j++)
        if (joint[j])
            mukca_text_put(&text, "%s%s", at++ ? ", " : " at ",
                           mukca_chain_joint_name(r->chain, j));
    mukca_text_put(&text, " (%s)", of->why);
    flush(stream, NULL, &text);
}

/* Median of the detection limits of a joint's effects, rad; NaN where it has none. */
static double joint_limit(const mukca_diagnosis *d, int joint)
{
    double limit[MUKCA_EFFECT_COUNT] = {0};
    int n = 0;
    for (int i = 0; i < d->n_tested && n < MUKCA_EFFECT_COUNT; i++)
        if (d->tested[i].joint == joint && isfinite(d->tested[i].limit))
            limit[n++] = d->tested[i].limit;
    return n ? mukca_stats_median(limit, n) : (double)NAN;
}

/* `caveat`: missing masses have been mentioned. */
static void print_limits(FILE *stream, const mukca_diagnosed *r, bool caveat)
{
    const mukca_diagnosis *d = r->diagnosis;
    char line[TEXT] = "";
    mukca_text text = MUKCA_TEXT(line);
    fputc('\n', stream);
    for (int j = 0, n = 0; j < r->chain->n_joints; j++) {
        const double limit = joint_limit(d, j);
        if (!(limit < useless_limit)) continue;
        mukca_text_put(&text, "%s %s %.2f%s",
                       n++ ? "," : "Detection limits, mrad rms (median over effects):",
                       mukca_chain_joint_name(r->chain, j), 1e3 * limit,
                       mukca_wording_slides(r->chain, j) ? " mm" : "");
    }
    flush(stream, NULL, &text);
    for (int i = 0, lines = 0; i < d->n_tested && lines < MOST_LINES; i++) {
        const mukca_tested *t = &d->tested[i];
        /* readings need no word about errors of commands */
        bool printed =
            t->testable || (r->data->n_sockets == 0 && mukca_effect_of_sockets(t->effect)) ||
            (mukca_effect_table[t->effect]->needs & MUKCA_NEEDS_COMMANDS && !r->data->by_command) ||
            (caveat && t->joint < 0 && (mukca_effect_table[t->effect]->needs & MUKCA_NEEDS_MASSES));
        for (int k = 0; k < i && !printed; k++)
            printed = !d->tested[k].testable && strcmp(d->tested[k].why, t->why) == 0 &&
                      (d->tested[k].joint < 0) == (t->joint < 0);
        if (printed) continue;
        print_reason(stream, r, t);
        lines++;
    }
    if (!r->data->time)
        fprintf(stream, "joint_drift: no time_s column; %.0f s per sample assumed\n",
                MUKCA_SECONDS_PER_ROW);
}

/* Both streams of angles: how they differ, and which was fitted. */
static void print_streams(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_streams *s = &r->diagnosis->streams;
    char line[TEXT] = "";
    mukca_text text = MUKCA_TEXT(line);
    int largest = 0, n = 0;
    for (int j = 1; j < s->n_joints; j++)
        if (s->joint[j].rms > s->joint[largest].rms) largest = j;
    if (s->n_joints == 0 || !(s->joint[largest].rms > 0)) return;
    mukca_text_put(&text, "%s fitted; reading minus command: at most %.3g mrad rms (%s)",
                   r->data->by_command ? "commands" : "readings", 1e3 * s->joint[largest].rms,
                   mukca_chain_joint_name(r->chain, largest));
    for (int j = 0; j < s->n_joints; j++)
        if (s->joint[j].log_bayes_factor > MUKCA_SAG_EVIDENT && s->joint[j].sag > 0)
            mukca_text_put(&text, "%s %s %.3g urad/(N·m) [%.3g, %.3g]", n++ ? "," : "; servo sag",
                           mukca_chain_joint_name(r->chain, j), 1e6 * s->joint[j].sag,
                           1e6 * s->joint[j].low, 1e6 * s->joint[j].high);
    if (isfinite(s->sigma_command_m))
        mukca_text_put(&text, "; geometry leaves %.3g mm with readings, %.3g with commands",
                       1e3 * s->sigma_reading_m, 1e3 * s->sigma_command_m);
    const double ratio = s->sigma_command_m / s->sigma_reading_m;
    if (r->data->by_command ? ratio > 1 / worth_changing : ratio < worth_changing)
        mukca_text_put(&text, ": fit the %s (--angles %s)",
                       r->data->by_command ? "readings" : "commands",
                       r->data->by_command ? "reading" : "command");
    flush(stream, "Angles", &text);
}

/* Several pose logs: which of the free frames they share; several targets. */
static void print_logs(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_logs *logs = &r->diagnosis->logs;
    const double *evidence = logs->log_evidence;
    const bool targets = r->data->n_targets > 1;
    if (logs->n < 2 || !(targets || isfinite(evidence[1]) || isfinite(evidence[2]))) return;
    const int chosen = logs->base_per_log + 2 * logs->tool_per_log;
    static const char *const own[] = {"", "a tracker's frame", "a target's offset",
                                      "a tracker's frame and a target's offset"};
    char line[TEXT] = "";
    mukca_text text = MUKCA_TEXT(line);
    if (targets)
        mukca_text_put(&text, "each of the %d targets has a place on the tool of its own", logs->n);
    else if (chosen)
        mukca_text_put(&text, "each of the %d pose logs has %s of its own (log Bayes factor %.3g)",
                       logs->n, own[chosen], evidence[chosen] - evidence[0]);
    else
        mukca_text_put(&text, "the %d pose logs share the free frames", logs->n);
    flush(stream, targets ? "Targets" : "Logs", &text);
}

void cli_diagnosis_print(FILE *stream, const mukca_diagnosed *r)
{
    char words[MUKCA_WORDING];
    cli_describe_data(words, r->data);
    fprintf(stream, "%s: %s\n", r->chain->robot, words);
    mukca_wording_caveat(words, r);
    const bool caveat = *words;
    cli_print_wrapped(stream, 0, words);
    if (r->diagnosis->verdict == MUKCA_VERDICT_UNTESTABLE) {
        mukca_wording_verdict(words, r);
        cli_print_wrapped(stream, 0, words);
        print_recording(stream, r);
        return;
    }
    fputc('\n', stream);
    print_causes(stream, r);
    print_logs(stream, r);
    print_streams(stream, r);
    print_recording(stream, r);
    print_errors(stream, r);
    print_limits(stream, r, caveat);
    mukca_wording_next(words, r);
    if (*words) cli_print_keyed(stream, "Next", words);
}
