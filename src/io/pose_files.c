/* The controller's poses beside recorded joint angles, paired row by row. */
#include "io/pose_files.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* MOST_PAIRS bounds the work space of the pairing, 9 bytes each: 600 MB. */
enum { POSE = 7, MOST_PAIRS = 1 << 26 };

static mukca_status read_row(double pose[POSE], const mukca_table *t, mukca_error *error)
{
    if (t->n_columns != POSE)
        return mukca_table_fail(error, t, -1, "%d columns, but a pose has 7: x,y,z,qw,qx,qy,qz",
                                t->n_columns);
    for (int i = 0; i < POSE; i++) {
        mukca_status status = mukca_table_number(&pose[i], t, i, error);
        if (status == MUKCA_OK && i < 3) status = mukca_rows_check_length(t, i, pose[i], error);
        if (status != MUKCA_OK) return status;
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
        if (status != MUKCA_OK || !more) break;
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

/* Tips of the nominal model and measured poses, to be paired.  The controller may measure another
 * point of the last link than the tip: `lever`, in the tip's frame. */
typedef struct {
    const mukca_frame *tip;
    int n_tips;
    const double (*pose)[POSE];
    int n_poses;
    double lever[3];
    bool tips_are_fewer;
    int few, many;
    /* work space, [few + 1][many - few + 1] and [few + 1]; cost[i][k]: the first i paired within
     * the first i + k */
    double *cost;
    unsigned char *skip;
    int *partner;
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
    const double d[3] = {lever[0] - p->lever[0], lever[1] - p->lever[1], lever[2] - p->lever[2]};
    return sqrt(mukca_dot3(d, d));
}

/* Pair each of the few with one of the many, in order, so that the sum of mismatches is least:
 * partner[i] grows with i.  Dynamic programming, as in the alignment of sequences. */
static void pair_in_order(pairing *p)
{
    const int spare = p->many - p->few, width = spare + 1;
    for (int k = 0; k < width; k++) p->cost[k] = 0;
    for (int i = 1; i <= p->few; i++) {
        double *row = p->cost + i * width;
        for (int k = 0; k < width; k++) {
            const double take = row[k - width] + mismatch(p, i - 1, i - 1 + k);
            const bool better = k > 0 && row[k - 1] < take;
            row[k] = better ? row[k - 1] : take;
            p->skip[i * width + k] = better;
        }
    }
    for (int i = p->few, k = spare; i > 0;) {
        if (p->skip[i * width + k]) {
            k--;
        } else {
            p->partner[i - 1] = i - 1 + k;
            i--;
        }
    }
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The lever by the medians over the pairs found so far. */
static void set_lever(pairing *p)
{
    double lever[3], median[3] = {0, 0, 0}, *work = p->cost;
    for (int k = 0; k < 3 && p->few > 0; k++) {
        for (int i = 0; i < p->few; i++) {
            offset(lever, p, p->tips_are_fewer ? i : p->partner[i],
                   p->tips_are_fewer ? p->partner[i] : i);
            work[i] = lever[k];
        }
        qsort(work, (size_t)p->few, sizeof *work, compare);
        median[k] = work[p->few / 2];
    }
    memcpy(p->lever, median, sizeof median);
}

/* found[n_tips]: the pose of each tip, -1 where it has none. */
static mukca_status pair(int *found, pairing *p, const char *path, mukca_error *error)
{
    enum { ROUNDS = 4 }; /* pairs and lever settle after two or three */
    p->tips_are_fewer = p->n_tips <= p->n_poses;
    p->few = p->tips_are_fewer ? p->n_tips : p->n_poses;
    p->many = p->tips_are_fewer ? p->n_poses : p->n_tips;
    const size_t size = (size_t)(p->few + 1) * (size_t)(p->many - p->few + 1);
    if (size > MOST_PAIRS)
        return mukca_fail(error, MUKCA_INPUT, "%s: %d poses for %d rows are too many to pair",
                          mukca_table_short_path(path), p->n_poses, p->n_tips);
    p->cost = calloc(size, sizeof *p->cost);
    p->skip = calloc(size, 1);
    p->partner = calloc((size_t)p->few + 1, sizeof *p->partner);
    mukca_status status = MUKCA_OK;
    if (!p->cost || !p->skip || !p->partner) {
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
        goto out;
    }
    for (int round = 0; round < ROUNDS; round++) {
        pair_in_order(p);
        if (p->few == p->many) break;
        set_lever(p);
    }
    for (int i = 0; i < p->n_tips; i++) found[i] = -1;
    for (int i = 0; i < p->few; i++)
        found[p->tips_are_fewer ? i : p->partner[i]] = p->tips_are_fewer ? p->partner[i] : i;
out:
    free(p->cost);
    free(p->skip);
    free(p->partner);
    return status;
}

static void note_difference(const mukca_dataset_builder *b, const char *path, int rows, int poses)
{
    if (poses > rows)
        mukca_build_note(
            b, "%s: %d poses for %d rows; %d dropped, the rest paired by forward kinematics",
            mukca_table_short_path(path), poses, rows, poses - rows);
    if (poses < rows)
        mukca_build_note(b, "%s: %d poses for %d rows; %d rows have none",
                         mukca_table_short_path(path), poses, rows, rows - poses);
}

mukca_status mukca_pose_file_read(mukca_dataset_builder *b, const char *path, int first, int n)
{
    double(*poses)[POSE];
    mukca_frame *tip = NULL;
    int m, *partner = NULL;
    mukca_geometry geometry;
    mukca_status status = read_poses(&poses, &m, path, b->error);
    if (status != MUKCA_OK) goto out;
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
    pairing p = {.tip = tip, .n_tips = n, .pose = (const double(*)[POSE])poses, .n_poses = m};
    status = pair(partner, &p, path, b->error);
    if (status != MUKCA_OK) goto out;
    note_difference(b, path, n, m);
    for (int i = 0; i < n && status == MUKCA_OK; i++)
        if (partner[i] >= 0) status = mukca_build_pose(b, first + i, poses[partner[i]]);
out:
    free(poses);
    free(tip);
    free(partner);
    return status;
}
