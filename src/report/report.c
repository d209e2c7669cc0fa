/* The report: its numbers, computed from the arm, the data and the results; its sections in reading
 * order. */
#include "report/report.h"
#include "fit/align.h"

/* Scores of a dataset by the nominal (0) or the calibrated model (1).  False: no memory. */
static bool score(mukca_report *r, int set, const mukca_dataset *data, int which,
                  const mukca_model *model)
{
    mukca_score *scores = MUKCA_TAKE(r->pool, mukca_score, data->n_placements + 1);
    r->score[set][which] = scores;
    r->n_scores[set] = scores ? mukca_evaluate(scores, NULL, model, data) : -1;
    return r->n_scores[set] >= 0;
}

mukca_status mukca_report_prepare(mukca_report *r, mukca_error *error)
{
    const mukca_dataset *data[2] = {r->train, r->test};
    double theta[MUKCA_MAX_THETA];
    mukca_model models[2];
    const mukca_model nominal = {.chain = r->fitted, .theta = theta},
                      rigid = {.chain = r->fitted, .theta = r->offsets->theta};
    MUKCA_TRY(mukca_frames_start(theta, r->fitted, r->train, r->free_base, r->free_tool, error));
    r->points = MUKCA_TAKE(r->pool, mukca_plot_point, 2 * r->train->n_rows);
    r->offset = MUKCA_TAKE(r->pool, mukca_offset_row, MUKCA_MAX_OFFSET_ROWS);
    mukca_effect *effects = MUKCA_TAKE(r->pool, mukca_effect, 2 * MUKCA_MAX_EFFECTS);
    if (r->pool->failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    mukca_geometry_set(&r->geometry, r->fitted, r->offsets->theta);
    r->n_offsets = mukca_offsets_rows(r->offset, r->offsets, r->fitted);
    for (int k = 0; k < 2; k++) {
        mukca_effect *placed = effects + k * MUKCA_MAX_EFFECTS;
        mukca_offsets_place_effects(placed, r->offsets, data[k]);
        models[k] = (mukca_model){.chain = r->fitted,
                                  .theta = r->offsets->theta,
                                  .effects = placed,
                                  .n_effects = r->offsets->n_effects};
        if (data[k]->n_rows > 0 &&
            !(score(r, k, data[k], 0, &nominal) && score(r, k, data[k], 1, &models[k])))
            return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    }
    const mukca_model *shown[MUKCA_REPORT_MODELS] = {&nominal, &rigid, &models[0]};
    for (int m = 0; m < MUKCA_REPORT_MODELS; m++)
        if (!mukca_evaluation_make(&r->evaluation[m], r->pool, shown[m], r->train))
            return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    return MUKCA_OK;
}

/* ---- the page ---- */

static const mukca_page_section sections[] = {
    {"causes", "Errors and their causes", mukca_report_put_causes},
    {"view", "Findings on the arm", mukca_report_put_view},
    {"placements", "Errors of the result", mukca_report_put_placements},
    {"joints", "Errors by joint", mukca_report_put_joints},
    {"limits", "Detection limits", mukca_report_put_limits},
    {"faults", "Recording faults", mukca_report_put_faults},
    {"offsets", "Parameters", mukca_report_put_offsets},
};

static void open_page(FILE *out, const void *content)
{
    mukca_report_put_accuracy(out, content);
    mukca_report_put_verdict(out, content);
}

mukca_page mukca_report_page(const mukca_report *r)
{
    return (mukca_page){.robot = r->chain->robot,
                        .kind = "calibration report",
                        .from = r->free_base ? "the tracker's frame" : r->chain->base,
                        .to = r->free_tool ? "the target" : r->chain->tip,
                        .open = open_page,
                        .sections = sections,
                        .n_sections = sizeof sections / sizeof *sections,
                        .content = r};
}
