/* Samples of a capture: placements and sockets, triggers, plausibility checks; memory. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "capture/capture.h"

/* Distance of a sample by standstill from all others in some joint, rad or m. */
static const double least_difference = 0.02;

bool mukca_capture_repeats(const mukca_capture *capture, const double *q)
{
    const size_t n = (size_t)capture->rows.n_joints, rows = (size_t)capture->rows.n_rows;
    return rows && memcmp(q, capture->rows.q + (rows - 1) * n, n * sizeof *q) == 0;
}

/* Sample of the current placement with a posture within `limit` of q; -1: none. */
static int find_posture(const mukca_capture *capture, const double *q, double limit)
{
    const mukca_dataset *rows = &capture->rows;
    if (capture->socket < 0) return -1;
    int placement = rows->sockets[capture->socket].placement;
    for (int i = rows->n_rows - 1; i >= 0; i--)
        if (mukca_dataset_placement(rows, i) == placement &&
            mukca_largest_difference(q, rows->q + i * rows->n_joints, rows->n_joints) < limit)
            return i;
    return -1;
}

/* Socket of the current placement, or of `any`, nearest to x, and its distance; -1: no samples
 * yet. */
static int nearest_socket(double *how_far, const mukca_capture *capture, const double x[3],
                          int without, bool any)
{
    const mukca_dataset *rows = &capture->rows;
    int nearest = -1;
    *how_far = HUGE_VAL;
    for (int s = 0; s < rows->n_sockets && capture->socket >= 0; s++) {
        double mean[3];
        const bool here =
            any || rows->sockets[s].placement == rows->sockets[capture->socket].placement;
        if (!here || !mukca_socket_mean(mean, &capture->geometry, rows, s, without)) continue;
        double d = mukca_distance3(x, mean);
        if (d < *how_far) {
            *how_far = d;
            nearest = s;
        }
    }
    return nearest;
}

/* Label of a socket of the current placement without samples; NULL: none. */
static const char *empty_label(const mukca_capture *capture)
{
    const mukca_dataset *rows = &capture->rows;
    for (int l = 0; l < capture->settings.n_labels; l++) {
        bool used = false;
        for (int s = 0; s < rows->n_sockets; s++)
            used =
                used || (rows->sockets[s].placement == rows->sockets[capture->socket].placement &&
                         strcmp(rows->sockets[s].label, capture->settings.labels[l]) == 0 &&
                         mukca_capture_count(capture, s));
        if (!used) return capture->settings.labels[l];
    }
    return NULL;
}

bool mukca_capture_due(int *socket, char text[MUKCA_CAPTURE_TEXT], mukca_capture *capture)
{
    const mukca_capture_settings *s = &capture->settings;
    mukca_capture_sample sample;
    mukca_error unsaid;
    text[0] = '\0';
    if (capture->last.time - capture->checked < 0.02 || capture->socket < 0) return false;
    capture->checked = capture->last.time;
    if (mukca_capture_take(&sample, capture, MUKCA_CAPTURE_IN_ORDER, &unsaid)) {
        capture->standing = false;
        return false;
    }
    if (!capture->standing ||
        mukca_largest_difference(sample.q, capture->anchor, capture->chain->n_joints) > s->range) {
        capture->taken = false;
        capture->standing = true;
        capture->still_since = sample.time - s->window;
        memcpy(capture->anchor, sample.q, sizeof capture->anchor);
    }
    if (capture->taken || sample.time - capture->still_since < s->dwell) return false;
    capture->taken = true;
    double x[3], how_far;
    if (find_posture(capture, sample.q, least_difference) >= 0) return false;
    mukca_fk_position(x, &capture->geometry, sample.q, NULL);
    int nearest = nearest_socket(&how_far, capture, x, -1, false);
    *socket = nearest < 0 ? capture->socket : nearest;
    if (nearest < 0 || how_far < 0.4 * s->distance) return true;
    const bool apart = how_far >= 0.5 * s->distance && how_far < 1.5 * s->distance;
    const char *label = apart ? empty_label(capture) : NULL;
    if (label && !mukca_capture_select(capture, mukca_capture_placement(capture), label, &unsaid)) {
        *socket = capture->socket;
        return true;
    }
    snprintf(text, MUKCA_CAPTURE_TEXT,
             "stands still, but %.0f mm from socket %s: not recorded (n begins another placement)",
             1e3 * how_far, capture->rows.sockets[nearest].label);
    nearest = nearest_socket(&how_far, capture, x, -1, true);
    *socket = how_far < 0.4 * s->distance ? nearest : -1;
    return false;
}

