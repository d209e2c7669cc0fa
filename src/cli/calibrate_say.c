/* What calibrate says to people: one screen, results first. */
#include "cli/calibrate_say.h"

#include <math.h>
#include <string.h>

/* Beyond this scatter per axis, m, the rows are not those of this arm (as diagnose has it). */
static const double foreign = 10e-3;

/* Nor is a nominal arm that is so far off, m. */
static const double far_off = 0.1;

/* A coefficient smaller than this beside the 1 of its direction is not worth a word. */
static const double worth = 0.05;

static int terms_of(const mukca_fit *fit, int direction)
{
    const int n = fit->parameters.n;
    int terms = 0;
    for (int i = 0; i < n; i++) terms += fabs(fit->null_space[direction * n + i]) > worth;
    return terms;
}

/* Words on a line of at most 79 columns, indented. */
static void say_word(cli_call *call, int *column, const char *word)
{
    const int length = (int)strlen(word);
    if (*column > 0 && *column + 1 + length > 79) {
        cli_answer(call, "\n");
        *column = 0;
    }
    cli_answer(call, *column == 0 ? "    %s" : " %s", word);
    *column += length + (*column == 0 ? 4 : 1);
}

/* Parameters that stand alone in their direction, by joint: "panda_joint1 (x y z roll)". */
static void say_alone(cli_call *call, const mukca_fit *fit, const unsigned char *alone)
{
    int column = 0;
    for (int k = 0; k < fit->chain.n_elements; k++) {
        char word[MUKCA_NAME_SIZE + 48];
        size_t used = 0;
        for (int p = 0; p < MUKCA_PARAMETERS; p++) {
            if (!alone[MUKCA_PARAMETERS * k + p]) continue;
            used += (size_t)snprintf(word + used, sizeof word - used, used ? " %s" : "%s (%s",
                                     used ? mukca_parameter_name[p] : fit->chain.element[k].name,
                                     mukca_parameter_name[p]);
        }
        if (used == 0) continue;
        snprintf(word + used, sizeof word - used, ")");
        say_word(call, &column, word);
    }
    cli_answer(call, "\n");
}

/* "panda_joint2.y~panda_joint3.z": free to move together. */
static void together_word(char word[4 * MUKCA_PARAMETER_TEXT], const mukca_fit *fit, int direction)
{
    const int n = fit->parameters.n, room = 4 * MUKCA_PARAMETER_TEXT;
    int seen = 0, used = 0;
    for (int i = 0; i < n && seen < 3; i++) {
        char name[MUKCA_PARAMETER_TEXT];
        if (fabs(fit->null_space[direction * n + i]) <= worth) continue;
        mukca_parameters_text(name, &fit->chain, fit->parameters.index[i]);
        used += snprintf(word + used, (size_t)(room - used), seen++ ? "~%s" : "%s", name);
    }
    if (terms_of(fit, direction) > 3) snprintf(word + used, (size_t)(room - used), "~...");
}

/* Each word once, though several directions may begin alike. */
static void say_together(cli_call *call, const mukca_fit *fit)
{
    const int hidden = fit->parameters.n - fit->identification.rank;
    int column = 0;
    for (int r = 0; r < hidden; r++) {
        char word[4 * MUKCA_PARAMETER_TEXT], earlier[4 * MUKCA_PARAMETER_TEXT];
        bool told = terms_of(fit, r) < 2;
        if (told) continue;
        together_word(word, fit, r);
        for (int k = 0; k < r && !told; k++) {
            if (terms_of(fit, k) < 2) continue;
            together_word(earlier, fit, k);
            told = strcmp(word, earlier) == 0;
        }
        if (!told) say_word(call, &column, word);
    }
    if (column > 0) cli_answer(call, "\n");
}

static void say_identifiability(cli_call *call, const mukca_fit *fit)
{
    const int n = fit->parameters.n, hidden = n - fit->identification.rank;
    unsigned char alone[MUKCA_MAX_FREE] = {0};
    int singles = 0;
    cli_answer_wrapped(call, "The rows see %d of %d parameter directions%s.",
                       fit->identification.rank, n,
                       hidden ? "; the pull to nominal holds the rest" : "");
    if (hidden == 0) return;
    for (int r = 0; r < hidden; r++) {
        if (terms_of(fit, r) != 1) continue;
        for (int i = 0; i < n; i++)
            if (fabs(fit->null_space[r * n + i]) > worth) alone[fit->parameters.index[i]] = 1;
        singles++;
    }
    if (singles > 0) {
        cli_answer(call, "  not seen at all:\n");
        say_alone(call, fit, alone);
    }
    if (singles < hidden) {
        cli_answer(call, "  seen only together (a~b: a combination of a and b):\n");
        say_together(call, fit);
    }
}

static bool fits(const mukca_fit *fit)
{
    return fit->identification.noise < foreign;
}

static bool enough_rows(const mukca_fit *fit)
{
    return fit->n_measured > fit->parameters.n;
}

