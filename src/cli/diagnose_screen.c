/* The diagnosis for people: one screen of 80 columns, causes first. */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

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

/* Text that grows by printf and is wrapped when it is printed. */
typedef struct {
    char text[TEXT];
    size_t used;
} paragraph;

__attribute__((format(printf, 2, 3))) static void put(paragraph *p, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    const int n = vsnprintf(p->text + p->used, sizeof p->text - p->used, format, args);
    va_end(args);
    if (n > 0) p->used += (size_t)n;
    if (p->used > sizeof p->text - 1) p->used = sizeof p->text - 1;
}

static void print(FILE *stream, const char *key, paragraph *p)
{
    if (p->used) cli_print_keyed(stream, key, p->text);
    *p = (paragraph){.used = 0};
}

static void print_line(FILE *stream, paragraph *p)
{
    if (p->used) cli_print_wrapped(stream, 0, p->text);
    *p = (paragraph){.used = 0};
}

/* ---- causes ---- */

static void put_amplitude(paragraph *p, const mukca_cause *c, const mukca_chain *chain)
{
    char amplitude[MUKCA_WORDING], probability[MUKCA_WORDING];
    mukca_wording_amplitude(amplitude, c, chain);
    mukca_wording_probability(probability, c->probability);
    put(p, "%s, %s", amplitude, probability);
}

/* "indistinguishable in these data; 10 more postures would decide: mukca plan --settle" */
static void put_tie(paragraph *p, const mukca_diagnosed *r, const mukca_cause *c)
{
    const mukca_next_poses *next = r->next;
    put(p, "indistinguishable in these data");
    if (!next || next->cause < 0 || c != &r->diagnosis->causes[next->cause]) return;
    const mukca_plan *plan = &next->plan;
    if (plan->n_rows > 0 && plan->evidence_after >= MUKCA_PLAN_NAME)
        put(p, "; %d more postures would decide: mukca plan --settle", plan->n_rows);
    else if (plan->n_rows > 0 && plan->rows_to_name > 0)
        put(p, "; some %d more postures would decide: mukca plan --settle --rows %d",
            plan->rows_to_name, plan->rows_to_name);
    else
        put(p, "; a placement far from these may decide: mukca plan --settle --suggest 1");
}

static void print_first(FILE *stream, const mukca_diagnosed *r, const mukca_cause *c)
{
    paragraph p = {.used = 0};
    char words[MUKCA_WORDING];
    const bool tied = c->n_ties || c->or_unknown;
    if (tied) {
        mukca_wording_rivals(words, c, r);
        put(&p, "%s (", words);
        put_tie(&p, r, c);
        put(&p, ")");
    } else {
        mukca_wording_cause(words, c, r);
        put(&p, "%s: %s", words, mukca_effect_table[c->effect.kind]->sentence);
    }
    print(stream, "Cause", &p);
    put_amplitude(&p, c, r->chain);
    print(stream, "", &p);
}

static void print_further(FILE *stream, const mukca_diagnosed *r, const mukca_cause *c,
                          const char *key)
{
    paragraph p = {.used = 0};
    char words[MUKCA_WORDING];
    mukca_wording_rivals(words, c, r);
    put(&p, "%s, ", words);
    put_amplitude(&p, c, r->chain);
    if (c->n_ties || c->or_unknown) {
        put(&p, " (");
        put_tie(&p, r, c);
        put(&p, ")");
    }
    print(stream, key, &p);
}

static void print_rest(FILE *stream, const mukca_diagnosis *d)
{
    paragraph p = {.used = 0};
    const bool unknown = d->verdict == MUKCA_VERDICT_UNKNOWN;
    if (!d->unexplained && !unknown)
        put(&p, "nothing above the noise");
    else if (!unknown)
        put(&p, "unexplained structure");
    if (isfinite(d->surprise) && d->surprise > worth_telling && p.used && d->unexplained)
        put(&p, ": ");
    if (isfinite(d->surprise) && d->surprise > worth_telling && (d->unexplained || unknown))
        put(&p,
            "held-out errors are %.2f times those expected from noise and the uncertainty of the "
            "geometry",
            d->surprise);
    print(stream, "Rest", &p);
}

