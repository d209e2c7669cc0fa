/* The verdict of a calibration, for its offsets table. */
#include "fit/accept.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "arm/tip_change.h"
#include "math/stats.h"

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

mukca_status mukca_fit_accept(mukca_offsets *offsets, const mukca_fit *fit,
                              const mukca_accept_task *task, mukca_error *error)
{
    const mukca_dataset *data = task->data;
    mukca_fit_options options = *task->options;
    const mukca_score *test = task->test;
    mukca_acceptance *a = &offsets->acceptance;
    mukca_cross_validation cv;
    if (test) {
        snprintf(a->error_of, sizeof a->error_of, "test data, %d samples", test[1].rows);
        a->error_nominal_m = test[0].mae;
        a->error_m = test[1].mae;
    } else {
        options.start = fit->theta;
        mukca_status status = mukca_fit_cross_validate(&cv, task->chain, data, &options, error);
        if (status != MUKCA_OK) return status;
        const int used =
            snprintf(a->error_of, sizeof a->error_of, "cross-validation, %d %s", cv.folds,
                     cv.placements ? "folds of placements" : "folds of consecutive samples");
        if (cv.samples > 0)
            snprintf(a->error_of + used, sizeof a->error_of - (size_t)used, ", %d samples",
                     cv.samples);
        a->error_nominal_m = cv.nominal;
        a->error_m = cv.mean;
    }
    a->converged = fit->converged;
    a->noise_m = fit->identification.noise;
    a->parameters = fit->parameters.n;
    a->identified = fit->identification.rank;
    a->determined = fit->identification.determined;
    mukca_tip_change_judge(offsets, &(mukca_tip_change_task){.chain = &fit->chain,
                                                             .to = offsets,
                                                             .data = data,
                                                             .base_frame = options.free_base,
                                                             .tool_frame = options.free_tool});
    mukca_acceptance_judge(a, mukca_stop_text(fit->outcome.stop),
                           test ? MUKCA_MEAN_NORM3 * a->noise_m : (double)NAN);
    return MUKCA_OK;
}
