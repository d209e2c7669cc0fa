/* Bounded, table-driven decoder of LCM messages that carry joint states. */
#include "lcm/type.h"

#include <math.h>
#include <string.h>

#include "lcm/packet.h"

typedef struct {
    const mukca_lcm_types *types;
    const signed char (*role)[MUKCA_LCM_MAX_DEPTH + 1];
    mukca_lcm_joints *out;
    int count[MUKCA_LCM_ROLES]; /* values stored per role */
    mukca_lcm_wire wire;
    size_t steps; /* remaining fields that may be visited: bounds the time to linear in the size */
    mukca_error *error;
} decoder;

static int64_t read_integer(const unsigned char *at, mukca_lcm_primitive primitive)
{
    const int size = mukca_lcm_primitive_sizes[primitive], unused = 64 - 8 * size;
    const uint64_t value = mukca_lcm_wire_get(at, size);
    if (primitive > MUKCA_LCM_INT64) return (int64_t)value; /* a byte or a boolean has no sign */
    return (int64_t)(value << unused) >> unused;
}

static double read_number(const unsigned char *at, mukca_lcm_primitive primitive)
{
    if (primitive == MUKCA_LCM_DOUBLE) {
        uint64_t bits = mukca_lcm_wire_get(at, 8);
        double value;
        memcpy(&value, &bits, sizeof value);
        return value;
    }
    if (primitive == MUKCA_LCM_FLOAT) {
        uint32_t bits = (uint32_t)mukca_lcm_wire_get(at, 4);
        float value;
        memcpy(&value, &bits, sizeof value);
        return (double)value;
    }
    return (double)read_integer(at, primitive);
}

static mukca_status fail(const decoder *d, const mukca_lcm_field *field, const char *what)
{
    return mukca_fail(d->error, MUKCA_INPUT, "malformed message: %s %s", field->name, what);
}

/* Store a value for each role of the mask. */
static mukca_status keep(decoder *d, const mukca_lcm_field *field, unsigned mask,
                         const unsigned char *at)
{
    for (int r = 0; r < MUKCA_LCM_ROLES; r++) {
        if (!(mask >> r & 1u)) continue;
        if (r != MUKCA_LCM_ROLE_TIME && d->count[r] == MUKCA_LCM_MAX_JOINTS)
            return fail(d, field, "has more than 64 entries");
        if (r == MUKCA_LCM_ROLE_TIME)
            d->out->time =
                field->primitive <= MUKCA_LCM_BOOLEAN ? read_integer(at, field->primitive) : 0;
        else if (r == MUKCA_LCM_ROLE_NAME)
            d->out->name[d->count[r]] = (const char *)at;
        else
            d->out->value[r][d->count[r]] = read_number(at, field->primitive);
        d->count[r]++;
    }
    return MUKCA_OK;
}

/* Number of elements of a field; `value` has the integers of this struct read so far. */
static mukca_status count_elements(const decoder *d, const mukca_lcm_field *field,
                                   const int64_t *value, size_t *count)
{
    *count = 1;
    for (int i = 0; i < field->n_dimensions; i++) {
        const mukca_lcm_dimension *dimension = &field->dimension[i];
        int64_t n = dimension->field < 0 ? dimension->count : value[dimension->field];
        /* each element that is stored occupies at least a byte */
        if (n < 0 || (uint64_t)n > d->wire.left || (n && *count > d->wire.left / (uint64_t)n))
            return fail(d, field, "has a count that does not fit the message");
        *count *= (size_t)n;
    }
    return MUKCA_OK;
}

