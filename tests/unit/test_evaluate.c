/* Scores on a gantry whose tip stands where its three sliding joints say, so that they can be
 * worked out by hand. */
#include <stdlib.h>
#include <string.h>

#include "close.h"
#include "fit/cross_training.h"
#include "math/random.h"
#include "model/dataset_subset.h"

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

enum { FITS = 6 };

typedef struct {
    mukca_cross_training result[FITS];
    mukca_score scores[FITS][4];
    int n, stop;
} trainings;

static bool keep_training(void *context, const mukca_cross_training *result, double share)
{
    trainings *t = context;
    assert_true(t->n < FITS && share > 0 && share <= 1);
    t->result[t->n] = *result;
    memcpy(t->scores[t->n++], result->scores, (size_t)result->n * sizeof *result->scores);
    return t->n != t->stop;
}

/* What was not trained on has no part in the fit, and all of it is scored. */
TEST(test_trained)
{
    mukca_chain chain;
    mukca_dataset data, parts[2], none = {0};
    mukca_random random;
    mukca_error error;
    mukca_fit fit;
    double q[40][4];
    int socket[40];
    unsigned char keep[2][40];
    mukca_score again[4];
    trainings found = {.n = 0};
    make_gantry(&chain);
    mukca_random_seed(&random, 41);
    for (int i = 0; i < 40; i++) {
        socket[i] = i % 4;
        keep[0][i] = socket[i] < 2, keep[1][i] = socket[i] >= 2;
        for (int j = 0; j < 4; j++)
            q[i][j] = 0.3 * socket[i] + (j < 3 ? 1e-3 : 1) * mukca_random_normal(&random);
    }
    make_data(&data, (const double(*)[4])q, socket, 40);
    data.n_placements = 2; /* the empty one in the middle goes */
    data.sockets[2].placement = data.sockets[3].placement = 1;
    snprintf(data.placements[0].name, sizeof data.placements[0].name, "a");
    snprintf(data.placements[1].name, sizeof data.placements[1].name, "b");
    for (int k = 0; k < 2; k++)
        assert_int_equal(mukca_dataset_subset(&parts[k], &data, keep[k], NULL), MUKCA_OK);
    assert_int_equal(
        mukca_cross_training_run(&chain, &data, &parts[0], keep_training, &found, NULL), MUKCA_OK);
    assert_int_equal(found.n, 3);
    assert_string_equal(found.result[0].name, "a");
    assert_string_equal(found.result[1].name, "b");
    assert_string_equal(found.result[2].name, "all");
    assert_int_equal(found.result[2].placements, 2);
    for (int k = 0; k < 2; k++) {
        assert_int_equal(mukca_fit_run(&fit, &chain, &parts[k], NULL, NULL), MUKCA_OK);
        const mukca_model model = {.chain = &chain, .theta = fit.theta};
        assert_int_equal(mukca_evaluate(again, NULL, &model, &data), 2);
        for (int i = 0; i < 2; i++) assert_close(found.scores[k][i].mae, again[i].mae, 1e-15);
        const double other = again[1 - k].mae, test = again[0].mae; /* the test data are a's */
        assert_close(found.result[k].mean, (other + test) / 2, 1e-15);
        assert_close(found.result[k].low, fmin(other, test), 1e-15);
        assert_close(found.result[k].high, fmax(other, test), 1e-15);
        mukca_fit_free(&fit);
    }
    found = (trainings){.stop = 2};
    assert_int_equal(mukca_cross_training_run(&chain, &data, &none, keep_training, &found, &error),
                     MUKCA_INTERRUPTED);
    assert_int_equal(found.n, 2);
    found = (trainings){.n = 0};
    assert_int_equal(mukca_cross_training_run(&chain, &data, &none, keep_training, &found, NULL),
                     MUKCA_OK);
    assert_true(isnan(found.result[2].mean)); /* nothing left to test on */
    for (int k = 0; k < 2; k++) mukca_dataset_free(&parts[k]);
    mukca_dataset_free(&data);
}

TEST_MAIN(NULL, NULL)
