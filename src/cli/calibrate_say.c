/* What calibrate says to people: one screen, results first. */
#include "cli/calibrate_say.h"

#include <math.h>
#include <string.h>

/* A coefficient smaller than this beside the 1 of its direction is not worth a word. */
static const double worth = 0.05;

static int terms_of(const mukca_fit *fit, int direction)
{
    const int n = fit->parameters.n;
    int terms = 0;
    for (int i = 0; i < n; i++) terms += fabs(fit->null_space[direction * n + i]) > worth;
    return terms;
}

/* Words on a line of at most 96 columns, indented. */
static void say_word(cli_call *call, int *column, const char *word)
{
    const int length = (int)strlen(word);
    if (*column > 0 && *column + length > 94) {
        cli_say(call, "\n");
        *column = 0;
    }
    cli_say(call, *column == 0 ? "    %s" : " %s", word);
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
    cli_say(call, "\n");
}

/* "panda_joint2.y with panda_joint3.z": free to move together. */
static void say_together(cli_call *call, const mukca_fit *fit)
{
    const int n = fit->parameters.n;
    int column = 0;
    for (int r = 0; r < n - fit->identification.rank; r++) {
        int seen = 0;
        char word[4 * MUKCA_PARAMETER_TEXT] = "";
        size_t used = 0;
        if (terms_of(fit, r) < 2) continue;
        for (int i = 0; i < n && seen < 3; i++) {
            char name[MUKCA_PARAMETER_TEXT];
            if (fabs(fit->null_space[r * n + i]) <= worth) continue;
            mukca_parameters_text(name, &fit->chain, fit->parameters.index[i]);
            used += (size_t)snprintf(word + used, sizeof word - used, seen++ ? "~%s" : "%s", name);
        }
        if (used < sizeof word - 4)
            snprintf(word + used, sizeof word - used, terms_of(fit, r) > 3 ? "~..;" : ";");
        say_word(call, &column, word);
    }
    if (column > 0) cli_say(call, "\n");
}

static void say_identifiability(cli_call *call, const mukca_fit *fit)
{
    const int n = fit->parameters.n, hidden = n - fit->identification.rank;
    unsigned char alone[MUKCA_MAX_FREE] = {0};
    int singles = 0;
    cli_say(
        call,
        "The rows see %d of %d directions of the parameters; the pull to nominal holds the rest.\n",
        fit->identification.rank, n);
    if (hidden == 0) return;
    for (int r = 0; r < hidden; r++) {
        if (terms_of(fit, r) != 1) continue;
        for (int i = 0; i < n; i++)
            if (fabs(fit->null_space[r * n + i]) > worth) alone[fit->parameters.index[i]] = 1;
        singles++;
    }
    if (singles > 0) {
        cli_say(call, "  not seen at all:\n");
        say_alone(call, fit, alone);
    }
    if (singles < hidden) {
        cli_say(call, "  seen only together:\n");
        say_together(call, fit);
    }
}

static void say_warnings(cli_call *call, const calibrate_result *r)
{
    const mukca_fit *fit = r->fit;
    if (fit->n_measured <= fit->parameters.n)
        cli_say(call,
                "warning: %d rows give %d numbers for %d parameters, rank %d: record more postures "
                "(30 per socket)\n",
                r->train->n_rows, fit->n_measured, fit->parameters.n, fit->identification.rank);
    for (int i = 0; i < r->train_scores.n; i++) {
        const mukca_score *nominal = &r->train_scores.nominal[i];
        if (nominal->placement < 0 && nominal->mae < 5e-5)
            cli_say(call,
                    "warning: the measured poses repeat the nominal model (within %.2g mm): they "
                    "seem to "
                    "come from the controller, not from a tracker, and cannot calibrate it\n",
                    1e3 * nominal->mae);
    }
    if (r->test_scores.n > 0 &&
        r->test_scores.calibrated_mean.mae > r->test_scores.nominal_mean.mae)
        cli_say(call,
                "warning: on the test data the calibrated model is worse than the nominal one\n");
}

static void say_next(cli_call *call, const calibrate_result *r)
{
    const double train = r->train_scores.calibrated_mean.mae,
                 test = r->test_scores.calibrated_mean.mae;
    const cli_common *c = call->common;
    cli_say(call, "Next: ");
    if (!r->fit->converged)
        cli_say(call,
                "do not use this result; look at the rows with `mukca diagnose`, or try --solver "
                "gauss-newton.\n");
    else if (!c->output)
        cli_say(call, "keep the result with -o offsets.tsv.\n");
    else if (r->test_scores.n == 0)
        cli_say(
            call,
            "see whether it holds elsewhere: record another placement, give it as --test DATA.\n");
    else if (test > 1.5 * train)
        cli_say(call,
                "the test error is %.1f times the training error: train on more placements, or "
                "find the "
                "cause with `mukca diagnose`.\n",
                test / train);
    else
        cli_say(call, "`mukca export --urdf %s --offsets %s` writes the calibrated URDF.\n",
                c->urdf, c->output);
}

/* "60 rows of 1 placement", "1000 measured poses". */
static void say_rows(cli_call *call, const mukca_dataset *data)
{
    if (data->n_sockets == 0)
        cli_say(call, "%d measured poses", data->n_rows);
    else
        cli_say(call, "%d rows of %d placement%s", data->n_rows, data->n_placements,
                data->n_placements == 1 ? "" : "s");
}

void calibrate_say(cli_call *call, const calibrate_result *r)
{
    const mukca_fit *fit = r->fit;
    char noise[24];
    cli_say(call, "%s: ", fit->chain.robot);
    say_rows(call, r->train);
    cli_say(call, " fitted");
    if (r->test_scores.n > 0) {
        cli_say(call, ", tested on ");
        say_rows(call, r->test);
    }
    cli_say(call, "\n");
    cli_scores_say_header(call, true);
    cli_scores_say(call, &r->train_scores, "train", true);
    if (r->test_scores.n > 0) cli_scores_say(call, &r->test_scores, "test", true);
    cli_millimetres(noise, fit->identification.noise);
    cli_say(call, "%s%s after %d evaluations (%s); a row scatters by %s per axis.%s\n",
            cli_bold(stderr), fit->converged ? "Converged" : "NOT CONVERGED",
            fit->outcome.evaluations, mukca_stop_text(fit->outcome.stop), noise, cli_plain(stderr));
    say_identifiability(call, fit);
    say_warnings(call, r);
    say_next(call, r);
}
