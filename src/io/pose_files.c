/* The controller's poses, paired with the samples of recorded joint angles. */
#include "io/dataset.h"

#include <math.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/list.h"
#include "base/pool.h"
#include "base/text.h"
#include "math/stats.h"

/* MOST_PAIRS limits the work space of the pairing to 600 MB, 9 bytes per pair. */
enum { POSE = 7, MOST_PAIRS = 1 << 26 };

typedef struct {
    double (*poses)[POSE];
    int n;
    double length; /* m per unit of the positions */
} list;

static void read_row(list *l, mukca_table *t)
{
    if (t->n_columns != POSE) {
        mukca_table_fail(t, -1, "%d columns, but a pose has 7: x,y,z,qw,qx,qy,qz", t->n_columns);
        return;
    }
    double *pose = mukca_list_append(&l->poses, &l->n, sizeof *l->poses);
    if (!pose) {
        mukca_table_stop(t, mukca_fail(t->error, MUKCA_MEMORY, "out of memory"));
        return;
    }
    for (int i = 0; i < POSE; i++) {
        pose[i] = mukca_table_number(t, i) * (i < 3 ? l->length : 1);
        if (i < 3) mukca_rows_check_length(t, i, pose[i]);
    }
    if (!mukca_rotations_normalise(pose + 3))
        mukca_table_fail(t, 3, "the quaternion's length is not 1 (order: qw,qx,qy,qz)");
}

/* Tips of the nominal model and measured poses to be paired: each of the `few` with one of the
 * `many`.  `lever`: the point that the controller measures, in the tip's frame. */
typedef struct {
    const mukca_frame *tip;
    const double (*pose)[POSE];
    bool tips_are_fewer;
    int few, many;
    double lever[3];
    int *partner; /* [few] */
    /* work space, [few + 1][many - few + 1]; cost[i][k]: cost of the first i paired within the
     * first i + k */
    double *cost;
    unsigned char *skip;
} pairing;

/* The measured position in the tip's frame, for one of the few and one of the many. */
static void offset(double lever[3], const pairing *p, int few, int many)
{
    const mukca_frame *tip = &p->tip[p->tips_are_fewer ? few : many];
    const double *pose = p->pose[p->tips_are_fewer ? many : few];
    const double d[3] = {pose[0] - tip->p[0], pose[1] - tip->p[1], pose[2] - tip->p[2]};
    mukca_mat3_tvec(lever, tip->R, d);
}

/* Pair in order with the least sum of distances from the lever: partner[i] increases with i.
 * Dynamic programming, as in sequence alignment. */
static void pair_in_order(pairing *p)
{
    const int spare = p->many - p->few, width = spare + 1;
    for (int i = 1; i <= p->few; i++) {
        double *row = p->cost + i * width;
        for (int k = 0; k < width; k++) {
            double point[3];
            offset(point, p, i - 1, i - 1 + k);
            const double take = row[k - width] + mukca_distance3(point, p->lever);
            const bool better = k > 0 && row[k - 1] < take;
            row[k] = better ? row[k - 1] : take;
            p->skip[i * width + k] = better;
        }
    }
    for (int i = p->few, k = spare; i > 0; i--) {
        while (p->skip[i * width + k]) k--;
        p->partner[i - 1] = i - 1 + k;
    }
}

/* Set the lever to the medians over the present pairs; `work` has room for `few` numbers. */
static void set_lever(pairing *p, double *work)
{
    double lever[3];
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < p->few; i++) {
            offset(lever, p, i, p->partner[i]);
            work[i] = lever[k];
        }
        p->lever[k] = mukca_stats_median(work, p->few);
    }
}

static mukca_status pair(pairing *p, mukca_pool *pool, const char *path, mukca_error *error)
{
    enum { ROUNDS = 4 }; /* pairs and lever converge within two or three */
    const size_t size = (size_t)(p->few + 1) * (size_t)(p->many - p->few + 1);
    if (!p->pose) return MUKCA_OK; /* nothing to pair */
    if (size > MOST_PAIRS)
        return mukca_fail(error, MUKCA_INPUT, "%s: %d poses and rows are too many to pair",
                          mukca_file_shown(path), p->few + p->many);
    p->cost = MUKCA_TAKE(pool, double, size);
    p->skip = MUKCA_TAKE(pool, unsigned char, size);
    double *work = MUKCA_TAKE(pool, double, p->few + 1);
    if (pool->failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    for (int round = 0; round < ROUNDS; round++) {
        pair_in_order(p);
        if (p->few == p->many) break;
        set_lever(p, work);
    }
    return MUKCA_OK;
}

static void note_difference(const mukca_dataset_builder *b, const char *path, int rows, int poses)
{
    path = mukca_file_shown(path);
    if (poses > rows)
        mukca_note_format(
            b->options->notes,
            "%s: %d poses for %d rows; %d dropped, the rest paired by forward kinematics", path,
            poses, rows, poses - rows);
    if (poses < rows)
        mukca_note_format(b->options->notes, "%s: %d poses for %d rows; %d rows have none", path,
                          poses, rows, rows - poses);
}

mukca_status mukca_pose_file_read(mukca_dataset_builder *b, const char *path, int first, int n)
{
    list l = {.length = b->options->format.length > 0 ? b->options->format.length : 1};
    mukca_pool pool = {0};
    mukca_table table;
    mukca_geometry geometry;
    mukca_table_open(&table, path, MUKCA_NO_HEADER, b->error);
    while (mukca_table_next(&table)) read_row(&l, &table);
    mukca_status status = mukca_table_close(&table);
    if (status != MUKCA_OK) goto out;
    mukca_frame *tip = MUKCA_TAKE(&pool, mukca_frame, n + 1);
    int *partner = MUKCA_TAKE(&pool, int, n + 1);
    mukca_geometry_set(&geometry, b->chain, NULL);
    for (int i = 0; i < n && tip; i++)
        mukca_fk_pose(&tip[i], &geometry,
                      b->data->q + (size_t)(first + i) * (size_t)b->data->n_joints, NULL);
    pairing p = {.tip = tip,
                 .pose = (const double(*)[POSE])l.poses,
                 .tips_are_fewer = n <= l.n,
                 .few = n <= l.n ? n : l.n,
                 .many = n <= l.n ? l.n : n,
                 .partner = partner};
    status = pair(&p, &pool, path, b->error);
    if (status == MUKCA_OK) note_difference(b, path, n, l.n);
    for (int i = 0; i < p.few && status == MUKCA_OK; i++) {
        const int row = p.tips_are_fewer ? i : partner[i];
        status = mukca_build_pose(b, first + row, l.poses[p.tips_are_fewer ? partner[i] : i]);
    }
out:
    free(l.poses);
    mukca_pool_free(&pool);
    return status;
}
