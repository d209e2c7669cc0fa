/* Samples from a stream of joint states: detection of standstill, averaging, triggers, plausibility
 * checks.  A state machine without input or output: times are arguments. */
#ifndef MUKCA_CAPTURE_CAPTURE_H
#define MUKCA_CAPTURE_CAPTURE_H

#include <stdbool.h>

#include "accept/posterior.h"
#include "model/dataset.h"
#include "mukca/chain.h"
#include "mukca/status.h"

enum {
    MUKCA_CAPTURE_RING = 4096, /* readings in the ring buffer */
    MUKCA_CAPTURE_MAX_ROWS = 8192,
    MUKCA_CAPTURE_MAX_SOCKETS = 512,
    MUKCA_CAPTURE_MAX_PLACEMENTS = 256,
    MUKCA_CAPTURE_TEXT = 200
};

/* Zeroed means the defaults. */
typedef struct {
    double window;         /* s, standstill averaged to a sample; 0: 0.2 */
    double range;          /* rad or m, motion of a joint allowed in it; 0: 0.001 */
    double dwell;          /* s, standstill that triggers a sample; 0: 1 */
    double distance;       /* m, between the sockets; 0: MUKCA_DISTANCE */
    double distance_sigma; /* its standard deviation, m; 0: MUKCA_DISTANCE_SIGMA */
    int n_labels;          /* sockets of a placement; 0: "0" and "1" */
    const char *const *labels;
} mukca_capture_settings;

/* One joint state. */
typedef struct {
    double time;    /* s, the sender's clock */
    double arrival; /* s, this machine's clock */
    double q[MUKCA_MAX_JOINTS], effort[MUKCA_MAX_JOINTS], command[MUKCA_MAX_JOINTS]; /* NaN: none */
} mukca_capture_reading;

/* Events reported by mukca_capture_feed (bits). */
enum {
    MUKCA_CAPTURE_BACKWARDS = 1,  /* the sender's clock was set back */
    MUKCA_CAPTURE_TWO_SENDERS = 2 /* readings alternate faster than an arm can move */
};

#define MUKCA_CAPTURE_IN_ORDER (-1.)

/* Sample: mean over a window of standstill. */
typedef struct {
    double time;                                          /* s, of its last reading */
    int n;                                                /* number of readings */
    double q[MUKCA_MAX_JOINTS], spread[MUKCA_MAX_JOINTS]; /* rad or m */
    double effort[MUKCA_MAX_JOINTS], command[MUKCA_MAX_JOINTS];
} mukca_capture_sample;

typedef struct {
    mukca_capture_settings settings;
    const mukca_chain *chain;
    /* Present model (advice.c): the initial one without samples. */
    mukca_geometry geometry;
    mukca_chain start;              /* the initial one as nominal */
    double noise;                   /* measurement noise of one coordinate, m */
    mukca_arm_posterior *posterior; /* NULL: without samples */
    /* Stream. */
    int head, count;                    /* ring buffer: next index to write, number stored */
    mukca_capture_reading *ring;        /* [RING] */
    mukca_capture_reading last, before; /* last reading, the one before */
    bool has_last;
    double jumps; /* decaying count of impossible motions */
    /* Standstill. */
    bool standing, taken;
    double still_since, checked;
    double anchor[MUKCA_MAX_JOINTS];
    /* Samples. */
    mukca_dataset rows; /* n_rows, n_sockets, n_placements in use; memory for maxima */
    int socket;         /* current, index into rows.sockets; -1: none */
} mukca_capture;

/* `chain`, and settings->labels, must outlive the capture; theta[6 * n_elements] (NULL: nominal) is
 * the initial model.  Free with mukca_capture_free.  Errors: MUKCA_MEMORY. */
mukca_status mukca_capture_init(mukca_capture *capture, const mukca_chain *chain,
                                const double *theta, const mukca_capture_settings *settings,
                                mukca_error *error);