/* ---- samples ---- */

mukca_status mukca_capture_select(mukca_capture *capture, const char *placement, const char *socket,
                                  mukca_error *error)
{
    mukca_dataset *rows = &capture->rows;
    int p = 0, s = mukca_dataset_find_socket(rows, placement, socket);
    while (p < rows->n_placements && strcmp(rows->placements[p].name, placement) != 0) p++;
    if (s < 0) s = rows->n_sockets;
    if (p == MUKCA_CAPTURE_MAX_PLACEMENTS || s == MUKCA_CAPTURE_MAX_SOCKETS)
        return mukca_fail(error, MUKCA_INPUT, "too many placements: begin another session");
    if (p == rows->n_placements) {
        rows->n_placements++;
        snprintf(rows->placements[p].name, sizeof rows->placements[p].name, "%s", placement);
    }
    if (s == rows->n_sockets) {
        rows->n_sockets++;
        rows->sockets[s].placement = p;
        snprintf(rows->sockets[s].label, sizeof rows->sockets[s].label, "%s", socket);
    }
    capture->socket = s;
    return MUKCA_OK;
}

const char *mukca_capture_placement(const mukca_capture *capture)
{
    const mukca_dataset *rows = &capture->rows;
    return capture->socket < 0 ? ""
                               : rows->placements[rows->sockets[capture->socket].placement].name;
}

const char *mukca_capture_socket(const mukca_capture *capture)
{
    return capture->socket < 0 ? "" : capture->rows.sockets[capture->socket].label;
}

const char *mukca_capture_next_label(const mukca_capture *capture)
{
    const mukca_capture_settings *s = &capture->settings;
    for (int i = 0; i < s->n_labels; i++)
        if (strcmp(s->labels[i], mukca_capture_socket(capture)) == 0)
            return s->labels[(i + 1) % s->n_labels];
    return s->labels[0];
}

void mukca_capture_spread(double *rms, double *last, const mukca_capture *capture, int socket)
{
    const mukca_dataset *rows = &capture->rows;
    double mean[3], x[3], apart = 0, squares = 0;
    const int n = mukca_socket_mean(mean, &capture->geometry, rows, socket, -1);
    for (int i = 0; i < rows->n_rows; i++) {
        if (rows->socket[i] != socket) continue;
        mukca_fk_position(x, &capture->geometry, rows->q + i * rows->n_joints, NULL);
        apart = mukca_distance3(x, mean);
        squares += apart * apart;
    }
    if (rms) *rms = n < 3 ? (double)NAN : sqrt(squares / n);
    if (last) *last = n < 2 ? (double)NAN : apart * n / (n - 1); /* the mean contains it */
}

/* Expected rms distance of the prediction at q from the mean of a socket's samples (except
 * `without`, -1: none), m, due to noise and to the posterior uncertainty of the model. */
