/* The diagnosis for people: one screen of 80 columns, the verdict first. */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "cli/diagnose_words.h"
#include "cli/scores.h"
#include "math/stats.h"

enum { FULL_CAUSES = 3, MOST_LINES = 6, TEXT = 1024 };

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

static void print(FILE *stream, int indent, paragraph *p)
{
    if (p->used) cli_print_wrapped(stream, indent, p->text);
    *p = (paragraph){.used = 0};
}

static void heading(FILE *stream, const char *text)
{
    fprintf(stream, "\n%s%s%s\n", cli_bold(stream), text, cli_plain(stream));
}

static bool on_arm(const mukca_cause *c)
{
    return mukca_effect_table[c->effect.kind].site != MUKCA_SITE_SOCKET ||
           c->effect.kind == MUKCA_EFFECT_SOCKET_DISTANCE;
}

static bool elastic(mukca_effect_kind kind)
{
    return kind == MUKCA_EFFECT_JOINT_COMPLIANCE || kind == MUKCA_EFFECT_LINK_BENDING ||
           kind == MUKCA_EFFECT_BASE_COMPLIANCE;
}

static const char *range_words(char text[48], const mukca_chain *chain, const mukca_where *w)
{
    const bool slides = cli_joint_slides(chain, w->joint);
    const double factor = slides ? 1e3 : 180 / M_PI;
    snprintf(text, 48, "%.0f to %.0f %s", factor * w->range_rad[0], factor * w->range_rad[1],
             slides ? "mm" : "degrees");
    return text;
}

/* ---- the verdict in a sentence ---- */

static void put_tie(paragraph *p, const cli_diagnosed *r, const mukca_cause *c)
{
    char words[CLI_WORDS];
    bool flexible = elastic(c->effect.kind);
    for (int t = 0; t < c->n_ties; t++) flexible &= elastic(c->ties[t].effect);
    cli_cause_words(words, c, r->chain, r->data);
    put(p, "%s%s", flexible ? "The arm gives way under its load: " : "The cause is ", words);
    for (int t = 0; t < c->n_ties; t++) {
        cli_effect_words(words, c->ties[t].effect, r->chain, c->ties[t].joint);
        put(p, "%s %s", t + 1 < c->n_ties ? "," : " or", words);
    }
    put(p, "%s; these rows cannot tell which.", c->or_unknown ? ", or something unknown" : "");
}

/* Without masses flexibility goes by the name of whatever varies slowly with the joints' angles. */
static bool imitates(const mukca_diagnosis *d, const mukca_cause *c)
{
    bool untested = false;
    for (int i = 0; i < d->n_tested; i++)
        untested |= d->tested[i].effect == MUKCA_EFFECT_JOINT_COMPLIANCE &&
                    d->tested[i].joint < 0 && !d->tested[i].testable;
    const mukca_effect_kind kind = c->effect.kind;
    return untested &&
           (kind == MUKCA_EFFECT_JOINT_SCALE || kind == MUKCA_EFFECT_JOINT_COUPLING ||
            kind == MUKCA_EFFECT_ENCODER_ECCENTRICITY || kind == MUKCA_EFFECT_AXIS_WOBBLE ||
            (kind == MUKCA_EFFECT_GEAR_HARMONIC && c->effect.variant <= 4));
}

/* One joint with its range, or the joints that share it about evenly. */
static void put_unknown(paragraph *p, const cli_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    char range[48];
    int n = 0;
    while (n < d->n_where && d->where[n].share > 0.5 * d->where[0].share) n++;
    put(p, "Something that no effect of the catalogue explains acts on ");
    if (n == 0) put(p, "the arm");
    for (int i = 0; i < n; i++)
        put(p, "%s%s",
            i == 0      ? ""
            : i + 1 < n ? ", "
                        : " and ",
            cli_joint_name(r->chain, d->where[i].joint));
    if (n == 1) put(p, ", most of all at %s", range_words(range, r->chain, &d->where[0]));
    put(p, ".");
}

