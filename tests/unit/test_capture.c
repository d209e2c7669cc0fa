/* A sample is the mean of a window in which the arm stands still; moving, old, thin and doubled
 * streams are refused; odd postures get a remark. */
#include "arms.h"
#include "capture/capture.h"
#include "close.h"
#include "math/random.h"

static mukca_chain chain;
static mukca_capture capture;
static mukca_capture_sample sample; /* the last one */
static mukca_capture_settings settings;
static char text[MUKCA_CAPTURE_TEXT];

/* A planar arm of three links of 0.4 m: easy to place by hand. */
FIXTURE(setup)
{
    make_chain(&chain, "RRRF", NULL, "A", 3);
    for (int k = 1; k < 4; k++) chain.element[k].xyz[0] = 0.4;
    memset(&settings, 0, sizeof settings);
    return mukca_capture_init(&capture, &chain, NULL, &settings, &error) ? 1 : 0;
}

FIXTURE(teardown)
{
    mukca_capture_free(&capture);
    return 0;
}

static mukca_status take(double age)
{
    return mukca_capture_take(&sample, &capture, age, &error);
}

static unsigned feed(double time, const double q[3])
{
    mukca_capture_reading reading = {
        .time = time, .arrival = time, .q = {q[0], q[1], q[2]}, .effort = {(double)NAN}};
    return mukca_capture_feed(&capture, &reading);
}

static double now = 1000;

/* Stand at q for `seconds` at `rate`, with noise; true when a sample was due meanwhile. */
static bool stand(const double q[3], double seconds, double rate, int *socket)
{
    static mukca_random random = {.state = {1, 2, 3, 4}};
    bool due = false;
    char said[MUKCA_CAPTURE_TEXT];
    for (int i = 0; i < (int)(seconds * rate); i++) {
        now += 1 / rate;
        mukca_capture_reading reading = {.time = now, .arrival = now, .effort = {1, 2, 3}};
        for (int j = 0; j < 3; j++) reading.q[j] = q[j] + 2e-5 * mukca_random_normal(&random);
        mukca_capture_feed(&capture, &reading);
        int s;
        if (mukca_capture_due(&s, said, &capture)) {
            due = true;
            *socket = s;
            assert_ok(take(0));
            capture.socket = s;
            assert_ok(mukca_capture_keep(text, &capture, sample.q, &error));
        }
        if (said[0]) memcpy(text, said, sizeof text);
    }
    return due;
}

/* Joint angles that put the tip at (x, y) with the last link at `angle`. */
static void reach(double q[3], double x, double y, double angle)
{
    double wx = x - 0.4 * cos(angle), wy = y - 0.4 * sin(angle), r = hypot(wx, wy);
    double elbow = acos((r * r - 0.32) / 0.32);
    q[0] = atan2(wy, wx) - elbow / 2;
    q[1] = elbow;
    q[2] = angle - q[0] - q[1];
}

TEST(a_sample_is_the_mean_of_the_window)
{
    assert_error(take(0), MUKCA_NEGATIVE, error, "no joint state");
    /* 1 kHz; the window of 0.2 s holds the last 200 readings, of which the mean is known */
    for (int i = 0; i < 5000; i++) {
        double q[3] = {1 + 1e-4 * (i % 2), -2, 3e-4 * (i < 4800 ? i : 4800)};
        assert_int_equal(feed(0.001 * i, q), 0);
    }
    assert_ok(take(0));
    assert_int_equal(sample.n, 200);
    assert_close(sample.q[0], 1.00005, 1e-12);
    assert_true(sample.q[1] == -2);
    assert_true(sample.q[2] == 1.44);
    assert_close(sample.spread[0], 0.5e-4 * sqrt(200 / 199.), 1e-10);
    assert_true(sample.spread[1] == 0);
    assert_close(sample.time, 4.999, 1e-9);
}

TEST(moving_stale_and_thin_streams_are_refused)
{
    for (int i = 0; i < 1000; i++) feed(0.001 * i, (const double[]){0, 0.02 * 0.001 * i, 0});
    assert_error(take(0), MUKCA_NEGATIVE, error, "the arm moves: A2 by 4.0 mrad");
    for (int i = 1000; i < 1300; i++) feed(0.001 * i, (const double[]){0, 0.02, 0});
    assert_ok(take(0.1));
    assert_error(take(0.25), MUKCA_NEGATIVE, error, "0.25 s old");
    /* the same numbers again: the driver does not update any more */
    assert_ok(mukca_capture_select(&capture, "p", "0", &error));
    assert_ok(take(0));
    assert_ok(mukca_capture_keep(text, &capture, sample.q, &error));
    assert_ok(take(0));
    assert_true(mukca_capture_repeats(&capture, sample.q));
    sample.q[1] += 1e-9;
    assert_false(mukca_capture_repeats(&capture, sample.q));
    /* the stream stops for 3 s and returns: the window must fill anew */
    assert_int_equal(feed(4.3, (const double[]){1, 1, 1}), 0);
    feed(4.301, (const double[]){1, 1, 1});
    assert_error(take(0), MUKCA_NEGATIVE, error, "too few joint states");
    for (int i = 2; i < 201; i++) feed(4.3 + 0.001 * i, (const double[]){1, 1, 1});
    assert_ok(take(0));
}