static double expected_offset(const mukca_capture *capture, int socket, const double *q,
                              int without)
{
    const mukca_dataset *rows = &capture->rows;
    mukca_arm_posterior *p = capture->posterior;
    const int n = rows->n_joints, w = p ? MUKCA_RIGID + p->m.linear.n_columns + 1 : 0;
    mukca_pool pool = {0};
    double *all = MUKCA_TAKE(&pool, double, n *(rows->n_rows + 1)),
           *X = MUKCA_TAKE(&pool, double, 3 * w * (rows->n_rows + 1));
    int count = 0;
    for (int i = 0; i < rows->n_rows && p && !pool.failed; i++)
        if (rows->socket[i] == socket && i != without)
            memcpy(all + n * count++, rows->q + i * n, (size_t)n * sizeof *q);
    double sum = 3 * capture->noise * capture->noise * (1 + 1. / count);
    if (count) memcpy(all + n * count, q, (size_t)n * sizeof *q);
    const bool known = count && mukca_arm_posterior_probe(X, w, p, all, count + 1);
    double *x = X + 3 * w * count; /* of q, without the mean of the others */
    for (int k = 0; known && k < 3 * w; k++)
        for (int i = 0; i < count; i++) x[k] -= X[3 * w * i + k] / count;
    for (int k = 0; known && k < 3; k++)
        sum += mukca_posterior_variance(x + k * w + MUKCA_RIGID, &p->m.evidence.posterior);
    mukca_pool_free(&pool);
    return known ? sqrt(sum) : HUGE_VAL;
}

/* The socket in which a ball seems to be that is `off` from the current one: the nearest with
 * samples, or one without if the distance fits; NULL: none. */
static const char *other_socket(const mukca_capture *capture, double off, int nearest,
                                double how_far)
{
    const double d = capture->settings.distance;
    if (off > 0.4 * d && nearest != capture->socket && how_far < 0.4 * off)
        return capture->rows.sockets[nearest].label;
    return fabs(off - d) < 0.3 * d ? empty_label(capture) : NULL;
}

static void remark(char text[MUKCA_CAPTURE_TEXT], mukca_capture *capture, int twin)
{
    const mukca_dataset *rows = &capture->rows;
    int latest = rows->n_rows - 1;
    const double *q = rows->q + latest * rows->n_joints;
    double x[3], mean[3], how_far;
    mukca_fk_position(x, &capture->geometry, q, NULL);
    int nearest = nearest_socket(&how_far, capture, x, latest, false);
    int n = mukca_socket_mean(mean, &capture->geometry, rows, capture->socket, latest);
    double off = n ? mukca_distance3(x, mean) : 0;
    double usual = n ? expected_offset(capture, capture->socket, q, latest) : 0;
    const mukca_socket *sockets = rows->sockets;
    const char *other = n ? other_socket(capture, off, nearest, how_far) : NULL;
    if (!n && nearest >= 0 && how_far < 0.4 * capture->settings.distance)
        snprintf(text, MUKCA_CAPTURE_TEXT,
                 "only %.1f mm from socket %.40s: is the ball really in socket %.40s?",
                 1e3 * how_far, sockets[nearest].label, sockets[capture->socket].label);
    else if (other)
        snprintf(
            text, MUKCA_CAPTURE_TEXT,
            "%.0f mm from this socket's other samples: this looks like socket %.63s; d deletes "
            "the sample",
            1e3 * off, other);
    else if (off > 3 * usual)
        snprintf(
            text, MUKCA_CAPTURE_TEXT,
            "%.2f mm from this socket's other samples, where %.2f mm would be usual: is the ball "
            "seated?",
            1e3 * off, 1e3 * usual);
    else if (twin >= 0)
        snprintf(
            text, MUKCA_CAPTURE_TEXT,
            "nearly the posture of sample %d: move the elbow further for a sample that adds more",
            twin + 1);
}

