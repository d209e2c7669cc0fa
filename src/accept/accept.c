/* Acceptance of an offsets table, by prediction. */
#include "accept/accept.h"

#include <math.h>
#include <string.h>

#include "base/text.h"
#include "fit/align.h"
#include "math/stats.h"
#include "model/dataset_subset.h"

/* Measurement noise or cross-validated errors, and an error of the nominal model above these, m,
 * mean that the samples are of another arm: four times those of the worst of 40 published
 * recordings.  So do several postures that any arm misses (tip_error.c). */
static const double foreign_noise = 10e-3, foreign_arm = 50e-3;
enum { SEVERAL = 3, LEAST_POSTURES = 3 };

/* Test data contradict the others if their error is this multiple of that of the others, and more
 * than this part of the nominal model's.  Extrapolation from one placement to another reaches a
 * factor of 10, but then removes most of the error. */
static const double contradiction = 10, left = 0.5;

/* Largest relative change of all lengths: three standard deviations of 0.7 %, the size of arms of
 * which each length has the prior of model/prior.h.  Of eleven published arms it is at most 0.6 %.
 */
static const double most_size_change = 0.02;

/* Mean angle, rad, between the orientations measured and those of the table at which they
 * contradict the positions: five times 20 mrad, beyond the errors of real axes. */
static const double most_turn = 0.1;

/* Largest distance of the ball from its place in the URDF, m: three of its prior sigmas. */
static const double most_tool = 0.06;

bool mukca_data_contradict(double error_m, double expected_m, double nominal_m)
{
    return error_m > contradiction * expected_m && error_m > left * nominal_m;
}

/* Least probability of an improvement at the tip; the interval of a held-out difference, in
 * standard errors. */
static const double sure = 0.95, interval = 2;

mukca_status mukca_difference_find(mukca_difference *d, const double *before, const double *after,
                                   const mukca_dataset *data, mukca_error *error)
{
    const int rows = before && after ? data->n_rows : 0;
    mukca_pool pool = {0};
    int *posture = MUKCA_TAKE(&pool, int, rows);
    double(*sum)[3] = MUKCA_TAKE(&pool, double[3], rows), squares = 0; /* before, after, number */
    *d = (mukca_difference){.sigma_m = HUGE_VAL};
    if (!pool.failed) mukca_postures_find(posture, &pool, data);
    for (int i = 0; i < rows && !pool.failed; i++) {
        if (!isfinite(before[i]) || !isfinite(after[i])) continue;
        double *of = sum[posture[i]];
        of[0] += before[i], of[1] += after[i], of[2]++;
    }
    for (int i = 0; i < rows && !pool.failed; i++) {
        if (!(sum[i][2] > 0)) continue;
        const double x = sum[i][0] / sum[i][2], y = sum[i][1] / sum[i][2];
        const double n = ++d->postures, off = y - x - d->mean_m;
        d->before_m += (x - d->before_m) / n;
        d->after_m += (y - d->after_m) / n;
        d->mean_m += off / n;
        squares += off * (y - x - d->mean_m);
    }
    if (d->postures > 1) d->sigma_m = sqrt(squares / d->postures / (d->postures - 1));
    const bool failed = pool.failed;
    mukca_pool_free(&pool);
    return failed ? mukca_fail(error, MUKCA_MEMORY, "out of memory") : MUKCA_OK;
}

/* Refuse for lack of an improvement: say what to do. */
static void advise(mukca_acceptance *a, const mukca_tip_error *tip, const char *otherwise)
{
    mukca_text reason = {.at = a->reason, .size = sizeof a->reason, .used = strlen(a->reason)};
    if (tip->outliers)
        mukca_text_put(
            &reason,
            "; %d of %d postures deviate%s from the others, by up to %.3g mm: correct or "
            "exclude these samples (row%s %s)",
            tip->outliers, tip->postures, tip->outliers > 1 ? "" : "s", 1e3 * tip->worst_m,
            strpbrk(tip->rows, ",") ? "s" : "", tip->rows);
    else
        mukca_text_put(&reason, "; %s",
                       isfinite(tip->lacking_m)
                           ? "the table lacks effects of this arm: use that of mukca diagnose"
                           : otherwise);
}

/* *turn: mean angle between the orientations of a pose log and those of the table, rad; NaN: none,
 * or several logs, of which the table has the frames of one.  False: no memory. */
