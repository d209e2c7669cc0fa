/* Reasons of a solver to stop: a result, not an error. */
#ifndef MUKCA_FIT_STOP_H
#define MUKCA_FIT_STOP_H

#define MUKCA_STOP_LIST(X)                              \
    X(GRADIENT, "the gradient vanished")                \
    X(TOLERANCE, "no further decrease within rounding") \
    X(LIMIT, "out of evaluations or time")              \
    X(NOT_FINITE, "the cost is not a finite number")    \
    X(FAILED, "the solver gave up")                     \
    X(STOPPED, "interrupted")

typedef enum {
#define MUKCA_STOP_ENUM(name, text) MUKCA_STOP_##name,
    MUKCA_STOP_LIST(MUKCA_STOP_ENUM)
#undef MUKCA_STOP_ENUM
} mukca_stop;

const char *mukca_stop_text(mukca_stop stop);

#endif
