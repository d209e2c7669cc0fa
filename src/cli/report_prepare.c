/* The numbers that the report shows: positions, joint errors, training steps, the matrix. */
#include "cli/report_prepare.h"

#include <math.h>
#include <string.h>

mukca_status report_join(mukca_dataset *all, unsigned char **held_out, mukca_pool *pool,
                         const mukca_dataset *train, const mukca_dataset *test, mukca_error *error)
{
    const int n = train->n_joints, sockets = train->n_sockets, places = train->n_placements;
    mukca_status status =
        mukca_dataset_create(all, train->n_rows + test->n_rows, n, sockets + test->n_sockets,
                             places + test->n_placements, error);
    *held_out = MUKCA_TAKE(pool, unsigned char, places + test->n_placements + 1);
    if (status == MUKCA_OK && !*held_out) status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    if (status == MUKCA_OK && (train->position || test->position)) {
        all->position = calloc((size_t)all->n_rows, 3 * sizeof *all->position);
        if (!all->position) status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    }
    if (status != MUKCA_OK || !*held_out) return status;
    for (int r = 0; r < all->n_rows; r++) {
        const bool second = r >= train->n_rows;
        const mukca_dataset *from = second ? test : train;
        const int at = second ? r - train->n_rows : r, socket = from->socket[at];
        memcpy(all->q + r * n, from->q + at * n, (size_t)n * sizeof *all->q);
        all->socket[r] = socket < 0 ? -1 : socket + (second ? sockets : 0);
        all->row[r] = from->row[at];
        for (int i = 0; all->position && i < 3; i++)
            all->position[3 * r + i] = from->position ? from->position[3 * at + i] : (double)NAN;
    }
    for (int k = 0; k < sockets; k++) all->sockets[k] = train->sockets[k];
    for (int p = 0; p < places; p++) all->placements[p] = train->placements[p];
    for (int k = 0; k < test->n_sockets; k++) {
        all->sockets[sockets + k] = test->sockets[k];
        all->sockets[sockets + k].placement += places;
    }
    for (int p = 0; p < test->n_placements; p++) {
        all->placements[places + p] = test->placements[p];
        (*held_out)[places + p] = 1;
    }
    return MUKCA_OK;
}

double *report_positions(mukca_pool *pool, const mukca_model *model, const mukca_dataset *data)
{
    double *positions = MUKCA_TAKE(pool, double, 3 * data->n_rows);
    mukca_frame *tips = MUKCA_TAKE(pool, mukca_frame, data->n_rows);
    if (!positions || !tips) return NULL;
    mukca_evaluate_tips(tips, model, data);
    for (int r = 0; r < data->n_rows; r++) memcpy(positions + 3 * r, tips[r].p, sizeof tips[r].p);
    return positions;
}

double *report_joint_errors(mukca_pool *pool, const mukca_chain *chain, const double *theta,
                            const double *positions, const mukca_dataset *data)
{
    const int n = data->n_joints;
    double *errors = MUKCA_TAKE(pool, double, data->n_rows *n);
    double(*mean)[3] = mukca_pool_take(pool, (size_t)data->n_sockets + 1, sizeof *mean);
    double *count = MUKCA_TAKE(pool, double, data->n_sockets + 1);
    mukca_geometry geometry;
    if (!errors || !mean || !count) return NULL;
    mukca_geometry_set(&geometry, chain, theta);
    for (int r = 0; r < data->n_rows; r++) {
        const int s = data->socket[r];
        if (s < 0) continue;
        count[s]++;
        for (int i = 0; i < 3; i++) mean[s][i] += positions[3 * r + i];
    }
    for (int r = 0; r < data->n_rows; r++) {
        const int s = data->socket[r];
        double J[6 * MUKCA_MAX_JOINTS], residual[3];
        mukca_fk_jacobian(J, NULL, &geometry, data->q + r * n, NULL);
        for (int i = 0; i < 3; i++) {
            const double at = s < 0 ? data->position[3 * r + i] : mean[s][i] / count[s];
            residual[i] = isnan(at) ? 0 : positions[3 * r + i] - at;
        }
        for (int j = 0; j < n; j++) {
            double dot = 0, square = 0;
            for (int i = 0; i < 3; i++) {
                dot += residual[i] * J[i * n + j];
                square += J[i * n + j] * J[i * n + j];
            }
            errors[r * n + j] = square > 1e-12 ? dot / sqrt(square) : 0;
        }
    }
    return errors;
}

