/* JSON objects from C values. */
#ifndef MUKCA_CLI_JSON_H
#define MUKCA_CLI_JSON_H

#include <jansson.h>
#include <stdbool.h>

#include "mukca/chain.h"

/* A JSON object: cli_json(KEY("name", text), KEY("error_m", number), ...).  The type of a value is
 * that of C: texts (NULL: null), flags, integers, numbers (null for NaN and infinity), json_t *
 * (stolen; NULL: null).  A comparison is an int: write (bool)(a > b). */
typedef struct {
    const char *key;
    json_t *value;
} cli_json_member;
#define KEY(name, value)                        \
    {                                           \
        name, _Generic((value),               \
            bool: cli_json_flag,           \
            unsigned char: cli_json_flag,  \
            int: json_integer,             \
            long: json_integer,            \
            double: cli_json_real,         \
            char *: cli_json_text,         \
            const char *: cli_json_text,   \
            json_t *: cli_json_value)(value) \
    }
#define FIELD(from, member) KEY(#member, (from)->member) /* FIELD(plan, rows_to_name) */
#define cli_json(...) cli_json_object((const cli_json_member[]){__VA_ARGS__, {NULL, NULL}})
#define cli_json_append(array, ...) json_array_append_new(array, cli_json(__VA_ARGS__))
json_t *cli_json_object(const cli_json_member *members); /* up to the key NULL */
json_t *cli_json_flag(bool value);
json_t *cli_json_real(double value);
json_t *cli_json_text(const char *text);
json_t *cli_json_value(json_t *value);
json_t *cli_json_positive(int value);               /* NULL unless above 0 */
json_t *cli_json_interval(double low, double high); /* NULL unless both are finite */

/* Numbers; null for NaN and infinity. */
json_t *cli_json_reals(const double *values, int n);

/* A pose: position_m, and quaternion, w first. */
json_t *cli_json_frame(const mukca_frame *frame);

#endif