static void print_verdict(FILE *stream, const cli_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    const mukca_cause *first = NULL;
    paragraph p = {.used = 0};
    char words[CLI_WORDS];
    int causes = 0;
    for (int i = d->n_causes - 1; i >= 0; i--)
        if (on_arm(&d->causes[i])) first = &d->causes[i], causes++;
    if (d->verdict == MUKCA_VERDICT_UNTESTABLE) {
        put(&p, "Nothing can be tested: %s.", d->why);
    } else if (d->verdict == MUKCA_VERDICT_UNKNOWN) {
        put_unknown(&p, r);
        if (causes)
            put(&p, " Beside it stand%s the cause%s below.", causes == 1 ? "s" : "",
                causes == 1 ? "" : "s");
    } else if (!first) {
        put(&p, "%s",
            d->n_causes ? "The tool was moved while it was recorded; beside that the arm shows "
                          "no effect but its geometry."
                        : "What geometry leaves is noise: these rows show no further effect.");
        if (d->verdict == MUKCA_VERDICT_TIED)
            put(&p, " Or a joint slipped: these rows cannot tell which.");
        if (d->unexplained) put(&p, " Yet structure remains that no effect explains.");
    } else {
        if (first->n_ties || first->or_unknown) {
            put_tie(&p, r, first);
        } else {
            cli_cause_words(words, first, r->chain, r->data);
            put(&p, "%s is %s: %s.", causes == 1 ? "The cause" : "The first cause", words,
                mukca_effect_table[first->effect.kind].sentence);
        }
        if (causes > 1) put(&p, " %d more %s found.", causes - 1, causes == 2 ? "is" : "are");
        if (d->verdict == MUKCA_VERDICT_TIED && !first->n_ties && !first->or_unknown)
            put(&p, " Not all of them can be told from others.");
        if (d->unexplained) put(&p, " Structure remains that no effect explains.");
        if (imitates(d, first))
            put(&p,
                " But flexibility could not be tested for want of masses, and may look like this.");
    }
    fputs(cli_bold(stream), stream);
    print(stream, 0, &p);
    fputs(cli_plain(stream), stream);
}

/* ---- the gap ---- */

static void print_step(FILE *stream, const char *name, double metres, const char *remark)
{
    char text[24];
    if (!isfinite(metres)) return;
    cli_millimetres(text, metres);
    fprintf(stream, "  %-18s %10s%s%s\n", name, text, *remark ? "   " : "", remark);
}

static void shrink_words(char text[96], const mukca_shrink *s)
{
    if (isfinite(s->low_percent) && isfinite(s->high_percent))
        snprintf(text, 96, "%.1f %% [%.1f, %.1f], %d of %d folds", s->shrink_percent,
                 s->low_percent, s->high_percent, s->folds_better, s->folds);
    else
        snprintf(text, 96, "%.1f %%, %d of %d folds", s->shrink_percent, s->folds_better, s->folds);
}

static void print_gap(FILE *stream, const cli_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    const char *left_out = r->data->n_placements >= 2 ? "placement"
                           : r->data->n_sockets > 0   ? "socket"
                                                      : "stretch of the log";
    char remark[120] = "";
    paragraph p = {.used = 0};
    if (!isfinite(d->nominal_m)) return;
    heading(stream, "Gap");
    put(&p, "Mean error");
    if (d->folds > 1 && isfinite(d->geometry_m))
        put(&p, ", each %s left out in turn (a fold)", left_out);
    put(&p, "%s:", d->n_causes ? "; 95 % in brackets" : "");
    print(stream, 2, &p);
    print_step(stream, "nominal model", d->nominal_m, "");
    print_step(stream, "geometry fitted", d->geometry_m, "");
    if (d->n_faults) print_step(stream, "faults excused", d->faults_excused_m, "");
    if (isfinite(d->held_out.shrink_percent) && d->n_causes) {
        char words[96];
        shrink_words(words, &d->held_out);
        snprintf(remark, sizeof remark, "%s %s",
                 d->held_out.low_percent > 0 ? "less by" : "unsure:", words);
    }
    if (d->n_causes) print_step(stream, "causes modelled", d->explained_m, remark);
    if (isfinite(d->structure_m))
        print_step(stream, "unknown fitted too", d->structure_m, "structure without a name");
    print_step(stream, "noise floor", d->noise_floor_m, "");
    if (d->unexplained || d->verdict == MUKCA_VERDICT_UNKNOWN) {
        if (d->surprise > 1.02)
            put(&p,
                "Left-out rows miss %.2f times as far as noise and what the others leave open of "
                "the geometry allow.",
                d->surprise);
        print(stream, 2, &p);
    }
    if (r->test && isfinite(d->test_geometry_m)) {
        char text[3][24];
        cli_millimetres(text[0], d->test_nominal_m);
        cli_millimetres(text[1], d->test_geometry_m);
        cli_millimetres(text[2], d->test_explained_m);
        put(&p, "On the test data: %s nominal, %s with the geometry, %s with the causes.", text[0],
            text[1], text[2]);
        print(stream, 2, &p);
    }
    if (r->data->n_sockets > 0 && r->data->n_placements < 4 && d->n_causes) {
        put(&p, "Fewer than four placements: how far the gap shrinks is uncertain");
        if (isfinite(d->noise_shrink_percent))
            put(&p, "; on pure noise the best of the catalogue gains %.0f %% here",
                d->noise_shrink_percent);
        put(&p, ".");
        print(stream, 2, &p);
    }
}

