/* Live recording, shared by capture and serve: options, standard error. */
#ifndef MUKCA_CLI_LIVE_H
#define MUKCA_CLI_LIVE_H

#include <stdbool.h>
#include <termios.h>

#include "cli/cli.h"
#include "record/server.h"

/* Member `live` of the options of both commands. */
typedef struct {
    mukca_recorder_options recorder;
    cli_list types; /* .lcm files */
} cli_live;

/* Rows of an option table: senders of the `network`, a member of the options struct `type`. */
/* NOLINTBEGIN(bugprone-macro-parentheses): names of members */
#define CLI_NETWORK_OPTIONS(type, network)                                           \
    CLI_OPTION(type, network.interface, "interface", CLI_TEXT, "ADDRESS",            \
               "receive from other machines, too, on the interface of this address " \
               "(default: from this machine only)"),                                 \
        CLI_OPTION(type, network.from, "from", CLI_TEXT, "LIST",                     \
                   "receive from these addresses only, commas between")
/* NOLINTEND(bugprone-macro-parentheses) */

/* Rows of an option table; `type` is the options struct. */
#define CLI_LIVE_OPTIONS(type)                                                                     \
    CLI_OPTION(                                                                                    \
        type, live.recorder.network.url, "lcm-url", CLI_TEXT, "URL",                               \
        "LCM network, or file://LOG to replay a log (default: LCM_DEFAULT_URL, else LCM's own)"),  \
        CLI_NETWORK_OPTIONS(type, live.recorder.network),                                          \
        CLI_OPTION(type, live.recorder.key, "key", CLI_INPUT, "FILE",                              \
                   "accept only triggers and commands signed with the key in this file "           \
                   "(mukca-formats(5))"),                                                          \
        CLI_OPTION(type, live.recorder.channel, "channel", CLI_TEXT, "NAME",                       \
                   "channel of the joint states (default: the one that fits the arm)"),            \
        CLI_OPTION(type, live.types, "type", CLI_TEXTS, "FILE",                                    \
                   "a .lcm description of the joint states, for a type that mukca does not know"), \
        CLI_OPTION(type, live.recorder.types.position, "position", CLI_TEXT, "FIELD",              \
                   "the field of --type that holds the joint positions, as in q or head.q"),       \
        CLI_OPTION(type, live.recorder.types.names, "names", CLI_TEXT, "FIELD",                    \
                   "the field of --type that holds the joint names"),                              \
        CLI_OPTION(type, live.recorder.map, "map", CLI_TEXT, "MAP",                                \
                   "which reading is which joint: name, order, or numbers as in 8-14 or 1,2,4 "    \
                   "(default: by name, else by order once you confirm it)"),                       \
        CLI_OPTION(type, live.recorder.stream, "stream", CLI_CHOICE, "KIND",                       \
                   "raw: readings of the encoders; corrected: the driver has added stored "        \
                   "offsets; recorded in the session (default: raw)",                              \
                   .choices = mukca_recorder_streams),                                             \
        CLI_OPTION(type, live.recorder.still, "still", CLI_FLAG, NULL,                             \
                   "record a sample whenever the arm stands still in a socket in a new posture"),  \
        CLI_OPTION(type, live.recorder.capture.dwell, "dwell", CLI_POSITIVE, "S",                  \
                   "time of standing still for --still, s (default: 1)"),                          \
        CLI_OPTION(type, live.recorder.capture.window, "window", CLI_POSITIVE, "S",                \
                   "a sample is the mean over this time, s (default: 0.2)"),                       \
        CLI_OPTION(type, live.recorder.capture.range, "motion", CLI_POSITIVE, "RAD",               \
                   "largest motion of a joint within the window, rad or m (default: 0.001)"),      \
        CLI_OPTION(                                                                                \
            type, live.recorder.placements, "placement", CLI_TEXT, "LIST",                         \
            "names of the placements in order, commas between (default: placement_1 and so on)"),  \
        CLI_OPTION(type, live.recorder.sockets, "sockets", CLI_TEXT, "LIST",                       \
                   "labels of the sockets, commas between (default: 0,1)"),                        \
        CLI_OPTION(type, live.recorder.prefix, "prefix", CLI_TEXT, "NAME",                         \
                   "prefix of mukca's own channels, as in NAME_TRIGGER (default: MUKCA)")

/* The words of the command line, up to NULL, that specify arm and tool: another command needs them
 * to read the session. */
void cli_live_arguments(const char *words[MUKCA_SERVER_ARGUMENTS], const cli_call *call);

/* Copy common options that the recorder needs. */
static inline void cli_live_complete(cli_live *live, const cli_common *common)
{
    live->recorder.types.file = live->types.items;
    live->recorder.types.n = live->types.n;
    live->recorder.capture.distance = common->distance;
    live->recorder.capture.distance_sigma = common->distance_sd;
}

/* ---- standard error of a live recording (live.c): a stopped terminal (Ctrl-S) or a slow reader
 * does not stop the recording ---- */

typedef struct {
    int file; /* standard error opened anew, without blocking; 0: standard error itself */
    char waiting[1 << 16];
    size_t used; /* bytes of it */
    long lost;   /* texts that did not fit */
} cli_relay;

void cli_relay_open(cli_relay *relay);
void cli_relay_close(cli_relay *relay);

/* Write a text, or keep it until it is taken; if it does not fit, the next one begins with the
 * number of texts lost. */
void cli_relay_write(cli_relay *relay, const char *text);

/* Whether all texts have been taken. */
bool cli_relay_idle(cli_relay *relay);

/* ---- the terminal of capture: keys, lines, a view redrawn in place (capture_view.c) ---- */

/* Zeroed: terminal unchanged. */
typedef struct {
    cli_relay relay;
    struct termios saved;
    int terminal;
    bool raw;                 /* unbuffered keys, without echo */
    int drawn;                /* lines of the view on the screen */
    int rows, refused, bells; /* samples and refusals at the last step; strokes to come */
    double rang;              /* s */
} cli_capture_view;

#define CLI_CAPTURE_KEYS \
    "a add, d delete the last sample, s other socket, n next placement, q finish, ? these keys"

/* Set the terminal `terminal` (descriptor) to single keys, and restore it. */
void cli_capture_enter(cli_capture_view *view, int terminal);
void cli_capture_leave(cli_capture_view *view);

/* Obey a key; true: finish. */
bool cli_capture_press(mukca_recorder *r, char key);

/* Ring the bell, once for a sample and twice for a refusal since the last call; `now` in s.  Both
 * hands of the operator are on the arm. */
void cli_capture_ring(cli_capture_view *view, const mukca_recorder *r, double now);

/* Draw the view, unless the terminal is behind; and print a line above it. */
void cli_capture_draw(cli_capture_view *view, const mukca_recorder *r);
void cli_capture_print(cli_capture_view *view, const char *line);

#endif
