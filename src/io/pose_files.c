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

/* Pair each of few[n] with one of many[m], m >= n, in order, so that the sum of distances is least:
 * partner[i] grows with i.  cost[(n + 1) * (m - n + 1)] and skip of the same size are work space.
 * cost[i][k]: the first i paired, within the first i + k of many. */
static void pair_in_order(int *partner, const double (*few)[3], int n, const double (*many)[3],
                          int m, double *cost, unsigned char *skip)
{
    const int spare = m - n, width = spare + 1;
    for (int k = 0; k < width; k++) cost[k] = 0;
    for (int i = 1; i <= n; i++) {
        for (int k = 0; k < width; k++) {
            double take = cost[(i - 1) * width + k] + distance(few[i - 1], many[i - 1 + k]);
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

/* partner[rows]: the pose of each row, -1 where it has none. */
static mukca_status pair(int *partner, const double (*row)[3], int rows, const double (*pose)[3],
                         int poses, const char *path, mukca_error *error)
{
    const int few = rows < poses ? rows : poses, many = rows < poses ? poses : rows;
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
    } else if (rows <= poses) {
        pair_in_order(found, row, rows, pose, poses, cost, skip);
        memcpy(partner, found, (size_t)rows * sizeof *partner);
    } else {
        pair_in_order(found, pose, poses, row, rows, cost, skip);
        for (int i = 0; i < rows; i++) partner[i] = -1;
        for (int i = 0; i < poses; i++) partner[found[i]] = i;
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
    double(*poses)[POSE], (*row)[3] = NULL, (*pose)[3] = NULL;
    int m, *partner = NULL;
    mukca_geometry geometry;
    mukca_status status = read_poses(&poses, &m, path, b->error);
    if (status) goto out;
    row = calloc((size_t)n + 1, sizeof *row);
    pose = calloc((size_t)m + 1, sizeof *pose);
    partner = calloc((size_t)n + 1, sizeof *partner);
    if (!row || !pose || !partner) {
        status = mukca_fail(b->error, MUKCA_MEMORY, "out of memory");
        goto out;
    }
    mukca_geometry_set(&geometry, b->chain, NULL);
    for (int i = 0; i < n; i++)
        mukca_fk_position(row[i], &geometry,
                          b->data->q + (size_t)(first + i) * (size_t)b->data->n_joints, NULL);
    for (int i = 0; i < m; i++) memcpy(pose[i], poses[i], sizeof pose[i]);
    status = pair(partner, (const double(*)[3])row, n, (const double(*)[3])pose, m, path, b->error);
    if (status) goto out;
    note_difference(b, path, n, m);
    for (int i = 0; i < n && status == MUKCA_OK; i++)
        if (partner[i] >= 0) status = mukca_build_pose(b, first + i, poses[partner[i]]);
out:
    free(poses);
    free(row);
    free(pose);
    free(partner);
    return status;
}