mukca_status mukca_capture_keep(char text[MUKCA_CAPTURE_TEXT], mukca_capture *capture,
                                const double *q, mukca_error *error)
{
    mukca_dataset *rows = &capture->rows;
    text[0] = '\0';
    if (capture->socket < 0)
        return mukca_fail(error, MUKCA_INPUT, "no placement and socket has been chosen");
    if (rows->n_rows == MUKCA_CAPTURE_MAX_ROWS)
        return mukca_fail(error, MUKCA_INPUT, "the session is full: begin another one");
    const int twin = find_posture(capture, q, 0.25 * least_difference);
    memcpy(rows->q + rows->n_rows * rows->n_joints, q, (size_t)rows->n_joints * sizeof *q);
    rows->socket[rows->n_rows++] = capture->socket;
    capture->taken = true;
    remark(text, capture, twin);
    return MUKCA_OK;
}

void mukca_capture_drop(mukca_capture *capture)
{
    if (capture->rows.n_rows > 0) capture->rows.n_rows--;
}

void mukca_capture_coverage(double *coverage, const mukca_capture *capture)
{
    const mukca_dataset *rows = &capture->rows;
    for (int j = 0; j < rows->n_joints; j++) {
        const mukca_element *e = &capture->chain->element[capture->chain->joint_element[j]];
        double low = HUGE_VAL, high = -HUGE_VAL, range = e->upper - e->lower;
        for (int i = 0; i < rows->n_rows; i++) {
            low = fmin(low, rows->q[i * rows->n_joints + j]);
            high = fmax(high, rows->q[i * rows->n_joints + j]);
        }
        if (e->type != MUKCA_PRISMATIC) range = fmin(range, 6.283185307179586);
        coverage[j] = rows->n_rows && range > 0 ? fmin((high - low) / range, 1) : 0;
    }
}

/* ---- initialisation and memory ---- */

static double or_default(double value, double otherwise)
{
    return value > 0 ? value : otherwise;
}

mukca_status mukca_capture_init(mukca_capture *capture, const mukca_chain *chain,
                                const double *theta, const mukca_capture_settings *settings,
                                mukca_error *error)
{
    static const char *const two_sockets[] = {"0", "1"};
    memset(capture, 0, sizeof *capture);
    capture->settings = *settings;
    mukca_capture_settings *s = &capture->settings;
    s->window = or_default(s->window, 0.2);
    s->range = or_default(s->range, 1e-3);
    s->dwell = or_default(s->dwell, 1);
    s->distance = or_default(s->distance, MUKCA_DISTANCE);
    if (s->n_labels == 0) {
        s->n_labels = 2;
        s->labels = two_sockets;
    }
    capture->chain = chain;
    capture->start = *chain;
    for (int k = 0; k < chain->n_elements && theta; k++, theta += MUKCA_PARAMETERS) {
        memcpy(capture->start.element[k].xyz, theta, 3 * sizeof *theta);
        memcpy(capture->start.element[k].rpy, theta + 3, 3 * sizeof *theta);
    }
    capture->ring = calloc(MUKCA_CAPTURE_RING, sizeof *capture->ring);
    mukca_status status =
        mukca_dataset_create(&capture->rows, MUKCA_CAPTURE_MAX_ROWS, chain->n_joints,
                             MUKCA_CAPTURE_MAX_SOCKETS, MUKCA_CAPTURE_MAX_PLACEMENTS, error);
    if (status == MUKCA_OK && !capture->ring)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    mukca_capture_clear(capture);
    mukca_capture_advice none;
    if (status == MUKCA_OK) status = mukca_capture_advise(&none, capture, error);
    if (status != MUKCA_OK) mukca_capture_free(capture);
    return status;
}

void mukca_capture_free(mukca_capture *capture)
{
    free(capture->ring);
    mukca_capture_forget(capture);
    mukca_dataset_free(&capture->rows);
    memset(capture, 0, sizeof *capture);
}

void mukca_capture_clear(mukca_capture *capture)
{
    capture->rows.n_rows = capture->rows.n_sockets = capture->rows.n_placements = 0;
    capture->socket = -1;
    capture->count = 0;
    capture->jumps = 0;
    capture->has_last = false;
    capture->standing = capture->taken = false;
    capture->checked = -HUGE_VAL;
}
