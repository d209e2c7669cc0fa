/* Rows of option tables, which drive parsing, help, man page and completion; the common options. */
#ifndef MUKCA_CLI_OPTIONS_H
#define MUKCA_CLI_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>

/* Texts given in order; items point into argv. */
typedef struct {
    const char **items;
    int n;
} cli_list;

/* Type of the member at `offset`, and its valid text. */
typedef enum {
    CLI_FLAG,     /* bool; no argument */
    CLI_TEXT,     /* const char *; the last one given wins */
    CLI_INPUT,    /* const char *; a file that is read */
    CLI_OUTPUT,   /* const char *; a file that is written; checked before the command runs */
    CLI_NUMBER,   /* double; finite */
    CLI_INTEGER,  /* int */
    CLI_CHOICE,   /* int; index into `choices` */
    CLI_POSITIVE, /* double; finite, above 0 (0: not given) */
    CLI_VECTOR,   /* double[3]; X,Y,Z, finite, not all 0 (all 0: not given) */
    CLI_TEXTS,    /* cli_list; one text each time, repeatable */
    CLI_REST      /* cli_list; all arguments that follow, up to the next option or `--` */
} cli_kind;

enum { CLI_MOST_OPTIONS = 64 }; /* of a command */

typedef struct {
    const char *name; /* without `--`; NULL ends a table */
    char letter;      /* 0: none */
    cli_kind kind;
    const char *argument;       /* its name in help, NULL for a flag */
    const char *help;           /* one sentence without a full stop, with the default */
    const char *const *choices; /* CLI_CHOICE: names, terminated by NULL */
    double least, most;         /* range of a number; both 0: any */
    const char *needs;          /* "poses or --at": one of them must be given, too */
    const char *excludes;       /* "poses at": none of them may be given */
    size_t offset;              /* of the member in the command's options */
    unsigned set;               /* of a common option: CLI_WITH_...; 0: the command's own */
} cli_option;

/* An option as it was given, the last time. */
typedef struct {
    const cli_option *option;
    char *const *words; /* [n_words] of the command line: its name and its value */
    int n_words;
} cli_given;

/* A row of an option table; `member` of the struct `type` gets the value.  After the help text may
 * stand further members of cli_option. */
#define CLI_OPTION(type, member, option, value, metavar, ...)     \
    {                                                             \
        .name = (option), .kind = (value), .argument = (metavar), \
        .offset = offsetof(type, member), .help = __VA_ARGS__     \
    }
/* -o, whose meaning differs by command; `what`: help text. */
#define CLI_OUTPUT_OPTION(what) \
    CLI_OPTION(cli_common, output, "output", CLI_OUTPUT, "FILE", what, .letter = 'o')

/* The options that specify an arm. */
typedef struct {
    const char *urdf, *base, *tip, *inertials, *kinematics, *offsets;
    double gravity[3]; /* m/s^2; all 0: upright base */
} cli_arm;

/* Options common to all commands: the first member of every command's options struct. */
typedef struct {
    cli_arm arm;
    const char *distances, *json, *output, *payload, *units, *columns, *rotation, *traits;
    cli_list test;
    int angles, map;              /* choices, see below */
    int threads;                  /* as of mukca_workers_start */
    double distance, distance_sd; /* m */
    bool free_base, free_tool, inverse_poses, accept_other_arm, accept_failed, accept_edited, force,
        quiet, verbose;
} cli_common;

/* Choices of --angles and --map, in the order of their names in the table. */
enum { CLI_ANGLES_READ, CLI_ANGLES_COMMANDED };
enum { CLI_BY_NAME, CLI_BY_ORDER, CLI_BY_ORDER_W_LAST };

/* Sets of common options that a command can take.  --force, -q and -v are common to all. */
enum {
    CLI_WITH_MODEL = 1 << 0,   /* --urdf to --gravity */
    CLI_WITH_OFFSETS = 1 << 1, /* --offsets, --accept-other-arm */
    CLI_WITH_ACCEPT = 1 << 2,  /* --accept-failed, --accept-edited */
    CLI_WITH_TEST = 1 << 3,
    CLI_WITH_DISTANCE = 1 << 4,
    CLI_WITH_DISTANCES = 1 << 5,
    CLI_WITH_JSON = 1 << 6,
    CLI_WITH_PAYLOAD = 1 << 7,
    CLI_WITH_ANGLES = 1 << 8,
    CLI_WITH_FRAMES = 1 << 9, /* --free-base, --free-tool */
    CLI_WITH_TRAITS = 1 << 10,
    CLI_WITH_COLUMNS = 1 << 11, /* --units, --columns */
    CLI_WITH_MAP = 1 << 12,     /* --map, --rotation, --inverse-poses */
    CLI_WITH_TABLES = CLI_WITH_COLUMNS | CLI_WITH_MAP,
    CLI_WITH_DATA = CLI_WITH_MODEL | CLI_WITH_DISTANCE | CLI_WITH_DISTANCES | CLI_WITH_PAYLOAD |
                    CLI_WITH_ANGLES | CLI_WITH_TABLES,
    CLI_WITH_SD = 1 << 13, /* --distance-sd */
    CLI_WITH_THREADS = 1 << 14,
    CLI_WITH_ALL = 1 << 15
};

/* The common options (options.c); the row that ends them has all sets. */
extern const cli_option cli_common_options[];

#endif
