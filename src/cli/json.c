/* JSON shared by several commands. */
#include "cli/cli.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"

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

json_t *cli_json_real(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *cli_json_flag(bool value)
{
    return json_boolean(value);
}

json_t *cli_json_value(json_t *value)
{
    return value ? value : json_null();
}

json_t *cli_json_positive(int value)
{
    return value > 0 ? json_integer(value) : NULL;
}

json_t *cli_json_interval(double low, double high)
{
    const double both[2] = {low, high};
    return isfinite(low) && isfinite(high) ? cli_json_reals(both, 2) : NULL;
}

json_t *cli_json_estimate(const mukca_estimate *e)
{
    return isfinite(e->value) ? cli_json_interval(e->low, e->high) : NULL;
}

json_t *cli_json_reals(const double *values, int n)
{
    json_t *array = json_array();
    for (int i = 0; i < n; i++) json_array_append_new(array, cli_json_real(values[i]));
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

json_t *cli_json_object(const cli_json_member *members)
{
    json_t *object = json_object();
    for (; members->key; members++) json_object_set_new(object, members->key, members->value);
    return object;
}

json_t *cli_json_offsets(const mukca_offsets *offsets, const mukca_chain *chain)
{
    json_t *array = json_array();
    mukca_offset_row *rows = calloc(MUKCA_MAX_OFFSET_ROWS, sizeof *rows);
    incomplete |= !rows;
    const int n = rows ? mukca_offsets_rows(rows, offsets, chain) : 0;
    for (const mukca_offset_row *r = rows; r < rows + n; r++)
        cli_json_append(array, FIELD(r, joint), FIELD(r, parameter), FIELD(r, unit),
                        FIELD(r, nominal), FIELD(r, calibrated), FIELD(r, offset), FIELD(r, sigma),
                        FIELD(r, identifiable), FIELD(r, term));
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
    json_t *object = cli_json(FIELD(a, accepted), KEY("why", a->reason), FIELD(a, error_of),
                              FIELD(a, converged), KEY("joints_at_rest", rest));
    for (int i = 0; i < MUKCA_ACCEPTANCE_NUMBERS; i++)
        json_object_set_new(object, mukca_acceptance_key[i], cli_json_real(a->number[i]));
    return object;
}

json_t *cli_json_frame(const mukca_frame *T)
{
    double q[4];
    mukca_rotation_to_quaternion(q, T->R);
    return cli_json(KEY("position_m", cli_json_reals(T->p, 3)),
                    KEY("quaternion", cli_json_reals(q, 4)));
}

mukca_status cli_write_json(cli_call *call, json_t *members)
{
    const cli_common *c = call->common;
    char schema[40];
    snprintf(schema, sizeof schema, "mukca.%s/1", call->command->name);
    json_t *root = cli_json(KEY("schema", (const char *)schema));
    mukca_output output = {0};
    mukca_status status = MUKCA_OK;
    if (json_object_update(root, members) != 0 || incomplete)
        status = cli_fail(call, MUKCA_MEMORY, "out of memory");
    else
        status = mukca_output_open(&output, c->json, c->force, &call->error);
    if (status == MUKCA_OK &&
        (json_dumpf(root, output.stream, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) != 0 ||
         fputc('\n', output.stream) == EOF) &&
        !ferror(output.stream)) /* mukca_output_close reports the reason */
        status = cli_fail(call, MUKCA_MEMORY, "out of memory");
    json_decref(members);
    json_decref(root);
    return mukca_output_finish(&output, status, &call->error);
}
