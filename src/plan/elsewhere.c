/* Evaluation points of the expected accuracy, all over the workspace; sockets of a dataset. */
#include <math.h>
#include <string.h>

#include "plan/choose.h"

enum {
    SPOTS = 50,
    POSES = 12
}; /* points, and postures at each: enough for their mean within a few % */

void mukca_plan_look_elsewhere(mukca_plan_state *s, const mukca_plan_rules *rules, uint64_t seed)
{
    const int p = s->n_geometry, k = s->n_known;
    double *H = MUKCA_TAKE(&s->pool, double, POSES * 3 * k);
    s->elsewhere = MUKCA_TAKE(&s->pool, double, SPOTS *POSES * 3 * p);
    mukca_random random;
    mukca_random_seed(&random, seed + 1);
    if (s->pool.failed) return;
    for (int spot = 0, tries = 0; spot < SPOTS && tries < 20 * SPOTS; tries++) {
        double q[MUKCA_MAX_JOINTS], centre[3];
        int found = 0;
        if (!mukca_plan_draw_anywhere(q, centre, rules, &random)) continue;
        for (int t = 0; t < 3 * POSES && found < POSES; t++)
            if (mukca_plan_draw_pose(q, centre, rules, &random))
                mukca_plan_design(H + 3 * k * found++, s, q, 0, NULL);
        if (found < POSES / 2) continue;
        spot++;
        for (int d = 0; d < 3; d++)
            for (int c = 0; c < p; c++) {
                double mean = 0;
                for (int f = 0; f < found; f++) mean += H[(3 * f + d) * k + c] / found;
                for (int f = 0; f < found; f++)
                    s->elsewhere[(3 * (s->n_elsewhere + f) + d) * p + c] =
                        H[(3 * f + d) * k + c] - mean;
            }
        s->n_elsewhere += found;
    }
}

int mukca_plan_sockets(mukca_plan_socket *sockets, int room, const mukca_geometry *geometry,
                       const mukca_dataset *data)
{
    int n = 0;
    for (int k = 0; k < data->n_sockets && n < room; k++) {
        double sum[3] = {0}, position[3];
        int rows = 0;
        for (int r = 0; r < data->n_rows; r++) {
            if (data->socket[r] != k) continue;
            mukca_fk_position(position, geometry, data->q + r * data->n_joints, NULL);
            for (int i = 0; i < 3; i++) sum[i] += position[i];
            rows++;
        }
        if (rows == 0) continue;
        mukca_plan_socket *s = &sockets[n++];
        s->place = data->sockets[k].placement;
        memcpy(s->label, data->sockets[k].label, sizeof s->label);
        memcpy(s->placement, data->placements[s->place].name, sizeof s->placement);
        for (int i = 0; i < 3; i++) s->centre[i] = sum[i] / rows;
    }
    return n;
}
