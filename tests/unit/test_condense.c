/* Readings that repeat a posture add nothing; of too many rows few are kept, in blocks. */
#include "diagnose/diagnose.h"
#include "model/dataset_subset.h"
#include "scene.h"

enum { TIMES = 3 };

static scene s;

/* Each row of a recording TIMES times, at angles that differ by less than an encoder's noise,
 * without times. */
static void repeat(mukca_dataset *out, const mukca_dataset *data)
{
    const int n = data->n_joints;
    scene longer = s;
    longer.how.rows *= TIMES;
    record(out, &longer);
    free(out->time);
    out->time = NULL;
    for (int i = 0; i < out->n_rows; i++)
        for (int j = 0; j < n; j++)
            out->q[i * n + j] =
                data->q[i / TIMES * n + j] + 5e-5 * sin(12.9898 * (i + 1) + 78.233 * j);
}

FIXTURE(set_up)
{
    set_scene(&s, "joint_compliance:joint_2=2e-4", 7);
    s.how.noise = 1e-4;
    return 0;
}

/* Of too many rows, those of a posture are averaged. */
TEST(postures_are_averaged)
{
    mukca_dataset data, longer;
    mukca_condensed how;
    record(&data, &s);
    repeat(&longer, &data);
    const int rows = longer.n_rows;
    double *mean = zeroed((size_t)rows, (size_t)data.n_joints * sizeof *mean);
    for (int i = 0; i < rows * data.n_joints; i++)
        mean[i / (TIMES * data.n_joints) * data.n_joints + i % data.n_joints] +=
            longer.q[i] / TIMES;
    assert_ok(mukca_condense(&how, &longer, rows, &error));
    assert_int_equal(longer.n_rows, rows); /* few enough as they are */
    assert_ok(mukca_condense(&how, &longer, rows - 1, &error));
    assert_int_equal(how.postures, data.n_rows);
    assert_int_equal(longer.n_rows, data.n_rows);
    for (int i = 0; i < data.n_rows; i++) {
        assert_int_equal(longer.socket[i], data.socket[i]);
        assert_int_equal(longer.row[i], TIMES * i + 1);
        for (int j = 0; j < data.n_joints; j++)
            assert_close(longer.q[i * data.n_joints + j], mean[i * data.n_joints + j], 1e-12);
    }
    free(mean);
    mukca_dataset_free(&data);
    mukca_dataset_free(&longer);
}

/* Readings that repeat a posture add nothing: the same causes, with about the same interval. */
TEST(readings_share_noise)
{
    mukca_dataset data, longer;
    mukca_diagnosis d[2];
    record(&data, &s);
    repeat(&longer, &data);
    for (int i = 0; i < 2; i++)
        assert_ok(mukca_diagnose(&d[i], &s.chain, i ? &longer : &data,
                                 &(mukca_diagnose_options){.no_folds = true}, &error));
    assert_int_equal(d[0].verdict, d[1].verdict);
    assert_int_equal(d[0].n_causes, 1);
    assert_int_equal(d[1].n_causes, 1);
    const mukca_cause *one = d[0].causes, *all = d[1].causes;
    assert_int_equal(all->effect.kind, one->effect.kind);
    assert_close(all->amplitude, one->amplitude, 0.02 * one->amplitude); /* other prior sizes */
    assert_close(all->high - all->low, one->high - one->low, 0.2 * (one->high - one->low));
    for (int i = 0; i < 2; i++) mukca_diagnosis_free(&d[i]);
    mukca_dataset_free(&data);
    mukca_dataset_free(&longer);
}

/* What is left of too many postures is blocks of successive ones. */
TEST(blocks_are_spread)
{
    mukca_dataset data;
    mukca_condensed how;
    record(&data, &s);
    const int rows = data.n_rows;
    int breaks = 0;
    assert_true(rows > 150);
    assert_ok(mukca_condense(&how, &data, 100, &error));
    assert_int_equal(how.postures, rows);
    assert_true(how.samples > 50 && how.samples <= 100);
    assert_int_equal(data.n_rows, how.samples);
    for (int i = 1; i < data.n_rows; i++) breaks += data.row[i] != data.row[i - 1] + 1;
    assert_int_equal(breaks, 1); /* two blocks, of which one may begin the recording */
    mukca_dataset_free(&data);
}

TEST_MAIN(set_up, NULL)