/* ---- causes ---- */

static void probability_words(char text[32], double probability)
{
    if (probability > 0.999)
        snprintf(text, 32, "over 99.9 %% sure");
    else
        snprintf(text, 32, "%.*f %% sure", probability > 0.99 ? 1 : 0, 100 * probability);
}

static void print_cause(FILE *stream, const cli_diagnosed *r, const mukca_cause *c, int number)
{
    paragraph p = {.used = 0};
    char words[CLI_WORDS], size[CLI_WORDS], sure[32];
    cli_cause_words(words, c, r->chain, r->data);
    cli_cause_size(size, c, r->chain);
    probability_words(sure, c->probability);
    if (number > FULL_CAUSES) {
        put(&p, "%d. %s: %s (%s)", number, words, size, sure);
        print(stream, 2, &p);
        return;
    }
    put(&p, "%d. %s%s%s", number, cli_bold(stream), words, cli_plain(stream));
    print(stream, 2, &p);
    put(&p, "%s; %s", size, sure);
    print(stream, 5, &p);
    if (isfinite(c->held_out.shrink_percent)) {
        const mukca_diagnosis *d = r->diagnosis;
        shrink_words(words, &c->held_out);
        put(&p, "alone it shrinks the gap by %s", words);
        if (c->held_out.folds != d->folds && d->folds > 0) /* of one placement */
            put(&p, " (sockets left out, for its placement must be seen)");
        print(stream, 5, &p);
    }
    for (int t = 0; t < c->n_ties; t++) {
        cli_effect_words(words, c->ties[t].effect, r->chain, c->ties[t].joint);
        put(&p, "or %s", words);
        if (isnan(c->ties[t].log_bayes_factor))
            put(&p, ": only masses can tell, give --inertials FILE");
        else if (c->ties[t].correlation > 0.9)
            put(&p, ": they move the ball alike (correlation %.3f)", c->ties[t].correlation);
        else
            put(&p, ": these rows are too few to choose");
        print(stream, 5, &p);
    }
    if (c->or_unknown) {
        put(&p,
            "or something that no effect of the catalogue makes: these rows are too few to "
            "choose");
        print(stream, 5, &p);
    }
}

static void print_causes(FILE *stream, const cli_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    int number = 0;
    for (int i = 0; i < d->n_causes; i++) {
        if (!on_arm(&d->causes[i])) continue;
        if (!number) heading(stream, d->n_causes > 1 ? "Causes" : "Cause");
        print_cause(stream, r, &d->causes[i], ++number);
    }
}

static void print_where(FILE *stream, const cli_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    paragraph p = {.used = 0};
    char range[48], text[24];
    int told = 0, worst = -1;
    for (int i = 0; i < d->n_where; i++) {
        const mukca_where *w = &d->where[i];
        if (w->share < 0.02) continue;
        put(&p, "%s%s %.0f %% (%s)", told++ ? ", " : "", cli_joint_name(r->chain, w->joint),
            100 * w->share, range_words(range, r->chain, w));
    }
    for (int i = 0; d->placement_mae_m && i < r->data->n_placements; i++)
        if (isfinite(d->placement_mae_m[i]) &&
            (worst < 0 || d->placement_mae_m[i] > d->placement_mae_m[worst]))
            worst = i;
    if (!told) return;
    put(&p, "; most of what remains is in placement");
    if (worst >= 0 && r->data->n_placements > 1) {
        cli_millimetres(text, d->placement_mae_m[worst]);
        put(&p, " %s (%s)", r->data->placements[worst].name, text);
    } else {
        p.used -= strlen("; most of what remains is in placement");
        p.text[p.used] = '\0';
    }
    heading(stream, "Where");
    print(stream, 2, &p);
}

/* ---- the recording ---- */

