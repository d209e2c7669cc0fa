/* Status codes, their texts, and the error record that every fallible function fills. */
#ifndef MUKCA_STATUS_H
#define MUKCA_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

/* name, value (also the exit code of the program), text */
#define MUKCA_STATUS_LIST(X)                                          \
    X(OK, 0, "done")                                                  \
    X(NEGATIVE, 1, "done, and the answer is a negative verdict")      \
    X(USAGE, 2, "bad usage")                                          \
    X(INPUT, 3, "bad input")                                          \
    X(TRANSPORT, 4, "transport or time-out")                          \
    X(UNIDENTIFIABLE, 5, "not identifiable")                          \
    X(MEMORY, 6, "out of memory, or an output was not written whole") \
    X(INTERRUPTED, 130, "interrupted")

typedef enum {
#define MUKCA_STATUS_ENUM(name, value, text) MUKCA_##name = (value),
    MUKCA_STATUS_LIST(MUKCA_STATUS_ENUM)
#undef MUKCA_STATUS_ENUM
} mukca_status;

/* One line for people: what is wrong, where (file, line, column, joint), and what to do. */
typedef struct {
    mukca_status status;
    char text[256];
} mukca_error;

/* Where a function has something to say that is no error (a warning), it calls this; `text` is one
 * line without a newline.  NULL means silence. */
typedef void mukca_note_fn(void *context, const char *text);

/* Text of a status, "unknown status" for a value outside the list.  Never NULL. */
const char *mukca_status_text(mukca_status status);

/* Fill `error` (may be NULL) with a printf-formatted line (cut at 255 characters) and return
 * `status`, so that callers can write `return mukca_fail(...)`. */
mukca_status mukca_fail(mukca_error *error, mukca_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#ifdef __cplusplus
}
#endif
#endif
