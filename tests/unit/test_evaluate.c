/* Scores on a gantry whose tip stands where its three sliding joints say, so that they can be
 * worked out by hand. */
#include <stdlib.h>
#include <string.h>

#include "close.h"
#include "fit/evaluate.h"

/* Three sliding joints along x, y, z, one turning about z, a fixed tip on its axis. */
static void make_gantry(mukca_chain *chain)
{
    memset(chain, 0, sizeof *chain);
    chain->n_elements = 5;
    chain->n_joints = 4;
    for (int k = 0; k < 5; k++) {
        mukca_element *e = &chain->element[k];
        snprintf(e->name, sizeof e->name, "g%d", k);
        e->type = k < 3 ? MUKCA_PRISMATIC : k == 3 ? MUKCA_REVOLUTE : MUKCA_FIXED;
        e->joint = k < 4 ? k : -1;
        e->axis[k < 3 ? k : 2] = 1;
        if (k < 4) chain->joint_element[k] = k;
    }
}

static void make_data(mukca_dataset *data, const double (*q)[4], const int *socket, int rows)
{
    assert_int_equal(mukca_dataset_create(data, rows, 4, 4, 3, NULL), MUKCA_OK);
    static const int placement[4] = {0, 0, 2, 2}; /* placement 1 has no rows */
    for (int s = 0; s < 4; s++) data->sockets[s].placement = placement[s];
    data->distances = calloc(2, sizeof *data->distances);
    assert_non_null(data->distances);
    data->n_distances = 2;
    data->distances[0] = (mukca_distance){0, 1, 0.05};
    data->distances[1] = (mukca_distance){2, 3, 0.1};
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
    make_gantry(&chain);
    mukca_chain_theta(theta, &chain);
    make_data(&data, q, socket, 9);
    data.position = malloc(27 * sizeof *data.position);
    data.quaternion = malloc(36 * sizeof *data.quaternion);
    assert_true(data.position && data.quaternion);
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
    const mukca_effect scale = {.kind = MUKCA_EFFECT_JOINT_SCALE,
                                .joint = 0,
                                .placement = -1,
                                .terms = 1,
                                .coefficient = {0.1}};
    model.effects = &scale;
    model.n_effects = 1;
    assert_int_equal(mukca_evaluate(scores, NULL, &model, &data), 3);
    assert_close(scores[0].mae, 0.0055, 1e-15);
    mukca_dataset_free(&data);
}

TEST_MAIN(NULL, NULL)
