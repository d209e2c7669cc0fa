/* Initialisation and memory of a capture. */
#include "capture/capture.h"

#include <stdlib.h>
#include <string.h>

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
    s->distance = or_default(s->distance, 0.05);
    if (s->n_labels == 0) {
        s->n_labels = 2;
        s->labels = two_sockets;
    }
    capture->chain = chain;
    mukca_linearisation_init(&capture->model, chain, theta);
    memcpy(capture->start, capture->model.theta, sizeof capture->start);
    mukca_posterior_prior(capture->sigma, chain, &capture->model.parameters);
    size_t n_free = (size_t)capture->model.parameters.n;
    capture->factor = calloc(n_free * n_free, sizeof *capture->factor);
    size_t n = (size_t)chain->n_joints;
    capture->time = calloc(2 * MUKCA_CAPTURE_RING, sizeof *capture->time);
    capture->values = calloc(MUKCA_CAPTURE_RING * 3 * n, sizeof *capture->values);
    mukca_status status =
        mukca_dataset_create(&capture->rows, MUKCA_CAPTURE_MAX_ROWS, chain->n_joints,
                             MUKCA_CAPTURE_MAX_SOCKETS, MUKCA_CAPTURE_MAX_PLACEMENTS, error);
    if (status == MUKCA_OK && (!capture->time || !capture->values || !capture->factor))
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    mukca_capture_clear(capture);
    mukca_capture_advice none;
    if (status == MUKCA_OK) status = mukca_capture_advise(&none, capture, error);
    if (status != MUKCA_OK) mukca_capture_free(capture);
    return status;
}

void mukca_capture_free(mukca_capture *capture)
{
    free(capture->time);
    free(capture->values);
    free(capture->factor);
    mukca_dataset_free(&capture->rows);
    memset(capture, 0, sizeof *capture);
}

void mukca_capture_clear(mukca_capture *capture)
{
    capture->rows.n_rows = capture->rows.n_sockets = capture->rows.n_placements = 0;
    capture->socket = -1;
    capture->count = 0;
    capture->jumps = 0;
    capture->has_last = capture->guided = capture->was_guided = false;
    capture->standing = capture->taken = false;
    capture->checked = 0;
}
