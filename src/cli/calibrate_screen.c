/* The screen of a calibration, the verdict first; and its JSON. */
#include "cli/calibrate.h"

#include <string.h>

#include "fit/poses.h"

const char *const cli_gradients[] = {"fd", "analytic", NULL};

static void print_identifiability(cli_call *call, const mukca_fit *fit)
{
    const int n = fit->parameters.n, rank = fit->identification.rank;
    cli_say(call, NULL, "The data identify %d of %d parameter combinations%s.", rank, n,
            rank < n ? "; the others have no effect on these samples and stay near nominal" : "");
    if (fit->n_part > 0)
        cli_say(call, NULL, "Standard errors: computed from %d samples, scaled to all.",
                fit->n_part);
}

static bool enough_samples(const mukca_fit *fit)
{
    return fit->n_measured > fit->parameters.n;
}

static void print_warnings(cli_call *call)
{
    const calibrate_work *w = call->work;
    const mukca_dataset *train = &call->session->data;
    const mukca_fit *fit = &w->fit;
    const mukca_score *nominal = &w->scores.set[0].mean[CLI_NOMINAL];
    const double distance = call->common->distance;
    if (!enough_samples(fit))
        cli_say(call, NULL, "warning: %d samples provide %d measured numbers for %d parameters",
                train->n_rows, fit->n_measured, fit->parameters.n);
    if (train->n_sockets > 0 && fit->chain.element[fit->chain.n_elements - 1].joint >= 0)
        cli_say(call, NULL,
                "warning: no fixed joint ends the chain at %s, so the position of the ball is not "
                "fitted; add it to the URDF as ball_link",
                fit->chain.tip);
    if (nominal->mae > CLI_FAR_OFF)
        cli_say(call, NULL,
                "warning: the nominal model is %.0f mm off; check the units of the URDF (m, rad) "
                "and the order of the columns",
                1e3 * nominal->mae);
    else if (!call->common->distances && nominal->distance_error > 0.2 * distance &&
             nominal->distance_error > nominal->mae)
        cli_say(call, NULL,
                "warning: by the nominal model the distance of the sockets differs by %.1f mm from "
                "--distance, %.1f mm; measure the tool again",
                1e3 * nominal->distance_error, 1e3 * distance);
}

static void print_next(cli_call *call)
{
    const calibrate_work *w = call->work;
    const mukca_dataset *train = &call->session->data;
    const bool sockets = train->n_sockets > 0;
    const cli_common *c = call->common;
    const mukca_acceptance *a = &w->offsets.acceptance;
    const double worth = 0.44; /* of the error: without it, a tenth less */
    if (!a->accepted) return;
    if (!enough_samples(&w->fit))
        cli_say(call, "Next", "record more postures%s", sockets ? ", 20 in each socket" : "");
    else if (sockets && train->n_placements < 2)
        cli_say(call, "Next", "move the tool and record two or three more placements");
    else if (a->error_lacking_m > worth * a->error_here_m)
        cli_say(call, "Next",
                "mukca diagnose -o FILE with these data: its table has the effects that this one "
                "lacks");
    else if (w->scores.set[1].n == 0)
        cli_say(call, "Next", "check the error elsewhere: --test with another %s",
                sockets ? "placement" : "pose log");
    else if (c->output)
        cli_say(call, "Next", "mukca export --urdf %s%s%s --offsets %s", c->arm.urdf,
                c->arm.kinematics ? " --kinematics " : "",
                c->arm.kinematics ? c->arm.kinematics : "", c->output);
    if (!c->output) cli_say(call, "Save", "-o offsets.tsv saves the result");
}

/* Were measured poses fitted?  Those beside samples of sockets are not. */
static bool fitted_poses(const mukca_dataset *data)
{
    bool any = false;
    for (int i = 0; i < data->n_rows; i++) any |= data->socket[i] < 0;
    return any;
}

static void print_verdict(cli_call *call)
{
    const calibrate_work *w = call->work;
    const mukca_dataset *train = &call->session->data;
    const mukca_acceptance *a = &w->offsets.acceptance;
    char turns[80] = "";
    cli_print_acceptance(cli_answer_stream(call), a, &w->fit.chain);
    if (!a->accepted) return;
    if (train->quaternion && fitted_poses(train))
        snprintf(turns, sizeof turns, ", positions and orientations together (1 mrad as %g mm)",
                 MUKCA_METRES_PER_RADIAN);
    cli_say(call, NULL, "Converged after %d evaluations; measurement noise %.3f mm per axis%s.",
            w->fit.outcome.evaluations, 1e3 * a->noise_m, turns);
}

/* A fitted frame of measured poses: the arm's base in the frame of the tracker (or of a fixed
 * board) if `base`, else the target (or camera) in the link that carries it.  False: not fitted. */
static bool find_frame(mukca_frame *T, const cli_call *call, bool base)
{
    const calibrate_work *w = call->work;
    const mukca_chain *chain = &w->fit.chain;
    const int k = base ? 0 : chain->n_elements - 1;
    const double *theta = w->fit.theta + MUKCA_PARAMETERS * k;
    bool fitted = false;
    for (int i = 0; i < w->fit.parameters.n; i++)
        fitted |= w->fit.parameters.index[i] / MUKCA_PARAMETERS == k;
    if (!fitted || !fitted_poses(&call->session->data) || chain->element[k].joint >= 0)
        return false;
    if (base && strcmp(chain->element[k].name, MUKCA_BASE_FRAME) != 0) return false;
    mukca_rotation_from_rpy(T->R, theta + 3);
    memcpy(T->p, theta, sizeof T->p);
    return true;
}

