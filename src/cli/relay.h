/* Standard error of a live recording: a thread writes it, so that a stopped terminal (Ctrl-S) or a
 * slow reader does not stop the recording. */
#ifndef MUKCA_CLI_RELAY_H
#define MUKCA_CLI_RELAY_H

#include <pthread.h>
#include <stdbool.h>

/* Zeroed: texts are written directly. */
typedef struct {
    int ends[2]; /* pipe to the thread */
    bool running;
    pthread_t thread;
    long lost; /* texts that did not fit the pipe */
} cli_relay;

/* Start the thread; and write what is left, and end it.  Harmless if it does not run. */
void cli_relay_open(cli_relay *relay);
void cli_relay_close(cli_relay *relay);

/* Write a text of at most PIPE_BUF bytes, whole or not at all; the next one then begins with the
 * number of texts lost. */
void cli_relay_write(cli_relay *relay, const char *text);

/* Whether all texts have been taken by the thread. */
bool cli_relay_idle(const cli_relay *relay);

#endif