void report_step(mukca_report_step *step, const mukca_chain *chain, const double *theta,
                 const mukca_dataset *train, const mukca_dataset *test, mukca_score *scores)
{
    mukca_score a = {0}, b = {.std = NAN, .distance_error = NAN};
    const mukca_model model = {.chain = chain, .theta = theta};
    mukca_evaluate(scores, &a, &model, train);
    if (test->n_rows > 0) mukca_evaluate(scores, &b, &model, test);
    *step = (mukca_report_step){a.std, a.distance_error, b.std, b.distance_error};
}

/* Fit to the marked placements and fill one bar; false where nothing is left to test on. */
static mukca_status fill_bar(mukca_report_bar *bar, bool *filled, const mukca_chain *chain,
                             const mukca_dataset *train, const mukca_dataset *test,
                             const unsigned char *marked, mukca_score *scores, mukca_error *error)
{
    mukca_score *others = scores + train->n_placements + 1;
    double sum = 0;
    int count = 0;
    memset(others, 0, (size_t)(test->n_placements + 2) * sizeof *others);
    mukca_status status = mukca_evaluate_trained(scores, others, chain, train, marked,
                                                 test->n_rows > 0 ? test : NULL, NULL, error);
    if (status != MUKCA_OK) return status;
    *bar = (mukca_report_bar){.low = HUGE_VAL, .high = 0};
    for (int p = 0, i = 0, named = 0; p < train->n_placements; p++) {
        const size_t used = strlen(bar->trained);
        if (marked[p])
            snprintf(bar->trained + used, sizeof bar->trained - used, "%s%.40s",
                     named++ ? " + " : "", train->placements[p].name);
        if (scores[i].placement != p) continue;
        const double mae = scores[i++].mae;
        if (marked[p]) continue;
        sum += mae;
        count++;
        bar->low = fmin(bar->low, mae);
        bar->high = fmax(bar->high, mae);
    }
    for (int i = 0; i <= test->n_placements && others[i].rows > 0; i++) {
        sum += others[i].mae;
        count++;
        bar->low = fmin(bar->low, others[i].mae);
        bar->high = fmax(bar->high, others[i].mae);
    }
    *filled = count > 0;
    if (count > 0) bar->mean = sum / count;
    return MUKCA_OK;
}

mukca_status report_bars(mukca_report_bar **bars, int *n_bars, mukca_pool *pool, cli_call *call,
                         const mukca_chain *chain, const mukca_dataset *train,
                         const mukca_dataset *test)
{
    const int n = train->n_placements, most = n + n * (n - 1) / 2 + 1;
    *n_bars = 0;
    *bars = MUKCA_TAKE(pool, mukca_report_bar, most);
    unsigned char *marked = MUKCA_TAKE(pool, unsigned char, n + 1);
    mukca_score *scores = MUKCA_TAKE(pool, mukca_score, n + test->n_placements + 4);
    if (pool->failed) return mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    for (int size = 1; size <= 3 && n > 0; size++)
        for (int a = 0; a < n; a++)
            for (int b = a; b < n; b++) {
                bool filled;
                /* 1: a alone; 2: a and b; 3: all, once, where that is more than a pair */
                if (size == 2 ? b == a : b != a) continue;
                if (size == 3 && (a > 0 || n < 3)) continue;
                if (cli_interrupted()) return MUKCA_INTERRUPTED;
                memset(marked, size == 3, (size_t)n);
                marked[a] = marked[b] = 1;
                mukca_report_bar *bar = *bars + *n_bars;
                mukca_status status =
                    fill_bar(bar, &filled, chain, train, test, marked, scores, &call->error);
                if (status != MUKCA_OK) return status;
                if (size == 3) snprintf(bar->trained, sizeof bar->trained, "all");
                *n_bars += filled;
                cli_progress(call, "training and testing", *n_bars, most);
            }
    return MUKCA_OK;
}
