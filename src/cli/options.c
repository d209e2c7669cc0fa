/* The table of the options common to several commands. */
#include "cli/options.h"
#include "base/workers.h"

static const char *const angles[] = {"reading", "command", NULL};
static const char *const maps[] = {"name", "order", "order-w-last", NULL};

/* A row of the table. */
#define COMMON(sets, text, member, type, metavar, ...) \
    CLI_OPTION(cli_common, member, text, type, metavar, __VA_ARGS__, .set = CLI_WITH_##sets)

const cli_option cli_common_options[] = {
    COMMON(MODEL, "urdf", arm.urdf, CLI_INPUT, "FILE", "nominal model of the arm"),
    COMMON(MODEL, "kinematics", arm.kinematics, CLI_INPUT, "FILE",
           "YAML with the robot's own origins (Universal Robots, Franka, UFACTORY): it replaces "
           "those of the URDF"),
    COMMON(MODEL, "base", arm.base, CLI_TEXT, "LINK",
           "first link of the chain (default: the URDF's root)"),
    COMMON(MODEL, "tip", arm.tip, CLI_TEXT, "LINK",
           "last link of the chain (default: ball_link, else ball, else the only leaf)"),
    COMMON(MODEL, "inertials", arm.inertials, CLI_INPUT, "FILE",
           "link masses (TSV: link, mass_kg, com_x_m, com_y_m, com_z_m); they replace those of the "
           "URDF"),
    COMMON(MODEL, "gravity", arm.gravity, CLI_VECTOR, "X,Y,Z",
           "gravity in the base frame, m/s^2 (default: 0,0,-9.80665)"),
    COMMON(OFFSETS, "offsets", arm.offsets, CLI_INPUT, "FILE",
           "apply this offsets table; it must belong to the URDF"),
    COMMON(OFFSETS, "accept-other-arm", accept_other_arm, CLI_FLAG, NULL,
           "use the offsets table even though it was made for another URDF or factory file"),
    COMMON(ACCEPT, "accept-failed", accept_failed, CLI_FLAG, NULL,
           "use the offsets table even though its calibration did not pass"),
    COMMON(ACCEPT, "accept-edited", accept_edited, CLI_FLAG, NULL,
           "use the offsets table even though it was edited or cut after it was written"),
    COMMON(TEST, "test", test, CLI_REST, "DATA...", "held-out data: never fitted, always reported"),
    COMMON(DISTANCE, "distance", distance, CLI_POSITIVE, "M",
           "distance between the sockets, m (default: 0.05)", .most = 2),
    COMMON(DISTANCES, "distances", distances, CLI_INPUT, "FILE",
           "distances of pairs of sockets (TSV: socket_a, socket_b, distance_m)",
           .excludes = "distance"),
    COMMON(SD, "distance-sd", distance_sd, CLI_POSITIVE, "M",
           "standard deviation of the distance between two sockets, one error for all "
           "placements, m (default: 1e-4, printed; a measured tool: that of the instrument)",
           .most = 0.1),
    COMMON(JSON, "json", json, CLI_OUTPUT, "FILE",
           "write the result as JSON; - means standard output"),
    COMMON(PAYLOAD, "payload", payload, CLI_TEXT, "KG[,KG...]",
           "mass at the tip beyond the model, of all DATA or of each in order, then of each "
           "--test, where the file has no payload_kg"),
    COMMON(ANGLES, "angles", angles, CLI_CHOICE, "STREAM",
           "fit the angles that were read, or those that were commanded (columns "
           "JOINT.command; without them all angles are commands; default: reading)",
           .choices = angles),
    COMMON(FRAMES, "free-base", free_base, CLI_FLAG, NULL,
           "pose logs: fit the frame of the tracker, too (joint base_frame)"),
    COMMON(FRAMES, "free-tool", free_tool, CLI_FLAG, NULL,
           "pose logs: fit the offset of the target (the last fixed joint, else joint tool_frame; "
           "recalibrate: its rotation)"),
    COMMON(TRAITS, "traits", traits, CLI_INPUT, "FILE",
           "traits of the model's fleet (mukca fleet -o), as prior of calibrate and diagnose"),
    COMMON(COLUMNS, "units", units, CLI_TEXT, "UNITS",
           "units of the tables that are read: rad or deg, m or mm, as in deg,mm (default: rad,m); "
           "columns x, y, z are then positions, too"),
    COMMON(COLUMNS, "columns", columns, CLI_TEXT, "NAMES",
           "names of the tables' columns: COLUMN=NAME,... or a name for each column in order, or a "
           "file of these"),
    COMMON(MAP, "map", map, CLI_CHOICE, "MAP",
           "name: the first line of a table names its columns; order: it has no such line, the "
           "joints come in the chain's order, then the pose, its quaternion with w first; "
           "order-w-last: with w last (default: name)",
           .choices = maps),
    COMMON(
        MAP, "rotation", rotation, CLI_TEXT, "FORM",
        "orientations of pose logs, their columns from left to right: three angles as XYZ (or "
        "another order; intrinsic) or xyz (extrinsic), vector, wxyz, xyzw, inverse (of the fixed "
        "frame in the target's) or none (not read); WRONG=FORM undoes a conversion of angles "
        "that are FORM by a convention WRONG (default: by the columns' names)"),
    COMMON(MAP, "inverse-poses", inverse_poses, CLI_FLAG, NULL,
           "the measured poses are those of the fixed frame in the target's, as a camera on the "
           "arm sees a fixed board"),
    COMMON(THREADS, "threads", threads, CLI_INTEGER, "N",
           "threads of the computation, the result is the same for every N (default: one for "
           "each core)",
           .least = 1, .most = MUKCA_MOST_WORKERS),
    COMMON(ALL, "force", force, CLI_FLAG, NULL, "overwrite existing files"),
    COMMON(ALL, "quiet", quiet, CLI_FLAG, NULL, "print errors only", .letter = 'q'),
    COMMON(ALL, "verbose", verbose, CLI_FLAG, NULL, "print inputs and elapsed time", .letter = 'v'),
    {.name = NULL, .set = CLI_WITH_ALL}};
