/* JSON shared by several commands. */
#include "cli/cli.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "base/utf8.h"

/* Set by any failed allocation: jansson reports failures per function, and a member that could not
 * be added is merely missing. */
static bool incomplete;

static void *allocate(size_t size)
{
    void *memory = malloc(size);
    incomplete |= !memory;
    return memory;
}

void cli_json_watch(void)
{
    json_set_alloc_funcs(allocate, free);
}

bool cli_json_incomplete(void)
{
    return incomplete;
}

static json_t *number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *cli_json_reals(const double *values, int n)
{
    json_t *array = json_array();
    for (int i = 0; i < n; i++) json_array_append_new(array, number(values[i]));
    return array;
}

json_t *cli_json_text(const char *text)
{
    if (!text || mukca_utf8_valid(text)) return text ? json_string(text) : json_null();
    char *mended = strdup(text); /* a file name; jansson accepts only UTF-8 */
    if (mended)
        mukca_utf8_mend(mended);
    else
        incomplete = true;
    json_t *string = json_string(mended);
    free(mended);
    return string;
}

/* Values of the keys, in order. */
typedef struct {
    va_list list;
} source;

static json_t *interval(double low, double high)
{
    const double both[2] = {low, high};
    return isfinite(low) && isfinite(high) ? cli_json_reals(both, 2) : json_null();
}

static json_t *next_value(source *from, char type)
{
    double low;
    int n;
    json_t *json;
    switch (type) {
        case 's':
            return cli_json_text(va_arg(from->list, const char *));
        case 'b':
            return json_boolean(va_arg(from->list, int));
        case 'i':
            return json_integer(va_arg(from->list, int));
        case 'n':
            n = va_arg(from->list, int);
            return n > 0 ? json_integer(n) : json_null();
        case 'l':
            return json_integer(va_arg(from->list, long));
        case 'f':
            return number(va_arg(from->list, double));
        case 'v':
            low = va_arg(from->list, double);
            return interval(low, va_arg(from->list, double));
        default:
            json = va_arg(from->list, json_t *);
            return json ? json : json_null();
    }
}

/* Set the keys up to the end of the text or a closing brace; returns the rest of the text. */
static const char *set(json_t *object, const char *keys, source *from)
{
    while (*keys && *keys != '}') {
        char key[48];
        const size_t length = strcspn(keys, ":{");
        const bool nested = keys[length] == '{';
        json_t *value = nested ? json_object() : next_value(from, keys[length + 1]);
        snprintf(key, sizeof key, "%.*s", (int)length, keys);
        keys = nested ? set(value, keys + length + 1, from) + 1 : keys + length + 2;
        json_object_set_new(object, key, value);
        keys += strspn(keys, " ");
    }
    return keys;
}

json_t *cli_json(const char *keys, ...)
{
    json_t *object = json_object();
    source from;
    va_start(from.list, keys);
    set(object, keys, &from);
    va_end(from.list);
    return object;
}

json_t *cli_json_offsets(const mukca_offsets *offsets, const mukca_chain *chain)
{
    json_t *array = json_array();
    mukca_offset_row *rows = calloc(MUKCA_MAX_OFFSET_ROWS, sizeof *rows);
    incomplete |= !rows;
    const int n = rows ? mukca_offsets_rows(rows, offsets, chain) : 0;
    for (const mukca_offset_row *r = rows; r < rows + n; r++)
        cli_json_append(array,
                        "joint:s parameter:s unit:s nominal:f calibrated:f offset:f sigma:f "
                        "identifiable:b term:s",
                        r->joint, r->parameter, r->unit, r->nominal, r->calibrated, r->offset,
                        r->sigma, r->identifiable, r->term);
    free(rows);
    return array;
}

json_t *cli_json_acceptance(const mukca_acceptance *a)
{
    if (!a) return json_null();
    json_t *rest = json_array();
    for (const char *at = a->at_rest; *at;) { /* "joint_6, joint_7" */
        const size_t length = strcspn(at, ",");
        json_array_append_new(rest, json_stringn(at, length));
        at += length;
        at += strspn(at, ", ");
    }
    json_t *object = cli_json("accepted:b why:s error_of:s converged:b joints_at_rest:o",
                              a->accepted, a->reason, a->error_of, a->converged, rest);
    for (const mukca_acceptance_number *n = mukca_acceptance_numbers; n->key; n++) {
        double value;
        memcpy(&value, (const char *)a + n->offset, sizeof value);
        json_object_set_new(object, n->key, number(value));
    }
    return object;
}

json_t *cli_json_frame(const mukca_frame *T)
{
    double q[4];
    mukca_rotation_to_quaternion(q, T->R);
    return cli_json("position_m:o quaternion:o", cli_json_reals(T->p, 3), cli_json_reals(q, 4));
}