static void print_causes(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    const bool unknown = d->verdict == MUKCA_VERDICT_UNKNOWN;
    paragraph p = {.used = 0};
    char words[MUKCA_WORDING];
    int printed = unknown;
    if (unknown) {
        mukca_wording_unexplained(words, r);
        put(&p, "%s", words);
        print(stream, "Cause", &p);
    }
    for (int i = 0; i < d->n_causes; i++) {
        if (!mukca_wording_on_arm(&d->causes[i])) continue;
        if (printed == 0)
            print_first(stream, r, &d->causes[i]);
        else if (printed <= MOST_CAUSES)
            print_further(stream, r, &d->causes[i], printed == 1 ? "Also" : "");
        printed++;
    }
    if (printed > MOST_CAUSES + 1) {
        put(&p, "and %d more; --json lists them all", printed - MOST_CAUSES - 1);
        print(stream, "", &p);
    }
    if (printed) {
        print_rest(stream, d);
        return;
    }
    mukca_wording_verdict(words, r);
    put(&p, "%s", words);
    print(stream, "Cause", &p);
}

/* ---- held-out errors ---- */

static void print_step(FILE *stream, const char *name, double metres, const char *remark)
{
    if (isfinite(metres))
        fprintf(stream, "  %-28s %8.3f%s%s\n", name, 1e3 * metres, *remark ? "   " : "", remark);
}

static void print_gain(char remark[120], const mukca_shrink *s)
{
    remark[0] = '\0';
    if (!isfinite(s->shrink_percent)) return;
    int used = snprintf(remark, 120, "%.0f %% %s", fabs(s->shrink_percent),
                        s->shrink_percent < 0 ? "more" : "less");
    if (isfinite(s->low_percent) && isfinite(s->high_percent))
        used += snprintf(remark + used, (size_t)(120 - used), " [%.0f, %.0f]%s", s->low_percent,
                         s->high_percent, s->low_percent > 0 ? "" : ", not significant");
    snprintf(remark + used, (size_t)(120 - used), ", in %d of %d folds", s->folds_better, s->folds);
}

static void print_errors(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    char remark[120];
    paragraph p = {.used = 0};
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
    print_gain(remark, &d->held_out);
    if (d->n_causes)
        print_step(stream,
                   causes == 0   ? "geometry and tool motion"
                   : causes == 1 ? "geometry and the cause"
                   : causes == 2 ? "geometry and both causes"
                                 : "geometry and all causes",
                   d->explained_m, remark);
    print_step(stream, "and unexplained structure", d->structure_m, "");
    print_step(stream, "noise floor", d->noise_floor_m, "");
    if (r->test && isfinite(d->test_geometry_m))
        fprintf(stream, "Test data, mm: nominal %.3f, geometry %.3f, with causes %.3f\n",
                1e3 * d->test_nominal_m, 1e3 * d->test_geometry_m, 1e3 * d->test_explained_m);
    if (r->data->n_sockets > 0 && r->data->n_placements < 4 && d->n_causes) {
        put(&p, "Fewer than four placements: the gain is uncertain");
        if (isfinite(d->noise_shrink_percent))
            put(&p, "; on pure noise the best effect gains %.0f %% here", d->noise_shrink_percent);
        print_line(stream, &p);
    }
}

/* ---- the recording ---- */

static void put_fault(paragraph *p, const mukca_diagnosed *r, const mukca_data_fault *f)
{
    const mukca_dataset *data = r->data;
    const mukca_diagnosis *d = r->diagnosis;
    bool creep = false;
    const char *path = data->files ? data->files[f->file] : "the recording";
    const char *file = strrchr(path, '/');
    for (int i = 0; i < d->n_causes; i++)
        creep |=
            d->causes[i].creep && d->causes[i].socket == f->socket && d->causes[i].row == f->row;
    if (f->placement >= 0) put(p, "%s, ", data->placements[f->placement].name);
    if (f->socket >= 0) put(p, "socket %s, ", data->sockets[f->socket].label);
    put(p, "row %d of %s: ", f->row, file ? file + 1 : path);
    const double mm = 1e3 * f->size_m;
    switch (f->kind) {
        case MUKCA_FAULT_TOOL_MOTION:
            put(p,
                creep ? "the tool crept by %.2f mm from here on; record this socket again"
                      : "the tool moved by %.2f mm before it; record this socket again",
                mm);
            break;
        case MUKCA_FAULT_WRONG_SOCKET:
            put(p, "the ball was in another socket (%.1f mm away); correct its label", mm);
            break;
        case MUKCA_FAULT_OUTLIER:
            put(p, "outlier of %.2f mm, not used; record it again", mm);
            break;
        case MUKCA_FAULT_DUPLICATE:
            put(p, "repeats the row before; record another posture");
            break;
    }
}