/* Decode one struct; bit r of `mask` is set while the path of role r leads here. */
static mukca_status decode_struct(decoder *d, int t, int depth, unsigned mask)
{
    const mukca_lcm_type *type = &d->types->type[t];
    int64_t value[MUKCA_LCM_MAX_TYPE_FIELDS] = {0};
    if (depth == MUKCA_LCM_MAX_DEPTH)
        return mukca_fail(d->error, MUKCA_INPUT, "malformed message: nested more than %d deep",
                          MUKCA_LCM_MAX_DEPTH);
    for (int i = 0; i < type->n_fields; i++) {
        const mukca_lcm_field *field = &d->types->field[type->first_field + i];
        unsigned here = 0;
        size_t count;
        MUKCA_TRY(count_elements(d, field, value, &count));
        for (int r = 0; r < MUKCA_LCM_ROLES; r++)
            if (mask >> r & 1u && d->role[r][depth] == i) here |= 1u << r;
        if (field->primitive != MUKCA_LCM_NESTED && field->primitive != MUKCA_LCM_STRING) {
            size_t size = mukca_lcm_primitive_sizes[field->primitive];
            const unsigned char *at =
                count > d->wire.left / size ? NULL : mukca_lcm_wire_bytes(&d->wire, count * size);
            if (!at) return fail(d, field, "is cut off");
            value[i] = count ? read_integer(at, field->primitive) : 0;
            for (size_t k = 0; k < count && here; k++)
                MUKCA_TRY(keep(d, field, here, at + k * size));
            continue;
        }
        for (size_t k = 0; k < count; k++) {
            if (d->steps-- == 0) return fail(d, field, "has too many entries");
            const char *text = NULL;
            if (field->primitive == MUKCA_LCM_NESTED)
                MUKCA_TRY(decode_struct(d, field->nested, depth + 1, here));
            else if (!(text = mukca_lcm_wire_text(&d->wire)))
                return fail(d, field, "is no text that fits");
            else if (here)
                MUKCA_TRY(keep(d, field, here, (const unsigned char *)text));
        }
    }
    return MUKCA_OK;
}

int mukca_lcm_types_find(const mukca_lcm_types *types, const void *data, size_t size)
{
    if (size < 8) return -1;
    uint64_t hash = mukca_lcm_wire_get(data, 8);
    for (int t = types->n_types - 1; t >= 0; t--)
        if (types->type[t].fingerprint == hash) return t;
    return -1;
}

mukca_status mukca_lcm_decode_joints(mukca_lcm_joints *joints, const mukca_lcm_types *types,
                                     int type, const void *data, size_t size, mukca_error *error)
{
    decoder d = {.types = types,
                 .role = (const signed char(*)[MUKCA_LCM_MAX_DEPTH + 1]) types->type[type].role,
                 .out = joints,
                 .error = error};
    if (size < 8) return mukca_fail(error, MUKCA_INPUT, "malformed message: %zu bytes", size);
    d.wire = (mukca_lcm_wire){.at = (const unsigned char *)data + 8, .left = size - 8};
    d.steps = 64 + size;
    joints->time = 0;
    unsigned mask = 0;
    for (int r = 0; r < MUKCA_LCM_ROLES; r++)
        if (d.role[r][0] >= 0) mask |= 1u << r;
    MUKCA_TRY(decode_struct(&d, type, 0, mask));
    if (d.wire.left)
        return mukca_fail(error, MUKCA_INPUT, "malformed message: %zu bytes left over",
                          d.wire.left);
    joints->n = d.count[MUKCA_LCM_ROLE_POSITION];
    if (joints->n < 1) return mukca_fail(error, MUKCA_INPUT, "message without joints");
    for (int r = 0; r < MUKCA_LCM_ROLES; r++) {
        joints->has[r] = (mask >> r & 1u) && d.count[r] > 0;
        if (r != MUKCA_LCM_ROLE_TIME && joints->has[r] && d.count[r] != joints->n)
            return mukca_fail(error, MUKCA_INPUT,
                              "message with %d positions, but %d of another field", joints->n,
                              d.count[r]);
    }
    for (int j = 0; j < joints->n; j++) {
        if (!isfinite(joints->value[MUKCA_LCM_ROLE_POSITION][j]))
            return mukca_fail(error, MUKCA_INPUT, "message whose position %d is no finite number",
                              j + 1);
        if (joints->has[MUKCA_LCM_ROLE_EFFORT])
            joints->value[MUKCA_LCM_ROLE_EFFORT][j] *= types->type[type].effort_factor;
    }
    return MUKCA_OK;
}
