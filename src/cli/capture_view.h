/* The terminal of `mukca capture`: single keys, lines, and a view that is redrawn in place. */
#ifndef MUKCA_CLI_CAPTURE_VIEW_H
#define MUKCA_CLI_CAPTURE_VIEW_H

#include <termios.h>

#include "cli/relay.h"
#include "record/recorder.h"

/* Zeroed: terminal unchanged. */
typedef struct {
    cli_relay relay;
    struct termios saved;
    int terminal;
    bool raw;  /* unbuffered keys, without echo */
    int drawn; /* lines of the view on the screen */
} cli_capture_view;

/* Set the terminal `terminal` (descriptor) to single keys, and restore it. */
void cli_capture_enter(cli_capture_view *view, int terminal);
void cli_capture_leave(cli_capture_view *view);

/* Draw the view, unless the terminal is behind; and print a line above it. */
void cli_capture_draw(cli_capture_view *view, const mukca_recorder *r);
void cli_capture_print(cli_capture_view *view, const char *line);

#endif
