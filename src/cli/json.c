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

json_t *cli_json_real(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *cli_json_reals(const double *values, int n)
{
    json_t *array = json_array();
    for (int i = 0; i < n; i++) json_array_append_new(array, cli_json_real(values[i]));
    return array;
}

json_t *cli_json_numbers_until(const char *key, double value, ...)
{
    json_t *object = json_object();
    va_list rest;
    va_start(rest, value);
    while (key) {
        json_object_set_new(object, key, cli_json_real(value));
        key = va_arg(rest, const char *);
        if (key) value = va_arg(rest, double);
    }
    va_end(rest);
    return object;
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

json_t *cli_json_offsets(const mukca_offsets *offsets, const mukca_chain *chain)
{
    json_t *array = json_array();
    mukca_offset_row *rows = calloc(MUKCA_MAX_OFFSET_ROWS, sizeof *rows);
    incomplete |= !rows;
    int n = rows ? mukca_offsets_rows(rows, offsets, chain) : 0;
    for (int i = 0; i < n; i++)
        json_array_append_new(
            array, json_pack("{s:s, s:s, s:s, s:o, s:o, s:o, s:o, s:b, s:s}", "joint",
                             rows[i].joint, "parameter", rows[i].parameter, "unit", rows[i].unit,
                             "nominal", cli_json_real(rows[i].nominal), "calibrated",
                             cli_json_real(rows[i].calibrated), "offset",
                             cli_json_real(rows[i].offset), "sigma", cli_json_real(rows[i].sigma),
                             "identifiable", (int)rows[i].identifiable, "term", rows[i].term));
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
    json_t *object =
        json_pack("{s:b, s:s, s:s, s:b, s:o}", "accepted", (int)a->accepted, "why", a->reason,
                  "error_of", a->error_of, "converged", (int)a->converged, "joints_at_rest", rest);
    for (const mukca_acceptance_number *n = mukca_acceptance_numbers; n->key; n++) {
        double value;
        memcpy(&value, (const char *)a + n->offset, sizeof value);
        json_object_set_new(object, n->key, cli_json_real(value));
    }
    return object;
}

json_t *cli_json_frame(const mukca_frame *T)
{
    double q[4];
    mukca_rotation_to_quaternion(q, T->R);
    return json_pack("{s:o, s:o}", "position_m", cli_json_reals(T->p, 3), "quaternion",
                     cli_json_reals(q, 4));
}
