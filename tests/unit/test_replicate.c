/* Replicates of a recording: the same postures and sockets, the noise asked for, the same for the
 * same seed. */
#include <stdlib.h>

#include "model/dataset_subset.h"
#include "scene.h"
#include "simulate/simulate.h"

typedef struct {
    scene s;
    mukca_dataset data;
    int *posture;
    mukca_replicate_task task;
} study;

/* A recording with an effect; `readings` successive rows count as one posture. */
static void begin(study *t, const char *text, int readings)
{
    set_scene(&t->s, text, 3);
    t->s.how.noise = 1e-4;
    t->s.how.command = true;
    record(&t->data, &t->s);
    t->posture = calloc((size_t)t->data.n_rows, sizeof *t->posture);
    assert_non_null(t->posture);
    for (int i = 0; i < t->data.n_rows; i++) t->posture[i] = i - i % readings;
    t->task = (mukca_replicate_task){.arm = &t->s.arm, .data = &t->data, .posture = t->posture};
}

static void end(study *t)
{
    mukca_dataset_free(&t->data);
    free(t->posture);
}

/* Positions of the true ball in a replicate, [n_rows][3]. */
static double (*balls(const study *t, mukca_dataset *out, uint64_t seed))[3]
{
    const mukca_corrected *arm = &t->s.arm;
    mukca_row_state states;
    double(*ball)[3] = calloc((size_t)t->data.n_rows, sizeof *ball);
    assert_non_null(ball);
    assert_ok(mukca_simulate_replicate(out, &t->task, seed, &error));
    for (int i = 0; i < out->n_rows; i++) {
        mukca_displacement displacement;
        const mukca_joint_state *state = mukca_dataset_state(&states, out, i);
        mukca_effects_displacement(&displacement, arm->effects, arm->n_effects, &arm->chain,
                                   &arm->geometry, state->q, state);
        mukca_fk_position(ball[i], &arm->geometry, state->q, &displacement);
    }
    return ball;
}

/* Without noise the ball stays in its socket, and the sockets have their distance; the angles are
 * those recorded but for the noise. */
TEST(test_seats)
{
    study t;
    mukca_dataset out;
    begin(&t, "joint_compliance:joint_2=2e-5,zero_jump:joint_3/left=1e-3,socket_distance=1e-3", 1);
    double(*ball)[3] = balls(&t, &out, 1);
    for (int i = 0; i < out.n_rows; i++)
        for (int a = 0; a < 3; a++) assert_close(ball[i][a], ball[i - i % 30][a], 1e-9);
    for (int i = 0; i < out.n_rows * out.n_joints; i++) {
        assert_close(out.q[i], t.data.q[i], 1e-2);
        assert_close(out.command[i] - out.q[i], t.data.command[i] - t.data.q[i], 1e-12);
    }
    for (int p = 0; p < PLACES; p++) {
        assert_close(mukca_distance3(ball[60 * p + 30], ball[60 * p]), 0.051, 1e-8);
    }
    free(ball);
    mukca_dataset_free(&out);
    end(&t);
}

/* A moved socket is displaced from its row on. */
TEST(test_motion)
{
    study t;
    mukca_dataset out;
    begin(&t, NULL, 1);
    const mukca_replicate_motion motion = {.socket = 1, .row = 41, .shift = {1e-3, 0, 2e-3}};
    t.task.motions = &motion;
    t.task.n_motions = 1;
    double(*ball)[3] = balls(&t, &out, 1);
    for (int i = 30; i < 60; i++)
        for (int a = 0; a < 3; a++)
            assert_close(ball[i][a] - ball[30][a], i >= 40 ? motion.shift[a] : 0, 1e-9);
    free(ball);
    mukca_dataset_free(&out);
    end(&t);
}

/* Variance, and covariance of successive rows, about the socket's position without noise: within
 * four standard errors of 720 numbers. */
static void check_noise(double correlation, double shared, double wanted)
{
    study t;
    mukca_dataset out, still;
    begin(&t, NULL, 2);
    double(*centre)[3] = balls(&t, &still, 1);
    t.task.noise = 1e-4;
    t.task.correlation = correlation;
    t.task.shared = shared;
    double(*ball)[3] = balls(&t, &out, 1), variance = 0, covariance = 0;
    int pairs = 0;
    for (int i = 0; i < out.n_rows; i++)
        for (int a = 0; a < 3; a++) {
            const double e = (ball[i][a] - centre[i][a]) / 1e-4;
            variance += e * e / (3 * out.n_rows);
            if (i % 2 == 0) continue;
            covariance += e * (ball[i - 1][a] - centre[i - 1][a]) / 1e-4;
            pairs++;
        }
    assert_close(variance, 1, 0.3);
    assert_close(covariance / pairs, wanted, 0.25);
    free(ball);
    free(centre);
    mukca_dataset_free(&out);
    mukca_dataset_free(&still);
    end(&t);
}

TEST(test_noise)
{
    check_noise(0, 0, 0);
    check_noise(0.6, 0, 0.6);
    check_noise(0, 0.8, 0.8);
}

/* Poses of a tracker; the same seed gives the same replicate. */
TEST(test_poses)
{
    study t = {0};
    mukca_dataset out, again;
    set_scene(&t.s, "joint_scale:joint_2=1e-3", 3);
    assert_ok(mukca_simulate_poses(&t.data, &t.s.arm, NULL, 40, &t.s.how, &error));
    t.posture = calloc(40, sizeof *t.posture);
    assert_non_null(t.posture);
    t.task = (mukca_replicate_task){.arm = &t.s.arm, .data = &t.data, .posture = t.posture};
    t.task.tracker = (mukca_frame){.R = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .p = {1, 2, 3}};
    assert_ok(mukca_simulate_replicate(&out, &t.task, 1, &error));
    for (int i = 0; i < 3 * 40; i++)
        assert_close(out.position[i] - t.data.position[i], i % 3 + 1, 1e-12);
    for (int i = 0; i < 4 * 40; i++) assert_close(out.quaternion[i], t.data.quaternion[i], 1e-12);
    mukca_dataset_free(&out);
    t.task.noise = 1e-4, t.task.rotation = 1e-3;
    assert_ok(mukca_simulate_replicate(&out, &t.task, 2, &error));
    assert_ok(mukca_simulate_replicate(&again, &t.task, 2, &error));
    assert_memory_equal(out.position, again.position, 3 * 40 * sizeof *out.position);
    assert_memory_equal(out.quaternion, again.quaternion, 4 * 40 * sizeof *out.quaternion);
    assert_true(out.position[0] != t.data.position[0] + 1);
    mukca_dataset_free(&out);
    mukca_dataset_free(&again);
    end(&t);
}

TEST_MAIN(NULL, NULL)
