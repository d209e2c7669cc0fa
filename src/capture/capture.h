/* Recording rows from a stream of joint states: when the arm stands still, what a sample is, what
 * is remarkable about it.  A state machine without input or output: times are handed in. */
#ifndef MUKCA_CAPTURE_CAPTURE_H
#define MUKCA_CAPTURE_CAPTURE_H

#include <stdbool.h>

#include "fit/posterior.h"
#include "mukca/chain.h"
#include "mukca/dataset.h"
#include "mukca/status.h"

enum {
    MUKCA_CAPTURE_RING = 4096, /* readings of a window */
    MUKCA_CAPTURE_MAX_ROWS = 8192,
    MUKCA_CAPTURE_MAX_SOCKETS = 512,
    MUKCA_CAPTURE_MAX_PLACEMENTS = 256,
    MUKCA_CAPTURE_TEXT = 200
};

/* Zeroed means the defaults. */
typedef struct {
    double window;     /* s of standing still that make a sample; 0: 0.2 */
    double range;      /* rad or m that a joint may move in it; 0: 0.001 */
    double dwell;      /* s of standing still after which a sample is due by itself; 0: 1 */
    double difference; /* rad or m by which such a sample differs from every row; 0: 0.02 */
    double distance;   /* m between the sockets; 0: 0.05 */
    int n_labels;      /* sockets of a placement; 0: "0" and "1" */
    const char *const *labels;
    /* change q[n_joints] from readings to angles of a rigid arm, by this share of the elasticity
     * that is expected, for all that is found about a sample (NULL: the readings are used) */
    void (*correct)(void *context, double share, double *q);
    void *context;
} mukca_capture_settings;

/* One message. */
typedef struct {
    double time;                        /* s, the sender's clock */
    const double *q, *effort, *command; /* [n_joints]; the last two may be NULL */
    bool guided;                        /* somebody moves the arm by hand now */
} mukca_capture_reading;

/* What mukca_capture_feed found, as bits. */
enum {
    MUKCA_CAPTURE_BACKWARDS = 1,  /* the sender's clock went back */
    MUKCA_CAPTURE_PAUSE = 2,      /* nothing came for `pause` seconds */
    MUKCA_CAPTURE_TWO_SENDERS = 4 /* readings jump to and fro as no arm can */
};

/* Mean over a still window. */
typedef struct {
    double time;                                          /* s, of its last reading */
    int n;                                                /* readings */
    double q[MUKCA_MAX_JOINTS], spread[MUKCA_MAX_JOINTS]; /* rad or m */
    double effort[MUKCA_MAX_JOINTS], command[MUKCA_MAX_JOINTS];
} mukca_capture_sample;

typedef struct {
    mukca_capture_settings settings;
    const mukca_chain *chain;
    /* the model so far (advice.c): that of the start until there are rows */
    mukca_linearisation model;
    double start[MUKCA_MAX_FREE]; /* [6 * n_elements] */
    double sigma[MUKCA_MAX_FREE]; /* [n] of the prior, n = model.parameters.n */
    double noise;                 /* of one coordinate, m */
    double *factor;               /* [n][n] as mukca_posterior_factor gives it */
    double share;                 /* of the expected elasticity that the rows support: 1, 0.5, 0 */
    /* the stream */
    int head, count; /* of the ring: next to be written, filled */
    double *time;    /* [RING] */
    double *values;  /* [RING][3][n_joints] q, effort, command */
    double last_time, pause;
    double last_q[MUKCA_MAX_JOINTS], before_q[MUKCA_MAX_JOINTS]; /* and the one before it */
    bool has_last, guided, was_guided;
    double jumps; /* decaying count of impossible moves */
    /* standing still */
    bool standing, taken;
    double still_since, checked;
    double anchor[MUKCA_MAX_JOINTS];
    /* the rows */
    mukca_dataset
        rows; /* as corrected; n_rows, n_sockets, n_placements in use; room for the maxima */
    double *readings; /* [MAX_ROWS][n_joints] of the rows */
    int socket;       /* current, index into rows.sockets; -1: none */
} mukca_capture;

/* `chain`, and settings->labels, must outlive the capture; theta[6 * n_elements] (NULL: nominal)
 * is the model to begin with.  Free with mukca_capture_free.  Errors: MUKCA_MEMORY, MUKCA_USAGE (no
 * joint). */