/* Base and target as the results of a hand-eye calibration. */
static void print_frames(cli_call *call)
{
    const calibrate_work *w = call->work;
    static const char *const keys[2] = {"Target", "Base"};
    const mukca_chain *chain = &w->fit.chain;
    const int last = chain->n_elements - 1;
    for (int base = 1; base >= 0; base--) {
        mukca_frame T;
        double q[4], rpy[3];
        if (!find_frame(&T, call, base)) continue;
        mukca_rotation_to_quaternion(q, T.R);
        mukca_rotation_to_rpy(rpy, T.R, NULL);
        cli_say(call, keys[base],
                "in %s%s: xyz %.6f %.6f %.6f m, rpy %.6f %.6f %.6f rad, quaternion (w first) %.6f "
                "%.6f %.6f %.6f",
                base ? "the frame of the poses" : "link ",
                base       ? ""
                : last > 0 ? chain->element[last - 1].child
                           : chain->base,
                T.p[0], T.p[1], T.p[2], rpy[0], rpy[1], rpy[2], q[0], q[1], q[2], q[3]);
    }
}

static void print_traits(cli_call *call)
{
    const calibrate_work *w = call->work;
    const mukca_traits *traits = &call->session->traits;
    mukca_effect elastic[MUKCA_FLEET_TERMS];
    if (!call->common->traits) return;
    if (mukca_traits_effects(elastic, NULL, traits, 1) == 0)
        cli_say(call, NULL, "Fleet: the traits of %d arms contain no elastic coefficient.",
                traits->n_arms);
    else
        cli_say(call, NULL,
                w->traits_share == 1
                    ? "Fleet: the elastic means of %d arms are in the table; the data agree (log "
                      "Bayes factor %.1f)."
                : w->traits_share > 0
                    ? "Fleet: half of the elastic means of %d arms is in the table: the data want "
                      "it (log Bayes factor %.1f), but not all."
                    : "Fleet: the data do not support the traits of %d arms (log Bayes factor "
                      "%.1f), which are not used.",
                traits->n_arms, w->traits_evidence);
}

mukca_status cli_calibration_print(cli_call *call)
{
    const calibrate_work *w = call->work;
    const cli_session *s = call->session;
    const bool accepted = w->offsets.acceptance.accepted,
               foreign = !accepted && w->scores.set[0].mean[CLI_NOMINAL].mae > CLI_FAR_OFF;
    mukca_frame T;
    cli_print_head(cli_answer_stream(call), w->fit.chain.robot, &s->data, &s->test);
    print_verdict(call);
    cli_print_mismatch(call, &s->data, find_frame(&T, call, true), find_frame(&T, call, false));
    cli_scores_print(call, &w->scores, false);
    if (!foreign) print_frames(call);
    if (!foreign) print_identifiability(call, &w->fit);
    print_warnings(call);
    print_next(call);
    print_traits(call);
    return accepted ? MUKCA_OK : MUKCA_NEGATIVE;
}

/* ---- JSON ---- */

static json_t *frame_json(const cli_call *call, bool base)
{
    mukca_frame T;
    return find_frame(&T, call, base) ? cli_json_frame(&T) : NULL;
}

static json_t *cost_json(const mukca_cost_value *c)
{
    return cli_json(FIELD(c, total), FIELD(c, inconsistency), FIELD(c, distortion),
                    FIELD(c, regularisation));
}

json_t *cli_calibration_json(const cli_call *call)
{
    const calibrate_options *o = call->options;
    const calibrate_work *w = call->work;
    const mukca_fit *fit = &w->fit;
    const cli_scores *s = &w->scores;
    json_t *traits = NULL;
    if (o->common.traits)
        traits = cli_json(KEY("used", (bool)(w->traits_share > 0)), KEY("share", w->traits_share),
                          KEY("arms", call->session->traits.n_arms),
                          KEY("log_bayes_factor", w->traits_evidence));
    return cli_json(
        FIELD(fit, converged),
        KEY("solver",
            cli_json(KEY("name", mukca_solver_name[o->solver]),
                     KEY("gradient", cli_gradients[o->gradient]),
                     KEY("evaluations", fit->outcome.evaluations),
                     KEY("iterations", fit->outcome.iterations),
                     KEY("status", mukca_stop_text[fit->outcome.stop]), FIELD(fit, to_gain))),
        KEY("cost", cli_json(KEY("nominal", cost_json(&fit->nominal)),
                             KEY("calibrated", cost_json(&fit->calibrated)))),
        KEY("train", cli_scores_json(&s->set[0], s->has_factory)),
        KEY("test", cli_scores_json(&s->set[1], s->has_factory)),
        KEY("parameters", cli_json_offsets(&w->offsets, &fit->chain)),
        KEY("rank", fit->identification.rank), KEY("free", fit->parameters.n),
        KEY("noise_m", fit->identification.noise),
        KEY("observability", fit->identification.observability),
        KEY("sigma_samples", fit->n_part > 0 ? fit->n_part : call->session->data.n_rows),
        KEY("acceptance", cli_json_acceptance(&w->offsets.acceptance)),
        KEY("frames",
            cli_json(KEY("base", frame_json(call, true)), KEY("target", frame_json(call, false)))),
        KEY("traits", traits), KEY("elapsed_s", cli_elapsed(call)));
}