static void print_recording(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    paragraph p = {.used = 0};
    for (int i = 0; i < d->n_faults && i < MOST_LINES; i++) {
        put_fault(&p, r, &d->faults[i]);
        print(stream, i ? "" : "Faults", &p);
    }
    if (d->n_faults > MOST_LINES) {
        put(&p, "and %d more; --json lists them all", d->n_faults - MOST_LINES);
        print(stream, "", &p);
    }
    if (r->data->n_sockets == 0 && d->nominal_m < echo_limit)
        put(&p,
            "the measured poses repeat the nominal model: they seem to come from the controller, "
            "not from a tracker, and contain no error of the arm");
    print(stream, "Poses", &p);
    if (d->efforts_correlation < -0.5)
        put(&p,
            "measured efforts oppose the torques that hold the arm (correlation %.2f) and were "
            "not used; write them as the torque that the joint exerts on the arm",
            d->efforts_correlation);
    else if (d->efforts_correlation < 0.5)
        put(&p,
            "measured efforts differ from the torques that hold the arm (correlation %.2f) and "
            "were not used; check their unit (N·m), their joints and the masses",
            d->efforts_correlation);
    print(stream, "Efforts", &p);
}

/* ---- detection limits ---- */

/* "Not testable: joint_drift, joint_scale (REASON)", with the joints where the reason is theirs. */
static void print_reason(FILE *stream, const mukca_diagnosed *r, const mukca_tested *of)
{
    const mukca_diagnosis *d = r->diagnosis;
    paragraph p = {.used = 0};
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
    put(&p, "Not testable: ");
    if (kinds > 3 && joints > 0)
        put(&p, "%d effects", kinds);
    else
        for (int k = 0; k < MUKCA_EFFECT_COUNT; k++)
            if (kind[k]) put(&p, "%s%s", n++ ? ", " : "", mukca_effect_table[k]->name);
    for (int j = 0, at = 0; j < r->chain->n_joints; j++)
        if (joint[j]) put(&p, "%s%s", at++ ? ", " : " at ", mukca_wording_joint(r->chain, j));
    put(&p, " (%s)", of->why);
    print_line(stream, &p);
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Median of the detection limits of a joint's effects, rad; NaN where it has none. */
static double joint_limit(const mukca_diagnosis *d, int joint)
{
    double limit[MUKCA_EFFECT_COUNT] = {0};
    int n = 0;
    for (int i = 0; i < d->n_tested && n < MUKCA_EFFECT_COUNT; i++)
        if (d->tested[i].joint == joint && isfinite(d->tested[i].limit))
            limit[n++] = d->tested[i].limit;
    qsort(limit, (size_t)n, sizeof *limit, by_value);
    return n ? limit[n / 2] : (double)NAN;
}

/* `caveat`: missing masses have been mentioned. */
static void print_limits(FILE *stream, const mukca_diagnosed *r, bool caveat)
{
    const mukca_diagnosis *d = r->diagnosis;
    paragraph p = {.used = 0};
    fputc('\n', stream);
    for (int j = 0, n = 0; j < r->chain->n_joints; j++) {
        const double limit = joint_limit(d, j);
        if (!(limit < useless_limit)) continue;
        put(&p, "%s %s %.2f%s",
            n++ ? "," : "Detection limits, mrad rms:", mukca_wording_joint(r->chain, j),
            1e3 * limit, mukca_wording_slides(r->chain, j) ? " mm" : "");
    }
    print_line(stream, &p);
    for (int i = 0, lines = 0; i < d->n_tested && lines < MOST_LINES; i++) {
        const mukca_tested *t = &d->tested[i];
        bool printed = t->testable || (caveat && t->joint < 0 &&
                                       (mukca_effect_table[t->effect]->needs & MUKCA_NEEDS_MASSES));
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

void cli_diagnosis_print(FILE *stream, const mukca_diagnosed *r)
{
    char words[MUKCA_WORDING];
    paragraph p = {.used = 0};
    cli_describe_data(words, r->data);
    fprintf(stream, "%s: %s\n", r->chain->robot, words);
    mukca_wording_caveat(words, r);
    const bool caveat = *words;
    put(&p, "%s", words);
    print_line(stream, &p);
    if (r->diagnosis->verdict == MUKCA_VERDICT_UNTESTABLE) {
        mukca_wording_verdict(words, r);
        put(&p, "%s", words);
        print_line(stream, &p);
        print_recording(stream, r);
        return;
    }
    fputc('\n', stream);
    print_causes(stream, r);
    print_recording(stream, r);
    print_errors(stream, r);
    print_limits(stream, r, caveat);
    mukca_wording_next(words, r);
    put(&p, "%s", words);
    print(stream, "Next", &p);
}
