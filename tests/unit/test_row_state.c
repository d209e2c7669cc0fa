/* The state of a row continues times, moves and commands where they are missing, and in a stream.
 */
#include "close.h"
#include "model/dataset_subset.h"
#include "mukca/row_state.h"

static const mukca_joint_state *next(mukca_row_state *rows, int number, double time, double q)
{
    const double angles[2] = {q, -q};
    const mukca_row_reading reading = {
        .q = angles, .time = time, .payload_kg = NAN, .placement = -1, .number = number};
    return mukca_row_state_next(rows, &reading);
}

TEST(times_continue)
{
    mukca_row_state rows;
    mukca_row_state_start(&rows, 2);
    assert_close(next(&rows, 1, NAN, 0)->time, 0, 0);
    assert_close(next(&rows, 2, 1e9, 0)->time, 8, 0); /* the first known time */
    assert_close(next(&rows, 3, 1e9 + 5, 0)->time, 13, 0);
    assert_close(next(&rows, 4, NAN, 0)->time, 21, 0);
    assert_close(next(&rows, 6, NAN, 0)->time, 37, 0); /* one row was left out */
    const mukca_joint_state *last = next(&rows, 7, 1e9 + 60, 0);
    assert_close(last->time, 68, 0);
    assert_close(last->payload_kg, 0, 0);
    mukca_row_state_start(&rows, 2);
    assert_close(next(&rows, 1, 1e9, 0)->time, 0, 0);
    assert_close(next(&rows, 2, 1e9 + 7, 0)->time, 7, 0);
}

TEST(moves_are_from_the_last_row)
{
    mukca_row_state rows;
    const double tried[2] = {0.7, 0}, sent[2] = {0.75, -0.5};
    mukca_row_state_start(&rows, 2);
    assert_close(next(&rows, 1, NAN, 0.25)->move[0], 0, 0);
    assert_close(mukca_row_state_set(&rows, sent)->move[0], 0, 0); /* still the first row */
    const mukca_joint_state *at = next(&rows, 2, NAN, 1);
    assert_close(at->move[0], 0.25, 0);
    assert_close(at->move[1], -0.5, 0);
    assert_close(mukca_row_state_set(&rows, tried)->move[0], 0.7 - 0.75, 0);
    assert_close(mukca_row_state_set(&rows, sent)->move[1], 0, 0);
    assert_close(next(&rows, 3, NAN, 1)->move[0], 0.25, 0);
}

TEST(a_missing_command_shows_no_lag)
{
    mukca_row_state rows;
    const double q[2] = {1, 2}, command[2] = {NAN, 2.5};
    const mukca_effect lag = {.kind = MUKCA_EFFECT_READBACK_LAG, .variant.to_command = true};
    double direction[2];
    mukca_row_reading reading = {.q = q, .command = command, .time = NAN, .number = 1};
    mukca_row_state_start(&rows, 2);
    mukca_effect_direction(direction, 2, &lag, mukca_row_state_next(&rows, &reading));
    assert_close(direction[0], 0, 0);
    assert_close(direction[1], 0.5, 0);
    reading.command = NULL;
    assert_null(mukca_row_state_next(&rows, &reading)->command);
}

/* Readings of one posture are no moves; a lag may settle in them. */
TEST(a_lag_settles_while_the_arm_dwells)
{
    double q[] = {0, 1, 1.0001, 0.9999, 2}, move[5], direction[1];
    int file[5] = {0}, posture[] = {0, 1, 1, 1, 4}, repeat[5];
    const mukca_dataset data = {.n_rows = 5, .n_joints = 1, .q = q, .file = file};
    mukca_effect lag = {.kind = MUKCA_EFFECT_READBACK_LAG};
    mukca_pool pool = {0};
    mukca_postures_move(move, repeat, &pool, posture, &data, q);
    mukca_pool_free(&pool);
    assert_close(move[3], 1, 1e-12);
    assert_close(move[4], 1, 1e-12);
    assert_int_equal(repeat[3], 2);
    assert_int_equal(repeat[4], 0);
    assert_null(mukca_effect_set_variant(&lag, "1readings", 1));
    mukca_effect_direction(direction, 1, &lag,
                           &(mukca_joint_state){.q = q + 3, .move = move + 3, .repeat = 2});
    assert_close(direction[0], exp(-2), 1e-15);
}

/* Rounds through eight postures 60 mrad apart, while the socket drifts by 3 mrad a round. */
TEST(rounds_are_repeats_although_something_drifts)
{
    double q[40];
    int posture[40];
    const mukca_dataset data = {.n_rows = 40, .n_joints = 1, .q = q};
    mukca_pool pool = {0};
    for (int row = 0; row < 40; row++)
        q[row] = 0.06 * (row % 8) + 4e-3 * sin(0.1 * row) + 1e-5 * (row * 7 % 5);
    assert_int_equal(mukca_postures_find(posture, &pool, &data), 32);
    for (int row = 0; row < 40; row++) assert_int_equal(posture[row], row % 8);
    mukca_pool_free(&pool);
}

/* More joints than a bucket has; angles at the edges of cells, and of both signs. */
TEST(repeats_are_found_across_the_cells)
{
    enum { ROWS = 4000, POSTURES = 500, JOINTS = 10 };
    static double q[ROWS * JOINTS];
    static int posture[ROWS];
    const mukca_dataset data = {.n_rows = ROWS, .n_joints = JOINTS, .q = q};
    mukca_pool pool = {0};
    for (int row = 0; row < ROWS; row++)
        for (int j = 0; j < JOINTS; j++)
            q[row * JOINTS + j] =
                0.06 * ((row % POSTURES * (7 * j + 13)) % 31 - 15 + row % POSTURES * (j == 0)) +
                1e-3 * sin(row * (j + 1.7));
    assert_int_equal(mukca_postures_find(posture, &pool, &data), ROWS - POSTURES);
    for (int row = 0; row < ROWS; row++) assert_int_equal(posture[row], row % POSTURES);
    mukca_pool_free(&pool);
}

/* The move does not depend on how often the states come, and is kept while the arm stands. */
TEST(streams_keep_their_direction)
{
    for (int steps = 10; steps <= 10000; steps *= 10) {
        mukca_row_state rows;
        mukca_row_state_stream(&rows, 2);
        for (int i = 0; i <= steps; i++) next(&rows, i, NAN, 0.5 * i / steps);
        for (int i = 0; i < 100; i++) next(&rows, i, NAN, 0.5 + 1e-6 * (i % 2));
        assert_close(rows.state.move[0], 0.1, 2e-6);
        assert_close(rows.state.move[1], -0.1, 2e-6);
        assert_close(next(&rows, 0, NAN, 0.47)->move[0], 0.07, 2e-6); /* it turns back */
        assert_close(next(&rows, 0, NAN, 0.2)->move[0], -0.1, 2e-6);
    }
}

TEST_MAIN(NULL, NULL)