static mukca_status arrive(double time, double arrival, double age)
{
    mukca_capture_reading reading = {.time = time, .arrival = arrival, .q = {0, 0, 0.1}};
    mukca_capture_feed(&capture, &reading);
    return take(age);
}

/* Readings that waited on their way are of another moment than a request from outside. */
TEST(what_arrives_at_once_is_not_the_present)
{
    double t = 0;
    for (; t < 1; t += 0.01) (void)arrive(t, t, 0);
    assert_ok(arrive(t, t, 0));
    for (int i = 0; i < 60; i++) /* for 3 s nothing arrives, then what was sent meanwhile */
        assert_error(arrive(t += 0.01, 4, 0), MUKCA_NEGATIVE, error, "came at once after a pause");
    assert_ok(arrive(t += 0.01, 4, MUKCA_CAPTURE_IN_ORDER));
    double arrival = 4;
    for (int i = 0; i < 11; i++)
        assert_int_equal(arrive(t += 0.01, arrival += 0.01, 0), MUKCA_NEGATIVE);
    assert_ok(arrive(t += 0.01, arrival += 0.0101, 0));
    for (int i = 0; i < 60; i++) /* a simulator at five times real time */
        (void)arrive(t += 0.05, arrival += 0.01, 0);
    assert_ok(arrive(t += 0.05, arrival += 0.01, 0));
    for (int i = 0; i < 60; i++) /* and at a tenth of it */
        (void)arrive(t += 0.01, arrival += 0.1, 0);
    assert_ok(arrive(t += 0.01, arrival += 0.1, 0));
}

TEST(slow_streams_need_three_readings)
{
    for (int i = 0; i < 5; i++) feed(0.09 * i, (const double[]){0, 0, 0.1});
    assert_ok(take(0));
    assert_int_equal(sample.n, 3);
    for (int i = 0; i < 5; i++) feed(1 + 0.15 * i, (const double[]){0, 0, 0.1});
    assert_error(take(0), MUKCA_NEGATIVE, error, "--window");
}

/* A window fits the ring at any rate; and any clock can be survived. */
TEST(fast_streams_and_mad_clocks)
{
    for (int i = 0; i < 400000; i++) feed(2e-6 * i, (const double[]){0.1, 0.2, 0.3});
    assert_ok(take(0));
    assert_true(sample.n > 1000);
    assert_int_equal(feed(-5, (const double[]){0.1, 0.2, 0.3}), MUKCA_CAPTURE_BACKWARDS);
    assert_int_equal(take(0), MUKCA_NEGATIVE);
    feed(9e12, (const double[]){0.1, 0.2, 0.3});
    for (int i = 0; i < 300; i++) feed(10 + 0.001 * i, (const double[]){0.1, 0.2, 0.3});
    assert_ok(take(0));
    for (int i = 0; i < 300; i++) feed(10.3, (const double[]){0.1, 0.2, 0.3}); /* clock stands */
    feed(10.6, (const double[]){0.1, 0.2, 0.3});
    assert_int_equal(take(0), MUKCA_NEGATIVE);
}

TEST(two_arms_on_one_channel_are_told)
{
    int told = 0, backwards = 0;
    for (int i = 0; i < 1000; i++) {
        told += feed(0.001 * i, (const double[]){0, 0, 0}) == MUKCA_CAPTURE_TWO_SENDERS;
        told += feed(0.001 * i + 1e-4, (const double[]){0.5, 0, 0}) == MUKCA_CAPTURE_TWO_SENDERS;
    }
    assert_int_equal(told, 1);
    assert_error(take(0), MUKCA_NEGATIVE, error, "two arms");
    for (int i = 0; i < 2000; i++) feed(2 + 0.001 * i, (const double[]){0, 0, 0}); /* one leaves */
    assert_ok(take(0));
    for (int i = 0; i < 10; i++) { /* same posture, but clocks 1 h apart */
        unsigned a = feed(10 + 0.001 * i, (const double[]){0, 0, 0});
        unsigned b = feed(3610 + 0.001 * i, (const double[]){0, 0, 0});
        backwards += !!(a & MUKCA_CAPTURE_BACKWARDS);
        told += (a | b) & MUKCA_CAPTURE_TWO_SENDERS ? 1 : 0;
    }
    assert_int_equal(told, 2);
    assert_int_equal(backwards, 9);
}

