/* Comparison of two models of one arm: differences of the tip, without and with alignment of base
 * and tool. */
#include "arm/compare.h"

#include <math.h>
#include <string.h>

#include "arm/tip_change.h"
#include "math/dense.h"
#include "math/stats.h"

enum { FREE = 9, MOST_STEPS = 50 }; /* base (6), tool translation (3) */

/* B's tip after alignment: base * b * tool. */
static void align(mukca_frame *out, const mukca_comparison *c, const mukca_frame *b)
{
    mukca_frame_multiply(out, &c->base, b);
    mukca_frame_multiply(out, out, &c->tool);
}

/* One Gauss-Newton step for the positions; returns its largest element. */
static double refine(mukca_comparison *c)
{
    enum { SIZE = FREE + 1 };
    double R[FREE * SIZE] = {0}, x[FREE], turn[9], turned[9], largest = 0;
    for (int i = 0; i < MUKCA_COMPARED; i++) {
        mukca_frame at;
        double rows[3 * SIZE] = {0}, lever[3], RB[9];
        align(&at, c, &c->tip[1][i]);
        mukca_mat3_mul(RB, c->base.R, c->tip[1][i].R);
        for (int k = 0; k < 3; k++) lever[k] = at.p[k] - c->base.p[k];
        for (int k = 0; k < 3; k++) {
            double *row = rows + k * SIZE;
            row[(k + 1) % 3] = lever[(k + 2) % 3]; /* omega x lever */
            row[(k + 2) % 3] = -lever[(k + 1) % 3];
            row[3 + k] = 1;
            for (int a = 0; a < 3; a++) row[6 + a] = RB[3 * k + a];
            row[FREE] = c->tip[0][i].p[k] - at.p[k];
        }
        mukca_dense_qr_absorb(R, NULL, rows, 3, FREE, 1);
    }
    for (int a = 0; a < FREE; a++) { /* undetermined directions stay */
        double row[SIZE] = {0};
        row[a] = 1e-6;
        mukca_dense_qr_absorb(R, NULL, row, 1, FREE, 1);
    }
    mukca_dense_qr_solve(x, R, FREE);
    for (int i = 0; i < FREE; i++) largest = fmax(largest, fabs(x[i]));
    mukca_rotation_exp(turn, x);
    mukca_mat3_mul(turned, turn, c->base.R);
    memcpy(c->base.R, turned, sizeof turned);
    for (int k = 0; k < 3; k++) {
        c->base.p[k] += x[3 + k];
        c->tool.p[k] += x[6 + k];
    }
    return largest;
}

/* Rotation of the tool: the mean of those from B's aligned tip to A's. */
static void turn_tool(mukca_comparison *c)
{
    double H[9] = {0};
    for (int i = 0; i < MUKCA_COMPARED; i++) {
        double R[9], off[9]; /* off = (base b)' a; H sums its transpose's outer products */
        mukca_mat3_mul(R, c->base.R, c->tip[1][i].R);
        mukca_mat3_tmul(off, c->tip[0][i].R, R);
        for (int k = 0; k < 9; k++) H[k] += off[k];
    }
    mukca_rotation_nearest(c->tool.R, H);
}

static mukca_compared_error sum_up(double *sorted)
{
    mukca_compared_error e = {.p95 = mukca_stats_quantile(sorted, MUKCA_COMPARED, 0.95)};
    for (int i = 0; i < MUKCA_COMPARED; i++) {
        e.mean += sorted[i] / MUKCA_COMPARED;
        e.max = fmax(e.max, sorted[i]);
    }
    return e;
}

void mukca_compare(mukca_comparison *c, const mukca_corrected *a, const mukca_corrected *b)
{
    mukca_random random;
    double q[MUKCA_MAX_JOINTS], moved[MUKCA_COMPARED], turned[MUKCA_COMPARED];
    mukca_compare_axes(c->axis, &a->geometry, &b->geometry);
    mukca_random_seed(&random, 1);
    for (int i = 0; i < MUKCA_COMPARED; i++) {
        mukca_posture_draw(q, &a->chain, &random);
        mukca_corrected_pose(&c->tip[0][i], a, q, NULL);
        mukca_corrected_pose(&c->tip[1][i], b, q, NULL);
    }
    c->base = c->tool = (mukca_frame){.R = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    for (int aligned = 0; aligned < 2; aligned++) {
        if (aligned) {
            mukca_frame_nearest(&c->base, c->tip[0]->p, c->tip[1]->p,
                                sizeof(mukca_frame) / sizeof(double), MUKCA_COMPARED);
            for (int i = 0; i < MOST_STEPS && refine(c) > 1e-12; i++) continue;
            turn_tool(c);
        }
        for (int i = 0; i < MUKCA_COMPARED; i++) {
            mukca_frame at;
            align(&at, c, &c->tip[1][i]);
            moved[i] = mukca_distance3(at.p, c->tip[0][i].p);
            turned[i] = mukca_rotation_between(at.R, c->tip[0][i].R);
        }
        c->position[aligned] = sum_up(moved);
        c->rotation[aligned] = sum_up(turned);
    }
}
