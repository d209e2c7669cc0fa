/* Stream of readings: window, detection of standstill, averaging to a sample. */
#include <math.h>
#include <string.h>

#include "capture/capture.h"

enum { MIN_READINGS = 3 }; /* the minimum for a spread */

#define LEAST_COVERED 0.6 /* of a window; one period less than all of it, with slow streams */

/* ---- readings ---- */

/* The reading `back` before the last. */
static const mukca_capture_reading *stored(const mukca_capture *capture, int back)
{
    return &capture->ring[(capture->head - 1 - back + 2 * MUKCA_CAPTURE_RING) % MUKCA_CAPTURE_RING];
}

/* Two arms on one channel: readings or clocks that jump away and back. */
static bool jumped(const mukca_capture *capture, const mukca_capture_reading *reading)
{
    double step = reading->time - capture->last.time;
    if (step < 0) return true;
    for (int j = 0; j < capture->chain->n_joints; j++) {
        double leap = fabs(reading->q[j] - capture->last.q[j]);
        if (leap > 0.05 + 10 * step && fabs(reading->q[j] - capture->before.q[j]) < 0.2 * leap)
            return true;
    }
    return false;
}

unsigned mukca_capture_feed(mukca_capture *capture, const mukca_capture_reading *reading)
{
    const mukca_capture_settings *s = &capture->settings;
    unsigned found = 0;
    double step = reading->time - capture->last.time;
    if (capture->has_last) {
        double before = capture->jumps;
        capture->jumps = jumped(capture, reading) ? before + 1 : before * 0.98;
        if (before < 4 && capture->jumps >= 4) found |= MUKCA_CAPTURE_TWO_SENDERS;
        if (step < 0) {
            found |= MUKCA_CAPTURE_BACKWARDS;
            capture->count = 0;
            capture->standing = false;
            capture->checked = reading->time;
        }
    }
    capture->before = capture->last;
    capture->last = *reading;
    capture->has_last = true;
    /* Drop readings of fast streams: a window always fits the ring buffer. */
    if (capture->count &&
        reading->time - stored(capture, 0)->time < s->window / (0.5 * MUKCA_CAPTURE_RING))
        return found;
    capture->ring[capture->head] = *reading;
    capture->head = (capture->head + 1) % MUKCA_CAPTURE_RING;
    if (capture->count < MUKCA_CAPTURE_RING) capture->count++;
    return found;
}

/* ---- samples ---- */

/* Number of readings in the window that ends with the last one; *empty: the longest gap between
 * them, s. */
static int count_window(double *empty, const mukca_capture *capture)
{
    const double window = capture->settings.window, end = stored(capture, 0)->time;
    int n = 1; /* half-open, with a margin for rounding: times are whole microseconds */
    *empty = 0;
    while (n < capture->count && stored(capture, n)->time > end - window + 1e-6) {
        *empty = fmax(*empty, stored(capture, n - 1)->time - stored(capture, n)->time);
        n++;
    }
    return n;
}

/* Number of the latest readings that arrived over a window without a pause of a window; 0: none:
 * they had waited on their way, and may be old. */
static int count_arrived(const mukca_capture *capture)
{
    const double window = capture->settings.window, end = stored(capture, 0)->arrival;
    for (int n = 1; n <= capture->count; n++) {
        const double here = stored(capture, n - 1)->arrival;
        if (end - here >= LEAST_COVERED * window) return n;
        if (n < capture->count && here - stored(capture, n)->arrival > window) break;
    }
    return 0;
}

/* Mean and spread of joint j over the last sample->n readings; returns its range over the last n.
 */
static double take_joint(mukca_capture_sample *sample, const mukca_capture *capture, int j, int n)
{
    const double first = stored(capture, 0)->q[j];
    double low = first, high = first, sum = 0, squares = 0, effort = 0, command = 0;
    for (int i = 0; i < n || i < sample->n; i++) {
        const double q = stored(capture, i)->q[j], d = q - first;
        low = fmin(low, q);
        high = fmax(high, q);
        if (i >= sample->n) continue;
        sum += d;
        squares += d * d;
        effort += stored(capture, i)->effort[j];
        command += stored(capture, i)->command[j];
    }
    const double mean = sum / sample->n;
    const double variance = (squares - sample->n * mean * mean) / (sample->n - 1);
    sample->q[j] = first + mean;
    sample->spread[j] = variance > 0 ? sqrt(variance) : 0;
    sample->effort[j] = effort / sample->n;
    sample->command[j] = command / sample->n;
    return high - low;
}

mukca_status mukca_capture_take(mukca_capture_sample *sample, const mukca_capture *capture,
                                double age, mukca_error *error)
{
    const double window = capture->settings.window;
    const mukca_chain *chain = capture->chain;
    if (!capture->count) return mukca_fail(error, MUKCA_NEGATIVE, "no joint state has come yet");
    if (age > window)
        return mukca_fail(error, MUKCA_NEGATIVE, "the last joint state is %.2f s old", age);
    if (capture->jumps >= 4)
        return mukca_fail(error, MUKCA_NEGATIVE, "two arms seem to send on this channel");
    double pause, widest = 0;
    const int n = count_window(&pause, capture), arrived = age < 0 ? n : count_arrived(capture);
    const double end = stored(capture, 0)->time, covered = end - stored(capture, n - 1)->time;
    if (n < MIN_READINGS || covered < LEAST_COVERED * window || pause > 0.5 * window)
        return mukca_fail(error, MUKCA_NEGATIVE,
                          "too few joint states in the last %g s (%d): hold still a little longer, "
                          "or use a longer --window",
                          window, n);
    if (!arrived)
        return mukca_fail(error, MUKCA_NEGATIVE,
                          "the joint states of the last %g s came at once after a pause: hold "
                          "still a little longer",
                          window);
    memset(sample, 0, sizeof *sample);
    sample->time = end;
    sample->n = n;
    int worst = 0;
    for (int j = 0; j < chain->n_joints; j++) {
        const double range = take_joint(sample, capture, j, arrived);
        if (range > widest) widest = range, worst = j;
    }
    if (widest <= capture->settings.range) return MUKCA_OK;
    return mukca_fail(
        error, MUKCA_NEGATIVE,
        "the arm moves: %s by %.1f m%s in %g s (%.1f allowed): hold still and trigger again",
        mukca_chain_joint_name(chain, worst), 1e3 * widest,
        chain->element[chain->joint_element[worst]].type == MUKCA_PRISMATIC ? "m" : "rad", window,
        1e3 * capture->settings.range);
}