static bool find_turn(double *turn, const mukca_offsets *table, const mukca_tip_change_task *task)
{
    const mukca_model model = {task->chain, table->theta, table->effects, table->n_effects, false};
    const mukca_dataset *d = task->data;
    mukca_dataset part = {0};
    mukca_error unsaid;
    mukca_score score = {.rotation_error = NAN};
    bool ok = true;
    if (d->quaternion && !d->n_sockets && d->n_files < 2 && d->n_targets < 2)
        ok = mukca_part_take(&part, d, MUKCA_MOST_SAMPLES, &unsaid) == MUKCA_OK &&
             mukca_evaluate(&score, NULL, &model, &part) >= 0;
    mukca_dataset_free(&part);
    *turn = score.rotation_error;
    return ok;
}

bool mukca_poses_repeat(const mukca_dataset *data, double nominal_m)
{
    /* m: a tenth of the nominal error of the most accurate of 40 published recordings; coarser
     * than the digits that controllers print */
    const double repeats = 3e-5;
    return data->n_sockets == 0 && nominal_m < repeats;
}

/* State the error of test poses in a base frame of their own, if it is much smaller: a tracker that
 * was moved between the recordings is no error of the arm.  False: no memory. */
static bool put_realigned(mukca_acceptance *a, const mukca_accept_task *task)
{
    mukca_text of = {.at = a->error_of, .size = sizeof a->error_of, .used = strlen(a->error_of)},
               reason = {.at = a->reason, .size = sizeof a->reason, .used = strlen(a->reason)};
    mukca_alignment own = {.mean_m = NAN};
    mukca_geometry geometry;
    if (!task->held || !isfinite(task->training_m) || task->held->n_sockets > 0) return true;
    mukca_geometry_set(&geometry, task->change.chain, task->change.to->theta);
    if (!mukca_align(&own, &geometry, task->held, &(mukca_align_options){.tracker = true}))
        return false;
    if (!(own.mean_m < left * a->error_m)) return true;
    if (a->accepted)
        mukca_text_put(&of, ", %.3g mm in their own frame", 1e3 * own.mean_m);
    else
        mukca_text_put(&reason,
                       "; in a base frame of their own the test data agree to %.3f mm: was the "
                       "tracker moved?",
                       1e3 * own.mean_m);
    return true;
}

static bool judge_samples(mukca_acceptance *a, const mukca_accept_task *task,
                          const mukca_tip_error *tip, bool changes, double turn)
{
    const double nominal_m = a->error_nominal_m, margin = interval * a->error_sigma_m,
                 misses = isnan(task->training_m) ? fmax(a->noise_m, a->error_m) : a->noise_m;
    const int sockets = task->change.data->n_sockets;
    if (task->misfit)
        mukca_acceptance_refuse(a, "%s", task->misfit);
    else if (mukca_poses_repeat(task->change.data, nominal_m))
        mukca_acceptance_refuse(a,
                                "the model predicts the poses to %.4f mm without a fit: they are "
                                "the controller's own, not measured; record them with a tracker, "
                                "or calibrate from sockets",
                                1e3 * nominal_m);
    else if (isinf(a->noise_m))
        mukca_acceptance_refuse(
            a, "%d different postures are too few to estimate the noise; record more of them",
            tip->postures);
    else if (tip->postures < LEAST_POSTURES + sockets)
        mukca_acceptance_refuse(a, "the samples are of %d different %s%s; record others",
                                tip->postures, tip->postures == 1 ? "posture" : "postures",
                                sockets ? " in all sockets together" : "");
    else if (misses >= foreign_noise)
        mukca_acceptance_refuse(a,
                                "the samples do not fit this arm (by %.2f mm); check the URDF, the "
                                "tip, the columns, the socket labels and the distances",
                                1e3 * misses);
    else if (turn > most_turn)
        mukca_acceptance_refuse(a,
                                "the measured orientations differ by %.0f mrad from those of the "
                                "arm that fits; check their convention (order, axes), or give "
                                "--free-tool",
                                1e3 * turn);
    else if (tip->gross >= SEVERAL)
        mukca_acceptance_refuse(a,
                                "%d postures do not fit this arm by more than 100 mm; check the "
                                "labels of placements and sockets, the URDF and the columns",
                                tip->gross);
    else if (!a->converged)
        mukca_acceptance_refuse(a, "NOT CONVERGED (%s); check the data with mukca diagnose",
                                task->stop ? task->stop : "out of iterations");
    else if (!isfinite(a->error_m))
        mukca_acceptance_refuse(a, "no held-out error is known; record more samples");
    else if (mukca_data_contradict(a->error_m, task->training_m, nominal_m))
        mukca_acceptance_refuse(a,
                                "test error %.3f mm, training error %.3f mm: the data contradict "
                                "each other; check for another arm, tool or tip",
                                1e3 * a->error_m, 1e3 * task->training_m);
    else if (a->error_m < nominal_m + (changes ? -margin : margin))
        return true;
    else {
        mukca_acceptance_refuse(a,
                                "held-out error %.3f mm, nominal %.3f mm (standard error of the "
                                "difference %.3f mm): no sure improvement",
                                1e3 * a->error_m, 1e3 * nominal_m, 1e3 * a->error_sigma_m);
        advise(a, tip, "record more postures; mukca diagnose identifies other causes");
    }
    return false;
}