static void print_fault(FILE *stream, const cli_diagnosed *r, const mukca_data_fault *f)
{
    const mukca_dataset *data = r->data;
    const mukca_diagnosis *d = r->diagnosis;
    paragraph p = {.used = 0};
    char size[24];
    bool creep = false;
    const char *path = data->files ? data->files[f->file] : "the recording";
    const char *file = strrchr(path, '/');
    file = file ? file + 1 : path;
    for (int i = 0; i < d->n_causes; i++)
        creep |=
            d->causes[i].creep && d->causes[i].socket == f->socket && d->causes[i].row == f->row;
    cli_millimetres(size, f->size_m);
    if (f->placement >= 0) put(&p, "%s, ", data->placements[f->placement].name);
    if (f->socket >= 0) put(&p, "socket %s, ", data->sockets[f->socket].label);
    put(&p, "row %d of %s: ", f->row, file);
    switch (f->kind) {
        case MUKCA_FAULT_TOOL_MOTION:
            put(&p,
                creep ? "from here the tool crept by %s; record this socket again"
                      : "the tool moved by %s before it; record this socket again",
                size);
            break;
        case MUKCA_FAULT_WRONG_SOCKET:
            put(&p, "the ball was in another socket (%s away); correct its label", size);
            break;
        case MUKCA_FAULT_OUTLIER:
            put(&p, "%s off, left out; record it again", size);
            break;
        case MUKCA_FAULT_DUPLICATE:
            put(&p, "repeats the row before; record another pose");
            break;
    }
    print(stream, 2, &p);
}

static void print_recording(FILE *stream, const cli_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    paragraph p = {.used = 0};
    const bool efforts_unlike = d->efforts_correlation < 0.5;
    const bool echo = r->data->n_sockets == 0 && d->nominal_m < 5e-5;
    if (!d->n_faults && !efforts_unlike && !echo) return;
    heading(stream, "Recording");
    for (int i = 0; i < d->n_faults && i < MOST_LINES; i++) print_fault(stream, r, &d->faults[i]);
    if (d->n_faults > MOST_LINES) {
        put(&p, "and %d more; --json lists them all", d->n_faults - MOST_LINES);
        print(stream, 2, &p);
    }
    if (echo) {
        put(&p,
            "The measured poses repeat the nominal model: they seem to come from the controller, "
            "not from a tracker, and show nothing of the arm.");
        print(stream, 2, &p);
    }
    if (efforts_unlike) {
        if (d->efforts_correlation < -0.5)
            put(&p,
                "The measured efforts oppose the torques that hold the arm (correlation %.2f): "
                "their sign is turned, and they were not used. Write them as the torque that the "
                "joint exerts on the arm.",
                d->efforts_correlation);
        else
            put(&p,
                "The measured efforts are unlike the torques that hold the arm (correlation "
                "%.2f), and were not used: check their unit (N m), their joints and the masses.",
                d->efforts_correlation);
        print(stream, 2, &p);
    }
}

/* ---- what could not be tested ---- */

