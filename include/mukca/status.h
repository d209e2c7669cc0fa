/* Status codes and the error record that every fallible function fills. */
#ifndef MUKCA_STATUS_H
#define MUKCA_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

/* The values are the exit codes of the program. */
typedef enum {
    MUKCA_OK = 0,
    MUKCA_NEGATIVE = 1, /* completed with a negative verdict */
    MUKCA_USAGE = 2,
    MUKCA_INPUT = 3,
    MUKCA_TRANSPORT = 4, /* or time-out */
    MUKCA_UNIDENTIFIABLE = 5,
    MUKCA_MEMORY = 6, /* or an output was not written completely */
    MUKCA_INTERRUPTED = 130
} mukca_status;

/* One line for display: what is wrong, where (file, line, column, joint), and what to do. */
typedef struct {
    mukca_status status;
    char text[400];
} mukca_error;

/* Receives the warnings of a function, each one line without a newline.  NULL: no warnings. */
typedef void mukca_note_fn(void *context, const char *text);

/* Fill `error` (may be NULL) with a printf-formatted line (truncated to 399 characters, control
 * characters replaced by ?) and return `status`, for `return mukca_fail(...)`. */
mukca_status mukca_fail(mukca_error *error, mukca_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Return the status of a call that fails from the calling function, which has nothing to free. */
#define MUKCA_TRY(call)                                  \
    do {                                                 \
        const mukca_status mukca_tried = (call);         \
        if (mukca_tried != MUKCA_OK) return mukca_tried; \
    } while (0)

#ifdef __cplusplus
}
#endif
#endif
