/* Zero-phase filter, differences and decimation: against SciPy and closed forms. */
#include "dynamics/signals.h"

#include "close.h"

enum { MOST = 200, WIDTH = 11 };

static double x[MOST * WIDTH], scratch[3 * MOST];

/* The signal of the references, with a constant and a factor that differ by column. */
static double signal(int k, int n, int column)
{
    return column + (1 + column) * (sin(0.3 * k) + 0.01 * k * k / n + (k * 7) % 5 * 0.1);
}

static void fill(int rows, int width)
{
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < width; c++) x[r * width + c] = signal(r, rows, c);
}

/* SciPy 1.10.1, rate 100 Hz: s = min(cutoff / 50, 0.95), sosfiltfilt(butter(order, s,
 * output="sos"), x, padtype="odd", padlen=min(int(6 / s), rows - 2)); the second one's ends are cut
 * short.  Values of the first two rows, the middle one and the last two. */
static const struct {
    int order;
    double cutoff;
    int rows;
    double value[5];
} scipy[] = {
    {3, 8, 120, {1.67386512e-05, 0.352919828852, -0.221189968416, 0.774678873473, 0.570503234747}},
    {4, 2.5, 40, {-0.00752249723, 0.01795254552, 0.43995510558, -0.02059563957, -0.08028173418}},
    {1, 20, 50, {6.6e-14, 0.460700620415, 1.16900496982, 1.63386096813, 1.62594683114}},
    {2, 49, 30, {0.010973094504, 0.487194909025, -0.894818126526, 1.22524282697, 1.22950091393}}};

TEST(the_filter_is_scipys_in_each_of_many_columns)
{
    for (size_t i = 0; i < sizeof scipy / sizeof *scipy; i++) {
        const int rows = scipy[i].rows, at[5] = {0, 1, rows / 2, rows - 2, rows - 1};
        mukca_lowpass lowpass;
        fill(rows, WIDTH);
        mukca_lowpass_set(&lowpass, scipy[i].order, scipy[i].cutoff, 100);
        mukca_lowpass_apply(x, rows, WIDTH, WIDTH, &lowpass, scratch);
        for (int k = 0; k < 5; k++)
            for (int c = 0; c < WIDTH; c++)
                assert_close(x[at[k] * WIDTH + c], c + (1 + c) * scipy[i].value[k], 1e-9);
    }
}

TEST(the_filter_leaves_other_columns_and_short_signals_alone)
{
    mukca_lowpass lowpass;
    mukca_lowpass_set(&lowpass, 3, 8, 100);
    fill(50, WIDTH);
    mukca_lowpass_apply(x, 50, 9, WIDTH, &lowpass, scratch);
    for (int r = 0; r < 50; r++)
        for (int c = 9; c < WIDTH; c++) assert_true(x[r * WIDTH + c] == signal(r, 50, c));
    fill(2, WIDTH);
    mukca_lowpass_apply(x, 2, WIDTH, WIDTH, &lowpass, scratch);
    for (int c = 0; c < WIDTH; c++) assert_true(x[WIDTH + c] == signal(1, 2, c));
}

TEST(two_passes_halve_the_amplitude_at_the_cutoff_without_a_shift)
{
    mukca_lowpass lowpass;
    mukca_lowpass_set(&lowpass, 4, 5, 100);
    for (int r = 0; r < MOST; r++) x[r] = sin(2 * 3.14159265358979323846 * 0.05 * r);
    mukca_lowpass_apply(x, MOST, 1, 1, &lowpass, scratch);
    for (int r = 80; r < 120; r++)
        assert_close(x[r], 0.5 * sin(2 * 3.14159265358979323846 * 0.05 * r), 1e-3);
}

TEST(differences_are_central_and_one_sided_at_the_ends)
{
    const double y[] = {0, 1, 1, 2, 4, 4, 9, 8, 16, 16}; /* two columns */
    const double slope[] = {10, 10, 20, 15, 40, 30, 60, 60, 70, 80};
    double dy[10];
    mukca_differences(dy, y, 5, 2, 0.1);
    for (int i = 0; i < 10; i++) assert_close(dy[i], slope[i], 1e-12);
}

TEST(decimation_keeps_every_nth_row)
{
    double y[14]; /* two columns */
    for (int i = 0; i < 14; i++) y[i] = i;
    assert_int_equal(mukca_decimate(y, 7, 2, 3), 3);
    for (int r = 0; r < 3; r++) assert_true(y[2 * r] == 6 * r && y[2 * r + 1] == 6 * r + 1);
}

TEST_MAIN(NULL, NULL)
