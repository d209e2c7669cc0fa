/* Checks of a pose log before re-calibration, on at most 1000 rows, evenly spread. */
#include "recalibrate/recalibrate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "math/stats.h"
#include "model/dataset_subset.h"

enum { PREVIEW = 1000 };

typedef struct {
    const mukca_chain *chain;
    mukca_geometry geometry;
    mukca_dataset rows;
    mukca_frame nominal[PREVIEW], measured[PREVIEW];
    double work[PREVIEW];
} preview;

static mukca_status load_preview(preview *p, const mukca_dataset *log, mukca_error *error)
{
    mukca_dataset *rows = &p->rows;
    const mukca_status status = mukca_part_take(rows, log, PREVIEW, error);
    for (int i = 0; i < rows->n_rows && status == MUKCA_OK; i++) {
        memcpy(p->measured[i].p, rows->position + 3 * i, sizeof p->measured[i].p);
        if (mukca_pose_oriented(rows, i))
            mukca_rotation_from_quaternion(p->measured[i].R, rows->quaternion + 4 * i);
    }
    return status;
}

/* Predict the nominal poses of the child link of `element`. */
static void predict_poses(preview *p, int element)
{
    p->geometry.n_elements = element + 1;
    for (int i = 0; i < p->rows.n_rows; i++)
        mukca_fk_pose(&p->nominal[i], &p->geometry, p->rows.q + i * p->rows.n_joints, NULL);
}

/* Median error of the positions, m, or of the orientations, rad; 0 without any. */
static double median_error(preview *p, bool rotation)
{
    int n = 0;
    for (int i = 0; i < p->rows.n_rows; i++)
        if (!rotation)
            p->work[n++] = mukca_distance3(p->nominal[i].p, p->measured[i].p);
        else if (mukca_pose_oriented(&p->rows, i))
            p->work[n++] = mukca_rotation_between(p->nominal[i].R, p->measured[i].R);
    return mukca_stats_median(p->work, n);
}

/* Length of the path through all poses, m. */
static double path_length(const mukca_frame *poses, int n)
{
    double sum = 0;
    for (int i = 1; i < n; i++) sum += mukca_distance3(poses[i].p, poses[i - 1].p);
    return sum;
}

/* Refuse a stream of positions that had stopped. */
static mukca_status check_moving(preview *p, mukca_error *error)
{
    predict_poses(p, p->chain->n_elements - 1);
    const int n = p->rows.n_rows;
    const double nominal = path_length(p->nominal, n), measured = path_length(p->measured, n);
    if (n > 2 && nominal <= 0)
        return mukca_fail(
            error, MUKCA_INPUT,
            "all samples have the same joint angles; their stream had stopped, record "
            "them again");
    if (nominal > 0.01 && measured < 0.001 * nominal)
        return mukca_fail(error, MUKCA_INPUT,
                          "all positions are the same while the joints move: the tracker's stream "
                          "had stopped, record them again");
    return MUKCA_OK;
}

static mukca_status check_frames(mukca_pose_check *check, preview *p, mukca_error *error)
{
    const mukca_chain *c = p->chain;
    const int last = c->n_elements - 1, joint = c->joint_element[c->n_joints - 1];
    double best = HUGE_VAL, best_turn = HUGE_VAL, median;
    for (int k = last; k >= 0; k--) {
        predict_poses(p, k);
        median = median_error(p, false);
        /* prefer the tip unless another link fits much better */
        if (median < (best == HUGE_VAL ? 1 : 0.5) * best)
            best = median, check->position_element = k;
        median = median_error(p, true);
        if (median < (best_turn == HUGE_VAL ? 1 : 0.5) * best_turn)
            best_turn = median, check->rotation_element = k;
    }
    predict_poses(p, check->position_element);
    median = median_error(p, true);
    if (median <= 1.5 * best_turn) /* no link fits the orientations much better */
        best_turn = median, check->rotation_element = check->position_element;
    if (best > 0.1)
        return mukca_fail(error, MUKCA_INPUT,
                          "the poses are %.0f mm (median) from every link of this arm: another "
                          "base frame or tool (--free-base, --free-tool), angles and poses in "
                          "another order of rows, or another arm",
                          1e3 * best);
    if (check->position_element < joint || (best_turn < 0.1 && check->rotation_element < joint))
        return mukca_fail(error, MUKCA_INPUT,
                          "the poses are those of link '%s', which joint '%s' does not move; give "
                          "--tip or record the tip's poses",
                          c->element[check->position_element].child, c->element[joint].name);
    if (check->rotation_element != check->position_element && best_turn < 0.1) {
        /* Positions of one link with orientations of another: a known, fixed rotation of the
         * tool. */
        predict_poses(p, check->rotation_element);
        const mukca_frame of_rotation = p->nominal[0];
        predict_poses(p, check->position_element);
        mukca_mat3_tmul(check->turn, p->nominal[0].R, of_rotation.R);
    }
    if (best_turn > 0.1)
        return mukca_fail(
            error, MUKCA_INPUT,
            "the orientations differ by %.3f rad (median) from those of every link, "
            "the positions do not: quaternions in another order than w x y z (correct "
            "the columns' names), or rotations in another frame (--free-tool fits a "
            "rotated tool)",
            best_turn);
    return MUKCA_OK;
}

mukca_status mukca_pose_check_run(mukca_pose_check *check, const mukca_chain *chain,
                                  const mukca_dataset *log, bool free_frames, mukca_error *error)
{
    const int last = chain->n_elements - 1;
    preview *p = calloc(1, sizeof *p);
    if (!p) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    *check = (mukca_pose_check){last, last, MUKCA_IDENTITY};
    p->chain = chain;
    mukca_geometry_set(&p->geometry, chain, NULL);
    mukca_status status = load_preview(p, log, error);
    if (status == MUKCA_OK && p->rows.n_rows == 0)
        status = mukca_fail(error, MUKCA_INPUT,
                            "no row has a measured position: need columns x_m y_m z_m, or "
                            "hole_*_pose.csv next to the joint files");
    if (status == MUKCA_OK) status = check_moving(p, error);
    if (status == MUKCA_OK && !free_frames) status = check_frames(check, p, error);
    mukca_dataset_free(&p->rows);
    free(p);
    return status;
}
