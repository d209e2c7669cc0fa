/* Scores on a gantry, to be worked out by hand: its tip stands where three sliding joints along x,
 * y and z say, and is turned about z by the fourth. */
#include "arms.h"
#include "close.h"
#include "fit/evaluate.h"

static void make_data(mukca_dataset *data, const double (*q)[4], const int *socket, int rows)
{
    assert_ok(mukca_dataset_create(data, rows, 4, 4, 3, NULL));
    static const int placement[4] = {0, 0, 2, 2}; /* placement 1 has no rows */
    for (int s = 0; s < 4; s++) data->sockets[s].placement = placement[s];
    data->distances = zeroed(2, sizeof *data->distances);
    data->n_distances = 2;
    data->distances[0] = (mukca_distance){.a = 0, .b = 1, .distance = 0.05};
    data->distances[1] = (mukca_distance){.a = 2, .b = 3, .distance = 0.1};
    memcpy(data->q, q, (size_t)rows * sizeof *q);
    memcpy(data->socket, socket, (size_t)rows * sizeof *socket);
}

TEST(test_by_hand)
{
    static const double q[9][4] = {{0, 0, 0, 1},       {0.02, 0, 0, 2},      {0.01, 0.06, 0, 0},
                                   {0.01, 0.06, 0, 1}, {0.3, 0.4, 0, 0},     {0.3, 0.4, 0.006, 0},
                                   {0.3, 0.5, 0, 0},   {0.1, 0.2, 0.3, 0.5}, {0.1, 0.2, 0.3, 0.5}};
    static const int socket[9] = {0, 0, 1, 1, 2, 2, 3, -1, -1};
    mukca_chain chain;
    mukca_dataset data;
    mukca_score scores[4], mean;
    double theta[30];
    make_chain(&chain, "PPPRF", NULL, "g", 0);
    for (int k = 0; k < 2; k++) chain.element[k].axis[2] = 0, chain.element[k].axis[k] = 1;
    mukca_chain_theta(theta, &chain);
    make_data(&data, q, socket, 9);
    data.position = zeroed(27, sizeof *data.position);
    data.quaternion = zeroed(36, sizeof *data.quaternion);
    for (int i = 0; i < 27; i++) data.position[i] = NAN;
    for (int i = 0; i < 36; i++) data.quaternion[i] = NAN;
    data.position[21] = 0.1, data.position[22] = 0.2, data.position[23] = 0.302; /* 2 mm off */
    data.quaternion[32] = cos(0.2), data.quaternion[35] = sin(0.2); /* 0.4 rad; arm 0.5 */
    data.quaternion[33] = data.quaternion[34] = 0;

    mukca_model model = {.chain = &chain, .theta = theta};
    assert_int_equal(mukca_evaluate(scores, &mean, &model, &data), 3);
    assert_int_equal(scores[0].placement, 0);
    assert_int_equal(scores[1].placement, 2);
    assert_int_equal(scores[2].placement, -1);
    assert_int_equal(scores[0].rows, 4);
    assert_close(scores[0].mae, 0.005, 1e-15); /* 10, 10, 0, 0 mm */
    assert_close(scores[0].std, sqrt(2e-4 / 4), 1e-15);
    assert_close(scores[0].distance_error, 0.01, 1e-15); /* 60 mm */
    assert_true(isnan(scores[0].rotation_error));
    assert_close(scores[1].mae, 0.002, 1e-15); /* 3, 3, 0 mm */
    assert_close(scores[1].distance_error, sqrt(0.01 + 9e-6) - 0.1, 1e-15);
    assert_int_equal(scores[2].rows, 2);
    assert_close(scores[2].mae, 0.002, 1e-15);
    assert_close(scores[2].rotation_error, 0.1, 1e-12);
    assert_true(isnan(scores[2].distance_error));
    assert_int_equal(mean.rows, 9);
    assert_close(mean.mae, 0.003, 1e-15);
    assert_close(mean.distance_error, (scores[0].distance_error + scores[1].distance_error) / 2,
                 1e-15);

    /* an effect: the first joint counts a tenth too much */
    const mukca_effect scale = make_effect(MUKCA_EFFECT_JOINT_SCALE, 0, 0.1);
    model.effects = &scale;
    model.n_effects = 1;
    assert_int_equal(mukca_evaluate(scores, NULL, &model, &data), 3);
    assert_close(scores[0].mae, 0.0055, 1e-15);
    mukca_dataset_free(&data);
}

TEST_MAIN(NULL, NULL)
