/* The controller's poses beside recorded joint angles, paired row by row. */
#include "io/pose_files.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { POSE = 7, MOST_PAIRS = 1 << 26 };
static const double most_length = 50;

static mukca_status read_row(double pose[POSE], const mukca_table *t, mukca_error *error)
{
    if (t->n_columns != POSE)
        return mukca_table_fail(error, t, -1, "%d columns; a pose has 7: x,y,z,qw,qx,qy,qz",
                                t->n_columns);
    for (int i = 0; i < POSE; i++) {
        mukca_status status = mukca_table_number(&pose[i], t, i, error);
        if (status) return status;
        if (i < 3 && fabs(pose[i]) > most_length)
            return mukca_table_fail(error, t, i, "%g looks like millimetres; give m", pose[i]);
    }
    if (!mukca_rows_normalise(pose + 3))
        return mukca_table_fail(error, t, 3,
                                "the quaternion's length is not 1 (order: qw,qx,qy,qz)");
    return MUKCA_OK;
}

static mukca_status read_poses(double (**poses)[POSE], int *n, const char *path, mukca_error *error)
{
    mukca_table t;
    int capacity = 0;
    *poses = NULL;
    *n = 0;
    mukca_status status = mukca_table_open(&t, path, MUKCA_NO_HEADER, error);
    while (status == MUKCA_OK) {
        bool more;
        status = mukca_table_next(&t, &more, error);
        if (status || !more) break;
        if (*n == capacity) {
            capacity = capacity ? 2 * capacity : 64;
            void *grown = realloc(*poses, (size_t)capacity * sizeof **poses);
            if (!grown) status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
            if (!grown) break;
            *poses = grown;
        }
        status = read_row((*poses)[(*n)++], &t, error);
    }
    mukca_table_close(&t);
    return status;
}

static double distance(const double a[3], const double b[3])
{
    double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(mukca_dot3(d, d));
}

/* What is paired: tips of the nominal model and measured poses.  The controller may measure another
 * point of the last link than the tip; `lever` is where, in the tip's frame. */
typedef struct {
    const mukca_frame *tip;
    const double (*pose)[POSE];
    double lever[3];
    bool tips_are_fewer;
} pairing;

/* Offset of pose j from tip i in the tip's frame. */
static void offset(double lever[3], const pairing *p, int i, int j)
{
    double d[3];
    for (int k = 0; k < 3; k++) d[k] = p->pose[j][k] - p->tip[i].p[k];
    mukca_mat3_tvec(lever, p->tip[i].R, d);
}

static double mismatch(const pairing *p, int few, int many)
{
    double lever[3];
    offset(lever, p, p->tips_are_fewer ? few : many, p->tips_are_fewer ? many : few);
    return distance(lever, p->lever);
}

/* Pair each of n with one of m >= n, in order, so that the sum of mismatches is least: partner[i]
 * grows with i.  cost and skip, both [(n + 1) * (m - n + 1)], are work space; cost[i][k]: the first
 * i paired within the first i + k. */
static void pair_in_order(int *partner, const pairing *p, int n, int m, double *cost,
                          unsigned char *skip)
{
    const int spare = m - n, width = spare + 1;
    for (int k = 0; k < width; k++) cost[k] = 0;
    for (int i = 1; i <= n; i++) {
        for (int k = 0; k < width; k++) {
            double take = cost[(i - 1) * width + k] + mismatch(p, i - 1, i - 1 + k);
            bool better = k > 0 && cost[i * width + k - 1] < take;
            cost[i * width + k] = better ? cost[i * width + k - 1] : take;
            skip[i * width + k] = better;
        }
    }
    for (int i = n, k = spare; i > 0;) {
        if (skip[i * width + k]) {
            k--;
        } else {
            partner[i - 1] = i - 1 + k;
            i--;
        }
    }
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The lever by the medians over the pairs found so far; work[n]. */
static void set_lever(pairing *p, const int *partner, int n, double *work)
{
    double lever[3], median[3] = {0, 0, 0};
    for (int k = 0; k < 3 && n > 0; k++) {
        for (int i = 0; i < n; i++) {
            offset(lever, p, p->tips_are_fewer ? i : partner[i],
                   p->tips_are_fewer ? partner[i] : i);
            work[i] = lever[k];
        }
        qsort(work, (size_t)n, sizeof *work, compare);
        median[k] = work[n / 2];
    }
    memcpy(p->lever, median, sizeof median);
}

/* partner[rows]: the pose of each row, -1 where it has none. */
static mukca_status pair(int *partner, const mukca_frame *tip, int rows, const double (*pose)[POSE],
                         int poses, const char *path, mukca_error *error)
{
    enum { ROUNDS = 4 };
    const int few = rows < poses ? rows : poses, many = rows < poses ? poses : rows;
    pairing p = {.tip = tip, .pose = pose, .tips_are_fewer = rows <= poses};
    if ((double)(few + 1) * (many - few + 1) > MOST_PAIRS)
        return mukca_fail(error, MUKCA_INPUT, "%s: %d poses for %d rows are too many to pair",
                          mukca_table_short_path(path), poses, rows);
    size_t size = (size_t)(few + 1) * (size_t)(many - few + 1);
    double *cost = calloc(size, sizeof *cost);
    unsigned char *skip = calloc(size, 1);
    int *found = calloc((size_t)few + 1, sizeof *found);
    mukca_status status = MUKCA_OK;
    if (!cost || !skip || !found) {
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    } else {
        for (int round = 0; round < ROUNDS; round++) {
            pair_in_order(found, &p, few, many, cost, skip);
            if (few == many) break;
            set_lever(&p, found, few, cost);
        }
        for (int i = 0; i < rows; i++) partner[i] = -1;
        for (int i = 0; i < few; i++)
            partner[p.tips_are_fewer ? i : found[i]] = p.tips_are_fewer ? found[i] : i;
    }
    free(cost);
    free(skip);
    free(found);
    return status;
}

static void note_difference(const mukca_dataset_builder *b, const char *path, int rows, int poses)
{
    if (poses > rows)
        mukca_build_note(b, "%s: %d poses for %d rows; %d dropped, the rest paired by kinematics",
                         mukca_table_short_path(path), poses, rows, poses - rows);
    if (poses < rows)
        mukca_build_note(b, "%s: %d poses for %d rows; %d rows go without",
                         mukca_table_short_path(path), poses, rows, rows - poses);
}

mukca_status mukca_pose_file_read(mukca_dataset_builder *b, const char *path, int first, int n)
{
    double(*poses)[POSE];
    mukca_frame *tip = NULL;
    int m, *partner = NULL;
    mukca_geometry geometry;
    mukca_status status = read_poses(&poses, &m, path, b->error);
    if (status) goto out;
    tip = calloc((size_t)n + 1, sizeof *tip);
    partner = calloc((size_t)n + 1, sizeof *partner);
    if (!tip || !partner) {
        status = mukca_fail(b->error, MUKCA_MEMORY, "out of memory");
        goto out;
    }
    mukca_geometry_set(&geometry, b->chain, NULL);
    for (int i = 0; i < n; i++)
        mukca_fk_pose(&tip[i], &geometry,
                      b->data->q + (size_t)(first + i) * (size_t)b->data->n_joints, NULL);
    status = pair(partner, tip, n, (const double(*)[POSE])poses, m, path, b->error);
    if (status) goto out;
    note_difference(b, path, n, m);
    for (int i = 0; i < n && status == MUKCA_OK; i++)
        if (partner[i] >= 0) status = mukca_build_pose(b, first + i, poses[partner[i]]);
out:
    free(poses);
    free(tip);
    free(partner);
    return status;
}