/* "joint_drift, joint_scale" of one reason, with the joints where it is the joint's. */
static void print_reason(FILE *stream, const cli_diagnosed *r, const mukca_tested *of)
{
    const mukca_diagnosis *d = r->diagnosis;
    paragraph p = {.used = 0};
    int n = 0;
    if (of->joint >= 0) {
        bool joint[MUKCA_MAX_JOINTS] = {false}, kind[MUKCA_EFFECT_COUNT] = {false};
        for (int i = 0; i < d->n_tested; i++) {
            const mukca_tested *t = &d->tested[i];
            if (t->testable || t->joint < 0 || strcmp(t->why, of->why) != 0) continue;
            joint[t->joint] = kind[t->effect] = true;
        }
        for (int j = 0; j < r->chain->n_joints; j++)
            if (joint[j]) put(&p, "%s%s", n++ ? ", " : "", cli_joint_name(r->chain, j));
        int kinds = 0;
        for (int k = 0; k < MUKCA_EFFECT_COUNT; k++) kinds += kind[k];
        if (kinds <= 3) {
            for (int k = 0, first = 1; k < MUKCA_EFFECT_COUNT; k++)
                if (kind[k]) {
                    put(&p, "%s%s", first ? " (" : ", ", mukca_effect_table[k].name);
                    first = 0;
                }
            put(&p, ")");
        } else {
            put(&p, " (%d effects)", kinds);
        }
    } else {
        for (int i = 0; i < d->n_tested; i++) {
            const mukca_tested *t = &d->tested[i];
            if (!t->testable && t->joint < 0 && strcmp(t->why, of->why) == 0)
                put(&p, "%s%s", n++ ? ", " : "", mukca_effect_table[t->effect].name);
        }
    }
    put(&p, ": %s", of->why);
    print(stream, 2, &p);
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Middle of the detection limits of a joint's effects, rad; NaN where it has none. */
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

static void print_untested(FILE *stream, const cli_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    paragraph p = {.used = 0};
    bool any_slides = false;
    if (d->verdict == MUKCA_VERDICT_UNTESTABLE) return;
    for (int j = 0; j < r->chain->n_joints; j++) any_slides |= cli_joint_slides(r->chain, j);
    heading(stream, "What these rows would show, and what not");
    put(&p,
        "A cause would be seen that moves a joint by (rms, arcmin%s):", any_slides ? " or mm" : "");
    for (int j = 0, n = 0; j < r->chain->n_joints; j++) {
        const double limit = joint_limit(d, j);
        const bool slides = cli_joint_slides(r->chain, j);
        if (!(limit < 30e-3)) continue;
        put(&p, "%s %s %.2g%s", n++ ? "," : "", cli_joint_name(r->chain, j),
            (slides ? 1e3 : CLI_ARCMIN) * limit, slides ? " mm" : "");
    }
    put(&p, ".");
    print(stream, 2, &p);
    for (int i = 0; i < d->n_tested; i++) {
        const mukca_tested *t = &d->tested[i];
        bool told = t->testable;
        for (int k = 0; k < i && !told; k++)
            told = !d->tested[k].testable && strcmp(d->tested[k].why, t->why) == 0 &&
                   (d->tested[k].joint < 0) == (t->joint < 0);
        if (!told) print_reason(stream, r, t);
    }
    if (!r->data->time) {
        put(&p, "joint_drift: without a time_s column each row stood for %.0f s",
            MUKCA_SECONDS_PER_ROW);
        print(stream, 2, &p);
    }
}

/* ---- what to do next ---- */

static void print_poses(FILE *stream, const cli_diagnosed *r)
{
    const mukca_next_poses *next = r->next;
    const mukca_plan *plan = &next->plan;
    const mukca_cause *c = &r->diagnosis->causes[next->cause];
    char words[2][CLI_WORDS];
    paragraph p = {.used = 0};
    cli_effect_words(words[0], c->effect.kind, r->chain, c->effect.joint);
    cli_effect_words(words[1], c->ties[next->tie].effect, r->chain, c->ties[next->tie].joint);
    if (plan->n_rows == 0) {
        put(&p,
            "No pose in these sockets tells %s from %s: record another placement, far from "
            "these, or take both as one.",
            words[0], words[1]);
        print(stream, 2, &p);
        return;
    }
    put(&p,
        "Record these poses (joints in degrees): of those in these sockets they best tell %s from "
        "%s.  Expected log Bayes factor: %.1f now, %.1f with them; %g settles it.",
        words[0], words[1], plan->evidence_before, plan->evidence_after, MUKCA_PLAN_NAME);
    print(stream, 2, &p);
    for (int i = 0; i < plan->n_rows; i++) {
        const mukca_plan_row *row = &plan->rows[i];
        const mukca_plan_socket *socket = &next->sockets[row->socket];
        put(&p, "%s, socket %s:", socket->placement, socket->label);
        for (int j = 0; j < r->chain->n_joints; j++) {
            const bool slides = cli_joint_slides(r->chain, j);
            put(&p, " %.1f%s", slides ? 1e3 * row->q[j] : 180 / M_PI * row->q[j],
                slides ? " mm" : "");
        }
        print(stream, 4, &p);
    }
    if (plan->evidence_after < MUKCA_PLAN_NAME) {
        put(&p,
            "They are not enough%s: `mukca plan --settle --suggest 1` with the same options and ",
            plan->rows_to_name > 0 ? "" : ", nor is any number of them");
        put(&p, "data names a place for the tool that tells more.");
    } else {
        put(&p, "`mukca plan --settle -o FILE` writes them, in rad.");
    }
    print(stream, 2, &p);
}

static void print_next(FILE *stream, const cli_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    const bool tied = r->next && r->next->cause >= 0, causes = d->n_causes > 0;
    paragraph p = {.used = 0};
    if (!tied && !(causes && !r->kept)) return;
    heading(stream, "Next");
    if (tied) print_poses(stream, r);
    if (causes && !r->kept)
        put(&p,
            "-o offsets.tsv keeps geometry and causes: evaluate, fk, compensate and export apply "
            "them.");
    print(stream, 2, &p);
}

void cli_diagnosis_print(FILE *stream, const cli_diagnosed *r)
{
    const mukca_dataset *data = r->data;
    fprintf(stream, "%s: %d rows", r->chain->robot, data->n_rows);
    if (data->n_placements)
        fprintf(stream, " in %d placement%s", data->n_placements,
                data->n_placements == 1 ? "" : "s");
    fputs("\n", stream);
    print_verdict(stream, r);
    print_gap(stream, r);
    print_causes(stream, r);
    print_where(stream, r);
    print_recording(stream, r);
    print_untested(stream, r);
    print_next(stream, r);
}