void mukca_capture_free(mukca_capture *capture);

/* Clear all samples, placements and readings. */
void mukca_capture_clear(mukca_capture *capture);

/* Process one reading; allocates nothing.  Returns MUKCA_CAPTURE_* bits, each at the start of the
 * event. */
unsigned mukca_capture_feed(mukca_capture *capture, const mukca_capture_reading *reading);

/* Sample of the last window if the arm is at standstill.  `age`: time from the arrival of the last
 * reading to the request, s; a window ago at most, and the readings must have arrived over a
 * window, not at once after a pause.  MUKCA_CAPTURE_IN_ORDER: the request came in order with the
 * readings. Errors: MUKCA_NEGATIVE with the reason (motion, stale, too few readings, two senders).
 */
mukca_status mukca_capture_take(mukca_capture_sample *sample, const mukca_capture *capture,
                                double age, mukca_error *error);

/* After a feed: true once per standstill if this is long enough, the posture differs from all
 * samples of the placement, and the ball is where a socket can be; *socket is then the index of
 * that socket.  If the ball is elsewhere, `text` gets a line and *socket is that of another
 * placement, or -1; else "". */
bool mukca_capture_due(int *socket, char text[MUKCA_CAPTURE_TEXT], mukca_capture *capture);

/* Select the current socket, creating placement and socket if needed.  Errors: MUKCA_INPUT (too
 * many). */
mukca_status mukca_capture_select(mukca_capture *capture, const char *placement, const char *socket,
                                  mukca_error *error);

/* Labels of the current placement and socket; "" before the first selection. */
const char *mukca_capture_placement(const mukca_capture *capture);
const char *mukca_capture_socket(const mukca_capture *capture);

/* The label after that of the current socket in the settings. */
const char *mukca_capture_next_label(const mukca_capture *capture);

/* True if readings q[n_joints] are identical to those of the last sample: the driver has stopped
 * updating. */
bool mukca_capture_repeats(const mukca_capture *capture, const double *q);

/* Add a sample of readings q[n_joints] to the current socket, or remove the last sample.
 * `text` gets a remark on the sample (repeated posture, ball not seated, wrong socket), or "".
 * Errors: MUKCA_INPUT (full). */
mukca_status mukca_capture_keep(char text[MUKCA_CAPTURE_TEXT], mukca_capture *capture,
                                const double *q, mukca_error *error);
void mukca_capture_drop(mukca_capture *capture);

/* Number of samples at a socket. */
static inline int mukca_capture_count(const mukca_capture *capture, int socket)
{
    int n = 0;
    for (int i = 0; i < capture->rows.n_rows; i++) n += capture->rows.socket[i] == socket;
    return n;
}

/* Rms distance of the model's predictions at a socket from their mean, m, and the distance of the
 * last sample from the mean of the others, m.  NaN: too few samples.  Either may be NULL. */
void mukca_capture_spread(double *rms, double *last, const mukca_capture *capture, int socket);

/* Share of each joint's range (its limits, at most a turn) between the smallest and the largest
 * reading of all samples, coverage[n_joints]. */
void mukca_capture_coverage(double *coverage, const mukca_capture *capture);

/* ---- present model (advice.c) ---- */

/* Return to the initial model. */
void mukca_capture_forget(mukca_capture *capture);

typedef struct {
    double expected; /* m: expected rms error of the calibrated tip over the joints' ranges, with
                        the best base pose; NaN: no samples */
    double expected_more; /* m: the same with ten more samples like those at this socket */
    bool more_rows_help;  /* those ten would reduce it by more than 3 % */
} mukca_capture_advice;

/* Fit the model to the samples, with a prior about the initial model (mukca_arm_posterior). Without
 * samples: the initial model.  Errors: MUKCA_MEMORY. */
mukca_status mukca_capture_advise(mukca_capture_advice *advice, mukca_capture *capture,
                                  mukca_error *error);

#endif