/* Standing still in two sockets by turns records both, each posture once, and no stop elsewhere. */
TEST(standing_still_records_by_itself)
{
    double q[3];
    int socket = -1, due = 0;
    assert_ok(mukca_capture_select(&capture, "front", "0", &error));
    for (int i = 0; i < 5; i++) {
        reach(q, 0.6, 0.2, 0.2 * i);
        due += stand(q, 1.5, 200, &socket);
        assert_int_equal(socket, 0);
        assert_false(stand(q, 3, 200, &socket)); /* still the same stop */
    }
    assert_int_equal(due, 5);
    reach(q, 0.6, 0.5, 0.1);
    text[0] = '\0';
    assert_false(stand(q, 2, 200, &socket)); /* on the way, 300 mm off */
    assert_part(text, "300 mm from socket 0");
    for (int i = 0; i < 5; i++) {
        reach(q, 0.65, 0.2, 0.2 * i);
        assert_true(stand(q, 1.5, 200, &socket));
        assert_int_equal(socket, 1);
    }
    assert_string_equal(mukca_capture_socket(&capture), "1");
    reach(q, 0.6, 0.2, 0.2);
    assert_false(stand(q, 1.5, 200, &socket)); /* a posture that is recorded */
    assert_int_equal(mukca_capture_count(&capture, 0), 5);
    assert_int_equal(mukca_capture_count(&capture, 1), 5);
    /* the full time counts */
    reach(q, 0.6, 0.2, -0.3);
    assert_false(stand(q, 0.9, 200, &socket));
    assert_true(stand(q, 0.3, 200, &socket));
    assert_int_equal(socket, 0);
}

/* Keep a sample there; what is remarked. */
static const char *keep(double x, double y, double angle)
{
    double q[3];
    reach(q, x, y, angle);
    assert_ok(mukca_capture_keep(text, &capture, q, &error));
    return text;
}

TEST(remarks_name_what_is_odd)
{
    double rms, last, coverage[3];
    mukca_capture_advice advice;
    assert_int_equal(mukca_capture_keep(text, &capture, (const double[]){0, 0, 0}, &error),
                     MUKCA_INPUT);
    assert_ok(mukca_capture_select(&capture, "front", "0", &error));
    for (int i = 0; i < 6; i++) assert_string_equal(keep(0.6 + 1e-4 * (i % 2), 0.2, 0.2 * i), "");
    /* in the other socket, which has no samples yet */
    assert_part(keep(0.648, 0.2, 0.5),
                "48 mm from this socket's other samples: this looks like socket 1");
    mukca_capture_drop(&capture);
    mukca_capture_spread(&rms, &last, &capture, 0);
    assert_close(rms, 0.5e-4, 1e-9);
    assert_close(last, 0.6e-4, 1e-9);
    assert_part(keep(0.6, 0.2, 0.201), "nearly the posture of sample 2");
    mukca_capture_drop(&capture);
    assert_string_equal(mukca_capture_next_label(&capture), "1");
    assert_ok(mukca_capture_select(&capture, "front", "1", &error));
    assert_string_equal(mukca_capture_next_label(&capture), "0");
    for (int i = 0; i < 6; i++) { /* the ball stays while the label changes: noticed once */
        const char *said =
            strstr(keep(0.601, 0.2, 0.9 + 0.1 * i), "is the ball really in socket 1?");
        assert_int_equal(said != NULL, i == 0);
        assert_ok(mukca_capture_advise(&advice, &capture, &error));
    }
    for (int i = 0; i < 6; i++) mukca_capture_drop(&capture);
    assert_string_equal(keep(0.65, 0.2, 0.9), "");
    assert_part(keep(0.6, 0.2, 0.7), "looks like socket 0");
    assert_int_equal(capture.rows.n_rows, 8);
    mukca_capture_coverage(coverage, &capture);
    for (int j = 0; j < 3; j++) assert_true(coverage[j] > 0.01 && coverage[j] < 0.5);
    while (capture.rows.n_rows) mukca_capture_drop(&capture);
    mukca_capture_spread(&rms, &last, &capture, 0);
    assert_true(isnan(rms) && isnan(last));
}

TEST_EACH(setup, teardown)
