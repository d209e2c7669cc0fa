/* Options of live recording, shared by capture and serve. */
#ifndef MUKCA_CLI_LIVE_H
#define MUKCA_CLI_LIVE_H

#include "cli/cli.h"
#include "record/recorder.h"

/* A member `live` of the options of both commands. */
typedef struct {
    mukca_recorder_options recorder;
    cli_list types; /* .lcm files */
} cli_live;

/* Rows of an option table; `type` is the options struct. */
#define CLI_LIVE_OPTION(type, name, kind, argument, member, choices, help)  \
    {                                                                       \
        name, 0, kind, argument, help, choices, offsetof(type, live.member) \
    }
#define CLI_LIVE_OPTIONS(type)                                                                     \
    CLI_LIVE_OPTION(                                                                               \
        type, "lcm-url", CLI_TEXT, "URL", recorder.lcm_url, NULL,                                  \
        "LCM network, or file://LOG to replay a log (default: LCM_DEFAULT_URL, else LCM's own)"),  \
        CLI_LIVE_OPTION(type, "channel", CLI_TEXT, "NAME", recorder.channel, NULL,                 \
                        "channel of the joint states (default: the one that fits the arm)"),       \
        CLI_LIVE_OPTION(                                                                           \
            type, "type", CLI_TEXTS, "FILE", types, NULL,                                          \
            "a .lcm description of the joint states, for a type that mukca does not know"),        \
        CLI_LIVE_OPTION(type, "position", CLI_TEXT, "FIELD", recorder.position, NULL,              \
                        "the field of --type that holds the joint positions, as in q or head.q"),  \
        CLI_LIVE_OPTION(type, "names", CLI_TEXT, "FIELD", recorder.names, NULL,                    \
                        "the field of --type that holds the joint names"),                         \
        CLI_LIVE_OPTION(type, "map", CLI_TEXT, "MAP", recorder.map, NULL,                          \
                        "which reading is which joint: name, order, or numbers as in 8-14 or "     \
                        "1,2,4 (default: by name, else by order once you confirm it)"),            \
        CLI_LIVE_OPTION(type, "stream", CLI_CHOICE, "KIND", recorder.stream,                       \
                        mukca_recorder_streams,                                                    \
                        "raw: readings of the encoders; corrected: the driver has added stored "   \
                        "offsets; recorded in the session (default: raw)"),                        \
        CLI_LIVE_OPTION(                                                                           \
            type, "still", CLI_FLAG, NULL, recorder.still, NULL,                                   \
            "record a sample whenever the arm stands still in a socket in a new posture"),         \
        CLI_LIVE_OPTION(type, "dwell", CLI_POSITIVE, "S", recorder.dwell, NULL,                    \
                        "time of standing still for --still, s (default: 1)"),                     \
        CLI_LIVE_OPTION(type, "window", CLI_POSITIVE, "S", recorder.window, NULL,                  \
                        "a sample is the mean over this time, s (default: 0.2)"),                  \
        CLI_LIVE_OPTION(type, "motion", CLI_POSITIVE, "RAD", recorder.motion, NULL,                \
                        "largest motion of a joint within the window, rad or m (default: 0.001)"), \
        CLI_LIVE_OPTION(                                                                           \
            type, "placement", CLI_TEXT, "LIST", recorder.placements, NULL,                        \
            "names of the placements in order, commas between (default: placement_1 and so on)"),  \
        CLI_LIVE_OPTION(type, "sockets", CLI_TEXT, "LIST", recorder.sockets, NULL,                 \
                        "labels of the sockets, commas between (default: 0,1)"),                   \
        CLI_LIVE_OPTION(type, "record", CLI_TEXT, "LOG", recorder.log, NULL,                       \
                        "also write the raw LCM stream to this log"),                              \
        CLI_LIVE_OPTION(type, "prefix", CLI_TEXT, "NAME", recorder.prefix, NULL,                   \
                        "prefix of mukca's own channels, as in NAME_TRIGGER (default: MUKCA)")

/* What the recorder needs from the other options. */
static inline void cli_live_complete(cli_live *live, const cli_common *common)
{
    live->recorder.types = live->types.items;
    live->recorder.n_types = live->types.n;
    live->recorder.distance = common->distance;
    live->recorder.force = common->force;
}

#endif