static void list_joints(char list[96], const unsigned char *which, const mukca_chain *chain)
{
    mukca_text text = {.at = list, .size = 96};
    list[0] = '\0';
    for (int j = 0; j < chain->n_joints; j++)
        if (which[j])
            mukca_text_put(&text, "%s%s", text.used ? ", " : "", mukca_chain_joint_name(chain, j));
}

/* *off: distance of the tip from the nominal one's, m, whatever is mounted on the last link.
 * False: no memory. */
static bool find_distance(double *off, const mukca_tip_error *tip,
                          const mukca_tip_change_task *task)
{
    mukca_alignment any = {.mean_m = NAN};
    mukca_geometry geometry;
    const mukca_align_options options = {.tracker = task->base_frame, .target = true};
    const bool sockets = task->data->n_sockets > 0;
    *off = tip->before_m[MUKCA_HERE] - (sockets ? tip->tool_m : 0);
    if (sockets || task->data->n_targets > 1 || task->data->n_files > 1) return true;
    mukca_geometry_set(&geometry, task->chain, NULL);
    const bool ok = mukca_align(&any, &geometry, task->data, &options);
    *off = any.mean_m;
    return ok;
}

static void judge_tip(mukca_acceptance *a, const mukca_tip_error *tip,
                      const mukca_tip_change_task *task, double off)
{
    const mukca_chain *chain = task->chain;
    const double *p = tip->probability;
    char stuck[96];
    list_joints(stuck, tip->stuck, chain);
    if (!(fabs(a->size_change) <= most_size_change)) {
        mukca_acceptance_refuse(a,
                                "the arm would be %.1f %% %s than the model; check --distance, "
                                "--tip, the URDF and the units",
                                1e2 * fabs(a->size_change),
                                a->size_change > 0 ? "larger" : "smaller");
    } else if (task->data->n_sockets > 0 && tip->tool_m > most_tool) {
        mukca_acceptance_refuse(a,
                                "the ball is %.0f mm from link %s; check --tip, or correct the "
                                "ball's position in the URDF",
                                1e3 * tip->tool_m, chain->tip);
    } else if (stuck[0]) {
        mukca_acceptance_refuse(a,
                                "%s did not move, but the errors are those of a tip that turns "
                                "about it; check the encoder and the column",
                                stuck);
    } else if (!(off < foreign_arm)) {
        mukca_acceptance_refuse(
            a,
            "the samples are of an arm whose tip is %.0f mm from that of the "
            "nominal model; check the URDF, joint zeros, columns, labels, distances",
            1e3 * off);
    } else if (!(p[MUKCA_HERE] >= sure && a->error_here_m < a->error_before_here_m)) {
        mukca_acceptance_refuse(a,
                                "expected error of the tip %.2f mm, nominal %.2f mm, from %.0f "
                                "different postures: no sure improvement",
                                1e3 * a->error_here_m, 1e3 * a->error_before_here_m, a->postures);
        advise(a, tip, "record more of them");
    } else if (!(p[MUKCA_ELSEWHERE] >= 1 - sure &&
                 a->error_workspace_m <
                     a->error_before_m + interval * tip->scatter_m[MUKCA_ELSEWHERE])) {
        mukca_acceptance_refuse(a,
                                "expected error of the tip %.2f mm within the joint limits, "
                                "nominal %.2f mm",
                                1e3 * a->error_workspace_m, 1e3 * a->error_before_m);
        advise(a, tip, "record postures over wider joint ranges");
    }
}

