/* Every column of the geometry in the diagnosis, against differences of forward kinematics, on
 * random arms of all joint types, with and without a fixed last link. */
#include "arms.h"
#include "close.h"
#include "diagnose/regression.h"
#include "fit/align.h"

enum { ROWS = 16 };

/* Arm, data without error, and the frames to be fitted. */
typedef struct {
    mukca_chain chain;
    mukca_dataset data;
    mukca_frame tracker, target; /* true ones */
    bool sockets, oriented, base, tool, per_log, fixed_tip;
} scene;

static void make_arm(mukca_chain *chain, mukca_random *random, bool fixed_tip)
{
    char types[16] = "";
    for (int j = 3 + mukca_random_below(random, 4); j > 0; j--) {
        if (mukca_random_below(random, 3) == 0) strcat(types, "F");
        strncat(types, &"RCP"[mukca_random_below(random, 3)], 1);
    }
    if (fixed_tip) strcat(types, "F");
    make_chain(chain, types, NULL, "joint_", 3);
    chain->gravity[2] = -9.80665;
    for (int k = 0; types[k]; k++)
        scatter_element(&chain->element[k], 0.3, mukca_random_below(random, 2), random);
}

static void random_frame(mukca_frame *frame, mukca_random *random, bool any)
{
    double w[3];
    for (int c = 0; c < 3; c++) {
        w[c] = any ? mukca_random_normal(random) : 0;
        frame->p[c] = any ? mukca_random_normal(random) : 0;
    }
    mukca_rotation_exp(frame->R, w);
}

/* Measured poses: those of the nominal arm, seen through random frames where these are free. */
static void make_data(scene *s, mukca_random *random)
{
    mukca_geometry nominal;
    mukca_frame pose;
    const int n = s->chain.n_joints, sockets = s->sockets ? ROWS : 0;
    assert_ok(mukca_dataset_create(&s->data, ROWS, n, sockets, sockets > 0, NULL));
    mukca_geometry_set(&nominal, &s->chain, NULL);
    random_frame(&s->tracker, random, s->base);
    random_frame(&s->target, random, s->tool);
    for (int i = 0; i < ROWS * n; i++) s->data.q[i] = mukca_random_normal(random);
    for (int i = 0; i < sockets; i++) s->data.socket[i] = i; /* alone, each is seated */
    if (sockets) return;
    s->data.position = zeroed(3 * ROWS, sizeof(double));
    s->data.quaternion = s->oriented ? zeroed(4 * ROWS, sizeof(double)) : NULL;
    for (int i = 0; i < ROWS; i++) {
        s->data.file[i] = i >= ROWS / 2;
        mukca_fk_pose(&pose, &nominal, s->data.q + i * n, NULL);
        mukca_frame_multiply(&pose, &s->tracker, &pose);
        mukca_frame_multiply(&pose, &pose, &s->target);
        memcpy(s->data.position + 3 * i, pose.p, sizeof pose.p);
        if (s->oriented) mukca_rotation_to_quaternion(s->data.quaternion + 4 * i, pose.R);
    }
}

/* Central difference of poses: position and rotation vector. */
static void difference(double slope[6], const mukca_frame side[2], double step)
{
    mukca_rotation_difference(slope + 3, side[1].R, side[0].R);
    for (int c = 0; c < 3; c++) {
        slope[c] = (side[1].p[c] - side[0].p[c]) / (2 * step);
        slope[3 + c] /= 2 * step;
    }
}

/* Pose of a row at the angles q, in the frame of the measurement. */
static void predict(mukca_frame *pose, mukca_unknowns *u, const mukca_recording *r, int row,
                    const double *q)
{
    mukca_unknowns_fold_frames(u);
    mukca_unknowns_set_geometry(u, r->chain);
    mukca_fk_pose(pose, &u->arm.geometry, q, NULL);
    mukca_frame_multiply(pose, pose, &u->arm.log.shift[r->log[row]]);
    if (u->free_base) mukca_frame_multiply(pose, &u->arm.log.tracker[r->log[row]], pose);
}

/* Offsets of some milliradians change a column by as much: it is that of the frame after them. */
static void check_diagnosis(const scene *s, mukca_random *random, double offset)
{
    mukca_regression m;
    mukca_unknowns moved;
    mukca_chain chain;
    const mukca_recording_options options = {.free_base = s->base,
                                             .free_tool = s->tool,
                                             .base_per_log = s->per_log && s->base,
                                             .tool_per_log = s->per_log && s->tool};
    assert_ok(mukca_chain_with_frames(&chain, &s->chain, false, s->tool, NULL));
    assert_ok(mukca_regression_create(&m, &chain, &s->data, &options, NULL));
    mukca_unknowns *u = &m.unknowns;
    const int n = u->n_geometry, d = m.recording.dim;
    assert_int_equal(d, s->oriented && !s->sockets ? 6 : 3);
    assert_true(u->free_tool == (s->tool && !s->sockets));
    for (int g = 0; g < MUKCA_MAX_LOGS && !s->sockets; g++) {
        u->arm.log.tracker[g] = s->tracker;
        mukca_rotation_exp(u->arm.log.shift[g].R, (const double[3]){0, 0, 0});
        memset(u->arm.log.shift[g].p, 0, sizeof u->arm.log.shift[g].p);
    }
    if (u->free_tool) u->target = s->target;
    assert_true(mukca_unknowns_clone(&moved, &m.pool, u));
    for (int k = 0; k < u->first_tracker; k++) u->theta[k] = offset * mukca_random_normal(random);
    mukca_unknowns_fold_frames(u);
    mukca_regression_linearise(&m);
    for (int k = 0; k < n; k++)
        for (int i = 0; i < ROWS; i++) {
            const double h = 1e-6;
            const int row = m.recording.order[i];
            mukca_frame side[2];
            double slope[6], in_base[6];
            for (int up = 0; up < 2; up++) {
                mukca_unknowns_assign(&moved, u);
                moved.theta[k] += up ? h : -h;
                predict(&side[up], &moved, &m.recording, row,
                        m.recording.data->socket[row] >= 0
                            ? m.linear.seated + i * chain.n_joints
                            : m.recording.data->q + row * chain.n_joints);
            }
            difference(slope, side, h);
            memcpy(in_base, slope, sizeof slope);
            for (int part = 0; part < 6 && u->free_base; part += 3)
                mukca_mat3_tvec(in_base + part, u->arm.log.tracker[m.recording.log[row]].R,
                                slope + part);
            for (int c = 0; c < d; c++)
                assert_close(m.linear.columns[(d * i + c) * m.linear.stride + k],
                             in_base[c] * (c < 3 ? 1 : u->rotation_weight), 2e-8 + 8 * offset);
        }
    mukca_regression_free(&m);
}

TEST(columns)
{
    mukca_random random = mukca_random_seeded(27);
    for (int kind = 0; kind < 64; kind++) {
        scene s = {.sockets = kind >> 5 & 1,
                   .oriented = kind & 1,
                   .base = kind >> 1 & 1,
                   .tool = kind >> 2 & 1,
                   .per_log = kind >> 3 & 1,
                   .fixed_tip = kind >> 4 & 1};
        if (s.sockets && kind & 15) continue;
        make_arm(&s.chain, &random, s.fixed_tip);
        make_data(&s, &random);
        check_diagnosis(&s, &random, 0);
        check_diagnosis(&s, &random, 1e-3);
        mukca_dataset_free(&s.data);
    }
}

TEST_MAIN(NULL, NULL)