mukca_status mukca_capture_init(mukca_capture *capture, const mukca_chain *chain,
                                const double *theta, const mukca_capture_settings *settings,
                                mukca_error *error);
void mukca_capture_free(mukca_capture *capture);

/* angles[n_joints] of a rigid arm, from readings q[n_joints]. */
void mukca_capture_correct(double *angles, const mukca_capture *capture, const double *q);

/* Forget all rows, placements and readings. */
void mukca_capture_clear(mukca_capture *capture);

/* Take in one reading; allocates nothing.  Returns MUKCA_CAPTURE_* bits, each when it begins. */
unsigned mukca_capture_feed(mukca_capture *capture, const mukca_capture_reading *reading);

/* Whether the arm stands still now: the sample of the last window.  `age` is the time in s since
 * the last reading arrived.  Errors: MUKCA_NEGATIVE with the reason (moving, stale, too few
 * readings, two senders, the very numbers of the row before). */
mukca_status mukca_capture_take(mukca_capture_sample *sample, const mukca_capture *capture,
                                double age, mukca_error *error);

/* After a feed: true once each time that the arm has stood still long enough, differs from all rows
 * of this placement, and its ball is where a socket can be; *socket is then its index (an index
 * as below).  `text` gets a line where it stands still elsewhere; else it is empty. */
bool mukca_capture_due(int *socket, char text[MUKCA_CAPTURE_TEXT], mukca_capture *capture);

/* Make a socket of a placement the current one, new ones included.  Errors: MUKCA_INPUT (too many).
 */
mukca_status mukca_capture_select(mukca_capture *capture, const char *placement, const char *socket,
                                  mukca_error *error);

/* Labels of the current placement and socket; "" before the first selection. */
const char *mukca_capture_placement(const mukca_capture *capture);
const char *mukca_capture_socket(const mukca_capture *capture);

/* The label that follows the current socket's in the settings. */
const char *mukca_capture_next_label(const mukca_capture *capture);

/* Whether the readings q[n_joints] hold the very numbers of the last row: a driver that updates no
 * more. */
bool mukca_capture_repeats(const mukca_capture *capture, const double *q);

/* Add a row of readings q[n_joints] to the current socket, or take the last one back.  `text` gets
 * what is remarkable about the row (a posture seen before, a ball that is not seated, the wrong
 * socket), or is empty.  Errors: MUKCA_INPUT (full; no row). */
mukca_status mukca_capture_keep(char text[MUKCA_CAPTURE_TEXT], mukca_capture *capture,
                                const double *q, mukca_error *error);
mukca_status mukca_capture_drop(mukca_capture *capture, mukca_error *error);

/* Rows at a socket. */
static inline int mukca_capture_count(const mukca_capture *capture, int socket)
{
    int n = 0;
    for (int i = 0; i < capture->rows.n_rows; i++) n += capture->rows.socket[i] == socket;
    return n;
}

/* Spread of the model's predictions at a socket (root mean square distance from their mean, m), and
 * the distance of the last row from the mean of the others.  NaN where there are too few rows.
 * Either may be NULL. */
void mukca_capture_spread(double *rms, double *last, const mukca_capture *capture, int socket);

/* Share of each joint's range (its limits, at most a turn) between the smallest and the largest
 * reading of all rows, coverage[n_joints]. */
void mukca_capture_coverage(double *coverage, const mukca_capture *capture);

/* ---- the model so far (advice.c) ---- */

typedef struct {
    double expected;      /* m: rms error of the calibrated tip over the joints' ranges, its base
                             placed best; NaN without rows */
    double expected_more; /* m: the same with ten more rows like those at this socket */
    bool more_rows_help;  /* those ten would take more than 3 % off */
    int twin;             /* socket that the current one seems to be; -1: none */
    double apart;         /* m, distance of their centres */
    double evidence;      /* log Bayes factor of capture->share against all of the elasticity */
} mukca_capture_advice;

/* Fit the model to the rows: Gaussian prior about the start, noise from the residuals, and the
 * share of the expected elasticity that the rows support.  Without rows back to the start. Errors:
 * MUKCA_MEMORY. */
mukca_status mukca_capture_advise(mukca_capture_advice *advice, mukca_capture *capture,
                                  mukca_error *error);

/* How far from the mean of a socket's rows (except `without`, -1: none) a row at q can be expected
 * to be predicted: root mean square, m, by the noise and what is not known yet. */
double mukca_capture_expected_offset(const mukca_capture *capture, int socket, const double *q,
                                     int without);

#endif