mukca_status mukca_accept(mukca_offsets *table, const mukca_accept_task *task, mukca_error *error)
{
    mukca_acceptance *a = &table->acceptance;
    mukca_tip_error tip;
    mukca_difference held = {.before_m = NAN, .after_m = NAN};
    MUKCA_TRY(mukca_tip_change_judge(table, &task->change, error));
    MUKCA_TRY(mukca_tip_error_expect(&tip, &task->change, error));
    if (task->held)
        MUKCA_TRY(mukca_difference_find(&held, task->before, task->after, task->held, error));
    a->given = a->accepted = true;
    a->reason[0] = '\0';
    a->error_nominal_m = held.postures ? held.before_m : (double)NAN;
    a->error_m = held.postures ? held.after_m : (double)NAN;
    a->error_sigma_m = held.sigma_m;
    a->postures = tip.postures;
    a->error_here_m = tip.after_m[MUKCA_HERE];
    a->error_before_here_m = tip.before_m[MUKCA_HERE];
    a->error_here_low_m = tip.low_m[MUKCA_HERE];
    a->error_here_high_m = tip.high_m[MUKCA_HERE];
    a->error_here_distance_m = tip.distance_m;
    a->error_lacking_m = tip.lacking_m;
    a->error_workspace_m = tip.after_m[MUKCA_ELSEWHERE];
    a->error_workspace_low_m = tip.low_m[MUKCA_ELSEWHERE];
    a->error_workspace_high_m = tip.high_m[MUKCA_ELSEWHERE];
    a->error_before_m = tip.before_m[MUKCA_ELSEWHERE];
    list_joints(a->at_rest, tip.at_rest, task->change.chain);
    /* a table of a hand-eye calibration may have frames only, which must not be worse than their
     * start values */
    bool changes = table->n_effects > 0;
    for (int i = 0; i < MUKCA_PARAMETERS * task->change.chain->n_elements; i++)
        changes |=
            table->listed[i] && !mukca_tip_change_is_frame(&task->change, i / MUKCA_PARAMETERS);
    double turn = task->turn_rad, off = 0;
    bool ok = turn > 0 || find_turn(&turn, table, &task->change);
    if (ok && judge_samples(a, task, &tip, changes, turn) && changes) {
        ok = find_distance(&off, &tip, &task->change);
        if (ok) judge_tip(a, &tip, &task->change, off);
    }
    ok = ok && put_realigned(a, task);
    return ok ? MUKCA_OK : mukca_fail(error, MUKCA_MEMORY, "out of memory");
}

void mukca_fit_offsets(mukca_offsets *offsets, const mukca_fit *fit)
{
    mukca_offsets_init(offsets, &fit->chain);
    memcpy(offsets->theta, fit->theta, sizeof fit->theta);
    for (int i = 0; i < fit->parameters.n; i++) {
        const int at = fit->parameters.index[i];
        offsets->listed[at] = 1;
        offsets->sigma[at] = fit->identification.sigma[i];
        offsets->identifiable[at] = fit->identification.identifiable[i];
    }
}

mukca_status mukca_accept_fit(mukca_offsets *offsets, const mukca_fit *fit,
                              const mukca_cross_validation *r, const mukca_dataset *data,
                              const mukca_fit_options *options, mukca_error *error)
{
    mukca_acceptance *a = &offsets->acceptance;
    const bool tested = r->held != &r->data;
    a->converged = fit->converged;
    a->noise_m = fit->identification.noise;
    a->parameters = fit->parameters.n;
    a->identified = fit->identification.rank;
    mukca_text of = MUKCA_TEXT(a->error_of);
    if (tested)
        mukca_text_put(&of, "test data, %d samples", r->held->n_rows);
    else
        mukca_text_put(&of, "cross-validation, %d folds of %s", r->folds,
                       r->placements ? "placements" : "consecutive samples");
    if (!tested && r->data.n_rows < data->n_rows)
        mukca_text_put(&of, ", %d samples", r->data.n_rows);
    return mukca_accept(
        offsets,
        &(mukca_accept_task){.change = {.chain = &fit->chain,
                                        .to = offsets,
                                        .data = data,
                                        .base_frame = options->free_base,
                                        .tool_frame = options->free_tool,
                                        .threads = options->threads},
                             .held = r->held,
                             .before = r->before,
                             .after = r->after,
                             .stop = mukca_stop_text[fit->outcome.stop],
                             .training_m = tested ? MUKCA_MEAN_NORM3 * a->noise_m : (double)NAN},
        error);
}