static void say_warnings(cli_call *call, const calibrate_result *r)
{
    const mukca_fit *fit = r->fit;
    const mukca_score *nominal = &r->train_scores.nominal_mean;
    const double distance = call->common->distance > 0 ? call->common->distance : 0.05;
    if (!enough_rows(fit))
        cli_answer_wrapped(call, "warning: %d rows give %d numbers for %d parameters",
                           r->train->n_rows, fit->n_measured, fit->parameters.n);
    if (r->train->n_sockets > 0 && fit->chain.element[fit->chain.n_elements - 1].joint >= 0)
        cli_answer_wrapped(
            call,
            "warning: no fixed joint ends the chain at %s, so the ball's place is not fitted: "
            "add it to the URDF as ball_link",
            fit->chain.tip);
    if (nominal->mae > far_off)
        cli_answer_wrapped(
            call,
            "warning: the nominal arm is %.0f mm off: check the URDF's units (m, rad) and the "
            "order of the columns",
            1e3 * nominal->mae);
    else if (!call->common->distances && nominal->distance_error > 0.2 * distance &&
             nominal->distance_error > nominal->mae)
        cli_answer_wrapped(
            call,
            "warning: the nominal arm finds the sockets %.1f mm off their --distance of %.1f "
            "mm: measure the tool again",
            1e3 * nominal->distance_error, 1e3 * distance);
    for (int i = 0; i < r->train_scores.n; i++) {
        const mukca_score *poses = &r->train_scores.nominal[i];
        if (poses->placement < 0 && poses->mae < 5e-5)
            cli_answer_wrapped(
                call,
                "warning: the measured poses repeat the nominal model (within %.2g mm): they "
                "seem to come from the controller, not from a tracker, and cannot calibrate "
                "it",
                1e3 * poses->mae);
    }
    if (r->test_scores.n > 0 &&
        r->test_scores.calibrated_mean.mae > r->test_scores.nominal_mean.mae)
        cli_answer_wrapped(
            call, "warning: on the test data the calibrated model is worse than the nominal");
}

static void say_next(cli_call *call, const calibrate_result *r)
{
    const double train = r->train_scores.calibrated_mean.mae,
                 test = r->test_scores.calibrated_mean.mae;
    const cli_common *c = call->common;
    const bool usable = r->fit->converged && fits(r->fit);
    if (!fits(r->fit))
        cli_answer_wrapped(
            call,
            "Next: do not use this result: the rows do not fit this arm. Check the URDF, the "
            "tip, the columns and their order, the socket labels and --distance.");
    else if (!r->fit->converged)
        cli_answer_wrapped(
            call,
            "Next: do not use this result; look at the rows with `mukca diagnose`, or try "
            "--solver gauss-newton.");
    else if (!enough_rows(r->fit))
        cli_answer_wrapped(call, "Next: record more postures, 20 in each socket.");
    else if (r->train->n_sockets > 0 && r->train->n_placements < 2)
        cli_answer_wrapped(call, "Next: move the tool and record it in two or three more places.");
    else if (r->test_scores.n == 0)
        cli_answer_wrapped(
            call,
            "Next: see whether it holds elsewhere: `mukca evaluate --matrix` with these data, "
            "or --test with another placement's.");
    else if (test > 1.5 * train)
        cli_answer_wrapped(call,
                           "Next: the test error is %.1f times the training error: train on more "
                           "placements, or find the cause with `mukca diagnose`.",
                           test / train);
    else if (c->output)
        cli_answer(call,
                   "Next: write the calibrated URDF:\n  mukca export --urdf %s --offsets %s\n",
                   c->urdf, c->output);
    if (usable && !c->output) cli_answer_wrapped(call, "-o offsets.tsv keeps the result.");
}

/* "60 rows of 1 placement", "1000 measured poses". */
static void say_rows(cli_call *call, const mukca_dataset *data)
{
    if (data->n_sockets == 0)
        cli_answer(call, "%d measured poses", data->n_rows);
    else
        cli_answer(call, "%d rows of %d placement%s", data->n_rows, data->n_placements,
                   data->n_placements == 1 ? "" : "s");
}

void calibrate_say(cli_call *call, const calibrate_result *r)
{
    const mukca_fit *fit = r->fit;
    char noise[24];
    cli_answer(call, "%s: ", fit->chain.robot);
    say_rows(call, r->train);
    cli_answer(call, " fitted");
    if (r->test_scores.n > 0) {
        cli_answer(call, ", tested on ");
        say_rows(call, r->test);
    }
    cli_answer(call, "\n");
    cli_scores_say_header(call, true);
    cli_scores_say(call, &r->train_scores, "train", true);
    if (r->test_scores.n > 0) cli_scores_say(call, &r->test_scores, "test", true);
    cli_millimetres(noise, fit->identification.noise);
    if (fit->converged)
        cli_answer(call, "Converged after %d evaluations; ", fit->outcome.evaluations);
    else
        cli_answer(call, "%sNOT CONVERGED after %d evaluations (%s)%s;\n", cli_bold(stderr),
                   fit->outcome.evaluations, mukca_stop_text(fit->outcome.stop), cli_plain(stderr));
    cli_answer(call, "a row scatters by %s per axis.\n", noise);
    say_identifiability(call, fit);
    say_warnings(call, r);
    say_next(call, r);
}
