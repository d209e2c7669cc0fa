/* The terminal of `mukca capture`: single keys, lines, and a view that is redrawn in place. */
#ifndef MUKCA_CLI_CAPTURE_VIEW_H
#define MUKCA_CLI_CAPTURE_VIEW_H

#include <termios.h>

#include "cli/live.h"
#include "record/recorder.h"

/* Zeroed: terminal unchanged. */
typedef struct {
    cli_relay relay;
    struct termios saved;
    int terminal;
    bool raw;                 /* unbuffered keys, without echo */
    int drawn;                /* lines of the view on the screen */
    int typed;                /* 1 + the number of a row, while it is typed; 0: none */
    int rows, refused, bells; /* samples and refusals at the last step; strokes to come */
    double rang;              /* s */
} cli_capture_view;

#define CLI_CAPTURE_KEYS                                                                      \
    "a add, d delete the last sample, x delete another (its number, Enter), m move the last " \
    "sample "                                                                                 \
    "to the socket that is offered, s other socket, n next placement, q finish, ? these keys"

/* Set the terminal `terminal` (descriptor) to single keys, and restore it. */
void cli_capture_enter(cli_capture_view *view, int terminal);
void cli_capture_leave(cli_capture_view *view);

/* Obey a key; true: finish. */
bool cli_capture_press(cli_capture_view *view, mukca_recorder *r, char key);

/* Ring the bell, once for a sample and twice for a refusal since the last call; `now` in s.  Both
 * hands of the operator are on the arm. */
void cli_capture_ring(cli_capture_view *view, const mukca_recorder *r, double now);

/* Draw the view, unless the terminal is behind; and print a line above it. */
void cli_capture_draw(cli_capture_view *view, const mukca_recorder *r);
void cli_capture_print(cli_capture_view *view, const char *line);

#endif
