/* The list of commands: one line each, in the order of the help. */
#ifndef MUKCA_CLI_COMMANDS_H
#define MUKCA_CLI_COMMANDS_H

#define CLI_COMMAND_LIST(X) \
    X(capture)              \
    X(serve)                \
    X(send)                 \
    X(simulate)             \
    X(plan)                 \
    X(calibrate)            \
    X(recalibrate)          \
    X(evaluate)             \
    X(diagnose)             \
    X(report)               \
    X(compensate)           \
    X(export)               \
    X(fk)

#endif
